"""Linkages that pass a change point while something else happens beside it, or in it: a load that bends or is switched,
a brake, dry friction, a spring, an impact that throws them back or stops them there. Drawn at random, by all methods,
against one equation of one coordinate along their branch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import brentq

from ccgen.runtime import Model, Run, simulate

from ..oracles.one_branch import Load, Motion, OneBranch
from ..support.reach import Reach
from ..support.tiers import hard, many
from ..support.workshop import Workshop

METHODS = ("gauss", "dop853", "dopri5", "radau")
KINDS = ("parallelogram", "kite", "folded", "stretched", "slider")
"""Four-bars whose opposite links, or neighbours, are alike; those that lie in a line with the input on the span, or
behind it; a slider-crank whose crank is as long as its rod."""
EVENTS = ("none", "bends", "begins", "ends", "switched", "rubs", "spring", "strikes", "strikes rough")
NAMES = ("crank", "rod", "rocker")
MISSED = {"gauss": 1e-9, "dop853": 1e-7, "dopri5": 1e-7, "radau": 1e-9}
"""Angles (rad), speeds and energies, relative: a hundred times the tolerance, or the tolerance by what has stages."""
ROWS = {"gauss": 60.0, "dop853": 60.0, "dopri5": 150.0, "radau": 400.0}
FAR = 0.62
"""Radians from the place up to which runs are compared."""


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

    @property
    def last(self) -> int:
        """The link at whose joint loads act: the output on its pivot, or the rod on the crank."""
        return 2 if self.branch.d else 1

    def turn(self, x: float, derivative: int) -> float:
        """The angle of that joint (rad), or a derivative of it by x."""
        angles = self.branch.angles(x, derivative)
        return angles[2] if self.branch.d else angles[1] - angles[0]


def passages(count: int, seed: int) -> list[Passage]:
    """The first ``count`` of ``seed``. What happens does so up to 0.01 s, or rad, before or after the place, on a scale
    of logarithms from 1e-9 on, and in half of them exactly there."""
    rng = np.random.default_rng(seed)
    found: list[Passage] = []
    while len(found) < count:
        branch = _drawn(rng)
        event = EVENTS[rng.integers(len(EVENTS))]
        strikes = event.startswith("strikes")
        found.append(
            Passage(
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
            )
        )
    return found


def _drawn(rng: np.random.Generator) -> OneBranch:
    """Lengths are whole parts of 1024, so that links lie in a line exactly."""

    def length(low: float, high: float) -> float:
        return float(np.round(rng.uniform(low, high) * 1024.0) / 1024.0)

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
        star = 0.5 * np.pi * place
        ways = np.abs(a * np.exp(1j * (star + np.linspace(-0.75, 0.75, 60))) - d)
        closes = np.all((ways > abs(b - c)) & (ways < b + c))
        in_line = min(abs(abs(a * np.exp(1j * star) - d) - way) for way in (b + c, abs(b - c))) < 1e-12
        if c >= 0.15 and abs(d - a) >= 0.1 and closes and in_line:
            return OneBranch(a, b, c, d, place, side, masses)


@dataclass(frozen=True)
class Case:
    """A scene, and what it is beside: its ``load`` and ``gap``, ``corners`` of the first, and when (s) it is at the
    place if nothing acts on it."""

    text: str
    begin: float
    load: Load
    corners: tuple[float, ...]
    gap: Callable[[float], float] | None
    passes: float


def case_of(one: Passage) -> Case | None:
    """``None`` where it does not get as far as the place, or the point that is to strike all but stands there, or
    could stand there in balance."""
    branch, begin = one.branch, one.branch.star + one.start
    v = float(-np.sign(one.start) * one.speed)
    passes = -one.start / v if one.driven else _passes(branch, begin, v)
    if passes is None:
        return None
    if one.event.startswith("strikes"):
        return _strike(one, begin, v, passes)
    at = passes + one.after
    extra, load = _acts(one, at)
    return Case(_scene(one, begin, v, extra, None), begin, load, (at,), None, passes)


def _acts(one: Passage, at: float) -> tuple[str, Load]:
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
        }[one.event]

    def load(t: float, x: float, v: float) -> float:
        way = one.turn(x, 1)
        return moment(t, x, way * v) * way

    return texts[one.event], load


def _strike(one: Passage, begin: float, v: float, passes: float) -> Case | None:
    """A point of a link comes to a ground so far from the place, or in it."""
    branch = one.branch
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
    return Case(_scene(one, begin, v, ground, point), begin, lambda t, x, v: 0.0, (), gap, passes)


def _passes(branch: OneBranch, begin: float, v: float) -> float | None:
    """When the branch is passed without loads, if it is within a quarter of a second."""
    motion = branch.run(begin, v, 0.25, lambda t, x, v: 0.0, gap=lambda x: float(np.sign(v)) * (branch.star - x) + 0.1)
    end, piece = motion.pieces[0]
    if (piece(end)[0] - branch.star) * (begin - branch.star) >= 0.0:
        return None
    return float(brentq(lambda t: piece(t)[0] - branch.star, 0.0, end, xtol=1e-16, rtol=8.9e-16))


def _scene(one: Passage, begin: float, v: float, extra: str, point: tuple[int, str] | None) -> str:
    branch, angles = one.branch, one.branch.angles(begin)
    text = f'name = "beside"\n[ground_link]\npoints = {{ O = [0, 0], Q = [{branch.d or 1.0!r}, 0] }}\n'
    for link, (name, mass, length) in enumerate(zip(NAMES, branch.masses, (branch.a, branch.b, branch.c), strict=True)):
        if link == 2 and not branch.d:
            text += (
                f'[[link]]\nname = "slider"\nmass = {mass}\npoints = {{ S = [0, 0] }}\ncom = [0, 0]\ninertia = 0.01\n'
            )
            continue
        more = point[1] if point and point[0] == link else ""
        text += (
            f'[[link]]\nname = "{name}"\nmass = {mass}\ninertia = {mass * length**2 / 12.0!r}\n'
            f"com = [{length / 2.0!r}, 0]\n"
            f"points = {{ A = [0, 0], B = [{length!r}, 0]{more} }}\n"
        )
    pins = {"axle": ("ground.O", "crank.A"), "pin": ("crank.B", "rod.A")}
    pins |= (
        {"end": ("rod.B", "rocker.B"), "hub": ("ground.Q", "rocker.A")} if branch.d else {"end": ("rod.B", "slider.S")}
    )
    for name, (first, second) in pins.items():
        text += (
            f'[[joint]]\nname = "{name if branch.d or name != "pin" else "hub"}"\nbetween = ["{first}", "{second}"]\n'
        )
    if not branch.d:
        text += '[[joint]]\ntype = "prismatic"\nbetween = ["ground.O", "slider.S"]\naxis = [1, 0]\n'
    told = ", ".join(f"{name} = {angle!r}" for name, angle in zip(NAMES, angles, strict=False))
    text += f"[start]\nangles = {{ {told} }}\n"
    if one.driven:
        text += f'[[drive]]\njoint = "axle"\nangle = "{begin!r} + ({v!r})*t"\n'
    else:
        text += f"angular_velocities = {{ crank = {v!r} }}\n"
    return text + extra + "[gravity]\n"


def reference(one: Passage, case: Case) -> tuple[Motion | None, float]:
    """The motion, if no drive gives it, and how long runs are compared with it (s)."""
    until = 2.0 * case.passes
    if one.driven:
        return None, min(until, case.passes + FAR / one.speed)
    v = float(-np.sign(one.start) * one.speed)
    motion = one.branch.run(case.begin, v, until, case.load, case.corners, case.gap, one.restitution)
    times = np.linspace(0.0, until, 400)
    away = [t for t in times if abs(motion.at(t)[0] - one.branch.star) > FAR]
    until = min([until, *(t - until / 400.0 for t in away)])
    strikes = [t for t, _ in motion.strikes if t < until]
    return motion, strikes[4] - 1e-5 if len(strikes) > 4 else until


def missed(one: Passage, case: Case, model: Model, run: Run, motion: Motion | None) -> dict[str, float]:
    """By how much a run misses angles (rad), speeds and efforts, relative to the largest, and its energy."""
    branch, v = one.branch, float(-np.sign(one.start) * one.speed)
    count = 3 if branch.d else 2
    columns = [model.q_names.index(f"theta_{list(model.links).index(name)}") for name in NAMES[:count]]
    turns = 2.0 * np.pi * np.round((run.q[0, columns] - branch.angles(case.begin)) / (2.0 * np.pi))
    near = case.passes + np.array([-1e-4, -1e-7, 0.0, 1e-7, 1e-4])
    times = np.unique(np.clip(np.concatenate([np.linspace(0.0, run.t[-1], 9), near]), 0.0, run.t[-1]))
    strikes = [t for t, _ in motion.strikes] if motion else []
    times = np.array([t for t in times if all(abs(t - strike) > 1e-6 for strike in strikes)])
    q, u = run.at(times)
    states = [(case.begin + v * t, v) if motion is None else motion.at(t) for t in times]
    angles, rates = (np.array([branch.angles(x, k) for x, _ in states]) for k in (0, 1))
    found = {
        "angles": float(np.max(np.abs(q[:, columns] - turns - angles))),
        "speeds": float(np.max(np.abs(u[:, columns] - rates * np.array([[v] for _, v in states]))) / one.speed),
        "energy": run.energy_drift / float(np.max(model.energy(run.q, run.u)[0])),
    }
    smooth = [k for k, t in enumerate(times) if all(abs(t - corner) > 1e-6 for corner in case.corners)]
    if one.driven:
        wanted = []
        for k in smooth:
            _, change, weight = branch.masses_and_weights(states[k][0])
            wanted.append(0.5 * change * v**2 + weight - case.load(times[k], states[k][0], v))
        got = run.reactions(times[smooth])[:, model.joints.index("axle"), 2]
        found["efforts"] = float(np.max(np.abs(got - wanted)) / (1.0 + np.max(np.abs(wanted))))
    return found


@pytest.mark.parametrize(("count", "seed"), [(4, 1), hard(many(24, 1000), 2)], ids=str)
def test_what_happens_beside_a_change_point(count: int, seed: int, workshop: Workshop, reach: Reach) -> None:
    """The branch is kept, and states, efforts and energies are those of the equation; impacts as many."""
    most: dict[tuple[str, str], float] = {}
    wrong, seen = [], set[str]()
    for one in passages(count, seed):
        case = case_of(one)
        if case is None:
            continue
        model = workshop.model(case.text)
        motion, until = reference(one, case)
        strikes = sum(t < until for t, _ in motion.strikes) if motion else 0
        for method in METHODS:
            run = simulate(model, until=until, method=method)
            assert run.success, (one, method, run.message)
            found = missed(one, case, model, run, motion)
            if len(run.impacts) != strikes or not all(much <= 1e-7 for much in found.values()):
                wrong.append(f"{method}: {found}, {len(run.impacts)} impacts for {strikes}\n{case.text}")
            for what, much in (*found.items(), ("rows", float(len(run.t)))):
                most[method, what] = max(most.get((method, what), 0.0), much)
        seen.add(one.event)
    assert not wrong, "\n".join(wrong)
    assert len(seen) >= min(len(EVENTS), count) - 1
    for (method, what), much in most.items():
        bound = 1e-8 if what == "efforts" else ROWS[method] if what == "rows" else MISSED[method]
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
