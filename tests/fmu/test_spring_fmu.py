"""A mass on a spring as an FMU: closed-form answers in both FMI versions, co-simulation and model exchange."""

import zipfile

import fmpy
import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.simulation import instantiate_fmu
from fmpy.validation import validate_fmu
from fmu_samples import MASS, OMEGA, ZETA, make, oscillator

from fowtio.fmu.build import write_fmu

DAMPED = OMEGA * np.sqrt(1 - ZETA**2)
VERSIONS = ("2.0", "3.0")
KINDS = ("CoSimulation", "ModelExchange")


def _step_response(t):
    """Position after a unit step of force: x'' + 2 zeta w x' + w^2 x = 1/m."""
    return (1 - np.exp(-ZETA * OMEGA * t) * (np.cos(DAMPED * t) + ZETA * OMEGA / DAMPED * np.sin(DAMPED * t))) / (
        MASS * OMEGA**2
    )


def _ramp_response(t):
    """Position after a unit ramp of force: the integral of the step response, in closed form."""
    k, decay = MASS * OMEGA**2, np.exp(-ZETA * OMEGA * t)
    swing = 2 * ZETA / OMEGA * np.cos(DAMPED * t) + (2 * ZETA**2 - 1) / DAMPED * np.sin(DAMPED * t)
    return (t - 2 * ZETA / OMEGA + decay * swing) / k


def _decay(t, position, velocity):
    swing = (velocity + ZETA * OMEGA * position) / DAMPED
    return np.exp(-ZETA * OMEGA * t) * (position * np.cos(DAMPED * t) + swing * np.sin(DAMPED * t))


@pytest.mark.parametrize("version", VERSIONS)
def test_the_standard_has_no_objection(spring, version):
    assert validate_fmu(str(spring[version])) == []


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("kind", KINDS)
def test_free_decay(spring, version, kind):
    start = {"Initial.Position": 1.5, "Initial.Velocity": -0.3}
    found = simulate_fmu(
        str(spring[version]),
        fmi_type=kind,
        stop_time=30,
        output_interval=0.5,
        start_values=start,
        relative_tolerance=1e-9,
    )
    # co-simulation is exact to rounding; the integrator of model exchange to its tolerance over thirty seconds
    tolerance = 1e-11 if kind == "CoSimulation" else 1e-5
    assert np.allclose(found["Position"], 2.0 + _decay(found["time"], 1.5, -0.3), atol=tolerance)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("step", [0.01, 0.1, 2.0, 50.0])
def test_a_held_force_is_exact_at_any_step(spring, version, step):
    steps = max(1, round(100 / step))
    found = _march(spring[version], step, steps, lambda t: 1.0)
    t = np.arange(steps + 1) * step
    assert np.allclose(
        found - 2.0, _step_response(t), atol=1e-12 * steps / (MASS * OMEGA**2) + 1e-15
    )  # rounding of as many steps


def test_input_derivatives_make_a_ramp_exact(spring):
    """FMI 2: with the derivative of the force given, the response to a ramp has no step error."""
    description = fmpy.read_model_description(str(spring["2.0"]))
    force, position = (
        next(v.valueReference for v in description.modelVariables if v.name == n) for n in ("Force", "Position")
    )
    with _instance(spring["2.0"]) as fmu:
        for k in range(20):
            fmu.setReal([force], [k * 1.0])
            fmu.fmi2SetRealInputDerivatives(
                fmu.component,
                (fmpy.fmi2.fmi2ValueReference * 1)(force),
                1,
                (fmpy.fmi2.fmi2Integer * 1)(1),
                (fmpy.fmi2.fmi2Real * 1)(1.0),
            )
            fmu.doStep(k * 1.0, 1.0)
        assert fmu.getReal([position])[0] - 2.0 == pytest.approx(_ramp_response(20.0), rel=1e-10)
        assert fmu.getReal([force])[0] == pytest.approx(20.0)  # the input stands where its slope has brought it


@pytest.mark.parametrize("version", VERSIONS)
def test_interpolated_inputs_make_a_ramp_exact(spring, version):
    """Settings.InputInterpolation = 1: the force goes on a line from its last value to the present one."""
    t = 20.0
    for step in (0.5, 4.0):
        found = _march(spring[version], step, round(t / step), lambda x: x, ahead=True)
        assert found[-1] - 2.0 == pytest.approx(_ramp_response(t), rel=1e-10)


def test_halving_the_step_changes_the_input_only(spring):
    """A sine force, interpolated: the error falls by four when the step is halved, as straight lines between its samples do."""
    errors = []
    reference = _march(spring["2.0"], 0.005, 8000, np.sin, ahead=True)[-1]
    for step in (0.4, 0.2, 0.1):
        errors.append(abs(_march(spring["2.0"], step, round(40 / step), np.sin, ahead=True)[-1] - reference))
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.05)  # second order; the next term is (w h)^2 / 20
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.05)


@pytest.mark.parametrize("version", VERSIONS)
def test_the_directional_derivatives_are_the_matrices(spring, version):
    """D directly; and, through them, the transfer function of the closed form."""
    description = fmpy.read_model_description(str(spring[version]))
    names = {v.name: v.valueReference for v in description.modelVariables}
    states = [names[f"State.Mode[{k}]"] for k in (1, 2)]
    rates = [names[f"der(State.Mode[{k}])"] for k in (1, 2)]
    outputs = [names[n] for n in ("Position", "Velocity", "Acceleration")]
    with _instance(spring[version]) as fmu:
        call = fmu.getDirectionalDerivative

        def matrix(unknown, known):
            return np.array([call(unknown, [k], [1.0]) for k in known]).T

        a, b = matrix(rates, states), matrix(rates, [names["Force"]])
        c, d = matrix(outputs, states), matrix(outputs, [names["Force"]])
        if version == "3.0":
            adjoint = fmu.getAdjointDerivative(outputs, states, [1.0, 2.0, -1.0], nSensitivity=2)
            assert np.allclose(adjoint, np.array([1.0, 2.0, -1.0]) @ c)
    assert np.allclose(d[:, 0], [0, 0, 1 / MASS])
    for omega in (0.1, OMEGA, 3.0):
        s = 1j * omega
        found = (c @ np.linalg.solve(s * np.eye(2) - a, b) + d)[:, 0]
        known = np.array([1, s, s**2]) / (MASS * (OMEGA**2 - omega**2 + 2j * ZETA * OMEGA * omega))
        assert np.allclose(found, known, rtol=1e-9)


