"""Parameter values of a model, by scene path; setting one takes effect at once, nothing is compiled again."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, MutableMapping, Sequence
from numbers import Real
from typing import Any

from ..faults import Faults, UnknownName

GATES = {
    "on": "an effect has one where an [[event]] of the scene names it in on or off, or [start] has it off",
    "held": "a joint has one where a [[release]] or a [[hold]] of the scene names it",
}
"""Which parameters that switch something a model has, by the last word of their paths."""


class Parameters(MutableMapping[str, float]):
    """Names are fixed, values are finite numbers in SI units, each within its domain: a mass stays positive.

    Raises ``KeyError`` for unknown names (with the nearest known ones) and ``ValueError`` for impossible values, and
    where there is some of both.
    ``declared`` are paths, values and domains as the model's data has them, ``values`` those that are other than there.
    Those of a ``folded`` model (its name) but its ``gates`` can be read only: its code holds them as numbers.
    ``rests_on`` are those that must keep their values, each with the joint that the equations leave out because it fits
    others with them; ``over_time`` are the paths of what the scene gives over time, so that it is none of them, and as
    what; ``by_laws`` are those of loads that are expressions of the state, each with the laws that it names.
    """

    def __init__(
        self,
        declared: Sequence[Mapping[str, Any]],
        values: Mapping[str, float],
        changed: Callable[[], None],
        folded: str = "",
        rests_on: Mapping[str, str] | None = None,
        over_time: Mapping[str, str] | None = None,
        gates: Collection[str] = (),
        by_laws: Mapping[str, Sequence[str]] | None = None,
    ) -> None:
        self._values: dict[str, float] = {one["path"]: one["value"] for one in declared} | dict(values)
        self._domains = {one["path"]: one["domain"] for one in declared}
        self._changed = changed
        self._folded = folded
        self._rests_on = dict(rests_on or {})
        self._over_time = dict(over_time or {})
        self._gates = frozenset(gates)
        self._by_laws = dict(by_laws or {})

    def __getitem__(self, name: str) -> float:
        self._known(name)
        return self._values[name]

    def __contains__(self, name: object) -> bool:  # that of a mapping looks for near names first
        return name in self._values

    def get(self, name: str, default: Any = None) -> Any:  # that too
        return self._values.get(name, default)

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
        checked = self.checked(other)
        before = dict(self._values)
        self._values.update(checked)
        try:
            self._changed()
        except ValueError:
            self._values = before
            self._changed()
            raise

    def checked(self, other: Mapping[str, float]) -> dict[str, float]:
        """Values that may be set, as numbers. Raises as ``update`` does, but for values that do not go together."""
        if not isinstance(other, Mapping):
            raise TypeError(
                f"parameters: found {type(other).__name__}, expected a mapping of parameter names to values"
            )
        faults, checked = Faults(), {}
        for name, value in other.items():
            with faults.collecting():
                checked[name] = self._checked(name, value)
        faults.stop_if_any()
        numbers = [path for path in checked if path not in self._gates]
        if self._folded and numbers:
            raise ValueError(
                f"{numbers[0]}: found a new value for {self._folded}, whose parameters are folded into its code as "
                "numbers; build it without --fold (ccgen --scene FILE, or generate(scene)) to change them"
            )
        return checked

    def _known(self, name: str) -> None:
        if name in self._by_laws:
            raise UnknownName(
                f"{name}: found a load that the scene gives by the state, expected a parameter; "
                f"{self._instead(self._by_laws[name])}"
            )
        if name in self._over_time:
            raise UnknownName(
                f"{name}: found a value that the scene gives over time ({self._over_time[name]}), expected a "
                "parameter; write a number in its place in the scene, or names of [let] within it, and set that"
            )
        if name not in self._values and (gate := str(name).rpartition(".")[2]) in GATES:
            raise UnknownName(f"{name}: found no such parameter, expected one of the model; {GATES[gate]}")
        if name not in self._values:
            near = self._near(str(name))
            raise UnknownName(
                f"{name}: found no such parameter, expected one of the model, as {', '.join(near)}; correct the name"
                if near
                else f"{name}: found no such parameter, expected none: the model has no parameters"
            )

    def _instead(self, laws: Sequence[str]) -> str:
        """What to set where a load is an expression of the state that names these laws."""
        own = [path for path in self._values if path.rpartition(".")[0] in laws]
        if own:
            return f"set what its law has, as {', '.join(own[:3])}"
        return "give it a [[law]] with parameters in the scene, and set those"

    def _near(self, name: str) -> list[str]:
        """Up to three names that may be meant, of what is given over time too, which is said: of a length the
        coordinates of that link's points, which make it."""
        from difflib import get_close_matches

        owner, _, word = name.rpartition(".")
        points = [one for one in self._values if one.startswith(f"{owner}.points.") and self._values[one] != 0.0]
        if word == "length" and points:
            return points[:3]
        if not owner and (ends := [one for one in self._values if one.endswith(f".{word}")]):
            return ends[:3]
        near = get_close_matches(name, (*self._values, *self._over_time), n=3) or list(self._values)[:3]
        return [f"{one} (given over time)" if one in self._over_time else one for one in near]

    def _checked(self, name: str, value: float) -> float:
        self._known(name)
        if isinstance(value, bool) and name in self._gates:
            return float(value)
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
        if wanted := unmet(self._domains[name], number):
            raise ValueError(f"{name}: found {number}, expected {wanted}")
        return number


def unmet(domain: Mapping[str, Any], number: float) -> str:
    """What a number outside its domain was expected to be, in words; empty if it is inside."""
    if domain.get("whole"):
        return "" if number in (0.0, 1.0) else "1 or 0"
    minimum, above, maximum = domain["minimum"], domain["above"], domain["maximum"]
    inside = (
        (minimum is None or number >= minimum)
        and (above is None or number > above)
        and (maximum is None or number <= maximum)
    )
    if inside:
        return ""
    if (minimum, above, maximum) == (0.0, None, None):
        return "a number that is not negative"
    if (minimum, above, maximum) == (None, 0.0, None):
        return "a positive number"
    if above is None and minimum is not None and maximum is not None:
        return f"a number from {minimum:g} to {maximum:g}"
    bounds = ((minimum, "at least"), (above, "more than"), (maximum, "at most"))
    return "a number " + " and ".join(f"{words} {bound:g}" for bound, words in bounds if bound is not None)
