"""Equilibria on grounds, stops and touches: against closed forms, and against where damped runs come to rest."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import simulate, static_equilibrium

from ..support.command_line import ccgen
from ..support.folders import SCENES
from ..support.workshop import Workshop

G = 9.81
LEANING = """\
name = "leaning"
[ground_link]
points = { O = [0, 0.5] }
[[link]]
name = "rod"
mass = 2.0
inertia = 0.1667
com = [0.5, 0.0]
points = { A = [0, 0], T = [1, 0] }
[[joint]]
name = "hinge"
between = ["ground.O", "rod.A"]
[start]
angles = { rod = 0.0 }
[gravity]
g = 9.81
"""
FLOOR = '[[ground]]\nrestitution = 0\ncontacts = ["rod.T"]\n'
STOP = '[[stop]]\njoint = "hinge"\nrestitution = 0\n'


def body(points: str, com: tuple[float, float], at: tuple[float, float, float], mass: float = 2.0) -> str:
    """A body that moves freely in the plane, at rest at the pose ``at``, under gravity."""
    return (
        f'[[link]]\nname = "body"\nmass = {mass!r}\ninertia = 0.03\ncom = [{com[0]!r}, {com[1]!r}]\n'
        f"points = {{ {points} }}\n[start]\nposition = [{at[0]!r}, {at[1]!r}]\nangles = {{ body = {at[2]!r} }}\n"
        f"[gravity]\ng = {G}\n"
    )


def ground(contacts: str, angle: float = 0.0, extra: str = "") -> str:
    """A plane that rises to the right by ``angle`` (rad)."""
    normal = [-float(np.sin(angle)), float(np.cos(angle))]
    return f"[[ground]]\nrestitution = 0\nnormal = {normal}\ncontacts = [{contacts}]\n{extra}\n"


def check_balance(model: Any, found: Any, points: dict[str, str]) -> None:
    """Every link is in balance under its weight, its joints and its contacts with grounds, forces and moments alike.

    ``points`` names the link of each contact's point.
    """
    planes = model.ground_planes()
    poses = model.poses(found.q)
    force, moment = np.zeros((len(model.links) + 1, 2)), np.zeros(len(model.links) + 1)

    def act(link: int, f: Any, at: Any) -> None:
        arm = np.asarray(at) - poses[link, :2]
        force[link] += f
        moment[link] += arm[0] * f[1] - arm[1] * f[0]

    for k, name in enumerate(model.links):
        turn = poses[k, 2]
        x, y = model.parameters.get(f"{name}.com.x", 0.0), model.parameters.get(f"{name}.com.y", 0.0)
        centre = poses[k, :2] + [x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn)]
        act(k, [0.0, -model.parameters[f"{name}.mass"] * G], centre)
    for k, name in enumerate(model.joints):
        for link, sign in zip(model.data["between"][k], (-1.0, 1.0), strict=True):
            if link >= 0:
                act(link, sign * found.reactions[k, :2], model.point(name, found.q))
                moment[link] += sign * found.reactions[k, 2]
    for (point, plane), (push, drag) in zip(model.contacts, found.contact_forces, strict=True):
        normal = planes[plane][1]
        where = model.point(point, found.q)
        act(model.links.index(points[point]), push * normal + drag * np.array([normal[1], -normal[0]]), where)
    assert np.max(np.abs(force[:-1])) <= 1e-9 and np.max(np.abs(moment[:-1])) <= 1e-9


# -- grounds, stops and touches ----------------------------------------------------------------------------------------


def test_a_rod_leans_on_the_floor(workshop: Workshop) -> None:
    """Half of its weight is on the tip, half on the hinge, half a metre above the floor."""
    model = workshop.model(LEANING + FLOOR)
    for nearest, start in ((False, [0.0]), (True, [-np.pi / 6.0])):
        found = static_equilibrium(model, start, nearest=nearest)
        assert found.q == pytest.approx([-np.pi / 6.0], abs=1e-12)
        assert found.stability == "stable" and found.stiffness.shape == (0,)
        assert found.closed == (("rod.T", "ground_0"),) and found.unique and not found.note
        assert found.contact_forces == pytest.approx(np.array([[G, 0.0]]), rel=1e-12)
        assert found.reactions[0] == pytest.approx([0.0, G, 0.0], abs=1e-11)
        assert found.residual <= 1e-12
    upright = static_equilibrium(model, [1.5], nearest=True)
    assert upright.stability == "unstable" and not upright.closed
    assert upright.q == pytest.approx([np.pi / 2.0], abs=1e-9)


def test_a_rod_rests_against_its_stop(workshop: Workshop) -> None:
    model = workshop.model(LEANING + STOP + 'lowest = "-20 deg"\n')
    found = static_equilibrium(model)
    assert found.q == pytest.approx([-np.radians(20.0)], abs=1e-12) and found.stability == "stable"
    assert found.closed == (("hinge", "stop_0.lowest"),)
    assert found.contact_forces == pytest.approx(np.array([[2.0 * G * 0.5 * np.cos(np.radians(20.0)), 0.0]]), rel=1e-12)
    assert found.reactions[0] == pytest.approx([0.0, 2.0 * G, 0.0], abs=1e-11)
    helped = static_equilibrium(model, torques={"hinge": 5.0})
    assert helped.contact_forces[0, 0] == pytest.approx(found.contact_forces[0, 0] - 5.0, rel=1e-12)
    lifted = static_equilibrium(model, torques={"hinge": 0.98 * G})
    assert lifted.q == pytest.approx([-np.arccos(0.98)], abs=1e-9) and not lifted.closed


def test_a_toggle_past_its_dead_centre_leans_on_its_stop(workshop: Workshop) -> None:
    """A slider at 2 cos θ is pushed inwards by 50 N; at θ = −10° the stop has the moment 100 sin 10° (virtual work)."""
    text = """\
