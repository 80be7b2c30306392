"""Forces and moments of joints are those on the second links of their ``between``, however a mechanism is cut.

The dense reference of random mechanisms (``test_random_mechanisms``) draws joints either way round and compares every
force. Here: power, turned joints, and Newton's and Euler's laws by differences of places along runs, with contacts,
stops, releases and holds.
"""

from __future__ import annotations


from typing import Any

import numpy as np
import pytest

from ccgen.runtime import driving_torque, ensemble, inverse_dynamics, sensitivities, simulate, static_equilibrium

from ..oracles.maximal import Array
from ..support.workshop import Workshop

G = 9.81
SIX_BAR = """
name = "six-bar"
[ground_link]
points = { A = [7, 4], D = [23, 10], G = [45, 17] }
[[link]]
name = "AB"
mass = 5
inertia = 0.1
com = "M"
points = { A = [7, 4], B = [5, 16], M = [6, 10] }
[[link]]
name = "BCE"
mass = 10
inertia = 0.2
com = "M"
points = { B = [5, 16], C = [25, 25], E = [18, 35], M = [16, "76/3"] }
[[link]]
name = "CD"
mass = 5
inertia = 0.1
com = "M"
points = { C = [25, 25], D = [23, 10], M = [24, 17.5] }
[[link]]
name = "EF"
mass = 10
inertia = 0.2
com = "M"
points = { E = [18, 35], F = [43, 32], M = [30.5, 33.5] }
[[link]]
name = "FG"
mass = 5
inertia = 0.1
com = "M"
points = { F = [43, 32], G = [45, 17], M = [44, 24.5] }
JOINTS
[[drive]]
joint = "DRIVEN"
speed = "SPEED"
[[force]]
point = "FG.M"
vector = [50, 0]
[gravity]
g = 9.81
[run]
until = 0.3
"""
ENDS = {
    "A": ("ground.A", "AB.A"),
    "B": ("AB.B", "BCE.B"),
    "C": ("BCE.C", "CD.C"),
    "D": ("ground.D", "CD.D"),
    "E": ("BCE.E", "EF.E"),
    "F": ("EF.F", "FG.F"),
    "G": ("ground.G", "FG.G"),
}


def six_bar(driven: str, turned: bool) -> str:
    """The six-bar with one joint driven, all joints one way round or the other; the motion is the same."""
    joints = [
        f'[[joint]]\nname = "{name}"\nbetween = {list(ends[::-1] if turned else ends)}'.replace("'", '"')
        for name, ends in ENDS.items()
    ]
    text = SIX_BAR.replace("JOINTS", "\n".join(joints)).replace("DRIVEN", driven)
    return text.replace("SPEED", "-0.1 - 0.5*t" if turned else "0.1 + 0.5*t")


@pytest.mark.sample(3)
@pytest.mark.parametrize("driven", ENDS)
def test_a_drives_moment_times_the_rate_of_its_joint_is_its_power(driven: str, workshop: Workshop) -> None:
    """The power by the energies along the run: dE/dt is that of the drive and of the force. Joints that are turned
    round have all of their forces turned round, and inverse dynamics has the drive's moment."""
    found = []
    for turned in (False, True):
        run = simulate(workshop.model(six_bar(driven, turned)), rtol=1e-11)
        t, h = np.array([0.1, 0.2]), 1e-3
        names = [f"{driven}.moment", f"{driven}.angular_velocity", f"{driven}.power", "FG.M.vx"]
        moment, rate, power, push = run.values(*names, t=t).values()
        energy = [sum(run.model.energy(*run.at(t + k * h))) for k in (-2, -1, 1, 2)]
        gained = (energy[0] - 8.0 * energy[1] + 8.0 * energy[2] - energy[3]) / (12.0 * h)
        assert moment * rate == pytest.approx(gained - 50.0 * push, rel=1e-6)
        assert np.array_equal(moment * rate, power)
        q, u = run.at(0.1)
        u_dot = run.accelerations(0.1)
        assert inverse_dynamics(run.model, q, u, u_dot, [driven], t=0.1) == pytest.approx(moment[:1], rel=1e-9)
        found.append(run.reactions(t))
        assert run.model.second_links == tuple(ends[0 if turned else 1].partition(".")[0] for ends in ENDS.values())
    assert np.max(np.abs(found[0] + found[1])) <= 1e-8 * np.max(np.abs(found[0]))


