"""The first stages, which need no compiler: from a scene to its plan and its equations, and what its effects cost."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .scene.scene import Scene

if TYPE_CHECKING:
    from .equations.equations import Equations
    from .mechanism.topology import Topology
    from .planning.choose import Choice
    from .program.prices import Price


def plan_scene(scene: Scene, wanted: str | None = None) -> tuple[Topology, Choice]:
    """The virtual open chain, and the order in which the unknowns go: the ``wanted`` one, or the one chosen for it.

    Where a large mechanism is solved from tip to root, the chain is the one on which that takes fewest operations.
    """
    from .mechanism.topology import span
    from .planning.choose import DYADS, TIP_TO_ROOT, choose
    from .planning.dead_centres import lasting_dyads, sound_dyads
    from .planning.samples import sample_poses
    from .planning.trees import GAIN, LARGE, other_tree

    mechanism, driven, poses = scene.mechanism, scene.driven, scene.start.poses
    loaded = any(effect.has_loads() for effect in scene.effects)

    def chosen(topology: Topology, plan: str | None) -> Choice:
        sound = sound_dyads(mechanism, topology, poses)
        choice = choose(mechanism, topology, driven, sound, plan, loaded=loaded)
        if plan is None and choice.plan.name == DYADS:
            lasting = lasting_dyads(mechanism, topology, sample_poses(mechanism, poses))
            if lasting != sound:
                choice = choose(mechanism, topology, driven, lasting, loaded=loaded)
        return choice

    topology = short = span(mechanism, driven)
    choice = chosen(short, None)
    cost = dict(choice.costs)[TIP_TO_ROOT]
    if choice.plan.name == TIP_TO_ROOT and cost > LARGE:
        other = other_tree(mechanism, short, driven)
        found = chosen(other, None)
        if GAIN * dict(found.costs)[found.plan.name] < cost:
            topology, choice = other, found
    if wanted is not None:
        choice = chosen(topology if wanted in dict(choice.costs) else short, wanted)
    return choice.topology, choice


def derive_scene(scene: Scene, fold: bool = False, plan: str | None = None) -> tuple[Topology, Equations]:
    """The first stages: the virtual open chain, and all equations, with numbers for the parameters if ``fold``.

    The unknowns go in the order that is chosen for the mechanism, or in that of the plan called ``plan``
    (:data:`~.planning.choose.PLANS`).
    """
    from .derive.derivation import derive

    topology, choice = plan_scene(scene, plan)
    equations = derive(scene.mechanism, topology, choice.plan, scene.effects)
    if fold:
        from .program.fold import fold as folded

        equations = folded(equations)
    return topology, equations


def prices(scene: Scene, fold: bool = False, equations: Equations | None = None) -> tuple[Price, ...]:
    """What each effect of ``scene`` adds in operations, found by deriving the scene without it; needs no compiler.

    ``equations`` are those of the scene itself, where they are at hand.
    """
    from .program.prices import Price, added
    from .program.program import lower

    program = lower(equations or derive_scene(scene, fold)[1])
    return tuple(
        Price(effect.title, effect.parameters(), added(program, lower(derive_scene(scene.without(index), fold)[1])))
        for index, effect in enumerate(scene.effects)
    )


def fold_price(scene: Scene) -> Price:
    """What folding adds in operations: what it saves is negative."""
    from .program.prices import Price, added
    from .program.program import lower

    folded, plain = (lower(derive_scene(scene, fold)[1]) for fold in (True, False))
    return Price("folding", (), added(folded, plain))
