"""Linkages that pass a change point while something else happens beside it, or in it: a load that bends or is switched,
a brake, dry friction, a spring, a mass that is let go, a rod that drags over rough ground, an impact that throws them
back or stops them there; alone, with a wheel in mesh, or with a second loop that lies in a line as the first does.
Drawn at random, by all methods, against one equation of one coordinate along their branch."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.optimize import brentq

from ccgen.runtime import Model, Run, simulate

from ..oracles.one_branch import MOST, Drag, G, Load, Motion, OneBranch, Part
from ..support.reach import Reach
from ..support.tiers import hard, many
from ..support.workshop import Workshop

METHODS = ("gauss", "dop853", "dopri5", "radau")
KINDS = ("parallelogram", "kite", "folded", "stretched", "slider")
"""Four-bars whose opposite links, or neighbours, are alike; those that lie in a line with the input on the span, or
behind it; a slider-crank whose crank is as long as its rod."""
EVENTS = ("none", "bends", "begins", "ends", "switched", "rubs", "spring", "drops", "drags", "strikes", "strikes rough")
BESIDES = ("nothing", "wheel", "loop")
NAMES = ("crank", "rod", "rocker")
MISSED = {"gauss": 1e-9, "dop853": 1e-7, "dopri5": 1e-7, "radau": 1e-9}
"""Angles (rad), speeds and energies, relative: a hundred times the tolerance, or the tolerance by what has stages."""
ROWS = {"gauss": 60.0, "dop853": 60.0, "dopri5": 150.0, "radau": 400.0}
FAR = 0.62
"""Radians from the place up to which runs are compared."""
WHEEL = 0.01
"""Inertia of wheels and discs (kg m²)."""
MISSES = 0.01
"""What neighbours' rods are longer or shorter by (m)."""
OF_NEIGHBOUR = {"gauss": 1.5, "dop853": 1.5, "dopri5": 1.5, "radau": 1.5}
"""Rows, of those of the neighbour."""


@dataclass(frozen=True)
class Passage:
    branch: OneBranch
    start: float
    speed: float
    event: str
    driven: bool
    after: float
    restitution: float
    torque: float
    along: float
    aside: float
    beside: str
    other: OneBranch | None
    """The second loop, on the same crank."""

    @property
    def last(self) -> int:
        """The link at whose joint loads act: the output on its pivot, or the rod on the crank."""
        return 2 if self.branch.d else 1

    def turn(self, x: float, derivative: int) -> float:
        """The angle of that joint (rad), or a derivative of it by x."""
        angles = self.branch.angles(x, derivative)
        return angles[2] if self.branch.d else angles[1] - angles[0]


def passages(count: int, seed: int) -> Iterator[tuple[Passage, Case]]:
    """The first ``count`` of ``seed``, all events in turn. What happens does so up to 0.01 s, or rad, before or after
    the place, on a scale of logarithms from 1e-9 on, and in half of them exactly there."""
    rng = np.random.default_rng(seed)
    for k in range(count):
        case = None
        while case is None:
            one = _passage(rng, EVENTS[k % len(EVENTS)])
            case = case_of(one)
        yield one, case


def _passage(rng: np.random.Generator, event: str) -> Passage:
    branch = _drawn(rng)
    strikes = event.startswith("strikes")
    beside = BESIDES[rng.integers(len(BESIDES))]
    other = _second(rng, branch) if beside == "loop" else None
    return Passage(
        branch,
        float(rng.uniform(0.25, 0.6) * rng.choice([-1.0, 1.0])),
        float(np.exp(rng.uniform(np.log(6.0), np.log(25.0)))),
        event,
        bool(rng.random() < 0.3) and not strikes,
        float(rng.choice([0.0, 10.0 ** rng.uniform(-9.0, -2.0) * rng.choice([-1.0, 1.0])])),
        float(rng.choice([0.0, rng.uniform()])) if strikes else 0.0,
        float(rng.uniform(0.2, 4.0)),
        float(rng.uniform(0.3, 1.0)),
        float(rng.uniform(-0.2, 0.2)),
        beside,
        other,
    )


def _length(rng: np.random.Generator, low: float, high: float) -> float:
    """Lengths are whole parts of 1024, so that links lie in a line exactly."""
    return float(np.round(rng.uniform(low, high) * 1024.0) / 1024.0)


