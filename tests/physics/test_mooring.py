"""Mooring systems against MAP++ and MoorPy, closed forms of symmetric systems, and finite differences."""

import time
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from model.conventions import rotation, rotation_rate
from model.system.catenary import catenary
from model.system.mooring import MooringSystem, force_offset_curve, line_profiles, mooring_state

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


def joined(count, points, lines, **change) -> MooringSystem:
    """Equal groups of points (kind, radius, sideways, height, mass, volume) and lines (a, b, length, properties)."""
    angle = np.radians(60 + 360 / count * np.arange(count))
    names, kinds, places, masses, volumes, ends, rows = [], [], [], [], [], [], []
    for i, phi in enumerate(angle):
        turn = np.array([[np.cos(phi), -np.sin(phi), 0], [np.sin(phi), np.cos(phi), 0], [0, 0, 1]])
        for j, (kind, *place, mass, volume) in enumerate(points):
            names.append(f"{kind}{i + 1}{j + 1}")
            kinds.append(kind)
            places.append(turn @ place)
            masses.append(mass)
            volumes.append(volume)
        for a, b, *values in lines:
            ends.append((a + i * len(points), b + i * len(points)))
            rows.append(values)
    length, mass, diameter, stiffness, friction = np.array(rows, dtype=float).T
    values = {
        "point_names": names,
        "point_kind": kinds,
        "position": places,
        "line_names": [f"line{i + 1}" for i in range(len(rows))],
        "end_a": [a for a, _ in ends],
        "end_b": [b for _, b in ends],
        "length": length,
        "mass_per_length": mass,
        "diameter": diameter,
        "axial_stiffness": stiffness,
        "seabed_friction": friction,
        "point_mass": masses,
        "point_volume": volumes,
        "depth": 200.0,
        "gravity": 9.80665,
        "density": 1025.0,
    }
    return MooringSystem(**(values | change))


CHAIN, GROUND = (113.35, 0.0766, 753.6e6, 1.0), (300.0, 0.15, 1.5e9, 0.7)
ROPE, NEUTRAL, FLOATING = (20.0, 0.15, 6e7, 0.0), (1025 * np.pi / 4 * 0.15**2, 0.15, 6e7, 0.0), (14.0, 0.16, 6e7, 0.0)
TENDON = (1000.0, 0.6, 8e9, 0.0)
ANCHOR, FAIRLEAD = ("fixed", 837.6, 0.0, -200.0, 0.0, 0.0), ("vessel", 40.868, 0.0, -14.0, 0.0, 0.0)
SIDES = [("vessel", 40.0, y, -14.0, 0.0, 0.0) for y in (-10.0, 10.0)]

