"""Mesh files (GDF, STL, MSH) give the coefficients of the mesh they were written from; comparison with other coefficients."""

import json

import numpy as np
import pytest

pytest.importorskip("capytaine", reason="Capytaine is not installed: pip install fowtio[bem]")

from typer.testing import CliRunner

from fowtio.bem import BemSettings, capytaine_body, far_field, solve_frequency
from fowtio.bem_run import read_hull, run_bem
from fowtio.cli import app
from fowtio.hull_mesh import whole
from fowtio.hulls import spar_mesh

OMEGAS = (0.6, 1.0)
WATER = "[bem]\ndepth = inf\nfrequency_low = 0.6\nfrequency_high = 1.0\nfrequency_count = 2\nheadings = [0.0, 90.0]\nlid = false\n"


def spar():
    return spar_mesh([(4.0, 0.0), (4.0, -12.0)], size=4.0, around=12)


def gdf(panels) -> str:
    """WAMIT's low-order panels: title, length and gravity, symmetries, number, four corners a panel."""
    rows = "\n".join(" ".join(f"{v:.9e}" for v in corner) for panel in panels for corner in panel)
    return f"a spar\n1.0 9.80665\n0 0\n{len(panels)}\n{rows}\n"


def stl(panels) -> str:
    """Facets of three corners; a quadrilateral becomes two, a panel at the axis (two equal corners) one."""
    rows = []
    for a, b, c, d in panels:
        for corners in ((a, b, c), (a, c, d)):
            normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
            if np.linalg.norm(normal) > 1e-9:
                facet = "".join(f"   vertex {x:.9e} {y:.9e} {z:.9e}\n" for x, y, z in corners)
                unit = " ".join(f"{v:.6e}" for v in normal / np.linalg.norm(normal))
                rows.append(f" facet normal {unit}\n  outer loop\n{facet}  endloop\n endfacet\n")
    return "solid spar\n" + "".join(rows) + "endsolid spar\n"


def msh(panels) -> str:
    """Gmsh's format 2.2: nodes, then quadrilaterals (type 3)."""
    points = panels.reshape(-1, 3)
    nodes = "\n".join(f"{k} {x:.9e} {y:.9e} {z:.9e}" for k, (x, y, z) in enumerate(points, start=1))
    faces = "\n".join(f"{k} 3 2 0 1 " + " ".join(str(4 * (k - 1) + c) for c in (1, 2, 3, 4)) for k in range(1, len(panels) + 1))
    return f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{len(points)}\n{nodes}\n$EndNodes\n$Elements\n{len(panels)}\n{faces}\n$EndElements\n"


@pytest.fixture(scope="module")
def native():
    """The coefficients of the spar's own mesh, without a lid, at OMEGAS."""
    settings = BemSettings(headings=(0.0, np.pi / 2), lid=False)
    body = capytaine_body(spar(), lid=False)
    found = [solve_frequency(body, w, settings) for w in OMEGAS]
    damping = [far_field(r["circle"], body.symmetry, w, settings) for r, w in zip(found, OMEGAS, strict=True)]
    return np.array([r["added_mass"] for r in found]), np.array(damping), np.array([r["excitation"] for r in found])


# the same panels, corners merged by Capytaine to 1e-6 m or so, solved without symmetry: 1e-5 (in deep water: in finite depth the
# Green function is fitted anew each time);
# triangles are other panels than quadrilaterals, twice as many: 4 % of coefficients whose own mesh error is 5 to 10 %
@pytest.mark.parametrize(("suffix", "text", "limit"), [("gdf", gdf, 1e-5), ("msh", msh, 1e-5), ("stl", stl, 0.04)])
def test_a_mesh_file_gives_the_coefficients_of_its_mesh(tmp_path, native, suffix, text, limit):
    if suffix != "gdf":
        pytest.importorskip("meshio", reason="meshio, which reads STL and MSH, is not installed: pip install fowtio[bem]")
    (tmp_path / f"spar.{suffix}").write_text(text(whole(spar())))
    (tmp_path / "spar.toml").write_text(f'kind = "mesh"\nfile = "spar.{suffix}"\n{WATER}')
    result = CliRunner().invoke(app, ["bem", str(tmp_path / "spar.toml"), "-o", str(tmp_path / "out"), "--jobs", "1", "--json", "--no-figures"])
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["volume"] == pytest.approx(np.pi * 16 * 12, rel=1e-6)  # polygons have the circle's area
    hydro, _ = run_bem(read_hull(tmp_path / "spar.toml"), tmp_path / "out")  # from what the command kept
    force = np.swapaxes(hydro.excitation, 0, 1)
    added, damping, waves = native
    for k in range(5):
        for found, wanted in ((hydro.added_mass, added), (hydro.radiation_damping, damping)):
            assert found[:, k, k] == pytest.approx(wanted[:, k, k], rel=limit)
        assert np.abs(force[..., k] - waves[..., k]).max() < limit * np.abs(waves[..., k]).max()


def test_comparing_with_itself_finds_nothing_and_draws(tmp_path):
    (tmp_path / "spar.toml").write_text('kind = "spar"\nprofile = [[4.0, 0.0], [4.0, -12.0]]\n' + WATER.replace("count = 2", "count = 3"))
    runner, out = CliRunner(), tmp_path / "out"
    arguments = ["bem", str(tmp_path / "spar.toml"), "-o", str(out), "--jobs", "1", "--json"]
    assert runner.invoke(app, arguments).exit_code == 0
    result = runner.invoke(app, [*arguments, "--compare", str(out / "spar.nc")])
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)["comparison"]
    assert {row["name"] for row in found} >= {"A11", "A33", "A55", "A15", "B33", "X1", "X3"}
    assert not {"A66", "B66", "X6"} & {row["name"] for row in found}  # a body of revolution makes no waves in yaw: nothing to compare
    assert max(abs(row["largest"]) for row in found) < 1e-6  # netCDF keeps all digits
    assert {p.name for p in out.glob("*.png")} == {"mesh.png", "comparison.png"}
