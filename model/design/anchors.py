"""Anchors from the load of a mooring line: drag-embedded by mass, suction piles by length, diameter and wall.

Both are curves of the ultimate holding capacity fitted to soil, for preliminary design; a pile takes uplift, a drag
anchor does not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from model.system.catenary import LineState, catenary

STEEL_DENSITY = 7850.0
SAFETY = 1.5  # on the largest tension at the anchor (thesis 8.1.1)
UPLIFT_TOLERANCE = 0.01  # of the horizontal load: rounding of a line that just rests on the seabed
# UHC [kN] = a (W [t])^b: Vryhof manual, Stevpris Mk5 as in the thesis; Mk6 as in MoorPy 1.2 (MoorProps)
DRAG_SOILS = {
    "mk5_very_soft_clay": (392.28, 0.92),
    "mk6_soft_clay": (509.96, 0.93),
    "mk6_medium_clay": (701.49, 0.93),
    "mk6_sand": (904.21, 0.92),
}
# L [m], D [m], t [mm] = c (UHC [kN])^d: ABS report on floating wind turbines, as in thesis Table 23 and MoorPy 1.2
PILE_SOILS = {
    "medium_clay": ((0.5166, 0.3995), (0.1260, 0.3561), (0.8398, 0.3561)),
    "soft_clay": ((1.1161, 0.3442), (0.3095, 0.2798), (2.0580, 0.2803)),
}


@dataclass(frozen=True, kw_only=True)
class Anchor:
    """One anchor: kind, soil, ultimate holding capacity [N], mass [kg]; of a pile also length, diameter and wall
    [m].
    """

    kind: str
    soil: str
    capacity: float
    mass: float
    length: float | None = None
    diameter: float | None = None
    wall: float | None = None


def drag_anchor(
    horizontal: float, vertical: float = 0.0, soil: str = "mk5_very_soft_clay", safety: float = SAFETY
) -> Anchor:
    """Return the drag-embedded anchor that holds a line (thesis eq. 8.1, inverted).

    Parameters
    ----------
    horizontal, vertical : largest load at the anchor [N], vertical upwards
    soil : of DRAG_SOILS
    safety : factor on the load

    Raises
    ------
    ValueError : uplift, which this kind of anchor cannot hold; an unknown soil; a load that is not positive.
    """
    load = _load(horizontal, vertical, safety)
    if vertical > UPLIFT_TOLERANCE * horizontal:
        raise ValueError(
            f"the line pulls a drag anchor up with {vertical / 1e3:.1f} kN (horizontal {horizontal / 1e3:.1f} kN): "
            "it holds no uplift; lengthen the line until some of it rests on the seabed, or take a suction pile"
        )
    return Anchor(kind="drag", soil=soil, capacity=load, mass=float(drag_anchor_mass(load, soil)))


def drag_anchor_mass(capacity, soil: str = "mk5_very_soft_clay") -> np.ndarray:
    """Return the mass (...) [kg] of drag anchors of an ultimate holding capacity (...) [N] (thesis eq. 8.1, inverted)."""
    a, b = _soil(soil, DRAG_SOILS, "drag anchors")
    return 1e3 * (np.asarray(capacity) / 1e3 / a) ** (1 / b)


def drag_capacity(mass: float, soil: str = "mk5_very_soft_clay") -> float:
    """Return the ultimate holding capacity [N] of a drag anchor of a mass [kg] (thesis eq. 8.1)."""
    a, b = _soil(soil, DRAG_SOILS, "drag anchors")
    return 1e3 * a * (mass / 1e3) ** b


def suction_pile(
    horizontal: float, vertical: float = 0.0, soil: str = "medium_clay", safety: float = SAFETY, *, lid: bool = False
) -> Anchor:
    """Return the suction pile that holds a line (thesis eq. 8.2).

    Parameters
    ----------
    horizontal, vertical : largest load at the anchor [N]
    soil : of PILE_SOILS
    safety : factor on the resultant
    lid : whether a lid as thick as the wall counts in the mass; the thesis counts the shell

    Raises
    ------
    ValueError : an unknown soil; a load that is not positive.
    """
    load = _load(horizontal, vertical, safety)
    length, diameter, wall, mass = (float(x) for x in suction_pile_size(load, soil))
    mass += STEEL_DENSITY * np.pi / 4 * diameter**2 * wall if lid else 0.0
    return Anchor(
        kind="suction pile",
        soil=soil,
        capacity=load,
        mass=mass,
        length=length,
        diameter=diameter,
        wall=wall,
    )


def suction_pile_size(capacity, soil: str = "medium_clay") -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return length, diameter, wall (...) [m] and mass of the shell (...) [kg] of suction piles of a capacity (...) [N]."""
    curves = _soil(soil, PILE_SOILS, "suction piles")
    length, diameter, wall = (c * (np.asarray(capacity) / 1e3) ** d for c, d in curves)
    wall = wall * 1e-3
    return length, diameter, wall, STEEL_DENSITY * np.pi * (diameter - wall) * wall * length


