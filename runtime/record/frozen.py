"""Records whose arrays nobody changes."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..precision import finite


def freeze(record: object, *names: str) -> None:
    """Make the named fields read-only arrays of finite numbers, of the precision that they have."""
    for name in names:
        array = np.array(getattr(record, name))
        array = array if array.dtype.kind == "f" else array.astype(float)
        if array.size and not finite(array):
            raise ValueError(f"{name} of the {type(record).__name__.lower()} holds a number that is not finite")
        array.setflags(write=False)
        object.__setattr__(record, name, array)


def restore(record: object, state: dict[str, Any]) -> None:
    """Fill a record from a pickle or a copy; its arrays are read-only as before."""
    vars(record).update(state)
    for value in state.values():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
