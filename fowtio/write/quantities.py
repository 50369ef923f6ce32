"""Names and units that people read, and what several writers derive from results in the same way.

model, loads and their parts are those of `fowtio.workflow`: a Model, and a sequence of StateLoads.
"""

from __future__ import annotations

import re

import numpy as np

from model.conventions import PLATFORM_DOFS
from model.response.loads import spectra_by_cause

DOF_LABELS = {
    "surge": "Surge", "sway": "Sway", "heave": "Heave", "roll": "Roll", "pitch": "Pitch", "yaw": "Yaw",
    "tower_fa1": "Tower fore-aft 1", "tower_fa2": "Tower fore-aft 2", "tower_ss1": "Tower side-side 1",
    "tower_ss2": "Tower side-side 2",
}  # fmt: skip
CHANNEL_LABELS = {
    "PtfmSurge": "Surge", "PtfmSway": "Sway", "PtfmHeave": "Heave", "PtfmRoll": "Roll", "PtfmPitch": "Pitch",
    "PtfmYaw": "Yaw",
    "TTDspFA": "Tower-top fore-aft", "TTDspSS": "Tower-top side-side", "NcIMUTAxs": "Nacelle acceleration fore-aft",
    "NcIMUTAys": "Nacelle acceleration side-side", "TwrBsFxt": "Tower-base shear fore-aft",
    "TwrBsFyt": "Tower-base shear side-side",
    "TwrBsMyt": "Tower-base moment fore-aft", "TwrBsMxt": "Tower-base moment side-side",
}  # fmt: skip
CHANNEL_DOFS = {
    "PtfmSurge": "surge", "PtfmSway": "sway", "PtfmHeave": "heave", "PtfmRoll": "roll", "PtfmPitch": "pitch",
    "PtfmYaw": "yaw",
    "TTDspFA": "tower_fa1", "TTDspSS": "tower_ss1",
}  # fmt: skip
PANEL_LABELS = {
    "TTDspFA": "Tower top x", "TTDspSS": "Tower top y", "NcIMUTAxs": "Nacelle acc. x", "NcIMUTAys": "Nacelle acc. y",
    "TwrBsFxt": "Base shear x", "TwrBsFyt": "Base shear y", "TwrBsMyt": "Base moment y", "TwrBsMxt": "Base moment x",
}  # fmt: skip
MOTIONS = tuple(CHANNEL_DOFS)
TOWER_BASE = ("TwrBsFxt", "TwrBsFyt", "TwrBsMyt", "TwrBsMxt")
PEOPLE = {"rad": ("deg", 180 / np.pi), "N": ("kN", 1e-3), "N m": ("MN m", 1e-6), "m/s^2": ("m/s²", 1.0)}
NEGLIGIBLE = 0.02  # of the largest of its kind: not drawn
SEAS = {
    "jonswap": "JONSWAP", "pierson_moskowitz": "Pierson–Moskowitz", "white_noise": "white noise",
    "torsethaugen": "Torsethaugen",
    "ochi_hubble": "Ochi–Hubble", "table": "given spectrum", "still": "still water",
}  # fmt: skip


WINDS = {"kaimal": "Kaimal", "von_karman": "von Kármán", "api": "API"}


def people(unit: str) -> tuple[str, float]:
    """Return the unit that people read for an SI unit, and the factor to it."""
    return PEOPLE.get(unit, (unit, 1.0))


def dof_label(dof: str) -> str:
    """Return the name of a degree of freedom or mode for people."""
    return DOF_LABELS.get(dof, dof)


def dof_unit(dof: str) -> str:
    """Return the SI unit of a degree of freedom."""
    return "rad" if dof in PLATFORM_DOFS[3:] else "m"


def channel_label(name: str) -> str:
    """Return the name of a channel for people."""
    line = re.fullmatch(r"T\[(\d+)\]", name)
    return f"Fairlead tension {line[1]}" if line else CHANNEL_LABELS.get(name, name)


def panel_label(name: str) -> str:
    """Return a short name of a channel, for the head of a small panel."""
    return PANEL_LABELS.get(name) or channel_label(name)


def squared(unit: str) -> str:
    """Return the square of a unit."""
    return f"({unit})²" if " " in unit or "/" in unit else f"{unit}²"


def tension_channels(names) -> list[int]:
    """Return the places of the fairlead tensions among channel names."""
    return [k for k, name in enumerate(names) if re.fullmatch(r"T\[\d+\]", name)]


def point_label(speed: float) -> str:
    """Return the name of an operating point."""
    return f"{speed:g} m/s" if speed else "parked, no wind"


def turbulence_label(state) -> str:
    """Return the turbulence of a state: a class, an intensity, or steady."""
    if not state.wind_speed:
        return "–"
    if state.turbulence is None:
        return "steady"
    return f"class {state.turbulence.replace('ETM-', 'extreme, ')}" if isinstance(state.turbulence, str) else f"{100 * state.turbulence:g} %"


def state_label(state) -> str:
    """Return a state's sea and wind in one line."""
    sea = state.sea
    parts = [SEAS.get(sea.kind, sea.kind)]
    if sea.significant_height is not None:
        parts.append(f"Hs {sea.significant_height:.4g} m")
    if sea.peak_period is not None:
        parts.append(f"Tp {sea.peak_period:.4g} s")
    if sea.band is not None:
        parts.append(f"{sea.band[0]:g} to {sea.band[1]:g} Hz")
    if sea.kind != "still":
        parts.append(f"heading {np.degrees(sea.heading):g}°")
    wind = f"wind {state.wind_speed:g} m/s, {turbulence_label(state)}" if state.wind_speed else "no wind, parked"
    return ", ".join(parts) + "; " + wind


def slug(text: str) -> str:
    """Return a text as part of a file name."""
    return re.sub(r"[^A-Za-z0-9]+", "_", text.replace(".", "p").replace("°", "deg")).strip("_").lower() or "unnamed"


def spectra_group(item) -> str:
    """Return the group of figures of a state's spectra."""
    return f"spectra of {item.state.name}"


def split_spectra(item) -> tuple[np.ndarray, np.ndarray]:
    """Return the parts of a state's response spectra (n, c) [unit2/(rad/s)] that waves and wind cause."""
    return spectra_by_cause(item.channels, item.response)


def has_wind(item) -> bool:
    """Tell whether turbulence drives a state."""
    return bool(np.any(item.response.excitation.wind_spectrum))


def main_headings(item) -> list[int]:
    """Return the places of a state's headings that have the most wave energy (one, unless several are equal)."""
    energy = item.response.excitation.wave_spectrum.max(axis=1)
    return [int(k) for k in np.flatnonzero(energy >= 0.999 * energy.max())] if np.any(energy) else [0]


def at_rest(value, unit: str) -> bool:
    """Tell whether a standard deviation (in people's unit) is nothing but rounding."""
    return abs(value) < {"m": 5e-4, "deg": 5e-4, "kN": 5e-2, "MN m": 5e-4, "m/s²": 5e-5}.get(unit, 0.0)


def worth_drawing(names, units, size) -> list[int]:
    """Return the places of the channels whose size (c) is not negligible beside others of their kind.

    Kinds are units, the tower's deflections apart from the platform's motions.
    """
    kinds = [(u, n.startswith("TTDsp")) for n, u in zip(names, units, strict=True)]
    largest = {kind: max(s for s, k in zip(size, kinds, strict=True) if k == kind) for kind in set(kinds)}
    return [k for k, kind in enumerate(kinds) if size[k] > max(NEGLIGIBLE * largest[kind], 1e-12)]
