"""Flight of W(6) for 10 s: ccgen beside CasADi's accelerations with RKF78 and heyoka's Taylor integrator, in one run.

Prints a markdown table; `python benchmarks/flight.py --help` lists the options, README.md explains the rest.
"""

import argparse
import ctypes
import math
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import casadi_loop
import heyoka_loop
import numpy as np
from driver import ROOT, WORK, compile_shared
from machine import machine
from workload import Array, workload

from ccgen.generator import generate, loop
from ccgen.runtime import Model, Run, load_model, methods, simulate

TOLERANCES = tuple(10.0**-k for k in range(4, 15))
CASADI_TOLERANCES = tuple(10.0 ** (-k / 2) for k in range(8, 31))
HEYOKA_TOLERANCES = (1e-6, 1e-8, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14, 1e-15, 1e-16)
"""heyoka compiles an integrator of its own for each, seconds to half a minute."""
IN_A_ROW = 5
"""Flights of one kind in each round: the first finds the caches full of another's code."""
LEVELS = (1e-4, 1e-6, 1e-8, 3e-11, 2e-13)
"""Errors at which times are compared."""


@dataclass
class Flight:
    """What flies at one tolerance: `fly` gives the end's q; `clock` the seconds of one flight. Then what was found."""

    name: str
    tolerance: float
    fly: Callable[[], Array]
    clock: Callable[[], float]
    seconds: float = math.inf
    error: float = math.nan  # largest error in x, y or angle of any link


def clocked(call: Callable[[], object]) -> Callable[[], float]:
    """A call that gives its seconds, as seen from Python."""

    def clock() -> float:
        began = time.perf_counter()
        call()
        return time.perf_counter() - began

    return clock


def ours(model: Model, q: Array, u: Array, until: float) -> list[Flight]:
    """Every method, as a whole call of `simulate` and as the compiled call inside it."""
    found, none = [], np.zeros(0)
    for method in methods(estimating=True):  # the others take steps of one length, whatever the tolerance
        for rtol in TOLERANCES:

            def whole(m: str = method, r: float = rtol) -> Run:
                return simulate(model, q, u, until=until, rtol=r, method=m)  # type: ignore[no-any-return]

            def inner(m: str = method, r: float = rtol) -> object:
                return model.kernels.simulate(q, u, m, until, r, r, 0.0, 10**7, 10**7, None, None, none)

            def end(call: Callable[[], Run] = whole) -> Array:
                return call().q[-1]

            found.append(Flight(f"{method}, from Python", rtol, end, clocked(whole)))
            found.append(Flight(f"{method}, compiled part", rtol, end, clocked(inner)))
    return found


def casadi(q: Array, u: Array, until: float) -> list[Flight]:
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
    y, count, address = np.empty(2 * q.size), ctypes.c_long(), ctypes.cast(accelerate, ctypes.c_void_p)

    def clock(tol: float) -> float:
        y[:] = np.concatenate([q, u])
        seconds: float = rkf78(address, q.size, until, tol, 1, y.ctypes.data, ctypes.byref(count))
        return seconds

    def fly(tol: float) -> Array:
        clock(tol)
        return y[: q.size].copy()

    return [Flight("CasADi, RKF78", tol, partial(fly, tol), partial(clock, tol)) for tol in CASADI_TOLERANCES]


def heyoka(q: Array, u: Array, until: float) -> list[Flight]:
    """heyoka's Taylor integrator, called from Python; compiling it and putting the start back are not in the time."""
    start = np.concatenate([q, u])

    def clock(integrator: Any) -> float:
        integrator.time = 0.0
        integrator.state[:] = start
        return clocked(lambda: integrator.propagate_until(until))()

    def fly(integrator: Any) -> Array:
        clock(integrator)
        return np.array(integrator.state[: q.size])

    integrators = [(tol, heyoka_loop.integrator(start, tol)) for tol in HEYOKA_TOLERANCES]
    return [Flight("heyoka, Taylor", tol, partial(fly, ta), partial(clock, ta)) for tol, ta in integrators]


def at(flights: list[Flight], error: float) -> Flight | None:
    """The fastest flight that stays within an error."""
    return min((f for f in flights if f.error <= error), key=lambda f: f.seconds, default=None)


def main() -> None:
    """Fly, and print a line for everything that flew, then ratios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--until", type=float, default=10.0, metavar="T", help="seconds of flight")
    parser.add_argument(
        "--rounds", type=int, default=20, help=f"rounds of {IN_A_ROW} flights, of which the fastest counts"
    )
    parser.add_argument("--all", action="store_true", help="also list every tolerance")
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    model = load_model(generate(loop(6, gravity=True), out=WORK / "models"))
    q, u, _ = workload(6, 1).coordinates(root=model.links.index(model.root))
    q, u = model.project(q[0], u[0])
    wanted = model.poses(heyoka_loop.exact_end(np.concatenate([q, u]), options.until)[: q.size])
    check = simulate(model, q, u, until=options.until, rtol=1e-15, method="gauss")
    doubt = np.max(np.abs(model.poses(check.q[-1]) - wanted))
    versions = f"CasADi {casadi_loop.version()}, heyoka {heyoka_loop.heyoka().__version__}"
    print(f"{machine()}, {versions}, {model.kernels.lanes} lanes")
    print(f"reference: heyoka in 80 bits; gauss at 1e-15 differs by {doubt:.0e}\n")
    flights = [*casadi(q, u, options.until), *heyoka(q, u, options.until), *ours(model, q, u, options.until)]
    for flight in flights:
        flight.error = float(np.max(np.abs(model.poses(flight.fly()) - wanted)))
    for _ in range(options.rounds):
        for flight in flights:
            flight.seconds = min(flight.seconds, *(flight.clock() for _ in range(IN_A_ROW)))
    if options.all:
        for flight in flights:
            line = f"{flight.name} at {flight.tolerance:.0e}: {1e6 * flight.seconds:.1f} µs, error {flight.error:.1e}"
            print(line, file=sys.stderr)
    table(flights)


def table(flights: list[Flight]) -> None:
    """A line for everything that flew, then the ratios."""
    names = list(dict.fromkeys(flight.name for flight in flights))
    groups = {name: [flight for flight in flights if flight.name == name] for name in names}
    print("| µs at an error of at most | " + " | ".join(f"{level:.0e}" for level in LEVELS) + " |")
    print("|" + "---|" * (len(LEVELS) + 1))
    for name in names:
        best = [at(groups[name], level) for level in LEVELS]
        print(f"| {name} | " + " | ".join(f"{1e6 * f.seconds:.0f}" if f else "–" for f in best) + " |")
    for name in ("gauss, from Python", "gauss, compiled part"):
        for peer in names[:2]:
            ratios = [(at(groups[name], level), at(groups[peer], level)) for level in LEVELS]
            cells = [f"{a.seconds / b.seconds:.3f}" if a and b else "–" for a, b in ratios]
            print(f"| ratio: {name} / {peer} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
