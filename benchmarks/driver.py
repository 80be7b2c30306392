"""Builds driver.c and times kernels with it."""

import ctypes
import os
import shlex
import signal
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from workload import Array

ROOT = Path(__file__).resolve().parent.parent
WORK = ROOT / ".cache" / "benchmarks"
COMPILER = shlex.split(os.environ.get("CC", "cc"))
CCGEN, CASADI, CCGEN_LANES = 0, 1, 2


class _Kernel(ctypes.Structure):
    """`struct kernel` of driver.c."""

    _fields_ = (
        *((name, ctypes.c_int) for name in ("kind", "states", "nq", "nu")),
        *((name, ctypes.c_void_p) for name in ("target", "q", "u", "u_dot", "constants", "multipliers")),
    )


@dataclass(frozen=True)
class Kernel:
    """A compiled acceleration and the states it is called with; `u_dot` receives the results."""

    name: str
    kind: int
    target: int  # address
    q: Array  # (states, nq), over lanes (states / lanes, nq, lanes); the next two likewise
    u: Array
    u_dot: Array
    constants: Array
    multipliers: Array

    def record(self) -> _Kernel:
        """The kernel as driver.c wants it; valid while this object lives."""
        arrays = (self.q, self.u, self.u_dot, self.constants, self.multipliers)
        states = self.q.size // self.q.shape[1]  # over lanes the arrays are (blocks, width, lanes)
        sizes = (states, self.q.shape[1], self.u.shape[1])
        return _Kernel(self.kind, *sizes, self.target, *(array.ctypes.data for array in arrays))


def compile_shared(source: Path, flags: Sequence[str], target: Path, limit: float | None = None) -> bool:
    """Compile a C file to a shared object; False when the compiler needs over `limit` seconds."""
    scratch = target.with_suffix(".part")
    command = [*COMPILER, *flags, "-fPIC", "-shared", str(source), "-o", str(scratch), "-lm"]
    compiler = subprocess.Popen(command, start_new_session=True)
    try:
        if compiler.wait(limit):
            raise subprocess.CalledProcessError(compiler.returncode, command)
    except subprocess.TimeoutExpired:
        return False
    finally:  # the compiler's own processes too, which would go on beside what is timed
        if compiler.poll() is None:
            os.killpg(compiler.pid, signal.SIGKILL)
            compiler.wait()
    scratch.replace(target)
    return True


def interleave(kernels: Sequence[Kernel], rounds: int, length: float) -> Array:
    """Seconds per evaluation (rounds, kernels), one batch of about `length` s of each kernel in every round."""
    seconds = np.empty((rounds, len(kernels)))
    records = (_Kernel * len(kernels))(*(kernel.record() for kernel in kernels))
    output = seconds.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
    _library().interleave(records, len(kernels), rounds, ctypes.c_double(length), output)
    return seconds


def batch(kernel: Kernel, calls: int) -> float:
    """Seconds that `calls` evaluations of one kernel take, one state after the other, or lanes of states."""
    return float(_library().batch(ctypes.byref(kernel.record()), ctypes.c_long(calls)))


def model_arrays(model: int, parameters: Array) -> tuple[Array, Array]:
    """Constants derived from the parameters, and room for the multipliers, of the model at an address."""
    address, constants, rows = ctypes.c_void_p(model), ctypes.c_int(), ctypes.c_int()
    _library().sizes(address, ctypes.byref(constants), ctypes.byref(rows))
    derived = np.zeros(constants.value)
    _library().derive(address, ctypes.c_void_p(parameters.ctypes.data), ctypes.c_void_p(derived.ctypes.data))
    return derived, np.zeros(rows.value)


@cache
def _library() -> ctypes.CDLL:
    """driver.c, compiled anew in every process: it depends on the runtime's model.h."""
    path = WORK / "driver.so"
    compile_shared(ROOT / "benchmarks" / "driver.c", ["-O2", "-std=c11", "-Wall", "-I", str(ROOT / "runtime")], path)
    library = ctypes.CDLL(str(path))
    library.batch.restype = ctypes.c_double
    return library
