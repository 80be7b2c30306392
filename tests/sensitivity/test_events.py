"""Derivatives of runs in which events set parameters, switch effects and end them: closed forms, and differences of
runs in wide numbers."""

from __future__ import annotations

from itertools import pairwise
from math import cos, sin, sqrt
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import directional, run_function, sensitivities, simulate
from ccgen.runtime.model.thresholds import characteristic_time

from ..oracles.maximal import WIDE
from ..support.derived_scenes import FOUR_BAR, HINGED, body
from ..support.run_differences import RTOL, along, relative, unit_directions
from ..support.workshop import Workshop

TIGHT = 1e-11

SPRUNG = """
name = "sprung"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "body"
mass = 2.0
inertia = 1.0
com = [0, 0]
points = { A = [0, 0] }
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.O", "body.A"]
axis = [1, 0]
[[spring]]
name = "pull"
between = ["ground.O", "body.A"]
stiffness = 8.0
[start]
slides = { guide = 0.5 }
[[event]]
name = "changed"
when = "slide(guide) - 0.2"
direction = "falling"
"""

WRT = ("q0", "u0", "pull.stiffness", "body.mass")


def test_a_spring_whose_stiffness_is_set_where_the_body_passes(workshop: Workshop) -> None:
    """From x0 at rest, x = x0 cos(w t) until x = 0.2 at t1; then x = 0.2 cos(W s) + v1 sin(W s) / W, s = t - t1."""
    model = workshop.model(SPRUNG + 'set = { "pull.stiffness" = 32 }\n', derivatives=True)
    found = sensitivities(model, WRT, until=1.0, rtol=1e-13)
    x0, at, mass, w, W = 0.5, 0.2, 2.0, 2.0, 4.0
    t1, v1 = np.arccos(at / x0) / w, -w * sqrt(x0**2 - at**2)
    s = 1.0 - t1
    x, v = at * cos(W * s) + v1 * sin(W * s) / W, -at * W * sin(W * s) + v1 * cos(W * s)
    assert [found.values["q"][0], found.values["u"][0]] == pytest.approx([x, v], abs=1e-12)
    # what x at t1 and the speed there change by with x0, u0, and with w, which stiffness and mass move
    dw = np.array([0, 0, 1 / (2 * mass * w), -w / (2 * mass)])
    dx = np.array([cos(w * t1), sin(w * t1) / w, 0, 0]) - x0 * t1 * sin(w * t1) * dw
    dt1 = -dx / v1
    dv1 = np.array([w**2 * x0 / v1, 0, 0, 0]) + w * (x0**2 - at**2) / v1 * dw
    by_W = -at * s * sin(W * s) + v1 * (s * W * cos(W * s) - sin(W * s)) / W**2
    dW = np.array([0, 0, 0, -W / (2 * mass)])
    assert found["q"][0] == pytest.approx(dv1 * sin(W * s) / W - v * dt1 + by_W * dW, abs=TIGHT)
    (passed,) = found.passed
    assert passed.kind == "event" and passed.events == ("changed",) and passed.contacts == ()
    assert passed.dt == pytest.approx(dt1, abs=TIGHT)
    assert passed.behind == pytest.approx(np.array([np.zeros(4), dv1]), abs=TIGHT)
    jump = (W**2 - w**2) * at * -1 / v1 * characteristic_time(model)
    assert passed.matrix == pytest.approx(np.array([[1, 0], [jump, 1]]), rel=1e-11)


def test_a_spring_whose_stiffness_is_set_to_what_the_speed_tells(workshop: Workshop) -> None:
    """As before, with W = c v1, c = -2: W moves as the speed there, and the energy with it."""
    model = workshop.model(SPRUNG + 'set = { "pull.stiffness" = "8*rate(slide(guide))**2" }\n', derivatives=True)
    found = sensitivities(model, ("q0", "body.mass"), ["q", "potential_energy"], until=1.0, rtol=1e-13)
    x0, at, mass, w = 0.5, 0.2, 2.0, 2.0
    t1, v1 = np.arccos(at / x0) / w, -w * sqrt(x0**2 - at**2)
    s, k = 1.0 - t1, 8 * v1**2
    W = sqrt(k / mass)
    dw = np.array([0, -w / (2 * mass)])
    dt1 = -(np.array([cos(w * t1), 0]) - x0 * t1 * sin(w * t1) * dw) / v1
    dv1 = np.array([w**2 * x0 / v1, 0]) + w * (x0**2 - at**2) / v1 * dw
    dk = 16 * v1 * dv1
    dW = (dk / mass - np.array([0, k / mass**2])) / (2 * W)
    x, v = at * cos(W * s) + v1 * sin(W * s) / W, -at * W * sin(W * s) + v1 * cos(W * s)
    by_W = -at * s * sin(W * s) + v1 * (s * W * cos(W * s) - sin(W * s)) / W**2
    wanted = dv1 * sin(W * s) / W - v * dt1 + by_W * dW
    assert found["q"][0] == pytest.approx(wanted, abs=TIGHT)
    assert found["potential_energy"] == pytest.approx(k * x * wanted + dk * x**2 / 2, abs=10 * TIGHT)


