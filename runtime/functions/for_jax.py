"""Functions of runs for JAX: host callbacks with derivatives of their own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..extras import needed
from .derived import Derived, check_vector, doubles


def for_jax(function: Derived, reverse: bool) -> Callable[[Any], Any]:
    """A function of float64 (p,) that JAX differentiates: by the Jacobian both ways, or backwards by ``vjp`` alone.

    JAX takes one rule of a function. Of one that is linear in the tangent, with the Jacobian from the host, it makes
    the transposed one itself. With ``reverse`` the rule is that backwards, for which no Jacobian is needed.
    """
    jax = needed("jax", "a run as a function of JAX")
    needs_doubles(jax)
    p, m = len(function.columns), function.count

    def ask(work: Callable[..., Any], shapes: Any, *given: Any) -> Any:
        shaped = jax.tree.map(lambda shape: jax.ShapeDtypeStruct(shape.shape, np.float64), shapes)
        return jax.pure_callback(lambda *a: work(*map(doubles, a)), shaped, *given, vmap_method="sequential")

    whole, row, values = np.zeros((m, p)), np.zeros(p), np.zeros(m)
    if reverse:
        run = jax.custom_vjp(lambda x: ask(function.value, values, x))
        run.defvjp(lambda x: (run(x), x), lambda x, w: (ask(function.vjp, row, x, w),))
    else:

        def along(primals: Any, tangents: Any) -> Any:
            value, jacobian = ask(function.value_and_jacobian, (values, whole), primals[0])
            return value, jacobian @ tangents[0]

        run = jax.custom_jvp(lambda x: ask(function.value, values, x))
        run.defjvp(along)

    def of_run(x: Any) -> Any:
        """The outputs (m,) of the run of x (p,)."""
        needs_doubles(jax)
        given = x if hasattr(x, "dtype") else jax.numpy.asarray(x)
        check_vector(function, given.shape, np.dtype(given.dtype), np.dtype(np.float64), "JAX")
        return run(given)

    return of_run


def needs_doubles(jax: Any) -> None:
    """Raise ``ValueError`` where JAX makes all numbers 32 bits wide."""
    if not jax.config.jax_enable_x64:
        raise ValueError(
            "jax: found 32-bit numbers, expected doubles; say so before anything else: "
            'jax.config.update("jax_enable_x64", True)'
        )