# -- Newton's and Euler's laws of each link, from its places alone ---------------------------------------------------

MIXED = """
name = "mixed"
[ground_link]
points = { O = [0, 0.2], Q = [1.2, 0.1], R = [-0.7, 0.4] }
[[link]]
name = "cart"
mass = 1.5
inertia = 0.03
com = [0.02, 0.05]
points = { A = [0, 0], H = [0.1, 0.05] }
[[link]]
name = "sledge"
mass = 0.7
inertia = 0.02
com = [0, 0]
points = { A = [0.05, -0.03] }
[[link]]
name = "rod"
mass = 0.9
inertia = 0.05
com = [0.35, 0.04]
points = { A = [0, 0], B = [0.8, 0.1] }
[[link]]
name = "arm"
mass = 1.1
inertia = 0.09
com = [0.2, 0.1]
points = { P = [0, 0], T = [-0.3, 0.2] }
JOINTS
[[spring]]
between = ["ground.R", "cart.H"]
stiffness = 40
length = 0.4
[[torsion]]
joint = "hip"
stiffness = 3
angle = ANGLE
[[joint_friction]]
joints = ["hip", "axle"]
viscous = 0.2
[[motor]]
joint = "axle"
torque = "TORQUE*cos(3*t)"
[[gravity_comes_below]]
DRIVE
[start]
slides = { SLIDES }
angles = { rod = "40 deg", arm = "100 deg" }
[run]
until = 0.6
"""
MIXED = MIXED.replace("[[gravity_comes_below]]", "[gravity]")
KINDS = {"rail": "prismatic", "top": "prismatic", "hip": "", "axle": "", "slot": "pin-in-slot"}
WRITTEN = {
    "rail": ("ground.O", "cart.A"),
    "top": ("cart.H", "sledge.A"),
    "hip": ("cart.A", "rod.A"),
    "axle": ("ground.Q", "arm.P"),
    "slot": ("arm.P", "rod.B"),
}


def mixed(turned: bool, driven: bool) -> str:
    """A cart on a rail with a sledge on top and a rod, whose end slides along an arm."""
    joints = []
    for name, ends in WRITTEN.items():
        between = list(ends[::-1] if turned and name != "slot" else ends)
        kind = f'\ntype = "{KINDS[name]}"\naxis = {[0.8, 0.6] if name == "top" else [1, 0]}' if KINDS[name] else ""
        joints.append(f'[[joint]]\nname = "{name}"{kind}\nbetween = {between}'.replace("'", '"'))
    drive = f'[[drive]]\njoint = "top"\nposition = "{"-" if turned else ""}(0.1 + 0.2*sin(4*t))"'
    text = MIXED.replace("JOINTS", "\n".join(joints)).replace("DRIVE", drive if driven else "")
    text = text.replace("ANGLE", "-0.5" if turned else "0.5").replace("TORQUE", "-2.5" if turned else "2.5")
    return text.replace("SLIDES", f"top = {-0.1 if turned else 0.1}")


def moved(run: Any, t: float) -> tuple[Array, Array, Array]:
    """Mass centres (links, 2) at t, and m a (links, 2) and I alpha (links,) by differences of places, order four."""
    model, h = run.model, 1e-3
    value = model.parameters.get
    com = np.array([[value(f"{k}.com.x", 0.0), value(f"{k}.com.y", 0.0)] for k in model.links])

    def places(at: float) -> Array:
        poses = model.poses(run.at(at)[0])
        c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        x = poses[:, 0] + c * com[:, 0] - s * com[:, 1]
        y = poses[:, 1] + s * com[:, 0] + c * com[:, 1]
        return np.column_stack([x, y, poses[:, 2]])

    rows = [places(t + k * h) for k in (-2, -1, 0, 1, 2)]
    second = (-rows[0] + 16.0 * rows[1] - 30.0 * rows[2] + 16.0 * rows[3] - rows[4]) / (12.0 * h * h)
    mass = np.array([model.parameters[f"{k}.mass"] for k in model.links])
    inertia = np.array([model.parameters[f"{k}.inertia"] for k in model.links])
    return rows[2][:, :2], mass[:, None] * second[:, :2], inertia * second[:, 2]


