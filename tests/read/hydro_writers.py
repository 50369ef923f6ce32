"""Writers of small AQWA, Nemoh and OrcaFlex files for the tests: the layout of those programs, our own numbers.

Each states the format's convention a second time, independently of its reader.
"""

from pathlib import Path

import numpy as np

from model.conventions import weight_stiffness
from model.environment.airy import wavenumber
from model.system.hydro import HydroCoefficients, transfer

LABELS = ("X", "Y", "Z", "RX", "RY", "RZ")


def seen_from(hydro: HydroCoefficients, point) -> tuple[HydroCoefficients, np.ndarray]:
    """Return the coefficients about `point` and the excitation (m, n, 6) for a crest at that point."""
    moved = transfer(hydro, point)
    k = wavenumber(hydro.omega, hydro.depth, hydro.gravity)
    path = np.cos(hydro.heading) * point[0] + np.sin(hydro.heading) * point[1]
    return moved, moved.excitation * np.exp(1j * k * path[:, None])[..., None]


# AQWA .AH1 -----------------------------------------------------------------------------------------------------------


def ah1_text(hydro, centre=(0.0, 0.0, 0.0), structures=1) -> str:
    """Return an .AH1 file of one structure, or of several equal ones with a coupling of a tenth."""
    h, force = seen_from(hydro, np.asarray(centre, dtype=float))
    m, n = force.shape[:2]
    head = [*(f"{v:12.5f}" for v in np.degrees(h.heading)), *(f"{v:12.7f}" for v in h.omega)]
    lines = [
        "* DATE:01/01/24      TIME:12:00:00      RUN:BODY",
        "* FILE VERSION NO 5  CREATED BY AQWA-LINE VERSION 2020 R1.",
        "*",
    ]
    lines += [f"{structures:3d}{m:3d}{n:4d}" + "".join(head[: min(m, 6)])]
    lines += [" " * 13 + "".join(head[a : min(a + 6, m)]) for a in range(6, m, 6)]
    lines += [" " * 13 + "".join(head[m + a : m + a + 6]) for a in range(0, n, 6)]
    lines += ["GENERAL", f"  1  {h.depth:16.3f}{h.density:12.3f}{h.gravity:12.3f}     0     0"]
    bodies = range(1, structures + 1)
    for name, values, form in (
        ("COG", centre, "12.3f"), ("DRAFT", (20.0,), "12.3f"), ("COB", h.centre_of_buoyancy, "12.3f"),
        ("DISPLACEMENT", (h.volume,), "14.4E"),
    ):  # fmt: skip
        lines += [name] + [f"{s:3d}      " + "".join(format(v, form) for v in values) for s in bodies]
    for name, matrix in (("MASS", np.eye(6)), ("HYDSTIFFNESS", h.hydrostatic_stiffness)):
        lines += [name] + [row for s in bodies for row in _rows6(f"{s:3d}", matrix)]
    pairs = [(s, t) for s in bodies for t in bodies]
    for name, values in (("ADDEDMASS", h.added_mass), ("DAMPING", h.radiation_damping)):
        lines.append(name)
        for s, t in pairs:
            for k in range(n):
                lines += _rows6(f"{s:3d}{t:3d}{k + 1:4d}", values[k] * (1.0 if s == t else 0.1))
    for name, matrix in (
        ("ADDEDMASS_LF", h.added_mass_zero), ("DAMPING_LF", np.zeros((6, 6))), ("ADDEDMASS_HF", h.added_mass_infinite),
    ):  # fmt: skip
        lines += [name] + [r for s, t in pairs for r in _rows6(f"{s:3d}{t:3d}", matrix * (1.0 if s == t else 0.1))]
    lines += ["FIDD"] + [f"{s:3d}          " + "  0.0000E+00" * 6 for s in bodies] + ["FORCERAO"]
    for s in bodies:
        for i in range(m):
            for k in range(n):
                amplitude, lag = np.abs(force[i, k]), -np.degrees(np.angle(force[i, k]))
                lines.append(f"{s:3d}{i + 1:3d}{k + 1:4d} " + "".join(f"{v:12.4E}" for v in amplitude))
                lines.append(" " * 11 + "".join(f"{v:12.2f}" for v in lag))
    return "\n".join(lines) + "\n"


