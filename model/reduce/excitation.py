"""Wave excitation as a causal state space driven by the wave elevation, delayed by a stated time shift.

A wave's force begins before its crest arrives, so F = X eta is not causal; F(t - shift) is, nearly, and is fitted by a stable
rational function with poles that all six forces share. The same device as HydroDyn's state-space excitation (ExctnMod 2).
Reference: Falnes, Applied Ocean Research 17(3), 1995.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import cho_factor, cho_solve

from model.conventions import PLATFORM_DOFS, freeze
from model.reduce.rational import frequency_response, orthogonal, partial_fractions, pole_at, realisation
from model.reduce.targets import PHASE, Targets
from model.response.solve import Response
from model.system.hydro import HydroCoefficients, excitation_at

TARGET = 0.0135  # of any response; see Targets for what a phase counts
SHIFTS = ((20.0, 48), (40.0, 72), (60.0, 108))  # s, and orders of the memory, tried in turn
MEMORY = 140.0  # s that the memory may last beyond the shift
STEP = 0.9  # s between samples of the memory: up to 3.5 rad/s
SLOW = (0.003, 0.01, 0.03, 0.1)  # 1/s: what the memory cannot hold, below the lowest frequency of the data
SLOWEST = 2e-3  # 1/s, least decay of any other pole
BENDS = (-0.06 + 1j, -0.2 + 1j), (-0.005 + 1j, -0.015 + 1j, -0.04 + 1j)  # poles over the frequencies where the data begin and end
MORE, PATIENCE = 24, 6  # poles added at most, and tried without a tenth of gain
START, HOPELESS = 3, 1.6  # poles after which a shift is left when its error is still so many times the target
NARROW, DECAYS = 0.015, (1.0, 2.0, 0.7)  # rad/s up to 2 rad/s, then that share of it: decay of the poles added
FEW, ROUNDS = 3, 12  # of reweighting, on the way and at the end
OWN = 0.3  # what an error of a force relative to its own peak counts beside one of a response; a tenth of it outside the band


@dataclass(frozen=True, eq=False, kw_only=True)
class ExcitationFit:
    """Wave force f = C z, z' = A z + b eta: a (r, r), b (r), c (6, r) for a force `shift` [s] late.

    error (6): largest error over the frequencies of the data as a fraction of each force's largest value (zero where there is no
    force); worst: largest error of any response in the band as `Targets` counts it, 0.02 standing for 2 % or 2 degrees.
    """

    a: np.ndarray
    b: np.ndarray
    c: np.ndarray
    shift: float
    error: np.ndarray
    worst: float

    def __post_init__(self):
        freeze(self, a=("r", "r"), b=("r",), c=(6, "r"), error=(6,))

    def __call__(self, omega) -> np.ndarray:
        """Return the force (n, 6) per metre of wave amplitude at omega (n) [rad/s], the shift taken out again."""
        omega = np.asarray(omega, dtype=float)
        late = frequency_response(self.a, self.b[:, None], self.c, omega)[..., 0]
        return late * np.exp(1j * omega * self.shift)[:, None]


@dataclass(frozen=True, eq=False, kw_only=True)
class WaveForce:
    """Wave force per metre of amplitude: that of potential flow from the data, and drag's (m, n, 6) at omega (n) [rad/s], as it was
    linearised for the response's sea; headings (m) [rad]; rows (6) true where the platform is free to move.
    """

    hydro: HydroCoefficients
    low_frequency: str
    omega: np.ndarray
    heading: np.ndarray
    drag: np.ndarray
    free: np.ndarray

    def __post_init__(self):
        freeze(self, omega=("n",), heading=("m",), drag=("m", "n", 6), free=(6,))

    def at(self, omega, column: int) -> np.ndarray:
        """Return the force (k, 6) at frequencies omega (k) [rad/s] from one of the headings."""
        omega = np.asarray(omega, dtype=float)
        potential = excitation_at(self.hydro, omega, self.heading[column], low_frequency=self.low_frequency)
        drag = [
            np.interp(omega, self.omega, f.real) + 1j * np.interp(omega, self.omega, f.imag)
            for f in self.drag[column].T
        ]
        return (potential + np.stack(drag, axis=1)) * self.free


def wave_force(hydro: HydroCoefficients, response: Response, *, low_frequency: str = "hold") -> WaveForce:
    """Return the wave force of a response, whose solution used the same coefficients and `low_frequency`."""
    here = [(PLATFORM_DOFS.index(d), response.dofs.index(d)) for d in response.dofs if d in PLATFORM_DOFS]
    rows, places = ([pair[k] for pair in here] for k in (0, 1))
    drive = response.excitation
    full = np.einsum("nij,mnj->mni", response.dynamic_stiffness, response.to_wave)
    potential = excitation_at(hydro, drive.omega, drive.heading, low_frequency=low_frequency)
    drag, free = np.zeros((*full.shape[:2], 6), dtype=complex), np.zeros(6)
    drag[..., rows] = full[..., places] - potential[..., rows]
    free[rows] = 1.0
    return WaveForce(
        hydro=hydro, low_frequency=low_frequency, omega=drive.omega, heading=drive.heading, drag=drag, free=free
    )


def fit_wave_force(waves: WaveForce, column: int, targets: Targets) -> ExcitationFit:
    """Return the causal state space of the wave force from one heading (its place among those of `waves`)."""
    top = targets.omega[-1]
    omega = np.concatenate([targets.omega[0] * np.array([0.4, 0.7]), targets.omega, top * np.array([1.05, 1.15, 1.3, 1.5, 1.8])])
    inside = (omega >= targets.omega[0]) & (omega <= top)
    force = waves.at(omega, column)
    peak = np.abs(force[inside]).max(axis=0)
    lever = np.where(np.arange(6) < 3, 1.0, 30.0)  # m, to tell forces and moments that are there from rounding
    live = np.flatnonzero((peak > 0) & (peak > 1e-4 * lever * (peak / lever).max(initial=0.0)))
    if not len(live):
        none = np.zeros(0)
        return ExcitationFit(a=np.zeros((0, 0)), b=none, c=np.zeros((6, 0)), shift=0.0, error=np.zeros(6), worst=0.0)
    own = OWN * np.where(inside, 1.0, 0.1)[:, None] / peak[live]
    poles, found, shift, worst = fit_excitation(omega, force[:, live], inside, targets, own, live)
    a, b = realisation(poles)
    c = np.zeros((6, len(a)))
    c[live] = found.T
    out = ExcitationFit(a=a, b=b, c=c, shift=shift, error=np.zeros(6), worst=worst)
    data = omega[inside][targets.data]
    error, known = np.zeros(6), waves.at(data, column)
    error[live] = np.abs(out(data) - known)[:, live].max(axis=0) / np.abs(known).max(axis=0)[live]
    object.__setattr__(out, "error", error)
    return out


def fit_excitation(
    omega, force, inside, targets: Targets, own, live, *, shifts=SHIFTS, target: float = TARGET
) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Return poles, coefficients (b, l), shift [s] and the largest error of any response of a causal fit of a force.

    Parameters
    ----------
    omega : (n) [rad/s]; force : (n, l) complex, the degrees of freedom `live` of six; inside : (n) true where `targets` hold
    targets : the responses to be met with the force
    own : (n, l) what an error of the force itself counts
    shifts : pairs of shift [s] and order, tried in turn; the first that reaches the target, else the best

    Poles are those of the late force's impulse response (`impulse_poles`), and narrow ones where the error is largest: where the data begin
    and end, and where splines between them bend. The coefficients follow from the responses, with weights that grow where the error is
    large (Lawson), so that the largest error falls.
    """
    best, ends = None, targets.omega[targets.data][[0, -1]]
    bends = np.concatenate([w * np.array(b) for w, b in zip(ends, BENDS, strict=True)])
    for shift, order in shifts:
        poles = np.concatenate([impulse_poles(omega, force, shift, order), bends])
        hopeless = np.inf if shift == shifts[-1][0] else HOPELESS * target
        problem, error = _grown(_Problem(omega, force, inside, targets, own, live, poles, shift), target, hopeless)
        if best is None or error < best[1]:
            best = problem, error
        if error <= target:
            break
    problem = best[0]
    coefficients, worst, _ = problem.fit(ROUNDS)
    return problem.poles, coefficients, problem.shift, worst