def balance(run: Any, t: float, ends: dict[str, tuple[str, str]], loads: list[tuple[str, str]]) -> float:
    """What is left of the laws: m a less the weight and all that joints do by their outputs, on the second link as
    said, the opposite on the first; ``loads`` (joint, output) are moments on second links beside."""
    model = run.model
    centres, forces, moments = moved(run, t)
    forces = forces + np.array([[0.0, G * model.parameters[f"{k}.mass"]] for k in model.links])
    size = np.max(np.abs(forces))

    def act(link: str, place: Array, force: Array, moment: float) -> None:
        if link != "ground":
            k = model.links.index(link)
            x, y = place - centres[k]
            forces[k] -= force
            moments[k] -= moment + x * force[1] - y * force[0]

    def place(end: str) -> Array:
        if end.startswith("ground"):
            return np.array({"O": [0.0, 0.2], "Q": [1.2, 0.1], "R": [-0.7, 0.4]}[end[-1]])
        return np.asarray(model.point(end, run.at(t)[0]))

    for name, (first, second) in ends.items():
        fx, fy, moment = (run.values(f"{name}.{what}", t=t)[f"{name}.{what}"] for what in ("fx", "fy", "moment"))
        on, of = second.partition(".")[0], first.partition(".")[0]
        at = second  # a pin in a slot is where the second point is
        if KINDS[name] == "prismatic":  # the later link's point
            at = max(first, second, key=lambda end: ["ground", *model.links].index(end.partition(".")[0]))
        act(on, place(at), np.array([fx, fy]), moment)
        act(of, place(at), -np.array([fx, fy]), -moment)
    for name, output in loads:
        moment = run.values(output, t=t)[output]
        first, second = (end.partition(".")[0] for end in ends[name])
        act(second, np.zeros(2), np.zeros(2), moment)
        act(first, np.zeros(2), np.zeros(2), -moment)
    pull = run.values("spring_0.force", t=t)["spring_0.force"]
    one, other = place("ground.R"), place("cart.H")
    act("cart", other, pull * (one - other) / np.hypot(*(one - other)), 0.0)
    return float(max(np.max(np.abs(forces)), np.max(np.abs(moments))) / size)


LOADS = [
    ("hip", "torsion_0.moment"),
    ("hip", "joint_friction_0.hip.moment"),
    ("axle", "joint_friction_0.axle.moment"),
    ("axle", "motor_0.torque"),
]


@pytest.mark.parametrize("driven", [False, True])
def test_links_accelerate_by_what_their_joints_are_said_to_do(driven: bool, workshop: Workshop) -> None:
    """m a and I alpha of each link from where it is along the run; joints turned round give the opposite numbers, and
    a driven slide's force along its line times the rate is its power."""
    found = []
    for turned in (False, True):
        run = simulate(workshop.model(mixed(turned, driven)), rtol=1e-12)
        assert run.success, run.message
        ends = {name: two[::-1] if turned and name != "slot" else two for name, two in WRITTEN.items()}
        assert all(balance(run, t, ends, LOADS) <= 1e-7 for t in (0.1, 0.35))
        found.append(np.array([run.reactions(t) for t in (0.1, 0.35)]))
        if driven:
            fx, fy, rate, power = run.values("top.fx", "top.fy", "top.slide_rate", "top.power", t=0.35).values()
            along = np.array([0.8, 0.6])
            assert (fx * along[0] + fy * along[1]) * rate == pytest.approx(power, rel=1e-12)
    signs = np.array([1.0 if name == "slot" else -1.0 for name in WRITTEN])[:, None]
    assert np.max(np.abs(found[0] - signs * found[1])) <= 1e-8 * np.max(np.abs(found[0]))
