"""Random sets of contacts that are struck together, in mechanisms of one to six freedoms, by the three laws."""

from __future__ import annotations

import os
import warnings
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from ccgen.generator import chain
from ccgen.runtime import Model, simulate

from ..oracles import march
from ..support.bodies import rod
from ..support.reach import Reach
from ..support.tiers import hard
from ..support.workshop import Workshop

LAWS = ("newton", "poisson", "stronge")
SETS = 10_000
MOST = 6
SLOPES = (0.0, 90.0, -90.0, 180.0, 37.0)
"""Degrees by which the grounds' normals lean: floor, walls that face each other, ceiling, and a slope."""


def _link(name: str, mass: float, *points: str) -> str:
    both = ", ".join(points)
    return f"""
[[link]]
name = "{name}"
mass = {mass}
inertia = {0.09 * mass}
com = [0.4, 0.1]
points = {{ {both} }}
"""


def _joint(first: str, second: str) -> str:
    return f'[[joint]]\nbetween = ["{first}", "{second}"]\n'


def _grounds(points: list[str]) -> str:
    listed = ", ".join(f'"{point}"' for point in points)
    return "".join(
        f"[[ground]]\npoint = [0.1, {-50.0 - k}]\nnormal = [{0.3 + 0.1 * k}, 0.8]\n"
        f"restitution = 0.5\nfriction = 0.3\ncontacts = [{listed}]\n"
        for k in range(len(SLOPES))
    )


ENDS = ("A = [0.0, 0.0]", "B = [1.0, 0.0]")


def _chain(links: int, hinged: bool) -> str:
    masses = (1.0, 0.4, 2.5, 0.8)
    feet = "F = [0.7, -0.3], G = [0.2, -0.3]"
    text = "[ground_link]\npoints = { O = [0.0, 0.3], Q = [1.6, 0.2] }\n"
    text += "".join(_link(f"l{k}", masses[k], *ENDS, feet) for k in range(links))
    text += (_joint("ground.O", "l0.A") if hinged else "") + "".join(
        _joint(f"l{k}.B", f"l{k + 1}.A") for k in range(links - 1)
    )
    if links > 1:
        text += '[[stop]]\njoint = "joint_0"\nlowest = -3.0\nhighest = 3.1\nrestitution = 0.5\n'
    return text + _grounds([f"l{k}.{point}" for k in range(links) for point in "BFG"])


def _loop(links: int, pinned: bool) -> str:
    """Moving links of a closed chain; pinned, the ground is one more."""
    text = "[ground_link]\npoints = { O = [0.0, 0.3], Q = [1.6, 0.2] }\n"
    text += "".join(_link(f"l{k}", 1.0 + 0.3 * k, *ENDS, "F = [0.7, -0.3]") for k in range(links))
    text += "".join(_joint(f"l{k}.B", f"l{k + 1}.A") for k in range(links - 1))
    if pinned:
        text += _joint("ground.O", "l0.A") + _joint("ground.Q", f"l{links - 1}.B")
    else:
        text += _joint(f"l{links - 1}.B", "l0.A")
    text += '[[stop]]\njoint = "joint_0"\nlowest = -3.0\nhighest = 3.1\nrestitution = 0.5\n'
    sketch = np.cumsum(np.full(links, 2.0 * np.pi / (links + pinned))) - 0.4
    angles = ", ".join(f"l{k} = {-float(angle)}" for k, angle in enumerate(sketch))
    return (
        text
        + f"[start]\nangles = {{ {angles} }}\n"
        + _grounds([f"l{k}.{point}" for k in range(links) for point in "BF"])
    )


MECHANISMS = {
    "bar on a pin": _chain(1, True),
    "two links on a pin": _chain(2, True),
    "three links on a pin": _chain(3, True),
    "free body": _chain(1, False),
    "two free links": _chain(2, False),
    "four free links": _chain(4, False),
    "four-bar": _loop(3, True),
    "five-bar": _loop(4, True),
    "free loop of four": _loop(4, False),
    "free loop of six": _loop(6, False),
}


@dataclass
class Set:
    """One set: a state, contacts and e; rows W and rates v without impulses, normals and then tangents."""

    model: Any
    q: Any
    u: Any
    contacts: list[tuple[str, str]]
    mu: Any
    e: Any
    W: Any = field(repr=False)
    v: Any = field(repr=False)


