"""Operation counts of the generated functions (docs/counts.md)."""

from __future__ import annotations

import argparse
import math
import tempfile
from pathlib import Path
from typing import Any

import strandbeest

from ccgen.generator import Scene, chain, load_scene, loop, pinned
from ccgen.generator.pipeline import derive_scene
from ccgen.generator.program.program import Program, lower
from ccgen.generator.scene import read_tables

SIZES = (4, 6, 8, 16, 32, 64)


def program(scene: Scene, plan: str | None = None) -> Program:
    return lower(derive_scene(scene, plan=plan)[1])


def acceleration(scene: Scene, plan: str | None = None) -> int:
    return program(scene, plan).function("acceleration").counts().total


def walking(cranks: int) -> Scene:
    """The Strandbeest of scenes/strandbeest.toml with this many cranks, two legs on each."""
    phases = [2.0 * math.pi * k / cranks for k in range(cranks)]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "walking.toml"
        path.write_text(strandbeest.text(phases))
        return load_scene(path)


def ladder(cells: int) -> Scene:
    """A row of four-bars: uprights on the ground, each joined to the next by a bar."""
    rod = {"mass": 1.0, "inertia": 1.0 / 12.0, "com": [0.5, 0.0], "points": {"A": [0.0, 0.0], "B": [1.0, 0.0]}}
    names = [f"upright{i}" for i in range(cells + 1)] + [f"bar{i}" for i in range(1, cells + 1)]
    joints: list[dict[str, Any]] = [{"between": [f"ground.A{i}", f"upright{i}.A"]} for i in range(cells + 1)]
    for i in range(1, cells + 1):
        joints += [{"between": [f"upright{i - 1}.B", f"bar{i}.A"]}, {"between": [f"bar{i}.B", f"upright{i}.B"]}]
    tables = {
        "ground_link": {"points": {f"A{i}": [float(i), 0.0] for i in range(cells + 1)}},
        "link": [{"name": name, **rod} for name in names],
        "joint": joints,
        "start": {"angles": [1.2] * (cells + 1) + [0.0] * cells},
    }
    return read_tables(tables, "ladder", f"ladder{cells}")


def tree(depth: int) -> Scene:
    """Four-bars that hang from each other: the coupler of each carries two further ones, so many levels of them."""
    angles = {"crank": 1.2, "coupler": 0.0, "rocker": 1.2}
    links: list[dict[str, Any]] = []
    joints: list[dict[str, Any]] = []
    carriers = [("ground.C", "ground.D")]
    for level in range(1, depth + 1):
        hanging = carriers
        carriers = []
        for i, (left, right) in enumerate(hanging):
            crank, coupler, rocker = names = [f"{kind}{level}_{i}" for kind in angles]
            rod = {"mass": 1.0, "inertia": 1.0 / 12.0, "com": [0.5, 0.0]}
            for name in names:
                points = {"A": [0.0, 0.0], "B": [1.0, 0.0]}
                if name == coupler and level < depth:
                    points |= {"C": [0.0, 0.2], "D": [1.0, 0.2], "E": [0.0, -0.2], "F": [1.0, -0.2]}
                links.append({"name": name, **rod, "points": points})
            pairs = [(left, f"{crank}.A"), (f"{crank}.B", f"{coupler}.A"), (f"{coupler}.B", f"{rocker}.B")]
            joints += [{"between": list(pair)} for pair in [*pairs, (right, f"{rocker}.A")]]
            carriers += [(f"{coupler}.C", f"{coupler}.D"), (f"{coupler}.E", f"{coupler}.F")]
    tables = {
        "ground_link": {"points": {"C": [0.0, 0.0], "D": [1.0, 0.0]}},
        "link": links,
        "joint": joints,
        "start": {"angles": [*angles.values()] * (len(links) // 3)},
    }
    return read_tables(tables, "tree", f"tree{depth}")


def main() -> None:
    """Print the tables, of fewer sizes where that is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--links", type=int, nargs="+", default=SIZES, metavar="N", help="rods of chains and rings")
    parser.add_argument(
        "--long", type=int, nargs="+", default=(25, 49, 97, 193), metavar="N", help="rods of long rings"
    )
    parser.add_argument(
        "--cells", type=int, nargs="+", default=(1, 2, 4, 8, 16, 32), metavar="N", help="four-bars in a row"
    )
    parser.add_argument(
        "--depths", type=int, nargs="+", default=(1, 2, 3, 4, 5), metavar="D", help="of trees of four-bars"
    )
    parser.add_argument("--cranks", type=int, nargs="*", default=(1, 2, 3, 4), metavar="C", help="of walking machines")
    options = parser.parse_args()
    print("functions of the falling hexagon, six links (sums + products + quotients = operations; sines with cosines)")
    hexagon = loop(6, gravity=True, start={"height": 1.0}, ground=[{"restitution": 0.5}])
    for function in program(hexagon).functions:
        c = function.counts()
        print(f"{function.kernel.name:17} {c.sums:4} + {c.products:4} + {c.quotients:2} = {c.total:4};  {c.angles}")
    print("\noperations of the acceleration")
    print("links   floating  open  hinged  pinned, from tip to root")
    for n in options.links:
        scenes = (loop(n), chain(n), chain(n, hinged=True), pinned(n))
        totals = [acceleration(scene, "tip to root") for scene in scenes]
        print(f"{n:5} {totals[0]:10} {totals[1]:5} {totals[2]:7} {totals[3]:7}")
    print("\nfloating loops in four segments, and from tip to root")
    for n in options.long:
        for plan in ("segments", "tip to root"):
            function = program(loop(n), plan).function("acceleration")
            print(f"{n:5} {plan:12} {function.counts().total:6}, longest chain {function.longest_chain()}", flush=True)
    print("\nrow of N four-bars, and by dyads")
    for cells in options.cells:
        scene = ladder(cells)
        print(f"N = {cells:2}, {2 * cells + 1:2} links: {acceleration(scene)}, {acceleration(scene, 'dyads')}")
    print("\ntrees of four-bars by the chosen plan, from tip to root, and by dyads")
    for depth in options.depths:
        scene = tree(depth)
        totals = [acceleration(scene, plan) for plan in (None, "tip to root", "dyads")]
        print(f"depth {depth}, {len(scene.mechanism.links):2} links: {totals[0]}, {totals[1]}, {totals[2]}", flush=True)
    print("\nwalking machines, and from tip to root (minutes)")
    for cranks in options.cranks:
        scene = walking(cranks)
        links = len(scene.mechanism.links)
        print(f"{cranks} cranks, {links} links: {acceleration(scene)}", flush=True)
        print(f"    from tip to root: {acceleration(scene, 'tip to root')}", flush=True)


if __name__ == "__main__":
    main()
