"""µs of flights, a drop and a walk by DOP853, as JSON. `since.py` runs it with each commit: it uses what all have."""

import json
import math
import sys
import time
from collections.abc import Callable
from pathlib import Path

from workload import workload

from ccgen.generator import generate, load_scene, loop
from ccgen.generator.scene.errors import SceneError
from ccgen.runtime import load_model, simulate

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "docs" / "scripts"))
import strandbeest  # noqa: E402

SCENE = ROOT / "scenes" / "falling-hexagon.toml"
FEET = ", ".join(f'"shin_{side}{crank}.F"' for crank in range(2) for side in "lr")
WALK = f"""
[start]
height = 37

[[ground]]
restitution = 0.0
friction = 0.8
contacts = [{FEET}]

[[motor]]
joint = "axle"
angle = "3*t"
stiffness = 1e10
damping = 1e9
"""
"""What makes the beach animal walk; its lengths are in centimetres."""


def walker() -> str:
    """A scene of 26 links: four of Jansen's legs on two cranks of a shaft, that a motor turns, on rough ground."""
    text = strandbeest.plain([0.0, math.pi], per_metre=1.0).replace("g = 9.81", "g = 981")
    return text.replace("shaft = 6.0", "shaft = 3.0") + WALK


def least(call: Callable[[], object], rounds: int) -> float:
    """µs of the fastest of many calls."""
    best = float("inf")
    for _ in range(rounds):
        began = time.perf_counter()
        call()
        best = min(best, time.perf_counter() - began)
    return 1e6 * best


def main() -> None:
    """Flights of W(6); the falling hexagon through its first impacts; the walker through six impacts."""
    folder, rounds = Path(sys.argv[1]), int(sys.argv[2])
    flier = load_model(generate(loop(6, gravity=True), out=folder / "flight"))
    q, u, _ = workload(6, 1).coordinates(root=flier.links.index(flier.root))
    start = flier.project(q[0], u[0])
    faller = load_model(generate(load_scene(SCENE), out=folder / "drop"))

    file = folder / "walker.toml"
    file.write_text(walker())
    try:
        animal = load_model(generate(load_scene(file), out=folder / "walk"))
    except SceneError:
        animal = None  # a commit that knows of no friction

    def flight(until: float = 10.0) -> object:
        return simulate(flier, *start, until=until, rtol=1e-10, method="dop853")

    def drop() -> object:
        return simulate(faller, until=1.2, rtol=1e-10, method="dop853")

    def walk() -> object:
        return simulate(animal, until=0.2, rtol=1e-8, method="dop853")

    found = {
        "flight, 1 s, µs": least(lambda: flight(1.0), rounds),
        "flight, 10 s, µs": least(flight, rounds),
        "drop, 1.2 s, µs": least(drop, rounds),
    }
    if animal is not None:
        found["walk, 0.2 s, µs"] = least(walk, rounds // 10)
    print(json.dumps(found))


if __name__ == "__main__":
    main()