def _drawn(rng: np.random.Generator) -> OneBranch:
    def length(low: float, high: float) -> float:
        return _length(rng, low, high)

    while True:
        kind = KINDS[rng.integers(len(KINDS))]
        place, a, b, d = 2 * int(rng.integers(2)), length(0.2, 0.7), length(0.3, 1.0), length(0.3, 1.2)
        side, masses = int(rng.choice([-1, 1])), [length(0.3, 3.0) for _ in NAMES]
        if kind == "slider":
            return OneBranch(a, a, 0.0, 0.0, 1, side, masses)
        if kind == "parallelogram":
            b, c = d, a
        elif kind == "kite":
            b, c = a, d
        elif kind == "folded":
            place, c = 0, b + (d - a) * float(rng.choice([-1.0, 1.0]))
        else:
            place, c = 2, d + a - b
        if c >= 0.15 and abs(d - a) >= 0.1 and _passes_in_line(a, b, c, d, place):
            return OneBranch(a, b, c, d, place, side, masses)


def _passes_in_line(a: float, b: float, c: float, d: float, place: int) -> bool:
    star = 0.5 * np.pi * place
    ways = np.abs(a * np.exp(1j * (star + np.linspace(-0.75, 0.75, 60))) - d)
    in_line = min(abs(abs(a * np.exp(1j * star) - d) - way) for way in (b + c, abs(b - c))) < 1e-12
    return in_line and bool(np.all((ways > abs(b - c)) & (ways < b + c)))


def _second(rng: np.random.Generator, first: OneBranch) -> OneBranch | None:
    """A loop on the same crank and pivots that lies in a line where the first does, on either branch, if one is found
    that closes around it."""
    a, d, place = first.a, first.d, first.place
    for _ in range(1000):
        side, masses = int(rng.choice([-1, 1])), [0.0, _length(rng, 0.3, 3.0), _length(rng, 0.3, 3.0)]
        if not d:
            return OneBranch(a, a, 0.0, 0.0, place, side, masses)
        b = _length(rng, 0.3, 1.0)
        c = b + (d - a) * float(rng.choice([-1.0, 1.0])) if place == 0 else d + a - b
        if c >= 0.15 and _passes_in_line(a, b, c, d, place):
            return OneBranch(a, b, c, d, place, side, masses)
    return None


@dataclass(frozen=True)
class Case:
    """A scene, and what it is beside: its ``load`` and ``gap``, ``corners`` of the first, and when (s) it is at the
    place if nothing acts on it."""

    text: str
    extra: str
    begin: float
    branch: OneBranch
    load: Load
    corners: tuple[float, ...]
    gap: Callable[[float], float] | None
    passes: float


def case_of(one: Passage) -> Case | None:
    """``None`` where it does not get as far as the place, or the point that is to strike all but stands there, or
    could stand there in balance, or what drags would lift or turn about."""
    begin = one.branch.star + one.start
    v = float(-np.sign(one.start) * one.speed)
    branch = replace(one.branch, parts=list(_parts(one)))
    if one.event == "drags":
        branch.drag = _drag(one)
    passes = -one.start / v if one.driven else _passes(branch, begin, v)
    if passes is None:
        return None
    if one.event.startswith("strikes"):
        return _strike(one, branch, begin, v, passes)
    at = passes + one.after
    extra, load = _acts(one, branch, at)
    if one.event == "drops":
        bob = _bob(one)
        branch.parts.append(lambda t, x: bob(t, x) if t < at else (0.0, 0.0, 0.0))
    case = Case(_scene(one, begin, v, extra, None), extra, begin, branch, load, (at,), None, passes)
    return case if one.event != "drags" or _drags_on(one, case) else None


def _parts(one: Passage) -> Iterator[Part]:
    """What moves with the mechanism besides."""
    other = one.other
    if other:
        yield lambda _, x: other.masses_and_weights(x)
    if one.beside == "wheel":

        def wheel(_: float, x: float) -> tuple[float, float, float]:
            first, second = (one.branch.angles(x, k)[2 if one.branch.d else 0] / one.along for k in (1, 2))
            return WHEEL * first**2, 2.0 * WHEEL * first * second, 0.0

        yield wheel


def _bob(one: Passage) -> Part:
    """A disc of 1 kg on a pin at the end of the rod, which does not turn."""

    def bob(_: float, x: float) -> tuple[float, float, float]:
        p = one.branch.point(1, one.branch.b, 0.0, x)
        return abs(p[1]) ** 2, 2.0 * (np.conj(p[1]) * p[2]).real, G * p[1].imag

    return bob


