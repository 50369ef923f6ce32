"""Endurance: S-N curves of welds, T-N and S-N curves of moorings, thickness and misalignment."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False, kw_only=True)
class EnduranceCurve:
    """Cycles to failure N = 10^intercept (range / unit)^-slope, with a second slope beyond a number of cycles.

    Parameters
    ----------
    name : of the curve
    slope, intercept : m and log10 a of the steep part
    unit : in which the intercept takes the range: 1e6 Pa for S-N curves, the breaking strength [N] for T-N curves
    second_slope, second_intercept : beyond `knee` cycles; None for one slope
    thickness_exponent, reference_thickness : k and t_ref [m] of the thickness effect

    Raises
    ------
    ValueError : a slope or unit that is not positive, or only one of the second slope and intercept.
    """

    name: str
    slope: float
    intercept: float
    unit: float = 1e6
    second_slope: float | None = None
    second_intercept: float | None = None
    thickness_exponent: float = 0.0
    reference_thickness: float = 0.025

    def __post_init__(self):
        if not (self.slope > 0 and self.unit > 0 and (self.second_slope is None or self.second_slope > 0)):
            raise ValueError(f"curve {self.name}: slopes and unit must be positive")
        if (self.second_slope is None) != (self.second_intercept is None):
            raise ValueError(f"curve {self.name}: the second slope needs its intercept, and the other way round")

    @property
    def knee(self) -> float:
        """Range at which the two lines meet, in the curve's own units times `unit`; 0 for one slope."""
        if self.second_slope is None or self.second_slope == self.slope:
            return 0.0
        return self.unit * 10 ** ((self.second_intercept - self.intercept) / (self.second_slope - self.slope))


# DNV-RP-C203 (2016 and 2019 editions), tables 2-1 (air), 2-2 (sea water with cathodic protection), 2-4 (free
# corrosion):
# m1, log a1, log a2 with m2 = 5; thickness exponent by class. Stress ranges in MPa.
_CLASSES = {
    "B1": (4.0, 15.117, 14.917, 12.436, 17.146, 0.0),
    "B2": (4.0, 14.885, 14.685, 12.262, 16.856, 0.0),
    "C": (3.0, 12.592, 12.192, 12.115, 16.320, 0.05),
    "C1": (3.0, 12.449, 12.049, 11.972, 16.081, 0.10),
    "C2": (3.0, 12.301, 11.901, 11.824, 15.835, 0.15),
    "D": (3.0, 12.164, 11.764, 11.687, 15.606, 0.20),
    "E": (3.0, 12.010, 11.610, 11.533, 15.350, 0.20),
    "F": (3.0, 11.855, 11.455, 11.378, 15.091, 0.25),
    "F1": (3.0, 11.699, 11.299, 11.222, 14.832, 0.25),
    "F3": (3.0, 11.546, 11.146, 11.068, 14.576, 0.25),
    "G": (3.0, 11.398, 10.998, 10.921, 14.330, 0.25),
    "W1": (3.0, 11.261, 10.861, 10.784, 14.101, 0.25),
    "W2": (3.0, 11.107, 10.707, 10.630, 13.845, 0.25),
    "W3": (3.0, 10.970, 10.570, 10.493, 13.617, 0.25),
}
ENVIRONMENTS = ("air", "seawater", "free_corrosion")
# T-N curves of API RP 2SK (2005), table 7: N (range of tension / breaking strength)^M = K; wire with the mean load L
# over
# the breaking strength. Stress-based curves of DNV-OS-E301 (2010), table F1: N = a s^-m with s in MPa.
_TENSION = {
    "studlink_chain": (3.0, 1000.0, 0.0),
    "studless_chain": (3.0, 316.0, 0.0),
    "kenter_shackle": (3.0, 178.0, 0.0),
    "six_strand_wire": (4.09, 10**3.20, -2.79),
    "spiral_strand_wire": (5.05, 10**3.25, -3.43),
}
_MOORING_STRESS = {
    "studlink_chain": (3.0, 1.2e11),
    "studless_chain": (3.0, 6.0e10),
    "six_strand_wire": (4.0, 3.4e14),
    "spiral_strand_wire": (4.8, 1.7e17),
}


