"""Random mechanisms with joints of every kind and loads of every kind, drawn in the plane.

Links get frames anywhere in the plane; each hangs from an earlier one by a joint of any kind, more joints close loops,
and every joint's points are read off the drawing, so that the drawing is a closed configuration. The same numbers make
a scene's text and the dense reference.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from . import random_loads, sliding
from .loads import Acting
from .maximal import GROUND, Array, Pin, System, turned
from .sliding import Given, Meshed, Prescribed, Slot

KINDS = ("revolute", "prismatic", "pin-in-slot")
LOADS = ("spring", "damper", "torsion", "joint_friction", "drag", "force", "torque", "motor", "drive")
LAWS = random_loads.KINDS
MESHES = ("gear", "belt", "rack")
MOST_BENT = 400.0
"""Loops whose rows are nearer to dependent than this condition number are not closed."""


@dataclass
class Sketch:
    """A mechanism under construction: frames (links, 3), named points of every link, joints and loads as drawn."""

    poses: Array
    mass: Array
    inertia: Array
    com: Array
    gravity: float
    points: dict[int, dict[str, tuple[float, float]]] = field(default_factory=dict)
    tables: list[str] = field(default_factory=list)
    pins: list[Pin] = field(default_factory=list)
    slots: list[Slot] = field(default_factory=list)
    kinds: list[tuple[str, int]] = field(default_factory=list)
    loads: list[tuple[str, tuple[object, ...]]] = field(default_factory=list)
    acts: list[Callable[[Acting], None]] = field(default_factory=list, repr=False)
    given: list[Given] = field(default_factory=list)
    driven: list[int] = field(default_factory=list)
    meshed: list[Meshed] = field(default_factory=list)

    @property
    def prescribed(self) -> list[Prescribed]:
        """What drives give, then what meshes ask."""
        return [*self.given, *self.meshed]

    @property
    def system(self) -> System:
        return System(self.mass, self.inertia, self.com, tuple(self.pins), self.gravity)

    def point(self, link: int, place: Array) -> tuple[str, tuple[float, float]]:
        """The place as a point of the link: its name and where it is in the link's frame."""
        x, y = place
        if link != GROUND:
            pose = self.poses[link]
            x, y = turned(np.asarray(-pose[2]), place - pose[:2])
        named = self.points.setdefault(link, {})
        name = f"P{len(named)}"
        named[name] = (float(x), float(y))
        return f"{'ground' if link == GROUND else f'body_{link}'}.{name}", named[name]

    def angle(self, link: int) -> float:
        return 0.0 if link == GROUND else float(self.poses[link, 2])

    def join(self, kind: str, a: int, b: int, rng: np.random.Generator) -> None:
        """A joint of the given kind between two links, near both; a line through it in any direction."""
        ends = [np.zeros(2) if k == GROUND else self.poses[k, :2] for k in (a, b)]
        place = (ends[0] + ends[1]) / 2 + rng.uniform(-0.5, 0.5, 2)
        name = f"joint_{len(self.kinds)}"
        if kind == "revolute":
            one, other = self.point(a, place), self.point(b, place)
            self.pins.append(Pin(a, one[1], b, other[1]))
            self.kinds.append(("pin", len(self.pins) - 1))
            self.tables.append(f'[[joint]]\nname = "{name}"\nbetween = ["{one[0]}", "{other[0]}"]')
            return
        along = rng.uniform(-3.0, 3.0)
        direction = np.array([np.cos(along), np.sin(along)])
        one, other = self.point(a, place - rng.uniform(-0.6, 0.6) * direction), self.point(b, place)
        axis = along - self.angle(a)
        held = self.angle(b) - self.angle(a) if kind == "prismatic" else None
        self.slots.append(Slot(a, one[1], axis, b, other[1], held))
        self.kinds.append(("slot", len(self.slots) - 1))
        text = f'[[joint]]\nname = "{name}"\ntype = "{kind}"\naxis = {axis!r}\nbetween = ["{one[0]}", "{other[0]}"]'
        self.tables.append(text + (f"\nangle = {held!r}" if held is not None else ""))

    def slid(self, slot: Slot) -> float:
        """How far along its line the slot is in the drawing."""
        ends = [
            np.asarray(on) if k == GROUND else self.poses[k, :2] + turned(self.poses[k, 2], on)
            for k, on in ((slot.a, slot.on_a), (slot.b, slot.on_b))
        ]
        along = self.angle(slot.a) + slot.axis
        return float((ends[1] - ends[0]) @ np.array([np.cos(along), np.sin(along)]))

    def unjoin(self) -> None:
        """Take the last joint away again."""
        kind, _ = self.kinds.pop()
        (self.pins if kind == "pin" else self.slots).pop()
        self.tables.pop()

    def load(self, kind: str, rng: np.random.Generator) -> None:
        """A load of the given kind, somewhere."""
        links = len(self.poses)
        first = int(rng.integers(links))
        second = int(rng.choice([k for k in range(-1, links) if k != first]))
        joint = int(rng.integers(len(self.kinds)))
        size, more = (float(x) for x in rng.uniform(0.5, 3.0, 2))
        slides, index = self.kinds[joint][0] == "slot", self.kinds[joint][1]
        if kind in ("spring", "damper", "drag", "force"):
            ends = [
                self.point(k, (0 if k < 0 else self.poses[k, :2]) + rng.uniform(-0.7, 0.7, 2)) for k in (first, second)
            ]
            places = tuple((k, end[1]) for k, end in zip((first, second), ends, strict=True))
        if kind == "spring":
            text = f'[[spring]]\nbetween = ["{ends[0][0]}", "{ends[1][0]}"]\nstiffness = {size!r}\nlength = {more!r}'
            self.loads.append((kind, (*places, size, more)))
        elif kind == "damper":
            text = f'[[damper]]\nbetween = ["{ends[0][0]}", "{ends[1][0]}"]\ndamping = {size!r}'
            self.loads.append((kind, (*places, size)))
        elif kind == "drag":
            text = f'[[drag]]\npoint = "{ends[0][0]}"\nlinear = {size!r}'
            self.loads.append((kind, (places[0], size)))
        elif kind == "force":
            text = f'[[force]]\npoint = "{ends[0][0]}"\nvector = [{size!r}, {more!r}]'
            self.loads.append((kind, (places[0], (size, more))))
        elif kind == "torque":
            text = f'[[torque]]\nlink = "body_{first}"\ntorque = {size!r}'
            self.loads.append((kind, (first, size)))
        elif kind == "torsion" and not slides:
            pin = self.pins[index]
            text = f'[[torsion]]\njoint = "joint_{joint}"\nstiffness = {size!r}\nangle = {more!r}\ndamping = 0.3'
            self.loads.append((kind, (pin.a, pin.b, size, more, 0.3)))
        elif kind == "joint_friction":
            text = f'[[joint_friction]]\njoints = ["joint_{joint}"]\nviscous = {size!r}\ndry = {more!r}\nrate = 0.5'
            self.loads.append((f"{kind} {self.kinds[joint][0]}", (index, size, more, 0.5)))
        elif kind == "motor":
            text = f'[[motor]]\njoint = "joint_{joint}"\n{"force" if slides else "torque"} = {size!r}'
            self.loads.append((f"{kind} {self.kinds[joint][0]}", (index, size)))
        elif kind == "drive" and self._drive(joint, more):
            text = f'[[drive]]\njoint = "joint_{joint}"\nspeed = "{size!r} + {more!r}*t"'
        else:
            return
        self.tables.append(text)

    def _drive(self, joint: int, acceleration: float) -> bool:
        """Prescribe the joint's motion, unless it is a pin in a slot or the rows would depend on each other."""
        kind, index = self.kinds[joint]
        ends = self.pins[index] if kind == "pin" else self.slots[index]
        slot = ends if isinstance(ends, Slot) else None
        if joint in self.driven or (slot and slot.angle is None):
            return False
        self.given.append(Given(ends.a, ends.b, acceleration, slot))
        freedoms = sliding.freedoms(self.system, self.slots, self.prescribed)
        if freedoms < 0 or sliding.conditioning(self.system, self.slots, self.poses, self.prescribed) > MOST_BENT:
            self.given.pop()
            return False
        self.driven.append(joint)
        return True

    def acting(self, poses: Array, velocities: Array) -> Acting:
        """Wrenches of all loads at a state."""
        found = Acting(self.system, poses, velocities)
        for kind, data in self.loads:
            _ACT[kind](self, found, *data)
        for act in self.acts:
            act(found)
        return found

    def slide_speed(self, acting: Acting, index: int) -> Any:
        """How fast a slot's second point moves along its line."""
        return _slide_speed(self, acting, index)

    def slide_effort(self, acting: Acting, index: int, effort: Any) -> None:
        """A force along a slot's line on the second link, and the opposite on the first."""
        _slide_effort(self, acting, index, effort)

    def toml(self, name: str) -> str:
        """The scene's text; floats are written so that they read back equal."""
        lines = [f'name = "{name}"', "[start]", f"angles = {[float(a) for a in self.poses[:, 2]]}"]
        if self.meshed and self.slots:  # wheels mesh as they stand in the drawing
            slid = {joint: self.slid(self.slots[k]) for joint, (kind, k) in enumerate(self.kinds) if kind == "slot"}
            lengths = ", ".join(f"joint_{joint} = {length!r}" for joint, length in slid.items())
            lines.append(f"slides = {{ {lengths} }}")
        if not any(GROUND in (pin.a, pin.b) for pin in (*self.pins, *self.slots)):
            lines.append(f"position = {[float(p) for p in self.poses[0, :2]]}")
        if self.gravity:
            lines += ["[gravity]", f"g = {self.gravity!r}"]
        if GROUND in self.points:
            lines += ["[ground_link]", f"points = {{ {_listed(self.points[GROUND])} }}"]
        for k in range(len(self.poses)):
            lines += ["[[link]]", f'name = "body_{k}"', f"mass = {float(self.mass[k])!r}"]
            lines += [f"inertia = {float(self.inertia[k])!r}", f"com = {[float(c) for c in self.com[k]]}"]
            lines += [f"points = {{ {_listed(self.points.get(k) or {'P0': (0.3, 0.1)})} }}"]
        return "\n".join([*lines, *self.tables]) + "\n"


