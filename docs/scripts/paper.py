"""The study that ccgen started from, by one command: six links in a ring, in flight and impact (docs/paper.md).

The falling hexagon by ccgen; the same one by a physics engine, where the paper takes a program for engineers;
operations of four formulations for growing n. Prints tables and writes the chart; `--write` also puts the tables into
the page. Other formulations are those of docs/data/formulations.csv unless `--derive` asks for them anew (ten minutes).
"""

from __future__ import annotations

import argparse
import csv
import math
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import counts
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Sheet
from matplotlib.ticker import NullFormatter, ScalarFormatter

from ccgen.generator import Scene, generate, load_scene, loop
from ccgen.runtime import Model, Run, load_model, simulate

DOCS = Path(__file__).parents[1]
sys.path.insert(0, str(DOCS.parent / "benchmarks"))
import engine_audits  # noqa: E402
import engine_cases  # noqa: E402
import formulations  # noqa: E402
import linkage  # noqa: E402
import pymunk_linkage  # noqa: E402

SCENE = DOCS.parent / "scenes" / "falling-hexagon.toml"
PAGE, CHART, DATA = DOCS / "paper.md", DOCS / "images" / "paper.png", DOCS / "data" / "formulations.csv"
MARKS = ("<!-- figures -->\n", "<!-- end of figures -->\n")
UNTIL, RTOL, RESTITUTION = 1.0, 1e-10, 0.5
STEPS, ITERATIONS = (1e-2, 1e-3, 1e-4), (10, 100)
"""Steps (s) of the engine and iterations of its solver, of which the first is its default."""
CHOSEN = (1e-3, 100)
"""What the chart has the heights of."""


@dataclass(frozen=True)
class Beside:
    """The engine at one step (s) and number of iterations.

    Times (t,), heights of the joints (t, 6) by it and by ccgen, the largest gap of a joint (m), how far its energy is
    off at the end (J), impacts missed, and how late or early the others are (s).
    """

    step: float
    iterations: int
    times: Any
    theirs: Any
    ours: Any
    gap: float
    energy: float
    missed: int
    late: float

    def apart(self, until: float) -> float:
        """The largest difference of a height (m) until a time (s)."""
        seen = self.times <= until + 1e-12
        return float(np.max(np.abs(self.theirs - self.ours)[seen]))


def first_impulse(height: float, gravity: float, restitution: float, mass: float = 1.0) -> float:
    """Impulse (N s) of a ring of six equal rods that falls on a corner: 11/10 (1 + e) m √(2 g h)."""
    return 1.1 * (1.0 + restitution) * mass * math.sqrt(2.0 * gravity * height)


def impacts(run: Run) -> str:
    """A line for every impact."""
    lines = [
        "| impact | t, s | joints | speed before, m/s | impulse each, N s | energy lost, J |",
        "|---|" + "---:|" * 5,
    ]
    for number, one in enumerate(run.impacts, 1):
        joints = ", ".join(point.rpartition("_")[2] for point, _ in one.contacts)
        q = run.q[int(np.flatnonzero(run.t == one.t)[0])]
        speed = float(run.model.gap_rates(q, one.u_minus)[int(joints.split(",")[0])])
        lines.append(
            f"| {number} | {one.t:.10f} | {joints} | {speed:.6f} | {one.impulses[0]:.6f} | {one.energy_loss:.6f} |"
        )
    return "\n".join(lines)


def beside(model: Model, scene: Scene, run: Run, step: float, iterations: int) -> Beside:
    """pymunk with the same ring."""
    ring = linkage.of_model(model, scene, corners=True, restitution=RESTITUTION)
    states = pymunk_linkage.start(ring, step, iterations)(round(UNTIL / step), 1)
    times = step * np.arange(1, len(states) + 1)
    known = engine_cases.strikes_of(run)
    missed, late = engine_audits.compare(engine_audits.strikes(ring, states, step), known)
    q, _ = run.at(np.minimum(times, run.t[-1]))
    heights = model.gaps(q)
    off = abs(float(engine_audits.energy(ring, states[-1]) - np.sum(model.energy(run.q[-1], run.u[-1]))))
    gap = engine_audits.gap(ring, states)
    return Beside(step, iterations, times, engine_audits.heights(ring, states), heights, gap, off, missed, late)


