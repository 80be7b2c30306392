"""Compiled event indicators against expressions read in Python, and the core's events against looks at each step."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import Run, simulate

from ..support.event_search import seen, signals_of
from ..support.quantities import Quantity
from ..support.tiers import hard
from ..support.workshop import Workshop
from .test_user_events import BALL, PENDULUM

SCENES = Path(__file__).parents[2] / "scenes"
SLIDER = (SCENES / "slider-crank.toml").read_text()
HEXAGON = (SCENES / "falling-hexagon.toml").read_text()
EXPRESSIONS = {
    PENDULUM: (
        "angle(pin) + pi/2",
        "sin(angle(pin)) - cos(2*t)*tan(0.1*direction(rod))",
        "exp(-t) * log(2 + y(rod.B)**2) / (3 - x(rod.B))",
        "sqrt(5 + x(rod.B)) - tanh(y(rod.B)) + abs(direction(rod))",
        "asin(0.5*sin(t)) - acos(0.3*x(rod.B)) + atan(angle(pin))",
        "atan2(y(rod.B), x(rod.B)) - 1",
        "rate(angle(pin))*x(rod.B) - 2",
        "(distance(ground.O, rod.B) - 1.5)**3 + t**0 - 2**2*t",
        "rate(y(rod.B)) - -(-1)",
    ),
}


def tables(whens: tuple[str, ...]) -> str:
    return "".join(f'[[event]]\nname = "e{number}"\nwhen = "{when}"\n' for number, when in enumerate(whens))


def states(model: Any, count: int, seed: int) -> tuple[Any, Any, Any]:
    rng, n = np.random.default_rng(seed), len(model.q_names)
    return rng.uniform(0.0, 3.0, count), rng.uniform(-3.0, 3.0, (count, n)), rng.uniform(-3.0, 3.0, (count, n))


@pytest.mark.parametrize("precision", ["double", "wide", hard("float")])
def test_indicators_are_the_expressions_with_their_rates_and_sizes(precision: str, workshop: Workshop) -> None:
    """Every function, operator and quantity; the two derive rates and sizes each on its own."""
    for text, whens in EXPRESSIONS.items():
        model = workshop.model(text + tables(whens), precision)
        compare(model, *states(model, 200, 1))


def test_indicators_of_sliding_joints_and_floating_links(workshop: Workshop) -> None:
    slider = workshop.model(SLIDER + tables(("slide(guide) - 0.1*angle(wrist_pin)", "rate(slide(guide))*t")))
    q, u = slider.start()
    run = simulate(slider, q, u, until=1.0)
    compare(slider, run.t, run.q, run.u)
    whens = ("y(joint_3) - distance(joint_0, link_2.A)", "rate(x(link_4.B)) - angle(joint_2)")
    hexagon = workshop.model(HEXAGON + tables(whens))
    run = simulate(hexagon, until=1.0)
    compare(hexagon, run.t, run.q, run.u)


def compare(model: Any, t: Any, q: Any, u: Any) -> None:
    numbers = model.start()[0].dtype
    t, q, u = (np.ascontiguousarray(one, dtype=numbers) for one in (t, q, u))
    values, rates, sizes = model.kernels.indicators(t, q, u)
    assert values.dtype == numbers
    eps = float(max(np.finfo(numbers).eps, np.finfo(float).eps))
    for number, event in enumerate(model.data["events"]):
        read = Quantity(event["when"]).along(model, t, q, u)
        known = np.isfinite(read.value)
        assert known.sum() > len(t) / 2, event
        value, rate, size = (one[known, number] for one in (values, rates, sizes))
        assert np.all(np.abs(value - read.value[known]) <= 16 * eps * read.size[known]), event
        assert np.all(np.abs(size - read.size[known]) <= 1e4 * eps * read.size[known]), event
        if read.rate is None:
            assert not rate.any()
        else:
            scale = np.abs(read.rate[known]) + read.size[known]
            assert np.all(np.abs(rate - read.rate[known]) <= 1e4 * eps * scale), event


def by_all_looks(run: Run) -> list[tuple[str, int, float]]:
    """Name, direction and time of the events of a run, found by looking through each of its steps with the expressions
    read in Python."""
    events = run.model.data["events"]
    signals = signals_of(events)
    found = seen(None, run, signals, [False] * len(signals)).found
    every = [
        (t, number, events[signal.event]["name"], signal.sign)
        for number, (signal, one) in enumerate(zip(signals, found, strict=True))
        for t in one.times
    ]
    struck = [impact.t for impact in run.impacts]

    def at_impact(t: float) -> float:
        near = [one for one in struck if abs(one - t) <= 1e-12 * max(abs(t), run.model.duration)]
        return min(near, key=lambda one: abs(one - t)) if near else t

    return sorted((name, sign, at_impact(t)) for t, _, name, sign in every)


QUANTITIES = {
    PENDULUM: ("angle('pin')", "x('rod.B')", "rate(y('rod.B'))"),
    BALL: ("y('ball.P')", "rate(y('ball.P'))", "x('ball.P') + t"),
    HEXAGON: ("y('joint_3')", "angle('joint_1')", "rate(direction('link_2'))", "distance('joint_0', 'joint_3')"),
    SLIDER: ("slide('guide')", "rate(slide('guide'))", "y('crank_pin')"),
}
WAYS: tuple[dict[str, Any], ...] = (
    {},
    {"method": "dop853", "rtol": 1e-6},
    {"method": "radau", "rtol": 1e-5},
    {"method": "dopri5"},
    {"rtol": 1e-4},
    {"method": "moreau", "step": 4e-3},
)


@pytest.mark.parametrize("way", range(len(WAYS)))
@pytest.mark.parametrize("text", QUANTITIES, ids=lambda text: text.split('"')[1])
def test_no_event_is_missed_in_steps_that_are_not_looked_through(text: str, way: int, workshop: Workshop) -> None:
    """Levels that the motion passes, that it all but reaches and all but misses, and that it only touches."""
    plain = workshop.model(text)
    options = {"until": 1.5, **WAYS[way]}
    before = simulate(plain, **options)
    times = np.linspace(0.0, 1.5, 4001)
    q, u = before.at(times)
    whens = []
    rng = np.random.default_rng(way)
    for quantity in QUANTITIES[text]:
        along = Quantity(quantity).along(plain, times, q, u).value
        low, high = float(along.min()), float(along.max())
        levels = [
            *rng.uniform(low, high, 2),
            high - 1e-3 * (high - low),
            low + 1e-6 * (high - low),
            high,
            2 * high - low,
        ]
        whens += [f"{quantity} - ({float(level)!r})" for level in levels]
    run = simulate(workshop.model(text + tables(tuple(whens))), **options)
    for mine, theirs in ((run.t, before.t), (run.q, before.q), (run.u, before.u)):
        assert mine.tobytes() == theirs.tobytes()
    found = sorted((event.name, 1 if event.direction == "rising" else -1, event.t) for event in run.events)
    expected = by_all_looks(run)
    assert [one[:2] for one in found] == [one[:2] for one in expected]
    assert len(found) > 3
    assert [one[2] for one in found] == pytest.approx([one[2] for one in expected], abs=1e-9)
    for event in run.events:
        q_then, u_then = run.at(event.t)
        assert (event.q == q_then).all() and (event.u == u_then).all()


@pytest.mark.parametrize("way", range(len(WAYS)))
@pytest.mark.parametrize("text", QUANTITIES, ids=lambda text: text.split('"')[1])
def test_runs_that_end_and_go_on_at_events_have_those_that_are_told(text: str, way: int, workshop: Workshop) -> None:
    """Each sets gravity to what it is: none comes twice, or not at all, and each run ends where its event is."""
    options = {"until": 1.2, **WAYS[way]}
    exact = "step" not in options
    for quantity in QUANTITIES[text][:3]:
        plain = workshop.model(text)
        before = simulate(plain, **options)
        times = np.linspace(0.0, 1.2, 301)
        along = Quantity(quantity).along(plain, times, *before.at(times)).value
        level = float(along.min() + 0.61 * (along.max() - along.min()))
        table = f'[[event]]\nname = "e"\nwhen = "{quantity} - ({level!r})"\n'
        told = simulate(workshop.model(text + table), **options)
        g = plain.parameters["gravity.g"]
        model = workshop.model(text + table + f'set = {{ "gravity.g" = {g!r} }}\n')
        sets = simulate(model, **options)
        assert sets.success and told.events
        assert [one.direction for one in sets.events] == [one.direction for one in told.events]
        error = 1e3 * options.get("rtol", 1e-9) if exact else 2 * options["step"]  # each misses a step
        assert [one.t for one in sets.events] == pytest.approx([one.t for one in told.events], abs=error)
        if exact:
            assert sets.q[-1] == pytest.approx(told.q[-1], abs=10 * error)
        for event in sets.events:
            rows = np.flatnonzero(sets.t == event.t)
            assert rows.size and (sets.q[rows[-1]] == event.q).all()
            values, _, sizes = model.kernels.indicators(np.array([event.t]), event.q[None], event.u[None])
            sign = 1.0 if event.direction == "rising" else -1.0
            assert sign * values[0, 0] >= -64 * np.finfo(float).eps * sizes[0, 0]


@pytest.mark.parametrize("method", ["gauss", "dop853", "dopri5", "radau"])
@pytest.mark.parametrize(
    ("when", "level"),
    [
        ("sqrt(slide(guide) - 0.2) - 0.1", 0.21),
        ("log(slide(guide)) + 2", np.exp(-2.0)),
        ("log(slide(guide) + 0.1)", 1.0),
    ],
)
@pytest.mark.parametrize("scene", ["", "released"])
def test_expressions_without_a_value_come_to_nothing(
    when: str, level: float, method: str, scene: str, workshop: Workshop
) -> None:
    """A cart swings as 0.3 cos(5t); where a root or a logarithm has no value no event comes, and none is lost."""
    model = workshop.model((RELEASED if scene else CART) + f'[[event]]\nwhen = "{when}"\n')
    found = [(event.t, event.direction) for event in simulate(model, method=method).events]
    first = np.arccos(level / 0.3) / 5.0 if level < 0.3 else np.nan
    turns = [k * 2.0 * np.pi / 5.0 for k in range(5)] if level < 0.3 else []
    expected = sorted([(t + first, "falling") for t in turns] + [(t - first, "rising") for t in turns[1:]])
    expected = [one for one in expected if one[0] <= 5.0]
    assert [one[1] for one in found] == [one[1] for one in expected]
    assert [one[0] for one in found] == pytest.approx([one[0] for one in expected], abs=1e-7)


@pytest.mark.parametrize("scene", ["", "released"])
@pytest.mark.parametrize("order", [1, -1])
def test_borders_in_one_step_are_looked_at_in_the_order_of_time(order: int, scene: str, workshop: Workshop) -> None:
    """By chosen steps, by long and by very short ones; at a border itself nothing comes."""
    tables = [f'[[event]]\nname = "{name}"\nwhen = "{when}"\ndirection = "falling"\n' for name, when in BORDERS.items()]
    model = workshop.model((RELEASED if scene else CART) + "".join(tables[::order]))
    expected = [("d", 0.75), ("b", 0.9995 - 1e-8), ("a", 1.0 - 1e-8)]
    for step in (None, 0.125, 0.01):
        run = simulate(model, until=1.2, step=step)
        assert [event.name for event in run.events] == [name for name, _ in expected], step
        assert [event.t for event in run.events] == pytest.approx([t for _, t in expected], abs=1e-11)
    first = simulate(model, until=1.0 - 1e-10)
    assert simulate(model, state=first.state, until=1.0 + 1e-10).success


BORDERS = {"a": "sqrt(1 - t) - 1e-4", "b": "sqrt(0.9995 - t) - 1e-4", "d": "sqrt(1 - t) - 0.5"}


@pytest.mark.parametrize("scene", ["", "released"])
def test_one_that_comes_back_beyond_zero_comes_where_it_has_a_value_again(scene: str, workshop: Workshop) -> None:
    text = (
        RELEASED if scene else CART
    ) + '[[event]]\nwhen = "sqrt((t - 1)*(t - 1.537)) + t - 1.2"\ndirection = "rising"\n'
    model = workshop.model(text)
    for step in (None, 0.1):
        assert [event.t for event in simulate(model, until=2.0, step=step).events] == [pytest.approx(1.537, abs=1e-6)]


def test_borders_in_floats(workshop: Workshop) -> None:
    model = workshop.model(CART + '[[event]]\nwhen = "sqrt(1 - t) - 0.5"\n', precision="float")
    assert [float(event.t) for event in simulate(model, until=2.0).events] == [pytest.approx(0.75, abs=1e-4)]


CART = """
name = "cart"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "cart"
mass = 2
inertia = 1
com = [0, 0]
points = { A = [0, 0] }
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.O", "cart.A"]
axis = [1, 0]
[[spring]]
between = ["ground.O", "cart.A"]
stiffness = 50
[start]
slides = { guide = 0.3 }
[run]
until = 5
"""


RELEASED = (
    CART.replace(
        "[start]",
        """[[link]]