@pytest.mark.parametrize("version", VERSIONS)
def test_a_stored_state_is_the_whole_state(spring, version):
    """Store, go on, come back, go on again: the same; and through bytes into another instance."""
    two = version == "2.0"
    position = _reference(spring[version], "Position")
    with _instance(spring[version]) as fmu, _instance(spring[version]) as other:
        _put(fmu, spring[version], "Force", 10.0)
        _advance(fmu, 0.0, 0.7, 5)
        state = fmu.getFMUstate() if two else fmu.getFMUState()
        _advance(fmu, 3.5, 0.7, 5)
        first = _get(fmu, position)
        (fmu.setFMUstate if two else fmu.setFMUState)(state)
        _advance(fmu, 3.5, 0.7, 5)
        assert _get(fmu, position) == first
        data = (fmu.serializeFMUstate if two else fmu.serializeFMUState)(state)
        copy = (other.deSerializeFMUstate if two else other.deserializeFMUState)(data)
        (other.setFMUstate if two else other.setFMUState)(copy)
        _advance(other, 3.5, 0.7, 5)
        assert _get(other, position) == first
        (fmu.freeFMUstate if two else fmu.freeFMUState)(state)


@pytest.mark.parametrize("version", VERSIONS)
def test_instances_do_not_touch_each_other(spring, version):
    position = _reference(spring[version], "Position")
    with _instance(spring[version]) as one, _instance(spring[version]) as two:
        _put(one, spring[version], "Force", 100.0)
        _advance(one, 0.0, 0.1, 50)
        _advance(two, 0.0, 0.1, 50)
        assert _get(two, position) == 2.0
        assert _get(one, position) - 2.0 == pytest.approx(100 * _step_response(5.0), rel=1e-9)


def test_steps_of_any_length_in_turn(spring):
    position = _reference(spring["2.0"], "Position")
    with _instance(spring["2.0"]) as fmu:
        _put(fmu, spring["2.0"], "Force", 1.0)
        t = 0.0
        for h in np.random.default_rng(0).uniform(1e-6, 3.0, 40):
            fmu.doStep(t, h)
            t += h
        assert _get(fmu, position) - 2.0 == pytest.approx(_step_response(t), rel=1e-9)


def test_the_same_numbers_give_the_same_file(spring, tmp_path):
    again = write_fmu(make(oscillator(), "Spring"), tmp_path / "again.fmu")
    assert again.read_bytes() == spring["2.0"].read_bytes()


def test_an_fmu_brings_its_sources_and_licence(spring):
    for version, licence in (("2.0", "documentation/license.txt"), ("3.0", "documentation/licenses/license.txt")):
        with zipfile.ZipFile(spring[version]) as archive:
            names = archive.namelist()
            assert licence in names
            assert "Apache" in archive.read(licence).decode()
            assert "sources/CMakeLists.txt" in names
            assert ("sources/buildDescription.xml" in names) == (version == "3.0")


def test_fmpy_builds_the_source_code_fmu(spring, tmp_path):
    """The sources with their build description are enough for another tool to make the binary."""
    import shutil
    import subprocess

    if shutil.which("cmake") is None:
        pytest.skip("no cmake")
    with zipfile.ZipFile(spring["3.0"]) as archive:
        archive.extractall(tmp_path)
    done = [["cmake", "-S", "sources", "-B", "build"], ["cmake", "--build", "build"]]
    for command in done:
        subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    assert (tmp_path / "build" / "Spring.so").is_file()


# --- what the tests above share


class _instance:
    """An instance in step mode, freed at the end."""

    def __init__(self, path, **start):
        self.description = fmpy.read_model_description(str(path))
        self.folder = fmpy.extract(str(path))

    def __enter__(self):
        self.fmu = instantiate_fmu(self.folder, self.description, "CoSimulation")
        if self.description.fmiVersion == "2.0":
            self.fmu.setupExperiment()
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        return self.fmu

    def __exit__(self, *_):
        self.fmu.terminate()
        self.fmu.freeInstance()


def _march(path, step, steps, force, ahead=False):
    from fowtio.fmu.runner import Runner

    t = np.arange(steps + 1) * step
    values = np.array([force(x) for x in t], dtype=float)
    with Runner(path) as runner:
        if not ahead:
            runner.variables = {n: v for n, v in runner.variables.items() if n != "Settings.InputInterpolation"}
        return runner.run(steps, step, {"Force": values}, ["Position"])[:, 0]


def _reference(path, name):
    return next(v.valueReference for v in fmpy.read_model_description(str(path)).modelVariables if v.name == name)


def _put(fmu, path, name, value):
    (getattr(fmu, "setReal", None) or fmu.setFloat64)([_reference(path, name)], [value])


def _get(fmu, reference):
    return (getattr(fmu, "getReal", None) or fmu.getFloat64)([reference])[0]


def _advance(fmu, t, h, count):
    for k in range(count):
        fmu.doStep(t + k * h, h)
