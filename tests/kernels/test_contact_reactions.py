"""Forces of held contacts, and what joints carry with them, in random mechanisms against the dense reference.

Contacts of every kind are added to the mechanisms of ``test_random_mechanisms.py``: points and discs on rough lines,
discs that touch, stops. The reference knows no contacts: it is given what each contact does as forces and moments on
links, put together here from where the links are. If its accelerations are the model's, and no held contact moves
along the ways that are closed to it, forces, accelerations and reactions are right.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from ccgen.runtime.model.drives import drive_rows

from ..oracles import maximal, random_mechanisms, sliding
from ..oracles.maximal import GROUND, Array, turned
from ..oracles.random_mechanisms import KINDS, LOADS, Sketch
from ..support.random_mechanism_checks import BOUND, EXAMPLES, check_forces, quasi_accelerations
from ..support.tiers import all_hard_but
from ..support.workshop import Workshop

HOW = ("sticks", "smooth", "slides forward", "slides backward")
CONTACTS = ("ground", "disc", "touch", "stop")
MU = 0.3
TOUCHING = f"restitution = 0.5\nfriction = {MU}\n"


@dataclass(frozen=True)
class Spot:
    """One contact: its table, its names, and the places where it pushes, as (link, point, radius)."""

    kind: str
    table: str
    name: tuple[str, str]
    sides: tuple[tuple[int, tuple[float, float], float], ...]
    normal: tuple[float, float] = (0.0, 0.0)


def spot(sketch: Sketch, kind: str, number: int, rng: np.random.Generator) -> Spot | None:
    """A contact of the kind somewhere, or None where the mechanism has no place for it."""
    links = sorted(sketch.points)
    bodies = [k for k in links if k != GROUND]
    link = int(rng.choice(bodies))
    name, on = list(sketch.points[link].items())[int(rng.integers(len(sketch.points[link])))]
    point = f"body_{link}.{name}"
    if kind in ("ground", "disc"):
        angle, radius = float(rng.uniform(0.0, 6.0)), float(rng.uniform(0.1, 0.5)) if kind == "disc" else 0.0
        normal = (float(np.cos(angle)), float(np.sin(angle)))
        x, y = maximal.reach(sketch.poses, link, on) - (radius + 0.5) * np.array(normal)
        table = (
            f'name = "line_{number}"\npoint = [{float(x)!r}, {float(y)!r}]\nnormal = [{normal[0]!r}, {normal[1]!r}]\n'
        )
        rim = f"radius = {radius!r}\n" if radius else ""
        table += f'contacts = ["{point}"]\n{rim}{TOUCHING}'
        return Spot(kind, f"[[ground]]\n{table}", (point, f"line_{number}"), ((link, on, radius),), normal)
    if kind == "stop":
        free = [k for k, (which, _) in enumerate(sketch.kinds) if which == "pin" and k not in sketch.driven]
        if not free:
            return None
        joint = int(rng.choice(free))
        pin = sketch.pins[sketch.kinds[joint][1]]
        table = f'[[stop]]\nname = "stop_{number}"\njoint = "joint_{joint}"\nlowest = -50.0\nrestitution = 0.5\n'
        sides = ((pin.b, (0.0, 0.0), 0.0), (pin.a, (0.0, 0.0), 0.0))
        return Spot(kind, table, (f"joint_{joint}", f"stop_{number}.lowest"), sides)
    others = [k for k in bodies if k != link]
    if not others:
        return None
    other = int(rng.choice(others))
    if kind == "polygon":
        return polygon_spot(sketch, number, (link, point, on), other, rng)
    second, place = list(sketch.points[other].items())[int(rng.integers(len(sketch.points[other])))]
    radii = [float(r) for r in rng.uniform(0.01, 0.3, size=2)]
    apart = maximal.reach(sketch.poses, link, on) - maximal.reach(sketch.poses, other, place)
    if np.hypot(*apart) <= sum(radii):
        return None
    table = f'[[touch]]\nname = "touch_{number}"\nbetween = ["{point}", "body_{other}.{second}"]\n'
    table += f"radius = {radii}\n{TOUCHING}"
    return Spot(kind, table, (point, f"touch_{number}"), ((link, on, radii[0]), (other, place, radii[1])))


def polygon_spot(
    sketch: Sketch, number: int, disc: tuple[int, str, tuple[float, float]], other: int, rng: np.random.Generator
) -> Spot | None:
    """A disc before a triangle with corners of its own, which pushes at the nearest place, or None inside of it."""
    link, point, on = disc
    middle, turn = rng.uniform(-0.5, 0.5, size=2), float(rng.uniform(0.0, 6.0))
    corners = [
        (float(middle[0] + np.cos(turn + k) * 0.3), float(middle[1] + np.sin(turn + k) * 0.3)) for k in (0.0, 1.8, 3.9)
    ]
    radii = [float(r) for r in rng.uniform(0.01, 0.1, size=2)]
    centre = maximal.reach(sketch.poses, link, on)
    seen = [complex(*(maximal.reach(sketch.poses, other, corner) - centre)) for corner in corners]
    if abs(sum(np.angle(seen[k] / seen[k - 1]) for k in range(3))) > 1.0:
        return None
    feet = []
    for k in range(3):
        edge = seen[k] - seen[k - 1]
        share = float(np.clip((-seen[k - 1] / edge).real, 0.0, 1.0))
        foot = (1 - share) * np.array(corners[k - 1]) + share * np.array(corners[k])
        feet.append((abs(seen[k - 1] + share * edge), (float(foot[0]), float(foot[1]))))
    away, place = min(feet)
    if away <= sum(radii):
        return None
    names = [f"K{number}_{k}" for k in range(3)]
    sketch.points[other].update(zip(names, corners, strict=True))
    ring = ", ".join(f'"body_{other}.{name}"' for name in [*names, names[0]])
    table = f'[[touch]]\nname = "touch_{number}"\nbetween = ["{point}", [{ring}]]\nradius = {radii}\n{TOUCHING}'
    return Spot("touch", table, (point, f"touch_{number}"), ((link, on, radii[0]), (other, place, radii[1])))


def wrenches(sketch: Sketch, poses: Array, one: Spot, normal: float, friction: float) -> Array:
    """What the contact does to each link, about its centre of mass, (links, 3)."""
    found = np.zeros((len(poses), 3), poses.dtype)
    if one.kind == "stop":
        for (link, _, _), sign in zip(one.sides, (1.0, -1.0), strict=True):
            if link != GROUND:
                found[link, 2] += sign * normal
        return found
    places = [maximal.reach(poses, link, on) for link, on, _ in one.sides]
    apart = places[0] - places[1] if one.kind == "touch" else np.array(one.normal, poses.dtype)
    direction = apart / np.sqrt(apart @ apart)
    along = np.array([direction[1], -direction[0]])
    for (link, _, radius), place, sign in zip(one.sides, places, (1.0, -1.0), strict=False):
        force = sign * (normal * direction + friction * along)
        centre = poses[link, :2] + turned(poses[link, 2], sketch.com[link])
        x, y = place - sign * radius * direction - centre
        found[link] += [*force, x * force[1] - y * force[0]]
    return found


def random_sketch(rng: np.random.Generator) -> Sketch:
    """One to five links, up to two more joints, up to two loads."""
    n = int(rng.integers(1, 6))
    floats = n > 1 and bool(rng.integers(2))
    lowest = 0 if floats else GROUND
    parents = [(GROUND + 1 if k else -2) if floats else int(rng.integers(GROUND, k)) for k in range(n)]
    kinds = [str(kind) for kind in rng.choice(KINDS, size=n)]
    extra = [
        (str(rng.choice(KINDS)), int(rng.integers(lowest, n)), int(rng.integers(n))) for _ in range(rng.integers(3))
    ]
    loads = [str(load) for load in rng.choice(LOADS, size=rng.integers(3))]
    pairs = [pair for pair in extra if pair[1] != pair[2]]
    return random_mechanisms.draw(kinds, parents, pairs, loads, int(rng.integers(10**6)), bool(rng.integers(2)))


@pytest.mark.sample(2)
@pytest.mark.large(10)
@pytest.mark.parametrize("seed", all_hard_but(0, 1, 2, 3, of=range(max(4, EXAMPLES // 2))))
def test_forces_and_impulses_of_contacts_and_joints(seed: int, workshop: Workshop) -> None:
    rng = np.random.default_rng(seed)
    sketch = random_sketch(rng)
    kinds = [str(kind) for kind in rng.choice(CONTACTS, size=rng.integers(1, 4))]
    check_contacts(sketch, kinds, rng, workshop)


@pytest.mark.sample(1)
@pytest.mark.parametrize("seed", all_hard_but(1, 4, of=range(6)))
def test_forces_and_impulses_at_polygons(seed: int, workshop: Workshop) -> None:
    """Two triangles, each before a disc of another link, in a mechanism of links that turn against each other."""
    rng = np.random.default_rng(seed)
    n = 3 + seed % 2
    kinds = ["revolute", *(str(kind) for kind in rng.choice(KINDS, size=n - 1))]
    parents = [GROUND, *range(n - 1)]
    sketch = random_mechanisms.draw(kinds, parents, [], ["spring"], seed, bool(seed % 2))
    check_contacts(sketch, ["polygon", "polygon"], rng, workshop)


def check_contacts(sketch: Sketch, kinds: list[str], rng: np.random.Generator, workshop: Workshop) -> None:
    """Contacts of these kinds somewhere in the mechanism, held or struck: all forces against the reference."""
    ways = [str(way) for way in rng.choice(HOW, size=3)]
    spots = [
        found for k, kind in enumerate(kinds) if (found := spot(sketch, kind, k, rng) or spot(sketch, "disc", k, rng))
    ]
    text = sketch.toml("drawn") + "".join(one.table for one in spots)
    model = workshop.model(text)
    held = {one.name: "smooth" if one.kind == "stop" else how for one, how in zip(spots, ways, strict=False)}
    order = [next(one for one in spots if one.name == name) for name in model.contacts]
    q, _ = model.state_from_poses(sketch.poses, np.zeros_like(sketch.poses))
    q, u = model.project(q, rng.normal(size=len(q)))
    poses, velocities = model.poses(q).astype(np.longdouble), model.velocities(q, u)
    _check_impulses(model, sketch, order, q, rng)
    if not independent(model, q, held):
        return
    try:
        u_dot = model.acceleration(q, u, contacts=held)
    except ValueError as jam:
        assert "jams" in str(jam) and any("slides" in how for how in held.values())
        return
    forces = model.contact_forces(q, u, contacts=held)
    push = sum(wrenches(sketch, poses, one, *force) for one, force in zip(order, forces, strict=True))
    acting = sketch.acting(poses, velocities)
    motion = sliding.accelerate(sketch.system, sketch.slots, poses, velocities, acting.wrenches + push, sketch.given)
    wanted = quasi_accelerations(model, poses, velocities, motion.frames)
    scale = max(float(np.max(np.abs(x), initial=1.0)) for x in (motion.frames, forces))
    assert np.max(np.abs(u_dot - wanted)) <= BOUND * scale * 10.0
    _check_held(model, q, u, u_dot, held, forces, scale)
    check_forces(_With(model, held), sketch, q, u, motion)


class _With:
    """The model with contacts that are always held."""

    def __init__(self, model: Any, held: dict[tuple[str, str], str]) -> None:
        self._model, self._held = model, held

    def __getattr__(self, name: str) -> Any:
        return getattr(self._model, name)

    def reactions(self, q: Array, u: Array, contacts: object = None) -> Array:
        found: Array = self._model.reactions(q, u, contacts=self._held)
        return found


def independent(model: Any, q: Array, held: dict[tuple[str, str], str]) -> bool:
    """Whether the ways that are closed to the contacts are well away from dependent, on the joints and each other."""
    n = len(model.u_names)
    many, unit = np.repeat(q[None], n, axis=0), np.eye(n)
    rates = model.kernels.of_state("gap_rates", many, unit).T
    slips = model.kernels.of_state("slips", many, unit).T
    numbers = {contact: model.contacts.index(contact) for contact in held}
    rows = [rates[k] for k in numbers.values()] + [slips[numbers[c]] for c, how in held.items() if how == "sticks"]
    all_rows = np.vstack([model.jacobian(q), drive_rows(model), *rows])
    sizes = np.linalg.norm(all_rows, axis=1)
    if np.any(sizes < 1e-3) or len(all_rows) > n:
        return False
    return bool(np.linalg.svd(all_rows / sizes[:, None], compute_uv=False)[-1] > 0.05)


def _check_held(
    model: Any, q: Array, u: Array, u_dot: Array, held: dict[tuple[str, str], str], forces: Array, scale: float
) -> None:
    """Held contacts do not accelerate along the ways that are closed; friction is what its way says."""
    at = (q[None], u[None])
    gaps = model.kernels.of_state("gap_rates", q[None], u_dot[None])[0] + model.kernels.of_state("gap_bias", *at)[0]
    rough = "slips" if model.kernels.friction.any() else None
    for contact, how in held.items():
        k = model.contacts.index(contact)
        assert abs(gaps[k]) <= BOUND * scale * 10.0
        normal, friction = forces[k]
        if how == "sticks":
            assert rough
            slip = (
                model.kernels.of_state("slips", q[None], u_dot[None])[0] + model.kernels.of_state("slip_bias", *at)[0]
            )
            assert abs(slip[k]) <= BOUND * scale * 10.0
        else:
            sign = {"smooth": 0.0, "slides forward": -1.0, "slides backward": 1.0}[how]
            assert friction == pytest.approx(sign * MU * normal, abs=1e-15 * scale)


def _check_impulses(model: Any, sketch: Sketch, order: list[Spot], q: Array, rng: np.random.Generator) -> None:
    """Random impulses at the contacts: the impulses of the joints that go with the jump of every link."""
    poses = model.poses(q).astype(np.longdouble)
    impulses = rng.normal(size=(len(order), 2)) * [[1.0, one.kind != "stop"] for one in order]
    push = sum(wrenches(sketch, poses, one, *pair) for one, pair in zip(order, impulses, strict=True))
    jump = sliding.strike(sketch.system, sketch.slots, poses, push, sketch.given)
    still = np.zeros_like(poses)
    du = quasi_accelerations(model, poses, still, jump.frames)
    found, outcomes = model.kernels.joint_impulses(q[None], du[None], impulses.T.reshape(1, -1))
    assert outcomes == ["done"]
    check_forces(_Fixed(model, found.reshape(-1, 3)), sketch, q, du, jump)


class _Fixed:
    """The model with reactions that are given."""

    def __init__(self, model: Any, reactions: Array) -> None:
        self._model, self._reactions = model, reactions

    def __getattr__(self, name: str) -> Any:
        return getattr(self._model, name)

    def reactions(self, q: Array, u: Array, contacts: object = None) -> Array:
        return self._reactions
