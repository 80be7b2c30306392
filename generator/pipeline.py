"""The map of the generator: scene → mechanism → equations → program → sources → compiled package.

stage     module              input → output
tree      mechanism.topology  Mechanism → Topology (virtual open chain and cut joints)
plan      planning.choose     Mechanism, Topology → Plan (which unknown goes when)
          planning.trees      Mechanism, Topology → Topology with fewer operations, for large mechanisms
derive    derive.derivation   Mechanism, Topology, Plan, effects → Equations (named assignments)
fold      program.fold        Equations → Equations with numbers for parameters, where that is asked for
lower     program.program     Equations → Program (one function per kernel)
write     documents.listing   Equations → equations.txt
          write_c.render      Program → model.c, lanes.c, _binding.pyx, on request derivatives.c
          package.data        Scene, Equations → model.json
compile   compile.compiler    sources → extension module

Up to the equations the stages stand in ``stages``, since documents begin with these alone.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from .compile.cache import contract_version, fetch_or_build, key_of, runtime_folder
from .compile.compiled_package import compile_package
from .compile.compiler import Compiler, cythonize, find_compiler
from .compile.kept_steps import Steps
from .package.parts import DERIVATIVES, HEADERS, ONE_LANE_HEADERS, is_current
from .package.replace import OutputError
from .scene.module_names import hidden_module
from .scene.scene import Scene
from .stages import derive_scene, fold_price, plan_scene, prices
from .version import VERSION
from .write_c.precision import DOUBLE, PRECISIONS, Precision

if TYPE_CHECKING:
    from .write_c.render import Banner

__all__ = ["Progress", "Variant", "derive_scene", "fold_price", "generate", "listing", "plan_scene", "prices"]

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Variant:
    """How a scene's model is made: with its parameters' values as numbers, in which precision, by which plan, and
    whether with its derivatives."""

    fold: bool = False
    numbers: Precision = DOUBLE
    plan: str | None = None
    derivatives: bool = False

    def __str__(self) -> str:
        said = ["folded"] if self.fold else []
        said += [] if self.numbers.double else [self.numbers.name]
        said += [] if self.plan is None else [f"plan: {self.plan}"]
        said += ["derivatives"] if self.derivatives else []
        return "".join(f"\n{text}" for text in said)


def generate(
    scene: Scene,
    out: str | PathLike[str] = "build",
    progress: Progress | None = None,
    *,
    fold: bool = False,
    precision: str = "double",
    plan: str | None = None,
    derivatives: bool = False,
) -> Path:
    """Derive, write and compile the model of ``scene``, or find it in the cache; returns ``out/<package>``.

    With ``fold`` the values of its parameters stand in the code as numbers and cannot be changed later; values that
    leave no finite number then raise ``FoldError``. ``precision`` is that of the numbers it computes with: "double",
    "float" or "wide", the compiler's long double; the package's name then ends in ``_float`` or ``_wide``. ``plan`` is
    the order of elimination, for study: "tip to root", "dyads" or "segments"; unless given, it follows from the
    mechanism; ``ValueError`` where that has none of the kind.
    With ``derivatives`` the model has those of its accelerations and other functions by coordinates, rates, time,
    inputs and parameters, for ``Model.derivatives`` and ``linearise``; without them it is the same to the byte.
    ``progress`` is told each stage's name as it begins. Raises ``CompileError`` (no working compiler) and
    ``OutputError`` (a folder that cannot be written, a name that would hide a module, or something at the place of the
    package that ccgen did not write); nothing is left half written, and nothing of others is removed or replaced.
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"scene: found {type(scene).__name__}, expected a Scene; read a file with load_scene(path)")
    if precision not in PRECISIONS:
        raise ValueError(f"precision: found {precision!r}, expected one of {', '.join(PRECISIONS)}")
    numbers = PRECISIONS[precision]
    if fold and not numbers.double:
        raise ValueError(f"precision: found {precision!r} beside fold, expected 'double'; folded numbers are doubles")
    tell = progress or (lambda stage: None)
    compiler = find_compiler()
    variant = Variant(fold, numbers, plan, derivatives)
    key = key_of(_identity(scene, variant), compiler.version, *compiler.command, *compiler.flags())
    target = Path(out) / numbers.package(scene.package)
    if module := hidden_module(target.name):
        raise OutputError(
            f"{scene.name}: found the name of {module}, which a package {target.name} in {target.parent} can hide, "
            "expected another; give the scene another name"
        )
    if not is_current(target, key):
        tell("look in the cache")
        fetch_or_build(key, target, lambda folder: _build(scene, variant, compiler, key, folder, tell))
    return target


def listing(scene: Scene, fold: bool = False, plan: str | None = None) -> str:
    """The text of ``equations.txt``, by the plan that :func:`derive_scene` takes; needs no compiler."""
    from .documents.listing import name_index, write_listing

    topology, equations = derive_scene(scene, fold, plan)
    return write_listing(scene.name, equations, name_index(scene, topology))