def _drag(one: Passage) -> Drag:
    deep = one.branch.c + 0.3
    return Drag(1.0, 1.3 * (deep + one.branch.c), deep, 1 if one.aside > 0.0 else -1, 30.0 + 20.0 * one.torque, 0.2)


def _drags_on(one: Passage, case: Case) -> bool:
    """Whether it presses on its ground all the time, and slides one way."""
    motion, until = reference(one, case)
    pressed, slid = [], []
    for t in np.linspace(0.0, until, 200):
        x, v = (case.begin - np.sign(one.start) * one.speed * t, -np.sign(one.start) * one.speed)
        x, v = (x, v) if motion is None else motion.at(t)
        matrix, sides = case.branch.equations(t, x, v, case.load)
        pressed.append(sides[1] / matrix[1, 1] if motion is None else case.branch.pressing(t, x, v, case.load))
        slid.append(case.branch.slides(x, v))
    return min(pressed) > 1.0 and min(np.array(slid) * np.sign(slid[0])) > 0.01


def _acts(one: Passage, branch: OneBranch, at: float) -> tuple[str, Load]:
    """What acts at the output's pivot, or on the rod, and changes at that time (s): tables of the scene, and the work
    that it does."""
    torque = one.torque
    rows = [0.0, at, 5.0], [torque, -2.0 * torque, torque]
    texts = {
        "none": "",
        "bends": f'[[motor]]\njoint = "hub"\ntable = {[list(row) for row in zip(*rows, strict=True)]}\n',
        "begins": f'[[brake]]\njoint = "hub"\ntorque = {torque}\nrate = 0.05\nbegins = {at!r}\n',
        "ends": f'[[brake]]\njoint = "hub"\ntorque = {torque}\nrate = 0.05\nends = {at!r}\n',
        "switched": f'[[motor]]\nname = "load"\njoint = "hub"\ntorque = {torque}\n'
        f'[[event]]\nwhen = "t - {at!r}"\noff = ["load"]\n',
        "rubs": f'[[joint_friction]]\njoints = ["hub"]\ndry = {torque}\nrate = 0.05\nviscous = 0.02\n',
        "spring": '[[torsion]]\njoint = "hub"\nstiffness = 3.0\nangle = 0.5\ndamping = 0.02\n',
        "drops": f'{_disc("bob", 1.0)}{_pin("hook", "rod.B", "bob.C")}[[release]]\njoint = "hook"\nat = {at!r}\n',
        "drags": _drag_scene(one, branch),
    }

    def moment(t: float, x: float, rate: float) -> float:
        brakes = -torque * float(np.tanh(rate / 0.05))
        return {
            "none": 0.0,
            "bends": float(np.interp(t, *rows)),
            "begins": brakes if t >= at else 0.0,
            "ends": brakes if t < at else 0.0,
            "switched": torque if t < at else 0.0,
            "rubs": brakes - 0.02 * rate,
            "spring": -3.0 * (one.turn(x, 0) - 0.5) - 0.02 * rate,
            "drops": 0.0,
            "drags": 0.0,
        }[one.event]

    def load(t: float, x: float, v: float) -> float:
        way = one.turn(x, 1)
        return moment(t, x, way * v) * way

    return texts[one.event], load


def _drag_scene(one: Passage, branch: OneBranch) -> str:
    if not branch.drag:
        return ""
    drag = branch.drag
    return (
        f"{_rod('drag', drag.mass, drag.length)}{_pin('hip', 'rocker.B' if branch.d else 'slider.C', 'drag.A')}"
        f'[[motor]]\njoint = "hip"\ntorque = {-drag.way * drag.torque!r}\n'
        f"[[ground]]\npoint = [0, {-drag.below!r}]\nfriction = {drag.friction}\nrestitution = 0\n"
        'contacts = ["drag.B"]\n'
    )


