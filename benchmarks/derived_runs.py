"""What derivatives of runs take, in plain runs: a falling hexagon along few directions and many, and a flight.

Prints a markdown table: the run alone, with its derivatives, and by one-sided differences of as many runs as
directions.
"""

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from driver import WORK
from machine import machine

from ccgen.generator import Scene, generate, load_scene, loop
from ccgen.runtime import Model, load_model, sensitivities, simulate

SCENES = Path(__file__).resolve().parents[1] / "scenes"

PLACES = ("q0", "u0")


def best(call: Callable[[], object], rounds: int) -> float:
    """The shortest time (s) of a call."""
    found = np.inf
    for _ in range(rounds):
        began = time.perf_counter()
        call()
        found = min(found, time.perf_counter() - began)
    return found


def directions(model: Model, count: int) -> dict[str, np.ndarray]:
    """Random directions of the start."""
    rng = np.random.default_rng(1)
    return {name: rng.normal(size=(len(model.q_names), count)) for name in PLACES}


def cases() -> list[tuple[str, Scene | str, float, float]]:
    """What is told, the scene, how long it runs (s), and by how much its start is turned, so that corners do not land
    together."""
    return [
        ("falling hexagon, to 0.62 s", str(SCENES / "falling-hexagon.toml"), 0.62, 0.1),
        ("ring of 12 rods in free flight", loop(12, gravity=True), 2.0, 0.3),
    ]


def derive(model: Model, q: np.ndarray, u: np.ndarray, until: float, wrt: dict[str, np.ndarray]) -> object:
    return sensitivities(model, wrt, q0=q, u0=u, until=until)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5, help="the best of so many is told")
    parser.add_argument("--directions", type=int, nargs="+", default=[1, 8], help="how many directions")
    given = parser.parse_args()
    print(f"{machine()}\n")
    print(
        "| run | impacts | directions | run, ms | with derivatives, ms | in runs | per direction | differences, in "
        "runs |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for name, source, until, turn in cases():
        scene = load_scene(source) if isinstance(source, str) else source
        model = load_model(generate(scene, out=WORK / "derived", derivatives=True))
        q, u = model.start()
        q[2:] += turn
        u = u + model.motions(q) @ np.random.default_rng(2).normal(size=model.dof)
        if model.contacts:
            q[1] += 0.2 - float(model.gaps(q).min())
        run = simulate(model, q, u, until=until)
        plain = best(lambda m=model, a=q, b=u, t=until: simulate(m, a, b, until=t), given.rounds)
        for count in given.directions:
            wrt = directions(model, count)
            derived = best(lambda m=model, a=q, b=u, t=until, w=wrt: derive(m, a, b, t, w), given.rounds)
            ratio = derived / plain
            print(
                f"| {name} | {len(run.impacts)} | {count} | {1e3 * plain:.2f} | {1e3 * derived:.2f} | {ratio:.1f} | "
                f"{(ratio - 1) / count:.1f} | {1 + count} |"
            )


if __name__ == "__main__":
    main()
