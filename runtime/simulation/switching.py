"""A run in which joints let go and take hold: from structure to structure (docs/theory.md, section 5.15)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..loading.structures import structures_of
from ..model.assembly import assemble, project
from ..model.joint_gap import take_hold
from ..model.jump import impulses_behind
from ..model.model import Model, with_params
from ..model.tolerances import joint_miss
from ..model.whole import Whole
from ..record.hybrid_state import HybridState
from ..record.impact import Impact
from ..record.joint_change import JointChange
from ..run import Run
from .advance import Advance
from .arguments import check_until
from .dead_point import Way
from .growing import Enough, Look, at_the_start, sure_rows, wanted
from .one_run import simulate_one
from .pieces import Piece, SwitchedRun, cut_at, joined
from .watching import Instant, certain, first_instant, signal_of, within_of

STRETCHES = 32
"""Parts of the scene's duration in which a run looks for changes: one is integrated beyond a change at most."""
MOST_CHANGES = 10_000
"""Changes of a run; more are taken for a joint that lets go and takes hold without end."""
WORDS = {
    "angle": "the angle of",
    "direction": "the direction of",
    "slide": "the length along",
    "height": "the height of",
}


@dataclass(frozen=True)
class Safe:
    """As far as a run has been looked at."""

    whole: Whole
    pieces: tuple[Piece, ...]
    strikes: tuple[tuple[int, Impact], ...]
    changes: tuple[JointChange, ...]
    missed: tuple[tuple[int, float], ...]
    nfev: int

    def run(self) -> SwitchedRun:
        """The run up to there."""
        return joined(self.whole, self.pieces, self.strikes, self.changes, self.missed, self.nfev, None)


@dataclass
class Walk:
    """Where a run through the structures of ``whole`` is, and what it has left.

    ``look`` is shown what it is so far, when it has as many rows as are ``wanted``. ``safe`` is it as far as it was
    looked at: what is kept where it is interrupted.
    """

    whole: Whole
    structure: int
    t: float
    q: FloatArray
    u: FloatArray
    state: HybridState | None = None
    latched: FloatArray | None = None
    way: Way | None = None
    anew: bool = True
    pieces: list[Piece] = field(default_factory=list)
    strikes: list[tuple[int, Impact]] = field(default_factory=list)
    changes: list[JointChange] = field(default_factory=list)
    missed: list[tuple[int, float]] = field(default_factory=list)
    nfev: int = 0
    look: Look | None = None
    wanted: int = 1
    rows: int = 0
    safe: Safe | None = None

    @property
    def model(self) -> Model:
        return self.whole.structures[self.structure]

    def armed(self) -> list[int]:
        """Numbers of the changes that can come now."""
        opened = self.whole.opened[self.structure]
        every = enumerate(self.whole.data["switching"]["changes"])
        return [number for number, one in every if (one["kind"] == "hold") == (one["joint"] in opened)]


def simulate_switching(
    model: Model,
    q0: ArrayLike | None,
    u0: ArrayLike | None,
    *,
    until: float | None,
    params: Mapping[str, float] | None,
    inputs: Any,
    state: HybridState | None = None,
    begin: tuple[int, float, FloatArray | None] | None = None,
    way: Way | None = None,
    look: Look | None = None,
    **options: Any,
) -> Run:
    """The run of a model whose joints let go and take hold, with the arguments of :func:`~..simulate.simulate`.

    ``begin``: the number of the structure in which it begins, the time (s), and what effects hold then, where that is
    not the start; ``way`` is that of the drives up to there. ``look`` is that of :func:`~.one_run.simulate_one`.
    """
    main = with_params(model, params)
    whole = Whole(structures_of(main))
    names = [one.name for one in whole.structures]
    number = names.index(state.model) if isinstance(state, HybridState) and state.model in names else 0
    end: float = main.duration if until is None else until
    check_until(end)
    if state is None:
        own_q, own_u = main.start()
        q0, u0 = own_q if q0 is None else q0, own_u if u0 is None else u0
        structure, t, latched = begin or (0, 0.0, None)
        walk = Walk(whole, structure, t, np.asarray(q0), np.asarray(u0), latched=latched, way=way, look=look)
    else:
        walk = Walk(whole, number, state.t, state.q, state.u, state, way=way, look=look)
        if not isinstance(state, HybridState) or q0 is not None or u0 is not None or not end > state.t:
            return simulate_one(main, q0, u0, until=until, inputs=inputs, state=state, **options)  # says what is wrong
    try:
        return _walked(walk, float(end), inputs, options, first=state is None and begin is None)
    except KeyboardInterrupt:
        if walk.safe is None or look is not None or not options["keep_interrupted"]:
            raise
        return walk.safe.run()


