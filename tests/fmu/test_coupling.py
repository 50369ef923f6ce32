"""Co-simulation with other FMUs: FMPy's container, the Open Simulation Platform, and a second FMU that damps the first."""

from copy import copy

import numpy as np
import pytest
from fmu_samples import MASS, OMEGA, ZETA, absorber, make, oscillator

from fowtio.fmu.build import write_fmu

STEP, STOP = 0.01, 40.0
TOLERANCE = 0.02  # m: forces come a step late, h w / 2 of the coupling a cycle, over five cycles


@pytest.fixture(scope="module")
def pairs(tmp_path_factory):
    """Paths of the oscillator and a tuned mass, by FMI version."""
    folder = tmp_path_factory.mktemp("pair")
    spaces = {"Spring": oscillator(), "Absorber": absorber()}
    return {
        v: tuple(write_fmu(make(s, n), folder / v / f"{n}.fmu", version=v) for n, s in spaces.items())
        for v in ("2.0", "3.0")
    }


def _together(t, position):
    """Position of the oscillator with the tuned mass, released from `position`: the coupled equations, exact by eigenvalues."""
    m, k, c = 10.0, 10.0 * OMEGA**2, 2 * 0.1 * OMEGA * 10.0
    mass = np.diag([MASS, m])
    stiffness = np.array([[MASS * OMEGA**2 + k, -k], [-k, k]])
    damping = np.array([[2 * ZETA * OMEGA * MASS + c, -c], [-c, c]])
    a = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)]])
    values, vectors = np.linalg.eig(a)
    share = np.linalg.solve(vectors, np.array([position, 0, 0, 0], dtype=complex))
    return (vectors[0] * share * np.exp(np.outer(t, values))).sum(axis=1).real


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_a_tuned_mass_in_a_container(pairs, tmp_path, version):
    """FMPy's container couples both, values exchanged at every step: the coupled equations, to first order in the step."""
    pytest.importorskip("fmpy.container_fmu")
    from fmpy import simulate_fmu

    path = _container(pairs[version], tmp_path, version)
    start = {"SpringStart": 1.0, "AbsorberStart": 2.0}  # the position has a mean of 2 m, where the tuned mass rests too
    found = simulate_fmu(str(path), stop_time=STOP, step_size=STEP, output_interval=STEP, start_values=start)
    known = _together(found["time"], 1.0)
    alone = np.exp(-ZETA * OMEGA * found["time"]) * np.cos(OMEGA * found["time"])
    assert np.abs(known - alone).max() > 0.2  # the tuned mass matters, by more than ten times the tolerance
    assert np.abs(found["Position"] - 2.0 - known).max() < TOLERANCE


def test_a_tuned_mass_in_the_open_simulation_platform(pairs):
    pair = pairs["2.0"]
    pytest.importorskip("libcosimpy")
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    execution = CosimExecution.from_step_size(step_size=int(STEP * 1e9))
    spring, mass = (
        execution.add_local_slave(local_slave=CosimLocalSlave(fmu_path=str(p), instance_name=p.stem)) for p in pair
    )
    of = {k: _references(p) for k, p in zip((spring, mass), pair, strict=True)}
    execution.real_initial_value(slave_index=spring, variable_reference=of[spring]["Initial.Position"], value=1.0)
    execution.real_initial_value(slave_index=mass, variable_reference=of[mass]["Initial.Position"], value=2.0)
    for there, output, here, entry in (
        (spring, "Position", mass, "BasePosition"),
        (spring, "Velocity", mass, "BaseVelocity"),
        (mass, "BaseForce", spring, "Force"),
    ):
        execution.connect_real_variables(there, of[there][output], here, of[here][entry])
    observer = CosimObserver.create_last_value()
    assert execution.add_observer(observer=observer)
    series = []
    for _ in range(round(STOP / STEP)):
        assert execution.step()
        series.append(observer.last_real_values(slave_index=spring, variable_references=[of[spring]["Position"]])[0])
    t = (np.arange(len(series)) + 1) * STEP
    assert np.abs(np.array(series) - 2.0 - _together(t, 1.0)).max() < TOLERANCE


def _references(path) -> dict[str, int]:
    from fmpy import read_model_description

    return {v.name: v.valueReference for v in read_model_description(str(path)).modelVariables}


def _container(pair, folder, version):
    """Write a container FMU of both: the spring's motion to the tuned mass, its force back; one output, two start values."""
    from fmpy import read_model_description
    from fmpy.container_fmu.cli import create_container_fmu
    from fmpy.container_fmu.config import Component, Configuration, Connection
    from fmpy.model_description import CoSimulation, DefaultExperiment, ModelDescription, ModelVariable, Unknown

    spring, mass = (Component(name=p.stem, filename=p, modelDescription=read_model_description(str(p))) for p in pair)

    def variable(component, name):
        return next(v for v in component.modelDescription.modelVariables if v.name == name)

    def connector(component, name):
        # FMPy 0.3.32 writes the type of a connection as it is in the component, and its container knows those of FMI 3 only
        typed = copy(variable(component, name))
        typed.type = "Float64"
        return typed

    def own(name, causality, variability, initial, start=None):
        return ModelVariable(
            name=name,
            valueReference=0,
            type="Real" if version == "2.0" else "Float64",
            causality=causality,
            variability=variability,
            initial=initial,
            start=start,
        )

    position = own("Position", "output", "continuous", "calculated")
    time = own("time", "independent", "continuous", None)
    starts = [own(n, "parameter", "fixed", "exact", "0") for n in ("SpringStart", "AbsorberStart")]
    md = ModelDescription(
        fmiVersion=version, modelName="Together", instantiationToken="{together}", coSimulation=CoSimulation(modelIdentifier="container_fmu"),
        defaultExperiment=DefaultExperiment(stepSize=str(STEP)), modelVariables=[time, position, *starts], outputs=[Unknown(variable=position)],
        initialUnknowns=[Unknown(variable=position)],
    )  # fmt: skip
    md.coSimulation.fixedInternalStepSize = STEP
    links = [
        (spring, "Position", mass, "BasePosition"),
        (spring, "Velocity", mass, "BaseVelocity"),
        (mass, "BaseForce", spring, "Force"),
    ]
    mappings = {
        "Position": (spring, "Position"),
        "SpringStart": (spring, "Initial.Position"),
        "AbsorberStart": (mass, "Initial.Position"),
    }
    configuration = Configuration(
        parallelDoStep=False, modelDescription=md, components=[spring, mass],
        connections=[Connection(a, [connector(a, x)], b, [connector(b, y)]) for a, x, b, y in links],
        variableMappings={v: [(c, variable(c, n))] for v, (c, n) in zip([position, *starts], mappings.values(), strict=True)},
    )  # fmt: skip
    scratch, path = folder / "container", folder / "Together.fmu"
    scratch.mkdir()
    create_container_fmu(configuration, scratch, path)
    return path
