"""Many flights with runs in the lanes of the machine, beside the stages of one run in them, as the core has it.

Prints a markdown table; `python benchmarks/shared_lanes.py --help` lists the options, README.md explains the rest.
"""

import argparse
import ctypes

import numpy as np
from driver import ROOT, WORK, compile_shared, model_arrays
from machine import machine
from workload import Array, workload

from ccgen.generator import generate, loop
from ccgen.runtime import load_model, simulate

UNTIL, TOLERANCE, RTOL = 10.0, 1e-13, 1e-10
"""Seconds of flight, what stages may still change by (m/s or rad/s), the tolerance of runs that choose their steps."""
STEPS = (0.1, 0.25, 0.5)
"""Steps (s); with tolerance W(6) takes steps of half a second."""
WAYS = ("stages in lanes", "runs in lanes", "runs in lanes, stages used at once")


class Flight(ctypes.Structure):
    """`struct flight` of shared_lanes.c."""

    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("model", "constants", "multipliers")),
        *((name, ctypes.c_int) for name in ("n", "steps")),
        *((name, ctypes.c_double) for name in ("h", "tolerance")),
    )


def main() -> None:
    """Fly the states of W(6) in three ways, and count the steps that runs would have in common."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=100, help="repeats of which the fastest counts")
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    model = load_model(generate(loop(6, gravity=True), out=WORK / "models"))
    lanes = model.kernels.lanes
    flags = ["-O2", "-march=native", "-fno-math-errno", "-Wno-psabi", f"-DLANES={lanes}"]
    core = ROOT / "runtime" / "core"
    includes = [f"-I{folder}" for folder in (core.parent, core, core / "methods")]
    compile_shared(ROOT / "benchmarks" / "shared_lanes.c", [*flags, *includes], WORK / "shared_lanes.so")
    library = ctypes.CDLL(str(WORK / "shared_lanes.so"))
    library.fly.restype = ctypes.c_double
    q, u = model.project(*workload(6).coordinates(root=model.links.index(model.root))[:2])
    constants, room = model_arrays(model.kernels.address, np.array(list(model.parameters.values())))
    room = np.zeros(lanes * room.size)
    print(f"{machine()}, {lanes} lanes\n\n| {UNTIL:g} s of W(6) | µs a step | sweeps | time / stages in lanes |")
    print("|---|---|---|---|", flush=True)
    for h in STEPS:
        addresses = (model.kernels.address, constants.ctypes.data, room.ctypes.data)
        flight = Flight(*addresses, q.shape[1], round(UNTIL / h), h, TOLERANCE)
        best, sweeps, ends = [np.inf] * 3, ctypes.c_long(), [q] * 3
        counts = [0.0] * 3
        for _ in range(options.rounds):
            for way in range(3):
                ends[way], speeds = q.copy(), u.copy()
                given = (ctypes.c_void_p(ends[way].ctypes.data), ctypes.c_void_p(speeds.ctypes.data))
                took = library.fly(ctypes.byref(flight), way, len(q), *given, ctypes.byref(sweeps))
                best[way], counts[way] = min(best[way], took), sweeps.value
        assert max(np.abs(end - ends[0]).max() for end in ends) < 1e-10
        steps = len(q) * flight.steps
        for name, seconds, count in zip(WAYS, best, counts, strict=True):
            cells = f"{1e6 * seconds / steps:.2f} | {count / steps:.2f} | {seconds / best[0]:.2f}"
            print(f"| steps of {h} s, {name} | {cells} |", flush=True)
    print(f"\nsteps in common with {lanes - 1} others / own: {in_common(model, q, u, lanes):.3f}")


def in_common(model: object, q: Array, u: Array, lanes: int) -> float:
    """How many more steps runs have that go on together, each as long as the shortest of theirs, than alone."""
    instants = np.linspace(0.0, UNTIL, 20_000, endpoint=False)
    runs = [simulate(model, a, b, until=UNTIL, rtol=RTOL) for a, b in zip(q, u, strict=True)]
    rates = np.array([1.0 / np.diff(run.t)[np.searchsorted(run.t, instants, side="right") - 1] for run in runs])
    together = [rates[first : first + lanes].max(axis=0).mean() for first in range(0, len(runs), lanes)]
    return float(np.mean(together) / rates.mean())


if __name__ == "__main__":
    main()
