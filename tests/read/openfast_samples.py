"""Sample files for the tests of the readers, made from the embedded deck and from numbers: nothing third-party."""

from __future__ import annotations

import re
import shutil
import struct
from pathlib import Path

import numpy as np

OC4 = Path(__file__).parents[2] / "validation" / "oc4_deepcwind"
LIN_FILE = OC4 / "linearisation" / "turbine" / "U14" / "m.1.lin"


def copy_deck(folder: Path) -> Path:
    """Copy the embedded deck and return its primary file."""
    shutil.copytree(OC4 / "input", folder)
    return folder / "oc4.fst"


def set_value(path: Path, name: str, value: str) -> None:
    """Replace what stands before a name."""
    lines = path.read_text().splitlines()
    found = [i for i, line in enumerate(lines) if re.search(rf"\s{re.escape(name)}\s+-", line)]
    assert len(found) == 1, (name, found)
    lines[found[0]] = re.sub(rf"^.*?(\s{re.escape(name)}\s+-)", lambda m: value + m[1], lines[found[0]])
    path.write_text("\n".join(lines) + "\n")


def line_of(path: Path, name: str) -> int:
    """Return the line number of a name."""
    lines = path.read_text().splitlines()
    return next(i for i, line in enumerate(lines, start=1) if re.search(rf"\s{re.escape(name)}(\s|$)", line))


def drop(path: Path, *names: str) -> None:
    """Delete the lines that give these names."""
    keep = [
        line
        for line in path.read_text().splitlines()
        if not any(re.search(rf"\s{re.escape(n)}\s+-", line) for n in names)
    ]
    path.write_text("\n".join(keep) + "\n")


def insert_after(path: Path, name: str, *new: str) -> None:
    """Add lines below the line of a name."""
    lines = path.read_text().splitlines()
    at = line_of(path, name)
    path.write_text("\n".join([*lines[:at], *new, *lines[at:]]) + "\n")


def replace(path: Path, old: str, new: str) -> None:
    """Replace text that must be there."""
    text = path.read_text()
    assert old in text, old
    path.write_text(text.replace(old, new))


def sections(text: str) -> list[str]:
    """Return a file cut at its section rules, the title first."""
    return re.split(r"(?m)^(?=-{10,})", text)


# --- layouts of older versions ----------------------------------------------------------------------------------------


def to_version(fst: Path, version: int) -> None:
    """Turn a copy of the embedded deck (OpenFAST 5) into the layout of OpenFAST 4, 3 or 2."""
    folder = fst.parent
    drop(fst, "NRotors", "MirrorRotor", "ModCoupling", "RhoInf", "ConvTol", "MaxConvIter")
    _structure_before_5(folder)
    _sections_before_5(folder / "HydroDyn.dat")
    if version <= 3:
        _waves_in_hydrodyn(fst)
    if version == 2:
        _version_2(fst)


def _structure_before_5(folder: Path) -> None:
    drop(folder / "ElastoDyn.dat", "PtfmXYIner", "PtfmYZIner", "PtfmXZIner", "PtfmRefxt", "PtfmRefyt")
    blade, tower = folder / "ElastoDyn_Blade.dat", folder / "ElastoDyn_Tower.dat"
    _widen(blade, "BlFract", 1, "PitchAxis", "0.25")
    _widen(tower, "HtFract", 4, "TwGJStif", "1.0E+11")


def _widen(path: Path, header: str, at: int, name: str, value: str) -> None:
    """Insert a column into a table whose first column is `header`."""
    out, inside = [], False
    for line in path.read_text().splitlines():
        parts = line.split()
        if parts[:1] == [header]:
            inside, extra = True, name
        elif inside and line.startswith("---"):
            inside = False
        else:
            extra = "(-)" if line.lstrip().startswith("(") else value
        if inside:
            line = "  ".join([*parts[:at], extra, *parts[at:]])
        out.append(line)
    path.write_text("\n".join(out) + "\n")


