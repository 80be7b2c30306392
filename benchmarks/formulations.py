"""What recursion buys: operations and derivation seconds of four formulations of the same equations of motion.

Recursive Gibbs-Appell as ccgen has it, the dense closed form, SymPy's KanesMethod and SymPy's LagrangesMethod, for
chains and loops of n rods. Prints markdown tables; `--write` also puts them, a CSV file and the plot into docs/.
`python benchmarks/formulations.py --help` lists the options, docs/formulations.md explains the figures.
"""

import argparse
import csv
import json
import os
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from derivations import OVER
from machine import machine
from rods import FEWEST

SIZES = (2, 3, 4, 6, 8, 12, 16, 24)
LIMIT = 60.0
QUICK, REPEATS = 5.0, 3
"""A derivation of fewer seconds is repeated, each time in a process of its own, and the fastest counts."""
TAIL = 4
"""Exponents are fitted to so many of the largest sizes."""
TITLES = {
    "recursive": "recursive Gibbs–Appell",
    "closed_form": "dense closed form",
    "kane": "SymPy KanesMethod",
    "lagrange": "SymPy LagrangesMethod",
}
FAMILIES = {"chain": "Open chain, hinged", "loop": "Closed loop, floating"}
COLOURS = {"recursive": "#1b6ca8", "closed_form": "#5a5a5a", "kane": "#c2571a", "lagrange": "#4d8b31"}
MARKS = {"recursive": "o", "closed_form": "s", "kane": "^", "lagrange": "v"}
DOCS = Path(__file__).parents[1] / "docs"


@dataclass(frozen=True)
class Figure:
    """One derivation: operations of the equations and of the solve that follows, pairs of sines and cosines, error."""

    formulation: str
    family: str
    links: int
    seconds: float
    equations: int
    solve: int
    angles: int
    error: float

    @property
    def operations(self) -> int:
        return self.equations + self.solve


def derive(formulation: str, family: str, n: int, limit: float, repeats: int) -> Figure | None:
    """One derivation in processes of its own; ``None`` when it takes longer than ``limit`` seconds."""
    script = Path(__file__).with_name("derivations.py")
    command = [sys.executable, str(script), formulation, family, str(n), str(limit)]
    found: list[Figure] = []
    while len(found) < repeats and (not found or found[0].seconds < QUICK):
        environment = os.environ | {"PYTHONHASHSEED": "0"}
        done = subprocess.run(command, check=False, capture_output=True, text=True, env=environment)
        if done.returncode == OVER:
            return None
        if done.returncode:
            raise RuntimeError(f"{formulation} of {family} {n} failed:\n{done.stderr}")
        found.append(Figure(formulation, family, n, **json.loads(done.stdout)))
    return min(found, key=lambda figure: figure.seconds)


def exponent(figures: Sequence[Figure], quantity: str) -> float | None:
    """Slope of a quantity over n, both logarithmic, by least squares over the tail; ``None`` of fewer than three."""
    tail = figures[-TAIL:]
    if len(tail) < 3:
        return None
    logs = np.log([[figure.links, getattr(figure, quantity)] for figure in tail])
    return float(np.polyfit(logs[:, 0], logs[:, 1], 1)[0])


def table(family: str, sizes: Sequence[int], figures: Sequence[Figure], limit: float) -> str:
    """Operations and seconds of one family as markdown."""
    lines = [
        f"| {FAMILIES[family]}, n | " + " | ".join(f"{title}, operations | s" for title in TITLES.values()) + " |",
        "|---:|" + "---:|---:|" * len(TITLES),
    ]
    mine = {(f.formulation, f.links): f for f in figures if f.family == family}
    for n in (size for size in sizes if size >= FEWEST[family]):
        cells = []
        for name in TITLES:
            f = mine.get((name, n))
            split = f"{f.equations} + {f.solve} = {f.operations}" if f and f.solve else str(f.operations if f else "–")
            cells += [split, f"{f.seconds:.2f}" if f else f"> {limit:.0f}"]
        lines.append(f"| {n} | " + " | ".join(cells) + " |")
    slopes = []
    for name in TITLES:
        own = [f for f in figures if f.family == family and f.formulation == name]
        slopes += [_power(exponent(own, "operations")), _power(exponent(own, "seconds"))]
    return "\n".join([*lines, "| grows as | " + " | ".join(slopes) + " |"])


