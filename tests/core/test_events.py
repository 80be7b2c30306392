"""Search and location of events by themselves: on known motions, and on a ball above the ground."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
import pytest

from ..support.core_functions import CORE, Functions
from ..support.folders import ROOT

Array = Any
EPS = float(np.finfo(float).eps)
TERMS, WIDTH = 7, 10
NONE = (-1, 2.0)
METHODS = ("dop853", "gauss", "dopri5", "radau")


@pytest.fixture(scope="module")
def core(tmp_path_factory: pytest.TempPathFactory) -> Functions:
    layers = sorted(path.name for path in CORE.iterdir() if path.is_dir())
    return Functions(tmp_path_factory.mktemp("events"), *layers, sources=(ROOT / "tests" / "c" / "events.c",))


def first(core: Functions, *gaps: Array, turning: float = 0.0, slow: float = 1e-10) -> tuple[int, float]:
    """Contact and place of the first event of gaps: coefficients, and a cosine's height, frequency and phase."""
    table = np.zeros((len(gaps), WIDTH))
    for row, gap in zip(table, gaps, strict=True):
        row[: len(gap)] = gap
    theta = np.zeros(1)
    return core.call("first_event", len(gaps), table, turning, slow, theta), theta[0].item()


def with_zeros(*zeros: float, scale: float = 1.0) -> Array:
    """Coefficients of the polynomial with these zeros, positive before the first one."""
    return scale * (-1.0) ** len(zeros) * np.polynomial.polynomial.polyfromroots(zeros)


def known_to(coefficients: Array, theta: float) -> float:
    """What a zero of a polynomial is known to: the rounding of its terms over its slope, and of theta itself.

    Horner's scheme of degree d rounds its value by at most 2 d EPS times the sum of the sizes of its terms.
    """
    degree = len(coefficients) - 1
    size = np.polynomial.polynomial.polyval(theta, np.abs(coefficients))
    slope = abs(np.polynomial.polynomial.polyval(theta, np.polynomial.polynomial.polyder(coefficients)))
    return float(2.0 * (2 * degree + 1) * EPS * size / slope + 1e-15)


# -- the search -------------------------------------------------------------------------------------------------


