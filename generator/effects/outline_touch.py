"""Outlines that touch: a disc against a line of edges or a polygon of another link, or two of those (``[[touch]]``)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

from ..effect_base.between import distance_from
from ..effect_base.contact import DEPTH
from ..effect_base.effect import ContactPoint, Effect, Rim
from ..mechanism.joints import PointRef
from ..mechanism.links import Parameter, Point
from ..mechanism.mechanism import Mechanism
from ..mechanism.outlines import convex_corners, convex_pieces, edges, is_inside
from ..mechanism.uniform_bodies import crossing_edges

if TYPE_CHECKING:
    from ..derive.gaps import Gap
    from ..derive.terms_of_effects import Let
    from ..derive.touching import Side
    from ..mechanism.assembled import Assembled


@dataclass(frozen=True)
class Outline:
    """One side of a touch: edges from corner to corner, ``closed`` where the last is joined to the first; a single
    corner is a disc.

    ``names`` are those of the corners in the scene, ``places`` in their link's frame, ``radius`` is half of what the
    edges are thick, or the disc's (m); ``None`` is zero. ``title`` is what the scene says.
    """

    title: str
    corners: tuple[PointRef, ...]
    names: tuple[str, ...]
    places: tuple[Point, ...]
    closed: bool
    radius: Parameter | None

    @property
    def size(self) -> float:
        return self.radius.value if self.radius else 0.0

    @property
    def edges(self) -> list[tuple[int, int]]:
        return edges(len(self.corners), self.closed)

    def pieces(self) -> list[tuple[int, ...]]:
        """What has a gap of its own to a disc, by the numbers of its corners: of an open line each edge, because a disc
        may touch it from both sides; of a polygon its convex pieces."""
        return convex_pieces(self._values()) if self.closed else [*self.edges]

    def tips(self) -> list[int]:
        """The corners by which it touches edges: all but those at which a polygon is concave."""
        return convex_corners(self._values()) if self.closed else [*range(len(self.corners))]

    def piece_name(self, piece: tuple[int, ...]) -> str:
        """By its first and last corner, ``R0-R1``."""
        return "-".join(self.names[k].rpartition(".")[2] for k in (piece[0], piece[-1]))

    def _values(self) -> list[complex]:
        return [complex(*place.values()) for place in self.places]


@dataclass(frozen=True)
class Pair:
    """A corner of one outline, by its number, and a piece of another; ``ground`` is what the contact calls that."""

    tipped: Outline
    tip: int
    facing: Outline
    piece: tuple[int, ...]
    ground: str


@dataclass(frozen=True)
class OutlineTouch(Effect):
    """Keeps two outlines of two links apart, with ``restitution`` (0 to 1) and ``friction``."""

    index: int
    name: str
    first: Outline
    second: Outline
    restitution: Parameter
    friction: Parameter | None = None

    def __post_init__(self) -> None:
        if not self.first.size + self.second.size > 0.0:
            raise ValueError(f"{self.name} has radii without a positive sum")

    def parameters(self) -> tuple[Parameter, ...]:
        radii = (side.radius for side in (self.first, self.second) if side.radius)
        return (*radii, self.restitution, *((self.friction,) if self.friction else ()))

    def describe(self, mechanism: Mechanism) -> str:
        sides = " against ".join(map(_in_words, (self.first, self.second)))
        return f"{sides}, {len([*self.pairs()])} contacts, {super().describe(mechanism)}"

    def pairs(self) -> Iterator[Pair]:
        """What touches what: corners of the first side before pieces of the second, then the other way round."""
        for tipped, facing in ((self.first, self.second), (self.second, self.first)):
            pieces = facing.pieces()
            for tip in tipped.tips():
                for piece in pieces:
                    ground = self.name if len(pieces) == 1 else f"{self.name}.{facing.piece_name(piece)}"
                    yield Pair(tipped, tip, facing, piece, ground)

    def gaps(self, let: Let) -> tuple[Gap, ...]:
        """One gap for every pair."""
        from ..derive.touching import PieceGap, Polygon
        from ..derive.vectors import symbol

        numbers = {id(side): number for number, side in enumerate((self.first, self.second))}
        spans = {id(side): self._sides(number, side, let) for number, side in enumerate((self.first, self.second))}

        def polygon(pair: Pair) -> Polygon | None:
            label = f"touch_{self.index}_corner_{numbers[id(pair.tipped)]}_{pair.tip}"
            return Polygon(label, tuple(spans[id(pair.facing)])) if pair.facing.closed else None

        return tuple(
            PieceGap(
                name=pair.tipped.names[pair.tip],
                ground=pair.ground,
                label=f"touch_{self.index}_{number}",
                disc=pair.tipped.corners[pair.tip],
                other=pair.facing.corners[0 if pair.facing.closed else pair.piece[0]],
                edge=None,
                radius=symbol(pair.tipped.radius),
                thickness=symbol(pair.facing.radius),
                restitution=symbol(self.restitution),
                friction=symbol(self.friction),
                sides=tuple(spans[id(pair.facing)][start] for start in pair.piece[:-1]),
                polygon=polygon(pair),
            )
            for number, pair in enumerate(self.pairs())
        )

    def _sides(self, number: int, outline: Outline, let: Let) -> list[Side]:
        """The edges with their lengths, which depend on parameters alone."""
        from sympy import sqrt

        from ..derive.touching import Side
        from ..derive.vectors import dot, less, local

        found = []
        for k, end in outline.edges:
            along = less(local(outline.places[end]), local(outline.places[k]))
            label = f"touch_{self.index}_{number}_{k}"
            span = let(f"span_{label}", sqrt(dot(along, along)))
            found.append(Side(label, outline.corners[k], outline.corners[end], span))
        return found

    def rims(self) -> tuple[Rim, ...]:
        found: list[Rim] = []
        for side in (self.first, self.second):
            found += [(side.corners[a], side.corners[b], side.radius) for a, b in side.edges]
            if not side.edges and side.radius:
                found.append((side.corners[0], None, side.radius))
        return tuple(found)

    def contact_points(self) -> tuple[ContactPoint, ...]:
        """Corners by which a side touches, each once: what it touches is the other side."""
        corners = dict.fromkeys(
            (pair.tipped.names[pair.tip], pair.tipped.corners[pair.tip], pair.tipped.radius) for pair in self.pairs()
        )
        return tuple((name, self.name, corner, radius) for name, corner, radius in corners)

    def check_start(self, start: Assembled) -> tuple[str, ...]:
        where = {
            id(side): [complex(*start.place(corner)) for corner in side.corners] for side in (self.first, self.second)
        }
        for pair in self.pairs():
            tip, corners = where[id(pair.tipped)][pair.tip], where[id(pair.facing)]
            if pair.facing.closed and is_inside(tip, corners):
                return (
                    f"the start has {pair.tipped.names[pair.tip]} inside the polygon of {pair.facing.title}, expected "
                    "it outside; change the start, or, for what is inside of a frame, name two open lines",
                )
        deepest, said = DEPTH, ""
        reach = self.first.size + self.second.size
        for pair in self.pairs():
            tip, corners = where[id(pair.tipped)][pair.tip], where[id(pair.facing)]
            depth = reach - min(distance_from(tip, corners[a], corners[b]) for a, b in pairwise(pair.piece))
            if depth > deepest:
                deepest = depth
                said = f"{pair.tipped.names[pair.tip]} inside {pair.facing.title} by {depth:.6g} m"
        if said:
            return (f"the start has {said}, expected at or off its surface; change the start or the radii",)
        one, other = (where[id(side)] for side in (self.first, self.second))
        for a, b in self.first.edges:
            for c, d in self.second.edges:
                if _cross(one[a], one[b], other[c], other[d]):
                    return (
                        f"the start has the edge {self.first.names[a]}-{self.first.names[b]} across the edge "
                        f"{self.second.names[c]}-{self.second.names[d]}, expected outlines apart; change the start",
                    )
        return ()


def fault_of(names: Sequence[str], places: Sequence[complex], closed: bool) -> str:
    """What is wrong with the corners of an outline; nothing where nothing is."""
    if closed and len(places) < 3:
        return "a line that ends where it begins has three corners or more"
    found = crossing_edges(places, closed)
    if found is None:
        return ""
    one, other = (f"{names[k]}-{names[(k + 1) % len(names)]}" for k in found)
    if one == other:
        return f"the edge {one} has no length"
    return f"the edges {one} and {other} cross, touch or overlap"


def _in_words(side: Outline) -> str:
    if len(side.corners) == 1:
        return side.names[0]
    return f"{side.title} ({'polygon' if side.closed else 'line'} of {len(side.edges)} edges)"


def _cross(a: complex, b: complex, c: complex, d: complex) -> bool:
    """Whether two segments cross."""

    def side(one: complex, other: complex, place: complex) -> float:
        return ((other - one).conjugate() * (place - one)).imag

    return side(a, b, c) * side(a, b, d) < 0.0 and side(c, d, a) * side(c, d, b) < 0.0
