"""What a run says by name: ``crank.angle``, ``coupler.tip.vy``, ``hinge.force`` (docs/model.md, "Outputs by name").

A name is that of what it is of, as scenes have it, a dot, and what is asked. Each output is one number at every time.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property, partial
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..model.forces import Motion
from ..model.joint_sides import between, ends_of
from ..model.mass_centres import NAME, mass_centre
from ..model.meshes import mesh_forces, mesh_names
from ..model.numbers import read_names, read_row_of_times
from .in_force import APART, InForce, Numbers, of_contacts
from .motion_at_rows import motion_at_rows
from .record import Record

NEAREST = 6
"""Names that are told beside one that is none."""
OTHER_WORDS: Mapping[str, tuple[str, ...]] = {
    "torque": ("moment",),
    "moment": ("torque",),
    "reaction": ("force",),
    "velocity": ("speed", "angular_velocity", "slide_rate"),
    "omega": ("angular_velocity",),
    "position": ("x", "y", "slide"),
}
"""What somebody may call it who knows other programs: a driven joint's torque is its moment."""


@dataclass(frozen=True)
class Output:
    """One number over time: its ``name``, what ``kind`` of thing it is of, its ``unit``, and its values (n,) at
    :class:`States`; those of impulses want a whole run, a :class:`Sample`. The ``link`` is that which a force or moment
    acts on, where its name does not have it."""

    name: str
    kind: str
    unit: str
    of: Callable[[Any], FloatArray]
    link: str = ""

    @property
    def measure(self) -> str:
        """The unit, and of a force the link that it acts on: ``N on crank``."""
        return f"{self.unit} on {self.link}" if self.link else self.unit


class States(ABC):
    """States (n,) of a model that outputs are read off, each quantity computed once."""

    def __init__(self, model: Any, t: FloatArray, q: FloatArray, u: FloatArray) -> None:
        self.model, self.t, self.q, self.u = model, t, q, u

    @cached_property
    def in_force(self) -> tuple[InForce, Numbers]:
        """The models that are in force at the states, and which of them is at each."""
        return InForce.of_one(self.model), np.zeros(len(self.t), dtype=np.intp)

    def _asked(self, ask: Callable[..., FloatArray], *given: FloatArray) -> FloatArray:
        """What ``ask`` answers for the model in force and those of the ``given`` arrays (n, ...) at its states."""
        models, which = self.in_force
        if len(models.models) == 1:
            return np.asarray(ask(models.models[0], *given))
        return models.told(which, lambda model, rows: ask(model, *(one[rows] for one in given)))

    @cached_property
    def poses(self) -> FloatArray:
        return self._asked(lambda model, q: model.poses(q), self.q)

    @cached_property
    def velocities(self) -> FloatArray:
        return self._asked(lambda model, q, u: model.velocities(q, u), self.q, self.u)

    @property
    @abstractmethod
    def motion(self) -> Motion:
        """Accelerations and forces there."""

    @cached_property
    def angular_accelerations(self) -> FloatArray:
        """Of the links (n, links): angles are sums of coordinates, so that their rates are linear in u by numbers that
        do not change."""
        u_dot = np.nan_to_num(self.motion.u_dot)
        found = self._asked(lambda model, q, u_dot: model.velocities(q, u_dot)[..., 2], self.q, u_dot)
        return np.asarray(found + self._unknown[:, None])

    @cached_property
    def energies(self) -> tuple[FloatArray, FloatArray]:
        both = self._asked(lambda model, q, u: np.stack(model.energy(q, u), axis=-1), self.q, self.u)
        return both[:, 0], both[:, 1]

    @cached_property
    def closure(self) -> FloatArray:
        """The gaps of the cut joints (n, rows)."""
        return self._asked(lambda model, q: model.closure(q), self.q)

    @cached_property
    def gaps(self) -> FloatArray:
        """Of the contacts (n, contacts); not numbers of those that are off."""
        return self._asked(lambda model, q: of_contacts(model, model.gaps(q)), self.q)

    @cached_property
    def gap_rates(self) -> FloatArray:
        return self._asked(lambda model, q, u: of_contacts(model, model.gap_rates(q, u)), self.q, self.u)

    @cached_property
    def _unknown(self) -> FloatArray:
        """(n,): 0 where accelerations are known, else not a number."""
        return np.where(np.isfinite(self.motion.u_dot).all(axis=1), 0.0, np.nan)

    def place(self, point: str) -> FloatArray:
        return self._asked(lambda model, q: model.point(point, q), self.q)

    def velocity(self, point: str) -> FloatArray:
        return self._asked(lambda model, q, u: model.point_velocity(point, q, u), self.q, self.u)

    def acceleration(self, point: str) -> FloatArray:
        def ask(model: Any, q: FloatArray, u: FloatArray, u_dot: FloatArray) -> FloatArray:
            return np.asarray(model.point_acceleration(point, q, u, u_dot=u_dot))

        found = self._asked(ask, self.q, self.u, np.nan_to_num(self.motion.u_dot))
        return np.asarray(found + self._unknown[:, None])

    @cached_property
    def slides(self) -> dict[str, FloatArray]:
        """How far every joint that slides is along its line (n,)."""
        joints = self.model.slides(self.q[:1])
        return {joint: self._asked(lambda model, q, joint=joint: model.slides(q)[joint], self.q) for joint in joints}

    def slide(self, joint: str) -> tuple[FloatArray, FloatArray]:
        """How far a joint is along its line (n,), and how fast that changes."""

        def ask(model: Any, poses: FloatArray, velocities: FloatArray) -> FloatArray:
            return np.stack(ends_of(model, joint).along(poses, velocities), axis=-1)

        both = self._asked(ask, self.poses, self.velocities)
        return both[:, 0], both[:, 1]

    def line(self, joint: str) -> FloatArray:
        """The direction (n, 2) of a joint's line."""
        return self._asked(lambda model, poses: ends_of(model, joint).direction(poses), self.poses)


