"""What a scene gives as zero and a parameter may be: taken, in the equations, and raised at run time."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError

from ccgen.generator import SceneError
from ccgen.generator.effect_base.table import kind_of_key
from ccgen.generator.effects import REGISTRY
from ccgen.generator.pipeline import listing
from ccgen.runtime import simulate

from ..support.command_line import ccgen
from ..support.effect_examples import SCENE
from ..support.workshop import Workshop

TOUCH = '[[touch]]\nbetween = ["link_2.B", "link_0.A"]\nradius = 0.01\n'
COMPLIANT = '[[compliant_touch]]\nbetween = ["link_2.B", "link_0"]\nradius = 0.01\n'
JOURNAL = '[[journal]]\nbetween = ["link_2.B", ["link_0.A", "link_0.B"]]\nradius = 0.01\nclearance = 2.5\n'
CAM = (
    '[[cam]]\ncentre = "link_0.A"\nfollower = "link_2.B"\nbase = 0.2\n'
    'lift = [{ to = "120 deg", lift = 0.02 }, { to = "360 deg", lift = 0 }]\n'
)
TABLES: dict[str, tuple[str, str]] = {
    "gravity g": ("[gravity]\ng = ?\n", "gravity.g"),
    "ground friction": ("[[ground]]\npoint = [0, -9]\nrestitution = 0.2\nfriction = ?\n", "ground_0.friction"),
    "ground restitution": ("[[ground]]\npoint = [0, -9]\nrestitution = ?\n", "ground_0.restitution"),
    "compliant_ground load": ("[[compliant_ground]]\npoint = [0, -9]\nload = ?\n", "compliant_ground_0.load"),
    "compliant_ground damping": (
        "[[compliant_ground]]\npoint = [0, -9]\nload = 30\ndamping = ?\n",
        "compliant_ground_0.damping",
    ),
    "compliant_ground restitution": (
        "[[compliant_ground]]\npoint = [0, -9]\nload = 30\nrestitution = ?\n",
        "compliant_ground_0.restitution",
    ),
    "compliant_ground friction": (
        "[[compliant_ground]]\npoint = [0, -9]\nload = 30\nfriction = ?\n",
        "compliant_ground_0.friction",
    ),
    "compliant_ground poisson": (
        '[[compliant_ground]]\npoint = [0, -9]\ncontacts = ["link_2.B"]\nradius = 0.1\nyoung = 1e6\npoisson = ?\n',
        "compliant_ground_0.poisson",
    ),
    "compliant_ground poisson of both": (
        '[[compliant_ground]]\npoint = [0, -9]\ncontacts = ["link_2.B"]\nradius = 0.1\nyoung = 1e6\n'
        "poisson = [?, 0.3]\n",
        "compliant_ground_0.poisson.0",
    ),
    "stop restitution": (
        '[[stop]]\njoint = "joint_1"\nlowest = -3\nhighest = 2\nrestitution = ?\n',
        "stop_0.restitution",
    ),
    "touch friction": (TOUCH + "restitution = 0.2\nfriction = ?\n", "touch_0.friction"),
    "touch restitution": (TOUCH + "restitution = ?\n", "touch_0.restitution"),
    "touch friction of outlines": (
        '[[touch]]\nbetween = [["slider.N", "slider.M"], ["link_2.A", "link_2.B"]]\nradius = 0.001\n'
        "restitution = 0\nfriction = ?\n",
        "touch_0.friction",
    ),
    "compliant_touch load": (COMPLIANT + "load = ?\ndepth = 0.1\n", "compliant_touch_0.load"),
    "compliant_touch damping": (COMPLIANT + "load = 3\ndamping = ?\n", "compliant_touch_0.damping"),
    "compliant_touch restitution": (COMPLIANT + "load = 3\nrestitution = ?\n", "compliant_touch_0.restitution"),
    "compliant_touch friction": (COMPLIANT + "load = 3\nfriction = ?\n", "compliant_touch_0.friction"),
    "compliant_touch poisson": (COMPLIANT + "young = 1e6\npoisson = ?\n", "compliant_touch_0.poisson"),
    "journal friction": (JOURNAL + "restitution = 0\nfriction = ?\n", "journal_0.friction"),
    "journal restitution": (JOURNAL + "restitution = ?\n", "journal_0.restitution"),
    "cam friction": (CAM + "restitution = 0\nfriction = ?\n", "cam_0.friction"),
    "cam restitution": (CAM + "restitution = ?\n", "cam_0.restitution"),
    "rope restitution": (
        '[[rope]]\nbetween = ["ground.O", "link_2.B"]\nlength = 4\nrestitution = ?\n',
        "rope_0.restitution",
    ),
    "spring damping": (
        '[[spring]]\nbetween = ["ground.O", "link_2.B"]\nstiffness = 2\nlength = 1\nacts = "pull"\ndamping = ?\n',
        "spring_0.damping",
    ),
    "spring damping with play": (
        '[[spring]]\nbetween = ["ground.O", "link_2.B"]\nstiffness = 2\nlength = 1\nplay = 0.1\ndamping = ?\n',
        "spring_0.damping",
    ),
    "damper damping": ('[[damper]]\nbetween = ["ground.O", "link_2.B"]\ndamping = ?\n', "damper_0.damping"),
    "torsion damping": ('[[torsion]]\njoint = "joint_1"\nstiffness = 2\ndamping = ?\n', "torsion_0.damping"),
    "torsion damping alone": ('[[torsion]]\njoint = "joint_1"\ndamping = ?\n', "torsion_0.damping"),
    "torsion damping with play": (
        '[[torsion]]\njoint = "joint_1"\nstiffness = 2\nplay = 0.1\ndamping = ?\n',
        "torsion_0.damping",
    ),
    "joint_friction viscous": ('[[joint_friction]]\njoints = ["joint_0"]\nviscous = ?\n', "joint_friction_0.viscous"),
    "joint_friction dry": ('[[joint_friction]]\njoints = ["joint_0"]\ndry = ?\n', "joint_friction_0.dry"),
    "brake torque": ('[[brake]]\njoint = "joint_1"\ntorque = ?\n', "brake_0.torque"),
    "brake force": ('[[brake]]\njoint = "guide"\nforce = ?\n', "brake_0.force"),
    "drag linear": ('[[drag]]\npoint = "link_2.B"\nlinear = ?\n', "drag_0.linear"),
    "drag quadratic": ('[[drag]]\npoint = "link_2.B"\nquadratic = ?\n', "drag_0.quadratic"),
    "force vector": ('[[force]]\npoint = "link_2.B"\nvector = [?, ?]\n', "force_0.vector.x force_0.vector.y"),
    "torque torque": ('[[torque]]\nlink = "link_1"\ntorque = ?\n', "torque_0.torque"),
    "motor torque": ('[[motor]]\njoint = "joint_1"\ntorque = ?\n', "motor_0.torque"),
    "motor force": ('[[motor]]\njoint = "guide"\nforce = ?\n', "motor_0.force"),
    "motor stiffness": ('[[motor]]\njoint = "joint_1"\nangle = 1\nstiffness = ?\ndamping = 2\n', "motor_0.stiffness"),
    "motor stiffness alone": ('[[motor]]\njoint = "joint_1"\nangle = 1\nstiffness = ?\n', "motor_0.stiffness"),
    "motor damping": (
        '[[motor]]\njoint = "joint_1"\nangle = "sin(t)"\nstiffness = 2\ndamping = ?\n',
        "motor_0.damping",
    ),
    "motor damping of a slide": (
        '[[motor]]\njoint = "guide"\nposition = 1\nstiffness = 2\ndamping = ?\n',
        "motor_0.damping",
    ),
}
"""By table and key, with what tells cases of one key apart: the text, and the parameters that the number is."""
PLACES = "radius lowest highest length angle position lift"
NO_PARAMETERS = {f"{table.key} {key}" for table in REGISTRY for key in PLACES.split()} | {
    "law value",  # an expression, of which a number is one
    "compliant_ground exponent",  # a choice of a few
    "compliant_touch exponent",
    "brake begins",  # a time
    "drag speed",  # of none the equations are others
    "motor integral",  # it would be a coordinate more
    "drive speed",  # where it is, over time
}
"""What may be 0 and is structural then, or is no parameter at all: docs/scenes says of places that they are."""


def may_be_zero() -> set[str]:
    """Every key of every effect's table that takes the number 0."""
    found = set()
    for entry in REGISTRY:
        for key in entry.table.model_fields:
            try:
                TypeAdapter(kind_of_key(entry.table, key)).validate_python(0.0, strict=True)
            except ValidationError:
                continue
            found.add(f"{entry.key} {key}")
    return found


def test_every_key_that_takes_zero_is_tried() -> None:
    tried = {" ".join(case.split()[:2]) for case in TABLES}
    assert may_be_zero() - NO_PARAMETERS == tried - {"force vector"}  # which is a list


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
    if case in ("gravity g", "force vector", "torque torque", "motor torque", "motor force"):
        workshop.scene(SCENE + table.replace("?", "-1"))
        return
    with pytest.raises(SceneError, match=r"found -1, expected .*(zero or|from 0 to)"):
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
