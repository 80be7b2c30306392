"""Derivatives of a model beside differences of the same model in wide numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..oracles.maximal import WIDE, Array

STEP = 2.0**-12
"""Step of the differences, whose error falls with its sixth power; kinks are seldom as near as that."""

SMALL = 0.05
"""Parameters below this are changed by larger parts of themselves, so that rounding does not tell."""

BOUND = 2e-9
"""Relative to the largest derivative of the same function by the same argument; the differences reach about 1e-11."""


def value(model: Any, of: str, q: Array, u: Array, t: float, inputs: Any) -> Array:
    """What the model says of its own function, shaped as its derivatives are."""
    if of in ("acceleration", "multipliers", "reactions"):
        return np.asarray(getattr(model, of)(q, u, t, inputs or None, contacts=()))
    if of in ("poses", "gaps"):
        return np.asarray(getattr(model, of)(q))
    if of in ("velocities", "energy", "gap_rates"):
        return np.array(getattr(model, of)(q, u))
    if of == "points":
        return np.asarray(model.kernels.of_q(of, q[None])[0]).reshape(-1, 2)
    kernels = model.kernels
    return np.asarray(kernels.of_q(of, q[None])[0] if of == "closure" else kernels.of_state(of, q[None], u[None])[0])


KNOWN = (
    "acceleration",
    "multipliers",
    "reactions",
    "closure",
    "closure_rate",
    "gaps",
    "gap_rates",
    "poses",
    "velocities",
    "points",
    "energy",
)
"""Functions of which a model tells values as well."""


def difference(function: Callable[[float], Array], step: float) -> Array:
    """The derivative at zero by central differences at three steps (L. F. Richardson, 1911)."""
    near, far, farthest = ((function(h) - function(-h)) / (2 * WIDE(h)) for h in (step, 2 * step, 4 * step))
    return (64 * near - 20 * far + farthest) / 45


def differences(wide: Any, of: str, q: Array, u: Array, t: float, inputs: dict[str, float], name: str) -> Array:
    """By all entries of an argument, an input or a parameter, columns last."""
    if name in ("q", "u"):
        units = np.eye(len(q), dtype=WIDE)
        moved = {"q": lambda h, e: (q + h * e, u), "u": lambda h, e: (q, u + h * e)}[name]
        columns = [difference(lambda h, e=e: value(wide, of, *moved(h, e), t, inputs), STEP) for e in units]
    elif name == "t":
        columns = [difference(lambda h: value(wide, of, q, u, t + h, inputs), STEP)]
    elif name in inputs:
        columns = [difference(lambda h: value(wide, of, q, u, t, {**inputs, name: inputs[name] + h}), STEP)]
    else:
        at = wide.parameters[name]

        def changed(h: float) -> Array:
            return value(wide.with_parameters({name: at + h}), of, q, u, t, inputs)

        step = (8 * STEP if abs(at) < SMALL else STEP) * abs(at) or STEP
        columns = [difference(changed, float(np.ldexp(1.0, int(np.log2(step)))))]
    return np.stack(columns, axis=-1)


def parameters_of(model: Any) -> list[str]:
    """Those whose values may be changed a little to both sides."""
    found = []
    for one in model.data["parameters"]:
        edges = [one["domain"][name] for name in ("minimum", "above", "maximum")]
        if one["path"] not in model.data["rests_on"] and one["value"] not in edges:
            found.append(one["path"])
    return found


def check_derivatives(model: Any, wide: Any, q: Array, u: Array, t: float = 0.3, of: Sequence[str] = KNOWN) -> None:
    """All derivatives of the functions against differences of the ``wide`` model, one argument after the other."""
    inputs = {name: 0.4 + 0.3 * k for k, name in enumerate(model.inputs)}
    long = np.asarray(q, dtype=WIDE), np.asarray(u, dtype=WIDE)
    names = ["q", "u", "t", *model.inputs, *parameters_of(model)]
    for what in of:
        found = model.derivatives(what, q, u, t, inputs or None, names, contacts=())
        first, scale = 0, float(np.max(np.abs(found), initial=0.0))
        for name in names:
            wanted = differences(wide, what, *long, t, inputs, name)
            part = found[..., first : first + wanted.shape[-1]]
            first += wanted.shape[-1]
            assert part.shape == wanted.shape
            size = max(float(np.max(np.abs(wanted), initial=0.0)), 1e-4 * scale, 1e-12)
            assert float(np.max(np.abs(part - wanted), initial=0.0)) <= BOUND * size, (what, name)
