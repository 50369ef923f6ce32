"""Mooring systems against MAP++ and MoorPy, closed forms of symmetric systems, and finite differences."""

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from model.conventions import rotation, rotation_rate
from model.system.catenary import catenary
from model.system.mooring import MooringSystem, mooring_state

REST = np.zeros(6)


def spread(count=3, fairlead=(40.868, -14.0), anchor=(837.6, -200.0), first=60.0, **change) -> MooringSystem:
    """Equal lines around the platform; by default those of the OC4 semi-submersible (NREL/TP-5000-60601)."""
    angle = np.radians(first + 360 / count * np.arange(count))
    ray = np.stack([np.cos(angle), np.sin(angle), 0 * angle], -1)
    ends = [radius * ray + [0, 0, height] for radius, height in (anchor, fairlead)]
    values = {"length": 835.35, "mass_per_length": 113.35, "diameter": 0.0766, "axial_stiffness": 753.6e6}
    values = values | {"seabed_friction": 1.0} | {k: v for k, v in change.items() if np.ndim(v) == 0}
    one = {"depth": values.pop("depth", 200.0), "gravity": 9.80665, "density": 1025.0}
    return MooringSystem(
        point_names=[f"{kind}{i + 1}" for kind in ("anchor", "fairlead") for i in range(count)],
        point_kind=["fixed"] * count + ["vessel"] * count,
        position=np.concatenate(ends),
        line_names=[f"line{i + 1}" for i in range(count)],
        end_a=np.arange(count),
        end_b=np.arange(count) + count,
        **{name: np.full(count, value) for name, value in values.items()},
        **one,
    )


OC4 = spread()
OPERATING = np.array([8.278, 0.0389, -0.038, *np.radians([0.20072, 3.3121, 0.0808])])


def differences(system, offset, length_step=1e-3, angle_step=1e-5):
    """-dF/dq, dT/dq and dTa/dq by central differences of second order with one Richardson step (error step^4)."""
    steps = np.array([length_step] * 3 + [angle_step] * 3)
    states = [mooring_state(system, offset + f * np.diag(steps)) for f in (-2, -1, 1, 2)]
    out = []
    for name in ("force", "fairlead_tension", "anchor_tension"):
        a, b, c, d = (getattr(s, name) for s in states)
        out.append(((a - d + 8 * (c - b)) / (12 * steps[:, None])).T)
    return -out[0], out[1], out[2]


def check_derivatives(system, offset, tolerance=1e-6):
    """Compare block by block, so that rotations (large in N m/rad) do not hide translations."""
    state = mooring_state(system, offset)
    exact = (state.stiffness, state.tension_gradient, state.anchor_tension_gradient)
    for analytic, numeric in zip(exact, differences(system, offset), strict=True):
        rows = ([slice(0, 3), slice(3, 6)]) if len(analytic) == 6 and analytic is exact[0] else [slice(None)]
        for row in rows:
            for column in (slice(0, 3), slice(3, 6)):
                size = max(np.abs(analytic[row, column]).max(), 1.0)
                np.testing.assert_allclose(numeric[row, column], analytic[row, column], atol=tolerance * size)


def test_tensions_match_map_at_rest_and_at_the_operating_point():
    """OpenFAST with MAP++: five and four digits are printed; the deck rounds positions to 1 mm (8e-5 of a tension)."""
    rest = mooring_state(OC4, REST)
    np.testing.assert_allclose(rest.fairlead_tension, 1.1072e6, rtol=2e-4)
    loaded = mooring_state(OC4, OPERATING)
    np.testing.assert_allclose(loaded.fairlead_tension, [0.9397e6, 1.6160e6, 0.9421e6], rtol=2e-4)


def test_surge_stiffness_matches_the_linearisation_of_map():
    """7.0748e4 N/m is OpenFAST's, linearised numerically at a slightly displaced equilibrium: 0.1 %."""
    assert mooring_state(OC4, REST).stiffness[0, 0] == pytest.approx(7.0748e4, rel=1e-3)


