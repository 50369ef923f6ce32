"""TurbSim wind fields (.bts): three velocity components on a vertical grid over time.

Source of the layout: TurbSim User's Guide (B. J. Jonkman, NREL), appendix on full-field files in TurbSim format:
little-endian header, then 16-bit integers scaled by a slope and an offset per component, the component running
fastest, then y, then z, then time; points of the tower below the grid follow each time step.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError, ModelError
from fowtio.read.registry import Format, span
from fowtio.read.text import read_bytes
from model.conventions import freeze

_IDS = {7: False, 8: True}
_FASTEST = 300.0  # m/s
_HEADER = struct.Struct("<h4i12fi")
_RINGS, _SPOKES = 8, 24  # points of the disk average


@dataclass(frozen=True, eq=False, kw_only=True)
class WindField:
    """A wind field on a grid normal to the mean wind.

    time (t) [s]; y (a), z (b) [m], y to the left looking downwind, z from the ground; velocity (t, b, a, 3) [m/s]
    along x, y, z; mean_speed [m/s] at hub_height [m] as the header says; periodic in time or not; description; source
    names the file.
    """

    time: np.ndarray
    y: np.ndarray
    z: np.ndarray
    velocity: np.ndarray
    mean_speed: float
    hub_height: float
    periodic: bool = False
    description: str = ""
    source: str = ""

    def __post_init__(self):
        freeze(self, time=("t",), y=("a",), z=("b",))
        if self.velocity.shape != (len(self.time), len(self.z), len(self.y), 3):
            raise ValueError(f"velocity has shape {self.velocity.shape}, needs (times, heights, sides, 3)")
        self.velocity.setflags(write=False)


def is_turbsim(head: bytes) -> bool:
    """Tell by the first bytes of a file whether it is a TurbSim wind field."""
    if len(head) < _HEADER.size:
        return False
    ident, *counts = struct.unpack_from("<h4i", head)
    return ident in _IDS and all(0 <= n < 100_000 for n in counts) and min(counts[0], counts[1], counts[3]) > 0


def read_turbsim(path: str | Path) -> WindField:
    """Return a TurbSim .bts wind field (32-bit velocities, tower points left out); raise FormatError."""
    path = Path(path)
    data = read_bytes(path)
    if not is_turbsim(data[: _HEADER.size]):
        raise FormatError(path, expected="a TurbSim wind field (.bts, identifier 7 or 8)", found=repr(data[:8]))
    ident, nz, ny, tower, steps, *values, length = _HEADER.unpack_from(data)
    dz, dy, dt, speed, hub, bottom, *scales = values
    slope, offset = np.array(scales[0::2]), np.array(scales[1::2])
    if not np.all(np.isfinite(values)) or np.any(slope == 0) or dt <= 0 or (nz > 1 and dz <= 0) or (ny > 1 and dy <= 0):
        raise FormatError(path, expected="finite scales, positive steps in time and space", found=f"{values}")
    per_step = 3 * (nz * ny + tower)
    start = _HEADER.size + length
    wanted = start + 2 * per_step * steps
    if length < 0 or len(data) != wanted:
        raise FormatError(
            path, expected=f"{wanted} bytes for {steps} steps of {ny} x {nz} points", found=f"{len(data)} bytes",
            hint="Is the file complete?",
        )  # fmt: skip
    packed = np.frombuffer(data, "<i2", per_step * steps, start).reshape(steps, per_step)[:, : 3 * nz * ny]
    packed = packed.reshape(steps, nz, ny, 3).astype(np.float32)
    with np.errstate(over="ignore", invalid="ignore"):  # what overflows is refused below
        velocity = (packed - offset.astype(np.float32)) / slope.astype(np.float32)
    if not np.abs(velocity).max() < _FASTEST:
        raise FormatError(
            path, expected=f"velocities below {_FASTEST:g} m/s", found=f"slopes {slope}, offsets {offset}"
        )
    return WindField(
        time=np.arange(steps) * float(dt),
        y=(np.arange(ny) - (ny - 1) / 2) * dy,
        z=bottom + np.arange(nz) * dz,
        velocity=velocity,
        mean_speed=float(speed),
        hub_height=float(hub),
        periodic=_IDS[ident],
        description=data[_HEADER.size : start].decode("latin-1").strip(),
        source=str(path),
    )


def point_wind(field: WindField, y: float, z: float) -> np.ndarray:
    """Return the velocity (t, 3) [m/s] at a point by bilinear interpolation; raise ModelError outside the grid."""
    return _weighted(field, np.array([[y, z]]), np.ones(1))


def hub_wind(field: WindField, height: float | None = None) -> np.ndarray:
    """Return the velocity (t, 3) [m/s] on the rotor axis at a height [m], the field's own hub height if left out."""
    return point_wind(field, 0.0, field.hub_height if height is None else height)


