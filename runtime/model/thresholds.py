"""The thresholds of the core as a model has them: numbers times its length, its characteristic time, its tolerance."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from .compiled import Compiled

UNITS = {"": "", "length": "m", "speed": "m/s", "time": "s", "unit": "rad or m", "tolerance": ""}
"""Units of what thresholds are times."""


@dataclass(frozen=True)
class Threshold:
    """``value``, a number, times ``of`` (a length, speed, time, a coordinate's unit, the tolerance, or nothing) makes
    ``size`` in ``unit``; what it decides, why it is as large, and the layer of the core that asks for it.

    Where ``of`` is a unit, ``size`` is that of an angle.
    """

    name: str
    value: float
    of: str
    size: float
    unit: str
    decides: str
    because: str
    layer: str


def thresholds(model: Compiled) -> Iterator[Threshold]:
    """Every threshold of the core, by layers, with sizes for this model in its own numbers.

    Lengths are of :attr:`Compiled.length`, times of :func:`characteristic_time`; what is times the time grows with it.
    What is times the tolerance follows ``rtol``, here that of the scene.
    """
    time, rtol = characteristic_time(model), model.data["run"]["rtol"]
    speed = model.length / time
    scale = {"": 1.0, "length": model.length, "speed": speed, "time": time, "unit": 1.0, "tolerance": rtol}
    for name, (value, of, decides, because, layer) in model.core.TOLERANCES.items():
        yield Threshold(name, float(value), of, float(value) * scale[of], UNITS[of], decides, because, layer)


def characteristic_time(model: Compiled) -> float:
    """The characteristic time (s) of a run: that of gravity, or the scene's duration.

    Without gravity a run that begins faster has a shorter one: half a turn at its largest rate.
    """
    return model.time or model.duration


def thresholds_text(model: Compiled) -> str:
    """The table for a person to read: what the numbers are times, then every threshold under its layer's name."""
    lines = _scales(model)
    for layer, entries in groupby(thresholds(model), lambda one: one.layer):
        lines += ["", f"[{layer}]"]
        for one in entries:
            lines += [f"{one.name}  {_size(one, model)}", f"    {one.decides}", f"    because: {one.because}"]
    return "\n".join(lines)


def _scales(model: Compiled) -> list[str]:
    """What thresholds are times, and how large that is here."""
    kind, time, rtol = model.core.REAL, characteristic_time(model), model.data["run"]["rtol"]
    told = "about half a swing under gravity"
    if model.time is None:
        told = "the duration, or half a turn at the rate at which a run begins, if that is less"
    return [
        f"{model.name}: rounding {float(np.finfo(kind).eps):.3g}, rtol {rtol:.3g}; by layers of the core",
        "A threshold is a number, times",
        f"    length     {model.length:.4g} m: the largest extent of a link; of the angle at a stop, 1 rad",
        f"    time       {time:.4g} s, or the time reached, if that is more; characteristic time {time:.4g} s: {told}",
        f"    speed      {model.length / time:.4g} m/s: the length per characteristic time",
        f"    unit       that of a coordinate: 1 rad, or {model.length:.4g} m of a place or a length along a line",
        f"    tolerance  {rtol:.3g}: rtol (in places atol); these thresholds follow it, the others do not",
        "or, with nothing beside it, times what it says.",
    ]


def _size(one: Threshold, model: Compiled) -> str:
    """``1e-12 length = 2e-12 m``."""
    if not one.of:
        return f"{one.value:.3g}"
    here = f"{one.size:.3g} {one.unit}"
    if one.of == "unit":
        here = f"{one.size:.3g} rad or {one.size * model.length:.3g} m"
    if one.of == "tolerance":
        here = f"{one.size:.3g}, follows rtol"
    return f"{one.value:.3g} {one.of} = {here}"
