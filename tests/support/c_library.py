"""The core as a library of its own, called without the compiled face of the runtime."""

from __future__ import annotations

import ctypes
import os
import subprocess
from pathlib import Path
from typing import Any

import numpy as np

from .c_declarations import fields_of
from .core_objects import core_objects
from .folders import RUNTIME

Array = Any


HIDDEN = ("-fvisibility=hidden", "-DCCGEN_SHARED", "-Wall", "-Wextra", "-Werror")
"""Flags of a library that shows its own names alone."""


class Settings(ctypes.Structure):
    """``struct ccgen_settings``, as its header has it."""

    _fields_ = fields_of(RUNTIME / "ccgen.h", "ccgen_settings")


class Event(ctypes.Structure):
    """``struct ccgen_event``."""

    _fields_ = fields_of(RUNTIME / "ccgen.h", "ccgen_event")


class Crossing(ctypes.Structure):
    """``struct ccgen_crossing``."""

    _fields_ = fields_of(RUNTIME / "ccgen.h", "ccgen_crossing")


class Change(ctypes.Structure):
    """``struct ccgen_change``."""

    _fields_ = fields_of(RUNTIME / "ccgen.h", "ccgen_change")


class Library:
    """The library made of the core in ``runtime``, a folder, compiled into ``file`` with more ``flags``."""

    def __init__(self, runtime: Path, file: Path, *more: str) -> None:
        objects = core_objects(runtime, (*HIDDEN, *more))
        own = os.environ.get("CFLAGS", "").split()
        subprocess.run(["cc", "-shared", *own, *more, *objects, "-lm", "-o", str(file)], check=True)
        self.calls: Any = ctypes.CDLL(str(file))
        self.calls.ccgen_outcome_name.restype = ctypes.c_char_p
        self.calls.ccgen_state_size.restype = ctypes.c_size_t

    def outcome(self, code: int) -> str:
        """The name of a code."""
        name: bytes = self.calls.ccgen_outcome_name(code)
        return name.decode()

    def create(self, model: Any, **settings: Any) -> tuple[str, Simulation]:
        """The outcome, and a simulation of a model of the runtime, whose address is NULL where there is none."""
        made = Simulation(self, model, settings)
        return self.outcome(made.code), made


