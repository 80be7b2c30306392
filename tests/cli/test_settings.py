"""``--set PATH=VALUE`` of the commands that compute."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from ccgen.generator.cli.app import app
from ccgen.runtime import simulate

from ..support.folders import SCENES
from ..support.slider_crank import SLIDER_CRANK as BODIES
from ..support.workshop import Workshop

FOUR_BAR = str(SCENES / "four-bar.toml")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_a_run_has_the_values_that_are_set(workshop: Workshop) -> None:
    """As in Python, to the bit, from the start that the scene has with them, and the file knows them."""
    from ccgen.generator import load_scene
    from ccgen.generator.scene.with_values import with_values

    values = {"crank.mass": 2.5, "gravity.g": 1.62, "coupler.points.B.x": 0.55}
    options = [text for path, value in values.items() for text in ("--set", f"{path}={value}")]
    done = CliRunner().invoke(app, ["run", FOUR_BAR, *options, "--until", "1", "-q"])
    assert done.exit_code == 0, done.stderr
    scene = load_scene(SCENES / "four-bar.toml")
    start = with_values(scene, values).start
    model = workshop.model(scene).with_parameters(values).with_start(start.poses, start.velocities)
    run = simulate(model, until=1.0)
    with np.load("results/four-bar/result.npz") as written:
        parameters = dict(zip(written["parameter_names"].tolist(), written["parameter_values"].tolist(), strict=True))
        assert {path: parameters[path] for path in values} == values
        assert np.array_equal(written["q"], run.q)
    assert run.closure_max < 1e-12


SLIDER_CRANK = (
    'name = "NAME"'
    + BODIES
    + """[[rope]]
