"""The thresholds of the core as a model has them: numbers times its length and its characteristic time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .compiled import Compiled

UNITS = {"": "", "length": "m", "length / time": "m/s", "time": "s", "unit": "rad or m"}
"""Units of what thresholds are times."""


@dataclass(frozen=True)
class Threshold:
    """``value``, a number, times ``of`` (a length, a speed, a time, a coordinate's unit, or nothing) makes ``size`` in
    ``unit``; what it decides, and why it is as large."""

    name: str
    value: float
    of: str
    size: float
    unit: str
    decides: str
    because: str


def thresholds(model: Compiled) -> Iterator[Threshold]:
    """Every threshold of the core, by layers, with sizes for this model in its own numbers.

    Lengths are of :attr:`Compiled.length`, times of :func:`characteristic_time`; what is times the time grows with it.
    """
    time = characteristic_time(model)
    scale = {"": 1.0, "length": model.length, "length / time": model.length / time, "time": time, "unit": 1.0}
    for name, (value, of, decides, because) in model.core.TOLERANCES.items():
        yield Threshold(name, float(value), of, float(value) * scale[of], UNITS[of], decides, because)


def characteristic_time(model: Compiled) -> float:
    """The characteristic time (s) of a run: that of gravity, or the scene's duration.

    Without gravity a run that begins faster has a shorter one: half a turn at its largest rate.
    """
    return model.time or model.duration


def thresholds_text(model: Compiled) -> str:
    """The table for a person to read."""
    kind, time = model.core.REAL, characteristic_time(model)
    rtol = model.data["run"]["rtol"]
    told = "about half a swing under gravity"
    if model.time is None:
        told = "the duration, or half a turn at the rate at which a run begins, if that is less"
    lines = [
        f"{model.name}: rounding {float(np.finfo(kind).eps):.3g}, rtol {rtol:.3g}, length {model.length:.4g} m",
        f"characteristic time {time:.4g} s: {told}",
        "",
    ]
    for one in thresholds(model):
        size = f" = {one.size:.3g} {one.unit}" if one.unit and one.of != "unit" else ""
        times = f" {one.of}" if one.of else ""
        lines += [f"{one.name}  {one.value:.3g}{times}{size}", f"    {one.decides}", f"    because: {one.because}"]
    return "\n".join(lines)
