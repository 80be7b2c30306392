"""Random lifts of a block that rests on two to six points: when it leaves the ground, and how it rises, by formulas of
its own. ``test_lifting.py`` draws from here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

from ccgen.runtime import Model, simulate

POINTS = 6
AWAY = 5.0
"""Metres above the mass centre, where the points lie that the block of a lift does not have."""
METHODS = ("gauss", "dop853", "dopri5", "radau")
LAWS = ("newton", "poisson", "stronge")
SHAPES = ("ramp", "square", "sine", "exponential", "slow", "table", "step", "steep")

COMPILED: dict[str, Callable[[float], float]] = {
    "25*sin(t)": lambda t: 25 * float(np.sin(t)),
    "exp(t)": lambda t: float(np.exp(t)),
}
"""Forces (N) upward that are compiled; they lift a block whose weight they reach."""


def scene(rough: bool, expression: str = "") -> str:
    """A block with six points on level ground, inputs at its mass centre, and the force ``expression`` upward."""
    points = ", ".join(f"P{k} = [{0.1 * (k - 2.5)}, -0.1]" for k in range(POINTS))
    contacts = ", ".join(f'"block.P{k}"' for k in range(POINTS))
    force = f'[[force]]\npoint = "block.C"\nvector = [0, "{expression}"]\n' if expression else ""
    return f"""
