"""Answers to the gallery that owe nothing to ``ccgen``: closed forms, virtual work by hand, published figures.

Numbers of the scenes are written here again, in SI units.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable

import numpy as np

from .woodpecker import pecks

G = 9.81
JANSEN = {
    **{"a": 0.38, "b": 0.415, "c": 0.393, "d": 0.401, "e": 0.558, "f": 0.394, "g": 0.367},
    **{"h": 0.657, "i": 0.49, "j": 0.5, "k": 0.619, "l": 0.078, "m": 0.15},
}
SPEED_OF_THE_SHAFT = 3.0
CRANKS = 6


def meet(p: complex, r: float, q: complex, s: float, side: int) -> complex:
    """Where the circles of radius r about p and s about q meet, on the ``side`` of the way from p to q (1: left)."""
    way = q - p
    along = (r**2 - s**2 + abs(way) ** 2) / (2.0 * abs(way))
    return p + way / abs(way) * complex(along, side * math.sqrt(r**2 - along**2))


def jansen_foot(crank: float) -> complex:
    """The foot of Jansen's leg as the body sees it, circle by circle."""
    of = JANSEN
    pivot, pin = complex(-of["a"], -of["l"]), cmath.rect(of["m"], crank)
    upper, knee = meet(pivot, of["b"], pin, of["j"], 1), meet(pivot, of["c"], pin, of["k"], -1)
    heel = meet(meet(pivot, of["d"], upper, of["e"], 1), of["f"], knee, of["g"], -1)
    return meet(heel, of["h"], knee, of["i"], -1)


def walking_speed() -> float:
    """Of a level body whose lowest foot stands: all feet go the same way, a sixth of a turn apart."""
    count = 300
    way = np.array([jansen_foot(2.0 * math.pi * k / (CRANKS * count)) for k in range(CRANKS * count)])
    lowest = np.argmin(way.reshape(CRANKS, count).imag, axis=0) * count + np.arange(count)
    passed = np.roll(way.real, -1)[lowest] - way.real[lowest]
    return abs(CRANKS * float(passed.sum())) * SPEED_OF_THE_SHAFT / (2.0 * math.pi)


def time_between_pecks() -> float:
    """The mean of the last periods of the toy by time stepping, which has settled by then."""
    return float(np.diff(pecks(until=0.75, step=5e-5)[:, 0])[-3:].mean())


def slope(value: Callable[[float], np.ndarray], t: float, h: float = 1e-3) -> np.ndarray:
    """The first derivative, of order 6 in h."""
    steps = ((1, 0.75), (2, -0.15), (3, 1 / 60))
    return sum(c * (value(t + k * h) - value(t - k * h)) for k, c in steps) / h  # type: ignore[return-value]


def curve(value: Callable[[float], np.ndarray], t: float, h: float = 1e-3) -> np.ndarray:
    """The second derivative, of order 6 in h."""
    steps = ((1, 1.5), (2, -0.15), (3, 1 / 90))
    found = -49 / 18 * value(t) + sum(c * (value(t + k * h) + value(t - k * h)) for k, c in steps)
    return found / h**2  # type: ignore[no-any-return]


def peak(value: Callable[[float], float], end: float) -> float:
    """The largest value from 0 to ``end``: of 100 even times the best, and what is near it."""
    from scipy.optimize import minimize_scalar

    step = end / 100
    best = max((k * step for k in range(101)), key=value)
    return -float(minimize_scalar(lambda t: -value(t), bounds=(best - step, best + step), method="bounded").fun)


def parted(p: np.ndarray, base: complex, start: complex, arm: float, rod: float, side: int) -> tuple[complex, complex]:
    """Elbow and end of an arm on ``base`` and a rod to the place ``start`` of a platform at p = (x, y, angle)."""
    end = complex(p[0], p[1]) + start * cmath.exp(1j * p[2])
    return meet(base, arm, end, rod, side), end


