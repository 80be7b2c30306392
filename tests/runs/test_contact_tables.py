"""What is written of impacts and phases, how deep contacts are, and when a choice was: against closed forms."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from ccgen.generator.cli.app import app
from ccgen.runtime import simulate
from ccgen.runtime.record.contact_tables import write_impacts, write_phases

from ..support.sliding_rod import ROD
from ..support.workshop import Workshop

G, E, MU, HEIGHT, SPEED = 9.81, 0.5, 0.2, 0.5, 2.0
DISC = f"""\
name = "disc"
[[link]]
name = "disc"
mass = 2.0
inertia = 0.01
com = "C"
points = {{ C = [0, 0] }}
[ground_link]
points = {{ O = [0, 0] }}
[gravity]
g = {G}
[[ground]]
name = "floor"
contacts = ["disc.C"]
restitution = {E}
friction = {MU}
[start]
poses = {{ disc = [0, {HEIGHT}, 0] }}
velocity = [{SPEED}, 0]
[run]
until = 0.7
"""
"""A mass in a parabola that strikes a rough floor, once within 0.6 s: it slides in the impact."""
STOPPED = f"""\
name = "stopped"
[ground_link]
points = {{ O = [0, 0] }}
[[link]]
name = "rod"
mass = 1.0
inertia = {1 / 12}
com = [0.5, 0]
points = {{ A = [0, 0], B = [1, 0] }}
[[joint]]
name = "pin"
between = ["ground.O", "rod.A"]
[[stop]]
joint = "pin"
lowest = "-30 deg"
restitution = 0.4
[gravity]
g = {G}
[start]
angles = ["30 deg"]
"""
SLIDING = ROD.replace("[gravity]", "angular_velocities = [8.0]\n[gravity]").replace("until = 2.0", "until = 0.1")
"""It turns so fast that it would lift off if friction did not hold it down: both are motions (Painleve)."""


def table(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_impacts_are_written_as_they_were(workshop: Workshop, tmp_path: Path) -> None:
    """Of a ball in closed form: when, how fast, what pushes, what rubs, what is lost and left."""
    run = simulate(workshop.model(DISC), until=0.6)
    lines = table(write_impacts(run, tmp_path / "impacts.csv"))
    assert [line["number"] for line in lines] == ["1"]
    (line,) = lines
    down, along = np.sqrt(2 * G * HEIGHT), SPEED
    pushed = 2.0 * (1 + E) * down
    after = 0.5 * 2.0 * ((E * down) ** 2 + (along - MU * pushed / 2.0) ** 2)
    expected = {
        "t [s]": np.sqrt(2 * HEIGHT / G),
        "speed before [m/s; rad/s]": -down,
        "impulse [N s; N m s]": pushed,
        "friction [N s]": -MU * pushed,
        "restitution share": 1.0,
        "energy lost [J]": 0.5 * 2.0 * (down**2 + along**2) - after,
        "energy after [J]": after,
    }
    assert {name: float(line[name]) for name in expected} == pytest.approx(expected, rel=1e-9)
    assert (line["point"], line["ground"]) == ("disc.C", "floor")


def test_phases_are_written_as_they_were(workshop: Workshop, tmp_path: Path) -> None:
    """It comes to rest by impacts without restitution: flight, impact, contact, each with its place in time."""
    model = workshop.model(DISC).with_parameters({"floor.restitution": 0.0, "floor.friction": 0.0})
    lines = table(write_phases(simulate(model), tmp_path / "phases.csv"))
    falls = np.sqrt(2 * HEIGHT / G)
    assert [line["kind"] for line in lines] == ["flight", "impact", "contact"]
    spans = [(float(line["start [s]"]), float(line["end [s]"])) for line in lines]
    assert np.array(spans) == pytest.approx(np.array([(0.0, falls), (falls, falls), (falls, 0.7)]), rel=1e-9)
    assert [line["how"] for line in lines] == ["", "", "smooth"] and lines[2]["point"] == "disc.C"
    assert all(line["step [s]"] == line["missed [rad, lengths]"] == "" for line in lines)


def test_time_stepping_is_written_with_its_step(workshop: Workshop, tmp_path: Path) -> None:
    run = simulate(workshop.model(DISC), method="moreau", step=1e-3)
    (line,) = table(write_phases(run, tmp_path / "phases.csv"))
    assert line["kind"] == "steps" and float(line["step [s]"]) == pytest.approx(1e-3)


def test_the_command_writes_them_where_something_can_strike(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Asked for by --csv; what an earlier run wrote does not stay beside one that has none."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "disc.toml").write_text(DISC)
    (tmp_path / "free.toml").write_text(
        DISC.replace("[[ground]]", "[off]").partition("[off]")[0] + "[run]\nuntil = 0.1\n"
    )
    for scene, options, there in (("disc", ["--csv"], True), ("disc", [], False), ("free", ["--csv"], False)):
        done = CliRunner().invoke(app, ["run", f"{scene}.toml", "--out", "results/one", *options])
        assert done.exit_code == 0, done.output
        for name in ("impacts.csv", "phases.csv"):
            assert (tmp_path / "results" / "one" / name).exists() == there
            written = done.output.partition("written: ")[2].partition("\n")[0]
            assert (f"results/one/{name}" in written) == there


def test_how_deep_contacts_are_is_an_audit(workshop: Workshop, capsys: pytest.CaptureFixture[str]) -> None:
    """A run is not in the floor; with a row a millimetre below, that; of a stop the angle by the mechanism's length."""
    from ccgen.generator.cli.report import print_audit

    run = simulate(workshop.model(DISC))
    assert 0.0 <= run.penetration_max <= 1e-13
    q = run.q.copy()
    q[3, 1] = -1e-3
    deep = replace(run, q=q)
    assert deep.penetration_max == pytest.approx(1e-3, rel=1e-12)
    print_audit(deep)
    assert "audit: contacts at most 1.0e-03 m deep, energy" in capsys.readouterr().out

    stopped = simulate(workshop.model(STOPPED), until=0.1)
    q = stopped.q.copy()
    q[-1, 0] = -np.pi / 6 - 1e-3
    assert replace(stopped, q=q).penetration_max == pytest.approx(1e-3 * stopped.model.length, rel=1e-9)
    assert str(stopped.penetration_max) == "0.0"


