"""Joints that let go and take hold beside gears, racks, belts, ropes, polygons and laws that hold values.

What a change does not touch goes on as if nothing were; what it does is held against closed forms and momenta.
"""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.generator import SceneError
from ccgen.runtime import simulate
from ccgen.runtime.record.force_history import columns, history, write_csv

from ..support.workshop import Workshop

BOX = "points = { C = [0, 0], a = [-0.2, -0.1], b = [0.2, -0.1], c = [0.2, 0.1], d = [-0.2, 0.1] }"
WORKS = f"""
name = "works"
[ground_link]
points = {{ A = [0, 0], B = [0.5, 0], D = [1.1, 0], R = [0, -0.2], H = [-0.5, 0.6], S = [1.6, 0.3] }}
[[link]]
name = "first"
disc = {{ radius = 0.2, mass = 2, centre = "C" }}
points = {{ C = [0, 0], P = [0.15, 0] }}
[[link]]
name = "second"
disc = {{ radius = 0.3, mass = 3 }}
points = {{ C = [0, 0] }}
[[link]]
name = "third"
disc = {{ radius = 0.3, mass = 1 }}
points = {{ C = [0, 0] }}
[[link]]
name = "bar"
mass = 1
inertia = 0.1
com = [0, 0]
points = {{ C = [0, 0] }}
[[link]]
name = "weight"
mass = 0.5
inertia = 0.01
com = [0, 0]
{BOX}
free = true
[[link]]
name = "block"
mass = 0.5
inertia = 0.01
com = [0, 0]
{BOX}
free = true
[[link]]
name = "ball"
disc = {{ radius = 0.1, mass = 0.4 }}
points = {{ C = [0, 0] }}
free = true
[[link]]
name = "hook"
mass = 0.3
inertia = 0.02
com = [0, -0.2]
points = {{ T = [0, 0], E = [0, -0.4] }}
[[link]]
name = "load"
mass = 0.2
inertia = 0.01
com = [0, 0]
points = {{ C = [0, 0] }}
[[joint]]
name = "top"
between = ["ground.S", "hook.T"]
[[joint]]
name = "grip"
between = ["hook.E", "load.C"]
[[joint]]
name = "one"
between = ["ground.A", "first.C"]
[[joint]]
name = "two"
between = ["ground.B", "second.C"]
[[joint]]
name = "three"
between = ["ground.D", "third.C"]
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.R", "bar.C"]
axis = [1, 0]
[[gear]]
joints = ["one", "two"]
teeth = [20, 30]
[[belt]]
joints = ["two", "three"]
radii = [0.1, 0.05]
[[rack]]
pinion = "one"
slide = "guide"
radius = 0.2
[[rope]]
between = ["ground.H", "weight.C"]
restitution = 0.2
[[rope]]
between = ["first.P", "hook.E"]
restitution = 0
length = 3
[[touch]]
between = [
    ["weight.a", "weight.b", "weight.c", "weight.d", "weight.a"],
    ["block.a", "block.b", "block.c", "block.d", "block.a"],
]
radius = 0.01
restitution = 0.3
friction = 0.2
[[ground]]
point = [0, -1.5]
contacts = ["block.a", "block.b"]
restitution = 0.2
friction = 0.4
[[compliant_ground]]
point = [0, -1.5]
contacts = ["ball.C"]
radius = 0.1
load = "10 N"
depth = "1 mm"
restitution = 0.5
friction = 0.3
[[journal]]
between = ["load.C", "ground.S"]
radius = 0.05
clearance = 0.45
restitution = 0.3
[[brake]]
joint = "three"
torque = 0.05
begins = 0.2
[[torsion]]
joint = "one"
stiffness = 5
play = 0.2
[[motor]]
joint = "one"
torque = 0.3
[[joint_friction]]
joints = ["top", "grip"]
viscous = 0.01
[start]
angles = {{ first = 0.7, second = 0.3, third = 2.0, hook = 1.0, load = 0 }}
poses = {{ weight = [-0.9, 0.2, 0.1], block = [-0.85, 0.55, 0], ball = [-1, -1.2, 0] }}
slides = {{ guide = 0.13 }}
angular_velocities = {{ hook = 1 }}
[gravity]
[[release]]
joint = "grip"
at = 0.207
[[hold]]
joint = "grip"
within = 2
at = 0.7
[run]
until = 1
rtol = 1e-10
"""
"""Two wheels, a belt, a rack; a weight that swings on a rope under a block; a ball on soft ground, which it touches
from 0.202 s to 0.215 s; and apart from them a hook and its load."""
APART = ("first.P", "second.C", "bar.C", "weight.a", "block.a", "ball.C")


