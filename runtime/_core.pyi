from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

class Tolerance(NamedTuple):
    value: float
    of: str
    decides: str
    because: str

TOLERANCES: dict[str, Tolerance]
TOLERANCE_ORDERS: tuple[tuple[str, str], ...]
OUTCOMES: tuple[str, ...]
DRIFTS: tuple[str, ...]
GAINS: tuple[str, ...]
MODES: dict[int, str]

def methods(estimating: bool = False) -> tuple[str, ...]: ...

class Carried:
    def __init__(
        self, h: Array, tableau: Sequence[Array], J: Array, back: Sequence[tuple[int, Array, Array]]
    ) -> None: ...
    def through(
        self,
        number: int,
        whole: Array,
        count: int = 1,
        before: NDArray[np.intp] | None = None,
        jumps: Array | None = None,
        seen: Array | None = None,
    ) -> Array | None: ...

def sure_inverses(matrices: Array, sure: float) -> tuple[Array, NDArray[np.bool_]]: ...
def all_finite(x: Array) -> bool: ...
def never_decreases(x: Array) -> bool: ...
def all_within(x: Array, limit: float) -> bool: ...

class Supply:
    error: BaseException | None
    def __init__(
        self,
        function: Callable[[float, Array, Array], Array] | None = None,
        t: Array | None = None,
        values: Array | None = None,
    ) -> None: ...

ROW_NOT_BEGUN: int
ROW_REFUSED: int

class Ensemble:
    answers: dict[str, NDArray[Any]]
    done: int
    def __init__(self, kernels: Kernels, count: int, q: Array, u: Array, **asked: Any) -> None: ...
    def work(self) -> None: ...
    def end(self) -> None: ...

class Kernels:
    sizes: dict[str, int]
    def __init__(
        self,
        capsule: object,
        parameters: Array,
        length: float,
        law: str = "newton",
        angular: Sequence[int] = (),
        time: float = 0.0,
        duration: float = 1.0,
        lengths: Sequence[int] = (),
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
    def rows_on(self) -> NDArray[np.intc]: ...
    @property
    def refined(self) -> bool: ...
    def refine_from_now(self, usual: float) -> None: ...
    def heaviest(self, q: Array) -> float: ...
    def motions(self, q: Array) -> Array: ...
    def closure_misses(self, parameters: Array, q: Array, u: Array) -> Array: ...
    def rounding(self, q: Array, u: Array, t: float = 0.0) -> Array: ...
    @property
    def derivatives(self) -> dict[str, int] | None: ...
    @property
    def directions(self) -> int: ...
    def constant_tangents(self, p: Array) -> Array: ...
    def acceleration_tangents(
        self,
        q: Array,
        u: Array,
        t: float | Array,
        u_dot: Array,
        multipliers: Array,
        by: dict[str, tuple[int, Array]],
        blocks: int,
    ) -> tuple[Array, Array, dict[int, str]]: ...
    def tangents(
        self,
        name: str,
        q: Array,
        u: Array,
        t: float | Array,
        u_dot: Array,
        multipliers: Array,
        P: Array,
        by: dict[str, Array],
        blocks: int,
        columns: NDArray[np.intp] | None = None,
    ) -> Array | None: ...
    def jacobians(
        self,
        q: Array,
        u: Array,
        t: Array,
        held: Sequence[tuple[int, str]],
        by: dict[str, tuple[int, Array]],
        whole: dict[str, Array],
        still: dict[str, Array],
        blocks: int,
        columns: NDArray[np.intp],
        side: int = 1,
    ) -> tuple[Array, Array, dict[int, str], bool]: ...
    def collocated(
        self,
        steps: Sequence[Array],
        ends: tuple[Array, Array],
        held: Sequence[tuple[int, str]],
        c: Array,
        A: Array,
        twice: Array,
        many: int,
        small: float,
        stays: float,
    ) -> tuple[Array, NDArray[np.bool_], tuple[float, str] | None]: ...
    def collocate(self, h: Array, c: Array, A: Array, twice: Array, J: Array) -> Array: ...
    def responses(self, q: Array) -> tuple[Array, dict[int, str]]: ...
    def repeat_jacobian(
        self, q: Array, u: Array, t: float, by: dict[str, tuple[int, Array]], blocks: int, calls: int
    ) -> None: ...
    def acceleration(
        self, q: Array, u: Array, t: float | Array, side_by_side: bool = True, forces: bool = True
    ) -> tuple[Array, Array, dict[int, str]]: ...
    def repeat_acceleration(self, t: Array, q: Array, u: Array, calls: int) -> None: ...
    def acceleration_lanes(self, q: Array, u: Array, t: Array) -> tuple[Array, list[str]]: ...
    def impulse(self, q: Array, f: Array, y: Array) -> tuple[Array, Array, list[str]]: ...
    def set_inputs(self, inputs: Array) -> None: ...
    def inverse_dynamics(self, q: Array, u: Array, t: float, u_dot: Array) -> Array: ...
    def reactions(self, q: Array, u: Array, t: float | Array, u_dot: Array, multipliers: Array) -> Array: ...
    def told(self, q: Array, u: Array, t: float | Array) -> Array: ...
    @property
    def works(self) -> bool: ...
    @property
    def friction(self) -> Array: ...
    def closed(self, q: Array) -> NDArray[np.bool_]: ...
    def near_limits(self, q: Array) -> NDArray[np.bool_]: ...
    def motion(
        self,
        q: Array,
        u: Array,
        t: float | Array,
        chosen: Sequence[tuple[int, str]] | None = None,
        supply: Supply | None = None,
        latched: Array | None = None,
        shared: bool = False,
    ) -> tuple[Array, Array, Array, Array, Array, NDArray[np.bool_], tuple[int, str, str, int, float] | None]: ...
    def contact_reactions(self, q: Array, P: Array) -> Array: ...
    def joint_impulses(self, q: Array, du: Array, P: Array) -> tuple[Array, list[str]]: ...
    def of_q(self, name: str, q: Array) -> Array: ...
    def of_state(self, name: str, q: Array, u: Array) -> Array: ...
    def audit(self, q: Array, u: Array, spent: Array, every: int) -> tuple[float, float, float, float, Array]: ...
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
        scales: tuple[float, float] | None = None,
        latched: Array | Sequence[float] = (),
    ) -> tuple[Array, Array, str]: ...
    def between(
        self,
        name: str,
        t: tuple[float, float],
        q: Array,
        u: Array,
        at: float,
        line: bool,
        supply: Supply | None = None,
        kept: str = ...,
        held: Sequence[tuple[int, str]] = (),
        rtol: float = ...,
        atol: float = ...,
        scales: tuple[float, float] | None = None,
        latched: Array | Sequence[float] = (),
    ) -> tuple[Array, Array, str]: ...
    def indicators(self, t: Array, q: Array, u: Array) -> tuple[Array, Array, Array]: ...
    def event_values(self, t: float, q: Array, u: Array) -> Array: ...
    def take_hold(self, q: Array, u: Array) -> tuple[Array, str]: ...
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
        rate_budget: int,
        progress: Callable[[float], object] | None,
        supply: Supply | None = None,
        stops: Sequence[float] | Array = (),
        kept: str = ...,
        state: bytes | None = None,
        on_gain: str = ...,
        left_at: Callable[[float, Array, Array], None] | None = None,
        events: tuple[Sequence[bool], Callable[..., tuple[str, Array | None]] | None] | None = None,
    ) -> dict[str, Any]: ...
