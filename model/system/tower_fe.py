"""Tower bending modes by finite elements: clamped at the base or standing on a rigid floating platform.

Euler-Bernoulli elements with cubic shapes, consistent mass and the geometric stiffness of the weight above; the
rotor-nacelle assembly is a rigid body on the top. Torsion and stretching are left out, as in ElastoDyn. The modes are
deflections of the tower relative to its (moving) base, which is what ElastoDyn's polynomials describe.
References: Przemieniecki, "Theory of Matrix Structural Analysis", 1968, chapters 5, 11 and 15.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import eigh

from model.conventions import PLATFORM_DOFS, freeze, point_motion
from model.system.tower import TOWER_MODES, Tower, polynomial
from model.system.turbine import RigidBody, TurbineMatrices, TurbineStructure, rotor_nacelle, structural_matrices

PLANES = ("fa", "ss")
_IN_PLANE = {"fa": (0, 2, 4), "ss": (1, 3, 5)}
_GAUSS = np.polynomial.legendre.leggauss(4)


@dataclass(frozen=True, eq=False, kw_only=True)
class TowerMatrices:
    """Tower and rotor-nacelle assembly in the six platform motions and the nodes' deflection and slope relative to the base.

    mass, elastic, geometric (d, d) with d = 6 + 4 n: six platform motions about the reference point, then deflection
    [m] and slope [-] of the n nodes above the base in the fore-aft plane, then the same in the side-side plane (deflection
    towards +y; its slope is minus a rotation about x). height (n + 1) [m above still water] of the nodes, base first;
    weight_force (d) is the generalised force of the weight; tower (d, d) the part of the tower alone in the mass.
    """

    height: np.ndarray
    mass: np.ndarray
    elastic: np.ndarray
    geometric: np.ndarray
    weight_force: np.ndarray
    tower: np.ndarray

    def __post_init__(self):
        freeze(
            self, height=(None,), mass=("d", "d"), elastic=("d", "d"), geometric=("d", "d"), weight_force=("d",), tower=("d", "d"),
        )  # fmt: skip

    def plane(self, plane: str) -> np.ndarray:
        """Return the places of a plane's nodal degrees of freedom, base upward, deflection before slope."""
        half = 2 * (len(self.height) - 1)
        return 6 + np.arange(half) + (half if plane == "ss" else 0)


@dataclass(frozen=True, eq=False, kw_only=True)
class TowerShapes:
    """Tower modes: names (k), frequency (k) [rad/s]; on heights (n) [m above still water] and stations (n) fractions of the
    flexible length, base and top included: shape (n, k) relative to the base, 1 at the top, and its slope (n, k) [1/m].

    platform (6, k) is how the platform moves in the mode (zero when clamped). The modal quantities of the shape with the
    base at rest: modal_mass (k) [kg], modal_stiffness (k) [N/m] elastic, gravity_stiffness (k) [N/m] the loss by weight,
    mass_coupling (6, k) and gravity_coupling (6, k) with the platform motions, tower_mass (k) [kg] without what stands on top.
    """

    names: tuple[str, ...]
    frequency: np.ndarray
    height: np.ndarray
    station: np.ndarray
    shape: np.ndarray
    slope: np.ndarray
    platform: np.ndarray
    modal_mass: np.ndarray
    modal_stiffness: np.ndarray
    gravity_stiffness: np.ndarray
    mass_coupling: np.ndarray
    gravity_coupling: np.ndarray
    tower_mass: np.ndarray
    clamped: bool

    def __post_init__(self):
        k = len(self.names)
        freeze(
            self, frequency=(k,), height=("n",), station=("n",), shape=("n", k), slope=("n", k), platform=(6, k), modal_mass=(k,),
            modal_stiffness=(k,), gravity_stiffness=(k,), mass_coupling=(6, k), gravity_coupling=(6, k), tower_mass=(k,),
        )  # fmt: skip


