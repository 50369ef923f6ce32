"""Many designs at once against one at a time by the main job's own functions; the space of designs; drag elements."""

from dataclasses import replace

import numpy as np
import pytest

from fowtio.database import read_database
from fowtio.hull_system import CHAIN, GRAVITY, SemiDesign, semi_hydro, thesis_hull
from fowtio.hull_turbine import carried, ten_megawatt, ten_megawatt_structure
from fowtio.optimise.setting import design_state
from fowtio.workflow import with_gradients
from model.design.evaluate import CHANNELS, Setting, make_batch
from model.design.hull import SemiHull, platform_body
from model.design.hull_drag import drag_members, hull_elements
from model.design.population import Carried, LineType, stiff_as, straight_distance
from model.design.quantities import QUANTITIES, Constraint, check_name, evaluate, quantity_value
from model.design.space import DesignSpace, DesignVariable
from model.environment.sea import SeaState
from model.response.assemble import assemble, equilibrium, natural_modes
from model.response.loads import channel_response, linear_outputs, response_spectra
from model.response.mean_offset import mean_offsets
from model.response.solve import excitation, prepare, solve, trapezoid_weights
from model.system.contributions import hydrostatic_contribution, platform_contribution, turbine_contribution
from model.system.mooring import mooring_state

OMEGA = 2 * np.pi * np.geomspace(0.003, 0.6, 70)
DESIGNS = np.array([
    [14.0, 39.0, 22.5, 837.6, 830.0],
    [20.0, 45.0, 31.5, 840.0, 825.0],
    [16.5, 33.0, 20.0, 800.0, 795.0],
])  # fmt: skip
SEA = SeaState(kind="jonswap", significant_height=4.93, peak_period=8.68, gamma=2.2)


@pytest.fixture(scope="module")
def setting():
    structure = ten_megawatt_structure()
    mass, height = carried(ten_megawatt(0.0))
    entries = (("parked", 0.0, None), ("rated", 11.0, "B"))
    from fowtio.case import StateEntry

    states = tuple(design_state(StateEntry(name=n, wind_speed=u, turbulence=t, sea=SEA), structure, OMEGA, 0.0) for n, u, t in entries)
    return Setting(
        omega=OMEGA, states=states, line=LineType(**CHAIN), depth=200.0, carried=Carried(mass=mass, height=height), tower_base=structure.tower.base_height,
        nacelle_motion=np.zeros(7), database=read_database(), hull={}, gravity=GRAVITY,
    )  # fmt: skip


@pytest.fixture(scope="module")
def batch(setting):
    return make_batch(setting, *DESIGNS.T)


def one_by_one(design, speed):
    """A design by the functions of the main job: system, mean offset and response of drag iterated to 1e-10."""
    semi = SemiDesign(hull=thesis_hull(*design[:3]), anchor_radius=design[3], length=design[4])
    floating, structure = semi.floating(), ten_megawatt_structure()
    turbine = ten_megawatt(speed)
    rotor = None
    if speed:
        turbine, rotor = with_gradients(turbine, structure, speed)
    hydro = semi_hydro(floating, 200.0, omega=OMEGA, heading=np.array([0.0]))
    parts = [
        turbine_contribution(turbine), platform_contribution(platform_body(floating), GRAVITY, ""), hydrostatic_contribution(hydro, "")
    ]  # fmt: skip
    system = assemble(turbine.dofs, turbine, parts, hydro, drag_members(semi.hull), semi.mooring())
    mean = equilibrium(system)
    from model.environment.wind import WindState

    wind = WindState(mean_speed=speed, hub_height=structure.hub_height, rotor_diameter=structure.rotor.diameter, turbulence_class="B") if speed else None
    drive = excitation(OMEGA, SEA, wind, rotor=rotor)
    response = solve(system, mean, drive, grid=prepare(system, OMEGA, drive.heading), tolerance=1e-10, limit=80)
    return system, mean, response, structure


