"""Hydrodynamic coefficients of a hull by the boundary-element method, with Capytaine (the extra `bem`).

Linear potential flow: radiation and diffraction by constant panels. The error of constant flat panels is of order h to h^1.4
in the panel size h, so the coefficients of two meshes, one with half the panel sides of the other, are extrapolated.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fowtio.errors import ModelError
from fowtio.hull_mesh import HullMesh

EXTRAPOLATION = 0.77
DEEP = 5.0
LEAST_KH = 0.1
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


def capytaine_body(mesh: HullMesh, *, lid: bool = True):
    """Return Capytaine's floating body of a mesh, with its symmetries, about the origin."""
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

    return cpt.FloatingBody(
        mesh=symmetric(mesh.part), lid_mesh=symmetric(mesh.lid) if lid and len(mesh.lid) else None,
        dofs=cpt.rigid_body_dofs(rotation_center=(0.0, 0.0, 0.0)), name="hull",
    )  # fmt: skip


def extrapolated(coarse, fine):
    """Return coefficients extrapolated to panels of no size from two meshes, the fine with half the panel sides.

    fine + EXTRAPOLATION (fine - coarse), the weight 1 / (2^p - 1) of an error of order p = 1.2, between the orders
    seen for heave (1.0) and surge (1.4) with constant panels on round columns.
    """
    return fine + EXTRAPOLATION * (np.asarray(fine) - np.asarray(coarse))


def solve_frequency(body, omega: float, settings: BemSettings, solver=None) -> dict[str, np.ndarray]:
    """Return added mass, damping (6, 6) and excitation (m, 6) of one frequency [rad/s], e^{+i omega t}.

    Frequencies 0 (in deep water only) and inf give the added mass alone. Where k h > DEEP the water counts as deep
    (tanh k h = 1 to 1e-4): the Green function is then quicker and the same to four digits.
    """
    cpt = load_capytaine()
    solver = solver or cpt.BEMSolver(method=settings.method)
    depth = settings.depth
    if not np.isfinite(omega) or omega == 0 or omega**2 * depth / settings.gravity > DEEP:
        depth = np.inf if not np.isinf(omega) else settings.depth
    common = dict(body=body, omega=omega, water_depth=depth, rho=settings.density, g=settings.gravity)
    radiation = [cpt.RadiationProblem(radiating_dof=dof, **common) for dof in DOFS]
    diffraction = []
    if np.isfinite(omega) and omega > 0:
        diffraction = [cpt.DiffractionProblem(wave_direction=beta, **common) for beta in settings.headings]

    def run(problem):
        return solver.solve(problem, keep_details=False, _check_wavelength=False)

    moved = [run(p) for p in radiation]
    added = np.array([[r.added_mass[dof] for r in moved] for dof in DOFS])
    damping = np.array([[r.radiation_damping[dof] for r in moved] for dof in DOFS])
    force = [[_total(run(p))[dof] for dof in DOFS] for p in diffraction]
    return {
        "added_mass": (added + added.T) / 2,
        "radiation_damping": (damping + damping.T) / 2,
        "asymmetry": np.abs(added - added.T).max() / np.abs(added).max(),
        "excitation": np.conj(np.array(force).reshape(-1, 6)),
    }


def _total(result) -> dict:
    from capytaine.bem.airy_waves import froude_krylov_force

    incident = froude_krylov_force(result.problem)
    return {dof: result.forces[dof] + incident[dof] for dof in DOFS}