PAIR = "\n".join(
    (
        'name = "pair"',
        HINGED,
        '[start]\nangles = ["-60 deg", "-100 deg"]\nangular_velocities = [1.0, -2.0]',
        '[[torsion]]\nname = "hold"\njoint = "knee"\nstiffness = 3\nangle = 0.2',
        '[[damper]]\nname = "drag"\nbetween = ["ground.P", "shank.B"]\ndamping = 1.5',
    )
).replace("points = { O = [0, 0] }", "points = { O = [0, 0], P = [3, 1] }")
KNEE = """
[[event]]
name = "bent"
when = "angle(knee) + 0.1*rate(direction(thigh)) - 0.05*t"
set = { "hold.stiffness" = "5 + angle(knee)*rate(angle(knee)) + sin(x(shank.B))*t", "thigh.mass" = 1.4 }
"""
DRAG = """
[[event]]
name = "free"
when = "y(shank.B) + 1.6"
off = ["drag"]
[[event]]
name = "slow"
when = "rate(distance(shank.B, ground.P))"
on = ["drag"]
set = { "drag.damping" = "1 + y(shank.B)**2" }
"""
SLIDING = body(
    'contacts = ["body.A"]\n[[ground]]\npoint = [0, -0.3]\nrestitution = 0.5\nfriction = 0.1\ncontacts = ["body.A"]\n'
    '[[event]]\nname = "gone"\nwhen = "x(body.A) - 0.2"\noff = ["ground_0"]\n'
    '[[event]]\nname = "low"\nwhen = "y(body.A) + 0.1"\nset = { "ground_1.friction" = "0.2 - x(body.A)/9" }\n',
)
BOUNCING = body(
    'contacts = ["body.A"]\n[[event]]\nname = "struck"\nwhen = "rate(y(body.A))"\n'
    'direction = "rising"\nset = { "gravity.g" = "9 + x(body.B)" }\n',
    position="[0, 0.6]",
    restitution=0.6,
    com="[0.2, 0]",
    angle=0.9,
)
LANDING = body(
    'contacts = ["body.A"]\n[[event]]\nname = "landed"\nwhen = "y(body.A) + 0.05*x(body.A)"\n'
    'set = { "gravity.g" = 5, "body.mass" = "1.3 + y(body.B)" }\n',
    position="[0, 0.6]",
    restitution=0.6,
    angle=0.9,
)
LINKED = (
    FOUR_BAR
    + """
[[torsion]]
name = "back"
joint = "pivot"
stiffness = 10
damping = 1
[[event]]
name = "heavier"
when = "direction(crank) - 1.02"
set = { "coupler.mass" = "1.5 + distance(crank.B, ground.Q)", "back.damping" = 0 }
[[event]]
name = "fast"
when = "rate(angle(pivot)) + 0.6"
off = ["back"]
"""
)

STOPPED = (
    HINGED
    + """
[start]
angles = ["0 deg", "30 deg"]
[[stop]]
name = "knock"
joint = "knee"
lowest = "-20 deg"
highest = "100 deg"
restitution = 0
[[motor]]
joint = "knee"
torque = -9
[[event]]
name = "lighter"
when = "direction(thigh) + 0.8"
set = { "shank.mass" = "1 + rate(direction(thigh))/20", "gravity.g" = 5 }
[[event]]
name = "unlocked"
when = "direction(thigh) + 1.2"
off = ["knock"]
"""
)
APART = (".on", ".normal.x", ".normal.y", ".point.x", ".point.y")
"""What parts an event from the impact with which it comes."""

