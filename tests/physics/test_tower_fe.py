"""Tower finite elements: textbook cantilevers, buckling, rigid bodies, OpenFAST's frequencies, ElastoDyn's polynomials."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from fowtio.read.elastodyn import read_elastodyn
from model.conventions import rigid_mass
from model.system.hydro import infinite_added_mass
from model.system.tower import TOWER_MODES, Tower
from model.system.tower_fe import (
    bending_modes,
    clamped_frequencies,
    fit_polynomials,
    modal_matrices,
    tower_matrices,
    with_modes,
)
from model.system.turbine import RigidBody, platform_matrices, rotor_nacelle, structural_matrices

VALIDATION = Path(__file__).resolve().parents[2] / "validation"
G = 9.80665
BASE, LENGTH, EI, MU = 10.0, 80.0, 5e11, 4000.0  # m, m, N m2, kg/m
EULER = np.sqrt(EI / MU) / LENGTH**2  # rad/s


def tower(**change) -> Tower:
    values = {
        "base_height": BASE, "top_height": BASE + LENGTH, "station": [0.0, 1.0], "mass_density": [MU, MU], "stiffness_fa": [EI, EI],
        "stiffness_ss": [EI, EI], "modes": [[1.0, 0, 0, 0, 0]] * 4, "damping_ratio": [0.01] * 4,
    }  # fmt: skip
    return Tower(**(values | change))


def head(mass=0.0, centre=(0.0, 0.0, 0.0), inertia=0.0) -> RigidBody:
    return RigidBody(mass=mass, centre=centre, inertia=np.asarray(inertia) * np.eye(3))


def deck(name: str):
    return read_elastodyn(VALIDATION / name, G).structure


DTU, NREL = "dtu10mw/input/ElastoDyn.dat", "oc4_deepcwind/linearisation/turbine/parked/ElastoDyn.dat"


# --- closed forms ----------------------------------------------------------------------------------------------------


def test_cantilever_of_the_textbook():
    """Roots of cos(b) cosh(b) = -1: 1.875104, 4.694091, 7.854757; cubic elements err as (b/n)^4, 1e-6 with 40 of them."""
    modes = bending_modes(tower(), head(), 0.0, count=3, elements=40)
    exact = np.array([1.87510407, 4.69409113, 7.85475744]) ** 2 * EULER
    assert np.allclose(modes.frequency, np.tile(exact, 2), rtol=3e-6)
    assert modes.names == ("tower_fa1", "tower_fa2", "tower_fa3", "tower_ss1", "tower_ss2", "tower_ss3")


@pytest.mark.parametrize(("mass", "inertia"), [(2.0, 0.0), (0.5, 0.1), (1.0, 0.4)])
def test_cantilever_with_a_rigid_body_on_top(mass, inertia):
    """Frequency equation of a beam with tip mass m mu L and tip inertia j mu L^3: the determinant of its end conditions."""

    def determinant(b):
        c, s, ch, sh = np.cos(b), np.sin(b), np.cosh(b), np.sinh(b)
        # w = A (cos - cosh) + B (sin - sinh); end: w'' = j b^4 w', w''' = -m b^4 w (lengths in L, mass in mu L)
        first = (-c - ch) - inertia * b**3 * (-s - sh), (-s - sh) - inertia * b**3 * (c - ch)
        second = (s - sh) + mass * b * (c - ch), (-c - ch) + mass * b * (s - sh)
        return first[0] * second[1] - first[1] * second[0]

    grid = np.linspace(0.1, 8, 2000)
    values = [determinant(b) for b in grid]
    roots = [brentq(determinant, grid[k], grid[k + 1]) for k in range(len(grid) - 1) if values[k] * values[k + 1] < 0]
    found = bending_modes(tower(), head(mass * MU * LENGTH, inertia=inertia * MU * LENGTH**3), 0.0, elements=40)
    assert np.allclose(found.frequency[:2], np.array(roots[:2]) ** 2 * EULER, rtol=3e-6)


def test_weight_lowers_the_frequency_to_zero_at_euler_s_load():
    """A top mass whose weight is pi2 EI / 4 L2 buckles a light column (its own 8 t of 20,000 t are a ten-thousandth of that):
    at 0.999 of it what is left of the stiffness is about 1e-3, of the frequency 0.03; at 1.001 nothing stands.
    """
    light = tower(mass_density=[100.0, 100.0])
    critical = np.pi**2 * EI / (4 * LENGTH**2) / G
    loaded, unloaded = (
        bending_modes(light, head(0.999 * critical), g, count=1, elements=12).frequency[0] for g in (G, 0.0)
    )
    assert 0.02 * unloaded < loaded < 0.04 * unloaded
    with pytest.raises(ValueError, match="buckles"):
        bending_modes(light, head(1.001 * critical), G, count=1, elements=12)


def test_a_tower_buckles_under_its_own_weight():
    """Greenhill 1881: a uniform column carries at most 7.8373 EI / L3 of its own weight per length."""
    parts = tower_matrices(tower(), head(), 1.0, elements=60)
    nodes = parts.plane("fa")
    here = np.ix_(nodes, nodes)
    load = np.linalg.eigvals(np.linalg.solve(parts.elastic[here], -parts.geometric[here])).real.max()
    assert np.isclose(1 / load, 7.8373 * EI / LENGTH**3 / MU, rtol=2e-5)  # the constant has five digits


def test_a_free_platform_and_its_tower_move_as_a_free_beam_with_a_body():
    """With a platform of no mass and no stiffness the tower is a free-free beam: b = 4.730041 for the first bending mode."""
    found = bending_modes(tower(base_height=0.0, top_height=LENGTH), head(), 0.0, platform_mass=np.zeros((6, 6)) + np.diag([1e-3] * 6),
                          platform_stiffness=np.zeros((6, 6)), count=1)  # fmt: skip
    assert np.isclose(found.frequency[0], 4.73004074**2 * EULER, rtol=3e-6)


def test_a_heavy_platform_is_a_clamped_base():
    """Mass a million times the tower's: the frequency is the clamped one to about that ratio."""
    body = head(3e5, (-1.0, 0.0, 2.0), 2e7)
    rigid = rigid_mass(1e13, [0, 0, 0], 1e17 * np.eye(3))
    floating = bending_modes(tower(), body, G, platform_mass=rigid, platform_stiffness=np.zeros((6, 6)))
    assert np.allclose(floating.frequency, bending_modes(tower(), body, G).frequency, rtol=1e-5)


