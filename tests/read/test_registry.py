"""The registry: every reader is in it, every file finds its own format and no other, and importing it costs little."""

import ast
import inspect
import os
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import openfast_samples as samples
import pytest
from test_fast7 import SAMPLE as FAST7_TEXT
from test_map import SAMPLE as MAP_TEXT
from test_moordyn import V1, V2
from test_rotor_table import text as rotor_text

import fowtio.read
from fowtio.errors import FormatError
from fowtio.read import describe, read_any, recognise, registry
from fowtio.read.registry import INTERNAL, Format

FOLDER = Path(fowtio.read.__file__).parent
MODULES = sorted(p.stem for p in FOLDER.glob("*.py") if p.stem != "__init__")
OUT_TEXT = "Time\tPtfmSurge\n(s)\t(m)\n0.0\t1.5\n0.1\t1.6\n"
CSV = "time,Hs (m),wind speed (m/s)\n2020-01-01 00:00,1.5,8\n2020-01-01 01:00,1.6,9\n"


def make_samples(folder: Path) -> dict[str, Path]:
    """Write one file of every format of ours and return its path by the name of its constant."""
    fst = samples.copy_deck(folder / "deck")
    text = {
        "FAST7_LIN": FAST7_TEXT,
        "MAP": MAP_TEXT,
        "MOORDYN": V2,
        "MOORDYN 1": V1,
        "ROTOR_TABLE": rotor_text(),
        "OPENFAST_OUT": OUT_TEXT,
        "METOCEAN": CSV,
    }
    out = {}
    for name, content in text.items():
        out[name] = folder / f"{name.lower().replace(' ', '_')}.dat"
        out[name].write_bytes(content.encode("latin-1"))
    wind = np.random.default_rng(1).normal(12, 1, (4, 9, 7, 3))
    binary = {
        "TURBSIM": samples.bts_bytes(wind),
        "OPENFAST_OUT 2": samples.outb_bytes([0, 0.1], [[1.0], [2.0]], ("x",), ("m",), 2),
    }
    for name, content in binary.items():
        out[name] = folder / f"{name.lower().replace(' ', '_')}.bin"
        out[name].write_bytes(content)
    deck = {
        "OPENFAST_DECK": fst,
        "ELASTODYN": "ElastoDyn.dat",
        "HYDRODYN": "HydroDyn.dat",
        "SEASTATE": "SeaState.dat",
        "INFLOWWIND": "InflowWind.dat",
        "OPENFAST_INPUT": "ElastoDyn_Tower.dat",
        "WAMIT_RADIATION": "hydro/oc4.1",
        "WAMIT_EXCITATION": "hydro/oc4.3",
        "WAMIT_HYDROSTATICS": "hydro/oc4.hst",
        "WAMIT_SET": "hydro/oc4",
    }
    return out | {name: fst.parent / file for name, file in deck.items()} | {"OPENFAST_LIN": samples.LIN_FILE}


@pytest.fixture(scope="module")
def sample_files(tmp_path_factory):
    return make_samples(tmp_path_factory.mktemp("formats"))


def constants() -> dict[str, Format]:
    """Return every registered format by the name of its constant."""
    out = {}
    for module in registry.MODULES:
        named = {
            name: value
            for name, value in vars(import_module(f"fowtio.read.{module}")).items()
            if isinstance(value, Format)
        }
        out |= {name: value for name, value in named.items() if value in registry.formats_of(module)}
    return out


@pytest.mark.parametrize("module", MODULES)
def test_every_module_is_registered_or_internal(module):
    assert (module in registry.MODULES) != (module in INTERNAL), (
        f"put {module} into the registry or among the internal modules"
    )
    written = set(re.findall(r"(?m)^([A-Z0-9_]+)(?:: Format)? = Format\(", (FOLDER / f"{module}.py").read_text()))
    own = {
        name
        for name, value in vars(import_module(f"fowtio.read.{module}")).items()
        if isinstance(value, Format) and value in registry.formats_of(module)
    }
    assert own == written
    assert bool(own) == (module in registry.MODULES)


def test_every_registered_module_is_there():
    assert set(registry.MODULES) | set(INTERNAL) == set(MODULES)


