"""Which model is in force when along a run: events set parameters, and switch effects on and off."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from .drawable import Drawable

Numbers = NDArray[np.intp]
APART = 2.0**20
"""The gap of a contact whose effect is off, and what such an effect tells for a length (``APART`` of
generator/derive/gated.py)."""


@dataclass(frozen=True, eq=False)
class InForce:
    """The ``models`` of a run, no two alike, and the spans in which they are in force.

    Of each span the number of its model, ``which``, its time ``since`` (s), and the first of the run's ``rows`` and
    ``impacts`` in it.
    """

    models: tuple[Drawable, ...]
    which: Numbers
    since: FloatArray
    rows: Numbers
    impacts: Numbers

    @classmethod
    def of_one(cls, model: Drawable) -> InForce:
        """One model all the time."""
        none = np.zeros(1, dtype=np.intp)
        return cls((model,), none, np.zeros(1), none, none)

    @classmethod
    def of_spans(cls, spans: Sequence[tuple[Drawable, float, int, int]]) -> InForce:
        """Of a model, when it begins, its first row and its first impact each; what goes on alike is one span."""
        numbers: dict[tuple[str, tuple[float, ...]], int] = {}
        models: list[Drawable] = []
        kept: list[tuple[int, float, int, int]] = []
        for model, since, row, impact in spans:
            if kept and model is models[kept[-1][0]]:
                continue
            key = model.name, tuple(model.parameters.values())
            if key not in numbers:
                numbers[key] = len(models)
                models.append(model)
            if not kept or kept[-1][0] != numbers[key]:
                kept.append((numbers[key], since, row, impact))
        which, rows, impacts = (np.array([one[column] for one in kept], dtype=np.intp) for column in (0, 2, 3))
        return cls(tuple(models), which, np.array([since for _, since, _, _ in kept]), rows, impacts)

    @property
    def changes(self) -> FloatArray:
        """The times (s) at which another model comes into force."""
        return self.since[1:]

    def at(self, t: FloatArray) -> Numbers:
        """The number of the model at each of the times (n,), that after a change at the change."""
        return self._within(self.since, t)

    def at_rows(self, count: int) -> Numbers:
        """That at each of ``count`` rows of the run; of the two of a change the first is before it."""
        return self._within(self.rows, np.arange(count))

    def at_impact(self, number: int) -> Drawable:
        """The model in which the impact of that ``number``, from 0, came."""
        return self.models[int(self._within(self.impacts, np.array([number]))[0])]

    def _within(self, begins: FloatArray | Numbers, where: FloatArray | Numbers) -> Numbers:
        found: Numbers = self.which[np.maximum(np.searchsorted(begins, where, side="right") - 1, 0)]
        return found

    def told(self, which: Numbers, ask: Callable[[Drawable, NDArray[np.bool_]], FloatArray]) -> FloatArray:
        """What ``ask`` answers for a model and those of the states (n,) at which it is in force, for all of them."""
        if len(self.models) == 1 or not len(which):
            return np.asarray(ask(self.models[0], np.ones(len(which), dtype=bool)))
        parts = [(which == number, model) for number, model in enumerate(self.models)]
        answers = [(rows, np.asarray(ask(model, rows))) for rows, model in parts if rows.any()]
        first = answers[0][1]
        found = np.empty((len(which), *first.shape[1:]), dtype=first.dtype)
        for rows, answer in answers:
            found[rows] = answer
        return found


def of_contacts(model: Drawable, values: FloatArray) -> FloatArray:
    """Numbers (n, contacts) of a model's contacts; not numbers of those that are off."""
    off = [model.contacts.index(contact) for contact in model.off_contacts]
    if off:
        values = np.array(values)
        values[:, off] = np.nan
    return values
