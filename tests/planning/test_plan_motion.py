"""Orders of elimination: each gives the motion of the dense reference, and no loop goes before what its rows need."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.generator.equations.names import turn
from ccgen.generator.mechanism.topology import span
from ccgen.generator.pipeline import listing, plan_scene
from ccgen.generator.planning import choose as choosing
from ccgen.generator.planning.choose import DYADS, PLANS, choose
from ccgen.generator.program.reading import read_listing

from ..oracles import graphs, maximal
from ..oracles.maximal import Array
from ..oracles.mechanisms import Drawing
from ..support.large_mechanisms import scene_of
from ..support.planned_mechanisms import MECHANISMS, ROWS
from ..support.tiers import all_hard_but


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


@pytest.mark.sample(2)
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


def _check_impulses(drawing: Drawing, text: str, q: Array, names: list[str], rng: np.random.Generator) -> None:
    """A jump du by impulses f keeps every joint closed and is balanced: f is M du along all motions that keep them."""
    wanted = maximal.project(drawing.system, drawing.poses, rng.normal(size=drawing.poses.shape))
    momentum = state_of(text, drawing.poses, wanted)[1]
    f = solved(text, "momentum", q=q, u=momentum)["p"]
    found = solved(text, "impulse", q=q, f=f)["du"]
    assert np.abs(found - momentum).max() <= 1e-12 * np.abs(momentum).max()


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