def _strike(one: Passage, branch: OneBranch, begin: float, v: float, passes: float) -> Case | None:
    """A point of a link comes to a ground so far from the place, or in it."""
    link = (0 if one.along < 0.65 else 1) if not branch.d else (1 if one.along < 0.65 else 2)
    along = one.along * (branch.a, branch.b, branch.c)[link]
    place = branch.point(link, along, one.aside, branch.star + float(np.sign(v)) * one.after)
    way = place[1] * np.sign(v)
    if abs(way) < 0.05 or abs(branch.acceleration(0.0, branch.star, 0.0, lambda t, x, v: 0.0)) < 1e-3:
        return None  # what is stopped there may stand on the ground in balance, or not
    normal = complex(-way / abs(way) * np.exp(1j * one.aside))

    def gap(x: float) -> float:
        return float((np.conj(normal) * (branch.point(link, along, one.aside, x)[0] - place[0])).real)

    if gap(begin) < 0.01:
        return None
    rough = "friction = 0.2\n" if one.event == "strikes rough" else ""
    ground = (
        f"[[ground]]\nrestitution = {one.restitution!r}\n{rough}"
        f"point = [{float(place[0].real)!r}, {float(place[0].imag)!r}]\n"
        f'normal = [{normal.real!r}, {normal.imag!r}]\ncontacts = ["{NAMES[link]}.P"]\n'
    )
    point = (link, f", P = [{along!r}, {one.aside!r}]")
    return Case(_scene(one, begin, v, ground, point), ground, begin, branch, lambda t, x, v: 0.0, (), gap, passes)


def _passes(branch: OneBranch, begin: float, v: float) -> float | None:
    """When the branch is passed without loads, if it is within a quarter of a second."""
    motion = branch.run(begin, v, 0.25, lambda t, x, v: 0.0, gap=lambda x: float(np.sign(v)) * (branch.star - x) + 0.1)
    end, piece = motion.pieces[0]
    if (piece(end)[0] - branch.star) * (begin - branch.star) >= 0.0:
        return None
    return float(brentq(lambda t: piece(t)[0] - branch.star, 0.0, end, xtol=1e-16, rtol=8.9e-16))


def _scene(
    one: Passage,
    begin: float,
    v: float,
    extra: str,
    point: tuple[int, str] | None,
    longer: float = 0.0,
) -> str:
    branch = one.branch
    text = f'name = "beside"\n[ground_link]\npoints = {{ O = [0, 0], Q = [{branch.d or 1.0!r}, 0] }}\n'
    angles, rates = dict(zip(NAMES, branch.angles(begin), strict=False)), {}
    lengths = (branch.a, branch.b + longer, branch.c)
    for link, (name, mass, length) in enumerate(zip(NAMES, branch.masses, lengths, strict=True)):
        if link == 2 and not branch.d:
            text += _disc("slider", mass)
            continue
        text += _rod(name, mass, length, point[1] if point and point[0] == link else "")
    text += _pin("axle", "ground.O", "crank.A")
    if branch.d:
        text += _pin("pin", "crank.B", "rod.A") + _pin("end", "rod.B", "rocker.B") + _pin("hub", "ground.Q", "rocker.A")
    else:
        text += _pin("hub", "crank.B", "rod.A") + _pin("end", "rod.B", "slider.C") + _guide("slider")
    if one.other:
        _, rod, last = one.other.masses
        text += _rod("rod2", rod, one.other.b + longer) + _pin("pin2", "crank.B", "rod2.A")
        angles["rod2"] = one.other.angles(begin)[1]
        if branch.d:
            text += _rod("rocker2", last, one.other.c) + _pin("end2", "rod2.B", "rocker2.B")
            text += _pin("hub2", "ground.Q", "rocker2.A")
            angles["rocker2"] = one.other.angles(begin)[2]
        else:
            text += _disc("slider2", last) + _pin("end2", "rod2.B", "slider2.C") + _guide("slider2")
    if one.beside == "wheel":
        text += _disc("wheel", 1.0) + _pin("spindle", "ground.Q" if branch.d else "ground.O", "wheel.C")
        text += f'[[gear]]\njoints = ["{"hub" if branch.d else "axle"}", "spindle"]\nratio = {one.along!r}\n'
    if one.event == "drags":
        dragging = replace(branch, drag=_drag(one))
        angles["drag"], way, _ = dragging.dragged(begin)[0]
        rates["drag"] = way * v
    told = ", ".join(f"{name} = {angle!r}" for name, angle in angles.items())
    text += f"[start]\nangles = {{ {told} }}\n"
    if one.driven:
        drive = f'[[drive]]\njoint = "axle"\nangle = "{begin!r} + ({v!r})*t"\n'
    else:
        drive, rates["crank"] = "", v
    if rates:
        text += f"angular_velocities = {{ {', '.join(f'{name} = {rate!r}' for name, rate in rates.items())} }}\n"
    return text + drive + extra + "[gravity]\n"