name = "line"
between = ["ground.O", "con.B"]
restitution = 0.5
[start]
START
[gravity]
[run]
until = 0.1
"""
)
STARTS = {
    "given": 'angles = { crank = "60 deg" }\nangular_velocities = { crank = 5 }',
    "sketched": 'angles = { crank = "60 deg", con = "-20 deg" }\nangular_velocities = { crank = 5 }',
    "drawn": "joints = { pin = [0.1, 0.17], wrist = [0.5, 0] }\nangular_velocities = { crank = 5 }",
}


@pytest.mark.sample(3)
@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("length", [0.7, 0.15])
def test_a_start_is_assembled_anew_as_that_of_the_file_with_these_numbers(
    length: float, start: str, tmp_path: Path
) -> None:
    """To the bit, what is given, drawn or sketched, also where the crank cannot stand where the scene has it; the rope,
    whose length is that of its way at the start, is as long as there."""
    files = {}
    for name, number in (("plain", "0.5"), ("edited", str(length))):
        text = SLIDER_CRANK.replace("NAME", name).replace("LENGTH", number).replace("START", STARTS[start])
        files[name] = tmp_path / f"{name}.toml"
        files[name].write_text(text)
    options = {"plain": ["--set", f"con.points.B.x={length}"], "edited": []}
    told = {}
    for name, more in options.items():
        done = CliRunner().invoke(app, ["run", str(files[name]), *more, "--rtol", "1e-12"])
        assert done.exit_code == 0, done.stderr
        told[name] = done.stderr
    runs = [np.load(f"results/{name}/result.npz") for name in files]
    for key in ("t", "q", "u", "parameter_values"):
        assert np.array_equal(runs[0][key], runs[1][key]), key
    closed = [line.partition(": ")[2] for line in told["edited"].splitlines() if "changed by" in line]
    assert [line for line in closed if line not in told["plain"]] == []


def test_a_start_that_is_set_is_that_of_the_file_with_these_numbers(tmp_path: Path) -> None:
    """To the bit, and nothing is compiled anew; another one is remarked on as in a file, and refused as there."""
    text = SLIDER_CRANK.replace("LENGTH", "0.5")
    (tmp_path / "plain.toml").write_text(text.replace("NAME", "plain").replace("START", STARTS["given"]))
    edited = text.replace("NAME", "edited").replace("START", STARTS["given"])
    edited = edited.replace("60 deg", "0.6 rad").replace("crank = 5", "crank = -2")
    (tmp_path / "edited.toml").write_text(edited)
    options = ["--set", "start.angles.crank=0.6 rad", "--set", "start.angular_velocities.crank=-2"]
    for name, more in (("plain", options), ("edited", [])):
        done = CliRunner().invoke(app, ["run", f"{name}.toml", *more])
        assert done.exit_code == 0, done.stderr
    runs = [np.load(f"results/{name}/result.npz") for name in ("plain", "edited")]
    for key in ("t", "q", "u", "parameter_values"):
        assert np.array_equal(runs[0][key], runs[1][key]), key
    assert runs[0]["q"][0, 0] == 0.6
    done = CliRunner().invoke(app, ["show", "plain.toml", "--set", "start.angles.crank=60"])
    assert '--set start.angles.crank: 60 is taken as rad, 9.55 turns; write "60 deg" for degrees' in done.stderr
    for given, said in (
        ("start.angles.con=1", "--set start.angles.con: found a value that [start] does not give, expected one that it "
         "gives: start.angles.crank, start.angular_velocities.crank; write it in the scene"),
        ("start.angles.crank=2 kg", '--set start.angles.crank: found "2 kg", expected rad; that is a mass'),
    ):  # fmt: skip
        done = CliRunner().invoke(app, ["run", "plain.toml", "--set", given])
        assert done.exit_code == 2 and said in done.stderr, done.stderr


def test_a_start_that_there_is_none_of_with_these_values(tmp_path: Path) -> None:
    file = tmp_path / "short.toml"
    text = SLIDER_CRANK.replace("NAME", "short").replace("LENGTH", "0.5").replace("START", STARTS["given"])
    text = text.replace("O = [0, 0] }", "O = [0, 0], G = [0, 0.4] }").replace(
        '"ground.O", "slider', '"ground.G", "slider'
    )
    file.write_text(text)
    done = CliRunner().invoke(app, ["run", str(file), "--set", "con.points.B.x=0.1"])
    assert done.exit_code == 2
    assert done.stderr.startswith("--set: with these values short: joint[")
    assert "found no way to close the loop" in done.stderr


def test_values_have_units_as_in_scenes() -> None:
    """Grams, degrees and arithmetic, as a shell hands them over and with quotes left."""
    plain, written = (
        CliRunner().invoke(app, ["equilibrium", FOUR_BAR, *more])
        for more in (
            ("--set", "crank.mass=2.5", "--set", "gravity.g=4.905", "--set", "coupler.points.B.x=0.5"),
            ("--set", "crank.mass=2500 g", "--set", "gravity.g=9.81/2", "--set", 'coupler.points.B.x="50 cm"'),
        )
    )
    assert written.exit_code == 0, written.stderr
    assert written.stdout == plain.stdout


@pytest.mark.sample(12)
@pytest.mark.parametrize("scene", [*SCENES.glob("*.toml"), *SCENES.glob("gallery/*.toml")], ids=lambda path: path.stem)
def test_it_is_known_what_every_parameter_measures(scene: Path) -> None:
    """So that none is set to what it cannot be; but one of a law, which may be anything."""
    from ccgen.generator import load_scene
    from ccgen.generator.effects.law import Law
    from ccgen.generator.scene.measures import units_of

    found = load_scene(scene)
    effects = [effect for effect in found.effects if not isinstance(effect, Law)]
    parameters = [*found.mechanism.parameters(), *(one for effect in effects for one in effect.parameters())]
    assert [one.path for one in parameters if not units_of(found, one.path)] == []


@pytest.mark.sample(12)
@pytest.mark.parametrize("scene", [*SCENES.glob("*.toml"), *SCENES.glob("gallery/*.toml")], ids=lambda path: path.stem)
def test_a_scene_with_its_own_values_is_the_same(scene: Path) -> None:
    from ccgen.generator import load_scene
    from ccgen.generator.scene.with_values import with_values

    found = load_scene(scene)
    parameters = [*found.mechanism.parameters(), *(one for effect in found.effects for one in effect.parameters())]
    assert with_values(found, {one.path: one.value for one in parameters}) == found


RODS = """
name = "rods"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "rod"
rod = { mass = 3.0 }
points = { A = [0, 0], B = [2.0, 0] }
[[link]]
name = "given"
mass = 1.0
inertia = 0.5
com = [0.5, 0]
points = { A = [0, 0] }
[[joint]]
between = ["ground.O", "rod.A"]
[[joint]]
between = ["rod.B", "given.A"]
[gravity]
g = 9.81
[run]
until = 0.1
"""


def _said(*options: str) -> str:
    Path("rods.toml").write_text(RODS)
    done = CliRunner().invoke(app, ["equilibrium", "rods.toml", *options])
    assert done.exit_code == 0, done.stderr
    return done.stderr


def test_an_inertia_that_stays_is_told() -> None:
    """That of a rod of 2 m: m l²/12 is 1 kg m² for 3 kg, and 2 kg m² for 6 kg."""
    said = _said("--set", "rod.mass=6 kg")
    assert "rods: rod.mass is set, rod.inertia stays 1 kg m², which was worked out for 3 kg" in said
    assert "--set rod.inertia=2 lets it grow with the mass" in said
    assert "rods: rod.points.B.x is set, rod.inertia stays 1 kg m²" in _said("--set", "rod.points.B.x=3")


@pytest.mark.parametrize(
    "options",
    [
        ("--set", "rod.mass=6", "--set", "rod.inertia=2"),
        ("--set", "given.mass=2"),
        ("--set", "gravity.g=1"),
        ("--set", "rod.mass=6", "-q"),
    ],
    ids=" ".join,
)
def test_what_does_not_stay_is_not_told(options: tuple[str, ...]) -> None:
    assert "stays" not in _said(*options)


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
        (["--set", "crank.mass=2 m"], '--set crank.mass: found "2 m", expected kg; that is a length, not a mass in kg'),
        (["--set", "crank.points.B.x=2 kg"], '--set crank.points.B.x: found "2 kg", expected m; that is a mass'),
        (["--set", "gravity.g=2 m/s"], '--set gravity.g: found "2 m/s", expected m/s²; that is a'),
        (["--set", "crank.mass=2 kgs"], '--set: found "crank.mass=2 kgs", expected PATH=NUMBER'),
        (["--set", "a=1", "--set", "a=2"], "--set a: found twice, expected once"),
        (
            ["--set", "crank.mas=1"],
            "--set crank.mas: found no such parameter, expected one of the model, as crank.mass",
        ),
        (
            ["--set", "crank.length=1"],
            "--set crank.length: found no such parameter, expected one of the model, as crank.points.B.x;",
        ),
        (["--set", "crank.mass=-1"], "--set crank.mass: found -1.0, expected a positive number"),
        (["--set", "crank.mass=2", "--fold"], "--fold"),
    ],
)
def test_wrong_values_are_told(options: list[str], told: str) -> None:
    done = CliRunner().invoke(app, ["run", FOUR_BAR, *options])
    assert done.exit_code == 2 and told in done.stderr and not Path("results").exists()


@pytest.mark.parametrize(
    ("command", "told"),
    [
        (("orbit", "--section", "1", "--along", "start.angles.crank=1:2"),
         "--along: start.angles.crank: found a value of the start, expected a parameter; name one"),
        (("orbit", "--section", "1", "--along", "rtol=1:2"),
         "--along: rtol: found a setting of runs, expected a parameter; name one"),
        (("cost", "--gradient", "--by", "rtol"),
         "--by: rtol: found a setting of runs, expected a parameter; name one"),
        (("cost", "--gradient", "--by", "crank.com.y"),
         "--by: crank.com.y: found a number that is 0 in the scene and so left out of the equations, expected a "
         "parameter; write another number for it in the scene, which may be small"),
    ],
    ids=["start", "along a setting", "by a setting", "zero"],
)  # fmt: skip
def test_what_is_named_for_a_parameter_is_said_without_a_value(command: tuple[str, ...], told: str) -> None:
    done = CliRunner().invoke(app, [command[0], FOUR_BAR, *command[1:]])
    assert done.exit_code == 2 and done.stderr == f"{told}\n"


MISSPELT = "--set crank.mas: found no such parameter, expected one of the model, as crank.mass"


@pytest.mark.parametrize(
    ("command", "told"),
    [
        (["run", FOUR_BAR, "--until", "-1", "--set", "crank.com.x=2 kg", "--set", "start.tilt=1"], [
            "--until: found -1.0", '--set crank.com.x: found "2 kg"',
            "--set start.tilt: found a value that [start] does not give",
        ]),
        (["run", FOUR_BAR, "--rtol", "x", "--set", "crank.inertia=-1", "--set", "coupler.mass=-2"], [
            "--rtol: found 'x'", "--set crank.inertia: found -1.0, expected a positive number",
            "--set coupler.mass: found -2.0, expected a positive number",
        ]),
        (["run", FOUR_BAR, "--plot", "crank.angel"], ["--plot: "]),
        (["show", FOUR_BAR, "--plan", "no"], ["--plan: "]),
        (["cost", FOUR_BAR, "--error", "5"], ["--error: found 5.0"]),
        (["cost", FOUR_BAR, "--gradient", "--by", "u0,crank.mis", "--until", "-3"],
         ["--by: crank.mis: found no such parameter", "--until: found -3.0"]),
        (["torque", FOUR_BAR, "none"], ["JOINT: found 'none'"]),
        (["equilibrium", FOUR_BAR], []),
        (["orbit", FOUR_BAR, "--section", "1", "--along", "crank.mis=1:2", "--most", "x"],
         ["--along: crank.mis: found no such parameter", "--most: found 'x'"]),
        (["sweep", FOUR_BAR, "plan.toml", "--threads", "x"],
         ["--threads: found 'x'", "plan.toml: found nothing there"]),
        (["replay", ".", FOUR_BAR, "plan.toml", "0"], ["plan.toml: found nothing there"]),
    ],
    ids=lambda value: value[0] if value and len(value) > 1 else "",
)  # fmt: skip
def test_all_faults_of_a_command_are_told_before_anything_is_generated(
    command: list[str], told: list[str], tmp_path: Path
) -> None:
    done = CliRunner().invoke(app, [*command, "--set", "crank.mas=1"])
    assert done.exit_code == 2
    assert [one for one in (MISSPELT, *told) if one not in done.stderr] == [], done.stderr
    assert len(done.stderr.splitlines()) == 1 + len(told)
    assert list(tmp_path.iterdir()) == []


def test_an_unreadable_value_hides_no_other_fault(tmp_path: Path) -> None:
    options = ("--set", "crank.mas=1", "--set", "crank.mass=abc", "--set", "coupler.mass=-2", "--until", "x")
    done = CliRunner().invoke(app, ["run", FOUR_BAR, *options])
    assert done.exit_code == 2
    began = ('--set: found "crank.mass=abc"', "--until: found 'x'", MISSPELT, "--set coupler.mass: found -2.0")
    lines = done.stderr.splitlines()
    assert len(lines) == len(began) and all(any(line.startswith(one) for line in lines) for one in began), lines
    assert list(tmp_path.iterdir()) == []


def test_no_start_is_missed_while_a_value_is_unreadable() -> None:
    """With the one that is meant there may be a start."""
    options = ("--set", "crank.points.B.x=70", "--set", "coupler.points.B.x=7o")
    done = CliRunner().invoke(app, ["run", FOUR_BAR, *options])
    assert done.exit_code == 2 and len(done.stderr.splitlines()) == 1
    assert done.stderr.startswith('--set: found "coupler.points.B.x=7o"')


def test_a_start_that_there_is_none_of_is_told_before_anything_is_generated(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["run", FOUR_BAR, "--set", "crank.points.B.x=70", "--until", "-1"])
    assert done.exit_code == 2
    assert "--set: with these values four-bar: " in done.stderr and "--until: found -1.0" in done.stderr
    assert list(tmp_path.iterdir()) == []


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


WRONG = {
    "a number that is 0 in the scene": (
        "crank.points.B.y=0.1",
        "--set crank.points.B.y: found a number that is 0 in the scene and so left out of the equations, expected a "
        "parameter; write another number for it in the scene",
    ),
    "an option of runs": ("until=3", "--set until: found a setting of runs, expected a parameter; write --until 3"),
    "an option of runs, with a unit": ("until=3 s", "write --until 3 s"),
    "another name": ("crank.weight=3", "--set crank.weight: found no such parameter"),
}


@pytest.mark.parametrize(("setting", "said"), WRONG.values(), ids=WRONG)
def test_what_is_no_parameter_is_told(setting: str, said: str) -> None:
    done = CliRunner().invoke(app, ["run", FOUR_BAR, "--set", setting])
    assert done.exit_code == 2
    assert said in done.stderr


def test_degrees_that_may_be_meant_are_told(tmp_path: Path) -> None:
    """As of a file: beyond a full turn, and without a unit."""
    text = SLIDER_CRANK.replace("NAME", "turned").replace("LENGTH", "0.5").replace("START", STARTS["given"])
    text += '[[torsion]]\nname = "wound"\njoint = "axle"\nstiffness = 1\nangle = 0.1\n'
    (tmp_path / "turned.toml").write_text(text)
    told = {}
    for value in ("40", "40 deg", "6", "20*pi"):
        done = CliRunner().invoke(app, ["run", "turned.toml", "--set", f"wound.angle={value}", "--until", "0.01"])
        assert done.exit_code == 0, done.stderr
        told[value] = "is taken as rad" in done.stderr
    assert told == {"40": True, "40 deg": False, "6": False, "20*pi": False}
    done = CliRunner().invoke(app, ["run", "turned.toml", "--set", "wound.angle=40", "--until", "10 ms"])
    assert '--set wound.angle: 40 is taken as rad, 6.37 turns; write "40 deg" for degrees' in done.stderr
    quiet = CliRunner().invoke(app, ["run", "turned.toml", "--set", "wound.angle=40", "--until", "10 ms", "-q"])
    assert quiet.stderr == '--set wound.angle: 40 is taken as rad, 6.37 turns; write "40 deg" for degrees\n'
    wrong = CliRunner().invoke(app, ["run", "turned.toml", "--set", "wound.angle=nan", "-q"])
    assert wrong.exit_code == 2 and "is taken as rad" not in wrong.stderr


def test_ends_have_units_as_in_scenes() -> None:
    """And nothing but times."""
    for text, end in (("200 ms", 0.2), ("1/4", 0.25)):
        done = CliRunner().invoke(app, ["run", FOUR_BAR, "--until", text, "-q"])
        assert done.exit_code == 0, done.stderr
        with np.load("results/four-bar/result.npz") as written:
            assert written["t"][-1] == pytest.approx(end, rel=1e-15)
    done = CliRunner().invoke(app, ["run", FOUR_BAR, "--until", "2 kg"])
    assert done.exit_code == 2
    assert "--until: found '2 kg', expected a positive number of seconds" in done.stderr


def test_the_way_to_another_equilibrium_is_told(tmp_path: Path) -> None:
    (tmp_path / "free.toml").write_text("[loop]\nlinks = 4\n[gravity]\n")
    done = CliRunner().invoke(app, ["equilibrium", "free.toml"])
    assert done.exit_code == 2
    assert "nearest=True (--nearest) looks for the nearest one, stable or not" in done.stderr
    done = CliRunner().invoke(app, ["equilibrium", "free.toml", "--nearest"])
    assert "--nearest" not in done.stderr


def test_names_of_let_take_what_they_measure_in_the_scene(tmp_path: Path) -> None:
    """With a unit as in the file, or without one in SI units; what measures something else is refused as there."""
    scene = (
        '[let]\nr = "80 mm"\n[[link]]\nname = "crank"\nrod = { mass = 1 }\npoints = { A = [0, 0], B = ["r", 0] }\n'
        '[ground_link]\npoints = { O = [0, 0] }\n[[joint]]\nbetween = ["ground.O", "crank.A"]\n[gravity]\n'
    )
    (tmp_path / "swing.toml").write_text(scene)
    for value in ("90 mm", "0.09", "2*0.045"):
        done = CliRunner().invoke(app, ["run", "swing.toml", "--set", f"r={value}", "--until", "10 ms", "-q"])
        assert done.exit_code == 0, done.stderr
        with np.load("results/swing/result.npz") as written:
            parameters = dict(zip(written["parameter_names"], written["parameter_values"], strict=True))
        assert parameters["crank.points.B.x"] == pytest.approx(0.09, rel=1e-15)
    for value, what in (("0.09 kg", "a mass"), ("5 deg", "an angle"), ("80 kg", "a mass")):
        done = CliRunner().invoke(app, ["run", "swing.toml", "--set", f"r={value}"])
        assert done.exit_code == 2 and f"that is {what}, not a length in m" in done.stderr, done.stderr
