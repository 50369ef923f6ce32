"""Rational fits, radiation as a passive state space, modal form, balanced reduction."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from model.reduce.excitation import fit_excitation
from model.reduce.passivity import least_damping
from model.reduce.radiation import fit_radiation, least_error
from model.reduce.rational import fit, frequency_response, partial_fractions, realisation, starting_poles
from model.reduce.state_space import StateSpace, modal_form, reduce_balanced, transfer
from model.reduce.targets import Targets
from model.response.cummins import retardation_transform
from model.system.hydro import HydroCoefficients

POLES = np.array([-0.3 + 0j, -0.1 + 0.7j, -0.2 + 1.6j])


def _space(a, b, c, d=None):
    n, m, p = len(a), b.shape[1], len(c)
    return StateSpace(
        a=a, b=b, c=c, d=np.zeros((p, m)) if d is None else d, mean=np.zeros(p), inputs=tuple(f"u{k}" for k in range(m)), input_units=("N",) * m,
        outputs=tuple(f"y{k}" for k in range(p)), output_units=("m",) * p, initial=np.zeros((n, 0)),
    )  # fmt: skip


def _random(seed: int, n: int, m: int = 2, p: int = 3) -> StateSpace:
    draw = np.random.default_rng(seed)
    a = draw.standard_normal((n, n))
    a -= (np.linalg.eigvals(a).real.max() + 0.1) * np.eye(n)
    return _space(a, draw.standard_normal((n, m)), draw.standard_normal((p, n)), draw.standard_normal((p, m)))


def _made_up_hydro(damping: float = 1.0) -> HydroCoefficients:
    """Coefficients of a known passive radiation: K = s (alpha) / ((s + beta)^2 + omega^2) has Re K >= 0 everywhere.

    With K = alpha s / (s^2 + 2 beta s + w0^2): Re K = 2 alpha beta w^2 / |.|^2. Surge and pitch share it, with a full coupling.
    """
    omega = np.concatenate([np.arange(0.05, 1.5, 0.025), np.arange(1.5, 3.01, 0.1)])
    s = 1j * omega
    one = damping * 4e6 * s / (s**2 + 0.4 * s + 0.81)
    shape = np.zeros((6, 6))
    shape[np.ix_([0, 4], [0, 4])] = [[1.0, -20.0], [-20.0, 400.0]]
    shape[np.ix_([1, 3], [1, 3])] = [[1.0, 20.0], [20.0, 400.0]]
    shape[2, 2], shape[5, 5] = 0.3, 300.0
    k = one[:, None, None] * shape
    infinite = np.diag([8e6, 8e6, 1.4e7, 7e9, 7e9, 5e9])
    zero = infinite + 4e6 / 0.81 * damping * shape  # the limit of Im K / omega
    return HydroCoefficients(
        omega=omega, added_mass=infinite + k.imag / omega[:, None, None], radiation_damping=k.real, added_mass_zero=zero, added_mass_infinite=infinite,
    )  # fmt: skip


def test_a_rational_function_is_found_again():
    omega = np.linspace(0.05, 3, 120)
    draw = np.random.default_rng(3)
    values = partial_fractions(1j * omega, POLES) @ draw.standard_normal((5, 3))
    found, error = fit(omega, values, np.ones((2, *values.shape)), starting_poles(5, 0.3, 2.0, 1))
    assert (
        error < 1e-6 * np.abs(values).max()
    )  # vector fitting is exact when the order is right; rounding of the least squares
    known = np.sort_complex(found.poles)
    assert np.abs(known - np.sort_complex(POLES)).max() < 1e-4


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 1000))
def test_the_real_basis_has_its_realisation(seed):
    draw = np.random.default_rng(seed)
    poles = np.concatenate([-draw.uniform(0.01, 2, 2) + 0j, -draw.uniform(0.01, 2, 3) + 1j * draw.uniform(0.1, 5, 3)])
    omega = draw.uniform(0.01, 10, 7)
    a, b = realisation(poles)
    state = np.linalg.solve(1j * omega[:, None, None] * np.eye(len(a)) - a, b[:, None] + 0j)[..., 0]
    assert np.allclose(state, partial_fractions(1j * omega, poles), rtol=1e-9)  # rounding of a solve


def test_a_block_diagonal_system_answers_by_its_modes():
    """Equal blocks, as each input of the radiation has its own copy of the poles; and no state at all, as of a hull of strips."""
    a, drive = realisation(POLES)
    a, b = np.kron(np.eye(2), a), np.kron(np.eye(2), drive[:, None])
    c, omega = np.random.default_rng(1).standard_normal((3, len(a))), np.linspace(0.01, 5, 9)
    known = c @ np.linalg.solve(1j * omega[:, None, None] * np.eye(len(a)) - a, b + 0j)
    assert np.allclose(frequency_response(a, b, c, omega), known, rtol=0, atol=1e-12 * np.abs(known).max())  # rounding
    none = frequency_response(np.zeros((0, 0)), np.zeros((0, 6)), np.zeros((6, 0)), omega)
    assert none.shape == (9, 6, 6)
    assert not none.any()


def test_radiation_of_a_known_kernel_is_found_again():
    hydro = _made_up_hydro()
    found = fit_radiation(hydro)
    assert (
        found.largest_error < 2e-3
    )  # the kernel is rational; what is left is the tail beyond the data, which is not (omega^-4 damping)
    assert set(found.blocks) == {("surge", "pitch"), ("sway", "roll"), ("heave",), ("yaw",)}
    assert np.linalg.eigvals(found.a).real.max() < 0
    low = found(np.array([1e-4]))[0]
    added = low.imag / 1e-4
    # K / (i omega) goes to A(0) - A_inf; heave as an example, to the accuracy of the fit
    assert added[2, 2] == pytest.approx((hydro.added_mass_zero - hydro.added_mass_infinite)[2, 2], rel=0.01)
    assert np.abs(np.diag(found.added_mass_change) / np.diag(hydro.added_mass_infinite)).max() < 2e-3  # the data agree with themselves
    assert (
        np.abs(low.real).max() < 1e-4 * np.abs(retardation_transform(hydro, hydro.omega)).max()
    )  # no damping at rest: K(0) = 0


def test_radiation_is_passive_where_the_data_are_not():
    """Data with a negative damping over a stretch, as panel codes give near irregular frequencies: the fit must not follow."""
    hydro = _made_up_hydro()
    damping = hydro.radiation_damping.copy()
    stretch = (hydro.omega > 1.9) & (hydro.omega < 2.3)
    damping[stretch, 2, 2] = -0.03 * damping[:, 2, 2].max()
    from dataclasses import replace

    found = fit_radiation(replace(hydro, radiation_damping=damping))
    omega = np.linspace(1e-3, 10, 8000)
    heave = found(omega)[:, 2, 2].real
    peak = np.abs(retardation_transform(hydro, hydro.omega)[:, 2, 2]).max()
    assert found.least_damping[0] < -1e-3  # the free fit does follow
    assert heave.min() > -1e-5 * peak  # what counts as rounding in the module
    assert found.least_damping[1] > -1e-5


def test_what_no_passive_kernel_can_follow():
    """Nothing of a kernel that is one; half at least of a step of the added mass where nothing radiates."""
    from dataclasses import replace

    hydro = _made_up_hydro()
    assert least_error(hydro, 2) < 3e-3  # damping that is linear between the frequencies, 0.025 rad/s apart about the peak
    added, places = hydro.added_mass.copy(), hydro.omega > 2.45
    peak = np.abs(retardation_transform(hydro, hydro.omega)[:, 2, 2]).max()
    still = hydro.radiation_damping.copy()
    still[hydro.omega > 2.0, 2, 2] = 0.0  # so that a kernel's own added mass cannot rise there: d A / d omega > 0 needs damping
    added[places, 2, 2] += np.where(np.arange(places.sum()) % 2, 0.04, -0.04) * peak / hydro.omega[places]
    wavering = replace(hydro, added_mass=added, radiation_damping=still)
    # a kernel in the middle of the step errs by 0.04, the damping cut off above 2 rad/s adds; half the step were it to follow a little
    assert 0.02 < least_error(wavering, 2) < 0.06


def test_oc4_radiation(oc4, parked):
    """The fit of the embedded case: stable, passive, below one per cent of each significant pair's peak.

    Heave alone stays above: added mass and damping of the data contradict each other, and no passive kernel follows both.
    """
    radiation = parked.linearised.radiation
    assert np.linalg.eigvals(radiation.a).real.max() < 0
    assert radiation.least_damping[1] > -1e-5
    error = radiation.error.copy()
    floor = least_error(parked.linearised.point.system.hydro, 2)
    assert 0.01 < floor < error[2, 2] < 0.0175  # fitted by itself, without regard to responses, heave has 1.7 %
    error[2, 2] = np.nan
    assert np.nanmax(error) < 0.01
    omega = np.linspace(0.001, 6, 3000)
    k = radiation(omega)
    peak = np.sqrt(np.diag(np.abs(retardation_transform(oc4.hydro, oc4.hydro.omega)).max(axis=0)))
    lowest = np.linalg.eigvalsh((k.real + np.swapaxes(k.real, 1, 2)) / 2 / np.outer(peak, peak)).min()
    assert lowest > -1e-5  # an independent, dense look at what the module says of itself


def test_negative_damping_between_grid_points_is_seen():
    """A resonance far narrower than any grid: its negative damping shows through the pencil's imaginary eigenvalues."""
    narrow, broad = np.array([[0.0, 1.0], [-4.0, -2e-7]]), np.array([[0.0, 1.0], [-1.0, -1.0]])
    a = np.block([[narrow, np.zeros((2, 2))], [np.zeros((2, 2)), broad]])
    b, c = np.array([[0.0], [1.0], [0.0], [1.0]]), np.array([[0.0, -1e-6, 0.0, 1.0]])
    lowest, places = least_damping(a, b, c, np.ones(1), 3.0)
    # at resonance the narrow part is -1e-6 / 2e-7 = -5, the broad one w^2 / ((1 - w^2)^2 + w^2) = 4/13
    assert lowest == pytest.approx(-5 + 4 / 13, rel=0.05)
    assert min(abs(w - 2.0) for w in places) < 1e-5


