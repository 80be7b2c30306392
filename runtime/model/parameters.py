"""Parameter values of a model, by scene path; setting one takes effect at once, nothing is compiled again."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, MutableMapping
from numbers import Real


class Parameters(MutableMapping[str, float]):
    """Names are fixed, values are finite numbers in SI units; masses and inertias stay positive, restitution in [0, 1],
    friction and radii of contacts not negative.

    Raises ``KeyError`` for an unknown name (with the nearest known ones) and ``ValueError`` for an impossible value.
    Those of a ``folded`` model (its name) can be read only: its code holds them as numbers. ``rests_on`` are those that
    must keep their values, each with the joint that the equations leave out because it fits others with them.
    """

    def __init__(
        self,
        values: Mapping[str, float],
        changed: Callable[[], None],
        folded: str = "",
        rests_on: Mapping[str, str] | None = None,
    ) -> None:
        self._values = dict(values)
        self._changed = changed
        self._folded = folded
        self._rests_on = dict(rests_on or {})

    def __getitem__(self, name: str) -> float:
        self._known(name)
        return self._values[name]

    def __setitem__(self, name: str, value: float) -> None:
        self.update({name: value})

    def __delitem__(self, name: str) -> None:
        raise TypeError("a model's parameters cannot be removed; generate a model without the effect instead")

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        return f"Parameters({self._values!r})"

    def update(self, other: Mapping[str, float], /) -> None:  # type: ignore[override]
        """Set several values together: all of them, or none when one is wrong."""
        if not isinstance(other, Mapping):
            raise TypeError(f"found {type(other).__name__}, expected a mapping of parameter names to values")
        checked = {name: self._checked(name, value) for name, value in other.items()}
        if self._folded and checked:
            raise ValueError(
                f"{next(iter(checked))}: found a new value for {self._folded}, whose parameters are folded into its "
                "code as numbers; build it without --fold (ccgen --scene FILE, or generate(scene)) to change them"
            )
        before = dict(self._values)
        self._values.update(checked)
        try:
            self._changed()
        except ValueError:
            self._values = before
            self._changed()
            raise

    def _known(self, name: str) -> None:
        if name not in self._values:
            from difflib import get_close_matches

            near = get_close_matches(str(name), self._values, n=3) or list(self._values)[:3]
            raise KeyError(f"the model has no parameter {name!r}; it has, among others, {', '.join(near)}")

    def _checked(self, name: str, value: float) -> float:
        self._known(name)
        if isinstance(value, bool) or not isinstance(value, Real):
            raise ValueError(f"{name}: found {value!r}, expected a number")
        number = float(value)
        if not math.isfinite(number):
            raise ValueError(f"{name}: found {number}, expected a finite number")
        if name in self._rests_on and number != self._values[name]:
            raise ValueError(
                f"{name}: found {number}, expected {self._values[name]}, because only with that {self._rests_on[name]} "
                "holds what other joints hold; change the scene, or remove the joint there"
            )
        if name.endswith((".mass", ".inertia", ".length")) and not number > 0.0:
            raise ValueError(f"{name}: found {number}, expected a positive number")
        if name.endswith(".restitution") and not 0.0 <= number <= 1.0:
            raise ValueError(f"{name}: found {number}, expected a number from 0 to 1")
        if (
            name.split(".")[1:2] in (["friction"], ["radius"]) and not number >= 0.0
        ):  # of a contact; lists go on behind it
            raise ValueError(f"{name}: found {number}, expected a number that is not negative")
        return number