SCENES: dict[str, tuple[str, float, tuple[str, ...]]] = {
    "a knee whose spring is set": (PAIR + KNEE, 1.2, ("event",)),
    "a damper that comes and goes": (PAIR + KNEE + DRAG, 1.5, ("event",) * 11),
    "a body whose ground goes while it slides": (SLIDING, 0.4, ("impact", "event", "event", "impact")),
    "an event as an impact turns a rate": (BOUNCING, 0.6, ("impact", "impact")),
    "an event where a contact closes": (LANDING, 0.6, ("impact",)),
    "a knee that leaves its stop": (STOPPED, 1.0, ("impact", "event", "event")),
    "a four-bar": (LINKED, 0.6, ("event", "event")),
}


@pytest.mark.parametrize("scene", SCENES)
def test_derivatives_are_those_of_differences(scene: str, workshop: Workshop) -> None:
    text, until, passed = SCENES[scene]
    text = text if text.startswith("name") else 'name = "derived"\n' + text
    model, wide = workshop.model(text, derivatives=True), workshop.model(text, "wide")
    names = [name for name in model.parameters if not name.endswith(APART if "landed" in text else ".on")]
    names = [name for name in names if not (name.endswith("restitution") and model.parameters[name] == 0.0)]
    found = sensitivities(model, names, ["q", "u", "impact_times"], until=until, rtol=RTOL, mode="tangent")
    kinds = [one.kind for one in found.passed]
    assert all(kinds.count(kind) >= passed.count(kind) for kind in passed), kinds
    assert sum(len(one.events) for one in found.passed) >= 1
    wanted = along(wide, model, unit_directions(names), until)
    assert relative(found.jacobian, wanted) < 1e-9
    adjoint = sensitivities(model, names, ["q", "u", "impact_times"], until=until, rtol=RTOL, mode="adjoint")
    assert relative(adjoint.jacobian, found.jacobian) < 1e-10


def test_a_run_that_an_event_ends(workshop: Workshop) -> None:
    """x = x0 cos(w t) comes to 0.2 at T1 for the second time: outputs are at that time, which is told to move."""
    model = workshop.model(SPRUNG + "stop = true\ntimes = 2\n", derivatives=True)
    found = sensitivities(model, WRT, until=9.0, rtol=1e-13)
    x0, at, mass, w = 0.5, 0.2, 2.0, 2.0
    T1, v1 = (np.arccos(at / x0) + 2 * np.pi) / w, -w * sqrt(x0**2 - at**2)
    assert found.times == pytest.approx([T1], abs=1e-12)
    dw = np.array([0, 0, 1 / (2 * mass * w), -w / (2 * mass)])
    dx = np.array([cos(w * T1), sin(w * T1) / w, 0, 0]) - x0 * T1 * sin(w * T1) * dw
    assert found["q"][0] == pytest.approx(dx, abs=TIGHT)
    (passed,) = found.passed
    assert passed.events == ("changed",) and passed.kind == "event"
    assert passed.dt == pytest.approx(-dx / v1, abs=TIGHT)
    dv1 = np.array([w**2 * x0 / v1, 0, 0, 0]) + w * (x0**2 - at**2) / v1 * dw
    assert passed.behind == pytest.approx(np.array([np.zeros(4), dv1]), abs=TIGHT)


def test_times_on_both_sides_of_an_event(workshop: Workshop) -> None:
    """A run is asked at several times at once, also as a function and for a gradient; one that goes on from a state
    beyond an event is derived from there."""
    model = workshop.model(SPRUNG + 'set = { "pull.stiffness" = "20*t", "body.mass" = 1 }\n', derivatives=True)
    outputs = ["guide.slide", "kinetic_energy", "potential_energy"]
    at = [0.2, 0.5, 0.7, 1.0]
    both = sensitivities(model, WRT, outputs, at=at, until=1.0, rtol=1e-13)
    for name in outputs:
        for k, t in enumerate(at):
            assert both[name][k] == pytest.approx(
                sensitivities(model, WRT, name, until=t, rtol=1e-13)[name], rel=1e-10, abs=1e-10
            )
    assert both["kinetic_energy"][2:, 3] == pytest.approx(
        both.run.values("guide.slide_rate", t=at)["guide.slide_rate"][2:]
        * sensitivities(model, WRT, "guide.slide_rate", at=at, until=1.0, rtol=1e-13)["guide.slide_rate"][2:, 3],
        rel=1e-10,
    )  # of the mass that is set, which its own value before does not move
    function = run_function(model, ["pull.stiffness", "body.mass"], outputs, at=at, until=1.0, rtol=1e-13)
    weights = np.linspace(-1.0, 1.0, 12)
    assert function.vjp(function.x0, weights) == pytest.approx(weights @ both.jacobian[:, 2:], rel=1e-10)
    along_one = directional(model, {"q0": [1.0], "body.mass": 2.0}, outputs, at=at, until=1.0, rtol=1e-13)
    assert along_one.jacobian[:, 0] == pytest.approx(both.jacobian @ [1, 0, 0, 2], rel=1e-10)
    first = simulate(model, until=0.7, rtol=1e-13)
    rest = simulate(model, until=1.0, state=first.state, rtol=1e-13)
    known = sensitivities(model, ("q0",), until=0.7, rtol=1e-13)
    after = rest.jacobian({"q0": known["q"], "u0": known["u"]}, ["guide.slide"])
    fresh = sensitivities(model, ("q0",), "guide.slide", until=0.7, rtol=1e-13)
    assert fresh["guide.slide"] == pytest.approx(known["q"][0])
    by_time = 20 * first.events[0].t
    assert rest.model.parameters["pull.stiffness"] == pytest.approx(by_time) and after.shape == (1, 1)


