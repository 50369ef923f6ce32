"""Frames, signs, degrees of freedom and rigid-body transforms: the only place that defines them.

SI units, radians, rad/s; Re{X e^{+i omega t}}; origin on the tower axis at still water, x downwind, z up;
surge, sway, heave, roll, pitch, yaw, then structural modes; heading = direction of propagation, 0 is +x,
counter-clockwise seen from above; phase 0 is a crest at the origin.
"""

from __future__ import annotations

import numpy as np

PLATFORM_DOFS = ("surge", "sway", "heave", "roll", "pitch", "yaw")
TOWER_FORE_AFT = "tower_fa1"
DOF_UNITS = dict.fromkeys(PLATFORM_DOFS[:3], "m") | dict.fromkeys(PLATFORM_DOFS[3:], "rad") | {TOWER_FORE_AFT: "m"}


def frozen(array, dtype=float) -> np.ndarray:
    """Return a read-only copy of an array."""
    out = np.array(array, dtype=dtype)
    out.setflags(write=False)
    return out


def freeze(instance, **shapes) -> None:
    """Make the named array fields of a frozen dataclass read-only and check their shapes.

    shapes maps a field name to a tuple of lengths; a string length is a dimension that must be equal
    wherever it is named, None is any length. A field that is None stays None. Raises ValueError.
    """
    sizes: dict[str, int] = {}
    for name, shape in shapes.items():
        value = getattr(instance, name)
        if value is None:
            continue
        array = np.asarray(value)
        array = frozen(array, dtype=complex if np.iscomplexobj(array) else float)
        if array.ndim != len(shape):
            raise ValueError(f"{name} needs {len(shape)} axes, has {array.ndim}")
        for length, want in zip(array.shape, shape, strict=True):
            want = sizes.setdefault(want, length) if isinstance(want, str) else want
            if want is not None and want != length:
                raise ValueError(f"{name} has shape {array.shape}, needs {shape}")
        object.__setattr__(instance, name, array)


def skew(vector) -> np.ndarray:
    """Return the matrix S(v) with S(v) u = v x u; (..., 3) to (..., 3, 3)."""
    v = np.asarray(vector, dtype=float)
    out = np.zeros(v.shape + (3,))
    out[..., 0, 1], out[..., 0, 2] = -v[..., 2], v[..., 1]
    out[..., 1, 0], out[..., 1, 2] = v[..., 2], -v[..., 0]
    out[..., 2, 0], out[..., 2, 1] = -v[..., 1], v[..., 0]
    return out


def rotation(vector) -> np.ndarray:
    """Return the rotation matrix of a rotation vector (roll, pitch, yaw) [rad]; (..., 3) to (..., 3, 3).

    To second order in the angles this is OpenFAST's small-angle transformation (the orthogonal matrix nearest
    to 1 + S(v)), and it treats the three angles alike.
    """
    v = np.asarray(vector, dtype=float)
    angle = np.linalg.norm(v, axis=-1)[..., None, None]
    s = skew(v)
    safe = np.where(angle > 1e-8, angle, 1.0)
    first = np.where(angle > 1e-8, np.sin(safe) / safe, 1.0)
    second = np.where(angle > 1e-8, (1 - np.cos(safe)) / safe**2, 0.5)
    return np.eye(3) + first * s + second * (s @ s)


def rotation_rate(vector) -> np.ndarray:
    """Return J with d(rotation) = S(J d(vector)) rotation: the left Jacobian of the rotation vector (..., 3, 3)."""
    v = np.asarray(vector, dtype=float)
    angle = np.linalg.norm(v, axis=-1)[..., None, None]
    s = skew(v)
    safe = np.where(angle > 1e-4, angle, 1.0)
    first = np.where(angle > 1e-4, (1 - np.cos(safe)) / safe**2, 0.5)
    second = np.where(angle > 1e-4, (safe - np.sin(safe)) / safe**3, 1 / 6)
    return np.eye(3) + first * s + second * (s @ s)


def point_motion(position) -> np.ndarray:
    """Return G with (motion of a point) = G q for platform motions q; position (..., 3) [m] to (..., 3, 6)."""
    r = np.asarray(position, dtype=float)
    eye = np.broadcast_to(np.eye(3), r.shape[:-1] + (3, 3))
    return np.concatenate([eye, -skew(r)], axis=-1)


def rigid_mass(mass: float, centre, inertia=None) -> np.ndarray:
    """Return the 6x6 mass matrix about the origin of a rigid body.

    mass [kg]; centre of mass (3) [m]; inertia (3, 3) about the centre of mass [kg m2], zero for a point mass.
    """
    g = point_motion(centre)
    out = mass * g.T @ g
    if inertia is not None:
        out[3:, 3:] += np.asarray(inertia, dtype=float)
    return out


def weight_stiffness(mass: float, centre, gravity: float) -> np.ndarray:
    """Return the 6x6 stiffness of a weight about the origin: -m g z in roll and pitch, m g x and m g y in yaw.

    The moment of the weight (0, 0, -m g) about the moving origin, as the body rotates by a small rotation vector.
    """
    x, y, z = np.asarray(centre, dtype=float) * mass * gravity
    out = np.zeros((6, 6))
    out[3, 3] = out[4, 4] = -z
    out[3, 5], out[4, 5] = x, y
    return out


def move_matrix(matrix, offset) -> np.ndarray:
    """Return 6x6 matrices (..., 6, 6), known about a point, about the point that lies `offset` (3) [m] from it."""
    t = np.eye(6)
    t[:3, 3:] = skew(np.asarray(offset, dtype=float))
    return t.T @ np.asarray(matrix) @ t


def move_force(force, offset) -> np.ndarray:
    """Return forces and moments (..., 6), known about a point, about the point that lies `offset` (3) [m] from it."""
    f = np.array(force)
    f[..., 3:] = f[..., 3:] - np.cross(np.asarray(offset, dtype=float), f[..., :3])
    return f