def test_forces_balance_the_suspended_weight():
    """Vertical: what hangs; the rest lies on the seabed. Moments and horizontal forces vanish by symmetry."""
    s = mooring_state(OC4, REST)
    hanging = (OC4.weight_per_length * (OC4.length - s.grounded_length)).sum()
    assert s.force[2] == pytest.approx(-hanging, rel=1e-12)
    assert np.abs(np.delete(s.force, 2)).max() < 1e-6 * hanging  # newtons and newton metres of rounding


def test_displaced_moment_is_about_the_displaced_reference_point():
    """Each fairlead's force crossed with its rotated arm, summed by hand."""
    s = mooring_state(OC4, OPERATING)
    body = OC4.position[3:]
    arms = body @ rotation(OPERATING[3:]).T
    way = OC4.position[:3] - (OPERATING[:3] + arms)
    horizontal = way[:, :2] / np.hypot(way[:, 0], way[:, 1])[:, None] * s.fairlead_horizontal[:, None]
    pull = np.column_stack([horizontal, -s.fairlead_vertical])
    np.testing.assert_allclose(s.force, np.r_[pull.sum(axis=0), np.cross(arms, pull).sum(axis=0)], rtol=1e-9, atol=1e-3)


@pytest.mark.parametrize("count", [3, 4, 5, 8])
@pytest.mark.parametrize("friction", [0.0, 1.0])
def test_symmetric_catenary_system_has_the_closed_form(count, friction):
    """n equal lines at rest; with fairlead radius R and depth D, plane stiffness k and k_y = H / l:

    K11 = n/2 (k11 + k_y), K33 = n k22, K66 = n (k_y R^2 + H R), K15 = n/2 (R k12 - D (k11 + k_y)), K51 with k21, and
    K55 = n/2 (R^2 k22 - D R (k12 + k21) + D^2 (k11 + k_y) + H R) + n V D, from the motion of each fairlead
    (R cos, R sin, -D); H R and V D are the moments of the pretension as the fairlead turns.
    """
    system = spread(count, seabed_friction=friction)
    s = mooring_state(system, REST)
    h, v, r, d, n = s.fairlead_horizontal[0], s.fairlead_vertical[0], 40.868, 14.0, count
    line = catenary(837.6 - r, 200.0 - d, 835.35, system.weight_per_length[0], 753.6e6, friction)
    (k11, k12), (k21, k22) = line.stiffness
    shear = k11 + h / (837.6 - r)
    expected = np.diag([n / 2 * shear, n / 2 * shear, n * k22, 0, 0, n * r * (h / (837.6 - r) * r + h)])
    expected[3, 3] = expected[4, 4] = n / 2 * (r**2 * k22 - d * r * (k12 + k21) + d**2 * shear + h * r) + n * v * d
    expected[0, 4], expected[4, 0] = n / 2 * (r * k12 - d * shear), n / 2 * (r * k21 - d * shear)
    expected[1, 3], expected[3, 1] = -expected[0, 4], -expected[4, 0]
    np.testing.assert_allclose(s.stiffness[:3, :3], expected[:3, :3], atol=1e-10 * expected[0, 0])
    np.testing.assert_allclose(s.stiffness, expected, atol=1e-10 * expected[5, 5])
    np.testing.assert_allclose(s.stiffness[:3, 3:], expected[:3, 3:], rtol=1e-9, atol=1e-6 * abs(expected[0, 4]))


def test_slack_lines_only_weigh():
    """Lines longer than their way along the seabed: no horizontal force, no surge stiffness, equal vertical force."""
    s = mooring_state(spread(length=990.0), REST)
    assert np.all(s.fairlead_horizontal == 0)
    np.testing.assert_allclose(s.stiffness[0], 0, atol=1e-9)
    assert s.force[2] == pytest.approx(-3 * OC4.weight_per_length[0] * 186.0, rel=1e-3)  # stretch of 8e-5


