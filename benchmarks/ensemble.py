"""Many runs by `ensemble`: what a run costs beside its steps, flights beside heyoka's batches, two threads beside one,
drops beside MuJoCo's rollout, and memory.

Prints markdown tables; `python benchmarks/ensemble.py --help` lists the options, README.md explains the rest.
"""

import argparse
import importlib.util
import math
import multiprocessing
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import heyoka_loop
import mujoco_linkage
import numpy as np
from driver import ROOT, WORK
from linkage import as_tree, of_model
from machine import machine
from turns import fastest
from workload import Array, workload

from ccgen.generator import generate, load_scene, loop
from ccgen.runtime import Model, ensemble, load_model, simulate

LEVEL = 3e-11
"""The error at which flights are compared."""
STARTS = 8
"""Flights whose errors are looked at: those of one batch."""
TOLERANCES = tuple(10.0 ** (-k / 2) for k in range(16, 29))
HEYOKA_TOLERANCES = (1e-11, 1e-12, 1e-13)
"""heyoka compiles an integrator of its own for each and each size, half a minute."""
FIXED, STEPS = 1e-3, (1, 2, 4, 8)
"""Steps (s), and how many a run has, from which what it costs beside them follows."""
MUJOCO_STEPS = (2e-3, 1e-3)
"""The first is the one it has unless told otherwise (s)."""
PIECE = 10_000
"""Starts that are drawn at a time where memory is looked at."""


def ring(height: float | None = None) -> Model:
    """W(6), above a smooth ground where a height is given."""
    tables: dict[str, Any] = {}
    if height is not None:
        tables = {"ground": [{"point": [0, 0], "normal": [0, 1], "restitution": 0.7}]}
    return load_model(generate(loop(6, gravity=True, **tables), out=WORK / "models"))  # type: ignore[no-any-return]


def starts(model: Model, count: int, height: float | None = None) -> tuple[Array, Array]:
    """So many states of W(6), its first ones over and over; where a height is given, the lowest joint is there."""
    q, u = model.project(*workload(6, STARTS).coordinates(root=model.links.index(model.root))[:2])
    if height is not None:
        q[:, 1] += height - model.poses(q)[:, :, 1].min(axis=1)
    again = np.arange(count) % STARTS
    return q[again], u[again]


def alone(model: Model, q: Array, u: Array, until: float, rtol: float) -> Callable[[], object]:
    """The compiled part of `simulate`, one start after the other."""
    none = np.zeros(0)

    def fly() -> None:
        for a, b in zip(q, u, strict=True):
            model.kernels.simulate(a, b, "gauss", until, rtol, rtol, 0.0, 10**7, 10**7, None, None, none)

    return fly


def together(model: Model, q: Array, u: Array, threads: int = 1, **asked: Any) -> Callable[[], object]:
    return lambda: ensemble(model, q0=q, u0=u, threads=threads, **asked)


def core_alone(model: Model, q: Array, u: Array, projections: int) -> None:
    """The core's part of an ensemble of runs of one step, its starts put onto the closure so many times."""
    made = model.core.Ensemble(
        model.kernels, len(q), q, u, method="gauss", until=FIXED / 2, rtol=1e-10, atol=1e-10, fixed_step=FIXED,
        step_budget=10**7, rate_budget=10**7, kept="projected", on_gain="reduce", projections=projections, deepest=1e-9,
    )  # fmt: skip
    made.work()


