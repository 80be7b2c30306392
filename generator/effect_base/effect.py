"""What an effect answers. An effect that a scene does not name is absent from everything that is generated."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from ..mechanism.assembled import Assembled
from ..mechanism.joints import PointRef
from ..mechanism.links import Parameter, Point
from ..mechanism.mechanism import Mechanism
from ..mechanism.meshes import Mesh
from .table import Table

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.gaps import Gap
    from ..derive.motion import Couple, Force, Motion
    from ..derive.terms_of_effects import Let, Told
    from ..derive.vectors import Vector
    from .changing import Changing
    from .expression_of_state import OfState

Contact = tuple[str, PointRef]
"""A point that can touch something: its name in the scene (``joint_3``, ``link_0.A``) and where it sits."""

Plane = tuple[str, Point, Point]
"""A half-plane: its name, a point of its surface, its outward normal."""

Rim = tuple[PointRef, PointRef | None, Parameter | tuple[Parameter, ...] | None]
"""What is drawn of a contact's surface: a disc about a point, or an edge to a second point; its radius (m) or half its
thickness, which may be the sum of several, ``None`` where that is zero."""

Curve = tuple[PointRef, tuple[tuple[float, float], ...]]
"""A closed curve to draw: a point of a link, and places about it in the axes of that link (m)."""

Drawn = tuple[str, tuple[PointRef, ...]]
"""A rope: its name, and the points in whose order it is drawn."""

Part = tuple[str, str, tuple[PointRef, ...], tuple[Parameter | float | None, ...]]
"""What is drawn where an effect acts: the kind, as ``PartData`` of ``generator/package/schema.py`` lists them, the
effect's name, the points, and the numbers of that kind."""

ContactPoint = tuple[str, str, PointRef, Parameter | None]
"""A point or a disc about it: its name, what it touches, where it sits, its radius (m), ``None`` where that is zero."""

Complain = Callable[[tuple[str | int, ...], str], None]
"""Notes a fault of an effect's own table: the key inside the table, and the sentence."""


@dataclass(frozen=True)
class Level:
    """A plane from which heights are measured: a point on it (m) and its unit normal."""

    point: tuple[float, float] = (0.0, 0.0)
    normal: tuple[float, float] = (0.0, 1.0)

    def height(self, x: float, y: float) -> float:
        """Distance of (x, y) from the plane, along its normal (m)."""
        return (x - self.point[0]) * self.normal[0] + (y - self.point[1]) * self.normal[1]


class Rub(NamedTuple):
    """Smoothed dry friction in a ``joint`` (an index): the ``rate`` (rad/s, or m/s along its line) about which it
    changes its sign, what :meth:`Effect.outputs` calls its moment (force), and the friction in proportion to the rate
    that is ``viscous`` in that beside it."""

    joint: int
    rate: Parameter
    told: str
    viscous: Parameter | None = None


