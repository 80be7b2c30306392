"""Dyads: where they are closed, what that saves, what stands beside them; their dead centres keep their digits."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from ccgen.generator import generate, load_scene
from ccgen.generator.derive.derivation import derive
from ccgen.generator.mechanism.topology import span
from ccgen.generator.pipeline import listing, plan_scene
from ccgen.generator.planning.choose import DYADS, TIP_TO_ROOT, choose
from ccgen.generator.planning.plan import is_dyad
from ccgen.generator.program.program import lower
from ccgen.generator.program.reading import read_listing
from ccgen.generator.scene.scene import Scene
from ccgen.runtime import load_model

from ..oracles import graphs, maximal
from ..oracles.maximal import Array
from ..oracles.mechanisms import Drawing
from ..support.large_mechanisms import operations, scene_of, walking
from ..support.planned_mechanisms import MECHANISMS
from ..support.tiers import hard
from ..support.workshop import Workshop

SLIDER_CRANK = """
name = "guide-first"
[ground_link]
points = { S = [0, 0], O = [0, 0] }
[[link]]
name = "piston"
mass = 0.5
inertia = 0.01
com = [0, 0]
points = { P = [0, 0] }
[[link]]
name = "crank"
mass = 1.0
inertia = 0.02
com = [0.15, 0]
points = { O = [0, 0], A = [0.3, 0] }
[[link]]
name = "rod"
mass = 1.0
inertia = 0.1
com = [0.4, 0]
points = { P = [0, 0], A = [0.8, 0] }
[[joint]]
name = "guide"
type = "prismatic"
axis = [1, 0]
between = ["ground.S", "piston.P"]
[[joint]]
name = "axle"
between = ["ground.O", "crank.O"]
[[joint]]
name = "wrist"
between = ["piston.P", "rod.P"]
[[joint]]
name = "pin"
between = ["crank.A", "rod.A"]
[start]
angles = { crank = 0.8, rod = 2.9 }
[gravity]
"""
"""The guide comes first, so that rod and crank are cut apart, and the rod hangs from what slides."""


HARD = """
name = "hard"
[ground_link]
points = { A = [0, 0], D = [2.0, 0], R = [0, 3] }
[[link]]
name = "crank"
mass = 1.0
inertia = 0.05
com = [0.25, 0]
points = { A = [0, 0], B = [0.5, 0], T = [0.5, 0.1] }
[[link]]
name = "coupler"
mass = 1.2
inertia = 0.4
com = [0.9, 0.1]
points = { A = [0, 0], B = [1.8, 0], S = [0.9, 0.3] }
[[link]]
name = "rocker"
mass = 2.0
inertia = 0.3
com = [0.6, 0]
points = { A = [0, 0], B = [1.3, 0] }
[[link]]
name = "slide"
mass = 0.7
inertia = 0.02
com = [0, 0.1]
points = { P = [0, 0], Q = [0.3, 0] }
[[link]]
name = "stick"
mass = MASS
inertia = INERTIA
com = [0.2, 0]
points = { A = [0, 0], B = [0.4, 0] }
[[link]]
name = "bob"
mass = 0.8
inertia = 0.01
com = [0.1, 0.05]
points = { A = [0, 0] }
[[joint]]
name = "hook"
between = ["slide.Q", "stick.A"]
[[joint]]
name = "string"
between = ["stick.B", "bob.A"]
[[joint]]
name = "axle"
between = ["ground.A", "crank.A"]
[[joint]]
name = "knee"
between = ["crank.B", "coupler.A"]
[[joint]]
name = "wrist"
between = ["coupler.B", "rocker.B"]
[[joint]]
name = "foot"
between = ["rocker.A", "ground.D"]
[[joint]]
name = "guide"
type = "prismatic"
axis = [1, 0]
between = ["ground.R", "slide.P"]
[start]
angles = { crank = 1.0, coupler = 0.5, rocker = 1.8, stick = -1.2, bob = -0.4 }
[gravity]
[[spring]]
name = "pull"
between = ["slide.Q", "rocker.B"]
stiffness = 30.0
length = 0.5
[[torsion]]
joint = "knee"
stiffness = 3.0
damping = 0.2
"""


def test_what_slides_carries_no_dyad(workshop: Workshop) -> None:
    model = workshop.model(SLIDER_CRANK)
    q, u = model.start()
    assert np.all(np.isfinite(model.acceleration(q, u)))
    assert [name for name, _ in plan_scene(workshop.scene(SLIDER_CRANK))[1].costs] == [TIP_TO_ROOT]


def with_all_dyads(scene: Scene) -> int:
    """Operations where every dyad is closed, wherever it stands at the start."""
    topology = span(scene.mechanism)
    plan = choose(scene.mechanism, topology, (), [cut.joint for cut in topology.cuts], DYADS).plan
    return lower(derive(scene.mechanism, topology, plan, scene.effects)).function("acceleration").counts().total


@pytest.mark.hard
def test_what_walks_costs_the_same_for_every_leg(tmp_path: Any) -> None:
    """Operations grow by the same number from leg to leg, where the order from tip to root grows faster and faster."""
    scenes = [scene_of(graphs.mechanism(f"legs{n}", walking(n), seed=3), tmp_path) for n in (1, 2, 3, 4)]
    found = [with_all_dyads(scene) for scene in scenes]
    steps = np.diff(found)
    assert np.ptp(steps) == 0, found
    assert operations(scenes[2], TIP_TO_ROOT) > 2 * found[2]


@pytest.mark.parametrize("name", MECHANISMS)
def test_dyads_are_closed_where_they_save_half(name: str, tmp_path: Any) -> None:
    scene = scene_of(graphs.mechanism("mechanism", MECHANISMS[name], seed=5), tmp_path)
    choice = plan_scene(scene)[1]
    costs = dict(choice.costs)
    assert choice.plan.name == (DYADS if 2.0 * costs.get(DYADS, math.inf) < costs[TIP_TO_ROOT] else TIP_TO_ROOT)


def test_a_dyad_that_starts_at_its_dead_centre_stays_open(tmp_path: Any) -> None:
    """Coupler and rocker in line at the start: nothing is divided by the sine of the angle between them."""
    scene = load_scene(_four_bar(tmp_path, 0.0))
    assert [name for name, _ in plan_scene(scene)[1].costs] == [TIP_TO_ROOT]
    bent = plan_scene(load_scene(_four_bar(tmp_path, 0.5)), DYADS)[1].plan
    assert bent.name == DYADS
    assert [len(pivot) for link in bent.pivots for pivot in bent.at(link) if is_dyad(pivot)] == [4]


def _four_bar(tmp_path: Any, bend: float) -> Any:
    """Ground, crank, coupler and rocker; coupler and rocker ``bend`` (rad) away from being stretched."""
    rocker, coupler = 0.3, 0.3 + bend
    knee = math.cos(rocker), math.sin(rocker)
    crank_end = knee[0] + 1.2 * math.cos(coupler), knee[1] + 1.2 * math.sin(coupler)
    path = tmp_path / "bar.toml"
    path.write_text(
        f"""
