"""What ``ccgen run`` prints, draws and writes of forces."""

from __future__ import annotations

import csv
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from ccgen.generator.cli.app import app
from ccgen.generator.cli.forces import Told, first_largest, print_forces
from ccgen.runtime import simulate
from ccgen.runtime.pictures.force_plot import draw_forces
from ccgen.runtime.record.force_history import away_from_lines, history, write_csv

from ..support.leaning_rod import LEANING, G
from ..support.touching_scenes import disc_on_plank
from ..support.workshop import Workshop


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "leaning.toml"
    file.write_text(LEANING)
    return file


def test_a_run_tells_its_largest_forces(scene: Path) -> None:
    done = CliRunner().invoke(app, ["run", str(scene), "--csv"])
    assert done.exit_code == 0
    lines = done.stdout.splitlines()
    at = lines.index("largest forces between impacts:")
    assert lines[at + 1].split() == ["rod.T", "on", "ground_0", "9.81", "N", "at", "t", "=", "0.268008", "s"]
    assert lines[at + 2].split()[0] == "hinge"
    # the ground stops the rod, half a turn by twelve down, and so does the hinge: 2 kg * 0.5 m * omega - impulse at T
    omega = math.sqrt(2.0 * 2.0 * G * 0.25 / (0.1667 + 2.0 * 0.25))
    push = (0.1667 + 2.0 * 0.25) * omega / math.cos(math.pi / 6.0)
    impulse = math.hypot(omega * math.sin(math.pi / 6.0), omega * math.cos(math.pi / 6.0) - push)
    assert lines[at + 2].endswith(f", in impacts up to {impulse:.6g} N s")
    folder = Path("results/leaning")
    assert (folder / "forces.png").read_bytes()[:4] == b"\x89PNG"
    with (folder / "forces.csv").open(newline="") as file:
        head, *rows = csv.reader(file)
    assert head == [
        "t [s]", "ground_0.rod.T.normal [N]", "ground_0.rod.T.friction [N]",
        "hinge.fx [N on rod]", "hinge.fy [N on rod]", "hinge.moment [N m on rod]",
    ]  # fmt: skip
    numbers = np.array(rows, dtype=float)
    assert numbers[0, 0] == 0.0 and numbers[-1, 0] == 2.0 and np.all(np.diff(numbers[:, 0]) >= 0.0)
    assert numbers[-1, 1:] == pytest.approx([G, 0.0, 0.0, G, 0.0], rel=1e-12, abs=1e-12)
    (jump,) = np.flatnonzero(np.diff(numbers[:, 0]) == 0.0)  # on both sides of the impact
    assert numbers[jump, 1] == 0.0 and numbers[jump + 1, 1] == pytest.approx(G, rel=1e-11)


