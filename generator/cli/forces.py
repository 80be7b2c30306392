"""What ``ccgen run`` prints and writes of forces: the largest of contacts and joints, their picture, and a table."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Set
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import typer

from .report import rounding_of_energy

if TYPE_CHECKING:
    from ccgen.runtime import Run
    from ccgen.runtime.arrays import FloatArray
    from ccgen.runtime.record.force_history import History

    from ..scene.scene import Scene

ROUNDING = 1e-13
"""Times the normal force: friction that is less is rounding."""
ALIKE = 1e-9
"""Part of the largest force by which others are as large: states are known to no more at the usual tolerance."""
PICTURE, TABLE = "forces.png", "forces.csv"
LARGEST = 3
"""Contacts, and joints, whose largest forces are printed, unless all are asked for."""


class Told:
    """The forces of a run, looked at once for all that tells them; ``shared`` where joints are redundant; ``every``
    where the largest force of each contact and joint is asked for."""

    def __init__(self, run: Run, shared: bool = False, every: bool = False) -> None:
        self.run, self.shared = run, shared
        self.most = None if every else LARGEST

    @cached_property
    def history(self) -> History:
        """Raises ``ValueError`` where the run knows none."""
        from ccgen.runtime.record.force_history import history

        return history(self.run)

    @cached_property
    def _with_peaks(self) -> tuple[History, FloatArray]:
        from ccgen.runtime.record.force_history import with_peaks

        both: tuple[History, FloatArray] = with_peaks(self.run, self.history)
        return both

    @property
    def peaks(self) -> History:
        """The same with the instants between at which the largest are. Raises ``ValueError`` as ``history``."""
        return self._with_peaks[0]

    @property
    def passed(self) -> FloatArray:
        """When (s) links passed a line, or were next to it at instants looked at; raises ``ValueError`` likewise."""
        beside = self.history.t[self.history.beside.any(axis=1)]
        last = self.history.t[-1] if self.stops else np.inf
        return np.sort(np.concatenate([self._with_peaks[1], beside[beside < last]]))

    @property
    def stops(self) -> bool:
        """Whether forces grow without bound towards the end of a run that cannot go on; raises as ``history``."""
        return bool(not self.run.success and self.history.beside[-1].any())

    @cached_property
    def rows(self) -> list[Row]:
        """The largest of contacts, joints and meshes; none where all are zero. Raises ``ValueError`` as ``history``."""
        run = self.run
        return [part for rows in (_contacts, _joints, _meshes) for part in rows(run, self.peaks, self.most)]


def print_forces(told: Told) -> None:
    """The largest forces of contacts, joints and meshes between impacts, and when; nothing where there are none."""
    if not acts(told.run):
        return
    try:
        rows = told.rows
    except ValueError as error:
        typer.echo(f"no forces: {error}")
        return
    if rows:
        between = " between impacts" if told.run.impacts else ""
        shared = ", those of redundant joints of least norm" if told.shared else ""
        typer.echo(f"largest forces{between}{shared}:")
    width = max((len(name) for name, _, _, _ in rows), default=0)
    for name, size, t, more in rows:
        typer.echo(f"  {name:{width}}  {size:>12}  at t = {t:.6g} s{more}")
    if len(told.passed):
        typer.echo(
            f"forces of joints that grow without bound near a line of links, a change point, as at "
            f"t = {told.passed[0]:.6g} s, are not {'among them' if rows else 'told'}: they and impulses "
            "grow there as one by the distance from it"
        )
    if told.stops:
        typer.echo(
            "forces that grow without bound towards where the run cannot go on are not "
            f"{'among them' if rows else 'told'}"
        )


def print_drives(told: Told) -> None:
    """The largest torque or force of each drive between impacts, and its largest powers, and when; nothing where all
    are zero, or forces are not known, which ``print_forces`` says."""
    try:
        rows = _drives(told.run, told.peaks) if told.run.model.joints else []
    except ValueError:
        return
    if rows:
        width = max(len(name) for name, _ in rows)
        typer.echo(f"drives at most{' between impacts' if told.run.impacts else ''}:")
    for name, said in rows:
        typer.echo(f"  {name:{width}}  {', '.join(said)}")


def acts(run: Run) -> bool:
    """Whether the model has anything that a force acts in."""
    from ccgen.runtime.model.meshes import mesh_names

    return bool(run.model.joints or run.model.contacts or mesh_names(run.model))


Row = tuple[str, str, float, str]


def first_largest(sizes: FloatArray) -> list[int]:
    """Per column of ``sizes`` (instants, forces) the first instant at which the largest is reached, to rounding.

    A force that stays as it is has no instant of its own: the last digit would choose one.
    """
    return np.argmax(sizes >= (1.0 - ALIKE) * np.max(sizes, axis=0), axis=0).tolist() if len(sizes) else []


def _contacts(run: Run, found: History, most: int | None) -> list[Row]:
    """Those that push hardest, each with the friction of that instant; stops, in other units, after them."""
    model = run.model
    peaks = first_largest(found.pushes[:, :, 0])
    rows: list[Row] = []
    for stops in (False, True):
        chosen = [k for k, (_, ground) in enumerate(model.contacts) if (ground in model.stops) == stops]
        sizes = {k: float(found.pushes[peaks[k], k, 0]) for k in chosen}
        for k in sorted(chosen, key=lambda k: -sizes[k])[:most]:
            if sizes[k] <= 0.0:
                continue
            friction = float(found.pushes[peaks[k], k, 1])
            rubs = np.abs(found.pushes[:, k, 1]) > ROUNDING * sizes[k]
            more = f", friction {friction if rubs[peaks[k]] else 0.0:z.6g} N" if rubs.any() else ""
            point, ground = model.contacts[k]
            unit = "N m" if stops else "N"
            rows.append((f"{point} on {ground}", f"{sizes[k]:.6g} {unit}", float(found.t[peaks[k]]), more))
    return rows


def _joints(run: Run, found: History, most: int | None) -> list[Row]:
    """Those whose forces are largest, each with the largest impulse of the impacts that it carries: no force.

    Where all are rounding, as of joints that only place free bodies, the largest is no measure of it: then it is the
    rounding of energies over the mechanism's length.
    """
    away = found.far_of_joints()
    sizes = np.where(away, np.hypot(found.reactions[:, :, 0], found.reactions[:, :, 1]), 0.0)
    peaks = first_largest(sizes)
    order = sorted(range(len(run.model.joints)), key=lambda j: -sizes[peaks[j], j])
    least = max(ROUNDING * float(np.max(sizes, initial=0.0)), rounding_of_energy(run) / run.model.length)
    return [
        (
            run.model.joints[j],
            f"{sizes[peaks[j], j]:.6g} N",
            float(found.t[peaks[j]]),
            _struck(run, j, set(found.t[away[:, j]].tolist())),
        )
        for j in order[:most]
        if sizes[peaks[j], j] > least
    ]


def _drives(run: Run, found: History) -> list[tuple[str, list[str]]]:
    """By the joint of each drive its largest torque or force, either way, the largest power that it gives, and that
    which it takes up; each where states are known well enough to tell it from zero, and away from lines of links, as
    forces of joints."""
    from ccgen.runtime.record.outputs import driven_joints, slides

    rows, far = [], found.far_of_drives()
    for number, joint in enumerate(driven_joints(run.model)):
        effort, power = found.drives[:, number].T
        what, unit = ("force", "N") if slides(run.model, joint) else ("torque", "N m")
        asked = (
            (what, unit, effort, np.abs(effort)),
            ("gives", "W", power, power),
            ("takes", "W", -power, -power),
        )
        said = []
        for kind, (word, measure, values, sizes) in enumerate(asked):
            counted = np.where(far[:, kind, number], sizes, 0.0)
            (peak,) = first_largest(counted[:, None])
            if counted[peak] > ALIKE * np.max(np.abs(sizes), where=np.isfinite(sizes), initial=0.0):
                said.append(f"{word} {values[peak]:.6g} {measure} at t = {found.t[peak]:.6g} s")
        if said:
            rows.append((joint, said))
    return rows


def _struck(run: Run, joint: int, away: Set[float]) -> str:
    """The largest impulse that a joint carries in impacts, in words; nothing where none is more than rounding of the
    largest at a joint or a contact. Only impacts at times ``away`` from lines of links count."""
    impacts = [impact for impact in run.impacts if impact.t in away]
    sizes = [np.hypot(*impact.reactions[:, :2].T) for impact in impacts]
    largest = [np.nanmax([*own, *impact.impulses], initial=0.0) for own, impact in zip(sizes, impacts, strict=True)]
    carried = [float(own[joint]) for own, most in zip(sizes, largest, strict=True) if own[joint] > ROUNDING * most]
    return f", in impacts up to {max(carried):.6g} N s" if carried else ""


def _meshes(run: Run, found: History, most: int | None) -> list[Row]:
    """Those whose tangential forces are largest."""
    from ccgen.runtime.model.meshes import mesh_names

    names, sizes = mesh_names(run.model), np.abs(found.meshes)
    peaks = first_largest(sizes)
    order = sorted(range(len(names)), key=lambda k: -sizes[peaks[k], k])
    return [
        (names[k], f"{sizes[peaks[k], k]:.6g} N", float(found.t[peaks[k]]), "")
        for k in order[:most]
        if sizes[peaks[k], k] > 0.0
    ]


def touches(scene: Scene) -> bool:
    """Whether anything in the scene can touch."""
    return any(effect.gaps(lambda _, expression: expression) for effect in scene.effects)


def force_files(scene: Scene, csv: bool) -> list[str]:
    """Names of the files of forces that a run of the scene may write."""
    return [PICTURE] * (touches(scene) or bool(scene.mechanism.joints)) + [TABLE] * csv


def ways_to_write(
    told: Told, csv: bool, times: int | None = None, settings: Mapping[str, object] | None = None
) -> dict[str, Callable[[Path], object]]:
    """By the name of each of these files what writes it: a picture where forces act, which names the ``settings``, a
    table if asked, of so many even ``times`` where that is a number; none of a run that went by time stepping, which
    records no forces."""
    run = told.run
    if run.phases and all(phase.kind == "steps" for phase in run.phases):
        return {}

    def draw(path: Path) -> None:
        from ccgen.runtime.pictures.force_plot import draw_forces

        draw_forces(run, path, told.peaks, settings)

    def write(path: Path) -> None:
        from ccgen.runtime.record.force_history import even_history, write_csv

        write_csv(run, path, told.history if times is None else even_history(run, times))

    ways: dict[str, Callable[[Path], object]] = {PICTURE: draw} if _drawn(told) else {}
    return ways | ({TABLE: write} if csv else {})


def _drawn(told: Told) -> bool:
    """Whether there is something to draw; what cannot be drawn is said by who tries."""
    if told.run.model.contacts or not told.run.model.joints:
        return bool(told.run.model.contacts)
    try:
        return bool(_joints(told.run, told.history, LARGEST)) or bool(told.history.beside.any())
    except ValueError:
        return True
