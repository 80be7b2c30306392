"""A scene's C with and without loops, compiled beside the runtime and called through ctypes."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
import pytest

from ccgen.generator.documents.listing import name_index, write_listing
from ccgen.generator.package.data import point_names
from ccgen.generator.pipeline import derive_scene
from ccgen.generator.program import abreast, rolling
from ccgen.generator.program.dialects import C
from ccgen.generator.program.program import lower
from ccgen.generator.program.reading import Listing, read_listing
from ccgen.generator.program.routine import Routines
from ccgen.generator.scene.scene import Scene
from ccgen.generator.write_c.render import Banner, Sizes, render_c

from ..oracles.maximal import Array
from .c_declarations import fields_of
from .folders import RUNTIME

WARNINGS = ["-std=c11", "-Wall", "-Wextra", "-Werror"]


def same(found: Array, wanted: Array, tolerance: float = 1e-12) -> bool:
    """Largest difference against the largest entry."""
    found, wanted = np.ravel(found), np.ravel(wanted).astype(float)
    assert found.shape == wanted.shape
    assert np.all(np.isfinite(found))
    return bool(np.max(np.abs(found - wanted), initial=0.0) <= tolerance * np.max(np.abs(wanted), initial=0.0))


COLUMNS = 3
"""Columns of impulses that contacts are asked to answer at once."""
Pointer = ctypes.c_void_p


class Descriptor(ctypes.Structure):
    """``struct ccgen_model``, as its header has it."""

    _fields_ = fields_of(RUNTIME / "model.h", "ccgen_model")


SIZES = [field.name for field in fields(Sizes)]


@dataclass
class Compiled:
    """A model's C, compiled without optimisation and without fused operations, called through ctypes."""

    source: str
    descriptor: Descriptor
    constants: Array

    def call(self, kernel: str, arguments: Sequence[Array | float | int | None], *outputs: int) -> list[Array]:
        """The outputs of a kernel; what it leaves unwritten stays NaN."""
        found = [np.full(size + 1, np.nan) for size in outputs]
        arrays = [self.constants, *arguments, *found]
        kinds = {float: ctypes.c_double, int: ctypes.c_int}
        types = [kinds.get(type(a), Pointer) for a in arrays]
        call = ctypes.CFUNCTYPE(ctypes.c_int, *types)(getattr(self.descriptor, kernel))
        call(*(a.ctypes.data if isinstance(a, np.ndarray) else a for a in arrays))
        assert all(np.isnan(out[-1]) for out in found), f"{kernel} writes beyond its output"
        return [out[:-1] for out in found]

    def call_without(self, kernel: str, arguments: Sequence[Array | float | None], size: int) -> Array:
        """The first output of a kernel whose second has no room."""
        found = np.full(size, np.nan)
        arrays = [self.constants, *arguments, found, None]
        types = [ctypes.c_double if isinstance(a, float) else Pointer for a in arrays]
        call = ctypes.CFUNCTYPE(ctypes.c_int, *types)(getattr(self.descriptor, kernel))
        call(*(a.ctypes.data if isinstance(a, np.ndarray) else a for a in arrays))
        return found

    def everything(self, q: Array, u: Array, f: Array, y: Array, pushes: Array) -> dict[str, list[Array]]:
        """Outputs of all kernels."""
        size = {name: getattr(self.descriptor, name) for name in SIZES}
        nu, rows, contacts = size["nu"], size["rows"], size["contacts"]
        found = {
            "acceleration": self.call("acceleration", [q, u, 0.0, None], nu, rows),
            "impulse": self.call("impulse", [q, f, y], nu, rows),
            "reactions": self.call("reactions", [q, u, 0.0, None, f, y], 3 * size["joints"]),
            "closure_bias": self.call("closure_bias", [q, u], rows),
            "momentum": self.call("momentum", [q, u], nu),
            "inverse_dynamics": self.call("inverse_dynamics", [q, u, 0.0, None, f], nu),
            "closure": self.call("closure", [q], rows),
            "closure_jacobian": self.call("closure_jacobian", [q], rows * nu),
            "poses": self.call("poses", [q], 3 * size["links"]),
            "point_positions": self.call("point_positions", [q], 2 * size["points"]),
            "closure_rate": self.call("closure_rate", [q, u], rows),
            "velocities": self.call("velocities", [q, u], 3 * size["links"]),
            "energy": self.call("energy", [q, u], 2),
        }
        if contacts:
            found["gaps"] = self.call("gaps", [q], contacts)
            found["gap_rates"] = self.call("gap_rates", [q, u], contacts)
            found["gap_bias"] = self.call("gap_bias", [q, u], contacts)
            found["contact_impulse"] = self.call("contact_impulse", [q, pushes], nu)
            width = contacts * (2 if self.descriptor.slip_impulse else 1)
            columns = np.resize(pushes, COLUMNS * width)
            found["contact_response"] = self.call(
                "contact_response", [q, COLUMNS, columns], COLUMNS * nu, COLUMNS * width
            )
        return found


