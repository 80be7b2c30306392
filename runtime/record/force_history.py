"""Forces of contacts and joints over a whole run: where they are largest, and as a table for other programs."""

from __future__ import annotations

import csv
import io
import os
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..files import read_path, write_whole
from ..model.meshes import mesh_forces, mesh_names
from .outputs import Sample, drive_effort, drive_power, driven_joints, headings_of
from .peaks import find_peaks
from .record import Record

INSTANTS = 1000
"""Least number of instants between the start of a run and its end."""
DEPENDENT = 1e-12
"""Part of the largest singular value: rows that others imply have less by rounding of sums over links."""
GROWS = 1.4
"""Times the size an instant before, three times in a row: what has no bound grows so towards the end of a run whose
steps come to a half and less of each other there, as the root of one by the distance at least."""
BEFORE = 1e-9
"""Part of a phase by which its end is looked at earlier: forces change by as little, places by more than rounding."""


@dataclass(frozen=True, eq=False)
class History:
    """Forces at times t (n,): ``pushes`` (n, contacts, 2), ``reactions`` (n, joints, 3) and those of the ``meshes``
    (n, meshes), as those of a run. Of ``drives`` (n, drives, 2) the torque (N m), or the force along a line (N), on the
    second link, and the power (W) that it gives.

    Instants at which forces jump are there twice, with what they are just before and after. ``beside``
    (n, quantities), of ``sizes``, says which are without bound, or may be: where joints of links in a line have to
    carry without bound, next to instants at which links are so nearly in a line that no force is known, and at the end
    of a run that cannot go on where they grow towards it as what has no bound does.
    """

    t: FloatArray
    pushes: FloatArray
    reactions: FloatArray
    meshes: FloatArray
    drives: FloatArray
    beside: NDArray[np.bool_]

    @property
    def parts(self) -> tuple[Any, ...]:
        """All arrays, in their order."""
        return tuple(getattr(self, one.name) for one in fields(self))

    def rows(self, chosen: NDArray[np.bool_] | NDArray[np.intp]) -> History:
        """Those at some of the times."""
        return History(*(part[chosen] for part in self.parts))

    @property
    def known(self) -> NDArray[np.bool_]:
        """Where contacts and joints have forces, with or without bound (n,)."""
        every = np.concatenate([self.pushes[:, :, 0], self.pushes[:, :, 1], *np.moveaxis(self.reactions, 2, 0)], axis=1)
        return np.asarray(~np.isnan(every).any(axis=1))

    @property
    def sizes(self) -> FloatArray:
        """What is told of the largest of (n, quantities): normal forces, forces of meshes and joints, efforts of
        drives, and the powers that they give and take up."""
        joints = np.hypot(self.reactions[:, :, 0], self.reactions[:, :, 1])
        effort, power = self.drives[:, :, 0], self.drives[:, :, 1]
        return np.hstack([self.pushes[:, :, 0], np.abs(self.meshes), joints, np.abs(effort), power, -power])

    @property
    def first_joint(self) -> int:
        """The number of quantities before those of joints, normal forces and forces of meshes."""
        return int(self.pushes.shape[1] + self.meshes.shape[1])

    @property
    def far(self) -> NDArray[np.bool_]:
        """Which ``sizes`` (n, quantities) are not on a slope that rises to where they are without bound."""
        sizes = np.abs(self.sizes)
        columns = [away_from_lines(self.t, *both) for both in zip(sizes.T, self.beside.T, strict=True)]
        return np.array(columns, dtype=bool).reshape(sizes.T.shape).T

    @property
    def away(self) -> FloatArray:
        """The ``sizes``, zero where they are not ``far`` from where they are without bound."""
        return np.where(self.far, self.sizes, 0.0)

    def far_of_joints(self) -> NDArray[np.bool_]:
        """``far`` of the forces of joints (n, joints)."""
        return self.far[:, self.first_joint :][:, : self.reactions.shape[1]]

    def far_of_drives(self) -> NDArray[np.bool_]:
        """``far`` of the efforts of drives and of the powers that they give and take (n, 3, drives)."""
        first = self.first_joint + self.reactions.shape[1]
        return self.far[:, first:].reshape(len(self.t), 3, self.drives.shape[1])


