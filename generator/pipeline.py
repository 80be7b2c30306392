"""The map of the generator: scene → mechanism → equations → program → sources → compiled package.

stage     module              input → output
tree      mechanism.topology  Mechanism → Topology (virtual open chain and cut joints)
plan      planning.choose     Mechanism, Topology → Plan (which unknown goes when)
          planning.trees      Mechanism, Topology → Topology with fewer operations, for large mechanisms
derive    derive.derivation   Mechanism, Topology, Plan, effects → Equations (named assignments)
fold      program.fold        Equations → Equations with numbers for parameters, where that is asked for
lower     program.program     Equations → Program (one function per kernel)
write     emit                Equations, Program → equations.txt, model.c, lanes.c, _binding.pyx, package data
compile   emit.compiler       sources → extension module
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Collection
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from .emit.cache import contract_version, fetch_or_build, key_of, runtime_folder
from .emit.compiler import Compiler, compile_model, cythonize, extension_file, extension_module, find_compiler
from .emit.kept_steps import Steps
from .emit.package import HEADERS, ONE_LANE_HEADERS, is_current, write_record
from .emit.precision import DOUBLE, PRECISIONS, Precision
from .emit.processor import processor
from .emit.replace import OutputError
from .scene.module_names import hidden_module
from .scene.scene import Scene
from .version import VERSION

if TYPE_CHECKING:
    from .derive.equations import Equations
    from .emit.render import Banner
    from .mechanism.topology import Topology
    from .planning.choose import Choice
    from .program.prices import Price
    from .program.program import Program

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Variant:
    """How a scene's model is made: with its parameters' values as numbers, in which precision, by which plan."""

    fold: bool = False
    numbers: Precision = DOUBLE
    plan: str | None = None

    def __str__(self) -> str:
        said = ["folded"] if self.fold else []
        said += [] if self.numbers.double else [self.numbers.name]
        said += [f"plan: {self.plan}"] if self.plan else []
        return "".join(f"\n{text}" for text in said)


def generate(
    scene: Scene,
    out: str | PathLike[str] = "build",
    progress: Progress | None = None,
    *,
    fold: bool = False,
    precision: str = "double",
    plan: str | None = None,
) -> Path:
    """Derive, write and compile the model of ``scene``, or find it in the cache; returns ``out/<package>``.

    With ``fold`` the values of its parameters stand in the code as numbers and cannot be changed later; values that
    leave no finite number then raise ``FoldError``. ``precision`` is that of the numbers it computes with: "double",
    "float" or "wide", the compiler's long double; the package's name then ends in ``_float`` or ``_wide``. ``plan`` is
    the order of elimination, for study: "tip to root", "dyads" or "segments"; unless given, it follows from the
    mechanism; ``ValueError`` where that has none of the kind.
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
    variant = Variant(fold, numbers, plan)
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


def plan_scene(
    scene: Scene, wanted: str | None = None, *, fold: bool = False, vectors: bool = True
) -> tuple[Topology, Choice]:
    """The virtual open chain, and the order in which the unknowns go: the ``wanted`` one, or the one chosen for it.

    Where a large mechanism is solved from tip to root, the chain is the one on which that takes fewest operations; what
    other plans save is told beside that. ``fold`` says that the values of parameters stand in the equations, and
    without ``vectors`` nothing goes side by side.
    """
    from .mechanism.topology import span
    from .planning.choose import DYADS, TIP_TO_ROOT, choose
    from .planning.dead_centres import lasting_dyads, sound_dyads
    from .planning.samples import sample_poses
    from .planning.trees import GAIN, LARGE, other_tree

    mechanism, driven, poses = scene.mechanism, scene.driven, scene.start.poses
    loaded = not vectors or any(effect.has_loads() for effect in scene.effects)

    def chosen(topology: Topology, plan: str | None) -> Choice:
        def by(dyads: Collection[int]) -> Choice:
            return choose(mechanism, topology, driven, dyads, plan, loaded=loaded, folded=fold)

        sound = sound_dyads(mechanism, topology, poses)
        choice = by(sound)
        if plan is None and choice.plan.name == DYADS:
            lasting = lasting_dyads(mechanism, topology, sample_poses(mechanism, poses))
            if lasting != sound:
                choice = by(lasting)
        return choice

    short = span(mechanism, driven)
    choice = chosen(short, wanted)
    if wanted in (None, TIP_TO_ROOT) and dict(choice.costs)[TIP_TO_ROOT] > LARGE:
        other = other_tree(mechanism, short, driven)
        if other is not short:
            sought = wanted if choice.plan.name == TIP_TO_ROOT else TIP_TO_ROOT
            choice = choice.with_others(chosen(other, sought), GAIN, wanted)
    return choice.topology, choice


def derive_scene(
    scene: Scene, fold: bool = False, plan: str | None = None, choice: Choice | None = None
) -> tuple[Topology, Equations]:
    """The first stages: the virtual open chain, and all equations, with numbers for the parameters if ``fold``.

    The unknowns go in the order that is chosen for the mechanism, or in that of the plan called ``plan``
    (:data:`~.planning.choose.PLANS`), or of the ``choice`` where it has been made.
    """
    from .derive.derivation import derive

    choice = choice or plan_scene(scene, plan, fold=fold)[1]
    topology = choice.topology
    equations = derive(scene.mechanism, topology, choice.plan, scene.effects)
    if fold:
        from .program.fold import fold as folded

        equations = folded(equations)
    return topology, equations


