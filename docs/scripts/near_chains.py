"""Operation counts of random near-chains, by the plan that is taken and by others on other trees (docs/counts.md).

With ``--run`` instead the milliseconds of runs by either plan, of models that are built for it.
"""

from __future__ import annotations

import argparse
import random
import tempfile
import time

import numpy as np

from ccgen.generator import Scene, generate
from ccgen.generator.derive.derivation import derive
from ccgen.generator.mechanism.mechanism import Mechanism
from ccgen.generator.mechanism.topology import Topology, hang, span
from ccgen.generator.pipeline import derive_scene, plan_scene
from ccgen.generator.planning.choose import DYADS, TIP_TO_ROOT, choose
from ccgen.generator.program.program import lower
from ccgen.generator.scene import read_tables
from ccgen.runtime import load_model, simulate

HEADER = (
    "n",
    "seed",
    "taken",
    "short branches",
    "dyads on it",
    "random trees",
    "dyads on others",
    "taken / fewest",
    "of all",
)
SEEDS = {40: (1, 2, 3, 4, 5), 80: (2, 3, 6, 7, 10)}
"""Those whose joints do not hold one another."""

COMPARED = (TIP_TO_ROOT, DYADS)
"""Plans that near-chains have: their rows are too short for segments."""

TEMPERATURE = 0.02
"""Share of its operations that a tree may be worse by, at first, and still be gone on from."""


def near_chain(links: int, seed: int) -> Scene:
    """A row of links, and pins between links of it that are three to eight apart, one for every four links."""
    rng = np.random.default_rng(seed)
    edges = [(k, k + 1) for k in range(links - 1)]
    while len(edges) < links - 1 + links // 4:
        a, b = sorted(int(x) for x in rng.integers(links, size=2))
        if 3 <= b - a <= 8 and (a, b) not in edges:
            edges.append((a, b))
    drawn = rng.uniform(-0.8, 0.8, (len(edges), 2)).tolist()
    tables = {
        "link": [
            {
                "name": f"link{k}",
                "mass": 1.0,
                "inertia": 0.1,
                "com": rng.uniform(-0.5, 0.5, 2).tolist(),
                "points": {f"P{j}": drawn[j] for j, edge in enumerate(edges) if k in edge},
            }
            for k in range(links)
        ],
        "joint": [{"between": [f"link{a}.P{j}", f"link{b}.P{j}"]} for j, (a, b) in enumerate(edges)],
        "start": {"angles": [0.0] * links},
    }
    return read_tables(tables, "near-chain", f"near_chain{links}_{seed}")


def operations(scene: Scene, topology: Topology, plan: str) -> int:
    """Of the acceleration and the multipliers, with all dyads closed where the plan closes dyads."""
    found = choose(scene.mechanism, topology, (), [cut.joint for cut in topology.cuts], plan).plan
    return lower(derive(scene.mechanism, topology, found, scene.effects)).function("acceleration").counts().total


def fewest(scene: Scene, plan: str, tries: int) -> Topology:
    """The tree with the fewest operations by the pattern, of ``tries``: joints exchanged and roots moved at random."""
    rng, mechanism = random.Random(0), scene.mechanism
    tree = best = plan_scene(scene)[0]
    cost = least = _pattern(mechanism, tree, plan)
    for number in range(tries):
        other = _changed(mechanism, tree, rng)
        found = _pattern(mechanism, other, plan)
        if found < cost * (1.0 + TEMPERATURE * (1.0 - number / tries) * rng.expovariate(1.0)):
            tree, cost = other, found
        if found < least:
            best, least = other, found
    return best


def _pattern(mechanism: Mechanism, tree: Topology, plan: str) -> float:
    sound = [cut.joint for cut in tree.cuts] if plan == DYADS else []
    return dict(choose(mechanism, tree, (), sound).costs).get(plan, float("inf"))


def _changed(mechanism: Mechanism, tree: Topology, rng: random.Random) -> Topology:
    """One cut joint goes into the tree for another on its loop, and one time in five the root goes elsewhere."""
    kept = {branch.joint for branch in tree.branches}
    cut = rng.choice(tree.cuts)
    way = {k for side in (cut.first.link, cut.second.link) for k in tree.path(side)}
    way -= set(tree.path(cut.meeting))
    joint = rng.choice(sorted(branch.joint for branch in tree.branches if branch.link in way))
    root = rng.randrange(len(mechanism.links)) if rng.random() < 0.2 else tree.root
    return hang(mechanism, root, kept - {joint} | {cut.joint}, tree.implied)


def row(links: int, seed: int, tries: int) -> str:
    """A line of the table: counts of what is written, not of the pattern."""
    scene = near_chain(links, seed)
    short = span(scene.mechanism)
    taken = lower(derive_scene(scene)[1]).function("acceleration").counts().total
    counts = [taken, operations(scene, short, TIP_TO_ROOT), operations(scene, short, DYADS)]
    counts += [operations(scene, fewest(scene, plan, tries), plan) for plan in COMPARED]
    ratios = [f"{taken / min(taken, counts[1], counts[3]):.2f}", f"{taken / min(counts):.2f}"]
    return "| " + " | ".join(map(str, (links, seed, *counts, *ratios))) + " |"


def runs(scene: Scene, folder: str, until: float = 20.0, rounds: int = 8) -> str:
    """A line for each plan and start: the least milliseconds of a run without forces, and its evaluations."""
    models = [load_model(generate(scene, out=f"{folder}/{plan.replace(' ', '_')}", plan=plan)) for plan in COMPARED]
    lines = []
    for start in range(3):
        rates = np.random.default_rng(start).normal(size=len(scene.mechanism.links))
        least, calls = [float("inf")] * len(models), [0] * len(models)
        for _ in range(rounds):
            for number, model in enumerate(models):
                q, u = model.start()
                u[[name.startswith("w_") for name in model.u_names]] = rates
                began = time.perf_counter()
                run = simulate(model, q, u, until=until)
                least[number] = min(least[number], time.perf_counter() - began)
                calls[number] = run.nfev
        found = zip(COMPARED, least, calls, strict=True)
        told = [f"{plan} {1e3 * seconds:.1f} ms, {nfev} evaluations" for plan, seconds, nfev in found]
        lines.append(f"{scene.package}, start {start}: " + "; ".join(told))
    return "\n".join(lines)


def main() -> None:
    """Print the table as it grows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--links", type=int, nargs="+", default=tuple(SEEDS), metavar="N")
    parser.add_argument("--seeds", type=int, nargs="+", metavar="S", help="others than those of the table")
    parser.add_argument("--tries", type=int, default=200, help="random trees for each plan")
    parser.add_argument("--run", action="store_true", help="times of runs instead")
    options = parser.parse_args()
    if not options.run:
        print("| " + " | ".join(HEADER) + " |\n|" + "---|" * len(HEADER), flush=True)
    for links in options.links:
        for seed in options.seeds or SEEDS.get(links, (1, 2, 3, 4, 5)):
            if options.run:
                with tempfile.TemporaryDirectory() as folder:
                    print(runs(near_chain(links, seed), folder), flush=True)
            else:
                print(row(links, seed, options.tries), flush=True)


if __name__ == "__main__":
    main()
