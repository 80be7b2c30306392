"""Four-bars whose links all but lie in a line: a + b is c + d but for a miss. They turn there, as sharply as its
root."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from ccgen.runtime import Run, simulate

from ..oracles.swings import FourBar
from ..support.reach import Reach
from ..support.tiers import hard
from ..support.workshop import Workshop

SPAN, INPUT, COUPLER, OUTPUT = 0.5, 0.3, 0.4, 0.6
MASSES = (1.0, 2.0, 1.5)
METHODS = ("gauss", "dop853", "dopri5", "radau")


def _scene(miss: float) -> str:
    """The input in the line at angle 0, the output at 180 degrees, where the coupler, too, lies along them."""
    lengths = {"crank": INPUT, "rod": COUPLER, "rocker": OUTPUT - miss}
    links = "".join(
        f'[[link]]\nname = "{name}"\nmass = {mass}\ninertia = {mass * length**2 / 12!r}\ncom = [{length / 2!r}, 0]\n'
        f"points = {{ A = [0, 0], B = [{length!r}, 0] }}\n"
        for (name, length), mass in zip(lengths.items(), MASSES, strict=True)
    )
    pins = (("ground.O", "crank.A"), ("crank.B", "rod.A"), ("rod.B", "rocker.B"), ("rocker.A", "ground.C"))
    joints = "".join(f'[[joint]]\nbetween = ["{a}", "{b}"]\n' for a, b in pins)
    return (
        f'name = "near"\n[ground_link]\npoints = {{ O = [0, 0], C = [{SPAN}, 0] }}\n{links}{joints}[gravity]\n'
        "[start]\nangles = { crank = -1.0, rod = 2.3, rocker = 3.0 }\nangular_velocities = { crank = 12.0 }\n"
    )


def _reference(miss: float, q: np.ndarray, end: np.ndarray, u: np.ndarray) -> float:
    """Seconds by quadrature: over the input's angle where it goes round, else over the output's, which then does."""
    bar = FourBar(
        *(mpmath.mpf(length) for length in (INPUT, COUPLER, OUTPUT - miss, SPAN)),
        tuple(mpmath.mpf(mass) for mass in MASSES),
        0,
    )
    pin, joint = INPUT * np.exp(1j * q[0]), INPUT * np.exp(1j * q[0]) + COUPLER * np.exp(1j * q[1])
    width = mpmath.sqrt(abs(miss)) / 16
    if miss > 0.0:
        side = int(np.sign(((joint - pin) * np.conj(SPAN - pin)).imag))
        bar = FourBar(bar.input, bar.coupler, bar.output, bar.span, bar.masses, side)
        return float(bar.duration(mpmath.mpf(q[0]), mpmath.mpf(end[0]), mpmath.mpf(u[0]), mpmath.mpf(0), width))
    side = int(
        np.sign(((pin - joint) * np.conj(-joint)).imag)
    )  # seen from behind, sides change, and so does what is joined
    other = bar.mirrored()
    other = FourBar(other.input, other.coupler, other.output, other.span, other.masses, -side)
    begin, last = (mpmath.pi - mpmath.mpf(angle) for angle in (q[2], end[2]))
    return float(other.duration(begin, last, -mpmath.mpf(u[2]), mpmath.mpf(0), width))


@pytest.mark.parametrize("method", [METHODS[0], METHODS[1], *map(hard, METHODS[2:])])
@pytest.mark.parametrize("miss", [1e-3, 1e-8, 1e-14, *map(hard, (1e-2, 1e-4, 1e-5, 1e-6, 1e-7, 1e-9, 1e-10, 1e-12))])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_swing_past_the_line(sign: float, miss: float, method: str, workshop: Workshop, reach: Reach) -> None:
    """The time of the swing is that of a quadrature in forty digits."""
    model = workshop.model(_scene(sign * miss))
    q, u = model.start()
    run = simulate(model, q, u, until=0.2, method=method)
    assert run.success, run.message
    with mpmath.workdps(40):
        seconds = _reference(sign * miss, run.q[0], run.q[-1], run.u[0])
    reach(f"swing past a line, missed by {sign * miss:g}, {method}: time, s", abs(seconds - run.t[-1]), 1e-7)
    moves = float(np.ptp(model.energy(run.q, run.u)[0]))
    reach(
        f"swing past a line, missed by {sign * miss:g}, {method}: energy, of that in motion",
        run.energy_drift / moves,
        1e-7,
    )


SECOND, THIRD = (0.45, 0.65, 1.0, 0.7), (0.5, 0.7, 0.8, 0.6)
"""Couplers and outputs of more loops on the same input and span (m), and their masses (kg)."""


def _more_loops(miss: float, *exact: tuple[float, ...]) -> str:
    """The loop above, which lies in a line exactly, a second one that misses it, and more of those that do not."""
    links = joints = angles = ""
    for k, (coupler, output, second, third) in enumerate(((*SECOND[:1], SECOND[1] - miss, *SECOND[2:]), *exact), 2):
        for name, length, mass in ((f"rod{k}", coupler, second), (f"rocker{k}", output, third)):
            links += (
                f'[[link]]\nname = "{name}"\nmass = {mass}\ninertia = {mass * length**2 / 12!r}\n'
                f"com = [{length / 2!r}, 0]\npoints = {{ A = [0, 0], B = [{length!r}, 0] }}\n"
            )
        pins = (("crank.B", f"rod{k}.A"), (f"rod{k}.B", f"rocker{k}.B"), (f"rocker{k}.A", "ground.C"))
        joints += "".join(f'[[joint]]\nbetween = ["{a}", "{b}"]\n' for a, b in pins)
        angles += f", rod{k} = 2.3, rocker{k} = 3.0"
    return _scene(0.0).replace("rocker = 3.0 }", f"rocker = 3.0{angles} }}") + links + joints


def _seconds_of_more(miss: float, run: Run, *exact: tuple[float, ...]) -> float:
    """By quadrature: those that lie in a line exactly change their sides there, the one that misses it does not."""
    names = list(run.model.links)
    angles = {name: run.q[0, run.model.q_names.index(f"theta_{names.index(name)}")] for name in names}
    pin = INPUT * np.exp(1j * angles["crank"])
    loops = []
    for k, (coupler, output, *masses) in enumerate(((COUPLER, OUTPUT, *MASSES[1:]), SECOND, *exact), 1):
        rod = coupler * np.exp(1j * angles["rod" if k == 1 else f"rod{k}"])
        side = int(np.sign((rod * np.conj(SPAN - pin)).imag))
        lengths = (mpmath.mpf(one) for one in (INPUT, coupler, output - (miss if k == 2 else 0.0), SPAN))
        of = tuple(mpmath.mpf(one) for one in (MASSES[0] if k == 1 else 0.0, *masses))
        sides = (side, side if k == 2 else -side)
        loops.append([FourBar(*lengths, of, one) for lengths in (tuple(lengths),) for one in sides])

    def sums(angle: mpmath.mpf) -> tuple[mpmath.mpf, mpmath.mpf]:
        every = [loop[int(angle > 0)].inertia_and_potential(angle) for loop in loops]
        return sum(one[0] for one in every), sum(one[1] for one in every)

    column = run.model.q_names.index(f"theta_{names.index('crank')}")
    begin, end, rate = (mpmath.mpf(one) for one in (run.q[0, column], run.q[-1, column], run.u[0, column]))
    energy = sums(begin)[0] * rate**2 / 2 + sums(begin)[1]
    points, step = {begin, mpmath.mpf(0), end}, mpmath.sqrt(miss) / 16
    while step < end - begin:
        points |= {point for point in (-step, step) if begin < point < end}
        step *= 4

    def pace(angle: mpmath.mpf) -> mpmath.mpf:
        inertia, potential = sums(angle)
        return mpmath.sqrt(inertia / (2 * (energy - potential)))

    return float(mpmath.quad(pace, sorted(points)))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("miss", [0.1, 0.02, 0.005])
@pytest.mark.parametrize("exact", [(), hard((THIRD,))], ids=["one", "two"])
def test_loops_cross_beside_another(
    exact: tuple[tuple[float, ...], ...], miss: float, method: str, workshop: Workshop, reach: Reach
) -> None:
    """One, or two, lie in a line exactly, and go through on their branches, where another turns sharply: time by
    quadrature."""
    run = simulate(workshop.model(_more_loops(miss, *exact)), until=0.2, method=method)
    assert run.success, run.message
    with mpmath.workdps(40):
        seconds = _seconds_of_more(miss, run, *exact)
    moves = float(np.ptp(run.model.energy(run.q, run.u)[0]))
    name = f"{1 + len(exact)} in a line, another misses it by {miss:g}, {method}"
    reach(f"{name}: time, s", abs(seconds - run.t[-1]), 1e-7)
    reach(f"{name}: energy, of that in motion", run.energy_drift / moves, 1e-7)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("miss", [1e-3, -1e-3, 1e-6, 1e-10])
def test_what_is_not_told_beside_another_loop_is_said(miss: float, method: str, workshop: Workshop) -> None:
    """It turned onto the other branch, and lost a millionth of its energy, without a word."""
    run = simulate(workshop.model(_more_loops(miss)), until=0.2, method=method)
    assert not run.success and "another misses it by very little" in run.message
    crank = run.model.q_names.index(f"theta_{list(run.model.links).index('crank')}")
    assert -0.5 < run.q[-1, crank] < 0.0 and run.energy_drift <= 1e-7


@pytest.mark.parametrize("miss", [0.1, 0.02])
def test_one_loop_crosses_beside_another_in_floats(miss: float, workshop: Workshop) -> None:
    """It ends where the same run in doubles does."""
    ends = []
    for precision in ("double", "float"):
        run = simulate(workshop.model(_more_loops(miss), precision), until=0.2)
        assert run.success, run.message
        ends.append(run.q[-1, run.model.q_names.index(f"theta_{list(run.model.links).index('crank')}")])
    assert abs(ends[1] - ends[0]) <= 1e-4  # a hundred times the rtol of floats, 1e-6
