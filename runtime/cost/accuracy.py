"""What accuracy costs in time: runs by all methods at many tolerances beside a reference better than any of them.

The error of a run is the largest in x, y (m) and angle (rad) of any link at its end, and in the time (s) of any
impact. The reference is a method of high order at a tight tolerance, in wide numbers where the machine has them; a
second method of another kind, as tight, tells how far it can be trusted. Where neighbouring motions part so fast that
rounding alone would spoil the comparison, it is made earlier.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import zip_longest

import numpy as np

from .._core import methods
from ..arrays import FloatArray
from ..model.model import Model
from ..record.impact import Impact
from ..run import Run
from ..simulate import simulate
from ..simulation.arguments import LEAST

TOLERANCES = tuple(10.0**-k for k in range(3, 14))
WIDE_TOLERANCES = tuple(10.0**-k for k in range(3, 17))
GROUNDS = {
    "double": (("gauss", 1e-15), ("dop853", 1e-14)),
    "wide": (("gauss", 1e-18), ("dop853", 1e-17)),
}
"""Method and tolerance of the reference, and of the run that it is checked with, by precision."""

NUDGE = 1e-9
"""Change of the velocities at the start by which the growth of errors is measured, relative to the largest."""
LARGEST_DOUBT = 1e-6
ROUNDING, WORTH = 1e-15, 1e-9
"""Where growth would make the first of the second, comparisons end."""
SAMPLES = 200
LONGEST = 2.0
"""Seconds: a method that needs more for one run is not asked for more digits."""
SPENT = 0.08
"""Seconds spent on repeating a run, the fastest of which counts."""
REPEATS = 25
TRIED = 8
"""Ends that are tried, each before what parted the runs to the last: none is said where all of them fail."""


@dataclass(frozen=True)
class Growth:
    """How fast neighbouring motions part: by ``factor`` until ``until`` (s), where comparisons end."""

    until: float
    factor: float
    cut: bool
    """Whether the motion was to go on longer than comparisons make sense."""


@dataclass(frozen=True)
class Reference:
    """A run better than what is measured, and by how much a run of another method differs from it."""

    run: Run
    second: Run
    doubt: float
    rtol: float
    second_rtol: float

    @property
    def wide(self) -> bool:
        """Whether it was computed in wider numbers than what is measured."""
        return isinstance(self.run.model, Model) and self.run.model.precision == "wide"


@dataclass(frozen=True)
class Measured:
    """One method at one tolerance: seconds of a whole call, errors, and what it did.

    Errors are infinite for runs that ended early or met other impacts than the reference.
    """

    method: str
    drift: str
    rtol: float
    seconds: float
    error: float
    impact_error: float
    steps: int
    evaluations: int
    precision: str = "double"

    @property
    def worst(self) -> float:
        return max(self.error, self.impact_error)


def errors(run: Run, wanted: Run) -> tuple[float, float]:
    """Largest error of a link's pose at the end (m or rad), and of an impact's time (s)."""
    if _contacts(run) != _contacts(wanted) or run.t[-1] != wanted.t[-1]:
        return np.inf, np.inf
    late = [float(abs(a.t - b.t)) for a, b in zip(_strikes(run), _strikes(wanted), strict=True)]
    return float(np.max(np.abs(_poses(run)[-1] - _poses(wanted)[-1]))), max(late, default=0.0)


def parted_at(run: Run, wanted: Run) -> tuple[float, str] | None:
    """When (s) two runs first meet other impacts, and the sentence that tells it; ``None`` where they do not."""
    for mine, others in zip_longest(_strikes(run), _strikes(wanted)):
        if mine is not None and others is not None and mine.contacts == others.contacts:
            continue
        told = (_impact_told(mine, run), _impact_told(others, wanted))
        return min(one.t for one in (mine, others) if one is not None), ", ".join(told)
    return None


def _impact_told(impact: Impact | None, run: Run) -> str:
    """An impact of a run with its number in the table of all, from 1."""
    if impact is None:
        return f"{run.method} has no further one"
    number = next(k for k, one in enumerate(run.impacts, 1) if one is impact)
    return f"impact {number} of {run.method} is of {_named(impact)} at t = {impact.t:.9g} s"


def _named(impact: Impact) -> str:
    return " and ".join(f"{name} on {side}" if side else name for name, side in impact.contacts)


def _before(t: float) -> float:
    """A time (s) of three digits before a positive one."""
    unit = 10.0 ** (math.floor(math.log10(t)) - 2)
    return float(f"{math.floor(0.999 * t / unit) * unit:.3g}")


def _poses(run: Run) -> FloatArray:
    model = run.model
    assert isinstance(model, Model)
    return model.poses(run.q[-1:])


def growth(model: Model, until: float) -> Growth:
    """How fast neighbouring motions part, by running two of them, and how long comparisons make sense.

    The neighbour starts with slightly other velocities, by chance; where that splits impacts that belong together, as
    in symmetric motions, it starts with velocities changed along the accelerations, which keeps the symmetry.
    """
    q, u = model.project(*model.start())
    chance = np.random.default_rng(1).normal(size=u.size)
    own = _run(model, q, u, until)
    for nudge in (chance, model.acceleration(q, u, contacts=()) + u):
        near_q, near_u = model.project(q, u + NUDGE * max(1.0, float(np.max(np.abs(u)))) * nudge)
        near = _run(model, near_q, near_u, until)
        if _contacts(near) == _contacts(own):
            break
    end = min(float(own.t[-1]), float(near.t[-1]))
    if end < until:
        end *= 1.0 - 1e-6  # before whatever ended it
    times = np.linspace(0.0, end, SAMPLES)
    apart = [model.poses(run.at(times)[0]) for run in (own, near)]
    parted = np.max(np.abs(apart[1] - apart[0]), axis=(1, 2)) / max(float(np.max(np.abs(near_u - u))), 1e-30)
    worst = np.maximum.accumulate(parted)
    far = np.flatnonzero(worst * ROUNDING > WORTH)
    last = max(int(far[0]) - 1, 1) if far.size else SAMPLES - 1
    cut = bool(far.size) or end < until
    # a time with few digits, so that it can be asked for again
    horizon = until if not cut else float(f"{times[last] * 0.999:.3g}")
    return Growth(horizon, float(worst[last]), cut)


def _run(model: Model, q: FloatArray, u: FloatArray, until: float) -> Run:
    return list(_until_one_succeeds(_tighter(model, until, "gauss", 1e-12, (q, u))))[-1]


def _contacts(run: Run) -> list[tuple[tuple[str, str], ...]]:
    return [impact.contacts for impact in _strikes(run)]


def _strikes(run: Run) -> list[Impact]:
    """Impacts in which contacts push: those of a loop with itself, at a line, come and go with rounding."""
    return [impact for impact in run.impacts if impact.impulses.any()]


def _tighter(
    model: Model, until: float, method: str, rtol: float, start: tuple[FloatArray, FloatArray] | None = None
) -> Iterator[Run]:
    """Runs at a tight tolerance and at looser ones: rounding near singular configurations may forbid the tightest."""
    q, u = start or (None, None)
    for loosened in range(5):
        yield simulate(model, q, u, until=until, rtol=rtol * 10**loosened, method=method)


def refer(model: Model, until: float) -> Reference:
    """The reference run, and how far a run of another method differs from it; best of a model in wide numbers.

    Raises ``ValueError`` when no run reaches ``until``, or when the two differ by too much for a reference; it says an
    earlier end up to which they are one, if there is.
    """
    found, refused = _two(model, until)
    if refused is not None:
        raise ValueError(f"{model.name}: no reference: {refused}; choose an earlier end: --until")
    if found.doubt > LARGEST_DOUBT:
        raise ValueError(f"{model.name}: no reference: {_disagreement(model, found)}")
    return found


def _two(model: Model, until: float) -> tuple[Reference, str | None]:
    """The two best runs beside each other, and why one of them does not reach its end, if so."""
    best: list[Run] = []
    reached: list[float] = []
    for method, rtol in GROUNDS[model.precision]:
        runs = list(_until_one_succeeds(_tighter(model, until, method, rtol)))
        best.append(runs[-1])
        reached.append(rtol * 10 ** (len(runs) - 1))
        if not runs[-1].success:
            return Reference(best[0], best[-1], np.inf, reached[0], reached[-1]), runs[-1].message
    first, second = best
    return Reference(first, second, max(errors(second, first)), *reached), None


def _disagreement(model: Model, found: Reference) -> str:
    """In what two runs that should be the same differ, and what to try."""
    first, second = found.run, found.second
    parted = parted_at(first, second)
    if parted is None:
        return (
            f"{first.method} and {second.method} differ by {found.doubt:.1e} at t = {first.t[-1]:g} s; choose an "
            "earlier end: --until"
        )
    t, told = parted
    end = _common_end(model, t)
    earlier = f", as --until {end:g}" if end > 0.0 else ": --until"
    return (
        f"{first.method} and {second.method} meet other impacts, although both are as exact as they get: {told}; from "
        f"there on rounding decides, as where bounces accumulate. Choose an end before it{earlier}"
    )


def _common_end(model: Model, t: float) -> float:
    """An end (s) before t up to which the two best runs are one, 0 where none is found: runs to another end take other
    steps, and where bounces accumulate another of them may be the last."""
    for _ in range(TRIED):
        if not t > 0.0:
            return 0.0
        end = _before(t)
        found, refused = _two(model, end)
        if refused is None and found.doubt <= LARGEST_DOUBT:
            return end
        parted = None if refused is not None else parted_at(found.run, found.second)
        t = end if parted is None else parted[0]
    return 0.0


def _until_one_succeeds(runs: Iterable[Run]) -> Iterator[Run]:
    """Runs up to and with the first that reaches its end."""
    for run in runs:
        yield run
        if run.success:
            return


def measure(model: Model, method: str, rtol: float, reference: Run, drift: str = "projected") -> Measured:
    """Time a run and compare it with the reference; short runs are repeated, and the fastest counts."""
    until = float(reference.t[-1])
    seconds, spent = np.inf, 0.0
    for _ in range(REPEATS):
        began = time.perf_counter()
        run = simulate(model, until=until, rtol=rtol, method=method, drift=drift)
        took = time.perf_counter() - began
        seconds, spent = min(seconds, took), spent + took
        if spent > SPENT:
            break
    steps = int(np.count_nonzero(np.diff(run.t)))
    return Measured(method, drift, rtol, seconds, *errors(run, reference), steps, run.nfev, model.precision)


def compare(
    model: Model,
    reference: Run,
    drifts: Sequence[str] = ("projected",),
    tolerances: Iterable[float] | None = None,
    tell: Callable[[int, int], object] = lambda done, total: None,
) -> list[Measured]:
    """Every method that a tolerance can choose steps for, at every tolerance, loosest first; one that gets too slow is
    not asked for more."""
    tolerances = tolerances_of(model.precision) if tolerances is None else tuple(tolerances)
    found: list[Measured] = []
    known = methods(estimating=True)
    total = len(known) * len(drifts) * len(tolerances)
    for number, (method, drift) in enumerate((m, d) for d in drifts for m in known):
        for k, rtol in enumerate(tolerances):
            tell(number * len(tolerances) + k, total)
            found.append(measure(model, method, rtol, reference, drift))
            if found[-1].seconds > LONGEST:
                break
    return found


def tolerances_of(precision: str) -> tuple[float, ...]:
    """Tolerances at which models in numbers of that precision are measured."""
    return tuple(t for t in (WIDE_TOLERANCES if precision == "wide" else TOLERANCES) if t >= LEAST[precision])


def recommend(measured: Iterable[Measured], error: float) -> Measured | None:
    """The fastest that stays below ``error``, if there is one."""
    good = [one for one in measured if one.worst <= error and one.drift == "projected"]
    return min(good, key=lambda one: one.seconds, default=None)