def _listed(points: dict[str, tuple[float, float]]) -> str:
    return ", ".join(f"{name} = [{x!r}, {y!r}]" for name, (x, y) in points.items())


def _slide_effort(sketch: Sketch, acting: Acting, index: int, effort: float) -> None:
    """A force along a slot's line on the second point, and the opposite at the same place on the first link."""
    slot = sketch.slots[index]
    along = turned(np.asarray(sketch.system.dtype(slot.axis) + _own(acting, slot.a)), (1.0, 0.0))
    acting.push((slot.b, slot.on_b), effort * along)
    if slot.a != GROUND:
        there = acting.at((slot.b, slot.on_b))[0]
        arm = there - acting.poses[slot.a, :2] - turned(acting.poses[slot.a, 2], sketch.com[slot.a])
        acting.wrenches[slot.a] -= (*(effort * along), effort * (arm[0] * along[1] - arm[1] * along[0]))


def _shared(one: Pin | Slot, other: Pin | Slot) -> tuple[int, int, int] | None:
    """The only link of both joints, and the other link of each; ``None`` if they share none or both."""
    common = {one.a, one.b} & {other.a, other.b}
    if len(common) != 1:
        return None
    (carrier,) = common
    return carrier, one.a + one.b - carrier, other.a + other.b - carrier


