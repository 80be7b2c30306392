"""Derivatives of a run by its start, parameters and inputs: the record, and how it is made."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray, IntArray
from ..faults import Faults
from ..model.inputs import Values, read_values
from ..model.model import Model
from ..model.numbers import read_numbers
from ..model.places import places_of
from ..record.outputs import values_of
from ..record.record import Record
from .acting import Stretch, does, stretches_of
from .along import Course, InOrder, along, carried, check
from .moving import Moving, Wrt, moving_of
from .passing import Passed
from .start import start_moves
from .told import TIMES, WHOLE, Output, check_outputs, label, moves, read_outputs, values

Mode = Literal["auto", "tangent", "adjoint"]
MODES: tuple[Mode, ...] = get_args(Mode)
"""Whether differences go along the run from each column, or covectors back from each number; "auto" takes what there
are fewer of, and goes along where columns are few beside coordinates: then no step needs a matrix."""

Given = tuple[FloatArray | None, FloatArray | None] | None
"""A start as it was given, with None for what is the scene's; None where all of it is."""


@dataclass(frozen=True, eq=False)
class Sensitivities:
    """What a run's outputs change by, per unit of each of the ``columns``, in SI units and radians.

    ``values`` and ``derivatives`` are by the name of each output: of a number () and (columns,), of q and u (n,) and
    (n, columns); where several times were asked for, these come first. ``impact_times`` (impacts, columns) are what the
    times of the run's impacts move by. ``passed`` are the instants at which the run changed, with the growth of
    differences there. ``sensitivities[name]`` is ``derivatives[name]``.
    """

    run: Record = field(repr=False)
    columns: tuple[str, ...]
    times: FloatArray
    values: Mapping[str, FloatArray] = field(repr=False)
    derivatives: Mapping[str, FloatArray] = field(repr=False)
    impact_times: FloatArray = field(repr=False)
    passed: tuple[Passed, ...] = field(repr=False)

    def __getitem__(self, name: str) -> FloatArray:
        """What an output moves by."""
        if name not in self.derivatives:
            raise KeyError(f"found {name!r}, expected one of {', '.join(self.derivatives)}")
        return self.derivatives[name]

    @property
    def jacobian(self) -> FloatArray:
        """All outputs one below the other, (numbers, columns)."""
        count = len(self.columns)
        parts = [part.reshape(-1, count) for part in self.derivatives.values()]
        return np.vstack(parts) if parts else np.zeros((0, count))


def run_sensitivities(
    run: Record,
    wrt: Wrt,
    outputs: Sequence[Output] | Output = WHOLE,
    at: ArrayLike | None = None,
    given: Given = None,
    mode: Mode = "auto",
    in_order: InOrder | None = None,
) -> Sensitivities:
    """The derivatives of a run; ``given`` is its start as it was given, with None for what is the scene's; ``in_order``
    takes one column, in tangent mode, through instants at which it parts contacts that strike together.

    Raises ``ValueError`` for what has no derivative, with the instant and the reason (docs/model.md, "Derivatives of a
    run").
    """
    if mode not in MODES:
        raise ValueError(f"mode: found {mode!r}, expected one of {', '.join(MODES)}")
    asked = _followed(run, wrt, outputs, at, given, forward=mode != "adjoint")
    told = {label(output): value for output, value in zip(asked.outputs, _values(asked), strict=True)}
    count = len(asked.moving.columns)
    numbers = sum(value.size for value in told.values())
    adjoint = mode == "adjoint" or (mode == "auto" and numbers < count and not asked.course.sweeps)
    with under(asked.stretches, asked.inputs):
        S, passed = carried(asked.course, asked.S, in_order)
    moved = _pulled_back(asked, np.eye(numbers)) if adjoint else _moved(asked, S, passed)
    derived, first = {}, 0
    for name, value in told.items():
        derived[name] = moved[first : first + value.size].reshape(*value.shape, count)
        first += value.size
    return Sensitivities(
        run, asked.moving.columns, asked.times, told, derived, _impact_times(run, asked.moving, passed), passed
    )


def run_vjp(
    run: Record,
    covector: ArrayLike,
    wrt: Wrt,
    outputs: Sequence[Output] | Output = WHOLE,
    at: ArrayLike | None = None,
    given: Given = None,
) -> FloatArray:
    """``covector`` (numbers,) or (k, numbers) times the Jacobian of :func:`run_sensitivities`, (columns,) or
    (k, columns), in adjoint mode."""
    asked = _followed(run, wrt, outputs, at, given, forward=False)
    numbers = sum(value.size for value in _values(asked))
    found = read_numbers(covector, "covector")
    if found.ndim not in (1, 2) or found.shape[-1] != numbers:
        raise ValueError(
            f"covector: found shape {found.shape}, expected ({numbers},), or rows of as many: a number for each of the "
            "outputs"
        )
    if any(part.checks for part in asked.course.parts):
        with under(asked.stretches, asked.inputs):
            carried(asked.course, asked.S)  # raises for columns that have no derivative
    pulled = _pulled_back(asked, np.atleast_2d(found))
    return pulled if found.ndim == 2 else pulled[0]


