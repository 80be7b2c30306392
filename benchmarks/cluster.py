"""A sweep by one worker of Dask beside the same in this process: what sending chunks costs in time.

Prints a markdown table; `python benchmarks/cluster.py --help` lists the options, README.md explains the rest.
"""

import argparse
import shutil
import statistics
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import distributed
from driver import ROOT, WORK
from machine import machine
from turns import in_turn

from ccgen.generator import generate, load_scene
from ccgen.runtime import Model, load_model
from ccgen.runtime.sweep.sweep import sweep


def make(model: Model, plan: dict[str, Any], out: Path, chunk: int, client: Any) -> None:
    """A sweep into a folder that is gone afterwards."""
    sweep(model, plan, out, threads=1, chunk=chunk, executor=client)
    shutil.rmtree(out)


def main() -> None:
    """Sweep falling hexagons here and by Dask in turn, and print the ratio of their times in each round."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=8000, help="drops of 1 s")
    parser.add_argument("--chunks", type=int, nargs="+", default=[1000], metavar="N", help="runs in a chunk")
    parser.add_argument("--rounds", type=int, default=8, help="pairs of sweeps, of which the median counts")
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    model = load_model(generate(load_scene(ROOT / "scenes" / "falling-hexagon.toml"), out=WORK / "models"))
    vary = [{"parameter": "gravity.g", "from": 5.0, "to": 12.0, "count": options.runs}]
    plan = {"observe": ["impacts"], "run": {"until": 1.0}, "vary": vary}
    cluster = distributed.LocalCluster(n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None)
    print(f"{machine()}, distributed {distributed.__version__}\n")
    print(
        "| runs in a chunk | here, s | by Dask, s | median of ratios | least, most |\n|---|---|---|---|---|", flush=True
    )
    with cluster, distributed.Client(cluster) as client, TemporaryDirectory() as folder:
        for chunk in options.chunks:
            calls = [
                partial(make, model, plan, Path(folder) / str(k), chunk, by) for k, by in enumerate((None, client))
            ]
            in_turn(calls, 1)  # the worker loads the model
            seconds = in_turn(calls, options.rounds)
            here, there = (statistics.median(column) for column in zip(*seconds, strict=True))
            ratios = [b / a for a, b in seconds]
            cells = f"{here:.2f} | {there:.2f} | {statistics.median(ratios):.2f} | {min(ratios):.2f}, {max(ratios):.2f}"
            print(f"| {chunk} | {cells} |", flush=True)


if __name__ == "__main__":
    main()
