"""Elastic catenary lines against closed forms, the catenary equation, integrated shapes and finite differences."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from model.system import catenary as module
from model.system.catenary import catenary, line_profile

# The OC4 semi-submersible's line (Robertson et al., NREL/TP-5000-60601, 2014).
WEIGHT = (113.35 - 1025 * np.pi / 4 * 0.0766**2) * 9.80665
OC4 = {"horizontal": 796.732, "vertical": 186.0, "length": 835.35, "weight": WEIGHT, "stiffness": 753.6e6}
FORCES = ("horizontal", "vertical", "anchor_horizontal", "anchor_vertical")


def jonkman(h, v, length, w, ea, cb):
    """x and z of the fairlead by NREL/TP-500-41958, equations 2-35 to 2-38, as written there."""
    lying = length - v / w
    if lying > 0:
        slip = lying - h / (cb * w) if cb > 0 else 0.0
        x = lying + h / w * np.arcsinh(v / h) + h * length / ea
        if cb > 0:
            x += cb * w / (2 * ea) * (-(lying**2) + slip * max(slip, 0))
        return x, h / w * (np.hypot(1, v / h) - 1) + v**2 / (2 * ea * w)
    low = v - w * length
    x = h / w * (np.arcsinh(v / h) - np.arcsinh(low / h)) + h * length / ea
    return x, h / w * (np.hypot(1, v / h) - np.hypot(1, low / h)) + (v * length - w * length**2 / 2) / ea


@pytest.mark.parametrize("friction", [0.0, 0.3, 1.0])
@pytest.mark.parametrize(("x", "z"), [(720.0, 186.0), (796.732, 186.0), (812.0, 186.0), (830.0, 186.0), (500.0, 660.0)])
def test_state_satisfies_the_published_equations(x, z, friction):
    """Putting the forces back into the report's equations returns the distances (to their rounding)."""
    line = OC4 | {"horizontal": x, "vertical": z}
    s = catenary(**line, friction=friction)
    back = jonkman(s.horizontal, s.vertical, line["length"], WEIGHT, line["stiffness"], friction)
    assert back == pytest.approx((x, z), rel=1e-10)


def test_oc4_line_matches_map():
    """MAP++ in OpenFAST gives 1.1072 MN at rest; its table has five digits, the deck rounds positions to 1 mm."""
    s = catenary(**OC4, friction=1.0)
    assert s.tension == pytest.approx(1.1072e6, rel=2e-4)


def test_vertical_force_is_the_suspended_weight_and_friction_holds_the_rest():
    s = catenary(**OC4, friction=0.5)
    assert s.vertical == pytest.approx(WEIGHT * (OC4["length"] - s.grounded), rel=1e-12)
    assert s.anchor_horizontal == pytest.approx(s.horizontal - 0.5 * WEIGHT * s.grounded, rel=1e-12)
    assert s.anchor_vertical == 0


@pytest.mark.parametrize("height", [10.0, 150.0, 640.0])
def test_slack_line_hangs_vertically_without_horizontal_tension(height):
    """z = s + w s^2 / 2 EA is the stretched length of the hanging part s, whose weight the fairlead carries."""
    s = catenary(10.0, height, 835.35, WEIGHT, 1e7, 1.0)
    hanging = 835.35 - s.grounded
    assert s.horizontal == 0
    assert s.lateral == 0
    assert s.vertical == pytest.approx(WEIGHT * hanging)
    assert hanging + WEIGHT * hanging**2 / 2e7 == pytest.approx(height)
    np.testing.assert_allclose(s.stiffness, [[0, 0], [0, WEIGHT / (1 + WEIGHT * hanging / 1e7)]], rtol=1e-12)


def test_slack_limit_is_continuous():
    """Where the flat part just reaches the point below the fairlead, H passes to zero without a jump."""
    x = 835.35 - 186.0
    pulls = [catenary(x + d, 186.0, 835.35, WEIGHT, 1e14, 0.0).horizontal for d in (-1e-3, 1e-5, 1e-3)]
    assert pulls[0] == 0
    assert 0 < pulls[1] < 0.05 * pulls[2]
    assert pulls[2] < 1.0  # about w dx / asinh(V / H): a tenth of a newton, against a weight of 0.9 MN


