"""The stored listings are what is derived now, byte for byte."""

from __future__ import annotations

import difflib
from collections.abc import Callable

import pytest

from ccgen.generator import Scene, load_scene, loop, pinned
from ccgen.generator.pipeline import listing
from ccgen.generator.program.reading import read_listing

from ..support.folders import ROOT

GOLDEN = ROOT / "tests" / "golden"

SCENES: dict[str, Callable[[], Scene]] = {
    "loop6": lambda: loop(6),
    "pinned3": lambda: pinned(3),
    **{
        name: lambda name=name: load_scene(ROOT / "scenes" / f"{name}.toml")  # type: ignore[misc]
        for name in ("falling-hexagon", "four-bar", "open-chain")
    },
}


@pytest.mark.parametrize("name", SCENES)
def test_listing_is_the_stored_one(name: str) -> None:
    stored = (GOLDEN / name / "equations.txt").read_bytes().decode()
    derived = listing(SCENES[name]())
    if derived != stored:
        changes = list(difflib.unified_diff(stored.splitlines(), derived.splitlines(), "stored", "derived", n=1))
        shown = "\n".join([*changes[:40], *(["..."] if len(changes) > 40 else [])])
        pytest.fail(f"the equations of {name} have changed; if that is meant, run: make golden\n{shown}", pytrace=False)


def test_every_stored_listing_is_checked_and_can_be_read() -> None:
    assert {folder.name for folder in GOLDEN.iterdir()} == set(SCENES)
    for name in SCENES:
        read_listing((GOLDEN / name / "equations.txt").read_text(encoding="utf-8"), name)
