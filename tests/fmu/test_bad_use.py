"""Bad use: FMI-conformant errors, never a crash, under sanitizers and valgrind; and the FMI 3 functions through ctypes."""

import ctypes
import math
import os
import shutil
import subprocess
from pathlib import Path

import pytest
from fmu_samples import make, oscillator

from fowtio.fmu.build import compile_library, find_compiler
from fowtio.fmu.sources import write_sources

DRIVER = Path(__file__).with_name("driver.c")
SANITIZERS = ("-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")


def _names() -> list[str]:
    """Return the compiler's definitions of token and value references that the driver needs."""
    d = make(oscillator(), "Spring")
    return [f'-DTOKEN="{d.token}"', f"-DFORCE={d.reference('Force')}u", f"-DPOSITION={d.reference('Position')}u"]


def _driver(sources: Path, *flags: str) -> Path:
    program = sources / "driver"
    command = [
        "gcc",
        "-std=c99",
        "-Wall",
        "-Wextra",
        *flags,
        *_names(),
        "-o",
        str(program),
        str(DRIVER),
        str(sources / "fmi2.c"),
        "-lm",
    ]
    subprocess.run(command, check=True, capture_output=True, cwd=sources)
    return program


def test_bad_use_under_the_sanitizers(spring_library):
    sources, _ = spring_library("2.0", "-O0")
    program = _driver(sources, *SANITIZERS)
    done = subprocess.run(
        [program],
        capture_output=True,
        text=True,
        env={"ASAN_OPTIONS": "detect_leaks=1", "UBSAN_OPTIONS": "print_stacktrace=1"},
    )
    if "LeakSanitizer has encountered a fatal error" in done.stderr:  # where processes may not be traced
        done = subprocess.run([program], capture_output=True, text=True, env={"ASAN_OPTIONS": "detect_leaks=0"})
    assert done.returncode == 0, done.stdout + done.stderr
    assert "refusals told" in done.stdout


@pytest.mark.skipif(shutil.which("valgrind") is None, reason="valgrind is not installed")
def test_bad_use_under_valgrind(spring_library):
    sources, _ = spring_library("2.0", "-O0")
    program = _driver(sources, "-g", "-O1")
    done = subprocess.run(
        ["valgrind", "--quiet", "--error-exitcode=9", "--leak-check=full", "--errors-for-leak-kinds=definite", program],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("wine") is None or shutil.which("x86_64-w64-mingw32-gcc") is None, reason="no wine, or no cross-compiler")
def test_bad_use_of_the_library_for_windows(tmp_path):
    """The driver against the DLL, as Windows loads it."""
    write_sources(make(oscillator(), "Spring"), "2.0", tmp_path / "fmu")
    library, program = tmp_path / "Spring.dll", tmp_path / "driver.exe"
    compile_library(tmp_path / "fmu" / "sources", library, find_compiler("win64"), "win64")
    command = ["x86_64-w64-mingw32-gcc", "-std=c99", *_names(), "-o", str(program), str(DRIVER), str(library)]
    subprocess.run(command, check=True, capture_output=True)
    own = os.environ | {"WINEPREFIX": str(tmp_path / "prefix"), "WINEDEBUG": "-all"}
    done = subprocess.run(["wine", str(program)], capture_output=True, text=True, cwd=tmp_path, env=own)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "refusals told" in done.stdout


def test_warnings_are_errors_at_every_optimisation(spring_library):
    for version in ("2.0", "3.0"):
        for level in ("-O0", "-O2", "-O3"):
            spring_library(
                version,
                level,
                "-Wpedantic",
                "-Wshadow",
                "-Wconversion",
                "-Wno-sign-conversion",
                "-Wno-float-conversion",
            )


@pytest.fixture
def three(spring_library):
    """The FMI 3 library of the oscillator through ctypes, and a maker of instances."""
    library = ctypes.CDLL(str(spring_library("3.0", "-O1", "-fPIC", "-shared")[1]))
    library.fmi3InstantiateCoSimulation.restype = ctypes.c_void_p
    d = make(oscillator(), "Spring")

    def instance(token=d.token, event_mode=False):
        make_one = library.fmi3InstantiateCoSimulation
        return make_one(
            b"one",
            token.encode(),
            None,
            False,
            False,
            ctypes.c_bool(event_mode),
            False,
            None,
            ctypes.c_size_t(0),
            None,
            None,
            None,
        )

    def call(name, c, *arguments):
        return getattr(library, name)(ctypes.c_void_p(c), *arguments)

    return instance, call, d


ERROR = 3


def test_fmi3_refuses_what_it_should(three):
    instance, call, d = three
    assert instance(token="another model") is None
    assert instance(event_mode=True) is None
    c = instance()
    force = (ctypes.c_uint32 * 1)(d.reference("Force"))
    value = (ctypes.c_double * 1)(1.0)
    one = ctypes.c_size_t(1)
    step = [ctypes.c_bool() for _ in range(3)]
    last = ctypes.c_double()

    def advance(t, h):
        return call(
            "fmi3DoStep",
            c,
            ctypes.c_double(t),
            ctypes.c_double(h),
            True,
            *(ctypes.byref(s) for s in step),
            ctypes.byref(last),
        )

    assert advance(0.0, 0.1) == ERROR  # before initialisation
    start = (ctypes.c_bool(False), ctypes.c_double(0), ctypes.c_double(0), ctypes.c_bool(True), ctypes.c_double(1.0))
    assert call("fmi3EnterInitializationMode", c, *start) == 0
    assert call("fmi3EnterInitializationMode", c, *start) == ERROR
    assert call("fmi3ExitInitializationMode", c) == 0
    for bad in (math.nan, math.inf):
        assert call("fmi3SetFloat64", c, force, one, (ctypes.c_double * 1)(bad), one) == ERROR
    assert call("fmi3SetFloat64", c, (ctypes.c_uint32 * 1)(999999), one, value, one) == ERROR
    assert call("fmi3SetFloat64", c, force, one, value, ctypes.c_size_t(2)) == ERROR
    for name in ("fmi3GetFloat32", "fmi3GetInt8", "fmi3GetUInt64", "fmi3GetBoolean", "fmi3GetString"):
        assert call(name, c, force, one, value, one) == ERROR
    for h in (0.0, -1.0, math.nan, 5.0):  # the last beyond the stop time
        assert advance(0.0, h) == ERROR
    assert advance(0.0, 0.5) == 0
    assert last.value == 0.5
    for name in ("fmi3EnterConfigurationMode", "fmi3EnterStepMode", "fmi3EnterContinuousTimeMode"):
        assert call(name, c) == ERROR
    assert call("fmi3Terminate", c) == 0
    assert advance(0.5, 0.1) == ERROR
    for _ in range(3):
        call("fmi3FreeInstance", c)
    assert advance(0.0, 0.1) == ERROR
    assert call("fmi3Reset", None) == ERROR
