"""Branches of periodic motions as a table for other programs."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..files import read_path, write_whole
from .branch import Branch
from .orbit import Orbit
from .values import names_of, unit_of


def write_branches(branches: Sequence[Branch], path: str | os.PathLike[str]) -> Path:
    """Write branches as CSV, a line for each motion in the order of the curve, bifurcations among them by their kind.

    Columns: the branch's number, the parameter, the kind of bifurcation or nothing, whether it is stable (1 or 0), the
    period, real and imaginary parts of the multipliers, largest first, then coordinates and rates on the section.
    """
    target = read_path(path, "a file")
    orbits = [orbit for branch in branches for orbit in branch.orbits]
    count = max(len(orbit.multipliers) for orbit in orbits)
    names = names_of(orbits[0].return_map.model)
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    parts = [f"{part}(multiplier {k})" for k in range(count) for part in ("re", "im")]
    states = [f"{name} [{unit_of(name)}]" for name in names]
    table.writerow(["branch", branches[0].parameter, "bifurcation", "stable", "period [s]", *parts, *states])
    for number, branch in enumerate(branches):
        rows = [
            (float(k), value, "", orbit)
            for k, (value, orbit) in enumerate(zip(branch.values.tolist(), branch.orbits, strict=True))
        ]
        rows += [(one.place, one.value, one.kind, one.orbit) for one in branch.bifurcations]
        for _, value, kind, orbit in sorted(rows, key=lambda row: row[0]):
            table.writerow([number, repr(value), kind, int(orbit.stable), repr(orbit.period), *_numbers(orbit, count)])
    write_whole(target, lambda part: part.write(text.getvalue().encode()))
    return target


def _numbers(orbit: Orbit, count: int) -> list[str]:
    """Multipliers, with nothing where there are fewer, and the state."""
    multipliers = [repr(float(x)) for one in orbit.multipliers for x in (one.real, one.imag)]
    multipliers += [""] * (2 * count - len(multipliers))
    return multipliers + [repr(float(x)) for x in np.concatenate([orbit.q, orbit.u])]
