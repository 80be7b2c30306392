"""The shorthand forms ``[loop]``, ``[chain]``, ``[pinned]`` and ``[four_bars]`` as mechanism records.

Link k runs from joint k (its point A, the origin of its frame) to joint k+1 (its point B, on the frame's x axis).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..mechanism.joints import Joint, PointRef
from ..mechanism.links import GROUND, POSITIVE, Link, Parameter, Point
from ..mechanism.mechanism import Mechanism
from .bodies import Bodies, point
from .errors import Path, Report
from .schema import ChainTable, FourBarsTable, LoopTable, PinnedTable, Rods

FEWEST = {"loop": 3, "chain": 1, "pinned": 2}
"""The smallest number of links of each form."""


def shorthand(form: str, table: LoopTable | ChainTable | PinnedTable | FourBarsTable, report: Report) -> Bodies | None:
    """The links of ``table`` as ``form`` says: in a row, or a row of four-bars; ``None`` after faults."""
    if isinstance(table, FourBarsTable):
        return _four_bars(table, report)
    fewest = FEWEST[form]
    if table.links < fewest:
        report.add((form, "links"), f"found {table.links}, expected at least {fewest} for [{form}]; {_more(form)}")
        return None
    lengths = _per_link(table.length, table.links, (form, "length"), report)
    masses = _per_link(table.mass, table.links, (form, "mass"), report)
    coms = _coms(table, (form, "com"), report)
    inertias = _inertias(table, masses, lengths, (form, "inertia"), report)
    if lengths is None or masses is None or coms is None or inertias is None:
        return None
    rods = tuple(
        _rod(index, length, mass, inertia, com or (length / 2.0, 0.0))
        for index, (length, mass, inertia, com) in enumerate(zip(lengths, masses, inertias, coms, strict=True))
    )
    if isinstance(table, PinnedTable):
        return _pinned(table, rods, lengths, report)
    if isinstance(table, ChainTable):
        return _chain(rods, table.hinged)
    return _loop(rods, lengths, report)


def _more(form: str) -> str:
    return {"loop": "use more links, or [pinned] or [chain]", "pinned": "use more links, or [chain]"}.get(
        form, "use more links"
    )


def _per_link(given: float | Sequence[float], count: int, path: Path, report: Report) -> list[float] | None:
    """One value per link, or ``None`` after a fault."""
    if not isinstance(given, Sequence):
        return [given] * count
    if len(given) != count:
        report.add(path, f"found {len(given)} numbers, expected one number or {count}, one per link; correct the list")
        return None
    return list(given)


def _inertias(
    table: Rods, masses: list[float] | None, lengths: list[float] | None, path: Path, report: Report
) -> list[float] | None:
    """Inertia of each link about its centre of mass (kg m²), that of a uniform rod unless given."""
    if table.inertia is not None:
        return _per_link(table.inertia, table.links, path, report)
    if masses is None or lengths is None:
        return None
    found = [mass * length * length / 12.0 for mass, length in zip(masses, lengths, strict=True)]
    if not all(0.0 < inertia < math.inf for inertia in found):
        report.add(
            path, f"found {min(found):.3g} to {max(found):.3g}, expected positive finite numbers; give an inertia"
        )
        return None
    return found


def _coms(table: Rods, path: Path, report: Report) -> list[tuple[float, float] | None] | None:
    """Centre of mass of each link (m), ``None`` for the middle; a pair of numbers is one point for every link."""
    given, count = table.com, table.links
    if given is None:
        return [None] * count
    if isinstance(given, float | int):
        return [(given, 0.0)] * count
    pair = len(given) == 2 and all(isinstance(value, float | int) for value in given)
    if pair and count == 2:
        report.add(path, "found two numbers, expected either [x, y] or one per link; write [[x, y], [x, y]]")
        return None
    per_link = [given] * count if pair else given
    if len(per_link) != count:
        message = f"found {len(per_link)} values, expected one or {count}, one per link; correct the list"
        report.add(path, message)
        return None
    return [(one[0], one[1]) if isinstance(one, list) else (one, 0.0) for one in per_link]  # type: ignore[misc]


def _rod(
    index: int, length: float, mass: float, inertia: float, com: tuple[float, float], name: str | None = None
) -> Link:
    """One link from A = (0, 0) to B = (length, 0)."""
    name = name or f"link_{index}"
    return Link(
        name=name,
        mass=Parameter(f"{name}.mass", f"m_{index}", mass, POSITIVE),
        inertia=Parameter(f"{name}.inertia", f"I_{index}", inertia, POSITIVE),
        com=point(f"{name}.com", f"c_{index}", *com),
        points={"A": Point(), "B": Point(Parameter(f"{name}.length", f"l_{index}", length, POSITIVE))},
    )


def _between(index: int) -> Joint:
    """Joint ``index`` between the links on its two sides."""
    return Joint(f"joint_{index}", PointRef(index - 1, "B"), PointRef(index, "A"))


def _loop(rods: tuple[Link, ...], lengths: Sequence[float], report: Report) -> Bodies | None:
    count = len(rods)
    if not _closes([(rod.name, length) for rod, length in zip(rods, lengths, strict=True)], ("loop", "length"), report):
        return None
    closing = Joint("joint_0", PointRef(count - 1, "B"), PointRef(0, "A"))
    joints = (closing, *(_between(index) for index in range(1, count)))
    sketch = tuple(2.0 * math.pi * (index + 0.5) / count for index in range(count))
    return Bodies(Mechanism(rods, {}, joints), (), sketch, ("loop",))


def _chain(rods: tuple[Link, ...], hinged: bool) -> Bodies:
    count = len(rods)
    last = (f"link_{count - 1}.B", PointRef(count - 1, "B"))
    joints = tuple(_between(index) for index in range(1, count))
    sketch = (0.0,) * count
    if hinged:
        foot = Joint("joint_0", PointRef(GROUND, "O"), PointRef(0, "A"))
        return Bodies(Mechanism(rods, {"O": Point()}, (foot, *joints)), (last,), sketch, ("chain",))
    return Bodies(Mechanism(rods, {}, joints), (("link_0.A", PointRef(0, "A")), last), sketch, ("chain",))


def _pinned(table: PinnedTable, rods: tuple[Link, ...], lengths: Sequence[float], report: Report) -> Bodies | None:
    """Both ends on the ground, at O = (0, 0) and E = (span, 0); the sketch hangs below as a regular polygon."""
    count = len(rods)
    span = math.fsum(lengths) / count if table.span is None else table.span
    sides = [(rod.name, length) for rod, length in zip(rods, lengths, strict=True)] + [("the span", span)]
    if not _closes(sides, ("pinned", "length" if table.span is None else "span"), report):
        return None
    supports = {"O": Point(), "E": Point(Parameter("ground.span", "l_g", span, POSITIVE))}
    first = Joint("joint_0", PointRef(GROUND, "O"), PointRef(0, "A"))
    last = Joint(f"joint_{count}", PointRef(count - 1, "B"), PointRef(GROUND, "E"))
    joints = (first, *(_between(index) for index in range(1, count)), last)
    sketch = tuple(2.0 * math.pi * (index + 1) / (count + 1) - math.pi for index in range(count))
    return Bodies(Mechanism(rods, supports, joints), (), sketch, ("pinned",))


def _four_bars(table: FourBarsTable, report: Report) -> Bodies | None:
    """Uprights from A_i = (i l, 0) to B_i, bars from B_{i-1} to B_i; upright, the first head at 1 m/s along x."""
    length, mass, count = table.length, table.mass, table.count
    inertia = mass * length * length / 12.0
    if not 0.0 < inertia < math.inf:
        report.add(("four_bars",), f"found rods of inertia {inertia:.3g}, expected a positive finite number")
        return None
    names = [f"upright_{k}" for k in range(count + 1)] + [f"bar_{k}" for k in range(1, count + 1)]
    rods = tuple(_rod(k, length, mass, inertia, (length / 2.0, 0.0), name) for k, name in enumerate(names))
    feet = {f"A_{k}": point(f"ground.points.A_{k}", f"l_g_{k}", k * length, 0.0) for k in range(count + 1)}
    joints = [Joint(f"foot_{k}", PointRef(GROUND, f"A_{k}"), PointRef(k, "A")) for k in range(count + 1)]
    for bar in range(count + 1, 2 * count + 1):
        right = bar - count
        joints.append(Joint(f"head_{right - 1}_right", PointRef(right - 1, "B"), PointRef(bar, "A")))
        joints.append(Joint(f"head_{right}_left", PointRef(right, "B"), PointRef(bar, "B")))
    sketch = (math.pi / 2.0,) * (count + 1) + (0.0,) * count
    rates = (-1.0 / length, *(None,) * (2 * count))
    return Bodies(Mechanism(rods, feet, tuple(joints)), (), sketch, ("four_bars",), rates)


def _closes(sides: Sequence[tuple[str, float]], path: Path, report: Report) -> bool:
    """The longest side is no longer than the others together, or else no configuration closes."""
    name, longest = max(sides, key=lambda side: side[1])
    others = math.fsum(length for _, length in sides) - longest
    missing = longest - others
    if missing <= 1e-12 * longest:
        return True
    report.add(
        path,
        f"found {name} {longest:.6g} m long and the others {others:.6g} m together, expected a chain that can close; "
        f"it misses by {missing:.6g} m, change the lengths",
    )
    return False
