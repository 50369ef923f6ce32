"""Is the FMU right? The standard's rules, the compiler's warnings, its size, and its responses beside the frequency-domain model's."""

from __future__ import annotations

import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtio.errors import ModelError
from fowtio.fmu.build import FLAGS, Exported, compile_library, find_compiler
from fowtio.fmu.runner import Runner, need_fmpy
from model.reduce.importance import excited
from model.reduce.targets import force_gain

LARGEST = 500_000  # bytes
MAGNITUDE, PHASE = 0.02, np.radians(2.0)
STEP = 0.1  # s
PATIENCE = 20000.0  # s: an FMU that has not forgotten its start by then is compared by its directional derivatives
DRIVES = {"wave_force": "wave forces", "elevation": "the wave elevation"}
FORCES = ("ForceX", "ForceY", "ForceZ", "MomentX", "MomentY", "MomentZ")


@dataclass(frozen=True, kw_only=True)
class Finding:
    """One check: what was looked at, whether it passed, what was found."""

    name: str
    passed: bool
    text: str


@dataclass(frozen=True, eq=False, kw_only=True)
class Comparison:
    """RAOs of an FMU (n, c) beside those of the frequency-domain model at omega (n) [rad/s]; counted (n, c) where they are large enough
    to be compared; channel names.
    """

    omega: np.ndarray
    channels: tuple[str, ...]
    fmu: np.ndarray
    model: np.ndarray
    counted: np.ndarray

    def magnitude_error(self) -> np.ndarray:
        """Largest relative error of the magnitude, by channel (c)."""
        return np.abs(np.abs(self._ratio) - 1).max(axis=0)

    def phase_error(self) -> np.ndarray:
        """Largest error of the phase [rad], by channel (c)."""
        return np.abs(np.angle(self._ratio)).max(axis=0)

    @property
    def _ratio(self) -> np.ndarray:
        return np.where(self.counted, self.fmu, 1.0) / np.where(self.counted, self.model, 1.0)


def check_fmu(exported: Exported, *, progress: Callable[[str], None] = lambda text: None) -> list[Finding]:
    """Return what the checks of all files of an export found."""
    out = []
    for version, path in exported.files.items():
        progress(f"validating FMI {version}")
        out += check_file(path)
        drives = driven_by(exported)
        if not drives:
            out.append(Finding(name=f"{path.name}: responses", passed=True, text="no wave input from outside, not compared"))
        for driven in drives:
            progress(f"comparing responses to {DRIVES[driven]}, FMI {version}")
            out.append(_responses(f"{path.name}: responses to {DRIVES[driven]}", compare_responses(exported, path, driven)))
    return out


def _responses(name: str, found: Comparison) -> Finding:
    """Return what a comparison of RAOs found."""
    magnitude, phase = found.magnitude_error(), found.phase_error()
    worst = int(np.argmax(magnitude))
    text = f"largest error {100 * magnitude.max():.2f} % ({found.channels[worst]}) and {np.degrees(phase.max()):.2f} deg"
    return Finding(name=name, passed=bool(magnitude.max() <= MAGNITUDE and phase.max() <= PHASE), text=text)


def check_file(path: str | Path) -> list[Finding]:
    """Return what FMPy's validation, a compiler with warnings as errors, and the size say of one FMU."""
    need_fmpy()
    from fmpy.validation import validate_fmu

    path = Path(path)
    problems = validate_fmu(str(path))
    out = [
        Finding(
            name=f"{path.name}: rules of the standard (FMPy)",
            passed=not problems,
            text="; ".join(problems) or "no finding",
        )
    ]
    with tempfile.TemporaryDirectory() as scratch:
        with zipfile.ZipFile(path) as archive:
            archive.extractall(scratch)
        try:
            compile_library(
                Path(scratch) / "sources", Path(scratch) / "check.so", find_compiler("linux64"), flags=FLAGS
            )
            out.append(Finding(name=f"{path.name}: its own sources compile", passed=True, text="no warning"))
        except ModelError as error:
            out.append(Finding(name=f"{path.name}: its own sources compile", passed=False, text=str(error)))
    size = path.stat().st_size
    out.append(Finding(name=f"{path.name}: size", passed=size < LARGEST, text=f"{size / 1e3:.0f} kB"))
    return out


