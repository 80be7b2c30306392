"""Tosses from C under the address and the undefined-behaviour sanitizer, leaks included; ``make sanitize`` has more."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from ccgen.generator import generate, load_scene, loop
from ccgen.runtime import load_model

from ..hard.fuzz import scene
from ..support.folders import ROOT
from ..support.tiers import all_hard_but

CORE = ROOT / "runtime" / "core"
SANITIZERS = "-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer -g -O1 -std=c11"
COUNT = os.environ.get("CCGEN_SANITIZED", "12")


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


@pytest.mark.parametrize("name", all_hard_but("rough", of=SCENES))
def test_tosses_under_the_sanitizers(name: str, core: Path, tmp_path: Path) -> None:
    folder = generate(SCENES[name](), out=tmp_path)
    load_model(folder).write_header(folder / "values.h")
    sources = [ROOT / "tests" / "c" / "tosses.c", folder / "model.c", folder / "lanes.c", core]
    names = [f"-DMODEL={folder.name}", '-DVALUES="values.h"', f"-I{folder}", f"-I{ROOT / 'runtime'}"]
    made = ["cc", *SANITIZERS.split(), *names, *map(str, sources), "-lm", "-o", str(tmp_path / "tosses")]
    subprocess.run(made, check=True)
    done = subprocess.run([tmp_path / "tosses", COUNT], capture_output=True, text=True, check=False, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
    print(done.stdout)
    assert done.stdout.count("done") >= int(COUNT) // 3, done.stdout
