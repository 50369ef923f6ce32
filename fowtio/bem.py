"""Hydrodynamic coefficients of a hull by the boundary-element method, with Capytaine (the extra `bem`).

Linear potential flow: radiation and diffraction by constant panels. The error of constant flat panels is of order
1.0 to 1.4 in their size, so the coefficients of two meshes, one with half the panel sides of the other, are extrapolated.
Damping follows from the excitation by waves from all around (Haskind's relation): from the pressure on the hull it is the small
imaginary part of a large number, with three to four times the error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fowtio.errors import ModelError
from fowtio.hull_mesh import HullMesh
from model.system.haskind import far_field_damping, sector_headings

EXTRAPOLATION = 0.77
DEEP = 5.0
SECTOR_STEP = np.radians(5.0)
DOFS = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")


@dataclass(frozen=True, eq=False, kw_only=True)
class BemSettings:
    """How a hull is solved: water depth [m] (inf is deep), density [kg/m3], gravity [m/s2], headings [rad], method
    ("direct" solves for the potential, "indirect" for sources), lid against irregular frequencies.
    """

    depth: float = np.inf
    density: float = 1025.0
    gravity: float = 9.80665
    headings: tuple[float, ...] = (0.0,)
    method: str = "direct"
    lid: bool = True


def load_capytaine():
    """Return the module capytaine, quiet and on one thread; raises ModelError with the remedy when it is not installed."""
    try:
        import capytaine
    except ImportError as error:
        raise ModelError(
            'the boundary-element solver needs Capytaine, which is not installed: pip install "fowtio[bem]"'
        ) from error
    capytaine.set_logging("ERROR")
    return capytaine


@dataclass(frozen=True, eq=False, kw_only=True)
class BemBody:
    """A body to solve: Capytaine's floating body, and the symmetry of its mesh."""

    floating: object
    symmetry: str


def capytaine_body(mesh: HullMesh, *, lid: bool = True) -> BemBody:
    """Return the body of a mesh, with its symmetries, about the origin."""
    cpt = load_capytaine()

    def symmetric(panels):
        from capytaine.meshes.symmetric_meshes import ReflectionSymmetricMesh, RotationSymmetricMesh

        part = cpt.Mesh(vertices=panels.reshape(-1, 3), faces=np.arange(4 * len(panels)).reshape(-1, 4))
        if mesh.symmetry == "none":
            return part
        part = ReflectionSymmetricMesh(part, plane="xOz")
        if mesh.symmetry == "xz yz":
            return ReflectionSymmetricMesh(part, plane="yOz")
        return RotationSymmetricMesh(part, n=3) if mesh.symmetry == "three-fold xz" else part

    floating = cpt.FloatingBody(
        mesh=symmetric(mesh.part), lid_mesh=symmetric(mesh.lid) if lid and len(mesh.lid) else None,
        dofs=cpt.rigid_body_dofs(rotation_center=(0.0, 0.0, 0.0)), name="hull",
    )  # fmt: skip
    return BemBody(floating=floating, symmetry=mesh.symmetry)


def extrapolated(coarse, fine):
    """Return coefficients extrapolated to panels of no size from two meshes, the fine with half the panel sides.

    fine + EXTRAPOLATION (fine - coarse), the weight 1 / (2^p - 1) of an error of order p = 1.2, between the orders
    seen for heave (1.0) and surge (1.4) with constant panels on round columns.
    """
    return fine + EXTRAPOLATION * (np.asarray(fine) - np.asarray(coarse))


def solve_frequency(body: BemBody, omega: float, settings: BemSettings, solver=None) -> dict[str, np.ndarray]:
    """Return what one frequency [rad/s] gives, e^{+i omega t}: added_mass (6, 6) and pressure_damping (6, 6) from the pressure
    on the hull, excitation (m, 6) and circle (b, 6), the excitation at the headings that `far_field` takes.

    Frequencies 0 and inf are solved in deep water and give the added mass alone. Where k h > DEEP the water counts as deep
    (tanh k h = 1 to 1e-4): the Green function is then quicker and the same to four digits.
    """
    cpt = load_capytaine()
    solver, floating = solver or cpt.BEMSolver(method=settings.method), body.floating
    depth = _felt_depth(omega, settings)
    common = {"body": floating, "omega": omega, "water_depth": depth, "rho": settings.density, "g": settings.gravity}
    if omega == 0 or np.isinf(omega):
        results = [solver.solve(cpt.RadiationProblem(radiating_dof=d, **common), keep_details=False) for d in DOFS]
        added, damping = np.array([[r.added_mass[dof] for r in results] for dof in DOFS]), np.zeros((6, 6))
        force, headings = np.zeros((0, 6)), ()
    else:
        headings = settings.headings
        around = (*headings, *sector_headings(body.symmetry, SECTOR_STEP))
        waves = [cpt.DiffractionProblem(wave_direction=beta, **common) for beta in around]
        added, damping, force = _radiation_and_diffraction(floating, waves, omega, depth, settings, solver)
    return {
        "added_mass": (added + added.T) / 2,
        "pressure_damping": (damping + damping.T) / 2,
        "asymmetry": np.abs(added - added.T).max() / np.abs(added).max(),
        "excitation": np.conj(force[: len(headings)]),
        "circle": np.conj(force[len(headings) :]),
    }


