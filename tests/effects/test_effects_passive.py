"""Springs, dampers, friction, drag and gravity in any direction, against dense references and closed forms."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ccgen.generator.pipeline import listing
from ccgen.generator.program.reading import read_listing
from ccgen.generator.scene import SceneError
from ccgen.runtime import simulate

from ..oracles import loads, maximal, mechanisms
from ..oracles.loads import Acting, Place
from ..oracles.maximal import GROUND, Array
from ..oracles.mechanisms import Drawing
from ..support.dense_comparison import allowed, close, quasi_accelerations, states
from ..support.tiers import all_hard_but
from ..support.workshop import Workshop

KINDS = ("spring", "damper", "torsion", "joint_friction", "drag", "gravity")
DIRECTION = (0.6, -0.8)
FAMILIES = [("hinged", 3), ("floating", 4), ("two_loops", 7), ("pinned", 3)]
Values = dict[str, float]


class Acted:
    """A drawn mechanism with effects at random places: the scene's tables, and the same for the reference."""

    def __init__(self, family: str, n: int, kinds: tuple[str, ...]) -> None:
        drawing = mechanisms.FAMILIES[family](n)
        ground = drawing.ground or {"O": (1.3, -2.1)}  # beside those that float too
        drawing = replace(drawing, system=drawing.system.with_gravity(0.0), ground=ground)
        self.drawing, self.kinds = drawing, kinds
        self.g, self.along = (9.81, DIRECTION) if "gravity" in kinds else (0.0, (0.0, -1.0))
        rng = np.random.default_rng([5, n])
        self.lines = [self._line(rng, ground=kind) for kind in ((True, False) if n % 2 else (False, True))]
        self.point = self._name(rng)
        self.joint = len(drawing.system.pins) - 1
        tables = {
            "spring": f'[[spring]]\nname = "coil"\nbetween = {self._between(0)}\nstiffness = 40.0\nlength = 0.7\n',
            "damper": f'[[damper]]\nname = "pot"\nbetween = {self._between(1)}\ndamping = 3.0\n',
            "torsion": f'[[torsion]]\njoint = "joint_{self.joint}"\nstiffness = 6.0\nangle = "40 deg"\ndamping = 0.8\n',
            "joint_friction": "[[joint_friction]]\nviscous = 0.3\ndry = 0.9\nrate = 0.5\n",
            "drag": f'[[drag]]\npoint = "{self.point}"\nlinear = 0.4\nquadratic = 0.7\nspeed = 0.1\n',
            "gravity": f"[gravity]\ng = 9.81\ndirection = {[5 * x for x in DIRECTION]}\n",
        }
        self.text = drawing.toml(extra="".join(tables[kind] for kind in kinds))

    def _name(self, rng: np.random.Generator) -> str:
        names = [f"body_{k}.{p}" for k, points in enumerate(self.drawing.points) for p in points]
        return str(rng.choice(names))

    def _line(self, rng: np.random.Generator, ground: bool) -> tuple[str, str]:
        """Two points of different links, well apart; with ``ground`` the first is one of the ground."""
        system, poses = self.drawing.system, self.drawing.poses
        for _ in range(100):
            fixed = f"ground.{rng.choice(list(self.drawing.ground))}"
            one, other = fixed if ground else self._name(rng), self._name(rng)
            gap = [Acting(system, poses, 0 * poses).at(self.place(name))[0] for name in (one, other)]
            if one.split(".")[0] != other.split(".")[0] and np.hypot(*(gap[0] - gap[1])) > 0.6:
                return one, other
        raise AssertionError("no two points are apart")

    def _between(self, line: int) -> str:
        return "[{}]".format(", ".join(f'"{name}"' for name in self.lines[line]))

    def place(self, name: str) -> Place:
        owner, point = name.split(".")
        if owner == "ground":
            return GROUND, self.drawing.ground[point]
        link = int(owner.removeprefix("body_"))
        return link, self.drawing.points[link][point]

    def acting(self, poses: Array, velocities: Array, v: Values) -> Acting:
        """What the effects do, with parameters ``v``."""
        acting = Acting(self.drawing.system, poses, velocities)
        pins = self.drawing.system.pins
        lines = [(self.place(one), self.place(other)) for one, other in self.lines]
        if "spring" in self.kinds:
            acting.spring(*lines[0], v["coil.stiffness"], v["coil.length"])
        if "damper" in self.kinds:
            acting.damper(*lines[1], v["pot.damping"])
        if "torsion" in self.kinds:
            pin = pins[self.joint]
            acting.torsion(pin.a, pin.b, *(v[f"torsion_0.{key}"] for key in ("stiffness", "angle", "damping")))
        for pin in pins if "joint_friction" in self.kinds else ():
            acting.friction(pin.a, pin.b, *(v[f"joint_friction_0.{key}"] for key in ("viscous", "dry", "rate")))
        if "drag" in self.kinds:
            acting.drag(self.place(self.point), *(v[f"drag_0.{key}"] for key in ("linear", "quadratic", "speed")))
        return acting

    def solve(self, poses: Array, velocities: Array, v: Values) -> maximal.Motion:
        system = self.drawing.system.with_gravity(v.get("gravity.g", 0.0))
        along = (v.get("gravity.direction.x", 0.0), v.get("gravity.direction.y", -1.0))
        wrenches = self.acting(poses, velocities, v).wrenches
        motion: maximal.Motion = loads.accelerate(system, poses, velocities, wrenches, along)
        return motion