def _walked(walk: Walk, end: float, inputs: Any, options: Mapping[str, Any], first: bool) -> SwitchedRun:
    message, begins = None, True
    while True:
        until, numbers = _next_stop(walk, end, first)
        if until > walk.t:
            try:
                numbers = _advance(walk, until, numbers, begins, inputs, options)
            except ValueError as error:
                if not walk.pieces:
                    raise
                message = f"stopped at t = {walk.t:.12g} s: {_drawn_together(walk)}{error}"
                break
        if walk.pieces and not walk.anew and not walk.pieces[-1].run.success:
            break
        begins = bool(numbers)
        message = _change(walk, numbers) if numbers else None
        first = False
        if len(walk.changes) > MOST_CHANGES:
            message = f"stopped at t = {walk.t:.12g} s: joints let go and take hold without end; change when they do"
        if message is not None or walk.t >= end:
            break
    if walk.anew and (message is None or not walk.pieces):
        _close(walk, inputs, options)
    return joined(walk.whole, walk.pieces, walk.strikes, walk.changes, walk.missed, walk.nfev, message)


def _drawn_together(walk: Walk) -> str:
    """What has brought the walk to a state from which it cannot go on, if a joint's taking hold has."""
    last = walk.changes[-1] if walk.changes and walk.anew else None
    if last is None or last.kind != "hold" or not last.gap > 0.0:
        return ""
    return f"{last.joint} took hold and drew links together by {last.gap:.3g} m, to where no run begins: "


def _advance(
    walk: Walk, until: float, numbers: tuple[int, ...], begins: bool, inputs: Any, options: Mapping[str, Any]
) -> tuple[int, ...]:
    """Go on to ``until``, when changes ``numbers`` come, or to the first change before; give those that come there."""
    given = _controller(walk.whole, walk.structure, inputs)
    walk.way = walk.way or Way(walk.t, {})
    run, instant = _looked_at(walk, until, begins, given, options)
    if instant is not None and instant.t < run.t[-1]:
        numbers = instant.numbers
        if instant.t in run.t:
            if instant.t == run.t[0] and not any(impact.t == instant.t for impact in run.impacts):
                return numbers
            run = cut_at(run, instant.t)
        else:
            run = _run(walk, instant.t, given, options)
    elif run.t[-1] < until:
        numbers = ()
    elif instant is not None:
        numbers = (*numbers, *instant.numbers)
    walk.pieces.append(Piece(walk.structure, run, walk.anew))
    walk.rows += len(run.t)
    walk.way = walk.way.on(run.model, run.q[0], run.q[-1])
    walk.t, walk.q, walk.u, walk.state, walk.anew = float(run.t[-1]), run.q[-1], run.u[-1], run.state, False
    walk.latched = run.advance.latched.at(walk.t) if isinstance(run.advance, Advance) else None
    return numbers


def _looked_at(
    walk: Walk, until: float, begins: bool, inputs: Any, options: Mapping[str, Any]
) -> tuple[Run, Instant | None]:
    """A run of the structure of now to ``until``, or as far as it is sure which change comes first, and that one."""
    looked, instant = 0, None
    before: Run | None = None

    def look(run: Run) -> int:
        nonlocal looked, instant, before
        instant = _instant(walk, run, begins, looked)
        if instant is None:
            looked = _last_before(run)
            if (sure := sure_rows(before, run, bool(walk.armed()))) is not None:
                _show(walk, sure)
        before = run
        if instant is not None and certain(instant.t, float(run.t[-1]), walk.whole.duration):
            raise Enough(look)
        return wanted(len(run.t))

    try:
        run = _run(walk, until, inputs, options, look)
    except Enough as enough:
        if enough.by is not look:
            raise
        assert before is not None
        walk.nfev += before.nfev
        return before, instant
    looked = min(looked, _last_before(run))  # a run is cut where it ends at a dead point
    return run, _instant(walk, run, begins, looked)


