"""Which loads of a model are expressions of the state, and which of them have rates in them."""

from __future__ import annotations

from .model import Model


def loads_of_state(model: Model) -> dict[str, bool]:
    """The loads in force that ask something of the state, themselves or by laws, each with whether a rate is in it."""
    asks: dict[str, set[str]] = {}
    found: dict[str, bool] = {}
    for one in model.data.get("of_state", []):  # laws first, each behind those that it names
        asked = {*one["asks"]}.union(*(asks[law] for law in one["laws"]))
        if not one["load"]:
            asks[one["name"]] = asked
        elif asked and one["name"].partition(".")[0] not in model.off:
            found[one["name"]] = any(word.startswith("rate(") for word in asked)
    return found
