"""What ``ccgen run --plot`` draws and writes, and ``ccgen show --outputs`` lists."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from typer.testing import CliRunner

from ccgen.generator.cli.app import app
from ccgen.runtime.pictures.output_plot import draw_outputs

from ..support.command_line import PENDULUM
from ..support.leaning_rod import LEANING, G
from ..support.player_page import data_of
from ..support.workshop import Workshop


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "leaning.toml"
    file.write_text(LEANING)
    return file


def test_a_run_draws_and_writes_what_is_asked(scene: Path) -> None:
    asked = "rod.angle, hinge.fy,ground_0.rod.T.gap,ground_0.rod.T.normal"
    done = CliRunner().invoke(app, ["run", str(scene), "--plot", asked, "--csv", "--times", "21"])
    assert done.exit_code == 0 and "outputs.png" in done.stdout and "outputs.csv" in done.stdout
    folder = Path("results/leaning")
    assert (folder / "outputs.png").read_bytes()[:4] == b"\x89PNG"
    page = data_of((folder / "player.html").read_text(encoding="utf-8"))
    assert page["plotted"] == ["rod.angle", "hinge.fy", "ground_0.rod.T.gap", "ground_0.rod.T.normal"]
    with (folder / "outputs.csv").open(newline="") as file:
        head, *rows = csv.reader(file)
    assert head == [
        "t [s]",
        "rod.angle [rad]",
        "hinge.fy [N on rod]",
        "ground_0.rod.T.gap [m]",
        "ground_0.rod.T.normal [N]",
    ]
    numbers = np.array(rows, dtype=float)
    assert numbers[:, 0] == pytest.approx(np.linspace(0, 2, 21), abs=0)
    assert numbers[-1, 2:] == pytest.approx([G, 0.0, G], rel=1e-11, abs=1e-11)
    assert "removed" not in done.stdout
    (folder / "notes.csv").write_text("not of ccgen")
    done = CliRunner().invoke(app, ["run", str(scene), "--plot", "rod.angle"])
    assert done.exit_code == 0 and not (folder / "outputs.csv").exists()  # that of an older run
    told = [line for line in done.stdout.splitlines() if line.startswith("removed")]
    gone = [str(folder / name) for name in ("forces.csv", "impacts.csv", "outputs.csv", "phases.csv")]
    assert told == [f"removed, as of the run before: {', '.join(gone)}"]
    assert (folder / "notes.csv").exists() and not any(Path(name).exists() for name in gone)
    done = CliRunner().invoke(app, ["run", str(scene), "-q"])
    assert done.exit_code == 0 and not (folder / "outputs.png").exists()


def test_pictures_say_what_was_set(scene: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Over plot, forces, outputs and the player stand the values, as written, of --set; over pictures that are drawn
    later those that are not the scene's; nothing over those of the scene itself."""
    titles: list[str] = []
    usual = Figure.suptitle

    def suptitle(figure: Figure, text: str, **other: Any) -> Any:
        titles.append(text)
        return usual(figure, text, **other)

    monkeypatch.setattr(Figure, "suptitle", suptitle)
    command = ["run", str(scene), "--plot", "rod.angle", "-q"]
    page = Path("results/leaning/player.html")
    for settings, told in (
        ([], "leaning"),
        (["rod.mass=2 kg"], "leaning, rod.mass = 2 kg"),
        (
            [f"{path}=1.5" for path in ("rod.mass", "rod.inertia", "gravity.g", "rod.points.T.x")],
            "leaning, rod.mass = 1.5, rod.inertia = 1.5, gravity.g = 1.5, and 1 more",
        ),
    ):
        done = CliRunner().invoke(app, [*command, *(part for one in settings for part in ("--set", one))])
        assert done.exit_code == 0, done.output
        assert sorted(titles) == [told, told, f"{told}: forces"]
        html = page.read_text(encoding="utf-8")
        assert data_of(html)["name"] == told and f"<title>{told}</title>" in html
        titles.clear()
    done = CliRunner().invoke(app, ["run", str(scene), "--set", "gravity.g=1.5", "-q"])
    done = CliRunner().invoke(app, ["plot", "results/leaning", "rod.angle"])
    assert done.exit_code == 0 and titles[-1] == "leaning, gravity.g = 1.5"


def test_rows_have_both_sides_of_an_impact(scene: Path) -> None:
    done = CliRunner().invoke(app, ["run", str(scene), "--plot", "rod.angular_velocity", "--csv", "-q"])
    assert done.exit_code == 0
    with Path("results/leaning/outputs.csv").open(newline="") as file:
        numbers = np.array([*csv.reader(file)][1:], dtype=float)
    (jump,) = np.flatnonzero((np.diff(numbers[:, 0]) == 0.0) & (np.diff(numbers[:, 1]) != 0.0))
    assert numbers[jump, 1] != 0.0 and numbers[jump + 1, 1] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--plot", "rod.angel"], "--plot: found 'rod.angel', which nothing is called, expected one such as rod.angle"),
        (["--plot", "hinge.torque"], "'hinge.torque', which nothing is called, expected one such as hinge.moment;"),
        (["--plot", "motor.reaction"], "which nothing is called, expected one such as hinge.force;"),
        (["--plot", " , "], '--plot: found " , ", expected names with commas between them'),
        (["--times", "5"], "--times: found without --csv, expected it"),
        (["--plot", "t", "--csv", "--times", "1"], "--times: found 1, expected a whole number from 2 to 1000000"),
        (["--plot", "t", "--csv", "--times", "x"], "--times: found x, expected a whole number from 2 to 1000000"),
    ],
)
def test_wrong_options_are_told_and_nothing_is_written(scene: Path, options: list[str], told: str) -> None:
    done = CliRunner().invoke(app, ["run", str(scene), *options])
    assert done.exit_code == 2 and told in done.stderr and not Path("results").exists()


