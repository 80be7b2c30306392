"""Functions of runs for CasADi."""

from __future__ import annotations

import re
from functools import cache
from typing import Any

import numpy as np

from ..extras import needed
from .derived import Derived, doubles


def for_casadi(function: Derived, name: str) -> Any:
    """A ``casadi.Callback`` from x (p,) to the values (m,), with its Jacobian and, backwards, ``vjp``."""
    casadi = needed("casadi", "a run as a function of CasADi")
    check_name(name)
    return _callbacks(casadi)(function, name)


def check_name(name: str) -> None:
    """Raise ``ValueError`` for what CasADi takes for no name of a function."""
    if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z](_?[A-Za-z0-9])*", name) or name in RESERVED:
        raise ValueError(f"name: found {name!r}, expected letters, digits and single underscores, as CasADi has names")


RESERVED = ("null", "jac", "hess")
"""Names that CasADi keeps for itself."""


@cache
def _callbacks(casadi: Any) -> Any:
    class Of(casadi.Callback):  # type: ignore[misc]
        """One output of dense inputs; what it makes is kept, which CasADi does not."""

        def __init__(self, name: str, inputs: list[tuple[int, int]], output: tuple[int, int], options: Any) -> None:
            casadi.Callback.__init__(self)
            self.inputs, self.output, self.made = inputs, output, list[Any]()
            self.construct(name, options)

        def get_n_in(self) -> int:
            return len(self.inputs)

        def get_n_out(self) -> int:
            return 1

        def get_sparsity_in(self, k: int) -> Any:
            return casadi.Sparsity.dense(*self.inputs[k])

        def get_sparsity_out(self, _: int) -> Any:
            return casadi.Sparsity.dense(*self.output)

    class Jacobian(Of):
        def __init__(self, function: Derived, name: str, options: Any) -> None:
            self.function = function
            p, m = len(function.columns), function.count
            super().__init__(name, [(p, 1), (m, 1)], (m, p), options)

        def eval(self, given: Any) -> Any:
            return [self.function.value_and_jacobian(doubles(given[0]).ravel())[1]]

    class Backwards(Of):
        def __init__(self, function: Derived, name: str, count: int, options: Any) -> None:
            self.function = function
            p, m = len(function.columns), function.count
            super().__init__(name, [(p, 1), (m, 1), (m, count)], (p, count), options)

        def eval(self, given: Any) -> Any:
            x, weights = doubles(given[0]).ravel(), doubles(given[2])
            return [np.column_stack([self.function.vjp(x, w) for w in weights.T])]

    class Run(Of):
        def __init__(self, function: Derived, name: str) -> None:
            self.function = function
            super().__init__(name, [(len(function.columns), 1)], (function.count, 1), {})

        def eval(self, given: Any) -> Any:
            return [self.function.value(doubles(given[0]).ravel())]

        def has_jacobian(self) -> bool:
            return True

        def get_jacobian(self, name: str, _: Any, __: Any, options: Any) -> Any:
            self.made.append(Jacobian(self.function, name, options))
            return self.made[-1]

        def has_reverse(self, _: int) -> bool:
            return True

        def get_reverse(self, count: int, name: str, _: Any, __: Any, options: Any) -> Any:
            self.made.append(Backwards(self.function, name, count, options))
            return self.made[-1]

    return Run