def _rod(name: str, mass: float, length: float, more: str = "") -> str:
    return (
        f'[[link]]\nname = "{name}"\nmass = {mass}\ninertia = {mass * length**2 / 12.0!r}\n'
        f"com = [{length / 2.0!r}, 0]\npoints = {{ A = [0, 0], B = [{length!r}, 0]{more} }}\n"
    )


def _disc(name: str, mass: float) -> str:
    return f'[[link]]\nname = "{name}"\nmass = {mass}\ncom = [0, 0]\ninertia = {WHEEL}\npoints = {{ C = [0, 0] }}\n'


def _pin(name: str, first: str, second: str) -> str:
    return f'[[joint]]\nname = "{name}"\nbetween = ["{first}", "{second}"]\n'


def _guide(name: str) -> str:
    return f'[[joint]]\ntype = "prismatic"\nbetween = ["ground.O", "{name}.C"]\naxis = [1, 0]\n'


def neighbour(one: Passage, case: Case) -> str | None:
    """The scene with rods longer or shorter by MISSES, so that the crank passes but nothing lies in a line there; none
    where that moves a contact, or the two loops need different ones."""
    if case.gap or one.event == "drags":
        return None
    for longer in (MISSES, -MISSES):
        loops = [loop for loop in (one.branch, one.other) if loop]
        ways = [abs(loop.a * np.exp(1j * loop.star) - loop.d) for loop in loops]
        far = [loop.c if loop.d else loop.a for loop in loops]  # a slider's second link is as long as the rod
        if all(
            abs(loop.b + longer - c) < way < loop.b + longer + c for loop, way, c in zip(loops, ways, far, strict=True)
        ):
            return _scene(one, case.begin, float(-np.sign(one.start) * one.speed), case.extra, None, longer)
    return None


def reference(one: Passage, case: Case) -> tuple[Motion | None, float]:
    """The motion, if no drive gives it, and how long runs are compared with it (s)."""
    until = 2.0 * case.passes
    if one.driven:
        return None, min(until, case.passes + FAR / one.speed)
    v = float(-np.sign(one.start) * one.speed)
    motion = case.branch.run(case.begin, v, until, case.load, case.corners, case.gap, one.restitution)
    times = np.linspace(0.0, until, 400)
    away = [t for t in times if abs(motion.at(t)[0] - one.branch.star) > FAR]
    until = min([until, *(t - until / 400.0 for t in away)])
    strikes = [t for t, _ in motion.strikes if t < until]
    return motion, strikes[-1] - 1e-5 if len(strikes) == MOST else until


def missed(one: Passage, case: Case, run: Run, motion: Motion | None) -> dict[str, float]:
    """By how much a run misses angles (rad), speeds and efforts, relative to the largest, and its energy."""
    model: Model = run.model
    v = float(-np.sign(one.start) * one.speed)
    names, columns = list(model.links), []
    for loop, suffix in ((one.branch, ""), (one.other, "2")):
        for k, name in enumerate(NAMES if one.branch.d else NAMES[:2]):
            if loop and (k or not suffix):
                columns.append((loop, k, model.q_names.index(f"theta_{names.index(name + suffix)}")))

    def of_links(x: float, derivative: int) -> list[float]:
        return [loop.angles(x, derivative)[k] for loop, k, _ in columns]

    at = [column for _, _, column in columns]
    turns = 2.0 * np.pi * np.round((run.q[0, at] - of_links(case.begin, 0)) / (2.0 * np.pi))
    near = case.passes + np.array([-1e-4, -1e-7, 0.0, 1e-7, 1e-4])
    times = np.unique(np.clip(np.concatenate([np.linspace(0.0, run.t[-1], 9), near]), 0.0, run.t[-1]))
    strikes = [t for t, _ in motion.strikes] if motion else []
    times = np.array([t for t in times if all(abs(t - strike) > 1e-6 for strike in strikes)])
    q, u = run.at(times)
    states = [(case.begin + v * t, v) if motion is None else motion.at(t) for t in times]
    angles, rates = (np.array([of_links(x, k) for x, _ in states]) for k in (0, 1))
    found = {
        "angles": float(np.max(np.abs(q[:, at] - turns - angles))),
        "speeds": float(np.max(np.abs(u[:, at] - rates * np.array([[v] for _, v in states]))) / one.speed),
        "energy": run.energy_drift / float(np.max(model.energy(run.q, run.u)[0])),
    }
    smooth = [k for k, t in enumerate(times) if all(abs(t - corner) > 1e-6 for corner in case.corners)]
    if one.driven:
        wanted = [case.branch.effort(times[k], states[k][0], v, case.load) for k in smooth]
        got = run.reactions(times[smooth])[:, model.joints.index("axle"), 2]
        found["efforts"] = float(np.max(np.abs(got - wanted)) / (1.0 + np.max(np.abs(wanted))))
    return found


