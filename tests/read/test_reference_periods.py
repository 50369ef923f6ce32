"""Natural periods of the reference floaters on the land-based tower that their reports have, against those reports.

The reports' periods fit a linearisation without radiation memory, as FAST's is: the added mass of infinite frequency. The studies in validation/ carry the tower of OC3 instead, whose linearisations come with the embedded case.
"""

import shutil

import numpy as np
import openfast_samples as samples
import pytest

import fowtio

# NREL/TP-500-38060, table 6-1: mass [kg/m] and bending stiffness [GN m2] at tenths of 87.6 m
LAND_TOWER = (
    (5590.87, 614.34), (5232.43, 534.82), (4885.76, 463.27), (4550.87, 399.13), (4227.75, 341.88), (3916.41, 291.01), (3616.83, 246.03),
    (3329.03, 206.46), (3053.01, 171.85), (2788.75, 141.78), (2536.27, 115.82),
)  # fmt: skip


@pytest.fixture
def periods(tmp_path, oc4_folder):
    """Return a function of a reference study: periods by mode, with infinite-frequency added mass, on the land-based tower."""

    def of(folder, deck):
        shutil.copytree(oc4_folder.parent / folder / "input", tmp_path / folder)
        samples.set_value(tmp_path / folder / "ElastoDyn.dat", "TowerBsHt", "0.0  ")
        tower = tmp_path / folder / "ElastoDyn_Tower.dat"
        lines = tower.read_text().splitlines()
        at = next(k for k, line in enumerate(lines) if line.split()[:1] == ["HtFract"]) + 2
        lines[at : at + 11] = [f"{k / 10} {m} {ei}E9 {ei}E9" for k, (m, ei) in enumerate(LAND_TOWER)]
        tower.write_text("\n".join(lines) + "\n")
        point = fowtio.build(fowtio.load(tmp_path / folder / deck)).points[0]
        return dict(zip(point.modes.names, 2 * np.pi / point.modes.frequency_infinite, strict=True))

    return of


def test_tension_leg_platform(periods):
    # D. Matha 2010, NREL/SR-500-45891: surge 60.6, heave 2.3, pitch 4.5, yaw 9.8 to 10.3 s; 3 % for coefficients of another mesh
    found = periods("mit_tlp", "tlp.fst")
    for name, published in (("surge", 60.6), ("heave", 2.3), ("pitch", 4.5), ("yaw", 10.3)):
        assert found[name] == pytest.approx(published, rel=0.03), name


def test_barge(periods):
    # J. Jonkman 2007, NREL/TP-500-41958: surge 131, heave 7.8, pitch 11.9 s; 3 % as above
    found = periods("iti_barge", "iti.fst")
    for name, published in (("surge", 131.0), ("heave", 7.8), ("pitch", 11.9)):
        assert found[name] == pytest.approx(published, rel=0.03), name