OFFSETS = st.tuples(*[st.floats(-1, 1) for _ in range(6)]).map(lambda q: np.array(q) * [15, 15, 4, 0.2, 0.2, 0.4])


@settings(max_examples=40, deadline=None)
@given(OFFSETS, st.integers(1, 6), st.floats(825.0, 850.0), st.sampled_from([0.0, 0.5, 1.0]))
def test_stiffness_and_tension_gradients_are_derivatives(offset, count, length, friction):
    """At rest and far from it; 1e-6 as required of the stiffness, differences of fourth order are good to 1e-8."""
    system = spread(count, length=length, seabed_friction=friction)
    for q in (REST, offset):
        check_derivatives(system, q)


@settings(max_examples=25, deadline=None)
@given(OFFSETS, st.floats(0, 2 * np.pi))
def test_turning_everything_turns_the_force(offset, angle):
    """Anchors, platform offset and force turned about the vertical together: physics has no preferred heading."""
    turn = rotation(np.array([0, 0, angle]))
    # the attitude turned as a frame is turn R turn', whose rotation vector is the turned one
    turned_offset = np.r_[turn @ offset[:3], turn @ offset[3:]]
    one, two = mooring_state(OC4, offset), mooring_state(spread(first=60 + np.degrees(angle)), turned_offset)
    np.testing.assert_allclose(two.force[:3], turn @ one.force[:3], atol=1e-6 * np.abs(one.force[:3]).max())
    np.testing.assert_allclose(two.force[3:], turn @ one.force[3:], atol=1e-6 * np.abs(one.force).max())
    np.testing.assert_allclose(two.fairlead_tension, one.fairlead_tension, rtol=1e-9)


