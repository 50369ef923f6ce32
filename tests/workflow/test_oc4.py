"""The embedded case against OpenFAST 5.0, MoorPy and its own limits. Reference numbers are of the OpenFAST 5.0 reference runs."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import trapezoid

import fowtio
from fowtio.case import StateEntry
from fowtio.read.openfast_lin import read_openfast_lin
from fowtio.workflow import build, loads, solve_states
from model.conventions import rotation
from model.environment.sea import SeaState
from model.response.solve import DRAG_MODELS
from model.system.contributions import hydrostatic_contribution, mooring_contribution, platform_contribution
from model.system.identified import perturbation_error, second_order
from model.system.mooring import mooring_state
from model.system.turbine import structural_matrices


def period(point, name, kind="frequency"):
    return 2 * np.pi / getattr(point.modes, kind)[point.modes.names.index(name)]


# --- natural periods -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("mode", "seconds", "tolerance"),
    [("surge", 112.95, 0.02), ("heave", 17.064, 0.02), ("pitch", 25.587, 0.02), ("tower_fa1", 2.3103, 0.01)],
)
def test_periods_of_free_decay(oc4, mode, seconds, tolerance):
    """Decays of 400 to 800 s in still water; drag shifts a decay's period by less than 1 %, hence 2 %."""
    assert period(oc4.at(0.0), mode) == pytest.approx(seconds, rel=tolerance)


def test_yaw_with_the_infinite_frequency_added_mass(oc4):
    """What OpenFAST's linearisation shows: its constant matrices hold the added mass of infinite frequency, 76.3 s."""
    assert period(oc4.at(0.0), "yaw", "frequency_infinite") == pytest.approx(76.3, rel=0.02)


def test_yaw_with_the_added_mass_of_its_own_frequency(oc4):
    """79.7 s: inertia 1.2286e10 kg m2 (deck) + 6.6e9 (data near zero frequency), stiffness 1.172e8 N m (reference linearisation)."""
    own = oc4.hydro.added_mass_zero[5, 5] + 1.2286e10
    assert period(oc4.at(0.0), "yaw") == pytest.approx(2 * np.pi * np.sqrt(own / 1.172e8), rel=0.01)
    assert period(oc4.at(0.0), "yaw") == pytest.approx(79.7, rel=0.01)


@pytest.mark.parametrize("k", [0, 1, 3, 4, 5])
def test_added_mass_and_damping_belong_together(oc4, k):
    """Ogilvie: A(0) - A(inf) = 2/pi times the integral of B / omega^2, so the added mass at low frequency is no artefact.

    Data end at 3 rad/s and are spaced 0.025 to 0.1 rad/s apart: 2 %. (Heave is left out: its zero-frequency row was computed in
    infinite depth, which matters at 25 % of a difference of 4 %.)
    """
    h = oc4.hydro
    damping, omega = np.r_[0.0, h.radiation_damping[:, k, k] / h.omega**2], np.r_[0.0, h.omega]
    difference = h.added_mass_zero[k, k] - h.added_mass_infinite[k, k]
    assert 2 / np.pi * trapezoid(damping, omega) == pytest.approx(difference, rel=0.02)


def test_periods_of_the_linearisation(oc4):
    """Eigenfrequencies of OpenFAST's parked linearisation, infinite-frequency added mass: 0.00931, 0.0393, 0.0397, 0.05879, 0.4331 Hz."""
    point = oc4.at(0.0)
    for mode, hz in (
        ("surge", 0.00931),
        ("sway", 0.00931),
        ("roll", 0.0397),
        ("pitch", 0.0393),
        ("heave", 0.05879),
        ("tower_fa1", 0.4331),
    ):
        # given with three or four digits; damping does not matter
        assert 1 / period(point, mode, "frequency_infinite") == pytest.approx(hz, rel=2e-3), mode


# --- matrices against OpenFAST's linearisation -----------------------------------------------------------------------