class Sample(States):
    """A run at all its rows, or at times t (n,) of it."""

    def __init__(self, run: Record, t: FloatArray | None) -> None:
        super().__init__(run.model, run.t if t is None else t, *((run.q, run.u) if t is None else run.at(t)))
        self.run, self.given = run, t

    @cached_property
    def in_force(self) -> tuple[InForce, Numbers]:
        models = self.run.in_force
        return models, models.at_rows(len(self.t)) if self.given is None else models.at(self.t)

    @cached_property
    def motion(self) -> Motion:
        if self.given is None:
            return motion_at_rows(self.run)
        if self.run.motion is None:
            raise ValueError("this run knows no forces: it was not made by simulate")
        return self.run.motion(self.t, self.q, self.u)


_listed: WeakKeyDictionary[Any, tuple[list[bool], dict[str, Output]]] = WeakKeyDictionary()
"""Of models their outputs, and which of their links had a mass when these were listed: values may be set since."""


def outputs_of(model: Any) -> Mapping[str, Output]:
    """All outputs of a model's runs by their names. What would be two things by one name has the kind of each before
    it: ``link crank.angle``, ``joint crank.angle``."""
    weighed = [mass_centre(model, link) is not None for link in model.links]
    known = _listed.get(model)
    if known is None or known[0] != weighed:
        _listed[model] = known = weighed, _list(model)
    return known[1]


def _list(model: Any) -> dict[str, Output]:
    found: dict[str, list[Output]] = {}
    for output in _every(model):
        found.setdefault(output.name, []).append(output)
    return {name if len(same) == 1 else f"{one.kind} {name}": one for name, same in found.items() for one in same}


def named_outputs(model: Any, names: Iterable[str]) -> dict[str, Output]:
    """Those of these names; where none is asked for, the list of all is not made, which takes as long as thousands of
    short runs. Raises ``KeyError`` for a name that none has."""
    asked = list(names)
    known = outputs_of(model) if asked else {}
    return {name: known[name] for name in asked}


