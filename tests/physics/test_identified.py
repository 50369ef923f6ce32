"""Matrices recovered from linearisation records: exact round trips, ElastoDyn's finite step, OpenFAST's own files."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fowtio.read.openfast_deck import read_deck
from fowtio.read.openfast_lin import read_openfast_lin
from fowtio.workflow import build
from model.conventions import PLATFORM_DOFS, rigid_mass
from model.system.contributions import contribution, turbine_of_linearisation
from model.system.identified import (
    PLATFORM_LOADS,
    WIND_INPUTS,
    has_load_inputs,
    inverse_mass,
    perturbation_error,
    second_order,
)
from model.system.linearisation import Linearisation
from model.system.turbine import structural_matrices

DOFS = (*PLATFORM_DOFS, "tower_fa1")
G, TOP = 9.80665, 87.6


def record(mass, damping, stiffness, wind=None, dofs=DOFS, **change) -> Linearisation:
    """The linearisation of M q'' + B q' + C q = F with loads at the platform and at the tower top as inputs."""
    q = len(dofs)
    inverse = np.linalg.inv(mass)
    a = np.block([[np.zeros((q, q)), np.eye(q)], [-inverse @ stiffness, -inverse @ damping]])
    forces = np.zeros((q, 8))
    for k, dof in enumerate(dofs):
        if dof in PLATFORM_DOFS:
            forces[k, PLATFORM_DOFS.index(dof)] = 1.0
    forces[:, 6] = forces[:, 0] + TOP * forces[:, 4]
    if "tower_fa1" in dofs:
        forces[dofs.index("tower_fa1"), 6] = 1.0
    forces[:, 7] = 0.0 if wind is None else wind
    names = (*(f"{n}, N" for n in PLATFORM_LOADS), "ED Nacelle X force, node 1, N", f"{WIND_INPUTS[0]}, m/s")
    values = {
        "A": a, "B": np.vstack([np.zeros((q, 8)), inverse @ forces]), "C": np.zeros((1, 2 * q)), "D": np.zeros((1, 8)),
        "state_names": tuple(f"x{k}" for k in range(2 * q)), "input_names": names, "output_names": ("y",),
        "state_point": np.zeros(2 * q), "input_point": (0.0,) * 8, "output_point": (0.0,), "state_rotating": np.zeros(2 * q),
        "input_rotating": np.zeros(8), "output_rotating": np.zeros(1), "state_order": np.full(2 * q, 2.0), "state_dof": dofs * 2,
        "state_rate": np.repeat([0.0, 1.0], q), "source": "a.lin",
    }  # fmt: skip
    return Linearisation(**(values | change))


def matrices(seed, q=7):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(q, q))
    return root @ root.T + q * np.eye(q), rng.normal(size=(q, q)), rng.normal(size=(q, q)), rng.normal(size=q)


@given(st.integers(0, 10_000), st.permutations(range(7)))
@settings(max_examples=40)
def test_round_trip(seed, order):
    """Mass, damping, stiffness and wind force come back exactly, in whatever order the states are."""
    mass, damping, stiffness, wind = matrices(seed)
    dofs = tuple(DOFS[k] for k in order)
    found = second_order([record(mass, damping, stiffness, wind, dofs)], TOP)
    assert found.dofs == dofs
    assert np.allclose(found.mass, mass, rtol=1e-8, atol=1e-8)
    assert np.allclose(found.damping, damping, atol=1e-8)
    assert np.allclose(found.stiffness, stiffness, atol=1e-8)
    assert np.allclose(found.wind_force, wind, atol=1e-8)
    assert found.mass_source == "load inputs of the linearisation"


def test_average_over_azimuths():
    """One mass matrix, stiffness that turns with the rotor: the average is the constant part."""
    mass, damping, stiffness, wind = matrices(3)
    ripple = matrices(4)[2]
    records = [record(mass, damping, stiffness + np.cos(k * np.pi / 2) * ripple, wind) for k in range(4)]
    assert np.allclose(second_order(records, TOP).stiffness, stiffness, atol=1e-9)


def test_a_given_mass_is_used():
    mass, damping, stiffness, wind = matrices(5)
    bare = record(mass, damping, stiffness, wind, input_names=tuple(f"u{k}" for k in range(7)) + (WIND_INPUTS[0],))
    assert not has_load_inputs(bare)
    found = second_order([bare], TOP, mass)
    assert np.allclose(found.stiffness, stiffness, atol=1e-9)
    assert np.allclose(found.wind_force, wind, atol=1e-9)
    assert found.mass_source == "given"