@pytest.fixture(scope="module")
def parked(oc4):
    """OpenFAST's linearisation of the floating parked turbine, and the same from the deck alone."""
    entry, deck = oc4.case.linearisations[0], oc4.deck
    structure = deck.elastodyn.structure
    found = second_order([read_openfast_lin(f) for f in entry.files], structure.tower.top_height)
    turbine = structural_matrices(structure, ("tower_fa1",))
    body = platform_contribution(structure.platform, deck.gravity, "")
    return found, turbine, body


def wide(matrix):
    return np.pad(matrix, ((0, 1), (0, 1)))


def scale(matrix):
    d = np.abs(np.diag(matrix))
    return np.sqrt(np.outer(d, d))


def test_mass_of_the_deck_alone(oc4, parked):
    """All entries within 1e-3 of the geometric mean of their diagonals: 2e-6, but for roll-yaw, 7e-4 (order of finite rotations).

    OpenFAST's is at the mean position, so the bodies are turned by its 0.08 degrees of pitch.
    """
    found, turbine, body = parked
    turn = np.eye(7)
    turn[:3, :3] = turn[3:6, 3:6] = rotation(found.point[3:6])
    own = turn @ (turbine.mass + wide(body.mass)) @ turn.T + wide(oc4.hydro.added_mass_infinite)
    difference = np.abs(own - found.mass) / scale(found.mass)
    assert difference.max() < 1e-3
    assert np.diag(difference).max() < 2e-6
    difference[3, 5] = difference[5, 3] = 0.0
    assert difference.max() < 1e-5


def test_entries_that_matter_agree(oc4, parked):
    """Not turned, entry by entry where above 2e-3 of its diagonals (below, the mean pitch's own part shows): within 0.5 %."""
    found, turbine, body = parked
    own = turbine.mass + wide(body.mass) + wide(oc4.hydro.added_mass_infinite)
    matter = np.abs(found.mass) > 2e-3 * scale(found.mass)
    assert matter.sum() > 12
    assert np.allclose(own[matter], found.mass[matter], rtol=5e-3)


def test_stiffness_of_the_deck_alone(oc4, parked):
    """Weight, buoyancy, moorings, tower: 0.5 % of the diagonals everywhere, 1e-5 in roll, pitch, heave, tower; surge 4e-4 (MAP's step)."""
    found, turbine, body = parked
    deck = oc4.deck
    parts = [
        body,
        hydrostatic_contribution(oc4.hydro, ""),
        mooring_contribution(deck.mooring, found.point[:6], ""),
    ]
    own = turbine.stiffness + sum(wide(p.stiffness) for p in parts)
    error = perturbation_error(found.mass - wide(oc4.hydro.added_mass_infinite), found.dofs, deck.gravity)
    other = found.stiffness - error
    difference = np.abs(own - other) / scale(other)
    assert difference.max() < 5e-3
    assert np.diag(difference)[[2, 3, 4, 6]].max() < 1e-5
    assert np.diag(difference).max() < 4e-4
    assert difference[4, 6] < 1e-5
    assert difference[6, 4] < 1e-5


def test_study_without_linearisations_gives_the_same_motions(oc4, oc4_loads):
    """The parked turbine from the deck alone instead of OpenFAST's linearisation: standard deviations within 0.3 %.

    Stiffness differs by 0.04 % in surge (MAP's finite step) and by the mean pitch's own part; grids follow each model's modes.
    """
    model = build(replace(oc4.case, linearisations=(), states=oc4.states[:1]))
    item = loads(solve_states(model))[0]
    a, b = item.statistics.std, oc4_loads["white_noise"].statistics.std
    for name in (
        "PtfmSurge",
        "PtfmHeave",
        "PtfmPitch",
        "TTDspFA",
        "NcIMUTAxs",
        "TwrBsFxt",
        "TwrBsMyt",
        "T[1]",
        "T[2]",
        "T[3]",
    ):
        k = item.channels.index(name)
        assert a[k] == pytest.approx(b[k], rel=3e-3), name


# --- white noise -----------------------------------------------------------------------------------------------------

