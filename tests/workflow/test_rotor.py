"""A study's rotor table: names read, operating points found, the turbine at any wind speed, errors with their place."""

import numpy as np
import pytest

from fowtio.errors import FormatError, ModelError
from fowtio.read.openfast_deck import read_deck
from fowtio.read.openfast_input import read_input
from fowtio.rotor import rotor_entry, rotor_turbine
from model.conventions import PLATFORM_DOFS
from model.environment.rotor_wind import rotor_sensitivity
from model.system.controller import ROTOR_AZIMUTH
from model.system.turbine import gradient_forces

DOFS = (*PLATFORM_DOFS, "tower_fa1")
PITCH, RATIO = np.arange(-4.0, 30.0), np.arange(2.0, 15.0, 0.5)


def _rows(values) -> str:
    return "\n".join("  ".join(f"{v:.6f}" for v in row) for row in np.atleast_2d(values))


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    """A table in ROSCO's layout of a rotor of the NREL 5 MW's size: Cp 0.48 at ratio 7.6, falling with pitch."""
    p, x = np.meshgrid(PITCH, RATIO)
    torque = (
        0.063 - 0.0065 * (x - 7.6) - 0.00022 * (x - 7.6) ** 2 - 0.0006 * p - 0.00011 * p**2 - 0.00025 * p * (x - 7.6)
    )
    thrust = 0.78 + 0.03 * (x - 7.6) - 0.028 * p
    file = tmp_path_factory.mktemp("rotor") / "rotor.txt"
    file.write_text(
        f"# made by a test\n# Pitch angle vector (deg)\n{_rows(PITCH)}\n# TSR vector (-)\n{_rows(RATIO)}\n# Wind speed vector (m/s)\n11.4\n"
        f"# Power coefficient\n{_rows(x * torque)}\n# Thrust coefficient\n{_rows(thrust)}\n# Torque coefficient\n{_rows(torque)}\n"
    )
    return file


@pytest.fixture
def study(table, tmp_path):
    """Return a maker of the lines of a study that name the rotor."""

    def make(more="", name="rotor.txt"):
        (tmp_path / "rotor.txt").write_bytes(table.read_bytes())
        file = tmp_path / "x.fowt"
        file.write_text(
            f'------- FOWTIO STUDY FILE\nx\n"{name}"  RotorTable - table\n5.2966  RotorPower - MW\n12.1  RatedSpeed - rpm\n'
            f"6.9  MinSpeed - rpm\n0.0  FinePitch - deg\n{more}END\n"
        )
        return read_input(file)

    return make


@pytest.fixture(scope="module")
def deck(oc4_folder):
    return read_deck(oc4_folder / "input" / "oc4.fst")


def test_names_and_units(study):
    entry = rotor_entry(
        study("constant_torque TorqueLaw - x\n0.3 SpeedLoopFreq - rad/s\n1.0 FloatGain - deg per m/s\n")
    )
    assert np.isclose(entry.rated_power, 5.2966e6)
    assert np.isclose(entry.rated_speed, 12.1 * 2 * np.pi / 60)
    assert entry.fine_pitch == 0.0
    assert (entry.torque_law, entry.loop_frequency, entry.loop_damping) == ("constant_torque", 0.3, 0.7)
    assert np.isclose(entry.platform_feedback, np.pi / 180)


def test_no_table_is_no_rotor(tmp_path):
    file = tmp_path / "x.fowt"
    file.write_text("------- FOWTIO STUDY FILE\nx\n11 WindSpeed - x\nEND\n")
    assert rotor_entry(read_input(file)) is None


def test_operating_points(study, deck):
    """Below rated the speed grows with the wind, above power is held: torque is power over speed."""
    entry = rotor_entry(study())
    slow, _ = rotor_turbine(entry, deck, DOFS, 7.0)
    fast, _ = rotor_turbine(entry, deck, DOFS, 9.0)
    assert np.isclose(fast.rotor_speed / slow.rotor_speed, 9 / 7, rtol=1e-9)
    above, notes = rotor_turbine(entry, deck, DOFS, 16.0)
    assert np.isclose(above.rotor_speed, entry.rated_speed)
    tilt = deck.elastodyn.structure.rotor.tilt
    assert np.isclose(
        above.force[3], 5.2966e6 / entry.rated_speed * np.cos(tilt), rtol=2e-3
    )  # the tower's bend tilts on
    assert "speed and pitch held" in notes[0]
    assert above.dofs == DOFS
    assert above.wind_speed == 16.0


def test_gradients_are_those_of_the_general_rule(study, deck):
    """The table's turbine brings its own gradient forces; the main ones are the rule's for any turbine."""
    turbine, _ = rotor_turbine(rotor_entry(study()), deck, DOFS, 12.0)
    structure = deck.elastodyn.structure
    arm = rotor_sensitivity(structure.rotor.diameter, 3, turbine.rotor_speed, 12.0).gradient_arm
    rule = gradient_forces(structure, turbine, arm)
    for row, dof in ((0, 4), (0, 6), (1, 5)):
        assert np.isclose(
            turbine.gradient_force[row, dof], rule[row, dof], rtol=0.02
        )  # sideways forces and the bend of the tower


def test_free_rotor(study, deck):
    entry = rotor_entry(study())
    free, notes = rotor_turbine(entry, deck, (*DOFS, ROTOR_AZIMUTH), 16.0)
    held, _ = rotor_turbine(entry, deck, DOFS, 16.0)
    assert free.dofs == (*DOFS, ROTOR_AZIMUTH)
    m, b, c = free.mass[-1, -1], free.damping[-1, -1], free.stiffness[-1, -1]
    assert np.isclose(m, 43_784_725, rtol=4e-3)  # Jonkman 2007: drivetrain inertia on the slow shaft
    assert np.isclose(np.sqrt(c / m), 0.2, rtol=1e-6)
    assert np.isclose(b / (2 * np.sqrt(c * m)), 0.7, rtol=1e-6)
    assert np.array_equal(free.mass[:7, :7], held.mass)
    assert "pitch control" in notes[0]
    assert "optimal torque" in rotor_turbine(entry, deck, (*DOFS, ROTOR_AZIMUTH), 8.0)[1][0]


def test_problems_name_their_place(study, deck, tmp_path):
    with pytest.raises(FormatError, match=r"x\.fowt, line 3: expected an existing file for RotorTable"):
        rotor_entry(study(name="other.txt"))
    with pytest.raises(FormatError, match="one of optimal"):
        rotor_entry(study("fastest TorqueLaw - x\n"))
    with pytest.raises(FormatError, match="SpeedLoopFreq above zero"):
        rotor_entry(study("-1 SpeedLoopFreq - x\n"))
    with pytest.raises(ModelError, match=r"rotor\.txt, 2 m/s: tip speed ratio .* lies outside the rotor table"):
        rotor_turbine(rotor_entry(study()), deck, DOFS, 2.0)
