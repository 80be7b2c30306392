"""What effects tell along runs by name, against their laws written with other numbers of the run."""

from __future__ import annotations

import numpy as np
import pytest

from ccgen.runtime import ensemble, simulate

from ..support.workshop import Workshop

G = 9.81
ARM = """
name = "arm"
[ground_link]
points = { O = [0, 0], W = [-1, 1] }
[[link]]
name = "rod"
mass = 1.0
inertia = 0.1
com = [0.5, 0]
points = { A = [0, 0], B = [1, 0] }
[[joint]]
name = "pin"
between = ["ground.O", "rod.A"]
[start]
angles = { rod = "-30 deg" }
angular_velocities = { rod = 0.5 }
[gravity]
[run]
until = 1.5
"""

EFFECTS = {
    "motor": ('joint = "pin"\nangle = "0.3*t"\nstiffness = 20\ndamping = 2\n', ("torque", "power")),
    "spring": ('between = ["ground.W", "rod.B"]\nstiffness = 30\nlength = 1.2\n', ("length", "force")),
    "damper": ('between = ["ground.W", "rod.B"]\ndamping = 3\n', ("force", "power")),
    "torsion": ('joint = "pin"\nstiffness = 8\ndamping = 1.5\nangle = 0.2\n', ("moment",)),
    "torque": ('link = "rod"\ntorque = "4*sin(5*t)"\n', ("torque", "power")),
    "force": ('point = "rod.B"\nvector = [2.0, "t"]\nframe = "link"\n', ("fx", "fy", "power")),
    "joint_friction": ('joints = ["pin"]\nviscous = 0.4\ndry = 1.0\nrate = 0.05\n', ("pin.moment", "power")),
    "brake": ('joint = "pin"\ntorque = 2.0\nrate = 0.05\n', ("torque", "power")),
    "drag": ('point = "rod.B"\nlinear = 0.3\nquadratic = 0.2\n', ("force", "power")),
}


def told(workshop: Workshop, kind: str) -> dict[str, np.ndarray]:
    table, asked = EFFECTS[kind]
    run = simulate(workshop.model(f"{ARM}[[{kind}]]\n{table}"), rtol=1e-10)
    assert [name.removeprefix(f"{kind}_0.") for name in run.outputs if name.startswith(f"{kind}_0.")] == [*asked]
    found = {name: run[f"{kind}_0.{name}"] for name in asked}
    others = ("rod.angle", "rod.angular_velocity", "rod.B.x", "rod.B.y", "rod.B.vx", "rod.B.vy", "t")
    return found | {name.removeprefix("rod."): run[name] for name in others}


def test_a_motor(workshop: Workshop) -> None:
    of = told(workshop, "motor")
    torque = 20 * (0.3 * of["t"] - of["angle"]) + 2 * (0.3 - of["angular_velocity"])
    assert of["torque"] == pytest.approx(torque, abs=1e-12)
    assert of["power"] == pytest.approx(torque * of["angular_velocity"], abs=1e-12)


def test_a_spring_and_a_damper(workshop: Workshop) -> None:
    of = told(workshop, "spring")
    length = np.hypot(of["B.x"] + 1, of["B.y"] - 1)
    assert of["length"] == pytest.approx(length, abs=1e-13)
    assert of["force"] == pytest.approx(30 * (length - 1.2), abs=1e-12)
    of = told(workshop, "damper")
    length = np.hypot(of["B.x"] + 1, of["B.y"] - 1)
    rate = ((of["B.x"] + 1) * of["B.vx"] + (of["B.y"] - 1) * of["B.vy"]) / length
    assert of["force"] == pytest.approx(3 * rate, abs=1e-12)
    assert of["power"] == pytest.approx(-3 * rate**2, abs=1e-12)


@pytest.mark.parametrize("more", ["", "damping = 2\n"])
def test_a_rope_that_pulls_only(more: str, workshop: Workshop) -> None:
    table = f'between = ["ground.W", "rod.B"]\nstiffness = 300\nlength = 2.3\nacts = "pull"\n{more}'
    above = ARM.replace('"-30 deg"', '"30 deg"')
    run = simulate(workshop.model(f"{above}[[spring]]\n{table}"), rtol=1e-10)
    x, y = run["rod.B.x"] + 1, run["rod.B.y"] - 1
    length = np.hypot(x, y)
    rate = (x * run["rod.B.vx"] + y * run["rod.B.vy"]) / length
    force = np.maximum(300 * (length - 2.3) + (2 * rate if more else 0.0), 0.0) * (length > 2.3)
    off = np.abs(length - 2.3) > 1e-9
    assert run["spring_0.force"][off] == pytest.approx(force[off], abs=1e-9)
    assert (force == 0.0).any() and (force > 1.0).any()


