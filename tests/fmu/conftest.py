"""FMUs that several tests use: a mass on a spring with closed-form answers, and the embedded OC4 case."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from fmu_samples import make, oscillator

import fowtio
from fowtio.fmu.build import compile_library, write_fmu
from fowtio.fmu.sources import write_sources

pytest.importorskip("fmpy")
if shutil.which("gcc") is None:
    pytest.skip("no C compiler is installed", allow_module_level=True)


@pytest.fixture(scope="session")
def spring(tmp_path_factory) -> dict[str, Path]:
    """FMUs of the oscillator by FMI version."""
    folder = tmp_path_factory.mktemp("spring")
    description = make(oscillator(), "Spring")
    return {v: write_fmu(description, folder / f"spring{v[0]}.fmu", version=v) for v in ("2.0", "3.0")}


@pytest.fixture(scope="session")
def spring_library(tmp_path_factory):
    """Return a maker of the oscillator's sources and library with compiler flags of one's own."""

    def build(version: str, *flags: str):
        folder = tmp_path_factory.mktemp("library") / "fmu"
        write_sources(make(oscillator(), "Spring"), version, folder)
        library = folder / "spring.so"
        compile_library(folder / "sources", library, "gcc", flags=("-std=c99", "-Wall", "-Wextra", "-Werror", *flags))
        return folder / "sources", library

    return build


@pytest.fixture(scope="session")
def parked(oc4, tmp_path_factory):
    """The embedded case, parked in its white-noise sea, as FMUs of both versions with all inputs."""
    return fowtio.export_fmu(oc4, tmp_path_factory.mktemp("oc4") / "oc4.fmu", state="white_noise", versions=("2.0", "3.0"))