def _rows(model: Any, q: Any, u: Any, chosen: Any) -> tuple[Any, Any]:
    every = len(model.contacts)
    both = np.append(chosen, chosen + every)
    kernels, n = model.kernels, u.size
    many, unit = np.repeat(q[None], n, axis=0), np.eye(n)
    J = np.vstack([kernels.of_state("gap_rates", many, unit).T, kernels.of_state("slips", many, unit).T])[both]
    mass = kernels.of_state("momentum", many, unit).T
    free = np.eye(n)
    if len(model.rows):
        _, values, directions = np.linalg.svd(model.jacobian(q))
        free = directions[int(np.sum(values > 1e-9 * values[0])) :].T
    moved = J @ free
    return moved @ np.linalg.solve(free.T @ mass @ free, moved.T), J @ u


def sets(model: Any, count: int, rng: np.random.Generator) -> list[Set]:
    """Random states of a model at which some contacts approach, each with friction and e of its own."""
    found: list[Set] = []
    stops = np.array([ground in model.stops for _, ground in model.contacts])
    q0, u0 = model.start()
    closed = len(model.rows) > 0
    while len(found) < count:
        rough = rng.uniform(0.0, 2.0, len(SLOPES)) * (rng.random(len(SLOPES)) < 0.8)
        if rng.random() < 0.15:
            rough[:] = 0.0
        values = {}
        for k, degrees in enumerate(SLOPES):
            lean = np.radians(degrees if rng.random() < 0.8 else rng.uniform(-180.0, 180.0))
            values |= {f"ground_{k}.normal.x": float(np.sin(lean)), f"ground_{k}.normal.y": float(np.cos(lean))}
            values[f"ground_{k}.friction"] = float(rough[k])
        moved = model.with_parameters(values)
        for _ in range(8):
            q = q0 + rng.normal(size=q0.size) * (0.15 if closed else 1.0)
            u = rng.normal(size=u0.size) * 10.0 ** rng.uniform(-1, 1)
            try:
                q, u = moved.project(q, u)
            except ValueError:
                continue
            if closed and np.linalg.svd(moved.jacobian(q), compute_uv=False)[-1] < 0.05:
                continue  # near a change point everything is larger
            rates = moved.gap_rates(q, u)
            falling = np.flatnonzero(rates < -1e-3 * np.linalg.norm(u))
            if falling.size < 2:
                continue
            n = int(rng.integers(2, min(MOST, falling.size) + 1))
            chosen = rng.choice(falling, n, replace=False)
            mu = np.array([0.0 if stops[c] else rough[int(moved.contacts[c][1][-1])] for c in chosen])
            e = rng.uniform(0.0, 1.0, n) if rng.random() < 0.5 else np.full(n, rng.choice([0.0, 0.3, 0.7, 1.0]))
            W, v = _rows(moved, q, u, chosen)
            found.append(Set(moved, q, u, [moved.contacts[c] for c in chosen], mu, e, W, v))
    return found[:count]


def _by_law(model: Any, law: str) -> Any:
    return Model(model._descriptor, {**model.data, "law": law}, dict(model.parameters))


@dataclass
class Answer:
    """What a law makes of a set; all rates and energies by the model's kernels."""

    of: Set
    P: Any
    u: Any
    gained: float
    """Of the kinetic energy."""
    recorded: float
    """The loss as runs record it, less that of the kinetic energy, relative to it."""
    opened: float
    """Rate of the loops, m/s, relative to the largest velocity."""


def _answers(every: list[Set], law: str) -> tuple[list[Answer], list[tuple[Set, str]]]:
    """Answers, and sets that are refused with why."""
    found: list[Answer] = []
    refused: list[tuple[Set, str]] = []
    known: tuple[Any, Any] = (None, None)
    for one in every:
        if known[0] is not one.model:
            known = one.model, _by_law(one.model, law)
        model = known[1]
        chosen = [model.contacts.index(contact) for contact in one.contacts]
        u, P, outcome = model.kernels.impact(one.q, one.u, np.array(chosen, dtype=np.int32), one.e)
        if outcome != "done":
            refused.append((one, outcome))
            continue
        many = np.array([one.u, u])
        state = np.repeat(one.q[None], 2, axis=0), many
        moving = 0.5 * np.einsum("ij,ij->i", many, model.kernels.of_state("momentum", *state))
        both = [model.kernels.of_state(rows, *state)[:, chosen] for rows in ("gap_rates", "slips")]
        loss = -0.5 * P @ np.hstack(both).sum(axis=0)
        rates = model.jacobian(one.q) @ u if len(model.rows) else np.zeros(1)
        change = (moving[1] - moving[0]) / moving[0]
        opened = float(np.max(np.abs(rates)) / np.max(np.abs(one.u)))
        found.append(Answer(one, P, u, change, abs(loss / moving[0] + change), opened))
    return found, refused