def test_a_delayed_causal_force_is_found_again():
    """An excitation that begins 6 s before the crest: causal after the shift; the force itself is the response to be met."""
    omega = np.linspace(0.03, 3.0, 200)
    s = 1j * omega
    force = (1e6 * 0.6 * s / (s**2 + 0.5 * s + 0.5) * np.exp(s * 6.0))[:, None]
    gain = np.zeros((200, 1, 6), dtype=complex)
    gain[:, 0, 0] = 1.0
    every = np.ones(200, dtype=bool)
    wanted = Targets(omega=omega, gain=gain, share=1 / force, data=every)
    own = np.zeros((200, 1))
    poles, found, shift, worst = fit_excitation(omega, force, every, wanted, own, np.array([0]), shifts=((10.0, 24),))
    assert shift == 10.0
    assert poles.real.max() < 0
    fitted = partial_fractions(1j * omega, poles) @ found[:, 0] * np.exp(s * shift)
    assert np.abs(fitted / force[:, 0] - 1).max() == pytest.approx(worst, rel=1)  # worst counts a phase a little less
    assert worst < 0.0135  # the target


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10000), n=st.integers(1, 9))
def test_the_modal_form_is_the_same_system(seed, n):
    space = _random(seed, n)
    modal = modal_form(space)
    omega = np.geomspace(0.01, 20, 9)
    reference = transfer(space, omega)
    # rounding, times the condition of the eigenvectors of a random matrix of this size
    assert np.allclose(transfer(modal, omega), reference, rtol=0, atol=1e-7 * np.abs(reference).max())


