"""The validation's speed and memory on this machine: six records of 8000 s read, processed and reported; and the whole embedded study."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from fowtio.start import embedded_folder

SIX_RECORDS, WHOLE = "oc4_rigid_tower.fowt", "oc4.fowt"


def measure(study: Path, *options: str) -> tuple[float, float, float]:
    """Return wall time [s], processor time [s] and peak memory [GB] of one validation with its report."""
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        command = [
            sys.executable,
            "-m",
            "fowtio",
            "validate",
            str(study),
            "-o",
            str(Path(folder) / "out"),
            "--quiet",
            *options,
        ]
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.perf_counter() - start
        if os.waitstatus_to_exitcode(status):
            raise SystemExit(f"{study.name}: exit status {os.waitstatus_to_exitcode(status)}")
    return wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1e6


def main() -> None:
    """Print the timings."""
    print(f"{'':52}{'wall':>9}{'processor':>11}{'memory':>10}   wanted")
    for name, study, options, wanted in (
        ("6 records of 8000 s, quadratic drag, report", SIX_RECORDS, (), "20 s, 1 GB"),
        ("the same without quadratic drag", SIX_RECORDS, ("--no-quadratic",), ""),
        ("whole embedded study (16 records), report", WHOLE, (), ""),
    ):
        wall, processor, memory = measure(embedded_folder() / study, *options)
        print(f"{name:52}{wall:7.1f} s{processor:9.1f} s{memory:7.2f} GB   {wanted}")


if __name__ == "__main__":
    main()
