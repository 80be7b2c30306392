"""Functions of a vector with first derivatives, as searches and other packages ask for them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..model.numbers import read_numbers
from .arguments import Arguments


class Function(ABC):
    """Values (m,) of a vector x (p,), and their derivatives (m, p)."""

    _arguments: Arguments

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the entries of x (p,)."""
        return self._arguments.columns

    @property
    def x0(self) -> FloatArray:
        """What x (p,) is in the model, or in what was given beside it."""
        return self._arguments.start.copy()

    @property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """The least and the largest of what each entry of x may be, (p,) each; infinite where there is no end."""
        return self._arguments.lowest.copy(), self._arguments.highest.copy()

    @property
    @abstractmethod
    def count(self) -> int:
        """How many numbers ``value`` has, m."""

    @abstractmethod
    def value(self, x: ArrayLike) -> FloatArray:
        """The values (m,)."""

    @abstractmethod
    def value_and_jacobian(self, x: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """The values (m,) and what they move by, (m, p)."""

    def __call__(self, x: ArrayLike) -> FloatArray:
        """The values (m,)."""
        return self.value(x)

    def jacobian(self, x: ArrayLike) -> FloatArray:
        """What the values move by, (m, p). Raises ``ValueError`` where there is no derivative."""
        return self.value_and_jacobian(x)[1]

    def value_and_gradient(self, x: ArrayLike) -> tuple[float, FloatArray]:
        """The one value, a number, and its gradient (p,), as ``scipy.optimize.minimize(..., jac=True)`` asks for them.

        Raises ``ValueError`` where there are more numbers than one.
        """
        value, jacobian = self.value_and_jacobian(x)
        if len(value) != 1:
            raise ValueError(f"values: found {len(value)} numbers, expected one, which has a gradient")
        return float(value[0]), jacobian[0]

    def jvp(self, x: ArrayLike, v: ArrayLike) -> FloatArray:
        """What the values (m,) move by along v (p,)."""
        return np.asarray(self.jacobian(x) @ self._arguments.read(v, "v"))

    def vjp(self, x: ArrayLike, w: ArrayLike) -> FloatArray:
        """What the values weighted with w (m,) move by, (p,). All that asks for gradients backwards asks here."""
        jacobian = self.jacobian(x)
        return np.asarray(self._weights(w, len(jacobian)) @ jacobian)

    @staticmethod
    def _weights(w: ArrayLike, count: int) -> FloatArray:
        weights = np.asarray(read_numbers(w, "w"), dtype=float)
        if weights.shape != (count,):
            raise ValueError(f"w: found shape {weights.shape}, expected ({count},), a weight for each value")
        return weights

    def to_jax(self, *, reverse: bool = False) -> Callable[[Any], Any]:
        """This as a function of JAX, of float64 (p,) to float64 (m,); works under ``jit``, ``vmap`` (one by one),
        ``grad``, ``jacrev``, ``jacfwd`` and ``jvp``. With ``reverse`` derivatives are asked backwards, by :meth:`vjp`,
        and those forwards are refused by JAX, which knows one of the two of a function.

        Raises ``ImportError`` where JAX is missing, ``ValueError`` where it works in 32 bits.
        """
        from .for_jax import for_jax

        return for_jax(self, reverse)

    def to_torch(self) -> Callable[[Any], Any]:
        """This as a function of PyTorch, of a tensor (p,) of float64 on the CPU to one (m,), with its derivatives
        backwards and forwards.

        Raises ``ImportError`` where PyTorch is missing.
        """
        from .for_torch import for_torch

        return for_torch(self)

    def to_casadi(self, name: str = "run") -> Any:
        """This as a ``casadi.Function`` of that name, (p,) to (m,), with its Jacobian; no second derivatives: solvers
        that want them need an approximation, as ``{"ipopt.hessian_approximation": "limited-memory"}``. Keep it as long
        as what is built of it: CasADi does not.

        Raises ``ImportError`` where CasADi is missing.
        """
        from .for_casadi import for_casadi

        return for_casadi(self, name)
