"""The embedded OC4 case as an FMU beside the frequency-domain model and OpenFAST."""

import numpy as np
import pytest
from fmu_samples import make
from scipy.optimize import least_squares

from fowtio.fmu.build import export_fmu, linearise, write_fmu
from fowtio.fmu.check import LARGEST, MAGNITUDE, PHASE, check_file, check_fmu, compare_responses
from fowtio.fmu.describe import describe, turbulence_table
from fowtio.fmu.runner import Runner
from fowtio.fmu.simulate import simulate
from model.conventions import PLATFORM_DOFS
from model.environment.sea import SeaState, wave_spectrum
from model.environment.wind import WindState
from model.reduce.importance import excited
from model.reduce.state_space import modal_form, state_space
from model.reduce.targets import force_gain
from model.response.assemble import natural_modes

MOTIONS = [f"Platform.{d.capitalize()}" for d in PLATFORM_DOFS]


def test_files_follow_the_rules(parked):
    """Rules of the standard, warnings of the compiler, size: of both versions."""
    findings = [f for path in parked.files.values() for f in check_file(path)]
    assert len(findings) == 6
    assert all(f.passed for f in findings), findings
    assert all(p.stat().st_size < LARGEST for p in parked.files.values())


@pytest.mark.parametrize(("version", "driven"), [("2.0", "elevation"), ("3.0", "wave_force")])
def test_responses(parked, version, driven):
    """RAOs by wave forces and by the wave elevation within 2 % and 2 degrees, between the data too."""
    found = compare_responses(parked, parked.files[version], driven)
    assert found.counted.any(axis=0).sum() >= 10  # the channels that head waves move
    assert found.magnitude_error().max() < MAGNITUDE
    assert found.phase_error().max() < PHASE


@pytest.mark.slow
@pytest.mark.parametrize("state", ["operating", "storm"])
def test_responses_of_the_other_states(oc4, tmp_path, state):
    exported = export_fmu(oc4, tmp_path / "oc4.fmu", state=state)
    assert all(f.passed for f in check_fmu(exported)), check_fmu(exported)


@pytest.mark.slow
@pytest.mark.parametrize("study", ["oc3_spar/oc3", "mit_tlp/tlp", "iti_barge/iti", "semi_10mw/semi_10mw", "oc4_deepcwind/oc4_flexible"])
def test_other_studies(oc4_folder, tmp_path, study):
    """A spar, a tension-leg platform, a barge, a larger semisubmersible and a flexible rotor: every check is met, by both drives."""
    import fowtio

    model = fowtio.build(fowtio.load(oc4_folder.parent / f"{study}.fowt"))
    findings = check_fmu(export_fmu(model, tmp_path / "other.fmu", inputs=("wave_force", "elevation")))
    assert all(f.passed for f in findings), findings


def test_a_rigid_tower(parked, oc4, tmp_path):
    """Six degrees of freedom: the same fits, one state pair less, and the same responses as the model of six."""
    from dataclasses import replace

    import fowtio

    case = replace(oc4.case, dofs=PLATFORM_DOFS)
    six = fowtio.build(case)
    found = linearise(six, "white_noise", inputs=("wave_force",))
    description = describe(found.space, modal_form(found.space), identifier="Rigid")
    path = write_fmu(description, tmp_path / "rigid.fmu")
    exported = type(parked)(files={"2.0": path}, description=description, linearised=found)
    compared = compare_responses(exported, path, "wave_force")
    assert compared.magnitude_error().max() < MAGNITUDE
    assert compared.phase_error().max() < PHASE
    assert not any(n.startswith("Tower.TopDeflection") for n in (v.name for v in description.variables))


