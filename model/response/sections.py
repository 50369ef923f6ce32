"""Further linear outputs: tower sections at any height, tower-base loads of the modal stiffness alone, anchor tensions, air gap."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.conventions import PLATFORM_DOFS, point_motion
from model.response.assemble import Equilibrium, System
from model.response.loads import MOTION_CHANNELS, LinearOutputs
from model.system.tower import TOWER_MODES, Tower, polynomial, tower_modes
from model.system.turbine import TurbineStructure


@dataclass(frozen=True, kw_only=True)
class ExtraOutputs:
    """What is wanted beside the standard channels: heights of tower sections [m above still water], whether the modal-stiffness
    tower loads and the anchor tensions, and points (x, y, z) fixed to the platform for relative elevation and air gap [m].
    """

    tower_sections: tuple[float, ...] = ()
    modal_tower_loads: bool = False
    anchor_tensions: bool = False
    air_gap_points: tuple[tuple[float, float, float], ...] = ()


def with_extras(
    outputs: LinearOutputs, system: System, mean: Equilibrium, structure: TurbineStructure | None, extras: ExtraOutputs
) -> LinearOutputs:
    """Return the standard channels with those of `extras` behind them; raise ValueError for a section outside the tower."""
    rows = []
    if structure is not None:
        rows += [row for height in extras.tower_sections for row in _section(outputs, system, structure, height)]
        if extras.modal_tower_loads:
            rows += _modal_loads(system, mean, structure)
    if extras.anchor_tensions and mean.mooring is not None:
        rows += _anchor_tensions(system, mean)
    rows += [_air_gap(system, mean, k, point) for k, point in enumerate(extras.air_gap_points, start=1)]
    if not rows:
        return outputs

    def joined(name, index):
        return np.concatenate([getattr(outputs, name), np.array([r[index] for r in rows], dtype=float)])

    old = np.full((len(outputs.names), 2), np.nan) if outputs.wave_point is None else outputs.wave_point
    return LinearOutputs(
        names=outputs.names + tuple(r[0] for r in rows), units=outputs.units + tuple(r[1] for r in rows),
        position=joined("position", 2), velocity=joined("velocity", 3), acceleration=joined("acceleration", 4),
        wind=joined("wind", 5), mean=joined("mean", 6), wave_point=np.concatenate([old, np.array([r[7] for r in rows])]),
        depth=system.hydro.depth, gravity=system.hydro.gravity,
    )  # fmt: skip


def _row(name, unit, q, *, position=None, velocity=None, acceleration=None, wind=None, mean=0.0, wave=(np.nan, np.nan)):
    zero = np.zeros(q)
    return (
        name, unit, zero if position is None else position, zero if velocity is None else velocity,
        zero if acceleration is None else acceleration, np.zeros(3) if wind is None else wind, mean, wave,
    )  # fmt: skip


def _section(outputs: LinearOutputs, system: System, structure: TurbineStructure, height: float) -> list[tuple]:
    """Fore-aft shear and moment in a tower section: the base's, less inertia and weight of the tower between.

    In axes that turn with the platform, about the displaced centre of the section.
    """
    tower, q, g = structure.tower, len(system.dofs), structure.gravity
    if not tower.base_height <= height < tower.top_height:
        raise ValueError(f"tower section at {height:g} m lies outside the tower ({tower.base_height:g} to {tower.top_height:g} m)")
    shapes = tower_modes(tower, tuple(d for d in system.dofs if d in TOWER_MODES))
    step = tower.length / tower.nodes
    covered = np.clip((height - tower.base_height) / step - np.arange(tower.nodes), 0.0, 1.0)
    mass, place = shapes.mass * covered, tower.base_height + (np.arange(tower.nodes) + covered / 2) * step
    bend, here = _deflection(system, tower, place), _deflection(system, tower, [height])[0]
    surge, tilt = _column(system, "surge"), _column(system, "pitch")
    motion = surge + place[:, None] * tilt + bend
    lever, arm = place - height, height - tower.base_height
    base, moment = (outputs.names.index(n) for n in ("TwrBsFxt", "TwrBsMyt"))
    all_above = float(system.turbine.mass[0, 0] * g)
    shear = -mass.sum() * g * tilt
    turned = -all_above * here - (mass @ lever) * g * tilt - g * mass @ (bend - here)

    def less(name):
        rows = getattr(outputs, name)
        return rows[base], rows[moment] - arm * rows[base]

    x, v, a, wind, level = (less(n) for n in ("position", "velocity", "acceleration", "wind", "mean"))
    return [
        _row(f"TwrFx@{height:g}m", "N", q, position=x[0] + shear, velocity=v[0], acceleration=a[0] + mass @ motion, wind=wind[0],
             mean=level[0] + shear @ mean_offset(system, outputs)),
        _row(f"TwrMy@{height:g}m", "N m", q, position=x[1] + turned, velocity=v[1], acceleration=a[1] + (mass * lever) @ motion,
             wind=wind[1], mean=level[1] + turned @ mean_offset(system, outputs)),
    ]  # fmt: skip


def mean_offset(system: System, outputs: LinearOutputs) -> np.ndarray:
    """Return the mean offset (q) that the standard channels of motion hold, zero for other degrees of freedom."""
    out = np.zeros(len(system.dofs))
    for dof, (name, _) in MOTION_CHANNELS.items():
        if dof in system.dofs:
            out[system.dofs.index(dof)] = outputs.mean[outputs.names.index(name)]
    return out


def _modal_loads(system: System, mean: Equilibrium, structure: TurbineStructure) -> list[tuple]:
    """Shear and moment from the modal stiffness alone, thesis eq. 5.7 and 5.8: C77 q7, and that times the tower's length."""
    q = len(system.dofs)
    if "tower_fa1" not in system.dofs:
        return []
    k = system.dofs.index("tower_fa1")
    unit = np.eye(q)[k]
    stiffness = system.stiffness[k, k]
    shear = float(stiffness * mean.offset[k])
    length = structure.tower.length
    return [
        _row("TwrBsFxt modal", "N", q, position=stiffness * unit, mean=shear),
        _row("TwrBsMyt modal", "N m", q, position=stiffness * length * unit, mean=shear * length),
    ]


