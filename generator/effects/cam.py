"""Cam: a smooth closed profile on a link that lifts a roller, a point or a straight face of another."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from pydantic import Discriminator, Field, Tag

from ..effect_base.between import Extent, Side, edge_between, find_extent, on_two_links, title_of
from ..effect_base.cam_profile import MEETS, CamProfile, Height, Piece
from ..effect_base.contact import DEPTH, LAW_MEANS, Friction, Law, Radius, Restitution
from ..effect_base.effect import Complain, ContactPoint, Curve, Effect, Entry, Rim, Surroundings
from ..effect_base.expression_of_angle import InAngle
from ..effect_base.expression_of_time import Expression
from ..effect_base.laws_of_rise import LAWS, TURN, LawOfRise
from ..effect_base.points import choose_carrier, find_point
from ..effect_base.table import Name, PointName, Positive, Table, number_or_list
from ..effect_base.written_numbers import Angle, Measured
from ..mechanism.joints import PointRef
from ..mechanism.links import FROM_0_TO_1, NOT_NEGATIVE, POSITIVE, Parameter, Point

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.following import Profile
    from ..derive.gaps import Gap
    from ..derive.motion import Motion
    from ..derive.terms_of_effects import Let
    from ..mechanism.assembled import Assembled

DRAWN = 180
"""Corners of a profile that is drawn."""


class PieceTable(Table):
    """A piece of a lift."""

    to: Angle = Field(description='where it ends, in rad or as "90 deg": after the piece before, the last at "360 deg"')
    lift: Annotated[float | Expression, InAngle()] | None = Field(
        default=None,
        description="the lift at its end in m, or all of it as an expression of angle; without it the follower rests",
    )
    law: LawOfRise | None = Field(
        default=None,
        description='how it gets there: "cycloidal" unless it says "3-4-5", "4-5-6-7", "harmonic" or '
        '"modified-trapezoidal"',
    )


class CamTable(Table):
    """One ``[[cam]]``."""

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    centre: PointName = Field(description='the cam\'s centre, a joint or "link.point"')
    follower: Side = Field(
        description='the centre of a roller, or a point: "lever.P"; or the two ends of a straight face: '
        '["lifter.A", "lifter.B"]'
    )
    base: Annotated[Positive, Measured("m")] = Field(
        description="the radius of the base circle in m, a positive number: where the lift is zero"
    )
    radius: Radius | None = Field(
        default=None, description="the radius of the roller in m, not negative; without it the follower is a point"
    )
    lift: Annotated[
        Annotated[Annotated[float | Expression, InAngle()], Tag("<number>")]
        | Annotated[Annotated[list[PieceTable], Field(min_length=1, max_length=60)], Tag("<list>")],
        Discriminator(number_or_list),
    ] = Field(
        description="how far the follower is lifted off the base circle in m, over a turn: an expression of angle, or "
        "a list of pieces"
    )
    angle: Angle = Field(default=0.0, description="where on its link the cam's angle is zero, in rad; 0 if not given")
    clockwise: bool = Field(
        default=False, description="whether the cam's angle is counted clockwise; false if not given"
    )
    restitution: Restitution = Field(description="the coefficient of restitution, a number from 0 to 1")
    friction: Friction | None = Field(default=None, description="Coulomb's coefficient of friction, zero or positive")
    law: Law | None = Field(default=None, description=LAW_MEANS)


@dataclass(frozen=True)
class Cam(Effect):
    """Keeps a follower outside of the ``profile`` about ``centre``: a roller or a point at ``follower``, or the face
    from there to ``end``, with its ``ends`` in its link's frame.

    Impacts have the coefficient ``restitution`` (0 to 1); without ``friction`` the follower slides freely.
    """

    index: int
    name: str
    titles: tuple[str, str]
    centre: PointRef
    follower: PointRef
    end: PointRef | None
    ends: tuple[Point, Point] | None
    profile: CamProfile
    restitution: Parameter
    friction: Parameter | None = None

    def __post_init__(self) -> None:
        if self.centre.link == self.follower.link:
            raise ValueError(f"{self.name} is not between two links")

    def parameters(self) -> tuple[Parameter, ...]:
        return (*self.profile.parameters(), self.restitution, *((self.friction,) if self.friction else ()))

    def describe(self, mechanism: object) -> str:
        own = ", ".join(f"{p.path} = {p.value!r}" for p in self.parameters())
        pieces = len(self.profile.pieces)
        lift = f"a lift in {pieces} pieces, " if pieces > 1 else ""
        return f"{self.titles[1]} on the cam about {self.titles[0]}, {lift}{own}"

    def gaps(self, let: Let) -> tuple[Gap, ...]:
        """One gap, called after the follower and the cam."""
        from ..derive.following import FaceGap, RollerGap
        from ..derive.vectors import symbol

        label, profile = f"cam_{self.index}", self._profile()
        radius = self._radius()
        restitution, friction = symbol(self.restitution), symbol(self.friction)
        if self.end is None:
            return (
                RollerGap(
                    name=self._touching(),
                    ground=self.name,
                    label=label,
                    cam=self.centre,
                    disc=self.follower,
                    radius=radius,
                    profile=profile,
                    restitution=restitution,
                    friction=friction,
                ),
            )
        edge = edge_between(self.ends, self.end, f"span_{label}", let)
        assert edge is not None
        return (
            FaceGap(
                name=self._touching(),
                ground=self.name,
                label=label,
                cam=self.centre,
                start=self.follower,
                end=self.end,
                length=edge.length,
                profile=profile,
                restitution=restitution,
                friction=friction,
            ),
        )

    def _radius(self) -> Expr:
        """The roller's radius; zero of a point and a face."""
        from ..derive.vectors import symbol

        return symbol(self.profile.radius if isinstance(self.profile.radius, Parameter) else None)

    def _profile(self) -> Profile:
        """The profile in symbols."""
        from ..derive.following import Profile
        from ..derive.vectors import symbol

        own = self.profile
        far = symbol(own.base) + self._radius()
        return Profile(f"cam_{self.index}", far, own.lifts(), symbol(own.mounted), own.sense)

    def _touching(self) -> str:
        """The contact's first name: the follower's point, or of a face the cam's centre."""
        return self.titles[1] if self.end is None else self.titles[0]

    def sides(self) -> tuple[str, ...]:
        """One where pieces of the lift meet: steps end there, so that no method loses its order."""
        count = len(self.profile.pieces)
        return tuple(f"cam_{self.index}_{k}" for k in range(count)) if count > 1 else ()

    def switching(self, motion: Motion) -> Sequence[Expr]:
        """The sines of the angles from there to where the follower is."""
        import sympy as sp

        from ..derive.vectors import dot, perp, scale

        if not self.sides():
            return ()
        label, profile = f"cam_{self.index}", self._profile()
        seen = motion.distance(self.centre, self.follower)
        if self.end:
            seen = perp(motion.distance(self.follower, self.end))
        seen = motion.let_vector(f"at_{label}", scale(1 / sp.sqrt(dot(seen, seen)), seen))
        found = []
        for k, piece in enumerate(self.profile.pieces):
            start = profile.zero(motion.angle(self.centre.link), piece.start)
            found.append(dot(perp(motion.let_vector(f"begins_{label}_{k}", start)), seen))
        return found

    def rims(self) -> tuple[Rim, ...]:
        """The roller, or the face."""
        if self.end:
            return ((self.follower, self.end, None),)
        return ((self.follower, None, self.profile.radius),) if isinstance(self.profile.radius, Parameter) else ()

    def curves(self) -> tuple[Curve, ...]:
        return ((self.centre, self.profile.surface(DRAWN)),)

    def contact_points(self) -> tuple[ContactPoint, ...]:
        if self.end:
            return ((self.titles[0], self.name, self.centre, None),)
        radius = self.profile.radius if isinstance(self.profile.radius, Parameter) else None
        return ((self.titles[1], self.name, self.follower, radius),)

    def check_start(self, start: Assembled) -> tuple[str, ...]:
        centre, foot = complex(*start.place(self.centre)), complex(*start.place(self.follower))
        far, off = self.profile.far, foot - centre
        if self.end is None:
            if not abs(off) > DEPTH:
                return (f"the start has {self.titles[1]} in the cam's centre, expected it outside; change the start",)
            seen = self.profile.seen_at(off, start.angle(self.centre.link))
            depth = (far(seen) - abs(off)) * far(seen) / math.hypot(far(seen), far(seen, 1))
            return self._too_deep(depth)
        face = (complex(*start.place(self.end)) - foot) / abs(complex(*start.place(self.end)) - foot)
        normal = 1j * face if (off * face.conjugate()).imag > 0.0 else -1j * face
        seen = self.profile.seen_at(normal, start.angle(self.centre.link))
        depth = far(seen) - (off * normal.conjugate()).real
        touched = centre + normal * complex(far(seen), self.profile.sense * far(seen, 1))
        along = ((touched - foot) * face.conjugate()).real
        length = abs(complex(*start.place(self.end)) - foot)
        if depth >= -DEPTH and not -DEPTH <= along <= length + DEPTH:
            return (
                f"the start has the cam against the line of {self.titles[1]} {along:.6g} m from its first end, "
                f"expected from 0 to its length, {length:.6g} m; make the face longer or change the start",
            )
        return self._too_deep(depth)

    def _too_deep(self, depth: float) -> tuple[str, ...]:
        if depth <= DEPTH:
            return ()
        return (
            f"the start has {self.titles[1]} inside the cam by {depth:.6g} m, expected at or off its surface; move "
            f"it away from {self.titles[0]} in [start], or make the cam's base or lift less",
        )


