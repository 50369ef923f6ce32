"""The boundary-element driver against closed forms and published values; resuming; files; the database's packing."""

import json

import numpy as np
import pytest
from scipy.special import h1vp

pytest.importorskip("capytaine", reason="Capytaine is not installed: pip install fowtio[bem]")

from fowtio.bem import BemSettings, capytaine_body, extrapolated, far_field, solve_frequency
from fowtio.bem_run import closed_form, full_circle, hull_meshes, hydrostatics, read_hull, run_bem, write_results
from fowtio.database import (
    DatabasePlan,
    database_plan,
    read_database,
    read_plan,
    solve_plan,
    write_database,
)
from fowtio.database_assemble import collect
from fowtio.errors import CaseError, FormatError, ModelError
from fowtio.hull_mesh import HullMesh, revolved, volume, whole
from fowtio.hulls import barge_mesh, semi_braces, semi_mesh, spar_mesh, tlp_mesh
from fowtio.read.wamit import read_wamit
from model.design.hull import OC4, displaced
from model.environment.airy import wavenumber

HEMISPHERE = [(10 * np.sin(a), -10 * np.cos(a)) for a in np.linspace(np.pi / 2, 0.0, 9)]
SPAR = """title = "small spar"
kind = "spar"
profile = [[4.0, 0.0], [4.0, -20.0]]
[bem]
depth = 60.0
frequency_low = 0.4
frequency_high = 1.2
frequency_count = 3
headings = [0.0, 90.0, 180.0]
panel_size = 5.0
around = 8
"""


def solved(meshes, omega, **settings):
    settings = BemSettings(**settings)
    found = [solve_frequency(capytaine_body(m), omega, settings) for m in meshes]
    out = {n: extrapolated(found[0][n], found[1][n]) for n in ("added_mass", "pressure_damping", "excitation", "circle")}
    return out | {"radiation_damping": far_field(out["circle"], meshes[0].symmetry, omega, settings)}


def hemisphere():
    return [spar_mesh(HEMISPHERE, size=(1,) * 8, around=16, refine=k) for k in (1, 2)]


def test_floating_hemisphere_has_hulmes_added_mass():
    # Hulme (1982): over the mass of displaced water, heave 0.8310 at zero, 0.5 at infinite frequency; surge 0.5 and 0.2732.
    # The hemisphere is a polygon of revolution of 8 pieces: its volume is 1 % small, and so is its added mass; 2 %
    displaced_mass = 1000.0 * volume(whole(hemisphere()[1]))
    zero, infinite = (solved(hemisphere(), w, density=1000.0)["added_mass"] for w in (0.0, np.inf))
    assert zero[2, 2] / displaced_mass == pytest.approx(0.8310, rel=0.02)
    assert zero[0, 0] / displaced_mass == pytest.approx(0.5, rel=0.02)
    assert infinite[2, 2] / displaced_mass == pytest.approx(0.5, rel=0.02)
    assert infinite[0, 0] / displaced_mass == pytest.approx(0.2732, rel=0.02)


def test_haskind_relation_and_signs_hold():
    omega = 1.0
    got = solved(hemisphere(), omega, density=1000.0, gravity=9.81, headings=(0.0,))
    # damping from the pressure on the hull against that from the excitation all around (Haskind): both are approximations
    # of one number, on two meshes extrapolated: 1 %
    for k in (0, 2):
        assert got["pressure_damping"][k, k] == pytest.approx(got["radiation_damping"][k, k], rel=0.01)
    assert np.allclose(got["added_mass"], got["added_mass"].T)
    # e^{+i omega t} and a crest at the origin at time zero: heave force in phase with the crest in long waves, surge a quarter ahead
    low = solved(hemisphere(), 0.15, density=1000.0, gravity=9.81)["excitation"][0]
    assert abs(np.degrees(np.angle(low[2]))) < 3
    assert np.degrees(np.angle(low[0])) == pytest.approx(90, abs=3)


def test_the_far_field_is_nearer_to_the_limit_than_the_pressure_on_the_hull():
    # heave of columns on heave plates: damping is 3 % of the added mass times omega, the difference of two large numbers.
    # Against the extrapolated value the coarse mesh errs by 40 % from the pressure, 25 % from the far field
    settings, omega = BemSettings(), 0.9
    bodies = [capytaine_body(semi_mesh(16.0, 36.0, 24.0, size=(4, 2, 1, 3), around=14, refine=k)) for k in (1, 2)]
    found = [solve_frequency(b, omega, settings) for b in bodies]
    limit = far_field(extrapolated(*(r["circle"] for r in found)), bodies[0].symmetry, omega, settings)[2, 2]
    far = abs(far_field(found[0]["circle"], bodies[0].symmetry, omega, settings)[2, 2] / limit - 1)
    near = abs(found[0]["pressure_damping"][2, 2] / limit - 1)
    assert far < 0.8 * near