# every kind of line and joint
KINDS = {
    "catenary": joined(3, [ANCHOR, FAIRLEAD], [(0, 1, 835.35, *CHAIN)]),
    "uplift": joined(3, [ANCHOR, FAIRLEAD], [(0, 1, 822.0, *CHAIN)]),
    "taut rope": joined(4, [("fixed", 300.0, 0, -200.0, 0, 0), FAIRLEAD], [(0, 1, 310.0, *ROPE)]),
    "neutral rope": joined(4, [("fixed", 300.0, 0, -200.0, 0, 0), FAIRLEAD], [(0, 1, 310.0, *NEUTRAL)]),
    "floating rope": joined(4, [("fixed", 300.0, 0, -200.0, 0, 0), FAIRLEAD], [(0, 1, 330.0, *FLOATING)]),
    "tendons": joined(
        3, [("fixed", 30.0, 0, -200.0, 0, 0), ("vessel", 30.0, 0, -30.0, 0, 0)], [(0, 1, 169.8, *TENDON)]
    ),
    "slack vertical": joined(3, [("fixed", 40.868, 0, -200.0, 0, 0), FAIRLEAD], [(0, 1, 240.0, *CHAIN)]),
    "clump weight": joined(
        3, [ANCHOR, ("connect", 240.0, 0, -120.0, 17e3, 2.0), FAIRLEAD], [(0, 1, 605.0, *CHAIN), (1, 2, 230.35, *CHAIN)]
    ),
    "chain and rope": joined(
        3, [ANCHOR, ("connect", 240.0, 0, -120.0, 0, 0), FAIRLEAD], [(0, 1, 605.0, *GROUND), (1, 2, 225.0, *ROPE)]
    ),
    "delta lines": joined(
        3,
        [ANCHOR, ("connect", 95.0, 0, -40.0, 500.0, 0.1), *SIDES],
        [(0, 1, 780.0, *CHAIN), (1, 2, 58.0, *CHAIN), (1, 3, 58.0, *CHAIN)],
    ),
    "buoy": joined(
        3,
        [ANCHOR, ("connect", 240.0, 0, -120.0, 0, 0), ("connect", 140.0, 0, -60.0, 2e3, 60.0), FAIRLEAD],
        [(0, 1, 605.0, *CHAIN), (1, 2, 120.0, *ROPE), (2, 3, 115.0, *NEUTRAL)],
    ),
    "resting joint": joined(
        3, [ANCHOR, ("connect", 637.0, 0, -200.0, 5e3, 1.0), FAIRLEAD], [(0, 1, 200.0, *CHAIN), (1, 2, 635.35, *CHAIN)]
    ),
    "lines on the vessel": joined(
        3, [ANCHOR, FAIRLEAD, ("vessel", 20.0, 5.0, -5.0, 0, 0)], [(0, 1, 835.35, *CHAIN), (2, 1, 45.0, *CHAIN)]
    ),
    "line between free points": joined(
        3,
        [ANCHOR, ("connect", 97.0, -10.0, -45.0, 0, 0), ("connect", 97.0, 10.0, -45.0, 0, 0), *SIDES],
        [
            (0, 1, 780.0, *CHAIN),
            (1, 2, 25.0, *CHAIN),
            (0, 2, 780.0, *CHAIN),
            (1, 3, 64.0, *CHAIN),
            (4, 2, 64.0, *CHAIN),
        ],
    ),
    "fairlead first": joined(3, [ANCHOR, FAIRLEAD], [(1, 0, 835.35, *CHAIN)]),
    "sag on the seabed": joined(
        3,
        [ANCHOR, ("connect", 437.0, 0, -160.0, 3e3, 30.0), FAIRLEAD],
        [(0, 1, 410.0, *CHAIN), (1, 2, 470.0, *CHAIN)],
    ),
}
OC4 = spread()
OPERATING = np.array([8.278, 0.0389, -0.038, *np.radians([0.20072, 3.3121, 0.0808])])


def differences(system, offset):
    """-dF/dq, dT/dq and dTa/dq by central differences of fourth order.

    Of three steps each entry takes the one whose second-order estimates at h and 2 h differ least: long steps meet the
    kinks where a line lifts off or friction ends, short ones the rounding of positions (1e-13 m of some MN/m).
    """
    steps = np.array([3e-2] * 3 + [5e-4] * 3) * np.array([1, 0.2, 0.04])[:, None]
    moves = np.array([-2, -1, 1, 2])[:, None, None, None] * (steps[:, :, None] * np.eye(6))
    state = mooring_state(system, offset + moves)
    lying = state.grounded_length > 0
    ways = (
        lying,
        lying & (state.fairlead_horizontal > 0),
        state.anchor_tension > 0,
        state.point_position[..., 2] <= -200,
    )
    assume(all(np.all(way[:, 2] == way[:1, 2, :1]) for way in ways))  # no kink within millimetres
    out = []
    for name in ("force", "fairlead_tension", "anchor_tension"):
        a, b, c, d = getattr(state, name)
        near, far = (c - b) / (2 * steps[..., None]), (d - a) / (4 * steps[..., None])
        best = np.abs(near - far).argmin(axis=0)
        out.append(np.take_along_axis((4 * near - far) / 3, best[None], axis=0)[0].T)
    return -out[0], out[1], out[2]