def test_formats_have_different_names():
    names = [f.name for f in fowtio.read.FORMATS]
    assert len(set(names)) == len(names) == len(constants())
    with pytest.raises(AttributeError):
        _ = fowtio.read.NOTHING


def test_every_sample_finds_its_format_and_gives_a_description(sample_files):
    known = constants()
    for name, path in sample_files.items():
        assert recognise(path) is known[name.split()[0]], name
        rows = describe(path)
        assert rows[0] == ("format", known[name.split()[0]].name)
        assert len(rows) > 1
        assert all(isinstance(label, str) and isinstance(text, str) and label and text for label, text in rows), rows
        assert read_any(path) is not None


def test_no_other_format_takes_a_sample(sample_files):
    """All but the general ones (any OpenFAST-style input file) tell their own files only."""
    general = {"OPENFAST_INPUT"}
    known = constants()
    for name, path in sample_files.items():
        head = path.read_bytes()[:65536] if path.is_file() else b""
        taken = {other for other, f in known.items() if f.recognises(path, head)} - general
        assert taken <= {name.split()[0]}, name


@pytest.mark.parametrize(
    "content", [b"", b"hello\n", bytes(range(256)) * 20, b"1 2 3\n" * 100, "é".encode() * 300, b"\x01\x00" * 400]
)
def test_other_files_are_of_no_format(tmp_path, content):
    path = tmp_path / "other.xyz"
    path.write_bytes(content)
    with pytest.raises(FormatError):
        read_any(path)


def test_missing_files_and_folders(tmp_path):
    with pytest.raises(FormatError, match="does not exist"):
        recognise(tmp_path / "no.dat")
    with pytest.raises(FormatError, match="known format"):
        recognise(tmp_path)


@pytest.mark.parametrize("module", MODULES)
def test_public_functions_and_classes_say_what_they_do(module):
    tree = ast.parse((FOLDER / f"{module}.py").read_text())
    assert ast.get_docstring(tree), module
    public = [n for n in tree.body if isinstance(n, ast.FunctionDef | ast.ClassDef) and not n.name.startswith("_")]
    methods = [m for c in public if isinstance(c, ast.ClassDef) for m in c.body if isinstance(m, ast.FunctionDef)]
    for node in [*public, *(m for m in methods if not m.name.startswith("_"))]:
        assert ast.get_docstring(node), f"{module}.{node.name}"


def test_importing_the_package_is_cheap():
    """No reader and none of the large libraries is imported before it is needed."""
    code = "import sys, fowtio.read; print(*[m for m in ('pandas', 'xarray', 'scipy', 'numpy', 'fowtio.read.openfast_lin') if m in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split() == []


def test_recognising_imports_no_slow_library(sample_files):
    code = (
        "import sys; from fowtio.read import recognise\n"
        f"recognise({str(sample_files['OPENFAST_LIN'])!r}); recognise({str(sample_files['ROTOR_TABLE'])!r})\n"
        "print(*[m for m in ('pandas', 'xarray') if m in sys.modules])"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split() == []


def test_readers_take_a_path_first():
    for own in fowtio.read.FORMATS:
        first = next(iter(inspect.signature(own.read).parameters))
        assert first in ("path", "stem"), own.name


@pytest.mark.reference
@pytest.mark.skipif("FOWTIO_FORMATS" not in os.environ, reason="FOWTIO_FORMATS names no folder of sample files")
def test_real_files_find_their_formats():
    folder = Path(os.environ["FOWTIO_FORMATS"])
    expected = {
        "openfast_lin/*.lin": "OPENFAST_LIN",
        "openfast_out/*.outb": "OPENFAST_OUT",
        "moordyn/*.dat": "MOORDYN",
        "rotor_tables/*.txt": "ROTOR_TABLE",
        "turbsim/*.bts": "TURBSIM",
        "wamit/*.1": "WAMIT_RADIATION",
        "wamit/*.3": "WAMIT_EXCITATION",
        "wamit/*.out": "WAMIT_OUTPUT",
        "aqwa/*.LIS": "AQWA_LIS",
        "capytaine/*.nc": "CAPYTAINE",
        "orcaflex/*.yml": "ORCAFLEX",
        "nemoh/*": "NEMOH",
    }
    known = constants()
    for pattern, name in expected.items():
        for path in folder.glob(pattern):
            assert recognise(path) is known[name], path