def _grown(problem: _Problem, target: float, hopeless: float) -> tuple[_Problem, float]:
    """Return the problem with narrow poles where the error is largest, and that error; give up where it stays above `hopeless`."""
    tried = []
    for _ in range(MORE + 1):
        _, error, where = problem.fit(FEW)
        tried.append((error, problem))
        least = min(e for e, _ in tried)
        stuck = len(tried) > PATIENCE and least > 0.9 * min(e for e, _ in tried[:-PATIENCE])
        if error <= target or stuck or (len(tried) > START and least > hopeless):
            break
        problem = problem.with_pole(pole_at(where, NARROW * max(1.0, where / 2) * np.array(DECAYS), problem.poles))
    error, problem = min(tried, key=lambda t: t[0])
    return problem, error


def impulse_poles(omega, force, shift: float, order: int) -> np.ndarray:
    """Return the poles [rad/s], one of each pair, of a state space of some order for a force (n, l) at omega (n) late by the shift [s].

    The impulse response is sampled, what would come before zero left out, and realised by the singular values of its Hankel
    matrix (eigensystem realisation: Kung 1978; Juang and Pappa, J. Guidance 8(5), 1985).
    """
    top, half = omega[-1] / 1.8, np.pi / STEP
    w = np.linspace(0.0, half, 4096)
    values = CubicSpline(omega, force / np.abs(force).max(axis=0))(np.clip(w, omega[0], omega[-1]))
    values.imag[w < omega[0]] *= (w[w < omega[0]] / omega[0])[:, None]
    values *= np.cos(np.clip((w - top) / (half - top), 0, 1) * np.pi / 2)[:, None] ** 2 * w[1]
    count, width = int((MEMORY + shift) / STEP), force.shape[1]
    late = np.exp(1j * np.outer(np.arange(count) * STEP - shift, w)) @ values
    memory = np.concatenate([late.real, np.zeros((count, width))])
    rows = memory[np.add.outer(np.arange(count), np.arange(count))]  # (i, j, l): h[i + j]
    u, size, _ = np.linalg.svd(np.moveaxis(rows, 2, 1).reshape(count * width, count), full_matrices=False)

    order = min(order, int(np.sum(size > 1e-6 * size[0])))
    observed = u[:, :order] * np.sqrt(size[:order])
    values = np.linalg.eigvals(np.linalg.lstsq(observed[:-width], observed[width:], rcond=None)[0]).astype(complex)
    real = np.abs(values.imag) <= 1e-9
    found = np.log(values[real & (values.real > 1e-6) | ~real & (values.imag > 0)]) / STEP  # without what alternates from sample to sample
    found = -np.maximum(-found.real, SLOWEST) + 1j * np.where(np.abs(found.imag) <= 1e-9, 0.0, found.imag)
    return np.concatenate([-np.array(SLOW) + 0j, found])


