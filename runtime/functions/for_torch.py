"""Functions of runs for PyTorch."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from ..extras import needed
from .derived import Derived, check_vector, doubles


def for_torch(function: Derived) -> Callable[[Any], Any]:
    """A function of a tensor (p,) of float64 on the CPU, differentiated backwards by ``vjp`` and forwards by ``jvp``."""
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
    def tensor(array: Any) -> Any:
        return torch.from_numpy(array)

    class Run(torch.autograd.Function):  # type: ignore[misc, name-defined]
        @staticmethod
        def forward(ctx: Any, x: Any, function: Derived) -> Any:
            ctx.function = function
            ctx.save_for_backward(x)
            ctx.save_for_forward(x)
            return tensor(function.value(doubles(x.detach())))

        @staticmethod
        @torch.autograd.function.once_differentiable
        def backward(ctx: Any, w: Any) -> Any:
            (x,) = ctx.saved_tensors
            return tensor(ctx.function.vjp(doubles(x), doubles(w))), None

        @staticmethod
        def jvp(ctx: Any, v: Any, _: Any) -> Any:
            (x,) = ctx.saved_tensors
            return tensor(ctx.function.jvp(doubles(x.detach()), doubles(v.detach())))

    return Run
