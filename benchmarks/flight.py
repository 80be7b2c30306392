"""Flight of W(6) for 10 s: ccgen beside CasADi's accelerations with RKF78, error and time of each, in one run.

Prints a markdown table; `python benchmarks/flight.py --help` lists the options, README.md explains the rest.
"""

import argparse
import ctypes
import time
from collections.abc import Callable
from dataclasses import dataclass

import casadi_loop
import numpy as np
from driver import ROOT, WORK, compile_shared
from machine import machine
from workload import Array, workload

from ccgen.generator import generate, loop
from ccgen.runtime import Model, load_model, methods, simulate

TOLERANCES = tuple(10.0**-k for k in range(4, 15))
LEVELS = (1e-4, 1e-6, 1e-8, 3e-11, 2e-13)
"""Errors at which times are compared."""


@dataclass(frozen=True)
class Flight:
    """One flight: what flew it, the tolerance, seconds, and the largest error in x, y or angle of any link."""

    name: str
    tolerance: float
    seconds: float
    error: float


def fastest(call: Callable[[], object], rounds: int) -> float:
    """Seconds of the fastest of several calls."""
    best = np.inf
    for _ in range(rounds):
        began = time.perf_counter()
        call()
        best = min(best, time.perf_counter() - began)
    return float(best)


def ours(model: Model, q: Array, u: Array, until: float, wanted: Array, rounds: int) -> list[Flight]:
    """Every method, as a whole call of `simulate` and as the compiled call inside it."""
    found, none = [], np.zeros(0)
    for method in methods():
        for rtol in TOLERANCES:
            run = simulate(model, q, u, until=until, rtol=rtol, method=method)
            error = float(np.max(np.abs(model.poses(run.q[-1]) - wanted)))
            whole = fastest(lambda m=method, r=rtol: simulate(model, q, u, until=until, rtol=r, method=m), rounds)
            inner = fastest(
                lambda m=method, r=rtol: model.kernels.simulate(q, u, m, until, r, r, 0.0, 10**7, None, None, none),
                rounds,
            )
            found.append(Flight(f"{method}, from Python", rtol, whole, error))
            found.append(Flight(f"{method}, compiled part", rtol, inner, error))
    return found


def theirs(model: Model, q: Array, u: Array, until: float, wanted: Array, rounds: int) -> list[Flight]:
    """CasADi's accelerations, compiled with ccgen's flags, in RKF78; timed from C."""
    source = casadi_loop.write_source(6, WORK)
    objects = [WORK / "casadi_flight.so", WORK / "rkf78.so"]
    for path, target, flags in zip(
        (source, ROOT / "benchmarks" / "rkf78.c"),
        objects,
        (["-O2", "-fno-math-errno", "-march=native"], ["-O3", "-march=native"]),
        strict=True,
    ):
        compile_shared(path, flags, target)
    accelerate = getattr(ctypes.CDLL(str(objects[0])), casadi_loop.FUNCTION)
    rkf78 = ctypes.CDLL(str(objects[1])).rkf78
    rkf78.restype = ctypes.c_double
    rkf78.argtypes = [ctypes.c_void_p, ctypes.c_int, ctypes.c_double, ctypes.c_double, ctypes.c_int]
    rkf78.argtypes += [ctypes.c_void_p, ctypes.c_void_p]
    found = []
    for tol in TOLERANCES:
        y, count = np.concatenate([q, u]), ctypes.c_long()
        address = ctypes.cast(accelerate, ctypes.c_void_p)
        seconds = rkf78(address, q.size, until, tol, rounds, y.ctypes.data, ctypes.byref(count))
        error = float(np.max(np.abs(model.poses(y[: q.size]) - wanted)))
        found.append(Flight("CasADi, RKF78", tol, seconds, error))
    return found


def at(flights: list[Flight], error: float) -> Flight | None:
    """The fastest flight that stays below an error."""
    return min((f for f in flights if f.error <= error), key=lambda f: f.seconds, default=None)


def main() -> None:
    """Fly, and print a line for everything that flew, then ratios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--until", type=float, default=10.0, metavar="T", help="seconds of flight")
    parser.add_argument("--rounds", type=int, default=100, help="flights of which the fastest counts")
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    model = load_model(generate(loop(6, gravity=True), out=WORK / "models"))
    q, u, _ = workload(6, 1).coordinates(root=model.links.index(model.root))
    q, u = model.project(q[0], u[0])
    reference = simulate(model, q, u, until=options.until, rtol=1e-15, method="gauss")
    check = simulate(model, q, u, until=options.until, rtol=1e-14, method="dop853")
    wanted = model.poses(reference.q[-1])
    doubt = np.max(np.abs(model.poses(check.q[-1]) - wanted))
    print(f"{machine()}, CasADi {casadi_loop.version()}, {model.kernels.lanes} lanes")
    print(f"reference: gauss at 1e-15; DOP853 at 1e-14 differs by {doubt:.0e}\n")
    flights = theirs(model, q, u, options.until, wanted, options.rounds)
    flights += ours(model, q, u, options.until, wanted, options.rounds)
    names = list(dict.fromkeys(flight.name for flight in flights))
    groups = {name: [flight for flight in flights if flight.name == name] for name in names}
    print("| µs at an error of at most | " + " | ".join(f"{level:.0e}" for level in LEVELS) + " |")
    print("|" + "---|" * (len(LEVELS) + 1))
    for name in names:
        best = [at(groups[name], level) for level in LEVELS]
        print(f"| {name} | " + " | ".join(f"{1e6 * f.seconds:.0f}" if f else "–" for f in best) + " |")
    for name in names[1:3]:
        ratios = [(at(groups[name], level), at(groups[names[0]], level)) for level in LEVELS]
        cells = [f"{a.seconds / b.seconds:.2f}" if a and b else "–" for a, b in ratios]
        print(f"| ratio: {name} / {names[0]} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