def listing(scene: Scene, fold: bool = False, plan: str | None = None) -> str:
    """The text of ``equations.txt``, by the plan that :func:`derive_scene` takes; needs no compiler."""
    from .emit.listing import name_index, write_listing

    topology, equations = derive_scene(scene, fold, plan)
    return write_listing(scene.name, equations, name_index(scene, topology))


def less_effect(scene: Scene, index: int, choice: Choice, fold: bool = False) -> tuple[Scene, Choice]:
    """The scene less one effect, and the ``choice`` that was made for the whole of it.

    Where that effect prescribes a joint's motion, the joint's acceleration is an unknown more, and goes by a plan of
    the same name if there is one.
    """
    rest = scene.without(index)
    if rest.driven == scene.driven:
        return rest, choice
    try:
        return rest, plan_scene(rest, choice.plan.name, fold=fold)[1]
    except ValueError:
        return rest, plan_scene(rest, fold=fold)[1]


def prices(
    scene: Scene, fold: bool = False, equations: Equations | None = None, choice: Choice | None = None
) -> tuple[Price, ...]:
    """What each effect of ``scene`` adds in operations, found by deriving the scene without it; needs no compiler.

    Both go by the plan of the scene itself: its ``choice``, and its ``equations``, where they are at hand.
    """
    from .program.prices import Price, added
    from .program.program import lower

    if not scene.effects:
        return ()
    choice = choice or plan_scene(scene, fold=fold)[1]
    program = lower(equations or derive_scene(scene, fold, choice=choice)[1])

    def without(index: int) -> Program:
        rest, same = less_effect(scene, index, choice, fold)
        return lower(derive_scene(rest, fold, choice=same)[1])

    return tuple(
        Price(effect.title, effect.parameters(), added(program, without(index)))
        for index, effect in enumerate(scene.effects)
    )


def fold_price(scene: Scene, fold: bool = False) -> Price:
    """What folding adds in operations: what it saves is negative. Both go by the plan of the scene with ``fold``."""
    from .program.prices import Price, added
    from .program.program import lower

    choice = plan_scene(scene, fold=fold)[1]
    folded, plain = (lower(derive_scene(scene, one, choice=choice)[1]) for one in (True, False))
    return Price("folding", (), added(folded, plain))


def _identity(scene: Scene, variant: Variant) -> str:
    """What tells one model from all others."""
    return f"{scene.canonical()}{variant}"


def _build(scene: Scene, variant: Variant, compiler: Compiler, key: str, folder: Path, tell: Progress) -> None:
    """Write and compile everything into an empty folder."""
    from .emit.render import Banner, render_binding, render_package

    numbers = variant.numbers
    hash_ = hashlib.sha256(_identity(scene, variant).encode()).hexdigest()[:16]
    banner = Banner(scene.name, numbers.package(scene.package), VERSION, hash_)
    (folder / "_binding.pyx").write_text(render_binding(banner, numbers.capsule))
    extension = extension_module(hash_)
    (folder / "__init__.py").write_text(render_package(banner))
    for header in HEADERS if numbers.double else ONE_LANE_HEADERS:
        (folder / header).write_text((runtime_folder() / header).read_text())
    steps = Steps()
    with ThreadPoolExecutor(1) as beside:
        binding = beside.submit(cythonize, folder, extension, steps)
        _write_model(scene, banner, folder, tell, variant)
        tell("compile")
        binding.result()
    compile_model(compiler, folder, extension, steps)
    steps.keep()
    facts = {
        "compiler": compiler.version,
        "flags": list(compiler.flags()),
        "processor": processor(compiler.command, compiler.flags()),
        "contract": contract_version(),
        "extension": extension_file(extension),
    }
    write_record(folder, key, facts)


def _write_model(scene: Scene, banner: Banner, folder: Path, tell: Progress, variant: Variant = Variant()) -> None:
    """The stages from the tree to the sources."""
    numbers = variant.numbers
    tell("derive")
    choice = plan_scene(scene, variant.plan, fold=variant.fold, vectors=numbers.double)[1]
    topology, equations = derive_scene(scene, variant.fold, choice=choice)
    tell("write")
    from .emit.data import driven_coordinates, model_data, point_names
    from .emit.expressions import C
    from .emit.listing import name_index, write_listing
    from .emit.render import Sizes, render_c, render_lanes, render_one_lane
    from .program.program import lower
    from .program.routine import Routines

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
        inputs=sum(len(effect.inputs()) for effect in scene.effects),
    )
    data = model_data(scene, topology, equations, banner.hash)
    if not numbers.double:
        data["precision"] = numbers.name
    (folder / "equations.txt").write_text(write_listing(scene.name, equations, index))
    tables = {"partner": topology.partners, "driven": driven}
    model = render_c(banner, routines, sizes, tables, topology.root, index, numbers)
    (folder / "model.c").write_text(model)
    lanes = render_lanes(banner, routines) if numbers.double else render_one_lane(banner, numbers)
    (folder / "lanes.c").write_text(lanes)
    (folder / "model.json").write_text(json.dumps(data, indent=1) + "\n")
