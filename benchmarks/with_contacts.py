"""Scenes with contacts by `gauss` and by `dop853`: seconds of whole runs, and errors of the times of early impacts.

Prints a markdown table; `python benchmarks/with_contacts.py --help` lists the options, README.md explains the rest.
"""

import argparse
import itertools
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from driver import WORK
from machine import machine

from ccgen.generator import generate, load_scene, loop
from ccgen.runtime import Run, load_model, simulate

METHODS = ("gauss", "dop853")
EARLY = 8
"""Impacts whose times are compared, at most: errors of later ones are those of the first, magnified by the motion."""
TIGHT = 1e-14
"""The tolerance of the runs, one by each method, that the others are held against; their difference is told too."""
SCENES = ("falling-hexagon", "tilted-hexagon", "falling-ring", "flyer", "newtons-cradle")
SIZES = (3, 4, 6, 9, 12)


@dataclass
class Case:
    """A motion with contacts: ``run`` takes a method and a tolerance."""

    name: str
    run: Callable[[str, float], Run]


def cases(sizes: Sequence[int]) -> list[Case]:
    """The scenes of the repository that have contacts, and unequal loops thrown onto smooth and rough planes."""
    made = [scene_case(name) for name in SCENES]
    return made + [tossed(n, rough, seed) for n, rough, seed in itertools.product(sizes, (False, True), (0, 1))]


def scene_case(name: str) -> Case:
    scene = load_scene(f"scenes/{name}.toml")
    model = load_model(generate(scene, WORK))
    return Case(name, lambda method, rtol: simulate(model, rtol=rtol, method=method))


def tossed(n: int, rough: bool, seed: int) -> Case:
    """Lengths and masses within a third of each other, thrown with random velocities; two seconds."""
    ground: dict[str, Any] = {"restitution": 0.5} | ({"friction": 0.4} if rough else {})
    name = f"rough{n}" if rough else f"smooth{n}"
    model = load_model(generate(loop(n, gravity=True, start={"height": 1.0}, ground=[ground]), WORK / name))
    rng = np.random.default_rng(seed)
    sizes = {f"link_{k}.{what}": float(rng.uniform(0.8, 1.2)) for k in range(n) for what in ("length", "mass")}
    model = model.with_parameters(sizes)
    q, u = model.start()
    q, u = model.project(q, u + 2.0 * rng.normal(size=u.size))
    q[1] += 0.2 - float(model.gaps(q).min())
    return Case(
        f"{name}, throw {seed}", lambda method, rtol: simulate(model, q, u, until=2.0, rtol=rtol, method=method)
    )


def early(run: Run) -> Any:
    """Times of the first impacts (s)."""
    return np.array([impact.t for impact in run.impacts[:EARLY]])


def apart(one: Any, other: Any) -> float:
    """By how much two lists of times differ (s); infinite where they are not of the same impacts."""
    return float(np.max(np.abs(one - other), initial=0.0)) if one.shape == other.shape else math.inf


def clock(case: Case, method: str, rtol: float) -> float:
    """Seconds of a run."""
    began = time.perf_counter()
    case.run(method, rtol)
    return time.perf_counter() - began


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rtol", type=float, nargs="+", default=[1e-6, 1e-9, 1e-12])
    parser.add_argument("--links", type=int, nargs="+", default=SIZES, metavar="N", help="sizes of the loops")
    parser.add_argument("--rounds", type=int, default=3, help="runs of each, of which the fastest counts")
    given = parser.parse_args()
    print(machine())
    made = cases(given.links)
    for rtol in given.rtol:
        print(
            f"\nrtol {rtol:g}: time of gauss / dop853; errors of early impacts, s: gauss, dop853, the reference's own\n"
        )
        print("| motion | impacts | time | gauss | dop853 | own |\n|---|---|---|---|---|---|")
        ratios, better = [], 0
        for case in made:
            exact = {method: early(case.run(method, TIGHT)) for method in METHODS}
            seconds = dict.fromkeys(METHODS, math.inf)
            for _ in range(given.rounds):  # in turn, so that what else the machine does meets both
                for method in METHODS:
                    seconds[method] = min(seconds[method], clock(case, method, rtol))
            runs = {method: case.run(method, rtol) for method in METHODS}
            errors = {
                method: apart(early(runs[method]), exact[METHODS[1 - METHODS.index(method)]]) for method in METHODS
            }
            own = apart(exact["gauss"], exact["dop853"])
            ratios.append(seconds["gauss"] / seconds["dop853"])
            better += errors["gauss"] <= errors["dop853"]
            count = len(runs["gauss"].impacts)
            told = " | ".join(f"{error:.0e}" for error in (*errors.values(), own))
            print(f"| {case.name} | {count} | {ratios[-1]:.2f} | {told} |", flush=True)
        mean = math.exp(np.mean(np.log(ratios)))
        spread = f"from {min(ratios):.2f} to {max(ratios):.2f}"
        print(f"\ngeometric mean of times {mean:.2f}, {spread}; as exact or better in {better} of {len(made)}")


if __name__ == "__main__":
    main()
