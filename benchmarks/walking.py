"""Nanoseconds per acceleration of walking machines, called from C: ccgen's plans beside CasADi, in one run.

A body, a shaft with c cranks, and two of Jansen's legs on each crank: 2 + 12 c links and 1 + 18 c pins, afloat. Prints
a markdown table; `python benchmarks/walking.py --help` lists the options.
"""

import argparse
import ctypes
import json
import math
import sys
import time

import casadi_linkage
import casadi_loop
import numpy as np
from ccgen_loop import descriptor
from driver import CASADI, CCGEN, ROOT, WORK, Kernel, compile_shared, interleave, model_arrays
from machine import machine

from ccgen.generator import Scene, generate, load_scene
from ccgen.generator.pipeline import derive_scene, plan_scene
from ccgen.generator.program.program import lower
from ccgen.runtime import load_model

sys.path.insert(0, str(ROOT / "docs" / "scripts"))
import strandbeest

CASADI_FLAGS = ("-O1", "-O2", "-O3")
SLOW = 40
"""Links beyond which the order from tip to root is left out: its code takes minutes to compile."""
HEADER = ("links", "plan", "operations", "ns, min", "built in s", "CasADi ns, min", "at", "ratio", "difference")


def scene_of(cranks: int) -> Scene:
    """The walking machine of docs/scripts/strandbeest.py without its pumps, c cranks evenly around the shaft."""
    text = strandbeest.text([2.0 * math.pi * k / cranks for k in range(cranks)], pumps=False)
    path = WORK / f"walking{cranks}.toml"
    path.write_text(text.replace('name = "strandbeest"', f'name = "walking{cranks}"', 1))
    return load_scene(path)


def ours(scene: Scene, plan: str) -> tuple[Kernel, int, float]:
    """The kernel by a plan at the start, its operations, and the seconds it took to generate (0: it was kept)."""
    operations = lower(derive_scene(scene, plan=plan)[1]).function("acceleration").counts().total
    start = time.perf_counter()
    package = generate(scene, out=WORK / "models" / plan.replace(" ", "_"), plan=plan)
    seconds = time.perf_counter() - start
    q, u = load_model(package).start()
    address = descriptor(package)
    data = json.loads((package / "model.json").read_text())
    constants, multipliers = model_arrays(address, np.array([one["value"] for one in data["parameters"]]))
    kernel = Kernel(plan, CCGEN, address, q[None], u[None], np.full((1, u.size), np.nan), constants, multipliers)
    return kernel, operations, seconds


def theirs(scene: Scene, like: Kernel) -> list[Kernel]:
    """CasADi's kernels at the same state, one for each set of flags."""
    count = len(scene.mechanism.links)
    gravity = next(p.value for effect in scene.effects for p in effect.parameters() if p.path == "gravity.g")
    source = casadi_linkage.write_source(scene.mechanism, gravity, WORK, scene.package)
    angles, rates = (np.ascontiguousarray(x[:, 2 : 2 + count]) for x in (like.q, like.u))
    kernels = []
    for flags in CASADI_FLAGS:
        target = source.with_name(f"{source.stem}{flags}.so")
        compile_shared(source, [flags, "-march=native", "-fno-math-errno"], target)
        address = ctypes.cast(getattr(ctypes.CDLL(str(target)), casadi_linkage.FUNCTION), ctypes.c_void_p).value or 0
        room = np.full_like(rates, np.nan)
        kernels.append(Kernel(flags, CASADI, address, angles, rates, room, np.empty(0), np.empty(0)))
    return kernels


def rows(cranks: int, rounds: int) -> list[str]:
    """Lines of the table for one machine."""
    scene = scene_of(cranks)
    links = len(scene.mechanism.links)
    plans = [name for name, _ in plan_scene(scene)[1].costs if links <= SLOW or name == plan_scene(scene)[1].plan.name]
    found = [ours(scene, plan) for plan in plans]
    peers = theirs(scene, found[0][0])
    seconds = interleave([kernel for kernel, *_ in found] + peers, rounds, length=2e-4).min(axis=0)
    best = len(found) + int(np.argmin(seconds[len(found) :]))
    peer = peers[best - len(found)]
    lines = []
    for (kernel, operations, built), time_ in zip(found, seconds, strict=False):
        own = kernel.u_dot[:, 2 : 2 + links]
        off = np.abs(own - peer.u_dot).max() / np.abs(own).max()
        cells = [str(links), kernel.name, str(operations), f"{1e9 * time_:.0f}", f"{built:.1f}"]
        cells += [f"{1e9 * seconds[best]:.0f}", peer.name, f"{time_ / seconds[best]:.2f}", f"{off:.0e}"]
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def main() -> None:
    """Measure every machine and print the table as it grows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cranks", type=int, nargs="+", default=(1, 2, 3), metavar="C", help="pairs of legs")
    parser.add_argument("--rounds", type=int, default=500, help="batches of 0.2 ms per kernel")
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    print(f"{machine()}, CasADi {casadi_loop.version()}\n")
    print("| " + " | ".join(HEADER) + " |\n|" + "---|" * len(HEADER), flush=True)
    for cranks in options.cranks:
        print("\n".join(rows(cranks, options.rounds)), flush=True)


if __name__ == "__main__":
    main()
