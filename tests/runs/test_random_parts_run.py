"""Short runs of random mechanisms with parts of every kind drawn in, a little apart at the start, half of them with a
joint that lets go: flight, impacts and contact keep to energy, closure and gaps, and none stops without reason."""

from __future__ import annotations

import pickle
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given, note, settings
from hypothesis import strategies as st

from ccgen.generator.scene.changes import GO_ALONG
from ccgen.runtime import simulate
from ccgen.runtime.model.drives import drive_rows
from ccgen.runtime.model.masses import mass_matrix

from ..support.drawn_parts import FRICTION, Drawn, drawings
from ..support.random_mechanism_checks import DRAWN, EXAMPLES, Array, first, unit_rows
from ..support.workshop import Workshop

SLACK, UNTIL = 0.03, 1.0
NEAR = 1e-8  # of gaps (m), and of what sums of velocities and impulses come to


def may_let_go(drawn: Drawn) -> list[str]:
    """Joints at which nothing is that has to stay."""
    staying = [one for one in drawn.sketch.tables if one.partition("]]")[0].strip("[") not in ("joint", *GO_ALONG)]
    names = [f"joint_{k}" for k in range(len(drawn.sketch.kinds))]
    return [name for name in names if not any(f'"{name}"' in one for one in staying)]


def check(drawn: Drawn, release: bool, workshop: Workshop) -> None:
    text, free = drawn.toml(), may_let_go(drawn) if release else []
    if free:
        text += f'[[release]]\njoint = "{free[0]}"\nat = {0.3 * UNTIL}\n'
    note(text)
    model = workshop.model(text)
    q, u = model.start()
    held = np.vstack([model.jacobian(q), drive_rows(model)])
    moved = np.random.default_rng(7).normal(size=len(u))
    for _ in range(2 if len(held) else 0):
        moved -= np.linalg.lstsq(held, held @ moved, rcond=None)[0]
    run = simulate(model, q, u + moved, until=UNTIL, rtol=1e-9)
    energies = np.sum(run.model.energy(run.q, run.u), axis=0)
    assert run.energy_drift <= 1e-7 * max(1.0, float(np.max(np.abs(energies))))
    assert run.closure_max <= 1e-11
    gaps = run.model.gaps(run.q)
    assert np.min(gaps[np.isfinite(gaps)], initial=0.0) >= -1e-11
    assert np.array_equal(pickle.loads(pickle.dumps(run)).q, run.q)
    if run.success:
        assert run.t[-1] == UNTIL and len(run.changes) == len(free[:1])
        return
    if "friction jams" in run.message:
        assert jams(at_the_end(run), run)
    elif "comes to a stop after" in run.message:
        assert at_a_dead_point(at_the_end(run), run)
    else:
        assert "whose prescribed motion no impact can change" in run.message, run.message


def at_the_end(run: Any) -> Any:
    """The model of what the mechanism is at the end of a run."""
    return run.in_force.models[run.in_force.which[-1]]


def closed_rows(model: Any, q: Array) -> Array:
    """Those of joints that hold, and of drives."""
    rows = np.vstack([model.jacobian(q), drive_rows(model)])
    return np.asarray(rows[np.any(rows != 0.0, axis=1)])


def at_a_dead_point(model: Any, run: Any) -> bool:
    """Whether what keeps loops and contacts comes near to leaving nothing to the drives."""
    q = run.q[-1]
    held = [model.contacts.index(contact) for contact in run.phases[-1].contacts]
    rows = np.vstack([closed_rows(model, q), unit_rows(model, "gap_rates", q)[held]])
    values = np.linalg.svd(rows, compute_uv=False)
    return bool(values[-1] <= 0.1 * values[0])


def jams(model: Any, run: Any) -> bool:
    """Whether friction turns the push of a contact that is closed into a pull, N W (N − μ T)ᵀ <= 0 one way or the
    other, with W the mobility that closure and drives leave: sliding comes to where it is 0, known to rounding. Or
    whether no modes of all that is closed bring its contacts to rest together."""
    q, u = run.state.q, run.state.u
    rows = closed_rows(model, q)
    none = np.zeros((len(rows), len(rows)))
    mobility = np.linalg.inv(np.block([[mass_matrix(model, q), rows.T], [rows, none]]))[: len(q), : len(q)]
    closed = np.abs(model.gaps(q)) < NEAR
    normals, tangents = unit_rows(model, "gap_rates", q)[closed], unit_rows(model, "slips", q)[closed]
    pairs = zip(normals, tangents, strict=True)
    if any(n @ mobility @ n <= (1.0 + NEAR) * FRICTION * abs(n @ mobility @ t) for n, t in pairs):
        return True
    every = np.vstack([normals, tangents])
    delassus, before = every @ mobility @ every.T, every @ u
    return not any(settles(delassus, before, modes) for modes in product("osfb", repeat=len(normals)))


def settles(delassus: Array, before: Array, modes: tuple[str, ...]) -> bool:
    """Whether an impact without restitution ends in these modes, one for each contact: open, sticking, or slipping
    forward or back. ``delassus`` and ``before``, the velocities before it, are of the normals and then the tangents."""
    count = len(modes)
    equations, right = np.zeros_like(delassus), np.zeros_like(before)
    for k, mode in enumerate(modes):
        normal, tangent = k, count + k
        if mode == "o":
            equations[normal, normal] = equations[tangent, tangent] = 1.0
            continue
        equations[normal], right[normal] = delassus[normal], -before[normal]
        if mode == "s":
            equations[tangent], right[tangent] = delassus[tangent], -before[tangent]
        else:
            equations[tangent, tangent], equations[tangent, normal] = 1.0, FRICTION if mode == "f" else -FRICTION
    impulse = np.linalg.lstsq(equations, right, rcond=1e-12)[0]
    after = before + delassus @ impulse
    slack = NEAR * (1.0 + np.max(np.abs(before)) + np.max(np.abs(impulse)))
    pushes, slips = impulse[:count], after[count:]
    signs = np.array([{"f": 1.0, "b": -1.0}.get(mode, 0.0) for mode in modes])
    return bool(
        np.linalg.norm(equations @ impulse - right) <= slack
        and np.all(pushes >= -slack)
        and np.all(after[:count] >= -slack)
        and np.all(np.abs(impulse[count:]) <= FRICTION * pushes + slack)
        and np.all(signs * slips >= -slack)
    )


EVERY = {"drawn": drawings(every=True, slack=SLACK), "release": st.booleans()}


@settings(DRAWN, max_examples=2)
@given(**EVERY)
def test_a_few_mechanisms_of_all_parts_run(drawn: Drawn, release: bool, workshop: Workshop) -> None:
    check(drawn, release, workshop)


@pytest.mark.hard
@settings(DRAWN, max_examples=3 * EXAMPLES)
@given(**EVERY)
@first(EXAMPLES // 4)
def test_mechanisms_of_all_parts_run(drawn: Drawn, release: bool, workshop: Workshop) -> None:
    check(drawn, release, workshop)