def _rows6(indices: str, matrix) -> list[str]:
    return [f"{indices if k == 0 else '':<12}" + "".join(f"{v:12.4E}" for v in row) for k, row in enumerate(matrix)]


# AQWA .LIS -----------------------------------------------------------------------------------------------------------


def spaced(title: str) -> str:
    return "   ".join(" ".join(word) for word in title.split())


def lis_text(hydro, centre=(0.0, 0.0, 0.0), structures=1, limits=True, parts=True) -> str:
    """Return the pages of a .LIS that hold hydrodynamics, for one structure or several equal ones."""
    h, force = seen_from(hydro, np.asarray(centre, dtype=float))
    lines = [" " + "*" * 80, " *********************************** DECK  0 " + "*" * 36, " JOB AQWA  LINE", "1"]
    lines += [_title("GLOBAL PARAMETERS"), ""]
    for label, value in (
        ("WATER  DEPTH  . . . . . . . . . . . . . . . . =", f"{h.depth:12.4f}"),
        ("DENSITY  OF  WATER  . . . . . . . . . . . . . =", f"{h.density:12.3f}"),
        ("ACCELERATION  DUE  TO GRAVITY . . . . . . . . =", f"{h.gravity:12.3f}"),
    ):
        lines.append(" " * 32 + label + value)
    lines += ["1", *_lis_grid(h, structures)]
    for s in range(1, structures + 1):
        lines += ["1", *_lis_statics(h, centre, s), "1", *_lis_parameters(h, centre, force, s, parts)]
        lines += _lis_limits(h, s) if limits else []
    return "\n".join([*lines, "1"]) + "\n"


def _title(text: str) -> str:
    return " " * 14 + f"* * * * {spaced(text)} * * * * "


def _lis_grid(h, structures) -> list[str]:
    lines = [
        _title("WAVE FREQUENCIES / PERIODS AND DIRECTIONS"),
        "",
        " STRUCTURE    FREQUENCY FREQUENCY  PERIOD      WAVE",
    ]
    for s in range(1, structures + 1):
        for n, w in enumerate(h.omega):
            own = f"{s:7d}" if n == 0 else " " * 7
            lines.append(
                f"{own}{n + 1:6d}{w:10.5f}{w / (2 * np.pi):10.5f}{2 * np.pi / w:8.2f}   0.01   1.0   1.0   *UNDEFINED"
            )
        heading = np.degrees(h.heading)
        lines += ["", "            DIRECTIONS   1       2       3", " ------", ""]
        lines += [" " * 20 + "".join(f"{v:8.2f}" for v in heading[a : a + 8]) for a in range(0, len(heading), 8)]
    return lines


def _lis_statics(h, centre, s) -> list[str]:
    x, y, z = h.centre_of_buoyancy
    return [
        _title("HYDROSTATIC PROPERTIES IN THE FREE FLOATING POSITION"), "", _title(f"FOR STRUCTURE {s}"),
        "   STRUCTURE C.O.G.            GX= {:9.4f}  GY= {:9.4f}  GZ= {:9.4f}".format(*centre),
        f"   MESH BASED DISPLACEMENT  . . . . . . . .   = {h.volume:13.5E}",
        f"   POSITION OF THE CENTRE OF BUOYANCY      BX = {x:13.4f}",
        f"                                           BY = {y:13.4f}",
        f"                                           BZ = {z:13.4f}",
    ]  # fmt: skip


def _lis_page(s) -> list[str]:
    return [_title(f"HYDRODYNAMIC PARAMETERS FOR STRUCTURE {s}"), "", "          (WITH RESPECT TO STRUCTURE COG)", ""]