def _last_before(run: Run) -> int:
    """The last row that is earlier than the end: what jumps at the end may yet come."""
    return max(int(np.searchsorted(run.t, run.t[-1], side="left")) - 1, 0)


def _show(walk: Walk, run: Run) -> None:
    """The walk with a run that no change comes along is kept where it is interrupted."""
    pieces = (*walk.pieces, Piece(walk.structure, run, walk.anew))
    nfev = walk.nfev + run.nfev
    walk.safe = Safe(walk.whole, pieces, tuple(walk.strikes), tuple(walk.changes), tuple(walk.missed), nfev)
    rows = walk.rows + len(run.t)
    if walk.look is not None and rows >= walk.wanted:
        walk.wanted = walk.look(walk.safe.run())


def _next_stop(walk: Walk, end: float, first: bool) -> tuple[float, tuple[int, ...]]:
    """Up to when a run may go, and the changes that come then."""
    said = walk.whole.data["switching"]["changes"]
    stretch = walk.whole.duration / STRETCHES
    border = stretch * (math.floor(walk.t / stretch) + 1)
    until = min(end, border if border > walk.t else border + stretch)
    times = {n: said[n]["at"] for n in walk.armed() if said[n]["at"] is not None}
    times = {n: t for n, t in times.items() if t > walk.t or (first and t == walk.t)}
    until = min([until, *times.values()])
    return until, tuple(n for n, t in times.items() if t == until)


def _run(walk: Walk, until: float, inputs: Any, options: Mapping[str, Any], look: Look = at_the_start) -> Run:
    """A run of the structure of now, from where the walk is."""
    begun: dict[str, Any] = {"q0": None, "u0": None, "state": walk.state}
    if walk.state is None:
        begun = {"q0": walk.q, "u0": walk.u, "begin": walk.t, "latched": walk.latched}
    run = simulate_one(walk.model, until=until, inputs=inputs, way=walk.way, look=look, **begun, **options)
    walk.nfev += run.nfev
    return run


def _controller(whole: Whole, structure: int, inputs: Any) -> Any:
    """A controller is called with the state in the coordinates of the whole, whatever structure it is in."""
    if not callable(inputs):
        return inputs
    called: Callable[..., Any] = inputs

    def lifted(t: float, q: FloatArray, u: FloatArray) -> Any:
        return called(t, *whole.lifted(structure, q, u))

    return lifted


def _instant(walk: Walk, run: Run, begins: bool, first: int = 0) -> Instant | None:
    """The first change that comes along a run, from its row ``first`` on, by what is watched, or by the impulse of an
    impact."""
    said = walk.whole.data["switching"]["changes"]
    armed = walk.armed()
    signals = [one for n in armed if (one := signal_of(walk.whole, walk.structure, n, run)) is not None]
    found = first_instant(walk.whole, walk.structure, run, signals, begins, first)
    for number in armed:
        limit = said[number]["impulse"]
        if limit is None:
            continue
        joint = walk.model.joints.index(said[number]["joint"])
        struck = [one.t for one in run.impacts if np.hypot(*one.reactions[joint, :2]) >= limit]
        if struck and (found is None or struck[0] <= found.t):
            same = found.numbers if found is not None and found.t == struck[0] else ()
            found = Instant(struck[0], (*same, number))
    return found


def _close(walk: Walk, inputs: Any, options: Mapping[str, Any]) -> None:
    """A structure that begins at the end of the run is left there: its state is what another run goes on from."""
    run = _run(walk, walk.t, inputs, options)
    walk.pieces.append(Piece(walk.structure, run, True))