name = "arm"
mass = 1
inertia = 1
com = [0.5, 0]
points = { A = [0, 0] }
[[joint]]
name = "hip"
between = ["ground.O", "arm.A"]
[start]""",
    )
    + '[[release]]\njoint = "hip"\nat = 9\n'
)
"""The same beside a joint that may let go."""


@pytest.mark.parametrize("scene", ["", "released"])
def test_a_rate_beside_no_value_makes_no_event(scene: str, workshop: Workshop) -> None:
    """That of the logarithm of a negative number would be one; the value crosses nearer to where it begins than can be
    told."""
    text = (RELEASED if scene else CART) + '[[event]]\nwhen = "log(slide(guide)) + 25"\n'
    model = workshop.model(text)
    for method in ("gauss", "dopri5", "radau"):
        assert simulate(model, until=2.0, method=method).events == ()


@pytest.mark.parametrize("precision", ["double", hard("wide")])
def test_an_event_at_an_impact_comes_behind_it(precision: str, workshop: Workshop) -> None:
    """Whatever the last digits of both are: the restitution that it sets is that of the next impact."""
    text = BALL + '[[event]]\nname = "hit"\nwhen = "y(ball.P)"\nset = { "ground_0.restitution" = 1 }\n'
    model = workshop.model(text, precision)
    q, u = model.start()
    for height in np.random.default_rng(0).uniform(0.2, 20.0, 60):
        q[1] = height
        run = simulate(model, q, u, until=1.2 * float(np.sqrt(2.0 * height / 9.81)))
        (event,) = run.events
        assert float(event.t) == pytest.approx(float(run.impacts[0].t), abs=1e-15 * max(1.0, float(event.t)))
        assert float(run.impacts[0].energy_loss) == pytest.approx(0.75 * 9.81 * height) and event.u[1] > 0.0


def test_wide_runs_end_and_go_on_at_events(workshop: Workshop) -> None:
    """At times that doubles have: what goes on begins where the piece before has ended."""
    table = '[[event]]\nname = "down"\nwhen = "angle(pin) + pi/2"\nset = { "gravity.g" = 9.81 }\n'
    wide, model = workshop.model(PENDULUM + table, "wide"), workshop.model(PENDULUM + table)
    for lower in np.linspace(0.0, 1.0, 8):
        runs = [simulate(one, one.start()[0] - lower, one.start()[1], until=4.0) for one in (wide, model)]
        found, expected = ([float(event.t) for event in run.events] for run in runs)
        assert found == pytest.approx(expected, abs=1e-8) and len(found) in (2, 3)


@pytest.mark.parametrize("rtol", [0.03, 0.01, 1e-4])
def test_levels_just_below_a_peak_are_found_in_long_steps(rtol: float, workshop: Workshop) -> None:
    """By the default method, whose steps have no accelerations at their ends."""
    for level in (0.9, 0.98, 0.99, 0.995):
        text = PENDULUM + f'[[event]]\nname = "e"\nwhen = "angle(pin) + pi/2 - {0.05 * level!r}"\n'
        model = workshop.model(text)
        run = simulate(model, np.array([-np.pi / 2 + 0.05]), np.zeros(1), until=12.0, rtol=rtol)
        assert len(run.events) == len(by_all_looks(run)) > 0