def _lis_matrix(title: str, matrix) -> list[str]:
    rows = [f"{label:>13}" + "".join(f"{v:14.4E}" for v in row) for label, row in zip(LABELS, matrix, strict=True)]
    return ["", " " * 40 + title, " " * 40 + "-" * len(title), "                       X            Y", " ----", *rows]


def _lis_parameters(h, centre, force, s, parts) -> list[str]:
    lines = _lis_page(s) + ["    BUOYANCY FORCE . . . . . =  1.0E+00"]
    lines += ["    THE CENTRE OF GRAVITY  AT ( {:12.4E}, {:12.4E}, {:12.4E})".format(*centre)]
    lines += _lis_matrix("STIFFNESS MATRIX", h.hydrostatic_stiffness)
    for n, w in enumerate(h.omega):
        lines += ["1", *_lis_page(s), f"           WAVE PERIOD = {2 * np.pi / w:7.3f}   WAVE FREQUENCY = {w:7.4f}"]
        lines += _lis_matrix("ADDED  MASS", h.added_mass[n]) + _lis_matrix("DAMPING", h.radiation_damping[n])
    shares = {"DIFFRACTION FORCES": 0.3 + 0.1j, "FROUDE KRYLOV FORCES": 0.7 - 0.1j} if parts else {}
    for name, share in (shares | {"FROUDE KRYLOV + DIFFRACTION FORCES": 1.0}).items():
        lines += [
            "1",
            *_lis_page(s),
            f"      {name}-VARIATION WITH WAVE PERIOD/FREQUENCY",
            " PERIOD   FREQ   DIRECTION   X",
            "",
        ]
        lines += _lis_force(h, force * share)
    lines += ["1", *_lis_page(s), "      R.A.O.S-VARIATION WITH WAVE PERIOD/FREQUENCY", ""] + _lis_force(
        h, force * 1e-6
    )
    return lines


def _lis_force(h, force) -> list[str]:
    lines = []
    for m, heading in enumerate(np.degrees(h.heading)):
        for n, w in enumerate(h.omega):
            polar = zip(np.abs(force[m, n]), -np.degrees(np.angle(force[m, n])), strict=True)
            direction = f"{heading:10.2f}" if n == 0 else " " * 10
            columns = "".join(f"{a:10.2E}{p:8.2f}" for a, p in polar)
            lines.append(f"{2 * np.pi / w:8.2f}{w:8.3f}{direction}{columns}")
        lines.append("")
    return lines


def _lis_limits(h, s) -> list[str]:
    lines = [
        "1",
        _title("HYDRODYNAMIC PARAMETERS AT LOW & HIGH FREQUENCIES"),
        "",
        f"     {spaced(f'FOR STRUCTURE {s}')}",
        "",
    ]
    for w, matrix in ((0.001, h.added_mass_zero), (100.0, h.added_mass_infinite)):
        lines += [f"     WAVE FREQUENCY = {w:9.4f}(RAD/S)     ENCOUNTER FREQUENCY = {w:9.4f}(RAD/S)"]
        lines += _lis_matrix("ADDED MASS", matrix)
    return lines


# Nemoh ---------------------------------------------------------------------------------------------------------------