def test_load_inputs_are_needed_and_the_message_says_what_to_do():
    bare = record(*matrices(5), input_names=tuple(f"u{k}" for k in range(8)))
    with pytest.raises(ValueError, match=r"a\.lin has no platform load inputs.*LinInputs = 2.*deck"):
        second_order([bare], TOP)


def test_nacelle_load_is_needed_for_the_tower_mode():
    names = tuple(n if "Nacelle" not in n else "other" for n in record(*matrices(5)).input_names)
    with pytest.raises(ValueError, match="no nacelle load inputs"):
        inverse_mass(record(*matrices(5), input_names=names), TOP)


def test_records_of_two_runs_do_not_mix():
    one, other = record(*matrices(1)), record(*matrices(1), state_names=tuple(f"z{k}" for k in range(14)))
    with pytest.raises(ValueError, match="has other states than"):
        second_order([one, other], TOP)


def test_rotating_states_without_a_blade():
    """A rotating state must name its blade, or multi-blade coordinates cannot be formed."""
    with pytest.raises(ValueError, match="rotating signal 'surge' names no blade"):
        second_order([record(*matrices(1), state_rotating=np.repeat([0.0, 1.0], 7))], TOP)


def test_a_state_without_its_velocity():
    with pytest.raises(ValueError, match="lacks the velocity state of surge"):
        second_order([record(*matrices(1), state_dof=(*DOFS, "", *DOFS[1:]))], TOP)


# --- ElastoDyn's finite rotation step --------------------------------------------------------------------------------


def test_no_error_for_a_body_about_its_own_centre():
    """Nothing turns about: with its centre of mass at the reference point the weight has no moment."""
    mass = rigid_mass(1e6, [0, 0, 0], np.diag([1e8, 2e8, 3e8]))
    assert np.abs(perturbation_error(mass, PLATFORM_DOFS, G)).max() < 1e-3 * 1e6 * G


def test_closed_form_of_a_tall_rigid_body():
    """Pitch of a rigid body about a point h below its centre, solved by hand.

    Turned by t, the weight's change is m g h sin t about the origin while M^-1 couples surge, heave and pitch of the turned
    body. With I about the centre of mass: angular acceleration m g h sin t / I, and the origin falls with -h times it across the
    turned axis, so surge accelerates by -h cos t of it and heave by +h sin t. Times M at t = 0: moment
    (I + m h^2) a - m h^2 cos t a, force m h a - m h cos t a.
    """
    m, h, inertia, t = 6e5, 70.0, 5e8, np.radians(2.0)
    found = perturbation_error(rigid_mass(m, [0, 0, h], inertia * np.eye(3)), PLATFORM_DOFS, G)
    a = m * G * h * np.sin(t) / inertia
    moment = ((inertia + m * h**2) * a - m * h**2 * np.cos(t) * a) / t
    force = (m * h * a - m * h * np.cos(t) * a) / t
    assert found[4, 4] == pytest.approx(-moment + m * G * h, rel=1e-5)  # derivative at zero by differences of 1e-5 rad
    assert found[0, 4] == pytest.approx(-force, rel=1e-5)
    assert found[3, 3] == pytest.approx(found[4, 4], rel=1e-6)


def test_error_falls_with_the_square_of_the_step(monkeypatch):
    import model.system.identified as module

    mass = rigid_mass(6e5, [0, 0, 70.0], 5e8 * np.eye(3))
    coarse = perturbation_error(mass, PLATFORM_DOFS, G)[4, 4]
    monkeypatch.setattr(module, "ROTATION_STEP", np.radians(1.0))
    assert perturbation_error(mass, PLATFORM_DOFS, G)[4, 4] == pytest.approx(coarse / 4, rel=1e-3)


def test_contained_parts_are_taken_out():
    """A record that holds a spring, a platform and added mass besides the turbine gives the turbine alone, without gravity's error."""
    mass, damping, stiffness, wind = matrices(8)
    stiffness = stiffness * 1e9
    extra = np.diag(np.arange(1.0, 7.0))
    spring = contribution("springs", "", stiffness=2 * extra, damping=3 * extra)
    body = contribution("platform", "", mass=4 * extra)
    added = contribution("infinite-frequency added mass", "", mass=5 * extra)
    wide = np.pad(extra, ((0, 1), (0, 1)))
    found = second_order([record(mass + 9 * wide, damping + 3 * wide, stiffness + 2 * wide, wind)], TOP)
    turbine = turbine_of_linearisation(found, [spring, body, added], gravity=0.0, source="test")
    assert np.allclose(turbine.mass, mass, atol=1e-7)
    assert np.allclose(turbine.damping, damping, atol=1e-6 * np.abs(damping).max())
    assert np.allclose(turbine.stiffness, stiffness, atol=1e-7 * np.abs(stiffness).max())


