"""What the gradient of a run costs: by differences over their step, and along the run (theory, section 11.5).

What is derived is one number, a weighted sum of all coordinates at the end. Each entry of its gradient is a sum too,
and its error is told in parts of what the terms of that sum are in size. The reference are differences of runs in wide
numbers at three steps, extrapolated (L. F. Richardson, Philosophical Transactions A 210, 1911), where the machine has
such numbers; those with other steps tell how far they can be trusted. Where it has none, they are derivatives along the
run at a tight tolerance, beside those of another method.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..functions.arguments import Arguments, arguments_of
from ..functions.run_function import RunFunction, run_function
from ..model.model import Model
from ..simulate import simulate
from .accuracy import LARGEST_DOUBT, REPEATS, SPENT

STEPS = tuple(10.0 ** (-k / 2) for k in range(2, 29))
"""Steps of differences, in parts of what is changed, or of one where that is zero."""
TOLERANCES = tuple(10.0**-k for k in range(4, 14))
TIGHT = 1e-13
"""Tolerance of runs whose differences are looked at too, beside the scene's."""
WIDE_STEP, WIDE_RTOL = 2.0**-15, 1e-18
"""Of the reference: what is cut off falls with the sixth power of the step, 1e-27 of what derivatives of that order
are, and what rounding leaves, 1e-18 of a run, is divided by it."""
NOTHING = 1e-9
"""An entry whose terms are below this in size is looked at as it is, not in parts of that."""
WAYS = ("one-sided", "central", "tangent", "adjoint")
DIFFERENCES = WAYS[:2]
NAMED = 4
"""As many names a sentence has at most."""


@dataclass(frozen=True)
class Derivatives:
    """Derivatives of the coordinates that are better than what is measured, (coordinates, columns), by how much the
    gradient of other ones differs in each entry, (columns,), and what both are."""

    jacobian: FloatArray
    doubts: FloatArray
    text: str
    """A sentence that goes on with the doubt."""

    @property
    def doubt(self) -> float:
        """The largest of all columns."""
        return float(np.max(self.doubts))


@dataclass(frozen=True)
class Measured:
    """One way at one tolerance, of differences at one ``step`` (not a number of others): seconds for the gradient of
    one number, its runs included, and its error, infinite where a run did not reach its end or has no derivative.

    By "one-sided" and "central" differences that is a run, or two, for each entry and one more, or none. In "tangent"
    mode derivatives of all coordinates by all columns go along the run, the whole Jacobian, and the gradient is the
    weighted sum of its rows. In "adjoint" mode the weights alone go back through the run, one covector (k = 1), and
    no Jacobian is made."""

    way: str
    rtol: float
    step: float
    seconds: float
    error: float


@dataclass(frozen=True)
class Columns:
    """What is derived by, and what is ``left`` out, each with the reason."""

    names: tuple[str, ...]
    left: dict[str, str]


def columns_of(model: Model, until: float) -> Columns:
    """The rates of the start and all parameters by which the run has derivatives, and can be changed to both sides."""
    names, left = list[str](), dict[str, str]()
    for name in ("u0", *model.parameters):
        try:
            function = run_function(model, name, "q", until=until)
            function.jacobian(function.x0)
        except (KeyError, ValueError) as error:
            left[name] = str(error.__cause__ or error)  # without the values, which are the scene's
            continue
        lowest, highest = function.bounds
        if np.any(function.x0 <= lowest) or np.any(function.x0 >= highest):
            left[name] = "it is at the end of what it may be"
        else:
            names.append(name)
    return Columns(tuple(names), left)


def weights_of(model: Model) -> FloatArray:
    """Of the coordinates (n,), per radian and per length of the mechanism, between a half and one and a half: by the
    fractional parts of multiples of the golden ratio no two are alike, so that nothing vanishes by a symmetry."""
    golden = (1.0 + np.sqrt(5.0)) / 2.0
    units = model.coordinate_units
    return np.asarray((0.5 + golden * np.arange(1, len(units) + 1) % 1.0) / units)


def relative(found: FloatArray, wanted: FloatArray, weights: FloatArray) -> float:
    """The largest error of a gradient, of all its entries: :func:`of_entries`."""
    return float(np.max(of_entries(found, wanted, weights)))


def of_entries(found: FloatArray, wanted: FloatArray, weights: FloatArray) -> FloatArray:
    """The error of each entry (columns,) of the gradient of coordinates with ``weights``, in parts of the sizes of the
    terms that it is the sum of; ``wanted`` (coordinates, columns) are their derivatives."""
    size = weights @ np.abs(wanted)
    return np.asarray(np.abs(found - weights @ wanted) / np.where(size > NOTHING, size, 1.0))


def sizes_of(arguments: Arguments) -> FloatArray:
    """How large each entry of x is, 1 where it is zero: steps are parts of it."""
    return np.where(arguments.start == 0.0, 1.0, np.abs(arguments.start))


def refer(model: Model, wide: Model | None, names: Sequence[str], until: float) -> Derivatives:
    """The reference, and how far it can be trusted.

    Raises ``ValueError`` where a run for it does not reach its end, or has no derivative, and where it cannot be
    trusted, as beside an impact.
    """
    arguments = arguments_of(model, names, (None, None), None)
    found = _reference(model, wide, arguments, until)
    if not found.doubt <= LARGEST_DOUBT:
        raise ValueError(f"{model.name}: no reference {_doubted(found, arguments, until)}")
    return found