@dataclass
class Written:
    """A scene's equations, to be written with and without loops."""

    scene: Scene
    folder: Path

    def __post_init__(self) -> None:
        self.topology, self.equations = derive_scene(self.scene)
        self.program = lower(self.equations)
        self.index = name_index(self.scene, self.topology)

    def listing(self) -> Listing:
        return read_listing(write_listing(self.scene.name, self.equations, self.index))

    def compiled(self, name: str, least: int, together: int = 10**9) -> Compiled:
        """The model with loops of at least ``least`` rounds, and modules of at least ``together`` statements abreast.

        Unless asked for there are none: sums over modules are added up in another order.
        """
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(rolling, "LEAST_ROUNDS", least)
            patch.setattr(abreast, "LEAST", together)
            source, sizes = self.source(name, {"partner": self.topology.partners, "driven": []})
        (self.folder / f"{name}.c").write_text(source)
        command = ["cc", *WARNINGS, "-O0", "-ffp-contract=off", "-fPIC", "-shared", f"-I{RUNTIME}", f"{name}.c"]
        command += ["-o", f"{name}.so", "-lm"]
        done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr[:3000]
        descriptor = Descriptor.in_dll(ctypes.CDLL(str(self.folder / f"{name}.so")), f"ccgen_model_{name}")
        result = Compiled(source, descriptor, np.full(sizes.constants, np.nan))
        values = np.array([p.value for p in self.program.parameters])
        fill = ctypes.CFUNCTYPE(None, Pointer, Pointer)(descriptor.derive_constants)
        fill(values.ctypes.data, result.constants.ctypes.data)
        return result

    def source(self, name: str, tables: Mapping[str, Sequence[int]], *, derivatives: bool = False) -> tuple[str, Sizes]:
        """The model's C with these tables of the contract, that names its derivatives if asked, and its sizes."""
        mechanism, program, state = self.scene.mechanism, self.program, self.equations.state
        routines = Routines(program, C.term)
        sizes = Sizes(
            nq=len(state.q),
            nu=len(state.u),
            base=state.base,
            rows=len(self.topology.rows),
            links=len(mechanism.links),
            joints=len(mechanism.joints),
            points=len(point_names(mechanism)),
            contacts=len(self.equations.contacts),
            parameters=len(program.parameters),
            constants=routines.packed_from + len(routines.packed_constants),
            inputs=0,
            drives=0,
            switches=0,
            latches=sum(len(effect.latches()) for effect in self.scene.effects),
            told=len(self.equations.outputs),
            lines=self.equations.lines,
            indicators=len(self.equations.rated),
            event_values=len(self.scene.values_of_events),
        )
        banner, root = Banner(name, name, "0", "0"), self.topology.root
        return render_c(banner, routines, sizes, tables, root, self.index, derivatives=derivatives), sizes

    def arguments(self, rng: np.random.Generator) -> tuple[Array, ...]:
        nu, rows = len(self.equations.state.u), 2 * len(self.topology.cuts)
        sizes = (nu, nu, nu, rows, len(self.equations.contacts))
        return tuple(rng.uniform(-2.0, 2.0, size) for size in sizes)
