"""Laws and loads of the state that have no value where a run is to begin, or where it ends."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..model.model import Model
from ..record.outputs import States, outputs_of

AHEAD = (0.0, 1e-12, 1e-9, 1e-6)
"""How far beyond the last row of a run, as parts of its time to there, expressions are tried: a step that comes to
where one has no value is refused, so that the last row is on the side where it has one."""
GROWN, VAST = 1e6, 1e9
"""A value that is so many times that of the first row (and 1 at least), or where no other row is known so large, is on
its way to infinity in a run that has stopped because of its accelerations, unless the coordinates have gone far."""
FAR = 1e3
"""Coordinates that are so many times those of the first row (and 1 at least) have gone far."""
_OUTPUTS = {
    "angle": "{}.angle",
    "direction": "{}.angle",
    "slide": "{}.slide",
    "x": "{}.x",
    "y": "{}.y",
    "rate angle": "{}.angular_velocity",
    "rate direction": "{}.angular_velocity",
    "rate slide": "{}.slide_rate",
    "rate x": "{}.vx",
    "rate y": "{}.vy",
}
"""The outputs of runs that tell what expressions ask."""


class _Place(States):
    """States whose accelerations nobody asks for."""

    @property
    def motion(self) -> Any:
        raise AssertionError("no accelerations are known here")


def check_values(model: Model, q: FloatArray, u: FloatArray, t: float) -> None:
    """Raise ``ValueError`` where a load of the state has no finite value at a start."""
    found = _wrong(model, t, q, u, np.inf)
    if found is not None:
        where = f"at t = {t:g} s" if t else "at the start"
        raise ValueError(
            f"{_named(found)} has no finite value {where}{_with(model, found, t, q, u)}; change the start, or write it "
            "so that it has one there, as with max(...) in a root or a divisor"
        )


def without_value(model: Model, found: Mapping[str, Any]) -> str:
    """Why a run stopped, in words, if that is because a law or a load has no value there; empty else."""
    if not model.data.get("of_state"):
        return ""
    t, q, u = float(found["t_end"]), found["q"][-1], found["u"][-1]
    for ahead in AHEAD:
        further = ahead * max(abs(t), 1e-3)
        place = q + further * u if len(q) == len(u) else q
        wrong = _wrong(model, t + further, place, u, _bounds(model, found))
        if wrong is not None:
            return (
                f"{_named(wrong)} comes to where it has no finite value{_with(model, wrong, t, q, u)}; end before, or "
                "write it so that it has one everywhere, as with max(...) in a root or a divisor"
            )
    return ""


def _bounds(model: Model, found: Mapping[str, Any]) -> FloatArray:
    """How large what effects tell may be, (told,)."""
    if np.any(np.abs(found["q"][-1]) > FAR * np.maximum(1.0, np.abs(found["q"][0]))):
        return np.full(len(model.told), np.inf)
    if len(found["q"]) < 2:
        return np.full(len(model.told), VAST)
    first = _told(model, float(found["t"][0]), found["q"][0], found["u"][0])
    with np.errstate(over="ignore"):
        return np.asarray(GROWN * np.maximum(1.0, np.nan_to_num(np.abs(first))))


def _told(model: Model, t: float, q: FloatArray, u: FloatArray) -> FloatArray:
    place, rates = (np.ascontiguousarray(one, dtype=model.core.REAL)[None] for one in (q, u))
    return np.asarray(model.kernels.told(place, rates, t)[0], dtype=np.float64)


def _wrong(model: Model, t: float, q: FloatArray, u: FloatArray, most: FloatArray | float) -> dict[str, Any] | None:
    """The first load that has no value, or a larger one than ``most`` (told,), or the law by which it has none."""
    said: list[dict[str, Any]] = model.data.get("of_state", [])
    if not any(one["load"] for one in said):
        return None
    with np.errstate(all="ignore"):
        bad = ~(np.abs(_told(model, t, q, u)) <= np.where(np.isinf(most), np.finfo(float).max, most))
    wrong = {name for (name, _), one in zip(model.told, bad, strict=True) if one}
    laws = {one["name"]: one for one in said if not one["load"]}
    found = next((one for one in said if one["load"] and wrong.intersection(one["outputs"])), None)
    while found and (inner := [name for name in found["laws"] if wrong.intersection(laws[name]["outputs"])]):
        found = laws[inner[0]]
    return found


def _named(one: Mapping[str, Any]) -> str:
    return f"{one['name']} = {one['text']}"


def _with(model: Model, one: Mapping[str, Any], t: float, q: FloatArray, u: FloatArray) -> str:
    """The values of what an expression asks of the state, in words."""
    told = ", ".join(_values(model, one, t, q, u))
    return f", with {told}" if told else ""


def _values(model: Model, one: Mapping[str, Any], t: float, q: FloatArray, u: FloatArray) -> Iterator[str]:
    known = outputs_of(model)
    place = _Place(model, np.array([t]), q[None], u[None])
    for asked in one["asks"]:
        kind, of = (parts := re.findall(r"[^()]+", asked))[:-1], parts[-1]
        name = _OUTPUTS.get(" ".join(kind), "").format(of)
        if name in known:
            yield f"{asked} = {float(np.asarray(known[name].of(place))[0]):.6g}"