@pytest.mark.parametrize("omega", [0.5, 0.9])
def test_bottom_mounted_cylinder_has_mccamy_and_fuchs_force(omega):
    radius, depth, rho, g = 8.0, 40.0, 1025.0, 9.80665
    quarter = [
        revolved([(radius, 0.0), (radius, -depth)], (8,), 16, refine=k, sector=(0.0, np.pi / 2)) for k in (1, 2)
    ]  # fmt: skip
    meshes = [HullMesh(part=p, lid=np.zeros((0, 4, 3)), symmetry="xz yz") for p in quarter]
    force = solved(meshes, omega, depth=depth)["excitation"][0, 0]
    k = float(np.asarray(wavenumber(np.array([omega]), depth, g))[0])
    exact = 4 * rho * g / k**2 * np.tanh(k * depth) / abs(h1vp(1, k * radius))
    # two meshes of 128 and 512 panels, extrapolated: 1 %
    assert abs(force) == pytest.approx(exact, rel=0.01)


def test_lid_removes_the_irregular_frequency():
    # inside a box of 40 x 40 m, draft 4 m, water between lid and bottom resonates at k = pi sqrt(2) / 40:
    # omega = sqrt(g k coth(4 k)) = 1.62 rad/s
    mesh = barge_mesh(40.0, 40.0, 4.0, size=5.0)
    omegas = np.linspace(1.5, 1.75, 11)
    with_lid, without = (
        [solve_frequency(capytaine_body(mesh, lid=lid), w, BemSettings())["added_mass"][2, 2] for w in omegas] for lid in (True, False)
    )  # fmt: skip
    spread = [np.ptp(v) / np.mean(v) for v in (with_lid, without)]
    assert spread[0] < 0.08  # the true added mass grows by some 5 per cent over this band
    assert spread[1] > 0.15  # a resonance that no wave outside has


def test_meshes_have_the_volume_of_their_shapes():
    assert volume(whole(barge_mesh(40.0, 30.0, 4.0, moonpool=10.0))) == pytest.approx(40 * 30 * 4 - 400, rel=1e-12)
    capped = barge_mesh(40.0, 40.0, 4.0, moonpool=10.0, cap=1.0)
    assert volume(whole(capped)) == pytest.approx(1600 * 4 - 100 * 3, rel=1e-12)
    closed = barge_mesh(40.0, 40.0, 4.0, moonpool=10.0, cap=0.0)
    assert volume(whole(closed)) == pytest.approx(6000, rel=1e-12)
    semi = semi_mesh(12.0, 50 / np.sqrt(3), 20.0, central_diameter=6.5, members=semi_braces(OC4))
    assert volume(whole(semi)) == pytest.approx(float(displaced(OC4)[0]), rel=5e-4)  # joints' curved ends
    tlp = tlp_mesh(18.0, 47.89, pontoon_length=18.0, pontoon_diameter=2.4)
    assert volume(whole(tlp)) == pytest.approx(np.pi * 81 * 47.89 + 4 * np.pi * 1.44 * 18, rel=5e-4)
    assert np.abs(whole(semi).mean(axis=(0, 1))[:2]).max() < 1e-9


def test_hydrostatics_of_meshes_equal_closed_forms(tmp_path):
    (tmp_path / "spar.toml").write_text(SPAR)
    (tmp_path / "barge.toml").write_text('kind = "barge"\nlength = 40.0\nwidth = 30.0\ndraft = 4.0\nmoonpool = 10.0\n')
    for name in ("spar", "barge"):
        hull = read_hull(tmp_path / f"{name}.toml")
        stiffness, size, centre = hydrostatics(hull_meshes(hull)[0], 1025.0, 9.80665)
        exact = closed_form(hull)
        assert size == pytest.approx(exact["volume"], rel=1e-12)
        assert stiffness[2, 2] == pytest.approx(exact["C33"], rel=1e-12)
        # the polygon of a circle has its area, and a second moment that differs by (pi/8)^4: small beside the volume's part
        assert stiffness[4, 4] == pytest.approx(exact["C55"], rel=1e-3)
        assert np.allclose(centre[:2], 0, atol=1e-9)


