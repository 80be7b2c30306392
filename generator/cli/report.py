"""What ``ccgen run`` prints of a run: its impacts as a table, and its audit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import typer

from ..mechanism.totals import total

if TYPE_CHECKING:
    from ccgen.runtime import Event, Impact, Model, Phase, Run
    from ccgen.runtime.arrays import FloatArray
    from ccgen.runtime.record.joint_change import JointChange

    from ..scene.scene import Scene

SHOWN = 40
"""Impacts printed, the first, and as many later ones that are told of apart; the result file has them all."""
STRETCHES = 8
"""Stretches of contact and of time stepping printed, the last ones."""
JAMS = " (friction jams)"
"""Behind the contacts of an impact without collision."""
EASED = " ({:.0%} of restitution)"
"""Behind those of an impact that could not have all of it."""
HELD = {
    "smooth": ("", ""),
    "sticks": (" sticks", " stick"),
    "slides": (" slides", " slide"),
    "at": (" is at the limit", " are at the limit"),
    "carried": (" is carried", " are carried"),
    "touches": (" touches", " touch"),
}
"""What is printed of one contact and of several, by the first word of ``Phase.how``."""
WIDTH = 140
DRAWN = 1e-9
"""Part of the mechanism's length beyond which it is told how far points were apart where a joint took hold."""
LAST = 5
"""What a run that stopped early did last, that is printed without being asked for."""
DRIFT = 1e-4
"""Share of the energy that moves beyond which a drift is warned of; of the scale of energy where nothing moves."""
INEXACT = 1e-9
"""Part of the largest acceleration beyond which an error that masses are at fault for is warned of."""


def print_impacts(model: Model, run: Run) -> None:
    """The impacts as a table: when, which points, how fast they came, the impulses, the energy lost and left.

    The energy left is as ``model.energy`` counts it, of the model that is in force then; the potential of weights is 0
    at y = 0.
    """
    if not run.impacts:
        typer.echo("impacts are not told apart by time stepping" if run.method == "moreau" else "no impacts")
        return
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for title in ("#", "t, s"):
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("contacts", no_wrap=True)
    units = ("rad/s", "N m s") if len(model.stops) == len(model.contacts) else ("m/s, rad/s", "N s, N m s")
    speed, push = units if model.stops else ("m/s", "N s")
    for title in (f"speed before, {speed}", f"impulse, {push}", "energy lost, J", "energy after, J (0 at y = 0)"):
        table.add_column(title, justify="right", no_wrap=True)
    in_force = run.in_force
    rows = [
        (number, row(model, run, number - 1, cast("Model", in_force.at_impact(number - 1))))
        for number, impact in enumerate(run.impacts, 1)
        if number <= SHOWN or impact.restitution_share < 1.0
    ][: 2 * SHOWN]
    for number, cells in rows:
        table.add_row(str(number), *cells)
    Console(width=WIDTH, highlight=False, soft_wrap=True).print(table)
    if any(JAMS in contacts for _, (_, contacts, *_) in rows):
        typer.echo("friction jams: an impact without collision, where a contact that slides has no forces (Painleve)")
    if len(run.impacts) > len(rows):
        typer.echo(f"and {len(run.impacts) - len(rows)} more, in result.npz")


def print_events(run: Run) -> None:
    """Joints that let go or took hold, and events, in the order of time: at one instant joints come first."""
    told = [(change.t, _change(run, change)) for change in run.changes[:SHOWN]]
    least = rounding_of_energy(run) if any(event.energy for event in run.events) else 0.0
    told += [(event.t, _event(event, least)) for event in run.events[:SHOWN]]
    for _, line in sorted(told, key=lambda one: one[0]):
        typer.echo(line)
    for what, count in (("changes of joints", len(run.changes)), ("events", len(run.events))):
        if count > SHOWN:
            typer.echo(f"and {count - SHOWN} more {what}, in result.npz")
    if run.events and run.message.startswith("ended at"):
        typer.echo(f"the run {run.message}")


def _change(run: Run, change: JointChange) -> str:
    """A joint that let go or took hold, when, and why."""
    does = "lets go" if change.kind == "release" else "takes hold"
    gap = f", drawn together by {change.gap:.2g} m" if change.gap > DRAWN * run.model.length else ""
    gap += f", by which the energy jumps by {change.energy:.3g} J" if gap and change.energy else ""
    return f"{change.joint} {does} at t = {change.t:.12g} s: {change.why}{gap}"


