"""A solution beside coefficients of the same hull from elsewhere: differences of added mass, damping peaks and excitation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.system.hydro import HydroCoefficients, excitation_at

DIAGONAL = tuple((k, k) for k in range(6))
COUPLED = ((0, 4), (1, 3))
NOTHING = 1e-6  # of the scale: what both sets say is zero


@dataclass(frozen=True, kw_only=True)
class Difference:
    """One entry compared: its name, mean and largest difference as shares, the frequency [rad/s] of the largest, and of what they
    are shares.
    """

    name: str
    mean: float
    largest: float
    omega: float
    of: str


def compare(own: HydroCoefficients, reference: HydroCoefficients) -> list[Difference]:
    """Return the differences of a solution from a reference, on the solution's frequencies that the reference covers.

    Added mass of the diagonal: share of its value there; coupling and excitation: of the largest value; damping: at the
    reference's peaks, of the peak.
    """
    inside = (own.omega >= reference.omega[0]) & (own.omega <= reference.omega[-1])
    omega = own.omega[inside]
    out = []
    for i, j in (*DIAGONAL, *COUPLED):
        a, b = own.added_mass[inside, i, j], np.interp(omega, reference.omega, reference.added_mass[:, i, j])
        out += _entry(f"A{i + 1}{j + 1}", omega, a, b, reference.added_mass, (i, j), "its value" if i == j else "its largest value")
    for i, j in DIAGONAL:
        b = np.interp(omega, reference.omega, reference.radiation_damping[:, i, j])
        if _nothing(b, reference.radiation_damping, (i, j)):
            continue
        a, peaks = own.radiation_damping[inside, i, j], _peaks(b)
        gap = a[peaks] / b[peaks] - 1
        out += [Difference(name=f"B{i + 1}{j + 1}", mean=float(g), largest=float(g), omega=float(omega[p]), of="the peak") for g, p in zip(gap, peaks, strict=True)]
    return out + (_excitation(own, reference, omega, inside) if own.heading is not None and reference.heading is not None else [])


def _entry(name, omega, a, b, matrices, place, of) -> list[Difference]:
    if _nothing(b, matrices, place):
        return []
    gap = (a - b) / (b if of == "its value" else np.abs(b).max())
    k = int(np.abs(gap).argmax())
    return [Difference(name=name, mean=float(gap.mean()), largest=float(gap[k]), omega=float(omega[k]), of=of)]


def _nothing(values, matrices, place) -> bool:
    """Whether an entry is zero beside the largest diagonal ones of its kinds of motion (translations, rotations)."""
    kinds = [slice(0, 3) if k < 3 else slice(3, 6) for k in place]
    scale = np.sqrt(np.prod([np.abs(np.diagonal(matrices, axis1=-2, axis2=-1)[..., kind]).max() for kind in kinds]))
    return bool(np.abs(values).max() <= NOTHING * scale)


def _peaks(values: np.ndarray) -> np.ndarray:
    """Return the places of the local maxima that reach half of the largest, the largest always."""
    inner = np.flatnonzero((values[1:-1] >= values[:-2]) & (values[1:-1] > values[2:])) + 1
    high = inner[values[inner] >= 0.5 * values.max()]
    return np.unique(np.append(high, values.argmax()))


def _excitation(own, reference, omega, inside) -> list[Difference]:
    low, high = (max(own.heading[0], reference.heading[0]), min(own.heading[-1], reference.heading[-1]))
    keep = (own.heading >= low - 1e-9) & (own.heading <= high + 1e-9)
    a = own.excitation[keep][:, inside]
    b = excitation_at(reference, omega, own.heading[keep])
    out = []
    scale = np.abs(b).max(axis=(0, 1))
    for k in range(6):
        if scale[k] <= NOTHING * (scale[:3] if k < 3 else scale[3:]).max():
            continue
        gap = np.abs(a[..., k] - b[..., k]) / scale[k]
        at = np.unravel_index(gap.argmax(), gap.shape)
        out.append(Difference(name=f"X{k + 1}", mean=float(gap.mean()), largest=float(gap[at]), omega=float(omega[at[1]]), of="its largest value, all headings"))
    return out


def compare_rows(found: list[Difference]) -> list[tuple[str, str]]:
    """Return labels and texts for people."""
    return [
        (d.name, f"{100 * d.largest:+6.2f} % at {d.omega:.2f} rad/s" + ("" if d.of == "the peak" else f", mean {100 * d.mean:+.2f} %") + f" (of {d.of})")
        for d in found
    ]


def compare_json(found: list[Difference]) -> list[dict]:
    """Return the differences for programs, as shares."""
    return [{"name": d.name, "mean": d.mean, "largest": d.largest, "frequency": d.omega, "share_of": d.of} for d in found]