def engine_table(found: Sequence[Beside], run: Run) -> str:
    """A line for every step and number of iterations."""
    heads = "| iterations | step, s | heights off before the first impact, m | to the end, m "
    heads += "| joints open, m | energy off at the end, J "
    lines = [heads + "| impacts missed | late, s |", "|---|" + "---:|" * 7]
    first = float(run.impacts[0].t)
    for one in found:
        before = one.apart(first - one.step)
        lines.append(
            f"| {one.iterations} | {one.step:.0e} | {before:.0e} | {one.apart(UNTIL):.0e} | {one.gap:.0e} "
            f"| {one.energy:.0e} | {one.missed} of {sum(len(i.contacts) for i in run.impacts)} | {one.late:.0e} |"
        )
    return "\n".join(lines)


def derived(anew: bool) -> list[formulations.Figure]:
    """Operations of loops by all formulations: those of ccgen counted now, the others read unless asked for anew.

    Raises ``ValueError`` where the data has other counts of ccgen than it has now.
    """
    if anew:
        sizes = [n for n in formulations.SIZES if n >= formulations.FEWEST["loop"]]
        tried = [(name, n) for name in formulations.TITLES for n in sizes]
        return [f for name, n in tried if (f := formulations.derive(name, "loop", n, formulations.LIMIT)) is not None]
    found = []
    with DATA.open(newline="") as file:
        for line in csv.DictReader(file):
            if line["family"] != "loop":
                continue
            numbers = {key: int(line[key]) for key in ("links", "equations", "solve", "angles")}
            one = formulations.Figure(
                line["formulation"], "loop", seconds=float(line["seconds"]), error=float(line["error"]), **numbers
            )
            found.append(one)
            if one.formulation == "recursive":
                now = counts.acceleration(loop(one.links, gravity=True), "tip to root")
                if now != one.operations:
                    raise ValueError(f"{DATA.name}: found {one.operations} operations of {one.links} links, now {now}")
    return found


def count_table(figures: Sequence[formulations.Figure]) -> str:
    """Operations of every formulation for growing n, and how they grow."""
    lines = [
        "| links | " + " | ".join(formulations.TITLES.values()) + " |",
        "|---:|" + "---:|" * len(formulations.TITLES),
    ]
    known = {(f.formulation, f.links): str(f.operations) for f in figures}
    for n in sorted({f.links for f in figures}):
        lines.append(f"| {n} | " + " | ".join(known.get((name, n), "–") for name in formulations.TITLES) + " |")
    slopes = []
    for name in formulations.TITLES:
        slope = formulations.exponent([f for f in figures if f.formulation == name], "operations")
        slopes.append("–" if slope is None else f"$n^{{{slope:.2f}}}$")
    return "\n".join([*lines, "| grows as | " + " | ".join(slopes) + " |"])


