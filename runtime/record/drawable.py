"""What a model must offer to be recorded and drawn; nothing else of it is used there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from ..arrays import FloatArray
from ..model.disc import Disc
from ..model.part import Part
from ..model.rope import Rope


class Drawable(Protocol):
    """A model as the record and the pictures see it; states may be single or a batch with a leading axis."""

    @property
    def name(self) -> str: ...
    @property
    def links(self) -> Sequence[str]: ...
    @property
    def joints(self) -> Sequence[str]: ...
    @property
    def second_links(self) -> Sequence[str]:
        """Of each joint the link that its force is on, the second of its ``between``."""

    @property
    def q_names(self) -> Sequence[str]: ...
    @property
    def q_of(self) -> Sequence[str]:
        """What each coordinate is: ``crank.angle``."""

    @property
    def u_names(self) -> Sequence[str]: ...
    @property
    def parameters(self) -> Mapping[str, float]: ...
    @property
    def rows(self) -> Sequence[str]:
        """Names of the closure rows."""

    @property
    def contacts(self) -> Sequence[tuple[str, str]]:
        """(point, ground) names of every contact that is watched."""

    @property
    def off_contacts(self) -> Sequence[tuple[str, str]]:
        """Those of ``contacts`` whose effects are off."""

    @property
    def told(self) -> Sequence[tuple[str, str]]:
        """(name, unit) of every number that effects tell along runs."""

    @property
    def told_links(self) -> Mapping[str, str]:
        """The link that forces among these act on, by their names."""

    @property
    def slide_ends(self) -> frozenset[str]:
        """Second names of those that stop joints along their lines."""

    @property
    def stops(self) -> frozenset[str]:
        """Second names of those contacts that are stops: their gaps are angles."""

    @property
    def outlines(self) -> Sequence[FloatArray]:
        """For each link that pictures show its drawn points (m, 2) in the link's frame: the first of the links."""

    @property
    def discs(self) -> Sequence[Disc]:
        """Discs and edges of links, and of the ground, that touch something."""

    @property
    def ropes(self) -> Sequence[Rope]:
        """Ropes between points of links, and of the ground."""

    @property
    def parts(self) -> Sequence[Part]:
        """What is drawn where effects act, and of joints that slide."""

    @property
    def drawn_joints(self) -> Sequence[str]:
        """The joints that pictures show."""

    @property
    def drawn_ground_points(self) -> FloatArray:
        """The points (k, 2) of the ground link that pictures show."""

    def ground_planes(self) -> Mapping[str, tuple[FloatArray, FloatArray]]:
        """For each ground a point of its surface and the unit normal, both (2,)."""

    def poses(self, q: FloatArray, /) -> FloatArray:
        """(..., links, 3): x, y of each link's frame and its angle."""

    def point(self, name: str, q: FloatArray, /) -> FloatArray:
        """(..., 2): where a joint or a link's point is."""

    def point_velocity(self, name: str, q: FloatArray, u: FloatArray, /) -> FloatArray:
        """(..., 2): its velocity, m/s."""

    def point_acceleration(self, name: str, q: FloatArray, u: FloatArray, /, *, u_dot: FloatArray) -> FloatArray:
        """(..., 2): its acceleration, m/s², where the mechanism has ``u_dot``."""

    def joint_angles(self, q: FloatArray, /) -> Mapping[str, FloatArray]:
        """For each joint that turns (...): the angle of its second link against its first, rad."""

    def gaps(self, q: FloatArray, /) -> FloatArray:
        """(..., contacts): gap of every contact, m; of a stop, rad."""

    def slides(self, q: FloatArray, /) -> Mapping[str, FloatArray]:
        """For each sliding joint (...): how far it is along its line, m."""

    def energy(self, q: FloatArray, u: FloatArray, /) -> tuple[FloatArray, FloatArray]:
        """(kinetic, potential), each (...)."""

    def closure(self, q: FloatArray, /) -> FloatArray:
        """(..., rows): the gaps of the cut joints."""
