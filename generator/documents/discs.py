"""Discs among the contacts, for a person: which link each turns with, and how large it is."""

from __future__ import annotations

from collections.abc import Iterator

from ..effect_base.points import written
from ..scene.scene import Scene


def disc_lines(scene: Scene) -> Iterator[str]:
    """One line per disc: ``wheel.hub on ground_0: a disc of 0.1 m (ground_0.radius), turns with wheel``."""
    mechanism = scene.mechanism
    for effect in scene.effects:
        for name, touched, ref, radius in effect.contact_points():
            if radius:
                link, _, point = written(ref, mechanism).partition(".")
                turns = "fixed" if link == "ground" else f"turns with {link}"
                about = "" if name == f"{link}.{point}" else f", about {link}.{point}"
                yield f"{name} on {touched}: a disc of {radius.value!r} m ({radius.path}){about}, {turns}"
