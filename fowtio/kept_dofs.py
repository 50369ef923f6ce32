"""What blades and drivetrain do that are kept in the model: transfer functions beside those with them following statically,
and their whirling modes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fowtio.workflow import Model, OperatingPoint, StateLoads
from model.conventions import PLATFORM_DOFS
from model.response.assemble import assemble, equilibrium
from model.response.loads import ChannelResponse, channel_response, linear_outputs, response_spectra
from model.response.solve import prepare, solve, trapezoid_weights
from model.system.contributions import condense, turbine_contribution
from model.system.tower import TOWER_MODES

CHANNELS = ("PtfmSurge", "PtfmSway", "PtfmHeave", "PtfmRoll", "PtfmPitch", "PtfmYaw", "TTDspFA", "TwrBsFxt", "TwrBsMyt")
DRAWN = ("PtfmSurge", "PtfmPitch", "TTDspFA", "TwrBsMyt")


@dataclass(frozen=True, eq=False, kw_only=True)
class KeptComparison:
    """Channels (c) of one state with all degrees of freedom that the study keeps, and with the rotor's condensed: standard
    deviations (c), differences (c) of the transfer functions to waves and to wind, weighed with their spectra as a share of the
    former; transfer functions (2, n, c) to waves and (2, n, c) to wind, all first; frequencies omega (n) [rad/s]; dropped
    names; wind_speed [m/s].
    """

    state: str
    wind_speed: float
    dropped: tuple[str, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]
    omega: np.ndarray
    std: np.ndarray
    std_condensed: np.ndarray
    wave_difference: np.ndarray
    wind_difference: np.ndarray
    to_wave: np.ndarray
    to_wind: np.ndarray


@dataclass(frozen=True, kw_only=True)
class Whirl:
    """The two whirling modes of a blade mode in the fixed frame: damped frequencies [Hz], damping ratios, and half their distance
    beside the rotor's speed [Hz]."""

    wind_speed: float
    name: str
    backward: float
    forward: float
    damping: tuple[float, float]
    half_distance: float
    rotor_speed: float


def compare_kept(model: Model, results: Sequence[StateLoads]) -> KeptComparison | None:
    """Return the comparison for the first state whose operating point keeps more than platform and tower, None without such a state."""
    item = next((i for i in results if _rotor_dofs(i.point)), None)
    if item is None:
        return None
    full, drive = item.channels, item.response.excitation
    condensed, spectra = _condensed(model, item)
    names = tuple(n for n in CHANNELS if n in full.names and n in condensed.names)
    a, b = ([c.index(n) for n in names] for c in (full, condensed))
    heading = int(np.argmax(drive.wave_spectrum.sum(axis=1)))
    to_wave = np.stack([full.to_wave[heading][:, a], condensed.to_wave[heading][:, b]])
    to_wind = np.stack([full.to_wind[:, a], condensed.to_wind[:, b]])
    step = trapezoid_weights(drive.omega)
    return KeptComparison(
        state=item.state.name, wind_speed=item.point.wind_speed, dropped=_rotor_dofs(item.point), names=names,
        units=tuple(full.units[k] for k in a), omega=drive.omega, std=item.statistics.std[a],
        std_condensed=np.sqrt(step @ spectra[:, b]), wave_difference=_difference(to_wave, drive.wave_spectrum[heading] * step),
        wind_difference=_difference(to_wind, drive.wind_spectrum * step), to_wave=to_wave, to_wind=to_wind,
    )  # fmt: skip


def whirling(points: Sequence[OperatingPoint]) -> tuple[Whirl, ...]:
    """Return the whirling pairs of every operating point that keeps blades: modes of the cosine and the sine coordinate."""
    out = []
    for point in points:
        modes = point.modes
        place = {name: k for k, name in enumerate(modes.names)}
        for name in (n.removesuffix("_cosine") for n in modes.names if n.endswith("_cosine")):
            if f"{name}_sine" not in place:
                continue
            pair = [place[f"{name}_cosine"], place[f"{name}_sine"]]
            ratio = modes.damping_ratio[pair]
            damped = modes.frequency[pair] * np.sqrt(np.maximum(1 - ratio**2, 0)) / (2 * np.pi)
            low, high = np.argsort(damped)
            out.append(
                Whirl(
                    wind_speed=point.wind_speed, name=name, backward=float(damped[low]), forward=float(damped[high]),
                    damping=(float(ratio[low]), float(ratio[high])), half_distance=float(damped[high] - damped[low]) / 2,
                    rotor_speed=point.turbine.rotor_speed / (2 * np.pi),
                )
            )  # fmt: skip
    return tuple(out)


def _rotor_dofs(point: OperatingPoint) -> tuple[str, ...]:
    return tuple(d for d in point.system.dofs if d not in PLATFORM_DOFS + TOWER_MODES)


def _condensed(model: Model, item: StateLoads) -> tuple[ChannelResponse, np.ndarray]:
    """Return channels and their spectra (n, c) of a state with blades and drivetrain following statically."""
    point, system = item.point, item.point.system
    dofs = tuple(d for d in system.dofs if d not in _rotor_dofs(point))
    turbine = condense(replace(point.turbine, gradient_force=_of_turbine(system, point.turbine)), dofs)
    own = turbine_contribution(turbine)
    parts = [own if p.name == own.name else p for p in system.parts]
    smaller = assemble(
        dofs, turbine, parts, system.hydro, system.drag, system.mooring, system.quadratic_damping, system.current
    )
    mean = equilibrium(smaller)
    drive, options = item.response.excitation, model.case.options
    grid = prepare(smaller, drive.omega, drive.heading, low_frequency=options.low_frequency_excitation)
    response = solve(smaller, mean, drive, grid=grid, drag=options.drag_model)
    channels = channel_response(linear_outputs(smaller, mean, model.deck.elastodyn.structure), response)
    return channels, response_spectra(channels, response)


