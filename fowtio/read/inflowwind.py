"""InflowWind input files: what wind a deck asks for."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from fowtio.errors import FormatError
from fowtio.read.openfast_input import InputFile, is_rule, read_input, tokens, unquote

_STEADY, _TURBSIM = 1, 3
_KINDS = {
    1: "steady", 2: "uniform, from a file", 3: "TurbSim", 4: "Bladed", 5: "HAWC", 6: "user-defined", 7: "Bladed native",
}  # fmt: skip


@dataclass(frozen=True, eq=False, kw_only=True)
class InflowWind:
    """What an InflowWind file says: kind of wind in words, speed [m/s] of a steady wind (None of others), the TurbSim
    file (None of others; not looked for), the wind's direction of propagation [deg] from +x.
    """

    path: Path
    kind: str
    speed: float | None
    turbsim: Path | None
    direction: float


def read_inflowwind(path: str | Path) -> InflowWind:
    """Return what an InflowWind file says of the wind; raise FormatError."""
    deck = read_input(path)
    kind = deck.integer("WindType")
    if kind not in _KINDS:
        known = ", ".join(f"{k} ({name})" for k, name in _KINDS.items())
        raise FormatError(deck.path, deck.line("WindType"), expected=f"a WindType of {known}", found=str(kind))
    turbsim = deck.path.parent / _turbsim_file(deck).replace("\\", "/") if kind == _TURBSIM else None
    return InflowWind(
        path=deck.path,
        kind=_KINDS[kind],
        speed=deck.number("HWindSpeed") if kind == _STEADY else None,
        turbsim=turbsim,
        direction=deck.number("PropagationDir", 0.0),
    )


def _turbsim_file(deck: InputFile) -> str:
    """Return the name of the TurbSim file; files older than OpenFAST 2.6 call it Filename, as others of its sections."""
    if deck.has("FileName_BTS"):
        return deck.text("FileName_BTS")
    inside = False
    for line in deck.lines:
        if is_rule(line):
            inside = "turbsim" in line.lower() or "wind type = 3" in line.lower() or "windtype = 3" in line.lower()
        parts = tokens(line)
        if inside and len(parts) > 1 and parts[1].lower().startswith("filename"):
            return unquote(parts[0])
    raise FormatError(deck.path, expected="FileName_BTS, the TurbSim file", found="none")
