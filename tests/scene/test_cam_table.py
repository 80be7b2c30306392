"""What is wrong in a ``[[cam]]``: every fault with its key, what was found, and what to do."""

from __future__ import annotations

import math

import pytest

from ccgen.generator.effects.cam import Cam
from ccgen.generator.scene import SceneError

from ..support.workshop import Workshop

LINKS = """
[ground_link]
points = { O = [0, 0], G = [0, 2] }
[[link]]
name = "shaft"
mass = 1.0
inertia = 0.1
com = [0, 0]
points = { O = [0, 0], E = [0.1, 0] }
[[link]]
name = "lifter"
mass = 1.0
inertia = 0.1
com = [0, 0]
points = { A = [-0.2, 0], B = [0.2, 0], P = [0, 0] }
[[joint]]
name = "axle"
between = ["ground.O", "shaft.O"]
[[joint]]
name = "guide"
type = "prismatic"
axis = [0, 1]
between = ["ground.G", "lifter.P"]
[start]
slides = { guide = -1.9 }
"""
ROLLER = 'follower = "lifter.P"'
FACE = 'follower = ["lifter.A", "lifter.B"]'
LIFT = 'lift = "0.01*cos(angle)"'
CAM = LINKS + (f'[[cam]]\ncentre = "shaft.O"\n{ROLLER}\nbase = 0.05\nradius = 0.02\n{LIFT}\nrestitution = 0.5\n')
PIECES = '[{ to = "90 deg", lift = 0.01 }, { to = "180 deg" }, { to = "360 deg", lift = 0 }]'
BAD: dict[str, tuple[str, str, str, tuple[str, ...]]] = {
    "no such centre": ('centre = "shaft.O"', 'centre = "shaft.X"', "cam[0].centre", ("the cam's centre", "O, E")),
    "a pin as the centre": ('"shaft.O"\nfollower', '"guide"\nfollower', "cam[0]", ("two places on lifter",)),
    "no such follower": (ROLLER, 'follower = "lifter.X"', "cam[0].follower", ("A, B, P",)),
    "a face on two links": (ROLLER, 'follower = ["lifter.A", "shaft.E"]', "cam[0].follower", ("different links",)),
    "one link": (ROLLER, 'follower = "shaft.E"', "cam[0]", ("two places on shaft",)),
    "no base": ("base = 0.05", "base = 0", "cam[0].base", ("positive",)),
    "an angle as the base": ("base = 0.05", 'base = "5 deg"', "cam[0].base", ("an angle",)),
    "a face with a radius": (ROLLER, FACE, "cam[0].radius", ("none with a straight face",)),
    "time": (LIFT, 'lift = "0.01*cos(t)"', "cam[0].lift", ("t is the time", "write angle")),
    "a name that is not known": (LIFT, 'lift = "0.01*cos(phi)"', "cam[0].lift", ("phi", "angle")),
    "a kink": (LIFT, 'lift = "0.01*abs(cos(angle))"', "cam[0].lift", ("abs(...) has a kink",)),
    "a unit of something else": (LIFT, 'lift = "5 N"', "cam[0].lift", ("a force",)),
    "a table": (LIFT, "lift = true", "cam[0].lift", ("0.01*(1 - cos(angle))",)),
    "not closed": (LIFT, 'lift = "0.001*angle"', "cam[0].lift", ("the lift is", "360 deg", "closed profile")),
    "a corner": (LIFT, 'lift = "0.001*angle*(2*pi - angle)"', "cam[0].lift", ("the slope of the lift",)),
    "pieces that do not meet": (
        LIFT,
        'lift = [{ to = "180 deg", lift = "0.01*sin(angle)**2" }, { to = "360 deg", lift = "0.001 + 0*angle" }]',
        "cam[0].lift",
        ("before 180 deg and 0.001 m after it",),
    ),
    "no distance": (LIFT, 'lift = "0.06*cos(angle)"', "cam[0].lift", ("comes as near as 0.01 m", "at 180 deg")),
    "cut under": (
        LIFT,
        'lift = "0.01*cos(6*angle)"',
        "cam[0].lift",
        ("bends with a radius of", "roller's radius, 0.02 m", "cut under"),
    ),
    "hollow": (
        f"{ROLLER}\nbase = 0.05\nradius = 0.02\n{LIFT}",
        f'{FACE}\nbase = 0.05\nlift = "0.01*cos(3*angle)"',
        "cam[0].lift",
        ("radius of curvature is -0.03 m at 0 deg", "straight face"),
    ),
    "out of order": (
        LIFT,
        f"lift = {PIECES.replace('180', '80')}",
        "cam[0].lift[1].to",
        ("found 80 deg", "more than 90 deg"),
    ),
    "not a turn": (LIFT, f"lift = {PIECES.replace('360', '350')}", "cam[0].lift[2].to", ("found 350 deg", '"360 deg"')),
    "a law of a rest": (
        LIFT,
        'lift = [{ to = "90 deg", lift = 0.01 }, { to = "180 deg", law = "harmonic" }, { to = "360 deg", lift = 0 }]',
        "cam[0].lift[1].law",
        ("beside a rest",),
    ),
    "no such law": (
        LIFT,
        'lift = [{ to = "90 deg", lift = 0.01, law = "cosine" }, { to = "360 deg", lift = 0 }]',
        "cam[0].lift[0].law",
        ("cycloidal",),
    ),
    "inside": (
        "guide = -1.9",
        "guide = -1.95",
        "cam[0]",
        ("inside the cam by 0.019799 m", "move it away from shaft.O in [start]"),
    ),
    "in the centre": ("guide = -1.9", "guide = -2", "cam[0]", ("in the cam's centre",)),
    "beside the face": (
        f"{ROLLER}\nbase = 0.05\nradius = 0.02\n{LIFT}",
        'follower = ["lifter.P", "lifter.B"]\nbase = 0.1\nlift = "0.01*sin(angle)"\nangle = 0.5',
        "cam[0]",
        ("from its first end", "0 to its length, 0.2 m"),
    ),
    "an unknown key": ("base = 0.05", "base = 0.05\nprofile = 3", "cam[0].profile", ("unknown",)),
}