WHITE_NOISE = {
    "PtfmSurge": 1.7041, "PtfmHeave": 0.33219, "PtfmPitch": np.radians(0.23489), "TTDspFA": 0.023515, "TwrBsFxt": 68.028e3,
    "TwrBsMyt": 4581.3e3, "NcIMUTAxs": 0.11233, "T[1]": 39_153.0, "T[2]": 79_509.0,
}  # fmt: skip


@pytest.mark.parametrize("channel", WHITE_NOISE)
def test_standard_deviations_in_white_noise(oc4_validation, channel):
    """Six seeds of 6000 s: within 2 %, the tolerance of the study; the reference's own values are read right."""
    found = next(c for c in oc4_validation.channels if c.name == channel)
    assert found.std_reference == pytest.approx(WHITE_NOISE[channel], rel=1e-3)
    assert abs(found.std_error) < 0.02
    assert found.passed


def test_shape_of_the_response_in_white_noise(oc4_validation):
    """Energy-weighted RAO error below 5 %; waves explain most of the motion; resonances within 1 % where the estimate is 0.001 Hz wide."""
    for c in oc4_validation.channels:
        assert c.rao_error < 0.05, c.name
        assert c.coherence_mean > 0.9, c.name
        assert abs(c.peak_frequency_error) < 0.01, c.name
        assert abs(c.peak_error) < 0.10, c.name
    assert oc4_validation.passed
    assert len(oc4_validation.files) == 6


@pytest.mark.parametrize(
    ("channel", "plain"), [("PtfmSurge", 0.028), ("PtfmHeave", 0.026), ("PtfmPitch", 0.037), ("TTDspFA", 0.022)]
)
def test_better_than_a_plain_model(oc4_validation, channel, plain):
    """RAO errors of an independent frequency-domain code with Borgman drag and a point-mass turbine against the same records."""
    found = next(c for c in oc4_validation.channels if c.name == channel)
    assert found.rao_error < plain


def test_coherence_in_white_noise(oc4_validation):
    """The model's coherence is the reference's, at the resonances too, where drag answers the waves incoherently."""
    f, found = oc4_validation.estimate.frequency, oc4_validation.estimate.coherence
    inside = (f > 0.007) & (f < 0.195)
    for name in ("PtfmHeave", "PtfmPitch", "TTDspFA"):
        k = [c.name for c in oc4_validation.channels].index(name)
        model, reference = oc4_validation.model_coherence[inside, k], found[inside, k]
        # an estimate's own scatter is sqrt(2 / n) gamma (1 - gamma^2), 0.03 where coherence is 0.76 and n = 63; four of them among 190 bins
        scatter = np.sqrt(2 / oc4_validation.estimate.averages) * np.sqrt(model) * (1 - model)
        assert np.mean(np.abs(model - reference) < 4 * scatter + 0.01) > 0.97, name
    at, pitch = np.argmin(np.abs(f - 0.039)), [c.name for c in oc4_validation.channels].index("PtfmPitch")
    assert oc4_validation.model_coherence[at, pitch] == pytest.approx(found[at, pitch], abs=0.06)


def test_run_and_validation_agree(oc4_loads, oc4_validation):
    """Two routes to the same number: the run's spectrum of the study's sea, and the model on the reference's frequencies. 2 %."""
    item = oc4_loads["white_noise"]
    for c in oc4_validation.channels:
        assert item.statistics.std[item.channels.index(c.name)] == pytest.approx(c.std_model, rel=0.02), c.name


def test_quadratic_drag_explains_what_is_left(oc4):
    """With the drag force itself on the record of one seed the RAO error shrinks: the linearisation is what it consists of."""
    reference = replace(oc4.case.references[0], files=oc4.case.references[0].files[:1])
    found = {c.name: c for c in fowtio.validate(oc4, reference).channels}
    for name in ("PtfmSurge", "PtfmHeave", "PtfmPitch", "TTDspFA"):
        assert found[name].rao_error_nonlinear < found[name].rao_error
        assert abs(found[name].std_error_nonlinear) < 0.02


