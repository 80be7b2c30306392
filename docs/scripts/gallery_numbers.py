"""What the run of each entry of the gallery says of its number: the side that ``ccgen`` computes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

THIRD = 2.0 * np.pi / 9.0
"""Time in which the Strandbeest's shaft makes a third of a turn (s)."""


def walking_speed(run: Any) -> float:
    """How fast the body goes in the last third of a turn of the shaft, which is two steps (m/s)."""
    end = float(run.t[-1])
    x = run.values("body.O.x", t=np.array([end - THIRD, end]))["body.O.x"]
    return float(x[1] - x[0]) / THIRD


def cranked(run: Any) -> float:
    """Angle of Andrews' crank at the end (rad)."""
    return float(run["K1.angle"][-1])


def between_pecks(run: Any) -> float:
    """Time between the last two pecks (s)."""
    pecks = [float(impact.t) for impact in run.impacts if any(table == "peck" for _, table in impact.contacts)]
    return pecks[-1] - pecks[-2]


def largest(run: Any, name: str) -> float:
    """The largest size of an output at 20,001 even times."""
    times = np.linspace(float(run.t[0]), float(run.t[-1]), 20001)
    return float(np.max(np.abs(run.values(name, t=times)[name])))


def lost(run: Any) -> float:
    """Energy that impacts have taken until 0.8 s (J)."""
    return float(sum(impact.energy_loss for impact in run.impacts if impact.t < 0.8))


def height_of_the_jack(run: Any) -> float:
    """Where his seat is at the end (m)."""
    return float(run["guide.slide"][-1])


def last_step(run: Any) -> float:
    """Time from the strike before the last one to the last one (s)."""
    strikes = [float(impact.t) for impact in run.impacts if impact.energy_loss > 1e-4]
    return strikes[-1] - strikes[-2]


def swing_of_the_clock(run: Any) -> float:
    """Mean time in which the pendulum swings to and fro, from where it hangs to where it hangs the same way (s)."""
    times = np.linspace(float(run.t[0]), float(run.t[-1]), 6001)
    angle = run.values("pendulum.angle", t=times)["pendulum.angle"]
    k = np.flatnonzero((angle[:-1] < 0.0) & (angle[1:] >= 0.0))
    crossings = times[k] - angle[k] * (times[k + 1] - times[k]) / (angle[k + 1] - angle[k])
    return float(np.diff(crossings).mean())


def thrown(run: Any) -> float:
    """How fast the stone is when it leaves its pouch (m/s)."""
    return float(run.values("stone.C.speed", t=run.changes[0].t)["stone.C.speed"])


def swing_of_the_last_ball(run: Any) -> float:
    """The largest angle to which the last ball swings out (deg)."""
    return float(np.degrees(largest(run, "ball_4.angle")))


def top_at_rest(run: Any) -> float:
    """How high the highest joint is at the end (m)."""
    return max(float(run[f"joint_{k}.y"][-1]) for k in range(6))


def way_out(run: Any) -> float:
    """Angle by which the crank turns while the ram goes out (deg), between changes of the sign of its speed."""
    times = np.linspace(float(run.t[0]), float(run.t[-1]), 20001)
    found = run.values("ram.E.vx", "crank.angle", t=times)
    v, angle = found["ram.E.vx"], np.degrees(found["crank.angle"])
    turns = np.flatnonzero(v[:-1] * v[1:] < 0.0)
    exact = angle[turns] + (angle[turns + 1] - angle[turns]) * v[turns] / (v[turns] - v[turns + 1])
    out = next(k for k, turn in enumerate(turns) if v[turn] < 0.0)
    return float(abs(exact[out + 1] - exact[out]))


def slack(run: Any) -> float:
    """How far the slider is at most from where bearings without clearance would have it (mm)."""
    times = np.linspace(float(run.t[0]), float(run.t[-1]), 20001)
    found = run.values("crank.angle", "slider.pin.x", t=times)
    angle = found["crank.angle"]
    tight = 0.05 * np.cos(angle) + np.sqrt(0.12**2 - (0.05 * np.sin(angle)) ** 2)
    return float(1000.0 * np.max(np.abs(found["slider.pin.x"] - tight)))


def arm_of_the_planets(run: Any) -> float:
    """How fast the arm turns at the end (rad/s)."""
    return float(run["arm.angular_velocity"][-1])


def screw(run: Any) -> float:
    """The force of the screw at the start, where the lift is lowest (N)."""
    return abs(float(run["screw.fx"][0]))


def stride(run: Any) -> float:
    """How far apart the places of a foot are, between which its crank makes a half turn (m)."""
    end = float(run.t[-1])
    place = run.point("leg_1_L.foot", np.array([0.0, end / 2.0])).position
    return float(np.hypot(*(place[1] - place[0])))


NUMBERS: dict[str, Callable[[Any], float]] = {
    "strandbeest-walking": walking_speed,
    "andrews": cranked,
    "woodpecker": between_pecks,
    "five-bar": lambda run: largest(run, "motor_L.moment"),
    "three-rrr-circle": lambda run: largest(run, "motor_a.moment"),
    "chain-over-edge": lost,
    "klann": stride,
    "jack-in-a-box": height_of_the_jack,
    "scissor-lift": screw,
    "simplest-walker": last_step,
    "escapement": swing_of_the_clock,
    "trebuchet": thrown,
    "newtons-cradle": swing_of_the_last_ball,
    "falling-hexagon": top_at_rest,
    "quick-return": way_out,
    "loose-slider-crank": slack,
    "planetary": arm_of_the_planets,
}
"""The number of each entry, of its run."""