class _Problem:
    """The problem with given poles and shift [s]: linear in the coefficients. own (n, l) is what an error of each force counts itself."""

    def __init__(self, omega, force, inside, targets: Targets, own, live, poles, shift: float):
        self.given, self.omega = (omega, force, inside, targets, own, live), targets.omega
        self.shift, self.poles, self.inside = shift, poles, np.flatnonzero(inside)
        self.basis, self.back = orthogonal(partial_fractions(1j * omega, poles))
        turn = targets.share[..., None] * np.exp(1j * targets.omega * shift)[:, None, None]
        self.rows = _real(turn * targets.gain[..., live], PHASE)
        self.level = np.concatenate([targets.share != 0, np.zeros(targets.share.shape)], axis=1)
        self.late = _stacked(force * np.exp(-1j * omega * shift)[:, None])
        self.own = np.concatenate([own, own], axis=1)

    def with_pole(self, pole: complex) -> _Problem:
        """Return the problem with one pair of poles more."""
        return _Problem(*self.given, np.append(self.poles, pole), self.shift)

    def fit(self, rounds: int) -> tuple[np.ndarray, float, float]:
        """Return coefficients (b, l) and the largest error of a response after some rounds of reweighting, and its frequency [rad/s]."""
        weight, best = np.ones(len(self.omega)), None
        for _ in range(rounds):
            normal, right = self._normal_equations(weight)
            size = np.sqrt(np.maximum(np.diag(normal), 1e-300))
            normal = normal / np.outer(size, size) + 1e-13 * np.eye(len(size))
            x = cho_solve(cho_factor(normal), right / size) / size
            error = self._errors(x)
            if best is None or error.max() < best[1]:
                best = x, float(error.max()), float(self.omega[error.argmax()])
            weight *= (0.05 * error.max() + error) ** 0.6
            weight /= weight.mean()
        return self.back @ best[0].reshape(-1, self.back.shape[1]).T, *best[1:]

    def _errors(self, x) -> np.ndarray:
        """Return the largest error of the responses (n)."""
        force = self.basis[self.inside] @ x.reshape(-1, self.back.shape[1]).T
        return np.abs(np.einsum("nij,nj->ni", self.rows, _stacked(force)) - self.level).max(axis=1)

    def _normal_equations(self, weight) -> tuple[np.ndarray, np.ndarray]:
        """Return matrix (l f, l f) and right side (l f) of the normal equations, summed frequency by frequency from what the forces' real
        and imaginary parts count."""
        count, each = self.own.shape[1] // 2, self.back.shape[1]
        square, target = np.zeros((len(self.basis), 2 * count, 2 * count)), self.own**2 * self.late
        rows = self.rows * weight[:, None, None]
        square[self.inside] = np.swapaxes(rows, 1, 2) @ rows
        target[self.inside] += np.einsum("nij,ni->nj", rows, self.level * weight[:, None])
        square[:, range(2 * count), range(2 * count)] += self.own**2
        real, imaginary = self.basis.real.copy(), self.basis.imag.copy()
        normal = np.empty((count, each, count, each))
        for j in range(count):
            for k in range(j, count):
                m = square[:, [[j], [count + j]], [k, count + k]]
                block = real.T @ (m[:, 0, 0, None] * real + m[:, 0, 1, None] * imaginary)
                block += imaginary.T @ (m[:, 1, 0, None] * real + m[:, 1, 1, None] * imaginary)
                normal[j, :, k], normal[k, :, j] = block, block.T
        right = real.T @ target[:, :count] + imaginary.T @ target[:, count:]
        return normal.reshape(count * each, -1), right.T.ravel()


def _real(matrix, phase: float = 1.0) -> np.ndarray:
    """Return a complex matrix (n, i, j) as a real one (n, 2 i, 2 j), real parts first; rows of imaginary parts times `phase`."""
    top = np.concatenate([matrix.real, -matrix.imag], axis=2)
    return np.concatenate([top, phase * np.concatenate([matrix.imag, matrix.real], axis=2)], axis=1)


def _stacked(values) -> np.ndarray:
    return np.concatenate([values.real, values.imag], axis=1)
