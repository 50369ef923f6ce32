"""What several test files share: the embedded OC4 case built once, small bodies with closed-form answers, the command line."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import fowtio
from model.conventions import PLATFORM_DOFS
from model.response.assemble import assemble
from model.system.contributions import contribution
from model.system.drag import DragMembers, no_drag
from model.system.hydro import HydroCoefficients
from model.system.turbine import TurbineMatrices

OC4 = Path(__file__).resolve().parent.parent / "validation" / "oc4_deepcwind"


@pytest.fixture(scope="session")
def oc4_folder() -> Path:
    """Folder of the embedded case; tests copy from it and never write to it."""
    return OC4


@pytest.fixture(scope="session")
def oc4():
    """The embedded study, read and assembled."""
    return fowtio.build(fowtio.load(OC4 / "oc4.fowt"))


@pytest.fixture(scope="session")
def oc4_loads(oc4):
    """Loads and statistics of the states of the embedded study, by name."""
    return {item.state.name: item for item in fowtio.loads(fowtio.solve(oc4))}


@pytest.fixture(scope="session")
def oc4_validation(oc4):
    """The embedded study beside its reference time series."""
    return fowtio.validate(oc4, oc4.case.references[0], nonlinear=False)


def _flat_hydro(added_mass, excitation, depth) -> HydroCoefficients:
    omega = np.array([1e-4, 1e3])
    matrix = np.asarray(added_mass, dtype=float)
    force = np.broadcast_to(np.asarray(excitation, dtype=complex), (1, 2, 6))
    return HydroCoefficients(
        omega=omega, heading=[0.0], added_mass=np.stack([matrix] * 2), radiation_damping=np.zeros((2, 6, 6)),
        added_mass_zero=matrix, added_mass_infinite=matrix, excitation=force, depth=depth,
    )  # fmt: skip


@pytest.fixture(scope="session")
def simple_body():
    """Return a maker of bodies whose matrices are constant: mass, damping, stiffness, added mass (6, 6), excitation (6) per metre."""

    def make(
        *, mass=None, damping=None, stiffness=None, added_mass=None, excitation=None, force=None, drag=None, mooring=None,
        dofs=PLATFORM_DOFS, wind_force=None, quadratic_damping=None, depth=np.inf,
    ):  # fmt: skip
        zero, line = np.zeros((6, 6)), np.zeros(6)
        turbine = TurbineMatrices(
            dofs=PLATFORM_DOFS, mass=zero, damping=zero, stiffness=zero, force=line, point=line,
            wind_force=line if wind_force is None else wind_force,
        )  # fmt: skip
        part = contribution("body", "test", mass=mass, damping=damping, stiffness=stiffness, force=force)
        hydro = _flat_hydro(
            zero if added_mass is None else added_mass, line if excitation is None else excitation, depth
        )
        return assemble(dofs, turbine, [part], hydro, no_drag() if drag is None else drag, mooring, quadratic_damping)

    return make


@pytest.fixture(scope="session")
def plate():
    """Return a maker of one drag element: an end plate (axial) or a strip across its axis, factor K [kg/m]."""

    def make(factor, *, position=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0), axial=True):
        return DragMembers(
            position=[position], axis=[axis], factor=[factor], axial=[float(axial)], diameter=[1.0], length=[1.0]
        )

    return make


@pytest.fixture
def cli(monkeypatch, capsys):
    """Return a runner of the command line in this process; its result has code, out and err."""
    from fowtio.cli import main

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["fowtio", *map(str, arguments)])
        capsys.readouterr()
        code = 0
        try:
            main()
        except SystemExit as stop:
            code = stop.code or 0
        out, err = capsys.readouterr()
        return SimpleNamespace(code=code, out=out, err=err)

    return run


STUDY = """------- FOWTIO STUDY FILE ------------------------------------------------------
Trial
---------------------- MODEL ---------------------------------------------------
"input/oc4.fst"  Deck          - OpenFAST primary file
"DEFAULT"        HydroFile     - hydrodynamic coefficients
7                DOFs          - degrees of freedom
---------------------- LINEARISATIONS ------------------------------------------
{linearisations}
---------------------- SEA AND WIND STATES -------------------------------------
1                NStates       - rows of the table
Name          WindSpeed  Turbulence  Spectrum     Hs        Tp    Gamma  WaveDir
(-)           (m/s)      (- or %)    (-)          (m)       (s)   (-)    (deg)
sea           {wind:<10} none        jonswap      {height:<9} 10.0  3.3    {heading}
---------------------- OPTIONS -------------------------------------------------
100              NFreq         - number of frequencies
END of study
"""
NO_LINEARISATIONS = """0                NLin          - operating points
WindSpeed  LinFiles  LinDeck  MassMatrix
(m/s)      (-)       (-)      (-)"""


@pytest.fixture
def trial(tmp_path):
    """Return a maker of a small study on a copy of the embedded deck: one JONSWAP sea, the turbine from the deck alone.

    rows are rows of the table of linearisations; copy names parts of the linearisation folder to bring along.
    """

    def make(*, rows=(), copy=(), wind=0.0, height=2.0, heading=0.0) -> Path:
        folder = tmp_path / "trial"
        shutil.copytree(OC4 / "input", folder / "input")
        for name in copy:
            (folder / "linearisation" / name).parent.mkdir(parents=True, exist_ok=True)
            source = OC4 / "linearisation" / name
            (shutil.copytree if source.is_dir() else shutil.copy)(source, folder / "linearisation" / name)
        head, _, rest = NO_LINEARISATIONS.partition("\n")
        table = "\n".join([head.replace("0", str(len(rows)), 1), rest, *rows])
        study = folder / "trial.fowt"
        study.write_text(STUDY.format(linearisations=table, wind=wind, height=height, heading=heading))
        return study

    return make