def test_moments_at_a_joint(workshop: Workshop) -> None:
    of = told(workshop, "torsion")
    assert of["moment"] == pytest.approx(-8 * (of["angle"] - 0.2) - 1.5 * of["angular_velocity"], abs=1e-12)
    of = told(workshop, "joint_friction")
    moment = -0.4 * of["angular_velocity"] - np.tanh(of["angular_velocity"] / 0.05)
    assert of["pin.moment"] == pytest.approx(moment, abs=1e-12)
    assert of["power"] == pytest.approx(moment * of["angular_velocity"], abs=1e-12)
    of = told(workshop, "brake")
    moment = -2 * np.tanh(of["angular_velocity"] / 0.05)
    assert of["torque"] == pytest.approx(moment, abs=1e-12)
    assert of["power"] == pytest.approx(moment * of["angular_velocity"], abs=1e-12)


def test_loads(workshop: Workshop) -> None:
    of = told(workshop, "torque")
    assert of["torque"] == pytest.approx(4 * np.sin(5 * of["t"]), abs=1e-13)
    assert of["power"] == pytest.approx(4 * np.sin(5 * of["t"]) * of["angular_velocity"], abs=1e-12)
    of = told(workshop, "force")
    turned = np.exp(1j * of["angle"]) * (2.0 + 1j * of["t"])
    assert of["fx"] == pytest.approx(turned.real, abs=1e-13) and of["fy"] == pytest.approx(turned.imag, abs=1e-13)
    assert of["power"] == pytest.approx(turned.real * of["B.vx"] + turned.imag * of["B.vy"], abs=1e-12)
    of = told(workshop, "drag")
    speed = np.hypot(of["B.vx"], of["B.vy"])
    assert of["force"] == pytest.approx(0.3 * speed + 0.2 * speed**2, abs=1e-6)
    assert of["power"] == pytest.approx(-of["force"] * speed, abs=1e-12)


BALL = """
name = "ball"
[[link]]
name = "ball"
disc = { mass = 2.0, radius = 0.1 }
points = { C = [0, 0] }
[start]
position = [0, 0.15]
velocity = [1.0, 0]
[gravity]
[run]
until = 2
[[compliant_ground]]
name = "mat"
contacts = ["ball.C"]
radius = [0.1]
load = 200
depth = 0.01
exponent = 1.5
damping = 2.0
friction = 0.3
"""


def test_a_ground_that_gives_way(workshop: Workshop) -> None:
    """Hertz's law with Hunt and Crossley's damping; what it pushes accelerates the ball."""
    run = simulate(workshop.model(BALL), rtol=1e-10)
    depth, normal, friction = (run[f"mat.ball.C.{name}"] for name in ("depth", "normal", "friction"))
    assert depth == pytest.approx(0.1 - run["ball.C.y"], abs=1e-13)
    deep = depth > 1e-6
    law = 200 * (depth[deep] / 0.01) ** 1.5 * np.maximum(1 - 2.0 * run["ball.C.vy"][deep], 0.0)
    assert normal[deep] == pytest.approx(law, abs=1e-9)
    assert not normal[depth < -1e-6].any() and (depth < -1e-6).any()
    clear = np.abs(depth) > 1e-6
    assert normal[clear] == pytest.approx(2 * (run["ball.C.ay"][clear] + G), abs=1e-7)
    assert friction[clear] == pytest.approx(2 * run["ball.C.ax"][clear], abs=1e-7)
    assert np.abs(friction[deep]).max() > 1.0 and (np.abs(friction) <= 0.3 * normal + 1e-9).all()


def test_effects_that_are_off_tell_nothing(workshop: Workshop) -> None:
    """A spring that an event switches off: its force is zero from then on."""
    spring = '[[spring]]\nname = "band"\nbetween = ["ground.W", "rod.B"]\nstiffness = 30\nlength = 1.2\n'
    event = '[[event]]\nname = "cut"\nwhen = "t - 0.7"\noff = ["band"]\n'
    run = simulate(workshop.model(f"{ARM}{spring}{event}"))
    force = run["band.force"]
    assert force[run.t < 0.7].all() and not force[run.t > 0.7].any()


