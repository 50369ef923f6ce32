"""What holds the project together: directions of imports, documentation of what is public, nothing of anyone's machine."""

import ast
import os
import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
SOURCES = sorted((ROOT / "model").rglob("*.py")) + sorted((ROOT / "fowtio").rglob("*.py"))
SKIP = {"__pycache__", "build", "dist", "results", "node_modules"}


def name(path: Path) -> str:
    return str(path.relative_to(ROOT))


def imported(path: Path) -> set[str]:
    """The modules that a file imports, wherever in it."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found.add("." * node.level + (node.module or ""))
    return found


def public(path: Path):
    """Public functions and classes of a file, and the public methods of those classes."""
    for node in ast.parse(path.read_text()).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
            yield node.name, node
            if isinstance(node, ast.ClassDef):
                yield from (
                    (f"{node.name}.{f.name}", f)
                    for f in node.body
                    if isinstance(f, ast.FunctionDef) and not f.name.startswith("_")
                )


@pytest.mark.parametrize("path", [p for p in SOURCES if "model" in p.relative_to(ROOT).parts[:1]], ids=name)
def test_the_physics_knows_neither_files_nor_people(path):
    """model/ takes numpy and scipy, the standard library and itself; no files, printing or processes."""
    allowed = {"numpy", "scipy", "model", *sys.stdlib_module_names}
    found = {m.split(".")[0] for m in imported(path)}
    assert found <= allowed, f"imports {sorted(found - allowed)}"
    assert not found & {"os", "pathlib", "subprocess", "shutil", "logging", "json", "csv", "pickle", "tempfile", "io"}
    calls = {
        n.func.id
        for n in ast.walk(ast.parse(path.read_text()))
        if isinstance(n, ast.Call) and isinstance(n.func, ast.Name)
    }
    assert not calls & {"print", "open", "input", "exit"}


@pytest.mark.parametrize("path", sorted((ROOT / "fowtio" / "read").glob("*.py")), ids=name)
def test_readers_do_not_reach_up(path):
    """A reader takes data types of the model, other readers and the errors; no study, workflow or writer."""
    for module in imported(path):
        if module.startswith("fowtio."):
            assert module.startswith(("fowtio.read", "fowtio.errors")), module


@pytest.mark.parametrize("path", SOURCES, ids=name)
def test_what_is_public_is_documented(path):
    """Every module, public function, class and method says what it is, in sentences that end."""
    tree = ast.parse(path.read_text())
    assert ast.get_docstring(tree), "the module has no docstring"
    for label, node in public(path):
        text = ast.get_docstring(node)
        assert text, f"{label} has no docstring"
        first = text.split("\n\n")[0].strip()
        assert first.endswith((".", ":")), f"{label}: {first!r} is no sentence"


@pytest.mark.parametrize("path", SOURCES, ids=name)
def test_no_traps_in_the_source(path):
    """No bare except, no mutable default, no leftover of debugging."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ExceptHandler):
            assert node.type is not None, f"line {node.lineno}: bare except"
        if isinstance(node, ast.FunctionDef):
            defaults = [*node.args.defaults, *node.args.kw_defaults]
            assert not any(isinstance(d, ast.List | ast.Dict | ast.Set) for d in defaults), (
                f"{node.name}: mutable default"
            )
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            assert node.func.id != "breakpoint", f"line {node.lineno}"


def test_data_between_rooms_is_frozen():
    """Dataclasses of the physics cannot be changed after they are made."""
    for path in SOURCES:
        if not name(path).startswith("model"):
            continue
        for node in ast.parse(path.read_text()).body:
            for decorator in node.decorator_list if isinstance(node, ast.ClassDef) else ():
                if ast.unparse(decorator).startswith("dataclass"):
                    assert "frozen=True" in ast.unparse(decorator), f"{name(path)}: {node.name}"


def texts():
    """Every text of the project, hidden folders and build products aside."""
    for folder, folders, files in os.walk(ROOT):
        folders[:] = [
            d
            for d in folders
            if d not in SKIP and not d.endswith(".egg-info") and (not d.startswith(".") or d == ".ci")
        ]
        for file in files:
            path = Path(folder) / file
            if file == ".git":  # a working tree beside its repository
                continue
            if (
                path.suffix
                in (".py", ".md", ".toml", ".fowt", ".dat", ".fst", ".j2", ".css", ".js", ".txt", ".yml", ".lin")
                or not path.suffix
            ):
                yield path


def test_no_file_names_a_place_on_someones_machine():
    """Paths of home folders, temporary folders and mounted drives belong to no one else."""
    roots = ("home", "Users", "root", "tmp", "work", "mnt", "scratch", "opt")
    pattern = re.compile(r"(?<![\w.:/\-)\]}])/(?:" + "|".join(roots) + r")/[\w.~-]+|[A-Za-z]:\\Users\\")
    found = []
    for path in texts():
        text = path.read_text(errors="replace")
        found += [f"{name(path)}: {match.group(0)}" for match in pattern.finditer(text)]
    assert not found


def test_the_package_imports_quickly_and_names_what_is_public():
    """import fowtio brings in no numerical library; every public name can be had."""
    import subprocess

    code = "import sys, fowtio; print(sorted({'numpy', 'scipy', 'pandas', 'matplotlib', 'xarray'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT)
    assert done.stdout.strip() == "[]", done.stderr
    import fowtio

    for public_name in fowtio.__all__:
        assert getattr(fowtio, public_name) is not None
    with pytest.raises(AttributeError, match="no attribute 'frobnicate'"):
        _ = fowtio.frobnicate


def test_a_foreign_module_named_model_is_reported(tmp_path):
    """A file model.py in the working folder would hide the physics; the message says so."""
    import subprocess

    (tmp_path / "model.py").write_text("")
    done = subprocess.run([sys.executable, "-c", "import fowtio"], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode != 0
    assert "foreign module named 'model'" in done.stderr
