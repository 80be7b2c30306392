"""What ``ccgen run`` says of a run that is right and may be meant otherwise: friction that creeps, redundant rows."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import typer

if TYPE_CHECKING:
    from ccgen.runtime import Run

    from ..mechanism.links import Parameter
    from ..scene.scene import Scene

LOOKS = 1001
"""Even times at which a joint's rate is looked at."""
LONG = 0.1
"""Part of a run for which a joint must be slow to be spoken of: what turns back is so for less."""
LOADED = 0.01
"""Part of its friction that a load must be at least: it is held at that part of the friction's rate."""
DEPENDENT = 1e-10
"""Closure rows whose least singular value is below that part of the largest depend on each other: what the core takes
for dependent (RANK_TOLERANCE)."""
ROWS = 16
"""Rows of a run at which that is looked for."""


def print_remarks(scene: Scene, run: Run) -> None:
    """These remarks, each in a line on standard error."""
    for remark in (*_creeping(scene, run), *_always_dense(run)):
        typer.echo(f"note: {remark}", err=True)


def _creeping(scene: Scene, run: Run) -> Iterator[str]:
    """Joints that dry friction holds by smoothing: ω₀ artanh(M/T) under a moment M of T at most."""
    names = run.outputs
    for effect, joint, rate in _rubbing(scene):
        angle, speed, unit = f"{joint}.angle", f"{joint}.angular_velocity", "rad/s"
        if angle not in names:
            angle, speed, unit = f"{joint}.slide", f"{joint}.slide_rate", "m/s"
        if angle not in names or rate.path not in run.model.parameters:
            continue
        slowly = run.model.parameters[rate.path]
        t = np.linspace(run.t[0], run.t[-1], LOOKS)
        try:
            found = run.values(angle, speed, t=t)
        except ValueError:  # a record that knows no more than its rows
            continue
        slow = np.abs(found[speed]) < slowly
        both = slow[1:] & slow[:-1]
        lasts = float(np.sum(np.diff(t)[both]))
        way = float(np.sum(np.abs(np.diff(found[angle])[both])))
        if lasts > LONG * (run.t[-1] - run.t[0]) and way > LOADED * slowly * lasts:
            far = f"{math.degrees(way):.3g}°" if unit == "rad/s" else f"{way:.3g} m"
            yield (
                f"{joint} creeps against the dry friction of {effect}, slower than its rate of {slowly:g} {unit} for "
                f"{lasts:.3g} s of the run and by {far} in all, since that is smoothed; with a smaller rate "
                "in its table it creeps less, in proportion"
            )


def _rubbing(scene: Scene) -> Iterator[tuple[str, str, Parameter]]:
    """Dry friction in joints: whose, in which joint, and the rate about which it changes its sign."""
    joints = [joint.name for joint in scene.mechanism.joints]
    for effect in scene.effects:
        yield from ((effect.title, joints[index], rate) for index, rate in effect.rubs())


def _always_dense(run: Run) -> Iterator[str]:
    """That closure rows depend on each other all along a run, so that the generated accelerations were of no use."""
    model = run.model
    if not len(getattr(model, "rows", ())) or not hasattr(model, "jacobian"):
        return
    numbers = np.unique(np.linspace(0, len(run.t) - 1, min(ROWS, len(run.t))).astype(int))
    idle = []
    for q in run.q[numbers]:
        rows = model.jacobian(q)
        values = np.linalg.svd(rows, compute_uv=False)
        idle.append(len(rows) - int(np.count_nonzero(values > DEPENDENT * values[0])))
    if min(idle) > 0:
        yield (
            f"{min(idle)} of {len(model.rows)} closure rows follow from the others all along the run, joints being "
            f"redundant: all of its {run.nfev} evaluations went by the dense solution, which is slower than the "
            "generated equations; without the redundant joints the motion is the same"
        )