name = "toggle"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "crank"
mass = 1.0
inertia = 0.1
com = [0.5, 0]
points = { A = [0, 0], B = [1, 0] }
[[link]]
name = "rod"
mass = 1.0
inertia = 0.1
com = [0.5, 0]
points = { A = [0, 0], B = [1, 0] }
[[link]]
name = "slider"
mass = 1.0
inertia = 0.1
com = [0, 0]
points = { A = [0, 0] }
[[joint]]
name = "axle"
between = ["ground.O", "crank.A"]
[[joint]]
name = "knee"
between = ["crank.B", "rod.A"]
[[joint]]
name = "guide"
type = "prismatic"
axis = [1, 0]
between = ["ground.O", "slider.A"]
[[joint]]
name = "pin"
between = ["rod.B", "slider.A"]
[start]
angles = { crank = -0.05, rod = 0.05 }
[[stop]]
joint = "axle"
lowest = "-10 deg"
restitution = 0
"""
    model = workshop.model(text)
    found = static_equilibrium(model, torques={"guide": -50.0})
    assert found.q[model.q_names.index("theta_0")] == pytest.approx(-np.radians(10.0), abs=1e-12)
    assert found.contact_forces[0, 0] == pytest.approx(100.0 * np.sin(np.radians(10.0)), rel=1e-10)
    assert found.stability == "stable"
    with pytest.raises(ValueError, match=r"no equilibrium found from here|no way"):
        static_equilibrium(workshop.model(text[: text.index("[[stop]]")]), torques={"guide": -50.0, "axle": 300.0})


def test_supports_share_a_beam_by_least_norm(workshop: Workshop) -> None:
    """Three feet at 0, 1 and 3 m, mass centre at 1.2 m: two balances for three forces; ranges end where one is zero."""
    points = "A = [0, 0], B = [1, 0], C = [3, 0]"
    model = workshop.model(body(points, (1.2, 0.0), (0.3, 0.4, 0.1)) + ground('"body.A", "body.B", "body.C"'))
    found = static_equilibrium(model)
    weight, feet = 2.0 * G, np.array([[1.0, 1.0, 1.0], [0.0, 1.0, 3.0]])
    assert found.contact_forces[:, 0] == pytest.approx(np.linalg.pinv(feet) @ [weight, 1.2 * weight], rel=1e-10)
    assert found.contact_forces[:, 0].sum() == pytest.approx(weight, rel=1e-12)
    ends = weight * np.array([[0.0, 1.8 / 3.0], [0.0, 0.9], [0.1, 0.4]])
    assert found.ranges[:, 0] == pytest.approx(ends, rel=1e-9, abs=1e-9)
    assert not found.unique and "not unique" in found.note
    assert found.stability == "indifferent"  # it slides along


def test_bodies_of_any_size_come_down(workshop: Workshop) -> None:
    for long in (1e-3, 1e3):
        at = (0.0, 0.4 * long, 0.1)
        model = workshop.model(
            body(f"A = [0, 0], B = [{long}, 0]", (0.4 * long, 0.0), at) + ground('"body.A", "body.B"')
        )
        found = static_equilibrium(model)
        assert found.contact_forces[:, 0] == pytest.approx([0.6 * 2.0 * G, 0.4 * 2.0 * G], rel=1e-9)
        assert found.q[1] == pytest.approx(0.0, abs=1e-12 * long) and found.q[2] == pytest.approx(0.0, abs=1e-12)


def test_a_hexagon_lies_flat_on_the_floor_with_its_weight(workshop: Workshop) -> None:
    model = workshop.model(load_scene(SCENES / "falling-hexagon.toml"))
    found = static_equilibrium(model)
    weight = G * sum(model.parameters[f"{link}.mass"] for link in model.links)
    assert len(found.closed) == 6
    assert found.contact_forces[:, 0].sum() == pytest.approx(weight, rel=1e-12)
    assert np.min(found.contact_forces[:, 0]) > 0.0 and np.max(np.abs(found.contact_forces[:, 1])) == 0.0
    assert np.max(np.abs(model.gaps(found.q))) <= 1e-12


def test_discs_rest_on_discs(workshop: Workshop) -> None:
    """A rod's round end of 0.2 m lies on a fixed disc of 0.3 m: the push is along the line of centres."""
    text = LEANING.replace("O = [0, 0.5]", "O = [0, 1.0], E = [0.6, 0.2]")
    model = workshop.model(text + '[[touch]]\nbetween = ["rod.T", "ground.E"]\nradius = [0.2, 0.3]\nrestitution = 0\n')
    found = static_equilibrium(model)
    tip = model.point("rod.T", found.q)
    normal = (tip - [0.6, 0.2]) / 0.5
    assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-12)
    arm = tip - [0.0, 1.0]
    push = 2.0 * G * 0.5 * np.cos(found.q[0]) / (arm[0] * normal[1] - arm[1] * normal[0])
    assert found.contact_forces[0] == pytest.approx([push, 0.0], rel=1e-10)
    assert found.reactions[0, :2] == pytest.approx([-push * normal[0], 2.0 * G - push * normal[1]], rel=1e-10)