ALONE = [(kind, (kind,), "two_loops", 7) for kind in KINDS]
TOGETHER = [("all", KINDS, *family) for family in [*FAMILIES, ("open", 12)]]
FEW = [case for case in ALONE if case[0] == "joint_friction"] + [case for case in TOGETHER if case[3] < 5]


@pytest.fixture(
    scope="module",
    params=all_hard_but(*FEW, of=ALONE + TOGETHER),
    ids=lambda case: f"{case[0]}-{case[2]}-{case[3]}",
)
def acted(request: pytest.FixtureRequest, workshop: Workshop) -> tuple[Any, Acted]:
    _, kinds, family, n = request.param
    acted = Acted(family, n, kinds)
    return workshop.model(acted.text), acted


@pytest.mark.sample(3)
def test_accelerations_are_those_of_the_dense_solve(acted: tuple[Any, Acted]) -> None:
    model, case = acted
    for state in states(model, case.drawing, 6):
        wanted = quasi_accelerations(model, case.solve(state.poses, state.velocities, dict(model.parameters)))
        assert close(model.acceleration(state.q, state.u), wanted, allowed(case.drawing.system))


def test_reactions_and_multipliers_hold_the_loads(acted: tuple[Any, Acted]) -> None:
    model, case = acted
    for state in states(model, case.drawing, 4):
        motion = case.solve(state.poses, state.velocities, dict(model.parameters))
        reactions = model.reactions(state.q, state.u)
        assert close(reactions[:, :2], motion.forces, allowed(case.drawing.system))
        cuts = np.array([row for name in model.cuts for row in motion.forces[model.joints.index(name)]], float)
        scale = float(np.max(np.abs(motion.forces)))
        miss = np.max(np.abs(model.multipliers(state.q, state.u) - cuts), initial=0.0)
        assert miss <= allowed(case.drawing.system) * scale


def test_energy_and_power(acted: tuple[Any, Acted], workshop: Workshop) -> None:
    """The power as the listing has it; a scene without such effects has no kernel for it."""
    model, case = acted
    listed = read_listing(listing(workshop.scene(case.text)))
    for state in states(model, case.drawing, 3):
        acting = case.acting(state.poses, state.velocities, dict(model.parameters))
        system = case.drawing.system
        places = state.poses[:, :2] + maximal.turned(state.poses[:, 2], system.com)
        wanted = acting.potential - case.g * float(system.mass @ (places @ np.array(case.along)))
        size = abs(float(acting.potential)) + case.g * float(system.mass.sum()) * (1 + np.abs(places).max())
        assert abs(model.energy(state.q, state.u)[1] - wanted) <= 1e-14 * size
        if acting.power:
            given = {"q": state.q, "u": state.u, "t": np.zeros(1), "inputs": np.zeros(0)}
            assert listed.evaluate("power", given)["power"][0] == pytest.approx(float(acting.power), rel=1e-12)
    assert ("power" in listed.kernels) == bool(acting.power)