def _anchor_tensions(system: System, mean: Equilibrium) -> list[tuple]:
    state, q = mean.mooring, len(system.dofs)
    rows = []
    for line, tension in enumerate(state.anchor_tension):
        gradient = np.zeros(q)
        for k, dof in enumerate(PLATFORM_DOFS):
            if dof in system.dofs:
                gradient[system.dofs.index(dof)] = state.anchor_tension_gradient[line, k]
        rows.append(_row(f"T_a[{line + 1}]", "N", q, position=gradient, mean=float(tension)))
    return rows


def _air_gap(system: System, mean: Equilibrium, number: int, point) -> tuple:
    """Return the wave elevation relative to a point fixed to the platform: the undisturbed wave less the point's rise.

    The air gap below the point is its height z less this. Diffraction by the hull is not in it.
    """
    rise = np.zeros(len(system.dofs))
    motion = point_motion(np.asarray(point, dtype=float))[2]
    for k, dof in enumerate(PLATFORM_DOFS):
        if dof in system.dofs:
            rise[system.dofs.index(dof)] = motion[k]
    place = (float(point[0]), float(point[1]))
    return _row(f"RelElev{number}", "m", len(system.dofs), position=-rise, mean=float(-rise @ mean.offset), wave=place)


def _deflection(system: System, tower: Tower, heights) -> np.ndarray:
    """Return the fore-aft deflection (n, q) of the tower at heights (n) per unit of each degree of freedom."""
    x = (np.asarray(heights, dtype=float) - tower.base_height) / tower.length
    out = np.zeros((len(x), len(system.dofs)))
    for k, name in enumerate(TOWER_MODES):
        if name.startswith("tower_fa") and name in system.dofs:
            out[:, system.dofs.index(name)] = polynomial(tower.modes[[k]], x)[:, 0]
    return out


def _column(system: System, dof: str) -> np.ndarray:
    return np.eye(len(system.dofs))[system.dofs.index(dof)] if dof in system.dofs else np.zeros(len(system.dofs))