# --- OpenFAST's own files --------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def turbines(oc4):
    """The embedded turbine at every wind speed that has a linearisation."""
    return build(replace(oc4.case, states=()), speeds=[e.wind_speed for e in oc4.case.linearisations])


@pytest.fixture(scope="module")
def parked(oc4_folder):
    """The parked turbine alone, held by the springs of its deck: record, deck, second-order form less those springs."""
    folder = oc4_folder / "linearisation" / "turbine" / "parked"
    deck = read_deck(folder / "turbine.fst")
    found = second_order([read_openfast_lin(folder / "m.1.lin")], deck.elastodyn.structure.tower.top_height)
    springs = np.pad(deck.hydrodyn.stiffness, ((0, 1), (0, 1)))
    return deck, found, found.stiffness - springs


def test_mass_of_the_parked_turbine(parked):
    """ElastoDyn's own mass matrix: 599 108 kg and first moment 4.21216e7 (hand calculation of the reference data), and symmetric."""
    _, found, _ = parked
    assert found.mass[0, 0] == pytest.approx(599_107.8, rel=1e-6)
    assert found.mass[0, 4] == pytest.approx(4.212162e7, rel=1e-6)
    assert found.mass[4, 4] == pytest.approx(3.414907e9, rel=1e-6)


def test_mass_from_the_deck_is_the_same(parked):
    """Structural data against ElastoDyn at the same deflection; ten digits in the file, inverted: 1e-5. Yaw 4e-5 (blade's own twist inertia)."""
    deck, found, _ = parked
    own = structural_matrices(deck.elastodyn.structure, ("tower_fa1",), [found.point[6]])
    scale = np.sqrt(np.outer(np.diag(found.mass), np.diag(found.mass)))
    assert np.abs((own.mass - found.mass) / scale).max() < 5e-5


def test_finite_step_of_elastodyn_is_understood(parked):
    """The file's pitch stiffness is 1.56 % off pure gravity's -g M15 = -4.13072e8; without the step's error it is within 1e-4.

    Roll, where the tower mode has no part, must come out to 1e-5 of the error itself.
    """
    deck, found, raw = parked
    exact = -deck.gravity * found.mass[0, 4]
    assert exact == pytest.approx(-4.13072e8, rel=1e-5)
    assert raw[4, 4] / exact - 1 == pytest.approx(0.0156, abs=1e-4)
    error = perturbation_error(found.mass, found.dofs, deck.gravity)
    assert raw[4, 4] - error[4, 4] == pytest.approx(exact, rel=1e-4)
    assert raw[3, 3] - error[3, 3] == pytest.approx(exact, rel=1e-6)
    assert raw[1, 3] == pytest.approx(error[1, 3], rel=1e-4)
    # what is left of pitch and tower is 0.3 % of the error
    assert raw[0, 4] == pytest.approx(error[0, 4], rel=3e-3)
    own = structural_matrices(deck.elastodyn.structure, ("tower_fa1",), [found.point[6]]).stiffness
    assert raw[6, 4] - error[6, 4] == pytest.approx(own[6, 4], rel=1e-4)


def test_stiffness_and_damping_from_the_deck_are_the_same(parked):
    """Deflection, which no rotation spoils: 1e-4; its coupling with pitch 1e-3 (differences of the file's accelerations, ten digits)."""
    deck, found, raw = parked
    own = structural_matrices(deck.elastodyn.structure, ("tower_fa1",), [found.point[6]])
    assert raw[6, 6] == pytest.approx(own.stiffness[6, 6], rel=1e-4)
    assert raw[4, 6] == pytest.approx(own.stiffness[4, 6], rel=1e-3)
    assert found.damping[6, 6] == pytest.approx(own.damping[6, 6], rel=1e-4)


