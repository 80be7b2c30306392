"""Mechanisms beside their mirror images and turned copies: effects of placed parts move them as the plain ones.

The answer is symmetry's own: what a part does, its mirror image does, seen in the mirror. Each part has joints to the
outside, both ways round, and joints of its own, so that every rule of a joint's angle is asked.
"""

from __future__ import annotations

import numpy as np
import pytest

from ccgen.generator import SceneError, load_scene
from ccgen.generator.effects import REGISTRY
from ccgen.runtime import Model, simulate

from ..support.tiers import all_hard_but
from ..support.workshop import Workshop

ARM = """
name = "arms"
[run]
until = 1.5
rtol = 1e-10
[ground_link]
points = { O = [0, 0] }
[[part]]
name = "arm"
ports = ["base"]
[[part.link]]
name = "upper"
mass = 1.0
inertia = 0.05
com = [0.3, 0.07]
points = { A = [0, 0], B = [0.8, 0.1], S = [0.4, 0.2] }
[[part.link]]
name = "fore"
rod = { mass = 0.6, between = ["B", [0.7, 0.2]] }
disc = { mass = 0.3, radius = 0.1, centre = "T" }
points = { B = [0, 0], T = [0.5, -0.1] }
[[part.joint]]
name = "shoulder"
between = ["base", "upper.A"]
[[part.joint]]
name = "elbow"
between = ["fore.B", "upper.B"]
[part.start]
angles = { upper = "-50 deg", fore = "15 deg" }
angular_velocities = { upper = 1.5, fore = -2 }
"""
INWARDS = ARM.replace('between = ["base", "upper.A"]', 'between = ["upper.A", "base"]')
RAILS = """
[[part.link]]
name = "slider"
rod = { mass = 0.4 }
points = { C = [0, 0.05], D = [0.3, 0.1] }
[[part.joint]]
name = "rail"
type = "prismatic"
between = ["fore.T", "slider.C"]
axis = [0.8, 0.6]
angle = "25 deg"
[[part.spring]]
between = ["slider.D", "upper.S"]
stiffness = 40
length = 0.2
"""
GUIDE = """
[part.ground_link]
points = { G = [0.3, -0.9] }
[[part.link]]
name = "block"
mass = 0.5
inertia = 0.02
com = [0.01, 0.02]
points = { C = [0, 0] }
[[part.joint]]
name = "guide"
type = "prismatic"
between = ["ground.G", "block.C"]
axis = "20 deg"
angle = "-35 deg"
[[part.spring]]
between = ["fore.T", "block.C"]
stiffness = 30
length = 0.3
"""
SLOT = """
[part.ground_link]
points = { G = [0.5, -1.0] }
[[part.link]]
name = "lever"
mass = 0.5
inertia = 0.02
com = [0.1, 0.02]
points = { G = [0, 0] }
[[part.joint]]
name = "pivot"
between = ["lever.G", "ground.G"]
[[part.joint]]
name = "slot"
type = "pin-in-slot"
between = ["lever.G", "fore.T"]
axis = [1, 0.2]
"""
WHEELS = """
[[part.link]]
name = "pinion"
disc = { mass = 0.3, radius = 0.06 }
points = { C = [0, 0] }
[[part.link]]
name = "wheel"
disc = { mass = 0.6, radius = 0.1 }
points = { C = [0, 0] }
[[part.joint]]
name = "pinion_axle"
between = ["fore.B", "pinion.C"]
[[part.joint]]
name = "wheel_axle"
between = ["wheel.C", "fore.T"]
[[part.rack]]
pinion = "pinion_axle"
slide = "rail"
radius = 0.06
[[part.gear]]
joints = ["pinion_axle", "wheel_axle"]
ratio = 2
[[part.belt]]
joints = ["wheel_axle", "elbow"]
radii = [0.1, 0.2]
carrier = "fore"
"""
CASES = {
    "plain": "",
    "torsion": """
        [[part.torsion]]\njoint = "shoulder"\nstiffness = 20\nangle = "-30 deg"\ndamping = 0.1
        [[part.torsion]]\njoint = "elbow"\nstiffness = 10\nangle = 0.4\n""",
    "stop": """
        [[part.stop]]\njoint = "shoulder"\nlowest = "-60 deg"\nhighest = 0.9\nrestitution = 0.4
        [[part.stop]]\njoint = "elbow"\nhighest = "-0.9"\nrestitution = 0.6\n""",
    "motor": """
        [[part.motor]]\njoint = "shoulder"\nangle = "0.3*sin(4*t)"\nstiffness = 30\ndamping = 1\nlimit = 4
        [[part.motor]]\njoint = "elbow"\ntorque = "cos(3*t) + 0.2"
        [[part.motor]]\njoint = "elbow"\ntable = [[0, 0.3], [1, -0.5]]\n""",
    "laws": """
        [[part.law]]\nname = "held"\nvalue = "clip(-k*(angle(shoulder) + 0.8) - 0.3*rate(shoulder), -most, most)"
        parameters = { k = 12, most = 3 }
        [[part.law]]\nname = "drawn"\nvalue = "x(fore.T)*vy(fore.T) - 2*rate(x(upper.S)) + rate(direction(fore))"
        [[part.motor]]\njoint = "shoulder"\ntorque = "held + min(drawn, 2)"
        [[part.motor]]\njoint = "elbow"\ntorque = "-distance(base, fore.T)*rate(elbow) - 0.5*sin(direction(fore))"
        [[part.torque]]\nlink = "fore"\ntorque = "0.5*y(upper.S)*angle(elbow) + abs(drawn)*0.2"
        [[part.force]]\npoint = "fore.T"\nvector = ["-3*x(fore.T)", "vx(fore.T)"]\nframe = "link"\n""",
    "vectors": """
        [[part.law]]\nname = "drawn"\nvalue = "k*x(fore.T)*vy(fore.T) - abs(y(upper.S))"\nparameters = { k = 1.5 }
        [[part.force]]\npoint = "fore.T"\nvector = ["2*x(fore.T) + drawn", "-3*angle(elbow)*vx(fore.T)"]
        [[part.force]]\npoint = "upper.S"\nvector = [0, "drawn"]
        [[part.force]]\npoint = "upper.S"\nvector = ["-min(x(upper.S), 0.3)", "2 N"]\n""",
    "drive": '[[part.drive]]\njoint = "shoulder"\nangle = "0.3*sin(4*t) - 0.8"\n',
    "speed": '[[part.drive]]\njoint = "elbow"\nspeed = "0.5 + t"\n',
    "loads": """
        [[part.force]]\npoint = "fore.T"\nvector = [2, "3*sin(t)"]\nframe = "link"
        [[part.torque]]\nlink = "upper"\ntorque = "1 - t"
        [[part.drag]]\npoint = "fore.T"\nlinear = 0.3
        [[part.joint_friction]]\njoints = ["shoulder", "elbow"]\nviscous = 0.2
        [[part.damper]]\nbetween = ["fore.T", "upper.A"]\ndamping = 0.5
        [[part.spring]]\nbetween = ["fore.T", "ground.O"]\nstiffness = 25\nlength = 0.6\nacts = "pull"\n""",
    "touch": """
        [[part.torsion]]\njoint = "elbow"\nstiffness = 20\nangle = 2.5
        [[part.touch]]\nbetween = ["fore.T", ["upper.A", "upper.S"]]\nradius = 0.1\nrestitution = 0.3
        friction = 0.2\n""",
    "soft touch": """
        [[part.torsion]]\njoint = "elbow"\nstiffness = 20\nangle = 2.5
        [[part.compliant_touch]]\nbetween = ["fore.T", ["upper.A", "upper.S"]]\nradius = 0.1\nload = 50\ndepth = 0.01
        restitution = 0.5\nfriction = 0.2\n""",
    "rope": """
        [[part.rope]]\nbetween = ["upper.A", "fore.T"]\nlength = 1.25\nrestitution = 0.4
        [[part.brake]]\njoint = "elbow"\ntorque = "0.1 + 0.1*t"\n""",
    "journal": """
        [[part.torsion]]\njoint = "elbow"\nstiffness = 8\nangle = 0
        [[part.journal]]\nbetween = ["fore.T", ["upper.A", "upper.S"]]\nradius = 0.02\nclearance = 0.85
        restitution = 0.4\nfriction = 0.1\n""",
    "meshes": RAILS + WHEELS,
    "cam": """
        [[part.torsion]]\njoint = "elbow"\nstiffness = 20\nangle = 2.5
        [[part.cam]]\ncentre = "upper.S"\nfollower = "fore.T"\nbase = 0.4\nradius = 0.1\nangle = "20 deg"
        lift = "0.05*cos(angle) + 0.04*sin(2*angle)"\nrestitution = 0.3\nfriction = 0.2\n""",
    "input": '[[part.input]]\nname = "push"\npoint = "fore.T"\ndirection = [1, 2]\nframe = "link"\n',
    "rail": RAILS,
    "guide": GUIDE,
    "slot": SLOT + '[[part.torsion]]\njoint = "slot"\nstiffness = 3\nangle = "40 deg"\n',
    "sliding": GUIDE
    + """
        [[part.motor]]\njoint = "guide"\nposition = "0.1*sin(3*t)"\nstiffness = 50\ndamping = 2
        [[part.joint_friction]]\njoints = ["guide"]\nviscous = 0.4\n""",
    "pushed": RAILS + '[[part.drive]]\njoint = "rail"\nspeed = "0.2*cos(t)"\n',
    "drawn": RAILS.replace("[[part.link]]", "[part.start.slides]\nrail = 0.2\n[[part.link]]"),
}
"""What is added to the part, by name."""
UNMOVED = ("torsion", "laws", "vectors", "stop", "motor", "drive", "loads", "guide", "slot", "pushed", "meshes")
"""Those that are tried without gravity too."""
SYMMETRIC = 1e-8
"""m: runs of this tolerance agree to less, whichever way their steps go."""


