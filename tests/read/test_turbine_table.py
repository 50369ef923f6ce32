"""Turbine matrices by wind speed: what is written comes back, is linear between, and what is wrong is said."""

import json

import numpy as np
import pytest

from fowtio.errors import FormatError
from fowtio.read.turbine_table import read_turbine_table
from model.conventions import PLATFORM_DOFS
from model.system.turbine_table import turbine_at

DOFS = (*PLATFORM_DOFS, "tower_fa1")


def point(speed: float) -> dict:
    square = np.diag(np.arange(1.0, 8.0)) + speed
    return {
        "wind_speed": speed, "rotor_rpm": 2 * speed, "pitch_deg": 90.0 if speed == 0 else 0.0, "tower_top": 0.1 * speed,
        "mass": (2 * square).tolist(), "damping": (3 * square).tolist(), "stiffness": (4 * square).tolist(),
        "force": [speed, 0.0, -1e6, 0.0, 80 * speed, 0.0], "wind_force": [5 * speed] * 7,
    }  # fmt: skip


def text(speeds=(0.0, 4.0, 6.0), **changes) -> str:
    return json.dumps({"title": "a turbine", "degrees_of_freedom": DOFS, "operating_points": [point(s) | changes for s in speeds]})


def written(tmp_path, content):
    path = tmp_path / "turbine.json"
    path.write_text(content, encoding="utf-8")
    return path


def test_numbers_come_back_and_are_linear_between(tmp_path):
    table = read_turbine_table(written(tmp_path, text()))
    assert table.wind_speed.tolist() == [0, 4, 6]
    assert table.blade_pitch[0] == pytest.approx(np.pi / 2)
    turbine = turbine_at(table, 4.5)
    assert turbine.damping[0, 0] == pytest.approx(3 * (1 + 4.5))
    assert turbine.force.tolist() == pytest.approx([4.5, 0, -1e6, 0, 360, 0, 0])
    assert turbine.point[6] == pytest.approx(0.45)
    assert turbine.rotor_speed == pytest.approx(9 * np.pi / 30)
    assert turbine_at(table, 4.0).mass[6, 6] == 2 * (7 + 4)


def test_between_parked_and_cut_in_there_is_nothing(tmp_path):
    table = read_turbine_table(written(tmp_path, text()))
    assert table.covers(0.0)
    for speed in (2.0, 6.1):
        assert not table.covers(speed)
        with pytest.raises(ValueError, match=r"has data at 0 \(parked\) and 4 to 6 m/s"):
            turbine_at(table, speed)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("{", "JSON"), ('{"degrees_of_freedom": []}', "operating_points"), (text(mass=[[1.0]]), "mass"), (text(force=[1.0]), "force"),
        (text(tower_top=[1.0, 2.0]), "tower_top"), (text(damping="much"), "numbers"), (text((4.0, 0.0)), "ascend"),
        (text(wind_force=[float("nan")] * 7), "wind_force"), (text().replace("rotor_rpm", "rpm"), "rotor_rpm"),
        (text().replace('"surge"', '"drift"'), "drift"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said(tmp_path, content, words):
    with pytest.raises(FormatError, match=words):
        read_turbine_table(written(tmp_path, content))
