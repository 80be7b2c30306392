"""``ccgen cost SCENE``: what a scene costs, by accuracy or by effect."""

from __future__ import annotations

from pathlib import Path

from .build import check_precision
from .detail import Detail
from .folders import check_results
from .refusal import fail
from .scene_file import read, tell_assembly

ERROR = 1e-8
"""The error for which a method is recommended unless another is wanted."""


def cost(
    scene_file: Path,
    until: float | None,
    error: float | None,
    drift: bool,
    precision: str | None,
    effects: bool,
    fold: bool,
    out: Path | None,
    detail: Detail = Detail.USUAL,
) -> None:
    """Measure error against time, or with ``effects`` each effect's price; options of the other one are refused."""
    if not effects:
        if fold:
            fail("--fold: found without --effects, expected with it only; add --effects")
        from .accuracy import price_accuracy

        precisions = list(dict.fromkeys(map(check_precision, (precision or "double").split(","))))
        price_accuracy(scene_file, until, ERROR if error is None else error, drift, precisions, out, detail)
        return
    others = {"--until": until, "--error": error, "--drift": drift or None, "--precision": precision}
    for option, given in others.items():
        if given is not None:
            fail(f"{option}: found beside --effects, expected one of them; leave one out")
    scene = read(scene_file)
    from .price import FILE, price_effects

    if out is not None:
        check_results(out, [FILE], "--out")
    tell_assembly(scene, detail)
    price_effects(scene, fold, out, detail)
