"""Step cost of the FMU on one core: how many times faster than real time the embedded OC4 case runs at a step of 0.1 s.

    python benchmarks/bench_fmu.py [STUDY]

The FMU is called as a co-simulation master in C would call it: per step one set of its inputs, one step, one get of all outputs.
A loop in C is compiled for that, so that the interpreter does not count; the same through FMPy is given beside it.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path

import numpy as np

import fowtio
from fowtio.fmu.build import export_fmu
from fowtio.fmu.runner import Runner

STEPS, STEP = 200_000, 0.1
LOOP = """
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
typedef void *component;
typedef struct { void *l, *a, *f, *s, *e; } callbacks;
component fmi2Instantiate(const char *, int, const char *, const char *, const callbacks *, int, int);
int fmi2SetupExperiment(component, int, double, double, int, double), fmi2EnterInitializationMode(component), fmi2ExitInitializationMode(component);
int fmi2GetReal(component, const unsigned *, size_t, double *), fmi2SetReal(component, const unsigned *, size_t, const double *);
int fmi2DoStep(component, double, double, int);
int main(void)
{
    static const unsigned in[] = {%(inputs)s}, parameter[] = {%(parameters)s}, out[] = {%(outputs)s};
    static const double value[] = {%(values)s};
    enum { NIN = sizeof in / sizeof *in, NOUT = sizeof out / sizeof *out };
    callbacks none = {0};
    component c = fmi2Instantiate("bench", 1, "%(token)s", "", &none, 0, 0);
    double u[NIN], y[NOUT], sum = 0;
    struct timespec a, b;
    fmi2SetupExperiment(c, 0, 0, 0, 0, 0);
    if (fmi2SetReal(c, parameter, %(count)d, value)) return 1;
    fmi2EnterInitializationMode(c);
    fmi2ExitInitializationMode(c);
    for (int k = 0; k < NIN; k++) u[k] = 0;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &a);
    for (long n = 0; n < %(steps)d; n++) {
        u[0] = (n %% 100) * 0.01;
        if (NIN && fmi2SetReal(c, in, %(driven)d, u)) return 1;
        if (fmi2DoStep(c, n * %(step)g, %(step)g, 1)) return 1;
        if (fmi2GetReal(c, out, NOUT, y)) return 1;
        sum += y[0];
    }
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &b);
    printf("%%.9g %%g\\n", (b.tv_sec - a.tv_sec + 1e-9 * (b.tv_nsec - a.tv_nsec)) / %(steps)d, sum);
    return 0;
}
"""


def seconds_per_step(exported, driven: list[str], start: dict[str, float]) -> float:
    """Return the processor time of one step in C, inputs set and outputs got; the best of three runs."""
    d = exported.description
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        with zipfile.ZipFile(exported.files["2.0"]) as archive:
            archive.extractall(folder)
        values = {
            "inputs": ", ".join(f"{d.reference(n)}u" for n in driven) or "0u", "driven": len(driven), "token": d.token, "steps": STEPS, "step": STEP,
            "outputs": ", ".join(f"{d.reference(v.name)}u" for v in d.of_kind("output")),
            "parameters": ", ".join(f"{d.reference(n)}u" for n in start) or "0u", "values": ", ".join(map(str, start.values())) or "0", "count": len(start),
        }  # fmt: skip
        (folder / "loop.c").write_text(LOOP % values)
        library = next((folder / "binaries" / "linux64").glob("*.so"))
        subprocess.run(
            ["gcc", "-O2", "-o", "loop", "loop.c", str(library), f"-Wl,-rpath,{library.parent}"], cwd=folder, check=True
        )
        return min(
            float(subprocess.run([folder / "loop"], check=True, capture_output=True, text=True).stdout.split()[0])
            for _ in range(3)
        )


def main() -> None:
    study = (
        sys.argv[1]
        if len(sys.argv) > 1
        else Path(__file__).resolve().parent.parent / "validation" / "oc4_deepcwind" / "oc4.fowt"
    )
    with tempfile.TemporaryDirectory() as scratch:
        began = time.perf_counter()
        model = fowtio.build(fowtio.load(study))
        exported = export_fmu(model, Path(scratch) / "bench.fmu")
        print(
            f"export {time.perf_counter() - began:.1f} s, {exported.linearised.space.order} states, {exported.files['2.0'].stat().st_size / 1e3:.0f} kB"
        )
        forces = [f"Wave.{n}" for n in ("ForceX", "ForceY", "ForceZ", "MomentX", "MomentY", "MomentZ")]
        for label, driven, start in (
            ("wave elevation", ["Wave.Elevation"], {}), ("six wave forces", forces, {}), ("internal sea", [], {"Sea.Hs": 3.0}),
        ):  # fmt: skip
            cost = seconds_per_step(exported, driven, start)
            print(f"{label:16s} {cost * 1e6:6.2f} us a step of {STEP} s: {STEP / cost:10,.0f} times real time")
        with Runner(exported.files["2.0"]) as runner:
            wave = np.sin(0.1 * np.arange(20001))
            began = time.perf_counter()
            runner.run(20000, STEP, {"Wave.Elevation": wave}, ["Platform.Surge"])
            print(f"through FMPy     {(time.perf_counter() - began) / 20000 * 1e6:6.2f} us a step")


if __name__ == "__main__":
    main()
