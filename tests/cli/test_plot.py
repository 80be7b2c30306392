"""``ccgen plot RUN``, and what ``[output]`` of a scene asks for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from ccgen.generator.cli.app import app
from ccgen.generator.cli.known_outputs import of_effects, possible_outputs
from ccgen.generator.cli.outputs import Wanted
from ccgen.runtime import load_model, simulate
from ccgen.runtime.record.outputs import outputs_of

from ..support.folders import SCENES
from ..support.workshop import Workshop

FOUR_BAR = (SCENES / "four-bar.toml").read_text(encoding="utf-8")
OUTPUT = """
[output]
plot = ["crank.angle", "knee.force"]
table = ["crank.angle", "coupler.tip.y"]
times = 5
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_a_run_that_is_done_is_looked_at_again() -> None:
    """By what the scene asks for, then by the command: numbers are those of the run, nothing is simulated."""
    Path("scene.toml").write_text(FOUR_BAR + OUTPUT)
    done = CliRunner().invoke(app, ["run", "scene.toml", "--until", "1", "--set", "crank.mass=2.5"])
    assert done.exit_code == 0 and "results/four-bar/outputs.png, results/four-bar/outputs.csv" in done.stdout
    results = Path("results/four-bar")
    lines = (results / "outputs.csv").read_text().splitlines()
    assert lines[0] == "t [s],crank.angle [rad],coupler.tip.y [m]" and len(lines) == 6
    before = (results / "outputs.png").read_bytes()
    run = simulate(load_model("build/four_bar"), until=1.0, params={"crank.mass": 2.5})
    done = CliRunner().invoke(app, ["plot", "results/four-bar", "motor.fx,motor.fy", "energy", "--csv", "--times", "3"])
    assert done.exit_code == 0, done.stderr
    assert done.stdout == "written: results/four-bar/outputs.png, results/four-bar/outputs.csv\n"
    assert (results / "outputs.png").read_bytes() != before
    heading, *rows = (results / "outputs.csv").read_text().splitlines()
    assert heading == "t [s],motor.fx [N on crank],motor.fy [N on crank],energy [J]"
    t = np.array([0.0, 0.5, 1.0])
    wanted = np.column_stack([t, *run.values("motor.fx", "motor.fy", "energy", t=t).values()])
    assert np.array_equal(np.array([row.split(",") for row in rows], dtype=float), wanted)
    # what the command has written is its own: a run takes its place
    assert CliRunner().invoke(app, ["run", "scene.toml", "--until", "1", "-q"]).exit_code == 0


def test_without_names_they_are_told() -> None:
    Path("scene.toml").write_text(FOUR_BAR)
    assert CliRunner().invoke(app, ["run", "scene.toml", "--until", "1", "-q"]).exit_code == 0
    done = CliRunner().invoke(app, ["plot", "results/four-bar/result.npz"])
    shown = CliRunner().invoke(app, ["show", "scene.toml", "--outputs", "-q"])
    assert done.exit_code == 0 and done.stdout == shown.stdout and "crank: angle [rad]" in done.stdout
    done = CliRunner().invoke(app, ["plot", "results/four-bar", "crank.angel", "--out", "elsewhere"])
    assert done.exit_code == 2 and not Path("elsewhere").exists()
    assert done.stderr.startswith("NAMES: found 'crank.angel', which nothing is called, expected one such as crank.ang")
    Path("build").rename("models")
    done = CliRunner().invoke(app, ["plot", "results/four-bar", "crank.angle"])
    assert done.exit_code == 2 and "found a run of a model four_bar that is not in build" in done.stderr
    done = CliRunner().invoke(app, ["plot", "results/four-bar", "crank.angle", "--models", "models", "--out", "new"])
    assert done.exit_code == 0 and Path("new/outputs.png").is_file(), done.stderr