def test_changed_parameters_take_effect(acted: tuple[Any, Acted]) -> None:
    """Every parameter of every effect, changed together; the model itself keeps its own."""
    model, case = acted
    effects = {path: value for path, value in model.parameters.items() if not path.startswith(("body", "ground."))}
    assert effects
    changed = {path: 1.0 + 1.3 * value for path, value in effects.items()}
    other = model.with_parameters(changed)
    state = next(iter(states(model, case.drawing, 1)))
    wanted = quasi_accelerations(model, case.solve(state.poses, state.velocities, dict(other.parameters)))
    assert close(other.acceleration(state.q, state.u), wanted, allowed(case.drawing.system))
    assert not close(model.acceleration(state.q, state.u), wanted, 1e-3)


@pytest.mark.parametrize(("family", "n"), FAMILIES, ids=str)
def test_work_closes_the_energy_balance(family: str, n: int, workshop: Workshop) -> None:
    model = workshop.model(Acted(family, n, KINDS).text)
    _, u = model.start()
    q, u = model.project(model.start()[0], np.random.default_rng(3).normal(size=u.size))
    run = simulate(model, q, u, until=2.0, rtol=1e-11)
    assert run.success, run.message
    kinetic, potential = model.energy(run.q, run.u)
    lost = (kinetic + potential)[0] - (kinetic + potential)[-1]
    assert lost > 0.1
    assert run.energy_drift <= 1e-9 * np.max(np.abs(kinetic) + np.abs(potential))


# --- far from the origin, and turned ----------------------------------------------------------------------------------


def test_internal_springs_do_not_feel_the_place(workshop: Workshop) -> None:
    text = """
        [loop]
        links = 5
        [[spring]]
        between = ["link_0.A", "link_2.A"]
        stiffness = 50
        length = 0.5
        [[damper]]
        between = ["joint_1", "link_3.B"]
        damping = 4
        [[torsion]]
        joint = "joint_2"
        stiffness = 3
    """
    model = workshop.model(text)
    q, _ = model.start()
    q, u = model.project(q, np.random.default_rng(1).normal(size=q.size))
    far = q.copy()
    far[[model.q_names.index(name) for name in model.q_names if name[0] in "xy"]] += (500.0, -500.0)
    assert far[0] - q[0] == pytest.approx(500.0)
    assert close(model.acceleration(far, u), model.acceleration(q, u), 1e-13)
    assert close(model.reactions(far, u), model.reactions(q, u), 1e-13)
    assert model.energy(far, u)[1] == pytest.approx(model.energy(q, u)[1], rel=1e-13)


def _turned(drawing: Drawing, angle: float) -> Drawing:
    poses = drawing.poses.copy()
    poses[:, :2] = maximal.turned(np.full(len(poses), angle), poses[:, :2])
    poses[:, 2] += angle
    return replace(drawing, poses=poses, system=drawing.system.with_gravity(0.0))


@pytest.mark.sample(1)
@pytest.mark.parametrize(("family", "n"), [("floating", 4), ("hinged", 3), ("two_loops", 7)], ids=str)
def test_turned_gravity_is_a_turned_mechanism(family: str, n: int, workshop: Workshop) -> None:
    """The ground's only point is the origin, or there is none: turning everything changes no angular acceleration."""
    drawing = mechanisms.FAMILIES[family](n)
    angle = 0.7
    direction = [float(np.sin(angle)), float(-np.cos(angle))]
    turned = _turned(drawing, angle).toml(extra=f"[gravity]\ndirection = {direction}\n")
    upright, leaning = workshop.model(drawing.toml()), workshop.model(turned)
    for state in states(upright, drawing, 4):
        poses, velocities = (maximal.turned(np.full(len(x), angle), x[:, :2]) for x in (state.poses, state.velocities))
        one = np.column_stack([poses, state.poses[:, 2] + angle])
        q, u = leaning.state_from_poses(one, np.column_stack([velocities, state.velocities[:, 2]]))
        found, wanted = leaning.acceleration(q, u), upright.acceleration(state.q, state.u)
        if not drawing.ground:
            wanted[:2] = maximal.turned(np.asarray(angle), wanted[:2])
        assert close(found, wanted, 1e-12)
        assert leaning.energy(q, u) == pytest.approx(upright.energy(state.q, state.u), rel=1e-12, abs=1e-12)


