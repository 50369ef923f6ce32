"""Rotor performance tables of ROSCO: power, thrust and torque coefficient over blade pitch and tip speed ratio.

Comment lines name what follows, so vectors and tables may stand in any order. Source of the layout: ROSCO toolbox
(N. J. Abbas et al., Wind Energ. Sci. 7:53, 2022), rotor performance file.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.registry import Format, span
from fowtio.read.text import number_table, numbers, read_lines
from model.conventions import freeze

_TITLES = {
    "pitch": "pitch angle vector",
    "tip_speed_ratio": "tsr vector",
    "wind_speed": "wind speed vector",
    "power": "power coefficient",
    "thrust": "thrust coefficient",
    "torque": "torque coefficient",
}
_IDENTITY = (
    0.01,
    2e-3,
)  # Cp and TSR Cq may differ by this part and this amount: files in use differ by 0.1 % and rounding


@dataclass(frozen=True, eq=False, kw_only=True)
class RotorTable:
    """Rotor coefficients: pitch (p) [rad], tip_speed_ratio (t) [-], wind_speed (w) [m/s]; power, thrust and torque
    coefficient (w, t, p) [-]; source names the file.
    """

    pitch: np.ndarray
    tip_speed_ratio: np.ndarray
    wind_speed: np.ndarray
    power: np.ndarray
    thrust: np.ndarray
    torque: np.ndarray
    source: str = ""

    def __post_init__(self):
        freeze(
            self,
            pitch=("p",),
            tip_speed_ratio=("t",),
            wind_speed=("w",),
            power=("w", "t", "p"),
            thrust=("w", "t", "p"),
            torque=("w", "t", "p"),
        )


def read_rotor_table(path: str | Path) -> RotorTable:
    """Return a rotor performance table; raise FormatError when it is not complete or contradicts itself.

    The power coefficient is the tip speed ratio times the torque coefficient: that tells a damaged number.
    """
    path = Path(path)
    blocks = _blocks(path)
    vectors = {name: _vector(path, name, blocks) for name in ("pitch", "tip_speed_ratio", "wind_speed")}
    shape = (len(vectors["wind_speed"]), len(vectors["tip_speed_ratio"]), len(vectors["pitch"]))
    tables = {name: _table(path, name, blocks, shape) for name in ("power", "thrust", "torque")}
    _check_identity(path, blocks, vectors["tip_speed_ratio"], tables)
    return RotorTable(pitch=np.radians(vectors.pop("pitch")), **vectors, **tables, source=str(path))


def _blocks(path: Path) -> dict[str, tuple[int, str, list[tuple[int, str]]]]:
    """Return title line number, title and lines of numbers below it by name."""
    out: dict[str, tuple] = {}
    lines: list | None = None
    for i, line in enumerate(read_lines(path), start=1):
        if line.lstrip().startswith("#"):
            title = " ".join(line.strip("# \t").lower().split())
            name = next((n for n, text in _TITLES.items() if title.startswith(text)), None)
            if name in out:
                raise FormatError(path, i, expected=f"'{_TITLES[name]}' once", found=line)
            lines = [] if name else None
            if name:
                out[name] = (i, title, lines)
        elif line.strip():
            if lines is None:
                raise FormatError(
                    path,
                    i,
                    expected="a comment line that names what follows, such as '# Pitch angle vector'",
                    found=line,
                )
            lines.append((i, line))
    return out


def _block(path: Path, name: str, blocks: dict) -> tuple:
    if name not in blocks or not blocks[name][2]:
        at = blocks[name][0] if name in blocks else None
        raise FormatError(path, at, expected=f"'# {_TITLES[name].capitalize()}' with numbers below it", found="none")
    return blocks[name]


def _vector(path: Path, name: str, blocks: dict) -> np.ndarray:
    """Return the numbers of a vector, which ascend and are as many as its title says."""
    at, title, lines = _block(path, name, blocks)
    values = []
    for i, line in lines:
        try:
            values += numbers(line)
        except ValueError as error:
            raise FormatError(
                path, i, expected=f"numbers of the {_TITLES[name]}", found=line, hint=str(error)
            ) from None
    said = re.search(r"(\d+) entries", title)
    if said and int(said[1]) != len(values):
        raise FormatError(path, at, expected=f"{said[1]} entries", found=f"{len(values)} numbers")
    if np.any(np.diff(values) <= 0):
        raise FormatError(path, lines[0][0], expected=f"an ascending {_TITLES[name]}", found=lines[0][1])
    return np.array(values)


def _table(path: Path, name: str, blocks: dict, shape: tuple[int, int, int]) -> np.ndarray:
    """Return a table (w, t, p)."""
    at, _, lines = _block(path, name, blocks)
    rows = shape[0] * shape[1]
    what = f"a row of the {_TITLES[name]}"
    first, last = lines[0][0], lines[-1][0]
    text = dict(lines)
    table = number_table(path, [text.get(i, "") for i in range(first, last + 1)], first, shape[2], what)
    if len(table) != rows:
        raise FormatError(
            path,
            at,
            expected=f"{rows} rows of the {_TITLES[name]}",
            found=f"{len(table)} rows",
            hint="Is the file complete?",
        )
    return table.reshape(shape)


def _check_identity(path: Path, blocks: dict, ratio: np.ndarray, tables: dict) -> None:
    """Refuse tables in which the power coefficient is not the tip speed ratio times the torque coefficient."""
    other = ratio[:, None] * tables["torque"]
    gap = np.abs(tables["power"] - other)
    wrong = gap > _IDENTITY[0] * np.abs(tables["power"]) + _IDENTITY[1]
    if np.any(wrong):
        w, t, p = np.argwhere(wrong)[0]
        line = blocks["power"][2][w * len(ratio) + t][0]
        found = f"{tables['power'][w, t, p]:g} against {other[w, t, p]:g} in column {p + 1}"
        raise FormatError(
            path, line, expected="a power coefficient equal to tip speed ratio times torque coefficient", found=found
        )


def _recognises(path, head: bytes) -> bool:
    low = head.lower()
    return b"pitch angle vector" in low and b"tsr vector" in low


def _describe(table: RotorTable) -> list[tuple[str, str]]:
    w, t, p = np.unravel_index(np.argmax(table.power), table.power.shape)
    best = f"{table.power[w, t, p]:.4g} at tip speed ratio {table.tip_speed_ratio[t]:g}, pitch {np.degrees(table.pitch[p]):g} deg"
    return [
        ("blade pitch", f"{len(table.pitch)}, {span(table.pitch, 'deg', 180 / np.pi)}"),
        ("tip speed ratio", f"{len(table.tip_speed_ratio)}, {span(table.tip_speed_ratio, '')}"),
        ("wind speed", span(table.wind_speed, "m/s")),
        ("largest power coefficient", best),
    ]


ROTOR_TABLE = Format(
    name="Rotor performance table (ROSCO)", recognises=_recognises, read=read_rotor_table, describe=_describe
)