def test_a_video_needs_ffmpeg(scene: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    done = CliRunner().invoke(app, ["run", str(scene), "--video"])
    assert done.exit_code == 2 and "--video: found no ffmpeg on PATH, expected" in done.stderr
    assert not Path("results").exists()


def test_names_are_listed(scene: Path) -> None:
    done = CliRunner().invoke(app, ["show", str(scene), "--outputs"])
    assert done.exit_code == 0
    lines = done.stdout.splitlines()
    assert "rod: angle [rad], angular_velocity [rad/s], angular_acceleration [rad/s^2]" in lines
    assert any(line.startswith("ground_0.rod.T: gap [m], gap_rate [m/s], normal [N]") for line in lines)
    done = CliRunner().invoke(app, ["show", str(scene), "--outputs", "--tolerances", "--latex"])
    assert done.exit_code == 2
    assert "--outputs: found beside --tolerances" in done.stderr and "--latex: found beside" in done.stderr


def test_outputs_of_one_unit_share_a_panel(workshop: Workshop) -> None:
    pytest.importorskip("matplotlib")
    from ccgen.runtime import simulate

    run = simulate(workshop.model(LEANING))
    names = ["rod.angle", "hinge.fx", "ground_0.rod.T.normal", "rod.T.ax", "hinge.angle"]
    figure = draw_outputs(run, names)
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert labels == ["angle [rad]", "force [N]", "ax [m/s²]"]
    assert [line.get_label() for line in figure.axes[0].lines[:2]] == ["rod.angle", "hinge.angle"]
    t, force = figure.axes[1].lines[1].get_data()
    assert len(t) > 600 and force[-1] == pytest.approx(G, rel=1e-11)
    with pytest.raises(ValueError, match="which nothing is called"):
        draw_outputs(run, ["rod.wobble"])


def test_of_a_point_the_path_is_drawn(workshop: Workshop) -> None:
    """Below what is drawn over time, alike in both directions: the tip of a rod goes along a circle about its hinge."""
    pytest.importorskip("matplotlib")
    from ccgen.runtime import simulate

    run = simulate(workshop.model(LEANING))
    figure = draw_outputs(run, ["rod.T", "rod.angle", "hinge.fx", "rod.A"])
    assert [axes.get_ylabel() for axes in figure.axes] == ["angle [rad]", "fx [N]", "y [m]"]
    path = figure.axes[2]
    assert path.get_aspect() == 1.0 and [text.get_text() for text in path.get_legend().get_texts()] == [
        "rod.T",
        "rod.A",
    ]
    x, y = path.lines[0].get_data()
    assert np.ptp(x) > 0.1 and np.hypot(x, y - 0.5) == pytest.approx(np.ones(len(x)), rel=1e-12)
    (alone,) = draw_outputs(run, ["rod.T"]).axes
    assert alone.get_xlabel() == "x [m]"


def test_a_path_is_asked_for_by_its_point(scene: Path) -> None:
    """The player and the table have its coordinates."""
    done = CliRunner().invoke(app, ["run", str(scene), "--plot", "rod.T,rod.angle,rod.T.x", "--csv"])
    assert done.exit_code == 0
    folder = Path("results/leaning")
    page = data_of((folder / "player.html").read_text(encoding="utf-8"))
    assert page["plotted"] == ["rod.T.x", "rod.T.y", "rod.angle"]
    with (folder / "outputs.csv").open(newline="") as file:
        assert next(csv.reader(file)) == ["t [s]", "rod.T.x [m]", "rod.T.y [m]", "rod.angle [rad]"]
    done = CliRunner().invoke(app, ["run", str(scene), "--plot", "rod.U"])
    assert done.exit_code == 2 and "found 'rod.U', which nothing is called" in done.stderr


def test_thresholds_are_those_of_the_values_that_are_set(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The characteristic time of what hangs is that of a swing: as the root of the length over gravity."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "pendulum.toml").write_text(PENDULUM)

    def time(*options: str) -> float:
        done = CliRunner().invoke(app, ["show", "pendulum.toml", "--tolerances", "-q", *options])
        assert done.exit_code == 0, done.stderr
        return float(done.stdout.partition("characteristic time ")[2].split()[0])

    assert time("--set", "gravity.g=2.4525") == pytest.approx(2.0 * time(), rel=1e-3)