def _load(W: Any, P: Any) -> float:
    """Normal impulses, summed as they load their contacts."""
    n = len(W) // 2
    return float(np.sqrt(np.diag(W)[:n]) @ P[:n])


def _stacked(answers: list[Answer]) -> tuple[Any, Any, Any, Any]:
    """W, rates, friction and e of all sets, filled up with contacts that nothing strikes."""
    many = len(answers)
    W, v = np.tile(np.eye(2 * MOST), (many, 1, 1)), np.tile(np.repeat([1.0, 0.0], MOST), (many, 1))
    mu, e = np.zeros((many, MOST)), np.zeros((many, MOST))
    for k, answer in enumerate(answers):
        n = len(answer.of.mu)
        rows = np.append(np.arange(n), MOST + np.arange(n))
        W[k][np.ix_(rows, rows)], v[k, rows] = answer.of.W, answer.of.v
        mu[k, :n], e[k, :n] = answer.of.mu, answer.of.e
    return W, v, mu, e


def _beyond_the_march(answers: list[Answer], law: str) -> list[Answer]:
    """Those with more than ten times the impulses of a march. One cut short has less, so it is enough for most."""
    W, v, mu, e = _stacked(answers)
    left = np.arange(len(answers))
    for passes in (30, 300, 3000):
        marched = march.impulses(W[left], mu[left], e[left], v[left], law, passes)
        loads = np.array([_load(W[k], P) for k, P in zip(left, marched, strict=True)])
        found = np.array([_load(answers[k].of.W, answers[k].P) for k in left])
        left = left[found > 10.0 * loads]
    return [answers[k] for k in left]


def _least(one: Set, law: str) -> float:
    """The least load with which the law's own rows can be met without adding energy, all ways tried; by Poisson's and
    Stronge's laws those of compression."""
    n = len(one.mu)
    b = np.append(one.v[:n] * (1.0 + (one.e if law == "newton" else 0.0)), one.v[n:])
    ways = march.ways(one.W, b, one.mu)
    loads = [_load(one.W, P) for P in ways if P @ (2.0 * one.v + one.W @ P) <= 1e-9 * np.abs(P) @ np.abs(one.v)]
    return min(loads, default=0.0)


