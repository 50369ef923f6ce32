"""Assembly, mean offset and natural modes of bodies with closed-form answers."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from model.conventions import PLATFORM_DOFS
from model.response.assemble import all_parts, assemble, equilibrium, natural_modes, to_platform
from model.system.contributions import contribution, widen
from model.system.hydro import HydroCoefficients, radiation_at


def test_parts_add_up_in_the_order_asked_for(simple_body):
    m = np.arange(36.0).reshape(6, 6)
    m = m + m.T + 100 * np.eye(6)
    system = simple_body(mass=m, stiffness=2 * m, damping=3 * m, dofs=("pitch", "surge"))
    assert np.array_equal(system.mass, m[np.ix_([4, 0], [4, 0])])
    assert np.array_equal(system.stiffness, 2 * system.mass)
    assert np.array_equal(system.damping, 3 * system.mass)
    assert system.platform == [1, 0]
    assert np.array_equal(to_platform(system, [0.1, 2.0]), [2.0, 0, 0, 0, 0.1, 0])


def test_locking_a_degree_of_freedom_is_not_condensing_it(simple_body):
    """A locked motion drops out with its rows and columns; the others keep theirs."""
    k = np.diag([1.0, 2, 3, 4, 5, 6])
    k[0, 4] = k[4, 0] = 0.5
    free = simple_body(mass=np.eye(6), stiffness=k, dofs=("surge", "pitch"))
    locked = simple_body(mass=np.eye(6), stiffness=k, dofs=("surge",))
    assert free.stiffness.shape == (2, 2)
    assert locked.stiffness == k[0, 0]


def test_unknown_degree_of_freedom(simple_body):
    with pytest.raises(ValueError, match="'tower_fa1' is in no part of the model; there are surge, sway"):
        simple_body(mass=np.eye(6), dofs=("surge", "tower_fa1"))


def test_a_part_in_a_wider_model_keeps_its_place():
    part = contribution("a", "b", stiffness=np.diag(np.arange(1.0, 7.0)), force=np.arange(6.0))
    wide = widen(part, ("yaw", "tower_fa1", "surge"))
    assert np.array_equal(np.diag(wide.stiffness), [6.0, 0.0, 1.0])
    assert np.array_equal(wide.force, [5.0, 0.0, 0.0])


@given(st.integers(0, 10_000))
def test_linear_equilibrium(seed):
    """Without moorings the mean offset is C^-1 F, and a force given at another point counts the same."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(6, 6))
    k, force, point = root @ root.T + 6 * np.eye(6), rng.normal(size=6), rng.normal(size=6)
    a = contribution("a", "", stiffness=k, force=force, mass=np.eye(6))
    b = contribution("a", "", stiffness=k, force=force - k @ point, point=point, mass=np.eye(6))
    for part in (a, b):
        system = _system([part])
        assert np.allclose(equilibrium(system).offset, np.linalg.solve(k, force), atol=1e-9)


def _system(parts, hydro=None):
    from model.system.drag import no_drag
    from model.system.turbine import TurbineMatrices

    zero, line = np.zeros((6, 6)), np.zeros(6)
    none = TurbineMatrices(
        dofs=PLATFORM_DOFS, mass=zero, damping=zero, stiffness=zero, force=line, point=line, wind_force=line
    )
    hydro = hydro or HydroCoefficients(
        omega=[0.1, 1.0], added_mass=np.zeros((2, 6, 6)), radiation_damping=np.zeros((2, 6, 6))
    )
    return assemble(PLATFORM_DOFS, none, parts, hydro, no_drag(), None)


def test_a_free_floater_does_not_drift_in_the_mean(simple_body):
    """Without stiffness in surge, sway and yaw these stay where they are; heave follows its force."""
    system = simple_body(mass=np.eye(6), stiffness=np.diag([0, 0, 4.0, 5, 6, 0]), force=[0, 0, 8.0, 0, 0, 0])
    found = equilibrium(system)
    assert np.allclose(found.offset, [0, 0, 2.0, 0, 0, 0])
    assert found.mooring is None
    assert natural_modes(system, found).names == ("heave", "roll", "pitch")


