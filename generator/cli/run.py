"""``ccgen run SCENE``: simulate, print impacts and audit, write result, plot and player."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
import typer

from ..effects.ground import Ground
from ..pipeline import generate
from ..scene import Scene
from .common import check_folder, fail, progress, read, tell_assembly, trouble

SHOWN = 40
"""Impacts printed; a longer list is cut, the result file has them all."""


def run(
    scene_file: Path, until: float | None, rtol: float | None, method: str | None, out: Path | None, gif: bool
) -> None:
    """Simulate the scene into the folder ``out``; exit code 3 when the run stopped early."""
    if until is not None and not (until > 0.0 and math.isfinite(until)):
        fail(f"--until {until}: expected a positive number of seconds; correct it")
    if rtol is not None and not 0.0 < rtol < 1.0:
        fail(f"--rtol {rtol}: expected a number between 0 and 1; correct it")
    scene = read(scene_file)
    folder = Path("results") / scene.name if out is None else out
    check_folder(folder, "--out")
    check_folder(Path("build"), "model folder")
    tell_assembly(scene)
    from ccgen.runtime import load_model, simulate

    with trouble(), progress() as say:
        model = load_model(generate(scene, "build", say))
        say("simulate")
        result = simulate(model, until=until, rtol=rtol, method=method)
        say("draw")
        files = write(result, folder, gif)
    print_impacts(scene, model, result)
    print_audit(result)
    typer.echo("written: " + ", ".join(str(file) for file in files))
    if not result.success:
        fail(f"{scene.name}: stopped at t = {result.t[-1]:.10g} s: {result.message}", 3)


def write(result: Any, folder: Path, gif: bool) -> list[Path]:
    """Write result, plot, player and, if asked, a GIF into ``folder``; the files written."""
    folder.mkdir(parents=True, exist_ok=True)
    files = [folder / name for name in ("result.npz", "plot.png", "player.html")]
    result.save(files[0])
    result.plot(files[1])
    result.animate(files[2])
    if gif:
        files.append(folder / "animation.gif")
        result.animate(files[3])
    return files


def print_impacts(scene: Scene, model: Any, result: Any) -> None:
    """The impacts as a table: when, which points, how fast they came, the impulses, the energy lost."""
    if not result.impacts:
        typer.echo("no impacts")
        return
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for title, side in (("#", "right"), ("t, s", "right"), ("contacts", "left")):
        table.add_column(title, justify="right" if side == "right" else "left", no_wrap=True)
    for title in ("speed before, m/s", "impulse, N s", "energy loss, J"):
        table.add_column(title, justify="right", no_wrap=True)
    for number, impact in enumerate(result.impacts[:SHOWN], 1):
        speeds = normal_speeds(scene, model, result, impact)
        table.add_row(
            str(number),
            f"{impact.t:.12f}",
            "\n".join(point if len(model.grounds) == 1 else f"{point} on {at}" for point, at in impact.contacts),
            "\n".join(f"{speed:.9f}" for speed in speeds),
            "\n".join(f"{impulse:.9f}" for impulse in impact.impulses),
            f"{impact.energy_loss:.9f}",
        )
    wide = 120 if not sys.stdout.isatty() else None
    Console(width=wide, highlight=False).print(table)
    if len(result.impacts) > SHOWN:
        typer.echo(f"and {len(result.impacts) - SHOWN} more")


def normal_speeds(scene: Scene, model: Any, result: Any, impact: Any) -> list[float]:
    """Speed of each contact of ``impact`` along the ground's normal just before it (m/s, negative inwards)."""
    q = result.q[int(np.searchsorted(result.t, impact.t))]
    poses, moving = model.poses(q), model.velocities(q, impact.u_minus)
    grounds = {effect.name: effect for effect in scene.effects if isinstance(effect, Ground)}
    speeds = []
    for name, at in impact.contacts:
        ref = dict(grounds[at].contacts)[name]
        arm = complex(*scene.mechanism.point(ref).values()) * np.exp(1j * poses[ref.link][2])
        vx, vy, spin = moving[ref.link]
        normal = grounds[at].normal.values()
        speeds.append(float((vx - spin * arm.imag) * normal[0] + (vy + spin * arm.real) * normal[1]))
    return speeds


def print_audit(result: Any) -> None:
    """How far the run got and how exact it was."""
    steps = len(result.t) - 1 - len(result.impacts)
    typer.echo(
        f"t = {result.t[-1]:.10g} s, impacts: {len(result.impacts)}, steps: {steps}, evaluations: {result.nfev}\n"
        f"closure {result.closure_max:.2e} m, energy drift {result.energy_drift:.2e} J"
    )
