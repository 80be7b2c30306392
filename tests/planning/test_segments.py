"""Segments: what may stand at their ends, how compact their links may be, and where their guards send a state on."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from ccgen.generator import generate, loop
from ccgen.generator.equations.equations import GUARD
from ccgen.generator.pipeline import derive_scene, listing, plan_scene
from ccgen.generator.planning import choose as choosing
from ccgen.generator.planning.choose import IN_SEGMENTS, TIP_TO_ROOT
from ccgen.generator.program.reading import ListedKernel, Listing, read_listing
from ccgen.generator.scene import read_tables
from ccgen.generator.scene.scene import Scene
from ccgen.runtime import load_model

from ..oracles.maximal import Array
from ..support.planned_mechanisms import ring_of
from ..support.tiers import all_hard_but, hard

ODD = {"massless": (0.0, 0.0, 0.0), "inner": (1.0, 0.0, 0.0), "outer": (1.0, 0.0, 1.0), "near": (1.0, 0.0, 1e-3)}
"""Mass, inertia and centre of links that resist some of their own motions only, or none."""


def ring_with(links: int, odd: int, kind: str, backwards: bool = False) -> Scene:
    """A ring of rods with one odd link; backwards, each joint names its links the other way round."""
    points = {"A": [0.0, 0.0], "B": [1.0, 0.0]}
    ends = [[f"link{k}.B", f"link{(k + 1) % links}.A"] for k in range(links)]
    tables = []
    for k in range(links):
        mass, inertia, x = ODD[kind] if k == odd else (1.0, 0.1, 0.5)
        tables.append({"name": f"link{k}", "mass": mass, "inertia": inertia, "com": [x, 0.0], "points": points})
    start = {"angles": [2.0 * math.pi * k / links for k in range(links)]}
    joints = [{"between": pair[::-1] if backwards else pair} for pair in ends]
    name = f"{kind}{links}_{odd}"
    return read_tables({"link": tables, "joint": joints, "start": start, "gravity": {}}, name, name)


def straight(links: int) -> list[float]:
    """Angles of a ring in the shape of a triangle."""
    return [2.0 * math.pi / 3.0 * (3 * k // links) for k in range(links)]


def at(read: Listing, angles: Any) -> dict[str, Array]:
    """Links at these angles, with speeds drawn at random, as arguments of an acceleration."""
    rates = np.random.default_rng(3).normal(size=len(angles))
    state = {"theta": angles, "w": rates}
    given = {}
    for name in ("q", "u"):
        split = [entry.rsplit("_", 1) for entry in read.state[name]]
        given[name] = np.array([state[kind][int(link)] if kind in state else 0.0 for kind, link in split])
    return given | {"t": np.zeros(1), "inputs": np.zeros(0)}


def motions(read: Listing, angles: Any) -> Array:
    given = {name: x for name, x in at(read, angles).items() if name in read.kernels["acceleration"].inputs}
    found = read.evaluate("acceleration", given)["u_dot"]
    split = [name.rsplit("_", 1) for name in read.state["u"]]
    return np.array([x for x, (kind, _) in zip(found, split, strict=True) if kind == "w"])


def carriers(scene: Scene) -> list[int]:
    """Links that segments hang from, and those that are joined to the outer end of the last, other than the root."""
    topology, choice = plan_scene(scene)
    plan = choice.plan
    found = [topology.branch(link).parent for link in plan.severed]
    found += [s.link for cut in topology.cuts for s in (cut.first, cut.second)]
    return [link for link in found if link != topology.root]


@pytest.mark.sample(3)
@pytest.mark.parametrize("kind", ODD)
@pytest.mark.parametrize("backwards", [False, True])
def test_odd_links_are_at_no_end_of_a_segment(kind: str, backwards: bool) -> None:
    """Beside the root on either side, with none to three links left over."""
    for links in (26, 27, 28, 29):
        for odd in (1, links - 1):
            scene = ring_with(links, odd, kind, backwards)
            assert plan_scene(scene)[1].plan.name == IN_SEGMENTS
            assert odd not in carriers(scene)


@pytest.mark.hard
@pytest.mark.slow
@pytest.mark.parametrize("kind", all_hard_but("massless", of=ODD))
@pytest.mark.parametrize(("odd", "backwards"), [(1, False), hard(25, True)])
def test_odd_links_beside_segments_move_as_from_tip_to_root(kind: str, odd: int, backwards: bool) -> None:
    """A point's centre may be set onto its pin at run time."""
    scene = ring_with(26, odd, kind, backwards)
    found = []
    for plan in (IN_SEGMENTS, TIP_TO_ROOT):
        read = read_listing(listing(scene, plan=plan), plan)
        if kind == "near":
            read.parameters[f"c_{odd}_x"] = 0.0
        found.append(motions(read, [pose[2] for pose in scene.start.poses]))
    assert np.abs(found[0] - found[1]).max() <= 1e-13 * np.abs(found[1]).max()