def _event(event: Event, least: float) -> str:
    """An event, when it came, what it set and switched, and by how much the energy jumped by that, if by more than the
    ``least`` (J) that is told from rounding."""
    told = [*event.done]
    if abs(event.energy) > least:
        told.append(f"the energy jumps by {event.energy:.6g} J")
    number = f" ({event.number})" if event.number > 1 else ""
    what = ": " + ", ".join(told) if told else ""
    return f"event {event.name}{number}, {event.direction}, at t = {event.t:.12g} s{what}"


def print_missing(scene: Scene, run: Run) -> None:
    """What the scene says of joints and events that has not come up to the end that was asked for."""
    if not run.success or run.message.startswith("ended at"):
        return
    changed = {(change.kind, change.joint) for change in run.changes}
    came = {event.name for event in run.events}
    missing = [f"{one.kind} of {one.joint}" for one in scene.changes if (one.kind, one.joint) not in changed]
    missing += [f"event {event.name}" for event in scene.events if event.name not in came]
    for what in missing:
        typer.echo(f"{what}: never came")
    for event in scene.events:
        if event.stop and event.name in came:
            times = sum(one.name == event.name for one in run.events)
            typer.echo(f"event {event.name}: came {times} of the {event.stop} times at which the run ends")


def row(model: Model, run: Run, number: int, then: Model) -> tuple[str, ...]:
    """The cells of impact ``number``, from 0, of the model that was in force ``then``; contacts that struck together
    stand below each other."""
    from ccgen.runtime.record.contact_tables import closing_rates

    impact = run.impacts[number]
    q = run.q[np.searchsorted(run.t, impact.t)]
    if impact.contacts[0] not in then.contacts:  # a joint that takes hold
        names = [f"{impact.contacts[0][0]} takes hold"]
    else:
        names = _names(model, impact.contacts)
    speeds = closing_rates(run, number)
    if without_collision(then, impact, speeds):
        names = [name + JAMS for name in names]
    if impact.restitution_share < 1.0:
        names = [name + EASED.format(impact.restitution_share) for name in names]
    return (
        f"{impact.t:.12f}",
        "\n".join(names),
        "\n".join(f"{speed:z.9f}" for speed in speeds),
        "\n".join(f"{impulse:z.9f}" for impulse in impact.impulses),
        f"{impact.energy_loss:z.9f}",
        f"{total(then.energy(q, impact.u_plus)):z.9f}",
    )


def _names(model: Model, contacts: Sequence[tuple[str, str]]) -> list[str]:
    """What touches what; what alone, where there is but one ground and no stop."""
    single = len({ground for _, ground in model.contacts}) == 1 and not model.stops
    return [point if single else f"{point} on {ground}" for point, ground in contacts]


def without_collision(model: Model, impact: Impact, speeds: Sequence[float]) -> bool:
    """Whether rough contacts have impulses although none of them approaches: friction jams (docs/theory, 5.11).

    ``speeds`` are the rates of the gaps before. What is slower than a contact at rest does not approach.
    """
    if max(impact.impulses) <= 0.0 or not np.any(impact.friction):
        return False
    from ccgen.runtime.model.thresholds import characteristic_time

    slow = model.core.TOLERANCES["REST_SPEED"].value / characteristic_time(model)
    units = [1.0 if ground in model.stops else model.length for _, ground in impact.contacts]
    return all(speed >= -slow * unit for speed, unit in zip(speeds, units, strict=True))


def print_contacts(model: Model, run: Run) -> None:
    """Stretches of contact, from when to when, the points that stay closed and how each does, and of time stepping.

    What follows without a gap and reads alike is one stretch.
    """
    stretches: list[list[Any]] = []
    for phase in run.phases:
        if phase.kind not in ("contact", "steps"):
            continue
        words = _held(model, phase)
        if stretches and stretches[-1][1:] == [phase.start, words]:
            stretches[-1][1] = phase.end
        else:
            stretches.append([phase.start, phase.end, words])
    for start, end, words in stretches[-STRETCHES:]:
        kind, points = ("contact", f": {words}") if words else ("time stepping", "")
        typer.echo(f"{kind} {_interval(start, end)}{points}")
    if (before := len(stretches) - STRETCHES) > 0:
        typer.echo(f"and {before} such stretch{'es' * (before > 1)} before, in result.npz")


def _held(model: Model, phase: Phase) -> str:
    """The contacts of a phase in groups: those that stick, those that slide, …; nothing of time stepping."""
    groups: dict[str, list[str]] = {}
    for name, how in zip(_names(model, phase.contacts), phase.how, strict=True):
        groups.setdefault(how.replace(",", " ").split()[0], []).append(name)
    return "; ".join(", ".join(names) + HELD[how][len(names) > 1] for how, names in groups.items())


