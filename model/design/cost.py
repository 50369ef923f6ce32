"""What a floating foundation costs to make: steel, ballast, welding, paint, moorings, anchors (thesis 8.3.1).

Only what follows from dimensions: no towing, no installation, no turbine. Welding is that of plates of a standard size
put together on a weld as wide as the plate is thick; the thesis leaves wall thickness and ballast open, so they are
inputs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

STEEL_DENSITY = 7850.0
# submerged arc welding, double K butt weld (Zhou et al. 2021 as in thesis eq. 8.5): minutes per metre at a width in mm
WELD_RATE, WELD_POWER = 0.1053, 1.94
EXTRA_TIME = 0.3  # T3 over T2: slag, electrodes, turning


@dataclass(frozen=True, kw_only=True)
class Prices:
    """Prices; the defaults are those of thesis Table 24.

    steel, concrete, chain, wire [EUR/kg], labour [EUR/h], drag_anchor, pile [EUR/kg], paint [EUR/m2].
    """

    steel: float = 0.5
    concrete: float = 0.1
    labour: float = 17.05
    chain: float = 2.0
    wire: float = 1.60
    drag_anchor: float = 6.706
    pile: float = 10.250
    paint: float = 12.5


@dataclass(frozen=True, kw_only=True)
class Plating:
    """Surfaces of one thickness: name, area [m2] of one design or (...) of several, thickness [m]."""

    name: str
    area: float | np.ndarray
    thickness: float

    @property
    def mass(self) -> float | np.ndarray:
        """Mass of the steel [kg]."""
        return STEEL_DENSITY * self.area * self.thickness


@dataclass(frozen=True, kw_only=True)
class PlateLayout:
    """Raw plates, length and width [m], and the difficulty of putting them together (C1 times Theta of thesis eq.
    8.4).
    """

    length: float = 10.0
    width: float = 4.0
    difficulty: float = 1.0

    @property
    def seam(self) -> float:
        """Weld per area [m/m2]: each plate's edge is shared with its neighbour."""
        return (self.length + self.width) / (self.length * self.width)


@dataclass(frozen=True, kw_only=True)
class Semisubmersible:
    """A hull of side columns on heave plates round a main column, joined by braces, as OC4 DeepCwind.

    Lengths in metres, numbers or arrays (...) of designs. Main column: diameter and freeboard. Side columns: number, diameter, freeboard; radius of
    their circle. Heave plates (base columns): height, diameter (None: twice the column's). Braces: diameter. Walls: of
    side columns and heave plates, of the main column, of braces.
    """

    column_diameter: float
    radius: float
    draft: float
    main_diameter: float = 8.3
    main_freeboard: float = 10.0
    columns: int = 3
    column_freeboard: float = 12.0
    plate_height: float = 6.0
    plate_diameter: float | None = None
    brace_diameter: float = 1.6
    column_wall: float = 0.033
    main_wall: float = 0.030
    brace_wall: float = 0.0175

    def __post_init__(self):
        for name, value in vars(self).items():
            if value is not None and not np.all(np.asarray(value) > 0):
                raise ValueError(f"{name} is {value}; it must be positive")
        if np.any(self.plate_height >= np.asarray(self.draft)):
            raise ValueError(f"heave plates of {self.plate_height:g} m do not fit a draft of {np.min(self.draft):g} m")
        if np.any(self.heave_plate_diameter < np.asarray(self.column_diameter)):
            raise ValueError("heave plates must not be narrower than their columns")
        tight = np.asarray(self.spacing < self.heave_plate_diameter)
        if tight.any():
            plate, radius = (np.broadcast_to(v, tight.shape)[tight][0] for v in (self.heave_plate_diameter, self.radius))
            raise ValueError(f"heave plates of {plate:g} m overlap at a radius of {radius:g} m")

    @property
    def heave_plate_diameter(self) -> float:
        """Diameter of the heave plates [m]."""
        return 2 * self.column_diameter if self.plate_diameter is None else self.plate_diameter

    @property
    def spacing(self) -> float:
        """Distance between the axes of neighbouring side columns [m]."""
        return 2 * self.radius * float(np.sin(np.pi / self.columns))

    @property
    def brace_length(self) -> float:
        """Length of all braces [m]: level ones high and low round the columns and to the middle, one diagonal each."""
        to_middle = self.radius - (self.column_diameter + self.main_diameter) / 2
        rise = self.draft - self.plate_height + self.main_freeboard / 2
        return self.columns * (
            2 * (self.spacing - self.column_diameter) + 2 * to_middle + np.hypot(to_middle, rise)
        )

    @property
    def fairlead_radius(self) -> float:
        """Radius of fairleads at the outer edge of the heave plates [m]."""
        return self.radius + self.heave_plate_diameter / 2

    @property
    def fairlead_depth(self) -> float:
        """Depth of fairleads on top of the heave plates [m]."""
        return self.draft - self.plate_height


