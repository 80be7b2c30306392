"""What derivatives cost: errors beside a closed form, the table, and wrong options."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from ccgen.generator.cli.app import app
from ccgen.runtime import simulate
from ccgen.runtime.cost.gradient import (
    TIGHT,
    WAYS,
    Measured,
    best,
    columns_of,
    compare,
    derived,
    measure,
    refer,
    relative,
    weights_of,
)
from ccgen.runtime.functions import run_function as run_function_module
from ccgen.runtime.functions.arguments import arguments_of
from ccgen.runtime.functions.run_function import run_function
from ccgen.runtime.precision import wider

from ..support.bounced import AT, BOUNCED, X, bounced, bounced_jacobian
from ..support.workshop import Workshop

NAMES = ("u0", "ball.mass", "gravity.g", "ground_0.restitution")
END = AT[1]
STILL = np.array([*X[:6], 0.0])
"""Without a push."""


def ends(x: Any) -> Any:
    """Coordinates at the end, in closed form."""
    return np.array([*bounced(x)[[1, 3]], x[2] * END])


def exact() -> Any:
    turned = np.zeros(6)
    turned[2] = END
    return np.vstack([bounced_jacobian(STILL)[[1, 3], :6], turned])


def by_hand(way: str, step: float) -> Any:
    """Differences of the closed form."""
    columns = []
    for k in range(6):
        h = step * STILL[k] * np.eye(7)[k]
        ahead, behind = ends(STILL + h), ends(STILL - h) if way == "central" else ends(STILL)
        columns.append((ahead - behind) / (h[k] * (2.0 if way == "central" else 1.0)))
    return np.array(columns).T


@pytest.fixture(autouse=True)
def once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is repeated to be timed better."""
    monkeypatch.setattr("ccgen.runtime.cost.gradient.SPENT", 0.0)


@pytest.fixture(scope="module")
def ball(workshop: Workshop) -> Any:
    return workshop.model(BOUNCED, derivatives=True)


def test_the_reference_is_exact(ball: Any, workshop: Workshop) -> None:
    found = refer(ball, workshop.model(BOUNCED, "wide") if wider() else None, NAMES, END)
    weights = weights_of(ball)
    assert relative(weights @ found.jacobian, exact(), weights) <= 2e-12 and found.doubt <= 2e-12
    assert found.jacobian == pytest.approx(exact(), rel=2e-12, abs=2e-12)
    assert ("wide" in found.text) == wider()
    pushed = refer(ball, workshop.model(BOUNCED, "wide") if wider() else None, ("push", "u0"), END)
    assert pushed.jacobian[:, 0] == pytest.approx([0.5 * END**2 / X[3], 0.0, 0.0], abs=1e-12)
    without = refer(ball, None, NAMES, END)
    assert relative(weights @ without.jacobian, exact(), weights) <= 1e-11 and "doubles too" in without.text


@pytest.mark.parametrize("way", ["one-sided", "central"])
def test_errors_of_differences_are_those_of_the_closed_form(way: str, ball: Any) -> None:
    for step in (1e-2, 1e-3):
        found = measure(ball, NAMES, END, way, 1e-12, step, exact())
        weights = weights_of(ball)
        assert found.error == pytest.approx(relative(weights @ by_hand(way, step), exact(), weights), rel=1e-4)
        assert found.seconds > 0.0


def test_differences_have_a_best_step_and_derivatives_need_none(ball: Any) -> None:
    """Too long a step cuts off, too short a one divides rounding: the curve turns, and its least is far above."""
    steps = (1e-1, 1e-3, 1e-5, 1e-9, 1e-13)
    told: list[tuple[int, int]] = []
    found = compare(ball, NAMES, END, 1e-10, exact(), lambda done, all_: told.append((done, all_)), steps)
    assert told == [(k, len(found)) for k in range(len(found))]
    assert {(one.way, one.rtol) for one in found if one.way in WAYS[:2]} == {
        (way, rtol) for way in WAYS[:2] for rtol in (1e-10, TIGHT)
    }
    for way in WAYS[:2]:
        errors = [one.error for one in found if (one.way, one.rtol) == (way, TIGHT)]
        least = int(np.argmin(errors))
        assert 0 < least < len(steps) - 1
        assert best(found, way, TIGHT).step == steps[least]
    for way in WAYS[2:]:
        assert best(found, way, 1e-10).error <= 1e-11 < best(found, "central", 1e-10).error / 2.0
    assert best(found, "central", TIGHT).error < best(found, "one-sided", TIGHT).error


