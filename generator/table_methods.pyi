"""The methods of :class:`~.builder.Mechanism` for tables; docs/scripts/table_methods.py writes this."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from .builder import Mechanism

Number = float | np.floating[Any] | np.integer[Any] | str
"""A number, or a text: a number with its unit, or arithmetic over names of ``let``."""
Whole = int | np.integer[Any] | str
Array = NDArray[Any]

class TableMethods:
    """Each adds a table; where its schema has no default, a key that is not given is a fault of the scene."""

    def let(
        self,
        **names: Number,
    ) -> Mechanism:
        """Add [let]."""

    def loop(
        self,
        *,
        links: Whole | None = None,
        length: Number | Sequence[Number] | Array | None = None,
        mass: Number | Sequence[Number] | Array | None = None,
        inertia: Number | Sequence[Number] | Array | None = None,
        com: Number | Sequence[Number | Sequence[Number] | Array] | Array | None = None,
    ) -> Mechanism:
        """Add [loop].

        links: the number of links, a whole number from 1 to 2000
        length: a length in m, a positive number or a list with one per link
        mass: a mass in kg, a positive number or a list with one per link
        inertia: an inertia about the centre of mass in kg m², a positive number or a list with one per link
        com: the centre of mass in m: a distance along the link, [x, y], or a list with one of these per link
        """

    def chain(
        self,
        *,
        links: Whole | None = None,
        length: Number | Sequence[Number] | Array | None = None,
        mass: Number | Sequence[Number] | Array | None = None,
        inertia: Number | Sequence[Number] | Array | None = None,
        com: Number | Sequence[Number | Sequence[Number] | Array] | Array | None = None,
        hinged: bool | None = None,
    ) -> Mechanism:
        """Add [chain].

        links: the number of links, a whole number from 1 to 2000
        length: a length in m, a positive number or a list with one per link
        mass: a mass in kg, a positive number or a list with one per link
        inertia: an inertia about the centre of mass in kg m², a positive number or a list with one per link
        com: the centre of mass in m: a distance along the link, [x, y], or a list with one of these per link
        hinged: true or false: whether the first end is pinned to the ground
        """

    def pinned(
        self,
        *,
        links: Whole | None = None,
        length: Number | Sequence[Number] | Array | None = None,
        mass: Number | Sequence[Number] | Array | None = None,
        inertia: Number | Sequence[Number] | Array | None = None,
        com: Number | Sequence[Number | Sequence[Number] | Array] | Array | None = None,
        span: Number | None = None,
    ) -> Mechanism:
        """Add [pinned].

        links: the number of links, a whole number from 1 to 2000
        length: a length in m, a positive number or a list with one per link
        mass: a mass in kg, a positive number or a list with one per link
        inertia: an inertia about the centre of mass in kg m², a positive number or a list with one per link
        com: the centre of mass in m: a distance along the link, [x, y], or a list with one of these per link
        span: the distance of the two supports in m, a positive number (default: the mean length)
        """

    def four_bars(
        self,
        *,
        count: Whole | None = None,
        length: Number | None = None,
        mass: Number | None = None,
    ) -> Mechanism:
        """Add [four_bars].

        count: the number of four-bars, a whole number from 1 to 600
        length: the length of every link in m, a positive number
        mass: the mass of every link in kg, a positive number
        """

    def link(
        self,
        name: str | None = None,
        *,
        mass: Number | None = None,
        inertia: Number | None = None,
        com: str | Sequence[Number] | Array | None = None,
        points: Mapping[str, Sequence[Number] | Array] | None = None,
        outline: Sequence[str | Sequence[Number] | Array] | Array | None = None,
        around: Mapping[str, Any] | Sequence[Mapping[str, Any]] | None = None,
        free: bool | None = None,
        rod: Mapping[str, Any] | Sequence[Mapping[str, Any]] | None = None,
        plate: Mapping[str, Any] | Sequence[Mapping[str, Any]] | None = None,
        disc: Mapping[str, Any] | Sequence[Mapping[str, Any]] | None = None,
        point_mass: Mapping[str, Any] | Sequence[Mapping[str, Any]] | None = None,
    ) -> Mechanism:
        """Add [[link]].

        name: a name of letters, digits and _, beginning with a letter
        mass: the mass in kg, a positive number, or 0 for a link without mass
        inertia: the inertia about the centre of mass in kg m², a positive number, or 0 for a point mass
        com: the centre of mass, a point of the link or [x, y] in m in its frame
        points: named points, { A = [x, y], ... } in m, at least one
        outline: what is drawn of it, its points or [x, y] in m in their order, ["A", "B", [0.1, 0.2]], or [] for
            nothing
        around: points round a circle, { count = ..., points = { ... } }, or a list of such tables
        free: true or false: whether it and what hangs on it move freely beside what is held
        rod: a uniform rod between two points, { mass = ... }, or a list of them
        plate: a uniform plate with corners in points, { mass = ... }, or a list of them
        disc: a uniform disc about a point, { mass = ..., radius = ... }, or a list of them
        point_mass: a mass in one place, { mass = ..., at = "A" }, or a list of them
        """

    def joint(
        self,
        name: str | None = None,
        *,
        type: Literal["revolute", "prismatic", "weld", "pin-in-slot"] | None = None,
        between: Sequence[str] | None = None,
        axis: Number | Sequence[Number] | Array | None = None,
        angle: Number | None = None,
    ) -> Mechanism:
        """Add [[joint]].

        name: a name of letters, digits and _, beginning with a letter
        type: the kind of joint, "revolute", "prismatic", "weld" or "pin-in-slot"
        between: the two points that it joins, ["link.point", "link.point"]
        axis: the direction of the line in the first link's frame, [x, y], an angle in rad or as "30 deg"
        angle: the angle of the second link against the first in rad, or a text such as "30 deg"
        """

    def ground_link(
        self,
        *,
        points: Mapping[str, Sequence[Number] | Array] | None = None,
    ) -> Mechanism:
        """Add [ground_link].

        points: named points of the ground, { O = [x, y], ... } in m
        """

    def part(
        self,
        name: str | Mechanism | None = None,
        *,
        ports: Sequence[str] | None = None,
        let: Mapping[str, Number] | None = None,
        link: Sequence[Mapping[str, Any]] | None = None,
        joint: Sequence[Mapping[str, Any]] | None = None,
        ground: Sequence[Mapping[str, Any]] | None = None,
        compliant_ground: Sequence[Mapping[str, Any]] | None = None,
        stop: Sequence[Mapping[str, Any]] | None = None,
        touch: Sequence[Mapping[str, Any]] | None = None,
        compliant_touch: Sequence[Mapping[str, Any]] | None = None,
        journal: Sequence[Mapping[str, Any]] | None = None,
        cam: Sequence[Mapping[str, Any]] | None = None,
        rope: Sequence[Mapping[str, Any]] | None = None,
        spring: Sequence[Mapping[str, Any]] | None = None,
        damper: Sequence[Mapping[str, Any]] | None = None,
        torsion: Sequence[Mapping[str, Any]] | None = None,
        joint_friction: Sequence[Mapping[str, Any]] | None = None,
        brake: Sequence[Mapping[str, Any]] | None = None,
        drag: Sequence[Mapping[str, Any]] | None = None,
        motor: Sequence[Mapping[str, Any]] | None = None,
        drive: Sequence[Mapping[str, Any]] | None = None,
        gear: Sequence[Mapping[str, Any]] | None = None,
        rack: Sequence[Mapping[str, Any]] | None = None,
        belt: Sequence[Mapping[str, Any]] | None = None,
        force: Sequence[Mapping[str, Any]] | None = None,
        torque: Sequence[Mapping[str, Any]] | None = None,
        input: Sequence[Mapping[str, Any]] | None = None,
        law: Sequence[Mapping[str, Any]] | None = None,
        place: Sequence[Mapping[str, Any]] | None = None,
        ground_link: Mapping[str, Any] | None = None,
        start: Mapping[str, Any] | None = None,
    ) -> Mechanism:
        """Add [[part]].

        name: a name of letters, digits and _, beginning with a letter
        ports: names for points outside of the part, which every [[place]] gives, ["pin", "hip"]
        let: a table of names and numbers
        link: tables of the part, as [[link]]
        joint: tables of the part, as [[joint]]
        ground: tables of the part, as [[ground]]
        compliant_ground: tables of the part, as [[compliant_ground]]
        stop: tables of the part, as [[stop]]
        touch: tables of the part, as [[touch]]
        compliant_touch: tables of the part, as [[compliant_touch]]
        journal: tables of the part, as [[journal]]
        cam: tables of the part, as [[cam]]
        rope: tables of the part, as [[rope]]
        spring: tables of the part, as [[spring]]
        damper: tables of the part, as [[damper]]
        torsion: tables of the part, as [[torsion]]
        joint_friction: tables of the part, as [[joint_friction]]
        brake: tables of the part, as [[brake]]
        drag: tables of the part, as [[drag]]
        motor: tables of the part, as [[motor]]
        drive: tables of the part, as [[drive]]
        gear: tables of the part, as [[gear]]
        rack: tables of the part, as [[rack]]
        belt: tables of the part, as [[belt]]
        force: tables of the part, as [[force]]
        torque: tables of the part, as [[torque]]
        input: tables of the part, as [[input]]
        law: tables of the part, as [[law]]
        place: tables of the part, as [[place]]
        ground_link: a table of the part, as [ground_link]
        start: a table of the part, as [start]
        """

    def place(
        self,
        name: str | None = None,
        *,
        part: str | None = None,
        at: Sequence[Number] | Array | None = None,
        angle: Number | None = None,
        mirror: bool | None = None,
        ports: Mapping[str, str] | None = None,
        let: Mapping[str, Number] | None = None,
        start: Mapping[str, Any] | None = None,
    ) -> Mechanism:
        """Add [[place]].

        part: the name of a [[part]]
        name: letters, digits and _, which are put behind all names of the part
        at: where the part's origin is, [x, y] in m
        angle: how far the part is turned in rad, or a text such as "120 deg"
        mirror: true or false: whether left and right are exchanged, before it is turned
        ports: a point for each of the part's ports, { pin = "shaft.A", ... }
        let: a table of numbers for names of the part's [let]
        start: a table of what begins otherwise here, as the start of the part
        """

    def start(
        self,
        *,
        position: Sequence[Number] | Array | None = None,
        velocity: Sequence[Number] | Array | None = None,
        height: Number | None = None,
        tilt: Number | None = None,
        angles: Sequence[Number] | Array | Mapping[str, Number] | None = None,
        joints: Mapping[str, Sequence[Number] | Array] | None = None,
        poses: Mapping[str, Sequence[Any] | Array] | None = None,
        angular_velocities: Sequence[Number] | Array | Mapping[str, Number] | None = None,
        slides: Mapping[str, Number] | None = None,
        sliding_velocities: Mapping[str, Number] | None = None,
        open: Sequence[str] | None = None,
        off: Sequence[str] | None = None,
    ) -> Mechanism:
        """Add [start].

        position: where the first link's frame begins, [x, y] in m
        velocity: the velocity of that point, [x, y] in m/s
        height: the height of the lowest joint in m, a finite number
        tilt: an angle in rad, or a text such as "10 deg" or "0.2 rad"
        angles: absolute angles of the links in rad or as "10 deg", a list with one per link or a table by name
        joints: where joints are roughly, a table by name, { A = [x, y], ... } in m
        poses: where frames of links are roughly, a table by name, { crank = [x, y, "30 deg"], ... } in m
        angular_velocities: absolute angular velocities in rad/s, a list with one per link or a table by name
        slides: how far sliding joints are along their lines in m, a table by the joint's name
        sliding_velocities: how fast they slide in m/s, a table by the joint's name
        open: joints of [[hold]] that do not hold at the start, such as ["gripper"]
        off: effects that an [[event]] switches and that are off at the start, ["left_sole"]
        """

    def release(
        self,
        *,
        joint: str | None = None,
        at: Number | None = None,
        when: Mapping[str, Any] | None = None,
        force: Number | None = None,
        impulse: Number | None = None,
    ) -> Mechanism:
        """Add [[release]].

        joint: the name of the joint that lets go
        at: the time at which it lets go in s, a number that is not negative
        when: where it lets go, { angle = "joint", above = "45 deg" } or alike
        force: the force in the joint at which it breaks in N, a positive number
        impulse: the impulse in the joint at which it breaks in N s, a positive number
        """

    def hold(
        self,
        *,
        joint: str | None = None,
        at: Number | None = None,
        when: Mapping[str, Any] | None = None,
        within: Number | None = None,
    ) -> Mechanism:
        """Add [[hold]].

        joint: the name of the joint that takes hold
        at: the time at which it takes hold in s, a number that is not negative
        when: where it takes hold, { angle = "joint", above = "45 deg" } or alike
        within: how far its points may be from each other then in m, a positive number
        """

    def event(
        self,
        name: str | None = None,
        *,
        when: str | None = None,
        direction: Literal["rising", "falling", "either"] | None = None,
        stop: bool | None = None,
        times: Whole | None = None,
        on: Sequence[str] | None = None,
        off: Sequence[str] | None = None,
        set: Mapping[str, Number] | None = None,
    ) -> Mechanism:
        """Add [[event]].

        name: a name of letters, digits and _, beginning with a letter
        when: an expression of the time and the state that comes to zero, as "angle(crank) - pi"
        direction: "rising", "falling" or "either"
        stop: true, if the run ends there, or false
        times: beside stop: how often it comes until the run ends, a positive whole number
        on: names of effects that act from then on, ["left_sole"]
        off: names of effects that are absent from then on
        set: values of parameters from then on, { "motor_0.torque" = 2 }: numbers, or expressions as in when
        """

    def run(
        self,
        *,
        until: Number | None = None,
        rtol: Number | None = None,
        atol: Number | None = None,
        law: Literal["newton", "poisson", "stronge"] | None = None,
        on_gain: Literal["reduce", "stop"] | None = None,
    ) -> Mechanism:
        """Add [run].

        until: the time at which the run ends in s, a positive number
        rtol: the relative tolerance, a number between 0 and 1
        atol: the absolute tolerance, a positive number
        law: the law of all impacts: newton, poisson or stronge
        on_gain: what becomes of an impact that would gain energy, "reduce" or "stop"
        """

    def output(
        self,
        *,
        plot: Sequence[str] | None = None,
        table: Sequence[str] | None = None,
        times: Whole | None = None,
    ) -> Mechanism:
        """Add [output].

        plot: names of what is drawn over time, ["crank.angle", "coupler.tip.vy"]
        table: names of what is written as CSV, ["crank.angle", "pin.force"]
        times: beside table: at how many even times, a whole number from 2 to 1000000
        """

    def gravity(
        self,
        *,
        g: Number | None = None,
        direction: Sequence[Number] | Array | None = None,
    ) -> Mechanism:
        """Add [gravity].

        g: the acceleration of gravity in m/s², a finite number
        direction: the direction in which things fall, [x, y], not both zero
        """

    def ground(
        self,
        name: str | None = None,
        *,
        point: Sequence[Number] | Array | None = None,
        normal: Sequence[Number] | Array | None = None,
        friction: Number | None = None,
        contacts: Sequence[str] | None = None,
        radius: Number | Sequence[Number] | Array | None = None,
        restitution: Number | None = None,
        law: Literal["newton", "poisson", "stronge"] | None = None,
    ) -> Mechanism:
        """Add [[ground]].

        name: a name of letters, digits and _, beginning with a letter
        point: a point of the surface, [x, y] in m
        normal: the direction out of the ground, [x, y], not both zero
        friction: Coulomb's coefficient of friction, zero or positive
        contacts: a list of points that touch it, such as ["joint_3", "link_0.A"]
        radius: the radius in m of discs about the contacts, not negative, or a list with one per contact
        restitution: the coefficient of restitution, a number from 0 to 1
        law: the law of all impacts: newton, poisson or stronge
        """

    def compliant_ground(
        self,
        name: str | None = None,
        *,
        load: Number | None = None,
        depth: Number | None = None,
        exponent: Number | None = None,
        young: Number | Sequence[Number] | Array | None = None,
        poisson: Number | Sequence[Number] | Array | None = None,
        damping: Number | None = None,
        restitution: Number | None = None,
        slowest: Number | None = None,
        friction: Number | None = None,
        slip_speed: Number | None = None,
        point: Sequence[Number] | Array | None = None,
        normal: Sequence[Number] | Array | None = None,
        contacts: Sequence[str] | None = None,
        radius: Number | Sequence[Number] | Array | None = None,
    ) -> Mechanism:
        """Add [[compliant_ground]].

        load: the force in N that presses a contact as deep as depth, zero or positive
        depth: the depth in m to which the load presses a contact, a positive number
        exponent: the power of the depth with which the force grows, 1, 1.5 (Hertz), 2, 2.5 or 3
        young: Young's modulus of both bodies in Pa, a positive number, or a list of two, one for each
        poisson: Poisson's ratio of both bodies, a number from 0 to 0.5, or a list of two
        damping: by what part the force is larger per speed of approach, in s/m, zero or positive
        restitution: the coefficient of restitution after Lankarani and Nikravesh, a number from 0 to 1
        slowest: the speed of approach in m/s up to which damping is that of this speed, positive
        friction: Coulomb's coefficient of friction, zero or positive
        slip_speed: the speed about which friction changes its sign in m/s, a positive number
        name: a name of letters, digits and _, beginning with a letter
        point: a point of the surface, [x, y] in m
        normal: the direction out of the ground, [x, y], not both zero
        contacts: a list of points that touch it, such as ["joint_3", "link_0.A"]
        radius: the radius in m of discs about the contacts, not negative, or a list with one per contact
        """

    def stop(
        self,
        name: str | None = None,
        *,
        joint: str | None = None,
        lowest: Number | None = None,
        highest: Number | None = None,
        restitution: Number | None = None,
    ) -> Mechanism:
        """Add [[stop]].

        name: a name of letters, digits and _, beginning with a letter
        joint: the joint that it limits, such as "joint_1"
        lowest: the joint's lowest angle in rad, or a text such as "-30 deg" (m along its line where it slides)
        highest: the joint's highest angle in rad, or a text such as "60 deg" (m along its line where it slides)
        restitution: the coefficient of restitution, a number from 0 to 1
        """

    def touch(
        self,
        name: str | None = None,
        *,
        between: Sequence[str | Sequence[str]] | None = None,
        radius: Number | Sequence[Number] | Array | None = None,
        restitution: Number | None = None,
        friction: Number | None = None,
        law: Literal["newton", "poisson", "stronge"] | None = None,
    ) -> Mechanism:
        """Add [[touch]].

        name: a name of letters, digits and _, beginning with a letter
        between: a disc's centre, and another one or an edge: ["ball.C", "other.C"], ["ball.C", "plank"] or ["ball.C",
            ["plank.A", "plank.B"]]; more points are a line, or a polygon where the last is the first again, and a link
            is its outline
        radius: the radius of the discs in m, not negative, or a list of two: of an edge, half of its thickness
        restitution: the coefficient of restitution, a number from 0 to 1
        friction: Coulomb's coefficient of friction, zero or positive
        law: the law of all impacts: newton, poisson or stronge
        """

    def compliant_touch(
        self,
        name: str | None = None,
        *,
        load: Number | None = None,
        depth: Number | None = None,
        exponent: Number | None = None,
        young: Number | Sequence[Number] | Array | None = None,
        poisson: Number | Sequence[Number] | Array | None = None,
        damping: Number | None = None,
        restitution: Number | None = None,
        slowest: Number | None = None,
        friction: Number | None = None,
        slip_speed: Number | None = None,
        between: Sequence[str | Sequence[str]] | None = None,
        radius: Number | Sequence[Number] | Array | None = None,
    ) -> Mechanism:
        """Add [[compliant_touch]].

        load: the force in N that presses a contact as deep as depth, zero or positive
        depth: the depth in m to which the load presses a contact, a positive number
        exponent: the power of the depth with which the force grows, 1, 1.5 (Hertz), 2, 2.5 or 3
        young: Young's modulus of both bodies in Pa, a positive number, or a list of two, one for each
        poisson: Poisson's ratio of both bodies, a number from 0 to 0.5, or a list of two
        damping: by what part the force is larger per speed of approach, in s/m, zero or positive
        restitution: the coefficient of restitution after Lankarani and Nikravesh, a number from 0 to 1
        slowest: the speed of approach in m/s up to which damping is that of this speed, positive
        friction: Coulomb's coefficient of friction, zero or positive
        slip_speed: the speed about which friction changes its sign in m/s, a positive number
        name: a name of letters, digits and _, beginning with a letter
        between: a disc's centre, and another one or an edge: ["ball.C", "other.C"], ["ball.C", "plank"] or ["ball.C",
            ["plank.A", "plank.B"]]
        radius: the radius of the discs in m, not negative, or a list of two: of an edge, half of its thickness
        """

    def journal(
        self,
        name: str | None = None,
        *,
        between: Sequence[str | Sequence[str]] | None = None,
        radius: Number | None = None,
        clearance: Number | None = None,
        restitution: Number | None = None,
        friction: Number | None = None,
        law: Literal["newton", "poisson", "stronge"] | None = None,
    ) -> Mechanism:
        """Add [[journal]].

        name: a name of letters, digits and _, beginning with a letter
        between: the journal's centre, and that of its bearing or the two ends of a slot's middle line: ["crank.pin",
            "rod.eye"] or ["crank.pin", ["rocker.A", "rocker.B"]]
        radius: the journal's radius in m, not negative
        clearance: how far its centre may be from that of the bearing, or from the slot's middle line, in m, a positive
            number
        restitution: the coefficient of restitution, a number from 0 to 1
        friction: Coulomb's coefficient of friction, zero or positive
        law: the law of all impacts: newton, poisson or stronge
        """

    def cam(
        self,
        name: str | None = None,
        *,
        centre: str | None = None,
        follower: str | Sequence[str] | None = None,
        base: Number | None = None,
        radius: Number | None = None,
        lift: Number | Sequence[Mapping[str, Any]] | None = None,
        angle: Number | None = None,
        clockwise: bool | None = None,
        restitution: Number | None = None,
        friction: Number | None = None,
        law: Literal["newton", "poisson", "stronge"] | None = None,
    ) -> Mechanism:
        """Add [[cam]].

        name: a name of letters, digits and _, beginning with a letter
        centre: the cam's centre, a joint or "link.point"
        follower: the centre of a roller, or a point: "lever.P"; or the two ends of a straight face: ["lifter.A",
            "lifter.B"]
        base: the radius of the base circle in m, a positive number: where the lift is zero
        radius: the radius of the roller in m, not negative; without it the follower is a point
        lift: how far the follower is lifted off the base circle in m, over a turn: an expression of angle, or a list of
            pieces
        angle: where on its link the cam's angle is zero, in rad; 0 if not given
        clockwise: whether the cam's angle is counted clockwise; false if not given
        restitution: the coefficient of restitution, a number from 0 to 1
        friction: Coulomb's coefficient of friction, zero or positive
        law: the law of all impacts: newton, poisson or stronge
        """

    def rope(
        self,
        name: str | None = None,
        *,
        between: Sequence[str] | None = None,
        over: Sequence[str] | None = None,
        length: Number | None = None,
        restitution: Number | None = None,
        law: Literal["newton", "poisson", "stronge"] | None = None,
    ) -> Mechanism:
        """Add [[rope]].

        name: a name of letters, digits and _, beginning with a letter
        between: the two points that it joins, ["link.point", "ground.point"]
        over: the eyelets that it runs over, in order from the first point to the second, ["ground.P"], at most 100
        length: its length in m, a positive number; unless given that of its way at the start
        restitution: the coefficient of restitution, a number from 0 to 1
        law: the law of all impacts: newton, poisson or stronge
        """

    def spring(
        self,
        name: str | None = None,
        *,
        between: Sequence[str] | None = None,
        stiffness: Number | None = None,
        length: Number | None = None,
        acts: Literal["both", "pull", "push"] | None = None,
        damping: Number | None = None,
        play: Number | None = None,
    ) -> Mechanism:
        """Add [[spring]].

        name: a name of letters, digits and _, beginning with a letter
        between: the two points it joins, ["link.point", "ground.point"]
        stiffness: the stiffness in N/m, a positive number
        length: the length at rest in m, zero or a positive number
        acts: "both" ways, "pull" only when it is longer than at rest, as a rope, or "push" only when it is shorter, as
            a buffer
        damping: the damping in N s/m while it acts, zero or positive, with acts "pull" or "push" or play only
        play: the way in m in which it is free, half on either side of its length at rest, a positive number
        """

    def damper(
        self,
        name: str | None = None,
        *,
        between: Sequence[str] | None = None,
        damping: Number | None = None,
    ) -> Mechanism:
        """Add [[damper]].

        name: a name of letters, digits and _, beginning with a letter
        between: the two points it joins, ["link.point", "ground.point"]
        damping: the damping in N s/m, zero or a positive number
        """

    def torsion(
        self,
        name: str | None = None,
        *,
        joint: str | None = None,
        stiffness: Number | None = None,
        angle: Number | None = None,
        damping: Number | None = None,
        play: Number | None = None,
    ) -> Mechanism:
        """Add [[torsion]].

        name: a name of letters, digits and _, beginning with a letter
        joint: the joint at which it acts, such as "joint_1"
        stiffness: the stiffness in N m/rad, a positive number
        angle: the joint's angle at rest in rad, or a text such as "30 deg"
        damping: the damping in N m s/rad, zero or a positive number
        play: the angle in rad in which it is free, half on either side of rest, a positive one, or "2 deg"
        """

    def joint_friction(
        self,
        name: str | None = None,
        *,
        joints: Sequence[str] | None = None,
        viscous: Number | None = None,
        dry: Number | None = None,
        rate: Number | None = None,
        breakaway: Number | None = None,
        stribeck: Number | None = None,
    ) -> Mechanism:
        """Add [[joint_friction]].

        name: a name of letters, digits and _, beginning with a letter
        joints: a list of joints, such as ["joint_1", "joint_2"] (default: all)
        viscous: the viscous friction in N m s/rad, zero or a positive number (N s/m where it slides)
        dry: the moment of dry friction in N m, zero or a positive number (the force in N where it slides)
        rate: the rate about which dry friction changes its sign in rad/s, a positive number (m/s on a line)
        breakaway: the moment of dry friction near standstill in N m, more than dry (the force in N where it slides)
        stribeck: the rate at which e⁻¹ of what breakaway is more is left, in rad/s, positive (m/s on a line)
        """

    def brake(
        self,
        name: str | None = None,
        *,
        joint: str | None = None,
        torque: Number | None = None,
        force: Number | None = None,
        begins: Number | None = None,
        ends: Number | None = None,
        rate: Number | None = None,
    ) -> Mechanism:
        """Add [[brake]].

        name: a name of letters, digits and _, beginning with a letter
        joint: the name of the joint that it brakes
        torque: the most torque in N m, zero or a positive number or an expression
        force: the most force along the line in N, zero or a positive number or an expression
        begins: the time in s from which on it brakes, zero or a positive number
        ends: the time in s up to which it brakes, a positive number
        rate: the rate about which it changes its sign in rad/s, a positive number (m/s where the joint slides)
        """

    def drag(
        self,
        name: str | None = None,
        *,
        point: str | None = None,
        linear: Number | None = None,
        quadratic: Number | None = None,
        speed: Number | None = None,
    ) -> Mechanism:
        """Add [[drag]].

        name: a name of letters, digits and _, beginning with a letter
        point: the point on which it acts, such as "link_0.B" or "joint_1"
        linear: the linear drag in N s/m, zero or a positive number
        quadratic: the quadratic drag in N s²/m², zero or a positive number
        speed: the speed below which quadratic drag is linear in m/s, zero or a positive number
        """

    def motor(
        self,
        name: str | None = None,
        *,
        joint: str | None = None,
        torque: Number | Mapping[str, Any] | None = None,
        force: Number | Mapping[str, Any] | None = None,
        table: Sequence[Sequence[Any] | Array] | Array | None = None,
        angle: Number | Mapping[str, Any] | None = None,
        position: Number | Mapping[str, Any] | None = None,
        stiffness: Number | None = None,
        damping: Number | None = None,
        integral: Number | None = None,
        limit: Number | None = None,
    ) -> Mechanism:
        """Add [[motor]].

        name: a name of letters, digits and _, beginning with a letter
        joint: the name of the joint that it moves
        torque: a torque in N m, a number, an expression of t or the state, or rows or pieces over time
        force: a force along the line in N, a number, an expression of t or the state, or rows or pieces over time
        table: a torque over time, rows [t, torque] in s and N m, at least two
        angle: the wanted angle in rad, a number or text as "30 deg", an expression of t, or rows or pieces over time
        position: the wanted length along the line in m, a number, an expression of t, or rows or pieces over time
        stiffness: the stiffness in N m/rad, zero or a positive number (N/m where it slides)
        damping: the damping in N m s/rad, zero or a positive number (N s/m where it slides)
        integral: the gain of the error's integral in N m/(rad s), zero or a positive number (N/(m s) where it slides)
        limit: the most torque towards a wanted angle, in N m, a positive number (N where it slides)
        """

    def drive(
        self,
        name: str | None = None,
        *,
        joint: str | None = None,
        speed: Number | Mapping[str, Any] | None = None,
        angle: Number | Mapping[str, Any] | None = None,
        position: Number | Mapping[str, Any] | None = None,
    ) -> Mechanism:
        """Add [[drive]].

        name: a name of letters, digits and _, beginning with a letter
        joint: the name of the joint whose motion is given
        speed: the joint's rate in rad/s, a number, an expression of t, or rows or pieces over time (m/s where it
            slides)
        angle: the joint's angle in rad, a number or text as "30 deg", an expression of t, or rows or pieces over time
        position: the length along the line in m, a number, an expression of t, or rows or pieces over time
        """

    def gear(
        self,
        name: str | None = None,
        *,
        joints: Sequence[str] | None = None,
        teeth: Sequence[Whole] | Array | None = None,
        ratio: Number | None = None,
        radii: Sequence[Number] | Array | None = None,
        internal: bool | None = None,
        carrier: str | None = None,
    ) -> Mechanism:
        """Add [[gear]].

        name: a name of letters, digits and _, beginning with a letter
        joints: the joints by which the two wheels turn, such as ["sun", "planet"]
        teeth: the numbers of teeth of the two wheels, whole and positive
        ratio: how many times as fast as the second wheel the first one turns, a positive number
        radii: the radii of the two pitch circles in m, positive numbers
        internal: true where one wheel is a ring about the other: both turn the same way
        carrier: the link on which both axes sit, where joints leave a choice; ground is one
        """

    def rack(
        self,
        name: str | None = None,
        *,
        pinion: str | None = None,
        slide: str | None = None,
        radius: Number | None = None,
        reverse: bool | None = None,
    ) -> Mechanism:
        """Add [[rack]].

        name: a name of letters, digits and _, beginning with a letter
        pinion: the joint by which the pinion turns
        slide: the prismatic joint by which the rack slides
        radius: the radius of the pinion's pitch circle in m, a positive number
        reverse: true where a pinion that turns counter-clockwise moves the rack against its line
        """

    def belt(
        self,
        name: str | None = None,
        *,
        joints: Sequence[str] | None = None,
        radii: Sequence[Number] | Array | None = None,
        crossed: bool | None = None,
        carrier: str | None = None,
    ) -> Mechanism:
        """Add [[belt]].

        name: a name of letters, digits and _, beginning with a letter
        joints: the joints by which the two pulleys turn, such as ["motor", "spindle"]
        radii: the radii of the two pulleys, or of the sprockets' pitch circles, in m, positive numbers
        crossed: true where the belt crosses itself: pulleys turn opposite ways
        carrier: the link on which both axes sit, where joints leave a choice; ground is one
        """

    def force(
        self,
        name: str | None = None,
        *,
        point: str | None = None,
        vector: Sequence[Number] | Array | None = None,
        frame: Literal["fixed", "link"] | None = None,
    ) -> Mechanism:
        """Add [[force]].

        name: a name of letters, digits and _, beginning with a letter
        point: the point it acts on, a joint or "link.point"
        vector: the force [x, y] in N, numbers or expressions of t or of the state
        frame: "fixed" for fixed axes or "link" for axes that turn with the link
        """

    def torque(
        self,
        name: str | None = None,
        *,
        link: str | None = None,
        torque: Number | Mapping[str, Any] | None = None,
    ) -> Mechanism:
        """Add [[torque]].

        name: a name of letters, digits and _, beginning with a letter
        link: the name of the link it acts on
        torque: a torque in N m, a number, an expression of t or the state, or rows or pieces over time
        """

    def input(
        self,
        name: str | None = None,
        *,
        point: str | None = None,
        direction: Sequence[Number] | Array | None = None,
        frame: Literal["fixed", "link"] | None = None,
        joint: str | None = None,
        link: str | None = None,
    ) -> Mechanism:
        """Add [[input]].

        name: a name of letters, digits and _, beginning with a letter, by which it is given
        point: the point that a force acts on, a joint or "link.point"
        direction: the direction of the force, [x, y], not both zero
        frame: "fixed" for fixed axes or "link" for axes that turn with the link
        joint: the name of the joint that a torque turns or a force slides
        link: the name of the link that a torque turns
        """

    def law(
        self,
        name: str | None = None,
        *,
        value: Number | None = None,
        parameters: Mapping[str, Number] | None = None,
        curves: Mapping[str, Mapping[str, Any]] | None = None,
        unit: Literal["1", "N", "N m", "J", "W", "Pa", "rad", "rad/s", "m", "m/s", "N/m"] | None = None,
    ) -> Mechanism:
        """Add [[law]].

        name: a name of letters, digits and _, beginning with a letter, that expressions have
        value: a number or an expression of t and of the state, "-kp*angle(hip) - kd*rate(hip)"
        parameters: names in the expression and their values, { kp = 30.0, kd = 2.0 }
        curves: functions in it by rows, { gas = { rows = [[x, value], ...], law = "monotone" } }
        unit: the unit of what it gives, "1", "N", "N m", "J", "W", "Pa", "rad", "rad/s", "m", "m/s", "N/m"
        """
