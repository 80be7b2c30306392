"""The outputs that a page can plot below the motion, and their values at the page's instants."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import chain, zip_longest
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..record.outputs import Output, outputs_of, unknown, values_of
from ..record.record import Record
from .named_points import named_points

MOST_OUTPUTS = 36
"""Outputs of a page's own choice; those that are asked for come in addition."""
MOST_INSTANTS = 2000
"""At more frames than that every second, third, ... is charted."""
ENERGIES = ("energy", "kinetic_energy", "potential_energy")
"""Those that every page has."""


def check_outputs(run: Record, names: Sequence[str]) -> None:
    """Raise ``ValueError`` with all names that no output of the run has."""
    if isinstance(names, str) or not all(isinstance(name, str) for name in names):
        raise TypeError(f'outputs: found {names!r}, expected a list of names such as ["energy"]')
    if run.motion is None:
        if wrong := [name for name in names if name not in ENERGIES]:
            raise ValueError(
                f"output: found {', '.join(wrong)}, but this run, which simulate has not made, knows energies only"
            )
    elif wrong := unknown(run.model, names):
        raise ValueError("; ".join(f"output: {one}" for one in wrong))


def chosen(run: Record) -> list[str]:
    """Names of up to ``MOST_OUTPUTS`` outputs worth a curve, in the order of :func:`outputs_of`.

    Kinds take turns, so that a mechanism of many links has some of each: angles and angular velocities of links, what
    effects tell, forces of contacts that have struck or closed, lengths along lines, forces of joints and meshes,
    heights and speeds of points, those first that are no joints, angles of joints, gaps.
    """
    if run.motion is None:
        return []
    known = outputs_of(run.model)
    free = _free_points(run)
    struck = {f"{ground}.{point}" for point, ground in _touched(run)}

    def of(kind: str, *asked: str, among: Callable[[str], bool] = lambda _: True) -> list[str]:
        own = [name for name, output in known.items() if output.kind == kind and _asked(output) in asked]
        return [name for name in own if among(_owner(known[name]))]

    def is_joint(name: str) -> bool:
        return _owner(known[name]) not in free

    groups = [
        of("link", "angle"),
        of("link", "angular_velocity"),
        [name for name, output in known.items() if output.kind == "effect"],
        of("contact", "normal", "moment", among=struck.__contains__),
        of("joint", "slide"),
        of("joint", "force"),
        of("mesh", "force"),
        sorted(of("point", "y"), key=is_joint),
        sorted(of("point", "speed"), key=is_joint),
        of("contact", "friction", among=struck.__contains__),
        of("joint", "moment", among=_driven(run.model).__contains__),
        of("joint", "angle"),
        of("contact", "gap"),
    ]
    turns = [name for name in chain.from_iterable(zip_longest(*groups)) if name is not None]
    first = {*turns[:MOST_OUTPUTS]}
    return [name for name in known if name in first]


def _asked(output: Output) -> str:
    return output.name.rpartition(".")[2]


def _owner(output: Output) -> str:
    return output.name.rpartition(".")[0]


def _touched(run: Record) -> set[tuple[str, str]]:
    """Contacts that have struck, or stayed closed for a time."""
    struck = {contact for impact in run.impacts for contact in impact.contacts}
    return struck | {contact for phase in run.phases for contact in phase.contacts}


def _free_points(run: Record) -> set[str]:
    """Names of points of links at which no joint is at the start: tips, feet, pens."""
    q = run.q[0]
    joints = np.array([run.model.point(joint, q) for joint in run.model.drawn_joints], dtype=float).reshape(-1, 2)

    def is_free(name: str) -> bool:
        away = joints - np.asarray(run.model.point(name, q), dtype=float)
        return not np.any(np.hypot(*away.T) < 1e-9)

    return {one.name for one in named_points(run) if is_free(one.name)}


def _driven(model: Any) -> set[str]:
    return {drive["joint"] for drive in model.data["drives"]}


def chart_times(run: Record, frames: FloatArray, jumps: Sequence[float]) -> tuple[FloatArray, FloatArray]:
    """Times of a chart, those of the frames and each of the ``jumps`` twice, and the times at which the run is asked
    for these: before an impact, or an event that sets something, just before it."""
    every = -(-len(frames) // MOST_INSTANTS)
    keep = np.arange(len(frames)) % every == 0
    keep[[0, -1]] = True
    times = np.asarray(frames[keep | np.isin(frames, jumps)], dtype=run.t.dtype)
    twice = np.array([t for t in jumps if times[0] < t <= times[-1]], dtype=run.t.dtype)
    t = np.concatenate([twice, times])
    asked = np.concatenate([np.nextafter(twice, -np.inf, dtype=run.t.dtype), times])
    order = np.argsort(t, kind="stable")
    return np.asarray(t[order]), np.clip(asked[order], run.t[0], run.t[-1])


def curves(run: Record, names: Sequence[str], t: FloatArray) -> dict[str, FloatArray]:
    """Outputs by name at the times t (n,), which grow; not numbers where the run knows none, nor at the end of a run
    that stopped early, where forces may have no solution."""
    if not run.success and np.any(t < run.t[-1]):
        before = t < np.nextafter(run.t[-1], -np.inf, dtype=run.t.dtype)
        end = np.full(np.count_nonzero(~before), np.nan)
        return {name: np.concatenate([known, end]) for name, known in _known(run, names, t[before]).items()}
    return _known(run, names, t)


def _known(run: Record, names: Sequence[str], t: FloatArray) -> dict[str, FloatArray]:
    """Outputs by name at the times t (n,)."""
    try:
        return values_of(run, names, t)
    except ValueError:  # as where forces have no solution at one of the times: the others are known
        found: dict[str, FloatArray] = {}
        for name in names:
            try:
                found |= values_of(run, [name], t)
            except ValueError:
                found[name] = np.full(len(t), np.nan)
        return found
