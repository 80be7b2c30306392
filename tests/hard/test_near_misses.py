"""Four-bars whose links all but lie in a line: a + b is c + d but for a miss. They turn there, as sharply as its
root."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from ccgen.runtime import simulate

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