class Arms:
    """A platform, or a pen, on arms of uniform bars, each turned by a motor: torques by virtual work.

    Masses are at places: a uniform bar of mass m is m/6 at its ends and 2m/3 in its middle, which have its mass, mass
    centre and inertia. The platform has its mass at three places round its middle that have its inertia.
    """

    def __init__(self, legs: list[tuple[complex, complex, float, float, int]], bars: tuple[float, float]) -> None:
        self.legs, self.bars = legs, bars
        self.more: list[tuple[float, complex]] = []

    def places(self, p: np.ndarray) -> np.ndarray:
        """All masses as (n, 2)."""
        found: list[complex] = []
        for base, *leg in self.legs:
            elbow, end = parted(p, base, *leg)
            found += [base, (base + elbow) / 2, elbow, elbow, (elbow + end) / 2, end]
        middle, spoke = complex(p[0], p[1]), cmath.exp(1j * p[2]) if len(p) > 2 else 1.0
        found += [middle + start * spoke for _, start in self.more]
        return np.array([[z.real, z.imag] for z in found])

    def masses(self) -> np.ndarray:
        arm, rod = self.bars
        leg = [arm / 6, 2 * arm / 3, arm / 6, rod / 6, 2 * rod / 3, rod / 6]
        return np.array([*leg * len(self.legs), *(mass for mass, _ in self.more)])

    def angles(self, p: np.ndarray) -> np.ndarray:
        """Of the arms."""
        return np.array([cmath.phase((parted(p, base, *leg)[0] - base) * 1j) for base, *leg in self.legs])

    def torques(self, path: Callable[[float], np.ndarray], t: float) -> np.ndarray:
        """Of the motors (N m) along a path of (x, y, angle): together with inertia forces they do no virtual work."""
        p, free = path(t), len(self.legs)
        push = self.masses()[:, None] * curve(lambda s: self.places(path(s)), t)
        shift, turn = np.zeros((free, *push.shape)), np.zeros((free, free))
        for k in range(free):
            way = np.eye(3)[k]
            shift[k] = slope(lambda s, way=way: self.places(p + s * way), 0.0)
            turn[k] = slope(lambda s, way=way: self.angles(p + s * way), 0.0)
        return np.linalg.solve(turn, np.einsum("kij,ij->k", shift, push))


def five_bar_torque() -> float:
    """The largest torque of the left motor along its eight."""
    legs = [(complex(-0.15, 0), 0j, 0.25, 0.35, 1), (complex(0.15, 0), 0j, 0.25, 0.35, -1)]
    arms = Arms(legs, (0.5, 0.4))
    arms.more = [(0.3, 0j)]

    def path(t: float) -> np.ndarray:
        return np.array([0.12 * math.sin(3 * t), 0.42 + 0.06 * math.sin(6 * t), 0.0])

    return peak(lambda t: abs(float(arms.torques(path, t)[0])), 2 * math.pi / 3)


def three_rrr_torque() -> float:
    """The largest torque of the first motor while the platform goes round; its mass is 1 kg, its inertia 0.01 kg m²."""
    turns = [cmath.exp(2j * math.pi * k / 3) for k in range(3)]
    legs = [(-0.5j * turn, -0.12j * turn, 0.25, 0.3, -1) for turn in turns]
    arms = Arms(legs, (0.4, 0.3))
    arms.more = [(1 / 3, 0.1 * turn) for turn in turns]

    def path(t: float) -> np.ndarray:
        return np.array([0.06 * math.cos(4 * t), 0.06 * math.sin(4 * t), 0.0])

    return peak(lambda t: abs(float(arms.torques(path, t)[0])), math.pi / 2)


def jack_at_rest() -> float:
    """Where the spring of 60 N/m and 0.36 m carries 0.3 kg and four rods of 0.02 kg."""
    return 0.36 - (0.3 + 4 * 0.02) * G / 60.0


def screw_at_the_start() -> float:
    """Lagrange's equation of the foot's place x, at rest at x = 0.9 m, of energies that are written by hand (N)."""

    def energies(x: float) -> tuple[float, float]:
        """Kinetic energy at unit speed of the foot, and potential energy; a stage is h high, and bars turn by -1/h."""
        h = math.sqrt(1.0 - x**2)
        rise = -x / h
        kinetic = 0.5 * 2.0 + 0.5 * 50.0 * (4.0 * rise) ** 2
        for k in range(4):
            kinetic += 2 * 0.5 * 5.0 * (0.25 + ((k + 0.5) * rise) ** 2 + 1.0 / (12.0 * h**2))
        return kinetic, G * (50.0 * 4.0 * h + sum(2 * 5.0 * (k + 0.5) * h for k in range(4)))

    x, acceleration = 0.9, -0.3 * math.pi**2
    fall = float(slope(lambda s: np.array(energies(x + s)[1]), 0.0))
    return abs(2.0 * energies(x)[0] * acceleration + fall)


def swing_of_the_clock() -> float:
    """Of the free pendulum at small angles: a rod of 50 g, and a disc of 500 g and 4 cm, 24.9 cm below (s)."""
    length = 0.249
    inertia = 0.05 * length**2 / 3 + 0.5 * (length**2 + 0.04**2 / 2)
    return 2 * math.pi * math.sqrt(inertia / (G * length * (0.05 / 2 + 0.5)))