def test_free_decay_has_the_models_periods_and_damping(parked):
    """Released in the shape of each natural mode: period within 0.5 %, damping within 2 % of the model's complex modes."""
    found = parked.linearised
    modes = natural_modes(found.point.system, found.point.mean, found.response.drag_damping)
    dofs = found.point.system.dofs
    with Runner(parked.files["2.0"]) as runner:
        for k, name in enumerate(modes.names):
            omega, zeta = modes.frequency[k], modes.damping_ratio[k]
            shape = modes.shape[:, k]
            rate = shape * complex(-zeta * omega, omega * np.sqrt(1 - zeta**2))
            start = {_initial(d): shape[i].real for i, d in enumerate(dofs)}
            start |= {_initial(d) + "Velocity": rate[i].real for i, d in enumerate(dofs)}
            channel = "Tower.TopDeflectionFA" if name == "tower_fa1" else f"Platform.{name.capitalize()}"
            step = 2 * np.pi / omega / 40
            series = runner.run(40 * 12, step, {}, [channel], start)[:, 0]
            t = np.arange(len(series)) * step
            use = t > 2 * 2 * np.pi / omega  # two cycles for the memory of the water to settle
            period, damping = _fit_decay(t[use], series[use], omega, zeta)
            assert period == pytest.approx(2 * np.pi / (omega * np.sqrt(1 - zeta**2)), rel=0.005), name
            assert damping == pytest.approx(zeta, rel=0.02, abs=2e-5), name


def test_the_internal_sea_is_the_sea(parked):
    """A JONSWAP sea made inside: its spectrum, and responses that are the model's RAO times its elevation, line by line."""
    lines, period = _sea_lines(parked.files["2.0"], {"Sea.Hs": 4.0, "Sea.Tp": 11.0, "Sea.Gamma": 2.0})
    omega = 2 * np.pi * np.arange(len(lines)) / period
    known = wave_spectrum(SeaState(kind="jonswap", significant_height=4.0, peak_period=11.0, gamma=2.0), omega)
    band = (omega > 0.7 * 2 * np.pi / 11) & (omega < 2.0)  # where a JONSWAP sea has energy
    amplitude = np.abs(lines[band, 0])
    assert np.allclose(amplitude**2 / 2 * period / (2 * np.pi), known[band], rtol=1e-6)  # amplitudes are not random
    variance = (np.abs(lines[1:, 0]) ** 2 / 2).sum()
    assert 4 * np.sqrt(variance) == pytest.approx(4.0, rel=0.01)  # IEC's normalisation, and the cut tails
    _assert_responses(parked, lines, omega, band, column=parked.linearised.column)


def test_the_internal_sea_from_another_heading(parked):
    """Waves from abeam: force interpolated from the table at 90 degrees."""
    angle = np.pi / 2
    waves = parked.linearised.waves
    column = (
        parked.linearised.column + 1 + int(np.argmin(np.abs(waves.heading[parked.linearised.column + 1 :] - angle)))
    )
    assert waves.heading[column] == pytest.approx(angle)
    lines, period = _sea_lines(
        parked.files["3.0"], {"Sea.Hs": 4.0, "Sea.Tp": 11.0, "Sea.Gamma": 2.0, "Sea.Heading": angle}
    )
    omega = 2 * np.pi * np.arange(len(lines)) / period
    band = (omega > 0.7 * 2 * np.pi / 11) & (omega < 2.0)
    _assert_responses(parked, lines, omega, band, column=column)


def test_seeds_make_other_seas_of_the_same_height(parked):
    with Runner(parked.files["2.0"]) as runner:
        runs = [runner.run(6000, 0.1, {}, ["Sea.Elevation"], {"Sea.Hs": 3.0, "Sea.Seed": s})[:, 0] for s in (1, 1, 2)]
    assert np.array_equal(runs[0], runs[1])
    assert abs(np.corrcoef(runs[0], runs[2])[0, 1]) < 0.3


