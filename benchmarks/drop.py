"""Hexagon dropped on a smooth ground, first sixteen impacts: ccgen beside heyoka's events with Newton's law in NumPy.

Prints a markdown table; `python benchmarks/drop.py --help` lists the options, README.md explains the rest.
"""

import argparse
import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import heyoka_loop
import numpy as np
from driver import WORK
from machine import machine
from workload import INERTIA, LENGTH, MASS, Array, workload

from ccgen.generator import generate, loop
from ccgen.runtime import Model, Run, load_model, methods, simulate

LINKS, HEIGHT, RESTITUTION, IMPACTS, TOLERANCE = 6, 0.5, 0.7, 16, 1e-12
TIGHT = 1e-16
"""heyoka's tolerance for the impact times that all others are held against."""


@dataclass
class Drop:
    """One way to drop the hexagon: `fall` gives the impact times, `clock` the seconds of one fall."""

    name: str
    fall: Callable[[], Array]
    clock: Callable[[], float]
    seconds: float = math.inf


class Newton:
    """Newton's law for one joint that strikes the ground: joint impulses and the ground's in maximal coordinates."""

    def __init__(self) -> None:
        n = LINKS
        self.rows = np.zeros((2 * n + 1, 3 * n))  # closure of each joint, then the speed of the joint that strikes
        self.blocks = self.rows[: 2 * n].reshape(n, 2, n, 3)
        k = np.arange(n)
        self.k, self.before = k, np.roll(k, 1)
        for axis in range(2):
            self.blocks[k, axis, self.before, axis] = 1.0
            self.blocks[k, axis, k, axis] = -1.0
        self.inverse = np.tile([1.0 / MASS, 1.0 / MASS, 1.0 / INERTIA], n)

    def __call__(self, y: Array, joint: int) -> None:
        """Put the velocities after the impact into y = (q, u)."""
        n, angles, rates = LINKS, y[2 : LINKS + 2], y[LINKS + 4 :]
        turned = LENGTH / 2 * np.stack([-np.sin(angles), np.cos(angles)], axis=1)
        self.blocks[self.k, :, self.before, 2] = turned[self.before]
        self.blocks[self.k, :, self.k, 2] = turned
        self.rows[-1] = 0.0
        self.rows[-1, 3 * joint + 1], self.rows[-1, 3 * joint + 2] = 1.0, -turned[joint, 1]
        spins = turned * rates[:, None]
        speeds = np.empty((n, 3))
        speeds[:, :2] = y[n + 2 : n + 4] + 2.0 * np.cumsum(spins, axis=0) - spins
        speeds[:, 2] = rates
        right = -(self.rows @ speeds.ravel())
        right[-1] *= 1.0 + RESTITUTION
        weighted = self.rows * self.inverse
        after = (speeds.ravel() + np.linalg.solve(weighted @ self.rows.T, right) @ weighted).reshape(n, 3)
        y[n + 2 : n + 4] = after[0, :2] - turned[0] * after[0, 2]
        y[n + 4 :] = after[:, 2]


class Peer:
    """heyoka's Taylor integrator with an event on the height of every joint."""

    def __init__(self, y: Array, tolerance: float) -> None:
        hy, self.start, self.times, self.law = heyoka_loop.heyoka(), y, list[float](), Newton()
        angles, height = hy.make_vars(*(f"angle_{k}" for k in range(LINKS))), hy.make_vars("y")
        events = []
        for joint in range(LINKS):
            down = hy.event_direction.negative
            events.append(hy.t_event(height, callback=self._struck(joint), direction=down, cooldown=0.0))
            height = height + LENGTH * hy.sin(angles[joint])
        self.integrator = heyoka_loop.integrator(y, tolerance, events)

    def _struck(self, joint: int) -> Callable[[Any, int], bool]:
        def strike(integrator: Any, sign: int) -> bool:
            self.times.append(integrator.time)
            self.law(integrator.state, joint)
            return len(self.times) < IMPACTS

        return strike

    def clock(self) -> float:
        """Seconds to the last impact; compiling, and putting the start back, are not in the time."""
        self.times.clear()
        self.integrator.time = 0.0
        self.integrator.state[:] = self.start
        self.integrator.reset_cooldowns()
        began = time.perf_counter()
        self.integrator.propagate_until(10.0)
        return time.perf_counter() - began

    def fall(self) -> Array:
        """Impact times."""
        self.clock()
        return np.array(self.times)


def ours(model: Model, q: Array, u: Array, until: float) -> list[Drop]:
    """Whole calls of `simulate` from Python."""
    found = []
    for method in methods(estimating=True):  # the others take steps of one length, whatever the tolerance

        def whole(m: str = method) -> Run:
            return simulate(model, q, u, until=until, rtol=TOLERANCE, method=m)  # type: ignore[no-any-return]

        def fall(call: Callable[[], Run] = whole) -> Array:
            return np.array([impact.t for impact in call().impacts])

        def clock(call: Callable[[], Run] = whole) -> float:
            began = time.perf_counter()
            call()
            return time.perf_counter() - began

        found.append(Drop(f"ccgen, {method}", fall, clock))
    return found


def main() -> None:
    """Drop, and print a line for everything that fell."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=50, help="falls of which the fastest counts")
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    ground = [{"point": [0, 0], "normal": [0, 1], "restitution": RESTITUTION}]
    model = load_model(generate(loop(LINKS, gravity=True, ground=ground), out=WORK / "models"))
    q, u = (part[0] for part in workload(LINKS, 1).coordinates(root=model.links.index(model.root))[:2])
    q, u = model.project(q, u)
    heights = model.poses(q)[:, 1]
    q[1] += HEIGHT - heights.min()
    y = np.concatenate([q, u])
    exact = Peer(y, TIGHT).fall()
    peer = Peer(y, TOLERANCE)
    drops = [Drop("heyoka, events and NumPy", peer.fall, peer.clock), *ours(model, q, u, float(exact[-1]) + 1e-9)]
    misses = []
    for drop in drops:
        times = drop.fall()
        misses.append(np.abs(times - exact).max() if times.shape == exact.shape else math.inf)
    for _ in range(options.rounds):
        for drop in drops:
            drop.seconds = min(drop.seconds, drop.clock())
    print(f"{machine()}, heyoka {heyoka_loop.heyoka().__version__}")
    print(f"{len(exact)} impacts from t = {exact[0]:.15f} to {exact[-1]:.6f} s, tolerance {TOLERANCE:.0e}\n")
    print("| | µs | error of impact times, s | ratio |\n|---|---|---|---|")
    for drop, miss in zip(drops, misses, strict=True):
        print(f"| {drop.name} | {1e6 * drop.seconds:.0f} | {miss:.0e} | {drop.seconds / drops[0].seconds:.3f} |")


if __name__ == "__main__":
    main()