def test_a_stopped_run_goes_on_and_files_read_back(tmp_path, monkeypatch):
    import fowtio.bem_run as module

    (tmp_path / "spar.toml").write_text(SPAR)
    hull, seen = read_hull(tmp_path / "spar.toml"), []
    hydro, quality = run_bem(hull, tmp_path / "out", jobs=1)
    (tmp_path / "out" / "solved" / "omega_0.800000.npz").unlink()
    again = module.solve_one
    monkeypatch.setattr(
        module, "solve_one", lambda hull, omega, folder: seen.append(omega) or again(hull, omega, folder)
    )
    second, _ = run_bem(hull, tmp_path / "out", jobs=1)
    assert seen == [pytest.approx(0.8)]
    # the fit of the finite-depth Green function is not the same to the last digit
    assert np.allclose(second.added_mass, hydro.added_mass, rtol=1e-5, atol=1e-5 * np.abs(hydro.added_mass).max())
    files = write_results(hull, hydro, tmp_path / "out")
    assert {f.suffix for f in files} == {".nc", ".1", ".3", ".hst"}
    back = read_wamit(tmp_path / "out" / "spar", density=1025.0, gravity=9.80665)
    scale = np.abs(hydro.excitation).max()
    assert np.allclose(back.excitation, hydro.excitation, atol=1e-5 * scale)  # WAMIT's digits
    assert np.linalg.eigvalsh(hydro.radiation_damping).min() >= -1e-9 * np.abs(hydro.radiation_damping).max()
    assert quality["zero_frequency_gap"][0] < 0.2
    (tmp_path / "spar.toml").write_text(SPAR.replace("4.0, -20.0", "4.0, -21.0"))
    with pytest.raises(ModelError, match="another hull"):
        run_bem(read_hull(tmp_path / "spar.toml"), tmp_path / "out", jobs=1)


def test_mirror_headings_follow_from_symmetry():
    heading = np.radians([0.0, 90.0, 180.0])
    force = np.arange(18.0).reshape(3, 1, 6) + 1
    full, values = full_circle(heading, force, "xz")
    assert np.degrees(full) == pytest.approx([-180, -90, 0, 90, 180])
    assert values[1, 0].tolist() == [7, -8, 9, -10, 11, -12]


def test_wrong_hull_files_say_what_is_wrong(tmp_path):
    for text, words in (
        ('kind = "raft"', "kind = one of"), ('kind = "barge"\nlength = 1.0\nwidth = 1.0', "draft, which a barge needs"),
        ('kind = "barge"\nlenght = 1.0', "a dimension of a barge"), (SPAR + "deepness = 3", "a setting of"),
    ):  # fmt: skip
        (tmp_path / "h.toml").write_text(text)
        with pytest.raises(FormatError, match=words):
            read_hull(tmp_path / "h.toml")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('kind = "barge"\nlength = -1.0\nwidth = "ten"\ndraft = 4.0\n[bem]\nmethod = "magic"\naround = 2.5', ("length is -1", "width is 'ten'", "direct or indirect", "around is 2.5")),
        ('kind = "barge"\nlength = 40.0\nwidth = 9.0\ndraft = 4.0\nmoonpool = 10.0\nmoonpool_cap = 0.05\n[bem]\ndepth = 3.0', ("barge is 40 x 9 m", "give 0, a deck at still water", "must be deeper")),
        ('kind = "spar"\nprofile = [[3.0, -1.0], [3.0, 5.0]]', ("must start at still water", "must go down")),
        ('kind = "spar"\nprofile = "round"', ("two or more pairs",)),
        ('kind = "tlp"\ndiameter = 10.0\ndraft = 20.0\npontoon_length = 9.0', ("pontoon_diameter is missing",)),
        ('kind = "tlp"\ndiameter = 10.0\ndraft = 20.0\npontoon_length = 9.0\npontoon_diameter = 11.0\npontoons = 3', ("takes 4", "less than the column's")),
        ('kind = "semi"\ndiameter = 30.0\nradius = 20.0\ndraft = 20.0', ("overlap", "reach the central column")),
    ],
)
def test_hulls_that_cannot_be_are_refused_with_all_reasons(tmp_path, text, words):
    (tmp_path / "h.toml").write_text(text)
    with pytest.raises(CaseError) as error:
        read_hull(tmp_path / "h.toml")
    for word in words:
        assert word in str(error.value)
    assert len(error.value.problems) == len(words)