def test_a_wrong_model_does_not_pass(oc4):
    """Without the waves' part of the drag heave is 3 to 4 % low: the comparison can tell."""
    model = replace(oc4, case=replace(oc4.case, options=replace(oc4.case.options, drag_model="none")))
    assert not fowtio.validate(model, oc4.case.references[0], nonlinear=False).passed


# --- moorings --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("surge", [0.0, 5.0])
def test_moorings_agree_with_moorpy(oc4, surge):
    """Forces, stiffness and tensions of the embedded MAP file through another code; 0.5 %, MoorPy's own differences.

    Both without seabed friction, which MoorPy takes per line type and fowtio per line.
    """
    moorpy = pytest.importorskip("moorpy")
    ours = replace(oc4.deck.mooring, seabed_friction=np.zeros_like(oc4.deck.mooring.seabed_friction))
    other = moorpy.System(depth=200.0, rho=1025.0, g=9.80665)
    other.addBody(-1, np.zeros(6))
    # OC4 documents: 113.35 kg/m, 0.0766 m, 753.6 MN, 835.35 m, anchors at 837.6 m, fairleads at 40.868 m and -14 m
    chain = {"d_vol": 0.0766, "m": 113.35, "w": (113.35 - 1025.0 * np.pi / 4 * 0.0766**2) * 9.80665, "EA": 753.6e6}
    other.lineTypes["chain"] = chain | {"name": "chain"}
    for k, angle in enumerate(np.radians([60.0, 180.0, 300.0])):
        direction = np.array([np.cos(angle), np.sin(angle), 0.0])
        other.addPoint(1, 837.6 * direction - [0, 0, 200.0])
        other.addPoint(1, 40.868 * direction - [0, 0, 14.0])
        other.bodyList[0].attachPoint(2 * k + 2, 40.868 * direction - [0, 0, 14.0])
        other.addLine(835.35, "chain", pointA=2 * k + 1, pointB=2 * k + 2)
    other.initialize()
    other.bodyList[0].setPosition(np.array([surge, 0, 0, 0, 0, 0.0]))
    other.solveEquilibrium()
    state = mooring_state(ours, np.array([surge, 0, 0, 0, 0, 0.0]))
    tension = np.sort([max(line.TA, line.TB) for line in other.lineList])
    assert np.sort(state.fairlead_tension) == pytest.approx(tension, rel=5e-3)
    force = other.bodyList[0].getForces(lines_only=True)
    assert np.abs(state.force - force)[:3].max() < 5e-3 * np.abs(force).max()
    stiffness = other.getCoupledStiffnessA(lines_only=True)
    assert np.abs(state.stiffness - stiffness).max() <= 5e-3 * scale(stiffness).max()
    assert (np.abs(state.stiffness - stiffness) / scale(stiffness)).max() < 5e-3


# --- degrees of freedom and grid -------------------------------------------------------------------------------------


def in_white_noise(oc4, dofs=None, **options):
    case = replace(
        oc4.case, dofs=dofs or oc4.case.dofs, states=oc4.states[:1], options=replace(oc4.case.options, **options)
    )
    return loads(solve_states(build(case)))[0]


def test_six_and_seven_degrees_of_freedom(oc4_folder, oc4, tmp_path):
    """One line of the study. A rigid tower leaves surge and heave alone (1 %) and lacks the tower's channels; pitch gets stiffer."""
    text = (oc4_folder / "oc4.fowt").read_text().replace("7                DOFs", "6                DOFs")
    for part in ("input", "linearisation", "reference"):
        (tmp_path / part).symlink_to(oc4_folder / part)
    (tmp_path / "six.fowt").write_text(text)
    case = fowtio.load(tmp_path / "six.fowt")
    model = build(replace(case, states=case.states[:1]))
    six, seven = loads(solve_states(model))[0], in_white_noise(oc4)
    assert len(model.points[0].modes.names) == 6
    assert "TTDspFA" not in six.channels.names
    for name in ("PtfmSurge", "PtfmHeave"):
        assert six.statistics.std[six.channels.index(name)] == pytest.approx(
            seven.statistics.std[seven.channels.index(name)], rel=0.01
        )
    # the bent tower adds C57^2 / C77 = 7.6e6 N m to an overturning moment of 1.07e9: 0.36 % of the frequency at most
    assert 1.0 < period(model.points[0], "pitch") ** -1 * period(oc4.at(0.0), "pitch") < 1.02