@pytest.fixture(scope="module", params=[hard(SETS // 50), hard(SETS if os.environ.get("CCGEN_LARGE") else SETS // 5)])
def every(request: pytest.FixtureRequest, workshop: Workshop) -> list[Set]:
    """The sets of mechanisms: 200 of a third of them and 2,000 of all in ``make hard``, 10,000 in ``make figures``."""
    rng, share = np.random.default_rng(20), request.param
    texts = (
        [*MECHANISMS.values()][::3] if share < SETS // 5 else [*MECHANISMS.values()]
    )  # compiling all takes longer than 200 sets
    return [one for text in texts for one in sets(workshop.model(text), share // len(texts), rng)]


@pytest.mark.sample(1)
@pytest.mark.parametrize("law", LAWS)
def test_random_sets_of_contacts(law: str, every: list[Set], reach: Reach) -> None:
    """Impulses of the size that a march gives, no energy gained, loops shut, and the loss that is recorded is that of
    the energy. Newton's law is refused where it has no impulses or would add energy; where its impulses are large, it
    has no others."""
    found, refused = _answers(every, law)
    name = f"{len(every)} random sets, {law}"
    most = 0.25 if law == "newton" else max(1e-3, 1.0 / len(every))  # one at least: a sample is not as fine
    reach(f"{name}: refused, share", len(refused) / len(every), most)
    reach(f"{name}: rate of loops, relative", max(answer.opened for answer in found), 1e-12)
    large = _beyond_the_march(found, law)
    reach(f"{name}: beyond ten times a march, share", len(large) / len(every), 0.05 if law == "newton" else 0.0)
    for answer in large:
        assert _load(answer.of.W, answer.P) <= 10.0 * _least(answer.of, law), answer.of
    usual = [answer for answer in found if not any(answer is other for other in large)]
    reach(f"{name}: energy gained, relative", max(answer.gained for answer in usual), 1e-13)
    reach(f"{name}: loss recorded less that of energy, relative", max(answer.recorded for answer in usual), 1e-12)
    if large:  # impulses have rounding of their size
        reach(f"{name}: energy gained by those beyond, relative", max(answer.gained for answer in large), 1e-11)
        reach(f"{name}: loss recorded of those beyond, relative", max(answer.recorded for answer in large), 1e-11)
    for one, outcome in refused:
        n = len(one.mu)
        if law == "newton" and n <= 3:
            b = np.append(one.v[:n] * (1.0 + one.e), one.v[n:])
            after = [(P, one.W @ P + one.v) for P in march.ways(one.W, b, one.mu)]
            gains = [0.5 * P @ (one.v + rates) for P, rates in after]
            assert all(gain > 0.0 for gain in gains), (outcome, gains)
            assert outcome == ("gained" if gains else "jammed")


def test_laws_agree_without_friction_at_equal_restitution(every: list[Set], reach: Reach) -> None:
    smooth = [one for one in every if not one.mu.any() and np.ptp(one.e) == 0.0]
    assert len(smooth) > len(every) // 50
    after = {law: _answers(smooth, law)[0] for law in LAWS}
    for law in LAWS[1:]:
        worst = 0.0
        for a, b in zip(after[law], after["newton"], strict=True):
            alone = np.max(np.abs(b.of.W * b.P)) / np.max(np.abs(b.of.v))  # rates by impulses that others undo
            worst = max(worst, float(np.max(np.abs(a.u - b.u)) / np.max(np.abs(b.of.u)) / max(1.0, alone)))
        reach(f"{len(smooth)} smooth sets, {law} less newton: velocities, relative", worst, 1e-12)


WEDGE = """
name = "wedge"
[ground_link]
points = {{ O = [0, 1] }}
[[link]]
name = "bar"
mass = 1.0
inertia = 0.1
com = [-0.2, -0.5]
points = {{ H = [0, 0], P = [-0.3, -1.0], Q = [-0.5, -1.0] }}
[[joint]]
between = ["ground.O", "bar.H"]
[start]
angles = {{ bar = -0.2 }}
angular_velocities = {{ bar = 3.0 }}
[[ground]]
restitution = 0.5
friction = 2.0
law = "{law}"
contacts = ["bar.P", "bar.Q"]
[run]
until = 1.0
"""
COMPRESSION = 0.39 * 3.0 / (0.3 + 2.0)
"""N s at P, 0.3 m beside and 1 m below the hinge: the least that ends the spin, against friction at its limit."""


def test_two_feet_wedge_under_a_hinge(workshop: Workshop) -> None:
    """Friction holds them: what compression has taken does not come back, and Poisson's law presses them on."""
    impulses = {}
    for law in LAWS[1:]:
        run = simulate(workshop.model(WEDGE.format(law=law)))
        for impact in run.impacts:
            before, after = (sum(run.model.energy(run.at(impact.t)[0], u)) for u in (impact.u_minus, impact.u_plus))
            assert impact.energy_loss == pytest.approx(before - after, abs=1e-12)
            assert sum(impact.impulses) < 2.0
        impulses[law] = sum(run.impacts[0].impulses)
    assert impulses["stronge"] == pytest.approx(COMPRESSION, rel=1e-9)
    assert impulses["poisson"] == pytest.approx(1.5 * COMPRESSION, rel=1e-9)


@pytest.mark.parametrize("e", [0.3, 0.5, 0.9])
def test_near_a_wedge_expansion_ends(e: float, workshop: Workshop) -> None:
    """Two feet again, at which friction leaves the share c of what they push: e / sqrt(c) times the impulse of
    compression would be needed, and no more than three times that is given."""
    model = _by_law(workshop.model(WEDGE.format(law="stronge")), "stronge")
    for mu in (0.0, 0.1, 0.2, 0.25, 0.27, 0.28, 0.29, 0.295, 0.299, 0.3, 0.31, 2.0):
        share = (0.3 - mu) / (0.3 + mu)
        leaves = 3.0 * min(e * np.sqrt(share), 3.0 * share) if share > 1e-9 else 0.0
        rough = model.with_parameters({"ground_0.friction": mu})
        u, P = rough.impact([0.0], [3.0], [("bar.P", "ground_0"), ("bar.Q", "ground_0")], e)
        assert u[0] == pytest.approx(-leaves, abs=1e-12)
        assert np.sum(P) <= 4.0 * 0.39 * 3.0 / (0.3 + mu) * (1.0 + 1e-12)


@pytest.mark.sample(1)
@pytest.mark.parametrize("ratio", [hard(1e-6), hard(1e-3), hard(1e3), 1e6])
@pytest.mark.parametrize("law", LAWS)
def test_what_sticks_keeps_its_digits_at_any_masses(law: str, ratio: float, workshop: Workshop, reach: Reach) -> None:
    """The end of a free chain of two links comes to rest, whose own link is ``ratio`` times as heavy: impulses are
    corrected by the rates that they give."""
    values = {"l1.mass": ratio, "l1.inertia": 0.09 * ratio, "ground_0.friction": 1e3}
    values |= {"ground_0.normal.x": 0.0, "ground_0.normal.y": 1.0}
    model = _by_law(workshop.model(MECHANISMS["two free links"]).with_parameters(values), law)
    rng, worst, stuck, struck = np.random.default_rng(2), 0.0, 0, ("l1.B", "ground_0")
    index = model.contacts.index(struck)
    for _ in range(200):
        q, u = rng.normal(size=(2, model.start()[0].size))
        if model.gap_rates(q, u)[index] > -0.1:
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            u, _ = model.impact(q, u, [struck], 0.0)
        slip = model.kernels.of_state("slips", q[None], u[None])[0][index]
        if abs(slip) < 1e-3:
            worst = max(worst, abs(slip), abs(model.gap_rates(q, u)[index]))
            stuck += 1
    assert stuck > 50
    reach(f"a chain that sticks, masses 1 : {ratio:g}, {law}: velocity, m/s", worst, 1e-12)


@pytest.mark.parametrize("mu", [1.0, 1e3, 1e6, 1e9])
@pytest.mark.parametrize("law", LAWS)
def test_what_sticks_keeps_its_digits_at_any_friction(law: str, mu: float, workshop: Workshop, reach: Reach) -> None:
    """A free rod whose lower end comes to rest: how large the friction could be does not matter."""
    smooth = workshop.model(rod(0.3, 1.0, (0.0, 0.0)))
    model = _by_law(smooth.with_parameters({"ground_0.friction": mu}), law)
    rng, impulse, speed, stuck = np.random.default_rng(1), 0.0, 0.0, 0
    for _ in range(200):
        angle, v = rng.uniform(-1.4, 1.4), np.array([-abs(rng.normal()), rng.normal()])
        x, y = -0.5 * np.cos(angle), -0.5 * np.sin(angle)
        W = np.array([[1 + 12 * x * x, -12 * x * y], [-12 * x * y, 1 + 12 * y * y]])
        P = -np.linalg.solve(W, v)
        if P[0] < 0.0 or abs(P[1]) > mu * P[0]:
            continue
        q, u = model.state_from_poses([[0.0, 0.0, angle]], [[v[1], v[0], 0.0]])
        u, found = model.impact(q, u, [("rod.A", "ground_0")], 0.0)
        impulse = max(impulse, abs(found[0] - P[0]) / float(np.max(np.abs(P))))
        speed = max(speed, float(np.max(np.abs(model.velocities(q, u)[0][:2]))))
        stuck += 1
    assert stuck > 50
    reach(f"a rod that sticks, mu = {mu:g}, {law}: normal impulse, relative", impulse, 1e-14)
    reach(f"a rod that sticks, mu = {mu:g}, {law}: velocity, m/s", speed, 1e-14)


def test_an_impact_that_would_add_energy_is_told_as_in_a_run(workshop: Workshop) -> None:
    """T. R. Kane's double pendulum by Newton's law, struck by itself and in a run: one sentence for both."""
    angles = np.radians([-70.0, -60.0])
    ground = [
        {"point": [0.0, float(np.sum(np.sin(angles)))], "restitution": 0.7, "friction": 0.5, "contacts": ["link_1.B"]}
    ]
    model = workshop.model(chain(2, hinged=True, gravity=True, ground=ground))
    run = simulate(model, angles, [-0.1, -0.2], until=0.001, on_gain="stop")
    with pytest.raises(ValueError, match="would add energy") as raised:
        model.impact(run.q[-1], run.u[-1], [("link_1.B", "ground_0")])
    assert run.message.split(": ", 1)[1] in str(raised.value)
