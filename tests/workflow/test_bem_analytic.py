"""Box barges and truncated cylinders against published added mass and an eigenfunction solution of their own."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import hankel1, ive, kve

pytest.importorskip("capytaine", reason="Capytaine is not installed: pip install fowtio[bem]")

from fowtio.bem import BemSettings, capytaine_body, extrapolated, far_field, solve_frequency
from fowtio.hulls import barge_mesh, spar_mesh


def coefficients(meshes, omega, settings):
    """Return added mass and far-field damping of two meshes, extrapolated."""
    found = [solve_frequency(capytaine_body(m), omega, settings) for m in meshes]
    circle = extrapolated(*(r["circle"] for r in found))
    return extrapolated(*(r["added_mass"] for r in found)), far_field(circle, meshes[0].symmetry, omega, settings)


# Still water is a mirror: at infinite frequency of heave (potential zero there), at zero frequency of sway (no flow through it). A
# barge and its image are then a prism, here of square section 2 a x 2 a, of whose added mass the barge has half. J. N. Newman,
# Marine Hydrodynamics (1977), table 4.3: 4.754 rho a^2 per length. The ends cancel in the difference of two lengths, but for their
# influence on each other, of the order of (a / length)^2; panels of a third and a sixth of a, extrapolated: 1.5 %
@pytest.mark.parametrize(("omega", "motion"), [(np.inf, 2), (0.0, 1)])
def test_a_long_box_barge_has_the_added_mass_of_its_section(omega, motion):
    added = []
    for length in (120.0, 160.0):
        meshes = [barge_mesh(length, 20.0, 10.0, size=10 / 3, refine=k) for k in (1, 2)]
        added.append(coefficients(meshes, omega, BemSettings(density=1.0))[0][motion, motion])
    assert (added[1] - added[0]) / 40.0 == pytest.approx(4.754 / 2 * 100.0, rel=0.015)


def heave_of_a_cylinder(radius, draft, depth, omega, gravity, terms=40):
    """Return heave added mass and damping over density of a truncated vertical cylinder by matched eigenfunctions.

    Source: R. W. Yeung, Added mass and damping of a vertical cylinder in finite-depth waters, Applied Ocean Research 3 (1981) 119.
    """
    gap, ratio = depth - draft, omega**2 / gravity
    k0 = brentq(lambda k: k * np.tanh(k * depth) - ratio, 1e-9, 10 * ratio + 10 / depth)
    roots = [brentq(lambda q: q * np.sin(q * depth) + ratio * np.cos(q * depth), (m - 0.5) * np.pi / depth, m * np.pi / depth) for m in range(1, terms)]
    k = np.array([1j * k0, *roots])  # cos(i k0 z) = cosh(k0 z)
    norm = np.sqrt(0.5 * (1 + np.sin(2 * k * depth) / (2 * k * depth)))
    slope = np.array([k0 * -hankel1(1, k0 * radius) / hankel1(0, k0 * radius), *(-q * kve(1, q * radius) / kve(0, q * radius) for q in roots)])
    n = np.arange(terms)
    inner = n * np.pi / gap
    total, less = k + inner[:, None], k - inner[:, None]
    overlap = (np.sin(total * gap) / total + np.sin(less * gap) / less) / 2 / norm  # of cos(inner z) and the outer functions under the hull
    own = np.array([gap / 3 - radius**2 / (2 * gap), *(2 * gap * (-1.0) ** n[1:] / (n[1:] * np.pi) ** 2)])
    inside = np.array([0.0, *(q * ive(1, q * radius) / ive(0, q * radius) for q in inner[1:])])
    # continuity of the potential under the hull: c + own = 2 / gap overlap d; of the radial velocity: depth slope d = overlap^T inside c - wall
    wall = radius / (2 * gap) * overlap[0]
    matrix = np.diag(depth * slope) - overlap.T @ (inside[:, None] * (2 / gap) * overlap)
    d = np.linalg.solve(matrix, -overlap.T @ (inside * own) - wall)
    c = 2 / gap * overlap @ d - own
    sums = c[1:] * (-1.0) ** n[1:] * 2 * np.pi * radius * np.array([ive(1, q * radius) / (q * ive(0, q * radius)) for q in inner[1:]])
    value = np.pi * radius**2 * (gap / 2 + c[0] / 2) - np.pi * radius**4 / (8 * gap) + sums.sum()
    return value.real, omega * value.imag


@pytest.mark.parametrize("omega", [0.4, 0.7, 1.0])
def test_heave_of_a_truncated_cylinder_has_yeungs_coefficients(omega):
    radius, draft, depth, g = 10.0, 10.0, 40.0, 9.80665
    meshes = [spar_mesh([(radius, 0.0), (radius, -draft)], size=2.5, around=24, refine=k) for k in (1, 2)]
    added, damping = coefficients(meshes, omega, BemSettings(density=1.0, gravity=g, depth=depth))
    exact = heave_of_a_cylinder(radius, draft, depth, omega, g)
    # two meshes of 192 and 768 panels, extrapolated: 1 %; 40 terms of the eigenfunctions are converged to 0.3 % (below)
    assert added[2, 2] == pytest.approx(exact[0], rel=0.015)
    assert damping[2, 2] == pytest.approx(exact[1], rel=0.015)


def test_the_eigenfunctions_have_converged_and_keep_the_limit_of_a_shallow_gap():
    few, many = (heave_of_a_cylinder(10.0, 10.0, 40.0, 0.7, 9.80665, terms=t) for t in (40, 120))
    assert few == pytest.approx(many, rel=3e-3)
    # little water under a wide disc must flow out sideways: added mass pi a^4 / (8 gap), plus what the water outside adds
    assert heave_of_a_cylinder(10.0, 9.98, 10.0, 0.3, 9.80665)[0] == pytest.approx(np.pi * 1e4 / 0.16, rel=0.05)