def driven_by(exported: Exported) -> list[str]:
    """Return the wave inputs from outside: of "wave_force" and "elevation"."""
    names = {v.name for v in exported.description.of_kind("input")}
    return [k for k, name in (("wave_force", "Wave.ForceX"), ("elevation", "Wave.Elevation")) if name in names]


def compare_responses(
    exported: Exported, path: str | Path, driven: str, *, low: float = 0.005, high: float = 0.5
) -> Comparison:
    """Return the RAOs of an FMU in co-simulation beside the model's, low to high [Hz].

    The FMU is driven by a periodic sum of waves of equal amplitude and random phases until it has forgotten its start; the
    Fourier coefficients of one period are the RAOs without leakage. One that is hardly damped (a hull without drag) would never
    forget, and its RAOs are those of its directional derivatives.
    """
    found = exported.linearised
    repeat = 2 * np.pi / 0.00625  # s: the lines hold all multiples of 0.025 rad/s
    count = round(repeat / STEP)
    step = repeat / count
    lines = np.arange(int(np.ceil(low * repeat)), int(high * repeat) + 1)
    omega = 2 * np.pi * lines / repeat
    phase = np.exp(2j * np.pi * np.random.default_rng(1).random(len(lines)))
    force = found.waves.at(omega, found.column)
    channels = {v.channel: v.name for v in exported.description.of_kind("output") if v.channel}
    gain = force_gain(found.point.system, found.point.mean, found.point.outputs, found.response.drag_damping, omega)
    reference = np.einsum("nck,nk->nc", gain, force)
    slowest = -np.linalg.eigvals(found.space.a).real.max()
    with Runner(path) as runner:
        if slowest * PATIENCE > 8.0:
            warm = int(np.ceil(8.0 / slowest / repeat))
            signals = _signals(driven, lines, phase, force, count, found.space.time_shift, omega)
            tiled = {n: np.append(np.tile(s, warm + 1), s[0]) for n, s in signals.items()}
            series = runner.run(count * (warm + 1), step, tiled, list(channels.values()))
            one = np.fft.rfft(series[count * warm : count * (warm + 1)], axis=0)[lines] / (count / 2)
            hold = np.sinc(lines / count) ** 2  # of the straight lines between samples
            fmu = one / (phase * hold)[:, None]
        else:
            fmu = _by_matrices(runner, driven, omega, force, found.space.time_shift, list(channels.values()))
    model = reference[:, [found.point.outputs.names.index(n) for n in channels]]
    units = [found.point.outputs.units[found.point.outputs.names.index(n)] for n in channels]
    return Comparison(
        omega=omega,
        channels=tuple(channels),
        fmu=fmu,
        model=model,
        counted=excited(np.abs(model), units),
    )


def _by_matrices(runner: Runner, driven: str, omega, force, shift: float, outputs: list[str]) -> np.ndarray:
    """Return the RAOs (n, c) that follow from the directional derivatives."""
    inputs = ["Wave.Elevation"] if driven == "elevation" else [f"Wave.{n}" for n in FORCES]
    a, b, c, d = runner.matrices(inputs, outputs)
    drive = np.exp(1j * omega * shift)[:, None] if driven == "elevation" else force
    iw = 1j * omega[:, None, None]
    state = np.linalg.solve(iw * np.eye(len(a)) - a, (drive @ b.T)[..., None])[..., 0]
    return state @ c.T + drive @ d.T


def _signals(driven: str, lines, phase, force, count: int, shift: float, omega) -> dict[str, np.ndarray]:
    """Return one period of the inputs that waves of unit amplitude make."""

    def series(amplitude):
        spectrum = np.zeros(count // 2 + 1, dtype=complex)
        spectrum[lines] = amplitude
        return np.fft.irfft(spectrum, count) * (count / 2)

    if driven == "elevation":
        return {"Wave.Elevation": series(phase * np.exp(1j * omega * shift))}
    return {f"Wave.{n}": series(phase * force[:, k]) for k, n in enumerate(FORCES)}
