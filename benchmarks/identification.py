"""What it takes to find six parameters of a falling hexagon again from noisy measurements, in plain runs.

Prints a markdown table: `identify` of three masses, a damper, friction and restitution from 200 noisy angles and places
of a rough drop, beside one plain run to the last of them. Both are timed in turn; `python benchmarks/identification.py
--help` lists the options, README.md explains the rest.
"""

import argparse
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from driver import WORK
from machine import machine
from turns import in_turn

from ccgen.generator import generate, load_scene
from ccgen.runtime import Identified, Model, identify, load_model, simulate

SCENE = """
name = "rough-hexagon"
[loop]
links = 6
length = 1.0
mass = 1.0
[start]
height = 0.5
tilt = "8 deg"
[gravity]
[[ground]]
restitution = 0.6
friction = 0.15
[[joint_friction]]
name = "rub"
joints = ["joint_1", "joint_3"]
viscous = 0.2
"""
TRUTH = {
    "link_1.mass": 1.1,
    "link_2.mass": 0.9,
    "link_4.mass": 1.2,
    "rub.viscous": 0.25,
    "ground_0.friction": 0.2,
    "ground_0.restitution": 0.55,
}
"""With these (kg, N m s, -, -) the measurements are made; the search begins with those of the scene."""
AT = np.linspace(0.01, 0.8, 25)
"""Instants of the measurements (s), at each all eight coordinates."""
NOISE = 1e-3
"""Standard deviation of the measurements (m, rad)."""
PLAIN = 20
"""Plain runs between two searches."""
HEADER = ("impacts", "measured", "runs derived", "search, ms", "plain run, ms", "search / run", "median", "farthest")


@dataclass(frozen=True)
class Case:
    """A drop and what was measured of it (25, 8)."""

    model: Model
    q: np.ndarray
    u: np.ndarray
    measured: np.ndarray
    impacts: int

    def search(self) -> Identified:
        """The parameters from the measurements."""
        return identify(self.model, {"q": self.measured}, AT, list(TRUTH), self.q, self.u, sigma=NOISE)

    def plain(self) -> object:
        """Runs with the true parameters."""
        return [simulate(self.model, self.q, self.u, until=AT[-1], params=TRUTH) for _ in range(PLAIN)]


def drop() -> Case:
    """The hexagon, thrown a little, so that its joints do not strike together."""
    path = WORK / "rough-hexagon.toml"
    path.write_text(SCENE)
    model = load_model(generate(load_scene(path), out=WORK / "identification", derivatives=True))
    rng = np.random.default_rng(1)
    q, u = model.start()
    q, u = model.project(q, u + 0.3 * rng.normal(size=u.size))
    run = simulate(model, q, u, until=AT[-1], params=TRUTH)
    return Case(model, q, u, run.at(AT)[0] + NOISE * rng.normal(size=(AT.size, q.size)), len(run.impacts))


def row(case: Case, rounds: int) -> str:
    """A line of the table."""
    found = case.search()
    seconds = np.array(in_turn([case.search, case.plain], rounds)) / (1, PLAIN)
    search, plain = seconds.min(axis=0)
    far = max(abs(found.values[path] - value) / found.deviations[path] for path, value in TRUTH.items())
    cells = [str(case.impacts), str(case.measured.size), str(found.evaluations), f"{1e3 * search:.0f}"]
    cells += [f"{1e3 * plain:.2f}", f"{search / plain:.0f}", f"{statistics.median(seconds[:, 0] / seconds[:, 1]):.0f}"]
    return "| " + " | ".join([*cells, f"{far:.1f}"]) + " |"


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=10, help="the best of so many is told")
    given = parser.parse_args(arguments)
    WORK.mkdir(parents=True, exist_ok=True)
    print(f"{machine()}\n")
    print(f"| {' | '.join(HEADER)} |\n|" + "---|" * len(HEADER))
    print(row(drop(), given.rounds), flush=True)


if __name__ == "__main__":
    main()
