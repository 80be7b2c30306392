"""Loops in generated code: mechanisms with long and shared runs of links, against the code written out."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ccgen.generator import generate
from ccgen.generator.documents.listing import name_index, write_listing
from ccgen.generator.package.data import point_names
from ccgen.generator.pipeline import derive_scene
from ccgen.generator.program import abreast, rolling
from ccgen.generator.program.dialects import C
from ccgen.generator.program.program import lower
from ccgen.generator.program.reading import Listing, read_listing
from ccgen.generator.program.rolling import LEAST_ROUNDS
from ccgen.generator.program.routine import Routines
from ccgen.generator.scene.scene import Scene
from ccgen.generator.write_c.render import Banner, Sizes, render_c

from .conftest import Workshop
from .oracles import graphs, maximal
from .oracles.maximal import Array
from .oracles.mechanisms import Drawing

RUNTIME = Path(__file__).parents[1] / "runtime"
WARNINGS = ["-std=c11", "-Wall", "-Wextra", "-Werror"]
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


@pytest.fixture(scope="module", params=FAMILIES)
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


def same(found: Array, wanted: Array, tolerance: float = 1e-12) -> bool:
    """Largest difference against the largest entry."""
    found, wanted = np.ravel(found), np.ravel(wanted).astype(float)
    assert found.shape == wanted.shape
    assert np.all(np.isfinite(found))
    return bool(np.max(np.abs(found - wanted), initial=0.0) <= tolerance * np.max(np.abs(wanted), initial=0.0))


def test_families_are_what_they_say() -> None:
    for name, (edges, _) in FAMILIES.items():
        links = 1 + max(link for edge in edges for link in edge)
        assert 30 <= links <= 62, name


# -- generated code ------------------------------------------------------------------------------------------------


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
        assert same(model.reactions(q, u), read.evaluate("reactions", given_)["reaction"])
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
        signs = [1.0 if model.outboard[k] == f"body_{p.b}" else -1.0 for k, p in enumerate(drawing.system.pins)]
        assert same(model.reactions(q, u)[:, :2], np.array(signs)[:, None] * motion.forces, 1e-11)
        assert model.energy(q, u)[0] == pytest.approx(
            maximal.energy(drawing.system, model.poses(q), model.velocities(q, u))[0], rel=1e-13
        )


# -- loops against the same code written out ------------------------------------------------------------------------

KERNELS = [
    *("derive_constants", "acceleration", "impulse", "reactions", "closure", "closure_rate", "closure_bias"),
    *(
        "closure_jacobian",
        "momentum",
        "inverse_dynamics",
        "power",
        "prescribed",
        "poses",
        "velocities",
        "point_positions",
        "energy",
        "gaps",
        "gap_rates",
        "gap_bias",
        "contact_impulse",
        "restitution",
        "slips",
        "slip_bias",
        "slip_impulse",
        "friction",
        "contact_reactions",
        "impulse_reactions",
    ),
]
SIZES = [
    *("nq", "nu", "base", "rows", "links", "joints", "points", "contacts", "parameters", "constants", "inputs"),
    "drives",
]
TABLES = ["partner", "driven"]
COLUMNS = 3
"""Columns of impulses that contacts are asked to answer at once."""
Pointer = ctypes.c_void_p


class Descriptor(ctypes.Structure):
    """``struct ccgen_model``."""

    _fields_ = (
        ("version", ctypes.c_int),
        ("name", ctypes.c_char_p),
        ("hash", ctypes.c_char_p),
        *((size, ctypes.c_int) for size in SIZES),
        *((table, Pointer) for table in TABLES),
        *((kernel, Pointer) for kernel in KERNELS),
        ("lanes", ctypes.c_int),
        *((kernel, Pointer) for kernel in ("acceleration_lanes", "acceleration_states", "stages", "contact_response")),
    )


@dataclass
class Compiled:
    """A model's C, compiled without optimisation and without fused operations, called through ctypes."""

    source: str
    descriptor: Descriptor
    constants: Array

    def call(self, kernel: str, arguments: Sequence[Array | float | int | None], *outputs: int) -> list[Array]:
        """The outputs of a kernel; what it leaves unwritten stays NaN."""
        found = [np.full(size + 1, np.nan) for size in outputs]
        arrays = [self.constants, *arguments, *found]
        kinds = {float: ctypes.c_double, int: ctypes.c_int}
        types = [kinds.get(type(a), Pointer) for a in arrays]
        call = ctypes.CFUNCTYPE(ctypes.c_int, *types)(getattr(self.descriptor, kernel))
        call(*(a.ctypes.data if isinstance(a, np.ndarray) else a for a in arrays))
        assert all(np.isnan(out[-1]) for out in found), f"{kernel} writes beyond its output"
        return [out[:-1] for out in found]

    def call_without(self, kernel: str, arguments: Sequence[Array | float | None], size: int) -> Array:
        """The first output of a kernel whose second has no room."""
        found = np.full(size, np.nan)
        arrays = [self.constants, *arguments, found, None]
        types = [ctypes.c_double if isinstance(a, float) else Pointer for a in arrays]
        call = ctypes.CFUNCTYPE(ctypes.c_int, *types)(getattr(self.descriptor, kernel))
        call(*(a.ctypes.data if isinstance(a, np.ndarray) else a for a in arrays))
        return found

    def everything(self, q: Array, u: Array, f: Array, y: Array, pushes: Array) -> dict[str, list[Array]]:
        """Outputs of all kernels."""
        size = {name: getattr(self.descriptor, name) for name in SIZES}
        nu, rows, contacts = size["nu"], size["rows"], size["contacts"]
        found = {
            "acceleration": self.call("acceleration", [q, u, 0.0, None], nu, rows),
            "impulse": self.call("impulse", [q, f, y], nu, rows),
            "reactions": self.call("reactions", [q, u, 0.0, None, f, y], 3 * size["joints"]),
            "closure_bias": self.call("closure_bias", [q, u], rows),
            "momentum": self.call("momentum", [q, u], nu),
            "inverse_dynamics": self.call("inverse_dynamics", [q, u, 0.0, None, f], nu),
            "closure": self.call("closure", [q], rows),
            "closure_jacobian": self.call("closure_jacobian", [q], rows * nu),
            "poses": self.call("poses", [q], 3 * size["links"]),
            "point_positions": self.call("point_positions", [q], 2 * size["points"]),
            "closure_rate": self.call("closure_rate", [q, u], rows),
            "velocities": self.call("velocities", [q, u], 3 * size["links"]),
            "energy": self.call("energy", [q, u], 2),
        }
        if contacts:
            found["gaps"] = self.call("gaps", [q], contacts)
            found["gap_rates"] = self.call("gap_rates", [q, u], contacts)
            found["gap_bias"] = self.call("gap_bias", [q, u], contacts)
            found["contact_impulse"] = self.call("contact_impulse", [q, pushes], nu)
            width = contacts * (2 if self.descriptor.slip_impulse else 1)
            columns = np.resize(pushes, COLUMNS * width)
            found["contact_response"] = self.call(
                "contact_response", [q, COLUMNS, columns], COLUMNS * nu, COLUMNS * width
            )
        return found


