"""Rotor performance tables: what is written comes back, and contradictions are noticed."""

import os
from pathlib import Path

import numpy as np
import pytest

from fowtio.errors import FormatError
from fowtio.read.rotor_table import read_rotor_table

PITCH, RATIO = np.arange(-2.0, 6.0), np.arange(2.0, 12.0, 0.5)


def coefficients(winds=1):
    """A smooth rotor: Cp with one peak, Cq by definition Cp / TSR."""
    pitch, ratio = np.meshgrid(PITCH, RATIO)
    power = 0.45 - 0.01 * (ratio - 7.5) ** 2 - 0.004 * pitch**2
    thrust = 0.8 - 0.05 * pitch + 0.02 * ratio
    return [np.stack([t * (1 + 0.1 * k) for k in range(winds)]) for t in (power, thrust, power / ratio)]


def text(winds=1, entries=True):
    def vector(values):
        return "   ".join(f"{v:.4f}" for v in values)

    said = (f", {len(PITCH)} entries", f", {len(RATIO)} entries") if entries else ("", "")
    out = [
        "# ----- a rotor made by the tests -----",
        "",
        f"# Pitch angle vector{said[0]} - x axis (matrix columns) (deg)",
        vector(PITCH),
    ]
    out += [
        f"# TSR vector{said[1]} - y axis (matrix rows) (-)",
        vector(RATIO),
        "# Wind speed vector - z axis (m/s)",
        vector(8.0 + np.arange(winds)),
    ]
    for title, table in zip(
        ("# Power coefficient", "#  Thrust coefficient", "# Torque coefficient"), coefficients(winds), strict=True
    ):
        out += ["", title, ""]
        for sheet in table:
            out += ["   ".join(f"{v:.6f}" for v in row) for row in sheet] + [""]
    return "\n".join(out) + "\n"


def read(tmp_path, content):
    path = tmp_path / "Cp_Ct_Cq.txt"
    path.write_bytes(content.encode("latin-1"))
    return read_rotor_table(path)


@pytest.mark.parametrize("winds", [1, 3])
@pytest.mark.parametrize("entries", [True, False])
def test_what_is_written_comes_back(tmp_path, winds, entries):
    table = read(tmp_path, text(winds, entries))
    for name, values in zip(("power", "thrust", "torque"), coefficients(winds), strict=True):
        np.testing.assert_allclose(getattr(table, name), values, atol=5e-7)  # six decimals were written
    np.testing.assert_allclose(table.pitch, np.radians(PITCH), rtol=1e-12)
    np.testing.assert_array_equal(table.tip_speed_ratio, RATIO)
    assert table.wind_speed.tolist() == [8.0 + k for k in range(winds)]


def test_sections_in_another_order(tmp_path):
    head, *parts = text().split("\n# ")
    other = "\n# ".join([head, *parts[3:], *parts[:3]])
    np.testing.assert_array_equal(read(tmp_path, other).power, read(tmp_path, text()).power)


def test_every_line_cut_off_is_noticed(tmp_path):
    lines = text().rstrip().split("\n")
    for k in range(len(lines)):
        with pytest.raises(FormatError):
            read(tmp_path, "\n".join(lines[:k]) + "\n")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("8 entries", "9 entries", "9 entries"),
        ("-1.0000", "-3.0000", "ascending"),
        ("# Power coefficient", "# Something", "names what follows"),
        ("# Torque coefficient", "#  Thrust coefficient", "once"),
        ("-1.0000", "NaN", "numbers of the pitch"),
        ("# Pitch angle vector", "Pitch", "names what follows"),
    ],
)
def test_what_does_not_fit_is_refused(tmp_path, old, new, words):
    assert old in text()
    with pytest.raises(FormatError) as error:
        read(tmp_path, text().replace(old, new, 1))
    assert words in str(error.value), str(error.value)


def test_a_digit_that_changed_is_noticed(tmp_path):
    """Power is tip speed ratio times torque: a wrong leading digit of either shows, with its line."""
    lines = text().split("\n")
    at = lines.index("# Power coefficient") + 12
    value = lines[at].split()[3]
    assert value.startswith("0.4")
    lines[at] = lines[at].replace(value, value.replace("0.4", "0.1", 1), 1)
    with pytest.raises(FormatError, match="torque coefficient") as error:
        read(tmp_path, "\n".join(lines))
    assert error.value.line == at + 1


@pytest.mark.reference
@pytest.mark.skipif("FOWTIO_FORMATS" not in os.environ, reason="FOWTIO_FORMATS names no folder of sample files")
@pytest.mark.parametrize(("name", "peak"), [("NREL5MW", 0.466), ("DTU10MW", 0.470)])
def test_real_files(name, peak):
    table = read_rotor_table(Path(os.environ["FOWTIO_FORMATS"]) / "rotor_tables" / f"Cp_Ct_Cq.{name}.txt")
    assert table.power.max() == pytest.approx(peak, abs=0.001)  # the largest number in the file, to three digits
