"""What a scene gives over time is no parameter: whoever sets it is told so, and of no other part's name."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from ccgen.generator import SceneError, load_scene
from ccgen.generator.cli.app import app

from ..support.workshop import Workshop

SCENE = """
name = "given"
[ground_link]
points = { O = [0, 0], P = [1, 0], Q = [2, 0], R = [3, 0] }
LINKS
[[joint]]
name = "a"
between = ["ground.O", "one.A"]
[[joint]]
name = "b"
between = ["ground.P", "two.A"]
[[joint]]
name = "c"
between = ["ground.Q", "three.A"]
[[joint]]
name = "d"
type = "prismatic"
between = ["ground.R", "four.A"]
axis = [0, 1]
[[motor]]
joint = "a"
torque = "2*sin(3*t)"
[[motor]]
joint = "b"
angle = { rows = [[0, 0], [1, 2]], order = 3 }
stiffness = 2
[[motor]]
joint = "d"
force = "t"
[[motor]]
joint = "d"
position = "t"
stiffness = 2
[[drive]]
joint = "c"
speed = "1 + t"
[[brake]]
name = "motor_10"
joint = "a"
torque = 3
[[brake]]
joint = "b"
torque = "t"
[[brake]]
joint = "d"
force = "t"
[[torque]]
link = "one"
torque = "t"
[[force]]
point = "one.B"
vector = [1, "cos(t)"]
EVENT
[run]
until = 0.1
"""
LINKS = "".join(
    f'[[link]]\nname = "{name}"\nmass = 1\ninertia = 0.1\ncom = [0.1, 0]\npoints = {{ A = [0, 0], B = [0.5, 0] }}\n'
    for name in ("one", "two", "three", "four")
)
OVER_TIME = {
    "motor_0.torque": "2 * sin(3 * t)",
    "motor_1.angle": "a spline of order 3 through 2 rows, at rest before and after",
    "motor_2.force": "t",
    "motor_3.position": "t",
    "drive_0.speed": "1 + t",
    "brake_1.torque": "t",
    "brake_2.force": "t",
    "torque_0.torque": "t",
    "force_0.vector.y": "cos(t)",
}


def text(event: str = "") -> str:
    return SCENE.replace("LINKS", LINKS).replace("EVENT", event)


@pytest.fixture(scope="module")
def model(workshop: Workshop) -> Any:
    return workshop.model(text())


@pytest.mark.parametrize("path", OVER_TIME)
def test_a_model_says_why_it_cannot_be_set(path: str, model: Any) -> None:
    said = f"{path}: found a value that the scene gives over time ({OVER_TIME[path]}), expected a parameter; write "
    with pytest.raises(KeyError) as error:
        model.with_parameters({path: 1.0})
    assert str(error.value).startswith(said)
    assert path not in model.parameters


def test_so_do_commands(tmp_path: Path) -> None:
    """Before anything is compiled; with its name the near one was that of a brake."""
    (tmp_path / "given.toml").write_text(text())
    done = CliRunner().invoke(app, ["run", str(tmp_path / "given.toml"), "--set", "motor_0.torque=1"])
    assert done.exit_code == 2
    assert done.stderr == (
        "--set motor_0.torque: found a value that the scene gives over time (2 * sin(3 * t)), expected a parameter; "
        "write a number in its place in the scene, or names of [let] within it, and set that\n"
    )


def test_a_misspelt_name_is_told_as_it(tmp_path: Path) -> None:
    """With what it is, and not as another part's parameter alone."""
    (tmp_path / "given.toml").write_text(text())
    done = CliRunner().invoke(app, ["run", str(tmp_path / "given.toml"), "--set", "motor_1.angel=1"])
    assert done.exit_code == 2
    assert "found no such parameter, expected one of the model, as motor_1.angle (given over time)" in done.stderr


def test_so_do_events() -> None:
    import tomllib

    event = '[[event]]\nname = "later"\nwhen = "t - 1"\nset = { "motor_0.torque" = 1 }\n'
    with pytest.raises(SceneError, match=r'found "motor_0\.torque", which is given over time, 2 \* sin\(3 \* t\), exp'):
        load_scene(tomllib.loads(text(event)))
