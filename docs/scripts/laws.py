"""Random rough loops on random grounds, each by every law of impact: how runs go by each (docs/events.md).

Loops, grounds and starts are drawn by tests/hard/fuzz.py, all of them rough.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ccgen.generator import generate
from ccgen.generator.effect_base.contact import LAWS
from ccgen.runtime import Model, load_model

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from tests.hard.fuzz import Toss, rise_of_energy, run, scene, tosses

HEADER = (
    "law",
    "runs",
    "reached their end",
    "runs with less restitution",
    "impacts with less restitution",
    "runs with time stepping",
    "median, s",
    "99 in 100, s",
    "energy rises by",
)


@dataclass(frozen=True)
class Figures:
    """What is kept of a run: how long it took (s), its impacts, how many of them had less restitution, whether it went
    on by time stepping, and the most that its energy rises by, in parts of that at the start."""

    seconds: float
    ended: bool
    impacts: int
    reduced: int
    stepped: bool
    rise: float


def figures(model: Model, toss: Toss) -> Figures:
    """Those of the run of a toss; a run that stops short is told on standard error."""
    began = time.perf_counter()
    found = run(model, toss)
    seconds = time.perf_counter() - began
    if not found.success:
        print(f"{toss}: {found.message}", file=sys.stderr)
    return Figures(
        seconds,
        found.success,
        len(found.impacts),
        sum(impact.restitution_share < 1.0 for impact in found.impacts),
        any(phase.kind == "steps" for phase in found.phases),
        rise_of_energy(found),
    )


def row(law: str, found: list[Figures]) -> str:
    """A line of the table."""
    impacts, seconds = sum(one.impacts for one in found), [one.seconds for one in found]
    cells = (
        law,
        str(len(found)),
        str(sum(one.ended for one in found)),
        str(sum(one.reduced > 0 for one in found)),
        f"{100 * sum(one.reduced for one in found) / max(1, impacts):.2g} % of {impacts:,}",
        str(sum(one.stepped for one in found)),
        f"{np.median(seconds):.2f}",
        f"{np.quantile(seconds, 0.99):.1f}",
        f"{max(one.rise for one in found):.0e}",
    )
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Print the table, a line for each law once all tosses have been thrown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int, nargs="?", default=100, metavar="COUNT", help="tosses, each by every law")
    parser.add_argument("--seed", type=int, default=0, help="draws others")
    options = parser.parse_args()
    drawn = list(tosses(options.count, options.seed, rough=True, law=LAWS[0]))
    print("| " + " | ".join(HEADER) + " |\n|" + "---|" * len(HEADER), flush=True)
    with tempfile.TemporaryDirectory() as folder:
        sizes = sorted({toss.n for toss in drawn})
        models = {n: load_model(generate(scene(n, rough=True), f"{folder}/loop{n}")) for n in sizes}
        for law in LAWS:
            print(row(law, [figures(models[toss.n], replace(toss, law=law)) for toss in drawn]), flush=True)


if __name__ == "__main__":
    main()
