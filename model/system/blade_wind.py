"""What the wind does blade by blade and node by node, from a linearisation with AeroDyn's node inputs (LinInputs 2).

AeroDyn's loads depend on the air's velocity past a node, so an input that moves a node by -u is a wind u there. Summed over the
nodes that is a uniform wind; weighed with their place in the disk, its gradients; node by node, how strongly each radius drives
the thrust. Blades with the inputs of their own azimuth are averaged over azimuth in fixed-frame lobes: one, cosine, sine.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model.conventions import PLATFORM_DOFS, freeze
from model.environment.rotor_wind import RotorSensitivity
from model.system.identified import SecondOrder
from model.system.linearisation import Linearisation
from model.system.tower import TOWER_MODES

_NODE = re.compile(r"AD Blade (\d+) X translation velocity, node (\d+)\b")


@dataclass(frozen=True, eq=False, kw_only=True)
class BladeWind:
    """Response of the degrees of freedom dofs (q) to the wind along x at the blades' nodes: radius (r) [m] and the thrust per m/s of
    all blades there (r); uniform_force (q) per m/s of all nodes; gradient_force (2, q) per (m/s)/m of the vertical and the lateral
    gradient; blades, their number.
    """

    dofs: tuple[str, ...]
    radius: np.ndarray
    thrust: np.ndarray
    uniform_force: np.ndarray
    gradient_force: np.ndarray
    blades: int

    def __post_init__(self):
        q = len(self.dofs)
        freeze(self, radius=("r",), thrust=("r",), uniform_force=(q,), gradient_force=(2, q))


def has_blade_inputs(record: Linearisation) -> bool:
    """Tell whether the record has AeroDyn's velocities of blade nodes as inputs."""
    return any(_NODE.match(name) for name in record.input_names)


def blade_wind(records: Sequence[Linearisation], found: SecondOrder, blades: int = 3) -> BladeWind:
    """Return what the wind at every node does, averaged over the azimuths of the records.

    found is the second-order form of the same records. The radius of a node follows from its own moment: at azimuth psi its
    thrust acts r cos(psi) above the hub. Raises ValueError for flexible blades, whose inputs turn with them, and for records
    without node inputs or without surge and pitch.
    """
    first = records[0]
    if not has_blade_inputs(first):
        raise ValueError(f"{first.source} has no inputs of blade nodes (AD Blade 1 X translation velocity ...): linearise with LinInputs = 2")
    if not {"surge", "pitch"} <= set(found.dofs) or any(d not in PLATFORM_DOFS + TOWER_MODES for d in found.dofs):
        raise ValueError(f"{first.source}: blade-wise wind needs surge, pitch and rigid blades among its degrees of freedom")
    force, azimuth = _node_forces(records, found, blades)
    thrust = force[..., found.dofs.index("surge")]
    radius = _radii(thrust, force[..., found.dofs.index("pitch")], azimuth)
    mean = thrust.sum(axis=1).mean(axis=0)
    kept = mean > 1e-4 * mean.sum()
    high = (radius * np.cos(azimuth)[..., None])[..., kept, None] * force[:, :, kept]
    aside = (-radius * np.sin(azimuth)[..., None])[..., kept, None] * force[:, :, kept]
    return BladeWind(
        dofs=found.dofs, radius=radius[kept], thrust=mean[kept], uniform_force=force.sum(axis=(1, 2)).mean(axis=0), blades=blades,
        gradient_force=np.stack([part.sum(axis=(1, 2)).mean(axis=0) for part in (high, aside)]),
    )  # fmt: skip


def sensitivity(wind: BladeWind, rotor_speed: float) -> RotorSensitivity:
    """Return how strongly the wind at each radius drives a blade's thrust, for the sampling of turbulence; rotor_speed [rad/s]."""
    return RotorSensitivity(
        radius=wind.radius, weight=wind.thrust, step=np.ones(len(wind.radius)), blades=wind.blades, rotor_speed=rotor_speed
    )


def _node_forces(records, found: SecondOrder, blades: int) -> tuple[np.ndarray, np.ndarray]:
    """Return forces (z, b, r, q) per m/s of wind at each node of each blade, azimuth by azimuth, and azimuths (z, b) [rad]."""
    first = records[0]
    place = {(int(m[1]), int(m[2])): k for k, m in enumerate(map(_NODE.match, first.input_names)) if m}
    nodes = sorted({n for _, n in place})
    columns = np.array([[place[b, n] for n in nodes] for b in range(1, blades + 1)])
    pairs = list(zip(first.state_dof, first.state_rate, strict=True))
    rates = [pairs.index((dof, 1)) for dof in found.dofs]
    force = np.stack([-np.einsum("ij,jbn->bni", found.mass, r.B[rates][:, columns]) for r in records])
    azimuth = np.array([r.azimuth for r in records])[:, None] + 2 * np.pi * np.arange(blades) / blades
    return force, azimuth


def _radii(thrust: np.ndarray, moment: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
    """Return the radii (r) of nodes whose thrusts (z, b, r) make moments (z, b, r) about a point below the hub."""
    n = thrust.shape[-1]
    lobe = thrust * np.cos(azimuth)[..., None]
    out = np.empty(n)
    for k in range(n):
        columns = np.stack([thrust[..., k].ravel(), lobe[..., k].ravel()], axis=1)
        out[k] = np.linalg.lstsq(columns, moment[..., k].ravel(), rcond=None)[0][1]
    return out