def test_the_adjoint_is_one_covector_and_the_tangent_all_columns(ball: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Both are the gradient of the closed form. What each asks the run for is counted: it is what its time is of."""
    asked: list[tuple[str, tuple[int, ...]]] = []

    def counted(name: str) -> Any:
        real = getattr(run_function_module, name)

        def call(run: Any, first: Any, *others: Any) -> Any:
            asked.append((name, np.shape(first) if name == "run_vjp" else ()))
            return real(run, first, *others)

        return call

    for name in ("run_vjp", "run_sensitivities"):
        monkeypatch.setattr(run_function_module, name, counted(name))
    weights, arguments = weights_of(ball), arguments_of(ball, NAMES, (None, None), None)
    for way, expected in (("adjoint", ("run_vjp", (3,))), ("tangent", ("run_sensitivities", ()))):
        asked.clear()
        function = run_function(ball, NAMES, "q", until=END, rtol=1e-12)
        found = derived(function, arguments, weights, way, np.nan)
        assert asked == [expected]
        assert found == pytest.approx(weights @ exact(), rel=1e-10, abs=1e-12)


def test_errors_are_in_parts_of_the_terms() -> None:
    """By hand: terms 1 and -0.9 add to 0.1, and an error of 0.019 there is a hundredth of 1.9."""
    wanted, weights = np.array([[1.0, 2.0], [-1.8, 0.0]]), np.array([1.0, 0.5])
    assert relative(np.array([0.119, 2.0]), wanted, weights) == pytest.approx(0.01)
    assert relative(np.array([0.1, 2.002]), wanted, weights) == pytest.approx(0.001)


def test_what_cannot_be_changed_to_both_sides_is_left_out(ball: Any) -> None:
    assert columns_of(ball, END).names[0] == "u0"
    found = columns_of(ball.with_parameters({"ground_0.restitution": 1.0}), END)
    assert "ground_0.restitution" not in found.names
    assert found.left["ground_0.restitution"] == "it is at the end of what it may be"


def test_a_way_without_derivatives_is_worth_nothing(ball: Any) -> None:
    found = measure(ball, ("ground_0.restitution",), END, "one-sided", 1e-10, 10.0, np.ones((3, 1)))
    assert found.error == np.inf and np.isnan(found.seconds)
    other = Measured("one-sided", 1e-10, 1e-3, 1.0, 0.1)
    assert best([found, other], "one-sided", 1e-10) == other


def test_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "bounced.toml").write_text(BOUNCED)
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, ["cost", "bounced.toml", "--gradient", "--until", "0.8", "--by", "u0,gravity.g"])
    assert done.exit_code == 0, done.output
    lines = done.output.splitlines()
    assert [line.partition(" at rtol")[0] for line in lines[-4:]] == list(WAYS)
    assert "derived: one number, a weighted sum of 3 coordinates at t = 0.8 s, by 4 numbers of u0, gravity.g" in lines
    folder = tmp_path / "results" / "bounced"
    with (folder / "gradient.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {row["way"] for row in rows} == set(WAYS) and all(float(row["seconds"]) > 0.0 for row in rows)
    assert (folder / "gradient.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--gradient", "--drift"], "--drift: found beside --gradient, expected one of them"),
        (["--gradient", "--effects", "--error", "1e-3"], "--error: found beside --gradient"),
        (["--by", "u0"], "--by: found without --gradient"),
        (["--gradient", "--by", "gravity.h,ball.weight"], "ball.weight"),
        (["--gradient", "--until", "-1"], "--until: found -1.0, expected a positive number of seconds"),
    ],
)
def test_wrong_options(options: list[str], sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "bounced.toml").write_text(BOUNCED)
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, ["cost", "bounced.toml", *options])
    assert done.exit_code == 2
    assert sentence in done.output


def test_beside_an_impact_there_is_no_reference(ball: Any, workshop: Workshop) -> None:
    """Steps to one side end before the bounce, others behind it; but neither mass nor restitution moves it."""
    hit = simulate(ball).impacts[0].t
    told = (
        r"no reference by u0, gravity\.g at t = .* they change by .* "
        r"leave them out, as --by ball\.mass,ground_0\.restitution, or choose another end: --until"
    )
    with pytest.raises(ValueError, match=told if wider() else "no reference by "):
        refer(ball, workshop.model(BOUNCED, "wide") if wider() else None, NAMES, hit + 1e-6)


@pytest.mark.parametrize(
    ("by", "told"),
    [
        ("q", "--by: q: found no such parameter"),
        ("u0,u", "--by: u: found no such parameter"),
        ("", '--by: found "", expected names with a comma between two of them, such as u0,gravity.g\n'),
        ("u0,,gravity.g", '--by: found "u0,,gravity.g", expected names with a comma between two of them, such as'),
        ("u0,gravity.g,u0", "--by: u0: found 2 times, expected once; leave the others out\n"),
    ],
)
def test_wrong_names_are_told_before_anything_is_generated(
    by: str, told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("bounced.toml").write_text(BOUNCED)
    done = CliRunner().invoke(app, ["cost", "bounced.toml", "--gradient", "--by", by, "--until", "-3"])
    assert done.exit_code == 2
    assert told in done.stderr and "--until: found -3.0" in done.stderr and len(done.stderr.splitlines()) == 2