@pytest.mark.parametrize(("name", "speed"), [("parked", 0.0), ("rated", 11.0)])
@pytest.mark.parametrize("k", [0, 1, 2])
def test_a_design_among_many_is_that_of_the_main_job(batch, name, speed, k):
    system, mean, response, structure = one_by_one(DESIGNS[k], speed)
    # both are iterated far below 1e-8; what is left is rounding and the last change of the drag (1e-9)
    assert batch.mean(name).offset[k] == pytest.approx(mean.offset, rel=1e-9, abs=1e-9)
    result = batch.result(name)
    mine = np.moveaxis(result.solution.motion[k, :, 0], 0, -1)
    size = np.abs(response.to_wave[0]).max(axis=0)
    scale = np.where([False, False, False, True, True, True, False], size[3:6].max(), size[[0, 1, 2, 6]].max())  # sway is nothing here
    assert np.abs(mine - response.to_wave[0]).max(axis=0) / scale == pytest.approx(0.0, abs=1e-8)
    outputs = linear_outputs(system, mean, structure)
    channels = channel_response(outputs, response)
    spectra = response_spectra(channels, response)
    for channel, theirs in (("surge", "PtfmSurge"), ("pitch", "PtfmPitch"), ("tower_moment", "TwrBsMyt")):
        c = CHANNELS.index(channel)
        weights = trapezoid_weights(OMEGA)
        ours, want = (float(np.sqrt(weights @ s)) for s in (result.spectra[k, c], spectra[:, channels.index(theirs)]))
        assert ours == pytest.approx(want, rel=1e-8)
        assert result.mean[k, c] == pytest.approx(channels.mean[channels.index(theirs)], rel=1e-8, abs=1e-9)


def test_company_does_not_matter(setting, batch):
    alone = make_batch(setting, *DESIGNS[1:2].T)
    for name in ("tower_moment:rated", "surge_peak:parked", "mean_pitch:rated", "pitch_period:parked"):
        # the same operations on the same numbers; matrix products of other sizes may round otherwise
        assert quantity_value(alone, name)[0] == pytest.approx(quantity_value(batch, name)[1], rel=1e-11)


def test_natural_periods_are_those_of_the_damped_modes(batch):
    system, mean = one_by_one(DESIGNS[0], 0.0)[:2]
    modes = natural_modes(system, mean)
    for c, dof in enumerate(("surge", "heave", "pitch")):
        # without drag and with small radiation damping (below 1 %) damped and undamped frequency agree to the square of the ratio
        want = 2 * np.pi / modes.frequency[modes.names.index(dof)]
        assert batch.periods("parked")[0, c] == pytest.approx(want, rel=2e-3)


def test_mean_offsets_of_many_moorings(batch):
    found = batch.mean("rated")
    assert found.converged.all()
    state = mooring_state(batch.population.mooring, found.offset[:, :6])
    force = state.force[:, 0]
    # along surge only the turbine and the lines act: thrust less the stiffness that turns with the platform balances the lines
    turbine = batch.setting.state("rated").turbine
    thrust = turbine.force[0] - (found.offset - turbine.point) @ turbine.stiffness[0]
    assert force == pytest.approx(-thrust, rel=1e-8)


def test_a_mean_offset_that_cannot_be_found_is_marked(batch):
    weak = replace(batch.population.mooring, axial_stiffness=batch.population.mooring.axial_stiffness * 1e-3)
    stiffness = np.repeat(np.eye(6)[None] * 1e9, 3, axis=0)
    stiffness[:, 0, 0] = 0.0
    pull = np.zeros((3, 6))
    pull[1, 0] = 2e5
    found = mean_offsets(("surge", "sway", "heave", "roll", "pitch", "yaw"), pull, stiffness, weak, limit=3)
    assert found.converged.tolist() == [True, False, True]


def test_line_lengths_of_one_stiffness(setting):
    hull = SemiHull(diameter=DESIGNS[:, 0], radius=DESIGNS[:, 1], draft=DESIGNS[:, 2])
    length = stiff_as(hull, 837.6, 70.8e3, line=setting.line, depth=200.0)
    stiff = make_batch(setting, *DESIGNS[:, :3].T, np.full(3, 837.6), length).population.at_rest.stiffness[:, 0, 0]
    assert stiff == pytest.approx(70.8e3, rel=1e-4)  # a micrometre of length is 1e-6 of it
    assert np.isnan(stiff_as(hull, 837.6, 1e9, line=setting.line, depth=200.0)).all()