def test_a_free_floater_cannot_hold_a_mean_force(simple_body):
    system = simple_body(mass=np.eye(6), stiffness=np.diag([0, 0, 4.0, 5, 6, 0]), force=[7e3, 0, 8.0, 0, 0, 0])
    with pytest.raises(ValueError, match=r"nothing holds the mean force of 7.0 kN in surge"):
        equilibrium(system)


def test_mean_force_on_moorings_balances(oc4):
    """At the mean offset all forces are in balance: thrust, weight, buoyancy, moorings; the residual is below 1e-6 of the thrust."""
    point = oc4.at(11.0)
    offset = point.mean.offset
    constant = sum(p.force - p.stiffness @ (offset - p.point) for p in point.system.parts)
    residual = constant[:6] + point.mean.mooring.force
    assert np.abs(residual[:3]).max() < 1.0
    assert np.abs(residual[3:]).max() < 100.0  # N m, of 7e7
    assert abs(constant[6]) < 1.0
    assert 2 <= point.mean.iterations < 20


def test_moorings_that_cannot_hold_say_so(oc4):
    """Fifty times the thrust: 35 MN on three chains."""
    point = oc4.at(0.0)
    push = contribution("push", "test", force=[1e9, 0, 0, 0, 0, 0])
    system = replace(point.system, parts=(*point.system.parts, widen(push, point.system.dofs)))
    with pytest.raises(ValueError, match="moorings"):
        equilibrium(system)


def test_everything_that_adds_up_is_listed(oc4):
    """The parts for people sum to the matrices that are solved, with the infinite-frequency added mass."""
    point = oc4.at(11.0)
    parts = all_parts(point.system, point.mean)
    assert [p.name for p in parts].count("moorings") == 1
    assert np.allclose(sum(p.stiffness for p in parts), point.mean.stiffness)
    added = np.zeros((7, 7))
    added[:6, :6] = oc4.hydro.added_mass_infinite
    assert np.allclose(sum(p.mass for p in parts), point.system.mass + added)
    assert all(p.source for p in parts)


# --- natural modes ---------------------------------------------------------------------------------------------------


@given(st.floats(0.1, 10.0), st.floats(0.0, 5.0), st.floats(0.1, 10.0), st.floats(0.0, 0.5))
def test_oscillator(mass, added, stiffness, ratio):
    """omega = sqrt(k / (m + a)) and the damping ratio c / (2 sqrt(k (m + a)))."""
    natural = np.sqrt(stiffness / (mass + added))
    hydro = HydroCoefficients(
        omega=[1e-3, 1e3], added_mass=np.stack([added * np.eye(6)] * 2), radiation_damping=np.zeros((2, 6, 6)),
        added_mass_zero=added * np.eye(6), added_mass_infinite=added * np.eye(6),
    )  # fmt: skip
    scatter = np.diag([1.0, 2.0, 4.0, 8.0, 16.0, 32.0])  # apart, so that modes can be told
    part = contribution(
        "a",
        "",
        mass=mass * np.eye(6),
        stiffness=stiffness * scatter,
        damping=2 * ratio * natural * (mass + added) * np.sqrt(scatter),
    )
    system = _system([part], hydro)
    found = natural_modes(system, equilibrium(system))
    exact = natural * np.sqrt(np.diag(scatter))
    assert found.names == PLATFORM_DOFS
    assert np.allclose(found.frequency, exact, rtol=1e-8)
    assert np.allclose(found.frequency_infinite, exact, rtol=1e-8)
    assert np.allclose(found.damping_ratio, ratio, atol=1e-8)
    assert np.allclose(np.abs(found.shape[:3, :3]), np.eye(3), atol=1e-8)


def test_two_coupled_oscillators(simple_body):
    """Masses 1, springs 1 to the ground and k between: omega^2 = 1 and 1 + 2 k, shapes in phase and opposed."""
    coupling = 0.7
    k = np.diag([1 + coupling, 1 + coupling, 9.0, 20.0, 30.0, 40.0])
    k[0, 1] = k[1, 0] = -coupling
    system = simple_body(mass=np.eye(6), stiffness=k)
    found = natural_modes(system, equilibrium(system))
    assert found.frequency[:2] == pytest.approx([1.0, np.sqrt(1 + 2 * coupling)])
    in_phase, opposed = found.shape[:2, 0], found.shape[:2, 1]
    assert in_phase[0] / in_phase[1] == pytest.approx(1.0)
    assert opposed[0] / opposed[1] == pytest.approx(-1.0)
    assert set(found.names[:2]) == {"surge", "sway"}