def overhead(rounds: int) -> None:
    """Microseconds of a run beside its steps."""
    model, count = ring(), 20_000
    q, u = starts(model, count)
    long = {"until": 1.0, "rtol": 1e-10}
    runs = fastest(
        [
            together(model, q, u, **long),
            together(model, q, u, observe=["q"], **long),
            alone(model, q[:1000], u[:1000], 1.0, 1e-10),
        ],
        rounds,
    )
    every, observed, compiled = (1e6 * s / n for s, n in zip(runs, (count, count, 1000), strict=True))
    short = fastest([together(model, q, u, step=FIXED, until=FIXED * (k - 0.5)) for k in STEPS], rounds)
    a_step, rest = np.polyfit(STEPS, [1e6 * s / count for s in short], 1)
    onto = fastest([partial(core_alone, model, q, u, k) for k in (0, 1, 2)], rounds)
    closing = 1e6 * (onto[2] - onto[0]) / 2 / count
    print("| W(6), one thread | µs a run |\n|---|---|")
    print(f"| flight of 1 s at 1e-10, `ensemble` | {every:.2f} |")
    print(f"| the same with `q` observed | {observed:.2f} |")
    print(f"| the same flight, compiled part of `simulate` | {compiled:.2f} |")
    print(f"| all beside its steps | {rest:.2f} |")
    print(f"| of that, putting the start onto the closure, twice as `simulate` does | {2 * closing:.2f} |")
    print(f"| of that, Python's part: numbers and table | {1e6 * (short[0] - onto[1]) / count:.2f} |")
    print(f"| **overhead**: all beside its steps and its start | {rest - 2 * closing:.2f} |")
    print(f"| a step of {FIXED} s | {a_step:.2f} |\n", flush=True)


def miss(model: Model, q: Array, wanted: Array) -> float:
    """The largest error of any link, in x, y or angle."""
    return float(np.max(np.abs(model.poses(q) - wanted)))


def flights(rounds: int, until: float) -> None:
    """10 s of W(6) at an error of 3e-11: per run and core."""
    model = ring()
    q, u = starts(model, STARTS)
    y = np.concatenate([q, u], axis=1)
    wanted = model.poses(np.array([heyoka_loop.exact_end(row, until)[: q.shape[1]] for row in y]))
    chosen = None
    for rtol in TOLERANCES:  # loosest first
        error = miss(model, ensemble(model, q0=q, u0=u, until=until, rtol=rtol, observe=["q"])["q"], wanted)
        if error <= LEVEL:
            chosen = rtol, error
            break
    if chosen is None:
        sys.exit(f"ensemble: no tolerance reaches {LEVEL}")
    rtol, error = chosen
    many, more = starts(model, 512)
    names = [f"`ensemble`, one thread, rtol {rtol:.1e}", "compiled part of `simulate`", "`simulate`"]
    calls: list[Callable[[], object]] = [
        together(model, many, more, until=until, rtol=rtol),
        alone(model, many, more, until, rtol),
        lambda: [simulate(model, a, b, until=until, rtol=rtol) for a, b in zip(q, u, strict=True)],
    ]
    counts, errors = [512, 512, STARTS], [error] * 3
    for width in sorted({int(heyoka_loop.heyoka().recommended_simd_size()), 8}):
        for tolerance in HEYOKA_TOLERANCES:
            call, end = batches(y, width, tolerance, until)
            call()
            errors.append(miss(model, end()[:, : q.shape[1]], wanted))
            names.append(f"heyoka, batches of {width}, tolerance {tolerance:.0e}")
            calls.append(call)
            counts.append(STARTS)
    seconds = [s / n for s, n in zip(fastest(calls, 5 * rounds), counts, strict=True)]
    print(f"| {until:g} s of W(6), one core | µs a run | largest error of {STARTS} | time / `ensemble` |")
    print("|---|---|---|---|")
    for name, s, found in zip(names, seconds, errors, strict=True):
        print(f"| {name} | {1e6 * s:.1f} | {found:.1e} | {s / seconds[0]:.2f} |")
    peers = [s for s, found in zip(seconds[3:], errors[3:], strict=True) if found <= LEVEL]
    ratio = f"{min(peers) / seconds[0]:.2f}" if peers else "none reaches it"
    print(
        f"\nat {LEVEL:.0e}: `ensemble` / compiled part {seconds[0] / seconds[1]:.2f}; heyoka / `ensemble` {ratio}\n",
        flush=True,
    )