def _interval(start: float, end: float) -> str:
    """From when to when; where the digits do not tell the two apart, when and for how long."""
    first, last = f"{start:.12g}", f"{end:.12g}"
    return f"from {first} s to {last} s" if first != last else f"at {first} s for {end - start:.1g} s"


PARTS = np.linspace(0.0, 1.0, 18)[1:-1]
"""Of the time between two rows, at which energies are looked at."""


def energy_moved(run: Run) -> float:
    """The most energy (J) that the mechanism had above the lowest potential it came to: what drifts are part of.

    Where events have set parameters it is that between two of them: their energies count from heights and lengths of
    their own, and what comes in at the event itself is no motion.
    """
    found = 0.0
    for kinetic, potential in _energies(run):
        found = max(found, float(np.max(kinetic + potential) - np.min(potential)))
    return found


def energy_scale(run: Run) -> float:
    """An energy (J) of the mechanism's size, also of one that rests: the largest kinetic energy that it has where it
    begins, if one coordinate alone moves by a radian, or a length of the mechanism, in its characteristic time."""
    rows = run.in_force.at_rows(len(run.t))
    firsts = [int(np.argmax(rows == number)) for number in range(len(run.in_force.models))]
    models = cast("list[Model]", run.in_force.models)
    return max(float(model.kernels.heaviest(run.q[first])) for model, first in zip(models, firsts, strict=True))


def _energies(run: Run) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Kinetic and potential energies (J) of every span between events that set something: at its rows, and at instants
    between those about the row with the most energy and about that with the least potential one."""
    in_force = run.in_force
    ends = [*in_force.rows[1:].tolist(), len(run.t)]
    for number, first, end in zip(in_force.which.tolist(), in_force.rows.tolist(), ends, strict=True):
        model = cast("Model", in_force.models[number])
        kinetic, potential = model.energy(run.q[first:end], run.u[first:end])
        highest, lowest = first + int(np.argmax(kinetic + potential)), first + int(np.argmin(potential))
        rows = {row for most in (highest, lowest) for row in (most - 1, most) if first <= row < end - 1}
        between = [run.t[row] + (run.t[row + 1] - run.t[row]) * PARTS for row in sorted(rows)]
        if between:
            more, farther = model.energy(*run.at(np.concatenate(between)))
            kinetic, potential = np.append(kinetic, more), np.append(potential, farther)
        yield kinetic, potential


def moves(run: Run) -> bool:
    """Whether the energy that moves is more than the rounding of energies."""
    return energy_moved(run) > rounding_of_energy(run)


def rounding_of_energy(run: Run) -> float:
    """How much of an energy (J) of the run is rounding."""
    potential = max(float(np.max(np.abs(potential))) for _, potential in _energies(run))
    rounding: float = run.model.core.TOLERANCES["ENERGY_ROUNDING"].value
    return rounding * (energy_scale(run) + potential)


def drift_of_energy(run: Run) -> str:
    """By how much the energy drifts, in words, where that is too much; else empty.

    A drift is compared with the energy that moves. Where nothing moves, it can only be of the work of loads that hold
    each other, whose rounding grows with them and with time: it is compared with the scale of energy.
    """
    if not moves(run):
        too_much = run.energy_drift > DRIFT * energy_scale(run)
        return f"{run.energy_drift:.2g} J although nothing moves" if too_much else ""
    share = run.energy_drift / energy_moved(run)
    return f"{100 * share:.2g} % of the energy that moves" if share > DRIFT else ""


def print_audit(run: Run) -> None:
    """How far the run got, at what cost, and how exact it was."""
    steps = int(np.count_nonzero(np.diff(run.t)))
    kept = f"{run.energy_drift:.1e} J" + (
        f" of {energy_moved(run):.3g} J above its lowest" if moves(run) else ", nothing moves"
    )
    loops = f"loops closed to {run.closure_max:.1e} m, " if run.model.closure(run.q[:1]).size else ""
    deep = f"contacts at most {run.penetration_max:.1e} m deep, " if run.model.contacts else ""
    jumps = total(abs(event.energy) for event in run.events)
    apart = f" beside jumps of {jumps:.3g} J in all at events" if jumps and jumps > rounding_of_energy(run) else ""
    taken = total(phase.taken for phase in run.phases)
    beside = f", beside {taken:.3g} J that contacts took in steps" if abs(taken) > rounding_of_energy(run) else ""
    typer.echo(
        f"t = {run.t[-1]:.10g} s, impacts: {len(run.impacts)}, steps: {steps}, evaluations: {run.nfev}\n"
        f"audit: {loops}{deep}energy kept to {kept}{apart}{beside}; method {run.method}"
    )


def print_warnings(run: Run) -> None:
    """What makes the run's figures doubtful, on standard error."""
    if eased := [impact for impact in run.impacts if impact.restitution_share < 1.0]:
        least = min(impact.restitution_share for impact in eased)
        typer.echo(
            f"warning: {len(eased)} of {len(run.impacts)} impacts, the first at t = {eased[0].t:.6g} s, would have "
            f"gained energy by {run.model.data['law'].title()}'s law, or have no impulses by it; their contacts have "
            f"the largest part of their restitution that has some and gains none, {least:.0%} of it at least; "
            'law = "stronge" in [run] never gains',
            err=True,
        )
    if run.rest_speed > 0.0:
        typer.echo(
            f"note: events crowded, or friction jammed, so that contacts that still moved, "
            f"at {run.rest_speed:.1e} m/s at most, counted as at rest",
            err=True,
        )
    if run.choices:
        instants = f"{run.choices} instant{'s' * (run.choices > 1)}"
        if run.chosen_at is not None:  # files of earlier versions do not have it
            instants += f", the first at t = {run.chosen_at:.6g} s,"
        typer.echo(
            f"note: at {instants} contacts that slide could as well have stayed as left (Painleve); they left",
            err=True,
        )
    if run.method != "moreau" and (steps := [phase for phase in run.phases if phase.kind == "steps"]):
        share = total(phase.end - phase.start for phase in steps) / (run.t[-1] - run.t[0])
        typer.echo(
            f"note: {len(steps)} stretch{'es' * (len(steps) > 1)} from t = {steps[0].start:.6g} s on, {share:.1e} of "
            "the run, went on by time stepping, where event by event did not get further; the steps miss "
            f"{total(phase.missed for phase in steps):.0e} rad or lengths there",
            err=True,
        )
        _print_taken(run, steps)
    if run.acceleration_error > INEXACT:
        typer.echo(
            f"warning: masses differ so much that accelerations are known to {run.acceleration_error:.0e} of the "
            "largest only; make light links that carry heavy ones heavier, or leave them out",
            err=True,
        )
    if drift := drift_of_energy(run):
        finer = "a shorter step" if run.method == "moreau" else "a smaller rtol"
        advice = f"ask for {finer}, or trust only the beginning"
        typer.echo(f"warning: the energy drifts by {drift}{_where(run)}; {advice}", err=True)