def test_a_floating_base_stiffens_the_first_mode():
    """A platform that can recoil leaves less inertia in the mode, so the frequency rises (Rayleigh's quotient)."""
    body = head(3.5e5, (0.0, 0.0, 2.0), 2e7)
    platform = rigid_mass(1.4e7, [0, 0, -13.0], 1e10 * np.eye(3))
    stiffness = np.diag([7e4, 7e4, 4e6, 1.5e9, 1.5e9, 1e8])
    floating = bending_modes(tower(), body, G, platform_mass=platform, platform_stiffness=stiffness)
    assert np.all(floating.frequency[[0, 2]] > 1.05 * bending_modes(tower(), body, G).frequency[[0, 2]])
    assert np.all(floating.platform[0, :2] != 0)
    assert np.all(floating.platform[[1, 3, 5], :2] == 0)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10_000))
def test_platform_block_is_a_rigid_body(seed):
    """Without bending the tower and what it carries are a rigid body: total mass, first moments, parallel axes."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(3, 3))
    body = RigidBody(mass=3e5, centre=rng.normal(size=3), inertia=1e6 * root @ root.T)
    parts = tower_matrices(tower(), body, G, elements=4)
    rod = MU * LENGTH
    middle = BASE + LENGTH / 2
    exact = rigid_mass(rod, [0, 0, middle], rod * LENGTH**2 / 12 * np.diag([1.0, 1.0, 0.0]))
    exact = exact + rigid_mass(body.mass, body.centre + [0, 0, BASE + LENGTH], body.inertia)
    size = np.sqrt(np.outer(np.diag(exact), np.diag(exact)))
    assert np.all(np.abs(parts.mass[:6, :6] - exact) < 1e-12 * size)
    moment = -G * (rod * middle + body.mass * (BASE + LENGTH + body.centre[2]))
    assert np.allclose(np.diag(parts.geometric)[3:5], moment, rtol=1e-12)
    assert np.allclose(np.diag(parts.geometric)[[0, 1, 2, 5]], 0.0, atol=1e-6)
    assert np.isclose(parts.weight_force[2], -G * (rod + body.mass))
    assert np.isclose(parts.weight_force[4], G * body.mass * body.centre[0], atol=1e-6)


# --- other programs and published values -----------------------------------------------------------------------------


def test_dtu_10_mw_clamped():
    """OpenFAST 5.0 with TwFADOF1 and 2, parked, base clamped: 0.3941 and 2.3047 Hz; an independent code of 200 elements:
    0.39406 and 2.3039 Hz. The two differ by 0.05 %; 0.1 % is allowed.
    """
    structure = deck(DTU)
    modes = bending_modes(structure.tower, rotor_nacelle(structure), structure.gravity)
    hz = modes.frequency / (2 * np.pi)
    assert np.allclose(hz[:2], [0.39406, 2.3039], rtol=1e-4)
    assert np.allclose(hz[:2], [0.3941, 2.3047], rtol=1e-3)
    own = clamped_frequencies(structure, TOWER_MODES[:2]) / (2 * np.pi)
    assert np.allclose(own, [0.3941, 2.3047], rtol=2e-4)  # OpenFAST's digits, and the mean bend that is left out here
    assert np.isclose(clamped_frequencies(structure, ("tower_fa1",))[0] / (2 * np.pi), 0.3997, rtol=2e-4)


def test_nrel_5_mw_clamped():
    """OpenFAST 5.0, parked, base clamped: 0.3709 Hz with TwFADOF1 alone; 0.3705 and 2.587 Hz with both, four digits each."""
    structure = deck(NREL)
    assert np.isclose(clamped_frequencies(structure, ("tower_fa1",))[0] / (2 * np.pi), 0.3709, rtol=2e-4)
    assert np.allclose(clamped_frequencies(structure, TOWER_MODES[:2]) / (2 * np.pi), [0.3705, 2.587], rtol=2e-4)
    found = bending_modes(structure.tower, rotor_nacelle(structure), structure.gravity).frequency[:2] / (2 * np.pi)
    assert np.isclose(found[0], 0.3705, rtol=1e-3)
    assert 0.95 * 2.587 < found[1] < 2.587  # polynomials of another base are stiffer than the mode itself (Rayleigh)


def test_oc4_tower_on_its_platform(oc4):
    """OpenFAST's decay of the tower in still water: 2.309 s, read to about 0.1 %; radiation at that frequency moves it little."""
    structure = oc4.deck.elastodyn.structure
    mass, stiffness, _ = platform_matrices(structure.platform, structure.gravity)
    found = bending_modes(
        structure.tower, rotor_nacelle(structure), structure.gravity, platform_mass=mass + infinite_added_mass(oc4.hydro),
        platform_stiffness=stiffness + oc4.hydro.hydrostatic_stiffness + oc4.points[0].mean.mooring.stiffness,
    )  # fmt: skip
    assert np.isclose(2 * np.pi / found.frequency[0], 2.309, rtol=3e-3)