def test_work_around_a_closed_path_vanishes_without_friction():
    """A frictionless elastic system is conservative: curl F = 0 in translations and spatial rotations.

    Spatial rotations do not commute, [X_i, X_j] = -e_ijk X_k, so K_ij - K_ji = -e_ijk M_k among them.
    """
    s = mooring_state(spread(seabed_friction=0.0), OPERATING)
    left = s.stiffness.copy()
    left[:, 3:] = left[:, 3:] @ np.linalg.inv(rotation_rate(OPERATING[3:]))
    moment = s.force[3:]
    skew = np.array([[0, -moment[2], moment[1]], [moment[2], 0, -moment[0]], [-moment[1], moment[0], 0]])
    np.testing.assert_allclose(left[:3, :3], left[:3, :3].T, rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(left[3:, :3], left[:3, 3:].T, rtol=1e-9, atol=1e-3)
    gap = left[3:, 3:] - left[3:, 3:].T
    np.testing.assert_allclose(gap, skew, atol=1e-9 * np.abs(left).max())


def as_moorpy(system):
    """The same system in MoorPy 1.2.1 (which drops seabed friction in a System)."""
    moorpy = pytest.importorskip("moorpy")
    other = moorpy.System(depth=system.depth, rho=system.density, g=system.gravity)
    other.addBody(-1, np.zeros(6))
    for i, kind in enumerate(system.point_kind):
        code = {"fixed": 1, "vessel": 1, "connect": 0}[kind]
        own = {"m": system.point_mass[i], "v": system.point_volume[i], "fExt": np.array(system.point_force[i])}
        other.addPoint(code, np.array(system.position[i]), **own)
        if kind == "vessel":
            other.bodyList[0].attachPoint(i + 1, np.array(system.position[i]))
    for i, name in enumerate(system.line_names):
        kind = {"d_vol": system.diameter[i], "m": system.mass_per_length[i], "w": system.weight_per_length[i]}
        other.lineTypes[name] = kind | {"EA": system.axial_stiffness[i], "name": name}
        a, b = int(system.end_a[i]) + 1, int(system.end_b[i]) + 1
        other.addLine(float(system.length[i]), name, pointA=a, pointB=b)
    other.initialize()
    return other


def check_against_moorpy(system, offset):
    """Forces, tensions at both ends and the full 6x6 (at zero rotation the conventions agree) within 0.1 %."""
    other = as_moorpy(system)
    other.bodyList[0].setPosition(np.array(offset))
    other.solveEquilibrium(tol=1e-5)
    s = mooring_state(system, offset)
    np.testing.assert_allclose(s.fairlead_tension, [line.TB for line in other.lineList], rtol=1e-3)
    np.testing.assert_allclose(s.anchor_tension, [line.TA for line in other.lineList], rtol=1e-3)
    force = other.bodyList[0].getForces(lines_only=True)
    np.testing.assert_allclose(s.force[:3], force[:3], atol=1e-3 * np.abs(force[:3]).max())
    np.testing.assert_allclose(s.force[3:], force[3:], atol=1e-3 * max(np.abs(force[3:]).max(), np.abs(force).max()))
    stiffness = other.getCoupledStiffnessA(lines_only=True)
    for rows in (slice(0, 3), slice(3, 6)):
        for columns in (slice(0, 3), slice(3, 6)):
            theirs = stiffness[rows, columns]
            atol = 1e-3 * max(np.abs(theirs).max(), 1e-3 * np.abs(stiffness[rows]).max())
            np.testing.assert_allclose(s.stiffness[rows, columns], theirs, atol=atol)


@pytest.mark.parametrize("offset", [REST, np.array([5.0, 0, 0, 0, 0, 0]), np.array([-3.0, 4.0, 1.0, 0, 0, 0])])
def test_agrees_with_moorpy(offset):
    check_against_moorpy(spread(seabed_friction=0.0), offset)


@pytest.mark.parametrize("surge", [0.0, 5.0])
def test_friction_agrees_with_the_catenary_of_moorpy(surge):
    """Its catenary function knows friction; the upwind line, moved along its own direction."""
    solve = pytest.importorskip("moorpy.Catenary").catenary
    s = mooring_state(OC4, np.array([surge, 0, 0, 0, 0, 0]))
    found = solve(837.6 - 40.868 + surge, 186.0, 835.35, 753.6e6, OC4.weight_per_length[1], CB=1.0)
    assert s.fairlead_horizontal[1] == pytest.approx(-found[2], rel=1e-3)
    assert s.fairlead_vertical[1] == pytest.approx(-found[3], rel=1e-3)
    assert s.anchor_horizontal[1] == pytest.approx(found[0], rel=1e-3)


def test_many_offsets_at_once_equal_one_by_one():
    offsets = np.random.default_rng(3).normal(size=(4, 5, 6)) * [10, 10, 1, 0.05, 0.05, 0.1]
    together = mooring_state(OC4, offsets)
    alone = mooring_state(OC4, offsets[2, 3])
    assert together.stiffness.shape == (4, 5, 6, 6)
    for name in ("force", "stiffness", "tension_gradient", "grounded_length", "point_position"):
        np.testing.assert_allclose(getattr(together, name)[2, 3], getattr(alone, name), rtol=1e-10, atol=1e-3)


def test_one_offset_is_quick():
    """Below half a millisecond on an idle machine; the bound leaves room for a busy one."""
    mooring_state(OC4, REST)
    best = np.inf
    for _ in range(5):
        start = time.perf_counter()
        for _ in range(20):
            mooring_state(OC4, OPERATING)
        best = min(best, (time.perf_counter() - start) / 20)
    assert best < 2e-3


def test_wrong_input_is_named():
    with pytest.raises(ValueError, match=r"line line2: the line cannot reach"):
        mooring_state(OC4, np.array([1000.0, 0, 0, 0, 0, 0]))
    with pytest.raises(ValueError, match=r"offset has shape \(3,\)"):
        mooring_state(OC4, np.zeros(3))
    with pytest.raises(ValueError, match="anchor1, anchor2, anchor3 is below the seabed"):
        spread(anchor=(837.6, -210.0))
    with pytest.raises(ValueError, match="line line1, line2, line3: length and axial stiffness"):
        spread(length=0.0)
