"""``--set PATH=VALUE`` of the commands that compute."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from ccgen.generator.cli.app import app
from ccgen.runtime import simulate

from ..support.folders import SCENES
from ..support.workshop import Workshop

FOUR_BAR = str(SCENES / "four-bar.toml")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_a_run_has_the_values_that_are_set(workshop: Workshop) -> None:
    """As in Python, to the bit, and the file knows them; links of other lengths are put together anew."""
    from ccgen.generator import load_scene

    values = {"crank.mass": 2.5, "gravity.g": 1.62, "coupler.points.B.x": 0.55}
    options = [text for path, value in values.items() for text in ("--set", f"{path}={value}")]
    done = CliRunner().invoke(app, ["run", FOUR_BAR, *options, "--until", "1", "-q"])
    assert done.exit_code == 0, done.stderr
    run = simulate(workshop.model(load_scene(SCENES / "four-bar.toml")), until=1.0, params=values)
    with np.load("results/four-bar/result.npz") as written:
        parameters = dict(zip(written["parameter_names"].tolist(), written["parameter_values"].tolist(), strict=True))
        assert {path: parameters[path] for path in values} == values
        assert np.array_equal(written["q"], run.q)
    assert run.closure_max < 1e-12


def test_equilibria_and_torques_have_them() -> None:
    """Twice the gravity turns a balance point into one of twice the stiffness, and takes twice the torque."""
    said = [
        CliRunner().invoke(app, ["equilibrium", FOUR_BAR, *more]).stdout for more in ((), ("--set", "gravity.g=19.62"))
    ]
    stiffness = [float(text.splitlines()[0].rpartition(" ")[2]) for text in said]
    assert stiffness[1] == pytest.approx(2 * stiffness[0], rel=1e-5)
    runs = [
        CliRunner().invoke(app, ["torque", FOUR_BAR, "motor", "--rate", "1e-6", *more]).stdout
        for more in ((), ("--set", "gravity.g=19.62"))
    ]
    largest = [float(text.split("largest")[1].split()[0]) for text in runs]
    assert largest[1] == pytest.approx(2 * largest[0], rel=1e-6) and largest[0] != 0.0


def test_a_crank_is_named_by_its_joint_or_its_link() -> None:
    motor, crank = (CliRunner().invoke(app, ["torque", FOUR_BAR, name]).stdout for name in ("motor", "crank"))
    assert motor == crank and "motor turned once at 1 rad/s: crank against ground" in crank
    done = CliRunner().invoke(app, ["torque", FOUR_BAR, "coupler"])
    assert done.exit_code == 2 and "JOINT: found 'coupler'" in done.stderr and "motor (ground - crank)" in done.stderr


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--set", "crank.mass"], '--set: found "crank.mass", expected PATH=NUMBER in SI units'),
        (["--set", "crank.mass=heavy"], '--set: found "crank.mass=heavy", expected PATH=NUMBER'),
        (["--set", "a=1", "--set", "a=2"], "--set a: found twice, expected once"),
        (
            ["--set", "crank.mas=1"],
            "--set crank.mas: found no such parameter, expected one of the model, as crank.mass",
        ),
        (["--set", "crank.mass=-1"], "--set crank.mass: found -1.0, expected a positive number"),
        (["--set", "crank.mass=2", "--fold"], "--fold"),
    ],
)
def test_wrong_values_are_told(options: list[str], told: str) -> None:
    done = CliRunner().invoke(app, ["run", FOUR_BAR, *options])
    assert done.exit_code == 2 and told in done.stderr and not Path("results").exists()


def test_prices_of_effects_refuse_them() -> None:
    done = CliRunner().invoke(app, ["cost", FOUR_BAR, "--effects", "--set", "crank.mass=2"])
    assert done.exit_code == 2 and "--set: found beside --effects" in done.stderr


def test_a_summary_is_of_the_values_that_are_set() -> None:
    """Branch, degrees of freedom and effects are those of the mechanism with other lengths; operations stay."""
    scene = str(SCENES / "parallelogram.toml")
    plain, level = (
        CliRunner().invoke(app, ["show", scene, *more]).stdout
        for more in ((), ("--set", "gravity.g=1.5", "--set", "coupler.points.B.x=0.9"))
    )
    assert "gravity.g = 9.81" in plain and "gravity.g = 1.5" in level
    assert _entry("branch", plain) != _entry("branch", level)
    assert _entry("operations", plain) == _entry("operations", level)


def test_names_of_outputs_take_values_too() -> None:
    done = CliRunner().invoke(app, ["show", FOUR_BAR, "--outputs", "--set", "crank.mass=2"])
    assert done.exit_code == 0 and done.stdout == CliRunner().invoke(app, ["show", FOUR_BAR, "--outputs"]).stdout


@pytest.mark.parametrize("option", ["--equations", "--latex", "--expand", "--fold"])
def test_equations_have_symbols_for_them(option: str) -> None:
    done = CliRunner().invoke(app, ["show", FOUR_BAR, option, "--set", "crank.mass=2"])
    assert done.exit_code == 2 and f"--set: found beside {option}, expected without" in done.stderr


def test_lengths_that_cannot_be_joined_are_told_without_a_trace() -> None:
    done = CliRunner().invoke(app, ["show", FOUR_BAR, "--set", "crank.points.B.x=70"])
    assert done.exit_code == 2 and "Traceback" not in done.stderr and done.stderr


def _entry(heading: str, text: str) -> str:
    """The lines of one heading of a summary."""
    lines = text.splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith(heading))
    last = next((k for k in range(first + 1, len(lines)) if not lines[k].startswith(" ")), len(lines))
    return "\n".join(lines[first:last])
