"""Derivatives of runs: ``sensitivities(model, wrt=["q0", "link.mass"], outputs=["tip.x", "impact_times"])``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .model.inputs import Given
from .model.model import Model
from .sensitivity.jacobian import Mode, Sensitivities, run_sensitivities
from .sensitivity.moving import Wrt
from .sensitivity.told import Output
from .simulate import simulate


def sensitivities(
    model: Model,
    wrt: Wrt,
    outputs: Sequence[Output] | Output = ("q", "u"),
    q0: ArrayLike | None = None,
    u0: ArrayLike | None = None,
    *,
    at: ArrayLike | None = None,
    until: float | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    method: str | None = None,
    step: float | None = None,
    params: Mapping[str, float] | None = None,
    inputs: Given = None,
    mode: Mode = "auto",
) -> Sensitivities:
    """Simulate a model and derive its run, exactly, through impacts, contact and friction (theory, section 11.5).

    ``wrt`` names what it is derived by: ``"q0"``, ``"u0"``, parameters by their paths, inputs, a column for each entry
    in that order; or it maps such names to directions (entries, columns). A start is put onto the closure and the
    drives as that of a run is; that of the scene moves with the parameters as ``Model.start`` does. ``outputs`` are
    names of outputs (coordinates and their rates, a link's ``angle`` and ``angular_velocity``, a point's ``x`` and
    ``y``, a contact's ``gap``, energies, in flight forces of joints), ``"q"`` and ``"u"``, ``"impact_times"``, and
    functions of (t, q, u) that return values and their derivatives by q and by u. They are read at the times ``at``
    (s), at the end of the run unless given. All other arguments are those of :func:`simulate`. Units are those of SI,
    and radians.

    ``mode`` says how: ``"tangent"`` takes differences along the run, from each column; ``"adjoint"`` takes covectors
    back through it, from each number that the outputs have; ``"auto"`` takes what there are fewer of. Both give the
    same derivatives, to rounding.

    Raises ``ValueError`` where there is no one matrix of derivatives or it is not known: time stepping, bounces that
    have come to rest, contacts that close together by chance, grazing, decisions of friction or of an impact within
    rounding, effects with kinks at which loads may jump, events of the scene that graze zero or come together by
    chance, joints that break
    by a force while contacts are held, controllers and tables as inputs, redundant joints; it says where and why. A
    model has to be generated with its derivatives.
    """
    if not isinstance(model, Model):
        raise TypeError(f"model: found {type(model).__name__}, expected a Model; load one with load_model(folder)")
    options: dict[str, Any] = {"until": until, "rtol": rtol, "atol": atol, "method": method, "step": step}
    run = simulate(model, q0, u0, params=params, inputs=inputs, **options)
    if isinstance(run, list):
        raise ValueError(f"q0: found {len(run)} starts, expected one; derive them one by one")
    given = tuple(None if part is None else np.asarray(part, dtype=float) for part in (q0, u0))
    return run_sensitivities(run, wrt, outputs, at, (given[0], given[1]), mode)
