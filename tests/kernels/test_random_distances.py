"""Random mechanisms with ropes, journals in bearings and slots, and cams drawn in, against the dense reference.

The reference (``tests/oracles/distances.py`` and ``cams.py``) knows gaps as true distances, in maximal coordinates, and
takes their rows and biases by differences in wide numbers.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ..oracles import distances, random_mechanisms, sliding
from ..oracles.cams import Face, Roller, Shape
from ..oracles.distances import Journal, Rope
from ..oracles.maximal import GROUND, WIDE, Array
from ..oracles.random_mechanisms import KINDS, LOADS, MOST_BENT, Sketch
from ..support.random_mechanism_checks import BOUND, FEW, check_forces, quasi_accelerations
from ..support.workshop import Workshop

PARTS = ("rope", "rope over eyelets", "bearing", "slot", "slot's end")
CAMS = ("roller", "knife edge", "face")
FRICTION = 0.3
RESTITUTION = 0.4


@dataclass
class Drawn:
    """A sketch with parts: what the reference holds, whether each may rub, and its contact in the model."""

    sketch: Sketch
    parts: list[Any] = field(default_factory=list)
    contacts: list[tuple[str, str]] = field(default_factory=list)

    def add(self, kind: str, rng: np.random.Generator) -> None:
        """A part of the kind that is just taut or in touch, unless its rows would depend on the others'."""
        tables, points = len(self.sketch.tables), {k: dict(named) for k, named in self.sketch.points.items()}
        draw = self._rope if "rope" in kind else self._cam if kind in CAMS else self._journal
        draw(kind, rng)
        if self._bent():
            del self.sketch.tables[tables:]
            self.sketch.points = points
            self.parts.pop()
            self.contacts.pop()

    def toml(self) -> str:
        """The scene's text, started as it is drawn, its sliding joints too."""
        poses = ", ".join(f"body_{k} = {[float(x) for x in pose]}" for k, pose in enumerate(self.sketch.poses))
        lines = self.sketch.toml("random-distances").splitlines()
        drawn = [f"poses = {{ {poses} }}" if line.startswith("angles = ") else line for line in lines]
        return "\n".join(line for line in drawn if not line.startswith("position = ")) + "\n"

    def _bent(self) -> bool:
        """Whether there are too many rows, or such as all but depend on each other, those of all slips included."""
        sketch, still = self.sketch, np.zeros_like(self.sketch.poses)
        rough = [not isinstance(part, Rope) for part in self.parts]
        held = distances.rows_of(sketch.system, self.parts, rough, sketch.poses, still).rows
        if sliding.freedoms(sketch.system, sketch.slots, sketch.given) < len(held):
            return True
        joints = sliding._rows(sketch.system, sketch.slots, sketch.poses.astype(WIDE), still.astype(WIDE), sketch.given)
        system = sketch.system
        inertias = np.stack([system.mass, system.mass, system.inertia], axis=1).ravel()
        rows = np.vstack([joints.jacobian.reshape(-1, 3 * system.size), held]).astype(float) / np.sqrt(inertias)
        values = np.linalg.svd(rows / np.linalg.norm(rows, axis=1)[:, None], compute_uv=False)
        return bool(values[0] ** 2 > MOST_BENT * values[-1] ** 2)

    def _place(self, link: int, rng: np.random.Generator) -> Array:
        return (np.zeros(2) if link == GROUND else self.sketch.poses[link, :2]) + rng.uniform(-0.8, 0.8, 2)

    def _two(self, rng: np.random.Generator) -> tuple[int, int]:
        links = len(self.sketch.poses)
        first = int(rng.integers(links))
        return first, int(rng.choice([k for k in range(-1, links) if k != first]))

    def _rope(self, kind: str, rng: np.random.Generator) -> None:
        links = list(self._two(rng))
        if "over" in kind:
            links[1:1] = [int(k) for k in rng.integers(-1, len(self.sketch.poses), int(rng.integers(1, 4)))]
        places = [self._place(link, rng) for link in links]
        names, points = zip(
            *[self.sketch.point(link, place) for link, place in zip(links, places, strict=True)], strict=True
        )
        length = float(sum(np.hypot(*(b - a)) for a, b in pairwise(places)))
        name = f"rope_{len(self.parts)}"
        over = ", ".join(f'"{one}"' for one in names[1:-1])
        self.sketch.tables.append(
            f'[[rope]]\nname = "{name}"\nbetween = ["{names[0]}", "{names[-1]}"]\nover = [{over}]\n'
            f"length = {length!r}\nrestitution = {RESTITUTION}"
        )
        self.parts.append(Rope(tuple(zip(links, points, strict=True)), length))
        self.contacts.append((names[-1], name))

    def _journal(self, kind: str, rng: np.random.Generator) -> None:
        a, b = self._two(rng)
        if rng.random() < 0.5:
            a, b = b, a
        place, turn = self._place(a, rng), np.exp(1j * rng.uniform(-3.0, 3.0))
        clearance, radius = float(rng.uniform(0.05, 0.3)), float(rng.uniform(0.01, 0.2))
        off = np.array([turn.real, turn.imag])
        foot, along = place - clearance * off, np.array([-off[1], off[0]])
        if kind == "slot's end":
            along = along + 0.5 * off  # so that the nearest point is the end
        ends = [foot] if kind == "bearing" else [foot - along * (kind == "slot") * 0.4, foot - along * 0.9]
        if kind == "slot":
            ends[1] = foot + along * 0.7
        name = f"journal_{len(self.parts)}"
        pin, holes = self.sketch.point(a, place), [self.sketch.point(b, end) for end in ends]
        listed = ", ".join(f'"{hole[0]}"' for hole in holes)
        self.sketch.tables.append(
            f'[[journal]]\nname = "{name}"\nbetween = ["{pin[0]}", {listed if len(holes) == 1 else f"[{listed}]"}]\n'
            f"radius = {radius!r}\nclearance = {clearance!r}\nrestitution = {RESTITUTION}\nfriction = {FRICTION}"
        )
        self.parts.append(Journal((a, pin[1]), ((b, holes[0][1]), (b, holes[-1][1])), radius, clearance))
        self.contacts.append((pin[0], name))

    def _cam(self, kind: str, rng: np.random.Generator) -> None:
        """A cam that its follower touches: with a roller, or a point, it may be hollow, with a face it is convex."""
        a, b = self._two(rng)
        if rng.random() < 0.5:
            a, b = b, a
        base, radius = float(rng.uniform(0.2, 0.5)), float(rng.uniform(0.02, 0.08)) if kind == "roller" else 0.0
        times, sense = int(rng.integers(1, 4)), int(rng.choice([-1, 1]))
        size = float(rng.uniform(0.2, 0.5)) * base / times**2
        mounted, shift = (float(x) for x in rng.uniform(-2.0, 2.0, 2))
        shape = Shape(base + radius, size, times, shift, mounted, sense)
        centre, seen = self._place(b, rng), float(rng.uniform(-3.0, 3.0))
        turned = 0.0 if b == GROUND else float(self.sketch.poses[b, 2])
        far = float(shape.at(seen - turned)[0])
        name = f"cam_{len(self.parts)}"
        e = np.array([np.cos(seen), np.sin(seen)])
        touching = centre + far * e
        cam = self.sketch.point(b, centre)
        if kind == "face":
            along = np.array([-e[1], e[0]]) * rng.choice([-1.0, 1.0])
            ends = [self.sketch.point(a, touching + s * along) for s in (-1.5, 1.2)]
            follower = f'["{ends[0][0]}", "{ends[1][0]}"]'
            self.parts.append(Face((b, cam[1]), ((a, ends[0][1]), (a, ends[1][1])), shape))
            self.contacts.append((cam[0], name))
        else:
            disc = self.sketch.point(a, touching)
            follower = f'"{disc[0]}"\nradius = {radius!r}'
            self.parts.append(Roller((b, cam[1]), (a, disc[1]), radius, shape))
            self.contacts.append((disc[0], name))
        self.sketch.tables.append(
            f'[[cam]]\nname = "{name}"\ncentre = "{cam[0]}"\nfollower = {follower}\nbase = {base!r}\n'
            f'lift = "{shape.text()}"\nangle = {mounted!r}\nclockwise = {"true" if sense < 0 else "false"}\n'
            f"restitution = {RESTITUTION}\nfriction = {FRICTION}"
        )