name = "bar"
[start]
angles = [1.5, {coupler + math.pi!r}, {rocker!r}]
[ground_link]
points = {{ A = [{crank_end[0] - 0.6 * math.cos(1.5)!r}, {crank_end[1] - 0.6 * math.sin(1.5)!r}], D = [0.0, 0.0] }}
[[link]]
name = "crank"
mass = 1.0
inertia = 0.1
com = [0.3, 0.0]
points = {{ A = [0.0, 0.0], B = [0.6, 0.0] }}
[[link]]
name = "coupler"
mass = 1.0
inertia = 0.1
com = [0.6, 0.0]
points = {{ A = [0.0, 0.0], B = [1.2, 0.0] }}
[[link]]
name = "rocker"
mass = 1.0
inertia = 0.1
com = [0.5, 0.0]
points = {{ A = [0.0, 0.0], B = [1.0, 0.0] }}
[[joint]]
name = "j0"
between = ["ground.A", "crank.A"]
[[joint]]
name = "j1"
between = ["crank.B", "coupler.A"]
[[joint]]
name = "j2"
between = ["coupler.B", "rocker.B"]
[[joint]]
name = "j3"
between = ["rocker.A", "ground.D"]
"""
    )
    return path


@pytest.mark.parametrize("legs", [0, hard(1), hard(4)])
def test_dead_centres_keep_their_digits(legs: int, tmp_path: Any) -> None:
    """A dyad's arms at angles from 0.1 to 0: four-bar and one leg have a plan for it, four legs the robust path."""
    edges = walking(legs) if legs else MECHANISMS["four-bar"]
    drawing = graphs.mechanism(f"dead{legs}", edges, seed=5)
    model = load_model(generate(scene_of(drawing, tmp_path), out=tmp_path, plan=DYADS))
    q0, _ = model.state_from_poses(drawing.poses, np.zeros_like(drawing.poses))
    rng = np.random.default_rng(4)
    worst = {}
    for angle in (1e-1, 1e-2, 1e-3, 1e-5, 1e-7, 1e-10, 0.0):
        q = _folded(model, drawing, q0, angle)
        u = rng.normal(size=len(q))
        poses = model.poses(q)
        motion = maximal.accelerate(drawing.system, poses, model.velocities(q, u))
        at = {"vx": 0, "vy": 1, "w": 2}
        split = (name.rsplit("_", 1) for name in model.u_names)
        wanted = np.array([motion.frames[int(link), at[kind]] for kind, link in split], dtype=float)
        worst[angle] = float(np.abs(model.acceleration(q, u) - wanted).max() / np.abs(wanted).max())
    assert max(worst.values()) <= 1e-14, worst


