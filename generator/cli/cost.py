"""``ccgen cost SCENE``: what a scene costs, by accuracy, by effect or in derivatives."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from .build import check_precision
from .detail import Detail
from .folders import check_results
from .refusal import Faults, read_option
from .scene_file import read, tell_assembly

ERROR = 1e-8
"""The error for which a method is recommended unless another is wanted."""


def cost(
    scene_file: Path,
    until: str | None,
    error: str | None,
    drift: bool,
    precision: str | None,
    effects: bool,
    fold: bool,
    gradient: bool,
    by: str | None,
    out: Path | None,
    detail: Detail,
    settings: Mapping[str, float],
    faults: Faults,
) -> None:
    """Measure error against time, with ``effects`` each effect's price, or with ``gradient`` derivatives; options of
    the others are refused."""
    if gradient:
        from .gradient import price_gradient

        others = {"--effects": effects, "--fold": fold, "--drift": drift, "--error": error, "--precision": precision}
        refuse_beside("--gradient", others, faults)
        price_gradient(scene_file, until, by, out, detail, settings, faults)
        return
    if by is not None:
        faults.add("--by: found without --gradient, expected with it only; add --gradient")
    if not effects:
        if fold:
            faults.add("--fold: found without --effects, expected with it only; add --effects")
        from .accuracy import price_accuracy

        precisions = list(dict.fromkeys((precision or "double").split(",")))
        for name in precisions:
            faults.of(check_precision, name)
        wanted = faults.of(read_option, error, check_error)
        aim = ERROR if wanted is None else wanted
        price_accuracy(scene_file, until, aim, drift, precisions, out, detail, settings, faults)
        return
    beside = {"--until": until, "--error": error, "--drift": drift, "--precision": precision}
    refuse_beside("--effects", {**beside, "--set": settings}, faults)
    scene = faults.of(read, scene_file)
    from .price import FILE, price_effects

    if out is not None:
        faults.of(check_results, out, [FILE], "--out")
    faults.stop_if_any()
    assert scene
    tell_assembly(scene, detail)
    price_effects(scene, fold, out, detail)


def refuse_beside(option: str, others: Mapping[str, object], faults: Faults) -> None:
    """Note which of the ``others`` are given, none of which goes with the ``option``."""
    for name, given in others.items():
        if given is not None and given is not False and given != {}:
            faults.add(f"{name}: found beside {option}, expected one of them; leave one out")


def check_error(error: object) -> None:
    """Raise ``ValueError`` unless this is an error that can be wanted."""
    if not isinstance(error, float) or not 1e-15 <= error < 1.0:
        raise ValueError(f"error: found {error!r}, expected a number from 1e-15 to 1; correct it")
