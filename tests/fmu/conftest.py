"""FMUs that several tests use: a mass on a spring with closed-form answers, and the embedded OC4 case."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from fowtio.fmu.build import compile_library, export_fmu, write_fmu
from fowtio.fmu.describe import describe
from fowtio.fmu.sources import write_sources
from model.reduce.state_space import StateSpace, modal_form

pytest.importorskip("fmpy")
if shutil.which("gcc") is None:
    pytest.skip("no C compiler is installed", allow_module_level=True)

OMEGA, ZETA, MASS = 0.8, 0.05, 250.0


def oscillator(omega=OMEGA, zeta=ZETA, mass=MASS) -> StateSpace:
    """A mass on a spring and a damper, driven by a force: position, velocity and acceleration."""
    a = np.array([[0.0, 1.0], [-(omega**2), -2 * zeta * omega]])
    b = np.array([[0.0], [1 / mass]])
    return StateSpace(
        a=a, b=b, c=np.vstack([np.eye(2), a[1]]), d=np.array([[0.0], [0.0], [1 / mass]]), mean=np.array([2.0, 0.0, 0.0]), inputs=("Force",),
        input_units=("N",), outputs=("Position", "Velocity", "Acceleration"), output_units=("m", "m/s", "m/s^2"), initial=np.eye(2),
        initial_names=("position", "velocity"), initial_units=("m", "m/s"),
    )  # fmt: skip


def absorber(omega=OMEGA, zeta=0.1, mass=10.0) -> StateSpace:
    """A tuned mass on a spring and a damper: base position and velocity in, the force on the base out."""
    k, c = mass * omega**2, 2 * zeta * omega * mass
    a = np.array([[0.0, 1.0], [-k / mass, -c / mass]])
    b = np.array([[0.0, 0.0], [k / mass, c / mass]])
    return StateSpace(
        a=a, b=b, c=np.array([[k, c]]), d=np.array([[-k, -c]]), mean=np.zeros(1), inputs=("BasePosition", "BaseVelocity"),
        input_units=("m", "m/s"), outputs=("BaseForce",), output_units=("N",), initial=np.eye(2), initial_names=("position", "velocity"),
        initial_units=("m", "m/s"),
    )  # fmt: skip


def make(space: StateSpace, identifier: str, **more):
    """Return the description of a space's FMU."""
    return describe(space, modal_form(space), identifier=identifier, **more)


@pytest.fixture(scope="session")
def spring(tmp_path_factory) -> dict[str, Path]:
    """FMUs of the oscillator by FMI version."""
    folder = tmp_path_factory.mktemp("spring")
    description = make(oscillator(), "Spring")
    return {v: write_fmu(description, folder / f"spring{v[0]}.fmu", version=v) for v in ("2.0", "3.0")}


@pytest.fixture(scope="session")
def spring_library(tmp_path_factory):
    """Return a maker of the oscillator's sources and library with compiler flags of one's own."""

    def build(version: str, *flags: str):
        folder = tmp_path_factory.mktemp("library") / "fmu"
        write_sources(make(oscillator(), "Spring"), version, folder)
        library = folder / "spring.so"
        compile_library(folder / "sources", library, "gcc", flags=("-std=c99", "-Wall", "-Wextra", "-Werror", *flags))
        return folder / "sources", library

    return build


@pytest.fixture(scope="session")
def parked(oc4, tmp_path_factory):
    """The embedded case, parked in its white-noise sea, as FMUs of both versions with all inputs."""
    return export_fmu(oc4, tmp_path_factory.mktemp("oc4") / "oc4.fmu", state="white_noise", versions=("2.0", "3.0"))
