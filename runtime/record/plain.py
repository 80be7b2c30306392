"""Records as text and arrays, for files that hold no code: nothing is made from them but records of known kinds."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import is_dataclass
from typing import Any

import numpy as np

from ..arrays import FloatArray

TEXT, BUFFER = "record", "record_"
"""Arrays of a file: the text, and the numbers of each type one after the other, ``record_float64``."""
VERSION, VERSION_KEY = 3, "record_version"
"""The number of what the text says, and the array that has it: it grows where records are made otherwise. Files without
it are of the first."""
LOST = "lost"
"""In place of a function, which no file holds."""

Found = Mapping[str, "np.ndarray[Any, Any]"]


class Writer:
    """Writes one record, and all that it holds, beside arrays by name, which are not written a second time.

    ``tell`` answers plain values that tell a model, None for what is no model.
    """

    def __init__(self, tell: Callable[[Any], Any], named: Found) -> None:
        self.tell = tell
        self.buffers: dict[str, list[np.ndarray[Any, Any]]] = {}
        self.sizes: dict[str, int] = {}
        self.places: dict[tuple[str, tuple[int, ...], bytes], Any] = {
            _content(array): name for name, array in named.items() if array.dtype.kind == "f"
        }
        self.met: dict[int, int] = {}
        self.kept: list[Any] = []  # so that no other object gets the same id meanwhile

    def arrays(self, record: Any) -> dict[str, np.ndarray[Any, Any]]:
        """The arrays to put into the file. Raises ``TypeError`` for what has no plain form."""
        text = json.dumps(self._plain(record), separators=(",", ":"))
        found = {BUFFER + kind: np.concatenate(parts) for kind, parts in sorted(self.buffers.items())}
        return {TEXT: np.frombuffer(text.encode(), dtype=np.uint8), VERSION_KEY: np.array(VERSION), **found}

    def _plain(self, value: Any) -> Any:
        if value is None or isinstance(value, bool | int | str):
            return value
        if isinstance(value, np.generic):
            return {"number": self._array(np.array(value))}
        if isinstance(value, np.ndarray):
            return {"array": self._array(value)}
        if isinstance(value, bytes):
            return {"bytes": self._array(np.frombuffer(value, dtype=np.uint8))}
        return value if isinstance(value, float) else self._of_many(value)

    def _of_many(self, value: Any) -> Any:
        """Of what holds others."""
        if isinstance(value, list):
            return [self._plain(one) for one in value]
        if isinstance(value, frozenset):
            return {"set": [self._plain(one) for one in sorted(value)]}
        if isinstance(value, Mapping):
            return {"table": [[self._plain(key), self._plain(one)] for key, one in value.items()]}
        if isinstance(value, tuple):
            row = {"row": [self._plain(one) for one in value]}
            return row if type(value) is tuple else {"kind": kind_of(type(value)), **row}
        return self._of_record(value)

    def _of_record(self, value: Any) -> Any:
        """Of models and records, each written once."""
        if id(value) in self.met:
            return {"again": self.met[id(value)]}
        if (said := self.tell(value)) is not None:
            self._meet(value)
            return {"model": self._plain(said)}
        if is_dataclass(value) and not isinstance(value, type):
            self._meet(value)
            own = getattr(value, "__getstate__", None)  # every object has one from Python 3.11 on; most answer vars
            state = own() if own is not None else vars(value)
            return {
                "kind": kind_of(type(value)),
                "state": {name: self._plain(one) for name, one in dict(state).items()},
            }
        if callable(value):
            return LOST
        raise TypeError(f"{kind_of(type(value))}: found a kind that no file of a run holds")

    def _meet(self, value: Any) -> None:
        self.met[id(value)] = len(self.kept)
        self.kept.append(value)

    def _array(self, array: np.ndarray[Any, Any]) -> Any:
        """Where the numbers of an array are: the name of another of the file, or type, place and shape."""
        content = _content(array)
        if content not in self.places:
            kind = array.dtype.name
            begin = self.sizes.get(kind, 0)
            self.buffers.setdefault(kind, []).append(np.ascontiguousarray(array).ravel())
            self.sizes[kind] = begin + array.size
            self.places[content] = [kind, begin, *array.shape]
        return self.places[content]


class Reader:
    """Reads what :class:`Writer` wrote, records of these ``kinds`` by their names alone.

    ``find`` answers the model that plain values tell.
    """

    def __init__(self, find: Callable[[Any], Any], kinds: Mapping[str, type], found: Found) -> None:
        self.find, self.kinds, self.arrays = find, kinds, found
        self.met: list[Any] = []

    def record(self) -> Any:
        """The record. Raises ``ValueError``, ``LookupError`` or ``TypeError`` for a file that is damaged."""
        return self._value(json.loads(self.arrays[TEXT].tobytes().decode()))

    def _value(self, said: Any) -> Any:
        if isinstance(said, list):
            return [self._value(one) for one in said]
        if not isinstance(said, dict):
            return said
        if "array" in said:
            return self._array(said["array"])
        if "number" in said:
            return self._array(said["number"])[()]
        if "bytes" in said:
            return self._array(said["bytes"]).tobytes()
        return self._of_many(said)

    def _of_many(self, said: dict[str, Any]) -> Any:
        if "set" in said:
            return frozenset(self._value(one) for one in said["set"])
        if "table" in said:
            return {self._value(key): self._value(one) for key, one in said["table"]}
        if "row" in said:
            row = tuple(self._value(one) for one in said["row"])
            return self.kinds[said["kind"]](*row) if "kind" in said else row
        if "again" in said:
            return self.met[said["again"]]
        place = len(self.met)
        self.met.append(None)
        if "model" in said:
            self.met[place] = self.find(self._value(said["model"]))
            return self.met[place]
        return self._of_record(self.kinds[said["kind"]], said["state"], place)

    def _of_record(self, kind: type, said: dict[str, Any], place: int) -> Any:
        made: Any = object.__new__(kind)
        self.met[place] = made
        state = {name: self._value(one) for name, one in said.items()}
        fill = getattr(made, "__setstate__", None)
        if fill is not None:
            fill(state)
        else:
            vars(made).update(state)
        return made

    def _array(self, place: Any) -> FloatArray:
        if isinstance(place, str):
            return self.arrays[place]
        kind, begin, *shape = place
        return self.arrays[BUFFER + kind][begin : begin + int(np.prod(shape, dtype=int))].reshape(shape)


def kind_of(kind: type) -> str:
    """The name of a kind of record in files: its module within the runtime, and its own."""
    return f"{kind.__module__.partition('.runtime.')[2]}.{kind.__qualname__}"


def _content(array: np.ndarray[Any, Any]) -> tuple[str, tuple[int, ...], bytes]:
    """What two arrays that are the same have in common."""
    return array.dtype.name, array.shape, array.tobytes()
