"""Capytaine netCDF: names, dimensions, convention, weight, several bodies, damaged files."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from hydro_samples import assert_equal, put, synthetic

from fowtio.errors import FormatError
from fowtio.read.capytaine import CAPYTAINE, read_capytaine
from fowtio.write.hydro import write_capytaine
from model.conventions import weight_stiffness
from model.system.hydro import transfer

ROUNDING = 1e-13  # double precision, a few operations


@pytest.fixture
def path(tmp_path):
    return write_capytaine(synthetic(), tmp_path / "a.nc")


def bend(path: Path, change) -> Path:
    data = change(xr.load_dataset(path))
    out = path.with_name("bent.nc")
    data.to_netcdf(out, engine="h5netcdf")
    return out


def test_written_file_reads_back(path):
    got = read_capytaine(path)
    assert_equal(got, synthetic(), 0.0)
    assert (got.volume, got.density, got.gravity, got.depth) == (12345.0, 1025.0, 9.80665, 80.0)


def test_infinite_depth_and_missing_parts(tmp_path):
    want = replace(
        synthetic(depth=np.inf), added_mass_zero=None, added_mass_infinite=None, heading=None, excitation=None,
        hydrostatic_stiffness=None, volume=None, centre_of_buoyancy=None,
    )  # fmt: skip
    got = read_capytaine(write_capytaine(want, tmp_path / "a.nc"))
    assert_equal(got, want, 0.0)
    assert got.depth == np.inf


def test_convention_in_the_file_is_minus_i_omega_t(path):
    """Capytaine's documentation: e^{-i omega t}, so the long-wave surge force has phase -90 deg there."""
    data = xr.load_dataset(path)
    force = data.excitation_force.sel(complex="re") + 1j * data.excitation_force.sel(complex="im")
    first = force.sel(wave_direction=0.0, influenced_dof="Surge").isel(omega=1)  # omega[0] is zero
    assert np.degrees(np.angle(first)) == pytest.approx(-90, abs=15)
    got = read_capytaine(path)
    np.testing.assert_allclose(got.excitation[1, 0, 0], np.conj(first), rtol=ROUNDING)


def test_rows_are_influenced_and_columns_radiating(path):
    data = bend(path, lambda d: d.assign(added_mass=d.added_mass.where(d.radiating_dof != "Pitch", d.added_mass * 2)))
    np.testing.assert_allclose(read_capytaine(data).added_mass[:, :, 4], 2 * synthetic().added_mass[:, :, 4])


@pytest.mark.parametrize(
    "dims", [("influenced_dof", "radiating_dof", "omega"), ("radiating_dof", "omega", "influenced_dof")]
)
def test_dimensions_in_any_order(path, dims):
    def turned(d):
        force = d.excitation_force.transpose("influenced_dof", "complex", "wave_direction", "omega")
        return d.assign(added_mass=d.added_mass.transpose(*dims), excitation_force=force).isel(
            omega=slice(None, None, -1)
        )

    assert_equal(read_capytaine(bend(path, turned)), synthetic(), 0.0)


@pytest.mark.parametrize(
    ("name", "convert"), [("period", lambda w: 2 * np.pi / w), ("freq", lambda w: w / (2 * np.pi))]
)
def test_other_frequency_coordinates(path, name, convert):
    def renamed(d):
        d = d.isel(omega=slice(1, -1)).drop_vars("wavenumber")  # finite ones
        return d.assign_coords(omega=convert(d.omega.values)).rename(omega=name)

    assert_equal(
        read_capytaine(bend(path, renamed)),
        replace(synthetic(), added_mass_zero=None, added_mass_infinite=None),
        ROUNDING,
    )


def test_froude_krylov_and_diffraction_are_added(path):
    def split(d):
        f = d.excitation_force
        return d.drop_vars("excitation_force").assign(Froude_Krylov_force=0.7 * f, diffraction_force=0.3 * f)

    assert_equal(read_capytaine(bend(path, split)), synthetic(), ROUNDING)


def test_parts_that_do_not_add_up_are_noticed(path):
    def wrong(d):
        return d.assign(Froude_Krylov_force=0.7 * d.excitation_force, diffraction_force=0.2 * d.excitation_force)

    with pytest.raises(FormatError, match="Froude_Krylov_force"):
        read_capytaine(bend(path, wrong))


def two_bodies(d: xr.Dataset) -> xr.Dataset:
    """Return two copies of the body as Capytaine 2 names them, the second with doubled coefficients, no coupling."""
    names = {k: [f"{k}__{dof}" for dof in d.radiating_dof.values] for k in ("left", "right")}

    def labelled(part, name):
        return part.assign_coords(radiating_dof=names[name], influenced_dof=names[name])

    first, second = labelled(d, "left"), labelled(d, "right")
    scaled = ["added_mass", "radiation_damping", "excitation_force", "hydrostatic_stiffness"]
    second = second.assign({k: (2 * second[k]).assign_attrs(second[k].attrs) for k in scaled})
    both = xr.merge(
        [first[scaled], second[scaled]], join="outer", combine_attrs="override", compat="no_conflicts"
    ).fillna({"added_mass": 0, "radiation_damping": 0})
    return both.assign_coords(d[["g", "rho", "water_depth"]].coords)


