"""The turbine's matrices recovered from linearisation records: mass from the load inputs, second-order form, azimuth average."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.conventions import PLATFORM_DOFS, freeze, rotation
from model.system.linearisation import Linearisation
from model.system.mbc import azimuth_average
from model.system.tower import TOWER_MODES

PLATFORM_LOADS = tuple(f"ED Platform {axis} {kind}, node 1" for kind in ("force", "moment") for axis in "XYZ")
WIND_INPUTS = ("IfW Extended input: horizontal wind speed", "AD Extended input: horizontal wind speed")
ROTATION_STEP = np.radians(2.0)  # ElastoDyn's perturbation of the platform's rotations


@dataclass(frozen=True, eq=False, kw_only=True)
class SecondOrder:
    """M q'' + B q' + C q = F + wind_force u of one linearisation: everything that the linearised code held.

    dofs (q) names; mass, damping, stiffness (q, q); wind_force (q) per m/s; point (q) the operating point;
    mass_source says where the mass matrix came from.
    """

    dofs: tuple[str, ...]
    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    wind_force: np.ndarray
    point: np.ndarray
    wind_speed: float
    rotor_speed: float
    mass_source: str

    def __post_init__(self):
        q = len(self.dofs)
        freeze(self, mass=(q, q), damping=(q, q), stiffness=(q, q), wind_force=(q,), point=(q,))


def has_load_inputs(record: Linearisation) -> bool:
    """Tell whether the record has ElastoDyn's platform load inputs, from which the mass matrix follows."""
    return all(_column(record, name) is not None for name in PLATFORM_LOADS)


def inverse_mass(record: Linearisation, tower_top) -> np.ndarray:
    """Return the inverse mass matrix (q, q) of a record in the order of its degrees of freedom.

    A unit load on the platform accelerates the degrees of freedom by a column of the inverse mass matrix; the column of
    a tower's first mode is that of a force on the tower top less what it does to the platform; tower_top is the height of
    the top, or its place (3) at the operating point, where the bent tower is lower and aside [m]. Other degrees of freedom get a unit column: their equations are scaled to unit inertia.
    Raises ValueError when the record lacks the load inputs.
    """
    if not has_load_inputs(record):
        raise ValueError(
            f"{record.source} has no platform load inputs, so its mass matrix cannot be recovered; "
            "linearise with LinInputs = 2, or name the deck that made it so that the mass comes from there"
        )
    dofs, rates = _dofs(record)
    x, y, z = (0.0, 0.0, float(tower_top)) if np.ndim(tower_top) == 0 else tower_top
    loads = np.stack([record.B[rates, _column(record, name)] for name in PLATFORM_LOADS], axis=1)
    out = np.zeros((len(dofs), len(dofs)))
    for k, dof in enumerate(dofs):
        if dof in PLATFORM_DOFS:
            out[:, k] = loads[:, PLATFORM_DOFS.index(dof)]
        elif dof in ("tower_fa1", "tower_ss1"):
            axis, moments = ("X", z * loads[:, 4] - y * loads[:, 5]) if dof == "tower_fa1" else ("Y", x * loads[:, 5] - z * loads[:, 3])
            column = _column(record, f"ED Nacelle {axis} force, node 1")
            if column is None:
                raise ValueError(f"{record.source} has no nacelle load inputs; linearise with LinInputs = 2")
            force = PLATFORM_DOFS.index("surge" if axis == "X" else "sway")
            out[:, k] = record.B[rates, column] - loads[:, force] - moments
        elif dof in TOWER_MODES:
            raise ValueError(f"{record.source}: the mass matrix of {dof} beside a first mode cannot be recovered from loads")
        else:
            out[k, k] = 1.0
    return out