PASSES = 'when = "slide(guide) - 0.2"\ndirection = "falling"\n'


@pytest.mark.parametrize(
    ("when", "said"),
    [
        ("(t - 0.3)**2", r"found changed at t = 0\.3 s, where what it watches changes by .* it grazes zero"),
        ("1/(t - 0.3)", r"found changed at t = 0\.3 s, where what it watches has no finite derivative"),
        ("tan(5*(t - 0.3))", ""),
    ],
)
def test_events_that_do_not_cross_zero_are_refused(when: str, said: str, workshop: Workshop) -> None:
    model = workshop.model(
        SPRUNG.replace(PASSES, f'when = "{when}"\n') + 'set = { "pull.stiffness" = 20 }\n', derivatives=True
    )
    if said:
        with pytest.raises(ValueError, match=said):
            sensitivities(model, WRT, until=0.5)
    else:
        assert sensitivities(model, WRT, until=0.5).passed[0].dt == pytest.approx(np.zeros(4))


def test_what_jumps_over_zero_is_refused(workshop: Workshop) -> None:
    """As an angle that is counted without turns does; a pole comes where its inverse is zero, and moves as that."""
    jumps = workshop.model(
        SPRUNG.replace(PASSES, 'when = "atan2(sin(4*t), cos(4*t))"\ndirection = "falling"\n')
        + 'set = { "pull.stiffness" = 20 }\n',
        derivatives=True,
    )
    run = simulate(jumps, until=1.0)
    assert [event.t for event in run.events] == pytest.approx([np.pi / 4])
    with pytest.raises(ValueError, match=r"where what it watches is -?3\.14, expected zero: it jumps over zero there"):
        run.jacobian(WRT)
    pole = SPRUNG.replace(PASSES, 'when = "tan(slide(guide) + pi/2 - 0.2)"\n') + 'set = { "pull.stiffness" = 20 }\n'
    crossing = SPRUNG + 'set = { "pull.stiffness" = 20 }\n'
    one, other = (sensitivities(workshop.model(text, derivatives=True), WRT, until=1.0) for text in (pole, crossing))
    assert one.jacobian == pytest.approx(other.jacobian, abs=1e-8)


def test_events_that_a_column_parts_are_refused(workshop: Workshop) -> None:
    """The body passes 0.2 at the time at which another event comes; by its mass one of them comes first."""
    other = f'[[event]]\nname = "other"\nwhen = "t - {float(np.arccos(0.4) / 2)!r}"\nset = {{ "body.mass" = 3 }}\n'
    model = workshop.model(SPRUNG + 'set = { "pull.stiffness" = 20 }\n' + other, derivatives=True)
    with pytest.raises(ValueError, match=r"found changed and other at t = 0\.57963974 s, which body\.mass parts"):
        sensitivities(model, "body.mass", until=1.0)
    with pytest.raises(ValueError, match=r"landed at .* s, the instant of an impact, which ground_0\.normal\.x parts"):
        sensitivities(workshop.model('name = "derived"\n' + LANDING, derivatives=True), "ground_0.normal.x", until=0.5)


