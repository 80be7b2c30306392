"""Loads with kinks or curves of their own in random mechanisms: springs with play, brakes, Stribeck's curve, and
contacts that give way, each as a table of a scene and as forces written out by vectors.

Each ``add`` puts a load of a kind into a sketch; the function that it leaves there acts in wide numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from .loads import Acting
from .maximal import GROUND, Array

KINDS = ("spring with play", "torsion with play", "brake", "stribeck", "compliant ground", "compliant touch")

SLOWEST = 0.001
"""The approach (m/s) below which damping grows no more, where a scene does not say it."""


def dead_zone(x: Any, rate: Any, play: float, stiffness: float, damping: float) -> tuple[Any, Any, Any]:
    """What draws x back, the energy stored, and the power of damping."""
    beyond = abs(x) - play / 2
    if beyond <= 0:
        return x * 0, x * 0, x * 0
    way = np.sign(x)
    drawing = max(stiffness * beyond + damping * way * rate, 0 * x)
    return way * drawing, stiffness * beyond**2 / 2, (stiffness * beyond - drawing) * way * rate


def press(depth: Any, approach: Any, slip: Any, law: dict[str, float]) -> tuple[Any, Any, Any, Any]:
    """Normal force and friction against the slip, energy stored, and the power of damping and friction."""
    if depth <= 0:
        return (0 * depth,) * 4
    load, unit, n = law["load"], law["depth"], law["exponent"]
    elastic = load * (depth / unit) ** n
    damping = law.get("damping", 0.0)
    if "restitution" in law:  # after Lankarani and Nikravesh, of a contact that begins here
        damping = 0.75 * (1 - law["restitution"] ** 2) / max(approach, SLOWEST)
    push = elastic * max(1 + damping * approach, 0 * depth)
    drag = -law["friction"] * push * np.tanh(slip / law["slip_speed"])
    stored = load * unit * (depth / unit) ** (n + 1) / (n + 1)
    return push, drag, stored, (elastic - push) * approach + drag * slip


def add(sketch: Any, kind: str, rng: np.random.Generator) -> None:
    """A load of the kind, somewhere."""
    _ADD[kind](sketch, rng)


def _two(sketch: Any, rng: np.random.Generator) -> tuple[int, int]:
    links = len(sketch.poses)
    first = int(rng.integers(links))
    return first, int(rng.choice([k for k in range(-1, links) if k != first]))


def _near(sketch: Any, link: int, rng: np.random.Generator) -> Array:
    return np.asarray((np.zeros(2) if link == GROUND else sketch.poses[link, :2]) + rng.uniform(-0.7, 0.7, 2))


def _joint(sketch: Any, rng: np.random.Generator) -> int | None:
    return int(rng.integers(len(sketch.kinds))) if sketch.kinds else None


def _spring(sketch: Any, rng: np.random.Generator) -> None:
    ends = [(link, *sketch.point(link, _near(sketch, link, rng))) for link in _two(sketch, rng)]
    one, other = ((link, on) for link, _, on in ends)
    stiffness, length, play, damping = (float(x) for x in rng.uniform((0.5, 0.3, 0.1, 0.1), (3.0, 1.0, 1.0, 0.5)))
    sketch.tables.append(
        f'[[spring]]\nbetween = ["{ends[0][1]}", "{ends[1][1]}"]\nstiffness = {stiffness!r}\nlength = {length!r}\n'
        f"play = {play!r}\ndamping = {damping!r}"
    )

    def act(acting: Acting) -> None:
        (p, v), (p2, v2) = acting.at(one), acting.at(other)
        long = np.sqrt((p2 - p) @ (p2 - p))
        line = (p2 - p) / long
        pull, stored, power = dead_zone(long - length, line @ (v2 - v), play, stiffness, damping)
        acting.push(one, pull * line)
        acting.push(other, -pull * line)
        acting.potential += stored
        acting.power += power

    sketch.acts.append(act)


def _torsion(sketch: Any, rng: np.random.Generator) -> None:
    joint = _joint(sketch, rng)
    if joint is None or sketch.kinds[joint][0] != "pin":
        return
    pin = sketch.pins[sketch.kinds[joint][1]]
    stiffness, angle, play, damping = (float(x) for x in rng.uniform((0.5, -3, 0.1, 0.1), (3.0, 3.0, 2.0, 0.5)))
    sketch.tables.append(
        f'[[torsion]]\njoint = "joint_{joint}"\nstiffness = {stiffness!r}\nangle = {angle!r}\nplay = {play!r}\n'
        f"damping = {damping!r}"
    )

    def act(acting: Acting) -> None:
        turn, rate = acting.turn(pin.a, pin.b)
        moment, stored, power = dead_zone(turn - angle, rate, play, stiffness, damping)
        acting.twist(pin.a, pin.b, -moment)
        acting.potential += stored
        acting.power += power

    sketch.acts.append(act)


def _rubbing(sketch: Any, joint: int, table: str, curve: Callable[[Any], Any]) -> None:
    """A table at a joint whose moment, or force along its line, against a rate is that of a ``curve``."""
    kind, index = sketch.kinds[joint]
    sketch.tables.append(table)

    def act(acting: Acting) -> None:
        if kind == "slot":
            rate = sketch.slide_speed(acting, index)
            effort = -curve(rate)
            sketch.slide_effort(acting, index, effort)
        else:
            pin = sketch.pins[index]
            rate = acting.turn(pin.a, pin.b)[1]
            effort = -curve(rate)
            acting.twist(pin.a, pin.b, effort)
        acting.power += effort * rate

    sketch.acts.append(act)


def _brake(sketch: Any, rng: np.random.Generator) -> None:
    joint = _joint(sketch, rng)
    if joint is None:
        return
    most, about = (float(x) for x in rng.uniform((0.5, 0.1), (3.0, 1.0)))
    key = "force" if sketch.kinds[joint][0] == "slot" else "torque"
    when = "begins = 0.5\n" if rng.random() < 0.3 else "ends = 0.5\n"
    table = f'[[brake]]\njoint = "joint_{joint}"\n{key} = {most!r}\n{when}rate = {about!r}'
    size = 0.0 if when.startswith("begins") else most
    _rubbing(sketch, joint, table, lambda rate: size * np.tanh(rate / about))


def _stribeck(sketch: Any, rng: np.random.Generator) -> None:
    joint = _joint(sketch, rng)
    if joint is None:
        return
    viscous, dry, more, slow = (float(x) for x in rng.uniform((0.1, 0.5, 0.1, 0.5), (1.0, 2.0, 1.0, 2.0)))
    table = (
        f'[[joint_friction]]\njoints = ["joint_{joint}"]\nviscous = {viscous!r}\ndry = {dry!r}\n'
        f"breakaway = {dry + more!r}\nstribeck = {slow!r}\nrate = {0.2 * slow!r}"
    )
    _rubbing(
        sketch,
        joint,
        table,
        lambda rate: viscous * rate + (dry + more * np.exp(-((rate / slow) ** 2))) * np.tanh(rate / (0.2 * slow)),
    )


def _law(rng: np.random.Generator) -> tuple[dict[str, float], str]:
    """A law of contact, its damping after Hunt and Crossley, or after Lankarani and Nikravesh."""
    numbers = rng.uniform((1.0, 0.05, 0.1, 0.1, 0.05), (5.0, 0.2, 1.0, 0.6, 0.3))
    law = dict(zip(("load", "depth", "damping", "friction", "slip_speed"), map(float, numbers), strict=True))
    law["exponent"] = float(rng.choice([1.0, 1.5, 2.0, 2.5, 3.0]))
    if rng.random() < 0.5:
        law["restitution"] = law.pop("damping")
    return law, "\n".join(f"{key} = {value!r}" for key, value in law.items())


def _ground(sketch: Any, rng: np.random.Generator) -> None:
    link = int(rng.integers(len(sketch.poses)))
    there, turn = _near(sketch, link, rng), rng.uniform(-3.0, 3.0)
    name, on = sketch.point(link, there)
    radius, deep = float(rng.uniform(0.0, 0.3)), float(rng.uniform(-0.05, 0.3))
    normal = np.array([np.cos(turn), np.sin(turn)])
    foot = there - (radius - deep) * normal
    law, text = _law(rng)
    sketch.tables.append(
        f'[[compliant_ground]]\npoint = {foot.tolist()}\nnormal = {normal.tolist()}\ncontacts = ["{name}"]\n'
        f"radius = {radius!r}\n{text}"
    )

    def act(acting: Acting) -> None:
        centre = acting.at((link, on))[0]
        depth = radius - normal @ (centre - foot)
        _push_apart(acting, link, GROUND, centre, normal.astype(centre.dtype), radius, radius - depth, depth, law)

    sketch.acts.append(act)


def _touch(sketch: Any, rng: np.random.Generator) -> None:
    a, b = _two(sketch, rng)
    there, turn = _near(sketch, a, rng), rng.uniform(-3.0, 3.0)
    name, on = sketch.point(a, there)
    radii, deep = rng.uniform(0.1, 0.3, 2), float(rng.uniform(-0.05, 0.2))
    normal = np.array([np.cos(turn), np.sin(turn)])
    along = np.array([normal[1], -normal[0]])
    foot = there - (radii.sum() - deep) * normal
    places = [foot] if rng.random() < 0.5 else [foot - 0.4 * along, foot + float(rng.choice([0.5, -0.02])) * along]
    ends = [sketch.point(b, place) for place in places]
    second = f'"{ends[0][0]}"' if len(ends) == 1 else str([end[0] for end in ends]).replace("'", '"')
    law, text = _law(rng)
    sketch.tables.append(
        f'[[compliant_touch]]\nbetween = ["{name}", {second}]\nradius = {[float(r) for r in radii]}\n{text}'
    )

    def act(acting: Acting) -> None:
        centre, start, end = (acting.at(place)[0] for place in ((a, on), (b, ends[0][1]), (b, ends[-1][1])))
        line = end - start
        share = min(max((centre - start) @ line / (line @ line), 0), 1) if len(ends) == 2 else 0
        off = centre - start - share * line
        away = np.sqrt(off @ off)
        _push_apart(acting, a, b, centre, off / away, radii[0], away - radii[1], radii.sum() - away, law)

    sketch.acts.append(act)


def _push_apart(
    acting: Acting,
    a: int,
    b: int,
    centre: Array,
    normal: Array,
    radius: Any,
    reach: Any,
    depth: Any,
    law: dict[str, float],
) -> None:
    """Forces at the two places where the surfaces would touch: ``radius`` and ``reach`` from the centre against the
    ``normal``. Friction acts on each where it is; the depth between them is small, but not neglected."""
    along = np.array([normal[1], -normal[0]])
    places = (centre - radius * normal, centre - reach * normal)
    speeds = [acting.carried(link, place) for link, place in zip((a, b), places, strict=True)]
    apart = speeds[0] - speeds[1]
    push, drag, stored, power = press(depth, -normal @ apart, along @ apart, law)
    for link, place, sign in zip((a, b), places, (1, -1), strict=True):
        acting.push_there(link, place, sign * (push * normal + drag * along))
    acting.potential += stored
    acting.power += power


_ADD: dict[str, Callable[[Any, np.random.Generator], None]] = {
    "spring with play": _spring,
    "torsion with play": _torsion,
    "brake": _brake,
    "stribeck": _stribeck,
    "compliant ground": _ground,
    "compliant touch": _touch,
}