def _change(walk: Walk, numbers: tuple[int, ...]) -> str | None:
    """Let joints go and take hold; why the run cannot go on, if so."""
    whole = walk.whole
    for number in sorted(numbers):
        if number not in walk.armed():
            continue  # another table has changed the same joint at the same instant
        said = whole.data["switching"]["changes"][number]
        joint, opened = said["joint"], whole.opened[walk.structure]
        then = whole.opened.index(opened ^ {joint})
        gap, q, u = 0.0, walk.q, walk.u
        if said["kind"] == "hold":
            poses, velocities = whole.links_of(walk.structure, q, u)
            gap = float(np.linalg.norm(whole.ends[joint].misses(poses, velocities, whole.length)[0]))
            within = within_of(whole, said)
            if gap > within:
                return (
                    f"stopped at t = {walk.t:.12g} s: {joint} is to take hold, but its points are {gap:.3g} m "
                    f"from where it holds, expected at most {within:.3g} m; let it take hold elsewhere, or set within"
                )
            taken = take_hold(walk.model, whole.ends[joint], q, u)
            before, u = walk.u, taken.u
        try:
            new_q, new_u = _state_after(whole, then, *whole.links_of(walk.structure, q, u))
        except ValueError as error:
            return f"stopped at t = {walk.t:.12g} s: {joint} cannot take hold: {error}"
        energy = sum(walk.model.energy(walk.q, walk.u)), sum(whole.structures[then].energy(new_q, new_u))
        lost = 0.0
        if said["kind"] == "hold":
            lost = taken.loss
            own = whole.links_of(walk.structure, q, before)[1], whole.links_of(walk.structure, q, u)[1]
            carried = impulses_behind(whole.structures[then], whole.meshes, new_q, *own)
            reactions = whole.reactions_of(then, carried)
            lifted = [whole.lifted(walk.structure, q, one)[1] for one in (before, u)]
            size = float(np.linalg.norm(taken.impulses[: 1 if whole.ends[joint].kind != "revolute" else 2]))
            impact = Impact(
                walk.t, ((joint, "hold"),), lifted[0], lifted[1], np.array([size]), lost, np.zeros(1), reactions
            )
            walk.strikes.append((len(walk.pieces), impact))
        walk.missed.append((len(walk.pieces), float(energy[1] - energy[0] + lost)))
        walk.changes.append(JointChange(walk.t, joint, said["kind"], _why(said), gap))
        if walk.latched is not None:
            walk.latched = whole.latched_in(then, walk.structure, walk.latched)
        walk.structure, walk.q, walk.u, walk.state, walk.anew = then, new_q, new_u, None, True
        if said["kind"] == "hold":
            broken = _broken(walk, reactions)
            if broken:
                return _change(walk, broken)
    return None


def _broken(walk: Walk, reactions: FloatArray) -> tuple[int, ...]:
    """Changes that the impulses of a joint that takes hold bring."""
    said = walk.whole.data["switching"]["changes"]
    return tuple(
        n
        for n in walk.armed()
        if said[n]["impulse"] is not None
        and np.hypot(*reactions[walk.whole.joints.index(said[n]["joint"]), :2]) >= said[n]["impulse"]
    )


def _state_after(
    whole: Whole, structure: int, poses: FloatArray, velocities: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The state of a structure nearest to links at these poses, that move so."""
    model = whole.structures[structure]
    q, u = whole.state_in(structure, poses, velocities)
    if model.cuts and np.max(np.abs(model.closure(q))) > joint_miss(model.core.REAL, model.length):
        q = assemble(model, q)
    return project(model, q, u)


def _why(said: Mapping[str, Any]) -> str:
    """What brings a change, in words."""
    if said["at"] is not None:
        return f"at {said['at']:g} s"
    if watch := said["watch"]:
        words = WORDS.get(watch["kind"])
        what = f"{words} {watch['names'][0]}" if words else f"the distance of {' and '.join(watch['names'])}"
        unit = "rad" if watch["kind"] in ("angle", "direction") else "m"
        return f"{what} comes {'above' if watch['sign'] > 0 else 'below'} {watch['limit']:.6g} {unit}"
    limits = [f"{said[key]:g} {unit}" for key, unit in (("force", "N"), ("impulse", "N s")) if said[key] is not None]
    return f"it carries {' or '.join(limits)}" if limits else "its points meet"
