"""Values by rows over time: splines beside SciPy's, motions that follow them, and what is wrong with rows."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from ccgen.generator.effect_base.rows_in_time import Spline
from ccgen.generator.scene.errors import SceneError
from ccgen.runtime import simulate

from ..support.workshop import Workshop

KINDS = [(3, "rest"), (3, "straight"), (3, "periodic"), (5, "rest"), (5, "straight"), (5, "periodic")]
"""Orders and ends, but for straight lines."""
ROWS = [[0.3, 0.5], [0.5, 0.9], [1.1, 0.2], [1.2, 0.4], [1.9, 0.5]]
"""Uneven in time; the last value is the first, so that they may be periodic."""


def written(order: int, ends: str) -> str:
    return f'{{ rows = {ROWS}, order = {order}, ends = "{ends}" }}'


def through_rows(order: int, ends: str) -> Callable[[float, int], float]:
    """SciPy's spline through the rows, and what the ends say beyond them; derivatives by order."""
    t, y = np.array(ROWS).T
    half = (order - 1) // 2
    zero = range(1, half + 1) if ends == "rest" else range(2, half + 2)
    conditions = "periodic" if ends == "periodic" else ([(d, 0.0) for d in zero],) * 2
    inner = make_interp_spline(t, y, k=order, bc_type=conditions if order > 1 else None)

    def value(at: float, d: int) -> float:
        if ends == "periodic":
            return float(inner(t[0] + (at - t[0]) % (t[-1] - t[0]), nu=d))
        end = min(max(at, t[0]), t[-1])
        if at == end:
            return float(inner(at, nu=d))
        slope = 0.0 if ends == "rest" else float(inner(end, nu=1))
        return (float(inner(end)) + slope * (at - end), slope)[d] if d < 2 else 0.0

    return value


@pytest.mark.parametrize(("order", "ends"), [(1, "rest"), (1, "straight"), *KINDS])
def test_it_is_the_spline_of_scipy(order: int, ends: Any) -> None:
    spline, wanted = Spline(tuple((t, y) for t, y in ROWS), order, ends), through_rows(order, ends)
    for at in np.random.default_rng(2).uniform(-1.0, 3.0, 300):
        for d in range(order):
            assert spline.slope_at(float(at), d) == pytest.approx(wanted(float(at), d), rel=1e-11, abs=1e-11)


@pytest.mark.parametrize(("order", "ends"), KINDS)
@pytest.mark.parametrize("apart", [1e-3, 1e-6])
def test_rows_may_be_close_together(order: int, ends: Any, apart: float) -> None:
    """What does not jump at a row is the same on both sides of it, to rounding of its size there."""
    rows = ((0.0, 0.0), (0.4, 1.0), (0.4 + apart, 1.0 + apart), (1.0, 0.7), (2.0, 0.0))
    pieces = Spline(rows, order, ends).pieces
    for (t0, _), (t1, _), left, right in zip(rows[:-2], rows[1:-1], pieces[:-1], pieces[1:], strict=True):
        for d in range(order):
            terms = [
                math.perm(j, d) * c * (Fraction(t1) - Fraction(t0)) ** (j - d) for j, c in enumerate(left) if j >= d
            ]
            assert abs(sum(terms) - math.factorial(d) * right[d]) <= 1e-15 * max(map(abs, terms))


SLIDER = """
name = "slider"
[ground_link]
points = {{ O = [0, 0] }}
[[link]]
name = "cart"
mass = 2.0
inertia = 0.1
com = [0, 0]
points = {{ C = [0, 0] }}
[[joint]]
name = "rail"
type = "prismatic"
axis = 0
between = ["ground.O", "cart.C"]
[run]
until = 4.5
rtol = 1e-11
[start]
slides = {{ rail = {at} }}
{more}
"""


def position(run: Any, t: np.ndarray) -> np.ndarray:
    return np.array([float(run.model.slides(run.at(s)[0])["rail"]) for s in t])


