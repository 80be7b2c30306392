"""Mechanisms drawn in the plane with whatever may touch or hold drawn in: ropes, journals, cams, grounds, discs,
edges, polygons and stops, as tables of a scene and as parts of the dense reference (``tests/oracles/distances.py``)."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from hypothesis import strategies as st

from ..oracles import distances, random_mechanisms, sliding
from ..oracles.cams import Face, Roller, Shape
from ..oracles.distances import Above, Beside, Journal, Limit, Rope, SlideEnd
from ..oracles.maximal import GROUND, WIDE, Array
from ..oracles.random_mechanisms import KINDS, LAWS, LOADS, MESHES, MOST_BENT, Sketch

DISTANCES = ("rope", "rope over eyelets", "bearing", "slot", "slot's end")
CAMS = ("roller", "knife edge", "face")
TOUCHES = ("ground", "disc", "edge", "edge's end", "line", "polygon", "stop", "slide end")
FRICTION = 0.3
RESTITUTION = 0.4


def rubs(part: Any) -> bool:
    """Whether friction acts on it."""
    return isinstance(part, Journal | Above | Beside | Roller | Face)


class Drawn:
    """A sketch with parts: what the reference holds, and its contact in the model. Gaps are ``slack`` (m, rad) at the
    start."""

    def __init__(self, sketch: Sketch, slack: float = 0.0) -> None:
        self.sketch = sketch
        self.slack = slack
        self.parts: list[Any] = []
        self.contacts: list[tuple[str, str]] = []

    def add(self, kind: str, rng: np.random.Generator) -> None:
        """A part of the kind that is just taut or in touch, unless its rows would
        depend on those of others; with slack whatever is drawn."""
        tables, points = len(self.sketch.tables), {k: dict(named) for k, named in self.sketch.points.items()}
        adds = {"rope": self._rope, "stop": self._stop, "slide end": self._slide_end, "ground": self._ground}
        journals = dict.fromkeys(("bearing", "slot", "slot's end"), self._journal)
        cams = dict.fromkeys(CAMS, self._cam)
        (adds | {"rope over eyelets": self._rope} | journals | cams).get(kind, self._touch)(kind, rng)
        if len(self.sketch.tables) == tables:
            return
        if not self.slack and self._bent():
            del self.sketch.tables[tables:]
            self.sketch.points = points
            self.parts.pop()
            self.contacts.pop()

    def __repr__(self) -> str:
        kinds = ", ".join(one.partition("]]")[0].strip("[") for one in self.sketch.tables)
        return f"<{len(self.sketch.poses)} links and {kinds}>"

    def toml(self) -> str:
        """The scene's text, started as it is drawn, its sliding joints too."""
        poses = ", ".join(f"body_{k} = {[float(x) for x in pose]}" for k, pose in enumerate(self.sketch.poses))
        lines = self.sketch.toml("random-distances").splitlines()
        drawn = [f"poses = {{ {poses} }}" if line.startswith("angles = ") else line for line in lines]
        return "\n".join(line for line in drawn if not line.startswith("position = ")) + "\n"

    def _bent(self) -> bool:
        """Whether there are too many rows, or such as all but depend on each other, those of all slips included."""
        sketch, still = self.sketch, np.zeros_like(self.sketch.poses)
        rough = [rubs(part) for part in self.parts]
        held = distances.rows_of(sketch.system, self.parts, rough, sketch.poses, still).rows
        if sliding.freedoms(sketch.system, sketch.slots, sketch.prescribed) < len(held):
            return True
        joints = sliding._rows(
            sketch.system, sketch.slots, sketch.poses.astype(WIDE), still.astype(WIDE), sketch.prescribed
        )
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
        length += self.slack
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
        foot, along = place - (clearance - self.slack) * off, np.array([-off[1], off[0]])
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

    def _two_apart(self, rng: np.random.Generator) -> tuple[int, int, Array, Array, Array]:
        """Two links, a place near the first, a normal towards it, and the direction along the surface."""
        a, b = self._two(rng)
        if rng.random() < 0.3:
            a, b = b, a
        turn = rng.uniform(-3.0, 3.0)
        normal = np.array([np.cos(turn), np.sin(turn)])
        return a, b, self._place(a, rng), normal, np.array([normal[1], -normal[0]])

    def _ground(self, kind: str, rng: np.random.Generator) -> None:
        link = int(rng.integers(len(self.sketch.poses)))
        place, turn, radius = self._place(link, rng), rng.uniform(-3.0, 3.0), float(rng.uniform(0.0, 0.3))
        normal = np.array([np.cos(turn), np.sin(turn)])
        foot, name = place - (radius + self.slack) * normal, f"ground_{len(self.parts)}"
        point = self.sketch.point(link, place)
        self.sketch.tables.append(
            f'[[ground]]\nname = "{name}"\npoint = {foot.tolist()}\nnormal = {normal.tolist()}\n'
            f'contacts = ["{point[0]}"]\nradius = {radius!r}\nrestitution = {RESTITUTION}\nfriction = {FRICTION}'
        )
        self.parts.append(Above((link, point[1]), radius, (foot[0], foot[1]), (normal[0], normal[1])))
        self.contacts.append((point[0], name))

    def _touch(self, kind: str, rng: np.random.Generator) -> None:
        """A disc that touches a disc, an edge beside it or at its end, a polygon, or the first edge of a line."""
        a, b, place, normal, along = self._two_apart(rng)
        radius, other = (float(r) for r in rng.uniform(0.05, 0.2, 2))
        foot, name = place - (radius + other + self.slack) * normal, f"touch_{len(self.parts)}"
        ways = {
            "disc": [foot],
            "edge": [foot - 0.4 * along, foot + 0.5 * along],
            "edge's end": [foot, foot + 0.6 * along - 0.3 * normal],
            "line": [foot - 0.4 * along, foot + 0.5 * along, foot + 0.9 * along - 0.6 * normal],
            "polygon": [
                *(foot - 0.4 * along, foot + 0.5 * along),
                *(foot + 0.3 * along - 0.5 * normal, foot - 0.3 * along - 0.6 * normal),
            ],
        }
        centre = self.sketch.point(a, place)
        corners = [self.sketch.point(b, corner) for corner in ways[kind]]
        names = [corner[0] for corner in (*corners, *(corners[:1] if kind == "polygon" else []))]
        second = f'"{names[0]}"' if kind == "disc" else str(names).replace("'", '"')
        self.sketch.tables.append(
            f'[[touch]]\nname = "{name}"\nbetween = ["{centre[0]}", {second}]\nradius = [{radius!r}, {other!r}]\n'
            f"restitution = {RESTITUTION}\nfriction = {FRICTION}"
        )
        ends = (b, corners[0][1]), (b, corners[1 if len(corners) > 1 else 0][1])
        self.parts.append(Beside((a, centre[1]), ends, radius, other))
        piece = "-".join(one.rpartition(".")[2] for one in names[:2])
        self.contacts.append((centre[0], f"{name}.{piece}" if kind == "line" else name))

    def _stop(self, kind: str, rng: np.random.Generator) -> None:
        """At a pin, if there is one."""
        pins = [(joint, index) for joint, (how, index) in enumerate(self.sketch.kinds) if how == "pin"]
        if not pins:
            return
        joint, index = pins[int(rng.integers(len(pins)))]
        pin, sign = self.sketch.pins[index], int(rng.choice([-1, 1]))
        limit = self.sketch.angle(pin.b) - self.sketch.angle(pin.a) - sign * self.slack
        name, key = f"stop_{len(self.parts)}", "lowest" if sign > 0 else "highest"
        self.sketch.tables.append(
            f'[[stop]]\nname = "{name}"\njoint = "joint_{joint}"\n{key} = {limit!r}\nrestitution = {RESTITUTION}'
        )
        self.parts.append(Limit(pin.a, pin.b, sign, limit))
        self.contacts.append((f"joint_{joint}", f"{name}.{key}"))

    def _slide_end(self, kind: str, rng: np.random.Generator) -> None:
        """Of a joint that slides, if there is one."""
        slots = [(joint, index) for joint, (how, index) in enumerate(self.sketch.kinds) if how == "slot"]
        if not slots:
            return
        joint, index = slots[int(rng.integers(len(slots)))]
        slot, sign = self.sketch.slots[index], int(rng.choice([-1, 1]))
        limit = self.sketch.slid(slot) - sign * self.slack
        name, key = f"stop_{len(self.parts)}", "lowest" if sign > 0 else "highest"
        self.sketch.tables.append(
            f'[[stop]]\nname = "{name}"\njoint = "joint_{joint}"\n{key} = {limit!r}\nrestitution = {RESTITUTION}'
        )
        self.parts.append(SlideEnd((slot.a, slot.on_a), (slot.b, slot.on_b), slot.axis, sign, limit))
        self.contacts.append((f"joint_{joint}", f"{name}.{key}"))

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
        touching = centre + (far + self.slack) * e
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
def drawings(choose: st.DrawFn, every: bool = False, slack: float = 0.0, parts: tuple[str, ...] = DISTANCES) -> Drawn:
    """One to five links, up to two more joints, loads, one to three ``parts`` of these kinds, or of ``every``
    kind, and meshes."""
    n = choose(st.integers(1, 5))
    kinds = choose(st.lists(st.sampled_from(KINDS), min_size=n, max_size=n))
    parents = [choose(st.integers(GROUND, k - 1)) for k in range(n)]
    if choose(st.booleans()) and n > 1:
        parents = [GROUND + 1 if k else -2 for k in range(n)]  # floats
    lowest = 0 if parents[0] < GROUND else GROUND
    pairs = st.tuples(st.sampled_from(KINDS), st.integers(lowest, n - 1), st.integers(0, n - 1))
    extra = [pair for pair in choose(st.lists(pairs, max_size=2)) if pair[1] != pair[2]]
    loads = choose(st.lists(st.sampled_from(LOADS), max_size=2))
    if every:
        loads = choose(st.lists(st.sampled_from(MESHES), max_size=2)) + loads
        loads = loads + choose(st.lists(st.sampled_from(LAWS), max_size=2))
        parts = DISTANCES + CAMS + TOUCHES
    seed = choose(st.integers(0, 10**6))
    drawn = Drawn(random_mechanisms.draw(kinds, parents, extra, loads, seed, choose(st.booleans())), slack)
    rng = np.random.default_rng(seed + 1)
    for kind in choose(st.lists(st.sampled_from(parts), min_size=1, max_size=3)):
        drawn.add(kind, rng)
    return drawn