name = "lift"
[[link]]
name = "block"
mass = 1.0
inertia = 0.01
com = [0, 0]
points = {{ C = [0, 0], {points} }}
{force}
[[input]]
name = "lift"
point = "block.C"
direction = [0, 1]
[[input]]
name = "push"
point = "block.C"
direction = [1, 0]
[[input]]
name = "twist"
link = "block"
[gravity]
[[ground]]
restitution = 0.5
{"friction = 0.3" if rough else ""}
contacts = [{contacts}]
[start]
position = [0, 0.1]
"""


def standing(points: Any) -> dict[str, float]:
    """Parameters of the block whose points at these places (m along the ground) alone can touch it."""
    places = [*map(float, points), *(0.1 * (k + 1) for k in range(POINTS - len(points)))]
    heights = [-0.1] * len(points) + [AWAY] * (POINTS - len(points))
    values = {f"block.points.P{k}.x": x for k, x in enumerate(places)}
    return values | {f"block.points.P{k}.y": y for k, y in enumerate(heights)}


@dataclass(frozen=True)
class Shape:
    """A force upward over time (s), in weights, that grows past 1 once before ``longest``; kinks of a table."""

    force: Callable[[float], float]
    longest: float
    kinks: tuple[float, ...] = ()


def shape(kind: str, rng: np.random.Generator) -> Shape:
    when, steep = float(np.exp(rng.uniform(np.log(0.05), np.log(3.0)))), float(rng.uniform(0.3, 3.0))
    if kind == "ramp":
        return Shape(lambda t: 1 + steep * (t - when), when + 1)
    if kind == "square":
        return Shape(lambda t: (t / when) ** 2, when + 1)
    if kind == "sine":
        quarter = float(np.arcsin(1 / (1 + steep)))
        return Shape(lambda t: (1 + steep) * float(np.sin(t / when * quarter)), 0.5 * np.pi * when / quarter)
    if kind == "exponential":
        return Shape(lambda t: float(np.exp(steep * (t - when))), when + 1)
    if kind == "slow":
        return Shape(lambda t: 1 + steep * (t - when) * abs(t - when) ** 2 + 1e-3 * (t - when), when + 1)
    if kind == "step":
        return Shape(lambda t: 0.5 if t < when else 1.0 + steep, when + 1)
    before, after = (0.1 * when, 1e-4 * steep) if kind == "steep" else (0.3 * when, 0.8 * when)
    times = (0.0, when - before, when + after, 2.0 * when + 2.0)
    return Shape(lambda t: float(np.interp(t, times, (0.2, 0.9, 1 + steep, 1 + steep))), when + 1, times)


def leaving(force: Callable[[float], float], weight: float, longest: float) -> float:
    """The time (s) at which the force reaches the weight, or jumps past it."""
    low, high = 0.0, longest
    if (
        force(longest) - weight > 0
        and abs(force(brentq(lambda t: force(t) - weight, low, high)) - weight) < 1e-6 * weight
    ):
        return float(brentq(lambda t: force(t) - weight, low, high, xtol=1e-15, rtol=1e-15))
    while 0.5 * (low + high) not in (low, high):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if force(middle) < weight else (low, middle)
    return high


@dataclass(frozen=True)
class Lifted:
    """A lift that was run, and what it should have been."""

    run: Any
    what: str
    rtol: float
    left: float
    """When the last contact ended (s)."""
    leaves: float
    """When the force reaches the weight (s)."""
    rate: float
    """How fast it does, in weights per second: rounding of the force is time by that."""
    missed: float
    """By how much the height at the end is not the double integral of the acceleration, relative to it or to 1 m."""
    turned: float
    """The largest turn of the block (rad), which should not turn."""


def lift(model: Any, expression: str, seed: int) -> Lifted:
    """One lift, all drawn from ``seed``; ``model`` is that of :func:`scene`. A push along the ground is a part of what
    still presses: with friction that holds it, the limits of friction vanish together with the forces too."""
    rng, rough = np.random.default_rng(seed), "ground_0.friction" in model.parameters
    law, method, kind = str(rng.choice(LAWS)), str(rng.choice(METHODS)), str(rng.choice(SHAPES))
    rtol = float(10 ** rng.uniform(-13, -6))
    mass, gravity = float(np.exp(rng.uniform(np.log(0.1), np.log(10.0)))), float(rng.uniform(1.0, 20.0))
    places = rng.uniform(-0.3, 0.3, size=rng.integers(2, POINTS + 1))
    places[:2] = -rng.uniform(0.05, 0.3), rng.uniform(0.05, 0.3)
    if rng.random() < 0.3:
        places[1] = -places[0]
    mu = float(np.exp(rng.uniform(np.log(1e-3), np.log(10.0)))) if rough else 0.0
    share = float(rng.choice([0.0, rng.uniform(-0.4, 0.4) * min(mu, 1.0)]))
    weight, inputs, kinks = mass * gravity, None, ()
    if expression:
        force, longest = COMPILED[expression], 1.5
        weight = force(float(rng.uniform(0.3, 1.2)))
    else:
        one = shape(kind, rng)
        longest, kinks = one.longest, one.kinks

        def force(t: float) -> float:
            return weight * one.force(t)

        if kinks:
            inputs = {"t": list(kinks), "lift": [force(t) for t in kinks]}
        else:
            inputs = lambda t, q, u: [force(t), share * max(0.0, weight - force(t)), 0.0]  # noqa: E731
    leaves = leaving(force, weight, longest)
    until = leaves + 0.5 * (longest - leaves)
    params = standing(places) | {
        "block.mass": mass,
        "block.inertia": mass * float(rng.uniform(0.001, 0.1)),
        "gravity.g": weight / mass,
        "ground_0.restitution": float(rng.choice([0.0, 0.5, 1.0])),
    }
    params |= {"ground_0.friction": mu} if rough else {}
    lawful = Model(model._descriptor, {**model.data, "law": law})
    run = simulate(lawful, until=until, rtol=rtol, method=method, params=params, inputs=inputs)
    left = max((phase.end for phase in run.phases if phase.kind == "contact"), default=0.0)
    inside = [t for t in kinks if leaves < t < until] or None
    rise = quad(
        lambda t: (until - t) * (force(t) - weight) / mass,
        leaves,
        until,
        epsabs=1e-14,
        epsrel=1e-12,
        limit=500,
        points=inside,
    )[0]
    return Lifted(
        run,
        f"seed {seed}: {law}, {method}, rtol {rtol:.1e}, {len(places)} points, {expression or kind}, push {share:.2g}",
        rtol,
        left,
        leaves,
        (force(leaves + 1e-6) - force(leaves - 1e-6)) / (2e-6 * weight),
        abs(run.q[-1, 1] - run.q[0, 1] - rise) / max(1.0, rise),
        float(np.max(np.abs(run.q[:, 2]))),
    )
