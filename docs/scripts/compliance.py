"""What a ground that gives way costs beside a rigid one, and how far off it is: table and chart of docs/accuracy.md.

The falling hexagon on its corner to 0.5 s: its first impact, without and with a time of contact. A linear spring beside
a rigid ground that loses nothing, and Hertz's law with the damping of Lankarani and Nikravesh at e = 0.5 beside a rigid
one with the restitution that follows from it (docs/theory.md, section 5.12). `--chart PATH` writes the chart elsewhere,
`--decades N` takes the first N stiffnesses.
"""

from __future__ import annotations

import argparse
import math
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from scipy.optimize import brentq

from ccgen.generator import Scene, generate, loop
from ccgen.runtime import Model, Run, load_model, simulate

ROOT = Path(__file__).parents[2]
CHART = ROOT / "docs" / "images" / "compliance.png"
UNTIL, RTOL, REPEATS = 0.5, 1e-9, 50
STIFFNESS = (1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10)
"""N/m at a depth of 1 mm, for 6 kg."""
DEPTH, LOST = 1e-3, 0.5
SPRING, HERTZ = "linear, nothing lost", "Hertz, Lankarani–Nikravesh, e = 0.5"


@dataclass(frozen=True)
class Row:
    """A run on one ground beside the run on the rigid one: relative time, and what velocities are off by (m/s)."""

    law: str
    stiffness: float
    rows: int
    time: float
    off: float
    energy: float


def scene(**ground: object) -> Scene:
    """The hexagon above a ground."""
    return loop(6, gravity=True, start={"height": 1.0}, **ground)


def effective(e: float) -> float:
    """Restitution that their damping leaves: χ(1 + ε) = ln((1 + χ)/(1 − χε)), χ = ¾(1 − e²)."""
    chi = 0.75 * (1.0 - e * e)
    return float(brentq(lambda r: chi * (1 + r) - math.log((1 + chi) / (1 - chi * r)), 1e-6, 1.0))


def timed(model: Model, params: dict[str, float] | None = None) -> tuple[Run, float]:
    """A run, and the least seconds of many."""
    least = float("inf")
    for _ in range(REPEATS):
        began = time.perf_counter()
        run = simulate(model, until=UNTIL, rtol=RTOL, params=params)
        least = min(least, time.perf_counter() - began)
    return run, least


def measure(decades: int) -> Iterator[Row]:
    """Every ground, the rigid one first, with a stiffness that is infinite."""
    laws = {
        SPRING: (1.0, {"exponent": 1.0}),
        HERTZ: (effective(LOST), {"exponent": 1.5, "restitution": LOST}),
    }
    with tempfile.TemporaryDirectory() as folder:
        for number, (law, (restitution, keys)) in enumerate(laws.items()):
            hard = scene(ground=[{"restitution": restitution}])
            soft = scene(compliant_ground=[{"load": 1.0, "depth": DEPTH, **keys}])
            rigid = load_model(generate(hard, Path(folder) / f"rigid_{number}"))
            model = load_model(generate(soft, Path(folder) / f"soft_{number}"))
            reference, seconds = timed(rigid)
            yield Row(law, math.inf, len(reference.t), 1.0, 0.0, reference.energy_drift)
            for stiffness in STIFFNESS[:decades]:
                run, own = timed(model, {"compliant_ground_0.load": stiffness * DEPTH})
                off = float(np.abs(run.u[-1] - reference.u[-1]).max())
                yield Row(law, stiffness, len(run.t), own / seconds, off, run.energy_drift)


def draw(rows: list[Row], path: Path) -> None:
    """Distance to the rigid run and time relative to it, over stiffness."""
    figure = Figure(figsize=(7.5, 6.0), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    above, below = figure.subplots(2, 1, sharex=True)
    for law, marker, colour in ((SPRING, "o", "#1f77b4"), (HERTZ, "s", "#d62728")):
        own = [row for row in rows if row.law == law and math.isfinite(row.stiffness)]
        x = [row.stiffness for row in own]
        above.loglog(x, [row.off for row in own], marker=marker, color=colour, markersize=4.5, label=law)
        below.semilogx(x, [row.time for row in own], marker=marker, color=colour, markersize=4.5)
    below.axhline(1.0, color="#888888", linewidth=0.8)
    above.set_ylabel("velocities off the rigid run by  [m/s]")
    below.set_ylabel("time of the rigid run")
    below.set_xlabel("stiffness at a depth of 1 mm  [N/m]")
    below.set_ylim(bottom=0.0)
    for axes in (above, below):
        axes.grid(True, which="major", color="#e6e6e6", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
    above.legend(frameon=False)
    figure.savefig(path, metadata={"Software": None})


def main() -> None:
    """Print the table and write the chart."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--chart", type=Path, default=CHART)
    arguments.add_argument("--decades", type=int, default=len(STIFFNESS))
    asked = arguments.parse_args()
    rows = list(measure(asked.decades))
    print(
        "| law | stiffness, N/m | rows | time | velocities off by, m/s | energy off by, J |\n|---|---|---|---|---|---|"
    )
    for row in rows:
        rigid = math.isinf(row.stiffness)
        name, off = ("rigid", "–") if rigid else (f"{row.stiffness:.0e}", f"{row.off:.0e}")
        print(f"| {row.law} | {name} | {row.rows} | {row.time:.1f} | {off} | {row.energy:.0e} |")
    draw(rows, asked.chart)


if __name__ == "__main__":
    main()
