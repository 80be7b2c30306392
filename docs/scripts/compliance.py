"""What a ground that gives way costs beside a rigid one, and how far it is from it: the table in docs/accuracy.md.

The falling hexagon on its corner, nothing lost, to 0.5 s: its first impact, without and with a time of contact.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np

from ccgen.generator import Scene, generate, loop
from ccgen.runtime import Model, Run, load_model, simulate

UNTIL, RTOL, REPEATS = 0.5, 1e-9, 50
LOADS = (1e2, 1e4, 1e6, 1e8)
"""N at a depth of 1 mm: stiffness of 10⁵ to 10¹¹ N/m, for 6 kg."""


def scene(**ground: object) -> Scene:
    """The hexagon above a ground."""
    return loop(6, gravity=True, start={"height": 1.0}, **ground)


def timed(model: Model, params: dict[str, float] | None = None) -> tuple[Run, float]:
    """A run, and the least seconds of many."""
    least = float("inf")
    for _ in range(REPEATS):
        began = time.perf_counter()
        run = simulate(model, until=UNTIL, rtol=RTOL, params=params)
        least = min(least, time.perf_counter() - began)
    return run, least


def main() -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as folder:
        rigid = load_model(generate(scene(ground=[{"restitution": 1.0}]), Path(folder) / "rigid"))
        soft = load_model(generate(scene(compliant_ground=[{"load": 1e4, "exponent": 1.0}]), Path(folder) / "soft"))
        reference, seconds = timed(rigid)
        print("| ground | rows | time | velocities off by, m/s | energy off by, J |\n|---|---|---|---|---|")
        print(f"| rigid | {len(reference.t)} | 1 | – | {reference.energy_drift:.0e} |")
        for load in LOADS:
            run, own = timed(soft, {"compliant_ground_0.load": load})
            off = float(np.abs(run.u[-1] - reference.u[-1]).max())
            cells = f"{len(run.t)} | {own / seconds:.1f} | {off:.0e} | {run.energy_drift:.0e}"
            print(f"| {1000 * load:.0e} N/m | {cells} |")


if __name__ == "__main__":
    main()
