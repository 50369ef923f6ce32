"""One floater in six formats is one set of coefficients; and any of them is found by its content."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hydro_samples import assert_equal, put, synthetic
from hydro_writers import ah1_text, lis_text, orcaflex_text, write_nemoh

from fowtio.errors import FormatError
from fowtio.read.hydro_any import HYDRO_FORMATS, read_hydro
from fowtio.read.wamit import read_wamit
from fowtio.write.hydro import write_capytaine, write_wamit
from model.system.hydro import HydroCoefficients

OC4 = Path(__file__).parents[2] / "validation/oc4_deepcwind/input/hydro/oc4"
CENTRE = (1.5, -2.5, -8.25)  # of gravity: exact in the digits of every format
MASS = 1.1e7


def oc4(gravity=9.81) -> HydroCoefficients:
    """Return the committed coefficients on nine of their frequencies, which four decimals hold."""
    h = read_wamit(OC4, density=1025.0, gravity=gravity, depth=200.0)
    some = np.linspace(0, len(h.omega) - 1, 9).astype(int)
    return replace(
        h, omega=np.round(h.omega[some], 4), added_mass=h.added_mass[some], radiation_damping=h.radiation_damping[some],
        excitation=h.excitation[:, some], volume=13917.0, centre_of_buoyancy=(0.0, 0.0, -13.125),
    )  # fmt: skip


def made_up(gravity=9.81) -> HydroCoefficients:
    return synthetic(gravity=gravity)


BODIES = {"synthetic": made_up, "oc4": oc4}


# what each format keeps of a number, relative to the largest: seven digits (WAMIT, Nemoh), five digits with phases to a
# hundredth of a degree, 0.9e-4 rad (AH1), three digits of forces, up to 5e-3 (LIS), double precision (netCDF,
# OrcaFlex); moving the point adds (force x arm) to the moments, which are of that size. WAMIT's damping and omega go
# through the period, the centres in Nemoh and AQWA have three decimals (exact here)
TOLERANCE = {
    "wamit": {"default": 1e-6},
    "capytaine": {"default": 0.0},
    "ah1": {"default": 1e-4, "excitation": 2e-4},
    "lis": {"default": 1e-4, "excitation": 8e-3},
    "nemoh": {"default": 2e-7},
    "orcaflex": {"default": 1e-13},
}


def written(kind: str, hydro: HydroCoefficients, folder: Path) -> tuple[Path, dict]:
    """Write the body in one format and return what read_hydro needs."""
    water = {"density": hydro.density, "gravity": hydro.gravity, "depth": hydro.depth}
    if kind == "wamit":
        write_wamit(hydro, folder / "body", length=2.0)
        return folder / "body", water | {"length": 2.0}
    if kind == "capytaine":
        return write_capytaine(hydro, folder / "body.nc"), {}
    if kind == "ah1":
        return put(folder / "body.AH1", ah1_text(hydro, CENTRE)), {}
    if kind == "lis":
        return put(folder / "body.LIS", lis_text(hydro, CENTRE)), {}
    if kind == "nemoh":
        return write_nemoh(folder, hydro, point=(0.5, 0.25, -3.0), centre=CENTRE, wave_point=(4.0, -1.0)), {}
    path = folder / "body.yml"
    path.write_text(orcaflex_text(hydro, point=(0.5, 0.25, -3.0), mass=MASS, centre=CENTRE), encoding="utf-8")
    return path, {}


@pytest.mark.parametrize("kind", TOLERANCE)
@pytest.mark.parametrize("body", BODIES)
def test_one_body_in_every_format(tmp_path, body, kind):
    want = BODIES[body](9.80665 if kind == "orcaflex" else 9.81)  # OrcaFlex has its own; AQWA prints three decimals
    path, options = written(kind, want, tmp_path)
    got = read_hydro(path, **options)
    tolerance = dict(TOLERANCE[kind])
    default = tolerance.pop("default")
    fields = ["omega", "heading", "added_mass", "radiation_damping", "excitation", "hydrostatic_stiffness"]
    fields += [] if kind == "nemoh" else ["added_mass_zero", "added_mass_infinite"]  # Nemoh's files have no limits
    assert_equal(got, want, default, fields, **tolerance)
    np.testing.assert_array_equal(got.reference_point, 0.0)
    for name in ("density", "gravity", "depth"):
        assert getattr(got, name) == pytest.approx(getattr(want, name), rel=1e-12)


@pytest.mark.parametrize("kind", [k for k in TOLERANCE if k != "wamit"])
def test_content_tells_the_format_whatever_the_others_say(tmp_path, kind):
    path, _ = written(kind, synthetic(gravity=9.81), tmp_path)
    head = path.read_bytes()[:65536] if path.is_file() else b""
    assert sum(f.recognises(path, head) for f in HYDRO_FORMATS) == 1
    own = next(f for f in HYDRO_FORMATS if f.recognises(path, head))
    rows = dict(own.describe(own.read(path)))
    assert rows["frequencies"].startswith("5, 0.3 to 1.5 rad/s")


def test_options_that_a_format_does_not_know_are_refused(tmp_path):
    path, _ = written("ah1", synthetic(gravity=9.81), tmp_path)
    with pytest.raises(FormatError, match="no option density"):
        read_hydro(path, density=1000.0)


def test_files_that_are_none_of_these(tmp_path):
    with pytest.raises(FormatError, match="expected one of"):
        read_hydro(put(tmp_path / "a.txt", "hello\n"))
    with pytest.raises(FormatError, match="nor a WAMIT set"):
        read_hydro(tmp_path / "nothing")


@pytest.mark.parametrize("body", BODIES)
def test_wamit_and_capytaine_to_and_fro(tmp_path, body):
    """Writing what was read changes nothing more: the second generation equals the first."""
    first = BODIES[body]()
    write_wamit(first, tmp_path / "a")
    water = {"density": first.density, "gravity": first.gravity, "depth": first.depth}
    second = read_hydro(tmp_path / "a", **water)
    third = read_hydro(write_capytaine(second, tmp_path / "b.nc"))
    assert_equal(third, second, 0.0)  # double precision throughout
    write_wamit(third, tmp_path / "c")
    # seven digits of seven digits: the same but for ties of rounding in the derived period and the modulus
    assert_equal(read_hydro(tmp_path / "c", **water), second, 1e-6)
