"""Forward dynamics of W(n) by ccgen: what `ccgen --links n --gravity` writes, called through its descriptor."""

import json
from pathlib import Path

import numpy as np
from driver import CCGEN, WORK, Kernel, model_arrays
from workload import Array, Workload

from ccgen.generator import generate, loop
from ccgen.runtime import load_model


def ccgen_kernel(load: Workload) -> tuple[Kernel, Array]:
    """The kernel on the states of W(n), and the exact du/dt in the model's coordinates."""
    package = generate(loop(load.links, gravity=True), out=WORK / "models")
    data = json.loads((package / "model.json").read_text())
    q, u, u_dot = load.coordinates(root=data["links"].index(data["root"]))
    address = descriptor(package)
    constants, multipliers = model_arrays(address, np.array([value for _, value in data["parameters"]]))
    return Kernel("ccgen", CCGEN, address, q, u, np.full_like(u, np.nan), constants, multipliers), u_dot


def descriptor(package: Path) -> int:
    """Address of the `struct ccgen_model` of a generated package; it stays while the process lives."""
    return load_model(package).kernels.address