def write_nemoh(
    folder: Path,
    hydro,
    *,
    point=(0.0, 0.0, 0.0),
    centre=(0.0, 0.0, 0.0),
    wave_point=(0.0, 0.0),
    version=3,
    unit="rad/s",
    bodies=1,
) -> Path:
    """Write a Nemoh folder: moments about `point`, hydrostatics about `centre` (of gravity), crest at `wave_point`."""
    h, _ = seen_from(hydro, np.asarray(point, dtype=float))
    k = wavenumber(h.omega, h.depth, h.gravity)
    path = np.cos(h.heading) * wave_point[0] + np.sin(h.heading) * wave_point[1]
    force = np.conj(h.excitation * np.exp(1j * k * path[:, None])[..., None])  # e^{-i omega t}
    results, mesh = folder / ("results" if version == 3 else "Results"), folder / ("mesh" if version == 3 else "Mesh")
    for each in (folder, results, mesh):
        each.mkdir(exist_ok=True)
    (folder / "Nemoh.cal").write_text(_cal(h, point, wave_point, version, bodies))
    column = {"rad/s": h.omega, "Hz": h.omega / (2 * np.pi), "s": 2 * np.pi / h.omega}[unit]
    pairs = np.stack([h.added_mass, h.radiation_damping], axis=-1)  # (n, force, motion, 2)
    full = np.zeros((len(column), bodies, 6, bodies, 6, 2))
    for s in range(bodies):
        for t in range(bodies):
            full[:, s, :, t] = pairs * (1.0 if s == t else 0.1)
    zones = [
        (f"Motion of body {s + 1:4d} in DoF {i + 1:4d}", full[:, :, :, s, i].reshape(len(column), -1))
        for s in range(bodies) for i in range(6)
    ]  # fmt: skip
    (results / "RadiationCoefficients.tec").write_text(_tec(column, unit, zones, ("A", "B"), bodies))
    title = "Excitation force" if version == 3 else "Diffraction force"
    files = {
        "ExcitationForce": (title, 1.0),
        "DiffractionForce": ("Diffraction force", 0.4 + 0.2j),
        "FKForce": ("FKforce", 0.6 - 0.2j),
    }
    for name, (words, share) in files.items():
        zones = []
        for m, heading in enumerate(np.degrees(h.heading)):
            f = np.tile(force[m] * share, (1, bodies))
            zones.append(
                (
                    f"{words} - beta = {heading:7.3f} deg",
                    np.stack([np.abs(f), np.angle(f)], axis=-1).reshape(len(column), -1),
                )
            )
        (results / f"{name}.tec").write_text(_tec(column, unit, zones, ("abs(F", "angle(F"), bodies))
    about = transfer(hydro, np.asarray(centre, dtype=float))
    for s in range(bodies):
        tag = "" if bodies == 1 else f"_{s}"
        pairs = zip("XYZ", about.centre_of_buoyancy, centre, strict=True)
        rows = [f" {c}F = {b:9.3f} - {c}G = {g:9.3f}" for c, b, g in pairs]
        rows += [f" Displacement = {h.volume:15.7E}", " Waterplane area =   0.1000000E+03"]
        (mesh / f"Hydrostatics{tag}.dat").write_text("\n".join(rows) + "\n")
        matrix = "\n".join("".join(f"{v:16.7E}" for v in row) for row in about.hydrostatic_stiffness)
        (mesh / f"KH{tag}.dat").write_text(matrix + "\n")
    return folder


def _cal(h, point, wave_point, version, bodies) -> str:
    depth = 0.0 if np.isinf(h.depth) else h.depth
    lines = [
        "--- Environment ---",
        f"{h.density:.6f}  ! RHO ! KG/M**3 ! Fluid specific volume",
        f"{h.gravity:.6f} ! G ! M/S**2 ! Gravity",
    ]
    lines += [
        f"{depth:.4f}  ! DEPTH ! M ! Water depth",
        f"{wave_point[0]}\t{wave_point[1]}\t! XEFF YEFF ! M ! Wave measurement point",
    ]
    lines += ["--- Description of floating bodies ---", f"{bodies}  ! Number of bodies"]
    axes = np.eye(3)
    for s in range(bodies):
        lines += [
            f"--- Body {s + 1} ---",
            "mesh\\body.dat  ! Name of mesh file",
            "100 90  ! Number of points and number of panels",
        ]
        for what in ("degrees of freedom", "resulting generalised forces"):
            lines.append(f"6 ! Number of {what}")
            for kind, where in ((1, (0.0, 0.0, 0.0)), (2, point)):
                for axis in axes:
                    lines.append(
                        " ".join([str(kind), *(f"{v:g}." for v in axis), *(f"{v:.6f}" for v in where)])
                        + " ! about a point"
                    )
        lines.append("0 ! Number of lines of additional information")
    first = "1 " if version == 3 else ""
    lines += [
        "--- Load cases to be solved ---",
        f"{first}{len(h.omega)}\t{h.omega[0]:.6f} {h.omega[-1]:.6f} ! Number of wave frequencies",
    ]
    heading = np.degrees(h.heading)
    lines += [
        f"{len(heading)} {heading[0]} {heading[-1]} ! Number of wave directions, Min and Max (degrees)",
        "--- Post processing ---",
    ]
    return "\n".join(lines) + "\n"


