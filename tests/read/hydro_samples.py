"""A synthetic floater for the tests of hydrodynamic readers, and the ways its files are bent."""

from pathlib import Path

import numpy as np

from model.conventions import skew
from model.environment.airy import wavenumber
from model.system.hydro import HydroCoefficients


def synthetic(
    n=5, headings=(-90.0, 0.0, 45.0, 90.0), depth=80.0, density=1025.0, gravity=9.80665, point=(0.0, 0.0, 0.0), seed=1
) -> HydroCoefficients:
    """Return a made-up floater: six horizontal slices of water moving as the waves do, and a damping to match.

    Its added mass tends from one limit to the other; its force on each slice follows the water's acceleration, so it
    has the phases of a real one. Everything about `point`.
    """
    rng = np.random.default_rng(seed)
    omega = np.round(np.linspace(0.3, 1.5, n), 4)
    heading = np.radians(headings)
    root = rng.normal(size=(6, 6)) * np.array([1, 1, 1, 8, 8, 8])[:, None]
    base = 1e6 * (root @ root.T)
    share = 1 / (1 + omega**2)
    added = base * (1 + share)[:, None, None]
    damping = 0.3 * base * (omega * share**2)[:, None, None]
    x, y, z = rng.uniform(-20, 20, 6), rng.uniform(-20, 20, 6), rng.uniform(-18, -2, 6)
    k = wavenumber(omega, depth, gravity)[:, None]
    decay = np.exp(k * z) * 1e6 * (1 + share)[:, None]
    path = np.cos(heading)[:, None, None] * x + np.sin(heading)[:, None, None] * y
    phasor = decay * np.exp(-1j * k * path)
    across = phasor * 1j * k
    force = np.stack(
        [across * np.cos(heading)[:, None, None], across * np.sin(heading)[:, None, None], phasor], axis=-1
    )
    arm = np.stack([x, y, z], axis=-1) - np.asarray(point)
    moment = np.einsum("sij,mnsj->mnsi", skew(arm), force)
    excitation = np.concatenate([force, moment], axis=-1).sum(axis=2)
    stiffness = np.zeros((6, 6))
    stiffness[2:5, 2:5] = 1e6 * np.array([[4.0, 2.0, -3.0], [2.0, 900.0, 5.0], [-3.0, 5.0, 1100.0]])
    volume, buoyancy = 12345.0, (0.5, -0.25, -9.0)
    stiffness[3, 5], stiffness[4, 5] = (-density * gravity * volume * c for c in buoyancy[:2])
    return HydroCoefficients(
        omega=omega, added_mass=added, radiation_damping=damping, added_mass_zero=2 * base, added_mass_infinite=base,
        heading=heading, excitation=excitation, hydrostatic_stiffness=stiffness, volume=volume,
        centre_of_buoyancy=buoyancy, reference_point=point, density=density, gravity=gravity, depth=depth,
    )  # fmt: skip


FIELDS = (
    "omega", "heading", "added_mass", "radiation_damping", "added_mass_zero", "added_mass_infinite", "excitation",
    "hydrostatic_stiffness",
)  # fmt: skip


def assert_equal(got, want, tolerance, fields=FIELDS, **looser):
    """Compare fields, each relative to its largest force and moment; `looser` gives fields a tolerance of their own."""
    for name in fields:
        a, b = getattr(got, name), getattr(want, name)
        if b is None or a is None:
            assert a is b, name
            continue
        scale = np.abs(b).max()
        if b.shape[-2:] == (6, 6):  # forces and moments have scales of their own
            blocks = np.abs(b).reshape(-1, 2, 3, 2, 3).max(axis=(0, 2, 4))
            blocks[[0, 1], [1, 0]] = np.sqrt(blocks[0, 0] * blocks[1, 1])
            scale = np.kron(blocks, np.ones((3, 3)))
        elif name == "excitation":
            scale = np.repeat(np.abs(b).reshape(-1, 2, 3).max(axis=(0, 2)), 3)
        error = np.abs((a - b) / np.where(scale > 0, scale, 1.0)).max()
        assert error <= looser.get(name, tolerance), f"{name}: {error:.2e} > {looser.get(name, tolerance):.0e}"


def variants(text: str):
    """Yield (name, bytes) of the same file as other systems write it; each must read alike."""
    yield "crlf", text.replace("\n", "\r\n").encode()
    yield "bom", b"\xef\xbb\xbf" + text.encode()
    yield "no last line end", text.rstrip("\n").encode()


def truncations(text: str, step: int = 1):
    """Yield (line count, text) of the file cut after each line."""
    lines = text.splitlines(keepends=True)
    for count in range(1, len(lines), step):
        yield count, "".join(lines[:count])


def flips(text: str, count: int, seed=0, alphabet="0123456789.-+EeX *,\t"):
    """Yield (place, text) of the file with one random character replaced."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        place = int(rng.integers(len(text)))
        character = alphabet[int(rng.integers(len(alphabet)))]
        if text[place] not in ("\n", character):
            yield place, text[:place] + character + text[place + 1 :]


def put(path: Path, data: str | bytes) -> Path:
    """Write text or bytes and return the path."""
    path.write_bytes(data.encode("latin-1") if isinstance(data, str) else data)
    return path
