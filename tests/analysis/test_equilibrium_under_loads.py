"""Equilibria under constant forces, torques and motors, whose work is in no potential: closed forms, virtual work."""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np
import pytest
from scipy import optimize

from ccgen.runtime import static_equilibrium

from ..support.tiers import hard
from ..support.workshop import Workshop

ROD = """
name = "pulled-rod"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "rod"
rod = { mass = 1 }
points = { O = [0, 0], T = [1, 0] }
[[joint]]
name = "hinge"
between = ["ground.O", "rod.O"]
[[torsion]]
joint = "hinge"
stiffness = 2
"""
PULLS = {
    "force": '[[force]]\npoint = "rod.T"\nvector = [0, -20]\n',
    "torque": '[[torque]]\nlink = "rod"\ntorque = -40\n',
    "motor": '[[motor]]\njoint = "hinge"\ntorque = 30\n',
    "table": '[[motor]]\njoint = "hinge"\ntable = [[0, 30], [1, 20]]\n',
    "servo": '[[motor]]\njoint = "hinge"\nangle = 0.7\nstiffness = 50\n',
    "limited": '[[motor]]\njoint = "hinge"\nangle = 0.7\nstiffness = 50\nlimit = 4\n',
    "follower": '[[force]]\npoint = "rod.T"\nvector = [3, 8]\nframe = "link"\n',
}


def asked(kind: str, a: float) -> float:
    """The torque (N m) that a load turns the rod with at its angle, beside -2 a of the spring."""
    return {
        "force": -20.0 * math.cos(a),
        "torque": -40.0,
        "motor": 30.0,
        "table": 30.0,
        "servo": 50.0 * (0.7 - a),
        "limited": min(max(50.0 * (0.7 - a), -4.0), 4.0),
        "follower": 8.0,
    }[kind]


@pytest.mark.parametrize("kind", sorted(PULLS))
def test_a_rod_rests_under_every_load(kind: str, workshop: Workshop) -> None:
    """From all starts, once round: the closed form balances, and rests."""
    model = workshop.model(ROD + PULLS[kind])
    for start in np.radians(np.arange(-180.0, 180.0, 10.0)):
        found = static_equilibrium(model, [start])
        (a,) = found.q
        assert asked(kind, a) - 2.0 * a == pytest.approx(0.0, abs=1e-7)
        slope = (asked(kind, a + 1e-5) - asked(kind, a - 1e-5)) / 2e-5 - 2.0
        assert slope < 0.0 and found.stability == "stable" and found.note == ""
        assert found.stiffness == pytest.approx([-slope], rel=1e-5)
    if kind == "force":
        assert static_equilibrium(model, [math.radians(80.0)]).q == pytest.approx([-1.427551779], abs=1e-9)


BAR = """
name = "four-bar"
[ground_link]
points = { O = [0, 0], P = [2, 0.3] }
[[link]]
name = "crank"
rod = { mass = 1 }
points = { O = [0, 0], A = [1, 0] }
[[link]]
name = "coupler"
rod = { mass = 2, between = ["A", "B"] }
points = { A = [0, 0], B = [2, 0], T = [0.8, 0.6] }
[[link]]
name = "rocker"
rod = { mass = 1 }
points = { P = [0, 0], B = [1.5, 0] }
[[joint]]
name = "drive"
between = ["ground.O", "crank.O"]
[[joint]]
name = "knee"
between = ["crank.A", "coupler.A"]
[[joint]]
name = "elbow"
between = ["coupler.B", "rocker.B"]
[[joint]]
name = "pivot"
between = ["ground.P", "rocker.P"]
[[torsion]]
joint = "drive"
stiffness = 12
[[force]]
name = "pull"
point = "coupler.T"
vector = [5, -3]
[[force]]
name = "push"
point = "rocker.B"
vector = [1, 2]
frame = "link"
[[torque]]
name = "turn"
link = "coupler"
torque = 4
[[motor]]
name = "motor"
joint = "pivot"
torque = 3
[gravity]
[start]
angles = { crank = 0.5, coupler = 0.4, rocker = 1.9 }
"""