def units_of(model: Any) -> dict[str, str]:
    """The unit of every output, by name."""
    return {name: output.unit for name, output in outputs_of(model).items()}


def headings_of(model: Any) -> dict[str, str]:
    """What stands over a column of every output, by name: the name, its unit, and of a force the link it acts on."""
    return {name: f"{name} [{output.measure}]" for name, output in outputs_of(model).items()}


def outputs_text(model: Any) -> str:
    """A line for everything that outputs are of: its name, and what is asked of it, with units, and of forces the link
    that they act on."""
    owners: dict[str, list[str]] = {}
    for name, output in outputs_of(model).items():
        owner, _, asked = name.rpartition(".")
        owners.setdefault(owner, []).append(f"{asked} [{output.measure}]")
    return "\n".join(f"{owner + ': ' if owner else ''}{', '.join(asked)}" for owner, asked in owners.items())


def values_of(run: Record, names: Sequence[str], t: ArrayLike | None = None) -> dict[str, FloatArray]:
    """Outputs by name at the times t (s), a number or a row of them, or at the rows of the run, those before impacts as
    before them. Not numbers where the run knows none.

    Raises ``ValueError`` with all names that are none, and what is near them, and for times outside of the run.
    """
    names, known = read_names(names, "names", "outputs"), outputs_of(run.model)
    if not known.keys() >= set(names):
        raise ValueError("; ".join(f"output: {one}" for one in unknown(run.model, names)))
    sample = Sample(run, None if t is None else read_row_of_times(t, run.t.dtype))
    found = {name: np.asarray(known[name].of(sample)) for name in names}
    return found if t is None or np.ndim(t) else {name: value[0] for name, value in found.items()}


def points_among(model: Any, names: Sequence[str]) -> list[str]:
    """Those of the names that are no output themselves, but have a place, ``NAME.x`` and ``NAME.y``."""
    known = outputs_of(model)
    return [name for name in names if name not in known and {f"{name}.x", f"{name}.y"} <= known.keys()]


def with_places(model: Any, names: Sequence[str]) -> list[str]:
    """The names, once each, with x and y in the place of what is a point."""
    points = points_among(model, names)
    each = [[f"{name}.x", f"{name}.y"] if name in points else [name] for name in names]
    return list(dict.fromkeys(name for some in each for name in some))


def unknown(model: Any, names: Sequence[str]) -> list[str]:
    """A sentence for each of the names that no output has."""
    known = outputs_of(model)
    every = f"Run.outputs and ccgen show --outputs have all {len(known)}"
    return [unknown_name(name, known, every) for name in names if name not in known]


def unknown_name(name: str, known: Collection[str], every: str) -> str:
    """What is wrong with a name that is none of these; ``every`` says where all are to be found."""
    twice = [one for one in known if one.endswith(f" {name}")]
    if twice:
        return f"found {name!r}, which is of two things, expected {' or '.join(map(repr, twice))}"
    owner, _, word = name.rpartition(".")
    same = [one for one in known if one.rpartition(".")[0] == owner] if owner else []
    meant = [one for one in known if one.rpartition(".")[2] in (word, *OTHER_WORDS.get(word, ()))]
    own = [one for one in meant if one in same]
    near = own or get_close_matches(name, known, NEAREST, 0.5) or (same or meant)[:NEAREST]
    beside = f", expected one such as {', '.join(near)}" if near else ", expected the name of an output"
    return f"found {name!r}, which nothing is called{beside}; {every}"