# -- friction ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("lifted", [0.0, 0.3])
def test_a_block_rests_below_the_angle_of_friction(lifted: float, workshop: Workshop) -> None:
    """With μ below tan 20° it slides for ever; with more it stays, where it is or where it lands."""
    slope = math.radians(20.0)
    place = (-lifted * math.sin(slope), lifted * math.cos(slope), slope + lifted)
    text = body("A = [0, 0], B = [0.4, 0]", (0.2, 0.1), place)
    model = workshop.model(text + ground('"body.A", "body.B"', slope, "friction = 0.3"))
    for part in (1.5, 1.0001, 0.9999, 0.5):
        mu = part * math.tan(slope)
        rough = model.with_parameters({"ground_0.friction": mu})
        if part < 1.0:
            with pytest.raises(ValueError, match=r"no equilibrium found from here.* may push and cannot balance it"):
                static_equilibrium(rough)
            continue
        found = static_equilibrium(rough)
        pushes, drags = found.contact_forces.sum(axis=0)
        assert pushes == pytest.approx(2.0 * G * math.cos(slope), rel=1e-10)
        assert abs(drags) == pytest.approx(2.0 * G * math.sin(slope), rel=1e-10)
        assert np.all(np.abs(found.contact_forces[:, 1]) <= mu * found.contact_forces[:, 0] * (1.0 + 1e-12))
        assert found.stability == "stable" and "friction holds it here" in found.note and not found.unique
        if not lifted:
            assert found.q == pytest.approx(place, abs=1e-12)