@pytest.fixture(scope="module")
def works(workshop: Workshop) -> Any:
    return workshop.model(WORKS)


@pytest.fixture(scope="module")
def run(works: Any) -> Any:
    return simulate(works)


@pytest.mark.hard
def test_what_effects_take_from_the_start_is_that_of_the_scene(works: Any) -> None:
    assert works.parameters["rope_0.length"] == pytest.approx(0.4 * 2**0.5)
    assert [works.parameters[f"rack_0.start_{k}"] for k in (1, 2)] == pytest.approx([0.7, 0.13])


@pytest.mark.hard
def test_what_a_change_does_not_touch_goes_on_as_if_nothing_were(workshop: Workshop, run: Any) -> None:
    """Against a run in which the joint is open all the time."""
    assert [change.kind for change in run.changes] == ["release", "hold"] and run.success
    alone = simulate(workshop.model(WORKS.replace("at = 0.207", "at = 0").replace("at = 0.7", "at = 7")))
    pressed = run.point("ball.C", [0.207]).position[0, 1]
    assert pressed < -1.4  # the ball is in the ground when the joint lets go
    met = [contact for one in (*run.impacts, *run.phases) for contact in one.contacts]
    assert {ground for _, ground in met} >= {"rope_0", "ground_0", "touch_0"}
    for t in (0.5, 0.69, 0.95):
        for point in APART:
            found, wanted = (one.point(point, [t]) for one in (run, alone))
            assert found.position == pytest.approx(wanted.position, abs=1e-8)
            assert found.velocity == pytest.approx(wanted.velocity, abs=1e-6)
    own, others = (one.model.contacts for one in (run, alone))
    pushes, wanted = run.contact_forces([0.95]), alone.contact_forces([0.95])
    for number, contact in enumerate(others):
        if contact[1] != "rope_1" and contact[1] != "journal_0":
            assert pushes[0, own.index(contact)] == pytest.approx(wanted[0, number], abs=1e-5)


@pytest.mark.hard
def test_what_is_told_of_such_runs_has_all_parts(run: Any, tmp_path: Path) -> None:
    """Along the rows wheels roll on each other; tables have the force between them, pictures are drawn."""
    t = np.linspace(0.05, 0.95, 7)
    angles = np.array([run.joint_angles(t)[name] for name in ("one", "two", "three")])
    assert 0.2 * (angles[0] - 0.7) == pytest.approx(-0.3 * (angles[1] - 0.3), abs=1e-12)
    assert 0.1 * (angles[1] - 0.3) == pytest.approx(0.05 * (angles[2] - 2.0), abs=1e-12)
    forces = history(run, 50)
    names = columns(run)
    assert names[-3:] == ["gear_0.force [N]", "rack_0.force [N]", "belt_0.force [N]"]
    bar = run.point("bar.C", forces.t[:1]).acceleration[0, 0]
    assert abs(forces.meshes[0, 1]) == pytest.approx(abs(1.0 * bar), rel=1e-9) and bar != 0.0
    lines = write_csv(run, tmp_path / "forces.csv").read_text().splitlines()
    assert lines[0].count(",") == len(names) - 1 and len(lines) > len(forces.t)
    run.plot(tmp_path / "plot.png")
    run.animate(tmp_path / "player.html")
    run.save(tmp_path / "run.npz")
    again = pickle.loads(pickle.dumps(run))
    assert np.array_equal(again.reactions(t), run.reactions(t)) and np.array_equal(again.q, run.q)


@pytest.mark.hard
def test_a_run_goes_on_within_a_compliant_contact_and_through_a_change(works: Any, run: Any) -> None:
    first = simulate(works, until=0.205)
    rest = simulate(works, state=first.state)
    assert rest.point("ball.C", [0.9]).position == pytest.approx(run.point("ball.C", [0.9]).position, abs=1e-8)
    at_change = simulate(works, until=0.207)
    rest = simulate(works, state=at_change.state)
    assert rest.point("ball.C", [0.9]).position == pytest.approx(run.point("ball.C", [0.9]).position, abs=1e-8)


