"""Derivatives of a run by its start, parameters and inputs: the record, and how it is made."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..faults import Faults
from ..model.inputs import read_values
from ..model.model import Model
from ..model.numbers import read_numbers
from ..model.places import places_of
from ..record.outputs import values_of
from ..record.record import Record
from .along import Passing, along, check
from .moving import Moving, Wrt, moving_of
from .passing import Passed, pass_impacts
from .start import start_moves
from .told import TIMES, WHOLE, Output, check_outputs, label, moves, values


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
    given: tuple[FloatArray | None, FloatArray | None] | None = None,
    passing: Passing = pass_impacts,
) -> Sensitivities:
    """The derivatives of a run; ``given`` is its start as it was given, with None for what is the scene's, ``passing``
    how they pass impacts.

    Raises ``ValueError`` for what has no derivative, with the instant and the reason (docs/model.md, "Derivatives of a
    run").
    """
    model = check(run)
    chosen = [outputs] if isinstance(outputs, str) or callable(outputs) else list(outputs)
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
    with model.given(inputs):
        S = _start_moves(model, moving, run, given)
        order = np.argsort(times, kind="stable")
        found = along(run, model, moving, S, [*dict.fromkeys(times[order].tolist())], passing)
    places = np.searchsorted(np.unique(times), times)
    single = at is None or np.ndim(at) == 0
    told, derived = {}, {}
    impact_times = _impact_times(run, moving, found.passed)
    for output in chosen:
        name = label(output)
        if output == TIMES:
            told[name], derived[name] = np.array([impact.t for impact in run.impacts]), impact_times
            continue
        named = _named(run, output, np.unique(times))
        each_moves = [
            moves(model, moving, output, t, found.states[k], found.S[k], found.held[k], inputs)
            for k, t in enumerate(np.unique(times).tolist())
        ]
        each = [
            values(model, output, t, found.states[k], {name: named[k]} if named is not None else {})
            for k, t in enumerate(np.unique(times).tolist())
        ]
        told[name], derived[name] = np.array(each)[places], np.array(each_moves)[places]
        if single:
            told[name], derived[name] = told[name][0], derived[name][0]
    return Sensitivities(run, moving.columns, times, told, derived, impact_times, found.passed)


def starts_as_scene(run: Record) -> bool:
    """Whether a run begins where the scene does, to rounding."""
    model = run.model
    if not isinstance(model, Model):
        return True
    q, u = model.start()
    near = 1e-14
    return bool(np.allclose(run.q[0], q, rtol=near, atol=near * model.length) and np.allclose(run.u[0], u, near, near))


def _named(run: Record, output: Output, times: FloatArray) -> FloatArray | None:
    if callable(output) or output in WHOLE or places_of(run.model)[output][0] in WHOLE:  # type: ignore[arg-type]
        return None
    return np.asarray(values_of(run, [output], times)[output])


def _times(run: Record, at: ArrayLike | None) -> FloatArray:
    """Times (s) at which outputs are read: the end of the run unless given.

    Raises ``ValueError`` for times outside of the run, and for those of impacts, where the state jumps.
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
    faults.stop_if_any()
    return np.asarray(times, dtype=float)


def _inputs(run: Record, model: Model) -> Any:
    """The constant values of the run's inputs."""
    given = getattr(run.advance, "inputs", None)
    if callable(given) or isinstance(given, str) or (isinstance(given, Mapping) and "t" in given):
        what = "a controller" if callable(given) or isinstance(given, str) else "a table over time"
        raise ValueError(
            f"inputs: found {what}, expected constants: runs under {what} have no derivatives"
            + (", as nobody knows those of a function of Python" if what == "a controller" else "")
        )
    return read_values(model.inputs, given) if model.inputs else None


def _start_moves(
    model: Model, moving: Moving, run: Record, given: tuple[FloatArray | None, FloatArray | None] | None
) -> FloatArray:
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
