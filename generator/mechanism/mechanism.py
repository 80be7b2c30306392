"""The mechanism: a graph whose nodes are links (ground among them) and whose edges are joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from .joints import Joint, PointRef
from .links import GROUND, Corner, Link, Parameter, Point
from .meshes import Mesh


@dataclass(frozen=True)
class Integrator:
    """The integral ``name`` over time is the rate of the link ``link`` (an index), which hangs on ``joint``."""

    name: str
    link: int
    joint: str


@dataclass(frozen=True)
class Mechanism:
    """Links, the points of the ground link, and the joints between them, in scene order.

    ``welded`` names links of the scene that have become part of another (its index, or ``GROUND``): point ``P`` of such
    a link ``arm`` is that one's point ``arm_P``. ``welds`` names the joints of the scene that made them so.
    ``meshes`` are those of the effects, which compare them and have their parameters.
    ``shafts`` has, by the names of driven joints, those of welds that let go in their place: their first links drive
    shafts without mass.
    ``open`` are joints of the scene that do not hold at present, which places can be named by all the same; ``aids``
    names joints that only place bodies which no joint of the scene holds. ``gates`` are, by joints that let go or take
    hold (their indices), the parameters that are 1 while they hold and 0 while they are open.
    ``integrators`` are links of no scene, behind all others, whose rates are integrals that effects ask for.
    ``outlines`` has what is drawn of links, by their names, where that is not all their points. ``corners`` has the
    points that a scene names as a link's outline, ``link.point`` each, by the link's name there.

    Raises ``ValueError`` when a name is used twice, or a joint names a link or point that does not exist.
    """

    links: tuple[Link, ...]
    ground_points: Mapping[str, Point]
    joints: tuple[Joint, ...]
    welded: Mapping[str, int] = field(default_factory=dict)
    welds: tuple[str, ...] = ()
    meshes: tuple[Mesh, ...] = field(default=(), compare=False)
    open: tuple[Joint, ...] = field(default=(), compare=False)
    aids: tuple[str, ...] = field(default=(), compare=False)
    shafts: Mapping[str, str] = field(default_factory=dict)
    gates: Mapping[int, Parameter] = field(default_factory=dict)
    integrators: tuple[Integrator, ...] = field(default=(), compare=False)
    outlines: Mapping[str, tuple[Corner, ...]] = field(default_factory=dict, compare=False)
    corners: Mapping[str, tuple[str, ...]] = field(default_factory=dict, compare=False)

    def __post_init__(self) -> None:
        for kind, names in (("link", [k.name for k in self.links]), ("joint", [j.name for j in self.joints])):
            twice = sorted({name for name in names if names.count(name) > 1})
            if twice:
                raise ValueError(f"{kind} name used twice: {', '.join(twice)}")
        for joint in self.joints:
            for end in (joint.first, joint.second):
                self.point(end)
        symbols = [p.symbol for p in self.parameters()]
        if len(set(symbols)) != len(symbols):
            raise ValueError("two parameters share a symbol")

    def point(self, ref: PointRef) -> Point:
        """The point that ``ref`` names."""
        points = self.ground_points if ref.link == GROUND else self.links[ref.link].points
        if ref.point not in points:
            raise ValueError(f"{self.link_name(ref.link)} has no point {ref.point!r}; it has {', '.join(points)}")
        return points[ref.point]

    @property
    def own_links(self) -> int:
        """How many links the scene has: they come first, then shafts, those that place bodies, and those that
        integrate."""
        return len(self.links) - len(self.shafts) - len(self.aids) // 2 - len(self.integrators)

    @property
    def hidden_joints(self) -> frozenset[str]:
        """Joints of no scene: those of shafts, those that place bodies, and the hinges of what integrates."""
        return frozenset((*self.shafts.values(), *self.aids, *(one.joint for one in self.integrators)))

    def as_named(self, index: int) -> Joint:
        """A joint between the links that a scene names: where a shaft is, up to what is welded to that."""
        joint = self.joints[index]
        weld = next((one for one in self.joints if one.name == self.shafts.get(joint.name)), None)
        return replace(joint, second=weld.second) if weld else joint

    @property
    def open_gates(self) -> frozenset[int]:
        """Joints (their indices) that let go or take hold and are open at the start."""
        return frozenset(k for k, gate in self.gates.items() if not gate.value)

    @property
    def gates_at(self) -> Mapping[int, Parameter]:
        """The gates of joints (their indices) as effects at them go: those of shafts too."""
        numbers = {joint.name: k for k, joint in enumerate(self.joints)}
        return dict(self.gates) | {numbers[name]: self.gates[numbers[weld]] for name, weld in self.shafts.items()}

    def link_name(self, link: int) -> str:
        return "ground" if link == GROUND else self.links[link].name

    def freedoms(self, driven: int = 0) -> int:
        """Degrees of freedom by Grübler's count, with so many ``driven`` joints: it knows nothing of lengths."""
        kinds = [joint.kind for k, joint in enumerate(self.joints) if k not in self.open_gates]
        slots, welds = kinds.count("pin-in-slot"), kinds.count("weld")
        return 3 * len(self.links) - 2 * len(kinds) + slots - welds - driven - len(self.meshes)

    def parameters(self) -> tuple[Parameter, ...]:
        """Parameters of all links, then of the ground's points, then of the joints, each once, and the gates."""
        found = [p for link in self.links for p in link.parameters()]
        found += [p for point in self.ground_points.values() for p in point.parameters()]
        found += [p for joint in self.joints for p in joint.parameters()]
        found += self.gates.values()
        return tuple(dict.fromkeys(found))