def second_order(
    records: list[Linearisation], tower_top, mass: np.ndarray | None = None, blades: int = 3
) -> SecondOrder:
    """Return the azimuth-averaged second-order form of the records of one operating point, in the fixed frame.

    records at equally spaced azimuths, all with the same states; tower_top as in `inverse_mass`; mass (q, q) in the order of the records'
    degrees of freedom, None to recover it from the load inputs; blades, for multi-blade coordinates. The equations of
    degrees of freedom that no load input drives alone (blades, drivetrain) are scaled to unit inertia: the
    matrices then are not symmetric, the solution is the same. Raises ValueError.
    """
    record = azimuth_average(records, blades)
    dofs, rates = _dofs(record)
    source = "given"
    if mass is None:
        mass = np.linalg.inv(inverse_mass(record, tower_top))
        if all(d in PLATFORM_DOFS + TOWER_MODES for d in dofs):
            mass = (mass + mass.T) / 2
        source = "load inputs of the linearisation"
    places = [record.state_dof.index(dof) for dof in dofs]
    column = next((c for c in (_column(record, name) for name in WIND_INPUTS) if c is not None), None)
    wind = np.zeros(len(dofs)) if column is None else mass @ record.B[rates, column]
    return SecondOrder(
        dofs=dofs, mass=mass, damping=-mass @ record.A[np.ix_(rates, rates)], stiffness=-mass @ record.A[np.ix_(rates, places)],
        wind_force=wind, point=record.state_point[places], wind_speed=record.wind_speed, rotor_speed=record.rotor_speed,
        mass_source=source,
    )  # fmt: skip


def perturbation_error(
    structural_mass: np.ndarray, dofs: tuple[str, ...], gravity: float, thrust=None, hub_motion=None
) -> np.ndarray:
    """Return the part (q, q) of a linearised stiffness that ElastoDyn's finite rotation step adds.

    ElastoDyn turns the platform by +-2 degrees and differences the accelerations. Between the two the mass matrix turns with
    the platform, so the difference quotient of M(t)^-1 f(t) is not the derivative; with uniform gravity a0 the
    acceleration is a0 - M(t)^-1 M(0) a0, which needs the structural mass (q, q) alone (without added mass). A mean
    aerodynamic force thrust (3) [N] on a point of the turbine, whose motion is hub_motion (3, q), adds to it: it keeps
    its direction while the point turns.
    """
    q = len(dofs)
    fall = np.array([-gravity if dof == "heave" else 0.0 for dof in dofs])
    weight = structural_mass @ fall
    out = np.zeros((q, q))
    for k, axis in enumerate(("roll", "pitch", "yaw")):
        if axis not in dofs:
            continue
        j = dofs.index(axis)
        direction = np.eye(3)[k]

        def turned(angle, direction=direction):
            matrix = rotation(direction * angle)
            t = _turn(dofs, matrix)
            out = fall - t @ np.linalg.solve(structural_mass, t.T @ weight)
            if thrust is not None:
                change = t @ (hub_motion.T @ (matrix.T @ thrust)) - hub_motion.T @ thrust
                out = out + t @ np.linalg.solve(structural_mass, t.T @ change)
            return out

        angle, small = ROTATION_STEP, 1e-5
        coarse = (turned(angle) - turned(-angle)) / (2 * angle)
        exact = (turned(small) - turned(-small)) / (2 * small)
        out[:, j] = -structural_mass @ (coarse - exact)
    return out


def _turn(dofs: tuple[str, ...], matrix: np.ndarray) -> np.ndarray:
    """Return the transformation of the degrees of freedom that turns the platform's and leaves the modes."""
    out = np.eye(len(dofs))
    for group in (PLATFORM_DOFS[:3], PLATFORM_DOFS[3:]):
        for i, a in enumerate(group):
            for j, b in enumerate(group):
                if a in dofs and b in dofs:
                    out[dofs.index(a), dofs.index(b)] = matrix[i, j]
    return out


def _dofs(record: Linearisation) -> tuple[tuple[str, ...], list[int]]:
    """Return the record's degrees of freedom in order and the rows of their velocities; raise ValueError."""
    rotating = [n for n, r in zip(record.state_dof, record.state_rotating, strict=True) if r]
    if rotating:
        raise ValueError(f"{record.source} has rotating states ({rotating[0]}); transform them first")
    dofs = tuple(d for d, rate in zip(record.state_dof, record.state_rate, strict=True) if d and not rate)
    rows = {d: i for i, (d, rate) in enumerate(zip(record.state_dof, record.state_rate, strict=True)) if d and rate}
    missing = [d for d in dofs if d not in rows]
    if missing or not dofs:
        raise ValueError(
            f"{record.source} lacks the velocity state of {missing[0] if missing else 'every degree of freedom'}"
        )
    return dofs, [rows[d] for d in dofs]


def _column(record: Linearisation, name: str) -> int | None:
    """Return the index of the input whose description begins with name."""
    return next((i for i, n in enumerate(record.input_names) if n.startswith(name)), None)