def _of_turbine(system, turbine) -> np.ndarray:
    """Return the gradient forces of a system in the turbine's degrees of freedom."""
    out = np.zeros((2, len(turbine.dofs)))
    for k, dof in enumerate(turbine.dofs):
        if dof in system.dofs:
            out[:, k] = system.gradient_force[:, system.dofs.index(dof)]
    return out


def _difference(pair: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return sqrt(sum |a - b|^2 w / sum |a|^2 w) (c), NaN where nothing drives."""
    power = (np.abs(pair[0]) ** 2 * weight[:, None]).sum(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.sqrt((np.abs(pair[0] - pair[1]) ** 2 * weight[:, None]).sum(axis=0) / np.where(power > 0, power, np.nan))


def kept_table(found: KeptComparison):
    """Return the comparison as a table for people."""
    from fowtio.write.quantities import people, worth_drawing
    from fowtio.write.table import Column, Table

    columns = (
        Column(name="Channel"), Column(name="Unit"), Column(name="σ, all kept"), Column(name="σ, condensed"),
        Column(name="Change of σ", unit="%", decimals=2), Column(name="Difference to waves", unit="%", decimals=2),
        Column(name="Difference to wind", unit="%", decimals=2),
    )  # fmt: skip
    rows = []
    for k in worth_drawing(found.names, found.units, found.std):
        unit, factor = people(found.units[k])
        change = 100 * (found.std_condensed[k] / found.std[k] - 1)
        shares = (100 * float(d[k]) if np.isfinite(d[k]) else None for d in (found.wave_difference, found.wind_difference))
        rows.append((found.names[k], unit, float(found.std[k]) * factor, float(found.std_condensed[k]) * factor, float(change), *shares))
    note = (
        f"State {found.state}, {found.wind_speed:g} m/s; condensed: {len(found.dropped)} degrees of freedom of blades and drivetrain follow "
        "statically. Differences of the complex transfer functions, weighed with the spectra of waves and wind."
    )
    return Table(name="kept_dofs", title="Degrees of freedom kept against condensed", columns=columns, rows=tuple(rows), note=note)


def whirl_table(rows: Sequence[Whirl]):
    """Return the whirling pairs as a table for people."""
    from fowtio.write.quantities import point_label
    from fowtio.write.table import Column, Table

    columns = (
        Column(name="Operating point"), Column(name="Blade mode"), Column(name="Backward", unit="Hz", decimals=4),
        Column(name="Forward", unit="Hz", decimals=4), Column(name="Damping backward", unit="%", decimals=1),
        Column(name="Damping forward", unit="%", decimals=1), Column(name="Half their distance", unit="Hz", decimals=4),
        Column(name="Rotor speed", unit="Hz", decimals=4),
    )  # fmt: skip
    body = tuple(
        (point_label(r.wind_speed), r.name, r.backward, r.forward, *(100 * d for d in r.damping), r.half_distance, r.rotor_speed) for r in rows
    )
    note = "Damped frequencies in the fixed frame. A blade mode alone is seen there at plus and minus the rotor's speed; tower and air couple it."
    return Table(name="whirl", title="Whirling modes", columns=columns, rows=body, note=note)


def kept_section(found: KeptComparison, pairs: Sequence[Whirl]):
    """Return the report section: tables and figure."""
    from fowtio.write.report import Section
    from fowtio.write.style import as_picture

    tables = (kept_table(found), *((whirl_table(pairs),) if pairs else ()))
    return Section(title="Flexible rotor: what the degrees of freedom kept do", content=(*tables, as_picture(_drawing(found))))


def _drawing(found: KeptComparison):
    import matplotlib as mpl

    from fowtio.write.quantities import panel_label, people
    from fowtio.write.style import BLUE, ORANGE, RC, Drawing, frequency_axis, grid, legend, log_axis

    hertz = found.omega / (2 * np.pi)
    names = [n for n in DRAWN if n in found.names]
    rows = [(per, h) for per, h in (("m", found.to_wave), ("(m/s)", found.to_wind)) if np.any(h)]
    with mpl.rc_context(RC):
        figure, axes = grid(len(rows), len(names), height=2.0)
        for row, (per, transfer) in enumerate(rows):
            for ax, name in zip(axes[row], names, strict=True):
                k = found.names.index(name)
                unit, factor = people(found.units[k])
                size = np.abs(transfer[:, :, k]) * factor
                one = ax.plot(hertz, size[0], color=BLUE)[0]
                two = ax.plot(hertz, size[1], color=ORANGE, ls="--", lw=1.1)[0]
                log_axis(ax, size.ravel())
                ax.set_title(f"{panel_label(name)} [{unit}/{per}]")
                frequency_axis(ax, max(hertz[0], 2e-3), hertz[-1], label=row == len(rows) - 1)
        legend(figure, [one, two], ["all kept", "blades and drivetrain condensed"])
    caption = f"Per metre of wave amplitude and per m/s of the rotor's wind, state {found.state}."
    return Drawing(name="kept_dofs", group="kept", title="Transfer functions, all kept and condensed", caption=caption, figure=figure)