def _tec(column, unit, zones, names, bodies) -> str:
    symbol = {"rad/s": "w (rad/s)", "Hz": "f (Hz)", "s": "T (s)"}[unit]
    lines = [f'VARIABLES="{symbol}"']
    close = ")" if names[0].endswith("F") else ""
    lines += [
        f'"{names[0]} {s + 1:3d} {i + 1:3d}{close}" "{names[1]} {s + 1:3d} {i + 1:3d}{close}"'
        for s in range(bodies)
        for i in range(6)
    ]
    for title, values in zones:
        lines.append(f'Zone t="{title}",I={len(column):6d},F=POINT')
        lines += ["".join(f"{v:16.7E}" for v in (w, *row)) for w, row in zip(column, values, strict=True)]
    return "\n".join(lines) + "\n"


# OrcaFlex ------------------------------------------------------------------------------------------------------------


def orcaflex_text(
    hydro, *, point=(0.0, 0.0, 0.0), mass=1.0e7, centre=(0.0, 0.0, 0.0), conventions=None, types=("Body1 type",)
) -> str:
    """Return an OrcaFlex text file with the conventions given (the defaults are OrcaFlex's own)."""
    h, force = seen_from(hydro, np.asarray(point, dtype=float))
    own = {
        "RAOWaveUnit": "amplitude", "WavesReferredToBy": "frequency (rad/s)", "RAOPhaseConvention": "leads",
        "RAOPhaseUnitsConvention": "degrees", "RAOPhaseRelativeToConvention": "crest", "SurgePositive": "forward",
        "SwayPositive": "port", "HeavePositive": "up", "RollPositiveStarboard": "down", "PitchPositiveBow": "down",
        "YawPositiveBow": "port",
    } | (conventions or {})  # fmt: skip
    lines = [
        "\ufeff%YAML 1.1",
        "# Type: Model",
        "# Program: OrcaFlex 11.3d",
        "---",
        "General:",
        "  # Units",
        "  UnitsSystem: SI",
    ]
    lines += ["  StageDuration:", "    - 8", "    - 16", "Environment:", f"  Density: {h.density / 1000!r}"]
    lines += [
        f"  WaterDepth: {'Infinity' if np.isinf(h.depth) else h.depth}",
        "  WaveTrains:",
        "    - Name: Wave1",
        "      WavePeriod: 8",
    ]
    lines += ["  CurrentDepth, CurrentFactor:", "    - [0, 1]", "VesselTypes:"]
    for name in types:
        lines += [
            f"  - Name: {name}",
            "    Length: ~",
            "    # Conventions",
            *(f"    {k}: {v}" for k, v in own.items()),
            "    Draughts:",
        ]
        lines += _draught(h, force, point, mass, centre, own)
    return "\n".join([*lines, "Vessels:", "  - Name: Body1", "    VesselType: Body1 type", "..."]) + "\n"


def _flow(values, width=0) -> str:
    text = "[" + ", ".join(repr(float(v)) for v in values) + "]"
    return (
        text
        if not width or len(text) < width
        else text[: (at := text.rfind(", ", 0, width) + 1)] + "\n" + " " * 16 + text[at + 1 :]
    )