@dataclass(frozen=True, eq=False, kw_only=True)
class PolynomialFit:
    """Mode shapes as ElastoDyn takes them: names (k), coefficients (k, 5) of x^2 ... x^6 that sum to 1, residual (k): the largest
    departure from the shape over the largest deflection of the shape.
    """

    names: tuple[str, ...]
    coefficients: np.ndarray
    residual: np.ndarray

    def __post_init__(self):
        freeze(self, coefficients=(len(self.names), 5), residual=(len(self.names),))


def tower_matrices(tower: Tower, head: RigidBody, gravity: float, elements: int = 60) -> TowerMatrices:
    """Return the finite-element matrices of a tower that carries a rigid body.

    head is the rotor-nacelle assembly about the tower top; gravity [m/s2], zero leaves the weight out; elements of
    equal length, properties linear between the tower's stations. Raises ValueError for fewer than two elements.
    """
    if elements < 2:
        raise ValueError(f"{elements} elements are too few for a tower; give two or more, 60 is plenty")
    height = np.linspace(tower.base_height, tower.top_height, elements + 1)
    size = 6 + 4 * elements
    mass, elastic, geometric = np.zeros((3, size, size))
    carried = head.mass
    for plane, rigidity in zip(PLANES, (tower.stiffness_fa, tower.stiffness_ss), strict=True):
        inertia, bending, weight = _plane_matrices(tower, rigidity, carried, elements)
        motion = _absolute(height, plane, size)
        mass += motion.T @ inertia @ motion
        elastic += motion.T @ bending @ motion
        geometric -= gravity * motion.T @ weight @ motion
    _add_base(tower, head, gravity, mass, geometric, tower_mass := _tower_mass(tower, elements))
    alone = mass.copy()
    jacobian = _head_jacobian(tower, head, size)
    mass += head.mass * jacobian[:3].T @ jacobian[:3] + jacobian[3:].T @ head.inertia @ jacobian[3:]
    turn = jacobian[3:5]
    geometric -= gravity * head.mass * head.centre[2] * turn.T @ turn
    force = -gravity * head.mass * jacobian[2]
    force[2] -= gravity * tower_mass
    elastic[:6], elastic[:, :6] = 0.0, 0.0  # rigid motions do not strain the tower: rounding only
    return TowerMatrices(
        height=height, mass=mass, elastic=elastic, geometric=geometric, weight_force=force, tower=alone
    )


def bending_modes(
    tower: Tower,
    head: RigidBody,
    gravity: float,
    *,
    platform_mass=None,
    platform_stiffness=None,
    count: int = 2,
    elements: int = 60,
) -> TowerShapes:
    """Return the first `count` bending modes in each plane, fore-aft before side-side.

    The base is clamped, or with platform_mass (6, 6) [kg, kg m, kg m2] (added mass with it) and platform_stiffness (6, 6)
    (hydrostatics, moorings and the platform's own weight, not the tower's and what it carries) stands on a rigid floating
    platform. Each plane has its own platform motions: surge, heave and pitch; sway, roll and yaw. The platform's own natural
    modes are passed over: a bending mode has most of its potential energy in the tower. Raises ValueError when platform mass
    and stiffness are not given together, or fewer modes are found.
    """
    if (platform_mass is None) != (platform_stiffness is None):
        raise ValueError(
            "a floating base needs platform_mass and platform_stiffness; give both, or neither for a clamped base"
        )
    parts = tower_matrices(tower, head, gravity, elements)
    floating = platform_mass is not None
    mass, stiffness = parts.mass.copy(), parts.elastic + parts.geometric
    if floating:
        mass[:6, :6] += np.asarray(platform_mass, dtype=float)
        stiffness[:6, :6] += np.asarray(platform_stiffness, dtype=float)
    found = [_plane_modes(parts, mass, stiffness, plane, count, floating) for plane in PLANES]
    frequency, vectors = (np.concatenate([f[k] for f in found], axis=-1) for k in (0, 1))
    names = tuple(f"tower_{plane}{k + 1}" for plane in PLANES for k in range(count))
    return _shapes(parts, tower, names, frequency, vectors, clamped=not floating)


