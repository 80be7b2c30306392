"""Random rough loops on random grounds, each by every law of impact: how runs go by each (docs/events.md).

Loops, grounds and starts are drawn as those of tests/hard/fuzz.py, but all are rough.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ccgen.generator import Scene, generate, loop
from ccgen.generator.effect_base.contact import LAWS
from ccgen.runtime import Model, Run, load_model, simulate

SECONDS = 10.0
RTOL = 1e-11
"""Tighter than the default, so that flight adds no energy that would be taken for that of impacts."""
TILTS = (0.3, -0.4)
RESTITUTIONS = (0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0)
FRICTIONS = (0.05, 0.1, 0.3, 0.7, 1.2)
FAR = 1000.0
"""Metres below the level plane at which the second one lies where a toss has but one."""
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
class Toss:
    """A loop of ``n`` rods thrown onto one or two planes; ``seed`` draws lengths, masses and the start."""

    n: int
    planes: int
    restitution: float
    friction: float
    seed: int


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


def tosses(count: int, seed: int) -> Iterator[Toss]:
    """The first ``count`` tosses of ``seed``, all choices as likely as each other."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        yield Toss(
            n=int(rng.integers(3, 13)),
            planes=int(rng.integers(1, 3)),
            restitution=RESTITUTIONS[rng.integers(len(RESTITUTIONS))],
            friction=FRICTIONS[rng.integers(len(FRICTIONS))],
            seed=int(rng.integers(2**31)),
        )


def scene(n: int, law: str) -> Scene:
    """That of all tosses of ``n`` rods by a law: they differ in parameters and starts alone."""
    grounds = [
        {"restitution": 0.5, "friction": 0.5, "normal": [tilt, 1.0], "point": [0.0, -plane * FAR]}
        for plane, tilt in enumerate(TILTS)
    ]
    return loop(n, gravity=True, start={"height": 1.0}, ground=grounds, run={"law": law})


def thrown(model: Model, toss: Toss) -> Run:
    """The run of a toss; it starts alike by every law."""
    rng = np.random.default_rng(toss.seed)
    model = model.with_parameters(parameters(toss, rng))
    q, u = model.start()
    u = u + 2.0 * rng.normal(size=u.size)
    q[2:] += rng.normal()
    q, u = model.project(q, u)
    q[1] += 0.2 + 1.5 * max(0.0, -float(model.gaps(q).min()))
    return simulate(model, q, u, until=SECONDS, rtol=RTOL)


def parameters(toss: Toss, rng: np.random.Generator) -> dict[str, float]:
    """Grounds, lengths and masses. One plane alone is level, the other out of reach below it."""
    values = {"ground_1.point.y": 0.0 if toss.planes > 1 else -FAR}
    for plane, tilt in enumerate(TILTS):
        values[f"ground_{plane}.normal.x"] = tilt if toss.planes > 1 else 0.0
        values[f"ground_{plane}.restitution"] = toss.restitution
        values[f"ground_{plane}.friction"] = toss.friction
    for k in range(toss.n):
        values[f"link_{k}.length"] = float(rng.uniform(0.8, 1.3))
        values[f"link_{k}.mass"] = float(rng.uniform(0.5, 2.0))
    return values


def figures(model: Model, law: str, toss: Toss) -> Figures:
    """Those of the run of a toss; a run that stops short is told on standard error."""
    began = time.perf_counter()
    run = thrown(model, toss)
    seconds = time.perf_counter() - began
    if not run.success:
        print(f"{law}, {toss}: {run.message}", file=sys.stderr)
    energy = np.sum(run.model.energy(run.q, run.u), axis=0)
    return Figures(
        seconds,
        run.success,
        len(run.impacts),
        sum(impact.restitution_share < 1.0 for impact in run.impacts),
        any(phase.kind == "steps" for phase in run.phases),
        float(np.max(energy - np.minimum.accumulate(energy))) / max(1.0, abs(float(energy[0]))),
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
    drawn = list(tosses(options.count, options.seed))
    print("| " + " | ".join(HEADER) + " |\n|" + "---|" * len(HEADER), flush=True)
    for law in LAWS:
        with tempfile.TemporaryDirectory() as folder:
            sizes = sorted({toss.n for toss in drawn})
            models = {n: load_model(generate(scene(n, law), f"{folder}/loop{n}")) for n in sizes}
            print(row(law, [figures(models[toss.n], law, toss) for toss in drawn]), flush=True)


if __name__ == "__main__":
    main()