def test_published_values_of_running_turbines(oc4):
    """Thrust slope and damping of the air at 11 m/s: OpenFAST 5.0 reference run, extracted by another code.

    8.2840e4 N/(m/s), 7.4934e6 N m/(m/s), B11 8.2756e4 N s/m and B55 7.4941e8 N m s. That code's mass of the bent tower is
    1e-5 off, which such differences of large numbers show as 1e-3.
    """
    steady = replace(oc4.case, thrust_table=None)  # the linearisation's own slope, not that in turbulence
    turbine = build(steady, speeds=[11.0]).at(11.0).turbine
    assert turbine.wind_force[0] == pytest.approx(8.2840e4, rel=2e-3)
    assert turbine.wind_force[4] == pytest.approx(7.4934e6, rel=2e-3)
    assert turbine.damping[0, 0] == pytest.approx(8.2756e4, rel=2e-3)
    assert turbine.damping[4, 4] == pytest.approx(7.4941e8, rel=2e-3)
    assert turbine.rotor_speed == pytest.approx(11.89 * np.pi / 30, rel=1e-3)
    assert turbine.wind_speed == pytest.approx(11.0)


@pytest.mark.parametrize("speed", [8.0, 11.0, 11.4, 14.0, 18.0, 24.0])
def test_going_upwind_is_more_wind(turbines, speed):
    """Galilei: moving as a whole at 1 m/s upwind loads the turbine as 1 m/s more wind, in every degree of freedom.

    Two per cent of the largest for side forces, which are differences of azimuths; a few per mille downwind.
    """
    turbine = turbines.at(speed).turbine
    moving, wind = turbine.damping[:, 0], turbine.wind_force
    for k, name in ((0, "surge"), (4, "pitch"), (6, "tower")):
        assert moving[k] == pytest.approx(wind[k], rel=5e-3), name
    assert np.abs(moving[:3] - wind[:3]).max() < 0.02 * wind[0]
    assert np.abs(moving[3:6] - wind[3:6]).max() < 0.02 * wind[4]


@pytest.mark.parametrize("speed", [8.0, 11.0, 14.0, 18.0, 24.0])
def test_a_shifted_turbine_feels_the_same_wind(turbines, speed):
    """Steady uniform wind: a turbine moved as a whole has the same loads, so surge, sway and heave have no stiffness.

    The springs of 1e6 N/m that hold it cancel only if the deck's mass is ElastoDyn's: the mass matrix is so ill-conditioned that an
    error of 1e-6 in the bent tower's height leaves 100 N/m. Rotor ripple over twelve azimuths leaves up to 40 N/m; 1e-4 of the springs.
    """
    stiffness = turbines.at(speed).turbine.stiffness
    assert np.abs(stiffness[[0, 1, 2]][:, [0, 1, 2]]).max() < 1e2
    assert abs(stiffness[4, 0]) < 1e2  # N, against 1e6 N/m on an arm of 70 m
    assert abs(stiffness[6, 0]) < 1.0


@pytest.mark.parametrize(
    ("speed", "thrust"), [(8.0, 382.6e3), (11.0, 696.9e3), (14.0, 443.8e3), (18.0, 333.0e3), (24.0, 248.8e3)]
)
def test_thrust_of_running_turbines(turbines, speed, thrust):
    """The force at rest less weight, taken along the shaft (5 degrees down), is the thrust of the OpenFAST 5.0 reference runs.

    The springs' constant force was set from a run before; what moves the turbine at the linearised azimuths is 0.5 % of it.
    """
    turbine = turbines.at(speed).turbine
    force = turbine.force + turbine.stiffness @ turbine.point
    tilt = np.radians(5.0)
    assert force[0] * np.cos(tilt) - (force[2] + 599_107.8 * G) * np.sin(tilt) == pytest.approx(thrust, rel=5e-3)


def test_air_stiffens_the_pitch(turbines):
    """Thrust falls as the disk tilts away from the wind: less overturning than weight alone, by up to a few per cent."""
    weight = -G * turbines.at(0.0).turbine.mass[0, 4]
    for speed in (8.0, 11.0, 14.0, 18.0, 24.0):
        assert 0.0 < turbines.at(speed).turbine.stiffness[4, 4] / -weight + 1 < 0.05


def test_between_two_speeds(oc4):
    """No file at 12.7 m/s: half way between 11.4 and 14, said in the notes."""
    model = build(replace(oc4.case, states=()), speeds=[11.4, 12.7, 14.0])
    a, b, c = (p.turbine for p in model.points)
    for name in ("mass", "damping", "stiffness", "force", "wind_force"):
        assert np.allclose(getattr(b, name), (getattr(a, name) + getattr(c, name)) / 2, rtol=1e-9)
    assert any("12.7 m/s interpolated" in note for note in model.notes)