def history(run: Record, instants: int = INSTANTS) -> History:
    """The forces at every row of a run and at ``instants`` even times, and at changes of contact on both sides.

    The last instant of a run that stopped early is left out: forces may have no solution there. So are those
    where it went on by time stepping.
    """
    if run.motion is None:
        raise ValueError("this run knows no forces: it was not made by simulate")
    even = np.linspace(run.t[0], run.t[-1], instants + 1, dtype=run.t.dtype)
    times = np.union1d(even, run.t)
    if not run.success and len(times) > 1:
        times = times[:-1]
    jumps = np.union1d(run.motion.since, np.array([impact.t for impact in run.impacts], dtype=run.t.dtype))
    jumps = jumps[(jumps > run.t[0]) & (jumps <= times[-1])]
    t = np.concatenate([jumps, times])
    asked = np.concatenate([_just_before(run, jumps), times])
    order = np.argsort(t, kind="stable")
    found = replace(_forces(run, asked[order]), t=t[order])
    if not found.known.any():
        raise ValueError("this run knows no forces: it went by time stepping, which records none")
    looked = asked[order]
    steps = [(looked >= phase.start) & (looked < phase.end) for phase in run.phases if phase.kind == "steps"]
    line = np.pad(~found.known & ~np.any(steps, axis=0), 1) if steps else np.pad(~found.known, 1)
    beside = ~np.isfinite(found.sizes)
    beside[:, found.first_joint :] |= (line[:-2] | line[2:])[:, None]
    found = replace(found, beside=beside).rows(found.known)
    if not run.success and len(found.t) > 3 and np.all(np.diff(found.t[-4:]) > 0.0):
        sizes = np.abs(found.sizes[-4:])  # towards a dead point, say, or where friction jams; events shrink their steps
        found.beside[-1] |= np.all((sizes[1:] > GROWS * sizes[:-1]) & (sizes[:-1] > 0.0), axis=0)
    return found


def with_peaks(run: Record, found: History) -> tuple[History, FloatArray]:
    """A run's ``history`` with the instants added at which the largest forces are between those that are looked at.

    And the times (k,) at which links passed a line between two of these, so that no instant beside it was looked at:
    forces of joints may have no bound there. Their instants next to such a time are ``beside`` it, and those of others
    that rise as high as what has none.
    """
    passed: dict[int, float] = {}
    joints = slice(found.first_joint, found.first_joint + found.reactions.shape[1])
    while True:
        peaks = find_peaks(found.t, found.away, lambda t: _forces(run, t).sizes, ~found.beside)
        spikes = np.unique(peaks.row[peaks.spikes]).tolist()
        rows = [row for row in spikes if _passes_a_line(run, found.t[row - 1], found.t[row + 1])]
        if not rows:
            break
        passed |= {row: peaks.t[peaks.row == row][0] for row in rows}
        here = peaks.spikes & np.isin(peaks.row, rows)
        beside = found.beside.copy()
        beside[peaks.row[here], peaks.column[here]] = True
        for row in rows:  # whichever side of the line the instant is on; a small pole on much else is no spike
            beside[[row, _across(found.t, row, passed[row])], joints] = True
        found = replace(found, beside=beside)
    times = np.setdiff1d(peaks.t, found.t)
    if len(times):
        more = _forces(run, times)
        more = more.rows(more.known)
        beside = ~np.isfinite(more.sizes)
        for row in passed:  # where a drive's torque has its peak, say, forces of joints may be on the slope to a pole
            between = (more.t > found.t[row - 1]) & (more.t < found.t[row + 1])
            beside[between, joints] = True
        more = replace(more, beside=beside)
        both = History(*(np.concatenate([one, other]) for one, other in zip(found.parts, more.parts, strict=True)))
        found = both.rows(np.argsort(both.t, kind="stable"))
    return found, np.array([passed[row] for row in sorted(passed)], dtype=found.t.dtype)


def _across(t: FloatArray, row: int, passed: float) -> int:
    """The instant of t (n,) next to ``row`` on the other side of the time ``passed``."""
    return row + 1 if t[row] <= passed else row - 1


def _passes_a_line(run: Record, before: float, after: float) -> bool:
    """Whether the rows of the closure become dependent between two times near each other.

    Of their singular vectors before, w A v = s, the least s shrinks to zero there and w A v has the other sign behind.
    Where several do, as of two linkages alike, no one vector has a partner of its own: what w A v / s of all of them is
    behind, the identity if nothing happens, has an eigenvalue below zero then. Where all joints of the closure are
    open, all rows are zero and none becomes dependent.
    """
    t = np.array([before, after])
    model: Any = run.in_force.models[int(run.in_force.at(t)[0])]
    if not len(model.rows):
        return False
    one, other = np.asarray(model.jacobian(run.at(t)[0]), dtype=float)
    left, values, right = np.linalg.svd(one, full_matrices=False)
    rank = int(np.count_nonzero(values > DEPENDENT * values[0]))
    if rank == 0:
        return False
    behind = left[:, :rank].T @ other @ right[:rank].T / values[:rank]
    return bool(np.min(np.linalg.eigvals(behind).real) < 0.0)


