"""Kinematics of the virtual open chain: arms, their centripetal parts, and where points are (theory, section 2)."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ..equations.ledger import Ledger
from ..equations.names import State, place, slide_name, sliding_name
from ..mechanism.joints import PointRef
from ..mechanism.links import GROUND, Point
from ..mechanism.mechanism import Mechanism
from ..mechanism.topology import Branch, Topology
from .vectors import ZERO, Vector, add, local, perp, scale, symbol


@dataclass(frozen=True)
class Slide:
    """How a branch's inboard point slides: ``length`` and ``speed`` along ``direction``, which turns with ``owner``.

    The direction is that in which the inboard point moves as the length grows.
    """

    owner: int
    length: sp.Symbol
    speed: sp.Symbol
    direction: Vector


class Kinematics:
    """Named kinematic quantities of every link; building it writes one block per link into the ledger.

    ``r[link, joint]`` is the arm from a link's inboard point to the joint, in fixed axes (eq. 2.2), ``cr`` the same
    times ω² (eq. 2.4); ``centre`` is the centre of mass in link axes and ``mu`` the first moment of mass in fixed axes,
    both from the inboard point. ``r`` of a joint that slides along a line of the link ends where the joint is now;
    ``lead[link]`` is the rest of the way to the link's inboard point where the line is the link's own (section 2.1).
    """

    def __init__(self, mechanism: Mechanism, topology: Topology, state: State, ledger: Ledger) -> None:
        self.mechanism, self.topology, self.state, self.ledger = mechanism, topology, state, ledger
        self.r: dict[tuple[int, int], Vector] = {}
        self.cr: dict[tuple[int, int], Vector] = {}
        self.mass: dict[int, sp.Expr] = {}
        self.centre: dict[int, Vector] = {}
        self.mu: dict[int, Vector] = {}
        self.inboard: dict[int, Vector] = {GROUND: ZERO}
        self.squared_rate: dict[int, sp.Expr] = {GROUND: sp.S.Zero}
        self.turning: dict[sp.Expr, Vector] = {sp.S.Zero: (sp.S.One, sp.S.Zero)}
        self.squares: dict[sp.Expr, sp.Expr] = {sp.S.Zero: sp.S.Zero}
        self.slides: dict[int, Slide] = {}
        self.lead: dict[int, Vector] = {}
        self.attached: dict[int, Vector] = {}
        for branch in topology.branches:
            self.inboard[branch.link] = local(mechanism.links[branch.link].points[branch.inboard])
        if topology.floating:
            self.inboard[topology.root] = ZERO
        links = range(len(mechanism.links))
        followers = {branch.link for branch in topology.branches if branch.follows}
        for link in sorted(links, key=lambda k: k in followers):
            self._write(link)
        self._write_ground()
        for branch in topology.branches:
            if branch.slides:
                self._write_slide(branch)

    def joints_of(self, link: int) -> tuple[tuple[int, str], ...]:
        """Joints that the link carries outboard of its inboard point (cut joints too), each with its point."""
        ends = [(branch.joint, branch.attach) for branch in self.topology.outboard(link)]
        for cut in self.topology.cuts:
            ends += [(cut.joint, side.point) for side in (cut.first, cut.second) if side.link == link]
        return tuple(sorted(ends))

    def _write(self, link: int) -> None:
        """Sine and cosine of the link's angle, its arms, and its first moment of mass."""
        let, body = self.ledger.let, self.mechanism.links[link]
        angle, rate = self.state.angle(link), self.state.rate(link)
        if angle not in self.turning:
            self.turning[angle] = (let(f"c_{link}", sp.cos(angle)), let(f"s_{link}", sp.sin(angle)))
        if rate not in self.squares:
            self.squares[rate] = let(f"w2_{link}", rate**2)
        self.squared_rate[link] = self.squares[rate]
        self.mass[link] = symbol(body.mass)
        for joint, point in self.joints_of(link):
            self.r[link, joint] = self.arm(link, body.points[point], str(joint))
            self.cr[link, joint] = self.ledger.let_vector(
                f"cr_{link}_{joint}", scale(self.squared_rate[link], self.r[link, joint])
            )
        self.centre[link] = xi, eta = self.offset(link, body.com, "c")
        moment = (let(f"mx_{link}", self.mass[link] * xi), let(f"my_{link}", self.mass[link] * eta))
        self.mu[link] = self.ledger.let_vector(f"mu_{link}", self.turn(link, moment))
        self.ledger.close(f"kinematics of {self.title(link)}")

    def line(self, joint: int) -> Vector:
        """Direction of a sliding joint's line in fixed axes, of length 1."""
        record, name = self.mechanism.joints[joint], f"along_{joint}"
        if record.axis is None:
            return self.turn(record.first.link, (sp.S.One, sp.S.Zero))
        if f"{name}_x" not in self.ledger:
            angle = self.state.angle(record.first.link) + symbol(record.axis)
            self.ledger.let_vector(name, (sp.cos(angle), sp.sin(angle)))
        return (sp.Symbol(f"{name}_x"), sp.Symbol(f"{name}_y"))

    def _write_slide(self, branch: Branch) -> None:
        """The line of a branch that slides, and the arm along it (eq. 2.5)."""
        joint, parent = branch.joint, branch.parent
        length, speed = sp.Symbol(slide_name(joint)), sp.Symbol(sliding_name(joint))
        direction = scale(sp.Integer(1 if branch.outwards else -1), self.line(joint))
        self.slides[branch.link] = Slide(branch.owner, length, speed, direction)
        slid = self.ledger.let_vector(f"slid_{joint}", scale(length, direction))
        self.attached[joint] = self.r[parent, joint]
        if branch.owner == branch.link:
            self.lead[branch.link] = slid
        else:
            self.r[parent, joint] = arm = self.ledger.let_vector(
                f"rs_{place(parent)}_{joint}", add(self.r[parent, joint], slid)
            )
            self.cr[parent, joint] = self.ledger.let_vector(
                f"crs_{place(parent)}_{joint}", scale(self.squared_rate[parent], arm)
            )
        self.ledger.close(f"line of {self.mechanism.joints[joint].name}")

    def bias(self, branch: Branch) -> Vector:
        """Acceleration of the inboard point against the parent's at u̇ = 0: −ω² r, and what sliding adds (eq. 2.6)."""
        total = scale(sp.S.NegativeOne, self.cr[branch.parent, branch.joint])
        if branch.link in self.lead:
            total = add(total, scale(-self.squared_rate[branch.link], self.lead[branch.link]))
        if branch.link in self.slides:
            total = add(total, self.coriolis(branch.link))
        return total

    def coriolis(self, link: int) -> Vector:
        """2 ω ṡ d⊥ of the joint that carries the link."""
        slide = self.slides[link]
        return scale(2 * self.state.rate(slide.owner) * slide.speed, perp(slide.direction))

    def _write_ground(self) -> None:
        for joint, point in self.joints_of(GROUND) if not self.topology.floating else ():
            self.r[GROUND, joint] = local(self.mechanism.ground_points[point])
            self.cr[GROUND, joint] = ZERO

    def title(self, link: int) -> str:
        """The link's number and name."""
        name = self.mechanism.link_name(link)
        return "ground" if link == GROUND else f"link {link} ({name})"

    def offset(self, link: int, point: Point, name: str) -> Vector:
        """A point's place in the link's frame, measured from the inboard point: ρ of eq. 2.1."""
        there, here = local(point), self.inboard[link]
        return self.ledger.let_vector(f"rho_{link}_{name}", (there[0] - here[0], there[1] - here[1]))

    def local_arm(self, link: int, joint: int) -> Vector:
        """The arm from the inboard point to a joint, in the link's axes."""
        point = dict(self.joints_of(link))[joint]
        return self.offset(link, self.mechanism.links[link].points[point], str(joint))

    def turn(self, link: int, v: Vector) -> Vector:
        """Link axes to fixed axes (eq. 2.2)."""
        c, s = self.turning[self.state.angle(link)]
        return (c * v[0] - s * v[1], s * v[0] + c * v[1])

    def arm(self, link: int, point: Point, name: str) -> Vector:
        """The named arm r from the inboard point to ``point``, in fixed axes."""
        return self.ledger.let_vector(f"r_{link}_{name}", self.turn(link, self.offset(link, point, name)))

    def arm_to(self, ref: PointRef) -> Vector:
        """The arm to a named point: that of a joint which sits there, or an arm of its own."""
        if ref.link == GROUND:
            return local(self.mechanism.ground_points[ref.point])
        for joint, point in self.joints_of(ref.link):
            if point == ref.point:
                return self.attached.get(joint, self.r[ref.link, joint])
        if self.is_inboard(ref):
            return ZERO
        return self.arm(ref.link, self.mechanism.links[ref.link].points[ref.point], f"at_{ref.point}")

    def is_carried_by(self, link: int, joint: int) -> bool:
        """Whether the joint is the one in which the link hangs in the tree."""
        return link not in (GROUND, self.topology.root) and self.topology.branch(link).joint == joint

    def is_inboard(self, ref: PointRef) -> bool:
        if ref.link == self.topology.root:
            return local(self.mechanism.links[ref.link].points[ref.point]) == ZERO
        return self.topology.branch(ref.link).inboard == ref.point

    def write_positions(self) -> dict[int, Vector]:
        """Positions of the inboard points, outwards from the root (eq. 2.3)."""
        found = {self.topology.root: self._root_vector(self.state.q)}
        for branch in self.topology.branches:
            arm = add(self.r[branch.parent, branch.joint], self.lead.get(branch.link, ZERO))
            found[branch.link] = self.ledger.let_vector(f"P_{branch.link}", add(found[branch.parent], arm))
        self.ledger.close("positions of the inboard points")
        return found

    def write_velocities(self) -> dict[int, Vector]:
        """Velocities of the inboard points, outwards from the root (eq. 2.3 differentiated)."""
        velocity = {self.topology.root: self._root_vector(self.state.u)}
        for branch in self.topology.branches:
            relative = self.relative_velocity(branch)
            velocity[branch.link] = self.ledger.let_vector(f"v_{branch.link}", add(velocity[branch.parent], relative))
        self.ledger.close("velocities of the inboard points")
        return velocity

    def relative_velocity(self, branch: Branch) -> Vector:
        """Velocity of the branch's inboard point less that of its parent's: ω r⊥, and what sliding adds (eq. 2.6)."""
        total = self.swing(branch.parent, self.r[branch.parent, branch.joint])
        if branch.link in self.lead:
            total = add(total, self.swing(branch.link, self.lead[branch.link]))
        if branch.link in self.slides:
            slide = self.slides[branch.link]
            total = add(total, scale(slide.speed, slide.direction))
        return total

    def swing(self, link: int, arm: Vector) -> Vector:
        """Velocity of an arm's end against its root: ω r⊥."""
        return scale(self.state.rate(link), perp(arm))

    def _root_vector(self, symbols: tuple[sp.Symbol, ...]) -> Vector:
        return (symbols[0], symbols[1]) if self.topology.floating else ZERO
