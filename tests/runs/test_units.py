"""Scale covariance: the same mechanism in other units of mass, length and time moves and decides alike, bit for bit
where units are powers of two apart."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import Run

from ..hard.fuzz import scene as toss_scene
from ..support.folders import SCENES
from ..support.units import Units
from ..support.workshop import Workshop

SPRUNG = """
name = "sprung"
[ground_link]
points = { O = [0, 0], G = [0, 0.1] }
[[link]]
name = "crank"
mass = 2.0
inertia = 0.04
com = [0.1, 0]
points = { A = [0, 0], B = [0.25, 0] }
[[link]]
name = "rod"
mass = 0.7
inertia = 0.02
com = [0.3, 0]
points = { A = [0, 0], B = [0.6, 0] }
[[link]]
name = "slider"
mass = 1.5
inertia = 0.01
com = [0, 0]
points = { A = [0, 0] }
[[joint]]
name = "axle"
between = ["ground.O", "crank.A"]
[[joint]]
name = "pin"
between = ["crank.B", "rod.A"]
[[joint]]
name = "wrist"
between = ["rod.B", "slider.A"]
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.G", "slider.A"]
axis = [1, 0]
[[spring]]
between = ["ground.O", "slider.A"]
stiffness = 40.0
length = 0.5
[[damper]]
between = ["ground.O", "slider.A"]
damping = 0.5
[[stop]]
joint = "axle"
lowest = "-60 deg"
highest = "80 deg"
restitution = 0.4
[start]
angles = { crank = "70 deg", rod = "-15 deg", slider = 0.0 }
slides = { guide = 0.7 }
[run]
until = 4.0
"""
"""A slider-crank without gravity, moved by a spring between its stops: its time is told by how it starts."""

CHAIN = "".join(
    f"""
