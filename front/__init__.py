"""Planar mechanisms with closed chains: compiled equations of motion, and runs through flight and impact.

    import ccgen
    run = ccgen.simulate("four-bar.toml", until=2.0)

``simulate`` takes a scene in any form; ``generate`` compiles one into a package, ``load`` gives its model. All public
names of :mod:`ccgen.generator` and :mod:`ccgen.runtime` are here too, and are imported when they are used.
"""

from __future__ import annotations

from importlib import import_module

# Type checkers go by its name; jedi by its value, and reads on where that is no literal. To import typing for it would
# take longer than all else here.
TYPE_CHECKING = bool()  # noqa: UP018
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from os import PathLike
    from typing import Any, overload

    from numpy.typing import ArrayLike

    from ccgen import generator as generator
    from ccgen import runtime as runtime
    from ccgen.generator import (
        CompileError,
        FoldError,
        Mechanism,
        OutputError,
        Scene,
        SceneError,
        chain,
        generate,
        load_scene,
        loop,
        pinned,
        rebuild,
    )
    from ccgen.generator.version import VERSION as __version__
    from ccgen.runtime import (
        AccelerationFunction,
        Bifurcation,
        Branch,
        DrivingTorque,
        Ensemble,
        Equilibrium,
        Event,
        Fitted,
        Followed,
        HybridState,
        Identified,
        Impact,
        Linear,
        Model,
        Modes,
        Orbit,
        OutOfReach,
        Phase,
        Reduction,
        Run,
        RunFunction,
        Sensitivities,
        acceleration_function,
        continue_orbit,
        directional,
        double_period,
        driving_torque,
        ensemble,
        find_orbit,
        fit,
        follow,
        identify,
        inverse_dynamics,
        linearise,
        load_model,
        load_run,
        methods,
        momentum,
        reach,
        run_function,
        sensitivities,
        static_equilibrium,
    )
    from ccgen.runtime.arrays import Starts
    from ccgen.runtime.model.inputs import Given
    from ccgen.runtime.simulation.events import OnEvent

    Source = str | PathLike[str] | Mapping[str, Any] | Scene | Mechanism | Model

__all__ = [
    "AccelerationFunction",
    "Bifurcation",
    "Branch",
    "CompileError",
    "DrivingTorque",
    "Ensemble",
    "Equilibrium",
    "Event",
    "Fitted",
    "FoldError",
    "Followed",
    "HybridState",
    "Identified",
    "Impact",
    "Linear",
    "Mechanism",
    "Model",
    "Modes",
    "Orbit",
    "OutOfReach",
    "OutputError",
    "Phase",
    "Reduction",
    "Run",
    "RunFunction",
    "Scene",
    "SceneError",
    "Sensitivities",
    "__version__",
    "acceleration_function",
    "chain",
    "continue_orbit",
    "directional",
    "double_period",
    "driving_torque",
    "ensemble",
    "find_orbit",
    "fit",
    "follow",
    "generate",
    "identify",
    "inverse_dynamics",
    "linearise",
    "load",
    "load_model",
    "load_run",
    "load_scene",
    "loop",
    "methods",
    "momentum",
    "pinned",
    "reach",
    "rebuild",
    "run_function",
    "sensitivities",
    "simulate",
    "static_equilibrium",
]

_OF_GENERATOR = frozenset(
    {
        "CompileError",
        "FoldError",
        "Mechanism",
        "OutputError",
        "Scene",
        "SceneError",
        "chain",
        "generate",
        "load_scene",
        "loop",
        "pinned",
        "rebuild",
    }
)


if not TYPE_CHECKING:  # all names are imported above: any other is a fault before the program runs

    def __getattr__(name: str) -> Any:
        if name == "__version__":
            return import_module(".generator.version", __name__).VERSION
        if name in ("generator", "runtime"):
            return import_module(f".{name}", __name__)
        if name not in __all__:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        return getattr(import_module(".generator" if name in _OF_GENERATOR else ".runtime", __name__), name)


