"""What ``ccgen run`` says of a run that is right and may be meant otherwise: friction that creeps, redundant rows,
steps as short as stability asks for."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import typer

if TYPE_CHECKING:
    from ccgen.runtime import Run

    from ..effect_base.effect import Rub
    from ..mechanism.joints import Joint
    from ..scene.scene import Scene

LOOKS = 1001
"""Even times at which a joint's rate is looked at."""
LONG = 0.1
"""Part of a run for which a joint must be slow to be spoken of: what turns back is so for less."""
LOADED = 0.01
"""Part of its friction that a load must be at least: it is held at that part of the friction's rate."""
NOTHING = 1e-12
"""Part of a viscous moment below which what is beside it is its rounding."""
DEPENDENT = 1e-10
"""Closure rows whose least singular value is below that part of the largest depend on each other: what the core takes
for dependent (RANK_TOLERANCE)."""
ROWS = 16
"""Rows of a run at which that is looked for."""
MANY = 1000
"""Steps in a run of which fewer would be worth a word."""
STABLE = {"dopri5": 3.3, "dop853": 6.4, "gauss": 6.3}
"""Step times fastest rate of decay, |h λ|, from which on a damped motion grows: where |R(h λ)| = 1 on the negative real
axis (E. Hairer, G. Wanner, Solving ordinary differential equations II, section IV.2), of gauss where its iteration no
longer contracts."""
TIGHT = 1e-10
"""Relative tolerance below which accuracy asks radau, of order 5, for as short steps as stability asks others for."""
NEAR = 0.75
"""Part of that which most steps must have: smooth motions have a quarter of it where the tolerance chooses the step."""


def print_remarks(scene: Scene, run: Run) -> None:
    """These remarks, each in a line on standard error."""
    for remark in (*_creeping(scene, run), *_always_dense(run), *_stiff(run)):
        typer.echo(f"note: {remark}", err=True)


def _creeping(scene: Scene, run: Run) -> Iterator[str]:
    """Joints that dry friction holds by smoothing: ω₀ artanh(M/T) under a moment M of T at most."""
    joints = scene.mechanism.joints
    found = ((effect.title, rub) for effect in scene.effects for rub in effect.rubs(scene.mechanism))
    yield from filter(None, (_creeps(run, joints[rub.joint], rub, title) for title, rub in found))


def _creeps(run: Run, joint: Joint, rub: Rub, effect: str) -> str:
    """That a joint creeps against friction of the ``effect`` of this title, if it does."""
    angle, speed, unit = f"{joint.name}.angle", f"{joint.name}.angular_velocity", "rad/s"
    if joint.slides:
        angle, speed, unit = f"{joint.name}.slide", f"{joint.name}.slide_rate", "m/s"
    parameters, effort = run.model.parameters, f"{effect}.{rub.told}"
    if rub.rate.path not in parameters or not {angle, effort} <= run.outputs.keys():
        return ""
    slowly, t = parameters[rub.rate.path], np.linspace(run.t[0], run.t[-1], LOOKS)
    try:
        found = run.values(angle, speed, effort, t=t)
    except ValueError:  # a record that knows no more than its rows
        return ""
    slow = np.abs(found[speed]) < slowly
    viscous = (parameters[rub.viscous.path] if rub.viscous else 0.0) * found[speed]
    acts = np.abs(found[effort] + viscous) > NOTHING * np.abs(viscous)  # brakes begin and end, and may have no torque
    both = slow[1:] & slow[:-1] & (acts[1:] | acts[:-1])  # at rest there is none
    lasts = float(np.sum(np.diff(t)[both]))
    way = float(np.sum(np.abs(np.diff(found[angle])[both])))
    if lasts <= LONG * (run.t[-1] - run.t[0]) or way <= LOADED * slowly * lasts:
        return ""
    far = f"{math.degrees(way):.3g}°" if unit == "rad/s" else f"{way:.3g} m"
    return (
        f"{joint.name} creeps against the dry friction of {effect}, slower than its rate of {slowly:g} {unit} for "
        f"{lasts:.3g} s of the run and by {far} in all, since that is smoothed; with a smaller rate in its table it "
        "creeps less, in proportion"
    )


def _always_dense(run: Run) -> Iterator[str]:
    """That closure rows depend on each other all along a run, so that the generated accelerations were of no use."""
    model = run.model
    if not len(getattr(model, "rows", ())) or not hasattr(model, "jacobian"):
        return
    numbers = np.unique(np.linspace(0, len(run.t) - 1, min(ROWS, len(run.t))).astype(int))
    lasting = [row.rpartition(".")[0] not in model.joint_gates for row in model.rows]
    idle = []
    for q in run.q[numbers]:
        rows = model.jacobian(q)[lasting]
        if not len(rows):
            return
        values = np.linalg.svd(rows, compute_uv=False)
        idle.append(len(rows) - int(np.count_nonzero(values > DEPENDENT * values[0])))
    if min(idle) > 0:
        yield (
            f"{min(idle)} of {len(model.rows)} closure rows follow from the others all along the run, joints being "
            f"redundant: all of its {run.nfev} evaluations went by the dense solution, which is slower than the "
            "generated equations; without the redundant joints the motion is the same"
        )


def _stiff(run: Run) -> Iterator[str]:
    """That most steps are as short as stability asks for, where an implicit method's need not be."""
    model, rows = run.model, np.linspace(0, len(run.t) - 2, ROWS).astype(int)
    if run.method not in STABLE or len(run.t) < MANY or not hasattr(model, "acceleration") or model.inputs:
        return
    state = run.state
    if state is None or state.settings["step"] or state.settings["rtol"] < TIGHT:
        return
    steps = np.diff(run.t)
    found = [steps[k] * rate for k in rows if steps[k] > 0.0 and (rate := _fastest(run, k)) is not None]
    if len(found) > ROWS // 2 and np.median(found) > NEAR * STABLE[run.method]:
        yield (
            f"most of the run's {len(steps)} steps are as short as {run.method} needs not to grow unstable, not as "
            "accuracy asks for: something is stiff, as strong damping or a hard compliant contact that damps; --method "
            "radau may need far fewer"
        )


def _fastest(run: Run, row: int) -> float | None:
    """The fastest rate (1/s) of the linearised motion at a row, where that dies away: the largest |λ| of the
    eigenvalues of [[0, 1], [∂a/∂q, ∂a/∂u]] by differences, in flight; ``None`` where the fastest is no decay
    (−Re λ < |Im λ|), as of a spring, whose swings accuracy has to follow, where a contact is closed, and where
    accelerations are none."""
    model, q, u, t = run.model, run.q[row], run.u[row], run.t[row]
    n, root = len(u), float(np.sqrt(np.finfo(float).eps))
    if len(model.contacts) and model.kernels.closed(q[None]).any():
        return None
    units = model.coordinate_units
    units = np.append(units, units / (model.time or model.duration))
    shifts = root * np.maximum(np.abs(np.append(q, u)), units)
    states = np.append(q, u) + np.vstack([np.zeros(2 * n), np.diag(shifts)])
    try:
        found = model.acceleration(states[:, :n], states[:, n:], t, contacts=())
    except ValueError:
        return None
    matrix = np.vstack([np.eye(n, 2 * n, n), ((found[1:] - found[0]) / shifts[:, None]).T])
    if not np.all(np.isfinite(matrix)):
        return None
    rates = np.linalg.eigvals(matrix)
    fastest = rates[np.argmax(np.abs(rates))]
    return float(np.abs(fastest)) if -fastest.real >= abs(fastest.imag) else None
