"""Wave excitation as a causal state space driven by the wave elevation, delayed by a stated time shift.

A wave's force begins before its crest arrives, so F = X eta is not causal; F(t - shift) is, nearly, and is fitted by a stable
rational function with poles that all six forces share. The same device as HydroDyn's state-space excitation (ExctnMod 2).
Reference: Falnes, Applied Ocean Research 17(3), 1995.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.conventions import PLATFORM_DOFS, freeze
from model.reduce.importance import Importance, pooled
from model.reduce.rational import RationalFit, fit, realisation
from model.response.solve import Response
from model.system.hydro import HydroCoefficients, excitation_at

TARGET = 0.006
SHIFTS = (12.0, 16.0, 20.0)
ORDERS = (44, 60, 72, 84)
CAP = 10.0  # that a relative error of a force may count above one, where forces nearly cancel in a response
LOW = 0.03  # rad/s


@dataclass(frozen=True, eq=False, kw_only=True)
class ExcitationFit:
    """Wave force f = C z, z' = A z + b eta: a (r, r), b (r), c (6, r) for a force `shift` [s] late.

    error (6): largest error over the frequencies of the data as a fraction of each force's largest value (zero where there is no
    force); worst: largest error weighted as in the fit.
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
        iw = 1j * np.asarray(omega, dtype=float)
        state = np.linalg.solve(iw[:, None, None] * np.eye(len(self.a)) - self.a, self.b[:, None] + 0j)[..., 0]
        return state @ self.c.T * np.exp(iw * self.shift)[:, None]


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


def fit_wave_force(waves: WaveForce, column: int, matters: Importance, *, band=(LOW, 3.2)) -> ExcitationFit:
    """Return the causal state space of the wave force from one heading (its place among those of `waves`).

    The fit is judged at the frequencies of the data: between them the model interpolates the force linearly, with kinks that
    no impulse response of reasonable length has. band [rad/s] outside which nothing is fitted.
    """
    data = np.array([w for w in waves.hydro.omega if band[0] <= w <= band[1]])
    data = np.unique(np.concatenate([np.geomspace(band[0] * 1.05, data[0], 3)[:-1], data]))
    between = waves.omega[(waves.omega >= band[0]) & (waves.omega <= band[1])]
    omega, first = np.unique(np.concatenate([data, between]), return_index=True)
    nodes = first < len(data)
    force = waves.at(omega, column)
    size = np.abs(force)
    peak = size[nodes].max(axis=0)
    lever = np.where(np.arange(6) < 3, 1.0, 30.0)  # m, to tell forces and moments that are there from rounding
    alive = (peak > 0) & (peak > 1e-4 * lever * (peak / lever).max(initial=0.0))
    sensitive = np.stack([np.interp(omega, data, s) for s in pooled(matters.omega, matters.force, data).T], axis=1)
    with np.errstate(divide="ignore"):
        weight = np.minimum(np.maximum(sensitive, 0.3 / peak), CAP / size + 1 / peak)
    return fit_excitation(omega, force, np.where(alive, weight, 0.0), nodes)


def fit_excitation(
    omega, force, weight, nodes, *, shifts=SHIFTS, orders=ORDERS, target: float = TARGET
) -> ExcitationFit:
    """Return the causal state space of a force per metre of wave amplitude.

    Parameters
    ----------
    omega : (n) [rad/s], ascending
    force : (n, 6) complex [N/m, N m/m]
    weight : (n, 6) what an error counts, 1/force for a relative one; zero columns are left out
    nodes : (n) true at the frequencies of the data; between them, where the force is interpolated, an error counts a tenth
    shifts, orders : [s] and numbers of poles that are tried; the smallest order that reaches the target with any shift, else the
        best fit, is taken
    """
    omega, force = np.asarray(omega, dtype=float), np.asarray(force)
    live = np.flatnonzero(weight.any(axis=0))
    if not len(live):
        return ExcitationFit(
            a=np.zeros((0, 0)), b=np.zeros(0), c=np.zeros((6, 0)), shift=0.0, error=np.zeros(6), worst=0.0
        )
    weight = weight[:, live] * np.where(nodes, 1.0, 0.1)[:, None]
    part = np.where(nodes[:, None], weight, 0.0)
    best: tuple[float, RationalFit, float] | None = None
    for order in orders:
        for shift in shifts:
            late = force[:, live] * np.exp(-1j * omega * shift)[:, None]
            found, error = fit(
                omega, late, np.stack([weight, weight]), _poles(order, omega[-1]), rounds=5, iterations=5, part=part
            )
            if best is None or error < best[0]:
                best = error, found, shift
        if best[0] <= target:
            break
    return _result(omega, force, nodes, live, *best)


def _poles(order: int, top: float) -> np.ndarray:
    """Return poles to start from: two slow real ones, few pairs at low frequency, the rest evenly up to the top [rad/s]."""
    even = np.linspace(0.25, 1.1 * top, order // 2 - 4)
    return np.concatenate([[-0.004 + 0j, -0.02 + 0j], (-0.03 + 1j) * np.concatenate([[0.04, 0.08, 0.15], even])])


def _result(omega, force, nodes, live, worst: float, found: RationalFit, shift: float) -> ExcitationFit:
    a, b = realisation(found.poles)
    c = np.zeros((6, len(a)))
    c[live] = found.coefficients.T
    out = ExcitationFit(a=a, b=b, c=c, shift=float(shift), error=np.zeros(6), worst=worst)
    peak = np.abs(force[nodes]).max(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        error = np.abs(out(omega[nodes]) - force[nodes]).max(axis=0) / peak
    dead = np.ones(6, dtype=bool)
    dead[live] = False
    object.__setattr__(out, "error", np.where(dead, 0.0, np.nan_to_num(error)))
    return out
