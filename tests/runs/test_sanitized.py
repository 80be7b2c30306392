"""Tosses from C under the address and the undefined-behaviour sanitizer, leaks included; ``make sanitize`` has more."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from ccgen.generator import generate, load_scene, loop
from ccgen.runtime import load_model

from ..hard.fuzz import scene
from ..support.folders import ROOT

pytestmark = pytest.mark.hard

CORE = ROOT / "runtime" / "core"
SANITIZERS = "-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer -g -O1 -std=c11"
COUNT = os.environ.get("CCGEN_SANITIZED", "6")


@pytest.fixture(scope="module")
def core(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The core with the sanitizers, as one object."""
    if os.name != "posix" or not shutil.which("cc") or not shutil.which("ld"):
        pytest.skip("needs cc and ld")
    folder = tmp_path_factory.mktemp("core")
    sources = sorted(map(str, CORE.rglob("*.c")))
    probe = folder / "probe.c"
    probe.write_text("int main(void) { return 0; }\n")
    if subprocess.run(["cc", *SANITIZERS.split(), str(probe), "-o", str(folder / "probe")], check=False).returncode:
        pytest.skip("the compiler has no sanitizers")
    command = ["cc", *SANITIZERS.split(), f"-I{ROOT / 'runtime'}", f"-I{CORE}", "-c", *sources]
    subprocess.run(command, cwd=folder, check=True)
    objects = sorted(map(str, folder.glob("*.o")))
    subprocess.run(["ld", "-r", "-o", str(folder / "core.o"), *objects], check=True)
    return folder / "core.o"


SCENES: dict[str, Any] = {
    "rough": lambda: scene(4, True),
    "smooth": lambda: scene(6, False),
    "hexagon": lambda: load_scene(ROOT / "scenes" / "falling-hexagon.toml"),
    "air": lambda: loop(5, gravity=True),
}


def compiled(program: str, scene_name: str, core: Path, folder: Path, *flags: str) -> Path:
    """A program of tests/c with the model of a scene and the core."""
    package = generate(SCENES[scene_name](), out=folder)
    load_model(package).write_header(folder / "values.h")
    sources = [ROOT / "tests" / "c" / f"{program}.c", package / "model.c", package / "lanes.c", core]
    folders = [f"-I{folder}", f"-I{package}", f"-I{ROOT / 'runtime'}", f"-I{CORE}"]
    names = [f"-DMODEL={package.name}", '-DVALUES="values.h"', *folders]
    made = ["cc", *SANITIZERS.split(), *names, *map(str, sources), *flags, "-lm", "-o", str(folder / program)]
    subprocess.run(made, check=True)
    return folder / program


@pytest.mark.parametrize("name", SCENES)
def test_tosses_under_the_sanitizers(name: str, core: Path, tmp_path: Path) -> None:
    tosses = compiled("tosses", name, core, tmp_path)
    done = subprocess.run([tosses, COUNT], capture_output=True, text=True, check=False, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
    print(done.stdout)
    assert done.stdout.count("done") >= int(COUNT) // 3, done.stdout


@pytest.mark.parametrize("name", ["rough", "hexagon"])
def test_memory_that_runs_out_is_said(name: str, core: Path, tmp_path: Path) -> None:
    """Wherever it does; what is wrong with that is told by the sanitizers."""
    if sys.platform != "linux":
        pytest.skip("needs a linker with --wrap")
    starved = compiled("starved", name, core, tmp_path, "-Wl,--wrap=malloc")
    done = subprocess.run([starved], capture_output=True, text=True, check=False, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