def _every(model: Any) -> Iterator[Output]:
    """Every output of a model."""
    yield Output("t", "time", "s", lambda sample: sample.t)
    for name, part in (("kinetic_energy", 0), ("potential_energy", 1)):
        yield Output(name, "mechanism", "J", partial(_energy, part=part))
    yield Output("energy", "mechanism", "J", lambda sample: sample.energies[0] + sample.energies[1])
    for number, link in enumerate(model.links[: len(model.outlines)]):
        yield from _of_link(link, number)
    joints = model.drawn_joints
    welded = model.data["welded_points"]
    for point in (*model.points, *welded):
        if (point in joints or "." in point) and point not in welded.values():
            yield from _of_point(point, "point" if "." in point else "joint")
    for link in model.links[: len(model.outlines)]:
        if (point := f"{link}.{NAME}") not in (*model.points, *welded) and mass_centre(model, link):
            yield from _of_point(point, "mass centre")
    turns = model.joint_angles(np.zeros(len(model.q_names)))
    for joint in joints:
        yield from _of_joint(model, joint, joint in turns)
    for number, (point, ground) in enumerate(model.contacts):
        rubs = ground not in model.stops | model.slide_ends
        yield from _of_contact(f"{ground}.{point}", number, ground in model.stops, rubs)
    for number, (name, unit) in enumerate(model.told):
        yield Output(name, "effect", unit, partial(_told, number=number), model.told_links.get(name, ""))
    for number, mesh in enumerate(mesh_names(model)):
        yield Output(f"{mesh}.force", "mesh", "N", partial(_mesh, number=number))


def _of_link(link: str, number: int) -> Iterator[Output]:
    yield Output(f"{link}.angle", "link", "rad", lambda sample: sample.poses[:, number, 2])
    yield Output(f"{link}.angular_velocity", "link", "rad/s", lambda sample: sample.velocities[:, number, 2])
    yield Output(
        f"{link}.angular_acceleration", "link", "rad/s^2", lambda sample: sample.angular_accelerations[:, number]
    )


def _of_point(point: str, kind: str) -> Iterator[Output]:
    for sign, unit, what in (("", "m", "place"), ("v", "m/s", "velocity"), ("a", "m/s^2", "acceleration")):
        for axis, letter in enumerate("xy"):
            of = partial(_part, what=what, point=point, axis=axis)
            yield Output(f"{point}.{sign}{letter}", kind, unit, of)
    yield Output(f"{point}.speed", kind, "m/s", lambda sample: np.hypot(*sample.velocity(point).T))


def _of_joint(model: Any, joint: str, turns: bool) -> Iterator[Output]:
    if slides(model, joint):
        for name, unit, part in (("slide", "m", 0), ("slide_rate", "m/s", 1)):
            yield Output(f"{joint}.{name}", "joint", unit, partial(_slide, joint=joint, part=part))
    if turns:
        for name, unit, what in (
            ("angle", "rad", "poses"),
            ("angular_velocity", "rad/s", "velocities"),
            ("angular_acceleration", "rad/s^2", "angular_accelerations"),
        ):
            yield Output(f"{joint}.{name}", "joint", unit, partial(_turn, joint=joint, what=what))
    number = list(model.joints).index(joint)
    yield Output(f"{joint}.force", "joint", "N", lambda sample: np.hypot(*sample.motion.reactions[:, number, :2].T))
    for part, (name, unit) in enumerate((("fx", "N"), ("fy", "N"), ("moment", "N m"))):
        of = partial(_reaction, number=number, part=part)
        yield Output(f"{joint}.{name}", "joint", unit, of, model.second_links[number])
    if joint in driven_joints(model):
        yield Output(f"{joint}.power", "joint", "W", partial(drive_power, joint=joint))
    if model.contacts:
        yield Output(f"{joint}.impulse", "joint", "N s", partial(_joint_impulse, number=number))


def _of_contact(name: str, number: int, stops: bool, rubs: bool) -> Iterator[Output]:
    angle = "rad" if stops else "m"
    yield Output(f"{name}.gap", "contact", angle, lambda sample: sample.gaps[:, number])
    yield Output(
        f"{name}.gap_rate",
        "contact",
        f"{angle}/s",
        lambda sample: sample.gap_rates[:, number],
    )
    for part, push in enumerate(("moment",) if stops else ("normal", "friction")[: 1 + rubs]):
        yield Output(f"{name}.{push}", "contact", "N m" if stops else "N", partial(_push, number=number, part=part))
    for part, push in enumerate(("impulse", "friction_impulse")[: 1 + rubs]):
        of = partial(_impulse, number=number, part=part)
        yield Output(f"{name}.{push}", "contact", "N m s" if stops else "N s", of)