def test_a_force_at_the_tower_top(parked):
    """A constant force: the static offset of the model's stiffness, and shear and moment at the tower base by statics."""
    found = parked.linearised
    system, mean = found.point.system, found.point.mean
    force = 1e5
    outputs = [*MOTIONS, "Tower.TopDeflectionFA", "Tower.BaseShearFA", "Tower.BaseMomentFA"]
    with Runner(parked.files["2.0"]) as runner:
        # one step of a million seconds: exact discretisation has no limit, and all has died out
        rest, loaded = (runner.run(1, 1e6, {"Tower.TopForceX": [f, f]}, outputs)[1] for f in (0.0, force))
    top, base = 87.6, 10.0  # m: the OC4 tower (NREL/TP-5000-60601, table 2-1)
    generalised = np.zeros(len(system.dofs))
    (
        generalised[system.dofs.index("surge")],
        generalised[system.dofs.index("pitch")],
        generalised[system.dofs.index("tower_fa1")],
    ) = force, force * top, force
    offset = np.linalg.solve(mean.stiffness, generalised)
    change = loaded - rest
    for k, dof in enumerate(PLATFORM_DOFS):
        assert change[k] == pytest.approx(offset[system.dofs.index(dof)], rel=1e-6, abs=1e-9)
    assert change[6] == pytest.approx(offset[system.dofs.index("tower_fa1")], rel=1e-6)
    rows = found.point.outputs
    weight = rows.position[rows.names.index("TwrBsFxt")] @ offset
    assert change[7] == pytest.approx(force + weight, rel=1e-6)
    moment = rows.position[rows.names.index("TwrBsMyt")] @ offset
    assert change[8] == pytest.approx(force * (top - base) + moment, rel=1e-6)


def test_a_force_at_the_platform_and_a_wave_force_are_alike(parked):
    with Runner(parked.files["3.0"]) as runner:
        pull = np.sin(0.3 * np.arange(601) * 0.5) * 1e6
        a = runner.run(600, 0.5, {"Platform.ExternalForceX": pull, "Platform.ExternalMomentY": -20 * pull}, MOTIONS)
        b = runner.run(600, 0.5, {"Wave.ForceX": pull, "Wave.MomentY": -20 * pull}, MOTIONS)
    assert np.allclose(a, b, atol=1e-12)
    assert np.ptp(a[:, 0]) > 0.1


def test_wind(parked, oc4, tmp_path):
    """Wind from outside: the static response of the linearisation; turbulence inside: the standard deviation of its spectrum."""
    point = oc4.at(11.0)
    structure = oc4.deck.elastodyn.structure
    space = state_space(
        point.system,
        point.mean,
        point.outputs,
        parked.linearised.response.drag_damping,
        parked.linearised.radiation,
        structure=structure,
        inputs=("wind",),
    )
    wind = WindState(
        mean_speed=11.0,
        hub_height=90.0,
        rotor_diameter=126.0,
        spectrum="kaimal",
        averaging="rotor",
        turbulence_intensity=0.2,
    )
    table = turbulence_table(wind, point.rotor, 0.0)
    path = write_fmu(
        describe(space, modal_form(space), identifier="Windy", wind_speed=11.0, turbulence=table),
        tmp_path / "windy.fmu",
    )
    with Runner(path) as runner:
        assert runner.constant("Wind.Speed") == 11.0
        one = runner.run(
            1, 1e7, {"Wind.Speed": [12.0, 12.0]}, ["Platform.Pitch", "Wind.HubSpeed", "Wind.RelativeSpeed"]
        )
        gusty = runner.run(
            36000,
            0.1,
            {},
            ["Wind.HubSpeed", "Platform.Pitch"],
            {"Wind.TurbulenceIntensity": 0.2, "Wind.MeanOffset": 0.5},
        )
    static = np.linalg.solve(point.mean.stiffness, point.system.wind_force)
    level = point.mean.offset[point.system.dofs.index("pitch")]
    assert one[1, 0] - level == pytest.approx(static[point.system.dofs.index("pitch")], rel=1e-6)
    assert one[1, 1] == pytest.approx(12.0)
    assert one[1, 2] == pytest.approx(12.0)  # at rest, the hub does not move
    assert gusty[:, 0].mean() == pytest.approx(11.5, abs=0.01)  # a whole period of the record
    from model.environment.rotor_wind import rotor_spectra

    omega = 2 * np.pi * np.linspace(1 / 3600, 0.8, 20000)
    spectrum = rotor_spectra(wind, point.rotor, omega)[0]
    # from the first line's lower edge on; the sum of lines against the integral of a spectrum that falls steeply there
    assert gusty[:, 0].std() == pytest.approx(np.sqrt(np.trapezoid(spectrum, omega)), rel=0.03)
    assert gusty[:, 1].std() > 1e-4


