"""Read OpenFAST decks and give the frequency-domain model of a floating wind turbine."""

from __future__ import annotations

import importlib
import importlib.util
from pathlib import Path

__version__ = "0.1.0"

_PUBLIC = {
    "load": "fowtio.case",
    "Case": "fowtio.case",
    "build": "fowtio.workflow",
    "solve": "fowtio.workflow:solve_states",
    "loads": "fowtio.workflow",
    "Model": "fowtio.workflow",
    "validate": "fowtio.validation",
    "read_deck": "fowtio.read.openfast_deck",
    "read_timeseries": "fowtio.read.openfast_out:read_openfast_out",
    "read_linearisation": "fowtio.read.openfast_lin:read_openfast_lin",
    "read_hydro": "fowtio.read.hydro_any",
    "convert": "fowtio.convert",
    "load_site": "fowtio.site",
    "contour_study": "fowtio.contour_study",
    "fatigue_study": "fowtio.fatigue_study",
    "cost_study": "fowtio.cost_study",
    "load_optimisation": "fowtio.optimise.study",
    "optimise_study": "fowtio.optimise.run:optimise",
    "write_results": "fowtio.write.results",
    "export_fmu": "fowtio.fmu.build",
    "check_fmu": "fowtio.fmu.check",
    "simulate_fmu": "fowtio.fmu.simulate:simulate",
    "FowtioError": "fowtio.errors",
    "FormatError": "fowtio.errors",
    "CaseError": "fowtio.errors",
    "ModelError": "fowtio.errors",
}
__all__ = ["__version__", "read", *_PUBLIC]


def __getattr__(name: str):
    """Import a public name when it is first used, so that `import fowtio` stays fast."""
    if name == "read":
        return importlib.import_module("fowtio.read")
    if name not in _PUBLIC:
        raise AttributeError(f"module 'fowtio' has no attribute {name!r}")
    module, _, attribute = _PUBLIC[name].partition(":")
    value = getattr(importlib.import_module(module), attribute or name)
    globals()[name] = value
    return value


def _check_model_package() -> None:
    """The package `model` must be ours: another one of that name first on the path would hide it."""
    spec = importlib.util.find_spec("model")
    ours = Path(__file__).resolve().parent.parent / "model" / "__init__.py"
    if spec is None or spec.origin is None:
        raise ImportError("fowtio's package 'model' is not installed; install fowtio again")
    found = Path(spec.origin).resolve()
    if found != ours and not (found.parent / "conventions.py").is_file():
        raise ImportError(
            f"a foreign module named 'model' ({found}) hides fowtio's own; run from another folder or rename that module"
        )


_check_model_package()
