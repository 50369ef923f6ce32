"""The DTU 10 MW turbine on its tower, as matrices at any wind speed: parked, and from 4 to 25 m/s."""

from __future__ import annotations

import json
from functools import lru_cache
from importlib.resources import files
from pathlib import Path

import numpy as np

from fowtio.errors import ModelError
from model.system.turbine import TurbineMatrices, TurbineStructure

GRAVITY = 9.80665
_ARRAYS = ("force", "mass", "damping", "stiffness", "wind_force")


def reference_folder(name: str) -> Path:
    """Return a folder of reference data, in a checkout or an installed package."""
    checkout = Path(__file__).resolve().parent.parent / "validation" / name
    return checkout if checkout.is_dir() else Path(str(files("fowtio.cases") / name))


def turbine_folder() -> Path:
    """Return the folder of the 10 MW turbine's data."""
    return reference_folder("dtu10mw")


@lru_cache(maxsize=1)
def _table() -> tuple[list[dict], tuple[str, ...]]:
    data = json.loads((turbine_folder() / "turbine.json").read_text(encoding="utf-8"))
    points = [{k: np.array(v) if k in _ARRAYS else v for k, v in row.items()} for row in data["operating_points"]]
    return points, tuple(data["degrees_of_freedom"])


def ten_megawatt(wind_speed: float = 0.0) -> TurbineMatrices:
    """Return the DTU 10 MW turbine at a wind speed [m/s] at hub height: 0 is parked, 4 to 25 in operation.

    Between the operating points of every whole m/s matrices are interpolated linearly; between 11 and 12 m/s, about rated, the
    blades start to pitch and the turbine changes most. Rigid blades, constant rotor speed. Raises ModelError elsewhere.
    """
    points, dofs = _table()
    speeds = np.array([p["wind_speed"] for p in points], dtype=float)
    if wind_speed != 0 and not speeds[1] <= wind_speed <= speeds[-1]:
        raise ModelError(
            f"the wind speed is {wind_speed:g} m/s; the 10 MW turbine has data at 0 (parked) and {speeds[1]:g} to {speeds[-1]:g} m/s"
        )
    high = int(np.searchsorted(speeds, wind_speed))
    low = high if speeds[high] == wind_speed else high - 1
    share = 0.0 if low == high else (wind_speed - speeds[low]) / (speeds[high] - speeds[low])

    def between(name):
        return (1 - share) * points[low][name] + share * points[high][name]

    return TurbineMatrices(
        dofs=dofs, mass=between("mass"), damping=between("damping"), stiffness=between("stiffness"),
        force=np.append(between("force"), 0.0), point=np.append(np.zeros(6), between("tower_top")), wind_force=between("wind_force"),
        wind_speed=wind_speed, rotor_speed=between("rotor_rpm") * np.pi / 30,
        source="DTU 10 MW, OpenFAST linearisation" + ("" if low == high else f", between {speeds[low]:g} and {speeds[high]:g} m/s"),
    )  # fmt: skip


def operating_points() -> list[dict]:
    """Return wind speed [m/s], rotor speed [rpm], blade pitch [deg] and rotor thrust [kN], as tabulated and as linearised."""
    names = ("wind_speed", "rotor_rpm", "pitch_deg", "thrust_table_kN", "rotor_thrust_kN")
    return [{n: p[n] for n in names} for p in _table()[0]]


@lru_cache(maxsize=1)
def ten_megawatt_structure() -> TurbineStructure:
    """Return the 10 MW turbine's structure (tower, nacelle, rotor) from its ElastoDyn deck, for loads and parked matrices."""
    from fowtio.read.elastodyn import read_elastodyn

    return read_elastodyn(turbine_folder() / "input" / "ElastoDyn.dat", GRAVITY).structure


def carried(turbine: TurbineMatrices) -> tuple[float, float]:
    """Return mass [kg] and height [m] of the centre of mass of a turbine from its mass matrix."""
    mass = float(turbine.mass[0, 0])
    return mass, float(turbine.mass[0, 4] / mass)
