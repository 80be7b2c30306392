"""Loops thrown onto the ground to their third impact and beyond, and the derivatives of their runs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from ccgen.runtime import Model, sensitivities, simulate

from ..hard import fuzz
from .run_differences import RTOL, along, relative
from .workshop import Workshop

BOUND = 1e-9
"""What is asked for. The differences themselves are known to about 1e-12, times what three impacts make of rounding."""

IMPACTS = 3


def parameters(rough: bool, stays: bool) -> tuple[str, ...]:
    """A length, a mass, a slope, gravity, and what there is of restitution and friction."""
    some = (*(["ground_0.restitution"] * (not stays)), *(["ground_0.friction"] * rough))
    return "link_0.length", "link_1.mass", "ground_0.normal.x", "gravity.g", *some


def misses(
    workshop: Workshop, n: int, rough: bool, seed: int, count: int, stays: bool = False
) -> Iterator[tuple[float, str]]:
    """How far derivatives of so many throws are from differences; and why not, where these are refused. Where a loop
    ``stays``, it has no restitution, and slides, sticks, rolls over and is let go behind its impacts."""
    scene = fuzz.scene(n, rough)
    models = workshop.model(scene, derivatives=True), workshop.model(scene, "wide")
    for thrown in throws(models, n, rough, seed, count, stays):
        try:
            yield _miss(*thrown, parameters(rough, stays)), ""
        except ValueError as error:
            yield 0.0, str(error)


def throws(
    models: tuple[Any, Any], n: int, rough: bool, seed: int, count: int, stays: bool = False
) -> Iterator[tuple[Any, Any, Any, Any, float, np.random.Generator]]:
    """So many throws of loops of n rods: the model in doubles and in wide numbers, a start, an end, and random numbers
    to go on with."""
    made = number = 0
    while made < count:
        rng = np.random.default_rng([seed, n, rough, number])
        toss = replace(next(fuzz.tosses(1, int(rng.integers(2**31)), rough=rough)), n=n)
        number += 1
        restitution = 0.0 if stays else min(max(toss.restitution, 0.1), 0.9)  # the differences go to either side
        thrown = _thrown(models, replace(toss, restitution=restitution), rng)
        if thrown is None:
            continue
        made += 1
        yield *thrown, rng


def _thrown(
    models: tuple[Any, Any], toss: fuzz.Toss, rng: np.random.Generator
) -> tuple[Any, Any, Any, Any, float] | None:
    """The model in doubles and in wide numbers, a start, and an end between the third impact and the fourth; None where
    there are not as many, or friction and Newton's law take some of the restitution."""
    values = fuzz.numbers(toss, rng)
    model, wide = (Model(m._descriptor, {**m.data, "law": toss.law}).with_parameters(values) for m in models)
    q, u = model.start()
    u = u + 2.0 * rng.normal(size=u.size)
    q[2:] += rng.normal()
    q, u = model.project(q, u)
    q[1] += 0.2 + 1.5 * max(0.0, -float(model.gaps(q).min()))
    impacts = simulate(model, q, u, until=4.0, rtol=RTOL).impacts
    times = [impact.t for impact in impacts]
    # the part of restitution that gains nothing is found to 1e-9, by which runs beside each other then differ
    if len(times) <= IMPACTS or any(impact.restitution_share < 1.0 for impact in impacts[:IMPACTS]):
        return None
    if toss.restitution == 0.0:
        end = times[IMPACTS - 1] + 0.05 + 0.3 * rng.random()
        # where impacts crowd, runs beside each other part: in some, what closes within a tolerance strikes together
        apart = np.min(np.diff([t for t in [0.0, *times] if t < end]))
        return (model, wide, q, u, end) if min(apart, *(abs(t - end) for t in times)) > 1e-4 else None
    end = 0.5 * (times[IMPACTS - 1] + times[IMPACTS])
    return (model, wide, q, u, end) if times[IMPACTS] - times[IMPACTS - 1] > 1e-3 else None


def _miss(model: Any, wide: Any, q: Any, u: Any, end: float, rng: np.random.Generator, names: tuple[str, ...]) -> float:
    wrt = directions(q, names, rng)
    found = sensitivities(model, wrt, ["q", "u", "impact_times"], q, u, until=end, rtol=RTOL)
    return relative(found.jacobian, along(wide, model, wrt, end, q, u))


def directions(q: Any, names: tuple[str, ...], rng: np.random.Generator) -> dict[str, Any]:
    """One direction in q0, one in u0, and each of the parameters."""
    columns = 2 + len(names)
    wrt = {"q0": np.zeros((len(q), columns)), "u0": np.zeros((len(q), columns))}
    wrt["q0"][:, 0], wrt["u0"][:, 1] = rng.normal(size=len(q)), rng.normal(size=len(q))
    wrt |= {name: np.eye(columns)[2 + k] for k, name in enumerate(names)}
    return wrt