@pytest.mark.parametrize(
    ("direction", "paths", "field"),
    [
        ("[0, -1]", [], (0, -1)),
        ("[0, -20]", [], (0, -1)),
        ("[0, 3]", [], (0, 1)),
        ("[-0.5, 0.0]", [], (-1, 0)),
        ("[3, 4]", ["gravity.direction.x", "gravity.direction.y"], (0.6, 0.8)),
    ],
)
def test_direction_along_an_axis_has_no_parameter(
    direction: str, paths: list[str], field: tuple[float, float], workshop: Workshop
) -> None:
    scene = workshop.scene(f'name = "plain"\n[chain]\nlinks = 1\n[gravity]\ng = 2\ndirection = {direction}\n')
    assert [p.path for p in scene.effects[0].parameters()] == ["gravity.g", *paths]
    model = workshop.model(scene)
    q, u = model.start()
    assert model.acceleration(q, u) == pytest.approx([2 * field[0], 2 * field[1], 0.0], abs=1e-15)
    down = workshop.scene('name = "plain"\n[chain]\nlinks = 1\n[gravity]\ng = 2\n')
    assert (scene.canonical() == down.canonical()) == (field == (0, -1))


# --- closed forms -----------------------------------------------------------------------------------------------------

ROD = "[chain]\nlinks = 1\nhinged = true\n"
BALL = """
[[link]]
name = "ball"
mass = 2.0
inertia = 0.1
com = [0, 0]
points = { C = [0, 0] }
[ground_link]
points = { O = [0, 0] }
[start]
"""
I_ROD = 1.0 / 3.0


def _end(model: Any, until: float, u0: list[float] | None = None) -> tuple[Array, Array]:
    run = simulate(model, u0=u0, until=until, rtol=1e-12)
    assert run.success, run.message
    kinetic, potential = model.energy(run.q, run.u)
    assert run.energy_drift <= 1e-9 * np.max(np.abs(kinetic) + np.abs(potential))
    return run.q[-1], run.u[-1]


@pytest.mark.parametrize("joint", ["torsion", "friction"])
def test_damped_torsion_decays(joint: str, workshop: Workshop) -> None:
    """I θ'' + c θ' + k (θ − θ₀) = 0 with the damping of either effect."""
    k, c, rest, theta = 5.0, 0.2, 0.3, 1.1
    text = f"{ROD}[start]\nangles = [{theta}]\n[[torsion]]\njoint = 'joint_0'\nstiffness = {k}\nangle = {rest}\n"
    text += f"damping = {c}\n" if joint == "torsion" else f"[[joint_friction]]\nviscous = {c}\n"
    q, u = _end(workshop.model(text), 3.0)
    s = (-c + np.sqrt(complex(c * c - 4 * I_ROD * k))) / (2 * I_ROD)
    a = (theta - rest) * s.conjugate() / (s.conjugate() - s)  # at rest at first
    wanted = 2 * (a * np.exp(3.0 * s)).real + rest, 2 * (a * s * np.exp(3.0 * s)).real
    assert (q[0], u[0]) == pytest.approx(wanted, abs=1e-10)


