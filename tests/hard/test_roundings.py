"""Surveys of hard cases once more, with models that round otherwise: a figure told is a figure everywhere.

Models are compiled for other processors, or by another compiler, or run on a C library without the machine's newer
instructions. Each goes in a process of its own, since the libraries choose their functions when they are loaded.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from ..support.folders import ROOT

SURVEYS = ("test_change_points.py", "test_wedge.py", "test_stronge.py")
"""Of this folder; those that are there. Loops that collapse are chaotic, and not among them."""
PLAIN = "gcc"
COMPILED = {
    "for x86-64-v2": (PLAIN, ("-march=x86-64-v2",)),
    "for x86-64-v3": (PLAIN, ("-march=x86-64-v3",)),
    "with products and sums in one operation": (PLAIN, ("-march=x86-64-v3", "-ffp-contract=fast")),
    "by clang": ("clang", ()),
}
HWCAPS = "glibc.cpu.hwcaps=-AVX512F,-AVX2,-FMA,-AVX2_Usable,-FMA_Usable"
"""Names of the features in new versions of the GNU C library, and in old ones."""

ASKED = pytest.mark.skipif("CCGEN_ROUNDINGS" not in os.environ, reason="runs surveys again; make figures asks for it")


def survey(folder: Path, environment: dict[str, str]) -> str:
    """The surveys in a process of their own, with a cache of their own; what they say, if any fails."""
    there = [str(ROOT / "tests" / "hard" / name) for name in SURVEYS if (ROOT / "tests" / "hard" / name).exists()]
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("CCGEN_", "PYTEST_"))}
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *there],
        cwd=ROOT,
        env=kept | {"CCGEN_TEST_CACHE_DIR": str(folder / "cache")} | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    return "" if done.returncode == 0 else done.stdout + done.stderr


def compiler(folder: Path, name: str, flags: tuple[str, ...]) -> str:
    """A command that calls the compiler with these flags after all others, so that they count."""
    command = folder / "compiler"
    command.write_text(f'#!/bin/sh\nexec {name} "$@" {" ".join(flags)}\n', encoding="utf-8")
    command.chmod(0o755)
    return str(command)


def makes_programs(command: str, folder: Path) -> bool:
    """Whether what the command compiles runs on this machine; a processor may lack what the flags ask for."""
    source = folder / "answer.c"
    source.write_text("int main(void) { volatile double x = 2.0; return x * x + 1.0 != 5.0; }\n", encoding="utf-8")
    done = subprocess.run([command, str(source), "-o", str(folder / "answer")], capture_output=True, check=False)
    return done.returncode == 0 and subprocess.run([str(folder / "answer")], check=False).returncode == 0


@pytest.mark.hard
@ASKED
@pytest.mark.parametrize("how", COMPILED)
def test_surveys_hold_with_models_compiled_otherwise(how: str, tmp_path: Path) -> None:
    name, flags = COMPILED[how]
    if not shutil.which(name):
        pytest.skip(f"{name} is not installed")
    command = compiler(tmp_path, name, flags)
    if not makes_programs(command, tmp_path):
        pytest.skip(f"this machine does not run what {name} {' '.join(flags)} compiles")
    said = survey(tmp_path, {"CC": command})
    assert not said, said


@pytest.mark.hard
@ASKED
def test_surveys_hold_with_a_library_without_newer_instructions(tmp_path: Path) -> None:
    if sys.platform != "linux" or os.confstr("CS_GNU_LIBC_VERSION") is None:
        pytest.skip("not the GNU C library")
    said = survey(tmp_path, {"GLIBC_TUNABLES": HWCAPS})
    assert not said, said