@pytest.mark.parametrize("case", [*BAD])
def test_faults(case: str, workshop: Workshop) -> None:
    old, new, where, told = BAD[case]
    assert CAM.count(old) == 1
    with pytest.raises(SceneError) as error:
        workshop.scene(CAM.replace(old, new))
    text = str(error.value)
    assert f"{where}:" in text and all(part in text for part in told), text


def test_a_good_one(workshop: Workshop) -> None:
    scene = workshop.scene(CAM.replace(LIFT, f"lift = {PIECES}\nangle = 0.3\nclockwise = true"))
    (cam,) = (effect for effect in scene.effects if isinstance(effect, Cam))
    assert {p.path: p.value for p in cam.parameters()} == {
        "cam_0.base": 0.05,
        "cam_0.radius": 0.02,
        "cam_0.lift.0": 0.01,
        "cam_0.angle": 0.3,
        "cam_0.restitution": 0.5,
    }
    assert cam.profile.far(math.pi) == pytest.approx(0.08, abs=1e-15)
    assert cam.profile.far(-1e-9) == pytest.approx(0.07, abs=1e-15)
    assert scene.to_toml() == workshop.scene(scene.to_toml()).to_toml()


def test_every_fault_at_once(workshop: Workshop) -> None:
    text = (
        CAM.replace(LIFT, 'lift = "0.01*cos(t)"').replace("base = 0.05", "base = -1").replace("shaft.O", "shaft.X", 2)
    )
    with pytest.raises(SceneError) as error:
        workshop.scene(text)
    assert len(error.value.faults) >= 3