def _mesh(sketch: Sketch, kind: str, rng: np.random.Generator) -> None:
    """Wheels that mesh, on two joints that share a link, unless the rows would depend on each other."""
    joints = [
        (joint, (sketch.pins if kind == "pin" else sketch.slots)[index])
        for joint, (kind, index) in enumerate(sketch.kinds)
    ]
    pins = [(joint, pin) for joint, pin in joints if isinstance(pin, Pin)]
    seconds = [(j, s) for j, s in joints if isinstance(s, Slot) and s.angle is not None] if kind == "rack" else pins
    pairs = [
        (one, other, found)
        for one in pins
        for other in seconds
        if one[0] != other[0] and (found := _shared(one[1], other[1])) is not None
    ]
    if not pairs:
        return
    (first, pin), (second, other), (carrier, wheel, far) = pairs[int(rng.integers(len(pairs)))]
    size, more = (float(x) for x in rng.uniform(0.3, 2.0, 2))
    flip = bool(rng.random() < 0.5)
    named = "ground" if carrier == GROUND else f"body_{carrier}"
    turning = Given(carrier, wheel, 0.0)
    if kind == "rack":
        assert isinstance(other, Slot)
        sign = (-1.0 if flip else 1.0) * (1.0 if other.a == carrier else -1.0)
        parts = ((size, turning), (-sign, Given(other.a, other.b, 0.0, other)))
        text = f'[[rack]]\npinion = "joint_{first}"\nslide = "joint_{second}"\nradius = {size!r}'
        text += "\nreverse = true" if flip else ""
    else:
        text = f'[[{kind}]]\njoints = ["joint_{first}", "joint_{second}"]\ncarrier = "{named}"\n'
        sign = (1.0 if flip else -1.0) if kind == "belt" else (-1.0 if flip else 1.0)
        if kind == "belt":
            text += f"radii = [{size!r}, {more!r}]" + ("\ncrossed = true" if flip else "")
        else:
            ends = [p.on_a if p.a == carrier else p.on_b for p in (pin, other)]
            apart = float(np.hypot(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]))
            share = abs(1.0 - more) if flip else 1.0 + more
            size, more = apart / share, apart / share * more
            text += f"ratio = {more / size!r}" + ("\ninternal = true" if flip else "")
        parts = ((size, turning), (sign * more, Given(carrier, far, 0.0)))
    sketch.meshed.append(Meshed(parts))
    freedoms = sliding.freedoms(sketch.system, sketch.slots, sketch.prescribed)
    if freedoms < 1 or sliding.conditioning(sketch.system, sketch.slots, sketch.poses, sketch.prescribed) > MOST_BENT:
        sketch.meshed.pop()
        return
    sketch.tables.append(text)


