"""Random mechanisms with parts of every kind drawn in, against the dense reference: gears, racks and belts; springs,
dampers, motors, brakes, play, drives and contacts that give way; ropes, journals, cams, grounds, discs, edges, polygons
and stops.

The reference (``tests/oracles/distances.py`` and ``cams.py``) knows gaps as true distances, in maximal coordinates, and
takes their rows and biases by differences in wide numbers.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings

from ccgen.runtime.model.drives import drive_rows

from ..oracles import distances, maximal
from ..oracles.maximal import WIDE, Array
from ..support.drawn_parts import CAMS, FRICTION, RESTITUTION, Drawn, drawings, rubs
from ..support.random_mechanism_checks import (
    BOUND,
    DRAWN,
    EXAMPLES,
    check_flight,
    check_forces,
    first,
    quasi_accelerations,
    unit_rows,
)
from ..support.workshop import Workshop


def check(drawn: Drawn, workshop: Workshop) -> None:
    """Without contact, then with all parts held, ropes taut and others sticking or sliding: accelerations, forces of
    contacts and joints. Then a smooth impact of each part alone."""
    sketch = drawn.sketch
    model = workshop.model(drawn.toml())
    check_flight(model, sketch, ())
    if not drawn.parts:
        return
    order = [model.contacts.index(contact) for contact in drawn.contacts]
    q, _ = model.state_from_poses(sketch.poses, np.zeros_like(sketch.poses))
    assert np.max(np.abs(model.gaps(q)[order])) <= 1e-14 * max(1.0, np.abs(sketch.poses).max())
    rng = np.random.default_rng(5)
    normals = unit_rows(model, "gap_rates", q)[order]
    rough = [rubs(part) for part in drawn.parts]
    sticking = [bool(rub and rng.random() < 0.5) for rub in rough]
    tangents = unit_rows(model, "slips", q)[order] if any(rough) else np.zeros_like(normals)
    _check_rows(drawn, model, q, normals, tangents)
    closure = np.vstack([model.jacobian(q), drive_rows(model)])
    rows = np.vstack([closure, normals, tangents[sticking]])
    u = rng.normal(size=len(q))
    for _ in range(2):
        u -= np.linalg.lstsq(rows, rows @ u, rcond=None)[0]
    ways = [
        None if s else float(np.sign(t @ u)) if r else 0.0 for s, r, t in zip(sticking, rough, tangents, strict=True)
    ]
    words = {None: "sticks", 1.0: "slides forward", -1.0: "slides backward", 0.0: "smooth"}
    held = {contact: words[way] for contact, way in zip(drawn.contacts, ways, strict=True)}
    poses, velocities = model.poses(q), model.velocities(q, u)
    acting = sketch.acting(poses, velocities)
    friction = [FRICTION if r else 0.0 for r in rough]
    wanted = distances.accelerate(sketch, poses, velocities, acting.wrenches, drawn.parts, ways, friction)
    if wanted.sign <= 0.0:
        with pytest.raises(ValueError, match="friction jams"):
            model.acceleration(q, u, contacts=held)
        return
    motion, forces = wanted.motion, wanted.forces
    scale = max(float(np.max(np.abs(motion.frames))), float(np.max(np.abs(forces))), 1.0)
    found = model.acceleration(q, u, contacts=held)
    assert np.max(np.abs(found - quasi_accelerations(model, poses, velocities, motion.frames))) <= BOUND * scale
    assert np.max(np.abs(model.contact_forces(q, u, contacts=held)[order] - forces)) <= 10.0 * BOUND * scale
    check_forces(model, sketch, q, u, motion, held)
    _check_impacts(drawn, model, q, closure, normals, rng)


def _check_rows(drawn: Drawn, model: Any, q: Array, normals: Array, tangents: Array) -> None:
    """Gaps change and surfaces slide as distances do."""
    system, poses = drawn.sketch.system, model.poses(q).astype(WIDE)
    rows = distances.rows_of(system, drawn.parts, [True] * len(drawn.parts), poses, np.zeros_like(poses)).rows
    moved = [
        maximal.centre_velocities(system, poses, model.velocities(q, unit).astype(WIDE)) for unit in np.eye(len(q))
    ]
    wanted = rows.astype(float) @ np.array([one.ravel() for one in moved], dtype=float).T
    assert np.max(np.abs(np.vstack([normals, tangents]) - wanted)) <= BOUND * max(1.0, float(np.abs(wanted).max()))


def _check_impacts(
    drawn: Drawn, model: Any, q: Array, closure: Array, normals: Array, rng: np.random.Generator
) -> None:
    smooth = model.with_parameters(
        {
            f"{name.partition('.')[0]}.friction": 0.0
            for (_, name), part in zip(drawn.contacts, drawn.parts, strict=True)
            if rubs(part)
        }
    )
    for part, contact, normal in zip(drawn.parts, drawn.contacts, normals, strict=True):
        u = rng.normal(size=len(q))
        if len(closure):
            u -= np.linalg.lstsq(closure, closure @ u, rcond=None)[0]
        u *= -np.sign(normal @ u)
        after, impulse = smooth.impact(q, u, [contact])
        velocities, wanted = distances.strike(drawn.sketch, model.poses(q), model.velocities(q, u), part, RESTITUTION)
        scale = max(float(np.max(np.abs(velocities))), float(abs(wanted)), 1.0)
        assert np.max(np.abs(model.velocities(q, after) - velocities)) <= BOUND * scale
        assert abs(impulse[0] - wanted) <= BOUND * scale


@pytest.mark.hard
@settings(DRAWN, max_examples=60)
@given(drawn=drawings())
@first(12)
def test_ropes_and_journals_are_those_of_the_dense_reference(drawn: Drawn, workshop: Workshop) -> None:
    check(drawn, workshop)


@pytest.mark.hard
@settings(DRAWN, max_examples=60)
@given(drawn=drawings(parts=CAMS))
@first(12)
def test_cams_are_those_of_the_dense_reference(drawn: Drawn, workshop: Workshop) -> None:
    check(drawn, workshop)


@pytest.mark.hard
@settings(DRAWN, max_examples=30)
@given(drawn=drawings(parts=("slide end",)))
@first(12)
def test_ends_of_slides_are_those_of_the_dense_reference(drawn: Drawn, workshop: Workshop) -> None:
    check(drawn, workshop)


@settings(DRAWN, max_examples=3)
@given(drawn=drawings(every=True))
def test_a_few_mechanisms_of_all_parts_are_those_of_the_dense_reference(drawn: Drawn, workshop: Workshop) -> None:
    check(drawn, workshop)


@pytest.mark.hard
@settings(DRAWN, max_examples=3 * EXAMPLES)
@given(drawn=drawings(every=True))
@first(EXAMPLES // 4)
def test_mechanisms_of_all_parts_are_those_of_the_dense_reference(drawn: Drawn, workshop: Workshop) -> None:
    check(drawn, workshop)
