"""Seconds from a description of W(n) to a compiled model: stage by stage, and as a whole process; and what part of the
quickest of these the look at a package takes, which every loading of a model begins with.

Prints a markdown table; `python benchmarks/build_time.py --help` lists the options, README.md explains the rest.
"""

import argparse
import os
import subprocess
import sys
import time
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

from machine import machine

from ccgen.generator import generate, loop
from ccgen.runtime.loading.package import read_package

SIZES = (6, 24, 96, 192)
STAGES = ("derive", "write", "compile")
HEADER = ("n", *STAGES, "sum", "whole process, cold", "cached", "look at a package / cached")


def stages(n: int, folder: Path) -> dict[str, float]:
    """Seconds of each stage that `generate` names, in this process, with an empty cache."""
    os.environ["CCGEN_CACHE_DIR"] = str(folder / "cache")
    begun: dict[str, float] = {}

    def note(stage: str) -> None:
        begun[stage] = time.perf_counter()

    generate(loop(n), out=folder / "build", progress=note)
    note("done")
    return {stage: end - start for (stage, start), (_, end) in pairwise(begun.items())}


def processes(n: int, folder: Path) -> tuple[float, float]:
    """Seconds of `ccgen --links n` as a process: with an empty cache, and into a new folder with the cache it left."""
    environment = os.environ | {"CCGEN_CACHE_DIR": str(folder / "cache")}
    command = [sys.executable, "-c", "from ccgen.generator.cli import main; main()", "--links", str(n)]
    seconds = []
    for out in ("cold", "cached"):
        start = time.perf_counter()
        subprocess.run([*command, "--out", out], check=True, cwd=folder, env=environment, stdout=subprocess.DEVNULL)
        seconds.append(time.perf_counter() - start)
    return seconds[0], seconds[1]


def look(n: int, folder: Path) -> float:
    """Seconds in which the package that `processes` left is found whole: the least of 50 times."""
    package = folder / "cached" / f"loop{n}"
    seconds = []
    for _ in range(50):
        start = time.perf_counter()
        read_package(package)
        seconds.append(time.perf_counter() - start)
    return min(seconds)


def row(n: int, repeats: int) -> str:
    """One line of the table: for every figure the fastest of the repeats, each with folders of its own."""
    runs = []
    for _ in range(repeats):
        with TemporaryDirectory() as inside, TemporaryDirectory() as outside:
            split = stages(n, Path(inside))
            named = [split[stage] for stage in STAGES]
            runs.append([*named, sum(split.values()), *processes(n, Path(outside)), look(n, Path(outside))])
    *seconds, cached, looked = (min(figures) for figures in zip(*runs, strict=True))
    return (
        "| "
        + " | ".join([str(n), *(f"{figure:.2f}" for figure in (*seconds, cached)), f"{looked / cached:.4f}"])
        + " |"
    )


def main() -> None:
    """Measure every size and print the table as it grows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--links", type=int, nargs="+", default=SIZES, metavar="N", help="sizes of the loop")
    parser.add_argument("--repeats", type=int, default=3, help="builds of each size, of which the fastest counts")
    options = parser.parse_args()
    row(3, repeats=1)  # imports and byte code
    print(f"{machine()}\n")
    print("| " + " | ".join(HEADER) + " |\n|" + "---|" * len(HEADER), flush=True)
    for n in options.links:
        print(row(n, options.repeats), flush=True)


if __name__ == "__main__":
    main()