class Simulation:
    """One ``struct ccgen_simulation``; it ends with this object."""

    def __init__(self, library: Library, model: Any, settings: dict[str, Any]) -> None:
        self.library, self.calls, self.model = library, library.calls, model
        self.values = (ctypes.c_double * len(model.parameters))(*model.parameters.values())
        self.lengths = (ctypes.c_ubyte * len(model.q_names))(
            *(kind != "angle" for kind, _ in model.data["coordinates"])
        )
        self.settings = Settings(
            ctypes.cast(self.values, ctypes.c_void_p),
            model.length,
            model.time or 0.0,
            model.duration,
            ctypes.cast(self.lengths, ctypes.c_void_p),
            **settings,
        )
        self.address = ctypes.c_void_p()
        model_address = ctypes.c_void_p(model.kernels.address)
        self.code: int = self.calls.ccgen_create(model_address, ctypes.byref(self.settings), ctypes.byref(self.address))

    def __del__(self) -> None:
        self.calls.ccgen_destroy(self.address)

    def reset(self, q: Array, u: Array, t: float = 0.0) -> str:
        """Begin; the outcome."""
        found = [np.ascontiguousarray(x, dtype=float) for x in (q, u)]
        q_, u_ = (ctypes.c_void_p(x.ctypes.data) for x in found)
        return self.library.outcome(self.calls.ccgen_reset(self.address, ctypes.c_double(t), q_, u_))

    def step_to_event(self, until: float) -> tuple[str, Event]:
        """The outcome and the event."""
        event = Event()
        code = self.calls.ccgen_step_to_event(self.address, ctypes.c_double(until), ctypes.byref(event))
        return self.library.outcome(code), event

    def motion(self) -> tuple[float, Array, Array]:
        """Time, q and u."""
        t, n = ctypes.c_double(), len(self.model.q_names)
        q, u = np.empty(n), np.empty(n)
        self.calls.ccgen_get_motion(
            self.address, ctypes.byref(t), ctypes.c_void_p(q.ctypes.data), ctypes.c_void_p(u.ctypes.data)
        )
        return t.value, q, u

    def acceleration(self, q: Array, u: Array, inputs: Array | None = None, t: float = 0.0) -> tuple[str, Array]:
        """The outcome, and accelerations in flight."""
        u_dot = np.full(len(q), np.nan)
        given = [_address(x) for x in (q, u, inputs)]
        code = self.calls.ccgen_find_acceleration(self.address, ctypes.c_double(t), *given, _address(u_dot))
        return self.library.outcome(code), u_dot

    def derived(self, q: Array, u: Array, inputs: Array | None = None, t: float = 0.0) -> tuple[str, Array, Array]:
        """The outcome, accelerations in flight, and what they change by (n, 2 n + inputs)."""
        n, others = len(q), len(self.model.inputs)
        u_dot, by = np.full(n, np.nan), [np.full((n, count), np.nan) for count in (n, n, others)]
        given, found = [_address(x) for x in (q, u, inputs)], [_address(x) for x in (u_dot, *by)]
        code = self.calls.ccgen_derive_acceleration(self.address, ctypes.c_double(t), *given, *found)
        return self.library.outcome(code), u_dot, np.hstack(by)

    def modes(self) -> list[int]:
        """How each contact is held, by its number in ``runtime/ccgen.h``."""
        modes = (ctypes.c_byte * len(self.model.contacts))()
        self.calls.ccgen_get_modes(self.address, modes)
        return list(modes)

    def rows(self) -> tuple[Array, Array]:
        """Times and rows that are recorded, copies of them."""
        t, rows, width = ctypes.POINTER(ctypes.c_double)(), ctypes.POINTER(ctypes.c_double)(), ctypes.c_size_t()
        self.calls.ccgen_rows.restype = ctypes.c_size_t
        count = self.calls.ccgen_rows(self.address, ctypes.byref(t), ctypes.byref(rows), ctypes.byref(width))
        found = np.ctypeslib.as_array(rows, (count, width.value)).copy()
        return np.ctypeslib.as_array(t, (count,)).copy(), found

    def crossings(self) -> tuple[str, list[tuple[float, int, int]], Array]:
        """The outcome, times, indicators and directions of the events of the scene so far, and the states there."""
        count, found, states = ctypes.c_size_t(), ctypes.POINTER(Crossing)(), ctypes.POINTER(ctypes.c_double)()
        code = self.calls.ccgen_crossings(self.address, ctypes.byref(count), ctypes.byref(found), ctypes.byref(states))
        every = [(one.t, one.indicator, one.direction) for one in found[: count.value]] if count.value else []
        shape = (count.value, 2 * len(self.model.q_names))
        there = np.ctypeslib.as_array(states, shape).copy() if count.value else np.empty(shape)
        return self.library.outcome(code), every, there

    def changes(self) -> tuple[str, list[Change], Array]:
        """The outcome, what events and joints have changed, and the parameters behind each."""
        count, found, values = ctypes.c_size_t(), ctypes.POINTER(Change)(), ctypes.POINTER(ctypes.c_double)()
        code = self.calls.ccgen_changes(self.address, ctypes.byref(count), ctypes.byref(found), ctypes.byref(values))
        shape = (count.value, len(self.model.settable))
        there = np.ctypeslib.as_array(values, shape).copy() if count.value else np.empty(shape)
        return self.library.outcome(code), list(found[: count.value]) if count.value else [], there

    def constants(self) -> Array:
        """What the model's functions read."""
        self.calls.ccgen_get_constants.restype = ctypes.POINTER(ctypes.c_double)
        found = self.calls.ccgen_get_constants(self.address)
        return np.ctypeslib.as_array(found, (len(self.model.kernels.constants),)).copy()

    def parameters(self) -> dict[str, float]:
        """Those that are in force, with what events have set."""
        self.calls.ccgen_get_parameters.restype = ctypes.POINTER(ctypes.c_double)
        found = self.calls.ccgen_get_parameters(self.address)
        return dict(zip(self.model.settable, found[: len(self.model.settable)], strict=True))

    def state(self) -> bytes:
        """The whole state."""
        buffer = ctypes.create_string_buffer(self.calls.ccgen_state_size(self.address))
        self.calls.ccgen_get_state(self.address, buffer)
        return buffer.raw

    def set_state(self, state: bytes) -> str:
        """Put a state back; the outcome."""
        return self.library.outcome(self.calls.ccgen_set_state(self.address, state))

    def forget(self) -> str:
        """Forget what is recorded but the present row; the outcome."""
        return self.library.outcome(self.calls.ccgen_forget(self.address))


def _address(x: Array | None) -> ctypes.c_void_p | None:
    """Of numbers in a row, which have to stay as long; NULL for None."""
    return None if x is None else ctypes.c_void_p(x.ctypes.data)
