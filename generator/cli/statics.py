"""``ccgen torque`` and ``ccgen equilibrium``: what a crank needs over a turn, and where a mechanism rests."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import typer

from ..mechanism.joints import Joint
from ..scene import Scene
from .compiled import compiled
from .detail import Detail
from .folders import MODELS, check_folder, check_picture
from .refusal import Faults, fail, read_option, refusing
from .settings import read_set, with_settings

SOME_TIMES = (0.0123, 0.37, 1.0, 7.3)
"""Times (s) at which loads are compared with those at 0; those of a table or formula differ at one of them at least."""

ROUNDED = 1e-12
"""A mean that is this part of the largest value is a sum that vanishes, of a few hundred roundings."""

if TYPE_CHECKING:
    from ccgen.runtime import Model
    from ccgen.runtime.arrays import FloatArray


def torque(
    scene_file: Path,
    joint: str | None,
    rate: str | None,
    plot: Path | None,
    detail: Detail,
    settings: Mapping[str, float],
    faults: Faults,
) -> None:
    """Print mean and extremes of the torque over one turn; plot it where asked."""
    from ccgen.runtime import driving_torque
    from ccgen.runtime.analysis.crank import check_rate

    asked = faults.of(read_option, rate, check_rate, "rad/s") if rate is not None else None
    scene = read_set(scene_file, settings, faults)
    turned = faults.of(_driving, scene, scene_file, joint) if scene else None
    if plot is not None:
        faults.of(check_picture, plot, "--plot")
    faults.of(check_folder, MODELS, "folder of models")
    faults.stop_if_any()
    assert scene and turned
    model = with_settings(compiled(scene, detail), settings, scene, detail)
    driven, steady = _driven_speed(model, turned)
    speed = asked if asked is not None else driven or 1.0
    with refusing(ValueError, OSError):
        turn = driving_torque(model, turned, speed)
        if plot is not None:
            turn.plot(plot)
    why = f", as its [[drive]] has it{'' if steady else ' at t = 0'}" if driven and asked is None else ""
    at = f"at {speed:g} rad/s{why}" if speed else "and at rest at each angle"
    typer.echo(f"{model.name}: {turned} turned once {at}: {_motion(scene, turned)}")
    mean = turn.mean if abs(turn.mean) > ROUNDED * np.abs(turn.torque).max() else 0.0
    typer.echo(f"mean     {mean:z16.{_digits(mean, turn.mean_error)}g} N m")
    for name, (most, angle) in (("largest", turn.largest), ("smallest", turn.smallest)):
        typer.echo(f"{name:8} {most:z16.9g} N m at {angle:.6g} rad")
    _tell_time(model, turn.q[0])
    if asked is None and driven == 0.0:
        typer.echo(
            f"note: its [[drive]] has {turned} at rest at t = 0, so it is turned at 1 rad/s; --rate asks for another"
        )
    if turn.closed:
        typer.echo(f"closed on the way: {_named(turn.closed)}; what they push does no work here and is not counted")
    if plot is not None:
        typer.echo(f"written: {plot}")


def _digits(value: float, error: float) -> int:
    """How many digits of a number are printed, nine at most, and at least one: those that hold."""
    return 9 if not value or not error else max(1, min(9, math.floor(math.log10(abs(value) / error))))


def _driven_speed(model: Model, joint: str) -> tuple[float | None, bool]:
    """The speed (rad/s) at t = 0 of the drive of a joint, ``None`` where it has none, and whether that is a plain
    number, kept all the time, rather than the rate of a law over time."""
    from ccgen.runtime.model.drives import drive_speeds

    of = [drive["joint"] for drive in model.data["drives"]]
    if joint not in of:
        return None, True
    index = of.index(joint)
    return float(drive_speeds(model)[index]), isinstance(model.data["drives"][index]["speed"], str)


def equilibrium(scene_file: Path, nearest: bool, detail: Detail, settings: Mapping[str, float], faults: Faults) -> None:
    """Print an equilibrium: stability, stiffnesses, coordinates, joint forces and forces of closed contacts."""
    from ccgen.runtime import static_equilibrium

    scene = read_set(scene_file, settings, faults)
    faults.of(check_folder, MODELS, "folder of models")
    faults.stop_if_any()
    assert scene
    model = with_settings(compiled(scene, detail), settings, scene, detail)
    with refusing(ValueError):
        found = static_equilibrium(model, nearest=nearest)
    stiffness = ", ".join(f"{value:z.6g}" for value in found.stiffness) or "none, it cannot move"
    told = "" if found.stability == "undetermined" else f"{found.stability} "
    typer.echo(f"{model.name}: {told}equilibrium; stiffnesses: {stiffness}")
    width = max(12, *map(len, model.q_of))
    for name, value in zip(model.q_of, found.q, strict=True):
        typer.echo(f"{name:{width}} {value:z16.9g} {'rad' if name.endswith('.angle') else 'm'}")
    typer.echo("joint            force x [N]     force y [N]  moment [N m]  on")
    for name, (x, y, moment), link in zip(model.joints, found.reactions, model.second_links, strict=True):
        typer.echo(f"{name:12} {x:z15.9g} {y:z15.9g} {moment:z13.6g}  {link}")
    _tell_meshes(model, found.meshes)
    if found.closed:
        typer.echo("contact                         normal        friction")
    for k, contact in enumerate(model.contacts):
        if contact in found.closed:
            _tell_contact(_named([contact]), found.contact_forces[k], found.ranges[k], contact[1] in model.stops)
    if found.note:
        typer.echo(f"note: {found.note}")
    _tell_time(model, found.q)


def _tell_time(model: Model, q: FloatArray) -> None:
    """Say so where loads depend on time, which stands still here."""
    rest = np.zeros((1, len(q)))
    loads = [model.kernels.inverse_dynamics(q[None], rest, t, rest) for t in (0.0, *SOME_TIMES)]
    if any(np.any(later != loads[0]) for later in loads[1:]):
        typer.echo("note: loads that depend on time are those at t = 0 throughout")


def _tell_meshes(model: Model, forces: FloatArray) -> None:
    """One line for each gear, rack and belt."""
    from ccgen.runtime.model.meshes import mesh_names, mesh_torques

    if names := mesh_names(model):
        typer.echo("mesh               force [N]  torque on the first wheel [N m]")
    for name, force, torque in zip(names, forces, mesh_torques(model, forces), strict=True):
        typer.echo(f"{name:12} {force:z15.9g} {torque:z32.9g}")


def _named(contacts: Iterable[tuple[str, str]]) -> str:
    return ", ".join(f"{point} on {ground}" for point, ground in contacts)


def _tell_contact(name: str, forces: FloatArray, ranges: FloatArray, stop: bool) -> None:
    """One line for the ``forces`` (2,) of a contact, and one for each end of ``ranges`` where others are possible."""
    unit = "N m" if stop else "N"
    typer.echo(f"{name:22} {forces[0]:z15.9g} {forces[1]:z15.9g}  {unit}")
    lowest, highest = ranges.T
    if any(lowest != highest):
        for word, ends in (("from", lowest), ("to", highest)):
            typer.echo(f"{word:>22} {ends[0]:z15.9g} {ends[1]:z15.9g}  {unit}")


def _driving(scene: Scene, scene_file: Path, joint: str | None) -> str:
    """The joint that is to be turned: the one asked for, the only one that pins the link asked for to the ground, or
    the only one whose motion the scene prescribes."""
    joints = scene.mechanism.joints
    turning = [one.name for one in joints if not one.slides]
    held = [one for one in joints if not one.slides and one.on_ground]
    of_link = [one.name for one in held if joint in _sides(scene, one)]
    if joint not in turning and len(of_link) == 1:
        return of_link[0]
    if joint is None and len(scene.driven) == 1:
        joint = joints[scene.driven[0]].name
    known = ", ".join(f"{one.name} ({' - '.join(_sides(scene, one))})" for one in joints if not one.slides)
    expected = f"expected the joint that drives, one of: {known or 'none here'}"
    if joint is None:
        fail(f"JOINT: found none, {expected}; name it behind the scene file")
    if joint not in turning:
        fail(f"JOINT: found {joint!r}, which does not turn in {scene_file}, {expected}; name one of them")
    return joint


def _sides(scene: Scene, joint: Joint) -> tuple[str, str]:
    """The links that a joint joins, by name."""
    return scene.mechanism.link_name(joint.first.link), scene.mechanism.link_name(joint.second.link)


def _motion(scene: Scene, name: str) -> str:
    """Which link turns against which at a joint."""
    first, second = next(_sides(scene, joint) for joint in scene.mechanism.joints if joint.name == name)
    return f"{second} against {first}"