def _draught(h, force, point, mass, centre, own) -> list[str]:
    c = h.hydrostatic_stiffness + weight_stiffness(mass, np.subtract(centre, point), h.gravity)
    pad = "        "
    lines = [
        "      - Name: Draught1",
        f"{pad}Mass: {mass / 1000!r}",
        f"{pad}CentreOfMass: {_flow(centre)}",
        f"{pad}LoadRAOs:",
    ]
    lines += [f"{pad}  RAOOrigin: {_flow(point)}", f"{pad}  PhaseOrigin: [~, ~, ~]", f"{pad}  RAOs:"]
    modes = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")
    names = ", ".join(["RAOPeriodOrFrequency"] + [f"RAO{m}{p}" for m in modes for p in ("Amp", "Phase")])
    w = h.omega[::-1]
    column = {"frequency (rad/s)": w, "frequency (Hz)": w / (2 * np.pi), "period (s)": 2 * np.pi / w}[
        own["WavesReferredToBy"]
    ]
    for m, heading in enumerate(np.degrees(h.heading)):
        lines += [
            f"{pad}    - RAODirection: {heading!r}".replace("np.float64(", "").replace(")", ""),
            f"{pad}      {names}:",
        ]
        for value, f in zip(column, force[m, ::-1], strict=True):
            amplitude, phase = _told(f / 1000, own)
            lines.append(f"{pad}        - " + _flow([value, *np.stack([amplitude, phase], axis=-1).ravel()], 100))
    lines += [
        f"{pad}# Stiffness, added mass and damping",
        f"{pad}AMDMethod: Frequency dependent",
        f"{pad}ReferenceOrigin: {_flow(point)}",
    ]
    lines += [f"{pad}DisplacedVolume: {h.volume!r}", f"{pad}CentreOfBuoyancy: {_flow(h.centre_of_buoyancy)}"]
    lines += [f"{pad}HydrostaticStiffnessz, HydrostaticStiffnessRx, HydrostaticStiffnessRy:"]
    lines += [f"{pad}  - {_flow(row)}" for row in c[2:5, 2:5] / 1000] + [f"{pad}FrequencyDependentAddedMassAndDamping:"]
    high, low = ("0", "Infinity") if own["WavesReferredToBy"].startswith("period") else ("Infinity", "0")
    blocks = [(high, h.added_mass_infinite, np.zeros((6, 6)))]
    blocks += [
        (repr(float(v)), a, b) for v, a, b in zip(column, h.added_mass[::-1], h.radiation_damping[::-1], strict=True)
    ]
    for value, a, b in [*blocks, (low, h.added_mass_zero, np.zeros((6, 6)))]:
        lines.append(f"{pad}  - AMDPeriodOrFrequency: {value}")
        for stem, matrix in (("AddedMassMatrix", a), ("Damping", b)):
            lines.append(f"{pad}    " + ", ".join(stem + axis for axis in ("X", "Y", "Z", "Rx", "Ry", "Rz")) + ":")
            lines += [f"{pad}      - {_flow(row, 100)}" for row in matrix / 1000]
    return lines + [f"{pad}OtherLinearDamping: [0, 0, 0, 0, 0, 0]"]


def _told(f: np.ndarray, own) -> tuple[np.ndarray, np.ndarray]:
    """Return amplitude and phase of a phasor (lead of a crest) as the conventions say."""
    usual = {"SurgePositive": "forward", "SwayPositive": "port", "HeavePositive": "up"}
    usual |= {"RollPositiveStarboard": "down", "PitchPositiveBow": "down", "YawPositiveBow": "port"}
    f = f * np.array([1 if own[k] == v else -1 for k, v in usual.items()])
    # time from the event to the crest: a quarter period before, half, or a quarter after
    wait = {"crest": 0.0, "zero up-crossing": 0.25, "trough": 0.5, "zero down-crossing": -0.25}[
        own["RAOPhaseRelativeToConvention"]
    ]
    lead = np.angle(f) - 2 * np.pi * wait
    phase = lead if own["RAOPhaseConvention"] == "leads" else -lead
    phase = np.degrees(phase) if own["RAOPhaseUnitsConvention"] == "degrees" else phase
    return np.abs(f) / (1 if own["RAOWaveUnit"] == "amplitude" else 2), phase
