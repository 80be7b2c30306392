"""The map of a motion from a section back to it, and its derivatives (docs/theory.md, eq. 12.1)."""

from __future__ import annotations

import ast
import copy
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arrays import FloatArray, IntArray
from ..faults import Faults
from ..model.derivatives import need_derivatives
from ..model.model import Model
from ..model.numbers import read_numbers
from ..model.thresholds import characteristic_time
from ..run import Run
from ..sensitivities import sensitivities
from ..simulate import simulate
from .kept import Kept, kept_at, rows_of, settled
from .level import Level, level_times
from .rank import least_change, unmoved

Section = float | tuple[str, str] | Level
"""A time (s), a contact behind whose impact the section is, or a coordinate that passes a value."""

SOMETIMES = (0.1234567, 0.3141593, 0.5772157, 0.7071068, 0.9159656)
"""Parts of a run's time at which forces are looked at."""

PASSES = 1e-8
"""A coordinate passes the value of a section where it is faster than this part of its unit in the time of the
mechanism: what is slower is rounding of what rests there, or turns back there."""

SOON = 16.0
"""A crossing is looked for in a run of so many times of the mechanism, then in runs twice as long."""

BEYOND = 1.25
"""Where it is known about when, first in a run so much longer: steps of a search for motions change their time by less,
and what comes behind the crossing, as a fall, may take longer than all before it."""

BEHIND = 1e-6
"""A run that is derived ends this part of its time behind the impact: beyond the rounding of its instant."""


class Crossed(NamedTuple):
    """A state (q, u) (n,) on the section and what comes of it: the ``runs``, one for each time that the map is applied,
    and their ``time`` (s). ``states`` (crossings, 2 n) are those each time that the section is crossed, from the first
    on, and ``end`` (2 n,) that behind the runs. ``basis`` (2 n, m) are directions of the state on the section, and
    ``ends`` (2 n, m) what ``end`` moves by with them. With a parameter the state moves by ``lift`` (2 n,), so that
    loops and contacts stay shut, and ``end`` by ``pushed`` (2 n,). ``kept`` is what is shut there."""

    q: FloatArray
    u: FloatArray
    runs: tuple[Run, ...]
    time: float
    basis: FloatArray
    ends: FloatArray
    lift: FloatArray
    pushed: FloatArray
    kept: Kept
    states: FloatArray
    end: FloatArray