def test_a_very_stiff_tower_is_rigid(oc4):
    """The seventh degree of freedom vanishes as its stiffness grows: all channels go to those of six."""
    deck_only = replace(oc4.case, linearisations=(), states=oc4.states[:1])
    six = loads(solve_states(build(replace(deck_only, dofs=deck_only.dofs[:6]))))[0]
    model = build(deck_only)
    point = model.points[0]
    stiff = [
        replace(p, stiffness=p.stiffness + np.diag([0.0] * 6 + [1e12])) if "turbine" in p.name else p
        for p in point.system.parts
    ]
    system = replace(point.system, parts=tuple(stiff))
    mean = replace(point.mean, stiffness=point.mean.stiffness + np.diag([0.0] * 6 + [1e12]))
    model = replace(model, points=(replace(point, system=system, mean=mean),))
    seven = loads(solve_states(model))[0]
    for name in ("PtfmSurge", "PtfmHeave", "PtfmPitch"):
        # the two frequency grids differ about their modes
        assert seven.statistics.std[seven.channels.index(name)] == pytest.approx(
            six.statistics.std[six.channels.index(name)], rel=3e-3
        )


def test_a_few_degrees_of_freedom_by_name(oc4):
    """Head waves on a symmetric floater: surge, heave and pitch alone give the same as all six (turbine's asymmetry: 0.1 %)."""
    few, six = (
        in_white_noise(oc4, ("surge", "heave", "pitch")),
        in_white_noise(oc4, ("surge", "sway", "heave", "roll", "pitch", "yaw")),
    )
    assert [n for n in few.channels.names if n.startswith("Ptfm")] == ["PtfmSurge", "PtfmHeave", "PtfmPitch"]
    for name in ("PtfmSurge", "PtfmHeave", "PtfmPitch"):
        assert few.statistics.std[few.channels.index(name)] == pytest.approx(
            six.statistics.std[six.channels.index(name)], rel=3e-3
        )


def test_grid_converges(oc4, oc4_loads):
    """400 frequencies against 3000: every channel that moves within 0.5 % in all states."""
    fine = build(replace(oc4.case, options=replace(oc4.case.options, frequency_count=3000)))
    for item in loads(solve_states(fine)):
        coarse = oc4_loads[item.state.name].statistics.std
        moving = (
            item.statistics.std
            > 1e-4 * item.statistics.std[[item.channels.units.index(u) for u in item.channels.units]].max()
        )
        moving &= item.statistics.std > 1e-6 * np.abs(item.channels.mean)
        for k in np.flatnonzero(moving):
            unit = item.channels.units[k]
            largest = max(s for s, u in zip(item.statistics.std, item.channels.units, strict=True) if u == unit)
            if item.statistics.std[k] > 1e-3 * largest:
                assert coarse[k] == pytest.approx(item.statistics.std[k], rel=5e-3), (
                    item.state.name,
                    item.channels.names[k],
                )


def test_drag_models_of_a_study(oc4):
    """Each choice runs, none of them the same; without drag heave's resonance is far too high."""
    found = {m: in_white_noise(oc4, drag_model=m).statistics.std for m in DRAG_MODELS}
    assert len({round(v[0], 4) for v in found.values()}) == len(DRAG_MODELS)
    assert found["none"][2] > 1.5 * found["relative"][2]