@pytest.mark.parametrize("angle", np.radians([0.0, 30.0, 60.0, 90.0]))
@pytest.mark.parametrize("weight", [0.0, 1e-3, -1e-3])
def test_taut_weightless_line_is_a_spring(angle, weight):
    """T = EA (l / L - 1) along the chord, T / l across it; 1e-3 N/m on 8 MN changes neither to 1e-8."""
    length, ea, chord = 100.0, 1e9, 100.8
    s = catenary(chord * np.cos(angle), chord * np.sin(angle), length, weight, ea, clearance=np.inf)
    tension = ea * (chord / length - 1)
    along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    expected = ea / length * np.outer(along, along) + tension / chord * np.outer(across, across)
    # half the line's weight, 0.05 N of 8 MN, goes to each end
    assert [s.horizontal, s.vertical] == pytest.approx(list(tension * along), rel=1e-7, abs=0.1)
    np.testing.assert_allclose(s.stiffness, expected, atol=1e-6 * ea / length)
    assert s.lateral == pytest.approx(tension / chord, rel=1e-6)


def test_tendon_with_weight_hanging_straight_down():
    """V at the top is EA (z / L - 1) + w L / 2, at the bottom wL less; no horizontal force at x = 0."""
    s = catenary(0.0, 120.5, 120.0, 2000.0, 5e9, clearance=0.0)
    assert s.vertical == pytest.approx(5e9 * 0.5 / 120 + 2000 * 60)
    assert s.anchor_vertical == pytest.approx(5e9 * 0.5 / 120 - 2000 * 60)
    assert s.horizontal == 0
    assert s.stiffness[0, 0] == s.lateral > 0


def test_lines_across_a_gap_sag_as_inelastic_catenaries():
    """Ends level, EA large: x = 2 a sinh^-1(L / 2 a) with a = H / w."""
    a, length = 300.0, 500.0
    x = 2 * a * np.arcsinh(length / 2 / a)
    s = catenary(x, 0.0, length, 50.0, 1e12, clearance=np.inf)
    assert s.horizontal == pytest.approx(50.0 * a, rel=1e-6)  # stretch H / EA = 1.5e-8
    assert s.vertical == pytest.approx(25.0 * length)
    assert s.anchor_vertical == pytest.approx(-25.0 * length)


def test_flat_line_on_the_seabed_is_a_spring_held_by_friction():
    """Without friction H = EA (x / L - 1); with full friction from the far end, x - L = H^2 / (2 CB w EA)."""
    pull = 0.01
    assert catenary(100.0 + pull, 0.0, 100.0, 1000.0, 1e8, 0.0).horizontal == pytest.approx(1e8 * pull / 100)
    s = catenary(100.0 + pull / 1e3, 0.0, 100.0, 1000.0, 1e8, 1.0)
    assert s.horizontal == pytest.approx(np.sqrt(2 * 1000 * 1e8 * pull / 1e3))
    assert s.anchor_horizontal == 0
    assert s.vertical == 0


def test_a_line_touching_between_two_raised_ends_is_two_grounded_lines():
    """Cut on the seabed, each half is a line from an anchor there, with the same horizontal tension."""
    left, right = (catenary(140.0, 30.0, 150.0, 400.0, 5e8), catenary(90.0, 55.0, 112.0, 400.0, 5e8))
    s = catenary(140.0 + 90.0, 25.0, 262.0, 400.0, 5e8, clearance=30.0)
    halves = sorted([left.horizontal, right.horizontal])
    assert halves[0] < s.horizontal < halves[1]  # the one slides until both pull alike
    a, b = -s.anchor_vertical / 400.0, s.vertical / 400.0
    again = [catenary(x, z, part, 400.0, 5e8) for x, z, part in _halves(s, a, b)]
    assert [p.horizontal for p in again] == pytest.approx([s.horizontal] * 2, rel=1e-9)


