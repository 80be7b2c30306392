from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

OUTCOMES: tuple[str, ...]
DRIFTS: tuple[str, ...]
BAUMGARTE: float
HOLDS: tuple[str, ...]

def methods() -> tuple[str, ...]: ...
def all_finite(x: Array) -> bool: ...

class Supply:
    error: BaseException | None
    def __init__(
        self,
        function: Callable[[float, Array, Array], Array] | None = None,
        t: Array | None = None,
        values: Array | None = None,
    ) -> None: ...

class Kernels:
    sizes: dict[str, int]
    def __init__(
        self, capsule: object, parameters: Array, length: float, law: str = "newton", angular: Sequence[int] = ()
    ) -> None: ...
    @property
    def address(self) -> int: ...
    @property
    def lanes(self) -> int: ...
    @property
    def hash(self) -> str: ...
    @property
    def constants(self) -> Array: ...
    inexact: float
    @property
    def refined(self) -> bool: ...
    def refine_from_now(self, usual: float) -> None: ...
    def rounding(self, q: Array, u: Array, t: float = 0.0) -> Array: ...
    def acceleration(self, q: Array, u: Array, t: float | Array) -> tuple[Array, Array, list[str]]: ...
    def repeat_acceleration(self, t: Array, q: Array, u: Array, calls: int) -> None: ...
    def acceleration_lanes(self, q: Array, u: Array, t: Array) -> tuple[Array, list[str]]: ...
    def impulse(self, q: Array, f: Array, y: Array) -> tuple[Array, Array, list[str]]: ...
    def set_inputs(self, inputs: Array) -> None: ...
    def inverse_dynamics(self, q: Array, u: Array, t: float, u_dot: Array) -> Array: ...
    def reactions(self, q: Array, u: Array, t: float | Array, u_dot: Array, multipliers: Array) -> Array: ...
    def of_q(self, name: str, q: Array) -> Array: ...
    def of_state(self, name: str, q: Array, u: Array) -> Array: ...
    def audit(self, q: Array, u: Array, spent: Array) -> tuple[float, float, float]: ...
    def project(self, q: Array, u: Array) -> tuple[Array, Array, list[str]]: ...
    def impact(self, q: Array, u: Array, contacts: NDArray[np.int32], e: Array) -> tuple[Array, Array, str]: ...
    def advance(
        self,
        name: str,
        t: float,
        q: Array,
        u: Array,
        h: float,
        supply: Supply | None = None,
        kept: str = ...,
        held: Sequence[tuple[int, str]] = (),
        rtol: float = ...,
        atol: float = ...,
    ) -> tuple[Array, Array, str]: ...
    def simulate(
        self,
        q: Array,
        u: Array,
        name: str,
        until: float,
        rtol: float,
        atol: float,
        fixed_step: float,
        step_budget: int,
        second_budget: int,
        progress: Callable[[float], object] | None,
        supply: Supply | None = None,
        stops: Sequence[float] | Array = (),
        kept: str = ...,
    ) -> dict[str, Any]: ...