def ends(model: Model, name: str) -> np.ndarray:
    """Where the points of a placed arm go, as complex numbers (times, points)."""
    run = simulate(model, **({"inputs": {"push_a": 1.5, "push_b": 1.5}} if "push_a" in model.inputs else {}))
    assert run.success, run.message
    q, _ = run.at(np.linspace(0.0, run.t[-1], 60))
    points = [point for point in model.points if point.endswith((f"_{name}.T", f"_{name}.S", f"_{name}.D"))]
    assert len(points) >= 2
    places = np.array([model.point(point, q) for point in points])
    return np.asarray(places[..., 0] + 1j * places[..., 1])


def of_part(arm: str, case: str) -> str:
    """A part with what is added to it. One with a drive begins as that moves; all links begin at some angle, as those
    that follow the others need not do so in a mirror's way."""
    began = "angular_velocities = { upper = 1.5, fore = -2 }\n"
    text = arm.replace(began, "" if case in ("drive", "speed", "pushed") else began)
    more = {"slot": ", lever = 1.4", "meshes": ", pinion = 0.3, wheel = 0.7"}.get(case, "")
    return text.replace('fore = "15 deg" }', f'fore = "15 deg"{more} }}') + CASES[case]


def placed(place: str) -> str:
    return f'\n[[place]]\npart = "arm"\nports = {{ base = "ground.O" }}\n{place}\n'