def test_spring_and_linear_drag_decay(workshop: Workshop) -> None:
    """m x'' + c x' + k x = 0 in both directions: a spring without length to the ground, drag on the mass."""
    m, k, c = 2.0, 9.0, 0.5
    text = BALL + 'position = [1.0, 0.4]\n[[spring]]\nbetween = ["ground.O", "ball.C"]\nstiffness = 9.0\n'
    q, u = _end(workshop.model(text + '[[drag]]\npoint = "ball.C"\nlinear = 0.5\n'), 2.0)
    s = (-c + np.sqrt(complex(c * c - 4 * m * k))) / (2 * m)
    a = s.conjugate() / (s.conjugate() - s)
    form = 2 * (a * np.exp(2.0 * s)).real, 2 * (a * s * np.exp(2.0 * s)).real
    assert q[:2] == pytest.approx(form[0] * np.array([1.0, 0.4]), abs=1e-11)
    assert u[:2] == pytest.approx(form[1] * np.array([1.0, 0.4]), abs=1e-11)


def test_spring_with_a_length_and_damper(workshop: Workshop) -> None:
    """Along their line m r'' + c r' + k (r − L₀) = 0."""
    m, k, c, rest = 2.0, 9.0, 0.5, 0.8
    text = BALL + 'position = [0.6, 0.8]\n[[spring]]\nbetween = ["ground.O", "ball.C"]\nstiffness = 9\nlength = 0.8\n'
    q, _ = _end(workshop.model(text + '[[damper]]\nbetween = ["ball.C", "ground.O"]\ndamping = 0.5\n'), 2.0)
    s = (-c + np.sqrt(complex(c * c - 4 * m * k))) / (2 * m)
    a = (1.0 - rest) * s.conjugate() / (s.conjugate() - s)
    assert q[:2] == pytest.approx((rest + 2 * (a * np.exp(2.0 * s)).real) * np.array([0.6, 0.8]), abs=1e-11)


def test_fall_with_quadratic_drag(workshop: Workshop) -> None:
    """m v' = m g − k v²: v = V tanh(g t/V), with V² = m g/k."""
    text = BALL + '[gravity]\n[[drag]]\npoint = "ball.C"\nquadratic = 0.3\nspeed = 0\n'
    model = workshop.model(text)
    assert "drag_0.speed" not in model.parameters
    q, u = _end(model, 2.0)
    final = np.sqrt(2.0 * 9.81 / 0.3)
    assert u[1] == pytest.approx(-final * np.tanh(9.81 * 2.0 / final), rel=1e-10)
    assert q[1] == pytest.approx(-(final**2) / 9.81 * np.log(np.cosh(9.81 * 2.0 / final)), rel=1e-10)


def test_smoothed_drag_is_linear_at_rest(workshop: Workshop) -> None:
    text = BALL + '[[drag]]\npoint = "ball.C"\nquadratic = 0.3\nspeed = 0.5\n'
    model = workshop.model(text)
    q, u = model.start()
    assert not model.acceleration(q, u).any()
    for speed in (1e-9, 1e-3, 2.0):
        force = 0.3 * np.hypot(speed, 0.5) * speed
        assert model.acceleration(q, [speed, 0.0, 0.0])[0] == pytest.approx(-force / 2.0, rel=1e-14)


def test_dry_friction_stops_a_rod(workshop: Workshop) -> None:
    """I ω' = −T tanh(ω/ω₀): sinh(ω/ω₀) falls by exp(−T t/(I ω₀))."""
    torque, about, omega = 0.25, 0.2, 2.0
    model = workshop.model(f"{ROD}[[joint_friction]]\njoints = ['joint_0']\ndry = {torque}\nrate = {about}\n")
    for until in (1.0, 2.5, 4.0):
        _, u = _end(model, until, [omega])
        wanted = about * np.arcsinh(np.sinh(omega / about) * np.exp(-torque * until / (I_ROD * about)))
        assert u[0] == pytest.approx(wanted, rel=1e-8, abs=1e-11)