def test_lengths_that_are_set_leave_loops_shut(workshop: Workshop) -> None:
    """A length that is set to a number is what its column does not move any more, and the loop would be open."""
    late = '[[event]]\nname = "late"\nwhen = "t - 0.2"\nset = {{ "crank.points.B.x" = {}, "gravity.g" = 5 }}\n'
    number, itself = (
        workshop.model('name = "bars"\n' + FOUR_BAR + late.format(value), derivatives=True)
        for value in ("0.7", '"distance(crank.A, crank.B)"')
    )
    with pytest.raises(ValueError, match=r"found late at t = 0\.2 s, where crank\.points\.B\.x opens loops"):
        sensitivities(number, ["gravity.g", "crank.points.B.x"], until=0.5)
    assert sensitivities(number, "gravity.g", until=0.5).passed
    wrt = ["crank.points.B.x", "rocker.points.B.x"]
    plain = workshop.model('name = "bars"\n' + FOUR_BAR + late.format("0.7").split("set")[0], derivatives=True)
    there = plain.with_parameters({"gravity.g": 5.0})
    begun = sensitivities(plain, wrt, until=0.2, rtol=1e-12)
    run = simulate(there, begun.values["q"], begun.values["u"], until=0.3, rtol=1e-12)
    by = {"q0": begun["q"], "u0": begun["u"]} | dict(zip(wrt, np.eye(2), strict=True))
    wanted = run.jacobian(by)
    assert sensitivities(itself, wrt, until=0.5, rtol=1e-12).jacobian == pytest.approx(wanted, abs=1e-8)


def test_what_functions_of_python_set_is_refused(workshop: Workshop) -> None:
    model = workshop.model(SPRUNG + 'set = { "pull.stiffness" = "20*t" }\n', derivatives=True)
    plain = simulate(model, until=1.0).jacobian(WRT)
    asked = simulate(model, until=1.0, on_event={"changed": lambda event: None})
    assert np.array_equal(asked.jacobian(WRT), plain)
    for values in ({"pull.stiffness": 11.0}, {"body.mass": 3.0}):
        run = simulate(model, until=1.0, on_event={"changed": lambda event, values=values: values})
        with pytest.raises(ValueError, match=r"where a function of Python has changed .*, expected what the event's"):
            run.jacobian(WRT)


def test_the_time_of_an_event_is_none_to_read_outputs_at(workshop: Workshop) -> None:
    model = workshop.model(SPRUNG + 'set = { "pull.stiffness" = 20 }\n', derivatives=True)
    run = simulate(model, until=1.0)
    with pytest.raises(ValueError, match=r"at: found 0\.57963974 s, the time of changed, which sets or switches"):
        run.jacobian(WRT, at=run.events[0].t)


def test_contacts_that_strike_as_an_event_comes_are_refused(workshop: Workshop) -> None:
    """A box that slides jams on ground that becomes rough."""
    rough = '[[event]]\nname = "rough"\nwhen = "x(body.A) - 0.1"\nset = { "ground_0.friction" = 3 }\n'
    box = body(
        'contacts = ["body.A", "body.B"]\n' + rough,
        position="[0, 0]",
        velocity="[1, 0]",
        angle=0,
        com="[0.2, 0.1]",
        friction=0.5,
    ).replace("[0.05, 1.0]", "[0, 1]")
    box = box.replace("[gravity]", "[gravity]\ndirection = [0.1, -1]")
    model = workshop.model('name = "box"\n' + box, derivatives=True)
    with pytest.raises(ValueError, match=r"found rough at t = .* s, behind which contacts strike at once"):
        sensitivities(model, "gravity.g", until=0.15)


TABLE = """
name = "wheel"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "wheel"
mass = 1
inertia = 2
com = [0, 0]
points = { C = [0, 0] }
[[joint]]
name = "axle"
between = ["ground.O", "wheel.C"]
[[motor]]
joint = "axle"
table = [[0, 1], [0.8, 3]]
[[event]]
when = "direction(wheel) - 0.02"
set = { "INSTANT" = VALUE }
"""


