"""What a scene gives as zero and a parameter may be: taken, in the equations, and raised at run time."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from ccgen.generator import SceneError
from ccgen.generator.pipeline import listing
from ccgen.runtime import simulate

from ..support.command_line import ccgen
from ..support.effect_examples import SCENE
from ..support.workshop import Workshop

TABLES: dict[str, tuple[str, str]] = {
    "ground": ("[[ground]]\npoint = [0, -9]\nrestitution = 0.2\nfriction = ?\n", "ground_0.friction"),
    "touch": (
        '[[touch]]\nbetween = ["link_2.B", "link_0.A"]\nradius = 0.01\nrestitution = 0.2\nfriction = ?\n',
        "touch_0.friction",
    ),
    "touch of outlines": (
        '[[touch]]\nbetween = [["slider.N", "slider.M"], ["link_2.A", "link_2.B"]]\nradius = 0.001\n'
        "restitution = 0\nfriction = ?\n",
        "touch_0.friction",
    ),
    "journal": (
        '[[journal]]\nbetween = ["link_2.B", ["link_0.A", "link_0.B"]]\nradius = 0.01\nclearance = 2.5\n'
        "restitution = 0\nfriction = ?\n",
        "journal_0.friction",
    ),
    "cam": (
        '[[cam]]\ncentre = "link_0.A"\nfollower = "link_2.B"\nbase = 0.2\nrestitution = 0\nfriction = ?\n'
        'lift = [{ to = "120 deg", lift = 0.02 }, { to = "360 deg", lift = 0 }]\n',
        "cam_0.friction",
    ),
    "compliant ground": (
        "[[compliant_ground]]\npoint = [0, -9]\nload = 30\nfriction = ?\n",
        "compliant_ground_0.friction",
    ),
    "compliant touch": (
        '[[compliant_touch]]\nbetween = ["link_2.B", "link_0"]\nradius = 0.01\nload = ?\ndepth = 0.1\n',
        "compliant_touch_0.load",
    ),
    "damper": ('[[damper]]\nbetween = ["ground.O", "link_2.B"]\ndamping = ?\n', "damper_0.damping"),
    "rope-like spring": (
        '[[spring]]\nbetween = ["ground.O", "link_2.B"]\nstiffness = 2\nlength = 1\nacts = "pull"\ndamping = ?\n',
        "spring_0.damping",
    ),
    "drag": ('[[drag]]\npoint = "link_2.B"\nlinear = ?\n', "drag_0.linear"),
    "quadratic drag": ('[[drag]]\npoint = "link_2.B"\nquadratic = ?\n', "drag_0.quadratic"),
    "viscous friction": ('[[joint_friction]]\njoints = ["joint_0"]\nviscous = ?\n', "joint_friction_0.viscous"),
    "dry friction": ('[[joint_friction]]\njoints = ["joint_0"]\ndry = ?\n', "joint_friction_0.dry"),
    "brake": ('[[brake]]\njoint = "joint_1"\ntorque = ?\n', "brake_0.torque"),
    "brake of a slide": ('[[brake]]\njoint = "guide"\nforce = ?\n', "brake_0.force"),
    "force": ('[[force]]\npoint = "link_2.B"\nvector = [?, ?]\n', "force_0.vector.x force_0.vector.y"),
    "torque": ('[[torque]]\nlink = "link_1"\ntorque = ?\n', "torque_0.torque"),
    "motor": ('[[motor]]\njoint = "joint_1"\ntorque = ?\n', "motor_0.torque"),
    "motor of a slide": ('[[motor]]\njoint = "guide"\nforce = ?\n', "motor_0.force"),
}


@pytest.mark.parametrize("case", TABLES)
def test_zero_is_a_parameter_of_the_same_equations(case: str, workshop: Workshop) -> None:
    """But for its value the listing of another number: so what a program makes of the parameter it makes of this."""
    table, paths = TABLES[case]
    zero, other = (workshop.scene(SCENE + table.replace("?", number)) for number in ("0", "0.25"))
    values = {parameter.path: parameter.value for effect in zero.effects for parameter in effect.parameters()}
    assert [values[path] for path in paths.split()] == [0.0] * len(paths.split())
    assert listing(zero) == re.sub(r" = 0\.25(  # (" + "|".join(paths.split()) + "))", r" = 0.0\1", listing(other))


@pytest.mark.parametrize("case", TABLES)
def test_less_than_zero_is_refused_as_before(case: str, workshop: Workshop) -> None:
    table, _ = TABLES[case]
    if case in ("force", "torque", "motor", "motor of a slide"):
        workshop.scene(SCENE + table.replace("?", "-1"))
        return
    with pytest.raises(SceneError, match=r"found -1, expected .*zero or"):
        workshop.scene(SCENE + table.replace("?", "-1"))


SLED = """
name = "sled"
[[link]]
name = "sled"
mass = 2
inertia = 0.1
com = [0, 0]
points = { A = [-0.5, -0.1], B = [0.5, -0.1], C = [0, 0] }
[gravity]
[[ground]]
restitution = 0
friction = 0
contacts = ["sled.A", "sled.B"]
[[force]]
name = "pull"
point = "sled.C"
vector = [0, 0]
[start]
position = [0, 0.1]
velocity = [3, 0]
[run]
until = 0.5
"""


@pytest.mark.parametrize("method", ["gauss", "dop853", "radau", "moreau"])
def test_a_sled_slides_on_and_slows_down(method: str, workshop: Workshop) -> None:
    """v = 3 on smooth ground; v = 3 − μ (g − F_y/m) t + F_x t/m with friction and where it is pulled."""
    model = workshop.model(SLED)
    slow, pull = {"ground_0.friction": 0.2}, {"pull.vector.x": 4.0, "pull.vector.y": 5.0}
    for params, wanted in (({}, 3.0), (slow, 3.0 - 0.981), (slow | pull, 4.0 - 0.2 * (9.81 - 2.5) * 0.5)):
        step = 0.01 if method == "moreau" else None
        run = simulate(model, method=method, params=params, step=step)
        speed = model.point_velocity("sled.C", run.q[-1], run.u[-1])
        assert speed == pytest.approx([wanted, 0.0], abs=1e-9 if method != "moreau" else 1e-6), params


def test_the_command_raises_what_the_file_has_as_zero(tmp_path: Path) -> None:
    (tmp_path / "sled.toml").write_text(SLED)
    for out, sets, wanted in (
        ("zero", [], 3.0),
        ("rough", ["--set", "ground_0.friction=0.2", "--set", "pull.vector.x=4"], 4.0 - 0.981),
    ):
        made = ccgen("run", "sled.toml", "--out", out, *sets, at=tmp_path)
        assert made.returncode == 0, made.stderr
        assert np.load(tmp_path / out / "result.npz")["u"][-1, 0] == pytest.approx(wanted, abs=1e-8)