def test_low_frequency_limit_of_the_excitation(oc4):
    """Excitation to its hydrostatic limit instead of held: surge below 0.05 rad/s gets less, heave is where it was."""
    hold, limit = in_white_noise(oc4), in_white_noise(oc4, low_frequency_excitation="hydrostatic")
    assert limit.statistics.std[0] < hold.statistics.std[0]
    assert limit.statistics.std[2] == pytest.approx(hold.statistics.std[2], rel=0.01)


# --- states ----------------------------------------------------------------------------------------------------------


def state(heading, **sea):
    values = {"kind": "jonswap", "significant_height": 5.0, "peak_period": 11.0} | sea
    return StateEntry(
        name="trial", wind_speed=0.0, turbulence=None, sea=SeaState(heading=np.radians(heading), **values)
    )


@pytest.fixture(scope="module")
def at_headings(oc4):
    model = build(replace(oc4.case, linearisations=(), states=(state(0.0),)))
    return {h: loads(solve_states(model, [state(h)]))[0] for h in (0.0, 45.0, -45.0, 120.0)}


def test_mirrored_headings(at_headings):
    """Waves from port or starboard: the same statistics, lines 1 and 3 exchanged. The rotor's asymmetry is 1e-4 of it."""
    a, b = at_headings[45.0], at_headings[-45.0]
    other = {"T[1]": "T[3]", "T[3]": "T[1]"}
    for k, name in enumerate(a.channels.names):
        if name == "PtfmYaw":
            continue  # yaw of a symmetric hull comes from the turbine alone
        assert a.statistics.std[k] == pytest.approx(
            b.statistics.std[b.channels.index(other.get(name, name))], rel=2e-3
        ), name


def test_line_that_faces_the_waves_works_hardest(at_headings):
    """Heading 0 (waves towards +x): line 2, upwave along -x. Heading 120: the line upwave of it is that towards (+418, -725), line 3."""
    for heading, line in ((0.0, "T[2]"), (120.0, "T[3]")):
        item = at_headings[heading]
        std = {n: s for n, s in zip(item.channels.names, item.statistics.std, strict=True) if n.startswith("T[")}
        assert max(std, key=std.get) == line


def test_waves_turned_by_120_degrees(at_headings):
    """Three-fold symmetry of hull and lines: heave alike (2 %: unequal panels), surge becomes motion at 120 degrees."""
    a, b = at_headings[0.0], at_headings[120.0]
    assert b.statistics.std[2] == pytest.approx(a.statistics.std[2], rel=0.02)
    assert np.hypot(*b.statistics.std[:2]) == pytest.approx(a.statistics.std[0], rel=0.02)
    assert b.statistics.std[1] / b.statistics.std[0] == pytest.approx(np.tan(np.radians(60.0)), rel=0.05)


def test_wind_moves_the_turbine(oc4_loads):
    """Turbulence at 11 m/s adds to the waves: surge and pitch are mostly the wind's, heave the waves'."""
    item = oc4_loads["operating"]
    drive = item.response.excitation
    gusts = trapezoid(np.abs(item.channels.to_wind) ** 2 * drive.wind_spectrum[:, None], drive.omega, axis=0)
    share = gusts / item.statistics.std**2
    assert share[item.channels.index("PtfmSurge")] > 0.5
    assert share[item.channels.index("PtfmHeave")] < 0.2


def test_what_was_assumed_is_said(oc4):
    """Notes name what the study does not model or had to guess."""
    model = build(replace(oc4.case, linearisations=(), states=(state(0.0),)))
    assert any("parked turbine from the deck's structural data" in note for note in model.notes)


def test_a_deck_alone_is_a_study(oc4_folder):
    """fowtio reads a primary file without a study: the deck's own sea and degrees of freedom."""
    model = build(fowtio.load(oc4_folder / "input" / "oc4.fst"))
    (entry,) = model.states
    assert entry.sea.significant_height == pytest.approx(2.0)
    assert entry.sea.peak_period == pytest.approx(10.0)
    assert model.points[0].system.dofs[-1] == "tower_fa1"
    assert loads(solve_states(model))[0].statistics.std[0] > 0