@st.composite
def drawings(choose: st.DrawFn, among: tuple[str, ...] = PARTS) -> Drawn:
    """One to five links, up to two more joints, two loads, and one to three parts."""
    n = choose(st.integers(1, 5))
    kinds = choose(st.lists(st.sampled_from(KINDS), min_size=n, max_size=n))
    parents = [choose(st.integers(GROUND, k - 1)) for k in range(n)]
    if choose(st.booleans()) and n > 1:
        parents = [GROUND + 1 if k else -2 for k in range(n)]  # floats
    lowest = 0 if parents[0] < GROUND else GROUND
    pairs = st.tuples(st.sampled_from(KINDS), st.integers(lowest, n - 1), st.integers(0, n - 1))
    extra = [pair for pair in choose(st.lists(pairs, max_size=2)) if pair[1] != pair[2]]
    loads = choose(st.lists(st.sampled_from(LOADS), max_size=2))
    seed = choose(st.integers(0, 10**6))
    drawn = Drawn(random_mechanisms.draw(kinds, parents, extra, loads, seed, choose(st.booleans())))
    rng = np.random.default_rng(seed + 1)
    for kind in choose(st.lists(st.sampled_from(among), min_size=1, max_size=3)):
        drawn.add(kind, rng)
    return drawn


def _unit_rows(model: Any, kernel: str, q: Array) -> Array:
    unit = np.eye(len(model.u_names))
    return np.asarray(model.kernels.of_state(kernel, np.repeat(q[None], len(unit), axis=0), unit).T)