def _doubted(found: Derivatives, arguments: Arguments, until: float) -> str:
    """By what there are no derivatives to compare with, how that shows, and what to try."""
    owners = np.repeat(arguments.names, arguments.sizes)
    doubted = [name for name in arguments.names if not np.max(found.doubts[owners == name]) <= LARGEST_DOUBT]
    kept = [name for name in arguments.names if name not in doubted]
    others = f"leave {'it' if len(doubted) == 1 else 'them'} out, as --by {','.join(kept[:NAMED])}, or " if kept else ""
    return (
        f"by {', '.join(doubted[:NAMED])}{', …' if len(doubted) > NAMED else ''} at t = {until:g} s: {found.text} "
        f"{found.doubt:.1e} of themselves, as where a small change makes other impacts, or moves one past the end; "
        f"{others}choose another end: --until"
    )


def _reference(model: Model, wide: Model | None, arguments: Arguments, until: float) -> Derivatives:
    weights = weights_of(model)
    if wide is None:
        first, second = (
            run_function(model, arguments.names, "q", until=until, rtol=rtol, method=method).jacobian(arguments.start)
            for method, rtol in (("gauss", 1e-15), ("dop853", 1e-14))
        )
        text = (
            "derivatives along the run by gauss at rtol 1e-15, in doubles too; by dop853 at rtol 1e-14 they change by"
        )
        return Derivatives(first, of_entries(weights @ second, first, weights), text)
    first, second = (extrapolated(wide, arguments, until, step) for step in (WIDE_STEP, 4.0 * WIDE_STEP))
    text = (
        f"differences of runs in wide numbers at rtol {WIDE_RTOL:.0e}, extrapolated to steps of zero; from steps four "
        "times as long they change by"
    )
    return Derivatives(first, of_entries(weights @ second, first, weights), text)


def extrapolated(wide: Model, arguments: Arguments, until: float, step: float) -> FloatArray:
    """Central differences at ``step``, two and four times of it, in parts of each entry, without the errors of second
    and fourth order."""

    def end(x: FloatArray) -> Any:
        parts: dict[str, Any] = arguments.parts(x)
        q0, u0 = parts.pop("q0", None), parts.pop("u0", None)
        inputs = {name: parts.pop(name) for name in wide.inputs if name in parts}
        run = simulate(wide, q0, u0, until=until, rtol=WIDE_RTOL, params=parts or None, inputs=inputs or None)
        if not run.success:
            raise ValueError(f"{wide.name}: no reference: {run.message}; choose an earlier end: --until")
        return run.q[-1]

    each = [differences(end, arguments, factor * step) for factor in (1.0, 2.0, 4.0)]
    return np.asarray((64.0 * each[0] - 20.0 * each[1] + each[2]) / 45.0, dtype=float)


def differences(end: Callable[[FloatArray], Any], arguments: Arguments, step: float, way: str = "central") -> Any:
    """Differences (coordinates, columns), or (columns,) of a number, with a ``step`` in parts of each entry, over the
    steps that are left of it where sums are rounded."""
    x, columns = arguments.start, list[Any]()
    here = end(x) if way == "one-sided" else None
    for k, size in enumerate(sizes_of(arguments)):
        ahead, behind = x.copy(), x.copy()
        ahead[k] += step * size
        if way == "central":
            behind[k] -= step * size
        columns.append((end(ahead) - (here if here is not None else end(behind))) / (ahead[k] - behind[k]))
    return np.array(columns).T


def measure(
    model: Model, names: Sequence[str], until: float, way: str, rtol: float, step: float, wanted: FloatArray
) -> Measured:
    """Time the gradient in one way and compare it with the ``wanted`` derivatives of coordinates (n, columns); what is
    short is repeated, and the fastest counts."""
    arguments = arguments_of(model, names, (None, None), None)
    weights = weights_of(model)
    seconds, spent, error = np.inf, 0.0, np.inf
    for _ in range(REPEATS):
        function = run_function(model, names, "q", until=until, rtol=rtol, mode="tangent")  # keeps no run of before
        began = time.perf_counter()
        try:
            found = derived(function, arguments, weights, way, step)
        except ValueError:
            return Measured(way, rtol, step, np.nan, np.inf)
        took = time.perf_counter() - began
        seconds, spent, error = min(seconds, took), spent + took, relative(found, wanted, weights)
        if spent > SPENT:
            break
    return Measured(way, rtol, step, seconds, error)


def derived(function: RunFunction, arguments: Arguments, weights: FloatArray, way: str, step: float) -> FloatArray:
    """The gradient (columns,) of the weighted coordinates in one way, as :class:`Measured` says."""
    if way in DIFFERENCES:
        return np.asarray(differences(lambda x: weights @ function.value(x), arguments, step, way))
    if way == "adjoint":
        return function.vjp(arguments.start, weights)
    return np.asarray(weights @ function.jacobian(arguments.start))


def compare(
    model: Model,
    names: Sequence[str],
    until: float,
    rtol: float,
    wanted: FloatArray,
    tell: Callable[[int, int], object] = lambda done, total: None,
    steps: Iterable[float] = STEPS,
) -> list[Measured]:
    """Differences over their steps, of runs at ``rtol`` and at :data:`TIGHT`, and derivatives along runs at all
    tolerances."""
    asked = [(way, t, h) for t in sorted({rtol, TIGHT}, reverse=True) for way in DIFFERENCES for h in steps]
    asked += [(way, t, np.nan) for way in WAYS[2:] for t in sorted({*TOLERANCES, rtol}, reverse=True)]
    found = []
    for k, (way, tolerance, step) in enumerate(asked):
        tell(k, len(asked))
        found.append(measure(model, names, until, way, tolerance, step, wanted))
    return found


def best(measured: Iterable[Measured], way: str, rtol: float) -> Measured:
    """The least error of a way at a tolerance."""
    return min((one for one in measured if one.way == way and one.rtol == rtol), key=lambda one: one.error)