def _folded(model: Any, drawing: Drawing, q: Array, angle: float) -> Array:
    """The state with the second link of the last cut dyad turned until its arm is ``angle`` from the other's line."""
    q = q.copy()
    pins = drawing.system.pins
    cut = pins[-1] if len(drawing.poses) > 3 else pins[2]
    ends = []
    for link, on in ((cut.a, cut.on_a), (cut.b, cut.on_b)):
        other = next(
            place for pin in pins for k, place in ((pin.a, pin.on_a), (pin.b, pin.on_b)) if k == link and pin is not cut
        )
        ends.append((link, complex(on[0] - other[0], on[1] - other[1])))
    (one, arm), (two, other_arm) = ends
    at = {name: index for index, name in enumerate(model.q_names)}
    line = q[at[f"theta_{one}"]] + math.atan2(arm.imag, arm.real)
    q[at[f"theta_{two}"]] = line + angle - math.atan2(other_arm.imag, other_arm.real)
    return q


@pytest.mark.parametrize("driven", [False, True])
@pytest.mark.parametrize("massless", [False, True])
def test_dyads_beside_drives_slides_loads_and_massless_links(driven: bool, massless: bool, workshop: Workshop) -> None:
    """The same accelerations as from tip to root, at a state of no symmetry."""
    text = HARD.replace("MASS", "0.0" if massless else "1.5").replace("INERTIA", "0.0" if massless else "0.4")
    text += '[[drive]]\njoint = "axle"\nspeed = "2 + sin(3*t)"\n' if driven else ""
    scene = workshop.scene(text)
    plan = plan_scene(scene, DYADS)[1].plan
    assert any(is_dyad(pivot) for pivots in plan.pivots.values() for pivot in pivots)
    found = {}
    for name in (DYADS, TIP_TO_ROOT):
        read = read_listing(listing(scene, plan=name), name)
        rng = np.random.default_rng(7)
        given = {"t": np.array([0.3]), "inputs": np.zeros(0)}
        values = {entry: rng.normal() for entry in sorted({*read.state["q"], *read.state["u"]})}
        given |= {side: np.array([values[entry] for entry in read.state[side]]) for side in ("q", "u")}
        inputs = read.kernels["acceleration"].inputs
        found[name] = read.evaluate("acceleration", {key: given[key] for key in inputs})["u_dot"], read.state["u"]
    assert found[DYADS][1] == found[TIP_TO_ROOT][1]
    first, other = found[DYADS][0], found[TIP_TO_ROOT][0]
    assert np.abs(first - other).max() <= 1e-12 * np.abs(other).max()