@pytest.mark.sample(3)
@pytest.mark.parametrize(("order", "ends"), KINDS)
def test_a_driven_slider_is_where_the_spline_is(order: int, ends: str, workshop: Workshop) -> None:
    """Within the rows and beyond, where its acceleration jumps at the ends too."""
    wanted = through_rows(order, ends)
    drive = f'[[drive]]\njoint = "rail"\nposition = {written(order, ends)}'
    run = simulate(workshop.model(SLIDER.format(at=wanted(0.0, 0), more=drive)))
    assert run.success, run.message
    times = np.linspace(0.0, 4.5, 120)
    assert position(run, times) == pytest.approx([wanted(t, 0) for t in times], abs=1e-9)


@pytest.mark.sample(3)
@pytest.mark.parametrize(("order", "ends"), [(1, "rest"), (1, "straight"), *KINDS[:2], *KINDS[3:]])
def test_a_driven_slider_is_as_fast_as_the_spline(order: int, ends: str, workshop: Workshop) -> None:
    """Order 1, whose acceleration jumps at every row, included: the usual profile of a drive."""
    wanted = through_rows(order, ends)
    run = simulate(
        workshop.model(SLIDER.format(at=0, more=f'[[drive]]\njoint = "rail"\nspeed = {written(order, ends)}'))
    )
    assert run.success, run.message
    times = np.linspace(0.0, 4.5, 120)
    assert [float(run.at(t)[1][0]) for t in times] == pytest.approx([wanted(t, 0) for t in times], abs=1e-9)


def test_a_trapezium_of_speed_covers_its_area(workshop: Workshop) -> None:
    rows = "{ rows = [[0, 0], [0.5, 2], [2, 2], [2.25, 0]], order = 1 }"
    run = simulate(workshop.model(SLIDER.format(at=0, more=f'[[drive]]\njoint = "rail"\nspeed = {rows}')))
    assert position(run, np.array([0.25, 0.5, 2.0, 2.25, 4.0])) == pytest.approx(
        [0.125, 0.5, 3.5, 3.75, 3.75], abs=1e-12
    )


@pytest.mark.parametrize("method", ["gauss", "dop853", "radau"])
def test_steps_end_at_the_rows(method: str, workshop: Workshop) -> None:
    """So that methods keep their order: the error at coarse tolerances is that of smooth motion between the rows."""
    text = SLIDER.format(at=0, more=f'[[motor]]\njoint = "rail"\nforce = {written(1, "rest")}')
    run = simulate(workshop.model(text), method=method, rtol=1e-5)
    t, y = np.array(ROWS).T
    exact = np.array([np.trapezoid(np.interp(grid := np.union1d(t[t < s], [0.0, s]), t, y), grid) / 2.0 for s in t])
    assert [float(run.at(s)[1][0]) for s in t] == pytest.approx(exact, abs=1e-12)
    assert set(t) <= set(run.t)


def test_rows_are_the_table_of_a_motor(workshop: Workshop) -> None:
    by_rows, by_table = (
        simulate(workshop.model(SLIDER.format(at=0, more=f'[[motor]]\njoint = "rail"\n{key}')))
        for key in (f"force = {written(1, 'rest')}", f"table = {ROWS}")
    )
    assert by_rows.q[-1] == pytest.approx(by_table.q[-1], abs=1e-12)


def test_a_servo_follows_rows(workshop: Workshop) -> None:
    """As it follows the same motion written as an expression: a polynomial of degree three between two rows."""
    gains = "stiffness = 300\ndamping = 40"
    rows = "{ rows = [[0, 0], [4.5, 9]], order = 3 }"
    smooth = "9*(3*(t/4.5)**2 - 2*(t/4.5)**3)"
    first, second = (
        simulate(workshop.model(SLIDER.format(at=0, more=f'[[motor]]\njoint = "rail"\n{gains}\nposition = {one}')))
        for one in (rows, f'"{smooth}"')
    )
    assert first.q[-1] == pytest.approx(second.q[-1], abs=1e-10)