def test_beside_openfast(parked, oc4_folder):
    """Driven by OpenFAST's own wave record: its motions and loads, the linearised drag apart."""
    found = simulate(parked.files["2.0"], elevation=oc4_folder / "reference" / "wn7_s1.outb")
    by_channel = {m.channel: m for m in found.matches}
    assert {"PtfmSurge", "PtfmHeave", "PtfmPitch", "TwrBsMyt"} <= set(by_channel)
    for match in by_channel.values():
        assert match.correlation > 0.97, match  # 0.98 is what the drag's linearisation leaves in pitch
        assert abs(match.std_error) < 0.04, match  # one record: its own scatter is about two per cent


def test_the_inputs_are_chosen_at_export(parked):
    names = {v.name for v in parked.description.of_kind("input")}
    assert {"Wave.Elevation", "Wave.ForceX", "Platform.ExternalMomentZ", "Tower.TopForceX"} <= names
    assert "Wind.Speed" not in names  # the state is calm
    shift = next(v for v in parked.description.variables if v.name == "Wave.TimeShift")
    assert shift.start == parked.linearised.excitation.shift > 0


def test_a_reduced_model(parked, tmp_path):
    """Balanced reduction: fewer states, and motions that stay within the bound's order."""
    from model.reduce.state_space import reduce_balanced, transfer

    full = parked.linearised.space
    small, _, bound = reduce_balanced(full, tolerance=1e-3)
    assert small.order < 0.7 * full.order
    omega = np.linspace(0.03, 3.0, 60)
    a, b = transfer(full, omega), transfer(small, omega)
    surge, elevation = full.outputs.index("PtfmSurge"), full.inputs.index("elevation")
    peak = np.abs(a[:, surge, elevation]).max()
    assert np.abs(a - b)[:, surge, elevation].max() < 1e-2 * peak
    assert write_fmu(make(small, "Small"), tmp_path / "small.fmu").is_file()
    assert bound > 0


# --- what the tests above share


def _initial(dof: str) -> str:
    return {"tower_fa1": "Initial.TowerFA1"}.get(dof, f"Initial.{dof.capitalize()}")


def _fit_decay(t, x, omega, zeta):
    """Return damped period and damping ratio of a decaying cosine with a slow remainder, by least squares."""

    def model(p):
        return np.exp(-p[0] * p[1] * t) * (p[2] * np.cos(p[1] * t) + p[3] * np.sin(p[1] * t)) + p[4]

    scale = np.abs(x - x.mean()).max()
    found = least_squares(
        lambda p: (model(p) - x) / scale,
        [zeta, omega, scale, 0.0, x.mean()],
        x_scale=[zeta, omega * zeta, scale, scale, scale],
    )
    return 2 * np.pi / found.x[1], found.x[0] / np.hypot(1, found.x[0])


def _sea_lines(path, start):
    """Return Fourier amplitudes (n, 1 + 6) of the sea's elevation and the motions over the third hour, and the period [s]."""
    period, step = 3600.0, 0.1
    with Runner(path) as runner:
        series = runner.run(3 * 36000, step, {}, ["Sea.Elevation", *MOTIONS], start)
    return np.fft.rfft(series[2 * 36000 : 3 * 36000], axis=0) / 18000, period


def _assert_responses(parked, lines, omega, band, column):
    """Compare the RAOs of the lines at the frequencies of the data with the model's, where they are large enough."""
    found = parked.linearised
    data = np.unique([np.argmin(np.abs(omega - w)) for w in found.data])
    gain = force_gain(found.point.system, found.point.mean, found.point.outputs, found.response.drag_damping, omega[data])
    known = np.einsum("nck,nk->nc", gain, found.waves.at(omega[data], column))[:, :6]
    counted = excited(np.abs(known), ["m"] * 3 + ["rad"] * 3) & band[data][:, None]
    rao = lines[data, 1:7] / np.where(band[data], lines[data, 0], 1.0)[:, None]
    assert counted.any(axis=0).sum() >= 3
    ratio = rao[counted] / known[counted]
    # as the RAOs by forces; and the straight line between samples of the sea: (w h)^2 / 12, 0.3 % at 2 rad/s and 0.1 s
    assert np.abs(np.abs(ratio) - 1).max() < MAGNITUDE + 0.004
    assert np.abs(np.angle(ratio)).max() < PHASE