def thrown() -> float:
    """The stone's speed where its sling is turned by -137° against the beam (m/s): a triple pendulum by Lagrange.

    The stone bounces off the ground with restitution and friction of 0.3; its disc of 8 cm may spin about its pin.
    """
    from scipy.integrate import solve_ivp

    beam, weight, sling, stone = 20.0, 500.0, 0.5, 5.0
    hang, rope, long, radius, axle = 0.5, 2.5, -3.0, 0.08, 3.0
    tip = sling / 2 + stone

    def masses(a: float, b: float, c: float) -> np.ndarray:
        m = np.diag(
            [
                beam * 16 / 12 + beam + weight + (sling + stone) * long**2,
                20.0 + weight * hang**2,
                sling * rope**2 / 3 + stone * rope**2,
                stone * radius**2 / 2,
            ]
        )
        m[0, 1] = m[1, 0] = weight * hang * math.cos(a - b)
        m[0, 2] = m[2, 0] = tip * long * rope * math.cos(a - c)
        return m

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        a, b, c, da, db, dc = y[:6]
        ab, ac = weight * hang * math.sin(a - b), tip * long * rope * math.sin(a - c)
        level = -beam + weight + (sling + stone) * long
        force = [
            -ab * db**2 - ac * dc**2 - G * level * math.cos(a),
            ab * da**2 - G * weight * hang * math.cos(b),
            ac * da**2 - G * tip * rope * math.cos(c),
        ]
        return np.array([da, db, dc, *np.linalg.solve(masses(a, b, c)[:3, :3], force), 0.0])

    def leaves(_: float, y: np.ndarray) -> float:
        return float(y[2] - y[0] + math.radians(137.0))

    def lands(_: float, y: np.ndarray) -> float:
        return float(axle + long * math.sin(y[0]) + rope * math.sin(y[2]) - radius)

    leaves.terminal = lands.terminal = True  # type: ignore[attr-defined]
    lands.direction = -1  # type: ignore[attr-defined]
    y = np.array([math.radians(50), -math.pi / 2, math.radians(-14), 0, 0, 0, 0])
    while True:
        found = solve_ivp(rates, (0, 3), y, method="DOP853", rtol=1e-11, atol=1e-12, events=(leaves, lands))
        y = found.y[:, -1]
        if len(found.t_events[0]):
            spokes = np.exp(1j * y[[0, 2]])
            return float(abs(long * y[3] * spokes[0] + rope * y[5] * spokes[1]))
        inverse = np.linalg.inv(masses(*y[:3]))
        up = np.array([long * math.cos(y[0]), 0, rope * math.cos(y[2]), 0])
        along = np.array([-long * math.sin(y[0]), 0, -rope * math.sin(y[2]), radius])
        rows = np.array([up, along])
        push = np.linalg.solve(rows @ inverse @ rows.T, -rows @ y[3:] - [0.3 * up @ y[3:], 0.0])
        if abs(push[1]) > 0.3 * push[0]:
            way = up + 0.3 * np.sign(push[1]) * along
            normal = -1.3 * (up @ y[3:]) / (up @ inverse @ way)
            push = normal * np.array([1.0, 0.3 * np.sign(push[1])])
        y[3:] += inverse @ rows.T @ push


def klann_stride() -> float:
    """The way of the foot over half a turn of the crank, circle by circle from table 1 of the patent."""
    upper, lower, axle = 1.366 + 1.366j, 1.009 + 0.574j, 1.599 + 0.75j
    elbow, pin, knee, hip = 0.741 + 0.75j, 1.331 + 0.75j, 0.232 + 0.866j, 0.866 + 1.5j

    def foot(turned: float) -> complex:
        now = axle + (pin - axle) * cmath.exp(1j * turned)
        bent = meet(lower, abs(elbow - lower), now, abs(elbow - pin), 1)
        knees = now + (bent - now) * (knee - pin) / (elbow - pin)
        hips = meet(upper, abs(hip - upper), knees, abs(hip - knee), -1)
        return knees - (hips - knees) * knee / (hip - knee)

    return 0.3 * abs(foot(math.pi) - foot(0.0))


def rods_lose(places: np.ndarray, velocities: np.ndarray, mass: float) -> float:
    """Energy (J) that uniform rods of that mass (kg) have lost from the first instant to the last.

    Places (m) and velocities (m/s) are of their ends, (rods, instants, 2 ends, 2)."""
    a, b = velocities[:, :, 0], velocities[:, :, 1]
    kinetic = mass / 6 * np.sum(a * a + a * b + b * b, axis=(0, 2))
    potential = mass * G * np.sum(places.mean(axis=2)[..., 1], axis=0)
    return float((kinetic + potential)[0] - (kinetic + potential)[-1])


ANSWERS: dict[str, Callable[[], float]] = {
    "strandbeest-walking": walking_speed,
    "andrews": lambda: 15.81077119629904,
    "woodpecker": time_between_pecks,
    "five-bar": five_bar_torque,
    "three-rrr-circle": three_rrr_torque,
    "klann": klann_stride,
    "jack-in-a-box": jack_at_rest,
    "scissor-lift": screw_at_the_start,
    "simplest-walker": lambda: 3.88246375285,
    "escapement": swing_of_the_clock,
    "trebuchet": thrown,
    "newtons-cradle": lambda: 40.0,
    "falling-hexagon": lambda: math.sqrt(3.0) / 2.0,
    "quick-return": lambda: 180.0 + 2.0 * math.degrees(math.asin(0.1 / 0.2)),
    "loose-slider-crank": lambda: 3 * 0.2 / math.cos(math.asin(0.05 / 0.12)),
    "planetary": lambda: 0.5 * (1.0 + 60 / 24) / 0.08,
}
"""Answers by the names of entries, in the units of docs/gallery/entries.toml; that of the chain is ``rods_lose``."""