@pytest.mark.sample(12)
@pytest.mark.parametrize("seed", range(40))
def test_the_first_zero_is_found(seed: int, core: Functions) -> None:
    """Of two to five zeros, each in a piece of its own: the first, at which the gap falls, to rounding."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 6))
    zeros = np.cumsum(rng.uniform(0.13, 0.2, count)) - 0.05
    gap = with_zeros(*zeros, scale=10.0 ** rng.integers(-6, 7))
    contact, theta = first(core, gap)
    assert contact == 0
    assert abs(theta - zeros[0]) <= known_to(gap, zeros[0])


@pytest.mark.parametrize("seed", range(60))
def test_zeros_that_share_a_piece(seed: int, core: Functions) -> None:
    """Four or six within a piece or two, no two nearer than a fortieth of a step: the gap falls and rises more than
    once between two samples."""
    rng = np.random.default_rng(seed)
    zeros = rng.uniform(0.05, 0.5) + np.cumsum(rng.uniform(0.025, 0.05, int(rng.choice([4, 6]))))
    gap = with_zeros(*zeros, scale=10.0 ** rng.integers(-3, 4) / 0.1 ** len(zeros))
    contact, theta = first(core, gap)
    assert contact == 0
    assert abs(theta - zeros[0]) <= known_to(gap, zeros[0])


@pytest.mark.parametrize("centre", [0.03, 0.2501, 0.43, 0.5, 0.62501, 0.97])
@pytest.mark.parametrize("depth", [1e-4, 1e-8, 1e-12])
def test_a_dip_between_samples(depth: float, centre: float, core: Functions) -> None:
    """A parabola below zero for 2 sqrt(depth) of a step is found where it enters; one that much above zero is none."""
    below, above = ([centre**2 + sign * depth, -2.0 * centre, 1.0] for sign in (-1.0, 1.0))
    entry = centre - np.sqrt(depth)
    contact, theta = first(core, below)
    assert contact == 0
    assert abs(theta - entry) <= known_to(np.array(below), entry)
    assert first(core, above) == NONE


def test_a_parabola_that_touches_is_known_to_the_root_of_rounding(core: Functions) -> None:
    """With its value known to EPS a double zero is found or not; what is found is within some sqrt(EPS) of it."""
    for centre in np.linspace(0.05, 0.95, 37):
        contact, theta = first(core, [centre**2, -2.0 * centre, 1.0])
        assert contact == -1 or abs(theta - centre) <= 4.0 * np.sqrt(EPS)


def test_a_gap_that_is_closed_and_opens_is_no_event(core: Functions) -> None:
    """From a zero at the start on: the next zero is the event, or there is none."""
    contact, theta = first(core, [0.0, 0.6, -1.0])
    assert contact == 0
    assert theta == pytest.approx(0.6, abs=1e-14)
    assert first(core, [0.0, 1.0]) == NONE
    assert first(core, [0.0, 0.0, 1.0]) == NONE  # with a rate of zero, too
    assert first(core, [0.0]) == NONE  # and one that stays closed


@pytest.mark.parametrize("end", [0.6, 0.06])
def test_a_gap_at_rest_that_opens_first_closes_later(end: float, core: Functions) -> None:
    """theta^2 (end - theta): neither gap nor rate is other than zero at first; also if all that is in one piece."""
    contact, theta = first(core, [0.0, 0.0, end, -1.0])
    assert contact == 0
    assert theta == pytest.approx(end, abs=1e-14)


@pytest.mark.parametrize(("rate", "expected"), [(-1.0, 0.0), (-1e-9, 0.0), (-1e-11, 0.0)])
def test_a_closed_gap_that_falls_is_an_event_at_once(rate: float, expected: float, core: Functions) -> None:
    """By its rate if that is beyond what is slow (1e-10), else since it never opens."""
    assert first(core, [0.0, rate]) == (0, expected)


def test_a_slow_start_is_no_fall_if_it_opens(core: Functions) -> None:
    """Falling at 1e-11 at first and rising from then on, to 0.5; another that falls at 1e-9 enters."""
    assert first(core, [0.0, -1e-11, 0.5]) == NONE
    assert first(core, [0.0, -1e-9, 0.5]) == (0, 0.0)


def test_the_first_of_several(core: Functions) -> None:
    """In order of time whatever the order of contacts; of those at one time, the first contact."""
    late, early, never = with_zeros(0.61), with_zeros(0.57), np.array([1.0])
    assert first(core, never, late, early)[0] == 2
    assert first(core, never, early, late)[0] == 1
    together = [with_zeros(0.5) for _ in range(9)]
    contact, theta = first(core, never, *together)
    assert (contact, theta) == (1, pytest.approx(0.5, abs=1e-15))


@pytest.mark.parametrize("waves", [1, 2, 4, 12, 24, 25, 26, 50])
def test_gaps_that_come_and_go_with_teeth(waves: int, core: Functions) -> None:
    """height + slope theta + cos(waves turning theta + phase), as of a wheel of so many teeth, by up to 40 rad."""
    rng = np.random.default_rng(waves)
    grid = np.linspace(0.0, 1.0, 40_001)
    for _ in range(100):
        turning = rng.uniform(1.0, 40.0)
        height, slope, phase = (
            1.0 + 10.0 ** rng.uniform(-3.0, 0.5),
            -(10.0 ** rng.uniform(-3.0, 0.7)),
            rng.uniform(0, 7),
        )
        gap = np.zeros(WIDTH)
        gap[:2], gap[TERMS:] = [height, slope], [1.0, waves * turning, phase]
        values = height + slope * grid + np.cos(waves * turning * grid + phase)
        below = np.flatnonzero(values < 0.0)
        contact, theta = first(core, gap, turning=turning)
        if not below.size:  # but for what lies between two points of the grid
            assert contact == -1 or abs(height + slope * theta + np.cos(waves * turning * theta + phase)) <= 1e-9
        else:
            assert contact == 0 and theta <= grid[below[0]] + 1e-12


@pytest.mark.parametrize("frequency", [30.0, 200.0, 3000.0])
def test_links_that_turn_often_in_a_step(frequency: float, core: Functions) -> None:
    """cos(w theta) + 0.5 is zero first at 2 pi / (3 w): where links turn by w in the step, there are more pieces."""
    wave = [0.5, *[0.0] * (TERMS - 1), 1.0, frequency, 0.0]
    contact, theta = first(core, wave, turning=frequency)
    assert contact == 0
    assert abs(theta - 2.0 * np.pi / 3.0 / frequency) <= 8.0 * EPS / frequency + 1e-15


def test_a_touch_in_each_turn(core: Functions) -> None:
    """1 - 1e-9 - cos dips in every turn for a hundred-thousandth of it: the first dip that is not at the start."""
    frequency, above = 300.0, 1.0 - 1e-9
    wave = [above, *[0.0] * (TERMS - 1), -1.0, frequency, 1.0]
    contact, theta = first(core, wave, turning=frequency)
    entry = (2.0 * np.pi - 1.0 - np.arccos(above)) / frequency
    assert contact == 0
    # rounding of values (2 EPS) and of the cosine's argument (EPS of 2 pi), over the slope sin(arccos(above)) w
    assert abs(theta - entry) <= (2.0 * EPS / np.sin(np.arccos(above)) + 8.0 * EPS) / frequency * 2.0 + 1e-15


# -- the location -------------------------------------------------------------------------------------------------


def land(
    core: Functions, method: str, g: float, height: float, speed: float, step: float, theta: float, t: float = 0.0
) -> tuple[float, float, float]:
    """Length of the step to the ground, and height and speed there."""
    length, y, parameters = np.zeros(1), np.zeros(2), np.array([2.0, g, 0.5])
    name = ctypes.c_char_p(method.encode())
    assert core.call("locate_ball", name, parameters, t, height, speed, step, theta, length, y) == 0
    return length[0].item(), y[0].item(), y[1].item()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("g", "height"), [(9.81, 1.0), (1.62, 30.0), (1.0, 1e-6), (9.81, 1e4)])
def test_a_ball_falls_for_the_root_of_2_h_over_g(g: float, height: float, method: str, core: Functions) -> None:
    """To the last digits, wherever the search took it to be.

    The weights of a step's stages, whose sizes add up to 13 (DOP853), multiply what their speeds are rounded by, at
    most 2 EPS g T: heights are known to 26 EPS g T^2 = 52 EPS h, which the ball falls through in 26 EPS T. The last
    correction of the time is below EPS of the step.
    """
    time = np.sqrt(2.0 * height / g)
    step = 1.7 * time
    for theta in (0.02, 0.3, 1.0 / 1.7, 0.99):
        length, y, speed = land(core, method, g, height, 0.0, step, theta)
        assert abs(length - time) <= 26.0 * EPS * time + 2.0 * EPS * step, theta
        assert abs(y) <= 52.0 * EPS * height + 2.0 * EPS * step * g * time
        assert abs(speed + g * time) <= 52.0 * EPS * g * time


@pytest.mark.parametrize("depth", [1e-2, 1e-5, 1e-8])
def test_a_ball_that_is_pulled_up_just_touches(depth: float, core: Functions) -> None:
    """Thrown down against a pull upwards (g = -2), it would turn at -depth: it enters at 2 h / (v + 2 sqrt(depth)).

    That is known to the rounding of the height, as above, over the speed there, 2 sqrt(depth).
    """
    height, g = 1.0, -2.0
    speed = 2.0 * np.sqrt(height + depth)  # v^2 / (2 * 2) = h + depth
    entry = 2.0 * height / (speed + 2.0 * np.sqrt(depth))
    length, y, _ = land(core, "dop853", g, height, -speed, 1.0, entry * (1.0 - 1e-4))
    assert abs(length - entry) <= 52.0 * EPS * height / (2.0 * np.sqrt(depth)) + 2.0 * EPS
    assert abs(y) <= 52.0 * EPS * height


def test_an_event_where_the_step_begins(core: Functions) -> None:
    """It has no length, and the state stays."""
    assert land(core, "dop853", 9.81, 0.0, -1.0, 0.1, 0.0) == (0.0, 0.0, -1.0)


@pytest.mark.parametrize("t", [1.0, 1e3, 1e6])
def test_late_times_are_known_to_their_own_rounding(t: float, core: Functions) -> None:
    """After a thousand or a million seconds the event is where the clock's last digit has it, and no closer.

    There the ball may be below the ground by more than rounding has it where time begins.
    """
    time = np.sqrt(2.0 / 9.81)
    length, _, _ = land(core, "dop853", 9.81, 1.0, 0.0, 1.0, 0.4, t)
    assert abs(length - time) <= 26.0 * EPS * time + 2.0 * EPS * (t + 1.0)


@pytest.mark.parametrize("t", [0.0, 1e3, 1e6])
@pytest.mark.parametrize("height", [1e-3, 1.0, 1795.7, 7318.2, 1e6])
def test_a_ball_strikes_the_ground_and_not_the_air(height: float, t: float, core: Functions) -> None:
    """In a whole run, however high it falls from and however late: bounds as above."""
    fall, times, parameters = np.sqrt(2.0 * height / 9.81), np.zeros(1), np.array([2.0, 9.81, 0.5])
    for method in METHODS:
        name = ctypes.c_char_p(method.encode())
        assert core.call("bounces", name, parameters, t, height, 0.0, 1e9, 1, times) == 1
        assert abs(times[0] - t - fall) <= 26.0 * EPS * fall + 3.0 * EPS * (t + fall), method


@pytest.mark.parametrize("method", METHODS)
def test_each_bounce_is_found_once(method: str, core: Functions) -> None:
    """A ball with restitution e falls for T, and flies for 2 e^k T after its k-th bounce.

    The zero at the start of a flight is not found again. Errors of the speeds, some EPS each bounce, add up in the
    times.
    """
    g, height, e = 9.81, 1.0, 0.5
    fall = np.sqrt(2.0 * height / g)
    expected = fall + 2.0 * fall * np.cumsum(np.concatenate([[0.0], e ** np.arange(1, 12)]))
    times = np.zeros(12)
    name = ctypes.c_char_p(method.encode())
    assert core.call("bounces", name, np.array([2.0, g, e]), 0.0, height, 0.0, 100.0, 12, times) == 12
    assert np.abs(times - expected).max() <= 12 * 16.0 * EPS * expected[-1]


def test_a_ball_that_flies_away_meets_nothing(core: Functions) -> None:
    """Thrown up where nothing falls, from the ground itself, too."""
    times, parameters = np.zeros(3), np.array([2.0, 0.0, 0.5])
    name = ctypes.c_char_p(b"dop853")
    for height in (0.0, 1.0):
        assert core.call("bounces", name, parameters, 0.0, height, 1.0, 5.0, 3, times) == 0