def pile_capacity(length: float, soil: str = "medium_clay") -> float:
    """Return the ultimate holding capacity [N] of a suction pile of a length [m]."""
    (c, d), *_ = _soil(soil, PILE_SOILS, "suction piles")
    return 1e3 * (length / c) ** (1 / d)


@dataclass(frozen=True, eq=False, kw_only=True)
class SpreadLine:
    """One line of a symmetric spread: number of lines, anchor and fairlead radius [m], depth of the seabed below the
    fairlead [m], unstretched length [m], submerged weight [N/m], axial stiffness [N].
    """

    count: int
    anchor_radius: float
    fairlead_radius: float
    fairlead_height: float
    length: float
    weight: float
    stiffness: float


@dataclass(frozen=True, eq=False, kw_only=True)
class SpreadState:
    """A symmetric spread under a steady push against one of its lines: offset [m], and that line's state."""

    offset: float
    upwind: LineState

    @property
    def horizontal(self) -> float:
        """Horizontal load at the upwind anchor [N]."""
        return float(self.upwind.anchor_horizontal)

    @property
    def uplift(self) -> float:
        """Vertical load at the upwind anchor [N]."""
        return float(self.upwind.anchor_vertical)


def spread_under_thrust(line: SpreadLine, thrust: float) -> SpreadState:
    """Return the offset at which a symmetric spread balances a thrust [N], one line straight upwind.

    Level surge only, quasi-static lines without friction. Raises ValueError when the lines cannot hold the thrust.
    """
    angle = np.pi + 2 * np.pi * np.arange(line.count) / line.count
    direction = np.stack([np.cos(angle), np.sin(angle)], axis=-1)

    def balance(offset: float):
        span = line.anchor_radius * direction - line.fairlead_radius * direction - [offset, 0.0]
        reach = np.hypot(*span.T)
        state = catenary(reach, line.fairlead_height, line.length, line.weight, line.stiffness)
        return float((state.horizontal * span[:, 0] / reach).sum()) + thrust, state

    straight = np.sqrt((1.01 * line.length) ** 2 - line.fairlead_height**2)
    furthest = straight - (line.anchor_radius - line.fairlead_radius)
    if not furthest > 0 or balance(furthest)[0] > 0:
        raise ValueError(
            f"lines of {line.length:g} m cannot hold {thrust / 1e3:.0f} kN within 1 % of stretch; "
            "lengthen or strengthen them, or move the anchors in"
        )
    offset = brentq(lambda x: balance(x)[0], -0.2 * line.anchor_radius, furthest, xtol=1e-6)
    state = balance(offset)[1]
    upwind = LineState(**{k: None if v is None else v[0] for k, v in vars(state).items()})
    return SpreadState(offset=float(offset), upwind=upwind)


def _soil(soil: str, table: dict, what: str):
    if soil not in table:
        raise ValueError(f"no curve for {what} in {soil!r}; there are {', '.join(table)}")
    return table[soil]


def _load(horizontal: float, vertical: float, safety: float) -> float:
    load = safety * float(np.hypot(horizontal, vertical))
    if not (load > 0 and np.isfinite(load)):
        raise ValueError(f"the anchor's load is {load:g} N; give the largest tension of the line there")
    return load
