"""Make a rotor performance table from an AeroDyn blade file and its aerofoils by blade-element momentum theory.

    python benchmarks/rotor_table.py AD_BLADE AEROFOIL1 AEROFOIL2 ... -o TABLE [--hub 1.5] [--tip 63] [--name NAME]

Aerofoil files in the order that the blade file counts them. Steady, no yaw, no cone; Prandtl's losses at tip and hub, lift alone in the
induction, drag in the loads, Buhl's empirical thrust where the induction is large (as AeroDyn's options in the embedded case).
Source of the equation solved: S. A. Ning, Wind Energy 17:1327, 2014.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

BLADES = 3
RATIOS = np.round(np.arange(2.0, 15.01, 0.5), 6)
PITCHES = np.arange(-5.0, 31.0)


def blade_stations(path: Path) -> np.ndarray:
    """Return span [m], twist [rad], chord [m], aerofoil number of the stations."""
    rows = [line.split() for line in path.read_text(errors="replace").splitlines()]
    table = [r for r in rows if len(r) >= 7 and r[0][:1] in "0123456789" and "." in r[0]]
    span, twist, chord, foil = (np.array([float(r[k]) for r in table]) for k in (0, 4, 5, 6))
    return np.stack([span, np.radians(twist), chord, foil])


def polar(path: Path) -> np.ndarray:
    """Return angle of attack [rad], lift and drag coefficient."""
    rows = []
    for line in path.read_text(errors="replace").splitlines():
        try:
            values = [float(x) for x in line.split()[:3]]
        except ValueError:
            continue
        if len(values) == 3:
            rows.append(values)
    alpha, lift, drag = np.array(rows).T
    return np.stack([np.radians(alpha), lift, drag])


def station_loads(ratio, pitch, r, tip, hub, twist, chord, foil):
    """Return the coefficients of normal and tangential load of one station, times chord and (W/U)^2, for arrays of ratio and pitch."""
    local = ratio * r / tip  # speed of the station over the wind
    low, high = np.full(ratio.shape, 1e-4), np.full(ratio.shape, np.pi / 2)
    for _ in range(60):
        phi = (low + high) / 2
        right = residual(phi, local, pitch, r, tip, hub, twist, chord, foil)[0] > 0
        high, low = np.where(right, phi, high), np.where(right, low, phi)
    _, a, b, cl, cd = residual(phi, local, pitch, r, tip, hub, twist, chord, foil)
    square = (1 - a) ** 2 + (local * (1 + b)) ** 2
    normal, tangential = cl * np.cos(phi) + cd * np.sin(phi), cl * np.sin(phi) - cd * np.cos(phi)
    return normal * chord * square, tangential * chord * square


def residual(phi, local, pitch, r, tip, hub, twist, chord, foil):
    """Return Ning's residual of the inflow angle, axial and tangential induction, lift and drag coefficient."""
    alpha = phi - twist - pitch
    cl, cd = np.interp(alpha, foil[0], foil[1]), np.interp(alpha, foil[0], foil[2])
    sine = np.sin(phi)
    loss = np.ones_like(phi)
    for gap, at in (((tip - r), r), ((r - hub), hub)):
        loss = loss * 2 / np.pi * np.arccos(np.exp(-BLADES / 2 * gap / (at * np.abs(sine))).clip(0, 1))
    loss = loss.clip(1e-4)
    solidity = BLADES * chord / (2 * np.pi * r)
    k = solidity * cl * np.cos(phi) / (4 * loss * sine**2)
    g1, g2, g3 = 2 * loss * k - (10 / 9 - loss), 2 * loss * k - loss * (4 / 3 - loss), 2 * loss * k - (25 / 9 - 2 * loss)
    with np.errstate(all="ignore"):
        empirical = np.where(np.abs(g3) < 1e-6, 1 - 1 / (2 * np.sqrt(g2)), (g1 - np.sqrt(np.abs(g2))) / g3)
    a = np.where(k <= 2 / 3, k / (1 + k), empirical)
    kp = solidity * cl * sine / (4 * loss * sine * np.cos(phi))
    b = kp / (1 - kp)
    return sine / (1 - a) - np.cos(phi) / (local * (1 + b)), a, b, cl, cd


def rotor_table(blade: Path, foils: list[Path], hub: float, tip: float) -> tuple[np.ndarray, np.ndarray]:
    """Return power and thrust coefficients over RATIOS and PITCHES."""
    span, twist, chord, number = blade_stations(blade)
    polars = [polar(f) for f in foils]
    edges = np.linspace(hub, tip, 61)
    ratio, pitch = np.meshgrid(RATIOS, np.radians(PITCHES), indexing="ij")
    thrust, torque = np.zeros(ratio.shape), np.zeros(ratio.shape)
    for r, width in zip((edges[1:] + edges[:-1]) / 2, np.diff(edges), strict=True):
        at = r - hub
        near = int(np.argmin(np.abs(span - at)))
        foil = polars[int(number[near]) - 1]
        normal, tangential = station_loads(ratio, pitch, r, tip, hub, np.interp(at, span, twist), np.interp(at, span, chord), foil)
        thrust += BLADES * normal * width / (np.pi * tip**2)
        torque += BLADES * tangential * width * r / (np.pi * tip**3)
    return torque * ratio, thrust


def write(path: Path, name: str, power: np.ndarray, thrust: np.ndarray) -> None:
    """Write the table in ROSCO's layout."""
    def block(title, matrix):
        return [f"#  {title}", "", *("".join(f"{x:10.6f}" for x in row) for row in matrix), ""]

    lines = [
        f"# ----- Rotor performance of {name} -----", "# Blade-element momentum, benchmarks/rotor_table.py of fowtio", "",
        f"# Pitch angle vector, {len(PITCHES)} entries - x axis (matrix columns) (deg)", "  ".join(f"{p:.1f}" for p in PITCHES),
        f"# TSR vector, {len(RATIOS)} entries - y axis (matrix rows) (-)", "  ".join(f"{t:.1f}" for t in RATIOS),
        "# Wind speed vector - z axis (m/s)", "11.0", "", *block("Power coefficient", power), *block("Thrust coefficient", thrust),
        *block("Torque coefficient", power / RATIOS[:, None]),
    ]  # fmt: skip
    path.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("blade", type=Path)
    parser.add_argument("aerofoils", type=Path, nargs="+")
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--hub", type=float, default=1.5)
    parser.add_argument("--tip", type=float, default=63.0)
    parser.add_argument("--name", default="a rotor")
    given = parser.parse_args()
    cp, ct = rotor_table(given.blade, given.aerofoils, given.hub, given.tip)
    write(given.output, given.name, cp, ct)
    print(f"largest power coefficient {cp.max():.4f} at tip speed ratio {RATIOS[np.unravel_index(cp.argmax(), cp.shape)[0]]:g}")
