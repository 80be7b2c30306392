"""The arena by itself (tests/c/arena.c), in every precision, with the sanitizers where the compiler has them."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from ..support.folders import ROOT

CORE = ROOT / "runtime" / "core"
SANITIZERS = "-fsanitize=address,undefined -fno-sanitize-recover=all"


@pytest.mark.sample(2)
@pytest.mark.parametrize("flags", ["", SANITIZERS])
@pytest.mark.parametrize("precision", [0, 1, 2])
def test_arrays_are_taken_and_given_back(precision: int, flags: str, tmp_path: Path) -> None:
    if os.name != "posix" or not shutil.which("cc"):
        pytest.skip("needs cc")
    sources = [str(ROOT / "tests" / "c" / "arena.c"), str(CORE / "base" / "arena.c")]
    options = [f"-DCCGEN_PRECISION={precision}", f"-I{CORE}", "-o", str(tmp_path / "arena")]
    made = subprocess.run(["cc", "-O1", "-g", "-std=c11", "-Wall", *flags.split(), *sources, *options], check=False)
    if made.returncode and flags:
        pytest.skip("the compiler has no sanitizers")
    assert made.returncode == 0
    done = subprocess.run([tmp_path / "arena"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