def test_elements_fill_up_to_one_number_and_keep_the_drag():
    hull = SemiHull(diameter=DESIGNS[:, 0], radius=DESIGNS[:, 1], draft=DESIGNS[:, 2])
    many = hull_elements(hull)
    factor = many.factor.reshape(3, -1)
    for k, design in enumerate(DESIGNS):
        one = drag_members(SemiHull(diameter=design[0], radius=design[1], draft=design[2]))
        assert (factor[k] > 0).sum() == len(one)
        assert factor[k].sum() == pytest.approx(one.factor.sum(), rel=1e-13)


def test_every_quantity_has_a_value_in_a_unit(batch):
    for name, quantity in QUANTITIES.items():
        if name in ("cost", "damage"):  # need rules that this setting does not have
            continue
        value = quantity_value(batch, name + (":rated" if quantity.of_state else ""))
        assert value.shape == (3,)
        assert np.isfinite(value).all(), name
        assert quantity.text
        assert quantity.unit


def test_names_of_quantities_are_checked():
    assert check_name("mean_pitch:rated", ["rated"]) is None
    assert "did you mean mean_pitch" in check_name("mean_pich:rated", ["rated"])
    assert "needs a state" in check_name("mean_pitch", ["rated"])
    assert "there are rated" in check_name("mean_pitch:storm", ["rated"])
    assert "takes no state" in check_name("steel_mass:rated", ["rated"])


def test_infeasible_designs_carry_the_reason_and_cost_nothing_further(setting):
    designs = np.concatenate([DESIGNS, [[14.0, 30.0, 20.0, 837.6, 700.0]]])
    reach = np.maximum(0.0, 1 - designs[:, 4] / straight_distance(SemiHull(diameter=designs[:, 0], radius=designs[:, 1], draft=designs[:, 2]), designs[:, 3], 200.0))
    asked = []

    def make(some):
        asked.append(len(some))
        return make_batch(setting, *some.T)

    limits = [Constraint(quantity="mean_pitch:rated", relation="<=", limit=2.0), Constraint(quantity="platform_mass", relation="<=", limit=4e4)]
    found = evaluate(make, designs, reach, ["tower_moment:rated"], limits)
    moment = found.values[:, found.names.index("tower_moment:rated")]
    assert asked == [3]
    assert "straight distance" in found.reason[3]
    assert found.reason[0].startswith("mean_pitch:rated")
    assert found.reason[1].startswith("platform_mass")
    assert np.isnan(moment[[0, 1, 3]]).all()
    # the earlier a design fails the larger its violation
    assert found.violation[3] > found.violation[1] > found.violation[0] > 0


def test_the_space_of_designs_and_back():
    space = DesignSpace(
        variables=(
            DesignVariable(name="line_length", lower=-20, upper=20, spacing=5, relative_to="anchor_radius"),
            DesignVariable(name="diameter", lower=14, upper=20, spacing=0.5),
            DesignVariable(name="anchor_radius", lower=570, upper=950, spacing=10),
        ),
        fixed={"radius": 40.0, "draft": 25.0},
    )  # fmt: skip
    assert space.size == 9 * 13 * 39
    places = np.array([[0, 0, 0], [8, 12, 38], [4, 3, 20]])
    designs = space.designs(places)
    assert designs[0] == pytest.approx([14.0, 40.0, 25.0, 570.0, 550.0])
    assert designs[1] == pytest.approx([20.0, 40.0, 25.0, 950.0, 970.0])
    assert (space.places(designs) == places).all()
    smaller = space.reduced(designs[1:])
    assert smaller.size == 5 * 10 * 19
    assert (smaller.designs(smaller.places(designs[1:])) == designs[1:]).all()
    assert len(space.every()) == space.size