def check(drawn: Drawn, workshop: Workshop) -> None:
    """With all parts held, ropes taut and journals sticking or sliding: accelerations, forces of contacts and joints.
    Then a smooth impact of each part alone."""
    if not drawn.parts:
        return
    sketch = drawn.sketch
    model = workshop.model(drawn.toml())
    order = [model.contacts.index(contact) for contact in drawn.contacts]
    q, _ = model.state_from_poses(sketch.poses, np.zeros_like(sketch.poses))
    assert np.max(np.abs(model.gaps(q))) <= 1e-14 * max(1.0, np.abs(sketch.poses).max())
    rng = np.random.default_rng(5)
    normals = _unit_rows(model, "gap_rates", q)[order]
    rough = [not isinstance(part, Rope) for part in drawn.parts]
    sticking = [bool(rub and rng.random() < 0.5) for rub in rough]
    tangents = _unit_rows(model, "slips", q)[order] if any(rough) else np.zeros_like(normals)
    closure = model.jacobian(q)
    rows = np.vstack([closure, normals, tangents[sticking]])
    u = rng.normal(size=len(q))
    for _ in range(2):
        u -= np.linalg.lstsq(rows, rows @ u, rcond=None)[0]
    ways = [
        None if s else float(np.sign(t @ u)) if r else 0.0 for s, r, t in zip(sticking, rough, tangents, strict=True)
    ]
    words = {None: "sticks", 1.0: "slides forward", -1.0: "slides backward", 0.0: "smooth"}
    held = {contact: words[way] for contact, way in zip(drawn.contacts, ways, strict=True)}
    poses, velocities = model.poses(q), model.velocities(q, u)
    acting = sketch.acting(poses, velocities)
    friction = [FRICTION if r else 0.0 for r in rough]
    wanted = distances.accelerate(sketch, poses, velocities, acting.wrenches, drawn.parts, ways, friction)
    if wanted.sign <= 0.0:
        with pytest.raises(ValueError, match="friction jams"):
            model.acceleration(q, u, contacts=held)
        return
    motion, forces = wanted.motion, wanted.forces
    scale = max(float(np.max(np.abs(motion.frames))), float(np.max(np.abs(forces))), 1.0)
    found = model.acceleration(q, u, contacts=held)
    assert np.max(np.abs(found - quasi_accelerations(model, poses, velocities, motion.frames))) <= BOUND * scale
    assert np.max(np.abs(model.contact_forces(q, u, contacts=held)[order] - forces)) <= 10.0 * BOUND * scale
    check_forces(model, sketch, q, u, motion, held)
    if not sketch.given:
        _check_impacts(drawn, model, q, closure, normals, rng)


def _check_impacts(
    drawn: Drawn, model: Any, q: Array, closure: Array, normals: Array, rng: np.random.Generator
) -> None:
    smooth = model.with_parameters(
        {f"{name}.friction": 0.0 for _, name in drawn.contacts if not name.startswith("rope")}
    )
    for part, contact, normal in zip(drawn.parts, drawn.contacts, normals, strict=True):
        u = rng.normal(size=len(q))
        if len(closure):
            u -= np.linalg.lstsq(closure, closure @ u, rcond=None)[0]
        u *= -np.sign(normal @ u)
        after, impulse = smooth.impact(q, u, [contact])
        velocities, wanted = distances.strike(drawn.sketch, model.poses(q), model.velocities(q, u), part, RESTITUTION)
        scale = max(float(np.max(np.abs(velocities))), float(abs(wanted)), 1.0)
        assert np.max(np.abs(model.velocities(q, after) - velocities)) <= BOUND * scale
        assert abs(impulse[0] - wanted) <= BOUND * scale


DRAWN = settings(
    derandomize=True,
    deadline=None,
    database=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture, HealthCheck.data_too_large],
)


@settings(DRAWN, max_examples=FEW)
@given(drawn=drawings(CAMS))
def test_a_few_cams_are_those_of_the_dense_reference(drawn: Drawn, workshop: Workshop) -> None:
    check(drawn, workshop)


@pytest.mark.hard
@settings(DRAWN, max_examples=60)
@given(drawn=drawings(CAMS))
def test_cams_are_those_of_the_dense_reference(drawn: Drawn, workshop: Workshop) -> None:
    check(drawn, workshop)


@settings(DRAWN, max_examples=FEW)
@given(drawn=drawings())
def test_a_few_ropes_and_journals_are_those_of_the_dense_reference(drawn: Drawn, workshop: Workshop) -> None:
    check(drawn, workshop)


@pytest.mark.hard
@settings(DRAWN, max_examples=60)
@given(drawn=drawings())
def test_ropes_and_journals_are_those_of_the_dense_reference(drawn: Drawn, workshop: Workshop) -> None:
    check(drawn, workshop)
