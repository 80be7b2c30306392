"""Loops in generated code: mechanisms with long and shared runs of links, against the code written out."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ccgen.generator import generate
from ccgen.generator.program.reading import read_listing
from ccgen.generator.program.rolling import LEAST_ROUNDS
from ccgen.generator.scene.scene import Scene

from ..oracles import graphs, maximal
from ..oracles.maximal import Array
from ..oracles.mechanisms import Drawing
from ..support.tiers import all_hard_but
from ..support.workshop import Workshop
from ..support.written_models import WARNINGS, Compiled, Written, same

CONDITIONED = 1e5
"""States whose ``G M^-1 G^T`` has a larger condition number are left out."""

FAMILIES: dict[str, tuple[graphs.Edges, bool]] = {
    "theta-three": (graphs.theta([14, 14, 14]), False),
    "theta-two-lengths-grounded": (graphs.theta([9, 12, 16], grounded=True), False),
    "theta-permuted": (graphs.theta([9, 10, 10]), True),
    "nested-off-the-root-grounded": (graphs.nested(30, 14, 8, 19, grounded=True), False),
    "ladder-12-grounded": (graphs.ladder(12, grounded=True), False),
    "comb": (graphs.comb(12, 3, grounded=True), False),
    "tree": (graphs.tree(40, 2), False),
    "tree-permuted": (graphs.tree(31, 3), True),
}


@pytest.fixture(scope="module", params=all_hard_but("theta-two-lengths-grounded", of=FAMILIES))
def pair(request: pytest.FixtureRequest, workshop: Workshop) -> tuple[Any, Drawing, Scene]:
    edges, permuted = FAMILIES[request.param]
    drawing = graphs.mechanism(request.param, edges, permuted=permuted)
    scene = workshop.scene(drawing.toml())
    return workshop.model(scene), drawing, scene


def closed_states(model: Any, drawing: Drawing, count: int = 3) -> Iterator[tuple[Array, Array]]:
    """Random closed states near the drawing, away from singular ones."""
    rng = np.random.default_rng([5, drawing.system.size])
    q0, _ = model.state_from_poses(drawing.poses, 0 * drawing.poses)
    angles = [k for k, name in enumerate(model.q_names) if name.startswith("theta_")]
    found = 0
    for attempt in range(10 * count):
        bent = q0.copy()
        if attempt:
            bent[angles] += rng.uniform(-0.1, 0.1, len(angles))
        try:
            q, u = model.project(model.assemble(bent), rng.normal(size=len(model.u_names)))
        except ValueError:
            continue  # a bend that cannot be closed
        if maximal.conditioning(drawing.system, model.poses(q)) <= CONDITIONED:
            yield q, u
            found += 1
        if found == count:
            return
    raise AssertionError(f"only {found} of {10 * count} random states are closed and away from singular ones")


def test_families_are_what_they_say() -> None:
    for name, (edges, _) in FAMILIES.items():
        links = 1 + max(link for edge in edges for link in edge)
        assert 30 <= links <= 62, name


# -- generated code ------------------------------------------------------------------------------------------------


@pytest.mark.hard
@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no cc")
def test_long_runs_compile_without_warnings(pair: tuple[Any, Drawing, Scene], tmp_path: Path) -> None:
    folder = generate(pair[2], out=tmp_path / "build")
    command = ["cc", *WARNINGS, "-fsyntax-only", "model.c"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:3000]


def test_compiled_kernels_are_the_listing(pair: tuple[Any, Drawing, Scene], tmp_path: Path) -> None:
    model, drawing, scene = pair
    read = read_listing((generate(scene, out=tmp_path / "build") / "equations.txt").read_text())
    rng = np.random.default_rng(17)
    for q, u in closed_states(model, drawing):
        rows = 2 * len(model.cuts)
        values = {"q": q, "u": u, "f": rng.normal(size=u.size), "y": rng.normal(size=rows)}
        (u_dot,), (multipliers,), without = model.kernels.acceleration(q[None], u[None], 0.0)
        (du,), (impulses,), (outcome,) = model.kernels.impulse(q[None], values["f"][None], values["y"][None])
        assert not without
        assert outcome == "done"
        wanted = read.evaluate("acceleration", values)
        assert same(u_dot, wanted["u_dot"])
        assert not rows or same(multipliers[:rows], wanted["lambda"])
        wanted = read.evaluate("impulse", values)
        assert same(du, wanted["du"])
        assert not rows or same(impulses[:rows], wanted["Lambda"])
        given_ = {"q": q, "u": u, "u_dot": u_dot, "lambda": multipliers[:rows]}
        outboard = np.array(model.data["sides"])[:, None] * model.reactions(q, u)  # the listing's are on outboard links
        assert same(outboard, read.evaluate("reactions", given_)["reaction"])
        assert same(np.array(model.energy(q, u)), read.evaluate("energy", values)["energy"])
        assert same(model.poses(q), read.evaluate("poses", values)["pose"])
        assert same(model.velocities(q, u), read.evaluate("velocities", values)["velocity"])
        assert not rows or same(model.jacobian(q), read.evaluate("closure_jacobian", values)["A"])


def test_long_runs_accelerate_as_the_dense_solve(pair: tuple[Any, Drawing, Scene]) -> None:
    model, drawing, _ = pair
    column = {"vx": 0, "vy": 1, "w": 2}
    names = [name.rsplit("_", 1) for name in model.u_names]
    for q, u in closed_states(model, drawing):
        motion = maximal.accelerate(drawing.system, model.poses(q), model.velocities(q, u))
        wanted = np.array([motion.frames[int(link), column[kind]] for kind, link in names], dtype=float)
        assert same(model.acceleration(q, u), wanted, 1e-11)
        assert same(model.reactions(q, u)[:, :2], motion.forces, 1e-11)
        assert model.energy(q, u)[0] == pytest.approx(
            maximal.energy(drawing.system, model.poses(q), model.velocities(q, u))[0], rel=1e-13
        )


# -- loops against the same code written out ------------------------------------------------------------------------


def compare(written: Written, count: int) -> Compiled:
    """Rolled code against the same written out, bit by bit."""
    rolled, straight = written.compiled("rolled", LEAST_ROUNDS), written.compiled("straight", 10**9)
    assert "for (int i" not in straight.source
    rng = np.random.default_rng(29)
    for _ in range(count):
        arguments = written.arguments(rng)
        found, wanted = rolled.everything(*arguments), straight.everything(*arguments)
        for kernel, outputs in wanted.items():
            for one, other in zip(found[kernel], outputs, strict=True):
                assert np.all(np.isfinite(other)), kernel
                assert one.tobytes() == other.tobytes(), kernel
    return rolled


GROUND = "[[ground]]\nnormal = [0.3, 1.0]\npoint = [0.1, -20.0]\nrestitution = 0.5\n"
LOOPED: dict[str, str] = {
    "ring": graphs.mechanism("ring", graphs.ring(26)).toml(extra=GROUND),
    "theta": graphs.mechanism("theta", graphs.theta([13, 13, 8])).toml(),
    "ladder": graphs.mechanism("ladder", graphs.ladder(12, grounded=True)).toml(),
    "shorthand": 'name = "rods"\n[loop]\nlinks = 30\n[gravity]\n[start]\nheight = 1.0\n' + GROUND,
}


@pytest.mark.hard
@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no cc")
@pytest.mark.parametrize("name", all_hard_but("theta", of=LOOPED))
def test_loops_are_bitwise_the_code_written_out(name: str, workshop: Workshop, tmp_path: Path) -> None:
    rolled = compare(Written(workshop.scene(LOOPED[name]), tmp_path), 5)
    assert "for (int i" in rolled.source


@st.composite
def mechanisms(draw: st.DrawFn) -> Drawing:
    """A link, and runs grown from anywhere to anywhere; numbered at random or in the order of growth."""
    end = st.integers(0, 30)
    parts = draw(st.lists(st.tuples(end, st.none() | end, st.integers(1, 10)), min_size=2, max_size=4))
    edges = graphs.ears(draw(st.booleans()), parts)
    return graphs.mechanism("ears", edges, draw(st.integers(0, 99)), draw(st.booleans()))


@pytest.mark.hard
@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no cc")
@settings(max_examples=6, derandomize=True, deadline=None, suppress_health_check=list(HealthCheck), database=None)
@given(drawing=mechanisms())
def test_random_mechanisms(drawing: Drawing, workshop: Workshop, tmp_path_factory: pytest.TempPathFactory) -> None:
    """Loops against straight code, the listing and the dense solve."""
    written = Written(workshop.scene(drawing.toml()), tmp_path_factory.mktemp("ears"))
    rolled, read = compare(written, 2), written.listing()
    if maximal.conditioning(drawing.system, drawing.poses) > CONDITIONED:
        return
    rng = np.random.default_rng(31)
    velocities = maximal.project(drawing.system, drawing.poses, rng.normal(size=drawing.poses.shape)).astype(float)
    q, u = (_picked([s.name for s in written.equations.state.u], x) for x in (drawing.poses, velocities))
    _, _, f, y, pushes = written.arguments(rng)
    found = rolled.everything(q, u, f, y, pushes)
    values = {"q": q, "u": u, "f": f, "y": y}
    for kernel, names in {"acceleration": ("u_dot", "lambda"), "impulse": ("du", "Lambda")}.items():
        wanted = read.evaluate(kernel, values)
        for name, output in zip(names, found[kernel], strict=True):
            assert not output.size or same(output, wanted[name])
    assert same(found["poses"][0], drawing.poses, 1e-13)
    motion = maximal.accelerate(drawing.system, drawing.poses, velocities)
    wanted_rates = _picked([s.name for s in written.equations.state.u], motion.frames.astype(float))
    assert same(found["acceleration"][0], wanted_rates, 1e-11)


def _picked(names: Iterable[str], frames: Array) -> Array:
    """Entries of per-link frames (x, y, angle) in the order of the quasi-velocities."""
    column = {"vx": 0, "vy": 1, "w": 2}
    return np.array([frames[int(link), column[kind]] for kind, link in (n.rsplit("_", 1) for n in names)])
