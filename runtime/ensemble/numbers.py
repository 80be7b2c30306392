"""The numbers of many runs: their parameters, starts and inputs, and which of them cannot be simulated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arrays import FloatArray
from ..faults import Faults
from ..model.compiled import EARTH, FALLS
from ..model.inputs import Given, read_values
from ..model.model import Model
from ..model.numbers import read_numbers
from ..model.samples import ROUNDING, samples
from ..model.start import floats_by_another, put_right, rates_miss, scene_start
from ..model.tolerances import largest_angle, start_miss
from ..simulation.arguments import checked_start


@dataclass(frozen=True, eq=False)
class Numbers:
    """Of ``count`` runs: ``params`` (count,) by scene path; ``q`` and ``u`` (count or 1, n), None for the scene's own;
    ``inputs`` (count or 1, inputs), a table or a controller for all, or None."""

    count: int
    params: Mapping[str, FloatArray]
    q: FloatArray | None
    u: FloatArray | None
    inputs: FloatArray | Given

    def part(self, first: int, last: int) -> Numbers:
        """Those of some runs."""

        def cut(rows: Any) -> Any:
            return rows[first:last] if isinstance(rows, np.ndarray) and len(rows) > 1 else rows

        params = {path: values[first:last] for path, values in self.params.items()}
        return replace(self, count=last - first, params=params, q=cut(self.q), u=cut(self.u), inputs=cut(self.inputs))

    def params_of(self, run: int) -> dict[str, float]:
        return {path: values[run].item() for path, values in self.params.items()}

    def start_of(self, run: int) -> tuple[FloatArray | None, FloatArray | None]:
        q, u = (None if x is None else x[run if len(x) > 1 else 0] for x in (self.q, self.u))
        return q, u


def read_numbers_of_runs(
    model: Model, params: Mapping[str, ArrayLike] | None, q0: ArrayLike | None, u0: ArrayLike | None, inputs: Any
) -> Numbers:
    """The numbers as they are given to :func:`~.ensemble.ensemble`.

    Raises ``ValueError`` for names that are none, parameters that cannot be changed and lengths that do not fit; what
    only some runs have wrong becomes their row."""
    faults, n, kind = Faults(), len(model.q_names), model.core.REAL
    counts: dict[str, int] = {}
    columns: dict[str, FloatArray] = {}
    if params is not None and not isinstance(params, Mapping):
        raise TypeError(
            f"params: found {type(params).__name__}, expected a mapping of parameter names to rows of values"
        )
    for path, given in (params or {}).items():
        with faults.collecting():
            columns[path] = _column(model, path, given)
            if columns[path].ndim:
                counts[f"params: {path}"] = len(columns[path])
    starts: list[FloatArray | None] = []
    for name, start in (("q0", q0), ("u0", u0)):
        with faults.collecting():
            starts.append(_start(name, start, n, kind))
            if start is not None and np.ndim(start) == 2:
                counts[name] = len(starts[-1])  # type: ignore[arg-type]
    with faults.collecting():
        inputs = _inputs(model, inputs)
        if isinstance(inputs, np.ndarray) and len(inputs) != 1:
            counts["inputs"] = len(inputs)
    lengths = set(counts.values())
    if len(lengths) > 1:
        faults.add(f"runs: found {', '.join(f'{of} of {n}' for of, n in counts.items())}, expected equally many of all")
    if 0 in lengths:
        faults.add(f"runs: found none in {', '.join(of for of, n in counts.items() if not n)}, expected at least one")
    faults.stop_if_any()
    count = lengths.pop() if lengths else 1
    spread = {path: np.broadcast_to(values, (count,)) for path, values in columns.items()}
    q, u = starts
    return Numbers(count, spread, q, u, inputs)


def _column(model: Model, path: str, given: ArrayLike) -> FloatArray:
    """A row of values of a parameter, or one for all, each finite or not."""
    values = np.array(read_numbers(given, f"params: {path}"), dtype=float)
    if values.ndim > 1:
        raise ValueError(f"params: {path}: found shape {values.shape}, expected a number or a row of them")
    current = model.parameters[path]
    if path not in model.settable:
        model.parameters.update({path: current})  # raises
    if path in model.data["rests_on"] and not np.all(values == current):
        model.with_parameters({path: next(x for x in values.ravel().tolist() if x != current)})
    return values


def _start(name: str, given: ArrayLike | None, n: int, kind: Any) -> FloatArray | None:
    if given is None:
        return None
    found = np.array(read_numbers(given, name, kind))
    if found.ndim not in (1, 2) or found.shape[-1] != n:
        raise ValueError(f"{name}: found shape {found.shape}, expected ({n},) or (runs, {n})")
    return np.ascontiguousarray(found.reshape(-1, n))


def _inputs(model: Model, given: Any) -> Any:
    """Constants as rows of all inputs, (runs or 1, inputs); tables and controllers as they are."""
    if not model.inputs:
        read_values(model.inputs, given)
        return None
    if given is None or callable(given) or (isinstance(given, Mapping) and "t" in given):
        return given
    if isinstance(given, Mapping):
        if wrong := [name for name in given if name not in model.inputs]:
            raise ValueError(f"inputs: found {wrong[0]!r}, expected one of {', '.join(model.inputs)}")
        columns = [np.array(read_numbers(given.get(name, 0.0), f"inputs: {name}")) for name in model.inputs]
        if any(column.ndim > 1 for column in columns):
            raise ValueError("inputs: found a table, expected a number or a row of them of each")
        lengths = {column.size for column in columns if column.ndim} or {1}
        if len(lengths) > 1:
            sizes = (f"{name} of {c.size}" for name, c in zip(model.inputs, columns, strict=True) if c.ndim)
            raise ValueError(f"inputs: found {', '.join(sizes)}, expected equally many of all")
        return np.stack([np.broadcast_to(column, tuple(lengths)) for column in columns], axis=1)
    found = np.array(read_numbers(given, "inputs"))
    if found.ndim == 0 and len(model.inputs) == 1:
        found = found.reshape(1)
    if found.ndim not in (1, 2) or found.shape[-1] != len(model.inputs):
        raise ValueError(
            f"inputs: found shape {found.shape}, expected ({len(model.inputs)},) or (runs, {len(model.inputs)}): "
            f"{', '.join(model.inputs)}"
        )
    return np.ascontiguousarray(found.reshape(-1, len(model.inputs)))


def outside(model: Model, numbers: Numbers) -> NDArray[np.bool_]:
    """Which runs (count,) have a value that its parameter cannot have, or a start or an input that is no number."""
    wrong = np.zeros(numbers.count, dtype=bool)
    for one in model.data["parameters"]:
        values, domain = numbers.params.get(one["path"]), one["domain"]
        if values is None:
            continue
        wrong |= ~np.isfinite(values)
        if domain.get("whole"):
            wrong |= values % 1.0 != 0.0
        for bound, fails in (("minimum", np.less), ("above", np.less_equal), ("maximum", np.greater)):
            if domain[bound] is not None:
                wrong |= fails(values, domain[bound])
    # as a rule nothing is wrong, which two numbers of all rows tell sooner than one of each: short runs feel it
    for rows in (numbers.q, numbers.u, numbers.inputs):
        if isinstance(rows, np.ndarray) and not _within(rows, np.finfo(rows.dtype).max):
            wrong |= ~np.isfinite(rows).all(axis=1)
    most = largest_angle(model.core)
    if numbers.q is not None and model.angular and not _within(numbers.q, most):
        wrong |= (np.abs(numbers.q[:, list(model.angular)]) > most).any(axis=1)
    return wrong


def _within(rows: FloatArray, most: float) -> bool:
    """Whether all are numbers of at most this size; NaN is not."""
    return rows.size == 0 or bool(rows.max() <= most and rows.min() >= -most)


@dataclass(frozen=True, eq=False)
class Prepared:
    """The same as the core has them: ``parameters`` (count, p) and ``scales`` (count, 2) where any vary; starts ``q``
    and ``u`` (count or 1, n), to be put onto the closure so many times; which runs are ``refused``."""

    parameters: FloatArray | None
    scales: FloatArray | None
    q: FloatArray
    u: FloatArray
    projections: int
    refused: NDArray[np.bool_]


def prepare(model: Model, numbers: Numbers) -> Prepared:
    """Everything of the starts that is not worked out by the core."""
    refused = outside(model, numbers)
    parameters = scales = None
    if numbers.params:
        parameters, scales = _parameters(model, numbers, refused)
    given = numbers.q is not None and numbers.u is not None
    if model.data["drives"] or (given != (numbers.q is not None or numbers.u is not None)):
        q, u = _one_by_one(model, numbers, np.arange(numbers.count), refused)
        return Prepared(parameters, scales, q, u, 0, refused)
    if given:
        assert numbers.q is not None and numbers.u is not None
        return Prepared(parameters, scales, numbers.q, numbers.u, 1, refused)
    if not numbers.params:
        q, u = _one_by_one(model, replace(numbers, count=1), np.arange(1), np.zeros(1, dtype=bool))
        refused |= ~np.isfinite(q).all()
        return Prepared(parameters, scales, q, u, 0, refused)
    q, u = (rows[None] for rows in scene_start(model))
    apart = np.flatnonzero(_to_be_put_right(model, parameters, scales, q[0], u[0]) & ~refused)
    if not apart.size:
        return Prepared(parameters, scales, q, u, 2, refused)
    q, u = np.repeat(q, numbers.count, axis=0), np.repeat(u, numbers.count, axis=0)
    for run in apart.tolist():
        try:
            other = model.with_parameters(numbers.params_of(run))
            q[run], u[run] = put_right(other, *scene_start(other))
        except ValueError:
            refused[run] = True
    return Prepared(parameters, scales, q, u, 2, refused)


def _one_by_one(
    model: Model, numbers: Numbers, runs: NDArray[np.intp], refused: NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray]:
    """Starts of some runs as a run alone has them; those that have none are marked as ``refused``."""
    q = np.full((len(runs), len(model.q_names)), np.nan, dtype=model.core.REAL)
    u = q.copy()
    for row, run in enumerate(runs.tolist()):
        if refused[run]:
            continue
        try:
            other = model.with_parameters(numbers.params_of(run)) if numbers.params else model
            q[row], u[row] = checked_start(other, *numbers.start_of(run))
        except (ValueError, KeyError, TypeError):
            refused[run] = True
    return q, u


def _to_be_put_right(model: Model, parameters: Any, scales: Any, q: FloatArray, u: FloatArray) -> NDArray[np.bool_]:
    """Which runs may begin elsewhere than the scene with its own values: their loops are open there, or open with its
    rates, or their first link may be another way from the root."""
    if floats_by_another(model):
        return np.ones(len(parameters), dtype=bool)
    if not model.rows:
        return np.zeros(len(parameters), dtype=bool)
    misses = model.kernels.closure_misses(parameters, q, u)
    places = np.array([start_miss(model.core.REAL, length) for length in scales[:, 0].tolist()])
    return np.asarray(~(misses[:, 0] <= places) | ~(misses[:, 1] <= places * rates_miss(u)))


def _parameters(model: Model, numbers: Numbers, refused: NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
    """Values of the parameters that can be set, and the length and the characteristic time (0: none) that follow.

    They are those of one model alone, worked out for all at once. Runs that are ``refused`` keep the model's own."""
    kind, paths = model.core.REAL, list(model.settable)
    parameters = np.tile(np.array([model.parameters[path] for path in paths], dtype=kind), (numbers.count, 1))
    for path, values in numbers.params.items():
        parameters[~refused, paths.index(path)] = values[~refused]

    def value(x: str | float) -> Any:
        if x in paths:
            return parameters[:, paths.index(x)].astype(float)
        return np.full(numbers.count, float(model.parameters[x] if isinstance(x, str) else x))

    extents = [
        np.ptp(np.array([[value(c) for c in point] for point in points]), axis=0).max(axis=0)
        for points in model.data["outlines"]
        if len(points) > 1
    ]
    length = np.max(extents, axis=0) if extents else np.zeros(numbers.count)
    length = np.where(length == 0.0, 1.0, length)
    falls = [np.abs(value(path)) for path in model.data["accelerations"]]
    gravity = np.max(falls, axis=0) if falls else np.zeros(numbers.count)
    with np.errstate(divide="ignore", over="ignore"):
        time = np.where(gravity > 0.0, np.sqrt(EARTH * length / gravity), np.inf)
    time = np.where(np.isfinite(time) & (time <= FALLS * model.duration), time, 0.0)
    return parameters, np.stack([length, time], axis=1)


def rounding_sample(model: Model) -> tuple[FloatArray, FloatArray, list[bool], float]:
    """States in units of the length at which the rounding of accelerations is measured for each run's parameters."""
    q, u = samples(model.q_names, 1.0, 1.0, model.core.REAL)
    slides = [name.startswith("slide_") for name in model.q_names]
    return q, u, slides, ROUNDING * float(np.finfo(model.core.REAL).eps)