def _halves(s, a, b):
    """Spans of the halves cut in the middle of the grounded part, from the shape along the line."""
    cut = a + s.grounded / 2
    n = 262 * 1000 + 1
    x = line_profile(s, 230.0, 25.0, 262.0, 5e8, n=n)[0]
    where = np.linspace(0, 262.0, n)
    x_cut = np.interp(cut, where, x)
    return (x_cut, 30.0, cut), (230.0 - x_cut, 55.0, 262.0 - cut)


def test_buoyant_line_is_the_mirror_image():
    up = catenary(60.0, 40.0, 90.0, -300.0, 1e8, clearance=np.inf)
    down = catenary(60.0, -40.0, 90.0, 300.0, 1e8, clearance=np.inf)
    assert up.horizontal == pytest.approx(down.horizontal)
    assert up.vertical == pytest.approx(-down.vertical)
    assert up.anchor_vertical == pytest.approx(-down.anchor_vertical)


def test_ends_can_be_exchanged():
    """The same line described from its other end: forces change places; dH/dz keeps its sign with both reversed."""
    one = catenary(796.732, 186.0, 835.35, WEIGHT, 753.6e6, 0.7)
    two = catenary(796.732, -186.0, 835.35, WEIGHT, 753.6e6, 0.7)
    assert two.anchor_horizontal == pytest.approx(one.horizontal)
    assert two.anchor_vertical == pytest.approx(-one.vertical)
    assert two.horizontal == pytest.approx(one.anchor_horizontal)


LINES = st.tuples(
    st.floats(0.05, 1.2),  # x / L
    st.floats(-1.0, 1.0).filter(lambda z: abs(z) > 0.02),  # z / L, away from the square root of a flat line
    st.floats(1.0, 7.0),  # log10 of EA / w L
    st.sampled_from([0.0, 0.4, 1.0, 2.0]),
    st.sampled_from([0.0, 0.1, np.inf]),
    st.sampled_from([1.0, -1.0]),
)


@settings(max_examples=150, deadline=None)
@given(LINES)
def test_stiffness_is_the_derivative_of_the_forces(numbers):
    """Central differences of fourth order, each entry with the step whose estimates at h and 2 h differ least."""
    x, z, e, cb, clear, sign = numbers
    length, w = 300.0, sign * 1e3
    ea = 1e3 * length * 10**e
    s = catenary(x * length, z * length, length, w, ea, cb, clear * length)
    # d2H/dx2 goes to infinity at the slack limit as 1 / (H log^2 H)
    assume(s.horizontal == 0 or s.horizontal > 1e-2 * 1e3 * length)
    steps = np.array([1e-2, 1e-3, 1e-4])
    moves = np.array([-2, -1, 1, 2])[:, None, None, None] * steps[:, None, None] * np.eye(2)
    q = catenary(x * length + moves[..., 0], z * length + moves[..., 1], length, w, ea, cb, clear * length)
    ways = q.grounded > 0, q.horizontal > 0, q.anchor_horizontal > 0
    assume(all(np.all(way[:, 2] == way[0, 2, 0]) for way in ways))  # no kink within a tenth of a millimetre
    a, b, c, d = np.stack([getattr(q, name) for name in FORCES], -1)
    near, far = (c - b) / (2 * steps[:, None, None]), (d - a) / (4 * steps[:, None, None])
    best = np.abs(near - far).argmin(axis=0)
    difference = np.take_along_axis((4 * near - far) / 3, best[None], axis=0)[0].T
    exact = np.concatenate([s.stiffness, s.anchor_stiffness])
    np.testing.assert_allclose(difference, exact, atol=1e-6 * np.abs(exact).max())


@settings(max_examples=100, deadline=None)
@given(LINES)
def test_profile_joins_the_ends_and_carries_its_weight(numbers):
    """The shape ends where the line does, with the state's tensions there, and its arc follows Hooke's law."""
    x, z, e, cb, clear, sign = numbers
    length, w = 300.0, sign * 1e3
    ea = 1e3 * length * 10**e
    s = catenary(x * length, z * length, length, w, ea, cb, clear * length)
    shape = line_profile(s, x * length, z * length, length, ea, cb, n=2001)
    assert (shape[0][0], shape[1][0]) == (0, 0)
    assert (shape[0][-1], shape[1][-1]) == pytest.approx((x * length, z * length), rel=1e-7, abs=1e-6)
    assert (shape[2][0], shape[2][-1]) == pytest.approx((s.anchor_tension, s.tension), rel=1e-8, abs=1e-3)
    if s.horizontal == 0:
        return  # the excess of a slack line has no shape of its own
    arc = np.hypot(np.diff(shape[0]), np.diff(shape[1]))
    stretched = length / 2000 * (1 + 0.5 * (shape[2][1:] + shape[2][:-1]) / ea)
    assert arc.sum() == pytest.approx(stretched.sum(), rel=1e-4)  # polygon against curve with 2000 pieces