def work(p: Any, guess: np.ndarray) -> Any:
    """Generalized force of the crank, by differences of poses near a guess, and the poses: functions of its angle."""

    def pose(a: float) -> np.ndarray:
        knee, far = complex(math.cos(a), math.sin(a)), 2.0 + 0.3j
        line = far - knee
        spread = math.acos((4.0 + abs(line) ** 2 - 2.25) / (4.0 * abs(line)))
        b = cmath.phase(line) + spread * np.array([1.0, -1.0])
        c = np.angle(knee + 2.0 * np.exp(1j * b) - far)
        both = np.array([b, c]).T
        both -= 2.0 * np.pi * np.round((both - guess) / (2.0 * np.pi))
        return np.array([a, *both[np.argmin(np.abs(both - guess).max(axis=1))]])

    def places(x: np.ndarray) -> dict[str, np.ndarray]:
        a, b, c = x
        knee = np.array([math.cos(a), math.sin(a)])
        along, across = np.array([math.cos(b), math.sin(b)]), np.array([-math.sin(b), math.cos(b)])
        elbow = np.array([2.0, 0.3]) + 1.5 * np.array([math.cos(c), math.sin(c)])
        middle, tip = (elbow + np.array([2.0, 0.3])) / 2.0, knee + 0.8 * along + 0.6 * across
        return {"crank": knee / 2.0, "coupler": knee + along, "rocker": middle, "elbow": elbow, "T": tip}

    def force(a: float) -> float:
        h = 1e-5
        one, other, here = pose(a - h), pose(a + h), pose(a)
        before, after = places(one), places(other)
        d = {name: (after[name] - before[name]) / (2.0 * h) for name in before}
        turns = (other - one) / (2.0 * h)
        c, s = math.cos(here[2]), math.sin(here[2])
        turned = np.array([c * p["push.x"] - s * p["push.y"], s * p["push.x"] + c * p["push.y"]])
        weights = -9.81 * (d["crank"][1] + 2.0 * d["coupler"][1] + d["rocker"][1])
        loads = p["pull.x"] * d["T"][0] + p["pull.y"] * d["T"][1] + turned @ d["elbow"]
        return float(weights + loads + p["turn.torque"] * turns[1] + p["motor.torque"] * turns[2] - 12.0 * a)

    return force, pose


@pytest.mark.parametrize("seed", [*range(6), *map(hard, range(6, 60))])
def test_a_four_bar_rests_by_virtual_work(seed: int, workshop: Workshop) -> None:
    """Under random constant loads: forces, one of them turning with its link, torques and a motor."""
    draw = np.random.default_rng(seed)
    names = [name for name in workshop.model(BAR).parameters if name.split(".")[0] in ("pull", "push", "turn", "motor")]
    assert len(names) == 6
    p = dict(zip(names, draw.uniform(-15.0, 15.0, 6).tolist(), strict=True))
    model = workshop.model(BAR).with_parameters(p)
    values = {name.replace("vector.", ""): value for name, value in p.items()}
    found = static_equilibrium(model)
    force, pose = work(values, found.q[1:].copy())
    assert pose(found.q[0]) == pytest.approx(found.q, abs=1e-9)
    low, high = found.q[0] - 1e-3, found.q[0] + 1e-3
    assert optimize.brentq(force, low, high, xtol=1e-13) == pytest.approx(found.q[0], abs=1e-8)
    slope = (force(high) - force(low)) / 2e-3
    assert (slope < 0.0) == (found.stability == "stable")
    assert found.stability == "stable"


ZIEGLER = """
name = "ziegler"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "lower"
mass = 0
inertia = 0
com = [0, 0]
point_mass = [{ mass = 2, at = "B" }]
points = { A = [0, 0], B = [0, 1] }
[[link]]
name = "upper"
point_mass = [{ mass = 1, at = "C" }]
points = { B = [0, 0], C = [0, 1] }
[[joint]]
name = "foot"
between = ["ground.O", "lower.A"]
[[joint]]
name = "knee"
between = ["lower.B", "upper.B"]
[[torsion]]
joint = "foot"
stiffness = 10
[[torsion]]
joint = "knee"
stiffness = 10
[[force]]
name = "follower"
point = "upper.C"
vector = [0, -1]
frame = "link"
"""


def test_zieglers_column_flutters(workshop: Workshop) -> None:
    """Two rods with masses 2m and m under a force P along the upper one: stable up to P l / k = 7/2 - sqrt 2 (Ziegler,
    1952), though its stiffness stays that of a stable one."""
    model = workshop.model(ZIEGLER.replace("mass = 0\ninertia = 0\ncom = [0, 0]\n", ""))
    path = next(name for name in model.parameters if name.startswith("follower"))
    for load, stability in ((2.07, "stable"), (2.1, "unstable"), (4.9, "unstable")):
        model.parameters[path] = -10.0 * load
        found = static_equilibrium(model, [0.0, 0.0])
        assert found.q == pytest.approx([0.0, 0.0], abs=1e-9) and found.stability == stability
        assert "no potential" in found.note
    model.parameters[path] = -15.0
    assert static_equilibrium(model, [0.3, -0.2]).q == pytest.approx([0.0, 0.0], abs=1e-9)