def test_a_ladder_stands_from_a_known_angle_on(workshop: Workshop) -> None:
    """A smooth wall, a floor with μ: it stands where tan θ >= 1 / (2 μ), and pushes the wall by m g / (2 tan θ)."""
    mu, long = 0.4, 2.0
    walls = ground('"body.A"', 0.0, f"friction = {mu}") + ground('"body.B"', math.pi / 2.0)
    start = (-long * math.cos(1.3), 0.0, 1.3)
    model = workshop.model(body(f"A = [0, 0], B = [{long}, 0]", (long / 2.0, 0.0), start) + walls)
    for beyond in (1e-5, -1e-5, 0.3):
        angle = math.atan(1.0 / (2.0 * mu)) + beyond
        place = [-long * math.cos(angle), 0.0, angle]
        found = static_equilibrium(model, place)
        if beyond < 0.0:
            assert abs(found.q[2] - angle) > 0.1
            continue
        assert found.q == pytest.approx(place, abs=1e-12) and found.stability == "stable" and found.unique
        push = 2.0 * G / (2.0 * math.tan(angle))
        assert found.contact_forces == pytest.approx(np.array([[2.0 * G, push], [push, 0.0]]), rel=1e-9, abs=1e-9)


def test_a_disc_in_a_rough_valley_has_a_range_of_forces(workshop: Workshop) -> None:
    """Between slopes of 30°, P (cos + k sin) = m g / 2 with any friction F = k P up the slopes, |k| <= μ."""
    mu, slope, radius = 0.2, math.radians(30.0), 0.2
    extra = f"radius = {radius}\nfriction = {mu}"
    walls = ground('"body.C"', -slope, extra) + ground('"body.C"', slope, extra)
    start = (0.0, radius / math.cos(slope), 0.3)
    model = workshop.model(body("C = [0, 0]", (0.0, 0.0), start) + walls)
    found = static_equilibrium(model)
    assert found.q == pytest.approx(start, abs=1e-12) and len(found.closed) == 2
    ends = [2.0 * G / (2.0 * (math.cos(slope) + k * math.sin(slope))) for k in (mu, -mu)]
    assert found.ranges[:, 0] == pytest.approx(np.array([ends, ends]), rel=1e-9)
    assert found.contact_forces[:, 0] == pytest.approx([ends[0]] * 2, rel=1e-9)
    model = model.with_parameters({"ground_0.friction": 0.0, "ground_1.friction": 0.0})
    smooth = static_equilibrium(model, [0.05, 0.5, 0.3])
    assert smooth.unique and smooth.q[:2] == pytest.approx(start[:2], abs=1e-12)
    assert smooth.contact_forces[:, 0] == pytest.approx([2.0 * G / (2.0 * math.cos(slope))] * 2, rel=1e-10)


def test_forces_between_facing_rough_walls_have_no_bound(workshop: Workshop) -> None:
    walls = ground('"body.A"', -np.pi / 2.0, "friction = 0.8") + ground(
        '"body.B"', np.pi / 2.0, "point = [0.5, 0]\nfriction = 0.8"
    )
    found = static_equilibrium(workshop.model(body("A = [0, 0], B = [0.5, 0]", (0.25, 0.0), (0.0, 1.0, 0.0)) + walls))
    assert found.q == pytest.approx([0.0, 1.0, 0.0], abs=1e-12)
    assert found.contact_forces == pytest.approx(np.array([[G / 0.8, -G], [G / 0.8, G]]), rel=1e-9)
    assert found.ranges[:, 0] == pytest.approx(np.array([[G / 0.8, np.inf]] * 2), rel=1e-9)