def _print_taken(run: Run, steps: Sequence[Phase]) -> None:
    """Where contacts took energy in time stepping, which no impact tells, and how much."""
    most = max(steps, key=lambda phase: abs(phase.taken))
    moved = energy_moved(run)
    if abs(most.taken) <= DRIFT * moved:
        return
    what = "contacts took" if most.taken > 0.0 else "contacts, and what drives gave at them, added"
    typer.echo(
        f"warning: {what} {abs(most.taken):.3g} J, {100 * abs(most.taken) / moved:.2g} % of the energy that moves, by "
        f"time stepping {_interval(most.start, most.end)}, in no impact that is recorded; trust only what is before, "
        "or compare with another method and rtol",
        err=True,
    )


def _where(run: Run) -> str:
    """Between which rows most of a drift has come, and how much there; nothing where no two rows tell most of it."""
    if not run.unexplained.size:
        return ""
    changes = np.diff(run.unexplained)
    row = int(np.argmax(np.abs(changes)))
    if not abs(changes[row]) > 0.5 * run.energy_drift:
        return ""
    return f", {changes[row]:.3g} J of it at t = {run.t[row]:.6g} s"


def print_trace(run: Run, asked: bool) -> None:
    """What the run did beside steps that were accepted, as far as it is kept if that is ``asked`` for, else the last of
    it where the run stopped early by itself."""
    if asked:
        typer.echo(f"trace, the last {len(run.trace)}:" if run.trace else "trace: nothing beside accepted steps")
    elif not run.success and run.trace and not run.message.endswith("interrupted"):
        typer.echo("what it did last, of which --trace prints more:")
    else:
        return
    lines = _gathered(run)
    for line in lines if asked else lines[-LAST:]:
        typer.echo(f"  {line}")


def _gathered(run: Run) -> list[str]:
    """The lines of the trace; of steps that are refused one after the other the first and the last."""
    lines: list[str] = []
    for refused, group in groupby(run.trace, lambda one: one.refused):
        same = [str(one) for one in group]
        between = [f"... {len(same) - 2} more ..."] if refused and len(same) > 2 else same[1:-1]
        lines += [same[0], *between, *same[1:][-1:]]
    return lines
