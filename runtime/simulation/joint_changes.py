"""Joints that let go and take hold, as a model's data say (docs/theory.md, section 5.15)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..model.model import Model

WORDS = {
    "angle": "the angle of",
    "direction": "the direction of",
    "slide": "the length along",
    "height": "the height of",
}


def changes_of(model: Model) -> Sequence[Mapping[str, Any]]:
    """What a model's data say of its joints that let go and take hold."""
    switching = model.data.get("switching")
    return () if switching is None else switching["changes"]


def why(said: Mapping[str, Any]) -> str:
    """What brings a change, in words."""
    if said["at"] is not None:
        return f"its time has come, {said['at']:g} s"
    if watch := said["watch"]:
        words = WORDS.get(watch["kind"])
        what = f"{words} {watch['names'][0]}" if words else f"the distance of {' and '.join(watch['names'])}"
        unit = "rad" if watch["kind"] in ("angle", "direction") else "m"
        return f"{what} comes {'above' if watch['sign'] > 0 else 'below'} {watch['limit']:.6g} {unit}"
    limits = [f"{said[key]:g} {unit}" for key, unit in (("force", "N"), ("impulse", "N s")) if said[key] is not None]
    return f"it carries its limit, {' or '.join(limits)}" if limits else "its points meet"
