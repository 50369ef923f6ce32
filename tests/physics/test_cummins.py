"""Retardation functions and Ogilvie's relations on damping with closed forms, decays against modes, the embedded hull."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from model.conventions import PLATFORM_DOFS
from model.response.assemble import assemble, equilibrium, natural_modes
from model.response.cummins import (
    added_mass_of_damping,
    consistency_rows,
    decay_period,
    decay_rows,
    free_decay,
    mode_decay_period,
    radiation_consistency,
    radiation_of_retardation,
    retardation,
    zero_added_mass_of_damping,
)
from model.system.contributions import contribution
from model.system.drag import no_drag
from model.system.hydro import HydroCoefficients
from model.system.turbine import TurbineMatrices

C1, C2 = 0.4, 1.1  # 1/s


def memory(size=1.0, count=4000, top=60.0) -> HydroCoefficients:
    """A body whose surge radiation has the retardation function (e^{-c1 t} c1 - e^{-c2 t} c2) / (c1 - c2), up to a factor.

    Its transforms: integral K cos = B = s w2 / ((w2 + c1^2)(w2 + c2^2)), which vanishes at zero as w2 and falls as w-2.
    """
    omega = np.linspace(top / count, top, count)
    damping = np.zeros((count, 6, 6))
    damping[:, 0, 0] = size * omega**2 / ((omega**2 + C1**2) * (omega**2 + C2**2))
    added = np.zeros((count, 6, 6))
    added[:, 0, 0] = 2.0 + size * _added(omega)
    infinite = np.diag([2.0, 0, 0, 0, 0, 0])
    return HydroCoefficients(omega=omega, added_mass=added, radiation_damping=damping, added_mass_infinite=infinite)


def _kernel(t):
    """Inverse of B: w2 / ((w2 + a2)(w2 + b2)) = (b2 / (w2 + b2) - a2 / (w2 + a2)) / (b2 - a2), each the transform of e^{-a t} a."""
    return (C2 * np.exp(-C2 * t) - C1 * np.exp(-C1 * t)) / (C2**2 - C1**2)


def _added(w):
    """Ogilvie: -1/w integral K sin(w t), with integral e^{-a t} sin(w t) = w / (w2 + a2)."""
    return -(C2 / (w**2 + C2**2) - C1 / (w**2 + C1**2)) / (C2**2 - C1**2)


def test_retardation_in_closed_form():
    """What is cut beyond 60 rad/s: B falls as w-2 there, taken as w-4; the difference is below 2/pi / 60 * 2/3 of the size."""
    t = np.array([0.0, 0.3, 1.0, 3.0, 10.0, 40.0])
    found = retardation(memory(), t)[:, 0, 0]
    assert abs(found[0] - _kernel(0.0)) < 2 / np.pi / 60 * 0.7
    assert np.allclose(found[1:], _kernel(t[1:]), atol=5e-4)  # the cut rings with sin(60 t) / (60^2 t)
    assert np.all(retardation(memory(), t)[:, 1:] == 0)


@pytest.mark.parametrize("t", [0.0, 0.02, 0.7, 5.0, 30.0])
def test_retardation_of_piecewise_linear_damping(t):
    """Adaptive quadrature of the damping as `radiation_at` continues it; w^-4 beyond the data."""
    hydro = memory(count=7, top=3.0)
    w = np.concatenate([[0.0], hydro.omega])
    b = np.concatenate([[0.0], hydro.radiation_damping[:, 0, 0]])
    inside = quad(lambda x: np.interp(x, w, b) * np.cos(x * t), 0, 3.0, points=w[1:-1], limit=400)[0]
    tail = b[-1] * 3.0**4 * (quad(lambda x: x**-4, 3.0, np.inf, weight="cos", wvar=t)[0] if t else 3.0**-3 / 3)
    assert np.isclose(retardation(hydro, [t])[0, 0, 0], 2 / np.pi * (inside + tail), rtol=1e-7, atol=1e-9)


def test_far_tail_is_continuous():
    """The tail changes from closed form to series where frequency times time is 200: no step, to rounding of z^3 = 8e6."""
    hydro = memory(count=7, top=3.0)
    t = 200 / 3.0 * np.array([1 - 1e-7, 1 + 1e-7])
    a, b = retardation(hydro, t)[:, 0, 0]
    assert abs(a - b) < 1e-7


def test_added_mass_of_damping_in_closed_form():
    """The line from zero to the first frequency, 0.015 rad/s, in place of a parabola: 2/pi B1 w1 / (6 w2) at w, 7e-4 at 0.2 rad/s."""
    hydro = memory()
    w = np.array([0.2, 1.0, 3.0, hydro.omega[100], 15.0])
    assert np.allclose(added_mass_of_damping(hydro, w)[:, 0, 0], _added(w), atol=1e-3)
    # lines through a parabola: 2/pi h b / 6 times the sum of 1/k2 is at most 0.014 for b = 1 / (c1 c2)2 and h = 0.015 rad/s
    assert np.isclose(zero_added_mass_of_damping(hydro)[0, 0], _added(0.0), atol=0.014)
    assert np.isclose(_added(0.0), 1 / (C1 * C2 * (C1 + C2)))


@settings(max_examples=20, deadline=None)
@given(st.floats(0.05, 8.0))
def test_principal_value(omega):
    """Against quadrature with a Cauchy weight, coarse data, frequencies inside and beyond them."""
    hydro = memory(count=9, top=4.0)
    w = np.concatenate([[0.0], hydro.omega])
    if np.min(np.abs(w - omega)) < 1e-3:  # the quadrature, not the closed form, fails next to a corner
        omega += 2e-3
    b = np.concatenate([[0.0], hydro.radiation_damping[:, 0, 0]])

    def damping(x):
        return np.interp(x, w, b) if x < 4.0 else b[-1] * (4.0 / x) ** 4

    edges = [*w, 20.0]
    total = 0.0
    for low, high in pairwise(edges):
        if low < omega < high:
            total += quad(lambda x: damping(x) / (x + omega), low, high, weight="cauchy", wvar=omega)[0]
        else:
            total += quad(lambda x: damping(x) / (x**2 - omega**2), low, high, limit=200)[0]
    total += quad(lambda x: damping(x) / (x**2 - omega**2), 20.0, np.inf)[0]
    assert np.isclose(added_mass_of_damping(hydro, [omega])[0, 0, 0], 2 / np.pi * total, rtol=1e-5, atol=1e-6)


def test_back_from_the_retardation_function():
    """Damping and added mass again, from the exact kernel sampled at 0.01 s up to 60 s, where it is e^-24."""
    t, w = np.arange(0, 60, 0.01), np.array([0.1, 0.5, 2.0, 10.0])
    added, damping = radiation_of_retardation(t, _kernel(t), w)
    hydro = memory()
    assert np.allclose(added, _added(w), atol=1e-5)  # lines between samples: K'' 1e-4 / 12
    assert np.allclose(damping, w**2 / ((w**2 + C1**2) * (w**2 + C2**2)), atol=2e-5)
    there = radiation_of_retardation(
        np.arange(0, 60, 0.02), retardation(hydro, np.arange(0, 60, 0.02)), hydro.omega[20:800:60]
    )
    assert np.allclose(there[1], hydro.radiation_damping[20:800:60], atol=4e-3)  # the cut at 60 rad/s, read back at 12
    with pytest.raises(ValueError, match="causal"):
        retardation(hydro, [-1.0])
    for function in (lambda w: added_mass_of_damping(hydro, w), lambda w: radiation_of_retardation(t, _kernel(t), w)):
        with pytest.raises(ValueError, match="above zero"):
            function([0.0])


def test_consistency_finds_what_is_wrong():
    """A consistent body, the same with a constant 10 % of its variation added to A, and with a wrong infinite value."""
    good = memory(count=600, top=30.0)
    found = radiation_consistency(good)
    assert found.misfit[0, 0] < 0.01
    assert np.isclose(found.infinite[0, 0], 2.0, atol=2e-3)
    assert np.isclose(found.zero[0, 0], 2.0 + _added(0.0), rtol=5e-3)  # steps of 0.05 rad/s
    assert np.isnan(found.misfit[1, 1])
    doubled = replace(good, radiation_damping=2 * good.radiation_damping)
    assert np.isclose(
        radiation_consistency(doubled).misfit[0, 0], 1.0, atol=0.1
    )  # the implied variation is twice the one there is
    lifted = replace(good, added_mass=good.added_mass + np.diag([0.3, 0, 0, 0, 0, 0]))
    assert np.isclose(radiation_consistency(lifted).infinite[0, 0], 2.3, atol=2e-3)
    assert radiation_consistency(lifted).misfit[0, 0] > 1
    (row,) = consistency_rows(good)
    assert row[0] == "radiation, surge"
    assert "(data 2)" in row[1]


def test_embedded_hull_agrees_with_itself(oc4):
    """Boundary-element coefficients of the OC4 semisubmersible: infinite-frequency added mass from damping within 0.3 % of the one
    that was solved for, zero-frequency within 0.3 % but in heave, whose added mass has no limit in water of finite depth.
    """
    found = radiation_consistency(oc4.hydro)
    for k in range(6):
        assert np.isclose(found.infinite[k, k], found.given_infinite[k, k], rtol=3e-3)
        if k != 2:
            assert np.isclose(found.zero[k, k], found.given_zero[k, k], rtol=3e-3)
        assert found.misfit[k, k] < 0.05
    assert len(consistency_rows(oc4.hydro)) == 8  # six motions, surge with pitch, sway with roll


# --- decays ----------------------------------------------------------------------------------------------------------


def body(hydro, mass, damping, stiffness):
    zero, line = np.zeros((6, 6)), np.zeros(6)
    turbine = TurbineMatrices(
        dofs=PLATFORM_DOFS, mass=zero, damping=zero, stiffness=zero, force=line, point=line, wind_force=line
    )
    one = np.diag([1.0, 0, 0, 0, 0, 0])
    part = contribution("body", "test", mass=mass * one, damping=damping * one, stiffness=stiffness * one)
    return assemble(("surge",), turbine, [part], hydro, no_drag(), None)


def _still():
    return HydroCoefficients(
        omega=[0.1, 10.0], added_mass=np.zeros((2, 6, 6)), radiation_damping=np.zeros((2, 6, 6)),
        added_mass_infinite=np.zeros((6, 6)),
    )  # fmt: skip


def test_decay_of_a_damped_oscillator():
    """x = e^{-z w t} (cos + z/sqrt(1 - z2) sin): Newmark's period error is (w h)2 / 12, 3e-5 here; over three periods of phase."""
    system = body(_still(), 2.0, 0.2, 8.0)
    omega, ratio = 2.0, 0.2 / (2 * np.sqrt(16.0))
    wd = omega * np.sqrt(1 - ratio**2)
    run = free_decay(system, equilibrium(system), [0.5], duration=9.0, step=0.01)
    exact = (
        0.5
        * np.exp(-ratio * omega * run.time)
        * (np.cos(wd * run.time) + ratio / np.sqrt(1 - ratio**2) * np.sin(wd * run.time))
    )
    assert np.allclose(run.motion[:, 0], exact, atol=5e-4)
    assert np.isclose(decay_period(run.time, run.motion[:, 0]), 2 * np.pi / wd, rtol=1e-4)
    assert np.isnan(decay_period(run.time[:100], run.motion[:100, 0]))