@pytest.mark.sample(3)
@pytest.mark.parametrize("arm", [ARM, INWARDS], ids=["outwards", "inwards"])
@pytest.mark.parametrize(
    "case",
    all_hard_but("torsion", "stop", "motor", "laws", "vectors", "loads", "slot", "rope", "meshes", "cam", of=CASES),
)
def test_mirrored_parts_move_as_their_mirror_images(case: str, arm: str, workshop: Workshop) -> None:
    """Under gravity, beside each other in one model."""
    text = of_part(arm, case) + "[gravity]\n" + placed('name = "a"') + placed('name = "b"\nmirror = true')
    model = workshop.model(workshop.scene(text))
    left, right = ends(model, "a"), ends(model, "b")
    assert np.ptp(left.real, axis=1).max() > 0.05
    assert np.abs(right + left.conjugate()).max() <= SYMMETRIC


@pytest.mark.sample(2)
@pytest.mark.parametrize("arm", [ARM, INWARDS], ids=["outwards", "inwards"])
@pytest.mark.parametrize("case", all_hard_but("torsion", "guide", "laws", "vectors", of=[*UNMOVED]))
def test_turned_parts_move_as_turned(case: str, arm: str, workshop: Workshop) -> None:
    """Without gravity, which does not turn with them: by 50 degrees, mirrored and not, and moved where they can be."""
    turn = np.exp(1j * np.radians(50.0))
    text = of_part(arm, case)
    places = ('name = "a"', 'name = "b"\nangle = "50 deg"', 'name = "c"\nangle = "50 deg"\nmirror = true')
    model = workshop.model(workshop.scene(text + "".join(map(placed, places))))
    plain, turned, mirrored = (ends(model, name) for name in "abc")
    assert np.abs(turned - turn * plain).max() <= SYMMETRIC
    assert np.abs(mirrored + turn * plain.conjugate()).max() <= SYMMETRIC