TRAIN = """
name = "train"
[ground_link]
points = { O = [0, 0], L = [0, 0.5] }
[[link]]
name = "sun"
mass = 1
inertia = 0.02
com = [0, 0]
points = { C = [0, 0] }
[[link]]
name = "arm"
mass = 0.7
inertia = 0.05
com = [0.1, 0]
points = { O = [0, 0], P = [0.3, 0], M = [-0.3, 0], L = [0.5, 0] }
PLANETS
[[joint]]
name = "sun_axle"
between = ["ground.O", "sun.C"]
[[joint]]
name = "arm_axle"
between = ["ground.O", "arm.O"]
[[joint]]
name = "lock"
between = ["ground.L", "arm.L"]
[[motor]]
joint = "sun_axle"
torque = 0.3
[[hold]]
joint = "lock"
[[release]]
joint = "lock"
at = 1.5
[start]
open = ["lock"]
angles = { sun = 0.4, arm = 0.2 }
angular_velocities = { sun = 1, arm = 2 }
[run]
until = 2
rtol = 1e-11
"""
PLANET = """
[[link]]
name = "planet_{0}"
mass = 0.5
inertia = 0.004
com = [0, 0]
points = {{ C = [0, 0] }}
[[joint]]
name = "pin_{0}"
between = ["arm.{0}", "planet_{0}.C"]
[[gear]]
joints = ["sun_axle", "pin_{0}"]
teeth = [20, 10]
"""


@pytest.mark.parametrize("planets", ["P", "PM"])
def test_an_arm_of_a_planetary_train_is_held_and_let_go(workshop: Workshop, planets: str) -> None:
    """By the angular velocities of sun and arm: a planet of half the sun's radius turns with w_a − 2 (w_s − w_a)."""
    run = simulate(workshop.model(TRAIN.replace("PLANETS", "".join(map(PLANET.format, planets)))))
    count = len(planets)
    turns = np.array([[1.0, 0.0], [0.0, 1.0], [-2.0, 3.0]])
    inertias = np.array([0.02, 0.05 + 0.7 * 0.01 + count * 0.5 * 0.09, count * 0.004])
    M = turns.T @ np.diag(inertias) @ turns
    spin, rate = np.array([1.0, 2.0]), np.linalg.solve(M, [0.3, 0.0])
    held, let_go = run.changes
    assert 0.2 + spin[1] * held.t + rate[1] * held.t**2 / 2 == pytest.approx(np.pi / 2, rel=1e-11)
    (impact,) = run.impacts
    before = spin + rate * held.t
    after = (M[0] @ before) / M[0, 0]  # the sun's own momentum stays, for its axle and the lock give it none
    found = run.model.velocities(*run.at(held.t))[:2, 2]
    assert found == pytest.approx([after, 0.0], abs=1e-11)
    lost = before @ M @ before / 2 - M[0, 0] * after**2 / 2
    assert impact.energy_loss == pytest.approx(lost, rel=1e-11)
    assert impact.reactions[run.model.joints.index("sun_axle")] == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    lock = run.model.joints.index("lock")
    moment = inertias @ turns @ ([after, 0.0] - before)
    assert -0.5 * impact.reactions[lock, 0] == pytest.approx(moment, rel=1e-10)
    still = after + 0.3 / M[0, 0] * (let_go.t - held.t)
    last = run.model.velocities(*run.at(2.0))[:2, 2]
    assert last == pytest.approx(np.array([still, 0.0]) + rate * (2.0 - let_go.t), rel=1e-10)
    angles = run.model.poses(run.q)[:, :3, 2]
    turned = angles - angles[0]
    assert turned[:, 2] == pytest.approx(3.0 * turned[:, 1] - 2.0 * turned[:, 0], abs=1e-11)  # and teeth never jump
    meshes = [row.endswith(".mesh") for row in run.model.rows]
    forces = np.array([run.motion(np.array([t]), *run.at(np.array([t]))).multipliers[0, meshes] for t in (0.1, 1.0)])
    shares = [(0.3 - 0.02 * a) / 0.2 / count for a in (rate[0], 0.3 / M[0, 0])]
    assert -forces == pytest.approx(np.tile(np.array(shares)[:, None], count), rel=1e-9)
    assert run.energy_drift < 1e-10 and run.closure_max < 1e-12


def test_a_gear_at_a_joint_that_changes_is_refused(workshop: Workshop) -> None:
    text = TRAIN.replace("PLANETS", PLANET.format("P")).replace('"lock"\nat', '"pin_P"\nat')
    with pytest.raises(SceneError, match=r'gear\[0\].joints\[1\]: found "pin_P", which lets go or takes hold'):
        workshop.scene(text)
