"""Times to read decks, linearisations, time series and the rest: the embedded case, generated files, and files given.

    python benchmarks/bench_readers.py [path ...]

Prints a table: file, format, size, best of several readings; for metocean records and others see the format's name.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from fowtio.errors import FowtioError
from fowtio.read import recognise

ROOT = Path(__file__).parents[1]
OC4 = ROOT / "validation" / "oc4_deepcwind"


def best_time(path: Path, repeats: int) -> tuple[str, float]:
    """Return the name of a file's format and the shortest time [s] of several readings, recognition included."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        own = recognise(path)
        own.read(path)
        times.append(time.perf_counter() - start)
    return own.name, min(times)


def generated(folder: Path) -> list[Path]:
    """Write large files: a linearisation of 5 MB, a binary time series of an hour, a wind field, ten years of hours."""
    sys.path.insert(0, str(ROOT / "tests" / "read"))
    import openfast_samples as samples

    rng = np.random.default_rng(0)
    states = [
        (f"{'First time derivative of ' if k >= 200 else ''}state {k % 200}, m", 0.0, False, 2) for k in range(400)
    ]
    inputs = [(f"input {k}, N", 0.0, False) for k in range(370)]
    big = {"A": rng.normal(size=(400, 400)), "B": rng.normal(size=(400, 370))}
    lin = folder / "large.lin"
    lin.write_text(samples.lin_text(big, states, inputs, []))
    names = [f"Channel{k}" for k in range(100)]
    outb, bts, csv = folder / "hour.outb", folder / "field.bts", folder / "ten_years.csv"
    outb.write_bytes(samples.outb_bytes(np.arange(36000) * 0.1, rng.normal(size=(36000, 100)), names, ["m"] * 100, 2))
    bts.write_bytes(samples.bts_bytes(rng.normal(12, 1, size=(6000, 21, 21, 3)).astype(np.float32)))
    hours = np.datetime64("2010-01-01T00") + np.arange(87648)
    rows = zip(np.datetime_as_string(hours, unit="m"), *rng.uniform(1, 9, size=(3, len(hours))), strict=True)
    csv.write_text(
        "time,wind speed (m/s),Hs (m),Tp (s)\n" + "\n".join(f"{t},{a:.2f},{b:.2f},{c:.2f}" for t, a, b, c in rows)
    )
    return [lin, outb, bts, csv]


def main() -> None:
    """Read what is asked for and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("paths", nargs="*", type=Path)
    parser.add_argument("--repeats", type=int, default=5)
    arguments = parser.parse_args()
    own = [
        OC4 / "input" / "oc4.fst",
        OC4 / "linearisation" / "parked" / "main.1.lin",
        OC4 / "linearisation" / "turbine" / "U14" / "m.1.lin",
    ]
    with tempfile.TemporaryDirectory() as folder:
        print(f"{'file':<32} {'format':<48} {'kB':>9} {'ms':>9} {'MB/s':>7}")
        for path in [*own, *generated(Path(folder)), *arguments.paths]:
            try:
                name, seconds = best_time(path, arguments.repeats)
            except FowtioError as error:
                print(f"{path.name:<32} {error}")
                continue
            size = path.stat().st_size
            print(f"{path.name:<32} {name:<48} {size / 1e3:9.0f} {1e3 * seconds:9.2f} {size / 1e6 / seconds:7.1f}")


if __name__ == "__main__":
    main()
