"""Meshes: what gears, racks and belts ask of joints, one linear row among their angles and lengths.

With x the angle of one link against another (rad), or how far a sliding joint is along its line (m), and radii r, a
mesh is Σ ± r (x − x₀) = 0, in m: as much passes the pitch point on one side as on the other. x₀ are those of the start.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from .links import GROUND, Parameter


@dataclass(frozen=True)
class MeshTerm:
    """``sign`` · ``radius`` · (x − ``start``), by which link ``second`` turns against link ``first``.

    Where joint ``slide`` is one that slides, x is its length and there is no radius.
    """

    sign: int
    radius: Parameter | None
    start: Parameter = field(compare=False)
    first: int = GROUND
    second: int = GROUND
    slide: int | None = None


@dataclass(frozen=True)
class Mesh:
    """A row of ``terms``, called ``name``; ``joints`` are those that the scene names for it."""

    name: str
    joints: tuple[int, ...]
    terms: tuple[MeshTerm, ...]

    @property
    def slides(self) -> tuple[int, ...]:
        """Sliding joints whose lengths are in the row."""
        return tuple(term.slide for term in self.terms if term.slide is not None)

    def levers(self) -> dict[int, float]:
        """What the row gains by a radian of each link, in m; the ground's too, whose angle is zero."""
        found: dict[int, float] = {}
        for term in self.terms:
            if term.radius is not None:
                for link, sign in ((term.second, term.sign), (term.first, -term.sign)):
                    found[link] = found.get(link, 0.0) + sign * term.radius.value
        return found

    def lengths(self) -> dict[int, int]:
        """What the row gains by a metre along each sliding joint."""
        return {term.slide: term.sign for term in self.terms if term.slide is not None}
