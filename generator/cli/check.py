"""``ccgen check``: whether an installation works, from the equations to the numbers."""

from __future__ import annotations

import math
import os
import platform
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from ..compile.compiler import CompileError, find_compiler
from ..package.replace import OutputError
from ..pipeline import generate
from ..scene import loop
from ..version import VERSION
from .refusal import refusing

if TYPE_CHECKING:
    from ccgen.runtime import Model, Run

WRONG_NUMBERS = 1
"""Exit code: everything runs, and comes to wrong numbers."""
ALLOWED = 1e-9
"""m, and J of the energy at the start: ten times what the tolerance of the run, 1e-10, leaves to each second."""
LINKS, GRAVITY, SECONDS = 6, 9.81, 1.0


def check() -> None:
    """Derive, compile and fly a hexagon in a folder that is removed, and hold its fall against the closed form."""
    typer.echo(f"ccgen       {VERSION}, Python {platform.python_version()}, {platform.system()} {platform.machine()}")
    with tempfile.TemporaryDirectory() as folder, refusing(CompileError, OutputError):
        os.environ["CCGEN_CACHE_DIR"] = folder  # what others have compiled says nothing of the compiler
        compiler = find_compiler()
        typer.echo(f"compiler    {' '.join(compiler.command)}: {compiler.version.partition(';')[0]}")
        from ccgen.runtime import load_model, simulate

        begin = time.perf_counter()
        model = load_model(generate(loop(LINKS, gravity=True), Path(folder) / "models"))
        typer.echo(f"model       a hexagon of rods, derived and compiled in {time.perf_counter() - begin:.1f} s")
        q, u = model.start()
        q, u = model.project(q, u + [math.sin(k + 1.0) for k in range(u.size)])
        begin = time.perf_counter()
        run = simulate(model, q, u, until=SECONDS, rtol=1e-10)
        spent = time.perf_counter() - begin
        typer.echo(f"simulation  {SECONDS:g} s of its fall in {1e3 * spent:.2g} ms")
        _hold(model, run)


def _hold(model: Model, run: Run) -> None:
    """Compare with what is known: the mass centre falls as a stone, energy and loop stay as they are."""
    import numpy as np

    def centre(values: np.ndarray) -> np.ndarray:  # rods of one mass
        found: np.ndarray = np.asarray(values)[:, :2].mean(axis=0)
        return found

    t = float(run.t[-1])
    thrown = centre(model.poses(run.q[0])) + t * centre(model.velocities(run.q[0], run.u[0]))
    expected = thrown - [0.0, 0.5 * GRAVITY * t * t]
    missed = {
        "of its mass centre from that of a stone": float(np.abs(centre(model.poses(run.q[-1])) - expected).max()),
        "of the loop's ends from each other": float(run.closure_max),
        "of its energy from that at the start": float(run.energy_drift),
    }
    for what, value in missed.items():
        typer.echo(f"difference  {value:.0e} {what}")
    if not run.success or not max(missed.values()) <= ALLOWED:
        typer.echo(
            f"wrong: found a difference beyond {ALLOWED:g} ({run.message}); compile with another compiler (CC=clang)",
            err=True,
        )
        raise typer.Exit(WRONG_NUMBERS)
    typer.echo("ccgen works here")
