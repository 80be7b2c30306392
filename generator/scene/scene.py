"""The record that a scene becomes: everything that decides a generated model, checked and consistent."""

from __future__ import annotations

import copy
import dataclasses
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeVar

from ..effect_base.contact import LAWS, Law, OnGain
from ..effect_base.effect import Effect
from ..effect_base.expression_of_state import OfState
from ..effect_base.grammar_of_state import laws_in
from ..mechanism.integrators import without_integrators
from ..mechanism.links import Parameter
from ..mechanism.mechanism import Mechanism
from .changes import Change
from .drawn import Anchor
from .events import Event
from .toml_text import toml_text

Triple = tuple[float, float, float]
T = TypeVar("T")
ON, HELD = ".on", ".held"
"""Behind the name of an effect in that of its gate, and behind that of a joint."""


@dataclass(frozen=True)
class Given:
    """What a scene itself says of the start in numbers: links whose angles and whose angular velocities it gives, and
    which of the sliding joints, in scene order, whose lengths and whose rates."""

    angles: tuple[int, ...] = ()
    rates: tuple[int, ...] = ()
    slides: tuple[int, ...] = ()
    sliding: tuple[int, ...] = ()


@dataclass(frozen=True)
class Sketch:
    """What a scene asks of the start, defaults filled in, and what of it is ``given`` rather than filled in or drawn.

    ``angles``: absolute angle of each link (rad), tilt included. ``rates``: angular velocity of each link (rad/s), or
    ``None`` where it is left open. ``position`` (m) and ``velocity`` (m/s) of the first link's frame, ``height`` (m) of
    the lowest joint instead of a position. ``slides`` (m) and ``sliding`` (m/s) are lengths along the lines of the
    sliding joints in scene order, and their rates, ``None`` where left open. ``loose``: links about whose angle nothing
    is said although something is about others. ``drawn``: where points of links are drawn.
    """

    angles: tuple[float, ...]
    rates: tuple[float | None, ...]
    position: tuple[float, float] = (0.0, 0.0)
    velocity: tuple[float, float] = (0.0, 0.0)
    height: float | None = None
    slides: tuple[float | None, ...] = ()
    sliding: tuple[float | None, ...] = ()
    loose: tuple[int, ...] = ()
    drawn: tuple[Anchor, ...] = ()
    given: Given = Given()


Kept = tuple[str, int]
"""The ``"angle"`` of a link, or the ``"slide"`` of a joint."""


@dataclass(frozen=True)
class Moved:
    """Joint ``joint`` is driven, and ``key`` of ``[start]`` gives ``of`` (a link, or the joint) what it does not have
    there: ``given``, ``got`` (rad or m). ``placed``: its drive says where it is; else the loops do not close so."""

    joint: str
    key: str
    of: str
    given: float
    got: float
    placed: bool


@dataclass(frozen=True)
class Start:
    """A consistent start: every loop is closed and stays closed.

    ``poses``: x, y (m) and angle (rad) of each link's frame; ``velocities``: their rates. ``turned`` are the links
    whose angles closing the loops changed, and by how much (rad), the largest change first; none when ``sketch`` was
    closed to 1e-9 m. ``slid`` are the same of lengths along lines (m), by joints. Links and lengths of which nothing
    was said are left out. ``missed_by`` is the largest distance (m) of a joint or frame from
    where it was drawn. ``kept_places`` and ``kept_rates`` are angles and lengths, and those whose rates, that stay as
    the scene gives them where loops are closed with other values of parameters: all that are given, if the loops leave
    them all free. ``wanted`` are the displacements of the sketch, angles (rad) and lengths in units of ``unit`` (m),
    where the start is the nearest to these with other values too; empty where it is found in another way.
    ``sketched_rates``: more rates are given than can be kept, so that none of them is; ``free_rates``: some are left
    free, and are the smallest. ``kept_drives`` are the drives, by number, whose joints stay as ``[start]`` gives them;
    ``moved`` tells of driven joints that could not.
    """

    poses: tuple[Triple, ...]
    velocities: tuple[Triple, ...]
    sketch: Sketch
    turned: tuple[tuple[str, float], ...] = ()
    slid: tuple[tuple[str, float], ...] = ()
    missed_by: float = 0.0
    kept_places: tuple[Kept, ...] = ()
    kept_rates: tuple[Kept, ...] = ()
    wanted: tuple[float, ...] = ()
    unit: float = 1.0
    sketched_rates: bool = False
    free_rates: bool = False
    kept_drives: tuple[int, ...] = ()
    moved: tuple[Moved, ...] = ()

    @property
    def assembled_by(self) -> float:
        """The largest change of an angle (rad), 0 where there is none."""
        return self.turned[0][1] if self.turned else 0.0

    @property
    def slid_by(self) -> float:
        """The largest change of a length (m), 0 where there is none."""
        return self.slid[0][1] if self.slid else 0.0