def test_compact_links_keep_the_order_from_tip_to_root() -> None:
    """From 0.03 m r² on they go in segments, r from the centre to the farther pin; so with what is beside."""
    edge = 0.03 * 0.25
    for n in (24, 26):
        for odd in (None, 1, 12) if n == 26 else (None,):
            names = []
            for inertia in (1.05 * edge, 0.95 * edge):
                inertias = [inertia if odd in (None, k) else 1.5 * edge for k in range(n)]
                plan = plan_scene(ring_of(n, inertia=inertias))[1].plan
                names.append(plan.name if odd is None else 1 in sum(plan.modules, ()) or plan.severed == (2, 8, 14, 20))
            assert names == ([IN_SEGMENTS, TIP_TO_ROOT] if odd is None else [True, False]), odd
    far = [[0.5, 0.0]] * 23 + [[0.8, 0.0]]
    assert plan_scene(ring_of(24, com=far, inertia=[0.9 * 0.03 * 0.64] * 24))[1].plan.name == TIP_TO_ROOT


@pytest.mark.parametrize("light", [1, 25])
def test_light_links_are_beside_no_segment(light: int) -> None:
    """A ring of 26 leaves one link over, which carries the first segment, unless that is light."""
    for ratio, spared in ((0.11, False), (0.09, True)):
        masses = [ratio if k == light else 1.0 for k in range(26)]
        plan = plan_scene(ring_of(26, mass=masses, inertia=[m / 12.0 for m in masses]))[1].plan
        segments = plan.modules if plan.name == IN_SEGMENTS else ()
        assert segments or light == 25
        near = {link for segment in segments for link in range(segment[0] - 1, segment[-1] + 2)}
        assert (light not in near) == spared


def felt(angles: Any, mass: float, inertia: float) -> Array:
    """The mass that the inner pin of a free row of rods of length 1 feels, from the dense mass matrix of the row."""
    count = len(angles)
    rows = np.zeros((2 * count, 2 + count))
    for k in range(count):
        rows[2 * k : 2 * k + 2, :2] = np.eye(2)
        for i in range(k + 1):
            reach = 0.5 if i == k else 1.0
            rows[2 * k : 2 * k + 2, 2 + i] = reach * np.array([-math.sin(angles[i]), math.cos(angles[i])])
    whole = mass * rows.T @ rows + np.diag([0.0, 0.0, *[inertia] * count])
    return whole[:2, :2] - whole[:2, 2:] @ np.linalg.solve(whole[2:, 2:], whole[2:, :2])


def holding(scene: Scene, read: Listing, angles: Any) -> Array:
    """By how much each guard of the acceleration holds in a state: its pivot over what that must exceed."""
    equations = derive_scene(scene, plan=IN_SEGMENTS)[1]
    kernel = next(kernel for kernel in equations.kernels if kernel.name == "acceleration")
    outputs = {}
    for index, guard in enumerate(kernel.guards):
        for name, entry in zip(("pivot", "scale"), guard, strict=True):
            outputs[name, index] = compile(str(entry), "guard", "eval")
    read.kernels["guards"] = ListedKernel(read.kernels["acceleration"].inputs, outputs)
    found = read.evaluate("guards", at(read, angles))
    return found["pivot"] / (GUARD * found["scale"])


