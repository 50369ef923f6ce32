"""Times to read hydrodynamic coefficients: the committed OC4 set in every format that is written here, and files given.

    python benchmarks/bench_hydro_readers.py [path ...]

Prints a table: file, format, size, frequencies, best of several readings.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

from fowtio.errors import FowtioError
from fowtio.read.hydro_any import read_hydro
from fowtio.read.wamit import read_wamit
from fowtio.write.hydro import write_capytaine, write_wamit

OC4 = Path(__file__).parents[1] / "validation/oc4_deepcwind/input/hydro/oc4"


def best_time(path: Path, repeats: int) -> tuple[float, int]:
    """Return the shortest time [s] of several readings, and the number of frequencies."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        hydro = read_hydro(path)
        times.append(time.perf_counter() - start)
    return min(times), len(hydro.omega)


def size(path: Path) -> int:
    """Return the bytes of a file, of all files of a folder, or of a WAMIT set."""
    if path.is_file():
        return path.stat().st_size
    files = path.rglob("*") if path.is_dir() else path.parent.glob(path.name + ".*")
    return sum(f.stat().st_size for f in files if f.is_file())


def main() -> None:
    """Read what is asked for and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("paths", nargs="*", type=Path)
    parser.add_argument("--repeats", type=int, default=5)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        hydro = read_wamit(OC4, depth=200.0)
        write_wamit(hydro, Path(folder) / "oc4_all_elements")
        own = [OC4, Path(folder) / "oc4_all_elements", write_capytaine(hydro, Path(folder) / "oc4.nc")]
        print(f"{'file':<40} {'kB':>9} {'frequencies':>12} {'ms':>9} {'MB/s':>7}")
        for path in [*own, *arguments.paths]:
            try:
                seconds, count = best_time(path, arguments.repeats)
            except FowtioError as error:
                print(f"{path.name:<40} {error}")
                continue
            total = size(path)
            print(f"{path.name:<40} {total / 1e3:9.0f} {count:12d} {1e3 * seconds:9.2f} {total / 1e6 / seconds:7.1f}")


if __name__ == "__main__":
    main()
