"""Orders of elimination: each gives the dense reference's motion, the cheapest is taken, dead centres keep their
digits."""

from __future__ import annotations

import dataclasses
import math
import re
from typing import Any

import numpy as np
import pytest

from ccgen.generator import generate, load_scene, loop
from ccgen.generator.derive.derivation import derive
from ccgen.generator.derive.gibbs import Recursion
from ccgen.generator.documents.show import show_text
from ccgen.generator.equations.names import turn
from ccgen.generator.mechanism.topology import Topology, span
from ccgen.generator.pipeline import Variant, derive_scene, fold_price, listing, plan_scene, prices
from ccgen.generator.planning import choose as choosing
from ccgen.generator.planning.choose import DYADS, IN_SEGMENTS, PLANS, TIP_TO_ROOT, choose
from ccgen.generator.planning.pattern import Pattern, Sweep
from ccgen.generator.planning.plan import is_dyad
from ccgen.generator.planning.segments import APART, SEGMENTS
from ccgen.generator.program.dialects import C
from ccgen.generator.program.program import lower
from ccgen.generator.program.reading import read_listing
from ccgen.generator.program.routine import LANES, Routines
from ccgen.generator.scene import read_tables
from ccgen.generator.scene.scene import Scene
from ccgen.runtime import load_model

from ..oracles import graphs, maximal
from ..oracles.graphs import Edges
from ..oracles.maximal import GROUND, Array
from ..oracles.mechanisms import Drawing
from ..support.folders import ROOT
from ..support.large_mechanisms import near_chain, operations, scene_of, walking
from ..support.tiers import all_hard_but, hard
from ..support.workshop import Workshop

MECHANISMS: dict[str, Edges] = {
    "four-bar": [(GROUND, 0), (0, 1), (1, 2), (2, GROUND)],
    "one leg": walking(1),
    "four legs": walking(4),
    "grounded ladder": graphs.ladder(5, grounded=True),
    "theta": graphs.theta((2, 3, 2)),
    "grounded theta": graphs.theta((1, 2, 2), grounded=True),
    "near chain": near_chain(24, 6, 1),
    "grounded near chain": [(GROUND, 0), *near_chain(20, 5, 2)],
    "a link with two cut pins": [(GROUND, 0), (GROUND, 1), (0, 2), (1, 3), (1, 4), (2, 3), (2, 4)],
    "a triangle under a rocker": [(GROUND, 0), (0, 1), (0, 3), (3, 1), (1, 2), (2, 4), (4, GROUND)],
    "a loop beside dyads": [
        *[(GROUND, 0), (GROUND, 1), (GROUND, 2), (0, 3), (3, 4), (1, 5), (5, 6), (3, 7), (7, 8), (8, 9), (2, 4)],
        *[(0, 8), (GROUND, 9)],
    ],
    "loops in a ring": [(0, 1), (1, 2), (0, 3), (3, 4), (4, 5), (3, 6), (0, 5), (4, 6)],
}
ROWS: dict[str, Edges] = {
    "ring": graphs.ring(25),
    "hinged ring": graphs.ring(23, grounded=True),
    "pinned at both ends": [*((k - 1, k) for k in range(20)), (19, GROUND)],
    "ring with a handle": graphs.nested(28, 2, 0, 2),
    "two rings": [*graphs.ring(24), (3, 24), (24, 25), (25, 26), (26, 3)],
    "ring that is drawn the other way": [(b, a) for a, b in graphs.ring(25)],
}
"""Mechanisms with a row of links in a loop that is long enough for segments."""
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


def solved(text: str, kernel: str, **given: Array) -> dict[str, Array]:
    """What a kernel of a listing gives."""
    read = read_listing(text, "listing")
    arguments = {name: given.get(name, np.zeros(len(s))) for name, s in read.kernels[kernel].inputs.items()}
    return read.evaluate(kernel, arguments)


def state_of(text: str, poses: Array, velocities: Array) -> tuple[Array, Array, list[str]]:
    """q and u of the listing for frames at ``poses`` that move with ``velocities``, and the names of u."""
    state = read_listing(text, "listing").state
    q_names, u_names = state["q"], state["u"]
    at = {"x": 0, "y": 1, "theta": 2, "vx": 0, "vy": 1, "w": 2}

    def read(names: Any, frames: Array) -> Array:
        split = (name.rsplit("_", 1) for name in names)
        return np.array([frames[int(link), at[kind]] for kind, link in split], dtype=float)

    return read(q_names, poses), read(u_names, velocities), list(u_names)