def hull_plating(hull: Semisubmersible) -> tuple[Plating, ...]:
    """Return the surfaces of a hull; tops and bottoms are as thick as the walls."""
    n, d, big, t = hull.columns, hull.column_diameter, hull.heave_plate_diameter, hull.column_wall
    height = hull.draft - hull.plate_height + hull.column_freeboard
    disc, ring = np.pi / 4 * d**2, np.pi / 4 * (big**2 - d**2)
    main_height = hull.draft + hull.main_freeboard
    main = np.pi * hull.main_diameter * main_height + np.pi / 2 * hull.main_diameter**2
    parts = (
        ("Side columns", n * (np.pi * d * height + disc), t),
        ("Heave plates", n * (np.pi * big * hull.plate_height + np.pi / 4 * big**2 + ring), t),
        ("Main column", main, hull.main_wall),
        ("Braces", np.pi * hull.brace_diameter * hull.brace_length, hull.brace_wall),
    )
    return tuple(Plating(name=name, area=area, thickness=wall) for name, area, wall in parts)


def displaced_volume(hull: Semisubmersible) -> float | np.ndarray:
    """Return the displaced volume [m3]; of the braces the share below water, those high up left out."""
    n = hull.columns
    plates = n * np.pi / 4 * hull.heave_plate_diameter**2 * hull.plate_height
    columns = n * np.pi / 4 * hull.column_diameter**2 * (hull.draft - hull.plate_height)
    main = np.pi / 4 * hull.main_diameter**2 * hull.draft
    braces = 0.5 * np.pi / 4 * hull.brace_diameter**2 * hull.brace_length
    return plates + columns + main + braces


def ballast_mass(volume: float, carried: float, density: float = 1025.0) -> float:
    """Return the ballast [kg] that brings a hull of a displaced volume [m3] to its draft.

    carried [kg]: steel, turbine and the moorings' vertical pull. Raises ValueError when it weighs more than the water.
    """
    mass = density * volume - carried
    if mass < 0:
        raise ValueError(
            f"{carried / 1e3:.0f} t do not float on {density * volume / 1e3:.0f} t of displaced water; "
            "deepen the draft or thin the walls"
        )
    return mass


@dataclass(frozen=True, kw_only=True)
class WeldTimes:
    """Minutes: preparation T1, welding T2, additional work T3."""

    preparation: float
    welding: float
    additional: float

    @property
    def hours(self) -> float:
        """All together in hours."""
        return (self.preparation + self.welding + self.additional) / 60


def weld_times(plating: Sequence[Plating], layout: PlateLayout | None = None) -> WeldTimes:
    """Return the times of welding (thesis eq. 8.4 and 8.5).

    T1 = C1 Theta sqrt(k rho V) of each part's k raw plates; T2 = sum C2 a^m L with the weld's width a [mm] that of the
    plate.
    """
    layout = layout or PlateLayout()
    plates = [np.ceil(p.area / (layout.length * layout.width)) for p in plating]
    first = sum(layout.difficulty * np.sqrt(k * p.mass) for k, p in zip(plates, plating, strict=True))
    second = sum(WELD_RATE * (1e3 * p.thickness) ** WELD_POWER * layout.seam * p.area for p in plating)
    return WeldTimes(preparation=first, welding=second, additional=EXTRA_TIME * second)


@dataclass(frozen=True, kw_only=True)
class CostItem:
    """One line of the account: name, quantity with its unit, price per unit, cost [EUR]."""

    name: str
    quantity: float
    unit: str
    price: float

    @property
    def cost(self) -> float:
        """Cost [EUR]."""
        return self.quantity * self.price


def cost_items(
    plating: Sequence[Plating],
    ballast: float,
    mooring_mass: float,
    anchor_mass: float,
    *,
    line: str = "chain",
    anchor: str = "drag",
    prices: Prices | None = None,
    layout: PlateLayout | None = None,
) -> tuple[CostItem, ...]:
    """Return the account of a foundation (thesis eq. 8.6).

    Parameters
    ----------
    plating : surfaces of the hull
    ballast, mooring_mass, anchor_mass : all of it [kg]
    line : "chain" or "wire"; anchor : "drag" or "suction pile"
    prices, layout : defaults of the thesis

    Raises
    ------
    ValueError : an unknown line or anchor.
    """
    prices = prices or Prices()
    lines = {"chain": prices.chain, "wire": prices.wire}
    anchors = {"drag": prices.drag_anchor, "suction pile": prices.pile}
    for value, known, what in ((line, lines, "line"), (anchor, anchors, "anchor")):
        if value not in known:
            raise ValueError(f"unknown {what} {value!r}; use one of {', '.join(known)}")
    area = sum(p.area for p in plating)
    return (
        CostItem(name="Steel of the hull", quantity=sum(p.mass for p in plating), unit="kg", price=prices.steel),
        CostItem(name="Concrete ballast", quantity=ballast, unit="kg", price=prices.concrete),
        CostItem(name="Welding", quantity=weld_times(plating, layout).hours, unit="h", price=prices.labour),
        CostItem(name="Paint", quantity=area, unit="m2", price=prices.paint),
        CostItem(name=f"Mooring lines ({line})", quantity=mooring_mass, unit="kg", price=lines[line]),
        CostItem(name=f"Anchors ({anchor})", quantity=anchor_mass, unit="kg", price=anchors[anchor]),
    )


def total_cost(items: Sequence[CostItem]) -> float | np.ndarray:
    """Return the sum of an account [EUR], (...) for several designs."""
    return sum(item.cost for item in items)
