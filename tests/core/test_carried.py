"""Differences through a step in vectors of every length (tests/c/carried.c): all processors find the same numbers."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from ..support.folders import ROOT
from ..support.tiers import hard

CORE = ROOT / "runtime" / "core"
SANITIZERS = "-O1 -fsanitize=address,undefined -fno-sanitize-recover=all"
"""Of -O1 as in ``make sanitize``: with -O2, as the others are, the compiler takes more than twice as long."""
NO_LONGER_THAN = {"avx2": "(name[3]=='2')", "the usual": "0"}
"""What a processor is said to have: the character tells avx2 from avx512f."""


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., list[str]]:
    """The numbers of a program compiled with given flags."""
    folder = tmp_path_factory.mktemp("carried")
    return cache(lambda *flags: numbers(folder, *flags))


def numbers(folder: Path, *flags: str) -> list[str]:
    """Skipped where the compiler takes the flags not."""
    if os.name != "posix" or not shutil.which("cc"):
        pytest.skip("needs cc")
    program = str(folder / "carried")
    sources = [str(ROOT / "tests" / "c" / "carried.c"), str(CORE / "motion" / "carried.c")]
    sources.append(str(CORE / "base" / "tolerances.c"))
    command = ["cc", "-O2", "-std=c11", "-Wall", *flags, f"-I{CORE}", *sources, "-lm", "-o", program]
    made = subprocess.run(command, check=False)
    if made.returncode and "-fsanitize" in " ".join(flags):
        pytest.skip("the compiler has no sanitizers")
    assert made.returncode == 0
    done = subprocess.run([program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-200:] + done.stderr
    return done.stdout.split()


@pytest.mark.parametrize("longest", NO_LONGER_THAN)
def test_vectors_of_any_length_find_the_same_numbers(longest: str, told: Callable[..., list[str]]) -> None:
    processor = Path("/proc/cpuinfo")
    if longest == "avx2" and not (processor.exists() and "avx2" in processor.read_text()):
        pytest.skip("this processor has no such vectors")
    shorter = f"-D__builtin_cpu_supports(name)={NO_LONGER_THAN[longest]}"
    assert told(shorter) == told()


@pytest.mark.parametrize("precision", [hard(0), 1, 2])
def test_so_do_other_precisions_but_for_rounding(precision: int, told: Callable[..., list[str]]) -> None:
    """With the sanitizers, where the compiler has them."""
    found, wanted = (
        np.array([float.fromhex(one) for one in told(*flags)])
        for flags in ([f"-DCCGEN_PRECISION={precision}", *SANITIZERS.split()], [])
    )
    assert np.abs(found - wanted).max() < (1e-5 if precision == 1 else 1e-14) * np.abs(wanted).max()
