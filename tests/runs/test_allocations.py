"""While a simulation goes on nothing is allocated but rows of its record: counted in C (tests/c/allocations.c)."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from ccgen.generator import chain, generate, load_scene, loop
from ccgen.runtime import load_model

from ..hard.fuzz import scene
from ..support.core_objects import core_objects
from ..support.folders import ROOT, RUNTIME

CORE = ROOT / "runtime" / "core"
WRAPPED = "-Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc,--wrap=free"
ROUGH = {"normal": [0.0, 1.0], "point": [0.0, 0.0], "restitution": 0.4, "friction": 0.6}

PENDULUM = {
    "name": "hung",
    "ground_link": {"points": {"O": [0, 0], "Q": [0.7, 1.1]}},
    "link": [{"name": "rod", "rod": {"mass": 1}, "points": {"A": [0, 0], "B": [1, 0]}}],
    "joint": [{"between": ["ground.O", "rod.A"]}],
    "gravity": {},
    "spring": [
        {"between": ["ground.Q", "rod.B"], "stiffness": 10.0, "length": 0.5 + 0.01 * k, "acts": "pull"}
        for k in range(40)
    ],
}

SCENES: dict[str, tuple[Callable[[], Any], dict[str, int]]] = {
    "rough hexagons": (lambda: scene(6, True), {"struck at once": 1, "stuck": 1, "slid": 1}),
    "rough squares, which fall flat": (
        lambda: loop(4, gravity=True, start={"height": 0.5}, ground=[ROUGH]),
        {"struck at once": 2, "dependent": 1, "stuck": 1, "slid": 1},
    ),
    "the hexagon on its edge": (
        lambda: load_scene(ROOT / "scenes" / "falling-hexagon.toml"),
        {"struck at once": 2},
    ),
    "a chain that lies, twice on the same ground": (
        lambda: chain(8, gravity=True, start={"height": 0.2}, ground=[ROUGH, ROUGH]),
        {"struck at once": 18, "stuck": 1},
    ),
    "a long chain that lies": (
        lambda: chain(24, gravity=True, start={"height": 0.2}, ground=[ROUGH]),
        {"struck at once": 25, "stuck": 1},
    ),
    "a driven walker": (lambda: load_scene(ROOT / "scenes" / "jansen-driven.toml"), {}),
    "a loop in the air": (lambda: loop(5, gravity=True), {}),
    "a pendulum on 40 ropes": (lambda: load_scene(PENDULUM), {}),
}


@pytest.fixture(scope="module")
def core(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The core, its calls of the C library not bound yet."""
    if sys.platform != "linux" or not shutil.which("cc") or not shutil.which("ld"):
        pytest.skip("needs cc and ld with --wrap")
    folder = tmp_path_factory.mktemp("core")
    subprocess.run(["ld", "-r", "-o", str(folder / "core.o"), *core_objects(RUNTIME, ["-O1"])], check=True)
    return folder / "core.o"


@pytest.mark.hard
@pytest.mark.parametrize("name", SCENES)
def test_nothing_is_allocated_between_calls(name: str, core: Path, tmp_path: Path) -> None:
    """And the tosses have met what needs most memory; Jacobians of generated derivatives need theirs too."""
    made, least = SCENES[name]
    folder = generate(made(), out=tmp_path, derivatives=True)
    load_model(folder).write_header(tmp_path / "values.h")
    of_model = [folder / f"{part}.c" for part in ("model", "lanes", "derivatives")]
    sources = [ROOT / "tests" / "c" / "allocations.c", *of_model, core]
    folders = [f"-I{tmp_path}", f"-I{folder}", f"-I{ROOT / 'runtime'}", f"-I{CORE}"]
    names = [f"-DMODEL={folder.name}", '-DVALUES="values.h"', *folders]
    command = ["cc", "-O1", "-std=c11", *names, *map(str, sources), WRAPPED, "-lm", "-o", str(tmp_path / "allocations")]
    subprocess.run(command, check=True)
    done = subprocess.run([tmp_path / "allocations"], capture_output=True, text=True, check=False, timeout=600)
    print(done.stdout)
    assert done.returncode == 0, done.stdout + done.stderr
    found = {what: int(count) for what, count in re.findall(r"([a-z][a-z ]*) (\d+)", done.stdout.splitlines()[-1])}
    assert all(found[what] >= count for what, count in least.items()), found