def test_what_cannot_be_made_of_a_run_is_said_and_the_rest_is_written(
    scene: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As where forces have no solution at an instant that is looked at: no traceback, and no file of an older run."""
    assert CliRunner().invoke(app, ["run", str(scene), "--csv"]).exit_code == 0

    def none(*_: object) -> None:
        raise ValueError("the forces at t = 1 have no solution")

    for module in ("pictures.force_plot", "record.force_history"):
        monkeypatch.setattr(f"ccgen.runtime.{module}.history", none)
    done = CliRunner().invoke(app, ["run", str(scene), "--csv"])
    assert done.exit_code == 3
    assert done.stderr.splitlines() == [
        f"leaning: {name} is not written: the forces at t = 1 have no solution" for name in ("forces.png", "forces.csv")
    ]
    assert "no forces: the forces at t = 1 have no solution" in done.stdout
    files = {path.name for path in Path("results/leaning").iterdir()}
    tables = {"impacts.csv", "phases.csv"}
    assert files == {".ccgen.json", "result.npz", "plot.png", "player.html", *tables}


def test_what_ccgen_did_not_write_is_kept(scene: Path) -> None:
    own = Path("results/leaning/forces.png")
    own.parent.mkdir(parents=True)
    own.write_text("mine")
    done = CliRunner().invoke(app, ["run", str(scene)])
    assert done.exit_code == 2 and own.read_text() == "mine"


STOPPED = """
name = "stopped"
[chain]
links = 2
hinged = true
[gravity]
[[stop]]
joint = "joint_1"
lowest = "-30 deg"
highest = "30 deg"
restitution = 0.5
[[ground]]
point = [0.0, -1.5]
restitution = 0.5
friction = 0.3
contacts = ["link_1.B"]
[run]
until = 1.0
"""


def test_stops_have_a_moment_and_no_friction_in_the_table(workshop: Workshop, tmp_path: Path) -> None:
    run = simulate(workshop.model(STOPPED))
    with write_csv(run, tmp_path / "forces.csv").open(newline="") as file:
        head, *rows = csv.reader(file)
    names = [f"{ground}.{point}" for point, ground in run.model.contacts]
    stops = [name for name, (_, ground) in zip(names, run.model.contacts, strict=True) if ground in run.model.stops]
    assert len(stops) == 2 and len(names) == 3
    for name in names:
        ends = ["moment [N m]"] if name in stops else ["normal [N]", "friction [N]"]
        assert [column for column in head if column.startswith(f"{name}.")] == [f"{name}.{end}" for end in ends]
    numbers, found = np.array(rows, dtype=float), history(run)
    for k, name in enumerate(names):
        kept = 1 if name in stops else 2
        at = next(i for i, column in enumerate(head) if column.startswith(f"{name}."))
        assert np.array_equal(numbers[:, at : at + kept], found.pushes[:, k, :kept])
    assert np.array_equal(numbers[:, -3:], found.reactions[:, -1])
    assert not found.pushes[:, [name in stops for name in names], 1].any()


def test_the_largest_is_told_where_it_is_first_reached() -> None:
    """Not where the last digit happens to be larger."""
    steady = 9.81 + 1e-14 * np.array([-1e14, 0.0, 30.0, 10.0, 50.0])
    growing = np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    assert first_largest(np.column_stack([steady, growing, growing[::-1], 0.0 * growing])) == [1, 4, 0, 0]
    assert first_largest(np.zeros((0, 2))) == []


def test_forces_on_both_sides_of_a_jump_are_those_of_the_run(workshop: Workshop) -> None:
    run = simulate(workshop.model(LEANING))
    found = history(run, 100)
    (impact,) = run.impacts
    at = np.flatnonzero(found.t == impact.t)
    assert len(at) == 2
    assert found.pushes[at[0], 0, 0] == 0.0 and found.pushes[at[1], 0, 0] == pytest.approx(G, rel=1e-11)
    assert np.allclose(found.reactions[at[0]], run.reactions(impact.t - 1e-9), atol=1e-5)
    after = found.t > impact.t
    assert np.array_equal(found.reactions[after], run.reactions(found.t[after]))


@pytest.mark.sample(2)
@pytest.mark.parametrize("thickness", [0.02, 1e-12])
@pytest.mark.parametrize("friction", ["", "friction = 0.5"])
def test_contacts_push_to_the_end_of_their_touch(friction: str, thickness: float, workshop: Workshop) -> None:
    """A disc runs down a plank and leaves it at its end, where the gap is to what comes next."""
    model = workshop.model(disc_on_plank(0.3, 0.2, f"restitution = 0.0\n{friction}", thickness=thickness))
    run = simulate(model, until=1.5)
    assert [phase.kind for phase in run.phases] == ["contact", "flight"], run.message
    found = history(run)
    normal, at = found.pushes[:, 0, 0], int(np.flatnonzero(found.t == run.phases[0].end)[0])
    weight = G * math.cos(0.3) * float(model.parameters["disc.mass"])
    assert np.max(np.abs(normal[: at - 20] - weight)) <= 1e-9 * weight
    assert np.min(normal) >= 0.0 and np.max(normal) <= weight * (1.0 + 1e-9) and normal[at + 1] == 0.0


def test_the_picture_has_a_panel_for_what_there_is(workshop: Workshop, tmp_path: Path) -> None:
    run = simulate(workshop.model(LEANING))
    figure: Any = draw_forces(run, tmp_path / "forces.png")
    assert [axes.get_ylabel() for axes in figure.axes] == ["normal force [N]", "joint force [N]"]
    with pytest.raises(ValueError, match=r"saved as .png"):
        draw_forces(run, tmp_path / "forces.pdf")


def test_what_never_pushes_and_what_is_rounding_is_not_drawn(workshop: Workshop, tmp_path: Path) -> None:
    """A block rests on level rough ground on two of its four corners: nothing rubs."""
    run = simulate(workshop.model(BLOCK), until=0.5)
    figure: Any = draw_forces(run, tmp_path / "forces.png")
    (axes,) = figure.axes
    assert axes.get_ylabel() == "normal force [N]"
    assert {"block.A", "block.B"} <= {line.get_label() for line in axes.lines}
    assert not {"block.C", "block.D"} & {line.get_label() for line in axes.lines}
    assert np.max(np.abs(history(run).pushes[:, :, 1])) <= 1e-13 * G


BLOCK = """
name = "block"
[[link]]
name = "block"
mass = 1
inertia = 0.2
com = [0.5, 0.5]
points = { A = [0, 0], B = [1, 0], C = [1, 1], D = [0, 1] }
[gravity]
[[ground]]
restitution = 0
friction = 0.5
contacts = ["block.A", "block.B", "block.C", "block.D"]
"""


SWING = """
name = "swing"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "rod"
rod = { mass = 2.0 }
points = { A = [0, 0], tip = [1, 0] }
[[joint]]
name = "hinge"
between = ["ground.O", "rod.A"]
[gravity]
g = 9.81
[run]
until = 2.0
"""


def test_joints_tell_their_forces_where_nothing_touches(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A rod let go level: at its lowest the pin carries 5/2 of the weight. Without gravity it rests, and nothing is
    told."""
    monkeypatch.chdir(tmp_path)
    scene = tmp_path / "swing.toml"
    scene.write_text(SWING)
    lines = CliRunner().invoke(app, ["run", str(scene)]).stdout.splitlines()
    told = lines[lines.index("largest forces:") + 1].split()
    assert told[0] == "hinge" and float(told[1]) == pytest.approx(2.5 * 2.0 * G, rel=1e-4)
    assert Path("results/swing/forces.png").read_bytes()[:4] == b"\x89PNG"
    done = CliRunner().invoke(app, ["run", str(scene), "--set", "gravity.g=0"])
    assert done.exit_code == 0 and "largest forces" not in done.stdout
    assert "forces.png" not in done.stdout.partition("written: ")[2].partition("\n")[0]
    assert "removed, as of the run before: results/swing/forces.png" in done.stdout
    assert not Path("results/swing/forces.png").exists()


FREE = """
name = "eccentric"
[[link]]
name = "one"
free = true
mass = 2.0
inertia = 1e-2
com = [0.031, 0.02]
points = { C = [0, 0] }
[[link]]
name = "other"
free = true
mass = 1.7
inertia = 1e-2
com = [0.031, 0.02]
points = { C = [0, 0] }
[start]
poses = { one = [0, 1, 0], other = [1, 1.03, 0] }
sliding_velocities = { one_x = 3.0, one_y = 0.5 }
angular_velocities = { one = 7.3, other = -3 }
[run]
until = 1.0
"""


def test_joints_that_place_free_bodies_tell_forces_only_where_they_carry_some(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What flies by itself they only measure: their forces are rounding. A drive along one is a force in both."""
    monkeypatch.chdir(tmp_path)
    Path("flying.toml").write_text(FREE)
    done = CliRunner().invoke(app, ["run", "flying.toml"])
    assert done.exit_code == 0 and "largest forces" not in done.stdout
    assert "forces.png" not in done.stdout.partition("written: ")[2].partition("\n")[0]
    Path("driven.toml").write_text(FREE + '[[drive]]\njoint = "one_x"\nposition = "3*t"\n')
    lines = CliRunner().invoke(app, ["run", "driven.toml"]).stdout.splitlines()
    at = lines.index("largest forces:")
    told = [line.split() for line in lines[at + 1 : lines.index("drives at most:")]]
    assert [words[0] for words in told] == ["one_x", "one_y"]
    # the drive takes the point straight on, and the mass centre swings about it
    assert told[0][1] == told[1][1] and float(told[0][1]) > 1.0


def test_the_table_of_forces_has_the_times_that_are_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """At first the pin of a level rod carries a quarter of its weight, upwards."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "swing.toml").write_text(SWING)
    assert CliRunner().invoke(app, ["run", "swing.toml", "--csv", "--times", "21"]).exit_code == 0
    head, *rows = csv.reader(Path("results/swing/forces.csv").read_text().splitlines())
    numbers = np.array(rows, dtype=float)
    assert head[1:3] == ["hinge.fx [N on rod]", "hinge.fy [N on rod]"]
    assert np.array_equal(numbers[:, 0], np.linspace(0.0, 2.0, 21))
    assert numbers[0, 1:3] == pytest.approx([0.0, 2.0 * G / 4.0], abs=1e-12)


def test_forces_of_redundant_joints_are_told_as_shared(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A rod on two hinges in one place: each bears half of what one would."""
    monkeypatch.chdir(tmp_path)
    scene = tmp_path / "swing.toml"
    other = '[[joint]]\nname = "other"\nbetween = ["ground.O", "rod.A"]\n'
    scene.write_text(SWING.replace("[gravity]", f"{other}[gravity]"))
    lines = CliRunner().invoke(app, ["run", str(scene)]).stdout.splitlines()
    at = lines.index("largest forces, those of redundant joints of least norm:")
    sizes = {line.split()[0]: float(line.split()[1]) for line in lines[at + 1 : at + 3]}
    assert sizes == pytest.approx({"hinge": 2.5 * G, "other": 2.5 * G}, rel=1e-4)


def test_what_rises_to_a_line_of_links_is_no_largest_force() -> None:
    """A force of 1 / |t - 1|, not known within 0.01 of 1, through a change of contact at 0.5, and a hill of 3 at 2."""
    t = np.sort(np.append(np.linspace(0.0, 3.0, 301), 0.5))
    sizes = 1.0 / np.maximum(np.abs(t - 1.0), 1e-9)
    sizes[t > 1.4] = 3.0 - np.abs(t[t > 1.4] - 2.0)
    known = np.abs(t - 1.0) > 0.011
    beside = known & (np.abs(t - 1.0) < 0.021)
    t, sizes, beside = t[known], sizes[known], beside[known]
    assert beside.sum() == 2 and sizes.max() > 40.0
    away = away_from_lines(t, sizes, beside)
    assert not away[t < 1.395].any() and away[(t > 1.45) & (t < 3.0)].all()
    assert sizes[away].max() == 3.0
    assert away_from_lines(t, sizes, 0 * t > 1.0).all()


FLOPPY = """
name = "floppy-box"
[loop]
links = 4
length = 0.4
mass = 0.5
[start]
height = 1.0
tilt = "20 deg"
velocity = [1.5, 0]
[gravity]
[[ground]]
normal = ["-sin(15*pi/180)", "cos(15*pi/180)"]
restitution = 0.4
friction = 0.6
[run]
until = 1.5
"""


def test_a_box_that_folds_into_its_line_tells_the_same_forces_by_all_methods(workshop: Workshop) -> None:
    """It follows its branch through the line, at 1.106 s: no instant lies so near that forces are not told."""
    model = workshop.model(FLOPPY)
    runs = [simulate(model, until=1.11, **how) for how in ({}, {"rtol": 1e-10}, {"method": "dop853"})]
    told = [largest_at_joints(one) for one in runs]
    assert told == pytest.approx([told[0]] * 3, rel=0.05)
    for one in runs:
        found = history(one)
        sizes = np.hypot(found.reactions[:, :, 0], found.reactions[:, :, 1])
        assert np.nanmax(sizes) == pytest.approx(told[0], rel=0.05)


def largest_at_joints(run: Any) -> float:
    """The largest force of a joint that is told (N)."""
    return max(float(size.split()[0]) for name, size, _, _ in Told(run).rows if name in run.model.joints)


SHAKEN = """
name = "shaken"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "rod"
mass = 2.0
inertia = 0.3
com = [0, 0]
points = { A = [0, 0] }
[[link]]
name = "block"
mass = 2.0
inertia = 0.1
com = [0, 0]
points = { B = [0, 0] }
[[joint]]
name = "axle"
between = AXLE
[[joint]]
name = "lift"
type = "prismatic"
between = ["ground.O", "block.B"]
axis = [0, 1]
[gravity]
g = 9.81
[[drive]]
joint = "axle"
angle = "0.5*sin(3*t)"
[[drive]]
joint = "lift"
position = "0.1*sin(2*t)"
[run]
until = 1.5
"""


@pytest.mark.parametrize("turned", [False, True])
def test_drives_tell_their_largest_torque_force_and_power(
    turned: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A wheel that a drive swings about its centre takes I phi'' and gives I phi' phi''; a block that one moves up and
    down takes m (g + y''). The torque is that on the joint's second link, whichever is the
    ground."""
    monkeypatch.chdir(tmp_path)
    between = ["ground.O", "rod.A"]
    (tmp_path / "shaken.toml").write_text(SHAKEN.replace("AXLE", str(between[::-1] if turned else between)))
    lines = CliRunner().invoke(app, ["run", "shaken.toml"]).stdout.splitlines()
    at = lines.index("drives at most:")
    told = {line.split()[0]: line.split()[1:] for line in lines[at + 1 : at + 3]}

    words = " ".join(told["axle"])  # I phi'' = -1.35 sin 3t, I phi' phi'' = -1.0125 sin 6t
    assert re.sub(r"-?\d[\d.e-]*", "#", words) == "torque # N m at t = # s, gives # W at t = # s, takes # W at t = # s"
    wanted = [-1.35, math.pi / 6.0, 1.0125, math.pi / 4.0, 1.0125, math.pi / 12.0]
    assert numbers_in(words) == pytest.approx(wanted, rel=1e-5)

    t = np.linspace(0.0, 1.5, 1_000_001)
    force = 2.0 * (9.81 - 0.4 * np.sin(2.0 * t))
    power = force * 0.2 * np.cos(2.0 * t)
    peaks = [(force.max(), t[force.argmax()]), (power.max(), t[power.argmax()]), (-power.min(), t[power.argmin()])]
    assert numbers_in(" ".join(told["lift"])) == pytest.approx(np.ravel(peaks), rel=1e-5, abs=1e-9)


def numbers_in(text: str) -> list[float]:
    return [float(word) for word in re.findall(r"(?<= )-?\d[\d.e-]*", text)]


JAW = """
name = "jaw"
[ground_link]
points = { A = [0, 0], B = [0, -0.04] }
[[link]]
name = "crank"
rod = { mass = 0.1 }
points = { A = [0, 0], C = [0.08, 0] }
[[link]]
name = "lever"
rod = { mass = 0.1 }
points = { B = [0, 0], D = [0.08, 0] }
[[link]]
name = "jaw"
rod = { mass = 0.15 }
points = { D = [0, 0], C = [0, 0.04] }
[[joint]]
name = "a"
between = ["ground.A", "crank.A"]
[[joint]]
name = "b"
between = ["ground.B", "lever.B"]
[[joint]]
name = "c"
between = ["crank.C", "jaw.C"]
[[joint]]
name = "d"
between = ["lever.D", "jaw.D"]
[start]
angles = { crank = "START", jaw = 0 }
[[motor]]
joint = "a"
torque = -1.0
[run]
until = 0.06
rtol = 1e-9
"""


def told_of_jaw(printed: str) -> tuple[float, list[str]]:
    """The largest of the forces that are told, 0 without any, and what is said of lines."""
    lines = printed.splitlines()
    first = lines[lines.index("largest forces:") + 1].split() if "largest forces:" in lines else ["", "0"]
    return float(first[1]), [line for line in lines if "near a line of links" in line]


def test_a_change_point_that_is_passed_between_instants_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, workshop: Workshop, capsys: pytest.CaptureFixture[str]
) -> None:
    """A parallelogram turns by its motor's torque alone, M / (2 m l^2 / 3 + m_jaw l^2) evenly faster, through the line
    of its links at 90 degrees. The jaw turns the lever by its force along the line times an arm that vanishes there:
    the largest force would be that of the nearest instant. At another tolerance, with instants elsewhere, the same is
    told. What does not come to the line says nothing of it.

    Two runs are those of the command, whose pictures take most of its time; of the others is printed what it prints."""
    monkeypatch.chdir(tmp_path)
    Path("jaw.toml").write_text(JAW.replace("START", "100 deg"))

    def told_by_command(*options: str) -> tuple[float, list[str]]:
        return told_of_jaw(CliRunner().invoke(app, ["run", "jaw.toml", *options]).stdout)

    def told_of(start: str, rtol: float, until: float = 0.06) -> tuple[float, list[str]]:
        run = simulate(workshop.model(JAW.replace("START", start)), until=until, rtol=rtol)
        print_forces(Told(run))
        return told_of_jaw(capsys.readouterr().out)

    inertia = 2.0 * 0.1 * 0.08**2 / 3.0 + 0.15 * 0.08**2
    passed = math.sqrt(2.0 * math.radians(10.0) * inertia)
    told = [told_by_command(), *(told_of("100 deg", rtol) for rtol in (1e-6, 1e-12))]
    for _, lines in told:
        (line,) = lines
        found = re.search(r"a change point, as at t = ([\d.]+) s, are not among them", line)
        assert found and float(found[1]) == pytest.approx(passed, rel=1e-3)
    assert [force for force, _ in told] == pytest.approx([told[0][0]] * 3, rel=0.02)
    away, none = told_of("80 deg", 1e-9)
    assert none == [] and away > 0.0
    # ten turns on it has passed a line twenty times: what is told is the pull of the speed, m r omega^2 and so on
    late, _ = told_of("100 deg", 1e-9, 0.43)
    speed = 0.43 / inertia
    jaw, rod = 0.15 * 0.08 * speed**2, 0.1 * 0.04 * speed**2
    assert late < jaw + rod
    nothing, (line,) = told_by_command("--until", "0.03")  # all rise to it
    assert nothing == 0.0 and "s, are not told: they and impulses grow" in line