def build(table: CamTable, index: int, around: Surroundings, complain: Complain) -> Cam | None:
    """The record of a table, or ``None`` after having complained."""
    mechanism = around.mechanism
    name = table.name or f"cam_{index}"
    centre, wrong = find_point(table.centre, mechanism)
    if centre is None:
        complain(("centre",), f'found "{table.centre}", expected a joint or link.point, the cam\'s centre; {wrong}')
    elif wrong := choose_carrier(table.centre, mechanism):
        complain(("centre",), wrong)
        centre = None
    follower = find_extent(table.follower, mechanism, lambda key, text: complain(("follower",), text))
    profile = _profile(table, name, index, follower, complain)
    rolls = isinstance(table.follower, str) and table.radius
    if follower and rolls and (wrong := choose_carrier(title_of(table.follower), mechanism)):
        complain(("follower",), wrong)
        follower = None
    if centre is None or follower is None or profile is None:
        return None
    if not on_two_links(table.centre, centre, table.follower, follower, mechanism, lambda _, text: complain((), text)):
        return None
    start, end = follower
    return Cam(
        index=index,
        name=name,
        titles=(table.centre, title_of(table.follower)),
        centre=centre,
        follower=start,
        end=end,
        ends=(mechanism.point(start), mechanism.point(end)) if end else None,
        profile=profile,
        restitution=Parameter(f"{name}.restitution", f"e_cam_{index}", table.restitution, FROM_0_TO_1),
        friction=None
        if table.friction is None
        else Parameter(f"{name}.friction", f"f_cam_{index}", table.friction, NOT_NEGATIVE),
    )


