"""What closed contacts do next, against every combination tried; and tosses that once stopped where forces exist."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.generator import loop
from ccgen.runtime import Model, simulate

from ..oracles import closed_contacts
from ..support.bodies import penetration
from ..support.reach import Reach
from ..support.tiers import all_hard_but, hard
from ..support.workshop import Workshop
from .fuzz import Toss, faults, run, scene

REDUNDANT = {
    "two that stick beside one that slides": Toss(12, 2, True, "poisson", 0.0, 0.7, 14646826),
    "four that stick beside two that slide": Toss(8, 1, True, "newton", 0.1, 0.3, 45),
    "two pairs on two planes": Toss(6, 2, True, "newton", 0.1, 1.2, 33859),
    "all begin to slide at once": Toss(6, 1, True, "newton", 0.1, 0.3, 426650),
    "sliding for less than a step": Toss(9, 1, True, "newton", 0.1, 0.7, 9),
    "an impact where sliding ends": Toss(7, 2, True, "poisson", 0.5, 0.3, 200),
    "a flat loop beside sticking points": Toss(9, 1, True, "newton", 0.1, 0.3, 1353),
}
MODES = {"sticks": "s", "slides forward": "+", "slides backward": "-"}
MOST = 4
"""Closed contacts whose combinations are all tried."""


@pytest.mark.parametrize(
    "toss",
    all_hard_but(REDUNDANT["two pairs on two planes"], REDUNDANT["all begin to slide at once"], of=REDUNDANT.values()),
    ids=REDUNDANT.keys(),
)
def test_friction_shared_by_more_contacts_than_can_slide(toss: Toss, workshop: Workshop) -> None:
    """Forces are not unique there, motions are: the run goes on to its end."""
    found = run(workshop.model(scene(toss.n, toss.rough)), toss)
    assert found.success, found.message
    assert not faults(found)


@pytest.mark.parametrize(
    "toss",
    [
        hard(REDUNDANT["two pairs on two planes"]),
        hard(REDUNDANT["all begin to slide at once"]),
        Toss(4, 1, True, "poisson", 0.3, 1.2, 162314),
    ],
    ids=lambda toss: f"{toss.n} rods",
)
def test_what_closed_contacts_do_next(toss: Toss, workshop: Workshop, reach: Reach) -> None:
    """At every change of contacts, the modes that the run takes are consistent, and all consistent ones move alike."""
    found = run(workshop.model(scene(toss.n, toss.rough)), toss)
    checked, several, worst = 0, 0, 0.0
    for phase in found.phases:
        last = int(np.searchsorted(found.t, phase.start, side="right")) - 1
        if phase.kind != "contact" or not set(phase.how) <= set(MODES):
            continue
        one = _decided(found.model, found.q[last], found.u[last], toss.friction, phase)
        if one is None:
            continue
        taken, every = one
        assert every, f"no combination is consistent at t = {phase.start}"
        spread = max(float(np.max(np.abs(taken - motion.accelerations))) for motion in every)
        worst = max(worst, spread / float(np.max(np.abs(taken)) + 9.81))
        checked += 1
        several += len(every) > 1
    assert checked > 20
    reach(f"{toss.n} rods, {checked} decisions, {several} of several forces: accelerations, relative", worst, 1e-7)


def _decided(model: Any, q: Any, u: Any, mu: float, phase: Any) -> Any:
    """Accelerations in the modes that the run took, and all consistent motions; ``None`` where too many are closed."""
    gaps, rates = model.gaps(q), model.gap_rates(q, u)
    slips = model.kernels.of_state("slips", q[None], u[None])[0]
    closed = [int(c) for c in np.flatnonzero((gaps <= 1e-12) & (np.abs(rates) <= 1e-10))]
    held = {model.contacts.index(contact): MODES[how] for contact, how in zip(phase.contacts, phase.how, strict=True)}
    if not set(held) <= set(closed) or len(closed) > MOST:
        return None
    both = [*closed, *(c + gaps.size for c in closed)]
    W, b = closed_contacts.rows(model, q, u)
    W, b = W[np.ix_(both, both)], b[both]
    slides = np.array([0.0 if abs(slips[c]) <= 1e-10 else np.sign(slips[c]) for c in closed])
    taken = closed_contacts.of_modes(W, b, mu, "".join(held.get(c, "o") for c in closed))
    return (taken.accelerations, closed_contacts.motions(W, b, mu, slides)) if taken else None


@pytest.mark.hard
def test_drops_of_a_rough_hexagon(workshop: Workshop, reach: Reach) -> None:
    """Folding onto rough ground by accumulations, sticking and sliding at up to six points: how many reach 10 s"""
    model = workshop.model(loop(6, gravity=True, start={"height": 1.0}, ground=[{"restitution": 0.5, "friction": 0.5}]))
    stopped, deepest = 0, 0.0
    for law in ("newton", "poisson", "stronge"):
        lawful = Model(model._descriptor, {**model.data, "law": law})
        for e in (0.0, 0.3, 0.5, 0.7):
            for mu in (0.1, 0.3, 1.0):
                values = {"ground_0.restitution": e, "ground_0.friction": mu}
                found = simulate(lawful, until=10.0, params=values)
                stopped += not found.success
                deepest = max(deepest, penetration(found))
    reach("36 drops of a rough hexagon: stopped before their end", stopped, 0)
    reach("36 drops of a rough hexagon: penetration, m", deepest, 1e-10)
    damped = simulate(model, until=5.0, drift="damped")
    assert damped.success, damped.message


@pytest.mark.parametrize(
    "toss",
    [
        hard(Toss(7, 2, True, "newton", 0.1, 0.3, 2592)),
        Toss(6, 1, True, "newton", 0.1, 0.1, 15162),
        hard(Toss(8, 1, True, "newton", 0.1, 0.7, 1)),
    ],
    ids=["between two planes", "of six rods", "of eight rods"],
)
def test_friction_at_its_limit_does_no_work(toss: Toss, workshop: Workshop, reach: Reach) -> None:
    """Loops that settle with all contacts at the limits of their friction: none of them may creep along it."""
    found = run(workshop.model(scene(toss.n, toss.rough)), toss)
    assert found.success and not faults(found), found.message
    energy = np.sum(found.model.energy(found.q, found.u), axis=0)
    rises = float(np.max(energy - np.minimum.accumulate(energy))) / abs(float(energy[0]))
    reach(f"friction at its limit, a loop of {toss.n}: rise of energy", rises, 1e-9)