@pytest.mark.parametrize("plan", PLANS)
@pytest.mark.parametrize("name", all_hard_but("four-bar", "one leg", "theta", "hinged ring", of=MECHANISMS | ROWS))
def test_every_plan_gives_the_motion_of_the_dense_reference(name: str, plan: str, tmp_path: Any) -> None:
    """Accelerations, and the jumps that generalized impulses bring, at the drawn configuration."""
    drawing = graphs.mechanism("mechanism", (MECHANISMS | ROWS)[name], seed=5)
    scene = scene_of(drawing, tmp_path)
    if plan not in dict(plan_scene(scene)[1].costs):
        pytest.skip("it has no such plan")
    text = listing(scene, plan=plan)
    rng = np.random.default_rng(2)
    speeds = maximal.project(drawing.system, drawing.poses, rng.normal(size=drawing.poses.shape))
    q, u, names = state_of(text, drawing.poses, speeds)
    motion = maximal.accelerate(drawing.system, drawing.poses, speeds)
    wanted = state_of(text, drawing.poses, motion.frames)[1]
    found = solved(text, "acceleration", q=q, u=u)["u_dot"]
    assert np.abs(found - wanted).max() <= 1e-12 * np.abs(wanted).max()
    _check_impulses(drawing, text, q, names, rng)


@pytest.mark.parametrize("name", MECHANISMS | ROWS)
def test_loops_go_after_what_their_rows_need(name: str, tmp_path: Any) -> None:
    """No multipliers are eliminated while an angular acceleration on the way round their loop is open."""
    scene = scene_of(graphs.mechanism("mechanism", (MECHANISMS | ROWS)[name], seed=5), tmp_path)
    tree = span(scene.mechanism)
    sound = [c.joint for c in tree.cuts]
    for wanted, _ in choose(scene.mechanism, tree, (), sound).costs:
        choice = choose(scene.mechanism, tree, (), sound, wanted)
        plan, topology = choice.plan, choice.topology
        gone: set[Any] = set()
        for link in [branch.link for branch in reversed(topology.branches)] + [topology.root]:
            for pivot in plan.at(link):
                if pivot[0].kind == "lambda":
                    cuts = [*topology.cuts, *map(topology.severed, plan.severed)]
                    (cut,) = (c for c in cuts if c.joint == pivot[0].joint)
                    for side in (cut.first.link, cut.second.link):
                        way = topology.path(side)
                        assert {turn(k) for k in way[: way.index(cut.meeting)]} <= gone
                gone |= set(pivot)
        assert {turn(k) for k in range(len(scene.mechanism.links))} <= gone