@pytest.mark.parametrize(
    ("output", "told"),
    [
        ('plot = ["crank.angel"]', "scene.toml: output.plot[0]: found 'crank.angel', which nothing is called"),
        ('table = ["x", "crank.angle"]', "scene.toml: output.table[0]: found 'x', which nothing is called"),
        ("times = 5", "output.times: found beside no table, expected one"),
        ('table = ["t"]\ntimes = 1', "output.times: found 1, expected beside table: at how many even times"),
        ('plot = "t"', 'output.plot: found "t", expected names of what is drawn over time'),
    ],
)
def test_what_no_run_says_is_refused(output: str, told: str) -> None:
    Path("scene.toml").write_text(f"{FOUR_BAR}\n[output]\n{output}\n")
    done = CliRunner().invoke(app, ["run", "scene.toml", "--until", "0.1"])
    assert done.exit_code == 2 and told in done.stderr, done.stderr
    assert not Path("results").exists() and not Path("build").exists()  # nothing is compiled


EFFECTS = """
[[spring]]
name = "coil"
between = ["ground.O", "coupler.B"]
stiffness = 10
[[drag]]
point = "coupler.B"
linear = 1
"""


def test_every_output_is_taken_before_compiling(workshop: Workshop) -> None:
    """What a model has is among what the scene may have, or of its effects: of every shipped scene that is compiled
    here, all; and each name but those of effects with a letter more is refused."""
    for text in (FOUR_BAR + EFFECTS, (SCENES / "trebuchet.toml").read_text(), (SCENES / "planetary.toml").read_text()):
        scene = workshop.scene(text)
        known = possible_outputs(scene)
        for name in outputs_of(workshop.model(scene)):
            assert name in known or of_effects(scene, name), name
        wrong = [name for name in known if of_effects(scene, f"{name}x")]
        assert not wrong
        with pytest.raises(typer.Exit):
            Wanted(plot=(("--plot", "coupler.com.z"),)).check_scene(scene)


def test_what_effects_tell_is_checked_with_the_model() -> None:
    Path("scene.toml").write_text(FOUR_BAR + EFFECTS)
    done = CliRunner().invoke(app, ["run", "scene.toml", "--until", "0.1", "--plot", "coil.farce,crank.com"])
    assert done.exit_code == 2 and "--plot: found 'coil.farce', which nothing is called" in done.stderr
    assert Path("build").exists() and not Path("results").exists()


def test_files_that_are_none_are_refused() -> None:
    Path("here").mkdir()
    for given, found in (("here", "no such file"), ("nowhere", "nothing there"), ("nowhere.npz", "nothing there")):
        done = CliRunner().invoke(app, ["plot", given, "t"])
        assert done.exit_code == 2 and f"found {found}, expected " in done.stderr
        assert "the .npz file of a run" in done.stderr
    done = CliRunner().invoke(app, ["plot", "here", "t", "--times", "5"])
    assert done.exit_code == 2 and "--times: found without --csv" in done.stderr


def test_results_of_a_model_that_another_has_replaced_say_what_to_do() -> None:
    """What is said to be done is done, and draws them."""
    rod = 'name = "same"\n[chain]\nlinks = 1\nhinged = true\n[gravity]\n[run]\nuntil = 0.1\n'
    Path("one.toml").write_text(rod)
    Path("two.toml").write_text(rod.replace("links = 1", "links = 2"))
    assert CliRunner().invoke(app, ["run", "one.toml", "-q"]).exit_code == 0
    assert CliRunner().invoke(app, ["--scene", "two.toml", "-q"]).exit_code == 0
    done = CliRunner().invoke(app, ["plot", "results/same", "joint_0.force"])
    assert done.exit_code == 2 and done.stdout == ""
    assert done.stderr == (
        "results/same/result.npz: found build/same made of another scene than the run, or of this one after a change, "
        "expected the model of the run; make that in a folder of its own, ccgen --scene FILE --out DIR, and name it by "
        "--models DIR, or run the scene again\n"
    )
    assert CliRunner().invoke(app, ["--scene", "one.toml", "--out", "old", "-q"]).exit_code == 0
    done = CliRunner().invoke(app, ["plot", "results/same", "joint_0.force", "--models", "old"])
    assert done.exit_code == 0, done.stderr