LINE = 'between = ["ground.W", "rod.B"]\n'
SWITCHED = (
    f'[[spring]]\nname = "band"\n{LINE}stiffness = 30\nlength = 1.2\n[[damper]]\nname = "pot"\n{LINE}damping = 3\n'
    '[[compliant_ground]]\nname = "mat"\ncontacts = ["rod.B"]\npoint = [0, -0.45]\nload = 10\ndepth = 0.1\n'
    '[[event]]\nname = "cut"\nwhen = "t - 0.7"\noff = ["band", "pot", "mat"]\n'
    '[[event]]\nname = "again"\nwhen = "t - 1.2"\non = ["band", "pot", "mat"]\n'
)


def test_of_what_is_off_forces_are_zero_and_lengths_no_numbers(workshop: Workshop) -> None:
    """As gaps of contacts are; and reactions, accelerations and energies are those of the rod alone."""
    model = workshop.model(f"{ARM}{SWITCHED}")
    run, names = simulate(model, rtol=1e-10), ("band.force", "pot.force", "pot.power", "mat.rod.B.normal")
    times, off = np.linspace(0.0, 1.5, 31), slice(14, 24)
    assert times[off][0] == pytest.approx(0.7) and times[off][-1] == pytest.approx(1.15)
    found = run.values(*names, "band.length", "mat.rod.B.depth", "rod.B.x", "rod.B.y", t=times + 1e-6 * (times < 1))
    for name in names:
        assert found[name][off].tolist() == [0.0] * 10 and not np.signbit(found[name][off]).any()
        assert np.delete(found[name], range(14, 24)).any()
    length = np.hypot(found["rod.B.x"] + 1, found["rod.B.y"] - 1)
    for name in ("band.length", "mat.rod.B.depth"):
        assert np.isnan(found[name][off]).all() and np.isfinite(np.delete(found[name], range(14, 24))).all()
    assert np.delete(found["band.length"] - length, range(14, 24)) == pytest.approx(np.zeros(21), abs=1e-12)
    assert np.isnan(run["band.length"][run.t > 0.7][run.t[run.t > 0.7] < 1.2]).all()
    at = run.values("rod.angle", "rod.angular_velocity", "pin.fx", "pin.moment", "potential_energy", t=1.0)
    angle, rate = at["rod.angle"], at["rod.angular_velocity"]
    spin = -G * 0.5 * np.cos(angle) / (0.1 + 0.25)
    assert run.accelerations(1.0)[0] == pytest.approx(spin, abs=1e-9)
    assert at["pin.fx"] == pytest.approx(0.5 * (-(rate**2) * np.cos(angle) - spin * np.sin(angle)), abs=1e-9)
    assert at["potential_energy"] == pytest.approx(G * 0.5 * np.sin(angle), abs=1e-12)
    many = ensemble(model, {"rod.mass": [1.0, 1.5]}, observe=["band.length", "band.force"], at=[0.3, 1.0])
    assert many["band.length"][0, 0] == pytest.approx(run.values("band.length", t=0.3)["band.length"], abs=1e-7)
    assert np.isnan(many["band.length"][:, 1]).all() and many["band.force"][:, 1].tolist() == [0.0, 0.0]


def test_a_spring_that_is_off_does_not_meet_its_end(workshop: Workshop) -> None:
    """Its length was told as zero, by which derivatives were refused."""
    spring = f'[[spring]]\nname = "band"\n{LINE}stiffness = 30\nlength = 1.2\n'
    event = '[[event]]\nwhen = "t - 9"\non = ["band"]\n'
    text = ARM.replace("[gravity]", 'off = ["band"]\n[gravity]') + spring + event
    run = simulate(workshop.model(text, derivatives=True), rtol=1e-10, until=0.4)
    plain = simulate(workshop.model(ARM, derivatives=True), rtol=1e-10, until=0.4)
    found, wanted = (one.jacobian(["rod.mass"], ["rod.angle"]) for one in (run, plain))
    assert found == pytest.approx(wanted, rel=1e-6)


def test_scenes_without_such_effects_tell_nothing(workshop: Workshop) -> None:
    model = workshop.model(ARM)
    assert model.told == () and model.data["outputs"] == []
    assert ".outputs" not in (model.folder / "model.c").read_text()
