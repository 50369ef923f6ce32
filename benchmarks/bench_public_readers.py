"""Times to read the same files with fowtio and with public readers that are installed in another environment.

    python -m venv other && other/bin/pip install openfast_io capytaine "mafredo<2026"
    python benchmarks/bench_public_readers.py --python other/bin/python

Prints a table: file, size, best of several readings by fowtio and by each other reader ("-": it cannot be imported or does
not read the file). Each reads into its own data: fowtio also checks and converts to one convention. None of the other packages
is needed by fowtio, nor part of it.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
import time
from pathlib import Path

from bench_readers import OC4, best_time, generated

from fowtio.read.hydro_any import read_hydro
from fowtio.write.hydro import write_capytaine

OTHERS = {  # suffix: (package, statements that define read(path))
    ".lin": ("openfast_io", "from openfast_io.FAST_linearization_reader import FASTLinearizationFile as read"),
    ".outb": ("openfast_io", "from openfast_io.FAST_output_reader import load_binary_output as read"),
    ".bts": ("openfast_io", "from openfast_io.turbsim_file import TurbSimFile as read"),
    ".nc": (
        "capytaine",
        "import xarray; from capytaine.io.xarray import merge_complex_values as merge\n"
        "def read(path): return merge(xarray.load_dataset(path))",
    ),
    ".nc ": ("mafredo", "from mafredo import Hyddb1\nread = Hyddb1.create_from_capytaine"),
}
_TIMING = """
import sys, time, json, io, contextlib
{define}
best = None
with contextlib.redirect_stdout(io.StringIO()):
    for _ in range({repeats}):
        start = time.perf_counter()
        read({path!r})
        took = time.perf_counter() - start
        best = took if best is None else min(best, took)
print(json.dumps(best))
"""


def other_time(python: Path, define: str, path: Path, repeats: int) -> float | None:
    """Return the shortest time [s] of several readings by another package, None when it cannot."""
    code = _TIMING.format(define=define, repeats=repeats, path=str(path))
    done = subprocess.run([str(python), "-c", code], capture_output=True, text=True)
    return json.loads(done.stdout.splitlines()[-1]) if done.returncode == 0 else None


def small_lin(folder: Path) -> Path:
    """Return a linearisation of about 300 kB: the first rows and columns of a large one would be no file, so a generated one."""
    import sys

    sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "read"))
    import numpy as np
    import openfast_samples as samples

    rng = np.random.default_rng(1)
    count = 60
    states = [
        (f"{'First time derivative of ' if k >= count // 2 else ''}state {k % (count // 2)}, m", 0.0, False, 2)
        for k in range(count)
    ]
    inputs = [(f"input {k}, N", 0.0, False) for k in range(200)]
    path = folder / "medium.lin"
    big = {"A": rng.normal(size=(count, count)), "B": rng.normal(size=(count, 200))}
    path.write_text(samples.lin_text(big, states, inputs, []))
    return path


def own_time(path: Path, repeats: int) -> float:
    """Return the shortest time [s] of several readings by fowtio, recognition included."""
    if path.suffix != ".nc":
        return best_time(path, repeats)[1]
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        read_hydro(path)
        times.append(time.perf_counter() - start)
    return min(times)


def main() -> None:
    """Read the embedded and generated files with fowtio and the others, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--python", type=Path, required=True, help="interpreter that has the other packages")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("paths", nargs="*", type=Path)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        hydro = read_hydro(OC4 / "input" / "hydro" / "oc4", depth=200.0)
        files = [
            OC4 / "linearisation" / "turbine" / "U14" / "m.1.lin", small_lin(folder), *generated(folder)[:3],
            OC4 / "reference" / "wn7_s1.outb", write_capytaine(hydro, folder / "oc4.nc"), *arguments.paths,
        ]  # fmt: skip
        print(f"{'file':<28} {'kB':>8} {'fowtio ms':>10}   others, ms")
        for path in files:
            own = own_time(path, arguments.repeats)
            found = []
            for suffix, (package, define) in OTHERS.items():
                if suffix.strip() == path.suffix:
                    took = other_time(arguments.python, define, path, arguments.repeats)
                    found.append(f"{package} {'-' if took is None else f'{1e3 * took:.1f}'}")
            print(f"{path.name:<28} {path.stat().st_size / 1e3:8.0f} {1e3 * own:10.1f}   {', '.join(found)}")


if __name__ == "__main__":
    main()
