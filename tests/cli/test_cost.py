"""What accuracy costs: the reference, the growth of errors, the table, and what is recommended."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from ccgen.generator import load_scene, loop
from ccgen.generator.cli.app import app
from ccgen.runtime import methods, simulate
from ccgen.runtime.cost import accuracy
from ccgen.runtime.cost.accuracy import Measured, compare, errors, growth, measure, parted_at, recommend, refer
from ccgen.runtime.precision import wider

from ..support.folders import SCENES
from ..support.pendulum import PENDULUM, exact_pendulum
from ..support.workshop import Workshop


@pytest.fixture(scope="module")
def pendulum(workshop: Workshop) -> Any:
    return workshop.model(PENDULUM.replace("method-pendulum", "cost-pendulum"))


def test_the_reference_is_exact(pendulum: Any) -> None:
    reference = refer(pendulum, 4.0)
    assert reference.run.method == "gauss"
    assert reference.second.method == "dop853"
    assert abs(reference.run.q[-1, 0] - exact_pendulum(np.array([4.0]))[0]) <= 2e-14
    assert reference.doubt <= 1e-12


def test_the_reference_meets_the_known_impacts(workshop: Workshop) -> None:
    """Times of the falling hexagon that two independent programs agree on."""
    reference = refer(workshop.model(load_scene(SCENES / "falling-hexagon.toml")), 0.9)
    times = [impact.t for impact in reference.run.impacts]
    assert times == pytest.approx([0.4515236409857, 0.5497839476458, 0.7701908095116], abs=5e-14)


@pytest.mark.parametrize("method", methods(estimating=True))
def test_measured_errors_are_the_true_ones(method: str, pendulum: Any) -> None:
    reference = refer(pendulum, 4.0)
    found = measure(pendulum, method, 1e-6, reference.run)
    run = simulate(pendulum, until=4.0, rtol=1e-6, method=method)
    angle = float(run.q[-1, 0] - exact_pendulum(np.array([4.0]))[0])
    assert found.error == pytest.approx(abs(angle), abs=3e-14)
    assert found.seconds > 0.0
    assert found.evaluations == run.nfev
    assert found.steps == len(run.t) - 1


def test_other_impacts_are_another_motion(workshop: Workshop) -> None:
    model = workshop.model(load_scene(SCENES / "falling-hexagon.toml"))
    whole, part = simulate(model, until=0.9), simulate(model, until=0.5)
    assert errors(part, whole) == (np.inf, np.inf)
    assert errors(whole, whole) == (0.0, 0.0)


BOX = """
name = "cost-box"
[[link]]
name = "box"
rod = [{ mass = 1, between = ["A", "B"] }, { mass = 1, between = ["B", "C"] }, { mass = 1, between = ["C", "A"] }]
points = { A = [0, 0], B = [0.4, 0], C = [0.4, 0.3] }
[start]
position = [0, 0.2]
velocity = [1.5, 0]
angular_velocities = [-6]
[gravity]
g = 10
[[ground]]
restitution = 0.4
friction = 0.6
contacts = ["box.A", "box.B", "box.C"]
"""


def test_the_first_other_impact_is_told(workshop: Workshop) -> None:
    model = workshop.model(BOX)
    longer = simulate(model, until=1.0)
    first, second = longer.impacts[0].t, longer.impacts[1].t
    shorter = simulate(model, until=(first + second) / 2.0)
    assert parted_at(longer, longer) is None
    t, told = parted_at(longer, shorter) or (0.0, "")
    (contact,) = longer.impacts[1].contacts
    assert t == second
    assert told == f"impact 2 of gauss is of {contact[0]} on ground_0 at t = {t:.9g} s, gauss has no further one"


def test_runs_that_meet_other_impacts_are_no_reference(workshop: Workshop) -> None:
    """Where bounces of a corner accumulate rounding decides which is the last; the end that is suggested is before."""
    model = workshop.model(BOX)
    with pytest.raises(ValueError, match=r"gauss and dop853 meet other impacts.* is of box") as caught:
        refer(model, 3.0)
    end = float(str(caught.value).rpartition("as --until ")[2])
    assert 0.0 < end < 3.0
    assert refer(model, end).doubt <= 1e-6
    assert len(simulate(model, until=end).impacts) >= 2


def test_tries_of_an_earlier_end_come_to_an_end(workshop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where two runs part at the same instant whatever the end, no end is suggested after as many tries as are told."""
    model = workshop.model(BOX)
    longer = simulate(model, until=1.0)
    shorter = simulate(model, until=(longer.impacts[0].t + longer.impacts[1].t) / 2.0)
    asked = []

    def two(_: Any, until: float) -> tuple[Any, None]:
        asked.append(until)
        return accuracy.Reference(longer, shorter, np.inf, 1e-12, 1e-12), None

    monkeypatch.setattr(accuracy, "_two", two)
    with pytest.raises(ValueError, match=r"Choose an end before it: --until$"):
        refer(model, 3.0)
    assert len(asked) == 1 + accuracy.TRIED


