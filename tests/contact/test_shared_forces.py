"""Forces that rigid bodies leave open: of all that Coulomb's law allows, those of least norm."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import nnls

from ccgen.runtime import simulate, static_equilibrium

from ..support.workshop import Workshop

Array = NDArray[np.float64]
G = 9.81
DEEP = -0.5
"""m: height of the feet in the frame of a table"""


def least(balance: Array, load: Array, feet: int, mu: float, slides: float = 0.0) -> Array:
    """Forces (feet, 2) with ``balance @ (normals, frictions, others) = load``, least of feet, which may all slide along
    the sign ``slides``.

    Each is a sum of the two edges of its cone, with shares that are not negative: least squares in these, the balance,
    freed of the others, counting 10^5 times."""
    left, values, _ = np.linalg.svd(balance[:, 2 * feet :])
    bare = left[:, int(np.sum(values > 1e-9)) :].T
    sides = [-slides] if slides else [1.0, -1.0] if mu else [0.0]
    edges = np.concatenate([np.concatenate([np.eye(feet), side * mu * np.eye(feet)]) for side in sides], axis=1)
    sure = 1e5
    rows = np.concatenate([sure * bare @ balance[:, : 2 * feet] @ edges, edges])
    shares, _ = nnls(rows, np.concatenate([sure * bare @ load, np.zeros(2 * feet)]), maxiter=1000)
    found = edges @ shares
    assert np.max(np.abs(bare @ (balance[:, : 2 * feet] @ found - load))) < 1e-6 * np.max(np.abs(load))
    return np.asarray(found.reshape(2, feet).T, dtype=float)


def plate(name: str, feet: Array, mass: float, com: float, more: str = "") -> str:
    points = ", ".join([f"F{i} = [{float(x)!r}, {DEEP}]" for i, x in enumerate(feet)] + [more] * bool(more))
    text = f'[[link]]\nname = "{name}"\nmass = {mass!r}\ninertia = 3.0\ncom = [{com!r}, 0]\n'
    return text + f"points = {{ {points} }}\n"


def grounds(mu: float, **feet: Array) -> str:
    names = ", ".join(f'"{name}.F{i}"' for name, xs in feet.items() for i in range(len(xs)))
    rough = f"friction = {mu!r}\n" if mu else ""
    return f"[gravity]\n[[ground]]\nrestitution = 0.0\n{rough}contacts = [{names}]\n[run]\nuntil = 0.1\n"


def agree(model: Any, wanted: Array, spread: float = 1e-8) -> None:
    """Along a run and at its state; where nothing moves also in equilibrium, joints' forces alike."""
    run = simulate(model)
    assert run.success, run.message
    size = np.max(np.abs(wanted))
    q, u = run.at(0.05)
    for found in (run.contact_forces(0.05), model.contact_forces(q, u)):
        np.testing.assert_allclose(found, wanted, atol=spread * size)
    if np.max(np.abs(u)) < 1e-9:
        rest = static_equilibrium(model, q)
        np.testing.assert_allclose(rest.contact_forces, wanted, atol=spread * size)
        np.testing.assert_allclose(run.reactions(0.05), rest.reactions, atol=spread * size)
        np.testing.assert_allclose(model.reactions(q, u), rest.reactions, atol=spread * size)


@pytest.mark.parametrize("mu", [0.0, 0.5, 2.0])
def test_four_legs_share_alike(mu: float, workshop: Workshop) -> None:
    feet = np.linspace(-1.0, 1.0, 4)
    text = (
        'name = "table"\n'
        + plate("table", feet, 10.0, 0.0)
        + "[start]\nposition = [0, 0.5]\n"
        + grounds(mu, table=feet)
    )
    agree(workshop.model(text), np.array([[10.0 * G / 4, 0.0]] * 4))


def table(rng: Any, workshop: Workshop) -> None:
    """Three to eight feet, a load off the middle, and one along the ground, up to most that friction holds"""
    n = int(rng.integers(3, 9))
    feet, mass, mu = np.sort(rng.uniform(-1, 1, n)), 10.0, float(rng.choice([0.0, 0.2, 0.5, 1.0, 2.0]))
    com = float(rng.uniform(0.9 * feet[0], 0.9 * feet[-1]))
    pushed = float(rng.choice([0.0, 0.3, 0.8])) * mu * mass * G
    text = f'name = "table"\n{plate("table", feet, mass, com)}[start]\nposition = [0, 0.5]\n{grounds(mu, table=feet)}'
    if pushed:
        text += f'[[force]]\npoint = "table.F0"\nvector = [{pushed!r}, 0]\n'
    balance = np.zeros((3, 2 * n))
    balance[0, :n] = balance[1, n:] = 1.0
    balance[2, :n], balance[2, n:] = feet - com, -DEEP
    agree(workshop.model(text), least(balance, np.array([mass * G, -pushed, DEEP * pushed]), n, mu))