def far_field(circle: np.ndarray, symmetry: str, omega: float, settings: BemSettings) -> np.ndarray:
    """Return the radiation damping (6, 6) that goes with the excitation all around (b, 6) of `solve_frequency`; 0 at its limits."""
    if not len(circle):
        return np.zeros((6, 6))
    return far_field_damping(
        circle, symmetry, omega, depth=_felt_depth(omega, settings), density=settings.density, gravity=settings.gravity
    )


def _felt_depth(omega: float, settings: BemSettings) -> float:
    """Return the depth that a frequency is solved in; Capytaine's Green function of finite depth errs at infinite frequency."""
    felt = 0 < omega < np.sqrt(DEEP * settings.gravity / settings.depth)
    return settings.depth if felt else np.inf


def _radiation_and_diffraction(body, waves, omega, depth, settings, solver):
    """Return added mass, damping and excitation (e^{-i omega t}) of one frequency: all right-hand sides in one solution."""
    from capytaine.bem.airy_waves import airy_waves_pressure

    panels, wet = body.mesh_including_lid, body.hull_mask
    motion = np.stack([np.sum(_motion(body, dof) * body.mesh.faces_normals, axis=1) for dof in DOFS], axis=1)
    condition = np.zeros((panels.nb_faces, 6 + len(waves)), dtype=complex)
    condition[wet, :6] = motion
    for k, wave in enumerate(waves):
        condition[:, 6 + k] = wave.boundary_condition
    matrices = solver.engine.build_matrices(
        panels, panels, free_surface=0.0, water_depth=depth, wavenumber=_wavenumber(omega, depth, settings.gravity),
        adjoint_double_layer=settings.method == "indirect",
    )  # fmt: skip
    weighted = (motion * body.mesh.faces_areas[:, None]).T
    forces = -1j * omega * settings.density * weighted @ _potential(*matrices, condition, settings.method)[wet]
    incident = -weighted @ np.stack([airy_waves_pressure(body.mesh.faces_centers, wave) for wave in waves], axis=1)
    return forces[:, :6].imag / omega, -forces[:, :6].real, (forces[:, 6:] + incident).T


def _wavenumber(omega: float, depth: float, gravity: float) -> float:
    from model.environment.airy import wavenumber

    return (
        omega**2 / gravity if np.isinf(depth) else float(np.asarray(wavenumber(np.array([omega]), depth, gravity))[0])
    )


def _motion(body, dof: str) -> np.ndarray:
    shape = body.dofs[dof]
    return shape.evaluate_motion(body.mesh) if hasattr(shape, "evaluate_motion") else shape


def _potential(single, double, condition: np.ndarray, method: str) -> np.ndarray:
    """Return the potential (p, k) on the panels of Capytaine's influence matrices for normal velocities (p, k).

    Symmetric hulls have block-circulant matrices; a discrete Fourier transform over the copies makes them block-diagonal.
    """
    if isinstance(single, np.ndarray):
        return _solved(single, double, condition, method)
    blocks = [np.asarray(m.blocks) for m in (single, double)]
    if len(blocks[0]) == 6:
        return _three_fold(*blocks, condition, method)
    shape = (2, 2) if len(blocks[0]) == 4 else (2,)
    axes, count = tuple(range(len(shape))), condition.shape[1]
    known = np.fft.fftn(condition.reshape(*shape, -1, count), axes=axes).reshape(len(blocks[0]), -1, count)
    diagonal = [np.fft.fftn(b.reshape(*shape, *b.shape[1:]), axes=axes).reshape(b.shape) for b in blocks]
    found = _solved(*diagonal, known, method)
    return np.fft.ifftn(found.reshape(*shape, -1, count), axes=axes).reshape(condition.shape)


def _solved(single, double, known, method: str) -> np.ndarray:
    """Return the potential: from sources (indirect) or from Green's second identity (direct)."""
    if method == "direct":
        return np.linalg.solve(double, single @ known)
    return single @ np.linalg.solve(double, known)


def _three_fold(single, double, condition, method: str) -> np.ndarray:
    """Return the potential on a hull with three-fold and mirror symmetry; blocks (6, n, n) are the first columns of the matrices.

    The transform over the three turns leaves a symmetric part, which the mirror splits in two, and two parts that are each
    other's mirror image, so that one factorisation serves both.
    """
    n, count = single.shape[1], condition.shape[1]
    known = np.fft.fft(condition.reshape(3, 2 * n, count), axis=0)
    w = np.exp(2j * np.pi / 3)

    def split(m):
        a, b, c, d, e, f = m
        p, q = a + c + e, b + d + f
        turned = np.empty((2 * n, 2 * n), dtype=complex)
        turned[:n, :n], turned[:n, n:] = a + w.conjugate() * c + w * e, b + w.conjugate() * f + w * d
        turned[n:, :n], turned[n:, n:] = b + w.conjugate() * d + w * f, a + w.conjugate() * e + w * c
        return np.stack([p + q, p - q]), turned

    (s0, s1), (d0, d1) = split(single), split(double)
    first, second = known[0, :n], known[0, n:]
    even, odd = _solved(s0, d0, np.stack([first + second, first - second]) / 2, method)
    mirror = np.roll(known[2], n, axis=0)
    both = _solved(s1, d1, np.concatenate([known[1], mirror], axis=1), method)
    found = np.stack([np.concatenate([even + odd, even - odd]), both[:, :count], np.roll(both[:, count:], n, axis=0)])
    return np.fft.ifft(found, axis=0).reshape(condition.shape)