def batches(y: Array, width: int, tolerance: float, until: float) -> tuple[Callable[[], object], Callable[[], Array]]:
    """heyoka's Taylor integrator over batches of starts, and the ends; compiling is not in the time."""
    parts = [np.ascontiguousarray(y[k : k + width].T) for k in range(0, len(y), width)]
    hy = heyoka_loop.heyoka()
    integrator = hy.taylor_adaptive_batch(heyoka_loop.equations(y.shape[1] // 2 - 2), parts[0], tol=tolerance)
    ends = [part.copy() for part in parts]

    def fly() -> None:
        for part, end in zip(parts, ends, strict=True):
            integrator.set_time(0.0)
            integrator.state[:] = part
            integrator.propagate_until([until] * width)
            end[:] = integrator.state

    return fly, lambda: np.concatenate(ends, axis=1).T


def threads(rounds: int) -> None:
    """Two threads beside one, and two processes that share nothing, which is what the machine has to give."""
    print("| runs | µs a run | one thread, ms | two | speed-up | of two processes |\n|---|---|---|---|---|---|")
    kinds = (("flights of 5 s", None, 5.0, 4096), ("drops to the 16th impact", 0.5, 1.85, 256))
    for name, height, until, count in kinds:
        model = ring(height)
        q, u = starts(model, count, height)
        asked: dict[str, Any] = {"until": until, "rtol": 1e-10, "observe": ["q", "impacts"]}
        whole, half = (together(model, q[:n], u[:n], **asked) for n in (count, count // 2))
        jobs[:] = [whole, half]
        context = multiprocessing.get_context("fork")
        with context.Pool(1) as single, context.Pool(2) as double:
            calls = [whole, together(model, q, u, 2, **asked)]
            calls += [partial(single.map, work, [0]), partial(double.map, work, [1, 1], 1)]
            one, two, alone_, both = fastest(calls, 8 * rounds)
        times = f"{1e6 * one / count:.0f} | {1e3 * one:.0f} | {1e3 * two:.0f}"
        print(f"| {count} {name} | {times} | {one / two:.2f} | {alone_ / both:.2f} |", flush=True)
    print()


jobs: list[Callable[[], object]] = []


def work(number: int) -> None:
    """One of the jobs, in a process that has been forked."""
    jobs[number]()


def drops(rounds: int, count: int, workers: int) -> None:
    """The falling hexagon from many heights, 1 s with its impacts, beside MuJoCo's rollout."""
    scene = load_scene(ROOT / "scenes" / "falling-hexagon.toml")
    model = load_model(generate(scene, out=WORK / "models"))
    q, u = model.start()
    lifts = np.random.default_rng(1).uniform(0.0, 0.2, count)
    qs = np.tile(q, (count, 1))
    qs[:, 1] += lifts
    began = time.perf_counter()
    table = ensemble(model, q0=qs, u0=u, until=1.0, observe=["impacts", "q"], threads=workers)
    whole = time.perf_counter() - began
    done = int((table.status == "done").sum())
    print(f"{count} hexagons, {workers} threads: {whole:.1f} s, {done} done, {int(table.impacts.sum())} impacts\n")
    counts, names = [min(count, 2000)], ["`ensemble`"]
    calls = [together(model, qs[: counts[0]], u, workers, until=1.0, observe=["impacts", "q"])]
    if importlib.util.find_spec("mujoco") is None:
        print("MuJoCo is not installed; run: python -m pip install -e .[engines]\n")
    else:
        linkage = of_model(model, scene, corners=True, restitution=0.5)
        for integrator in ("implicitfast", "RK4"):
            for step in MUJOCO_STEPS:
                names.append(f"MuJoCo's rollout, {integrator}, steps of {1e3 * step:g} ms")
                calls.append(rollout(linkage, step, integrator, lifts[:500], workers))
                counts.append(min(count, 500))
    rates = [n / s for n, s in zip(counts, fastest(calls, rounds), strict=True)]
    print("| hexagon, 1 s | runs a second | time / `ensemble` |\n|---|---|---|")
    for name, rate in zip(names, rates, strict=True):
        print(f"| {name} | {rate:.0f} | {rates[0] / rate:.2f} |")
    print(flush=True)


def rollout(linkage: Any, step: float, integrator: str, lifts: Array, workers: int) -> Callable[[], object]:
    """MuJoCo's own threads over many starts, which keep every step's state; in pieces, for memory."""
    import mujoco
    from mujoco.rollout import Rollout

    tree = as_tree(linkage)
    model: Any = mujoco.MjModel.from_xml_string(mujoco_linkage.xml(tree, step, integrator))
    data = [mujoco.MjData(model) for _ in range(workers)]
    names = [*(("x", "y") if tree.floats else ()), *(f"t{bond.link}" for bond in tree.bonds)]
    order = np.array([int(model.joint(name).qposadr[0]) for name in names])
    size = mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    initial = np.zeros((len(lifts), size))  # time, coordinates, velocities
    data[0].qvel[order] = tree.speeds()
    mujoco.mj_getState(model, data[0], initial[0], mujoco.mjtState.mjSTATE_FULLPHYSICS)
    initial[:] = initial[0]
    initial[:, 1 + order[1]] += lifts
    pool, steps = Rollout(nthread=workers), round(1.0 / step)

    def fall() -> None:
        for first in range(0, len(lifts), 250):
            pool.rollout(model, data, initial[first : first + 250], nstep=steps)

    return fall


def remember(count: int) -> None:
    """Fly so many starts, drawn piece by piece, keep the largest height alone, and print what memory it took."""
    model = ring()
    q, u = starts(model, PIECE)
    rng, found = np.random.default_rng(1), -math.inf

    def highest(found: float, table: Any) -> float:
        return max(found, float(table["q"][:, 1].max()))

    for _ in range(0, count, PIECE):
        q[:, 1] = rng.uniform(0.0, 1.0, PIECE)
        found = ensemble(model, q0=q, u0=u, until=1.0, observe=["q"], reduce=highest, initial=found)
    print(peak())


def peak() -> float:
    """The most memory this process has had, MB. Linux's `ru_maxrss` would count what started it too."""
    try:
        lines = Path("/proc/self/status").read_text().splitlines()
    except OSError:
        import resource

        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024) / 1e6
    return next(int(line.split()[1]) * 1024 for line in lines if line.startswith("VmHWM:")) / 1e6


def memory(counts: list[int]) -> None:
    """Peak memory of processes that make so many flights."""
    print("| flights of 1 s, `reduce` | seconds | peak of the process, MB |\n|---|---|---|")
    for count in counts:
        began = time.perf_counter()
        command = [sys.executable, str(Path(__file__)), "--remember", str(count)]
        said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        print(f"| {count} | {time.perf_counter() - began:.1f} | {float(said):.0f} |", flush=True)


PARTS = ("overhead", "flights", "threads", "drops", "memory")


def main() -> None:
    """Print the parts that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=PARTS, metavar="PART", help=", ".join(PARTS))
    parser.add_argument("--rounds", type=int, default=7, help="rounds of which the fastest counts")
    parser.add_argument("--drops", type=int, default=100_000, metavar="N", help="hexagons that are dropped")
    parser.add_argument("--threads", type=int, default=2, help="of the drops")
    parser.add_argument("--flights", type=int, nargs="+", default=[10_000, 100_000, 1_000_000], help="of the memory")
    parser.add_argument("--remember", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    if options.remember:
        remember(options.remember)
        return
    print(f"{machine()}\n", flush=True)
    if "overhead" in options.parts:
        overhead(options.rounds)
    if "flights" in options.parts:
        flights(options.rounds, 10.0)
    if "threads" in options.parts:
        threads(options.rounds)
    if "drops" in options.parts:
        drops(options.rounds, options.drops, options.threads)
    if "memory" in options.parts:
        memory(options.flights)


if __name__ == "__main__":
    main()