@pytest.mark.hard
def test_the_guard_compares_what_resists_across_a_row() -> None:
    """Φ⊥² > 1e-4 m Φ∥: a straight segment at whatever inertia, and the same from a dense matrix."""
    scene, angles = ring_of(24), straight(24)
    plan = plan_scene(scene)[1].plan
    read = read_listing(listing(scene), "ring")
    for inertia in (1.0 / 12.0, 3e-3, 1e-3, 1e-5):
        read.parameters |= {name: inertia for name in read.parameters if name.startswith("I_")}
        held = holding(scene, read, angles)
        wanted = []
        for segment in plan.modules:
            phi = felt([angles[k] for k in segment], 1.0, inertia)
            wanted.append(np.linalg.det(phi) ** 2 / (1e-4 * np.trace(phi) ** 3))
        for value in wanted:
            assert np.abs(held / value - 1.0).min() <= 1e-6
        assert (held.min() > 1.0) == (inertia >= 3e-3)


@pytest.mark.hard
def test_the_guard_compares_what_resists_at_the_ends() -> None:
    """J > 1e-3 m l² for the link that carries the first segment, one that carries the next, and the last of the row."""
    scene = ring_of(26)
    plan = plan_scene(scene)[1].plan
    assert plan.severed == (2, 8, 14, 20)
    read = read_listing(listing(scene), "ring")
    for link in (1, 7, 25):
        for mass in (1e-1, 4e-3, 2e-3, 1e-5):
            given = dict(read.parameters)
            read.parameters |= {f"m_{link}": mass, f"I_{link}": mass / 12.0}
            held = holding(scene, read, straight(26))
            read.parameters = given
            assert np.abs(held / (mass / 3.0 / 1e-3) - 1.0).min() <= 1e-6
            assert (held.min() > 1.0) == (mass > 3e-3)


@pytest.mark.hard
@pytest.mark.parametrize("compiled", [True, False])
def test_compact_links_in_a_straight_row_keep_their_digits(
    compiled: bool, tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Inertias that are made small at run time: such states go from tip to root, or on the runtime's robust path."""
    if not compiled:
        monkeypatch.setattr(choosing, "LONGEST", 0)
    bound = 1e-13 if compiled else 1e-12
    scene = loop(24, gravity=True, name=f"compact{compiled:d}")
    assert (plan_scene(scene)[1].plan.otherwise is not None) == compiled
    own = load_model(generate(scene, out=tmp_path))
    wide = load_model(generate(scene, out=tmp_path, plan=TIP_TO_ROOT, precision="wide"))
    q, u = own.start()
    at_angles = [own.q_names.index(f"theta_{k}") for k in range(24)]
    q[at_angles] = straight(24)
    q, u = own.project(q, np.random.default_rng(1).normal(size=len(u)))
    for inertia in (3e-3, 8e-4, 1e-4, 1e-6, 1e-8):
        for model in (own, wide):
            model.parameters.update({f"link_{k}.inertia": inertia for k in range(24)})
        wanted = wide.acceleration(q.astype(np.longdouble), u.astype(np.longdouble))
        assert np.abs(own.acceleration(q, u) - wanted).max() <= bound * np.abs(wanted).max(), inertia
        several = own.acceleration(np.tile(q, (9, 1)), np.tile(u, (9, 1)))
        assert np.abs(several - wanted).max() <= bound * np.abs(wanted).max(), inertia


@pytest.mark.hard
@pytest.mark.parametrize("light", [1, 7])
def test_links_that_become_light_at_run_time_keep_the_digits(light: int, tmp_path: Any) -> None:
    """The link that carries a segment, and the last of one that carries the next: masses down to 1e-9."""
    scene = loop(26, gravity=True, name="light")
    own = load_model(generate(scene, out=tmp_path))
    wide = load_model(generate(scene, out=tmp_path, plan=TIP_TO_ROOT, precision="wide"))
    for ratio in (1e-2, 1e-4, 1e-6, 1e-9):
        for model in (own, wide):
            model.parameters.update({f"link_{light}.mass": ratio, f"link_{light}.inertia": ratio / 12.0})
        q, u = own.start()
        q, u = own.project(q, np.random.default_rng(1).normal(size=len(u)))
        wanted = wide.acceleration(q.astype(np.longdouble), u.astype(np.longdouble))
        assert np.abs(own.acceleration(q, u) - wanted).max() <= 1e-12 * np.abs(wanted).max(), ratio