def test_the_plan_for_dead_centres_is_whole(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """However soon the count of the order from tip to root is given up, what is compiled of it has everything."""
    monkeypatch.setattr(choosing, "FAR", 0.1)
    scene = scene_of(graphs.mechanism("mechanism", MECHANISMS["one leg"], seed=5), tmp_path)
    otherwise = plan_scene(scene, DYADS)[1].plan.otherwise
    assert otherwise is not None
    gone = {v for pivots in otherwise.pivots.values() for pivot in pivots for v in pivot}
    assert {turn(k) for k in range(len(scene.mechanism.links))} <= gone


def test_what_slides_carries_no_dyad(workshop: Workshop) -> None:
    model = workshop.model(SLIDER_CRANK)
    q, u = model.start()
    assert np.all(np.isfinite(model.acceleration(q, u)))
    assert [name for name, _ in plan_scene(workshop.scene(SLIDER_CRANK))[1].costs] == [TIP_TO_ROOT]


def _check_impulses(drawing: Drawing, text: str, q: Array, names: list[str], rng: np.random.Generator) -> None:
    """A jump du by impulses f keeps every joint closed and is balanced: f is M du along all motions that keep them."""
    wanted = maximal.project(drawing.system, drawing.poses, rng.normal(size=drawing.poses.shape))
    momentum = state_of(text, drawing.poses, wanted)[1]
    f = solved(text, "momentum", q=q, u=momentum)["p"]
    found = solved(text, "impulse", q=q, f=f)["du"]
    assert np.abs(found - momentum).max() <= 1e-12 * np.abs(momentum).max()


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


@pytest.mark.hard
def test_the_order_is_told(tmp_path: Any) -> None:
    """What a walking machine closes and leaves open, and the operations of each plan as its program has them."""
    scene = load_scene(ROOT / "scenes" / "strandbeest.toml")
    text = show_text(scene, False, False, equations=False)
    taken, other = operations(scene, DYADS), operations(scene, TIP_TO_ROOT)
    assert re.search(rf"order +dyads: {taken} operations of the acceleration, \d+ of them one after the other\n", text)
    assert f" tip to root: {other} operations, {other / taken:.2g} times as many, " in text
    assert "closed as dyads, the outermost first: " in text and "left open until then: shaft" in text


def test_why_a_plan_with_fewer_operations_is_not_taken() -> None:
    scene = load_scene(ROOT / "scenes" / "four-bar.toml")
    text = " ".join(show_text(scene, False, False, equations=False).split())
    few = operations(scene, DYADS)
    assert f"dyads: {few} operations, 0.64 times as many, " in text
    assert "taken only where they are 1.8 times fewer, since dyads divide by sines" in text
    text = show_text(scene, False, False, equations=False, plan=DYADS)
    assert f"dyads: {few} operations of the acceleration" in text and "1.6 times as many" in text
    with pytest.raises(ValueError, match="found 'segments', expected 'tip to root': no loop"):
        show_text(scene, False, False, plan="segments")


@pytest.mark.slow
def test_of_segments_the_chain_is_told() -> None:
    """A ring in segments has more operations, four at a time, and fewer that wait for each other."""
    text = " ".join(show_text(loop(24), False, False, equations=False).split())
    found = re.search(r"order segments: (\d+) .*?, (\d+) of them .*? tip to root: (\d+) .*?, (\d+) of them", text)
    assert found
    own, chain, others, longer = map(int, found.groups())
    assert own > others and chain < longer


def test_a_ring_keeps_the_order_from_tip_to_root() -> None:
    choice = plan_scene(loop(12))[1]
    assert choice.plan.name == TIP_TO_ROOT
    assert [name for name, _ in choice.costs] == [TIP_TO_ROOT]
    with pytest.raises(ValueError, match="found 'dyads', expected 'tip to root': the mechanism has no dyad to close"):
        plan_scene(loop(12), DYADS)
    with pytest.raises(ValueError, match="found 'best', expected 'tip to root', 'dyads' or 'segments'"):
        plan_scene(loop(12), "best")
    assert str(Variant(plan="")) != str(Variant())  # so that no model of the default plan stands for a wrong name
    with pytest.raises(ValueError, match="found '', expected 'tip to root', 'dyads' or 'segments'"):
        plan_scene(loop(12), "")


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


def test_long_rings_go_in_segments() -> None:
    """Four segments of a ring as long as they can be; what is left over stays with the root."""
    topology, choice = plan_scene(loop(50))
    assert choice.plan.name == IN_SEGMENTS
    assert [len(segment) for segment in choice.plan.modules] == [12] * 4
    assert sum(choice.plan.modules, ()) == tuple(range(2, 50))
    assert choice.plan.severed == (2, 14, 26, 38)
    assert [cut.joint for cut in topology.cuts] == [
        next(j for j in (0, 49) if j not in {b.joint for b in topology.branches})
    ]
    assert plan_scene(loop(50), TIP_TO_ROOT)[1].plan.severed == ()
    with pytest.raises(
        ValueError, match="found 'segments', expected 'tip to root': no loop has a row of 20 links alike"
    ):
        plan_scene(loop(12), IN_SEGMENTS)


def ring_of(links: int, **table: Any) -> Scene:
    return read_tables({"loop": {"links": links, **table}, "gravity": {}}, "ring", "ring")


def test_rows_end_at_unlike_links() -> None:
    """Where a link's centre of mass is off its line and its neighbours' are not, their equations differ."""

    def longest(odd: int) -> int:
        coms = [[0.5, 0.1 * (k == odd)] for k in range(49)]
        plan = plan_scene(ring_of(49, com=coms))[1].plan
        return len(plan.modules[0]) if plan.name == IN_SEGMENTS else 0

    assert [longest(odd) for odd in (-1, 0, 1, 24, 36, 48)] == [12, 12, 11, 6, 0, 0]


@pytest.mark.parametrize("compiled", [False, hard(True)])
def test_links_that_do_not_resist_a_motion_are_in_no_segment(compiled: bool, workshop: Workshop) -> None:
    """Point masses on their inner or outer pin, or between: the ends of a segment would have no inertia."""
    points = {"A": [0.0, 0.0], "B": [1.0, 0.0]}
    joints = [{"between": [f"link{k}.B", f"link{(k + 1) % 44}.A"]} for k in range(44)]
    start = {"angles": [2.0 * math.pi * k / 44 for k in range(44)]}
    for com in (0.0, 0.5, 1.0):
        own = [(0.0, com) if 9 < k < 15 else (0.1, 0.5) for k in range(44)]
        links = [
            {"name": f"link{k}", "mass": 1.0, "inertia": inertia, "com": [x, 0.0], "points": points}
            for k, (inertia, x) in enumerate(own)
        ]
        name = f"points{10 * com:.0f}"
        scene = read_tables({"link": links, "joint": joints, "start": start}, name, name)
        choice = plan_scene(scene)[1]
        assert choice.plan.name == IN_SEGMENTS
        assert min(link for segment in choice.plan.modules for link in segment) >= 15
        if compiled:
            model = workshop.model(scene)
            assert np.all(np.isfinite(model.acceleration(*model.start())))


def test_light_links_and_forces_keep_the_order_from_tip_to_root(tmp_path: Any) -> None:
    """They cost digits at the ends of segments, or make segments unequal."""
    masses = [1.0] * 44
    assert plan_scene(ring_of(44, mass=masses))[1].plan.name == IN_SEGMENTS
    masses[30] = 1e-3
    assert plan_scene(ring_of(44, mass=masses))[1].plan.name == TIP_TO_ROOT
    pulled = loop(44, spring=[{"between": ["link_3.A", "link_9.A"], "stiffness": 10.0, "length": 1.0}])
    assert plan_scene(pulled)[1].plan.name == TIP_TO_ROOT
    assert plan_scene(pulled, IN_SEGMENTS)[1].plan.name == IN_SEGMENTS


@pytest.mark.hard
def test_segments_keep_their_digits_as_far_as_masses_may_differ(tmp_path: Any) -> None:
    """Light links at the ends of all segments, beside the same in wide numbers from tip to root."""
    masses = [1.0 if k not in (8, 13, 18, 23) else 1.0 / APART for k in range(24)]
    scene = ring_of(24, mass=masses)
    own = load_model(generate(scene, out=tmp_path, plan=IN_SEGMENTS))
    wide = load_model(generate(scene, out=tmp_path, plan=TIP_TO_ROOT, precision="wide"))
    rng = np.random.default_rng(1)
    for _ in range(3):
        start = own.start()[0] + 0.05 * rng.normal(size=26)
        q, u = own.project(start, rng.normal(size=26))
        wanted = wide.acceleration(q.astype(np.longdouble), u.astype(np.longdouble))
        assert np.abs(own.acceleration(q, u) - wanted).max() <= 1e-14 * np.abs(wanted).max()


def test_there_are_as_many_segments_as_lanes() -> None:
    assert SEGMENTS == LANES


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


@pytest.mark.hard
def test_prices_compare_programs_of_one_plan() -> None:
    """A spring's force keeps a ring from segments; what it costs is its own operations, not those of another plan."""
    spring = {"between": ["link_3.A", "link_9.A"], "stiffness": 10.0, "length": 1.0}
    (gravity, stretched) = prices(loop(24, gravity=True, spring=[spring]))
    assert gravity.added["acceleration"].total == 1
    assert 15 <= stretched.added["acceleration"].total <= 40
    assert -150 <= fold_price(loop(24, gravity=True)).added["acceleration"].total < 0


@pytest.mark.slow
def test_a_drive_has_a_price_by_the_same_kind_of_plan() -> None:
    """Without it, its joint has an acceleration more to solve for."""
    driven = load_scene(ROOT / "scenes" / "jansen-driven.toml")
    (index,) = [number for number, effect in enumerate(driven.effects) if effect.driven()]
    found = prices(driven)[index].added["acceleration"].total
    assert found == operations(driven, TIP_TO_ROOT) - operations(driven.without(index), TIP_TO_ROOT) < 0


@pytest.mark.hard
def test_the_order_from_tip_to_root_is_judged_on_its_best_tree() -> None:
    """Also where it is asked for, and where dyads are compared with it."""
    scene = load_scene(ROOT / "scenes" / "strandbeest.toml")
    short = dict(choose(scene.mechanism, span(scene.mechanism), (), ()).costs)[TIP_TO_ROOT]
    topology, asked = plan_scene(scene, TIP_TO_ROOT)
    taken = plan_scene(scene)[1]
    assert taken.plan.name == DYADS
    assert dict(asked.costs)[TIP_TO_ROOT] == dict(taken.costs)[TIP_TO_ROOT] < 0.7 * short
    assert topology != span(scene.mechanism)
    assert operations(scene, TIP_TO_ROOT) < 0.75 * _on(scene, span(scene.mechanism))


def _on(scene: Scene, topology: Topology) -> int:
    plan = choose(scene.mechanism, topology, (), (), TIP_TO_ROOT).plan
    return lower(derive(scene.mechanism, topology, plan, scene.effects)).function("acceleration").counts().total


@pytest.mark.hard
def test_segments_are_taken_only_where_they_go_side_by_side() -> None:
    """Folded numbers that differ leave no equal statements, and floats and wide numbers have no vectors."""
    unequal = ring_of(24, mass=[1.0 if k % 7 else 2.0 for k in range(24)])
    periodic = ring_of(24, mass=[1.0 if k % 5 else 2.0 for k in range(24)])
    for scene, fold, vectors, wanted in (
        (unequal, False, True, IN_SEGMENTS),
        (unequal, True, True, TIP_TO_ROOT),
        (ring_of(24), True, True, IN_SEGMENTS),
        (periodic, True, True, IN_SEGMENTS),
        (ring_of(24), False, False, TIP_TO_ROOT),
    ):
        topology, choice = plan_scene(scene, fold=fold, vectors=vectors)
        assert choice.plan.name == wanted
        if vectors:
            program = lower(derive_scene(scene, fold, choice=choice)[1])
            side_by_side = Routines(program, C.term).one_by_one("acceleration").modules
            assert bool(side_by_side) == (wanted == IN_SEGMENTS), topology


@pytest.mark.parametrize("plan", PLANS)
@pytest.mark.parametrize(
    "name", all_hard_but("four-bar", "one leg", "theta", "near chain", "hinged ring", of=MECHANISMS | ROWS)
)
def test_the_pattern_has_every_entry_of_the_forms(
    name: str, plan: str, tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Link by link, as gathered: what is not zero in a form is an entry of its pattern."""
    scene = scene_of(graphs.mechanism("mechanism", (MECHANISMS | ROWS)[name], seed=5), tmp_path)
    if plan not in dict(plan_scene(scene)[1].costs):
        pytest.skip("it has no such plan")
    topology, choice = plan_scene(scene, plan)
    forms: dict[int, set[Any]] = {}
    patterns: dict[int, set[Any]] = {}
    eliminate = Recursion._eliminate

    def gathered(self: Recursion, link: int, form: Any, eliminator: Any) -> Any:
        forms.setdefault(link, {key for key, entry in form.hessian.items() if entry != 0})
        return eliminate(self, link, form, eliminator)

    def told(link: int, pattern: Pattern) -> Any:
        patterns[link] = set(pattern.entries)
        return choice.plan.at(link)

    monkeypatch.setattr(Recursion, "_eliminate", gathered)
    first_only = dataclasses.replace(choice.plan, otherwise=None)
    derive(scene.mechanism, topology, first_only, scene.effects)
    Sweep(scene.mechanism, topology, scene.driven, choice.plan.severed).run(told)
    assert forms.keys() == patterns.keys()
    for link, entries in forms.items():
        assert entries <= patterns[link], link


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
