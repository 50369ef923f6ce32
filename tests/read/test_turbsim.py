"""TurbSim wind fields: what is packed comes back; hub and rotor averages of fields known in closed form."""

import os
from pathlib import Path

import numpy as np
import pytest
from openfast_samples import bts_bytes

from fowtio.errors import FormatError, ModelError
from fowtio.read.turbsim import hub_wind, point_wind, read_turbsim, rotor_wind

RNG = np.random.default_rng(3)


def read(tmp_path, content):
    path = tmp_path / "a.bts"
    path.write_bytes(content)
    return read_turbsim(path)


def linear(steps=20, ny=7, nz=9, slope=0.05):
    """A field that grows linearly with height and side, and with time."""
    y = (np.arange(ny) - (ny - 1) / 2) * 10
    z = 60 + np.arange(nz) * 10
    t = np.arange(steps) * 0.1
    u = 12 + slope * (z[None, :, None] - 90) + 0.02 * y[None, None, :] + t[:, None, None]
    return np.stack([u, 0 * u + 1, 0.5 * u], axis=-1)


@pytest.mark.parametrize("tower", [0, 3])
@pytest.mark.parametrize("ident", [7, 8])
def test_what_is_packed_comes_back(tmp_path, tower, ident):
    velocity = RNG.normal(size=(15, 4, 5, 3)) * [2, 1, 0.5] + [12, 0, 0]
    field = read(tmp_path, bts_bytes(velocity, tower=tower, ident=ident))
    # half a step of 65534 over the range, plus single precision (2^-23 of the value through slope and offset)
    step = np.ptp(velocity, axis=(0, 1, 2)) / 65534
    assert np.all(np.abs(field.velocity - velocity) <= 0.51 * step + 2e-6 * np.abs(velocity).max())
    np.testing.assert_allclose(field.y, [-20, -10, 0, 10, 20])
    np.testing.assert_allclose(field.z, [60, 70, 80, 90])
    np.testing.assert_allclose(np.diff(field.time), 0.1, rtol=1e-6)  # the step is stored in single precision
    assert field.periodic == (ident == 8)
    assert (field.mean_speed, field.hub_height) == (12, 90)
    assert field.description == "made by the tests"


def test_average_over_the_rotor_of_a_linear_field_is_that_of_its_centre(tmp_path):
    field = read(tmp_path, bts_bytes(linear()))
    # bilinear interpolation is exact for it, so only the packing remains (a step is 5 m/s / 65534)
    expected = 12 + np.arange(20) * 0.1
    np.testing.assert_allclose(hub_wind(field)[:, 0], expected, atol=1e-4)
    np.testing.assert_allclose(rotor_wind(field, 25.0)[:, 0], expected, atol=1e-4)
    np.testing.assert_allclose(point_wind(field, 5.0, 100.0)[:, 0], expected + 0.05 * 10 + 0.02 * 5, atol=1e-4)


def test_average_over_the_rotor_of_a_paraboloid(tmp_path):
    # the mean of r^2 over a disk of radius R is R^2/2; interpolation between points 2 m apart adds at most 2^2/8
    # times the
    # second derivative 0.02 in each of two directions, 0.02 in all
    y, z = (np.arange(31) - 15) * 2.0, 60 + np.arange(31) * 2.0
    u = 10 + 0.01 * ((z[:, None] - 90) ** 2 + y[None, :] ** 2)
    velocity = np.broadcast_to(np.stack([u, 0 * u, 0 * u], axis=-1), (3, 31, 31, 3))
    field = read(tmp_path, bts_bytes(velocity, dy=2.0, dz=2.0))
    assert rotor_wind(field, 25.0)[0, 0] == pytest.approx(10 + 0.01 * 25**2 / 2, abs=0.02)


def test_a_rotor_larger_than_the_grid_is_refused(tmp_path):
    field = read(tmp_path, bts_bytes(linear()))
    for ask in (lambda: rotor_wind(field, 31.0), lambda: hub_wind(field, 141.0), lambda: rotor_wind(field, 0.0)):
        with pytest.raises(ModelError):
            ask()


def test_files_cut_short_or_damaged_are_refused(tmp_path):
    content = bts_bytes(linear(steps=4))
    for length in [*range(0, 80, 3), *range(80, len(content), 101), len(content) - 1]:
        with pytest.raises(FormatError):
            read(tmp_path, content[:length])
    for at in range(18):  # each byte of identifier and counts
        bad = bytearray(content)
        bad[at] ^= 0x15
        with pytest.raises(FormatError):
            read(tmp_path, bytes(bad))


@pytest.mark.reference
@pytest.mark.skipif("FOWTIO_FORMATS" not in os.environ, reason="FOWTIO_FORMATS names no folder of sample files")
def test_real_file_has_the_statistics_of_its_summary():
    field = read_turbsim(Path(os.environ["FOWTIO_FORMATS"]) / "turbsim" / "TurbSim.bts")
    hub = hub_wind(field)
    # TurbSim.sum: mean 11.40, 0, 0 and sigma 1.404, 1.333, 1.008 m/s of the 476 steps before 472 were written
    np.testing.assert_allclose(hub.mean(axis=0), [11.40, 0, 0], atol=0.03)
    np.testing.assert_allclose(hub.std(axis=0), [1.404, 1.333, 1.008], rtol=0.02)
