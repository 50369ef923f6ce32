"""Turbine matrices by wind speed (JSON): what a linearisation gives, reduced to one set of matrices an operating point.

Keys: `title`, `degrees_of_freedom` (the six platform motions, then tower modes), `operating_points`, each with `wind_speed`
[m/s], `rotor_rpm`, `pitch_deg`, `mass`, `damping`, `stiffness` (q x q), `force` (platform motions, or all q), `tower_top` (the place of
the tower modes at which the force holds), `wind_force` (q) per m/s. SI, about the origin at still water; other keys are for people.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.registry import Format
from fowtio.read.text import read_lines
from model.conventions import PLATFORM_DOFS
from model.system.turbine_table import TurbineTable

_KEYS = ("wind_speed", "rotor_rpm", "pitch_deg", "mass", "damping", "stiffness", "force", "tower_top", "wind_force")


def read_turbine_table(path: str | Path) -> TurbineTable:
    """Return a table of turbine matrices; raise FormatError when a key, a number or a shape is wrong."""
    path = Path(path)
    try:
        data = json.loads("\n".join(read_lines(path)))
    except json.JSONDecodeError as error:
        raise FormatError(path, error.lineno, expected="JSON", found=error.msg) from None
    if not isinstance(data, dict) or not data.get("degrees_of_freedom") or not data.get("operating_points"):
        raise FormatError(path, expected="degrees_of_freedom and operating_points", found="none of one of them")
    dofs, points = tuple(data["degrees_of_freedom"]), data["operating_points"]
    rows = [_row(path, dofs, k, point) for k, point in enumerate(points, start=1)]
    try:
        stacked = {name: np.array([r[name] for r in rows]) for name in rows[0]}
        return TurbineTable(dofs=dofs, **stacked, source=f"{data.get('title') or path.stem} ({path.name})")
    except ValueError as error:
        raise FormatError(path, expected="operating points of one shape, wind speeds ascending", found=str(error)) from None


def _row(path: Path, dofs: tuple[str, ...], number: int, point: dict) -> dict[str, np.ndarray]:
    """Return one operating point's arrays in the table's names."""
    q, modes = len(dofs), len(dofs) - len(PLATFORM_DOFS)
    missing = [key for key in _KEYS if key not in point]
    if missing:
        raise FormatError(path, expected=f"{', '.join(missing)} in operating point {number}", found="none")
    try:
        value = {key: np.array(point[key], dtype=float) for key in _KEYS}
    except (TypeError, ValueError) as error:
        raise FormatError(path, expected=f"numbers in operating point {number}", found=str(error)) from None
    force, bent = value["force"], np.atleast_1d(value["tower_top"])
    if force.shape == (len(PLATFORM_DOFS),):
        force = np.append(force, np.zeros(modes))
    shapes = {"mass": (q, q), "damping": (q, q), "stiffness": (q, q), "wind_force": (q,)}
    wrong = [key for key, shape in shapes.items() if value[key].shape != shape]
    wrong += ["force"] * (force.shape != (q,)) + ["tower_top"] * (bent.shape != (modes,))
    wrong += [key for key in _KEYS if not np.all(np.isfinite(value[key]))]
    if wrong:
        raise FormatError(
            path, expected=f"{q} degrees of freedom and finite numbers in operating point {number}", found=f"otherwise in {', '.join(dict.fromkeys(wrong))}"
        )
    return {name: value[name] for name in (*shapes, "wind_speed")} | {
        "rotor_speed": value["rotor_rpm"] * np.pi / 30, "blade_pitch": np.radians(value["pitch_deg"]), "force": force,
        "point": np.append(np.zeros(len(PLATFORM_DOFS)), bent),
    }  # fmt: skip


def _recognises(path, head: bytes) -> bool:
    return head.lstrip().startswith(b"{") and b'"degrees_of_freedom"' in head and b'"operating_points"' in head


def _describe(table: TurbineTable) -> list[tuple[str, str]]:
    return [
        ("source", table.source),
        ("degrees of freedom", ", ".join(table.dofs)),
        ("operating points", f"{len(table.wind_speed)}, {table.span}"),
        ("rotor speed", f"up to {table.rotor_speed.max() * 30 / np.pi:.4g} rpm"),
    ]


TURBINE_TABLE = Format(
    name="Turbine matrices by wind speed (JSON)", recognises=_recognises, read=read_turbine_table, describe=_describe
)
