"""The JSON documents of the commands: SI numbers with a companion `units` object."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fowtio import __version__
from fowtio.case import Case
from fowtio.workflow import Model, OperatingPoint, StateLoads
from model.conventions import DOF_UNITS
from model.response.assemble import all_parts

if TYPE_CHECKING:
    from fowtio.kept_dofs import KeptComparison, Whirl
    from fowtio.validation import Validation


def all_speeds(case: Case) -> list[float]:
    """Return every wind speed [m/s] that a study can be built at: its states' and its linearisations'."""
    return sorted({s.wind_speed for s in case.states} | {e.wind_speed for e in case.linearisations} | ({0.0} if not case.states else set()))


def modes_json(model: Model) -> dict:
    """Return natural modes; `modes` are those of the first operating point, `operating_points` all."""
    points = [{"wind_speed": p.wind_speed, "modes": _modes(p)} for p in model.points]
    return {
        "case": str(model.case.path), "version": __version__, "modes": points[0]["modes"], "operating_points": points,
        "units": {"frequency_hz": "Hz", "period_s": "s", "damping_ratio": "-", "wind_speed": "m/s"},
        "notes": [
            *model.notes,
            "periods use the added mass at the mode's own frequency; period_infinite_added_mass_s uses the infinite-frequency one, "
            "as a linearisation without radiation memory does",
        ],
    }  # fmt: skip


def run_json(model: Model, results: tuple[StateLoads, ...], folder: Path, files: list[Path]) -> dict:
    """Return the results of the main job; the top level repeats the first state."""
    states = {r.state.name: _state(r) for r in results}
    first = states[results[0].state.name]
    return {
        "case": str(model.case.path), "title": model.case.title, "version": __version__, "state": results[0].state.name, **first,
        "states": states, "modes": _modes(model.points[0]), "folder": str(folder), "files": [str(f) for f in files],
        "notes": list(model.notes), "units": _units(results[0]),
    }  # fmt: skip


def kept_json(kept: KeptComparison | None, pairs: Sequence[Whirl]) -> dict:
    """Return what a flexible rotor does beside a condensed one and its whirling pairs, nothing without one."""
    if kept is None:
        return {}
    names = ("std", "std_condensed", "wave_difference", "wind_difference")
    channels = {
        name: {key: float(v) if np.isfinite(v := getattr(kept, key)[k]) else None for key in names} for k, name in enumerate(kept.names)
    }
    return {
        "kept_dofs": {"state": kept.state, "condensed": list(kept.dropped), "channels": channels},
        "whirling": [dict(vars(p)) for p in pairs],
    }


def check_json(model: Model) -> dict:
    """Return what a study holds and who contributes what at every operating point."""
    return {
        "case": str(model.case.path), "files": [str(f) for f in model.deck.files], "depth": model.deck.depth, "density": model.deck.density,
        "gravity": model.deck.gravity, "frequencies": len(model.hydro.omega), "headings": len(model.hydro.heading),
        "drag_elements": len(model.points[0].system.drag), "states": [s.name for s in model.states],
        "operating_points": [_contributions(p) for p in model.points], "notes": list(model.notes),
        "units": {"mass": "kg, kg m, kg m2", "stiffness": "N/m, N, N m", "force": "N, N m", "depth": "m", "density": "kg/m3", "gravity": "m/s2"},
    }  # fmt: skip


def validation_json(found: list[Validation], files: list[Path], decays: Sequence = ()) -> dict:
    """Return the comparison; `channels` are those of the first reference, `references` all."""
    references = [
        {
            "state": v.state, "kind": v.kind, "passed": v.passed, "tolerance": v.tolerance, "files": list(v.files),
            "channels": {c.name: _channel(c) for c in v.channels}, "channels_without_counterpart": list(v.unmatched), "channels_missing": list(v.missing),
            "findings": [{"severity": f.severity, "subject": f.subject, "text": f.text} for f in v.findings],
            "averages": None if v.estimate is None else v.estimate.averages, "segment": None if v.estimate is None else v.estimate.segment,
            "wave_std_error": _finite(v.wave_error), "hub_wind_std_error": _finite(v.wind_error), "rotor_wind_std_error": _finite(v.felt_error),
            "lacking": {} if v.lack is None else {
                d: {"damping": float(v.lack.terms.damping[k]), "stiffness": float(v.lack.terms.stiffness[k]), "frequency_hz": float(v.lack.frequency[k]),
                    "damping_ratio": float(v.lack.damping_ratio[k])} for k, d in enumerate(v.lack.terms.dofs)
            },
        } for v in found
    ]  # fmt: skip
    return {
        "channels": references[0]["channels"] if references else {}, "passed": all(v.passed for v in (*found, *decays)), "references": references,
        "decays": {d.channel: _decay(d) for d in decays}, "files": [str(f) for f in files],
        "units": {"std": "as the channel's unit", "errors": "fraction", "peak_frequency": "Hz", "period": "s", "damping": "N s/m, N m s", "stiffness": "N/m, N m",
                  "damping_quadratic": "damping ratio per unit of the channel", "segment": "s"},
    }  # fmt: skip


def _decay(d) -> dict:
    return {
        "unit": d.unit, "period": float(d.model.period[0]), "period_reference": d.found.period, "period_error": d.period_error, "damping_linear": d.model_linear,
        "damping_linear_reference": float(d.found.linear), "damping_quadratic": d.model_quadratic, "damping_quadratic_reference": float(d.found.quadratic),
        "damping_error": _finite(d.damping_error), "passed": d.passed, "file": d.file,
    }  # fmt: skip


def _modes(point: OperatingPoint) -> list[dict]:
    m = point.modes
    return [
        {
            "name": name, "frequency_hz": w / (2 * np.pi), "period_s": 2 * np.pi / w, "damping_ratio": float(z),
            "period_infinite_added_mass_s": 2 * np.pi / wi,
            "shape": {dof: abs(x) for dof, x in zip(point.system.dofs, shape, strict=True)},
        } for name, w, z, wi, shape in zip(m.names, m.frequency, m.damping_ratio, m.frequency_infinite, m.shape.T, strict=True)
    ]  # fmt: skip


def _state(result: StateLoads) -> dict:
    point, figures = result.point, result.statistics
    document = {
        "wind_speed": result.state.wind_speed,
        "mean_offset": {d: float(x) for d, x in zip(point.system.dofs, point.mean.offset, strict=True)},
        "statistics": {
            name: {
                "unit": unit, "mean": float(figures.mean[k]), "std": float(figures.std[k]),
                "expected_maximum": float(figures.mean[k] + figures.extreme[k]), "expected_minimum": float(figures.mean[k] - figures.extreme[k]),
                "zero_crossing_period": _finite(figures.zero_crossing_period[k]),
            } for k, (name, unit) in enumerate(zip(result.channels.names, result.channels.units, strict=True))
        },
        "drag_iterations": result.response.iterations,
    }  # fmt: skip
    if point.mean.mooring is not None:
        state = point.mean.mooring
        document["mooring"] = {
            "stiffness": state.stiffness.tolist(), "force": state.force.tolist(), "fairlead_tension": state.fairlead_tension.tolist(),
            "anchor_tension": state.anchor_tension.tolist(),
        }  # fmt: skip
    return document


def _units(result: StateLoads) -> dict:
    return {
        "mean_offset": {d: DOF_UNITS.get(d, "m") for d in result.point.system.dofs}, "mooring.stiffness": "N/m, N, N m",
        "mooring.fairlead_tension": "N", "mooring.anchor_tension": "N", "wind_speed": "m/s", "zero_crossing_period": "s",
        "statistics": dict(zip(result.channels.names, result.channels.units, strict=True)),
    }  # fmt: skip


def _contributions(point: OperatingPoint) -> dict:
    def row(p):
        return {"name": p.name, "source": p.source, "mass": p.mass.tolist(), "damping": p.damping.tolist(), "stiffness": p.stiffness.tolist(),
                "force": p.force.tolist()}  # fmt: skip

    parts = all_parts(point.system, point.mean)
    return {
        "wind_speed": point.wind_speed, "dofs": list(point.system.dofs), "contributions": [row(p) for p in parts],
        "taken_out_of_linearisation": [row(p) for p in point.contained],
        "sum": {k: sum(getattr(p, k) for p in parts).tolist() for k in ("mass", "damping", "stiffness")},
    }  # fmt: skip


def _channel(c) -> dict:
    plain = {
        "std": c.std_model, "std_reference": c.std_reference, "std_error": c.std_error, "std_error_state": c.std_error_state, "std_error_hub_wind": c.std_error_hub,
        "std_error_same_waves": c.std_error_same_waves, "std_error_nonlinear": c.std_error_nonlinear, "std_error_memory": c.std_error_memory,
        "scatter": c.scatter, "interval": c.interval, "mean": c.mean_model, "mean_reference": c.mean_reference, "mean_error": c.mean_error, "mean_error_rest": c.mean_error_rest,
        "mean_interval": c.mean_interval, "rao_error": c.rao_error, "rao_error_same_waves": c.rao_error_same_waves,
        "rao_error_nonlinear": c.rao_error_nonlinear, "rao_error_memory": c.rao_error_memory, "estimator_error": c.estimator_error, "log_error": c.log_error,
        "peak_error": c.peak_error, "peak_frequency": c.peak_frequency, "peak_frequency_error": c.peak_frequency_error, "peak_leakage": c.peak_leakage,
        "coherence_mean": c.coherence_mean, "extreme": c.extreme_model, "extreme_reference": c.extreme_reference, "excess_kurtosis": c.excess_kurtosis,
        "correlation": c.correlation, "correlation_same_waves": c.correlation_same_waves,
    }  # fmt: skip
    return {
        "unit": c.unit, "name_in_files": c.written, **{k: _finite(v) for k, v in plain.items()}, "rao_error_bands": [_finite(b) for b in c.band_errors],
        "verdict": c.verdict, "passed": c.passed,
    }  # fmt: skip


def _finite(x) -> float | None:
    return float(x) if np.isfinite(x) else None
