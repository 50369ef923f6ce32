"""The main job's speed on this machine: one evaluation, the whole run without figures, the help text."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

from fowtio.bench import time_case
from fowtio.start import embedded_folder

STUDY = embedded_folder() / "oc4.fowt"


def _wall(*arguments: str) -> float:
    start = time.perf_counter()
    subprocess.run([sys.executable, "-m", "fowtio", *arguments], check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - start


def main() -> None:
    """Print the timings."""
    print(f"{'':44}{'measured':>12}{'wanted':>12}")
    for name, seconds in time_case(STUDY):
        wanted = "10 ms" if name == "one evaluation in all" else ""
        print(f"{name:44}{seconds * 1e3:9.2f} ms{wanted:>12}")
    with tempfile.TemporaryDirectory() as folder:
        runs = [_wall("run", str(STUDY), "-o", str(Path(folder) / str(k)), "--no-figures", "--quiet") for k in range(3)]
        full = _wall("run", str(STUDY), "-o", str(Path(folder) / "full"), "--quiet")
    print(f"{'fowtio run without figures (warm)':44}{min(runs):9.2f} s {'3 s':>12}")
    print(f"{'fowtio run with figures and report':44}{full:9.2f} s ")
    print(f"{'fowtio --help':44}{min(_wall('--help') for _ in range(3)):9.2f} s {'0.5 s':>12}")


if __name__ == "__main__":
    main()