def test_several_bodies_are_chosen_or_refused(path):
    both = bend(path, two_bodies)
    with pytest.raises(FormatError, match="1: left, 2: right"):
        read_capytaine(both)
    want = synthetic()
    assert_equal(read_capytaine(both, body="left"), want, ROUNDING)
    for body in ("right", 2):
        got = read_capytaine(both, body=body)
        np.testing.assert_allclose(got.added_mass, 2 * want.added_mass)
        np.testing.assert_allclose(got.excitation, 2 * want.excitation)
    for body in ("middle", 3, 0):
        with pytest.raises(FormatError, match="left"):
            read_capytaine(both, body=body)


def test_rotation_centre_is_moved_to_the_origin(tmp_path):
    want = synthetic()
    got = read_capytaine(write_capytaine(transfer(want, (1.0, 2.0, -7.0)), tmp_path / "a.nc"))
    assert_equal(got, want, ROUNDING)


def test_weight_in_the_stiffness(path):
    """Capytaine's own stiffness has the weight: left out when it is not known, taken off when it is."""
    mass, centre = 1.2e7, np.array([0.5, -0.25, -13.0])
    want = synthetic()
    total = want.hydrostatic_stiffness + weight_stiffness(mass, centre, want.gravity)

    def heavy(d):
        return d.assign(hydrostatic_stiffness=(("influenced_dof", "radiating_dof"), total))

    assert read_capytaine(bend(path, heavy)).hydrostatic_stiffness is None
    assert_equal(read_capytaine(bend(path, heavy), weight=(mass, centre)), want, 1e-12)

    def known(d):
        inertia = np.diag([mass, mass, mass, 1.0, 1.0, 1.0])
        return heavy(d).assign(
            inertia_matrix=(("influenced_dof", "radiating_dof"), inertia), center_of_mass=("point_coordinates", centre)
        )

    assert_equal(read_capytaine(bend(path, known)), want, 1e-12)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda d: d.drop_vars("added_mass"), "added_mass"),
        (lambda d: d.drop_vars("rho"), "rho"),
        (lambda d: d.assign_coords(forward_speed=1.0), "forward_speed"),
        (lambda d: d.drop_sel(influenced_dof="Yaw"), "no yaw"),
        (lambda d: d.drop_vars("omega"), "omega, period or freq"),
        (lambda d: d.assign(radiation_damping=-d.radiation_damping), "not negative"),
        (lambda d: d.assign(added_mass=d.added_mass.where(d.omega != d.omega[2])), "added_mass has a value"),
        (lambda d: xr.concat([d, d.assign_coords(water_depth=9.0)], "water_depth"), "one water_depth"),
    ],
)
def test_what_is_wrong_is_said(path, change, words):
    with pytest.raises(FormatError, match=words):
        read_capytaine(bend(path, change))


def test_damaged_and_missing_files(path, tmp_path):
    data = path.read_bytes()
    for part in (10, 1000, len(data) // 2):
        with pytest.raises(FormatError):
            read_capytaine(put(tmp_path / "cut.nc", data[:part]))
    with pytest.raises(FormatError, match="netCDF"):
        read_capytaine(put(tmp_path / "text.nc", "hello"))
    with pytest.raises(FormatError, match="does not exist"):
        read_capytaine(tmp_path / "nothing.nc")


def test_recognition(path, tmp_path):
    assert CAPYTAINE.recognises(path, path.read_bytes()[:65536])
    xr.Dataset({"a": 1.0}).to_netcdf(tmp_path / "other.nc", engine="h5netcdf")
    assert not CAPYTAINE.recognises(tmp_path / "other.nc", (tmp_path / "other.nc").read_bytes()[:65536])
    assert dict(CAPYTAINE.describe(CAPYTAINE.read(path)))["displaced volume"] == "12345 m3"


@pytest.mark.reference
@pytest.mark.skipif("FOWTIO_FORMATS" not in os.environ, reason="FOWTIO_FORMATS names no folder")
def test_real_file_of_two_equal_bodies():
    """Two equal bodies 10 m apart along y: mirror images, so their surge and heave agree but for the wave's path."""
    path = Path(os.environ["FOWTIO_FORMATS"]) / "capytaine/two_bodies.nc"
    first, second = (read_capytaine(path, body=k) for k in ("Body 1", "Body 2"))
    np.testing.assert_allclose(first.added_mass[:, 0, 0], second.added_mass[:, 0, 0], rtol=1e-3)
    head_on = int(np.argmin(np.abs(first.heading)))
    assert np.degrees(np.angle(first.excitation[head_on, 0, 0])) == pytest.approx(90, abs=0.1)
    np.testing.assert_allclose(first.excitation[head_on, :, 2], second.excitation[head_on, :, 2], rtol=2e-2)
