"""Forces that rigid bodies leave open: of all that Coulomb's law allows, those of least norm."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import linprog, nnls

from ccgen.runtime import ensemble, simulate, static_equilibrium

from ..support.workshop import Workshop

Array = NDArray[np.float64]
G = 9.81
DEEP = -0.5
"""m: height of the feet in the frame of a table"""


def balanced(balance: Array, load: Array, feet: int, mu: float) -> bool:
    """Whether forces within Coulomb's limits, feet first, balance the load at all: a linear programme"""
    limits = np.zeros((2, feet, balance.shape[1]))
    for k, way in enumerate((1.0, -1.0)):
        limits[k, :, :feet], limits[k, :, feet : 2 * feet] = -mu * np.eye(feet), way * np.eye(feet)
    bounds = [(0.0, None)] * feet + [(None, None)] * (balance.shape[1] - feet)
    zeros = np.zeros(2 * feet)
    found = linprog(0.0 * balance[0], limits.reshape(2 * feet, -1), zeros, balance, load, bounds)
    assert found.status in (0, 2), found.message
    return bool(found.status == 0)


def least(balance: Array, load: Array, feet: int, mu: float, slides: float = 0.0) -> Array:
    """Forces (feet, 2) with ``balance @ (normals, frictions, others) = load``, least of feet, which may all slide along
    the sign ``slides``.

    Of all x + free y that balance, the others left out, the one nearest to zero within the limits: least distance
    programming by non-negative least squares (Lawson, Hanson 1974, chapter 23). What is found proves itself: it obeys
    the law, and its norm grows along whatever the limits leave (Kuhn, Tucker)."""
    left, values, _ = np.linalg.svd(balance[:, 2 * feet :])
    bare = left[:, int(np.sum(values > 1e-9)) :].T
    normal, along = np.eye(2 * feet)[:feet], np.eye(2 * feet)[feet:]
    fixed = along + slides * mu * normal if slides or not mu else np.zeros((0, 2 * feet))
    limits = normal if len(fixed) else np.concatenate([mu * normal + along, mu * normal - along])
    rows = np.concatenate([bare @ balance[:, : 2 * feet], fixed])
    wanted = np.concatenate([bare @ load, np.zeros(len(fixed))])
    x = np.linalg.lstsq(rows, wanted, rcond=1e-10)[0]
    _, values, right = np.linalg.svd(rows)
    free, size = right[int(np.sum(values > 1e-10 * values[0])) :].T, np.max(np.abs(x))
    edges = np.concatenate([(limits @ free).T, -(limits @ x)[None] / size])
    shares, _ = nnls(edges, np.eye(len(edges))[-1], maxiter=10_000)
    rest = np.eye(len(edges))[-1] - edges @ shares
    found = x - size / rest[-1] * free @ rest[:-1]
    pressed = size / rest[-1] * shares
    assert np.max(np.abs(rows @ found - wanted)) < 1e-9 * size and np.min(limits @ found) > -1e-9 * size
    assert np.max(np.abs(free.T @ (found - limits.T @ pressed)), initial=0.0) < 1e-9 * size
    assert np.max(np.abs(pressed * (limits @ found))) < 1e-9 * size**2
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
) -> tuple[str, Callable[[float, float], Array | None]]:
    """Two plates that bars at these heights join, and the forces of their feet under a force on the first foot of the
    first plate; None where no forces of feet let them rest"""
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
    every, way = np.concatenate(rows), float(np.sign(speed))

    def wanted(fx: float = 0.0, fy: float = 0.0) -> Array | None:
        both = np.array(load)
        both[:3] -= fx, fy, a[0] * fy - DEEP * fx
        return least(every, both, n, mu, way) if way or balanced(every, both, n, mu) else None

    return text, wanted


def loop(rng: Any, workshop: Workshop) -> None:
    """Two plates on two to four feet each, which two bars between them make a loop"""
    a, b = (np.sort(rng.uniform(-1, 1, int(rng.integers(2, 5)))) for _ in range(2))
    mu, mass, com = float(rng.choice([0.0, 0.3, 1.0, 2.0])), rng.uniform(1, 10, 4), rng.uniform(-0.5, 0.5, 2)
    text, forces = ring(a, b, mass, com, mu, [0.2, -0.1])
    model, wanted = workshop.model(text), forces(0.0, 0.0)
    if wanted is not None:
        agree(model, wanted)
    else:
        assert np.max(np.abs(simulate(model).u[-1])) > 1e-3