def ring(
    a: Array, b: Array, mass: Array, com: Array, mu: float, heights: list[float], speed: float = 0.0
) -> tuple[str, Array]:
    """Two plates that bars at these heights join, and the forces of their feet"""
    names = [f"P{k}" for k in range(len(heights))]
    text = 'name = "ring"\n'
    for name, feet, i, side in (("a", a, 0, 1.0), ("b", b, 1, -1.0)):
        points = ", ".join(f"{p} = [{side}, {y!r}]" for p, y in zip(names, heights, strict=True))
        text += plate(name, feet, float(mass[i]), float(com[i]), points)
    for k, name in enumerate(names):
        text += f'[[link]]\nname = "bar{k}"\nmass = {float(mass[2 + k])!r}\ninertia = 0.5\ncom = [1, 0]\n'
        text += "points = { A = [0, 0], B = [2, 0] }\n"
        text += f'[[joint]]\nbetween = ["a.{name}", "bar{k}.A"]\n[[joint]]\nbetween = ["bar{k}.B", "b.{name}"]\n'
    text += f"[start]\nposition = [-2, 0.5]\nvelocity = [{speed!r}, 0]\n{grounds(mu, a=a, b=b)}"
    n = len(a) + len(b)
    pins = [
        ends
        for k, y in enumerate(heights)
        for ends in ((("a", 1.0, y), (f"bar{k}", 0.0, 0.0)), ((f"bar{k}", 2.0, 0.0), ("b", -1.0, y)))
    ]
    rows, load = [], []
    links = ["a", "b", *(f"bar{k}" for k in range(len(heights)))]
    for link, m, c in zip(links, mass, (*com, *[1.0] * len(heights)), strict=True):
        balance = np.zeros((3, 2 * n + 2 * len(pins)))  # along x, along y, moments about the link's own frame
        for i, (on, x) in enumerate([("a", x) for x in a] + [("b", x) for x in b]):
            if on == link:
                balance[1, i], balance[2, i], balance[0, n + i], balance[2, n + i] = 1.0, x, 1.0, -DEEP
        for k, ends in enumerate(pins):
            for sign, (on, x, y) in zip((-1.0, 1.0), ends, strict=True):
                if on == link:
                    balance[[0, 2], 2 * n + 2 * k] += sign, -sign * y
                    balance[[1, 2], 2 * n + 2 * k + 1] += sign, sign * x
        rows.append(balance)
        load += [-np.sign(speed) * mu * m * G, m * G, m * G * c]
    return text, least(np.concatenate(rows), np.array(load), n, mu, np.sign(speed))


def loop(rng: Any, workshop: Workshop) -> None:
    """Two plates on two to four feet each, which two bars between them make a loop"""
    a, b = (np.sort(rng.uniform(-1, 1, int(rng.integers(2, 5)))) for _ in range(2))
    mu, mass, com = float(rng.choice([0.0, 0.3, 1.0, 2.0])), rng.uniform(1, 10, 4), rng.uniform(-0.5, 0.5, 2)
    text, wanted = ring(a, b, mass, com, mu, [0.2, -0.1])
    agree(workshop.model(text), wanted)


@pytest.mark.parametrize("mu", [0.0, 0.1, 0.2, 0.5])
def test_contacts_beside_a_loop_that_closes_twice(mu: float, workshop: Workshop) -> None:
    """A third bar that is as the others closes what is closed: the feet's forces are as without it, its weight apart"""
    feet = np.array([-0.9, -0.2, 0.5]), np.array([-0.5, 0.1, 0.8])
    text, wanted = ring(*feet, np.array([5.0, 5.0, 1.0, 1.0, 1.0]), np.array([0.2, 0.2]), mu, [0.2, -0.1, 0.05])
    model = workshop.model(text)
    agree(model, wanted)
    run = simulate(model)
    assert [phase.kind for phase in run.phases] == ["contact"] and not run.impacts and len(run.t) < 20
    assert np.all(np.abs(run.contact_forces(0.05)[:, 1]) <= mu * run.contact_forces(0.05)[:, 0] + 1e-9)


@pytest.mark.parametrize("heights", [[0.2, -0.1], [0.2, -0.1, 0.05]])
def test_feet_that_slide_under_loops(heights: list[float], workshop: Workshop) -> None:
    feet, bars = (np.array([-0.9, -0.2, 0.5]), np.array([-0.5, 0.1, 0.8])), [1.0] * len(heights)
    text, wanted = ring(*feet, np.array([5.0, 5.0, *bars]), np.array([0.2, 0.2]), 0.2, heights, 1.0)
    agree(workshop.model(text), wanted)


@pytest.mark.parametrize("seed", range(2))
def test_some_tables_and_loops(seed: int, workshop: Workshop) -> None:
    rng = np.random.default_rng(seed)
    table(rng, workshop)
    loop(rng, workshop)


@pytest.mark.hard
@pytest.mark.parametrize("seed", range(100, 125))
def test_tables_and_loops(seed: int, workshop: Workshop) -> None:
    rng = np.random.default_rng(seed)
    table(rng, workshop)
    loop(rng, workshop)