def test_added_mass_of_the_modes_own_frequency():
    """Added mass falls linearly from 3 at rest to 1 at 2 rad/s: omega^2 (1 + 3 - omega) = k has its root at 1 for k = 3."""
    omega = np.array([0.5, 1.0, 1.5, 2.0])
    added = (3.0 - omega)[:, None, None] * np.eye(6)
    hydro = HydroCoefficients(
        omega=omega,
        added_mass=added,
        radiation_damping=np.zeros((4, 6, 6)),
        added_mass_zero=3 * np.eye(6),
        added_mass_infinite=np.eye(6),
    )
    part = contribution("a", "", mass=np.eye(6), stiffness=np.diag([3.0, 1e4, 2e4, 3e4, 4e4, 5e4]))
    system = _system([part], hydro)
    found = natural_modes(system, equilibrium(system))
    assert found.frequency[0] == pytest.approx(1.0, abs=1e-8)
    assert found.frequency_infinite[0] == pytest.approx(np.sqrt(3.0 / 2.0))


def test_a_mode_damped_beyond_oscillating_keeps_its_place(simple_body):
    """Twice critical damping in surge: undamped frequency and ratio; the other modes do not take over."""
    system = simple_body(mass=np.eye(6), stiffness=np.diag(np.arange(1.0, 7.0)), damping=np.diag([4.0, 0, 0, 0, 0, 0]))
    found = natural_modes(system, equilibrium(system))
    assert found.names == PLATFORM_DOFS
    assert found.frequency == pytest.approx(np.sqrt(np.arange(1.0, 7.0)))
    assert found.damping_ratio == pytest.approx([2.0, 0, 0, 0, 0, 0], abs=1e-12)


def test_an_unstable_floater_says_where(simple_body):
    system = simple_body(mass=np.eye(6), stiffness=np.diag([1.0, 2, 3, 4, -5, 6]))
    with pytest.raises(ValueError, match="statically unstable in pitch"):
        natural_modes(system, equilibrium(system))


def test_every_mode_satisfies_its_own_equation(oc4):
    """(s^2 (M + A(|s|)) + s (B + B_rad(|s|)) + C) shape = 0 with s from frequency and damping."""
    point = oc4.at(11.0)
    m = point.modes
    assert sorted(m.names) == sorted(point.system.dofs)
    for w, z, shape in zip(m.frequency, m.damping_ratio, m.shape.T, strict=True):
        s = w * (-z + 1j * np.sqrt(1 - z**2))
        added, radiated = (np.pad(x[0], ((0, 1), (0, 1))) for x in radiation_at(point.system.hydro, np.array([w])))
        inertia, damping = s**2 * (point.system.mass + added), s * (point.system.damping + radiated)
        residual = (inertia + damping + point.mean.stiffness) @ shape
        size = np.abs(point.mean.stiffness) @ np.abs(shape)
        # fixed point to 1e-9 of the frequency; the equation feels twice that
        assert np.abs(residual / size).max() < 1e-6


def test_drag_damps_the_modes(oc4):
    point = oc4.at(0.0)
    damped = natural_modes(point.system, point.mean, np.diag([1e5, 1e5, 1e6, 1e9, 1e9, 1e9]))
    assert np.all(damped.damping_ratio[:6] > point.modes.damping_ratio[:6])
    heave = damped.names.index("heave")
    # c / (2 sqrt(k m)) with k 3.84e6 N/m and m 2.85e7 kg (mass 1.41e7 and added mass 1.44e7): 0.0478
    assert damped.damping_ratio[heave] - point.modes.damping_ratio[heave] == pytest.approx(
        1e6 / (2 * np.sqrt(3.84e6 * 2.85e7)), rel=0.02
    )
