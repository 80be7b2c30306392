"""What finding a periodic motion takes, in plain runs of its period.

Prints a markdown table: the gait of the simplest walker on stepping stones (the scene of its tests) by `find_orbit`
from rough guesses, beside one plain run of a step of the gait. Both are timed in turn; `python benchmarks/orbits.py
--help` lists the options, README.md explains the rest.
"""

import argparse
import statistics
import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from driver import ROOT, WORK
from machine import machine
from turns import in_turn

from ccgen.generator import generate, load_scene
from ccgen.runtime import Model, Orbit, find_orbit, load_model, simulate

sys.path.insert(0, str(ROOT))
from tests.support.simplest_walker import SEARCH, STONES

GUESSES = (("0.2, -0.2, as the scene begins", 0.2, -0.2), ("0.21, -0.22", 0.21, -0.22), ("0.19, -0.19", 0.19, -0.19))
"""Angle and rate of the stance leg (rad, rad/s) behind a strike; of the gait they are 0.2003 and -0.1998."""
PLAIN = 100
"""Plain runs between two searches."""
HEADER = ("guess", "runs derived", "search, ms", "plain step, ms", "search / plain step", "median of ratios", "missed")


@dataclass(frozen=True)
class Timed:
    """Seconds (rounds,) of the search and of a plain run beside it, and what was found."""

    search: np.ndarray
    plain: np.ndarray
    orbit: Orbit


def walker() -> Model:
    """The walker with its derivatives."""
    path = WORK / "walker-on-stones.toml"
    path.write_text(STONES)
    return load_model(generate(load_scene(path), out=WORK / "orbits", derivatives=True))


def standing(model: Model, angle: float, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """The state (q, u) behind a strike, both feet on the ground, of which the one that has struck stays."""
    q, u = model.start()
    q[2:], u[2:] = np.pi / 2 + np.array([angle, -angle]), (rate, np.cos(2 * angle) * rate)
    u[:2] = 0.0
    return model.project(q, u)


def compare(model: Model, angle: float, rate: float, rounds: int) -> Timed:
    """The search from a guess, and plain runs of the step that it finds, in turn, about as long: so that what else the
    machine does meets both alike."""
    q, u = standing(model, angle, rate)
    found = find_orbit(model, q, u, **SEARCH)

    def search() -> object:
        return find_orbit(model, q, u, **SEARCH)

    def plain() -> object:
        return simulate(model, found.q, found.u, until=found.period, method=SEARCH["method"], rtol=SEARCH["rtol"])

    def several() -> object:
        return [plain() for _ in range(PLAIN)]

    seconds = np.array(in_turn([search, several], rounds)) / (1, PLAIN)
    return Timed(seconds[:, 0], seconds[:, 1], found)


def row(name: str, timed: Timed) -> str:
    """A line of the table."""
    search, plain = float(timed.search.min()), float(timed.plain.min())
    median = statistics.median((timed.search / timed.plain).tolist())
    cells = [name, str(timed.orbit.runs), f"{1e3 * search:.1f}", f"{1e3 * plain:.2f}", f"{search / plain:.1f}"]
    return "| " + " | ".join([*cells, f"{median:.1f}", f"{timed.orbit.missed:.0e}"]) + " |"


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=30, help="the best of so many is told")
    given = parser.parse_args(arguments)
    WORK.mkdir(parents=True, exist_ok=True)
    print(f"{machine()}\n")
    print(f"| {' | '.join(HEADER)} |\n|" + "---|" * len(HEADER))
    model = walker()
    for name, angle, rate in GUESSES:
        print(row(name, compare(model, angle, rate, given.rounds)), flush=True)


if __name__ == "__main__":
    main()