# -- stability ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("above", [-0.05, 0.05])
def test_a_rocking_disc_is_stable_with_its_mass_centre_below_its_middle(above: float, workshop: Workshop) -> None:
    """Rolling by s lifts the mass centre by above (cos(s / r) − 1): a stiffness −m g above per rad², over motions of
    length 1 in (x, θ)."""
    radius = 0.2
    text = body("C = [0, 0]", (0.0, above), (0.0, radius, 0.0))
    model = workshop.model(text + ground('"body.C"', 0.0, f"radius = {radius}\nfriction = 0.4"))
    found = static_equilibrium(model, nearest=True)
    assert found.stiffness == pytest.approx([-2.0 * G * above / (1.0 + radius**2)], rel=1e-7)
    assert found.stability == ("stable" if above < 0.0 else "unstable")
    rolled = static_equilibrium(model, [0.0, radius, 0.5])
    assert rolled.stability == "stable"
    assert np.cos(rolled.q[2]) == pytest.approx(-np.sign(above), abs=1e-12)
    sliding = static_equilibrium(workshop.model(text + ground('"body.C"', 0.0, f"radius = {radius}")), nearest=True)
    assert np.sort(sliding.stiffness) == pytest.approx(np.sort([0.0, -2.0 * G * above]), abs=1e-6)


def test_contacts_without_force_leave_motions_on_one_side(workshop: Workshop) -> None:
    """An upright rod just at its stop falls to the other side; held between that and a wall it cannot."""
    stopped = LEANING.replace("rod = 0.0", 'rod = "90 deg"') + STOP + 'highest = "90 deg"\n'
    top = [np.pi / 2.0]
    one = static_equilibrium(workshop.model(stopped), top, nearest=True)
    assert one.stability == "unstable" and one.closed == (("hinge", "stop_0.highest"),)
    assert one.contact_forces[0, 0] == pytest.approx(0.0, abs=1e-9)
    wall = "[[ground]]\nrestitution = 0\nnormal = [-1, 0]\npoint = [1e-13, 0]\ncontacts = ['rod.T']\n"
    both = static_equilibrium(workshop.model(stopped + wall), top)
    assert both.q == pytest.approx(top, abs=1e-9) and len(both.closed) == 2 and both.stability == "stable"


# -- runs come to rest there -------------------------------------------------------------------------------------------


def arm(count: int, height: float, effects: str) -> str:
    """A hinged chain of uniform rods with dampers in its joints."""
    text = f'name = "arm"\n[ground_link]\npoints = {{ O = [0, {height}], E = [0.5, {height - 0.5}], F = [2.0, 0.4] }}\n'
    for k, long in enumerate((1.0, 0.8, 0.6)[:count]):
        before = f"rod_{k - 1}.B" if k else "ground.O"
        text += (
            f'[[link]]\nname = "rod_{k}"\nmass = 1.5\ninertia = {1.5 * long**2 / 12.0!r}\ncom = [{long / 2.0!r}, 0]\n'
            f"points = {{ A = [0, 0], B = [{long}, 0] }}\n"
            f'[[joint]]\nname = "pin_{k}"\nbetween = ["{before}", "rod_{k}.A"]\n'
            f'[[torsion]]\njoint = "pin_{k}"\ndamping = 1.5\n'
        )
    angles = ", ".join(f"rod_{k} = {angle}" for k, angle in enumerate((0.3, 0.6, 0.2)[:count]))
    return f"{text}[start]\nangles = {{ {angles} }}\n[gravity]\ng = {G}\n{effects}"