@pytest.mark.parametrize("name", [DTU, NREL])
def test_modal_matrices_agree_with_elastodyn_s_discretisation(name):
    """Fitted polynomials on ElastoDyn's nodes against the shapes on finite elements: node count and fit leave 0.6 % in what
    the second modes' curvature enters, and 1e-4 in masses and couplings of the first.
    """
    structure = deck(name)
    shapes = bending_modes(structure.tower, rotor_nacelle(structure), structure.gravity)
    ours = modal_matrices(structure, shapes)
    fitted = replace(structure, tower=with_modes(structure.tower, fit_polynomials(shapes)))
    theirs = structural_matrices(fitted, ours.dofs[6:], np.zeros(4))
    first = [0, 1, 2, 3, 4, 5, 6, 8]
    for kind, allow, allow_first in (("mass", 6e-3, 2e-4), ("damping", 6e-3, 5e-4), ("stiffness", 6e-3, 6e-4)):
        a, b = getattr(ours, kind), np.array(getattr(theirs, kind))
        if kind == "stiffness":
            b[3:5, 5] = 0.0  # yaw turns the weight's overhang: not a matter of the tower
        size = np.sqrt(np.abs(np.outer(np.diag(b), np.diag(b)))).clip(1.0)
        gap = np.abs(a - b) / size
        assert gap.max() < allow
        assert gap[np.ix_(first, first)].max() < allow_first


