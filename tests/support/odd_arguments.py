"""What no argument is, for every argument of a function: whether it is refused in words of the one who calls."""

from __future__ import annotations

import inspect
import re
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
OF_THE_MOTION = re.compile(r"cannot give this motion|does not determine the motion here|no equilibrium found from here")
"""What is said where an argument is taken, and the motion that it asks for is none."""
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


def _entries(given: object) -> list[str]:
    """What is given as texts, one by one; of a mapping its keys."""
    if isinstance(given, str):
        return [given]
    return (
        [str(one) for one in given] if isinstance(given, dict) or (isinstance(given, np.ndarray) and given.ndim) else []
    )


def complaint(call: Callable[..., Any], arguments: dict[str, Any] | tuple[Any, ...], argument: str = "") -> str | None:
    """What is wrong with how an odd ``argument`` is taken: nothing where it is taken, or refused in words that name
    it, or an entry of it by its key, with what was found and what was expected."""
    try:
        call(**arguments) if isinstance(arguments, dict) else call(*arguments)
    except DOCUMENTED as error:
        text = str(error.args[0]) if type(error) is KeyError and error.args else str(error)
        given = arguments.get(argument) if isinstance(arguments, dict) else arguments[0]
        names = [argument, *_entries(given)]
        if "expected" in text and "found" in text and any(name in text for name in names):
            return None
        if OF_THE_MOTION.search(text):
            return None
        return f"{type(error).__name__}: {text[:150]}"
    except Exception as error:
        return f"{type(error).__name__}: {str(error)[:150]}"
    return None