@settings(max_examples=100, deadline=None)
@given(
    st.floats(-6, 0.05),
    st.floats(-6, 0.05),
    st.floats(0, 9),
    st.sampled_from([0.0, 1.0]),
    st.sampled_from([0.0, np.inf]),
)
def test_every_reachable_line_is_solved(x, z, e, cb, clear):
    """Eleven decades of spans and stiffnesses: the forces returned give the span back."""
    x, z, ea = 10**x, 10**z, 10**e
    s = catenary(x, z, 1.0, 1.0, ea, cb, clear)
    if s.horizontal > 0 and (s.grounded > 0) == (s.vertical < 1):
        # long double: the report's formula loses digits for taut lines
        h, v = np.longdouble(s.horizontal), np.longdouble(s.vertical)
        assert jonkman(h, v, 1.0, 1.0, np.longdouble(ea), cb) == pytest.approx((x, z), rel=1e-6, abs=1e-9)


def test_bisection_finds_what_newton_finds(monkeypatch):
    """The fallback for lines that Newton leaves unsolved, here all of them."""
    x, z = np.meshgrid([0.3, 0.7, 0.95, 0.999, 1.01], [0.02, 0.2, 0.5])
    lines = {"length": 1.0, "weight": 1.0, "stiffness": 1e3, "friction": 0.5}
    newton = module._newton

    def lazy(h, v, *rest):
        return (h, v, ~rest[-2]) if rest[-1] > 4 else newton(h, v, *rest)

    for clear in (0.0, np.inf):
        known = catenary(x, z, **lines, clearance=clear)
        with monkeypatch.context() as patch:
            patch.setattr(module, "_newton", lazy)
            found = catenary(x, z, **lines, clearance=clear)
        for name in FORCES:
            np.testing.assert_allclose(getattr(found, name), getattr(known, name), rtol=1e-9, atol=1e-12)


def test_starting_from_another_line_changes_nothing():
    x = np.linspace(660, 820, 9)
    far = catenary(x[::-1], 120.0, 835.35, WEIGHT, 753.6e6, 1.0)
    known = catenary(x, 186.0, 835.35, WEIGHT, 753.6e6, 1.0)
    found = catenary(x, 186.0, 835.35, WEIGHT, 753.6e6, 1.0, start=far)
    np.testing.assert_allclose(found.horizontal, known.horizontal, rtol=1e-11)


def test_arrays_of_any_shape():
    x = np.linspace(700, 820, 12).reshape(3, 4)
    s = catenary(x, 186.0, 835.35, WEIGHT, 753.6e6, 1.0)
    one = catenary(x[1, 2], 186.0, 835.35, WEIGHT, 753.6e6, 1.0)
    assert s.stiffness.shape == (3, 4, 2, 2)
    assert s.horizontal[1, 2] == pytest.approx(one.horizontal, rel=1e-13)
    np.testing.assert_allclose(s.flexibility @ s.stiffness, np.broadcast_to(np.eye(2), (3, 4, 2, 2)), atol=1e-9)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"horizontal": [700.0, 1700.0]}, "line north: the line cannot reach"),
        ({"length": [835.0, -1.0]}, "line north: length and axial stiffness must be positive"),
        ({"horizontal": [700.0, np.nan]}, "line north: the numbers must be finite"),
        ({"stiffness": [0.0, 1e8]}, "line south: length and axial"),
        ({"friction": [-1.0, -1.0]}, "line south, north: horizontal distance and friction"),
    ],
)
def test_impossible_lines_are_named(change, text):
    with pytest.raises(ValueError, match=text):
        catenary(**(OC4 | change), names=("south", "north"))
