"""What ``ccgen run`` prints of a run: its impacts as a table, and its audit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import typer

if TYPE_CHECKING:
    from ccgen.runtime import Impact, Model, Run

SHOWN = 40
"""Impacts printed; a longer list is cut, the result file has them all."""
CONTACTS = 8
"""Stretches of contact printed, the last ones."""
WIDTH = 140
DRIFT = 1e-4
"""Share of the energy that moves beyond which a drift is warned of."""
INEXACT = 1e-9
"""Part of the largest acceleration beyond which an error that masses are at fault for is warned of."""


def print_impacts(model: Model, run: Run) -> None:
    """The impacts as a table: when, which points, how fast they came, the impulses, the energy lost and left."""
    if not run.impacts:
        typer.echo("no impacts")
        return
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for title in ("#", "t, s"):
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("contacts", no_wrap=True)
    units = ("rad/s", "N m s") if len(model.stops) == len(model.contacts) else ("m/s, rad/s", "N s, N m s")
    speed, push = units if model.stops else ("m/s", "N s")
    for title in (f"speed before, {speed}", f"impulse, {push}", "energy lost, J", "energy after, J"):
        table.add_column(title, justify="right", no_wrap=True)
    for number, impact in enumerate(run.impacts[:SHOWN], 1):
        table.add_row(str(number), *row(model, run, impact))
    Console(width=WIDTH, highlight=False, soft_wrap=True).print(table)
    if len(run.impacts) > SHOWN:
        typer.echo(f"and {len(run.impacts) - SHOWN} more, in result.npz")


def row(model: Model, run: Run, impact: Impact) -> tuple[str, ...]:
    """The cells of one impact; contacts that struck together stand below each other."""
    q = run.q[np.searchsorted(run.t, impact.t)]
    rates = model.gap_rates(q, impact.u_minus)
    speeds = [rates[model.contacts.index(contact)] for contact in impact.contacts]
    names = _names(model, impact.contacts)
    return (
        f"{impact.t:.12f}",
        "\n".join(names),
        "\n".join(f"{speed:z.9f}" for speed in speeds),
        "\n".join(f"{impulse:z.9f}" for impulse in impact.impulses),
        f"{impact.energy_loss:z.9f}",
        f"{sum(model.energy(q, impact.u_plus)):z.9f}",
    )


def _names(model: Model, contacts: Sequence[tuple[str, str]]) -> list[str]:
    """What touches what; what alone, where there is but one ground and no stop."""
    single = len({ground for _, ground in model.contacts}) == 1 and not model.stops
    return [point if single else f"{point} on {ground}" for point, ground in contacts]


def print_contacts(model: Model, run: Run) -> None:
    """Stretches of contact, from when to when, and the points that stay closed; one line for each set of points."""
    stretches: list[list[Any]] = []
    for phase in run.phases:
        if phase.kind != "contact":
            continue
        words = ", ".join(_names(model, phase.contacts))
        if stretches and stretches[-1][1:] == [phase.start, words]:
            stretches[-1][1] = phase.end
        else:
            stretches.append([phase.start, phase.end, words])
    for start, end, words in stretches[-CONTACTS:]:
        typer.echo(f"contact from {start:.12g} s to {end:.12g} s: {words}")
    if len(stretches) > CONTACTS:
        typer.echo(f"and {len(stretches) - CONTACTS} stretches of contact before, in result.npz")


def energy_moved(run: Run) -> float:
    """The most energy (J) that the mechanism had above the lowest potential it came to: what drifts are part of."""
    kinetic, potential = run.model.energy(run.q, run.u)
    return float(np.max(kinetic + potential) - np.min(potential))


def print_audit(run: Run) -> None:
    """How far the run got, at what cost, and how exact it was."""
    steps = int(np.count_nonzero(np.diff(run.t)))
    moved = energy_moved(run)
    typer.echo(
        f"t = {run.t[-1]:.10g} s, impacts: {len(run.impacts)}, steps: {steps}, evaluations: {run.nfev}\n"
        f"audit: loops closed to {run.closure_max:.1e} m, energy kept to {run.energy_drift:.1e} J of {moved:.3g} J; "
        f"method {run.method}"
    )


def print_warnings(run: Run) -> None:
    """What makes the run's figures doubtful, on standard error."""
    moved = energy_moved(run)
    if eased := [impact for impact in run.impacts if impact.restitution_share < 1.0]:
        least = min(impact.restitution_share for impact in eased)
        typer.echo(
            f"warning: {len(eased)} of {len(run.impacts)} impacts, the first at t = {eased[0].t:.6g} s, would have "
            f"gained energy by {run.model.data['law'].title()}'s law; their contacts have the largest part of their "
            f'restitution that gains none, {least:.0%} of it at least; law = "stronge" in [run] never gains',
            err=True,
        )
    if run.rest_speed > 0.0:
        typer.echo(
            f"note: events crowded so that contacts slower than {run.rest_speed:.1e} m/s counted as at rest", err=True
        )
    if run.choices:
        typer.echo(
            f"note: at {run.choices} instant{'s' * (run.choices > 1)} contacts that slide could as well have stayed as "
            "left (Painleve); they left",
            err=True,
        )
    if run.method != "moreau" and (steps := [phase for phase in run.phases if phase.kind == "steps"]):
        share = sum(phase.end - phase.start for phase in steps) / (run.t[-1] - run.t[0])
        typer.echo(
            f"note: {len(steps)} stretch{'es' * (len(steps) > 1)} from t = {steps[0].start:.6g} s on, {share:.1e} of "
            "the run, went on by time stepping, where event by event did not get further; the steps miss "
            f"{sum(phase.missed for phase in steps):.0e} rad or lengths there",
            err=True,
        )
    if run.acceleration_error > INEXACT:
        typer.echo(
            f"warning: masses differ so much that accelerations are known to {run.acceleration_error:.0e} of the "
            "largest only; make light links that carry heavy ones heavier, or leave them out",
            err=True,
        )
    if run.energy_drift > DRIFT * moved:
        share = f"{100 * run.energy_drift / moved:.2g} % of the energy that moves"
        typer.echo(
            f"warning: the energy drifts by {share}; ask for a smaller rtol, or trust only the beginning", err=True
        )
