"""Damaged files: a reader gives finite numbers or a FormatError, never another exception and never NaN.

The seeds are fixed. Default: 8 text files x 150 damages, 6 files of a deck x 110 and 6 binary files x 120, 2,580 in
all; the slow version does 20 x 3,000 with other seeds. Damages of one line or one character at random places, files cut
at random lines, and the dress of other systems: Windows line ends, tabs, Latin-1, Fortran's exponents, stars and
grown-together columns.
"""

import dataclasses

import numpy as np
import openfast_samples as samples
import pytest
from test_fast7 import SAMPLE as FAST7_TEXT
from test_map import SAMPLE as MAP_TEXT
from test_map import WATER
from test_metocean import frame
from test_moordyn import V1, V2
from test_openfast_lin import SAMPLE as LIN_TEXT
from test_openfast_out import DATA, NAMES, TIME, UNITS
from test_openfast_out import text as out_text
from test_rotor_table import text as rotor_text

from fowtio.errors import FowtioError
from fowtio.read.fast7_lin import read_fast7_lin
from fowtio.read.map import map_mooring, read_map
from fowtio.read.metocean import read_metocean
from fowtio.read.moordyn import moordyn_mooring, read_moordyn
from fowtio.read.openfast_deck import read_deck
from fowtio.read.openfast_lin import read_openfast_lin
from fowtio.read.openfast_out import read_openfast_out
from fowtio.read.rotor_table import read_rotor_table
from fowtio.read.turbsim import read_turbsim

DECK = ("oc4.fst", "ElastoDyn.dat", "ElastoDyn_Tower.dat", "HydroDyn.dat", "SeaState.dat", "MAP.dat")
TEXTS = {
    "lin": (LIN_TEXT, read_openfast_lin),
    "fast7": (FAST7_TEXT, read_fast7_lin),
    "out": (out_text(), read_openfast_out),
    "map": (MAP_TEXT, lambda path: map_mooring(read_map(path), **WATER)),
    "moordyn 1": (V1, lambda path: moordyn_mooring(read_moordyn(path), depth=200.0)),
    "moordyn 2": (V2, lambda path: moordyn_mooring(read_moordyn(path))),
    "rotor": (rotor_text(), read_rotor_table),
    "metocean": (frame().to_csv(index=False), read_metocean),
}
BYTES = {
    f"outb {form}": (samples.outb_bytes(TIME, DATA, NAMES, UNITS, form), read_openfast_out) for form in (1, 2, 3, 4)
} | {
    f"bts {ident}": (samples.bts_bytes(np.random.default_rng(2).normal(12, 1, (5, 4, 3, 3)), ident=ident), read_turbsim)
    for ident in (7, 8)
}
WORDS = (
    "NaN",
    "*****",
    "1.0D+03",
    "-1.234E+00-5.678E+00",
    "Infinity",
    "1e999",
    "",
    "é",
    "99999999",
    "-1",
    "0",
    "x",
    "True",
    '"',
    "---",
    "|",
    "#",
    "1,2",
)


def damages(text: str, rng, count: int):
    """Yield damaged versions of a text as bytes."""
    lines = text.split("\n")
    for _ in range(count):
        kind = rng.integers(9)
        new = list(lines)
        i = int(rng.integers(len(lines)))
        if kind == 0:
            new = lines[:i]
        elif kind == 1:
            del new[i]
        elif kind == 2:
            new.insert(i, lines[int(rng.integers(len(lines)))])
        elif kind == 3 and lines[i]:
            k = int(rng.integers(len(lines[i])))
            new[i] = lines[i][:k] + chr(int(rng.integers(32, 256))) + lines[i][k + 1 :]
        elif kind == 4 and lines[i].split():
            parts = lines[i].split()
            parts[int(rng.integers(len(parts)))] = WORDS[int(rng.integers(len(WORDS)))]
            new[i] = "  ".join(parts)
        elif kind == 5:
            new[i] = lines[i].replace("  ", "").replace("\t", "")
        elif kind == 6:
            new[i] = lines[i].replace("E+", "D+").replace("  ", "\t") + "  größer"
        elif kind == 7:
            k = int(rng.integers(len(text)))
            new = (text[:k] + text[k + int(rng.integers(1, 30)) :]).split("\n")
        yield ("\r\n" if kind == 8 else "\n").join(new).encode("latin-1", errors="replace")


