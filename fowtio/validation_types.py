"""What a comparison with time series holds: figures and verdicts of every channel, spectra, histories, doubts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fowtio.case_validation import Tolerance
from fowtio.reference import Finding
from fowtio.validation_lack import Lack
from model.response.identify import Estimate

WITHIN, SCATTER, OUTSIDE, NOT_JUDGED = "within", "within scatter", "outside", "not judged"
NAN = float("nan")


@dataclass(frozen=True, eq=False, kw_only=True)
class ChannelComparison:
    """One channel, model against reference; errors are fractions, NaN where a figure does not apply. docs/validation.md defines them.

    std_error: σ of model over reference less one, in the reference's own wave spectrum (and the wind that its rotor felt);
    std_error_state: in the state's spectra; hub: with the wind of the reference at the hub; same_waves: driven by the reference's own
    wave records (and that wind); nonlinear: likewise, with quadratic drag itself; memory: that and
    the radiation memory as HydroDyn convolves it. scatter and interval (half width, 95 %) are the reference's own from seed to seed.
    rao_error weighs amplitudes by energy over the whole band, band_errors (4) over bands; estimator_error is what a perfect model
    would have. correlation: time history with the model's amplitudes and the reference's phases; correlation_same_waves: predicted
    from the waves (and that wind). Verdicts of the standard deviation, that in the state's own wind (where the seeds' interval
    counts), the mean and the RAO.
    """

    name: str
    unit: str
    written: str
    std_model: float
    std_reference: float
    std_error: float
    std_error_state: float
    std_error_hub: float
    std_error_same_waves: float
    std_error_nonlinear: float
    std_error_memory: float
    scatter: float
    interval: float
    mean_model: float
    mean_reference: float
    mean_error: float
    mean_error_rest: float
    mean_interval: float
    rao_error: float
    rao_error_same_waves: float
    rao_error_nonlinear: float
    rao_error_memory: float
    estimator_error: float
    log_error: float
    band_errors: tuple[float, ...]
    coherence_mean: float
    peak_frequency: float
    peak_frequency_error: float
    peak_error: float
    peak_leakage: float
    extreme_model: float
    extreme_reference: float
    excess_kurtosis: float
    correlation: float
    correlation_same_waves: float
    tolerance: Tolerance
    std_verdict: str
    state_verdict: str
    mean_verdict: str
    rao_verdict: str

    @property
    def verdicts(self) -> list[str]:
        """The verdicts on what is judged."""
        return [v for v in (self.std_verdict, self.state_verdict, self.mean_verdict, self.rao_verdict) if v != NOT_JUDGED]

    @property
    def verdict(self) -> str:
        """The worst of the verdicts, "not judged" without any."""
        return next((v for v in (OUTSIDE, SCATTER, WITHIN) if v in self.verdicts), NOT_JUDGED)

    @property
    def passed(self) -> bool:
        """Whether nothing that is judged is outside its tolerance."""
        return self.verdict != OUTSIDE


@dataclass(frozen=True, eq=False, kw_only=True)
class Histories:
    """Parts of the first record in time (t) [s], deviations from the mean (t, c): reference, model's amplitudes with the reference's
    phases, prediction from the waves (NaN with wind).
    """

    time: np.ndarray
    reference: np.ndarray
    phases: np.ndarray
    predicted: np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True)
class Validation:
    """A comparison of one state with its time series.

    kind: "waves" (RAOs against one long-crested sea), "spectra" (wind or several headings) or "mean" (nothing moves). channels;
    estimate of the reference and model_rao (smoothed by its window), model_rao_raw, model_phase [rad], model_coherence, quadratic_rao, memory_rao on its frequencies (n, c);
    model_spectrum and model_spectrum_raw (n, c) per Hz in the reference's own inputs, wave_part (n, c) what the waves give of it;
    histograms: edges (b + 1) in standard deviations and the reference's densities (b, c);
    narrowest half-power width [Hz] of a peak; unmatched channels of the reference, missing ones; findings; lack, what the linear model
    lacks; histories; errors of the state's waves, wind
    at the hub and wind of the rotor (standard deviation over the records' less one), felt_wind, whether the records tell the latter.
    """

    state: str
    kind: str
    files: tuple[str, ...]
    channels: tuple[ChannelComparison, ...]
    tolerance: float
    discard: float
    duration: float
    step: float
    unmatched: tuple[str, ...]
    missing: tuple[str, ...]
    findings: tuple[Finding, ...]
    estimate: Estimate | None = None
    model_rao: np.ndarray | None = None
    model_rao_raw: np.ndarray | None = None
    model_phase: np.ndarray | None = None
    model_coherence: np.ndarray | None = None
    quadratic_rao: np.ndarray | None = None
    memory_rao: np.ndarray | None = None
    model_spectrum: np.ndarray | None = None
    model_spectrum_raw: np.ndarray | None = None
    wave_part: np.ndarray | None = None
    histogram_edges: np.ndarray | None = None
    histograms: np.ndarray | None = None
    narrowest: float = NAN
    lack: Lack | None = None
    histories: Histories | None = None
    wave_error: float = NAN
    wind_error: float = NAN
    felt_error: float = NAN
    felt_wind: bool = False

    @property
    def passed(self) -> bool:
        """Whether every channel is within its tolerances and nothing is wrong with the reference."""
        return all(c.passed for c in self.channels) and not any(f.severity == "error" for f in self.findings)
