"""What is said about joints that make no sense."""

from __future__ import annotations

from pathlib import Path

import pytest

from ..support.command_line import ccgen
from ..support.joint_texts import FLOOR, faults, scene

AXIS = "axis = [1, 0]\n\n[start]"
CRANK_PIN = 'between = ["crank.B", "rod.A"]\n'
SAID: dict[str, tuple[tuple[str, str], str, tuple[str, ...]]] = {
    "axis missing": ((AXIS, "[start]"), "joint[3].axis", ("missing", "[x, y] or an angle", "add it")),
    "axis zero": ((AXIS, AXIS.replace("1, 0", "0, 0")), "joint[3].axis", ("not both zero", "write [1, 0]")),
    "axis of three": ((AXIS, AXIS.replace("1, 0", "1, 0, 0")), "joint[3].axis", ("[1, 0, 0]", "write 2 values")),
    "axis no angle": ((AXIS, 'axis = "ten deg"\n[start]'), "joint[3].axis", ('found "ten deg"', '"30 deg"')),
    "axis at a pin": ((CRANK_PIN, CRANK_PIN + "axis = [1, 0]\n"), "joint[1].axis", ("at a revolute joint", "remove")),
    "angle at a pin": ((CRANK_PIN, CRANK_PIN + "angle = 0.3\n"), "joint[1].angle", ("at a revolute joint", "remove")),
    "axis at a weld": (
        (CRANK_PIN, CRANK_PIN + 'type = "weld"\naxis = [1, 0]\n'),
        "joint[1].axis",
        ("at a weld joint", "prismatic or pin-in-slot"),
    ),
    "angle at a slot": (
        ('type = "prismatic"', 'type = "pin-in-slot"\nangle = 0.1'),
        "joint[3].angle",
        ("at a pin-in-slot joint", "remove it"),
    ),
    "angle no angle": ((AXIS, 'angle = "wide"\n' + AXIS), "joint[3].angle", ('found "wide"', '"30 deg"')),
    "unknown type": (('"prismatic"', '"cylindrical"'), "joint[3].type", ('found "cylindrical"', '"pin-in-slot"')),
    "slide of nothing": (("{ guide = 0.68 }", "{ giude = 0.68 }"), "start.slides.giude", ("expected one of guide",)),
    "slide of a pin": (("{ guide = 0.68 }", "{ motor = 0.68 }"), "start.slides.motor", ("unknown sliding joint",)),
    "slide no number": (("{ guide = 0.68 }", '{ guide = "far" }'), "start.slides.guide", ('found "far"', "quotes")),
    "slide not finite": (("{ guide = 0.68 }", "{ guide = inf }"), "start.slides.guide", ("found inf", "finite")),
    "speeds disagree": (
        ("crank = 12.0 }", "crank = 12.0 }\nsliding_velocities = { guide = 1.0 }"),
        "start.sliding_velocities",
        ("crank, guide", "m/s", "give fewer"),
    ),
    "speed of a pin": (
        ("angular_velocities = { crank", "sliding_velocities = { motor"),
        "start.sliding_velocities.motor",
        ("expected one of guide",),
    ),
    "torque on a slide": (
        ("[gravity]", '[[motor]]\njoint = "guide"\ntorque = 1\n[gravity]'),
        "motor[0].torque",
        ("slides along a line", "write force"),
    ),
    "force on a pin": (
        ("[gravity]", '[[motor]]\njoint = "motor"\nforce = 1\n[gravity]'),
        "motor[0].force",
        ("at a joint that turns", "write torque"),
    ),
    "friction of both kinds": (
        ("[gravity]", "[[joint_friction]]\nviscous = 1\n[gravity]"),
        "joint_friction[0]",
        ("joints that turn and joints that slide", "a second table"),
    ),
    "ground under the ground's point": (
        ('["ground.O", "slider.C"]\naxis = [1, 0]\n', '["slider.C", "ground.O"]\naxis = [1, 0]\n' + FLOOR),
        "ground[0].contacts[0]",
        ("guide is the ground's point O", "as slider.C"),
    ),
    "torsion where nothing turns": (
        ("[gravity]", '[[torsion]]\njoint = "guide"\nstiffness = 1\n[gravity]'),
        "torsion[0].joint",
        ('found "guide"', "does not turn"),
    ),
}
"""A change to the slider-crank, the key that it is said about, words of the message."""


@pytest.mark.parametrize("case", SAID)
def test_what_makes_no_sense_is_said(case: str, tmp_path: Path) -> None:
    change, key, words = SAID[case]
    text = scene("slider-crank", change)
    ((line, found, message),) = faults(text, tmp_path)
    assert found == key
    assert line is not None and 1 <= line <= text.count("\n")
    for word in words:
        assert word in message


def test_the_command_line_says_it_too(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(scene("slider-crank", (AXIS, "[start]")))
    done = ccgen("--scene", str(path), at=tmp_path)
    assert done.returncode == 2 and "joint[3].axis: missing" in done.stderr
    assert list(tmp_path.iterdir()) == [path]