@pytest.mark.parametrize("mu", [0.0, 0.1, 0.2, 0.5])
def test_contacts_beside_a_loop_that_closes_twice(mu: float, workshop: Workshop) -> None:
    """A third bar that is as the others closes what is closed: the feet's forces are as without it, its weight apart"""
    feet = np.array([-0.9, -0.2, 0.5]), np.array([-0.5, 0.1, 0.8])
    text, forces = ring(*feet, np.array([5.0, 5.0, 1.0, 1.0, 1.0]), np.array([0.2, 0.2]), mu, [0.2, -0.1, 0.05])
    model, wanted = workshop.model(text), forces(0.0, 0.0)
    assert wanted is not None
    agree(model, wanted)
    run = simulate(model)
    assert [phase.kind for phase in run.phases] == ["contact"] and not run.impacts and len(run.t) < 20
    assert np.all(np.abs(run.contact_forces(0.05)[:, 1]) <= mu * run.contact_forces(0.05)[:, 0] + 1e-9)


@pytest.mark.parametrize("heights", [[0.2, -0.1], [0.2, -0.1, 0.05]])
def test_feet_that_slide_under_loops(heights: list[float], workshop: Workshop) -> None:
    feet, bars = (np.array([-0.9, -0.2, 0.5]), np.array([-0.5, 0.1, 0.8])), [1.0] * len(heights)
    text, forces = ring(*feet, np.array([5.0, 5.0, *bars]), np.array([0.2, 0.2]), 0.2, heights, 1.0)
    wanted = forces(0.0, 0.0)
    assert wanted is not None
    agree(workshop.model(text), wanted)


def follow(text: str, load: Load, wanted: Callable[[float, float], Array | None], workshop: Workshop) -> int:
    """Forces of a run under a load on the first foot, as long as all may rest, are those of least norm at each instant:
    so are those of its states and of ensembles, and joints' forces with them. At how many instants that is."""
    model = workshop.model(text + load.table(text))
    run = simulate(model)
    assert run.success, run.message
    at, rests = np.linspace(0.0013, 0.0987, 24), []
    for t in at.tolist():
        if (forces := wanted(*load(t))) is None:
            break
        rests.append(forces)
    held = [phase for phase in run.phases if phase.kind == "contact" and rests and phase.start < at[len(rests) - 1]]
    assert len(held) == bool(rests), held  # what forces of least norm would let go, others hold
    names = [f"{ground}.{point}.{part}" for point, ground in model.contacts for part in ("normal", "friction")]
    names += [f"{joint}.{part}" for joint in model.joints for part in ("fx", "fy")]
    rows = ensemble(model, observe=names, at=at)
    for k, forces in enumerate(rests):
        t, near = float(at[k]), 1e-8 * np.max(np.abs(forces))
        q, u = run.at(t)
        assert np.max(np.abs(u)) < 1e-9
        np.testing.assert_allclose(run.contact_forces(t), forces, atol=near)
        np.testing.assert_allclose(model.contact_forces(q, u, t), forces, atol=near)
        np.testing.assert_allclose(run.reactions(t), model.reactions(q, u, t), atol=near)
        together = np.array([rows[name][0, k] for name in names])
        alone = [*run.contact_forces(t).ravel(), *run.reactions(t)[:, :2].ravel()]
        np.testing.assert_allclose(together, alone, atol=near)
    return len(rests)


class Load:
    """A force on the first foot that turns round and about: x + dx sin(way t), y + dy sin(way t + turn)"""

    def __init__(self, x: float, y: float, dx: float, dy: float, way: float = 70.0, turn: float = 0.0) -> None:
        self.x, self.y, self.dx, self.dy, self.way, self.turn = x, y, dx, dy, way, turn

    def __call__(self, t: float) -> tuple[float, float]:
        x, y = self.dx * math.sin(self.way * t), self.dy * math.sin(self.way * t + self.turn)
        return self.x + x, self.y + y

    def table(self, text: str) -> str:
        link = re.findall(r'\[\[link\]\]\nname = "(\w+)"', text)[0]
        x, y = f"{self.dx!r} * sin({self.way!r} * t)", f"{self.dy!r} * sin({self.way!r} * t + {self.turn!r})"
        return f'[[force]]\npoint = "{link}.F0"\nvector = ["{self.x!r} + {x}", "{self.y!r} + {y}"]\n'