def check_derivatives(system, offset, tolerance=1e-6):
    """Compare block by block, so that rotations (in N m and per rad) do not hide translations.

    Blocks of moments or per radian that nearly vanish are held to the translations: their arms are metres.
    """
    state = mooring_state(system, offset)
    exact = (state.stiffness[:3], state.stiffness[3:], state.tension_gradient, state.anchor_tension_gradient)
    force, *tensions = differences(system, offset)
    for analytic, numeric in zip(exact, (force[:3], force[3:], *tensions), strict=True):
        for column in (slice(0, 3), slice(3, 6)):
            floor = state.stiffness[:3] if analytic.shape == (3, 6) else analytic
            size = max(np.abs(analytic[:, column]).max(), np.abs(floor[:, :3]).max(), 1.0)
            np.testing.assert_allclose(numeric[:, column], analytic[:, column], atol=tolerance * size)


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


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=5, deadline=None)
@given(OFFSETS)
def test_derivatives_of_every_kind(kind, offset):
    """Stiffness and both tension gradients at rest and displaced, with the free points following."""
    if kind == "tendons":
        offset = offset * [1, 1, 0.02, 0.02, 0.02, 1]  # else they go slack
    for q in (REST, offset):
        check_derivatives(KINDS[kind], q)


@pytest.mark.parametrize("kind", KINDS)
def test_free_points_are_in_balance(kind):
    """Force on the platform plus what the anchors and the seabed hold equals the weight of everything."""
    system = KINDS[kind]
    s = mooring_state(system, OPERATING * [1, 1, 1, 0.1, 0.1, 1])
    free = np.array([k == "connect" for k in system.point_kind])
    pull = np.zeros((len(free), 3))
    way = s.point_position[system.end_b] - s.point_position[system.end_a]
    along = way[:, :2] / np.maximum(np.hypot(way[:, 0], way[:, 1]), 1e-9)[:, None]
    np.add.at(pull, system.end_a, np.column_stack([along * s.anchor_horizontal[:, None], s.anchor_vertical]))
    np.add.at(pull, system.end_b, np.column_stack([-along * s.fairlead_horizontal[:, None], -s.fairlead_vertical]))
    rest = (pull + system.point_load)[free]
    size = s.fairlead_tension.max()
    on_seabed = s.point_position[free, 2] <= -200
    assert np.all(rest[on_seabed, 2] <= 0)  # the seabed carries these
    rest[on_seabed, 2] = 0
    assert np.abs(rest).max(initial=0) < 1e-9 * size
    vessel = np.array([k == "vessel" for k in system.point_kind])
    np.testing.assert_allclose(s.force[:3], pull[vessel].sum(axis=0), atol=1e-9 * size)