def __dir__() -> list[str]:
    return sorted({*__all__, "generator", "runtime", *(name for name in globals() if name.startswith("__"))})


def load(source: Source) -> Model:
    """The model of a scene: of its file, its tables as a dict, a ``Scene``, a ``Mechanism``, the folder of a generated
    package, or a model itself.

    A scene is compiled into the folder ``build``, or found there. Raises what ``load_scene``, ``generate`` and
    ``load_model`` raise."""
    from collections.abc import Mapping
    from os import PathLike
    from pathlib import Path

    from ccgen.generator import Mechanism, Scene, generate, load_scene
    from ccgen.runtime import Model, load_model

    if isinstance(source, Model):
        return source
    if isinstance(source, Mechanism):
        source = source.scene()
    if isinstance(source, Mapping):
        source = load_scene(source)
    if isinstance(source, Scene):
        return load_model(generate(source))
    if not isinstance(source, str | PathLike):
        raise TypeError(
            f"source: found {source!r}, expected the name of a scene file or of a package's folder, tables of a scene "
            "as a dict, a Scene, a Mechanism or a Model"
        )
    path = Path(source)
    return load_model(path) if path.is_dir() else load_model(generate(load_scene(path)))


if TYPE_CHECKING:

    @overload
    def simulate(
        source: Source,
        q0: Sequence[float] | None = None,
        u0: ArrayLike | None = None,
        until: float | None = None,
        rtol: float | None = None,
        atol: float | None = None,
        method: str | None = None,
        params: Mapping[str, float] | None = None,
        inputs: Given = None,
        *,
        on_event: OnEvent | None = None,
        step: float | None = None,
        drift: str | None = None,
        on_gain: str | None = None,
        state: HybridState | None = None,
        progress: Callable[[float], object] | None = None,
        keep_interrupted: bool = False,
    ) -> Run: ...
    @overload
    def simulate(
        source: Source,
        q0: Starts,
        u0: ArrayLike | None = None,
        until: float | None = None,
        rtol: float | None = None,
        atol: float | None = None,
        method: str | None = None,
        params: Mapping[str, float] | None = None,
        inputs: Given = None,
        *,
        on_event: OnEvent | None = None,
        step: float | None = None,
        drift: str | None = None,
        on_gain: str | None = None,
        state: HybridState | None = None,
        progress: Callable[[float], object] | None = None,
        keep_interrupted: bool = False,
    ) -> list[Run]: ...
    @overload
    def simulate(
        source: Source,
        q0: ArrayLike | Starts | None,
        u0: ArrayLike | None = None,
        until: float | None = None,
        rtol: float | None = None,
        atol: float | None = None,
        method: str | None = None,
        params: Mapping[str, float] | None = None,
        inputs: Given = None,
        *,
        on_event: OnEvent | None = None,
        step: float | None = None,
        drift: str | None = None,
        on_gain: str | None = None,
        state: HybridState | None = None,
        progress: Callable[[float], object] | None = None,
        keep_interrupted: bool = False,
    ) -> Any: ...


def simulate(
    source: Source,
    q0: ArrayLike | Starts | None = None,
    u0: ArrayLike | None = None,
    until: float | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    method: str | None = None,
    params: Mapping[str, float] | None = None,
    inputs: Given = None,
    *,
    on_event: OnEvent | None = None,
    step: float | None = None,
    drift: str | None = None,
    on_gain: str | None = None,
    state: HybridState | None = None,
    progress: Callable[[float], object] | None = None,
    keep_interrupted: bool = False,
) -> Run | Any:
    """The run of what :func:`load` takes, with the arguments of :func:`ccgen.runtime.simulate`; a list of runs where it
    is given many starts."""
    from ccgen.runtime import simulate as simulated

    return simulated(
        load(source),
        *(q0, u0, until, rtol, atol, method, params, inputs),
        on_event=on_event,
        step=step,
        drift=drift,
        on_gain=on_gain,
        state=state,
        progress=progress,
        keep_interrupted=keep_interrupted,
    )
