"""µs of a flight and of a drop by DOP853, as JSON. `since.py` runs it with each commit: it uses what all have."""

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path

from workload import workload

from ccgen.generator import generate, load_scene, loop
from ccgen.runtime import load_model, simulate

SCENE = Path(__file__).resolve().parent.parent / "scenes" / "falling-hexagon.toml"


def least(call: Callable[[], object], rounds: int) -> float:
    """µs of the fastest of many calls."""
    best = float("inf")
    for _ in range(rounds):
        began = time.perf_counter()
        call()
        best = min(best, time.perf_counter() - began)
    return 1e6 * best


def main() -> None:
    """Flight of W(6) for 10 s; the falling hexagon through its first impacts."""
    folder, rounds = Path(sys.argv[1]), int(sys.argv[2])
    flier = load_model(generate(loop(6, gravity=True), out=folder / "flight"))
    q, u, _ = workload(6, 1).coordinates(root=flier.links.index(flier.root))
    start = flier.project(q[0], u[0])
    faller = load_model(generate(load_scene(SCENE), out=folder / "drop"))

    def flight() -> object:
        return simulate(flier, *start, until=10.0, rtol=1e-10, method="dop853")

    def drop() -> object:
        return simulate(faller, until=1.2, rtol=1e-10, method="dop853")

    print(json.dumps({"flight, 10 s, µs": least(flight, rounds), "drop, 1.2 s, µs": least(drop, rounds)}))


if __name__ == "__main__":
    main()
