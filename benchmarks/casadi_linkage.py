"""Forward dynamics of any linkage of pins by CasADi: its sparse LDL of the system in maximal coordinates, as C.

The unknowns stand in a greedy order of least fill, which a user would write who knows that it matters: always the one
whose elimination joins the fewest pairs of others. A joint's force may go only after one of its links has, since its
diagonal entry is zero until then.
"""

from importlib import import_module
from itertools import combinations
from pathlib import Path
from typing import Any

from ccgen.generator.mechanism.links import GROUND
from ccgen.generator.mechanism.mechanism import Mechanism

FUNCTION = "casadi_linkage"

Unknown = tuple[str, int, str]
"""("link" or "joint", its number, "x", "y" or "turn")."""


def write_source(mechanism: Mechanism, gravity: float, folder: Path, name: str) -> Path:
    """Write C of (angles, rates) -> angular accelerations of all links; the data are baked in as constants."""
    ca = import_module("casadi")
    angles, rates = (ca.SX.sym(letter, len(mechanism.links)) for letter in "qu")
    found = _accelerations(ca, mechanism, gravity, angles, rates)
    path = folder / f"casadi_{name}.c"
    generator = ca.CodeGenerator(path.name, {"with_header": False})
    generator.add(ca.Function(FUNCTION, [angles, rates], [found], {"cse": True}))
    path.write_text(generator.dump())
    return path


def least_fill(near: dict[Unknown, set[Unknown]], ready: set[Unknown]) -> list[Unknown]:
    """All unknowns; ``near`` says who shares an equation with whom, ``ready`` may go at once.

    Of equal ones the first goes: links before joints, which keeps digits.
    """
    order = []
    while near:

        def fill(unknown: Unknown) -> tuple[int, int]:
            around = near[unknown]
            return sum(b not in near[a] for a, b in combinations(around, 2)), len(around)

        chosen = min((unknown for unknown in near if unknown in ready), key=fill)
        around = near.pop(chosen)
        order.append(chosen)
        ready |= around
        for one in around:
            near[one] = (near[one] | around) - {one, chosen}
    return order


def _accelerations(ca: Any, mechanism: Mechanism, gravity: float, angles: Any, rates: Any) -> Any:
    links = range(len(mechanism.links))
    near: dict[Unknown, set[Unknown]] = {("link", k, axis): set() for k in links for axis in ("x", "y", "turn")}
    ready = set(near)
    entries: dict[tuple[Unknown, Unknown], Any] = {}
    right: dict[Unknown, Any] = {}
    for k, link in enumerate(mechanism.links):
        mass, inertia = (p.value if p else 0.0 for p in (link.mass, link.inertia))
        for axis, value in (("x", mass), ("y", mass), ("turn", inertia)):
            entries[("link", k, axis), ("link", k, axis)] = value
        right["link", k, "y"] = -gravity * mass
    for j, joint in enumerate(mechanism.joints):
        for side, sign in ((joint.first, -1.0), (joint.second, 1.0)):
            if side.link == GROUND:
                continue
            link = mechanism.links[side.link]
            (x, y), (cx, cy) = mechanism.point(side).values(), link.com.values()
            c, s = ca.cos(angles[side.link]), ca.sin(angles[side.link])
            arm = (c * (x - cx) - s * (y - cy), s * (x - cx) + c * (y - cy))
            for axis, turned, along in (("x", -arm[1], arm[0]), ("y", arm[0], arm[1])):
                row: Unknown = ("joint", j, axis)
                near.setdefault(row, set())
                for other, entry in ((axis, sign), ("turn", sign * turned)):
                    column: Unknown = ("link", side.link, other)
                    entries[row, column] = entries[column, row] = entry
                    near[row].add(column)
                    near[column].add(row)
                right[row] = right.get(row, 0.0) + sign * rates[side.link] ** 2 * along
    order = least_fill(near, ready)
    place = {unknown: number for number, unknown in enumerate(order)}
    system, known = ca.SX(len(order), len(order)), ca.SX(len(order), 1)
    for (row, column), entry in entries.items():
        system[place[row], place[column]] = entry
    for row, entry in right.items():
        known[place[row]] = entry
    diagonal, factor, given = ca.ldl(system, False)
    solved = ca.ldl_solve(known, diagonal, factor, given)
    return ca.vertcat(*(solved[place["link", k, "turn"]] for k in links))
