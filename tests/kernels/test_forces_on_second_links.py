"""Forces and moments of joints are those on the second links of their ``between``, however a mechanism is cut.

The dense reference of random mechanisms (``test_random_mechanisms``) draws joints either way round and compares every
force. Here: power, turned joints, and Newton's and Euler's laws by differences of places along runs, with contacts,
stops, releases and holds.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import ensemble, inverse_dynamics, sensitivities, simulate, static_equilibrium
from ccgen.runtime.record.force_history import write_csv
from ccgen.runtime.record.output_table import write_outputs
from ccgen.runtime.record.outputs import headings_of, outputs_text

from ..oracles.maximal import Array
from ..support.leaning_rod import LEANING
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
        headings, on = headings_of(run.model), "ground" if turned else "arm"
        assert headings["motor_0.torque"] == f"motor_0.torque [N m on {on}]"
        assert headings["joint_friction_0.axle.moment"].endswith(f"[N m on {on}]")
        found.append(np.array([run.reactions(t) for t in (0.1, 0.35)]))
        if driven:
            fx, fy, rate, power = run.values("top.fx", "top.fy", "top.slide_rate", "top.power", t=0.35).values()
            along = np.array([0.8, 0.6])
            assert (fx * along[0] + fy * along[1]) * rate == pytest.approx(power, rel=1e-12)
    signs = np.array([1.0 if name == "slot" else -1.0 for name in WRITTEN])[:, None]
    assert np.max(np.abs(found[0] - signs * found[1])) <= 1e-8 * np.max(np.abs(found[0]))


# -- every place that reports them ---------------------------------------------------------------------------------


def test_all_that_is_reported_turns_with_the_joint(workshop: Workshop, tmp_path: Path) -> None:
    """A rod falls onto the ground and lies there: states, runs, impacts, tables, rest, ensembles and derivatives.

    The weight at rest is shared by the ground and the hinge, G each: upwards on the rod, downwards on the ground.
    """
    found = []
    for sign, between in ((1.0, '["ground.O", "rod.A"]'), (-1.0, '["rod.A", "ground.O"]')):
        text = LEANING.replace('["ground.O", "rod.A"]', between) + "[[drag]]\npoint = 'rod.T'\nlinear = 0.3\n"
        model = workshop.model(text, derivatives=True)
        link = "rod" if sign > 0.0 else "ground"
        assert model.second_links == model.outboard == (link,)
        assert f"fx [N on {link}], fy [N on {link}], moment [N m on {link}]" in outputs_text(model)
        run = simulate(model, rtol=1e-11)
        assert run.reactions(2.0)[0] == pytest.approx([0.0, sign * G, 0.0], abs=1e-9)
        table = write_csv(run, tmp_path / "forces.csv").read_text().splitlines()
        assert f"hinge.fy [N on {link}]" in table[0]
        assert float(table[-1].split(",")[-2]) == pytest.approx(sign * G, rel=1e-9)
        table = write_outputs(run, ["hinge.fy"], tmp_path / "outputs.csv").read_text().splitlines()
        assert table[0] == f"t [s],hinge.fy [N on {link}]"
        assert float(table[-1].split(",")[1]) == pytest.approx(sign * G, rel=1e-9)
        rest = static_equilibrium(model, run.q[-1]).reactions[0]
        assert rest == pytest.approx([0.0, sign * G, 0.0], abs=1e-9)
        (impact,) = run.impacts
        speed = run.values("rod.angular_velocity")["rod.angular_velocity"][np.flatnonzero(run.t == impact.t)]
        jump = 2.0 * 0.5 * (speed[1] - speed[0])  # of the rod's momentum, upwards it is cos 30 of that
        assert sign * impact.reactions[0, 1] + impact.impulses[0] == pytest.approx(jump * np.cos(np.pi / 6.0), rel=1e-8)
        rows = ensemble(model, {"rod.mass": [2.0, 3.0]}, observe=["hinge.fy"], at=[0.1, 2.0])
        assert rows["hinge.fy"][0] == pytest.approx(run.values("hinge.fy", t=[0.1, 2.0])["hinge.fy"], rel=1e-12)
        q, u = run.at(0.1)
        h = 1e-6
        with_more = (model.reactions(q, u + k * h) for k in (1, -1))
        slope = np.subtract(*with_more) / (2.0 * h)
        assert model.derivatives("reactions", q, u, wrt="u")[..., 0] == pytest.approx(slope, abs=1e-8)
        ways = [
            sensitivities(model, ["rod.mass"], ["hinge.fx", "hinge.fy"], at=[0.1], rtol=1e-11, mode=mode)
            for mode in ("tangent", "adjoint")
        ]
        ends = [simulate(model, until=0.1, rtol=1e-11, params={"rod.mass": 2.0 + k * 1e-4}) for k in (1, -1)]
        by_mass = np.subtract(*(one.reactions(0.1)[0, :2] for one in ends)) / 2e-4
        for way in ways:
            assert way.jacobian.ravel() == pytest.approx(by_mass, rel=1e-6)
            assert way.values["hinge.fy"] == pytest.approx(run.values("hinge.fy", t=[0.1])["hinge.fy"], rel=1e-9)
        found.append([run.reactions(0.1), impact.reactions, rest, slope, by_mass])
    for one, other in zip(*found, strict=True):
        assert np.max(np.abs(one + other)) <= 1e-9 * np.max(np.abs(one))


@pytest.mark.parametrize("turned", [False, True])
def test_a_rail_that_takes_hold_gives_its_impulse_to_the_second_link(turned: bool, workshop: Workshop) -> None:
    """A block flies across a rail and spins: the rail takes its momentum across and its spin, about the block's point,
    off the mass centre by c: m v up, and the moment of momentum I w + c m v."""
    between = ["ground.O", "block.A"]
    text = f"""
name = "caught"
[ground_link]
points = {{ O = [-1, 0] }}
[[link]]
name = "block"
mass = 2
inertia = 0.3
com = [0.25, 0]
points = {{ A = [0, 0] }}
free = true
[[link]]
name = "post"
mass = 1
inertia = 1
com = [0, 0]
points = {{ A = [0, 0] }}
[[joint]]
name = "hinge"
between = ["ground.O", "post.A"]
[[joint]]
name = "rail"
type = "prismatic"
axis = [1, 0]
between = {between[::-1] if turned else between}
[[hold]]
joint = "rail"
at = 0
within = 1
[start]
open = ["rail"]
poses = {{ block = [0.4, 0, 0] }}
sliding_velocities = {{ block_x = 0.5, block_y = -3 }}
angular_velocities = {{ block = 2 }}
[run]
until = 0.1
""".replace("'", '"')
    run = simulate(workshop.model(text))
    assert run.success, run.message
    (impact,) = run.impacts
    centre = -3.0 + 0.25 * 2.0  # velocity of the mass centre, across
    up, moment = -2.0 * centre, -(0.3 * 2.0 + 0.25 * 2.0 * centre)
    sign = -1.0 if turned else 1.0
    rail = run.model.joints.index("rail")
    assert impact.reactions[rail] == pytest.approx(sign * np.array([0.0, up, moment]), rel=1e-9, abs=1e-12)
    assert impact.impulses[0] == pytest.approx(up, rel=1e-9)  # its size
