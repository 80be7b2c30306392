"""The first stages, which need no compiler: from a scene to its plan and its equations, and what its effects cost."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

from .scene.scene import Scene

if TYPE_CHECKING:
    from .equations.equations import Equations
    from .mechanism.topology import Topology
    from .planning.choose import Choice
    from .program.prices import Price
    from .program.program import Program


def check_plan(wanted: str | None) -> None:
    """Raise ``ValueError`` for a name that no plan has."""
    from .planning.choose import check_plan as check

    check(wanted)


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
    from .derive.gated import at_joints, gated
    from .effect_base.indicators import ChangeIndicator, Indicator, SetTo

    choice = choice or plan_scene(scene, plan, fold=fold)[1]
    topology = choice.topology
    indicators = tuple(
        Indicator(one, scene.mechanism) if isinstance(one, str) else ChangeIndicator(one, scene.mechanism)
        for one, _ in scene.indicators
    )
    joints = [effect.at_joints() for effect in scene.effects]
    effects = at_joints(scene.effects, joints, scene.everywhere, scene.mechanism)
    effects = gated(effects, scene.gates)
    values = tuple(SetTo(one.value, scene.mechanism) for one in scene.values_of_events)
    equations = derive(scene.mechanism, topology, choice.plan, effects, indicators, values)
    if fold:
        from .program.fold import fold as folded

        equations = folded(equations, [*scene.mechanism.gates.values(), *(gate for gate in scene.gates if gate)])
    return topology, equations


def less_effect(scene: Scene, index: int, choice: Choice, fold: bool = False) -> tuple[Scene, Choice]:
    """The scene less one effect, and the ``choice`` that was made for the whole of it.

    Where that effect prescribes a joint's motion, the joint's acceleration is an unknown more, and where it integrates,
    there is an unknown less: that goes by a plan of the same name if there is one.
    """
    rest = scene.without(index)
    here, there = scene.mechanism, rest.mechanism
    if rest.driven == scene.driven and (there.meshes, there.integrators) == (here.meshes, here.integrators):
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
