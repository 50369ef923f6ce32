"""What is wrong with a hull file, all of it at once, before anything is solved."""

from __future__ import annotations

from numbers import Real

import numpy as np

MAY_BE_ZERO = ("moonpool", "moonpool_cap", "pontoon_length", "pontoon_diameter")
DIMENSIONS = ("length", "width", "draft", "diameter", "radius", "scale", "moonpool", "moonpool_cap", "pontoon_length", "pontoon_diameter", "pontoon_depth",
              "plate_ratio", "plate_height", "central_diameter", "column_freeboard", "central_freeboard", "brace_diameter")  # fmt: skip


def hull_problems(kind: str, shape: dict, bem: dict) -> list[str]:
    """Return what is wrong with the dimensions [m] of a kind of hull and its settings [bem]: one sentence each, none when all is well."""
    out = [p for name in DIMENSIONS if name in shape for p in _size(name, shape[name], zero=name in MAY_BE_ZERO)]
    out += _settings(bem)
    if kind == "mesh" and not isinstance(shape["file"], str):
        out.append(f"file is {shape['file']!r}; it must be the name of a mesh file")
    if out:
        return out
    out = {"spar": _spar, "barge": _barge, "tlp": _tlp, "semi": _semi}.get(kind, lambda shape, bem: [])(shape, bem)
    deepest = shape.get("draft") or (-shape["profile"][-1][1] if kind == "spar" and not out else 0.0)
    if not bem["depth"] > deepest:
        out.append(f"depth is {bem['depth']:g} m, the hull reaches {deepest:g} m below still water; the water must be deeper")
    return out


def _number(value) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool) and not np.isnan(value)


def _size(name: str, value, *, zero: bool = False) -> list[str]:
    if not _number(value) or np.isinf(value) or value < 0 or (value == 0 and not zero):
        return [f"{name} is {value!r}; it must be a {'number of 0 or more' if zero else 'positive number'}"]
    return []


def _settings(bem: dict) -> list[str]:
    out = [p for name in ("density", "gravity", "frequency_low", "frequency_high", "panel_size") for p in _size(name, bem[name])]
    if not _number(bem["depth"]) or bem["depth"] <= 0:
        out.append(f"depth is {bem['depth']!r}; it must be a positive number of metres, or inf")
    for name, least in (("frequency_count", 2), ("around", 4)):
        if not _number(bem[name]) or bem[name] < least or bem[name] != round(bem[name]):
            out.append(f"{name} is {bem[name]!r}; it must be a whole number, {least} or more")
    if not out and bem["frequency_high"] <= bem["frequency_low"]:
        out.append(f"frequency_high is {bem['frequency_high']:g} rad/s; it must exceed frequency_low, {bem['frequency_low']:g}")
    headings = bem["headings"]
    if not isinstance(headings, list) or not headings or not all(_number(h) and np.isfinite(h) for h in headings) or len(set(headings)) < len(headings):
        out.append(f"headings are {headings!r}; they must be a list of different numbers (degrees)")
    if bem["method"] not in ("direct", "indirect"):
        out.append(f"method is {bem['method']!r}; it must be direct or indirect")
    return out + [f"{name} is {bem[name]!r}; it must be true or false" for name in ("lid", "braces") if not isinstance(bem[name], bool)]


def _spar(shape: dict, bem: dict) -> list[str]:
    profile = shape["profile"]
    pairs = isinstance(profile, list) and all(isinstance(p, list) and len(p) == 2 and all(map(_number, p)) for p in profile)
    if not pairs or len(profile) < 2:
        return ["profile must be two or more pairs [radius, elevation] of numbers, from the waterline down"]
    radius, z = np.array(profile, dtype=float).T
    out = [f"profile starts at elevation {z[0]:g} m; it must start at still water, 0"] if z[0] != 0 else []
    if np.any(np.diff(z) > 0):
        out.append("profile must go down: an elevation above the one before it (a shoulder may be level)")
    if radius[0] <= 0 or np.any(radius < 0):
        out.append("profile has a radius below zero, or none at the waterline")
    return out


def _barge(shape: dict, bem: dict) -> list[str]:
    pool, cap, size = shape.get("moonpool", 0.0), shape.get("moonpool_cap"), bem["panel_size"]
    out = []
    if pool >= min(shape["length"], shape["width"]):
        out.append(f"moonpool is {pool:g} m wide; the barge is {shape['length']:g} x {shape['width']:g} m")
    if cap is not None and not pool:
        out.append("moonpool_cap is the deck over a moonpool; give moonpool too")
    if cap is not None and cap >= shape["draft"]:
        out.append(f"moonpool_cap is {cap:g} m; it must be less than the draft, {shape['draft']:g} m")
    if cap and cap < size / 4:
        out.append(
            f"moonpool_cap is {cap:g} m: panels of {size:g} m do not resolve so little water above the deck; "
            "give 0, a deck at still water, or a deck deeper than a quarter of panel_size"
        )
    return out


def _tlp(shape: dict, bem: dict) -> list[str]:
    length, diameter, draft = shape.get("pontoon_length", 0.0), shape.get("pontoon_diameter", 0.0), shape["draft"]
    if not length:
        return []
    if not diameter:
        return ["pontoon_diameter is missing; pontoons of pontoon_length need it"]
    depth = shape.get("pontoon_depth", draft - diameter / 2)
    out = [f"pontoons is {shape['pontoons']!r}; the mesh has two planes of symmetry and takes 4"] if shape.get("pontoons", 4) != 4 else []
    if diameter >= shape["diameter"]:
        out.append(f"pontoon_diameter is {diameter:g} m; it must be less than the column's, {shape['diameter']:g} m")
    if not diameter / 2 <= depth <= draft - diameter / 2 + 1e-9:
        out.append(f"pontoons with their axis {depth:g} m deep leave the column between still water and its bottom at {draft:g} m")
    return out


def _semi(shape: dict, bem: dict) -> list[str]:
    from model.design.hull import SemiHull, geometry_problems

    hull = SemiHull(**shape)
    out = [str(text) for mask, text in geometry_problems(hull) if mask]
    if hull.plate_diameter <= hull.diameter:
        out.append("plate_ratio must exceed 1: the heave plates are wider than the columns")
    return out
