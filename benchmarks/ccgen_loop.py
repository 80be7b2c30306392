"""Forward dynamics of W(n) by ccgen: what `ccgen --links n --gravity` writes, called through its descriptor."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
from driver import CCGEN, CCGEN_LANES, WORK, Kernel, batch, model_arrays
from workload import Array, Workload

from ccgen.generator import generate, loop
from ccgen.runtime import Model, load_model


def ccgen_kernel(load: Workload) -> tuple[Kernel, Array]:
    """The kernel on the states of W(n), and the exact du/dt in the model's coordinates."""
    package = generate(loop(load.links, gravity=True), out=WORK / "models")
    data = json.loads((package / "model.json").read_text())
    q, u, u_dot = load.coordinates(root=data["links"].index(data["root"]))
    address = descriptor(package)
    constants, multipliers = model_arrays(address, np.array([one["value"] for one in data["parameters"]]))
    return Kernel("ccgen", CCGEN, address, q, u, np.full_like(u, np.nan), constants, multipliers), u_dot


def ccgen_lanes(q: Array, u: Array, model: Model) -> tuple[Kernel, Callable[[], Array]]:
    """The kernel over lanes on q (b, nq), u (b, nu), b a multiple of the lanes; a call that gives du/dt (b, nu)."""
    lanes = model.kernels.lanes
    blocks = [np.ascontiguousarray(x.reshape(-1, lanes, x.shape[1]).transpose(0, 2, 1)) for x in (q, u)]
    constants, multipliers = model_arrays(model.kernels.address, np.array(list(model.parameters.values())))
    room = np.zeros(lanes * multipliers.size)
    kernel = Kernel(
        "ccgen", CCGEN_LANES, model.kernels.address, *blocks, np.full_like(blocks[1], np.nan), constants, room
    )

    def found() -> Array:
        batch(kernel, len(q))
        return np.ascontiguousarray(kernel.u_dot.transpose(0, 2, 1)).reshape(u.shape)

    return kernel, found


def descriptor(package: Path) -> int:
    """Address of the `struct ccgen_model` of a generated package; it stays while the process lives."""
    return load_model(package).kernels.address