def rotor_wind(field: WindField, radius: float, height: float | None = None) -> np.ndarray:
    """Return the velocity (t, 3) [m/s] averaged over a disk of a radius [m] around the hub; raise ModelError outside.

    The mean of the interpolated field by Gauss quadrature in the radius squared and equal steps of the angle.
    """
    if radius <= 0:
        raise ModelError(f"the radius of the rotor disk must be above zero, is {radius:g} m")
    x, weight = np.polynomial.legendre.leggauss(_RINGS)
    r = radius * np.sqrt((x + 1) / 2)
    angle = (np.arange(_SPOKES) + 0.5) * 2 * np.pi / _SPOKES
    height = field.hub_height if height is None else height
    points = np.stack([np.outer(r, np.cos(angle)), height + np.outer(r, np.sin(angle))], axis=-1).reshape(-1, 2)
    return _weighted(field, points, np.repeat(weight / 2 / _SPOKES, _SPOKES))


def _weighted(field: WindField, points: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return the weighted sum over points (p, 2) of y and z of the interpolated velocity."""
    grid = np.zeros((len(field.z), len(field.y)))
    columns = _bracket(field, field.y, points[:, 0], "y")
    rows = _bracket(field, field.z, points[:, 1], "z")
    for j, part in columns:
        for i, share in rows:
            np.add.at(grid, (i, j), weights * part * share)
    return np.einsum("ij,tijk->tk", grid, field.velocity)


def _bracket(field: WindField, axis: np.ndarray, value: np.ndarray, name: str) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the two neighbouring indices of values on an axis with their shares."""
    slack = 1e-6 * max(abs(axis[0]), abs(axis[-1]), 1.0)
    if value.min() < axis[0] - slack or value.max() > axis[-1] + slack:
        raise ModelError(
            f"{field.source}: {name} from {value.min():g} to {value.max():g} m is wanted, the wind field has "
            f"{axis[0]:g} to {axis[-1]:g} m; make a larger grid"
        )
    if len(axis) == 1:
        return [(np.zeros(len(value), dtype=int), np.ones(len(value)))]
    low = np.clip(np.searchsorted(axis, value, side="right") - 1, 0, len(axis) - 2)
    share = np.clip((value - axis[low]) / (axis[low + 1] - axis[low]), 0, 1)
    return [(low, 1 - share), (low + 1, share)]


def _describe(field: WindField) -> list[tuple[str, str]]:
    hub = hub_wind(field)
    return [
        ("time", f"{span(field.time, 's')}, {len(field.time)} steps" + (", periodic" if field.periodic else "")),
        ("grid", f"{len(field.y)} x {len(field.z)} points, y {span(field.y, 'm')}, z {span(field.z, 'm')}"),
        (
            "hub",
            f"{field.hub_height:g} m; mean {hub[:, 0].mean():.4g} m/s, standard deviation {hub[:, 0].std():.4g} m/s",
        ),
        ("description", field.description or "none"),
    ]


TURBSIM = Format(
    name="TurbSim wind field (.bts)",
    recognises=lambda path, head: is_turbsim(head),
    read=read_turbsim,
    describe=_describe,
)