def _forces(run: Record, t: FloatArray) -> History:
    """The forces at times t (n,), not numbers where the run knows none."""
    sample = Sample(run, t)
    motion = sample.motion
    meshes = mesh_forces(run.model, motion.multipliers)
    return History(t, motion.pushes, motion.reactions, meshes, _of_drives(sample), np.zeros((len(t), 0), dtype=bool))


def _of_drives(sample: Sample) -> FloatArray:
    """Efforts and powers (n, drives, 2)."""
    joints = driven_joints(sample.model)
    found = [np.stack([drive_effort(sample, joint), drive_power(sample, joint)], axis=-1) for joint in joints]
    return np.stack(found, axis=1) if found else np.zeros((len(sample.t), 0, 2), dtype=sample.t.dtype)


def away_from_lines(t: FloatArray, sizes: FloatArray, beside: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which of the sizes (n,) of a force are not on a slope that rises to an instant ``beside`` a line of links (n,).

    A slope goes on through changes of contact, instants that are there twice in t (n,).
    """
    away = np.ones(len(sizes), dtype=bool)
    for peak in np.flatnonzero(beside).tolist():
        away[peak] = False
        for way in (-1, 1):
            i = peak + way
            while 0 <= i < len(sizes) and away[i] and (sizes[i] <= sizes[i - way] or t[i] == t[i - way]):
                away[i] = False
                i += way
    return away


def even_history(run: Record, count: int) -> History:
    """The forces at ``count`` even times from a run's start to its end, NaN where it knows none.

    The last instant of a run that stopped early is left out, as by ``history``.
    """
    if run.motion is None:
        raise ValueError("this run knows no forces: it was not made by simulate")
    t = np.linspace(run.t[0], run.t[-1], count, dtype=run.t.dtype)
    if not run.success:
        t = t[:-1]
    return _forces(run, t)


def _just_before(run: Record, jumps: FloatArray) -> FloatArray:
    """Times at which the forces are those before the ``jumps``.

    At a jump itself a contact may be at the end of the edge that it leaves, where its gap is that to what comes next:
    its force before is a limit. After a phase too short for a time within it they are those at its beginning.
    """
    start = np.concatenate([run.t[:1], jumps[:-1]])
    found: FloatArray = np.maximum(start, jumps - np.maximum(BEFORE * (jumps - start), 4.0 * np.spacing(jumps)))
    return found


def columns(run: Record) -> list[str]:
    """Headings of a table of forces: the outputs' own names, with units and the links that joints' forces act on. A
    stop has a moment, or a force along a line, and no friction."""
    model = run.model
    known, found = headings_of(model), ["t [s]"]

    def add(kind: str, owner: str, asked: str, otherwise: str = "") -> None:
        name = f"{owner}.{asked}"
        found.append(known.get(name) or known.get(f"{kind} {name}") or f"{name} [{otherwise}]")

    for point, ground in model.contacts:
        smooth = ground in model.slide_ends
        for asked in ("moment",) if ground in model.stops else ("normal",) if smooth else ("normal", "friction"):
            add("contact", f"{ground}.{point}", asked)
    for joint, link in zip(model.joints, model.second_links, strict=True):
        if joint in model.drawn_joints:  # others the scene has not: they place links that move freely
            for asked, unit in (("fx", "N"), ("fy", "N"), ("moment", "N m")):
                add("joint", joint, asked, f"{unit} on {link}")
    for mesh in mesh_names(model):
        add("mesh", mesh, "force")
    return found


def write_csv(run: Record, path: str | os.PathLike[str], found: History | None = None) -> Path:
    """Write the forces of contacts, joints, meshes as CSV, headings with units first; times as of ``history``.

    ``found`` are the forces where they are known already."""
    target = read_path(path, "a file")
    found = history(run) if found is None else found
    count = len(found.t)
    smooth = run.model.stops | run.model.slide_ends
    rubs = np.array([(True, ground not in smooth) for _, ground in run.model.contacts], dtype=bool).ravel()
    pushes = found.pushes.reshape(count, -1)[:, rubs]
    shown = [joint in run.model.drawn_joints for joint in run.model.joints]
    numbers = np.column_stack([found.t, pushes, found.reactions[:, shown].reshape(count, -1), found.meshes])
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(columns(run))
    table.writerows([[repr(float(x)) for x in row] for row in numbers.tolist()])
    write_whole(target, lambda part: part.write(text.getvalue().encode()))
    return target