def draw(run: Run, found: Sequence[Beside], figures: Sequence[formulations.Figure], path: Path) -> None:
    """Heights of the joints by ccgen and the engine, how far they are apart, operations over n."""
    sheet = Sheet(figsize=(11.0, 8.2), dpi=110, facecolor="white", layout="constrained")
    FigureCanvasAgg(sheet)
    (heights, energy), (apart, operations) = sheet.subplots(2, 2)
    times = np.linspace(0.0, UNTIL, 800)
    q, u = run.at(times)
    shade = ("#1b6ca8", "#c2571a", "#4d8b31", "#7b4ea3")
    gaps = run.model.gaps(q)
    for joint in range(4):  # the other two mirror 1 and 2
        heights.plot(times, gaps[:, joint], color=shade[joint], linewidth=1.4, label=f"joint {joint}")
    chosen = next((one for one in found if (one.step, one.iterations) == CHOSEN), None)
    if chosen is not None:
        some = slice(None, None, 20)
        for joint in range(4):
            heights.plot(chosen.times[some], chosen.theirs[some, joint], ".", color=shade[joint], markersize=4)
        heights.plot([], [], ".", color="#555555", label=f"pymunk, {CHOSEN[1]} iterations, {1e3 * CHOSEN[0]:g} ms")
    heights.set(title="Heights of the joints", xlabel="t  [s]", ylabel="m")
    kinetic, potential = run.model.energy(q, u)
    for values, name, colour in ((kinetic, "kinetic", shade[1]), (potential, "potential", shade[2])):
        energy.plot(times, values, color=colour, linewidth=1.2, label=name)
    energy.plot(times, kinetic + potential, color="#222222", linewidth=1.8, label="sum")
    energy.set(title="Energy: level in flight, steps at impacts", xlabel="t  [s]", ylabel="J")
    for one in found:
        colour, line = shade[STEPS.index(one.step)], "--" if one.iterations == ITERATIONS[0] else "-"
        off = np.max(np.abs(one.theirs - one.ours), axis=1)
        label = f"{one.iterations} iterations, {1e3 * one.step:g} ms"
        apart.semilogy(one.times, np.maximum(off, 1e-6), line, color=colour, linewidth=1.2, label=label)
    title = "Largest difference of a height, pymunk to ccgen" if found else "pymunk is not installed"
    apart.set(title=title, xlabel="t  [s]", ylabel="m")
    for name, called in formulations.TITLES.items():
        own = [f for f in figures if f.formulation == name]
        look = {"color": formulations.COLOURS[name], "marker": formulations.MARKS[name]}
        operations.loglog([f.links for f in own], [f.operations for f in own], label=called, **look)
    operations.set(title="Operations per evaluation, closed loops", xlabel="links n")
    operations.set_xticks(sorted({f.links for f in figures}))
    operations.xaxis.set_major_formatter(ScalarFormatter())
    operations.xaxis.set_minor_formatter(NullFormatter())
    for axes in (heights, energy, apart, operations):
        axes.grid(True, which="major", color="#e6e6e6", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(frameon=False, fontsize=8)
    sheet.savefig(path, metadata={"Software": None})


def page(text: str, tables: str) -> str:
    """The page with tables between its marks."""
    before, _, rest = text.partition(MARKS[0])
    _, _, after = rest.partition(MARKS[1])
    return f"{before}{MARKS[0]}{tables}\n{MARKS[1]}{after}"


def main() -> None:
    """Run the ring, run it by the engine, count, draw."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--chart", type=Path, default=CHART)
    arguments.add_argument("--derive", action="store_true", help="derive the other formulations anew: ten minutes")
    arguments.add_argument("--write", action="store_true", help="put the tables into docs/paper.md")
    asked = arguments.parse_args()
    scene = load_scene(SCENE)
    with tempfile.TemporaryDirectory() as folder:
        model = load_model(generate(scene, folder))
        run = simulate(model, until=UNTIL, rtol=RTOL)
        exact = first_impulse(1.0, 9.81, RESTITUTION)
        parts = [
            impacts(run),
            f"Closed form of the first impulse: {exact:.10f} N s, found {run.impacts[0].impulses[0]:.10f} N s. "
            f"Loops closed to {run.closure_max:.0e} m, energy kept to {run.energy_drift:.0e} J of 117.72 J.",
        ]
        found: list[Beside] = []
        try:
            found = [beside(model, scene, run, step, count) for count in ITERATIONS for step in STEPS]
            parts += [engine_table(found, run)]
        except ImportError as missing:
            parts += [f"Left out: pymunk ({missing}); pip install 'ccgen[engines]'"]
        figures = derived(asked.derive)
        parts += [count_table(figures)]
        print("\n\n".join(parts))
        draw(run, found, figures, asked.chart)
    if asked.write:
        PAGE.write_text(page(PAGE.read_text(), "\n\n".join(parts)))


if __name__ == "__main__":
    main()