def test_decay_with_memory_is_that_of_its_state_space():
    """The two exponentials of the kernel are two states: the same decay from a matrix exponential's eigenvalues."""
    size, mass, stiffness = 3.0, 3.0, 12.0
    system = body(memory(size=size, count=3000, top=80.0), mass, 0.0, stiffness)
    a, b = -size * C1 / (C2**2 - C1**2), size * C2 / (C2**2 - C1**2)
    total = mass + 2.0
    state = np.array([[0, 1, 0, 0], [-stiffness / total, 0, -1 / total, -1 / total], [0, a, -C1, 0], [0, b, 0, -C2]])
    run = free_decay(system, equilibrium(system), [1.0], duration=20.0, step=0.02, memory=20.0)
    values, vectors = np.linalg.eig(state)
    parts = np.linalg.solve(vectors, np.array([1.0, 0, 0, 0]))
    exact = np.real(np.exp(np.outer(run.time, values)) @ (vectors[0] * parts))
    # the cut of the damping at 80 rad/s weakens the kernel's first instant: an impulse of 2/pi s / 80^2 * 2/3
    assert np.allclose(run.motion[:, 0], exact, atol=4e-3)


def test_decays_of_the_embedded_case_have_the_periods_of_its_modes(oc4):
    """Surge to tower of the floater, started in each mode's shape: zero crossings of six cycles in the time domain against
    eigenvalues. What differs is A(omega) between data and the few per cent by which A and B disagree: 0.3 %.
    """
    point = oc4.points[0]
    names = point.modes.names
    for name in ("surge", "heave", "pitch", "yaw", "tower_fa1"):
        k = names.index(name)
        want = 2 * np.pi / (point.modes.frequency[k] * np.sqrt(1 - point.modes.damping_ratio[k] ** 2))
        assert np.isclose(mode_decay_period(point.system, point.mean, point.modes, k, cycles=4.0), want, rtol=3e-3), (
            name
        )


def test_decays_against_openfast(oc4):
    """OpenFAST's decays in still water: surge 113.0, heave 17.07, pitch 25.6, tower 2.309 s; they have drag, which moves
    periods by tenths of a per cent, and are read to as much.
    """
    point = oc4.points[0]
    for name, period in (("surge", 113.0), ("heave", 17.07), ("pitch", 25.6), ("tower_fa1", 2.309)):
        k = point.modes.names.index(name)
        assert np.isclose(mode_decay_period(point.system, point.mean, point.modes, k, cycles=4.0), period, rtol=7e-3), (
            name
        )


def test_rows_and_misuse():
    system = body(memory(count=400, top=20.0), 3.0, 0.05, 12.0)
    mean = equilibrium(system)
    modes = natural_modes(system, mean)
    (row,) = decay_rows(system, mean, modes)
    assert row[0] == "decay, surge"
    assert "s in the time domain" in row[1]
    with pytest.raises(ValueError, match="below the duration"):
        free_decay(system, mean, [1.0], duration=1.0, step=2.0)