[[link]]
name = "link_{k}"
mass = {mass}
inertia = {inertia}
com = [0.2, 0]
points = {{ A = [0, 0], B = [{length}, 0] }}
[[joint]]
name = "joint_{k}"
between = ["{before}.{"B" if k else "O"}", "link_{k}.A"]
"""
    for k, (before, mass, inertia, length) in enumerate(
        [("ground", 1.0, 0.03, 0.5), ("link_0", 0.8, 0.02, 0.4), ("link_1", 0.6, 0.015, 0.45)]
    )
)
BETWEEN_STOPS = f"""
name = "between-stops"
[ground_link]
points = {{ O = [0, 0] }}
{CHAIN}
[[stop]]
joint = "joint_1"
lowest = "-40 deg"
highest = "30 deg"
restitution = 0.3
[[stop]]
joint = "joint_2"
lowest = "-25 deg"
highest = "50 deg"
restitution = 0.2
[gravity]
g = 9.81
[[ground]]
point = [0, -0.8]
normal = [0, 1]
restitution = 0.3
friction = 0.4
contacts = ["link_1.B", "link_2.B"]
[start]
angles = {{ link_0 = "20 deg", link_1 = "35 deg", link_2 = "20 deg" }}
[run]
until = 1.0
"""
"""A chain strikes stops of two joints and a rough ground, in turn and then together: angles beside lengths."""


def tossed(workshop: Workshop) -> tuple[Any, Any, Any, float]:
    model = workshop.model(toss_scene(6, rough=True)).with_parameters(
        {f"link_{k}.length": 0.9 + 0.05 * k for k in range(6)} | {"ground_1.point.y": 0.0}
    )
    q, u = model.start()
    q, u = model.project(q, u + np.random.default_rng(1).normal(size=u.size))
    q[1] += 0.2 + 1.5 * max(0.0, -float(model.gaps(q).min()))
    return model, q, u, 4.0


def sprung(workshop: Workshop) -> tuple[Any, Any, Any, float]:
    model = workshop.model(SPRUNG)
    return model, *model.start(), 4.0


def between_stops(restitution: float) -> Callable[[Workshop], tuple[Any, Any, Any, float]]:
    def case(workshop: Workshop) -> tuple[Any, Any, Any, float]:
        model = workshop.model(BETWEEN_STOPS)
        bouncing = [path for path in model.parameters if path.endswith("restitution")]
        return model.with_parameters(dict.fromkeys(bouncing, restitution)), *model.start(), 1.0

    return case


def of_scene(name: str, until: float) -> Callable[[Workshop], tuple[Any, Any, Any, float]]:
    def case(workshop: Workshop) -> tuple[Any, Any, Any, float]:
        model = workshop.model(load_scene(SCENES / f"{name}.toml"))
        return model, *model.start(), until

    return case


CASES = {
    "tossed": (tossed, {}),
    "sprung": (sprung, {}),
    "sprung, radau": (sprung, {"method": "radau"}),
    "between stops, bouncing": (between_stops(0.3), {}),
    "between stops, landing": (between_stops(0.0), {}),
    "quick return": (of_scene("quick-return", 2.0), {}),
    "quick return, dopri5": (of_scene("quick-return", 1.0), {"method": "dopri5", "rtol": 1e-7}),
    "stiff rocker": (of_scene("stiff-rocker", 0.5), {"method": "radau"}),
    "falling hexagon": (of_scene("falling-hexagon", 2.0), {}),
    "parallelogram": (of_scene("parallelogram", 4.0), {}),
    "cradle": (of_scene("newtons-cradle", 3.0), {}),
}


UNDERFLOW = 1e-300
"""Numbers this small have lost bits in one unit that they have in another."""


def in_old_units(run: Run, units: Units) -> tuple[Any, Any, Any]:
    """Times and states of the run, in the units in which it was first."""
    by = units.coordinates(run.model)
    return run.t / units.time, run.q / by, run.u / by * units.time


UNSEEN = 1e-8
"""Seconds in which accelerations of ten per second squared move things by 1e-15, which is rounding: it decides how many
bounces so short a contact has before it rests."""


def decisions(run: Run, unseen: float = 0.0) -> Any:
    """What the run decides: which contacts strike in turn, and how contacts are held from phase to phase; without
    flights that are shorter than ``unseen``, and the impacts after them."""
    short = {phase.end for phase in run.phases if phase.kind == "flight" and 0.0 < phase.end - phase.start < unseen}
    seen = [phase.contacts for phase in run.phases if phase.end not in short]
    return [impact.contacts for impact in run.impacts if impact.t not in short], seen


@pytest.mark.sample(6)
@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize(
    "units",
    [
        pytest.param(Units(2.0**3, 2.0**10, 2.0**10), id="milli"),
        pytest.param(Units(2.0**-7, 2.0**-9, 2.0**-12), id="kilo", marks=pytest.mark.hard),
    ],
)
def test_units_a_power_of_two_apart_change_no_bit(case: str, units: Units, workshop: Workshop) -> None:
    make, options = CASES[case]
    model, q, u, until = make(workshop)
    first = Units(1.0, 1.0, 1.0).run(model, q, u, until, **options)
    other = units.run(model, q, u, until, **options)
    assert first.success == other.success
    assert len(first.t) == len(other.t)
    for old, new in zip((first.t, first.q, first.u), in_old_units(other, units), strict=True):
        np.testing.assert_allclose(new, old, rtol=0.0, atol=UNDERFLOW)
    assert decisions(first) == decisions(other)
    assert [i.energy_loss for i in first.impacts] == [i.energy_loss / units.factor((1, 2, -2)) for i in other.impacts]


ROUNDING_GROWS = {"tossed": 1.1, "falling hexagon": 1.5, "sprung, radau": 0.55, "between stops, bouncing": 0.541}
"""Times (s) from which on these amplify rounding, of which other units have another, until decisions differ."""


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("units", [Units(1e3, 1e3, 1e3), Units(1e-3, 1e-3, 1.0 / 3600.0)], ids=["mm, ms", "km, h"])
def test_other_units_decide_alike(case: str, units: Units, workshop: Workshop) -> None:
    make, options = CASES[case]
    model, q, u, until = make(workshop)
    until = min(until, ROUNDING_GROWS.get(case, until))
    first = Units(1.0, 1.0, 1.0).run(model, q, u, until, **options)
    other = units.run(model, q, u, until, **options)
    assert decisions(first, UNSEEN) == decisions(other, UNSEEN * units.time)
    assert first.success == other.success