def test_two_equal_poles_have_a_modal_form_too():
    """A chain of two equal lags cannot be diagonalised; a change in its last digits can, and is told."""
    space = _space(np.array([[-1.0, 1.0], [0.0, -1.0]]), np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]]))
    modal = modal_form(space)
    assert 0 < modal.perturbation <= 1e-10
    omega = np.geomspace(0.01, 10, 9)
    assert np.allclose(transfer(modal, omega)[:, 0, 0], 1 / (1 + 1j * omega) ** 2, atol=1e-5)  # sqrt of the change


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10000), keep=st.integers(1, 6))
def test_reduction_keeps_its_bound(seed, keep):
    space = _random(seed, 8)
    reduced, values, bound = reduce_balanced(space, keep)
    assert np.all(np.diff(values) <= 1e-9 * values[0])
    gain = np.abs(transfer(space, np.geomspace(1e-3, 10, 200)) - space.d).max(axis=0)
    rows = gain.max(axis=1)
    columns = (gain / rows[:, None]).max(axis=0)
    omega = np.geomspace(1e-3, 1e3, 400)
    error = (transfer(space, omega) - transfer(reduced, omega)) / rows[:, None] / columns
    assert (
        np.linalg.svd(error, compute_uv=False).max() <= bound * (1 + 1e-6) + 1e-9 * values[0]
    )  # Glover's bound, rounding
    assert np.linalg.eigvals(reduced.a).real.max() < 1e-9


def test_what_is_not_stable_is_not_reduced():
    with pytest.raises(ValueError, match="moorings"):
        reduce_balanced(
            _space(np.array([[0.0, 1.0], [0.0, -1.0]]), np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]])), 1
        )