def fit_polynomials(shapes: TowerShapes) -> PolynomialFit:
    """Return ElastoDyn's polynomials through mode shapes: least squares over the tower with the sum of coefficients held at 1."""
    powers = shapes.station[:, None] ** np.arange(2, 7)
    basis = powers[:, :4] - powers[:, 4:]
    free = np.linalg.lstsq(basis, shapes.shape - powers[:, 4:], rcond=None)[0]
    coefficients = np.vstack([free, 1 - free.sum(axis=0)]).T
    gap = np.abs(polynomial(coefficients, shapes.station) - shapes.shape).max(axis=0)
    return PolynomialFit(names=shapes.names, coefficients=coefficients, residual=gap / np.abs(shapes.shape).max(axis=0))


def with_modes(tower: Tower, fit: PolynomialFit) -> Tower:
    """Return the tower with its polynomial modes replaced by fitted ones, those not fitted kept."""
    modes = np.array(tower.modes)
    for name, row in zip(fit.names, fit.coefficients, strict=True):
        if name in TOWER_MODES:
            modes[TOWER_MODES.index(name)] = row
    return replace(tower, modes=modes)


def clamped_frequencies(structure: TurbineStructure, modes: Sequence[str]) -> np.ndarray:
    """Return the natural frequencies (k) [rad/s] that the named polynomial modes give together on a clamped base."""
    turbine = structural_matrices(structure, tuple(modes), np.zeros(len(modes)))
    stiffness = (turbine.stiffness + turbine.stiffness.T)[6:, 6:] / 2
    return np.sqrt(eigh(stiffness, turbine.mass[6:, 6:], eigvals_only=True))


def modal_matrices(structure: TurbineStructure, shapes: TowerShapes, elements: int = 60) -> TurbineMatrices:
    """Return the parked turbine in the six platform motions and the finite-element modes themselves, about the straight tower.

    The counterpart of `structural_matrices`, which takes ElastoDyn's polynomials and discretisation. Damping is ElastoDyn's
    rule, 2 zeta / omega times the elastic stiffness with omega of the tower without top mass. Reference: thesis
    equations 4.15 to 4.18, C57 with g in both terms.
    """
    parts = tower_matrices(structure.tower, rotor_nacelle(structure), structure.gravity, elements)
    basis = _basis(parts, shapes)
    known = [TOWER_MODES.index(n) for n in shapes.names]
    elastic = basis.T @ parts.elastic @ basis
    alone = np.sqrt(shapes.modal_stiffness / shapes.tower_mass)
    ratio = np.concatenate([np.zeros(6), 2 * structure.tower.damping_ratio[known] / alone])
    q = basis.shape[1]
    return TurbineMatrices(
        dofs=PLATFORM_DOFS + shapes.names, mass=basis.T @ parts.mass @ basis, damping=elastic * ratio,
        stiffness=elastic + basis.T @ parts.geometric @ basis, force=basis.T @ parts.weight_force, point=np.zeros(q),
        wind_force=np.zeros(q), source="tower by finite elements",
    )  # fmt: skip


