"""Runs one instance of an FMU in co-simulation from arrays of inputs, either FMI version, through FMPy."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from ctypes import c_double
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError, ModelError

INTERPOLATION = "Settings.InputInterpolation"


def need_fmpy():
    """Return the package fmpy; raise ModelError saying how to install it."""
    try:
        import fmpy
    except ModuleNotFoundError:
        raise ModelError("simulating and checking an FMU needs FMPy: pip install 'fowtio[fmu]'") from None
    return fmpy


class Runner:
    """An unpacked FMU, to be used with `with`; `run` makes a new instance every time."""

    def __init__(self, path: str | Path):
        fmpy = need_fmpy()
        self.path = Path(path)
        try:
            self.description = fmpy.read_model_description(str(path))
            self.folder = fmpy.extract(str(path))
        except Exception as error:
            raise FormatError(path, expected="an FMU of FMI 2.0 or 3.0", found=str(error)) from None
        self.variables = {v.name: v for v in self.description.modelVariables}

    def __enter__(self):
        return self

    def __exit__(self, *_):
        shutil.rmtree(self.folder, ignore_errors=True)

    @property
    def version(self) -> str:
        """FMI version, "2.0" or "3.0"."""
        return self.description.fmiVersion

    def names(self, causality: str) -> list[str]:
        """Return the names of the variables of one causality."""
        return [v.name for v in self.description.modelVariables if v.causality == causality]

    def constant(self, name: str, default: float = 0.0) -> float:
        """Return the start value of a variable, or the default when there is none of that name."""
        return float(self.variables[name].start) if name in self.variables else default

    def run(
        self, steps: int, step: float, inputs: Mapping[str, np.ndarray], outputs: Sequence[str], start: Mapping[str, float] | None = None,
        start_time: float = 0.0,
    ) -> np.ndarray:  # fmt: skip
        """Return outputs (steps + 1, c) of a co-simulation.

        inputs: name to values (steps + 1), linear between communication points where the FMU can; start: parameters.
        Raises FormatError for a name that the FMU lacks.
        """
        from fmpy.simulation import instantiate_fmu

        start = dict(start or {})
        for name in (*inputs, *outputs, *start):
            if name not in self.variables:
                raise FormatError(
                    self.path, expected=f"a variable named {name}", found=", ".join(list(self.variables)[:40]) + " ..."
                )
        instance = instantiate_fmu(self.folder, self.description, "CoSimulation")
        try:
            ahead = INTERPOLATION in self.variables
            if ahead:
                start[INTERPOLATION] = 1
            return self._march(instance, steps, step, inputs, outputs, start, start_time, ahead)
        finally:
            instance.freeInstance()

    def matrices(
        self, inputs: Sequence[str], outputs: Sequence[str]
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return A, B, C, D between named inputs and outputs, as the FMU's directional derivatives give them."""
        from fmpy.simulation import instantiate_fmu

        states = [v.derivative for v in self.description.modelVariables if v.derivative is not None]
        rates = [v.valueReference for v in self.description.modelVariables if v.derivative is not None]
        known = [v.valueReference for v in states] + [self.variables[n].valueReference for n in inputs]
        unknown = rates + [self.variables[n].valueReference for n in outputs]
        instance = instantiate_fmu(self.folder, self.description, "CoSimulation")
        try:
            instance.enterInitializationMode()
            columns = [instance.getDirectionalDerivative(unknown, [k], [1.0]) for k in known]
        finally:
            instance.freeInstance()
        whole, n = np.array(columns).T, len(states)
        return whole[:n, :n], whole[:n, n:], whole[n:, :n], whole[n:, n:]

    def _march(self, instance, steps, step, inputs, outputs, start, start_time, ahead) -> np.ndarray:
        two = self.version == "2.0"
        if two:
            instance.setupExperiment(startTime=start_time)
            instance.enterInitializationMode()
        else:
            instance.enterInitializationMode(startTime=start_time)
        for name, value in start.items():
            variable = self.variables[name]
            if variable.type in ("Integer", "Int32"):
                (instance.setInteger if two else instance.setInt32)([variable.valueReference], [int(value)])
            else:
                (instance.setReal if two else instance.setFloat64)([variable.valueReference], [float(value)])
        references = [self.variables[n].valueReference for n in inputs]
        table = (
            np.ascontiguousarray(np.stack([np.asarray(v, dtype=float) for v in inputs.values()], axis=1))
            if inputs
            else None
        )
        put, get = self._functions(instance, references, [self.variables[n].valueReference for n in outputs])
        if inputs:
            put(table[0])
        instance.exitInitializationMode()
        out = np.empty((steps + 1, len(outputs)))
        get(out[0])
        for k in range(steps):
            if inputs:
                put(table[k + 1] if ahead else table[k])
            instance.doStep(currentCommunicationPoint=start_time + k * step, communicationStepSize=step)
            get(out[k + 1])
        instance.terminate()
        return out

    def _functions(self, instance, inputs: list[int], outputs: list[int]):
        """Return fast functions that set and get all values from and to rows of arrays."""
        from ctypes import POINTER, c_uint32

        put_references, get_references = (c_uint32 * len(inputs))(*inputs), (c_uint32 * len(outputs))(*outputs)
        pointer = POINTER(c_double)
        if self.version == "2.0":
            handle = instance.component

            def put(row):
                instance.fmi2SetReal(handle, put_references, len(inputs), row.ctypes.data_as(pointer))

            def get(row):
                instance.fmi2GetReal(handle, get_references, len(outputs), row.ctypes.data_as(pointer))
        else:
            handle = instance.component

            def put(row):
                instance.fmi3SetFloat64(handle, put_references, len(inputs), row.ctypes.data_as(pointer), len(inputs))

            def get(row):
                instance.fmi3GetFloat64(handle, get_references, len(outputs), row.ctypes.data_as(pointer), len(outputs))

        return put, get