def _profile(table: CamTable, name: str, index: int, follower: Extent | None, complain: Complain) -> CamProfile | None:
    """The profile, or ``None`` after having complained."""
    face = follower is not None and follower[1] is not None
    if face and table.radius is not None:
        complain(("radius",), f"found {table.radius:.6g}, expected none with a straight face; leave it out")
        return None
    pieces = _pieces(table.lift, name, index, complain)
    if pieces is None:
        return None
    radius: Parameter | float | None = None if face else 0.0
    if table.radius:
        radius = Parameter(f"{name}.radius", f"r_cam_{index}", table.radius, NOT_NEGATIVE)
    profile = CamProfile(
        base=Parameter(f"{name}.base", f"b_cam_{index}", table.base, POSITIVE),
        radius=radius,
        pieces=pieces,
        mounted=Parameter(f"{name}.angle", f"o_cam_{index}", table.angle) if table.angle else None,
        clockwise=table.clockwise,
    )
    if follower is not None and (wrong := profile.fault()):
        complain(("lift",), wrong)
        return None
    return profile


def _pieces(
    lift: float | Expression | Sequence[PieceTable], name: str, index: int, complain: Complain
) -> tuple[Piece, ...] | None:
    """The pieces of a lift; ``None`` after having complained."""
    if isinstance(lift, Expression):
        return (Piece(0.0, TURN, lift, Height(lift.at(0.0)), Height(lift.at(0.0))),)
    if isinstance(lift, float):
        height = _height(lift, f"{name}.lift", f"l_cam_{index}")
        return (Piece(0.0, TURN, None, height, height),)
    if not _in_order(lift, complain):
        return None
    heights: list[Height | None] = []
    for k, one in enumerate(lift):
        if isinstance(one.lift, Expression):
            heights.append(Height(one.lift.at(one.to if k < len(lift) - 1 else TURN)))
        elif one.lift is None:
            heights.append(heights[-1] if heights else None)
        else:
            heights.append(_height(one.lift, f"{name}.lift.{k}", f"l_cam_{index}_{k}"))
    last = next((height for height in reversed(heights) if height), Height(0.0))
    known = [height or last for height in heights]
    ends = [*(float(one.to) for one in lift[:-1]), TURN]
    found = []
    for k, one in enumerate(lift):
        law = one.lift if isinstance(one.lift, Expression) else None if one.lift is None else one.law or "cycloidal"
        start, heights_of = ends[k - 1] if k else 0.0, (known[k - 1], known[k])
        if law is None or isinstance(law, Expression):
            found.append(Piece(start, ends[k], law, *heights_of))
            continue
        parts = LAWS[law]
        places = [start + (ends[k] - start) * part.start for part in parts] + [ends[k]]
        found += [Piece(places[i], places[i + 1], law, *heights_of, i) for i in range(len(parts))]
    return tuple(found)


