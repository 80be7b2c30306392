"""A generated model's compiled code with values of its parameters, and what it may be asked: names, sizes, kernels."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from threading import RLock
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..faults import Faults
from ..precision import core_of
from .disc import Disc
from .inputs import Values, read_values
from .numbers import read_numbers, told
from .parameters import Parameters
from .part import Part
from .rope import Rope
from .samples import ROUNDING, samples
from .tolerances import check_angles, largest_angle

if TYPE_CHECKING:
    from .._core import Kernels


EARTH = 9.81
"""With π² in its place the characteristic time would be half a swing to the last digit; it is 0.3 % less."""
FALLS = 1e3
"""Gravity under which that takes longer than this, times the scene's duration, tells no time: in the
duration it moves nothing by five millionths of the mechanism's length."""


class Compiled:
    """What the other modules here compute with: a model's data, parameters and kernels, and the checks of states.

    Names that begin with an underscore are for the modules of the runtime, not for users of a model.
    """

    def __init__(
        self,
        descriptor: object,
        data: Mapping[str, Any],
        values: Mapping[str, float] | None = None,
        folder: Path | None = None,
    ) -> None:
        self._descriptor, self.data, self.folder = descriptor, data, folder
        self.name: str = data["name"]
        self.links = tuple(data["links"])
        self.joints = tuple(data["joints"])
        self.grounds = tuple(plane["name"] for plane in data["grounds"])
        self.stops = frozenset(data["stops"])
        self.slide_ends = frozenset(data.get("slide_ends", ()))
        self.pieces_of_time: dict[tuple[float, tuple[float, ...]], list[float]] = {}
        self.told = tuple((name, unit) for name, unit in data["outputs"])
        self.told_links: Mapping[str, str] = data["output_links"]
        self.points = tuple(data["points"])
        self.q_names = tuple(data["q_names"])
        self.q_of = tuple(self._named(kind, of) for kind, of in data["coordinates"])
        self.u_names = tuple(data["u_names"])
        self.inputs = tuple(data["inputs"])
        self.angular = tuple(index for index, (kind, _) in enumerate(data["coordinates"]) if kind == "angle")
        self.cuts = tuple(data["cuts"])
        self.rows = tuple(data["rows"])
        self.second_links = tuple("ground" if k < 0 else self.links[k] for _, k in data["between"])
        self.root: str = data["root"]
        self.folded: bool = data["folded"]
        self.precision: str = data["precision"]
        self.core = core_of(self.precision)
        self.contacts: tuple[tuple[str, str], ...] = tuple((point, ground) for point, ground in data["contacts"])
        self._changes = 0
        self._asked = RLock()
        self._inputs = np.zeros(len(self.inputs))
        folded = self.name if self.folded else ""
        self.gates: Mapping[str, str] = {one["effect"]: one["parameter"] for one in data.get("gates", ())}
        ends = (data.get("switching") or {}).get("ends", {})
        self.joint_gates: Mapping[str, str] = {joint: one["gate"] for joint, one in ends.items()}
        self.all_gates = (*self.joint_gates.values(), *self.gates.values())
        own = data["parameters"], dict(values or {}), self._rebuild, folded
        loads = {one["name"]: one["laws"] for one in data.get("of_state", ()) if one["load"]}
        self._parameters = Parameters(*own, data["rests_on"], data.get("over_time", {}), self.all_gates, loads)
        self._rebuild()
        if self.kernels.hash != data["hash"]:
            raise ImportError(f"the code and the data of {self.name} are of different scenes; generate the model again")

    @property
    def outboard(self) -> tuple[str, ...]:
        """``second_links``, by their name of before."""
        return self.second_links

    def _named(self, kind: str, of: str | int) -> str:
        """What a coordinate is, by the name of an output: ``crank.angle``, ``ram.slide``, ``frame.x``."""
        return f"{of if isinstance(of, str) else self.links[of]}.{kind}"

    def _rebuild(self) -> None:
        values = np.array(list(self.settable.values()), dtype=float)
        angular = [index for index, (_, ground) in enumerate(self.contacts) if ground in self.stops]
        lengths = [index for index, (kind, _) in enumerate(self.data["coordinates"]) if kind != "angle"]
        length, duration, law = self._extent(), self.duration, self.data["law"]
        time = self._characteristic_time(length)
        kernels = self.core.Kernels(self._descriptor, values, length, law, angular, time or 0.0, duration, lengths)
        if not np.all(np.isfinite(kernels.constants)):
            raise ValueError(
                f"{self.name}: the equations have no finite constants with these values (a normal of no length?)"
            )
        lost, usual = (
            kernels.rounding(*samples(self.q_names, length, time or duration, self.core.REAL)).max(axis=0).tolist()
        )
        if lost > ROUNDING * float(np.finfo(self.core.REAL).eps) * usual:
            kernels.refine_from_now(usual)
        self.usual = usual
        self.kernels: Kernels = kernels
        self._length, self._time = length, time
        self._changes += 1

    @property
    def length(self) -> float:
        """A length of the mechanism (m): the largest extent of a link."""
        return self._length

    def _extent(self) -> float:
        links = [self._coordinates(points) for points in self.data["outlines"] if len(points) > 1]
        extents = [float(np.ptp(points, axis=0).max()) for points in links]
        return max(extents, default=0.0) or 1.0

    @property
    def time(self) -> float | None:
        """The characteristic time (s) under gravity g, √(9.81 length / g): about half a swing of a pendulum as long.

        So a mechanism of 1 m has 1 s on earth. ``None`` where nothing falls: then the motion's start tells its time.
        """
        return self._time

    def _characteristic_time(self, length: float) -> float | None:
        gravity = max((abs(self._parameters[path]) for path in self.data["accelerations"]), default=0.0)
        time = math.sqrt(EARTH * length / gravity) if gravity else math.inf
        return time if math.isfinite(time) and time <= FALLS * self.duration else None

    @property
    def coordinate_units(self) -> FloatArray:
        """What coordinates (nq,) are measured by, so that they compare: 1 rad, or the mechanism's ``length`` (m)."""
        units = np.full(len(self.q_names), self.length)
        units[list(self.angular)] = 1.0
        return units

    @property
    def duration(self) -> float:
        """How long (s) the scene is simulated: the longest that a characteristic time told by a start can be."""
        return float(self.data["run"]["until"])

    @property
    def parameters(self) -> Parameters:
        """Values by scene path (``link_0.mass``); set one and it takes effect at once."""
        return self._parameters

    @property
    def settable(self) -> Mapping[str, float]:
        """Values of the parameters that are no numbers in the code, by their paths: all but those that are folded."""
        every = self._parameters
        return {path: every[path] for path in self.all_gates} if self.folded else every

    @property
    def off(self) -> tuple[str, ...]:
        """Names of the effects that are off, of those that events switch."""
        return tuple(name for name, path in self.gates.items() if not self._parameters[path])

    @property
    def off_contacts(self) -> tuple[tuple[str, str], ...]:
        """Those of ``contacts`` whose effects are off, or that joints have only while they hold, or are open."""
        there = dict.fromkeys(range(len(self.contacts)), True)
        for one in self.data.get("whiles", ()):
            there[one["contact"]] = any(
                all(bool(self._parameters[path]) is held for path, held in each.items()) for each in one["whiles"]
            )
        return tuple(self.contacts[number] for number, on in there.items() if not on)

    def _is_there(self, drawn: Mapping[str, Any]) -> bool:
        """Whether an effect by which something is drawn is on."""
        gates = drawn.get("on")
        return not gates or any(self._parameters[path] for path in gates)

    @property
    def outlines(self) -> tuple[FloatArray, ...]:
        """Per link that pictures show, which come first, what is drawn of it, corners in the link's frame, (m, 2) in m:
        its named points unless it says otherwise."""
        drawn = self.data.get("drawn", {})
        shown = len(self.links) - len(self.data.get("integrators", ()))
        links = zip(self.links[:shown], self.data["outlines"][:shown], strict=True)
        return tuple(self._coordinates(drawn.get(name, points)) for name, points in links)

    @property
    def discs(self) -> tuple[Disc, ...]:
        """Discs, edges and profiles of links and of the ground, by which they touch."""
        return tuple(
            Disc(
                disc["link"],
                ends[0],
                self._size(disc["radius"]),
                ends[1] if disc["end"] else None,
                np.array(disc["around"]) if disc.get("around") else None,
            )
            for disc in self.data["discs"]
            if self._is_there(disc)
            for ends in [self._coordinates([disc[end] for end in ("point", "end") if disc[end]])]
        )

    @property
    def ropes(self) -> tuple[Rope, ...]:
        """Ropes between points of links and of the ground."""
        return tuple(
            Rope(
                rope["name"],
                tuple(rope["links"]),
                self._coordinates(rope["points"]),
                self._parameters.get(f"{rope['name']}.length"),
            )
            for rope in self.data.get("ropes", ())
            if self._is_there(rope)
        )

    @property
    def parts(self) -> tuple[Part, ...]:
        """What is drawn where effects act, and of joints that slide; a link with a shape of its own has no block."""
        shown = set(self.drawn_joints)
        drawn = self.data.get("drawn", {})
        shaped = {number for number, name in enumerate(self.links) if len(drawn.get(name, ())) > 2}
        shaped |= {disc["link"] for disc in self.data["discs"] if disc["end"] and disc["link"] >= 0}
        sliders = (
            Part(
                "rails" if line["links"][1] in shaped else "slider",
                joint,
                line["links"],
                self._coordinates(line["points"]),
                self._numbers([line["axis"]]),
            )
            for joint, line in self.data["lines"].items()
            if joint in shown
        )
        found = (
            Part(
                one["kind"], one["name"], one["links"], self._coordinates(one["points"]), self._numbers(one["numbers"])
            )
            for one in self.data.get("parts", ())
            if self._is_there(one)
        )
        return (*sliders, *found)

    @property
    def ground_points(self) -> FloatArray:
        """Named points of the ground, (k, 2) in m."""
        return self._coordinates(self.data["ground_points"])

    @property
    def drawn_joints(self) -> tuple[str, ...]:
        """Joints that pictures show: all but those that only place links which no joint of the scene holds, and those
        of what integrates."""
        hidden = {
            *self.data.get("aids", ()),
            *self.data.get("shafts", ()),
            *(one["joint"] for one in self.data.get("integrators", ())),
        }
        return tuple(joint for joint in self.joints if joint not in hidden)

    @property
    def drawn_ground_points(self) -> FloatArray:
        """Points of the ground that pictures show, (k, 2) in m: all but those that free links are placed from."""
        points = self.ground_points
        return points[: len(points) - len(self.data.get("aids", ())) // 2]

    def ground_planes(self) -> dict[str, tuple[FloatArray, FloatArray]]:
        """Per ground that is not off a point of its surface (2,) in m and its outward unit normal (2,)."""
        planes = {}
        for plane in filter(self._is_there, self.data["grounds"]):
            point, normal = self._coordinates([plane["point"], plane["normal"]])
            planes[plane["name"]] = (point, normal / np.linalg.norm(normal))
        return planes

    def _numbers(self, values: Sequence[str | float]) -> tuple[float, ...]:
        return tuple(self._parameters[value] if isinstance(value, str) else value for value in values)

    def _size(self, radius: str | float | list[str]) -> float:
        """A radius (m): of a list the sum of these parameters."""
        parts = radius if isinstance(radius, list) else [radius]
        size = 0.0  # one after the other: the built-in sum compensates from Python 3.12 on
        for part in parts:
            size += self._coordinates([[part, 0.0]])[0, 0].item()
        return size

    def _coordinates(self, points: Sequence[Sequence[str | float]]) -> FloatArray:
        values = [[self._parameters[c] if isinstance(c, str) else c for c in point] for point in points]
        return np.array(values, dtype=float).reshape(-1, 2)

    def _contacts(self, contacts: Iterable[tuple[str, str]]) -> list[int]:
        """Numbers of the contacts of the argument of that name."""
        if isinstance(contacts, str | bytes) or not np.iterable(contacts):
            raise TypeError(f"contacts: found {told(contacts)}, expected pairs of names of Model.contacts, as a list")
        return [self._contact(contact) for contact in contacts]

    def _contact(self, contact: tuple[str, str]) -> int:
        if not isinstance(contact, list | tuple) or tuple(map(str, contact)) not in self.contacts:
            known = ", ".join(f"({point}, {ground})" for point, ground in self.contacts) or "none"
            raise ValueError(f"contacts: found contact {contact!r}, expected one of: {known}")
        return self.contacts.index((contact[0], contact[1]))

    # -- calls of the kernels -----------------------------------------------------------------------------------------

    def _of_q(self, kernel: str, q: ArrayLike, shape: tuple[int, ...]) -> FloatArray:
        states, single = self._batch(q, "q", len(self.q_names))
        found = self.kernels.of_q(kernel, states).reshape(len(states), *shape)
        return found[0].copy() if single else found.copy()

    def _state(
        self, q: ArrayLike, u: ArrayLike, names: tuple[str, str] = ("q", "u")
    ) -> tuple[tuple[FloatArray, FloatArray], bool]:
        sizes = len(self.q_names), len(self.u_names)
        try:
            (qs, single), (us, single_u) = map(self._batch, (q, u), names, sizes)
        except ValueError:
            faults = Faults()  # seldom: then what is wrong with either
            for given, what, width in zip((q, u), names, sizes, strict=True):
                with faults.collecting():
                    self._batch(given, what, width)
            faults.stop_if_any()
            raise
        if qs.shape[0] != us.shape[0] or single != single_u:
            raise ValueError(
                f"{names[0]}, {names[1]}: found shapes {np.shape(q)} and {np.shape(u)}, expected equally many states "
                "in both"
            )
        return (qs, us), single

    def _batch(self, x: ArrayLike, what: str, width: int) -> tuple[FloatArray, bool]:
        kind = self.core.REAL
        found = x if isinstance(x, np.ndarray) and x.dtype == kind else read_numbers(x, what, kind)
        if found.ndim:
            found = np.ascontiguousarray(found)
        if found.ndim not in (1, 2) or found.shape[-1] != width:
            raise ValueError(f"{what}: found shape {found.shape}, expected ({width},) or (states, {width})")
        rows, single = (found[None], True) if found.ndim == 1 else (found, False)
        if not self.core.all_within(found.ravel(), largest_angle(self.core)):  # seldom: then what it is
            if not self.core.all_finite(found.ravel()):
                raise ValueError(f"{what}: found {found[~np.isfinite(found)][0]}, expected finite numbers")
            if what.startswith("q"):
                check_angles(what, rows[:, self.angular], [self.q_names[k] for k in self.angular], self.core)
        return rows, single

    def given(self, inputs: Values | None) -> Under:
        """``with model.given(inputs):`` values of the inputs for calls of the kernels inside; outside they are what
        they were, zero at first. Other threads wait."""
        return Under(self, self._inputs if inputs is None and not self.inputs else read_values(self.inputs, inputs))


class Under:
    """A block in which a model's inputs have these values (inputs,)."""

    def __init__(self, model: Compiled, values: FloatArray) -> None:
        self._model, self._values, self._before = model, values, values

    def __enter__(self) -> None:
        model = self._model
        if model.inputs:
            model._asked.acquire()
            self._before, model._inputs = model._inputs, self._values
            model.kernels.set_inputs(self._values)

    def __exit__(self, *_: object) -> None:
        model = self._model
        if model.inputs:
            model._inputs = self._before
            model.kernels.set_inputs(self._before)
            model._asked.release()