class Map:
    """From a state on a section of a model to that in which it comes back; it is applied so many ``times``, and the
    state relabelled behind each."""

    def __init__(
        self,
        model: Model,
        section: Section,
        crossings: int,
        until: float,
        relabel: tuple[FloatArray, FloatArray] | None,
        free: IntArray,
        options: dict[str, Any],
    ) -> None:
        self.model, self.section, self.crossings, self.until = model, section, crossings, until
        self.relabel, self.free, self.options, self.times = relabel, free, options, 1
        n, time = len(model.q_names), characteristic_time(model)
        unit = model.coordinate_units
        self.units = np.concatenate([unit, unit / time])
        self.compared = np.setdiff1d(np.arange(2 * n), free)
        self.counted = [0]
        at = [section.coordinate] if isinstance(section, Level) else []
        self.fixed = np.union1d(free, at).astype(int)
        # the contact that is closed on the section, -1 for none, and whether others that are closed stay so
        self.closed = -1, isinstance(section, tuple)
        if isinstance(section, tuple) and relabel is None:
            self.closed = model.contacts.index(section), True

    @property
    def count(self) -> int:
        """How many runs were derived, by this map and those made of it."""
        return self.counted[0]

    def of(self, model: Model) -> Map:
        """The same map of the model with other values of its parameters."""
        other = copy.copy(self)
        other.model = model
        return other

    def doubled(self) -> Map:
        """The map applied twice: in one run, or one after the other where the state is relabelled between them."""
        other = copy.copy(self)
        if self.relabel is None:
            other.crossings, other.until = 2 * self.crossings, 2.0 * self.until
        else:
            other.times = 2 * self.times
        return other

    def single(self) -> Map:
        """The map to the next crossing, and where the state is relabelled behind each, to where it is."""
        other = copy.copy(self)
        other.times = 1
        if self.relabel is None:
            other.crossings = 1
        return other

    def at(self, q: FloatArray, u: FloatArray, parameter: str | None = None, about: float | None = None) -> Crossed:
        """What comes of a state with loops shut, and by what that moves with a ``parameter``; ``about`` is the time (s)
        that it took from a state nearby."""
        kept = kept_at(self.model, q, u, self.closed)
        n, units = len(q), self.units
        rows, by = rows_of(self.model, q, u, kept, units, parameter)
        fixed = np.eye(2 * n)[self.fixed]
        rows = np.vstack([fixed, rows])
        basis = unmoved(rows) * units[:, None]
        lift = np.zeros(2 * n)
        columns, along = basis, dict[str, FloatArray]()
        if parameter is not None:
            lift = units * least_change(rows, np.concatenate([np.zeros(len(fixed)), -by]))
            columns = np.column_stack([basis, lift])
            along = {parameter: np.eye(columns.shape[1])[-1:]}
        runs, time, states, end, moved = self._applied(q, u, columns, along, about)
        begin, m = states[0], basis.shape[1]
        pushed = moved[:, m] if parameter is not None else np.zeros(2 * n)
        return Crossed(begin[:n], begin[n:], runs, time, basis, moved[:, :m], lift, pushed, kept, states, end)

    def moved(self, crossed: Crossed, change: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The state that is (2 n,) away from one, of this map's model, put back onto all that is kept shut there."""
        n = len(crossed.q)
        return settled(self.model, crossed.q + change[:n], crossed.u + change[n:], crossed.kept, self.units)

    def _applied(
        self,
        q: FloatArray,
        u: FloatArray,
        columns: FloatArray,
        along: dict[str, FloatArray],
        about: float | None,
    ) -> tuple[tuple[Run, ...], float, FloatArray, FloatArray, FloatArray]:
        """The runs and the time that they take, the states (crossings, 2 n) in which they cross the section, from the
        first on, that behind them, and by what this moves along ``columns`` (2 n, m)."""
        n, runs, time, states = len(q), list[Run](), 0.0, list[FloatArray]()
        end, moved = np.concatenate([q, u]), columns
        for _ in range(self.times):
            self.counted[0] += 1
            by = {"q0": moved[:n], "u0": moved[n:], **along}
            crossing = self._timed if isinstance(self.section, float) else self._struck
            crossing = self._passed if isinstance(self.section, Level) else crossing
            run, one, end, moved = crossing(end[:n], end[n:], by, about and about / self.times)
            states += [np.concatenate(state) for state in self._crossed(run)]
            if self.relabel is not None:
                A, b = self.relabel
                end, moved = A @ end + b, A @ moved
            _check_left(run, one)
            runs.append(run)
            time += one
        return tuple(runs), time, np.array(states), end, moved

    def _crossed(self, run: Run) -> list[tuple[FloatArray, FloatArray]]:
        """The states in which a run crosses the section, that in which it begins the first, the last left out."""
        found = [(run.q[0], run.u[0])]
        if isinstance(self.section, float):
            return found + [run.at(k * self.section) for k in range(1, self.crossings)]
        return found + [self._state_at(run, t) for t in self._instants(run)[: self.crossings - 1]]

    def _timed(
        self, q: FloatArray, u: FloatArray, by: dict[str, FloatArray], about: float | None
    ) -> tuple[Run, float, FloatArray, FloatArray]:
        """At a time: periods of what drives the model."""
        assert isinstance(self.section, float)
        time = self.section * self.crossings
        found = sensitivities(self.model, by, ["q", "u"], q, u, until=time, **self.options)
        end = np.concatenate([found.values["q"], found.values["u"]])
        return _whole(found.run), time, end, np.vstack([found["q"], found["u"]])

    def _struck(
        self, q: FloatArray, u: FloatArray, by: dict[str, FloatArray], about: float | None
    ) -> tuple[Run, float, FloatArray, FloatArray]:
        """Behind an impact of a contact, wherever that comes. Instants are those of the run that is derived: the one
        that looks for the impact ends elsewhere, and its last digits are others."""
        until = self._instant(q, u, about=about) * (1.0 + BEHIND)
        found = sensitivities(self.model, by, ["impact_times"], q, u, until=until, **self.options)
        run = _whole(found.run)
        time = self._instants(run)[self.crossings - 1]
        (passed,) = (one for one in found.passed if one.kind == "impact" and one.t == time)
        return run, time, np.concatenate(_behind(run, time)), passed.behind

    def _passed(
        self, q: FloatArray, u: FloatArray, by: dict[str, FloatArray], about: float | None
    ) -> tuple[Run, float, FloatArray, FloatArray]:
        """Where a coordinate passes a value, at whatever time: the end moves back along the motion by that."""
        assert isinstance(self.section, Level)
        i, n, time = self.section.coordinate, len(q), self._instant(q, u, about=about)
        found = sensitivities(self.model, by, ["q", "u"], q, u, until=time, **self.options)
        run = _whole(found.run)
        end = np.concatenate([found.values["q"], found.values["u"]])
        rates = np.concatenate([found.values["u"], run.accelerations(run.t[-1])])
        if abs(rates[i]) <= PASSES * self.units[n + i]:
            raise ValueError(
                f"{self.model.name}: found {self.model.q_of[i]} at {self.section.value:g} with a rate of "
                f"{rates[i]:.2g}, expected a motion that passes it; begin farther from rest, or choose another value"
            )
        moved = np.vstack([found["q"], found["u"]])
        off = self.section.value - end[i]
        off -= 2.0 * np.pi * round(off / (2.0 * np.pi)) if self.section.turns else 0.0
        return run, time + off / rates[i], end + off / rates[i] * rates, moved - np.outer(rates, moved[i] / rates[i])

    def first(self, q: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The state behind the first crossing of a run, on the section, from a state that need not be on it."""
        if isinstance(self.section, float):
            return q, u
        run = simulate(self.model, q, u, until=self._instant(q, u, 1) * (1.0 + BEHIND), **self.options)
        assert isinstance(run, Run)
        return self._relabelled(*self._state_at(run, self._instants(run)[0]))

    def after(self, q: FloatArray, u: FloatArray, about: float | None = None) -> tuple[FloatArray, FloatArray]:
        """The state to which the map leads, loops shut, without derivatives; ``about`` as in :meth:`at`."""
        for _ in range(self.times):
            q, u = self._once(q, u, about and about / self.times)
        return q, u

    def _once(self, q: FloatArray, u: FloatArray, about: float | None) -> tuple[FloatArray, FloatArray]:
        """The state behind one run."""
        until = self.time_of(q, u, about)
        run = simulate(self.model, q, u, until=until * (1.0 + BEHIND), **self.options)
        assert isinstance(run, Run)
        if not run.success:
            raise ValueError(f"{self.model.name}: {run.message}")
        _check_left(run, until)
        if isinstance(self.section, float):
            return self._relabelled(*run.at(until))
        return self._relabelled(*self._state_at(run, self._instants(run)[self.crossings - 1]))

    def _state_at(self, run: Run, time: float) -> tuple[FloatArray, FloatArray]:
        """The state at a crossing, behind an impact."""
        return _behind(run, time) if isinstance(self.section, tuple) else run.at(time)

    def _relabelled(self, q: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        if self.relabel is not None:
            A, b = self.relabel
            whole = A @ np.concatenate(self.model.project(q, u)) + b
            q, u = whole[: len(q)], whole[len(q) :]
        return self.model.project(q, u)

    def time_of(self, q: FloatArray, u: FloatArray, about: float | None = None) -> float:
        """How long one run from there takes to come back to the section."""
        return self.section * self.crossings if isinstance(self.section, float) else self._instant(q, u, about=about)

    def _instant(self, q: FloatArray, u: FloatArray, crossings: int | None = None, about: float | None = None) -> float:
        """When a run from there crosses the section so many times."""
        wanted = crossings or self.crossings
        until = min(self.until, BEYOND * about if about else SOON * characteristic_time(self.model))
        while True:
            run = _whole(simulate(self.model, q, u, until=until, **self.options))
            found = self._instants(run)
            if len(found) >= wanted or until >= self.until or not run.success:
                break
            until = min(2.0 * until, self.until)
        if len(found) < wanted:
            raise ValueError(
                f"{self.model.name}: found {len(found)} {self._name()} in {run.t[-1]:g} s, "
                f"expected {wanted}: {run.message or 'the run came to its end; let it go on with until'}"
            )
        return found[wanted - 1]

    def _instants(self, run: Run) -> list[float]:
        """When the section is crossed, behind the start; impacts at one instant are one crossing."""
        if isinstance(self.section, Level):
            return level_times(run, self.section, float(self.units[self.section.coordinate]))
        own = (impact.t for impact in run.impacts if self.section in impact.contacts and impact.t > 0.0)
        return list(dict.fromkeys(own))

    def _name(self) -> str:
        if isinstance(self.section, Level):
            return f"passages of {self.model.q_of[self.section.coordinate]} = {self.section.value:g}"
        assert isinstance(self.section, tuple)
        return f"impacts of {' on '.join(self.section)}"


def _check_left(run: Run, time: float) -> None:
    """Raise ``ValueError`` where events have left parameters at a time (s) other than they were where the run began: a
    motion that begins anew there is another."""
    if time > run.t[-1]:  # by rounding
        time = float(run.t[-1])
    began, now = run.model.parameters, run.model_at(time).parameters
    for path, value in began.items():
        if now[path] != value:
            set_by = [event.name for event in run.events if path in event.parameters] or [
                event.name for event in run.events if {*event.on, *event.off} & {path.removesuffix(".on")}
            ]
            joints = [joint for joint, gate in run.model.joint_gates.items() if gate == path]
            if joints:
                raise ValueError(
                    f"{run.model.name}: found {joints[0]} {'open' if value else 'held'} at the end of a way from the "
                    f"section back to it, t = {time:.9g} s, expected it as where it begins; let it "
                    f"{'take hold' if value else 'let go'} before"
                )
            raise ValueError(
                f"{run.model.name}: found {path} at {now[path]:.9g} at the end of a way from the section back to it, "
                f"t = {time:.9g} s, set by {set_by[-1]}, expected {value:.9g} as where it begins; let an event set it "
                "back before"
            )


def _behind(run: Run, time: float) -> tuple[FloatArray, FloatArray]:
    """The state behind the impacts of an instant."""
    last = [impact for impact in run.impacts if impact.t == time][-1]
    return run.q[np.flatnonzero(run.t == time)[-1]], last.u_plus


def _whole(run: Any) -> Run:
    assert isinstance(run, Run)
    return run


def read_map(
    model: Model,
    section: Any,
    crossings: Any,
    until: Any,
    relabel: Any,
    advances: Sequence[str],
    options: dict[str, Any],
) -> Map:
    """Raises ``ValueError`` with all that is wrong."""
    faults, n = Faults(), len(model.q_names)
    where: Section = 0.0
    with faults.collecting():
        where = _read_section(model, section)
    if isinstance(crossings, bool) or not isinstance(crossings, int) or crossings < 1:
        faults.add(f"crossings: found {crossings!r}, expected a number, at least 1")
    end = model.data["run"]["until"] if until is None else until
    if isinstance(end, bool) or not isinstance(end, (int, float)) or not 0.0 < end < np.inf:
        faults.add(f"until: found {until!r}, expected a time in s above 0")
    changed = None
    if relabel is not None:
        with faults.collecting():
            changed = _relabel(relabel, n)
    unknown = [name for name in advances if name not in model.q_of]
    if isinstance(advances, str) or unknown:
        faults.add(f"advances: found {advances!r}, expected a list of coordinates, of {', '.join(model.q_of)}")
    if not isinstance(where, float) and depends_on_time(model):
        what = "a contact" if isinstance(where, tuple) else "a coordinate"
        faults.add(
            f"section: found {what} in a model that depends on time, expected the period of what drives it, as a "
            "time: there it would begin at another phase"
        )
    timed = [one["name"] for one in acting_by_time(model) if not isinstance(where, float) or _set_by_time(one)]
    if timed:
        faults.add(
            f"section: found {timed[0]}, an event that does something by the time, expected events by the state alone: "
            "each way from the section back to it begins at t = 0"
        )
    at_times = [
        said["joint"] for said in (model.data.get("switching") or {}).get("changes", ()) if said["at"] is not None
    ]
    if at_times:
        faults.add(
            f"section: found {at_times[0]}, a joint that lets go or takes hold at a given time, once, expected joints "
            "that do so by the state alone"
        )
    with faults.collecting():
        need_derivatives(model)
    faults.stop_if_any()
    free = np.array([model.q_of.index(name) for name in advances], dtype=int)
    return Map(model, where, crossings, float(end), changed, free, options)


def _read_section(model: Model, section: Any) -> Section:
    """Raises ``ValueError`` for what is none."""
    if isinstance(section, (tuple, list)) and len(section) == 2 and not isinstance(section[1], str):
        name, value = section
        number = isinstance(value, (int, float)) and not isinstance(value, bool) and -np.inf < value < np.inf
        if name not in model.q_of or not number:
            known = ", ".join(model.q_of)
            raise ValueError(f"section: found {section!r}, expected one of the coordinates {known} and its value")
        return Level(model.q_of.index(name), float(value), name.endswith(".angle"))
    if isinstance(section, (tuple, list)):
        where = (str(section[0]), str(section[1])) if len(section) == 2 else ("", "")
        if where not in model.contacts:
            known = ", ".join(map(str, model.contacts)) or "there are none"
            raise ValueError(f"section: found {section!r}, expected a time, or one of the contacts {known}")
        return where
    if isinstance(section, (int, float)) and not isinstance(section, bool) and 0.0 < section < np.inf:
        return float(section)
    raise ValueError(
        f"section: found {section!r}, expected a time in s above 0, a contact (point, surface), or a coordinate and "
        "its value (name, number)"
    )


def acting_by_time(model: Model) -> list[Mapping[str, Any]]:
    """Events that set, switch or end something where, or to what, the time tells."""
    acting = (one for one in model.data.get("events", ()) if one["set"] or one["on"] or one["off"] or one["stop"])
    return [one for one in acting if _has_time(one["when"]) or _set_by_time(one)]


def _set_by_time(event: Mapping[str, Any]) -> bool:
    return any(_has_time(value) for value in event["set"].values() if isinstance(value, str))


def _has_time(text: str) -> bool:
    """Whether an expression of an event has the time in it."""
    return any(isinstance(node, ast.Name) and node.id == "t" for node in ast.walk(ast.parse(text, mode="eval")))


def depends_on_time(model: Model) -> bool:
    """Whether joints are driven, or accelerations change with time, at instants that no period has in common."""
    return bool(model.data["drives"]) or any(
        not np.array_equal(accelerations_at(model, *state, t * model.duration), accelerations_at(model, *state, 0.0))
        for state in looked_at(model)
        for t in SOMETIMES
    )


def looked_at(model: Model) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
    """States (q, u) at which forces are looked at: the scene's start, at rest and in motion (what damps is nothing at
    rest)."""
    q, u = model.start()
    return (q, 0.0 * u), model.project(q, u + model.coordinate_units / characteristic_time(model))


def accelerations_at(model: Model, q: FloatArray, u: FloatArray, t: float) -> FloatArray:
    """Accelerations (n,) in flight, with inputs that are zero."""
    inputs = dict.fromkeys(model.inputs, 0.0) or None
    return np.asarray(model.acceleration(q, u, t, inputs, contacts=()))


def _relabel(relabel: Any, n: int) -> tuple[FloatArray, FloatArray]:
    if not isinstance(relabel, (tuple, list)) or len(relabel) != 2:
        raise ValueError(f"relabel: found {type(relabel).__name__}, expected a matrix and a column, (A, b)")
    A, b = (np.asarray(read_numbers(part, "relabel"), dtype=float) for part in relabel)
    if A.shape != (2 * n, 2 * n) or b.shape != (2 * n,) or not np.all(np.isfinite(A)) or not np.all(np.isfinite(b)):
        raise ValueError(
            f"relabel: found shapes {A.shape} and {b.shape}, expected finite numbers {(2 * n, 2 * n)} and {(2 * n,)}"
        )
    return A, b