def _energy(sample: States, part: int) -> FloatArray:
    return sample.energies[part]


def _part(sample: States, what: str, point: str, axis: int) -> FloatArray:
    found: FloatArray = getattr(sample, what)(point)
    return found[:, axis]


def _slide(sample: States, joint: str, part: int) -> FloatArray:
    return sample.slide(joint)[part]


def _turn(sample: States, joint: str, what: str) -> FloatArray:
    """Of the joint's second link less of its first, the ground's being zero."""
    found = getattr(sample, what)
    of_links = found if found.ndim == 2 else found[:, :, 2]
    one, other = (of_links[:, link] if link >= 0 else np.zeros(len(of_links)) for link in between(sample.model, joint))
    return np.asarray(other - one)


def _reaction(sample: States, number: int, part: int) -> FloatArray:
    return sample.motion.reactions[:, number, part]


def _push(sample: States, number: int, part: int) -> FloatArray:
    return sample.motion.pushes[:, number, part]


def drive_effort(sample: States, joint: str) -> FloatArray:
    """What the drive of a joint does to its second link (n,): a torque (N m), or a force along its line (N)."""
    reaction = sample.motion.reactions[:, list(sample.model.joints).index(joint)]
    if not slides(sample.model, joint):
        return reaction[:, 2]
    return np.asarray(np.sum(reaction[:, :2] * sample.line(joint), axis=1))


def drive_power(sample: States, joint: str) -> FloatArray:
    """What it gives the mechanism (n,), in W."""
    rate = sample.slide(joint)[1] if slides(sample.model, joint) else _turn(sample, joint, "velocities")
    return np.asarray(drive_effort(sample, joint) * rate)


def driven_joints(model: Any) -> list[str]:
    """Of each ``[[drive]]`` its joint."""
    return [drive["joint"] for drive in model.data["drives"]]


def slides(model: Any, joint: str) -> bool:
    """Whether a joint has a line."""
    return joint in model.slides(np.zeros(len(model.q_names)))


def _impulse(sample: Sample, number: int, part: int) -> FloatArray:
    contact = sample.model.contacts[number]
    shares = []
    for impact in sample.run.impacts:
        given = (impact.impulses, impact.friction)[part]
        shares.append(
            float(given[impact.contacts.index(contact)]) if contact in impact.contacts and given.size else 0.0
        )
    return _at_impacts(sample, shares)


def _joint_impulse(sample: Sample, number: int) -> FloatArray:
    """Impacts whose impulses are unknown have none that is a number."""
    parts = [impact.reactions for impact in sample.run.impacts]
    known = len(sample.model.joints), 3
    return _at_impacts(sample, [float(np.hypot(*one[number, :2])) if one.shape == known else np.nan for one in parts])


def _at_impacts(sample: Sample, values: Sequence[float]) -> FloatArray:
    """Zero but at impacts: there the sum of their ``values``, in the row after the last one of an instant."""
    t = sample.t
    found = np.zeros(len(t), dtype=t.dtype)
    for impact, value in zip(sample.run.impacts, values, strict=True):
        if sample.given is not None:
            found[t == impact.t] += value
        else:
            found[int(np.searchsorted(t, impact.t, side="right")) - 1] += value
    return found


def _told(sample: States, number: int) -> FloatArray:
    """What an effect tells, zeros without a sign; not numbers of a length of what is off."""
    found = sample.motion.told[:, number]
    return np.where(found == APART, np.nan, found + 0.0)


def _mesh(sample: States, number: int) -> FloatArray:
    return mesh_forces(sample.model, sample.motion.multipliers)[:, number]