def test_parts_stand_where_they_are_put(workshop: Workshop) -> None:
    """Points of the ground and drawn starts move with the place."""
    text = ARM.replace("ports", "# ports").replace('["base", "upper.A"]', '["ground.P", "upper.A"]')
    text = text.replace("[part.start]", "[part.ground_link]\npoints = { P = [0.5, 0.2] }\n[part.start]")
    text = text.replace('angles = { upper = "-50 deg", fore = "15 deg" }', "joints = { elbow = [1, -0.4] }")
    places = ('name = "a"', 'name = "b"\nat = [3, "50 cm"]\nangle = "90 deg"\nmirror = true')
    text += "[gravity]\n" + "".join(f'\n[[place]]\npart = "arm"\n{place}\n' for place in places)
    scene = workshop.scene(text)
    assert [point.values() for point in scene.mechanism.ground_points.values()][1:] == [
        (0.5, 0.2),
        (3 - 0.2, 0.5 - 0.5),
    ]
    (x, y, angle), (far_x, far_y, turned) = scene.start.poses[0], scene.start.poses[2]
    assert (far_x, far_y) == pytest.approx((3 - y, 0.5 - x), abs=1e-12)
    assert np.exp(1j * turned) == pytest.approx(np.exp(1j * (1.5 * np.pi - angle)), abs=1e-9)


def test_every_effect_of_a_part_is_asked() -> None:
    """But grounds, which stay as they are."""
    text = "".join(CASES.values()).replace("part.", "")
    named = {key for key in (entry.key for entry in REGISTRY if entry.many) if f"[[{key}]]" in text}
    assert named == {entry.key for entry in REGISTRY if entry.many} - {"ground", "compliant_ground"}


def test_a_number_called_as_a_joint_is_not_taken_for_it(workshop: Workshop) -> None:
    """In expressions of the state of a part that is mirrored."""
    text = ARM.replace('ports = ["base"]', 'ports = ["base"]\nlet = { NUMBER = 0.4 }')
    text += '[[part.motor]]\njoint = "elbow"\ntorque = "-NUMBER*angle(elbow) - 0.1*rate(elbow)*NUMBER"\n'
    text += placed('name = "a"\nmirror = true\nangle = 0.3')
    one, other = (workshop.model(text.replace("NUMBER", name)) for name in ("elbow", "gain"))
    q, u = one.start()
    assert np.array_equal(one.acceleration(q, u), other.acceleration(q, u))


def test_grounds_of_parts_stay(workshop: Workshop) -> None:
    text = ARM + '[[part.ground]]\npoint = [0, -5]\nnormal = [0.2, 1]\nrestitution = 0\ncontacts = ["fore.T"]\n'
    scene = load_scene(workshop.scene(text + placed('name = "a"\nmirror = true\nangle = 0.3')).to_dict())
    (ground,) = scene.effects
    assert [parameter.value for parameter in ground.parameters()] == pytest.approx(
        [0.2 / 1.04**0.5, 1 / 1.04**0.5, -5, 0]
    )


def test_a_cam_beside_the_part_is_not_turned(workshop: Workshop) -> None:
    """Its profile would have to be another one on a link that stays."""
    cam = '[[part.cam]]\ncentre = "ground.O"\nfollower = "fore.T"\nbase = 0.1\nlift = "0.01*cos(angle)"\n'
    cam += "restitution = 0\n"
    workshop.scene(ARM + cam + placed('name = "a"'))
    for change in ("mirror = true", 'angle = "90 deg"'):
        with pytest.raises(SceneError, match="found the centre of a cam on a link that is not the part's"):
            workshop.scene(ARM + cam + placed(f'name = "a"\n{change}'))


def test_vectors_of_the_state_are_seen_from_the_part(workshop: Workshop) -> None:
    """Mirrored and turned as wholes, to rounding; those of numbers and of the time stay, as they are given in fixed
    axes."""
    places = ('name = "a"', 'name = "b"\nmirror = true', 'name = "c"\nangle = "50 deg"')
    model = workshop.model(workshop.scene(ARM + CASES["vectors"] + "".join(map(placed, places))))
    q, u = model.start()
    found = model.acceleration(q, u)
    own, mirrored, turned = (
        np.array([found[model.q_of.index(f"{link}_{name}.angle")] for link in ("upper", "fore")]) for name in "abc"
    )
    assert np.abs(own).min() > 0.1
    assert mirrored == pytest.approx(-own, rel=1e-13)
    assert turned == pytest.approx(own, rel=1e-13)


def test_vectors_over_time_stay(workshop: Workshop) -> None:
    text = ARM + '[[part.force]]\npoint = "upper.S"\nvector = [2, "3*sin(t)"]\n'
    scene = workshop.scene(text + placed('name = "a"') + placed('name = "b"\nmirror = true\nangle = 0.3'))
    one, other = scene.effects
    assert [part.shown for part in (one.vector[1], other.vector[1])] == ["3 * sin(t)"] * 2
    assert one.vector[0].value == other.vector[0].value == 2.0
