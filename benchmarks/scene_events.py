"""Events of scenes: runs that are told of them, or end and go on at them, beside the same runs without, and ensembles;
and a joint that lets go.

Prints four markdown tables; `python benchmarks/scene_events.py --help` lists the options, README.md explains the rest.
"""

import argparse
from functools import partial
from pathlib import Path

from driver import WORK
from machine import machine
from turns import fastest

from ccgen.generator import generate, load_scene
from ccgen.runtime import Model, Run, ensemble, load_model, simulate

SCENES = Path(__file__).parents[1] / "scenes"
CASES = (
    ("falling-hexagon", 1.5, "y(joint_3) + 9", "y(joint_3) - 1", "gravity.g"),
    ("tilted-hexagon", 2.0, "y(joint_3) + 9", "y(joint_3) - 1", "gravity.g"),
    ("four-bar", 20.0, "angle(knee) - 900", "rate(angle(pivot))", "gravity.g"),
    ("jansen-leg", 20.0, "x(shin.F) + 900", "x(shin.F) + 20", "gravity.g"),
)
"""Scene, end (s), an expression that never comes to zero, one that does, and a parameter."""


def model_of(name: str, kind: str, when: str = "", then: str = "") -> Model:
    """The scene's model of that ``kind``, with an event if there is a ``when``."""
    text = (SCENES / f"{name}.toml").read_text()
    table = f'\n[[event]]\nname = "event"\nwhen = "{when}"\n{then}\n' if when else ""
    file = WORK / f"{name}-{kind}.toml"
    file.write_text(text + table)
    return load_model(generate(load_scene(file), out=WORK / "models"))


def main() -> None:
    """Run each scene in four ways, and print a line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=40, help="repeats of which the fastest counts")
    parser.add_argument("--throws", type=int, default=1000, help="runs of the trebuchet in an ensemble")
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    print(f"{machine()}\n\n| run | rows | ms | never comes | told | of them | sets, for each that comes |")
    print("|---|---|---|---|---|---|---|", flush=True)
    for name, until, never, when, path in CASES:
        plain = model_of(name, "plain")
        value = plain.parameters[path]
        models = [
            plain,
            model_of(name, "never", never),
            model_of(name, "told", when),
            model_of(name, "sets", when, f'set = {{ "{path}" = {value} }}'),
        ]

        def run(model: Model, end: float = until) -> Run:
            return simulate(model, until=end)

        rows, came = len(run(plain).t), len(run(models[2]).events)
        assert not run(models[1]).events and len(run(models[3]).events) == came > 0
        alone, missed, told, sets = fastest([lambda m=m: run(m) for m in models], options.rounds)
        each = (sets - alone) / came / alone
        print(
            f"| {name}, {until:g} s | {rows} | {1e3 * alone:.2f} | {missed / alone:.2f} | {told / alone:.2f} | {came} |"
            f" {each:.2f} |",
            flush=True,
        )
    ensembles(max(options.rounds // 10, 2), 100)
    throws(options.rounds, options.throws)


def ensembles(rounds: int, count: int) -> None:
    """Runs in an ensemble that set a parameter at events, beside those without, and beside one call each."""
    print(
        f"\n| ensemble of {count} runs | ms a run | sets, for each that comes | of one call each |\n|---|---|---|---|"
    )
    for name, until, _, when, path in CASES:
        plain = model_of(name, "plain")
        value = plain.parameters[path]
        sets = model_of(name, "sets", when, f'set = {{ "{path}" = {value} }}')
        values = {path: [value * (1.0 + 1e-3 * k / count) for k in range(count)]}
        came = len(simulate(sets, until=until).events)

        def make(model: Model, end: float = until, values: dict[str, list[float]] = values) -> object:
            return ensemble(model, values, until=end, threads=1)

        def one_by_one(model: Model = sets, end: float = until, values: dict[str, list[float]] = values) -> None:
            for path, row in values.items():
                for one in row:
                    simulate(model, until=end, params={path: one})

        alone, with_events, singly = fastest([partial(make, plain), partial(make, sets), one_by_one], rounds)
        each = (with_events - alone) / came / alone
        print(
            f"| {name}, {until:g} s | {1e3 * alone / count:.3f} | {each:.3f} | {with_events / singly:.3f} |", flush=True
        )


def throws(rounds: int, count: int) -> None:
    """The trebuchet beside itself without its release, up to where that comes; and many of it by the core alone, on two
    threads, beside one call each."""
    text = (SCENES / "trebuchet.toml").read_text()
    models = []
    for name in ("lets-go", "holds"):
        file = WORK / f"trebuchet-{name}.toml"
        table = text[text.index("[[release]]") : text.index("[[ground]]")]
        file.write_text(text if name == "lets-go" else text.replace(table, ""))
        models.append(load_model(generate(load_scene(file), out=WORK / "models")))
    lets_go, holds = models
    until = simulate(lets_go).changes[0].t
    rows = [len(simulate(model, until=until).t) for model in models]
    masses = {"counterweight.mass": [500.0 + 0.1 * k for k in range(count)]}

    def run(model: Model) -> Run:
        return simulate(model, until=until)

    def one_by_one() -> None:
        for mass in masses["counterweight.mass"]:
            simulate(lets_go, params={"counterweight.mass": mass})

    made = ensemble(lets_go, masses, threads=2)
    assert set(made.status) == {"done"}
    short, plain = fastest([lambda: run(lets_go), lambda: run(holds)], rounds)
    whole, singly = fastest([lambda: ensemble(lets_go, masses, threads=2), one_by_one], max(rounds // 10, 2))
    print("\n| trebuchet, to where its stone leaves | rows | ms | without release |\n|---|---|---|---|")
    print(f"| {until:.3f} s | {rows[0]}, {rows[1]} | {1e3 * short:.2f} | {short / plain:.2f} |")
    print(f"\n| {count} throws of 1.2 s, two threads | ms a run | of one call each |\n|---|---|---|")
    print(f"| by the core | {1e3 * whole / count:.3f} | {whole / singly:.3f} |", flush=True)


if __name__ == "__main__":
    main()