def _sections_before_5(hydro: Path) -> None:
    """Drop rectangular sections and their columns, and give the cylindrical ones their former names."""
    kept = [s for s in sections(hydro.read_text()) if "RECTANG" not in s.splitlines()[0]]
    text = "".join(kept)
    for name in ("NPropSets", "NCoefDpth", "NCoefMembers"):
        text = text.replace(f"{name}Cyl", name)
    rows = []
    for line in text.splitlines():
        parts = line.split("!")[0].split()
        members = parts[:1] == ["MemberID"] and "MSecGeom" in parts
        if members or (len(parts) == 11 and parts[-1].upper() in ("TRUE", "FALSE", "(FLAG)")):
            line = "  ".join([*parts[:5], *parts[7:9], parts[10]])
        rows.append(line)
    hydro.write_text("\n".join(rows) + "\n")
    drop(hydro, "NAddDOF", "HstMod", "AMMod")


def _waves_in_hydrodyn(fst: Path) -> None:
    hydro, sea = fst.parent / "HydroDyn.dat", fst.parent / "SeaState.dat"
    wet = "".join(s for s in sections(sea.read_text()) if re.match(r"-+ (WATER|WAVES|CURRENT)", s))
    parts = sections(hydro.read_text())
    hydro.write_text("".join([*parts[:1], wet, *parts[1:]]) if parts[0] else "".join([parts[1], wet, *parts[2:]]))
    drop(fst, "CompSeaSt", "SeaStFile")
    sea.unlink()


def _version_2(fst: Path) -> None:
    folder = fst.parent
    hydro, elasto, inflow = folder / "HydroDyn.dat", folder / "ElastoDyn.dat", folder / "InflowWind.dat"
    drop(fst, "Gravity", "AirDens", "WtrDens", "KinVisc", "SpdSound", "Patm", "Pvap", "WtrDpth", "MSL2SWL", "MHK")
    insert_after(elasto, "DT", "       9.80665   Gravity        - gravity (m/s^2)")
    for name, value in (("WtrDens", "1025"), ("WtrDpth", "200"), ("MSL2SWL", "0")):
        set_value(hydro, name, value)
    for k in (1, 2, 3):
        replace(elasto, f"BldFile({k})", f"BldFile{k}  ")
    drop(hydro, "NBody", "NBodyMod", "ExctnDisp", "ExctnCutOff", "PtfmYMod", "PtfmRefY", "PtfmYCutOff", "NExctnHdg")
    drop(hydro, "PtfmRefxt", "PtfmRefyt", "PtfmRefzt", "PtfmRefztRot", "WaveDisp")
    lines = hydro.read_text().splitlines()
    at = line_of(hydro, "AddF0") - 1
    flags = [f"True  {n} - load on" for n in ("PtfmSgF", "PtfmSwF", "PtfmHvF", "PtfmRF", "PtfmPF", "PtfmYF")]
    lines[at : at + 6] = [*flags, "0 0 0 0 0 0   AddF0 - constant force and moment (N, N m)"]
    hydro.write_text("\n".join(lines) + "\n")
    replace(inflow, "FileName_BTS ", "Filename     ")
    replace(inflow, "Filename_Uni ", "Filename     ")


# --- linearisation files ----------------------------------------------------------------------------------------------


def lin_text(
    matrices: dict, states, inputs, outputs, *, order_column=True, digits=9, wind_speed=True, prefix=""
) -> str:
    """Return the text of an OpenFAST linearisation file.

    matrices by name, those besides A to D come as Jacobians; states (name, point, rotating, order), inputs and outputs
    (name, point, rotating), point a number or three.
    """
    out = [
        "",
        f"Linearized model: {prefix}made by the tests",
        " linked with  NWTC Subroutine Library; ElastoDyn; Some (<1>)",
        "",
    ]
    out += ["Description from the FAST input file: a sample", "", "Simulation information:"]
    out += ["   Simulation time:   10.0 s", "   Rotor Speed:   1.2500 rad/s", "   Azimuth:   0.5000 rad"]
    out += ["   Wind Speed:   11.0000 m/s"] if wind_speed else []
    counts = zip(("continuous states", "discrete states", "constraint states", "inputs", "outputs"),
                 (len(states), 0, 0, len(inputs), len(outputs)), strict=True)  # fmt: skip
    out += [f"   Number of {name}:   {n}" for name, n in counts]
    jacobians = [name for name in matrices if name not in "ABCD"]
    out += [f"   Jacobians included in this file?   {'Yes' if jacobians else 'No'}", ""]
    out += _lin_table("Order of continuous states:", states, order_column, digits)
    derivatives = [(f"First time derivative of {s[0]}/s", *s[1:]) for s in states]
    out += _lin_table("Order of continuous state derivatives:", derivatives, order_column, digits)
    out += _lin_table("Order of inputs:", [(*s, 0) for s in inputs], order_column, digits)
    out += _lin_table("Order of outputs:", [(*s, 0) for s in outputs], order_column, digits)
    if jacobians:
        out += ["", "Jacobian matrices:", ""]
    for name in jacobians:
        out += _lin_matrix(name, matrices[name], digits)
    out += ["", "Linearized state matrices:", ""]
    for name in (n for n in "ABCD" if n in matrices):
        out += _lin_matrix(name, matrices[name], digits)
    return "\n".join(out) + "\n"