def test_a_rod_under_everything_follows_its_equation(workshop: Workshop) -> None:
    """One angle: I θ'' = sum of the moments about the hinge, integrated by SciPy."""
    text = f"{ROD}[start]\nangles = [0.4]\n[gravity]\ndirection = [1, -1]\n"
    text += '[[torsion]]\njoint = "joint_0"\nstiffness = 2\nangle = 0.3\ndamping = 0.05\n'
    text += (
        '[[joint_friction]]\nviscous = 0.02\ndry = 0.1\n[[drag]]\npoint = "link_0.B"\nlinear = 0.04\nquadratic = 0.1\n'
    )
    model = workshop.model(text)

    def slope(t: float, y: Array) -> list[float]:
        theta, w = y
        moment = 9.81 * np.sqrt(0.5) * 0.5 * (-np.sin(theta) - np.cos(theta)) - 2 * (theta - 0.3) - 0.05 * w
        moment -= 0.02 * w + 0.1 * np.tanh(w / 0.01) + (0.04 + 0.1 * np.hypot(w, 1e-3)) * w
        return [w, moment / I_ROD]

    wanted = solve_ivp(slope, (0.0, 2.0), [0.4, 0.0], method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    q, u = _end(model, 2.0)
    assert (q[0], u[0]) == pytest.approx(tuple(wanted), abs=1e-9)


# --- bad input --------------------------------------------------------------------------------------------------------

TWO = "[chain]\nlinks = 2\nhinged = true\n"
SPRING, DAMPER = "[[spring]]\nstiffness = 1\n", "[[damper]]\ndamping = 1\n"
TORSION, FRICTION = '[[torsion]]\njoint = "joint_1"\n', "[[joint_friction]]\n"
DRAG = '[[drag]]\npoint = "link_1.B"\n'

BAD: list[tuple[str, str, tuple[str, ...]]] = [
    (SPRING, "spring[0].between", ("missing", "two points", "add it")),
    (
        SPRING + 'between = ["link_0.C", "ground.O"]',
        "spring[0].between[0]",
        ('"link_0.C"', "link_0 has the points A, B"),
    ),
    (SPRING + 'between = ["link_0.A", "joint_7"]', "spring[0].between[1]", ('"joint_7"', "joint_0, joint_1")),
    (
        SPRING + 'between = ["body.A", "ground.O"]',
        "spring[0].between[0]",
        ("the links are link_0, link_1, and ground",),
    ),
    (SPRING + 'between = ["link_0.A", "link_0.B"]', "spring[0].between", ("two points of one link", "change one")),
    (SPRING + 'between = ["joint_1", "link_1.B"]', "spring[0].between", ("two points of one link", '"joint_1"')),
    (SPRING + 'between = ["ground.O", "joint_0"]', "spring[0].between", ("two points of one link",)),
    (SPRING + 'between = ["link_0.A"]', "spring[0].between", ("two points",)),
    (SPRING + "stiff = 2", "spring[0].stiff", ("unknown key", 'remove it, "stiffness" is there already')),
    ('[[spring]]\nbetween = ["ground.O", "link_1.B"]\nstiffness = -1', "spring[0].stiffness", ("found -1", "positive")),
    ('[[spring]]\nbetween = ["ground.O", "link_1.B"]\nstiffness = 0', "spring[0].stiffness", ("found 0", "positive")),
    (
        SPRING + 'length = -1\nbetween = ["ground.O", "link_1.B"]',
        "spring[0].length",
        ("found -1", "zero or a positive"),
    ),
    (SPRING + 'name = "link_1"\nbetween = ["ground.O", "link_1.B"]', "spring[0].name", ("a second time",)),
    (SPRING + 'length = 1\nbetween = ["link_1.A", "link_0.B"]\n', "spring[0]", ("at the same place", "no direction")),
    ("[spring]\nstiffness = 1", "spring", ("array of tables", "[[spring]]")),
    (DAMPER + 'between = ["link_1.A", "link_1.B"]', "damper[0].between", ("two points of one link",)),
    (DAMPER + 'between = ["ground.P", "link_1.B"]', "damper[0].between[0]", ("ground has the points O",)),
    (DAMPER + 'between = ["link_0.B", "link_1.A"]', "damper[0]", ("at the same place", "no direction")),
    ('[[damper]]\nbetween = ["ground.O", "link_1.B"]\ndamping = -2', "damper[0].damping", ("found -2", "positive")),
    ('[[torsion]]\nstiffness = 1\njoint = "knee"', "torsion[0].joint", ('"knee"', "the joints are joint_0, joint_1")),
    (TORSION, "torsion[0]", ("neither stiffness nor damping", "add one")),
    (TORSION + "stiffness = -1", "torsion[0].stiffness", ("found -1", "positive")),
    (TORSION + "damping = -1", "torsion[0].damping", ("found -1", "zero or a positive")),
    (TORSION + "damping = 1\nangle = 1", "torsion[0].angle", ("without stiffness", "remove it")),
    (TORSION + 'stiffness = 1\nangle = "1 turn"', "torsion[0].angle", ('"1 turn"', "30 deg")),
    (FRICTION, "joint_friction[0]", ("neither viscous nor dry",)),
    (FRICTION + "viscous = -1", "joint_friction[0].viscous", ("found -1", "positive")),
    (FRICTION + "viscous = 1\nrate = 1", "joint_friction[0].rate", ("without dry friction",)),
    (FRICTION + "dry = 1\nrate = 0", "joint_friction[0].rate", ("found 0", "positive")),
    (FRICTION + 'dry = 1\njoints = ["joint_0", "knee"]', "joint_friction[0].joints[1]", ('"knee"', "the joints are")),
    (FRICTION + 'dry = 1\njoints = ["joint_0", "joint_0"]', "joint_friction[0].joints[1]", ("listed twice",)),
    (FRICTION + "dry = 1\njoints = []", "joint_friction[0].joints", ("a list of joints",)),
    (DRAG, "drag[0]", ("neither linear nor quadratic",)),
    (DRAG + "linear = -1", "drag[0].linear", ("found -1", "positive")),
    (DRAG + "linear = 1\nspeed = 1", "drag[0].speed", ("without quadratic drag",)),
    (DRAG + "quadratic = 1\nspeed = -1", "drag[0].speed", ("found -1", "zero or a positive")),
    ('[[drag]]\nlinear = 1\npoint = "link_1.C"', "drag[0].point", ("link_1 has the points A, B",)),
    ('[[drag]]\nlinear = 1\npoint = "ground.O"', "drag[0].point", ("fixed on the ground",)),
    ('[[drag]]\nlinear = 1\npoint = "joint_0"', "drag[0].point", ("fixed on the ground",)),
    ("[gravity]\ndirection = [0, 0]", "gravity.direction", ("found [0, 0]", "not both zero")),
    ("[gravity]\ndirection = [1]", "gravity.direction", ("[x, y]", "write 2 values")),
    ('[gravity]\ndirection = "down"', "gravity.direction", ('found "down"', "[x, y]")),
    ("[gravity]\ndirection = [inf, 1]", "gravity.direction[0]", ("found inf", "finite")),
]


@pytest.mark.parametrize(("table", "key", "words"), BAD, ids=lambda value: value if isinstance(value, str) else "")
def test_a_fault_says_what_is_wrong(table: str, key: str, words: tuple[str, ...], workshop: Workshop) -> None:
    with pytest.raises(SceneError) as caught:
        workshop.scene(TWO + table + "\n")
    (fault,) = [fault for fault in caught.value.faults if fault.key == key]
    assert fault.line and fault.line > 3
    for word in words:
        assert word in fault.message


def test_faults_come_together(workshop: Workshop) -> None:
    with pytest.raises(SceneError) as caught:
        workshop.scene(TWO + '[[torsion]]\njoint = "knee"\n[[spring]]\nstiffness = -1\nbetween = ["a.b", "c"]\n')
    found = {fault.key for fault in caught.value.faults}
    assert found == {
        "torsion[0].joint",
        "torsion[0]",
        "spring[0].stiffness",
        "spring[0].between[0]",
        "spring[0].between[1]",
    }


@pytest.mark.parametrize("form", ["[loop]\nlinks = 3\n", "[chain]\nlinks = 3\n"])
def test_a_ground_without_points_says_which_have_some(form: str, workshop: Workshop) -> None:
    with pytest.raises(SceneError, match=r"the ground has no points here.*\[ground_link\].*hinge the chain"):
        workshop.scene(form + '[[spring]]\nbetween = ["ground.O", "link_1.B"]\nstiffness = 1\n')