def _own(acting: Acting, link: int) -> float:
    return 0.0 if link == GROUND else acting.poses[link, 2]


def _slide_speed(sketch: Sketch, acting: Acting, index: int) -> float:
    slot = sketch.slots[index]
    along = turned(np.asarray(sketch.system.dtype(slot.axis) + _own(acting, slot.a)), (1.0, 0.0))
    (pa, va), (pb, vb) = acting.at((slot.a, slot.on_a)), acting.at((slot.b, slot.on_b))
    spin = 0.0 if slot.a == GROUND else acting.velocities[slot.a, 2]
    apart = pb - pa
    return along @ (vb - va - spin * np.array([-apart[1], apart[0]]))


def _slide_friction(sketch: Sketch, acting: Acting, index: int, viscous: float, dry: float, about: float) -> None:
    rate = _slide_speed(sketch, acting, index)
    effort = -viscous * rate - dry * np.tanh(rate / about)
    _slide_effort(sketch, acting, index, effort)
    acting.power += effort * rate


def _pin_friction(sketch: Sketch, acting: Acting, index: int, viscous: float, dry: float, about: float) -> None:
    pin = sketch.pins[index]
    acting.friction(pin.a, pin.b, viscous, dry, about)


def _turn_torque(sketch: Sketch, acting: Acting, link: int, torque: float) -> None:
    acting.wrenches[link, 2] += torque
    acting.power += torque * acting.velocities[link, 2]


def _push(sketch: Sketch, acting: Acting, place: tuple[int, tuple[float, float]], force: tuple[float, float]) -> None:
    acting.push(place, np.asarray(force, sketch.system.dtype))
    acting.power += np.asarray(force) @ acting.at(place)[1]


def _pin_motor(sketch: Sketch, acting: Acting, index: int, torque: float) -> None:
    pin = sketch.pins[index]
    acting.twist(pin.a, pin.b, torque)
    spins = [0.0 if k == GROUND else acting.velocities[k, 2] for k in (pin.a, pin.b)]
    acting.power += torque * (spins[1] - spins[0])


def _slide_motor(sketch: Sketch, acting: Acting, index: int, force: float) -> None:
    _slide_effort(sketch, acting, index, force)
    acting.power += force * _slide_speed(sketch, acting, index)


_ACT = {
    "spring": lambda sketch, acting, *data: acting.spring(*data),
    "damper": lambda sketch, acting, *data: acting.damper(*data),
    "torsion": lambda sketch, acting, *data: acting.torsion(*data),
    "drag": lambda sketch, acting, place, linear: acting.drag(place, linear, 0.0, 1.0),
    "joint_friction pin": _pin_friction,
    "joint_friction slot": _slide_friction,
    "torque": _turn_torque,
    "force": _push,
    "motor pin": _pin_motor,
    "motor slot": _slide_motor,
}


def draw(
    kinds: Sequence[str],
    parents: Sequence[int],
    extra: Sequence[tuple[str, int, int]],
    loads: Sequence[str],
    seed: int,
    gravity: bool = True,
) -> Sketch:
    """A mechanism of ``len(kinds)`` links.

    Link k hangs by a joint of ``kinds[k]`` from ``parents[k]``, an earlier link or the ground; link 0 floats if its
    parent is not the ground. ``extra`` joints close loops, left out where their rows depend on the others. Odd seeds
    turn joints round: the later link is then the first one.
    """
    rng, n = np.random.default_rng(seed), len(kinds)
    poses = np.column_stack([rng.uniform(-1.5, 1.5, (n, 2)), rng.uniform(-3.0, 3.0, n)])
    mass = rng.uniform(0.5, 2.0, n)
    sketch = Sketch(
        poses, mass, mass * rng.uniform(0.06, 0.2, n), rng.uniform(-0.3, 0.3, (n, 2)), 9.81 if gravity else 0.0
    )
    for k, (kind, parent) in enumerate(zip(kinds, parents, strict=True)):
        if k or parent == GROUND:
            sketch.join(kind, *_order(parent, k, rng), rng)
    for kind, a, b in extra:
        sketch.join(kind, *_order(a, b, rng), rng)
        freedoms = sliding.freedoms(sketch.system, sketch.slots)
        if freedoms < 1 or sliding.conditioning(sketch.system, sketch.slots, poses) > MOST_BENT:
            sketch.unjoin()
    for kind in loads:
        if kind in MESHES:
            _mesh(sketch, kind, rng)
        elif kind in LAWS:
            random_loads.add(sketch, kind, rng)
        elif sketch.kinds or kind not in ("joint_friction", "motor", "torsion", "drive"):
            sketch.load(kind, rng)
    return sketch


def _order(a: int, b: int, rng: np.random.Generator) -> tuple[int, int]:
    return (a, b) if rng.random() < 0.5 else (b, a)