@pytest.mark.parametrize("kind", ["clump weight", "delta lines", "buoy", "resting joint", "sag on the seabed"])
@settings(max_examples=5, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_the_equilibrium_does_not_depend_on_where_one_starts(kind, seed):
    """The energy is convex, so there is one equilibrium; found from joints thrown about by a hundred metres."""
    system = KINDS[kind]
    rng = np.random.default_rng(seed)
    start = system.position + rng.normal(size=(20,) + system.position.shape) * 100
    found, known = mooring_state(system, np.zeros((20, 6)), start), mooring_state(system, REST)
    np.testing.assert_allclose(found.point_position, np.broadcast_to(known.point_position, start.shape), atol=1e-6)
    np.testing.assert_allclose(
        found.fairlead_tension, np.broadcast_to(known.fairlead_tension, (20, len(system.length))), rtol=1e-8
    )


@pytest.mark.parametrize("friction", [0.0, 1.0])
@pytest.mark.parametrize("cut", [150.0, 230.0, 400.0, 700.0])
def test_cutting_a_line_in_two_changes_nothing(cut, friction):
    """A weightless joint, hanging or on the seabed, leaves forces, stiffness and tension as they were.

    With friction a joint on the seabed may turn sideways as the rest of the grounded line may not: no stiffness then.
    """
    one = spread(seabed_friction=friction)
    s = mooring_state(one, OPERATING)
    radius, _, height = [np.interp(cut, np.linspace(0, 835.35, 4001), c) for c in line_profiles(one, s, 4001)[0][1].T]
    points = [ANCHOR, ("connect", abs(radius), 0.0, max(height, -200.0), 0.0, 0.0), FAIRLEAD]
    chain = (*CHAIN[:3], friction)
    two = joined(3, points, [(0, 1, cut, *chain), (1, 2, 835.35 - cut, *chain)])
    t = mooring_state(two, OPERATING)
    # 1e-7: the tension of a joint in balance to 1e-13 m of a chain of 4 MN/m
    np.testing.assert_allclose(t.force, s.force, rtol=1e-7)
    np.testing.assert_allclose(t.fairlead_tension[1::2], s.fairlead_tension, rtol=1e-7)
    np.testing.assert_allclose(t.anchor_tension[::2], s.anchor_tension, rtol=1e-7)
    if friction == 0:
        np.testing.assert_allclose(t.stiffness, s.stiffness, atol=1e-7 * np.abs(s.stiffness).max())
        gradient = s.tension_gradient
        np.testing.assert_allclose(t.tension_gradient[1::2], gradient, atol=1e-6 * np.abs(gradient).max())


@pytest.mark.parametrize("count", [3, 4, 6])
@pytest.mark.parametrize("reach", [0.0, 60.0, 220.0])
def test_symmetric_taut_system_has_the_closed_form(count, reach):
    """n weightless lines at inclination a, with tension T, length L', spring K = EA / L, fairlead radius R, depth D:

    K11 = n/2 (T/L' (1 + sin^2) + K cos^2), K33 = n (K sin^2 + T/L' cos^2), K66 = n T R / L' (R + L' cos),
    K15 = -n (T/2L' (D + D sin^2 + R sin cos) + K/2 (D cos^2 - R sin cos)),
    K55 = n (T (D sin + R cos / 2) + T/2L' ((R cos + D sin)^2 + D^2) + K/2 (D cos - R sin)^2);
    vertical (reach 0): n T/L', n K, n T R^2 / L', -n T D / L', n (T D^2 / L' + K R^2 / 2 + T D).
    """
    r, d, height, ea = 30.0, 20.0, 180.0, 1e9
    chord = np.hypot(reach, height)
    length = chord / 1.002
    points = [("fixed", r + reach, 0.0, -200.0, 0, 0), ("vessel", r, 0.0, -d, 0, 0)]
    s = mooring_state(joined(count, points, [(0, 1, length, *NEUTRAL[:2], ea, 0.0)]), REST)
    spring, tension, sine, cosine = ea / length, 0.002 * ea, height / chord, reach / chord
    across, n = tension / chord, count
    expected = np.zeros((6, 6))
    expected[0, 0] = expected[1, 1] = n / 2 * (across * (1 + sine**2) + spring * cosine**2)
    expected[2, 2] = n * (spring * sine**2 + across * cosine**2)
    shear = across / 2 * (d + d * sine**2 + r * sine * cosine) + spring / 2 * (d * cosine**2 - r * sine * cosine)
    expected[0, 4] = expected[4, 0] = -n * shear
    expected[1, 3] = expected[3, 1] = n * shear
    lean = across / 2 * ((r * cosine + d * sine) ** 2 + d**2) + spring / 2 * (d * cosine - r * sine) ** 2
    expected[3, 3] = expected[4, 4] = n * (tension * (d * sine + r * cosine / 2) + lean)
    expected[5, 5] = n * across * r * (r + chord * cosine)
    np.testing.assert_allclose(s.fairlead_tension, tension, rtol=1e-9)
    np.testing.assert_allclose(s.stiffness, expected, atol=1e-9 * expected[4, 4])
    np.testing.assert_allclose(s.stiffness[:3, :3], expected[:3, :3], atol=1e-9 * expected[2, 2])
    np.testing.assert_allclose(s.force[2], -n * tension * sine, rtol=1e-9)


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
    """Forces, tensions at both ends and the full 6x6 (at zero rotation the conventions agree) within 0.01 %.

    MoorPy stops iterating a line at 1e-6 of its size, which leaves about 1e-6 in tensions and 1e-5 in the stiffness.
    """
    other = as_moorpy(system)
    other.bodyList[0].setPosition(np.array(offset))
    other.solveEquilibrium(tol=1e-5)
    s = mooring_state(system, offset)
    np.testing.assert_allclose(s.fairlead_tension, [line.TB for line in other.lineList], rtol=1e-4)
    np.testing.assert_allclose(s.anchor_tension, [line.TA for line in other.lineList], rtol=1e-4)
    force = other.bodyList[0].getForces(lines_only=True)
    np.testing.assert_allclose(s.force[:3], force[:3], atol=1e-4 * np.abs(force[:3]).max())
    np.testing.assert_allclose(s.force[3:], force[3:], atol=1e-4 * max(np.abs(force[3:]).max(), np.abs(force).max()))
    stiffness = other.getCoupledStiffnessA(lines_only=True)
    for rows in (slice(0, 3), slice(3, 6)):
        for columns in (slice(0, 3), slice(3, 6)):
            theirs = stiffness[rows, columns]
            atol = 1e-4 * max(np.abs(theirs).max(), 1e-3 * np.abs(stiffness[rows]).max())
            np.testing.assert_allclose(s.stiffness[rows, columns], theirs, atol=atol)


@pytest.mark.parametrize("offset", [REST, np.array([5.0, 0, 0, 0, 0, 0]), np.array([-3.0, 4.0, 1.0, 0, 0, 0])])
def test_agrees_with_moorpy(offset):
    check_against_moorpy(spread(seabed_friction=0.0), offset)


@pytest.mark.parametrize("kind", ["clump weight", "tendons", "delta lines", "uplift"])
@pytest.mark.parametrize("surge", [5.0, 8.0])  # not upright: MoorPy loses digits in nearly vertical lines
def test_joints_and_tendons_agree_with_moorpy(kind, surge):
    system = replace(KINDS[kind], seabed_friction=np.zeros(len(KINDS[kind].length)))
    check_against_moorpy(system, np.array([surge, 0, 0, 0, 0, 0]))


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


def test_designs_at_once_equal_one_by_one():
    """Leading axes on lengths and positions, against offsets on an axis of their own."""
    system = KINDS["clump weight"]
    longer = system.length + np.array([0.0, 1.0, -2.0])[:, None]
    deeper = np.array(np.broadcast_to(system.position, (3, *system.position.shape)))
    deeper[1, 2::3, 2] -= 3.0
    offsets = np.stack([REST, OPERATING])
    together = mooring_state(replace(system, length=longer, position=deeper), offsets[:, None])
    assert together.stiffness.shape == (2, 3, 6, 6)
    for i in range(2):
        for j in range(3):
            alone = mooring_state(replace(system, length=longer[j], position=deeper[j]), offsets[i])
            np.testing.assert_allclose(together.force[i, j], alone.force, rtol=1e-9, atol=1)
            np.testing.assert_allclose(together.tension_gradient[i, j], alone.tension_gradient, rtol=1e-6, atol=1)


def test_force_offset_curve_is_the_work_of_the_stiffness():
    """Starts at zero, its slope is K11 and it grows faster than linearly; the force is that of mooring_state."""
    offsets = np.linspace(-10, 10, 41)
    force, state = force_offset_curve(OC4, 0.0, offsets)
    assert force[20] == pytest.approx(0, abs=1e-3)
    # one line alone is stretched; Simpson's rule on the stiffness
    slope = state.stiffness[:, 0, 0]
    area = (offsets[1] - offsets[0]) / 3 * (slope[20] + 4 * slope[21:40:2].sum() + 2 * slope[22:40:2].sum() + slope[40])
    assert force[40] == pytest.approx(area, rel=1e-4)
    assert force[40] > 10 * slope[20] > -force[0]
    yaw, state = force_offset_curve(OC4, [0, 0, 0, 0, 0, 1], [0.01])
    assert yaw == pytest.approx(0.01 * mooring_state(OC4, REST).stiffness[5, 5], rel=1e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_profiles_run_from_end_to_end(kind):
    """Shapes join the points, stay above the seabed where lines feel it, and carry the end tensions."""
    system = KINDS[kind]
    s = mooring_state(system, OPERATING * [1, 1, 1, 0.1, 0.1, 1])
    shape, tension = line_profiles(system, s, 201)
    assert shape.shape == (len(system.length), 201, 3)
    np.testing.assert_allclose(shape[:, 0], s.point_position[system.end_a], atol=1e-6)
    np.testing.assert_allclose(shape[:, -1], s.point_position[system.end_b], atol=1e-6)
    np.testing.assert_allclose(tension[:, 0], s.anchor_tension, rtol=1e-8, atol=1e-3)
    np.testing.assert_allclose(tension[:, -1], s.fairlead_tension, rtol=1e-8, atol=1e-3)
    if np.all(system.weight_per_length > 0):
        assert shape[..., 2].min() >= -200 - 1e-6


def test_uplift_angle_at_the_anchor():
    """A line clear of the seabed pulls the anchor up by what its weight leaves of the fairlead's vertical force."""
    system = KINDS["uplift"]
    s = mooring_state(system, REST)
    up = s.fairlead_vertical - system.weight_per_length * system.length
    assert np.all(up > 0)
    np.testing.assert_allclose(s.anchor_vertical, up, rtol=1e-9)
    np.testing.assert_allclose(np.tan(s.anchor_uplift_angle), up / s.fairlead_horizontal, rtol=1e-9)


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


def test_a_state_nearby_is_a_start():
    """Starting from the joints of another offset leads to the same state."""
    system = KINDS["buoy"]
    near = mooring_state(system, OPERATING)
    found = mooring_state(system, OPERATING + 0.1, near.point_position)
    np.testing.assert_allclose(found.force, mooring_state(system, OPERATING + 0.1).force, rtol=1e-8)


def test_wrong_input_is_named():
    with pytest.raises(ValueError, match=r"line line2: the line cannot reach"):
        mooring_state(OC4, np.array([1000.0, 0, 0, 0, 0, 0]))
    with pytest.raises(ValueError, match=r"offset has shape \(3,\)"):
        mooring_state(OC4, np.zeros(3))
    with pytest.raises(ValueError, match="anchor1, anchor2, anchor3 is below the seabed"):
        spread(anchor=(837.6, -210.0))
    with pytest.raises(ValueError, match="line line1, line2, line3: length and axial stiffness"):
        spread(length=0.0)
    loose = joined(1, [ANCHOR, FAIRLEAD, ("connect", 100.0, 0, -50.0, 1.0, 1.0)], [(0, 1, 835.35, *CHAIN)])
    with pytest.raises(ValueError, match="point connect13: no equilibrium found"):
        mooring_state(loose, REST)
    with pytest.raises(ValueError, match="point_kind needs one of"):
        replace(OC4, point_kind=["anchor"] * 6)
    with pytest.raises(ValueError, match="position has shape"):
        replace(OC4, position=np.zeros((5, 3)))
    with pytest.raises(ValueError, match="line line1: both ends are the same point"):
        replace(OC4, end_b=[0, 4, 5])
