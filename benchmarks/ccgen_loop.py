"""Forward dynamics of W(n) by ccgen: what `ccgen --links n --gravity` writes, called through its descriptor."""

import ctypes
import json
from importlib.machinery import EXTENSION_SUFFIXES, ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path

import numpy as np
from driver import CCGEN, WORK, Kernel, model_arrays
from workload import Array, Workload

from ccgen.generator import generate, loop


def ccgen_kernel(load: Workload) -> tuple[Kernel, Array]:
    """The kernel on the states of W(n), and the exact du/dt in the model's coordinates."""
    package = generate(loop(load.links, gravity=True), out=WORK / "models")
    data = json.loads((package / "model.json").read_text())
    q, u, u_dot = load.coordinates(root=data["links"].index(data["root"]))
    address = descriptor(package)
    constants, multipliers = model_arrays(address, np.array([value for _, value in data["parameters"]]))
    return Kernel("ccgen", CCGEN, address, q, u, np.full_like(u, np.nan), constants, multipliers), u_dot


def descriptor(package: Path) -> int:
    """Address of the `struct ccgen_model` of a generated package; the runtime is not needed for it."""
    file = next(path for suffix in EXTENSION_SUFFIXES if (path := package / f"_binding{suffix}").exists())
    spec = spec_from_loader("_binding", ExtensionFileLoader("_binding", str(file)))
    assert spec is not None and spec.loader is not None
    binding = module_from_spec(spec)
    spec.loader.exec_module(binding)
    pointer = ctypes.pythonapi.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, (ctypes.py_object, ctypes.c_char_p)
    return int(pointer(binding.descriptor, b"ccgen.model"))
