"""Where mass centres are in their links: parameters of a scene by the names of links."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

NAME = "com"
"""What a link's mass centre is called after the link's name and a dot, unless a point of the link has that name."""


class Weighed(Protocol):
    """A model whose links have masses."""

    @property
    def links(self) -> Sequence[str]: ...
    @property
    def parameters(self) -> Mapping[str, float]: ...


class MassCentre(NamedTuple):
    """Of the link with this number: its place (m) in the link's frame, and the link's mass (kg)."""

    link: int
    x: float
    y: float
    mass: float


def mass_centre(model: Weighed, link: str) -> MassCentre | None:
    """That of the link of this name; ``None`` where it has no mass. Coordinates that are no parameter are exactly 0."""
    of = model.parameters.get
    mass = of(f"{link}.mass", 0.0)
    if link not in model.links or not mass > 0.0:
        return None
    return MassCentre(model.links.index(link), of(f"{link}.com.x", 0.0), of(f"{link}.com.y", 0.0), mass)