def byte_damages(content: bytes, rng, count: int):
    """Yield damaged versions of a binary file: most in its header, where counts and scales are."""
    for _ in range(count):
        new = bytearray(content)
        for _ in range(int(rng.integers(1, 4))):
            at = int(rng.integers(len(new) if rng.random() < 0.3 else min(120, len(new))))
            new[at] = int(rng.integers(256))
        yield bytes(new[: int(rng.integers(len(new)))] if rng.random() < 0.2 else new)


def finite(value, depth=0) -> bool:
    """Tell whether all numbers of typed data are finite; NaN stands for a doubtful value in metocean records only."""
    if isinstance(value, np.ndarray):
        return value.dtype.kind not in "fc" or bool(np.isfinite(value).all())
    if isinstance(value, float):
        return bool(np.isfinite(value))
    if dataclasses.is_dataclass(value) and depth < 6:
        skip = ("input", "values", "input_point")
        return all(finite(getattr(value, f.name), depth + 1) for f in dataclasses.fields(value) if f.name not in skip)
    if isinstance(value, tuple | list):
        return all(finite(v, depth + 1) for v in value)
    return True


def outcomes(path, contents, read) -> tuple[int, int]:
    """Return how many damaged files were read and how many refused; anything else fails."""
    good = bad = 0
    for content in contents:
        path.write_bytes(content)
        try:
            data = read(path)
        except FowtioError:
            bad += 1
            continue
        assert finite(data)
        good += 1
    return good, bad


def seed(name: str, slow: bool) -> int:
    return sum(map(ord, name)) + (1000 if slow else 0)


def fuzz_text(tmp_path, name, count, slow=False):
    text, read = TEXTS[name]
    good, bad = outcomes(tmp_path / "a.dat", damages(text, np.random.default_rng(seed(name, slow)), count), read)
    assert good + bad == count
    assert (
        bad > 0.1 * count
    )  # many damages must be noticed; those of single cells of a metocean record are in its report


def fuzz_bytes(tmp_path, name, count, slow=False):
    content, read = BYTES[name]
    good, bad = outcomes(
        tmp_path / "a.bin", byte_damages(content, np.random.default_rng(seed(name, slow)), count), read
    )
    assert good + bad == count
    assert bad > 0.2 * count


def fuzz_deck(tmp_path, name, count, slow=False):
    fst = samples.copy_deck(tmp_path / "deck")
    path = fst.parent / name
    good, bad = outcomes(
        path, damages(path.read_text(), np.random.default_rng(seed(name, slow)), count), lambda _: read_deck(fst)
    )
    assert good + bad == count
    assert good > 0
    assert bad > 0


@pytest.mark.parametrize("name", TEXTS)
def test_text(tmp_path, name):
    fuzz_text(tmp_path, name, 150)


@pytest.mark.parametrize("name", TEXTS)
def test_cut_after_every_line(tmp_path, name):
    """Each is refused, or read as the shorter table that it is."""
    text, read = TEXTS[name]
    lines = text.splitlines(keepends=True)
    cuts = ["".join(lines[:k]).encode("latin-1", errors="replace") for k in range(len(lines))]
    good, bad = outcomes(tmp_path / "a.dat", cuts, read)
    assert good + bad == len(lines)
    assert bad > 0


@pytest.mark.parametrize("name", BYTES)
def test_bytes(tmp_path, name):
    fuzz_bytes(tmp_path, name, 120)


@pytest.mark.parametrize("name", DECK)
def test_deck(tmp_path, name):
    fuzz_deck(tmp_path, name, 110)


@pytest.mark.slow
@pytest.mark.parametrize("name", [*TEXTS, *BYTES, *DECK])
def test_many_more(tmp_path, name, request):
    if "slow" not in request.config.option.markexpr:
        pytest.skip("takes minutes; run with -m slow")
    fuzz = fuzz_text if name in TEXTS else fuzz_bytes if name in BYTES else fuzz_deck
    fuzz(tmp_path, name, 3000, slow=True)