@pytest.mark.parametrize(("count", "seed"), [(4, 1), hard(many(24, 1000), 2)], ids=str)
def test_what_happens_beside_a_change_point(count: int, seed: int, workshop: Workshop, reach: Reach) -> None:
    """The branch is kept, and states, efforts and energies are those of the equation; impacts as many."""
    most: dict[tuple[str, str], float] = {}
    wrong, compared = [], 0
    for one, case in passages(count, seed):
        model = workshop.model(case.text)
        motion, until = reference(one, case)
        strikes = sum(t < until for t, _ in motion.strikes) if motion else 0
        missing = neighbour(one, case)
        compared += missing is not None
        for method in METHODS:
            run = simulate(model, until=until, method=method)
            assert run.success, (one, method, run.message)
            found = missed(one, case, run, motion)
            if len(run.impacts) != strikes or not all(much <= 1e-7 for much in found.values()):
                wrong.append(f"{method}: {found}, {len(run.impacts)} impacts for {strikes}\n{case.text}")
            found["rows"] = len(run.t)
            if missing:
                beside = simulate(workshop.model(missing), until=until, method=method)
                assert beside.success, (one, method, beside.message)
                found["rows of a neighbour's"] = len(run.t) / len(beside.t)
            for what, much in found.items():
                most[method, what] = max(most.get((method, what), 0.0), much)
    assert not wrong, "\n".join(wrong)
    assert 2 * compared >= count / 2
    for (method, what), much in most.items():
        bound = {"efforts": 1e-8, "rows": ROWS[method], "rows of a neighbour's": OF_NEIGHBOUR[method]}.get(
            what, MISSED[method]
        )
        reach(f"{count} passages of change points with something beside, {method}: {what}", much, bound)


@pytest.mark.parametrize("method", ["gauss", *map(hard, METHODS[1:])])
def test_what_is_stopped_in_a_place_goes_on_from_its_state(method: str, workshop: Workshop) -> None:
    """A parallelogram is stopped by a ground where its cranks are level, and its weight takes it back: as the same
    parallelogram, whether the run goes on or begins anew from the state at the impact."""
    scene = """
    name = "stopped"
    [ground_link]
    points = { O = [0, 0], Q = [0.5, 0] }
    [[link]]
    name = "crank"
    rod = { mass = 1 }
    points = { A = [0, 0], B = [0.4, 0] }
    [[link]]
    name = "rod"
    rod = { mass = 1.5 }
    points = { A = [0, 0], B = [0.5, 0] }
    [[link]]
    name = "rocker"
    rod = { mass = 2 }
    points = { A = [0, 0], B = [0.4, 0] }
    [[joint]]
    between = ["ground.O", "crank.A"]
    [[joint]]
    between = ["crank.B", "rod.A"]
    [[joint]]
    between = ["rod.B", "rocker.B"]
    [[joint]]
    between = ["ground.Q", "rocker.A"]
    [start]
    angles = { crank = 3.7, rod = 0, rocker = 3.7 }
    angular_velocities = { crank = -20 }
    [[ground]]
    restitution = 0
    normal = [0, -1]
    contacts = ["rocker.B"]
    [gravity]
    """
    model = workshop.model(scene)
    whole = simulate(model, until=0.3, method=method)
    first = simulate(model, until=whole.impacts[0].t, method=method)
    rest = simulate(model, state=first.state, until=0.3, method=method)
    for run in (whole, rest):
        assert run.success and run.energy_drift <= 1e-9 * float(np.max(model.energy(whole.q, whole.u)[0]))
        assert np.max(np.abs(run.q[:, 0] - run.q[:, 2])) <= 1e-9 and np.max(np.abs(run.q[:, 1])) <= 1e-9
    assert len(whole.impacts) == 1 and abs(first.q[-1, 0] - np.pi) <= 1e-12
    assert whole.q[-1, 0] - np.pi > 0.3 and np.max(np.abs(rest.q[-1] - whole.q[-1])) <= 1e-7