def test_neighbours_of_a_regular_motion_part_slowly(pendulum: Any) -> None:
    """In proportion to time at most: no horizon."""
    found = growth(pendulum, 10.0)
    assert not found.cut
    assert found.until == 10.0
    assert 0.1 <= found.factor <= 100.0


def test_chaos_has_a_horizon(workshop: Workshop) -> None:
    """A triple pendulum from high up: errors grow exponentially, and comparisons end before they mean nothing."""
    text = "name = 'cost-triple'\n[chain]\nlinks = 3\nhinged = true\n[gravity]\ng = 9.81\n"
    text += "[start]\nangles = [1.7, 1.9, 2.3]\n"
    model = workshop.model(text)
    found = growth(model, 60.0)
    assert found.cut
    assert 1.0 < found.until < 60.0
    assert 1e3 < found.factor <= 1.1e6
    assert refer(model, found.until).doubt < 1e-6
    with pytest.raises(
        ValueError, match=r"cost-triple: no reference: gauss and dop853 differ by .* choose an earlier end"
    ):
        refer(model, 60.0)


def test_symmetric_motions_keep_their_symmetry(workshop: Workshop) -> None:
    """Two corners that land together: a neighbour that splits them says nothing of the errors of runs, which do not."""
    found = growth(workshop.model(load_scene(SCENES / "falling-hexagon.toml")), 0.9)
    assert not found.cut


def test_a_start_that_strikes_has_neighbours(workshop: Workshop) -> None:
    """A rod that starts on its surface and moves into it: the impact is the first thing that happens."""
    text = "name = 'cost-strikes'\n[chain]\nlinks = 1\n[gravity]\n[[ground]]\nrestitution = 0.5\n"
    text += "contacts = ['link_0.A']\n[start]\nposition = [0, 0]\nvelocity = [0, -1]\nangles = [1.0]\n"
    assert growth(workshop.model(text), 0.1).until == 0.1


def test_comparison_covers_methods_and_ways_to_keep_the_closure(workshop: Workshop) -> None:
    model = workshop.model(loop(6, gravity=True))
    reference = refer(model, 0.5)
    told = []
    found = compare(
        model,
        reference.run,
        ("projected", "left", "damped"),
        (1e-4, 1e-8),
        lambda done, all_: told.append((done, all_)),
    )
    assert {(one.method, one.drift) for one in found} == {
        (m, d) for m in methods(estimating=True) for d in ("projected", "left", "damped")
    }
    assert len(found) == 24
    assert told == [(k, 24) for k in range(24)]
    assert all(one.error <= 300 * one.rtol for one in found)


def row(method: str, error: float, seconds: float, impact: float = 0.0, drift: str = "projected") -> Measured:
    return Measured(method, drift, 1e-6, seconds, error, impact, 1, 1)


def test_the_fastest_that_is_good_enough_is_recommended() -> None:
    rows = [row("a", 1e-9, 3.0), row("b", 1e-7, 1.0), row("c", 1e-12, 2.0), row("d", 1e-12, 1.5, impact=1e-5)]
    rows += [row("e", 1e-12, 0.1, drift="left"), row("f", np.inf, 0.1)]
    assert recommend(rows, 1e-8) == rows[2]
    assert recommend(rows, 1e-6) == rows[1]
    assert recommend(rows, 1e-13) is None


def test_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = tmp_path / "swing.toml"
    scene.write_text(PENDULUM.replace("method-pendulum", "swing") + "[run]\nuntil = 0.5\n")
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, ["cost", str(scene), "--error", "1e-9"])
    assert done.exit_code == 0, done.output
    lines = done.output.splitlines()
    assert re.fullmatch(r"for 1e-09: \w+ at rtol 1e-\d\d, about [\d.e+]+ µs per simulated second", lines[-1])
    assert lines[-2].startswith("for 1e-06: ")
    grounds = r"reference: gauss at rtol 1e-\d\d in (wide numbers|doubles too); dop853 at rtol 1e-\d\d, a method .*"
    (numbers,) = [found[1] for line in lines if (found := re.fullmatch(grounds, line))]
    assert (numbers == "wide numbers") == wider()
    with (tmp_path / "results" / "swing" / "cost.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 44
    assert {r["method"] for r in rows} == set(methods(estimating=True))
    assert all(float(r["us_per_second"]) == pytest.approx(2e6 * float(r["seconds"])) for r in rows)
    assert (tmp_path / "results" / "swing" / "cost.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--error", "2"], "--error: found 2.0, expected a number from 1e-15 to 1; correct it"),
        (["--until", "-1"], "--until: found -1.0, expected a positive number of seconds; correct it"),
        (["--out", "swing.toml"], "--out swing.toml: found a file"),
    ],
)
def test_wrong_options(options: list[str], sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "swing.toml").write_text(PENDULUM)
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, ["cost", "swing.toml", *options])
    assert done.exit_code == 2
    assert sentence in done.output
