"""The DTU 10 MW turbine on its tower, as matrices at any wind speed: parked, and from 4 to 25 m/s."""

from __future__ import annotations

import json
from functools import lru_cache
from importlib.resources import files
from pathlib import Path

from fowtio.errors import ModelError
from fowtio.read.turbine_table import read_turbine_table
from model.system.turbine import TurbineMatrices, TurbineStructure
from model.system.turbine_table import TurbineTable, turbine_at

GRAVITY = 9.80665
MATRICES = "turbine.json"


def reference_folder(name: str) -> Path:
    """Return a folder of reference data, in a checkout or an installed package."""
    checkout = Path(__file__).resolve().parent.parent / "validation" / name
    return checkout if checkout.is_dir() else Path(str(files("fowtio.cases") / name))


def turbine_folder() -> Path:
    """Return the folder of the 10 MW turbine's data."""
    return reference_folder("dtu10mw")


@lru_cache(maxsize=1)
def ten_megawatt_table() -> TurbineTable:
    """Return the matrices of the DTU 10 MW turbine at all its operating points."""
    return read_turbine_table(turbine_folder() / MATRICES)


def ten_megawatt(wind_speed: float = 0.0) -> TurbineMatrices:
    """Return the DTU 10 MW turbine at a wind speed [m/s] at hub height: 0 is parked, 4 to 25 in operation.

    Between the operating points of every whole m/s matrices are interpolated linearly; between 11 and 12 m/s, about rated, the
    blades start to pitch and the turbine changes most. Rigid blades, constant rotor speed. Raises ModelError elsewhere.
    """
    try:
        return turbine_at(ten_megawatt_table(), wind_speed)
    except ValueError as error:
        raise ModelError(str(error)) from None


def operating_points() -> list[dict]:
    """Return wind speed [m/s], rotor speed [rpm], blade pitch [deg] and rotor thrust [kN], as tabulated and as linearised."""
    names = ("wind_speed", "rotor_rpm", "pitch_deg", "thrust_table_kN", "rotor_thrust_kN")
    points = json.loads((turbine_folder() / MATRICES).read_text(encoding="utf-8"))["operating_points"]
    return [{n: p[n] for n in names} for p in points]


@lru_cache(maxsize=1)
def ten_megawatt_structure() -> TurbineStructure:
    """Return the 10 MW turbine's structure (tower, nacelle, rotor) from its ElastoDyn deck, for loads and parked matrices."""
    from fowtio.read.elastodyn import read_elastodyn

    return read_elastodyn(turbine_folder() / "input" / "ElastoDyn.dat", GRAVITY).structure


def carried(turbine: TurbineMatrices) -> tuple[float, float]:
    """Return mass [kg] and height [m] of the centre of mass of a turbine from its mass matrix."""
    mass = float(turbine.mass[0, 0])
    return mass, float(turbine.mass[0, 4] / mass)
