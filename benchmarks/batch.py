"""Nanoseconds per state of W(n) over many states: ccgen's lanes beside heyoka's compiled function, in one run.

Prints a markdown table; `python benchmarks/batch.py --help` lists the options, README.md explains the rest.
"""

import argparse
import os
import time
from collections.abc import Callable

import heyoka_loop
import numpy as np
from ccgen_loop import ccgen_kernel, ccgen_lanes
from driver import WORK, batch
from machine import machine
from workload import Array, workload

from ccgen.generator import generate, loop
from ccgen.runtime import load_model

SIZES = (6, 24, 48)
BYTES = 512 * 1024
"""Of q, u and du/dt: the 32 states are repeated until they take as much, which stays in the second cache."""


def from_python(call: Callable[[], object], states: int) -> Callable[[], float]:
    """A call that gives its seconds per state, as seen from Python."""

    def clock() -> float:
        began = time.perf_counter()
        call()
        return (time.perf_counter() - began) / states

    return clock


def compare(n: int, rounds: int) -> list[tuple[str, float, float]]:
    """Name, seconds per state, and error relative to the largest acceleration, of each; heyoka first."""
    load = workload(n)
    scale = np.abs(load.accelerations).max()
    repeats = BYTES // (8 * 3 * (n + 2) * len(load.poses))
    model = load_model(generate(loop(n, gravity=True), out=WORK / "models"))
    q, u, exact = (np.tile(x, (repeats, 1)) for x in load.coordinates(root=model.links.index(model.root)))
    y0 = np.concatenate(load.coordinates(root=0)[:2], axis=1)
    y, exact0 = np.ascontiguousarray(np.tile(y0.T, (1, repeats))), np.tile(load.coordinates(root=0)[2], (repeats, 1))
    found, function = np.zeros((n + 2, y.shape[1])), heyoka_loop.function(n)
    function(y, outputs=found)
    assert len(q) % model.kernels.lanes == 0
    lanes, got = ccgen_lanes(q, u, model)
    kernel, _ = ccgen_kernel(load)
    results: list[tuple[str, Callable[[], float], Array]] = [
        ("heyoka", from_python(lambda: function(y, outputs=found), len(q)), found.T - exact0),
        ("ccgen lanes, C", lambda: batch(lanes, len(q)) / len(q), got() - exact),
        ("ccgen, Python", from_python(lambda: model.acceleration(q, u), len(q)), model.acceleration(q, u) - exact),
        ("ccgen one by one, C", lambda: batch(kernel, len(q)) / len(q), np.zeros(1)),
    ]
    best = [np.inf] * len(results)
    for _ in range(rounds):
        for i, (_, clock, _) in enumerate(results):
            best[i] = min(best[i], clock())
    errors = [float(np.abs(miss).max() / scale) for _, _, miss in results]
    return [(name, s, error) for (name, _, _), s, error in zip(results, best, errors, strict=True)]


def main() -> None:
    """Measure every size and print the table as it grows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--links", type=int, nargs="+", default=SIZES, metavar="N", help="sizes of the loop")
    parser.add_argument("--rounds", type=int, default=200, help="batches of which the fastest counts")
    options = parser.parse_args()
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})  # heyoka would take all cores
    WORK.mkdir(parents=True, exist_ok=True)
    print(f"{machine()}, heyoka {heyoka_loop.heyoka().__version__}\n")
    print(
        "| n | errors, heyoka / ccgen | heyoka ns | lanes, C | ratio | `acceleration`, Python | ratio | one by one, C |"
    )
    print("|" + "---|" * 8, flush=True)
    for n in options.links:
        (_, peer, peer_error), (_, lanes, error), (_, python, _), (_, single, _) = compare(n, options.rounds)
        cells = [str(n), f"{peer_error:.0e} / {error:.0e}", f"{1e9 * peer:.1f}", f"{1e9 * lanes:.1f}"]
        cells += [f"{lanes / peer:.2f}", f"{1e9 * python:.1f}", f"{python / peer:.2f}", f"{1e9 * single:.1f}"]
        print("| " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