def _plane_matrices(tower: Tower, rigidity, carried: float, elements: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return mass, bending stiffness and the integral of the mass above times slope squared (2 (n + 1) each), absolute nodes."""
    h = tower.length / elements
    xi, weight = (_GAUSS[0] + 1) / 2, _GAUSS[1] / 2 * h
    shape, slope, curvature = _hermite(xi, h)
    station = (np.arange(elements)[:, None] + xi) / elements
    density = np.interp(station, tower.station, tower.mass_density)
    above = carried + _mass_above(tower, station)
    local = [
        np.einsum("eg,g,gi,gj->eij", density, weight, shape, shape),
        np.einsum("eg,g,gi,gj->eij", np.interp(station, tower.station, rigidity), weight, curvature, curvature),
        np.einsum("eg,g,gi,gj->eij", above, weight, slope, slope),
    ]
    out = np.zeros((3, 2 * (elements + 1), 2 * (elements + 1)))
    index = 2 * np.arange(elements)[:, None] + np.arange(4)
    for total, part in zip(out, local, strict=True):
        np.add.at(total, (index[:, :, None], index[:, None, :]), part)
    return out[0], out[1], out[2]


def _hermite(xi: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return cubic shapes (g, 4), their slope and curvature at xi (g) of an element of length h [m]."""
    shape = np.stack(
        [1 - 3 * xi**2 + 2 * xi**3, h * (xi - 2 * xi**2 + xi**3), 3 * xi**2 - 2 * xi**3, h * (xi**3 - xi**2)], axis=1
    )
    slope = np.stack(
        [(6 * xi**2 - 6 * xi) / h, 1 - 4 * xi + 3 * xi**2, (6 * xi - 6 * xi**2) / h, 3 * xi**2 - 2 * xi], axis=1
    )
    curvature = np.stack([(12 * xi - 6) / h**2, (6 * xi - 4) / h, (6 - 12 * xi) / h**2, (6 * xi - 2) / h], axis=1)
    return shape, slope, curvature


def _mass_above(tower: Tower, station: np.ndarray) -> np.ndarray:
    """Return the tower's own mass [kg] above stations of any shape: the exact integral of the piecewise linear density."""
    s, m = tower.station, tower.mass_density
    total = np.concatenate([[0.0], np.cumsum((m[1:] + m[:-1]) / 2 * np.diff(s))])
    k = np.clip(np.searchsorted(s, station, side="right") - 1, 0, len(s) - 2)
    here = np.interp(station, s, m)
    return tower.length * (total[-1] - total[k] - (m[k] + here) / 2 * (station - s[k]))


def _tower_mass(tower: Tower, elements: int) -> float:
    """Return the tower's mass [kg] by the same quadrature as its matrices."""
    station = (np.arange(elements)[:, None] + (_GAUSS[0] + 1) / 2) / elements
    return float(
        np.sum(np.interp(station, tower.station, tower.mass_density) @ _GAUSS[1]) / 2 * tower.length / elements
    )


def _absolute(height: np.ndarray, plane: str, size: int) -> np.ndarray:
    """Return the map (2 (n + 1), size) from all degrees of freedom to absolute deflection and slope in a plane."""
    n = len(height) - 1
    out = np.zeros((2 * (n + 1), size))
    first = 6 + (2 * n if plane == "ss" else 0)
    out[2:, first : first + 2 * n] = np.eye(2 * n)
    along, turn, sign = (0, 4, 1.0) if plane == "fa" else (1, 3, -1.0)
    out[::2, along], out[::2, turn], out[1::2, turn] = 1.0, sign * height, sign
    return out


def _add_base(tower: Tower, head: RigidBody, gravity: float, mass, geometric, tower_mass: float) -> None:
    """Add to the matrices the tower's heave, and the weight that sinks as the platform turns with the base on its lever."""
    mass[2, 2] += tower_mass
    lever = gravity * (tower_mass + head.mass) * tower.base_height
    geometric[3, 3] -= lever
    geometric[4, 4] -= lever


def _head_jacobian(tower: Tower, head: RigidBody, size: int) -> np.ndarray:
    """Return translation and rotation (6, size) of the centre of mass of what stands on the tower."""
    nodes = (size - 6) // 2
    out = np.zeros((6, size))
    out[:3, :6] = point_motion(head.centre + [0.0, 0.0, tower.top_height])
    out[3:, 3:6] = np.eye(3)
    for end, along, turn in ((6 + nodes, 0, [0.0, 1.0, 0.0]), (size, 1, [-1.0, 0.0, 0.0])):
        out[along, end - 2] = 1.0
        out[:3, end - 1] = np.cross(turn, head.centre)
        out[3:, end - 1] = turn
    return out


def _plane_modes(
    parts: TowerMatrices, mass, stiffness, plane: str, count: int, floating: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies (count) and vectors (d, count) of a plane's bending modes."""
    nodes = parts.plane(plane)
    index = np.concatenate([_IN_PLANE[plane], nodes]) if floating else nodes
    here = np.ix_(index, index)
    values, vectors = _lowest(mass[here], (stiffness[here] + stiffness[here].T) / 2, _parabola(parts, plane), count + 6)
    full = np.zeros((len(mass), len(values)))
    full[index] = vectors
    strain = np.einsum("dk,de,ek->k", full, parts.elastic, full)
    if not floating and values[0] <= 0:
        raise ValueError(f"the tower buckles in the {plane} plane under the weight it carries")
    bending = np.flatnonzero((values > 0) & (strain > 0.5 * values))[:count]
    if len(bending) < count:
        raise ValueError(f"only {len(bending)} bending modes in the {plane} plane; more elements have more")
    return np.sqrt(values[bending]), full[:, bending]


def _lowest(mass, stiffness, shift: float, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest eigenvalues (k) and vectors (d, k), of unit modal mass, of stiffness against mass.

    As the largest of mass against stiffness plus shifted mass: that keeps the low modes' digits, which the highest modes
    would drown. The shift is the first mode's own size, so that free and slightly unstable motions are no trouble.
    """
    size = len(mass)
    try:
        values, vectors = eigh(mass, stiffness + shift * mass, subset_by_index=[max(0, size - count), size - 1])
    except np.linalg.LinAlgError:
        raise ValueError("the tower buckles under the weight it carries, or its platform capsizes") from None
    return 1 / values[::-1] - shift, vectors[:, ::-1] / np.sqrt(values[::-1])


def _parabola(parts: TowerMatrices, plane: str) -> float:
    """Return the squared frequency [(rad/s)2] of a tower bent as a parabola, without the weight: the size of the first mode's."""
    bent, up = np.zeros(len(parts.mass)), parts.height[1:] - parts.height[0]
    nodes = parts.plane(plane)
    bent[nodes[::2]], bent[nodes[1::2]] = up**2, 2 * up
    return float((bent @ parts.elastic @ bent) / (bent @ parts.mass @ bent))


def _shapes(parts: TowerMatrices, tower: Tower, names, frequency, vectors, clamped: bool) -> TowerShapes:
    """Return modes scaled to 1 at the top with their modal quantities."""
    count = len(names) // 2
    columns = []
    for k in range(len(names)):
        own = parts.plane(PLANES[k // count])
        top = vectors[own[-2], k]
        if abs(top) < 1e-9 * np.abs(vectors[own[::2], k]).max():
            raise ValueError(f"{names[k]} has a node at the tower top; it cannot be scaled to 1 there")
        columns.append((vectors[own, k] / top, vectors[:6, k] / top))
    nodal = np.array([c[0] for c in columns]).T
    still = np.zeros((1, len(names)))
    blank = TowerShapes(
        names=names, frequency=frequency, height=parts.height, station=(parts.height - tower.base_height) / tower.length,
        shape=np.vstack([still, nodal[::2]]), slope=np.vstack([still, nodal[1::2]]), platform=np.array([c[1] for c in columns]).T,
        modal_mass=still[0], modal_stiffness=still[0], gravity_stiffness=still[0], mass_coupling=np.zeros((6, len(names))),
        gravity_coupling=np.zeros((6, len(names))), tower_mass=still[0], clamped=clamped,
    )  # fmt: skip
    basis = _basis(parts, blank)
    mass, elastic, gravity, alone = (
        basis.T @ m @ basis for m in (parts.mass, parts.elastic, parts.geometric, parts.tower)
    )
    return replace(
        blank, modal_mass=np.diag(mass)[6:], modal_stiffness=np.diag(elastic)[6:], gravity_stiffness=np.diag(gravity)[6:],
        mass_coupling=mass[:6, 6:], gravity_coupling=gravity[:6, 6:], tower_mass=np.diag(alone)[6:],
    )  # fmt: skip


def _basis(parts: TowerMatrices, shapes: TowerShapes) -> np.ndarray:
    """Return the basis (d, 6 + k) of platform motions and mode shapes."""
    out = np.zeros((len(parts.mass), 6 + len(shapes.names)))
    out[:6, :6] = np.eye(6)
    for k, name in enumerate(shapes.names):
        own = parts.plane(name[6:8])
        out[own[::2], 6 + k], out[own[1::2], 6 + k] = shapes.shape[1:, k], shapes.slope[1:, k]
    return out
