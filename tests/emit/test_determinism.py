"""Same input, same bytes; and a cost that grows in proportion to the number of links."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ..oracles import mechanisms
from ..support.tiers import all_hard_but
from ..support.workshop import Workshop

SEEDS = ("0", "1", "4242")
TEXTS = (".txt", ".c", ".h", ".pyx", ".py", ".json")
GENERATE = """
import sys
from ccgen.generator import generate, load_scene
generate(load_scene(sys.argv[2]), out=sys.argv[1])
generate(load_scene(sys.argv[2]), out=sys.argv[1] + "/with", derivatives=True)
"""


SLOPE = "[[ground]]\nnormal = [0.3, 1]\npoint = [0, -9]\nrestitution = 0.2\n"
SCENES = {
    "falling ring": "[loop]\nlinks = 4\n[start]\nheight = 1.0\n[gravity]\ng = 9.81\n[[ground]]\nrestitution = 0.5\n",
    "two loops of random links": mechanisms.two_loops(7).toml(extra=SLOPE),
}


@pytest.fixture(scope="module", params=all_hard_but("falling ring", of=SCENES))
def generated(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, bytes]]:
    """All text files of freshly generated packages, once per hash seed, each time from another folder.

    They share what is compiled: it is known by what the compiler reads, and texts are compared here."""
    steps = Path(os.environ["CCGEN_CACHE_DIR"]) / "steps"
    steps.mkdir(mode=0o700, exist_ok=True)
    places = [tmp_path_factory.mktemp(name) for name in ("here", "far-away", "elsewhere")]
    running = []
    for seed, place in zip(SEEDS, places, strict=True):
        scene = place / "scene.toml"
        scene.write_text(SCENES[request.param])
        (place / "cache").mkdir(mode=0o700)
        (place / "cache" / "steps").symlink_to(steps)
        environment = {**os.environ, "PYTHONHASHSEED": seed, "CCGEN_CACHE_DIR": str(place / "cache")}
        command = [sys.executable, "-c", GENERATE, str(place / "out"), str(scene)]
        running.append(subprocess.Popen(command, env=environment, cwd=place, stderr=subprocess.PIPE, text=True))
    for process in running:
        _, trouble = process.communicate(timeout=300)
        assert process.returncode == 0, trouble
    found = []
    for place in places:
        files = sorted((place / "out").rglob("*"))
        texts = [f for f in files if f.suffix in TEXTS and f.name != "build.json"]
        found.append({str(f.relative_to(place / "out")): f.read_bytes() for f in texts})
    return found


def test_same_bytes_under_three_hash_seeds_and_from_other_folders(generated: list[dict[str, bytes]]) -> None:
    """Without a word of the folders they were made in."""
    first = generated[0]
    assert sum(name.endswith("equations.txt") for name in first) == 2
    assert sum(name.endswith("model.c") for name in first) == 2
    assert sum(name.endswith("derivatives.c") for name in first) == 1
    for other in generated[1:]:
        assert list(other) == list(first)
        assert [name for name in first if other[name] != first[name]] == []
    assert [name for name, text in generated[1].items() if b"far-away" in text] == []


def _operations(scene: Any, plan: str | None = None) -> int:
    """Operations of the acceleration kernel besides sines and cosines."""
    from ccgen.generator.pipeline import derive_scene
    from ccgen.generator.program.program import lower

    _, equations = derive_scene(scene, plan=plan)
    return int(lower(equations).function("acceleration").counts().total)


def _exponent(sizes: list[int], counts: list[int]) -> float:
    return float(np.polyfit(np.log(sizes), np.log(counts), 1)[0])


SIZES = [4, 6, 8, 12, 16, 24, 32, 48, 64]
FOUR_EQUAL = [21, 25, 33, 49, 65]
"""Rings of a root and four equal segments."""


@pytest.mark.hard
@pytest.mark.slow
def test_operations_grow_in_proportion_to_the_links() -> None:
    """Counts over n = 4 ... 64 fitted with a power of n: exponent at most 1.05."""
    from ccgen.generator import loop

    assert _exponent(SIZES, [_operations(loop(n, gravity=True), "tip to root") for n in SIZES]) <= 1.05


@pytest.mark.hard
@pytest.mark.parametrize(
    ("form", "plan", "sizes"),
    [
        ("loop", "tip to root", SIZES),
        ("pinned", "tip to root", SIZES),
        ("chain", "tip to root", SIZES),
        ("loop", "segments", FOUR_EQUAL),
        ("pinned", "segments", [n - 1 for n in FOUR_EQUAL]),
    ],
)
def test_a_further_link_costs_the_same_wherever_it_comes(form: str, plan: str, sizes: list[int]) -> None:
    """Operations per added link; a power fits the chains badly, whose first links are cheaper than the others."""
    from ccgen import generator

    counts = [_operations(getattr(generator, form)(n, gravity=True), plan) for n in sizes]
    steps = np.diff(counts) / np.diff(sizes)
    assert steps.max() <= 1.02 * np.median(steps)


@pytest.mark.hard
def test_operations_of_a_ladder_grow_in_proportion_to_its_loops(workshop: Workshop) -> None:
    loops = [2, 4, 8, 16]
    counts = [_operations(workshop.scene(mechanisms.ladder(n).toml())) for n in loops]
    assert _exponent([3 * n + 1 for n in loops], counts) <= 1.1


def test_the_hexagon_is_cheap() -> None:
    from ccgen.generator import loop

    assert _operations(loop(6)) <= 600
