"""Many flights of W(6) and many drops of the hexagon: `simulate` over threads beside one run after the other.

Prints a markdown table; `python benchmarks/threads.py --help` lists the options, README.md explains the rest.
"""

import argparse
import os

import numpy as np
from driver import WORK
from machine import machine
from turns import fastest
from workload import Array, workload

from ccgen.generator import generate, loop
from ccgen.runtime import Model, load_model, simulate


def starts(model: Model, height: float | None) -> tuple[Array, Array]:
    """The states of W(6); where a height is given, with the lowest joint there."""
    q, u = model.project(*workload(6).coordinates(root=model.links.index(model.root))[:2])
    if height is not None:
        q[:, 1] += height - model.poses(q)[:, :, 1].min(axis=1)
    return q, u


def main() -> None:
    """Fly and drop 32 starts, and print a line for each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=20, help="repeats of which the fastest counts")
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    ground = [{"point": [0, 0], "normal": [0, 1], "restitution": 0.7}]
    print(f"{machine()}\n\n| 32 starts | one by one, ms | together, ms | speed-up on {os.cpu_count()} cores |")
    print("|---|---|---|---|", flush=True)
    for name, until, tables in (
        ("flight, 10 s", 10.0, {}),
        ("flight, 200 s", 200.0, {}),
        ("drop, 1.8 s", 1.8, {"ground": ground}),
    ):
        model = load_model(generate(loop(6, gravity=True, **tables), out=WORK / "models"))
        q, u = starts(model, 0.5 if tables else None)

        def together(q: Array = q, u: Array = u, end: float = until, m: Model = model) -> object:
            return simulate(m, q, u, until=end, rtol=1e-10)

        def alone(q: Array = q, u: Array = u, end: float = until, m: Model = model) -> object:
            return [simulate(m, a, b, until=end, rtol=1e-10) for a, b in zip(q, u, strict=True)]

        for one, other in zip(alone(), together(), strict=True):
            assert np.array_equal(one.q, other.q)
        single, threads = fastest([alone, together], options.rounds)
        print(f"| {name} | {1e3 * single:.2f} | {1e3 * threads:.2f} | {single / threads:.2f} |", flush=True)


if __name__ == "__main__":
    main()
