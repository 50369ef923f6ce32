"""Multi-blade coordinates: linearised models of a turning rotor brought to the fixed frame.

The blades' states, inputs and outputs of one kind are a group; at azimuth psi their fixed-frame coordinates are
q_b = a_0 + sum_k (a_k cos k psi_b + b_k sin k psi_b) (+ a_d (-1)^b for an even number of blades), psi_b = psi + 2 pi (b - 1) / n.
Reference: Bir, "Multiblade coordinate transformation and its application to wind turbine analysis", AIAA 2008-1300;
here written for states x_R = T x_N, so that A_N = T^-1 (A T - T'), which holds the terms in the rotor's acceleration too.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.system.linearisation import Linearisation


@dataclass(frozen=True, eq=False, kw_only=True)
class Groups:
    """Places of the blades' members of each kind, (g, n) in blade order, and the labels of the kinds."""

    places: np.ndarray
    labels: tuple[str, ...]


def coordinate_labels(blades: int) -> tuple[str, ...]:
    """Return the names of the fixed-frame coordinates of a group."""
    out = ["collective"]
    for k in range(1, (blades - 1) // 2 + 1):
        out += [f"cosine{'' if k == 1 else k}", f"sine{'' if k == 1 else k}"]
    return tuple(out + (["differential"] if blades % 2 == 0 else []))


def blade_matrices(azimuth: float, blades: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return T1 (n, n) of one group and its first and second derivative with respect to azimuth [rad]; raise ValueError for n < 3."""
    if blades < 3:
        raise ValueError(f"multi-blade coordinates need three blades or more, not {blades}")
    psi = azimuth + 2 * np.pi * np.arange(blades) / blades
    columns = [(np.ones(blades), np.zeros(blades), np.zeros(blades))]
    for k in range(1, (blades - 1) // 2 + 1):
        c, s = np.cos(k * psi), np.sin(k * psi)
        columns += [(c, -k * s, -(k**2) * c), (s, k * c, -(k**2) * s)]
    if blades % 2 == 0:
        sign = (-1.0) ** np.arange(blades)
        columns.append((sign, np.zeros(blades), np.zeros(blades)))
    return tuple(np.stack([c[d] for c in columns], axis=1) for d in range(3))


def blade_groups(names: Sequence[str], rotating: np.ndarray, blades: int) -> Groups:
    """Return the groups among named signals with rotating-frame flags: names that are alike but for the blade's number.

    Raises ValueError when a rotating signal has no counterpart on every other blade.
    """
    kinds: dict[str, dict[int, int]] = {}
    for place, (name, turns) in enumerate(zip(names, rotating, strict=True)):
        if turns:
            label, blade = _blade_of(name)
            kinds.setdefault(label, {})[blade] = place
    for label, members in kinds.items():
        if sorted(members) != list(range(1, blades + 1)):
            raise ValueError(f"rotating signal {label!r} is there for blades {sorted(members)}, needs 1 to {blades}")
    places = np.array([[m[b] for b in range(1, blades + 1)] for m in kinds.values()], dtype=int).reshape(-1, blades)
    return Groups(places=places, labels=tuple(kinds))


def to_fixed_frame(record: Linearisation, blades: int, rotor_acceleration: float = 0.0) -> Linearisation:
    """Return a record with its rotating states, inputs and outputs in multi-blade coordinates.

    rotor_acceleration [rad/s2]. Degrees of freedom of the blades are renamed, blade1_flap1 to flap1_collective and so on.
    An output that is there for some blades only has no mean in the fixed frame and is left out. Raises ValueError when
    rotating states or inputs do not come in whole groups.
    """
    if not (record.state_rotating.any() or record.input_rotating.any() or record.output_rotating.any()):
        return record
    record = _whole_outputs(record, blades)
    one, first, second = blade_matrices(record.azimuth, blades)
    rate = record.rotor_speed
    positions = (record.state_order == 2) & (record.state_rate == 0) & (record.state_rotating > 0)
    velocities = (record.state_order == 2) & (record.state_rate > 0) & (record.state_rotating > 0)
    lags = (record.state_order != 2) & (record.state_rotating > 0)
    keys = [d or n for d, n in zip(record.state_dof, record.state_names, strict=True)]
    q, v, x = (blade_groups(keys, flags, blades) for flags in (positions, velocities, lags))
    if sorted(q.labels) != sorted(v.labels):
        raise ValueError(f"{record.source}: rotating positions and velocities do not pair")
    order = [v.labels.index(label) for label in q.labels]
    turn, turned = np.eye(len(record.A)), np.zeros_like(record.A)
    for p, w in zip(q.places, v.places[order], strict=True):
        turn[np.ix_(p, p)], turn[np.ix_(w, w)], turn[np.ix_(w, p)] = one, one, rate * first
        turned[np.ix_(p, p)] = turned[np.ix_(w, w)] = rate * first
        turned[np.ix_(w, p)] = rate**2 * second + rotor_acceleration * first
    for p in x.places:
        turn[np.ix_(p, p)], turned[np.ix_(p, p)] = one, rate * first
    back, one_back = np.linalg.inv(turn), np.linalg.inv(one)
    driven, through = back @ record.B, record.D.copy()
    for p in blade_groups(record.input_names, record.input_rotating, blades).places:
        driven[:, p], through[:, p] = driven[:, p] @ one, through[:, p] @ one
    measured = record.C @ turn
    for p in blade_groups(record.output_names, record.output_rotating, blades).places:
        measured[p], through[p] = one_back @ measured[p], one_back @ through[p]
    return replace(
        record,
        A=back @ (record.A @ turn - turned), B=driven, C=measured, D=through,
        state_dof=_renamed(record.state_dof, (q, v), blades), state_point=back @ record.state_point,
        state_rotating=np.zeros(len(record.A)), input_rotating=np.zeros(record.B.shape[1]),
        output_rotating=np.zeros(len(record.C)), jacobians={},
    )  # fmt: skip


def azimuth_average(records: Sequence[Linearisation], blades: int, rotor_acceleration: float = 0.0) -> Linearisation:
    """Return the mean of records over azimuth after each is brought to the fixed frame.

    Raises ValueError when the records have different states, inputs or outputs, or azimuths that repeat.
    """
    first = records[0]
    for other in records[1:]:
        for kind in ("state_names", "input_names", "output_names"):
            if getattr(other, kind) != getattr(first, kind):
                raise ValueError(f"{other.source} has other {kind[:-6]}s than {first.source}; average files of one run only")
    fixed = [to_fixed_frame(r, blades, rotor_acceleration) for r in records]

    def mean(name):
        return np.mean([getattr(r, name) for r in fixed], axis=0)

    return replace(
        fixed[0], A=mean("A"), B=mean("B"), C=mean("C"), D=mean("D"), state_point=mean("state_point"),
        rotor_speed=float(mean("rotor_speed")), wind_speed=float(mean("wind_speed")),
    )  # fmt: skip


def _whole_outputs(record: Linearisation, blades: int) -> Linearisation:
    """Return the record without the rotating outputs that not every blade has."""
    count: dict[str, int] = {}
    labels = [_blade_of(n)[0] if r else "" for n, r in zip(record.output_names, record.output_rotating, strict=True)]
    for label in labels:
        count[label] = count.get(label, 0) + 1
    keep = [k for k, label in enumerate(labels) if label == "" or count[label] == blades]
    if len(keep) == len(labels):
        return record
    return replace(
        record, C=record.C[keep], D=record.D[keep], output_names=tuple(record.output_names[k] for k in keep),
        output_point=tuple(record.output_point[k] for k in keep), output_rotating=record.output_rotating[keep],
    )  # fmt: skip


def _blade_of(name: str) -> tuple[str, int]:
    """Return a signal's name without its blade number, and that number; raise ValueError when it names no blade."""
    match = re.search(r"(?i)blade(?: root)?[ _]?(\d)", name) or re.search(r"(?<=[A-Za-z])([1-9])(?=(?:,|\s|$))", name)
    match = match or re.search(r"(?<![A-Za-z])B([1-9])(?=N\d)", name) or re.search(r"\(([1-9])\)", name)
    if match is None:
        raise ValueError(f"rotating signal {name!r} names no blade")
    return name[: match.start(1)] + "#" + name[match.end(1) :], int(match[1])


def _renamed(dofs: tuple[str, ...], groups: tuple[Groups, Groups], blades: int) -> tuple[str, ...]:
    """Return the degrees of freedom with the blades' replaced by their fixed-frame coordinates."""
    out = list(dofs)
    for group in groups:
        for label, places in zip(group.labels, group.places, strict=True):
            kind = label.split("_", 1)[-1]
            for place, coordinate in zip(places, coordinate_labels(blades), strict=True):
                out[place] = f"{kind}_{coordinate}"
    return tuple(out)
