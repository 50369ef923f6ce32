"""Elastic catenary lines: end forces, line stiffness, grounded length, shape and tension along the line.

Inside, lengths are divided by the unstretched length L and forces by the submerged weight w L, so that a line is
two numbers, e = w L / EA and the seabed friction coefficient, and a state is (h, v) = (H, V) / (w L) at the upper
end. A line lies in one of these ways:

    slack      on the seabed with its upper part hanging vertically, h = 0
    flat       wholly on the seabed, v = 0
    grounded   its lower end lies on the seabed, the rest hangs, v < 1
    suspended  clear of the seabed; with v < 1 it sags below its lower end
    touching   both ends are above the seabed and the sag rests on it, frictionless

Source: J. M. Jonkman, Dynamics modeling and loads analysis of an offshore floating wind turbine,
NREL/TP-500-41958, 2007, section 2.7; H. M. Irvine, Cable structures, MIT Press, 1981 (suspended, start of a taut line).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

# A line lighter than this part of EA / L is given this weight: it is then straight when taut and carries next to
# nothing when slack, which is the limit wanted for neutrally buoyant ropes, and the equations stay regular.
LEAST_WEIGHT = 1e-12
# Relative Newton step after which the quadratically convergent next state is exact to rounding.
STEP = 1e-8
# A horizontal distance below this part of the length is a vertical line; a height below it a flat one.
NOTHING = 1e-13
TINY = 1e-150


@dataclass(frozen=True, eq=False, kw_only=True)
class LineState:
    """End forces and stiffness of lines; every array has the lines' shape (...), matrices behind it.

    horizontal, vertical: what the line pulls at its fairlead, towards the anchor and down [N];
    anchor_horizontal, anchor_vertical: at its anchor, towards the fairlead and up (uplift) [N];
    weight: submerged weight per length that was used [N/m];
    grounded: unstretched length on the seabed [m];
    stiffness: d(horizontal, vertical) / d(x, z) of the fairlead (..., 2, 2) [N/m];
    anchor_stiffness: d(anchor_horizontal, anchor_vertical) / d(x, z) (..., 2, 2) [N/m];
    flexibility: d(x, z) / d(H, V) at the fairlead (..., 2, 2) [m/N], infinite for a slack line;
    lateral, anchor_lateral: H / x, the stiffness across the line's plane [N/m];
    clearance_stiffness: d(H, V, anchor H, anchor V) / d(clearance) (..., 4) [N/m], None unless a line is touching.
    """

    horizontal: np.ndarray
    vertical: np.ndarray
    anchor_horizontal: np.ndarray
    anchor_vertical: np.ndarray
    grounded: np.ndarray
    stiffness: np.ndarray
    anchor_stiffness: np.ndarray
    lateral: np.ndarray
    anchor_lateral: np.ndarray
    weight: np.ndarray
    clearance_stiffness: np.ndarray | None = None

    def __post_init__(self) -> None:
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)

    @property
    def flexibility(self) -> np.ndarray:
        """d(x, z) / d(H, V) of the fairlead (..., 2, 2) [m/N], infinite for a slack line."""
        k = self.stiffness
        det = k[..., 0, 0] * k[..., 1, 1] - k[..., 0, 1] * k[..., 1, 0]
        slack = det == 0
        adjoint = np.stack([k[..., 1, 1], -k[..., 0, 1], -k[..., 1, 0], k[..., 0, 0]], -1)
        out = adjoint / np.where(slack, 1.0, det)[..., None]
        with np.errstate(divide="ignore"):
            loose = np.stack([1 / k[..., 0, 0], 0 * slack, 0 * slack, 1 / k[..., 1, 1]], -1)
        return np.where(slack[..., None], loose, out).reshape(k.shape)

    @property
    def tension(self) -> np.ndarray:
        """Fairlead tension (...) [N]."""
        return np.hypot(self.horizontal, self.vertical)

    @property
    def anchor_tension(self) -> np.ndarray:
        """Anchor tension (...) [N]."""
        return np.hypot(self.anchor_horizontal, self.anchor_vertical)


def catenary(
    horizontal, vertical, length, weight, stiffness, friction=0.0, clearance=0.0, *, start=None, names=None
) -> LineState:
    """Solve elastic catenary lines between two ends, partly on the seabed or suspended.

    Parameters: horizontal and vertical distance from anchor to fairlead [m]; unstretched length [m]; submerged
    weight per length [N/m], negative for a buoyant line, zero for a neutral one; axial stiffness EA [N]; seabed
    friction coefficient [-]; clearance of the lower end above the seabed [m], zero if it lies on the seabed, inf
    for no seabed; start, the LineState of lines of the same shape nearby to start from; names of the lines along the
    last axis, for messages. All arrays broadcast to one shape (...).

    Returns the LineState. A line longer than its way along the seabed and up to the fairlead has H = 0. The lower end
    is the anchor or the fairlead, whichever is lower. Buoyant lines do not feel the seabed.

    Raises ValueError for a length or stiffness that is not positive, numbers that are not finite, and lines that
    would have to stretch to more than twice their length.

    Source: Jonkman (2007), section 2.7; the Jacobians are their derivatives.
    """
    given = (horizontal, vertical, length, weight, stiffness, friction, clearance)
    shape = np.broadcast_shapes(*(np.shape(a) for a in given))
    x, z, length, w, ea, cb, clear = (np.array(np.broadcast_to(a, shape or (1,)), dtype=float) for a in given)
    check_lines(x, z, length, w, ea, cb, names)
    state = solve_lines(x, z, length, w, ea, cb, clear, start)
    lost = ~np.isfinite(state.horizontal + state.vertical)
    if lost.any():
        raise ValueError(
            f"{_which(lost, names)}: no equilibrium, the line is too short ({_numbers(lost, x, z, length)})"
        )
    if shape:
        return state
    return LineState(**{name: None if value is None else value[0] for name, value in vars(state).items()})


def line_profile(state, horizontal, vertical, length, stiffness, friction=0.0, n=101):
    """Return shape and tension along solved lines at n points, equally spaced in unstretched length from the anchor.

    Parameters: state from `catenary`, and the horizontal and vertical distance [m], unstretched length [m], axial
    stiffness [N] and seabed friction [-] it was solved for, all (...); n points.

    Returns x and z from the anchor [m] and the tension [N], each (..., n).

    Source: Jonkman (2007), section 2.7; the excess of a slack line is laid evenly along the seabed.
    """
    given = (horizontal, vertical, length, stiffness, friction, state.grounded, state.anchor_vertical, state.weight)
    x, z, length, ea, cb, lying, lift, w = (np.asarray(a, dtype=float)[..., None] for a in given)
    s = np.linspace(0, 1, n) * length
    first = np.where(lying > 0, np.maximum(-lift, 0.0) / np.abs(w), 0.0)  # hanging length between anchor and seabed
    flat = np.clip(s - first, 0.0, lying)
    v = lift + w * (s - flat)
    pull = np.maximum(state.horizontal, state.anchor_horizontal)[..., None]
    h = np.maximum(pull, 1e-250)
    t, t0 = np.hypot(h, v), np.hypot(h, lift)
    # friction eats the horizontal tension away from the touchdown point of a line with one end on the seabed
    one_end = (state.vertical == 0) | (state.anchor_vertical == 0)
    drag = np.where((lying > 0) & one_end[..., None], cb * np.abs(w), 0.0)
    back = np.where(z < 0, flat, lying - flat)
    left, most = np.maximum(pull - drag * back, 0.0), np.maximum(pull - drag * lying, 0.0)
    edge = np.where(z < 0, pull**2 - left**2, left**2 - most**2)
    stretch = pull * (s - flat) + np.where(drag > 0, 0.5 * edge / np.where(drag > 0, drag, 1.0), pull * flat)
    along = np.where((pull > 0) | (lying == 0), 1.0, x / np.where(lying > 0, lying, 1.0)) * flat
    across = along + h / w * _span(h, v, lift, t, t0, w * (s - flat)) + stretch / ea
    up = (v + lift) * (s - flat) * (1 / (t + t0) + 0.5 / ea)
    return across, up, np.hypot(left, v)


def solve_lines(x, z, length, w, ea, cb, clear, start=None) -> LineState:
    """Solve lines as `catenary` does, for arrays of one shape and without its checks."""
    weight = effective_weight(w, length, ea)
    light = weight < 0
    w = np.abs(weight)
    turned = np.where(light, -z, z) < 0
    scale = w * length
    e, cb, clear = scale / ea, np.where(light, 0.0, cb), np.where(light, np.inf, clear) / length
    x, z = x / length, np.abs(z) / length
    if start is not None:
        start = _started(start, scale, turned)
    h, v, below, flexibility = _solve(x, z, e, cb, clear <= NOTHING, start)
    state = _upper_and_lower(x, h, v, below, flexibility, cb)
    touching = (clear > NOTHING) & (v < 1) & (_sag(h, v - 1, e) > clear)
    extra = None
    if touching.any():
        state, extra = _merge_touching(touching, state, x, z, e, clear)
    return _assemble(state, extra, scale, length, w, weight, light, turned)


def _started(start, scale, turned):
    """Return (h, v) at the upper end from the LineState of lines nearby."""
    h = np.where(turned, start.anchor_horizontal, start.horizontal)
    v = np.abs(np.where(turned, start.anchor_vertical, start.vertical))
    return np.maximum(h / scale, 1e-9), np.maximum(v / scale, 1e-9)


def effective_weight(weight, length, stiffness) -> np.ndarray:
    """Return the submerged weight per length [N/m] used for a line: never closer to zero than LEAST_WEIGHT EA / L."""
    least = LEAST_WEIGHT * stiffness / length
    return np.where(np.abs(weight) < least, least, weight)


def check_lines(x, z, length, w, ea, cb, names) -> None:
    """Raise ValueError naming the lines that `catenary` refuses."""
    problems = (
        (~np.isfinite(x + z + length + w + ea + cb), "the numbers must be finite"),
        (~((length > 0) & (ea > 0)), "length and axial stiffness must be positive"),
        (~((x >= 0) & (cb >= 0)), "horizontal distance and friction must not be negative"),
        (
            np.hypot(x, z) > 2 * length,
            "the line cannot reach: it would stretch to more than twice its length; lengthen it or check both ends",
        ),
    )
    for bad, text in problems:
        if bad.any():
            raise ValueError(f"{_which(bad, names)}: {text} ({_numbers(bad, x, z, length)})")


def _which(bad, names) -> str:
    """Name the lines along the last axis that are marked."""
    last = np.flatnonzero(bad.reshape(-1, bad.shape[-1]).any(axis=0)) if bad.ndim else [0]
    return "line " + ", ".join(str(names[i] if names is not None else i + 1) for i in last)


def _numbers(bad, x, z, length) -> str:
    first = np.flatnonzero(bad.ravel())[0]
    x, z, length = (a.ravel()[first] for a in (x, z, length))
    return f"horizontal {x:g} m, vertical {z:g} m, unstretched length {length:g} m"


# --- one state: (h, v) to (x, z) and its Jacobian -------------------------------------------------------------------


def _grounded(h, v, e, cb):
    """Return x, z, dx/dh, dx/dv, dz/dh, dz/dv of lines with their lower part on the seabed."""
    t = np.sqrt(h * h + v * v)
    lying = 1 - v
    rise = np.arcsinh(v / h)
    safe = np.where(cb > 0, cb, 1.0)
    free = np.maximum(cb * lying - h, 0.0)  # friction left over where the tension has come down to zero
    x = lying + h * rise + e * (h - 0.5 * cb * lying**2 + 0.5 * free**2 / safe)
    z = v * v * (1 / (t + h) + 0.5 * e)
    cross = -v * v / (t * (t + h))
    return x, z, rise - v / t + e * (1 - free / safe), cross + e * (cb * lying - free), cross, v / t + e * v


def _span(h, top, bottom, t_top, t_bottom, rise):
    """Return asinh(top / h) - asinh(bottom / h), exact for taut lines too; rise is top - bottom without rounding."""
    p = top * bottom
    taut = p > 0
    q = 0.5 + 0.5 * (h * h + top * top + bottom * bottom) / np.where(taut, t_top * t_bottom + p, 1.0)
    short = 2 * np.arcsinh(rise * np.sqrt(q) / (t_top + t_bottom))
    if taut.all():
        return short
    return np.where(taut, short, np.arcsinh(top / h) - np.arcsinh(bottom / h))


def _suspended(h, v, e):
    """Return x, z, dx/dh, dx/dv, dz/dh, dz/dv of lines clear of the seabed."""
    u = v - 1
    t, b = np.sqrt(h * h + v * v), np.sqrt(h * h + u * u)
    span = _span(h, v, u, t, b, 1.0)
    turn = v / t - u / b
    taut = v * u > 0
    if taut.any():
        turn = np.where(taut, h * h * (2 * v - 1) / (np.where(taut, u * t + v * b, 1.0) * t * b), turn)
    cross = -h * (2 * v - 1) / ((t + b) * t * b)
    z = (2 * v - 1) * (1 / (t + b) + 0.5 * e)
    return h * (span + e), z, span + e - turn, cross, cross, turn + e


def _evaluate(h, v, e, cb, seabed):
    contact = seabed & (v < 1)
    if contact.all():
        return _grounded(h, v, e, cb)
    if not contact.any():
        return _suspended(h, v, e)
    return tuple(np.where(contact, np.array(_grounded(h, v, e, cb)), np.array(_suspended(h, v, e))))


def _sag(h, v, e):
    """Return the depth of the lowest point below an end with vertical force v."""
    return v * v * (1 / (np.sqrt(h * h + v * v) + h + TINY) + 0.5 * e)


# --- the inverse: (x, z) to (h, v) ----------------------------------------------------------------------------------


def _solve(x, z, e, cb, seabed, start):
    """Return h, v, whether the lower end lies on the seabed with v < 1, and the flexibility (fxx, fxz, fzx, fzz)."""
    h, v = _start(x, z, e, seabed) if start is None else start
    closed, h, v = _closed_forms(x, z, e, cb, seabed, h, v)
    h, v, bad = _newton(h, v, x, z, e, cb, seabed, closed, 40)
    if bad.any():
        g, u = _bracket(*(a[bad] for a in (x, z, e, cb, seabed)))
        h[bad], v[bad] = g, u
        h[bad], v[bad], _ = _newton(g, u, *(a[bad] for a in (x, z, e, cb, seabed, closed)), 4)
    flexibility = _evaluate(h, v, e, cb, seabed)[2:]
    if closed.any():
        h, flexibility = _closed_flexibility(closed, h, v, z, e, cb, seabed, flexibility)
    return h, v, seabed & (v < 1), flexibility


def _start(x, z, e, seabed):
    """Return Jonkman's starting values, Irvine's for lines close to straight; v to match z with seabed contact."""
    ratio = 3 * ((1 - z * z) / np.maximum(x, NOTHING) ** 2 - 1)
    root = np.sqrt(np.maximum(ratio, 0.04))
    h, v = 0.5 * x / root, 0.5 * (z / np.tanh(root) + 1)
    taut = ratio < 0.04
    if taut.any():
        chord = np.sqrt(x * x + z * z)
        chord = np.where(chord > 0, chord, 1.0)
        t = _taut_tension(chord - 1, x / chord, e)
        h, v = np.where(taut, t * x / chord, h), np.where(taut, t * z / chord + 0.5, v)
    h = np.maximum(h, TINY)
    resting = z * (z + 2 * h)
    return h, np.where(seabed & (resting < 1), np.sqrt(resting), v)


def _taut_tension(stretch, cosine, e):
    """Return the positive root of e t^3 - stretch t^2 - cosine^2 / 24 = 0, from above by Newton."""
    c = cosine**2 / 24
    e = np.maximum(e, 1e-15)
    t = np.maximum(stretch, 0) / e + np.cbrt(c / e)
    t = np.where(stretch < 0, np.minimum(t, np.sqrt(c / np.where(stretch < 0, -stretch, 1.0))), t) + 1e-12
    for _ in range(4):
        t = t - (t * t * (e * t - stretch) - c) / (t * np.maximum(3 * e * t - 2 * stretch, e * t))
    return t


def _closed_forms(x, z, e, cb, seabed, h, v):
    """Return which lines are slack, flat or vertical, and (h, v) with their solution filled in."""
    hanging = 2 * z / (1 + np.sqrt(1 + 2 * e * z))
    slack = seabed & (hanging <= 1) & (x <= 1 - hanging)
    flat = seabed & (z <= NOTHING) & ~slack
    vertical = (x <= NOTHING) & ~slack
    closed = slack | flat | vertical
    if closed.any():
        pull = np.maximum(x - 1, 0) / np.maximum(e, TINY)
        sliding = np.where(2 * pull >= cb, pull + 0.5 * cb, np.sqrt(2 * cb * pull))
        upright = np.where(z > 1 + 0.5 * e, 0.5 + (z - 1) / np.maximum(e, TINY), 0.5 + z / (2 + e))
        h = np.select([slack | vertical, flat], [TINY, np.maximum(sliding, TINY)], h)
        v = np.select([slack, flat, vertical], [hanging, 0.0, upright], v)
    return closed, h, v


def _closed_flexibility(closed, h, v, z, e, cb, seabed, flexibility):
    """Put the limits in place of the flexibility of slack, flat and vertical lines."""
    fxx, fxz, fzx, fzz = (np.array(f) for f in flexibility)
    loose = closed & (h <= TINY) & ((v < 1) | seabed & (v == 1))
    flat = closed & seabed & (z <= NOTHING) & ~loose
    h = np.where(closed & (h <= TINY), 0.0, h)
    fxx[loose] = np.inf
    fxx[flat] = (e * np.where(cb > 0, np.minimum(h / np.where(cb > 0, cb, 1.0), 1.0), 1.0))[flat]
    fxz[loose | flat] = fzx[loose | flat] = 0.0
    fzz[loose] = np.where(seabed, 1 + e * v, 2 + e)[loose]
    fzz[flat] = np.inf
    return h, (fxx, fxz, fzx, fzz)


def _newton(h, v, x, z, e, cb, seabed, closed, count):
    """Return h, v after damped Newton steps and which lines have not converged."""
    some = closed.any()
    for _ in range(count):
        gx, gz, fxx, fxz, fzx, fzz = _evaluate(h, v, e, cb, seabed)
        rx, rz = x - gx, z - gz
        det = fxx * fzz - fxz * fzx
        if some:
            det = np.where(closed, 1.0, det)
        dh, dv = (fzz * rx - fxz * rz) / det, (fxx * rz - fzx * rx) / det
        bad = ~((np.abs(dh) <= STEP * h) & (np.abs(dv) <= STEP * v))
        if some:
            dh, dv, bad = np.where(closed, 0.0, dh), np.where(closed, 0.0, dv), bad & ~closed
        short = dh < -0.9 * h
        h, v = np.where(short, 0.1 * h, h + dh), np.maximum(v + dv, 0.1 * v)
        if not bad.any():
            break
        if short.any():  # back to where z is right, on the seabed; elsewhere v may stay
            v = np.where(short & seabed, np.minimum(np.sqrt(z * (z + 2 * h)), np.maximum(v, 1.0)), v)
    return h, v, bad


def _bracket(x, z, e, cb, seabed):
    """Return h, v by bisection on log h; x grows with h when z is held, so this always succeeds."""
    low = np.full(x.shape, np.log(1e-30))
    high = np.log(np.minimum((x + 1) / np.maximum(e, 1e-15) + cb + 1, 1e15))
    for _ in range(100):
        middle = 0.5 * (low + high)
        h = np.exp(middle)
        v = _vertical(h, z, e, seabed & (z < _sag(h, 1.0, e)))
        short = _evaluate(h, v, e, cb, seabed)[0] < x
        low, high = np.where(short, middle, low), np.where(short, high, middle)
    return h, v


def _vertical(h, z, e, contact):
    """Return the v that gives height z at given h; z(v) is convex with seabed contact and concave without."""
    v = np.where(contact, np.sqrt(z * z + 2 * h * z), 0.5)
    for _ in range(60):
        t, b = np.sqrt(h * h + v * v), np.sqrt(h * h + (v - 1) ** 2)
        hanging = (2 * v - 1) * (1 / (t + b) + 0.5 * e)
        gap = z - np.where(contact, _sag(h, v, e), hanging)
        step = gap / np.maximum(np.where(contact, v / t, v / t - (v - 1) / b) + e * np.where(contact, v, 1), TINY)
        v = v + step
        if np.all(np.abs(step) <= 1e-14 * v):
            break
    return v


# --- from (h, v) to forces and stiffness ----------------------------------------------------------------------------


def _upper_and_lower(x, h, v, below, flexibility, cb):
    """Return upper and lower (h, v), grounded length, their stiffness (2, 2, ...) and h / x, all divided by w, L."""
    fxx, fxz, fzx, fzz = flexibility
    upper = np.zeros((2, 2) + x.shape)
    limp, rigid = np.isinf(fxx), np.isinf(fzz)
    if limp.any() or rigid.any():
        upper[0, 0] = np.where(limp, 0.0, 1 / np.where(rigid | ~limp & (fxz == 0), fxx, 1.0))
        upper[1, 1] = np.where(rigid, 0.0, 1 / np.where(limp, fzz, 1.0))
        keep = ~(limp | rigid)
        fxx, fzz = np.where(keep, fxx, 1.0), np.where(keep, fzz, 1.0)
    else:
        keep = True
    det = fxx * fzz - fxz * fzx
    for (i, j), entry in {(0, 0): fzz, (0, 1): -fxz, (1, 0): -fzx, (1, 1): fxx}.items():
        upper[i, j] = np.where(keep, entry / det, upper[i, j])
    lying = np.where(below, 1 - v, 0.0)
    anchor = np.where(below, np.maximum(h - cb * lying, 0.0), h)
    lower = np.where(below, 0.0, upper)
    pulled = below & (anchor > 0)
    lower[0] = np.where(pulled, upper[0] + cb * upper[1], lower[0])
    wide = x > NOTHING
    lateral = np.where(wide, h / np.where(wide, x, 1.0), upper[0, 0])
    anchor_lateral = np.where(wide, anchor / np.where(wide, x, 1.0), lower[0, 0])
    return h, v, anchor, np.where(below, 0.0, v - 1), lying, upper, lower, lateral, anchor_lateral


def _assemble(state, extra, scale, length, w, weight, light, turned) -> LineState:
    """Return the LineState in metres and newtons, with fairlead and anchor in place of upper and lower end."""
    h, v, anchor_h, anchor_v, lying, upper, lower, lateral, anchor_lateral = state
    if turned.any():
        h, anchor_h = np.where(turned, anchor_h, h), np.where(turned, h, anchor_h)
        v, anchor_v = np.where(turned, anchor_v, v), np.where(turned, v, anchor_v)
        upper, lower = np.where(turned, lower, upper), np.where(turned, upper, lower)
        lateral, anchor_lateral = np.where(turned, anchor_lateral, lateral), np.where(turned, lateral, anchor_lateral)
    sign = np.where(light != turned, -1.0, 1.0)
    both = w * np.stack([upper, lower])
    both[:, 0, 1] *= sign
    both[:, 1, 0] *= sign
    k, anchor_k = np.moveaxis(both, (1, 2), (-2, -1))
    if extra is not None:
        extra = np.where(turned, extra[[2, 3, 0, 1]], extra) * w
        extra[1::2] *= sign
        extra = np.moveaxis(extra, 0, -1)
    return LineState(
        horizontal=scale * h,
        vertical=sign * scale * v,
        anchor_horizontal=scale * anchor_h,
        anchor_vertical=sign * scale * anchor_v,
        grounded=lying * length,
        stiffness=k,
        anchor_stiffness=anchor_k,
        lateral=w * lateral,
        anchor_lateral=w * anchor_lateral,
        weight=weight,
        clearance_stiffness=extra,
    )


# --- touching: both ends above the seabed, the sag on it ------------------------------------------------------------


def _merge_touching(mask, state, x, z, e, clear):
    """Return the state with the touching lines replaced, and d(h, v, lower h, lower v) / d(clearance)."""
    solved, slope = _touching(*(a[mask] for a in (x, z, e, clear)))
    out = tuple(np.array(a) for a in state)
    for array, values in zip(out, solved, strict=True):
        array[..., mask] = values
    extra = np.zeros((4,) + x.shape)
    extra[:, mask] = slope
    return out, extra


def _touching(x, z, e, clear):
    """Return upper and lower state of lines that touch the seabed between their ends, and the clearance slope."""
    heights = np.stack([clear + z, clear])
    h, v = _touching_pull(x, heights, e)
    t = np.sqrt(h * h + v * v)
    zv, zh = v / t + e * v, -v * v / (t * (t + h))
    ratio = zh / zv
    slack = h <= TINY
    total = np.where(slack, 1.0, e + (np.arcsinh(v / h) - v / t - zh * ratio).sum(axis=0))
    hx = np.where(slack, 0.0, 1 / total)
    upper_slope, lower_slope = -ratio * hx  # dh / d(height of the end): zh = dx/dv too
    rise = 1 / zv
    upper = np.stack([[hx, upper_slope], [-ratio[0] * hx, rise[0] - ratio[0] * upper_slope]])
    lower = np.stack([[hx, upper_slope], [ratio[1] * hx, ratio[1] * upper_slope]])
    both = upper_slope + lower_slope
    extra = np.stack([both, rise[0] - ratio[0] * both, both, ratio[1] * both - rise[1]])
    h = np.where(slack, 0.0, h)
    lateral = h / np.maximum(x, NOTHING)
    return (h, v[0], h, -v[1], 1 - v[0] - v[1], upper, lower, lateral, lateral), extra


def _touching_pull(x, heights, e):
    """Return h and the vertical forces (2, ...) at both ends: Newton on h, kept inside a shrinking bracket."""
    hanging = 2 * heights / (1 + np.sqrt(1 + 2 * e * heights))
    slack = x <= 1 - hanging.sum(axis=0)
    low, high = np.full(x.shape, 1e-30), (x + 1) / np.maximum(e, 1e-15) + 1
    h = np.sqrt(low * high)
    for _ in range(200):
        v = _vertical(np.broadcast_to(h, heights.shape), heights, e, True)
        t = np.sqrt(h * h + v * v)
        zv, zh = v / t + e * v, -v * v / (t * (t + h))
        rise = np.arcsinh(v / h)
        gap = x - (1 + e * h + (h * rise - v).sum(axis=0))
        low, high = np.where(gap > 0, h, low), np.where(gap > 0, high, h)
        step = gap / (e + (rise - v / t - zh * zh / zv).sum(axis=0))
        done = slack | (np.abs(step) <= 1e-14 * h)
        inside = (h + step > low) & (h + step < high)
        h = np.where(done, h, np.where(inside, h + step, np.sqrt(low * high)))
        if done.all():
            break
    return np.where(slack, TINY, h), np.where(slack, hanging, v)