@dataclass(frozen=True)
class Asked:
    """A run as small differences go along it from S (2 n, columns) at its start, and what of it is asked for:
    ``outputs`` at the times ``stops`` of the course, in the order of ``places`` among these; ``single`` where a number
    was given instead of a row of times."""

    run: Record
    moving: Moving
    stretches: Sequence[Stretch]
    inputs: Values | None
    outputs: Sequence[Output]
    stops: FloatArray
    places: IntArray
    single: bool
    S: FloatArray
    course: Course

    @property
    def times(self) -> FloatArray:
        """Times as they were asked for."""
        return self.stops[self.places]


def _followed(
    run: Record, wrt: Wrt, outputs: Sequence[Output] | Output, at: ArrayLike | None, given: Given, *, forward: bool
) -> Asked:
    """``forward`` where differences need not be taken back."""
    model = check(run)
    chosen = read_outputs(outputs)
    faults = Faults()
    moving, times = None, np.zeros(0)
    with faults.collecting():
        moving = moving_of(model, wrt)
    with faults.collecting():
        check_outputs(model, chosen)
    with faults.collecting():
        times = _times(run, at)
    inputs = None
    with faults.collecting():
        inputs = _inputs(run, model)
    faults.stop_if_any()
    assert moving is not None
    stops = np.array(sorted(set(times.tolist())))
    places = np.searchsorted(stops, times)
    stretches = stretches_of(run, moving)
    with under(stretches, inputs):
        S = _start_moves(model, moving, run, given)
        course = along(run, stretches, S, stops.tolist(), forward=forward)
    single = at is None or np.ndim(at) == 0
    return Asked(run, stretches[0].moving, stretches, inputs, chosen, stops, places, single, S, course)


def under(stretches: Sequence[Stretch], inputs: Values | None) -> ExitStack:
    """A block in which the models of all stretches have these inputs."""
    with ExitStack() as block:
        for stretch in stretches:
            block.enter_context(stretch.model.given(inputs))
        return block.pop_all()


def _values(asked: Asked) -> list[FloatArray]:
    """Of each output its values, at all times the first of which tells the shape."""
    found = []
    for output in asked.outputs:
        if output == TIMES:
            found.append(np.array([impact.t for impact in asked.run.impacts]))
            continue
        named = _named(asked.run, output, asked.stops)
        each = [
            values(stop.stretch.model, output, t, stop.state, {str(output): named[k]} if named is not None else {})
            for k, (t, stop) in enumerate(zip(asked.stops.tolist(), asked.course.stops, strict=True))
        ]
        told = np.array(each)[asked.places]
        found.append(told[0] if asked.single else told)
    return found


def _moved(asked: Asked, S: FloatArray, passed: Sequence[Passed]) -> FloatArray:
    """All outputs one below the other, (numbers, columns), by differences S (stops, D, columns) that went along."""
    parts = [np.zeros((0, len(asked.moving.columns)))]
    for output in asked.outputs:
        if output == TIMES:
            parts.append(_impact_times(asked.run, asked.moving, passed))
            continue
        each = _at_stops(asked, output, S)
        parts += [each[place] for place in asked.places]
    return np.vstack(parts)


def _pulled_back(asked: Asked, covectors: FloatArray) -> FloatArray:
    """Covectors (k, numbers) of all outputs one below the other as those of the columns, (k, columns)."""
    moving = asked.moving
    D = len(moving.directions.columns)
    one_by_one = np.broadcast_to(np.eye(D), (len(asked.course.stops), D, D))
    at_stops = np.zeros((len(asked.course.stops), len(covectors), D))
    at_impacts: dict[float, FloatArray] = {}
    first = 0
    for output in asked.outputs:
        if output == TIMES:
            for impact in asked.run.impacts:
                at_impacts[impact.t] = at_impacts.get(impact.t, 0.0) + covectors[:, first]
                first += 1
            continue
        each = _at_stops(asked, output, one_by_one)
        for place in asked.places:
            rows = each[place]
            at_stops[place] += covectors[:, first : first + len(rows)] @ rows
            first += len(rows)
    found = asked.course.back(at_stops, at_impacts)
    return np.asarray(found @ np.vstack([asked.S, moving.along]))


