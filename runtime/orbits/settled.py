"""Where many runs settle along a parameter: the bifurcation diagram by brute force, of what is stable alone."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arrays import FloatArray
from ..ensemble.ensemble import ensemble
from .orbit import Orbit
from .section import Map
from .values import names_of


def settled(
    orbit: Orbit,
    parameter: str,
    values: FloatArray,
    name: str,
    *,
    crossings: int = 300,
    last: int = 60,
    progress: Callable[[int, int], object] | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Runs from an orbit's state at other ``values`` (b,) of a parameter, and a coordinate or rate by ``name`` at the
    ``last`` of so many ``crossings`` of its section: values and what is there, each (b * last,), as pairs.

    Not a number where a run did not come so far. With a time as section they are an :func:`ensemble`; with a contact
    the map is applied run by run.
    """
    a_map = orbit.return_map.single()
    if name not in names_of(a_map.model):
        raise ValueError(f"name: found {name!r}, expected one of {', '.join(names_of(a_map.model))}")
    if isinstance(a_map.section, float) and a_map.relabel is None:
        at = a_map.section * np.arange(crossings - last + 1, crossings + 1)
        options = {key: value for key, value in a_map.options.items() if value is not None}
        table = ensemble(
            a_map.model,
            {parameter: values},
            orbit.q,
            orbit.u,
            observe=[name],
            at=at,
            until=float(at[-1]),
            progress=progress,
            **options,
        )
        found = np.asarray(table[name])
    else:
        place = names_of(a_map.model).index(name)
        rows = []
        for done, value in enumerate(values.tolist()):
            rows.append(
                _iterated(a_map.of(a_map.model.with_parameters({parameter: value})), orbit, crossings)[:, place]
            )
            if progress is not None:
                progress(done + 1, len(values))
        found = np.array(rows)[:, -last:]
    return np.repeat(values, last), found.ravel()


def _iterated(a_map: Map, orbit: Orbit, crossings: int) -> FloatArray:
    """The states (crossings, 2 n) behind each crossing; not a number from where a run does not come back."""
    found = np.full((crossings, 2 * len(orbit.q)), np.nan)
    q, u = orbit.q, orbit.u
    for row in found:
        try:
            q, u = a_map.after(q, u)
        except ValueError:  # it falls, or stops
            break
        row[:] = np.concatenate([q, u])
    return found