def test_modal_quantities_follow_the_thesis():
    """Equations 4.17 and 4.18 with the errata: M17, M57, M77 and C57 by plain sums over the shape."""
    structure = deck(DTU)
    body = rotor_nacelle(structure)
    s = bending_modes(structure.tower, body, structure.gravity, elements=200)
    z = (s.height[1:] + s.height[:-1]) / 2
    phi, top = np.interp(z, s.height, s.shape[:, 0]), s.slope[-1, 0]
    rho = np.interp(
        (z - structure.tower.base_height) / structure.tower.length,
        structure.tower.station,
        structure.tower.mass_density,
    )
    m = rho * np.diff(s.height)
    at_head, pitch = 1 + top * body.centre[2], body.inertia[1, 1] + body.mass * body.centre[0] ** 2
    up = structure.tower.top_height + body.centre[2]
    assert np.isclose(s.mass_coupling[0, 0], body.mass * at_head + m @ phi, rtol=3e-5)  # midpoint rule, 200 pieces
    assert np.isclose(s.mass_coupling[4, 0], body.mass * at_head * up + pitch * top + m @ (phi * z), rtol=3e-5)
    assert np.isclose(s.modal_mass[0], body.mass * at_head**2 + pitch * top**2 + m @ phi**2, rtol=3e-5)
    assert np.isclose(s.gravity_coupling[4, 0], -G * (body.mass * at_head + m @ phi), rtol=3e-5)
    assert np.isclose(
        s.frequency[0] ** 2 * s.modal_mass[0], s.modal_stiffness[0] + s.gravity_stiffness[0], rtol=1e-6
    )  # rounding grows as elements^4


# --- polynomials -----------------------------------------------------------------------------------------------------


@settings(max_examples=30, deadline=None)
@given(st.lists(st.floats(-5, 5), min_size=4, max_size=4))
def test_a_polynomial_is_fitted_by_itself(four):
    """A shape that is a polynomial x^2 ... x^6 with sum 1 comes back."""
    exact = np.array([*four, 1 - sum(four)])
    modes = bending_modes(tower(), head(), 0.0, count=1, elements=30)
    shape = (modes.station[:, None] ** np.arange(2, 7)) @ exact
    fit = fit_polynomials(replace(modes, shape=np.stack([shape] * 2, axis=1)))
    assert np.allclose(fit.coefficients, exact, atol=1e-9 * np.abs(exact).max().clip(1))  # conditioning of the powers
    assert np.all(fit.residual < 1e-10)


def test_fits_of_a_real_tower():
    structure = deck(DTU)
    body = rotor_nacelle(structure)
    shapes = bending_modes(structure.tower, body, structure.gravity)
    fit = fit_polynomials(shapes)
    assert np.allclose(fit.coefficients.sum(axis=1), 1.0, atol=1e-12)
    assert np.all(fit.residual < 1e-3)
    fitted = replace(structure, tower=with_modes(structure.tower, fit))
    # polynomials are a subspace: never below the finite elements but for discretisation (79 nodes, 2e-5), and close above
    ratio = clamped_frequencies(fitted, TOWER_MODES[:2]) / shapes.frequency[:2] - 1
    assert np.all((ratio > -5e-5) & (ratio < 1e-3))


def test_orthogonality():
    structure = deck(DTU)
    body = rotor_nacelle(structure)
    shapes = bending_modes(structure.tower, body, structure.gravity)
    turbine = modal_matrices(structure, shapes)
    for matrix in (turbine.mass[6:, 6:], turbine.stiffness[6:, 6:]):
        size = np.sqrt(np.outer(np.diag(matrix), np.diag(matrix)))
        assert np.abs(matrix - np.diag(np.diag(matrix))).max() < 1e-7 * size.max()


def test_misuse_is_explained():
    with pytest.raises(ValueError, match="give both, or neither"):
        bending_modes(tower(), head(), G, platform_mass=np.eye(6))
    with pytest.raises(ValueError, match="too few"):
        tower_matrices(tower(), head(), G, elements=1)