def test_a_model_without_contacts_enters_nothing(workshop: Workshop, capsys: pytest.CaptureFixture[str]) -> None:
    from ccgen.generator.cli.report import print_audit

    run = simulate(
        workshop.model(STOPPED.replace("[[stop]]\njoint", "[output]\n#").partition("[output]")[0]), until=0.1
    )
    assert run.penetration_max == 0.0
    print_audit(run)
    assert "audit: energy" in capsys.readouterr().out


@pytest.fixture
def undecided(workshop: Workshop) -> Any:
    return workshop.model(SLIDING)


def test_it_is_told_when_a_choice_was(undecided: Any, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """The first of them; a file knows it too, and a run that goes on from there tells of its own."""
    from ccgen.generator.cli.report import print_warnings
    from ccgen.runtime import load_run

    run = simulate(undecided)
    assert (run.choices, run.chosen_at) == (1, 0.0)
    print_warnings(run)
    note = "note: at 1 instant, the first at t = 0 s, contacts that slide could as well have stayed as left (Painleve)"
    assert note in capsys.readouterr().err
    later = simulate(undecided, state=run.state, until=0.2)
    assert (later.choices, later.chosen_at) == (0, None)
    read = load_run(run.save(tmp_path / "run.npz"), undecided)
    assert (read.choices, read.chosen_at) == (1, 0.0)


def test_without_a_choice_there_is_no_time_of_one(workshop: Workshop) -> None:
    run = simulate(workshop.model(DISC))
    assert (run.choices, run.chosen_at) == (0, None)


def test_pictures_say_what_their_marks_are(workshop: Workshop) -> None:
    """One word for each kind of mark that there is."""
    model = workshop.model(DISC)

    def words(figure: Any) -> list[str]:
        (part,) = [part for part in [figure, *figure.subfigs] if part.legends]
        return [text.get_text() for text in part.legends[0].get_texts()]

    still = simulate(model.with_parameters({"floor.restitution": 0.0}))
    assert words(still.plot()) == ["impact", "in contact"]
    assert words(simulate(model, method="moreau", step=1e-2).plot()) == ["time stepping"]
    flight = simulate(model, until=0.1).plot()
    assert not any(part.legends for part in [flight, *flight.subfigs])


def test_stops_of_a_joint_that_lets_go_are_told(workshop: Workshop, tmp_path: Path) -> None:
    """Only the structure that holds the joint knows its stop: depth and speeds are that structure's."""
    release = '[[release]]\njoint = "pin"\nat = 0.7\n'
    run = simulate(workshop.model(STOPPED.replace("[gravity]", f"{release}[gravity]")), until=0.8)
    (line,) = table(write_impacts(run, tmp_path / "impacts.csv"))
    speed = np.sqrt(3.0 * G)  # of a rod that falls from 30 to -30 degrees about its end
    assert float(line["speed before [m/s; rad/s]"]) == pytest.approx(-speed, rel=1e-9)
    assert (line["point"], line["ground"]) == ("pin", "stop_0.lowest") and run.changes
    holding = run.advance.pieces[0]  # type: ignore[attr-defined]
    q = holding.run.q.copy()
    q[1, 0] = -np.pi / 6 - 1e-3
    deep = replace(holding, run=replace(holding.run, q=q))
    advance = replace(run.advance, pieces=(deep, *run.advance.pieces[1:]))  # type: ignore[attr-defined,type-var]
    found = replace(run, advance=advance).penetration_max
    assert found == pytest.approx(1e-3 * holding.run.model.length, rel=1e-9)


def test_choices_are_counted_once(workshop: Workshop) -> None:
    """A run with an event that never comes goes on from piece to piece."""
    event = '[[event]]\nname = "late"\nwhen = "t - 5"\nset = { "gravity.g" = 5.0 }\n'
    run = simulate(workshop.model(SLIDING.replace("[run]", f"{event}[run]")))
    assert (run.choices, run.chosen_at) == (1, 0.0)


def test_what_is_off_is_not_deep(workshop: Workshop) -> None:
    """A floor that an event takes away lets the mass through, which is no depth."""
    event = '[[event]]\nname = "gone"\nwhen = "t - 0.2"\noff = ["floor"]\n'
    run = simulate(workshop.model(DISC.replace("[start]", f"{event}[start]")))
    assert run.success and run.q[-1, 1] < -0.1 and run.penetration_max <= 1e-13
