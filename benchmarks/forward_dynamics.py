"""Nanoseconds per acceleration of W(n), called from C: ccgen beside CasADi, in one run.

Prints a markdown table; `python benchmarks/forward_dynamics.py --help` lists the options, README.md explains the rest.
"""

import argparse
import ctypes
import hashlib
import sys
from collections.abc import Sequence
from dataclasses import dataclass

import casadi_loop
import numpy as np
from ccgen_loop import ccgen_kernel
from driver import CASADI, WORK, Kernel, compile_shared, interleave
from machine import machine
from workload import Array, Workload, workload

SIZES = (4, 6, 12, 24, 48, 96, 192)
CASADI_FLAGS = ("-O1", "-O2 -fno-math-errno", "-O3", "-O1 -ffast-math", "-O3 -ffast-math")
"""Each with -march=native; the fastest is shown. The second are the flags of ccgen's own models."""

HEADER = (
    *("n", "ccgen ns, min", "median", "error", "CasADi ns, min", "median", "error"),
    *("ratio of minima", "of medians", "CasADi at"),
)


@dataclass(frozen=True)
class Result:
    """Seconds per evaluation over the rounds, and the largest error relative to the largest acceleration."""

    name: str
    minimum: float
    median: float
    error: float


def casadi_kernels(load: Workload, limit: float) -> list[Kernel]:
    """CasADi's C under every set of flags that the compiler gets through within `limit` seconds."""
    source = casadi_loop.write_source(load.links, WORK)
    q, u, _ = load.coordinates(root=0)
    kernels = []
    for flags in CASADI_FLAGS:
        options = [*flags.split(), "-march=native"]
        key = hashlib.sha256(source.read_bytes() + f"{machine()} {flags}".encode()).hexdigest()[:16]
        path = WORK / f"{source.stem}_{key}.so"
        if path.exists() or compile_shared(source, options, path, limit):
            function = getattr(ctypes.CDLL(str(path)), casadi_loop.FUNCTION)
            address = ctypes.cast(function, ctypes.c_void_p).value or 0
            kernels.append(Kernel(flags, CASADI, address, q, u, np.full_like(u, np.nan), np.empty(0), np.empty(0)))
    return kernels


def measure(load: Workload, kernels: Sequence[Kernel], exact: Sequence[Array], rounds: int) -> list[Result]:
    """Time the kernels in turn and compare what they computed with the exact du/dt."""
    seconds = interleave(kernels, rounds, length=2e-4)
    scale = np.abs(load.accelerations).max()
    return [
        Result(kernel.name, times.min(), float(np.median(times)), np.abs(kernel.u_dot - reference).max() / scale)
        for kernel, reference, times in zip(kernels, exact, seconds.T, strict=True)
    ]


def compare(n: int, rounds: int, limit: float) -> tuple[Result, list[Result]]:
    """ccgen and CasADi's variants on W(n)."""
    load = workload(n)
    ours, exact = ccgen_kernel(load)
    theirs = casadi_kernels(load, limit)
    results = measure(load, [ours, *theirs], [exact, *[load.coordinates(root=0)[2]] * len(theirs)], rounds)
    return results[0], results[1:]


def row(n: int, ours: Result, theirs: Sequence[Result]) -> str:
    """One line of the table: ccgen beside the fastest of CasADi's variants."""
    best = min(theirs, key=lambda result: result.minimum)
    cells = [str(n)]
    for result in (ours, best):
        cells += [f"{1e9 * result.minimum:.0f}", f"{1e9 * result.median:.0f}", f"{result.error:.0e}"]
    cells += [f"{ours.minimum / best.minimum:.2f}", f"{ours.median / best.median:.2f}", best.name]
    return "| " + " | ".join(cells) + " |"


def main() -> None:
    """Measure every size and print the table as it grows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--links", type=int, nargs="+", default=SIZES, metavar="N", help="sizes of the loop")
    parser.add_argument("--rounds", type=int, default=500, help="batches of 0.2 ms per kernel")
    parser.add_argument("--compile-limit", type=float, default=60.0, help="seconds per CasADi variant")
    parser.add_argument("--variants", action="store_true", help="also list every CasADi variant")
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    print(f"{machine()}, CasADi {casadi_loop.version()}\n")
    print("| " + " | ".join(HEADER) + " |\n|" + "---|" * len(HEADER), flush=True)
    for n in options.links:
        ours, theirs = compare(n, options.rounds, options.compile_limit)
        print(row(n, ours, theirs), flush=True)
        if options.variants:
            for result in theirs:
                nanoseconds = f"{1e9 * result.minimum:.0f} {1e9 * result.median:.0f}"
                print(f"    CasADi {result.name}: {nanoseconds}", file=sys.stderr)


if __name__ == "__main__":
    main()