class Effect:
    """Something that acts on the mechanism. Records of effects are frozen dataclasses derived from this one."""

    @property
    def title(self) -> str:
        """What it is called where the model is described: its name in the scene, or its kind."""
        return str(getattr(self, "name", "")) or type(self).__name__.lower()

    def parameters(self) -> tuple[Parameter, ...]:
        """The effect's own parameters, each once."""
        return ()

    def over_time(self) -> Mapping[str, Changing]:
        """What its table gives over time, or by the state, by the paths that numbers there would have: none is a
        parameter."""
        return {}

    def defines(self) -> Mapping[str, OfState]:
        """Names that expressions of the state may have, each with what it stands for."""
        return {}

    def describe(self, mechanism: Mechanism) -> str:
        """What ``ccgen show`` says of it behind its title: its parameters, unless it has something better to say."""
        told = [f"{p.path} = {p.value!r}" for p in self.parameters()]
        told += [f"{path} = {value.shown}" for path, value in self.over_time().items() if value.of_state]
        return ", ".join(told) or "no parameters"

    def field(self) -> Vector:
        """Uniform acceleration field (m/s²) as expressions in the parameters' symbols."""
        from ..derive.vectors import ZERO

        return ZERO

    def accelerations(self) -> tuple[Parameter, ...]:
        """Parameters that are the size of such a field (m/s²): they tell the mechanism's characteristic time."""
        return ()

    def inputs(self) -> tuple[str, ...]:
        """Names of inputs that are given at run time."""
        return ()

    def instants(self) -> tuple[Parameter, ...]:
        """Parameters that are times (s) at which a load has a kink: steps of a run end there."""
        return ()

    def kinks(self) -> tuple[tuple[float, float], ...]:
        """The same times where they are no parameters, each with the time (s) after which it comes again, or 0."""
        return ()

    def sides(self) -> tuple[str, ...]:
        """Names of the kinks of its loads: ``motion.side(name)`` is 1 where the kink's switching function is positive,
        else 0. Steps of a run end where that changes its sign. Where loads jump there, the function may not depend on
        velocities that the jump turns back, or no motion would be possible on either side."""
        return ()

    def jumps(self) -> bool:
        """Whether its loads may jump at a kink; derivatives of runs go through those at which none does."""
        return bool(self.sides())

    def switching(self, motion: Motion) -> Sequence[Expr]:
        """The switching functions of :meth:`sides`, of the state, time and inputs."""
        return ()

    def latches(self) -> tuple[tuple[str, str], ...]:
        """Names of values that it holds, each with that of :meth:`sides` whose function sets it when it becomes
        positive: ``motion.latched(name)`` is what :meth:`latching` gave then, until that is so again; before the first
        time, zero within steps. It may stand in loads, power and switching functions."""
        return ()

    def latching(self, motion: Motion) -> Sequence[Expr]:
        """The values of :meth:`latches` where they are set, of the state, time and inputs."""
        return ()

    def reaches(self, motion: Motion) -> Sequence[Vector]:
        """Vectors (m) that its loads have the direction of: loads jump where one comes to zero, and turn fast near it.
        Steps of a run become short there."""
        return ()

    def loads(self, motion: Motion) -> Sequence[Force | Couple]:
        """Forces and moments on links."""
        return ()

    @classmethod
    def has_loads(cls) -> bool:
        """Whether effects of this kind put forces or moments on links."""
        return cls.loads is not Effect.loads

    def rubs(self, mechanism: Mechanism) -> tuple[Rub, ...]:
        """Joints that it resists by smoothed dry friction."""
        return ()

    def at_joints(self) -> tuple[int, ...]:
        """Joints (indices) between whose links it acts: where one of them lets go it is gone there."""
        return ()

    def driven(self) -> tuple[int, ...]:
        """Joints (indices) whose motion the effect prescribes."""
        return ()

    def begins(self) -> tuple[float | None, float]:
        """Position and speed at t = 0 of the joint that the effect drives; a position of ``None`` is left open."""
        return None, 0.0

    def drives(self, motion: Motion) -> Sequence[tuple[int, Expr]]:
        """The driven joints' accelerations (rad/s², or m/s² along their lines)."""
        return ()

    def integrals(self) -> tuple[str, ...]:
        """Names of the integrals over time that its loads need: ``motion.integral(name)`` is one, zero where a run
        begins, and ``motion.integrate(name, value)`` the load by which it grows at the rate ``value``."""
        return ()

    def mesh(self) -> Mesh | None:
        """The row that the effect asks of joints' angles and lengths."""
        return None

    def potential(self, motion: Motion) -> Expr:
        """Potential energy (J) of the loads that have one."""
        import sympy as sp

        return sp.S.Zero

    def power(self, motion: Motion) -> Expr:
        """Power (W) of the loads that have no potential."""
        import sympy as sp

        return sp.S.Zero

    def outputs(self, motion: Motion) -> Sequence[Told]:
        """What runs tell of it by name, ``motor_0.torque``: what is asked, its unit, and the value, of the state, time
        and inputs."""
        return ()

    def gaps(self, let: Let) -> tuple[Gap, ...]:
        """What may touch what; ``let`` names what depends on parameters alone."""
        return ()

    def planes(self) -> tuple[Plane, ...]:
        """Half-planes to be drawn: name, a point of the surface, outward normal."""
        return ()

    def rims(self) -> tuple[Rim, ...]:
        """Discs and edges to be drawn."""
        return ()

    def curves(self) -> tuple[Curve, ...]:
        """Closed curves to be drawn, with the numbers of the scene."""
        return ()

    def ropes(self) -> tuple[Drawn, ...]:
        """Ropes to be drawn."""
        return ()

    def parts(self, mechanism: Mechanism) -> tuple[Part, ...]:
        """What is drawn where it acts, beside surfaces and ropes: the coil of a spring, the arc of a motor."""
        return ()

    def contact_points(self) -> tuple[ContactPoint, ...]:
        """What touches what, in the order of :meth:`gaps`, as far as points or discs do."""
        return ()

    def level(self) -> Level | None:
        """The plane from which a scene's ``height`` is measured, if the effect is one."""
        return None

    def remarks(self) -> tuple[tuple[str, str], ...]:
        """Keys of its table whose values may be meant otherwise than they are understood, each with a sentence."""
        return ()

    def left_out(self) -> Effect | None:
        """What stands in its place in the scene without it, where others name what it :meth:`defines`."""
        return None

    def settled(self, start: Assembled) -> Effect:
        """The effect with what the scene leaves to the ``start``, as the length of a rope or how wheels mesh.

        Where joints let go or take hold, that is the scene's own start, whichever of them are open."""
        return self

    def angles(self) -> tuple[str, ...]:
        """Keys of its table that are angles here, as at a joint that turns, and lengths elsewhere."""
        return ()

    def check_start(self, start: Assembled) -> tuple[str, ...]:
        """What is wrong with the ``start`` as far as this effect is concerned, one sentence each."""
        return ()


@dataclass(frozen=True)
class Surroundings:
    """What an effect may know of its scene: the mechanism, and the points that touch things unless told otherwise."""

    mechanism: Mechanism
    contacts: tuple[Contact, ...]


Turns = Literal["angle", "lowest angle", "highest angle", "moment", "sense", "vector"]
"""What becomes of a key in a part that is turned or mirrored. ``angle``: of the table's joint; the limits of one change
places in a mirror. ``moment``: a moment, or an angular velocity, changes its sign in a mirror. ``sense``: true, or
false as where it is not given, becomes the other in a mirror. ``vector``: [x, y] in the axes of a link, where ``frame``
says that; in fixed axes it stays."""


@dataclass(frozen=True)
class Entry:
    """A kind of effect: the key of its table, whether it is a ``[[key]]``, its schema, and how its record is made.

    ``build(table, index, surroundings, complain)`` gives the record, or ``None`` after having complained. ``turned``
    says which keys are others in a part that is placed turned or mirrored; where it is ``None``, nobody has said so,
    and such a part has to be placed as it is written.
    """

    key: str
    many: bool
    table: type[Table]
    build: Callable[[Any, int, Surroundings, Complain], Effect | None]
    turned: Mapping[str, Turns] | None = None