def _height(value: float, path: str, symbol: str) -> Height:
    return Height(float(value), Parameter(path, symbol, float(value)) if value else None)


def _in_order(lift: Sequence[PieceTable], complain: Complain) -> bool:
    """Whether every piece ends after the one before, the last after a turn, and only rises have a law."""
    fine, before = True, 0.0
    for k, one in enumerate(lift):
        last = k == len(lift) - 1
        if last and abs(one.to - TURN) > MEETS:
            complain(
                ("lift", k, "to"),
                f'found {math.degrees(one.to):.6g} deg, expected "360 deg", because the last piece ends where the '
                "first begins",
            )
            fine = False
        elif not before < one.to < TURN + MEETS:
            complain(
                ("lift", k, "to"),
                f"found {math.degrees(one.to):.6g} deg, expected more than {math.degrees(before):.6g} deg, where the "
                "piece before ends, and less than 360 deg; put the pieces in order",
            )
            fine = False
        if one.law and (one.lift is None or isinstance(one.lift, Expression)):
            what = "rest" if one.lift is None else "expression"
            told = f'found "{one.law}" beside a {what}, expected a lift in m with it; leave it out'
            complain(("lift", k, "law"), told)
            fine = False
        before = one.to
    return fine


ENTRY = Entry("cam", True, CamTable, build, {"clockwise": "sense"})