def _at_stops(asked: Asked, output: Output, S: FloatArray) -> list[FloatArray]:
    """What an output moves by at each stop, (numbers, columns), along differences S (stops, D, columns)."""
    arguments = asked.moving.arguments
    return [
        np.atleast_2d(moves(stop.stretch.model, arguments, output, t, stop.state, one, stop.held, asked.inputs))
        for t, stop, one in zip(asked.stops.tolist(), asked.course.stops, S, strict=True)
    ]


def starts_as_scene(run: Record) -> bool:
    """Whether a run begins where the scene does, to rounding."""
    model = run.model
    if not isinstance(model, Model):
        return True
    q, u = model.start()
    near = 1e-14
    for found, own, size in ((run.q[0], q, model.length), (run.u[0], u, 1.0)):
        if not (np.abs(found - own) <= near * (size + np.abs(own))).all():
            return False
    return True


def _named(run: Record, output: Output, times: FloatArray) -> FloatArray | None:
    if callable(output) or output in WHOLE or places_of(run.model)[output][0] in WHOLE:  # type: ignore[arg-type]
        return None
    return np.asarray(values_of(run, [output], times)[output])


def _times(run: Record, at: ArrayLike | None) -> FloatArray:
    """Times (s) at which outputs are read: the end of the run unless given.

    Raises ``ValueError`` for times outside of the run, and for those of impacts, of events that do something, and at
    which joints let go or take hold, where the state or its derivatives jump.
    """
    times = np.atleast_1d(read_numbers(run.t[-1] if at is None else at, "at"))
    faults = Faults()
    if times.ndim != 1:
        raise ValueError(f"at: found shape {times.shape}, expected a number or a row of them")
    for t in times.tolist():
        if not run.t[0] <= t <= run.t[-1]:
            faults.add(f"at: found {t:g} s, expected times from {run.t[0]:g} to {run.t[-1]:g} s")
        elif any(impact.t == t for impact in run.impacts):
            faults.add(
                f"at: found {t:.9g} s, the time of an impact, at which the state jumps, expected a time beside it"
            )
        for event in run.events:
            if event.t == t and does(event):
                faults.add(
                    f"at: found {t:.9g} s, the time of {event.name}, which sets or switches something, so that "
                    "derivatives jump, expected a time beside it"
                )
                break
        for change in run.changes:
            if change.t == t and change.kind == "release":
                faults.add(
                    f"at: found {t:.9g} s, the time at which {change.joint} lets go, so that derivatives jump, "
                    "expected a time beside it"
                )
    faults.stop_if_any()
    return np.asarray(times, dtype=float)


def _inputs(run: Record, model: Model) -> Any:
    """The constant values of the run's inputs."""
    given = getattr(run.stretches[0].advance, "inputs", None)
    if callable(given) or isinstance(given, str) or (isinstance(given, Mapping) and "t" in given):
        what = "a controller" if callable(given) or isinstance(given, str) else "a table over time"
        raise ValueError(
            f"inputs: found {what}, expected constants: runs under {what} have no derivatives"
            + (", as nobody knows those of a function of Python" if what == "a controller" else "")
        )
    return read_values(model.inputs, given) if model.inputs else None


def _start_moves(model: Model, moving: Moving, run: Record, given: Given) -> FloatArray:
    """What the start of a run moves by. Where q0 or u0 alone is given the other is the scene's, and moves as that."""
    q, u = given if given is not None else (None, None)
    if q is None and u is None:
        return start_moves(model, moving, run.q[0], run.u[0], None)
    if q is None or u is None:
        own = model.start()
        still = replace(moving, q0=np.zeros_like(moving.q0), u0=np.zeros_like(moving.u0))
        of_scene = start_moves(model, still, *own, None)
        n = len(own[0])
        if q is None:
            q, moving = own[0], replace(moving, q0=moving.q0 + of_scene[:n])
        else:
            u, moving = own[1], replace(moving, u0=moving.u0 + of_scene[n:])
    return start_moves(model, moving, run.q[0], run.u[0], (np.asarray(q, dtype=float), np.asarray(u, dtype=float)))


def _impact_times(run: Record, moving: Moving, passed: Sequence[Passed]) -> FloatArray:
    """What the times of all impacts move by, (impacts, columns)."""
    by = {one.t: one.dt for one in passed if one.kind == "impact"}
    none = np.full(len(moving.columns), np.nan)
    return np.array([by.get(impact.t, none) for impact in run.impacts]).reshape(-1, len(moving.columns))