def loaded_table(feet: Array, com: float, mu: float, load: Load, workshop: Workshop) -> int:
    n, mass = len(feet), 10.0
    text = f'name = "table"\n{plate("table", feet, mass, com)}[start]\nposition = [0, 0.5]\n{grounds(mu, table=feet)}'
    balance = np.zeros((3, 2 * n))
    balance[0, :n] = balance[1, n:] = 1.0
    balance[2, :n], balance[2, n:] = feet - com, -DEEP

    def wanted(fx: float, fy: float) -> Array | None:
        force = np.array([mass * G - fy, -fx, DEEP * fx - (feet[0] - com) * fy])
        return least(balance, force, n, mu) if balanced(balance, force, n, mu) else None

    return follow(text, load, wanted, workshop)


@pytest.mark.parametrize(
    ("mu", "com", "load"),
    [
        (0.5, 0.5, Load(0.0, 0.0, 30.0, 0.0)),  # leaves the limit, and reaches the other
        (0.5, 0.9, Load(0.0, 0.0, 40.0, 0.0)),  # with feet that are carried
        (2.0, 0.5, Load(0.0, 0.0, 100.0, 0.0)),
        (2.0, 0.7, Load(0.0, -20.0, 60.0, 30.0)),  # feet are carried, and bear again
        (0.0, 0.7, Load(0.0, -20.0, 0.0, 30.0)),
    ],
)
def test_loads_that_vary(mu: float, com: float, load: Load, workshop: Workshop) -> None:
    """What was at its limit, or carried, when something last changed, is that no longer where the load has changed"""
    assert loaded_table(np.array([-1.0, -0.3, 0.3, 1.0]), com, mu, load, workshop) == 24


@pytest.mark.parametrize("heights", [[0.2, -0.1], [0.2, -0.1, 0.05]])
def test_loads_that_vary_on_loops(heights: list[float], workshop: Workshop) -> None:
    """Joints' forces follow those of feet, beside dependent rows of the closure too"""
    feet = np.array([-0.9, -0.2, 0.5]), np.array([-0.5, 0.1, 0.8])
    mass = np.array([5.0, 5.0, *[1.0] * len(heights)])
    text, wanted = ring(*feet, mass, np.array([-0.3, 0.2]), 0.5, heights)
    assert follow(text, Load(0.0, 0.0, 30.0, -20.0), wanted, workshop) == 24


def varied(rng: Any, workshop: Workshop) -> None:
    feet, mu = np.sort(rng.uniform(-1, 1, int(rng.integers(2, 8)))), float(rng.choice([0.0, 0.2, 0.5, 1.0, 2.0]))
    com = float(rng.uniform(0.9 * feet[0], 0.9 * feet[-1]))
    mean, change = rng.uniform(-30, 30, 2) * [mu > 0.0, 1.0], rng.uniform(-60, 60, 2) * [mu > 0.0, 1.0]
    load = Load(*mean.tolist(), *change.tolist(), way=float(rng.uniform(30, 130)), turn=float(rng.uniform(0, 6)))
    loaded_table(feet, com, mu, load, workshop)


@pytest.mark.parametrize("seed", range(2))
def test_some_loads_that_vary(seed: int, workshop: Workshop) -> None:
    varied(np.random.default_rng([seed, 1]), workshop)


@pytest.mark.hard
@pytest.mark.large(12)
@pytest.mark.parametrize("seed", range(100, 140))
def test_random_loads_that_vary(seed: int, workshop: Workshop) -> None:
    varied(np.random.default_rng([seed, 1]), workshop)


@pytest.mark.parametrize("seed", range(2))
def test_some_tables_and_loops(seed: int, workshop: Workshop) -> None:
    rng = np.random.default_rng(seed)
    table(rng, workshop)
    loop(rng, workshop)


@pytest.mark.hard
@pytest.mark.large(8)
@pytest.mark.parametrize("seed", range(100, 125))
def test_tables_and_loops(seed: int, workshop: Workshop) -> None:
    rng = np.random.default_rng(seed)
    table(rng, workshop)
    loop(rng, workshop)