def test_database_is_built_resumed_packed_and_its_damage_found(tmp_path):
    plan = DatabasePlan(
        diameter=(14.0, 20.0, 2), radius=(30.0, 45.0, 2), draft=(20.0, 32.0, 1), depths=(np.inf, 200.0), depth_points=(1, 1, 1),
        scaled_frequency=(0.5, 1.5, 2.5), headings_deg=(0.0, 60.0), panels=(1, 1, 1, 1), around=6,
    )  # fmt: skip
    with pytest.raises(ModelError, match="5 of 5 solutions are missing"):
        collect(plan, tmp_path)
    counts = []
    solve_plan(plan, tmp_path / "work", jobs=1, progress=lambda done, total: counts.append((done, total)))
    solve_plan(plan, tmp_path / "work", jobs=1, progress=lambda done, total: counts.append((done, total)))
    assert counts[0] == (0, 5)
    assert counts[-1] == (5, 5)
    database = collect(plan, tmp_path / "work")
    path = write_database(database, tmp_path / "family.nc", plan)
    back = read_database(path)
    # 18 binary digits are kept of deep water and of the change from it: each is rounded by 2^-18 of itself or less
    assert np.allclose(back.values[0], database.values[0], rtol=2.0**-18, atol=0)
    assert np.allclose(back.values, database.values, rtol=0, atol=2.0**-17 * np.abs(database.values).max(axis=(0, 1, 2, 3, 4)))
    assert np.any(back.values[0] != back.values[1])  # the bottom is felt
    raw = bytearray(path.read_bytes())
    import h5py

    with h5py.File(path, "r+") as file:
        file["infinite"][0, 0, 0, 0] *= 1.001
    with pytest.raises(FormatError, match="checksum"):
        read_database(path)
    path.write_bytes(raw)
    with pytest.raises(ModelError, match="another plan"):
        solve_plan(DatabasePlan(), tmp_path / "work", jobs=1)


TINY_PLAN = """
diameter = [14.0, 20.0, 2]
radius = [40.0, 40.0, 1]
draft = [26.0, 26.0, 1]
depths = [inf]
scaled_frequency = [0.5, 1.5, 2.0, 2.5]
panels = [1, 1, 1, 1]
around = 6
"""


def test_build_check_and_info_work_on_any_plan(tmp_path, monkeypatch):
    from typer.testing import CliRunner

    from fowtio.cli import app

    monkeypatch.chdir(tmp_path)
    (tmp_path / "plan.toml").write_text(TINY_PLAN)
    built = CliRunner().invoke(app, ["database", "build", "--plan", "plan.toml", "-o", "tiny.nc", "--jobs", "1", "--json"])
    assert built.exit_code == 0, built.output
    assert database_plan("tiny.nc") == read_plan("plan.toml")
    assert "verified" in CliRunner().invoke(app, ["database", "info", "tiny.nc"]).output
    found = CliRunner().invoke(app, ["database", "check", "tiny.nc", "--hulls", "1", "--depth", "inf", "--jobs", "1", "--json"])
    assert found.exit_code == 3  # two hulls and four frequencies cannot hold 1 %
    errors = json.loads(found.stdout)["hulls"][0]["errors"]
    assert max(errors.values()) > 0.01


@pytest.mark.parametrize(
    ("text", "words"),
    [("panles = [1]", "panles"), ("around = [6]", "around like 14"), ("diameter = [14.0, 20.0]", "diameter like"), ("around = ", "TOML")],
)
def test_a_wrong_plan_is_refused(tmp_path, text, words):
    (tmp_path / "plan.toml").write_text(text)
    with pytest.raises(FormatError, match=words):
        read_plan(tmp_path / "plan.toml")


def test_bem_command_reports_as_json(tmp_path):
    from typer.testing import CliRunner

    from fowtio.cli import app

    (tmp_path / "spar.toml").write_text(SPAR)
    result = CliRunner().invoke(
        app, ["bem", str(tmp_path / "spar.toml"), "-o", str(tmp_path / "o"), "--jobs", "1", "--json"]
    )
    assert result.exit_code == 0, result.output
    document = json.loads(result.stdout)
    assert document["volume"] == pytest.approx(np.pi * 16 * 20, rel=1e-9)
    assert {f.rsplit(".", 1)[1] for f in document["files"]} == {"nc", "1", "3", "hst", "png"}


@pytest.mark.slow
def test_a_dask_cluster_gives_the_same_file_to_the_bit(tmp_path):
    distributed = pytest.importorskip("distributed", reason="Dask is not installed: pip install fowtio[cluster]")
    plan = DatabasePlan(
        diameter=(14.0, 20.0, 2), radius=(30.0, 45.0, 1), draft=(20.0, 32.0, 1), depths=(np.inf,), scaled_frequency=(0.5, 1.5, 2.0, 2.5),
        headings_deg=(0.0, 60.0), panels=(1, 1, 1, 1), around=6,
    )  # fmt: skip
    files = []
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        for name, options in (("joblib", {"jobs": 2}), ("dask", {"dask": cluster.scheduler_address})):
            counts = []
            solve_plan(plan, tmp_path / name, progress=lambda done, total, kept=counts: kept.append((done, total)), **options)
            files.append(write_database(collect(plan, tmp_path / name), tmp_path / f"{name}.nc", plan).read_bytes())
            assert counts[-1] == (2, 2)
    # deep water: the Green function is tabulated, not fitted, and both ways run the same code; nothing may differ
    assert files[0] == files[1]
