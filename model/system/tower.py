"""The tower as ElastoDyn describes it: distributed mass and stiffness, polynomial modes, modal matrices.

Discretised as ElastoDyn does (equal elements, values at their midpoints), so that the matrices agree with its linearisation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.conventions import freeze

TOWER_MODES = ("tower_fa1", "tower_fa2", "tower_ss1", "tower_ss2")


@dataclass(frozen=True, eq=False, kw_only=True)
class Tower:
    """A tower: base_height, top_height [m above still water]; at stations (s) fractions of height: mass_density [kg/m],
    stiffness_fa, stiffness_ss [N m2]; modes (4, 5) coefficients of x^2 ... x^6 in the order of TOWER_MODES;
    damping_ratio (4) [-] of the tower without its top mass; nodes, the number of elements; the mode stiffness tuners (4).
    """

    base_height: float
    top_height: float
    station: np.ndarray
    mass_density: np.ndarray
    stiffness_fa: np.ndarray
    stiffness_ss: np.ndarray
    modes: np.ndarray
    damping_ratio: np.ndarray
    stiffness_tuner: np.ndarray = (1.0, 1.0, 1.0, 1.0)
    nodes: int = 20

    def __post_init__(self):
        freeze(
            self, station=("s",), mass_density=("s",), stiffness_fa=("s",), stiffness_ss=("s",), modes=(4, 5),
            damping_ratio=(4,), stiffness_tuner=(4,),
        )  # fmt: skip
        if self.top_height <= self.base_height:
            raise ValueError(f"tower top at {self.top_height} m is not above its base at {self.base_height} m")
        if self.nodes < 1 or np.any(np.diff(self.station) <= 0):
            raise ValueError("the tower needs at least one node and stations that ascend")

    @property
    def length(self) -> float:
        """Flexible length [m]."""
        return self.top_height - self.base_height


@dataclass(frozen=True, eq=False, kw_only=True)
class TowerModes:
    """Modes on the tower's nodes: height (n) [m above still water], element mass (n) [kg]; shape and slope (n, k) [-], [1/m];
    top_slope (k); elastic stiffness, damping (k, k); shortening (n, k, k) and top_shortening (k, k) [1/m], the integral of the
    product of slopes up to the node, by which the axis shortens.
    """

    names: tuple[str, ...]
    height: np.ndarray
    mass: np.ndarray
    shape: np.ndarray
    slope: np.ndarray
    top_slope: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    shortening: np.ndarray
    top_shortening: np.ndarray


def polynomial(coefficients, x, derivative: int = 0) -> np.ndarray:
    """Return mode shapes sum c_k x^k, k = 2..6, or their derivative; coefficients (k, 5), x (n) to (n, k)."""
    powers = np.arange(2, 7)
    factor = np.ones(5)
    for d in range(derivative):
        factor = factor * (powers - d)
    exponents = np.maximum(powers - derivative, 0)
    return (np.asarray(x)[:, None] ** exponents) @ (np.asarray(coefficients) * factor).T


def tower_modes(tower: Tower, names: tuple[str, ...]) -> TowerModes:
    """Return the modal quantities of the named tower modes.

    Modal stiffness is the integral of EI times the product of curvatures; damping follows ElastoDyn, 2 zeta / omega
    times the stiffness, omega that of the tower without top mass and gravity.
    """
    unknown = [n for n in names if n not in TOWER_MODES]
    if unknown:
        raise ValueError(f"unknown tower mode {unknown[0]!r}, known are {', '.join(TOWER_MODES)}")
    index = [TOWER_MODES.index(n) for n in names]
    coefficients = tower.modes[index]
    length, step = tower.length, tower.length / tower.nodes
    x = (np.arange(tower.nodes) + 0.5) / tower.nodes
    mass = np.interp(x, tower.station, tower.mass_density) * step
    shape, slope = polynomial(coefficients, x), polynomial(coefficients, x, 1) / length
    curvature = polynomial(coefficients, x, 2) / length**2
    fore_aft = np.array([TOWER_MODES[i].startswith("tower_fa") for i in index], dtype=bool)
    same = fore_aft[:, None] == fore_aft[None, :]
    rigidity = np.where(
        fore_aft, *(np.interp(x, tower.station, s)[:, None] for s in (tower.stiffness_fa, tower.stiffness_ss))
    )
    tuner = np.sqrt(tower.stiffness_tuner[index])
    stiffness = np.einsum("ni,ni,nj->ij", rigidity, curvature, curvature) * step * same * np.outer(tuner, tuner)
    alone = np.sqrt(np.diag(stiffness) / (mass @ shape**2)) if len(index) else np.zeros(0)
    slopes = np.einsum("ni,nj->nij", slope, slope) * step * same
    total = np.cumsum(slopes, axis=0)
    return TowerModes(
        names=names, height=tower.base_height + x * length, mass=mass, shape=shape, slope=slope,
        top_slope=polynomial(coefficients, np.ones(1), 1)[0] / length, stiffness=stiffness,
        damping=stiffness * (2 * tower.damping_ratio[index] / alone)[None, :] if len(index) else stiffness,
        shortening=total - slopes / 2, top_shortening=total[-1],
    )  # fmt: skip


def top_place(tower: Tower, names: tuple[str, ...], deflection) -> np.ndarray:
    """Return the place (3) [m] of the tower top bent by `deflection` (k) [m] of the named modes, lowered by the shortening."""
    shapes, bent = tower_modes(tower, names), np.asarray(deflection, dtype=float)
    fore_aft = np.array([n.startswith("tower_fa") for n in names], dtype=bool)
    lowered = bent @ shapes.top_shortening @ bent / 2 if names else 0.0
    return np.array([bent[fore_aft].sum(), bent[~fore_aft].sum(), tower.top_height - lowered])