@dataclass(frozen=True)
class RunSettings:
    """How long and how exactly a simulation runs unless told otherwise: s, relative and absolute tolerance, and what
    becomes of impacts that would gain energy. ``law`` is that of all impacts, which no option of a run changes."""

    until: float = 10.0
    rtol: float = 1e-9
    atol: float | None = None
    on_gain: OnGain = "reduce"
    law: Law = LAWS[0]


@dataclass(frozen=True)
class Asked:
    """What a run's command draws and writes of it, by names of outputs: as a ``plot``, as a ``table``, that at so many
    even ``times`` or, where this is None, at the rows of the run."""

    plot: tuple[str, ...] = ()
    table: tuple[str, ...] = ()
    times: int | None = None


class ValueOfEvent(NamedTuple):
    """What an event, or behind all events a change, by its number, sets the parameter of a ``path`` to."""

    event: int
    path: str
    value: float | str


@dataclass(frozen=True)
class Scene:
    """A mechanism, what acts on it, where it starts and how it is run.

    ``name`` is as written (``falling-hexagon``), ``package`` the name of the generated package (``falling_hexagon``).
    ``output`` is what is looked at of a run, which changes no model. ``remarks`` say how values are understood that may
    be meant otherwise, one sentence each; they change nothing.
    ``changes`` are joints that let go and take hold, which have gates in the mechanism. ``events`` are instants of a
    run that are asked for. ``gates`` are, for each of the effects, the parameter that is 1 while it acts and 0 while it
    is off, or ``None`` where no event switches it; no gates where none is switched. ``everywhere`` says of each of them
    whether it has all contacts that there are, where joints let go or take hold.
    ``keys_of_effects`` are the keys of the effects' tables, ``worked_out`` the links whose inertia follows from what
    they are made of.
    """

    name: str
    mechanism: Mechanism
    effects: tuple[Effect, ...]
    start: Start
    run: RunSettings
    output: Asked = field(default=Asked(), compare=False)
    remarks: tuple[str, ...] = field(default=(), compare=False)
    changes: tuple[Change, ...] = ()
    events: tuple[Event, ...] = ()
    gates: tuple[Parameter | None, ...] = ()
    everywhere: tuple[bool, ...] = ()
    keys_of_effects: tuple[str, ...] = field(default=(), compare=False)
    worked_out: tuple[str, ...] = field(default=(), compare=False)
    _tables: Mapping[str, Any] | None = field(default=None, init=False, compare=False, repr=False)
    """What it was read from; a scene that is made from another by ``dataclasses.replace`` has none."""

    @property
    def package(self) -> str:
        return self.name.replace("-", "_")

    def written_as(self, tables: Mapping[str, Any]) -> Scene:
        """The same scene, which knows the tables that it was read from."""
        found = dataclasses.replace(self)
        object.__setattr__(found, "_tables", tables)
        return found

    def to_dict(self) -> dict[str, Any]:
        """The tables that the scene was read from, as ``load_scene`` takes them: dicts, lists, numbers and texts.

        Texts with units and arithmetic, names and parts are as they were written, and what was left to its default is
        left out; only the name is always there. Raises ``ValueError`` for a scene that was changed after it was read.
        """
        if self._tables is None:
            raise ValueError(
                f"{self.name}: found a scene that was changed after it was read, expected one as it was "
                "read; change its tables, and read them with load_scene"
            )
        return copy.deepcopy(dict(self._tables))

    def to_toml(self) -> str:
        """The text of a scene file with the tables of :meth:`to_dict`, which reads back to the same scene."""
        return toml_text(self.to_dict())

    def without(self, effect: int) -> Scene:
        """The scene as it would be had it never named the effect of this index, starting where this one starts.

        A height is measured from a ground that may be gone then, so the start keeps the position it came to.
        """
        own, named = self.effects[effect].defines(), self._named_laws()
        rest = self.effects[effect].left_out() if named & own.keys() else None
        if rest is not None:
            return dataclasses.replace(self, effects=(*self.effects[:effect], rest, *self.effects[effect + 1 :]))
        effects = tuple(e for index, e in enumerate(self.effects) if index != effect)
        keys = tuple(key for index, key in enumerate(self.keys_of_effects) if index != effect)
        sketch = self.start.sketch
        if sketch.height is not None:
            sketch = dataclasses.replace(sketch, height=None, position=self.start.poses[0][:2])
        meshes = tuple(mesh for effect in effects if (mesh := effect.mesh()))
        mechanism, links = without_integrators(self.mechanism, self.effects[effect].integrals())
        sketch = dataclasses.replace(sketch, angles=_of(links, sketch.angles), rates=_of(links, sketch.rates))
        mechanism = dataclasses.replace(mechanism, meshes=meshes)
        poses, velocities = _of(links, self.start.poses), _of(links, self.start.velocities)
        start = dataclasses.replace(self.start, poses=poses, velocities=velocities, sketch=sketch)
        gates = tuple(gate for index, gate in enumerate(self.gates) if index != effect)
        everywhere = tuple(whole for index, whole in enumerate(self.everywhere) if index != effect)
        return dataclasses.replace(
            self,
            mechanism=mechanism,
            effects=effects,
            start=start,
            keys_of_effects=keys,
            gates=gates,
            everywhere=everywhere,
        )

    def _named_laws(self) -> set[str]:
        """The laws that effects and events name."""
        values = [
            value for effect in self.effects for value in (*effect.defines().values(), *effect.over_time().values())
        ]
        forms = [value.text for value in values if isinstance(value, OfState)]
        for event in self.events:
            forms += [event.when, *(value for _, value in event.set if isinstance(value, str))]
        return {name for form in forms for name in laws_in(form)}

    @property
    def off(self) -> tuple[str, ...]:
        """Names of the effects that are off at the start."""
        return tuple(gate.path.removesuffix(ON) for gate in self.gates if gate and not gate.value)

    def gate(self, effect: int) -> Parameter | None:
        """The gate of the effect of this index."""
        return self.gates[effect] if self.gates else None

    def parameters(self) -> Iterator[Parameter]:
        """All parameters, in the order in which models have them."""
        yield from self.mechanism.parameters()
        for index, effect in enumerate(self.effects):
            yield from effect.parameters()
            gate = self.gate(index)
            if gate:
                yield gate

    @property
    def driven(self) -> tuple[int, ...]:
        """Joints whose motion an effect prescribes."""
        return tuple(joint for effect in self.effects for joint in effect.driven())

    @property
    def indicators(self) -> tuple[tuple[str | Change, int], ...]:
        """What a compiled model looks for: the expressions of its events, each with 1 where its rises are events, -1
        where its falls are, 0 where both are, and behind them its changes, which come with rises."""
        signs = {"rising": 1, "falling": -1, "either": 0}
        found: list[tuple[str | Change, int]] = [(one.when, signs[one.direction]) for one in self.events]
        return (*found, *((one, 1) for one in self.changes))

    @property
    def values_of_events(self) -> tuple[ValueOfEvent, ...]:
        """What indicators set in a compiled model, in their order: gates of effects last of each event."""
        found = []
        for number, event in enumerate(self.events):
            switched = dict.fromkeys(event.on, 1.0) | dict.fromkeys(event.off, 0.0)
            every = (*event.set, *((f"{name}{ON}", value) for name, value in switched.items()))
            found += [ValueOfEvent(number, path, value) for path, value in every]
        for number, change in enumerate(self.changes, len(self.events)):
            found.append(ValueOfEvent(number, f"{change.joint}{HELD}", float(change.kind == "hold")))
        return tuple(found)

    def canonical(self) -> str:
        """Text that is the same for scenes that generate the same model, and only for those.

        The start enters as it was asked for, because the digits of an assembled one depend on the machine.
        """
        parts: dict[str, object] = {
            "name": self.name,
            "mechanism": self.mechanism,
            "effects": self.effects,
            "start": self.start.sketch,
            "run": self.run,
        }
        if self.changes:
            parts |= {"changes": self.changes, "everywhere": self.everywhere}
        if self.events:
            parts["events"] = self.events
        if self.gates:
            parts["gates"] = self.gates
        if self.mechanism.outlines:
            parts["outlines"] = self.mechanism.outlines
        plain = {key: _plain(value) for key, value in parts.items()}
        return json.dumps(plain, sort_keys=True, allow_nan=False, separators=(",", ":"))


def _of(numbers: tuple[int, ...], values: tuple[T, ...]) -> tuple[T, ...]:
    return tuple(values[number] for number in numbers)


def _plain(value: object) -> object:
    """Records as JSON values, fields that are compared; mappings keep their order, as pairs; minus zero is zero."""
    if dataclasses.is_dataclass(value):
        own = [field.name for field in dataclasses.fields(value) if field.compare]
        fields = {name: _plain(getattr(value, name)) for name in own}
        return {"record": type(value).__name__, **fields}
    if isinstance(value, Mapping):
        return [[key, _plain(item)] for key, item in value.items()]
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return value + 0.0 if isinstance(value, float) else value