def _lin_table(title, rows, order_column, digits) -> list[str]:
    if not rows:
        return []
    head = (
        "   Row/Column Operating Point   Rotating Frame?"
        + (" Derivative Order" if order_column else "")
        + " Description"
    )
    out = [title, head, "   ---------- ---------------   --------------- -----------"]
    for k, (name, point, rotating, order) in enumerate(rows, start=1):
        values = ", ".join(f"{v:.{digits}E}" for v in np.atleast_1d(point))
        out.append(
            f"  {k:9d}   {values}      {'T' if rotating else 'F'}   "
            + (f"   {order}     " if order_column else "")
            + name
        )
    return [*out, ""]


def _lin_matrix(name, matrix, digits) -> list[str]:
    rows = ["".join(f" {v: .{digits}E}" for v in row) for row in np.asarray(matrix)]
    return [f"{name}: {matrix.shape[0]} x {matrix.shape[1]}", *rows, ""]


# --- binary time series and wind --------------------------------------------------------------------------------------


def outb_bytes(
    time, data, names, units, form: int, *, width: int = 10, description: str = "made by the tests"
) -> bytes:
    """Return an OpenFAST binary output file; form is FileFmtID."""
    time, data = np.asarray(time, dtype=float), np.asarray(data, dtype=float)
    channels, steps = data.shape[1], len(time)
    out = (
        struct.pack("<h", form) + (struct.pack("<h", width) if form == 4 else b"") + struct.pack("<ii", channels, steps)
    )
    scale = (2**31 - 1) / max(np.ptp(time), 1e-9) * 0.999
    offset = -scale * time.mean()
    out += struct.pack("<dd", scale, offset) if form == 1 else struct.pack("<dd", time[0], time[1] - time[0])
    span = np.where(np.ptp(data, axis=0) > 0, np.ptp(data, axis=0), 1.0)
    slope = (65535 / span * 0.999).astype("<f4")
    shift = (-slope * (data.max(axis=0) + data.min(axis=0)) / 2).astype("<f4")
    if form != 3:
        out += slope.tobytes() + shift.tobytes()
    width = width if form == 4 else 10
    text = description.encode("latin-1")
    out += struct.pack("<i", len(text)) + text
    out += b"".join(n.encode("latin-1").ljust(width)[:width] for n in ("Time", *names))
    out += b"".join(f"({u})".encode("latin-1").ljust(width)[:width] for u in ("s", *units))
    if form == 1:
        out += np.round(time * scale + offset).astype("<i4").tobytes()
    return out + (data.astype("<f8") if form == 3 else np.round(data * slope + shift).astype("<i2")).tobytes()


def bts_bytes(velocity, *, dy=10.0, dz=10.0, dt=0.1, speed=12.0, hub=90.0, bottom=60.0, tower=0, ident=7) -> bytes:
    """Return a TurbSim wind field; velocity (t, z, y, 3)."""
    steps, nz, ny, _ = velocity.shape
    low, high = velocity.min(axis=(0, 1, 2)), velocity.max(axis=(0, 1, 2))
    slope = (65534 / np.where(high > low, high - low, 1.0)).astype(np.float32)
    offset = (-32767 - slope * low).astype(np.float32)
    text = b"made by the tests"
    scales = [v for pair in zip(slope, offset, strict=True) for v in pair]
    head = struct.pack("<h4i6f", ident, nz, ny, tower, steps, dz, dy, dt, speed, hub, bottom) + struct.pack(
        "<6f", *scales
    )
    packed = np.round(velocity * slope + offset).astype("<i2").reshape(steps, -1)
    with_tower = np.hstack([packed, np.full((steps, 3 * tower), 7, dtype="<i2")])
    return head + struct.pack("<i", len(text)) + text + with_tower.astype("<i2").tobytes()
