"""The registry: every reader is in it, every file finds its own format and no other, and importing it costs little."""

import ast
import inspect
import os
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
from every_format import every_format

import fowtio.read
from fowtio.errors import FormatError
from fowtio.read import describe, read_any, recognise, registry
from fowtio.read import inspect as inspect_file
from fowtio.read.registry import INTERNAL, Format

FOLDER = Path(fowtio.read.__file__).parent
MODULES = sorted(p.stem for p in FOLDER.glob("*.py") if p.stem != "__init__")


@pytest.fixture(scope="module")
def sample_files(tmp_path_factory):
    return every_format(tmp_path_factory.mktemp("formats"))


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


def test_every_format_has_a_sample(sample_files):
    assert {name.split()[0] for name in sample_files} == set(constants())


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
    """All but the general ones, tried last (any OpenFAST-style input file, any netCDF), tell their own files only."""
    known = constants()
    for name, path in sample_files.items():
        head = path.read_bytes()[:65536] if path.is_file() else b""
        general = {"OPENFAST_INPUT"} | ({"METOCEAN"} if path.suffix == ".nc" else set())
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


# --- what no format recognises ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.lin", "hello\n", ("a.lin, line 1", "'Linearized model", "because of its suffix")),
        ("a.1", "x\n", ("because of its suffix",)),
        ("a.outb", "Time is up\n", ("because of its suffix",)),
        ("a.csv", "hello\nworld\n", ("line 1", "headings", "because of its suffix")),
        ("a.qtf", "AQTF-2.0 :\n", ("'AQTF-2.0 :'", "not read")),
        ("a.xyz", "hello world\n", ("'hello world'", "Tried by content", "WAMIT", "MoorDyn", "Metocean")),
        ("a.xyz", "", ("an empty file",)),
    ],
)
def test_errors_say_what_was_tried(tmp_path, name, content, words):
    path = tmp_path / name
    path.write_text(content)
    with pytest.raises(FormatError) as error:
        read_any(path)
    for word in words:
        assert word in str(error.value), str(error.value)


def test_every_bad_line_is_named(tmp_path):
    rows = [" 5.0 1 1 1.0 1.0", " 5.0 1 2 ***** 1.0", " 5.0 1 3 1.0 1.0", " 5.0 2 2 NaN 1.0", " 5.0 2 3 x 1.0"]
    path = tmp_path / "a.1"
    path.write_text("\n".join(rows) + "\n")
    with pytest.raises(FormatError, match=r"line 2: .*2 more such lines: 4, 5") as error:
        read_any(path)
    assert error.value.line == 2


def test_every_body_is_inspected(tmp_path):
    path = tmp_path / "two.1"
    rows = [
        f" {t} {i + 6 * b} {j + 6 * b} {1.0 * (i == j)} 0.1"
        for t in (5.0, 9.0)
        for b in (0, 1)
        for i in range(1, 7)
        for j in range(1, 7)
    ]
    path.write_text("\n".join(rows) + "\n")
    found = inspect_file(path)
    labels = [label for label, _ in found.rows]
    assert labels[0] == "bodies"
    assert "body 1: periods" in labels
    assert "body 2: periods" in labels


def test_every_format_is_in_the_page_of_formats():
    """By the first word of its name and every suffix in it."""
    page = (FOLDER.parents[1] / "docs" / "formats.md").read_text(encoding="utf-8").lower()
    for own in fowtio.read.FORMATS:
        for word in [own.name.split()[0], *re.findall(r"(?<!\w)\.\w+", own.name)]:
            assert word.lower() in page, (own.name, word)