def _identity(scene: Scene, variant: Variant) -> str:
    """What tells one model from all others."""
    return f"{scene.canonical()}{variant}"


def _hash(scene: Scene, variant: Variant) -> str:
    """That in a model's code and data."""
    return hashlib.sha256(_identity(scene, variant).encode()).hexdigest()[:16]


def _build(scene: Scene, variant: Variant, compiler: Compiler, key: str, folder: Path, tell: Progress) -> None:
    """Write and compile everything into an empty folder."""
    from .write_c.render import Banner, render_binding, render_package

    numbers = variant.numbers
    hash_ = _hash(scene, variant)
    banner = Banner(scene.name, numbers.package(scene.package), VERSION, hash_)
    (folder / "_binding.pyx").write_text(render_binding(banner.version, numbers.capsule))
    (folder / "__init__.py").write_text(render_package(banner))
    for header in HEADERS if numbers.double else ONE_LANE_HEADERS:
        (folder / header).write_text((runtime_folder() / header).read_text())
    steps = Steps()
    with ThreadPoolExecutor(1) as beside:
        binding = beside.submit(cythonize, folder, steps)
        _write_model(scene, banner, folder, tell, variant)
        tell("compile")
        binding.result()
    compile_package(compiler, folder, banner.name, hash_, key, steps)


def _write_model(scene: Scene, banner: Banner, folder: Path, tell: Progress, variant: Variant = Variant()) -> None:
    """The stages from the tree to the sources."""
    numbers = variant.numbers
    tell("derive")
    choice = plan_scene(scene, variant.plan, fold=variant.fold, vectors=numbers.double)[1]
    topology, equations = derive_scene(scene, variant.fold, choice=choice)
    tell("write")
    from .documents.listing import name_index, write_listing
    from .package.data import driven_coordinates, event_data, model_data, point_names, switching_data
    from .package.event_tables import event_tables
    from .program.dialects import C
    from .program.program import lower
    from .program.routine import Routines
    from .write_c.render import Sizes, render_c, render_derivatives, render_lanes, render_one_lane

    program, mechanism = lower(equations), scene.mechanism
    routines = Routines(program, C.term, vectors=numbers.double)
    index = name_index(scene, topology)
    driven = driven_coordinates(equations.state, topology, scene.driven)
    sizes = Sizes(
        nq=len(equations.state.q),
        nu=len(equations.state.u),
        base=equations.state.base,
        rows=len(topology.rows),
        links=len(mechanism.links),
        joints=len(mechanism.joints),
        points=len(point_names(mechanism)),
        contacts=len(equations.contacts),
        parameters=len(program.parameters),
        constants=routines.packed_from + len(routines.packed_constants),
        drives=len(driven) // 2,
        inputs=sum(len((*effect.inputs(), *effect.sides(), *effect.latches())) for effect in scene.effects),
        switches=sum(len(effect.sides()) for effect in scene.effects),
        latches=sum(len(effect.latches()) for effect in scene.effects),
        told=len(equations.outputs),
        lines=equations.lines,
        indicators=len(scene.indicators),
        event_values=len(scene.values_of_events),
    )
    extra = switching_data(scene) | event_data(scene)
    data = model_data(scene, topology, equations, banner.hash, contract_version(), numbers.name, extra)
    (folder / "equations.txt").write_text(write_listing(scene.name, equations, index))
    switches = [side for effect in scene.effects for side in effect.sides()]
    latched_at = [switches.index(side) for effect in scene.effects for _, side in effect.latches()]
    sides = topology.sides(len(mechanism.joints))
    tables: dict[str, Sequence[int] | Sequence[float]] = {
        "partner": topology.partners,
        "sides": sides,
        "driven": driven,
        "latched_at": latched_at,
    }
    tables |= {"directions": [direction for _, direction in scene.indicators], "rated": equations.rated}
    numbers_of = {one.path: number for number, one in enumerate(equations.parameters)}
    tables["row_held"] = [numbers_of[cut.gate.path] if cut.gate else -1 for cut in topology.cuts for _ in cut.rows] + [
        -1 for row in topology.meshes for _ in row.rows
    ]
    tables |= event_tables(scene, equations.parameters, topology.implied)
    model = render_c(banner, routines, sizes, tables, topology.root, index, numbers, variant.derivatives)
    (folder / "model.c").write_text(model)
    lanes = render_lanes(banner, routines) if numbers.double else render_one_lane(banner, numbers)
    (folder / "lanes.c").write_text(lanes)
    if variant.derivatives:
        (folder / DERIVATIVES).write_text(render_derivatives(banner, equations, routines, numbers))
    (folder / "model.json").write_text(json.dumps(data, indent=1) + "\n")
