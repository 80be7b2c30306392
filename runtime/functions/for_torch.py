"""Functions of runs for PyTorch."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from ..extras import needed
from .derived import Derived, check_vector, doubles


def for_torch(function: Derived) -> Callable[[Any], Any]:
    """A function of a tensor (p,) of float64 on the CPU, derived by ``vjp`` backwards and by ``jvp`` forwards."""
    torch = needed("torch", "a run as a function of PyTorch")
    run = _run_of(torch)

    def of_run(x: Any) -> Any:
        """The outputs (m,) of the run of x (p,)."""
        if not isinstance(x, torch.Tensor):
            raise TypeError(f"x: found {type(x).__name__}, expected a tensor of float64")
        if x.device.type != "cpu":
            raise ValueError(f"x: found a tensor on {x.device}, expected one on the CPU, where runs are made")
        check_vector(function, tuple(x.shape), x.dtype, torch.float64, "PyTorch")
        return run.apply(x, function)

    return of_run


@cache
def _run_of(torch: Any) -> Any:
    def one_by_one(of: Any, info: Any, dims: Any, arguments: Any) -> Any:
        """``vmap``: the function of each entry."""
        rows = [
            [one if dim is None else one.select(dim, k) for one, dim in zip(arguments, dims, strict=True)]
            for k in range(info.batch_size)
        ]
        return torch.stack([of.apply(*row) for row in rows]), 0

    class Derivative(torch.autograd.Function):  # type: ignore[misc]
        """``work`` of x and a vector beside it. A step in the graph of its own, so that who derives it again is told
        that there is nothing, where a plain tensor would count as constant."""

        @staticmethod
        def forward(x: Any, other: Any, work: Callable[[Any, Any], Any]) -> Any:
            return torch.from_numpy(work(doubles(x.detach()), doubles(other.detach())))

        @staticmethod
        def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
            pass

        @staticmethod
        def backward(ctx: Any, *_: Any) -> Any:
            raise NotImplementedError(AGAIN)

        @staticmethod
        def jvp(ctx: Any, *_: Any) -> Any:
            raise NotImplementedError(AGAIN)

        @staticmethod
        def vmap(info: Any, dims: Any, *arguments: Any) -> Any:
            return one_by_one(Derivative, info, dims, arguments)

    class Run(torch.autograd.Function):  # type: ignore[misc]
        @staticmethod
        def forward(x: Any, function: Derived) -> Any:
            return torch.from_numpy(function.value(doubles(x.detach())))

        @staticmethod
        def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
            x, ctx.function = inputs
            ctx.save_for_backward(x)
            ctx.save_for_forward(x)

        @staticmethod
        def backward(ctx: Any, w: Any) -> Any:
            return Derivative.apply(*ctx.saved_tensors, w, ctx.function.vjp), None

        @staticmethod
        def jvp(ctx: Any, v: Any, _: Any) -> Any:
            return Derivative.apply(*ctx.saved_tensors, v, ctx.function.jvp)

        @staticmethod
        def vmap(info: Any, dims: Any, *arguments: Any) -> Any:
            return one_by_one(Run, info, dims, arguments)

    return Run


AGAIN = "derivatives of a run: found a second derivative asked for, expected first ones alone: there are no others"