def _power(slope: float | None) -> str:
    return "–" if slope is None else f"$n^{{{slope:.2f}}}$"


def draw(figures: Sequence[Figure], path: Path) -> None:
    """Operations above seconds, chains beside loops, all axes logarithmic; the exponents stand in the legends."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure as Sheet
    from matplotlib.ticker import NullFormatter, ScalarFormatter

    sheet = Sheet(figsize=(11.0, 8.5), facecolor="white", layout="constrained")
    FigureCanvasAgg(sheet)
    axes = sheet.subplots(2, len(FAMILIES), sharex=True, sharey="row")
    labels = {"operations": "operations per evaluation", "seconds": "derivation, s"}
    for row, (quantity, label) in zip(axes, labels.items(), strict=True):
        for ax, (family, title) in zip(row, FAMILIES.items(), strict=True):
            for name, called in TITLES.items():
                own = [f for f in figures if f.family == family and f.formulation == name]
                slope = exponent(own, quantity)
                text = called + ("" if slope is None else f", $n^{{{slope:.2f}}}$")
                ax.loglog(
                    [f.links for f in own],
                    [getattr(f, quantity) for f in own],
                    label=text,
                    color=COLOURS[name],
                    marker=MARKS[name],
                )
            ax.set(title=title, xlabel="links n", ylabel=label, facecolor="white")
            ax.set_xticks(sorted({f.links for f in figures}))
            ax.xaxis.set_major_formatter(ScalarFormatter())
            ax.xaxis.set_minor_formatter(NullFormatter())
            ax.tick_params(labelbottom=True, labelleft=True)
            ax.grid(which="major", color="#dddddd")
            ax.legend(frameon=False)
    sheet.savefig(path, dpi=110, metadata={"Software": None})


def write(tables: str, figures: Sequence[Figure]) -> None:
    """The tables between the marks of docs/formulations.md, the figures as CSV, the plot."""
    page = DOCS / "formulations.md"
    before, _, rest = page.read_text().partition("<!-- figures -->\n")
    _, _, after = rest.partition("<!-- end of figures -->\n")
    page.write_text(f"{before}<!-- figures -->\n{tables}\n<!-- end of figures -->\n{after}")
    with (DOCS / "data" / "formulations.csv").open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        columns = ("formulation", "family", "links", "seconds", "equations", "solve", "operations", "angles", "error")
        writer.writerow(columns)
        for f in figures:
            values = {column: getattr(f, column) for column in columns}
            writer.writerow((values | {"seconds": f"{f.seconds:.3f}", "error": f"{f.error:.1e}"}).values())
    draw(figures, DOCS / "images" / "formulations.png")


def main() -> None:
    """Derive everything that ends within the limit, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--links", type=int, nargs="+", default=SIZES, metavar="N", help="numbers of links")
    parser.add_argument("--limit", type=float, default=LIMIT, help="seconds after which a derivation is given up")
    parser.add_argument("--repeats", type=int, default=REPEATS, help="of a quick one, of which the fastest counts")
    parser.add_argument("--write", action="store_true", help="write tables, CSV and plot into docs/")
    options = parser.parse_args()
    sizes = sorted(options.links)
    figures: list[Figure] = []
    for family in FAMILIES:
        for name in TITLES:
            for n in (size for size in sizes if size >= FEWEST[family]):
                figure = derive(name, family, n, options.limit, options.repeats)
                print(figure or f"{name}, {family}, n = {n}: over {options.limit:.0f} s", file=sys.stderr, flush=True)
                if figure is None:  # larger ones take longer still
                    break
                figures.append(figure)
    worst = f"Largest relative error of any acceleration: {max(figure.error for figure in figures):.0e}."
    parts = [machine(), *(table(family, sizes, figures, options.limit) for family in FAMILIES), worst]
    tables = "\n\n".join(parts)
    print(tables)
    if options.write:
        write(tables, figures)


if __name__ == "__main__":
    main()
