"""The sea of a deck: the waves section of SeaState's file, or of HydroDyn's in decks older than SeaState."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.openfast_input import InputFile
from model.environment.current import Current
from model.environment.sea import SeaState, default_gamma

_REGULAR, _IRREGULAR, _WHITE_NOISE = 1, 2, 3


@dataclass(frozen=True, eq=False, kw_only=True)
class DeckSea:
    """What a deck says of the water: the sea (None when fowtio has no such kind), density [kg/m3] and depth [m] (None
    when left to the primary file), a still-water level offset [m], and the current (its depth left to the primary file; None when
    there is none).
    """

    sea: SeaState | None
    wave_model: str
    density: float | None
    depth: float | None
    level_offset: float
    current: Current | None


def deck_sea(deck: InputFile) -> DeckSea:
    """Return the sea of an input file that holds OpenFAST's waves section; raise FormatError."""
    model = deck.text("WaveMod")
    if not model[:1].isdigit():
        raise FormatError(deck.path, deck.line("WaveMod"), expected="a number for WaveMod", found=model)
    kind = int(model) if model.isdigit() else -1
    if kind in (_IRREGULAR, _WHITE_NOISE):
        heading = np.radians(deck.number("WaveDir"))
        low, high = deck.number("WvLowCOff"), deck.number("WvHiCOff")
    spreading = None
    if deck.has("WaveDirMod") and deck.integer("WaveDirMod", 0) == 1:
        spreading = _spreading(deck)
    sea = None
    if kind == 0:
        sea = SeaState(kind="still")
    elif kind == _IRREGULAR:
        hs, tp = deck.number("WaveHs"), deck.number("WaveTp")
        gamma = deck.number("WavePkShp", default_gamma(hs, tp) if hs > 0 and tp > 0 else None)
        sea = _sea(deck, "WaveHs", kind="jonswap", significant_height=hs, peak_period=tp, gamma=gamma, heading=heading,
                   spreading=spreading, low_cutoff=low, high_cutoff=high)  # fmt: skip
    elif kind == _WHITE_NOISE:
        band = (low / (2 * np.pi), high / (2 * np.pi))
        sea = _sea(
            deck, "WvHiCOff", kind="white_noise", significant_height=deck.number("WaveHs"), band=band, heading=heading
        )
    return DeckSea(
        sea=sea, wave_model=model, density=deck.number("WtrDens", None), depth=deck.number("WtrDpth", None),
        level_offset=deck.number("MSL2SWL", 0.0), current=_current(deck),
    )  # fmt: skip


def _current(deck: InputFile) -> Current | None:
    """Return the standard current profile (CurrMod 1); refuse one defined by a user's routine."""
    mode = deck.integer("CurrMod", 0) if deck.has("CurrMod") else 0
    if mode == 0:
        return None
    if mode != 1:
        raise FormatError(deck.path, deck.line("CurrMod"), expected="CurrMod 0 or 1", found=deck.text("CurrMod"))
    waves = deck.number("WaveDir", 0.0)
    out = Current(
        sub_surface=deck.number("CurrSSV0"), sub_surface_heading=np.radians(deck.number("CurrSSDir", waves)),
        near_surface=deck.number("CurrNSV0"), near_surface_depth=deck.number("CurrNSRef"),
        near_surface_heading=np.radians(deck.number("CurrNSDir")), depth_independent=deck.number("CurrDIV"),
        depth_independent_heading=np.radians(deck.number("CurrDIDir")),
    )  # fmt: skip
    if out.near_surface and out.near_surface_depth <= 0:
        raise FormatError(
            deck.path, deck.line("CurrNSRef"), expected="a depth above zero", found=deck.text("CurrNSRef")
        )
    return None if out.still else out


def _spreading(deck: InputFile) -> float:
    """Return the exponent s of cos^2s(x/2) that spreads as OpenFAST's cos^2S(pi x/R) over a range R does.

    Both have the same mean of cos x, which is s/(s + 1) for the first; at R = 360 degrees s is S. Source: OpenFAST,
    HydroDyn theory, directional spreading.
    """
    exponent, span = deck.number("WaveDirSpread"), np.radians(deck.number("WaveDirRange", 360.0))
    for name, wrong in (("WaveDirSpread", exponent <= 0), ("WaveDirRange", not 0 < span <= 2 * np.pi + 1e-9)):
        if wrong:
            raise FormatError(
                deck.path, deck.line(name), expected=f"{name} above zero (and up to 360 degrees)", found=deck.text(name)
            )
    x = (np.arange(2000) + 0.5) / 2000 * span - span / 2
    share = np.cos(np.pi * x / span) ** (2 * exponent)
    mean = float((share * np.cos(x)).sum() / share.sum())
    return mean / (1 - mean)


def _sea(deck: InputFile, name: str, **values) -> SeaState:
    try:
        return SeaState(**values)
    except ValueError as error:
        raise FormatError(deck.path, deck.line(name), expected="a sea that can be", hint=str(error)) from None
