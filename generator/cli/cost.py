"""``ccgen cost SCENE``: what a scene costs."""

from __future__ import annotations

from pathlib import Path

from .folders import check_folder
from .refusal import fail
from .scene_file import read, tell_assembly


def cost(scene_file: Path, effects: bool, fold: bool, out: Path | None) -> None:
    """Measure what was asked for, print it as a table, and write it as CSV into ``out`` where there is a folder."""
    if not effects:
        fail("cost: found nothing to measure, expected --effects, the price of each effect of the scene; add it")
    scene = read(scene_file)
    if out is not None:
        check_folder(out, "--out")
    tell_assembly(scene)
    from .price import price_effects

    price_effects(scene, fold, out)
