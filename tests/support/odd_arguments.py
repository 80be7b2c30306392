"""What no argument is, for every argument of a function: whether it is refused in words of the one who calls."""

from __future__ import annotations

import inspect
from collections import UserDict
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

ODD: dict[str, Any] = {
    "None": None,
    "3": 3,
    "-1": -1,
    "0": 0,
    "huge": 10**400,
    "nan": float("nan"),
    "inf": float("inf"),
    "True": True,
    "complex": 1j,
    "empty text": "",
    "text": "no such",
    "bytes": b"",
    "set": set(),
    "list": [],
    "lists": [[1.0], [1.0, 2.0]],
    "list of None": [None],
    "dict": {},
    "dict of None": {"a": None},
    "dict by number": {3: 1.0},
    "object": object(),
    "type": int,
    "function": lambda *_, **__: None,
    "array": np.ones(2),
    "matrix": np.ones((2, 2)),
    "cube": np.ones((2, 2, 2)),
    "texts": np.array(["a", "b"]),
    "objects": np.array([None, {}], dtype=object),
    "scalar array": np.array(1.0),
    "user's dict": UserDict(),
}
DOCUMENTED = (ValueError, TypeError, KeyError, FileNotFoundError, ImportError, IsADirectoryError, PermissionError)
"""Kinds of errors that a caller is told of. Others are faults of ours."""


def odd_calls(call: Callable[..., Any], given: dict[str, Any], *args: Any) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """For each parameter of a function and each odd value: their names, and all arguments by name."""
    signature = inspect.signature(call)
    bound = signature.bind_partial(*args).arguments
    for name, parameter in signature.parameters.items():
        if name in bound or parameter.kind in (parameter.VAR_KEYWORD, parameter.VAR_POSITIONAL):
            continue
        for odd, value in ODD.items():
            yield name, odd, {**given, name: value}


def complaint(call: Callable[..., Any], arguments: dict[str, Any]) -> str | None:
    """What is wrong with how an odd argument is taken: nothing where it is taken, or refused with what was found."""
    try:
        call(**arguments)
    except DOCUMENTED as error:
        text = str(error.args[0]) if type(error) is KeyError and error.args else str(error)
        if "expected" in text or "found" in text:
            return None
        return f"{type(error).__name__}: {text[:150]}"
    except Exception as error:
        return f"{type(error).__name__}: {str(error)[:150]}"
    return None