@dataclass
class Written:
    """A scene's equations, to be written with and without loops."""

    scene: Scene
    folder: Path

    def __post_init__(self) -> None:
        self.topology, self.equations = derive_scene(self.scene)
        self.program = lower(self.equations)
        self.index = name_index(self.scene, self.topology)

    def listing(self) -> Listing:
        return read_listing(write_listing(self.scene.name, self.equations, self.index))

    def compiled(self, name: str, least: int, together: int = 10**9) -> Compiled:
        """The model with loops of at least ``least`` rounds, and modules of at least ``together`` statements abreast.

        Unless asked for there are none: sums over modules are added up in another order.
        """
        mechanism, program, state = self.scene.mechanism, self.program, self.equations.state
        sizes = Sizes(
            nq=len(state.q),
            nu=len(state.u),
            base=state.base,
            rows=len(self.topology.rows),
            links=len(mechanism.links),
            joints=len(mechanism.joints),
            points=len(point_names(mechanism)),
            contacts=len(self.equations.contacts),
            parameters=len(program.parameters),
            constants=len(program.parameters) + len(program.constants),
            inputs=0,
            drives=0,
        )
        tables = {"partner": self.topology.partners, "driven": []}
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(rolling, "LEAST_ROUNDS", least)
            patch.setattr(abreast, "LEAST", together)
            routines = Routines(program, C.term)
            sizes = replace(sizes, constants=routines.packed_from + len(routines.packed_constants))
            source = render_c(Banner(name, name, "0", "0"), routines, sizes, tables, self.topology.root, self.index)
        (self.folder / f"{name}.c").write_text(source)
        command = ["cc", *WARNINGS, "-O0", "-ffp-contract=off", "-fPIC", "-shared", f"-I{RUNTIME}", f"{name}.c"]
        command += ["-o", f"{name}.so", "-lm"]
        done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr[:3000]
        descriptor = Descriptor.in_dll(ctypes.CDLL(str(self.folder / f"{name}.so")), f"ccgen_model_{name}")
        result = Compiled(source, descriptor, np.full(sizes.constants, np.nan))
        values = np.array([p.value for p in program.parameters])
        fill = ctypes.CFUNCTYPE(None, Pointer, Pointer)(descriptor.derive_constants)
        fill(values.ctypes.data, result.constants.ctypes.data)
        return result

    def arguments(self, rng: np.random.Generator) -> tuple[Array, ...]:
        nu, rows = len(self.equations.state.u), 2 * len(self.topology.cuts)
        sizes = (nu, nu, nu, rows, len(self.equations.contacts))
        return tuple(rng.uniform(-2.0, 2.0, size) for size in sizes)


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


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no cc")
@pytest.mark.parametrize("name", LOOPED)
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