@pytest.mark.parametrize("value", ['"0.6 + t"', "0.9"])
def test_a_time_at_which_a_load_jumps_is_set_to_numbers_alone(value: str, workshop: Workshop) -> None:
    """It is not known what the instant at which a torque bends does to a run where that moves."""
    plain = workshop.model(TABLE.partition("[[event]]")[0], derivatives=True)
    instant = plain.data["instants"][-1]
    model = workshop.model(TABLE.replace("INSTANT", instant).replace("VALUE", value), derivatives=True)
    if value.startswith('"'):
        with pytest.raises(ValueError, match="set to an expression by an event, a time at which a load jumps"):
            sensitivities(model, "wheel.inertia", until=1.0)
        return
    found = sensitivities(model, "wheel.inertia", ["q"], until=1.2, rtol=1e-12)
    ends = [simulate(model, until=1.2, rtol=1e-12, params={"wheel.inertia": 2 + h}).q[-1][0] for h in (1e-4, -1e-4)]
    assert found["q"][0, 0] == pytest.approx((ends[0] - ends[1]) / 2e-4, rel=1e-7)


TWO = (
    'name = "two"\n[gravity]\n[[ground]]\nrestitution = 0.5\ncontacts = ["one.C", "other.C"]\n[[event]]\n'
    'when = "slide(at_one) - 0.8"\nset = { "gravity.g" = "9 + 3*slide(at_other)*t" }\n'
    "[ground_link]\npoints = { O = [0, 0] }\n[start]\nslides = { at_one = 1.0, at_other = 1.0 }\n"
) + "".join(
    f'[[link]]\nname = "{name}"\nmass = 1\ninertia = 1\ncom = [0, 0]\npoints = {{ C = [0, 0] }}\n[[joint]]\n'
    f'name = "at_{name}"\ntype = "prismatic"\nbetween = ["ground.O", "{name}.C"]\naxis = [0, 1]\n'
    for name in ("one", "other")
)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_direction_that_parts_contacts_behind_an_event(way: float, workshop: Workshop) -> None:
    """Two balls land together, pulled by what has been set before; by differences to the one side, extrapolated."""
    model = workshop.model(TWO, derivatives=True)
    direction = way * np.array([1.0, 0.3])
    found = directional(model, {"q0": direction}, until=0.6, rtol=RTOL)
    assert [one.kind for one in found.passed] == ["event", "impact"]
    q, u = model.start()

    def end(h: float) -> Any:
        run = simulate(model, q + h * direction, u, until=0.6, rtol=RTOL)
        return np.concatenate([run.q[-1], run.u[-1]])

    rows = [(end(h) - end(0.0)) / h for h in (1e-3, 5e-4, 2.5e-4, 1.25e-4)]
    for order in range(1, 4):
        rows = [(2**order * fine - coarse) / (2**order - 1) for coarse, fine in pairwise(rows)]
    assert found.jacobian[:, 0] == pytest.approx(rows[0], rel=1e-8)


@pytest.mark.hard
@pytest.mark.parametrize("scene", SCENES)
def test_starts_at_random(scene: str, workshop: Workshop) -> None:
    """By central differences of the sixth order over steps so long that rounding of the instants is not seen."""
    text, until, _ = SCENES[scene]
    text = text if text.startswith("name") else 'name = "derived"\n' + text
    model, wide = workshop.model(text, derivatives=True), workshop.model(text, "wide")
    rng, met = np.random.default_rng(5), 0
    for _ in range(12):
        q, u = model.start()
        free = scene != "a four-bar" and "slides" not in scene
        q, u = q + 0.2 * free * rng.normal(size=len(q)), u + 0.4 * rng.normal(size=len(u))
        end = until * rng.uniform(0.6, 1.2)
        try:
            q, u = model.project(q, u)
            found = sensitivities(model, "gravity.g", ["q", "u"], q, u, until=end, rtol=RTOL)
        except ValueError as why:
            assert "found" in str(why) or "has no derivative" in str(why)
            continue

        def state(h: float, q: Any = q, u: Any = u, end: float = end) -> Any:
            moved = wide.with_parameters({"gravity.g": WIDE(9.81) + WIDE(h)})
            run = simulate(moved, np.asarray(q, dtype=WIDE), np.asarray(u, dtype=WIDE), until=end, rtol=1e-17)
            return np.concatenate([run.q[-1], run.u[-1]])

        best = min(
            float(np.max(np.abs(found.jacobian[:, 0] - _central(state, h))) / np.max(np.abs(found.jacobian)))
            for h in (1e-3, 1e-4, 1e-5)
        )
        assert best < 1e-7, (q, u, end)
        met += bool(found.passed)
    assert met >= 4


def _central(state: Any, h: float) -> Any:
    near, middle, far = ((state(k * h) - state(-k * h)) / (2 * k * h) for k in (1, 2, 3))
    return np.asarray(1.5 * near - 0.6 * middle + 0.1 * far, dtype=float)