TURNED = """
name = "turned"
[ground_link]
points = { O = [0, 0] }
[[part]]
name = "arm"
[[part.link]]
name = "rod"
mass = 1.0
inertia = 0.1
com = [0.1, 0.05]
points = { A = [0, 0] }
[[part.joint]]
name = "hip"
between = ["ground.O", "rod.A"]
[[part.drive]]
joint = "hip"
angle = { rows = [[0, 0.3], [1, "60 deg"]], order = 5 }
[[place]]
name = "one"
part = "arm"
[[place]]
name = "two"
part = "arm"
mirror = true
angle = "20 deg"
[start]
[gravity]
"""


def test_a_part_in_a_mirror_turns_the_other_way(workshop: Workshop) -> None:
    run = simulate(workshop.model(TURNED), until=0.7)
    ways = run.q - run.q[0]
    assert ways[-1, 0] > 0.3 and ways[:, 1] == pytest.approx(-ways[:, 0], abs=1e-12)


WRONG = {
    "no rows": ("position = { rows = [[0, 1]], order = 3 }", r"drive\[0\]\.position\.rows: .*at least two"),
    "no order": (
        "position = { rows = [[0, 1], [1, 2]] }",
        r"drive\[0\]\.position: .*it has neither order nor law; write",
    ),
    "even order": (
        "position = { rows = [[0, 1], [1, 2]], order = 2 }",
        r"position\.order: found 2, expected .*1 .*3 or 5",
    ),
    "backward": ("position = { rows = [[0, 1], [1, 2], [1, 3]], order = 3 }", r"row 2 has t = 1 after t = 1"),
    "not closed": (
        'position = { rows = [[0, 1], [1, 2]], order = 5, ends = "periodic" }',
        r"position\.ends: .*the last row has 2, the first 1; end with the value of the first",
    ),
    "other ends": ('position = { rows = [[0, 1], [1, 2]], order = 5, ends = "loop" }', r'"rest" \(stay\), "straight"'),
    "other key": ("position = { rows = [[0, 1], [1, 2]], order = 5, degree = 3 }", r"position\.degree: found"),
    "a jump of the speed": (
        "position = { rows = [[0, 1], [1, 2]], order = 1 }",
        r"order = 1 for the position, expected 3",
    ),
    "a jump again and again": (
        'speed = { rows = [[0, 1], [1, 1]], order = 1, ends = "periodic" }',
        r"order = 1 for a speed that is periodic, expected 3 or 5",
    ),
    "a row of three": ("position = { rows = [[0, 1, 2], [1, 2]], order = 3 }", r"position\.rows\[0\]"),
    "a mass": ('position = { rows = [[0, "1 kg"], [1, 2]], order = 3 }', r"position\.rows\[0\]\[1\]: .*kg"),
    "too large": ("position = { rows = [[0, 0], [1, 1e308], [2, -1e308]], order = 3 }", r"no spline in doubles"),
    "too near": ("position = { rows = [[0, 0], [1e-200, 1], [1, 0]], order = 3 }", r"no spline in doubles"),
    "an angle": ("angle = { rows = [[0, 1], [1, 2]], order = 3 }", r"found angle, expected position at this joint"),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_rows(case: str, workshop: Workshop) -> None:
    key, said = WRONG[case]
    with pytest.raises(SceneError, match=said):
        workshop.scene(SLIDER.format(at=0, more=f'[[drive]]\njoint = "rail"\n{key}'))


def test_rows_stand_where_joints_move_alone(workshop: Workshop) -> None:
    load = '[[force]]\npoint = "cart.C"\nvector = [{ rows = [[0, 1], [1, 2]], order = 3 }, 0]'
    with pytest.raises(SceneError, match=r"force\[0\]\.vector\[0\]: .*rows over time are for what joints do"):
        workshop.scene(SLIDER.format(at=0, more=load))


def test_degrees_in_rows_are_remarked_on(workshop: Workshop) -> None:
    text = TURNED.replace('[1, "60 deg"]', "[1, 60]")
    assert any("rows[1][1]" in remark and "60 deg" in remark for remark in map(str, workshop.scene(text).remarks))


INVERSE = {
    "sqrt": ("sqrt(1 + t**2)", lambda t: math.sqrt(1 + t * t)),
    "asin": ("asin(0.8*sin(2*t))", lambda t: math.asin(0.8 * math.sin(2 * t))),
    "acos": ("acos(0.6*cos(t))", lambda t: math.acos(0.6 * math.cos(t))),
    "atan": ("atan(3*t - 2)", lambda t: math.atan(3 * t - 2)),
    "atan2": ("atan2(sin(2*t), cos(2*t) + 0.3)", lambda t: math.atan2(math.sin(2 * t), math.cos(2 * t) + 0.3)),
}


@pytest.mark.sample(2)
@pytest.mark.parametrize("case", INVERSE)
def test_angles_from_ratios_are_functions_of_time(case: str, workshop: Workshop) -> None:
    """A drive by them is where they are, with turns counted on; a servo pulls as far as they are away."""
    text, value = INVERSE[case]
    driven = simulate(
        workshop.model(SLIDER.format(at=value(0.0), more=f'[[drive]]\njoint = "rail"\nposition = "{text}"'))
    )
    assert driven.success, driven.message
    found = position(driven, times := np.linspace(0.0, 4.5, 60))
    turns = np.array([value(float(t)) for t in times])
    assert found == pytest.approx(np.unwrap(turns), abs=1e-9)
    servo = workshop.model(SLIDER.format(at=0, more=f'[[motor]]\njoint = "rail"\nstiffness = 2\nposition = "{text}"'))
    q, u = servo.start()
    for t in (0.0, 0.4, 1.1, 3.3):
        assert float(servo.acceleration(q, u, t=t)[0]) == pytest.approx(value(t), abs=1e-12)
    damped = workshop.model(SLIDER.format(at=0, more=f'[[motor]]\njoint = "rail"\ndamping = 2\nposition = "{text}"'))
    for t in (0.0, 0.4, 1.1, 3.3):
        slope = (value(t + 1e-5) - value(t - 1e-5)) / 2e-5
        assert float(damped.acceleration(q, u, t=t)[0]) == pytest.approx(slope, abs=1e-7)


def test_periods_that_are_too_short_are_told(workshop: Workshop) -> None:
    rows = '{ rows = [[0, 1], [5e-10, 1], [1e-9, 1]], order = 3, ends = "periodic" }'
    model = workshop.model(SLIDER.format(at=0, more=f'[[motor]]\njoint = "rail"\nforce = {rows}'))
    with pytest.raises(ValueError, match="begin anew every 1e-09 s, "):
        simulate(model)


def test_rows_hold_from_their_own_instant_on(workshop: Workshop) -> None:
    """At a row what is asked of the run is that of the piece that begins there, at the first one too.

    A speed by straight lines has accelerations 4 and 0 m/s² from 0 and 0.5 s on, and the rail's drive pushes 4 m.
    """
    rows = "{ rows = [[0, 0], [0.5, 2], [1, 2]], order = 1 }"
    model = workshop.model(SLIDER.format(at=0, more=f'[[drive]]\njoint = "rail"\nspeed = {rows}'))
    run = simulate(model, until=1.0)
    times = np.array([0.0, 0.25, 0.5, 0.75])
    assert run.accelerations(times)[:, 0] == pytest.approx([4.0, 4.0, 0.0, 0.0], abs=1e-12)
    mass = sum(value for path, value in model.parameters.items() if path.endswith(".mass"))
    pushed = run.reactions(times)[:, model.joints.index("rail"), 0]
    assert pushed == pytest.approx(4.0 * mass * np.array([1, 1, 0, 0]), abs=1e-9)