LEVEL = '[[ground]]\nrestitution = 0\ncontacts = ["rod_0.B", "rod_1.B"{more}]\n{extra}'
TOUCHES = "".join(
    f'[[touch]]\nbetween = ["rod_{k}.B", ["ground.E", "ground.F"]]\nradius = [0.1, 0.05]\nrestitution = 0\n'
    for k in (0, 1)
)
STOPS = "".join(
    f'[[stop]]\njoint = "pin_{k}"\nlowest = "{low} deg"\nhighest = "50 deg"\nrestitution = 0\n'
    for k, low in enumerate((-30, -40, -35))
)


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    ("count", "height", "effects"),
    [
        (2, 0.5, LEVEL.format(more="", extra="")),
        (3, 0.9, LEVEL.format(more=', "rod_2.B"', extra="")),
        (3, 0.9, LEVEL.format(more=', "rod_2.B"', extra="normal = [-0.3, 1]\nradius = 0.1\n")),
        (2, 1.5, TOUCHES),
        (3, 0.9, STOPS),
    ],
)
def test_damped_runs_come_to_rest_in_equilibria(count: int, height: float, effects: str, workshop: Workshop) -> None:
    """Where a run ends is an equilibrium; and a run that begins at rest in the one that is found stays there."""
    model = workshop.model(arm(count, height, effects))
    run = simulate(model, until=60.0, rtol=1e-8)
    ended = static_equilibrium(model, model.assemble(run.q[-1]))
    assert np.max(np.abs(ended.q - run.q[-1])) <= 1e-6
    found = static_equilibrium(model)
    assert found.stability == "stable" and found.closed
    assert np.min(model.gaps(found.q)) >= -1e-11
    assert found.unique
    rest = 0.0 * found.q  # the forces of a motion that begins there are those of no acceleration
    assert model.contact_forces(found.q, rest) == pytest.approx(found.contact_forces, abs=1e-8)
    assert model.reactions(found.q, rest) == pytest.approx(found.reactions, abs=1e-8)
    stays = simulate(model, found.q, 0.0 * found.q, until=3.0)
    assert np.max(np.abs(stays.q - found.q)) <= 1e-7
    if "touch" not in effects and "stop" not in effects and "radius" not in effects:
        check_balance(model, found, {f"rod_{k}.B": f"rod_{k}" for k in range(count)})


# -- refusals and the command line -------------------------------------------------------------------------------------


def test_configurations_behind_a_surface_are_refused(workshop: Workshop) -> None:
    model = workshop.model(LEANING + FLOOR)
    with pytest.raises(
        ValueError, match=r"q: found rod\.T inside ground_0 by 0\.5 m, expected .* outside all surfaces"
    ):
        static_equilibrium(model, [-np.pi / 2.0])
    stopped = workshop.model(LEANING + STOP + 'lowest = "-20 deg"\n')
    with pytest.raises(ValueError, match=r"q: found hinge beyond stop_0\.lowest by 0\.150934 rad"):
        static_equilibrium(stopped, [-0.5])
    falling = workshop.model(body("A = [0, 0], B = [0.4, 0]", (0.2, 0.1), (0.0, 1.0, 0.0)) + ground('"body.A"', 0.4))
    with pytest.raises(ValueError, match="no equilibrium found from here"):
        static_equilibrium(falling)


def test_the_command_prints_contact_forces(tmp_path: Path) -> None:
    (tmp_path / "leaning.toml").write_text(LEANING + FLOOR.replace("restitution", "friction = 0.5\nrestitution"))
    done = ccgen("equilibrium", "leaning.toml", at=tmp_path)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    row = next(k for k, line in enumerate(lines) if line.startswith("rod.T on ground_0"))
    assert "leaning: stable equilibrium; stiffnesses: none, it cannot move" in lines
    assert lines[row - 1].split() == ["contact", "normal", "friction"] and lines[row].endswith(" N")
    assert lines[row + 1].split()[0] == "from" and lines[row + 2].split()[0] == "to"
    assert lines[-1].startswith("note: contact forces are not unique")
    (tmp_path / "stopped.toml").write_text(LEANING + STOP + 'lowest = "-20 deg"\n')
    done = ccgen("torque", "stopped.toml", "hinge", "--rate", "-1", at=tmp_path)
    assert done.returncode == 2
    assert (
        "hinge cannot be turned right round: it comes to a stop after 20°, where hinge reaches stop_0.lowest"
        in done.stderr
    )