def sn_curve(detail: str, environment: str = "air", two_slopes: bool = True) -> EnduranceCurve:
    """Return a curve of DNV-RP-C203 (2016): detail B1 ... W3; environment of ENVIRONMENTS; stress ranges in Pa.

    two_slopes False keeps the first slope throughout; free corrosion has one. Raises ValueError for an unknown name.
    """
    if detail not in _CLASSES:
        raise ValueError(f"unknown S-N curve {detail!r}; DNV-RP-C203 has {', '.join(_CLASSES)}")
    if environment not in ENVIRONMENTS:
        raise ValueError(f"unknown environment {environment!r}; use one of {', '.join(ENVIRONMENTS)}")
    slope, air, sea, free, second, exponent = _CLASSES[detail]
    name = f"DNV-RP-C203 {detail}, {environment.replace('_', ' ')}"
    if environment == "free_corrosion":
        return EnduranceCurve(name=name, slope=3.0, intercept=free, thickness_exponent=exponent)
    pair = (5.0, second) if two_slopes else (None, None)
    return EnduranceCurve(
        name=name,
        slope=slope,
        intercept=air if environment == "air" else sea,
        second_slope=pair[0],
        second_intercept=pair[1],
        thickness_exponent=exponent,
    )


def tn_curve(component: str, breaking_strength: float, mean_load: float = 0.3) -> EnduranceCurve:
    """Return a T-N curve of API RP 2SK: component, breaking strength [N], mean load over it [-] (wire only).

    Raises ValueError for an unknown component.
    """
    if component not in _TENSION:
        raise ValueError(f"unknown mooring component {component!r}; use one of {', '.join(_TENSION)}")
    slope, k, fall = _TENSION[component]
    return EnduranceCurve(
        name=f"API RP 2SK {component.replace('_', ' ')}",
        slope=slope,
        intercept=float(np.log10(k) + fall * mean_load),
        unit=breaking_strength,
    )


def mooring_stress_curve(component: str) -> EnduranceCurve:
    """Return a curve of DNV-OS-E301 on the nominal stress range [Pa]: tension over pi d^2/2 of chain, pi d^2/4 of wire.

    Raises ValueError for an unknown component.
    """
    if component not in _MOORING_STRESS:
        raise ValueError(f"unknown mooring component {component!r}; use one of {', '.join(_MOORING_STRESS)}")
    slope, a = _MOORING_STRESS[component]
    return EnduranceCurve(name=f"DNV-OS-E301 {component.replace('_', ' ')}", slope=slope, intercept=float(np.log10(a)))


def mooring_area(component: str, diameter: float) -> float:
    """Return the nominal steel area [m2] of a chain or wire of nominal diameter [m] (DNV-OS-E301)."""
    return np.pi * diameter**2 / (2 if "chain" in component else 4)


def cycles_to_failure(curve: EnduranceCurve, stress_range, thickness: float | None = None) -> np.ndarray:
    """Return the cycles (...) to failure at ranges (...) in the curve's unit of load; thickness [m] adds its effect."""
    s = np.asarray(stress_range, dtype=float) * thickness_factor(curve, thickness)
    with np.errstate(divide="ignore"):
        first = 10**curve.intercept * (s / curve.unit) ** -curve.slope
        if not curve.knee:
            return first
        return np.where(s < curve.knee, 10**curve.second_intercept * (s / curve.unit) ** -curve.second_slope, first)


def thickness_factor(curve: EnduranceCurve, thickness: float | None) -> float:
    """Return the factor on stress of a wall thicker than the reference thickness (thesis eq. 8.7): (t / t_ref)^k, or
    1.
    """
    return 1.0 if thickness is None else max(thickness / curve.reference_thickness, 1.0) ** curve.thickness_exponent


def weld_concentration(
    thickness: float, diameter: float, weld_width: float, misalignment: float | None = None
) -> float:
    """Return the stress concentration of a girth weld between plates out of line (thesis eq. 8.8; DNV-RP-C203).

    thickness, outer diameter, width of the weld [m]; misalignment [m] is 0.15 of the thickness when not given.
    """
    offset = 0.15 * thickness if misalignment is None else misalignment
    return float(1 + 3 * offset / thickness * np.exp(-0.91 * weld_width / np.sqrt((diameter - thickness) * thickness)))
