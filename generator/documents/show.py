"""A scene for a person: a summary, then the listing or the expanded closed form where asked for, as text or LaTeX."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence

import numpy as np

from ..derive.expanded import ExpandedForm, expand
from ..derive.gated import gated
from ..equations.equations import OTHERWISE, Equations
from ..mechanism.joints import Joint, PointRef
from ..mechanism.layout import lay_out
from ..mechanism.mechanism import Mechanism
from ..mechanism.topology import Cut, Topology, span
from ..planning.choose import Choice
from ..program.dialects import LISTING, write
from ..program.prices import Price
from ..program.program import lower
from ..scene.driven import drive_layout, mesh_speeds
from ..scene.scene import Scene
from ..stages import derive_scene, plan_scene, prices
from .assembled import branch_lines, mobility_of, moving, redundancy_lines
from .discs import disc_lines
from .latex import Summary, expanded_document, recursive_document
from .listing import name_index, write_listing
from .order import module_lines, order_lines
from .price_table import price_lines

WIDTH = 120
RANK_TOLERANCE = 1e-9
"""Singular values of the closure's Jacobian (m) below this count as zero."""


def show_text(
    scene: Scene,
    latex: bool,
    expanded: bool,
    fold: bool = False,
    *,
    equations: bool = True,
    plan: str | None = None,
    changed: Scene | None = None,
) -> str:
    """The text that ``ccgen show`` prints: the summary, and unless left out the listing; LaTeX and the expanded form,
    where these are asked for, are whole in any case. ``plan`` names an order of elimination other than the chosen one;
    ``changed`` is the scene with other values, which its summary has then: its equations are those of ``scene``.

    Raises ``ValueError`` for an expanded form of too many links or of driven joints, for one that is to be folded, and
    for a plan that the mechanism has not.
    """
    if expanded and fold:
        raise ValueError("--fold: found beside --expand, whose closed form keeps its symbols; leave out one of them")
    if expanded and scene.driven:
        raise ValueError(
            f"--expand: found {', '.join(e.title for e in scene.effects if e.driven())}, expected no [[drive]]: the "
            "expanded form knows no prescribed motion; leave out --expand"
        )
    effects = gated(scene.effects, scene.gates)
    form = expand(scene.mechanism, span(scene.mechanism, scene.driven), effects) if expanded else None
    choice = plan_scene(scene, plan, fold=fold)[1]
    topology, derived = derive_scene(scene, fold, choice=choice)
    summary, added = summarize(changed or scene, choice, derived), prices(scene, fold, derived, choice)
    if latex:
        return expanded_document(summary, form, added) if form else recursive_document(summary, derived, added)
    if form:
        return _text(summary, added, "\n".join(_expanded_lines(form)))
    if not equations:
        return _text(summary, added)
    return _text(summary, added, write_listing(scene.name, derived, name_index(scene, topology)).rstrip("\n"))


def summarize(scene: Scene, choice: Choice, equations: Equations) -> Summary:
    """Links, joints, loops, degrees of freedom, coordinates, effects, and operation counts, as headings with lines."""
    mechanism, topology, state = scene.mechanism, choice.topology, equations.state
    bare, _ = moving(mechanism)
    links, joints = bare.links, bare.joints
    root = mechanism.link_name(topology.root)
    effects = [_effect(scene, index) for index in range(len(scene.effects))]
    contacts = ", ".join(f"{c.point} on {c.ground}" for c in equations.contacts)
    discs = tuple(disc_lines(scene))
    inputs = ", ".join(name for effect in scene.effects for name in effect.inputs())
    program = lower(equations)
    functions = sorted(program.functions, key=lambda f: f.kernel.name.endswith(OTHERWISE))
    counts = [f"{f.kernel.name}: {f.counts()}" for f in functions if f.sections]
    return (
        ("model", (scene.name,)),
        ("links", (f"{len(links)}: " + ", ".join(link.name for link in links),)),
        *([("welded", (_welded(mechanism),))] if mechanism.welded else []),
        ("joints", (f"{len(joints)}: " + (", ".join(_joint(mechanism, j) for j in joints) or "none"),)),
        ("root", (f"{root}, floating" if topology.floating else root,)),
        ("loops", tuple(_loop(mechanism, topology, cut) for cut in topology.cuts) or ("none",)),
        ("branch", tuple(branch_lines(scene, topology)) or ("no loop",)),
        *([("order", tuple(order_lines(scene, choice, program, bool(equations.folded))))] if topology.cuts else []),
        *([("modules", modules)] if (modules := tuple(module_lines(mechanism, program))) else []),
        (
            "degrees of freedom",
            (
                _freedom(scene, topology, len(state.u)),
                _mobility(bare, len(scene.driven)),
                *redundancy_lines(scene, mobility_of(scene)),
            ),
        ),
        ("coordinates q", (", ".join(map("{} = {}".format, state.q, _coordinates(mechanism, topology))),)),
        ("quasi-velocities u", (", ".join(s.name for s in state.u),)),
        *([("integrals", integrals)] if (integrals := _integrals(mechanism)) else []),
        ("effects", tuple(effects) or ("none",)),
        *([("changes", tuple(change.describe() for change in scene.changes))] if scene.changes else []),
        *([("events", (*_off(scene), *(event.describe() for event in scene.events)))] if scene.events else []),
        *([("contacts", (contacts,))] if contacts else []),
        *([("discs", discs)] if discs else []),
        *([("inputs", (inputs,))] if inputs else []),
        *([("parameters", ("folded: their values stand in the equations as numbers",))] if equations.folded else []),
        ("operations", tuple(counts)),
    )


def _coordinates(mechanism: Mechanism, topology: Topology) -> list[str]:
    """What the coordinates are, by names of outputs, in their order."""
    root = [f"{mechanism.link_name(topology.root)}.{axis}" for axis in "xy"] if topology.floating else []
    leaders = [k for k in range(len(mechanism.links)) if topology.leader(k) == k]
    slides = sorted(branch.joint for branch in topology.branches if branch.slides)
    angles = [f"{mechanism.link_name(k)}.angle" for k in leaders]
    return [*root, *angles, *(f"{mechanism.joints[joint].name}.slide" for joint in slides)]


def _integrals(mechanism: Mechanism) -> tuple[str, ...]:
    """Integrals over time, and the quasi-velocities that they are."""
    return tuple(f"{one.name} = w_{one.link}" for one in mechanism.integrators)


def _mobility(mechanism: Mechanism, driven: int) -> str:
    """Grübler's count, which knows nothing of lengths: joints that lose rank make the true number larger."""
    links = len(mechanism.links)
    kinds = [joint.kind for k, joint in enumerate(mechanism.joints) if k not in mechanism.open_gates]
    slots, welds = kinds.count("pin-in-slot"), kinds.count("weld")
    count = f"3 x {links} links - 2 x {len(kinds) - slots - welds} joints"
    count += f" - 3 x {welds} weld{'s' * (welds != 1)}" if welds else ""
    count += f" - {slots} pin{'s in slots' if slots > 1 else ' in a slot'}" if slots else ""
    count += f" - {_driven(driven)}" if driven else ""
    meshes = len(mechanism.meshes)
    count += f" - {meshes} mesh{'es' * (meshes != 1)}" if meshes else ""
    return f"{mechanism.freedoms(driven)} by Grübler's count: {count}"


def _driven(count: int) -> str:
    return f"{count} driven joint{'s' * (count != 1)}"


def _joint(mechanism: Mechanism, joint: Joint) -> str:
    first, second = _point(mechanism, joint.first), _point(mechanism, joint.second)
    if joint.slides:
        return f"{joint.name} ({joint.kind}: {second} on a line of {first})"
    return f"{joint.name} ({first} = {second})"


def _welded(mechanism: Mechanism) -> str:
    return ", ".join(f"{name} to {mechanism.link_name(owner)}" for name, owner in mechanism.welded.items())


def _point(mechanism: Mechanism, ref: PointRef) -> str:
    return f"{mechanism.link_name(ref.link)}.{ref.point}"


def _loop(mechanism: Mechanism, topology: Topology, cut: Cut) -> str:
    """The links around the loop that a cut joint closes, from its first side to its second."""
    there, back = topology.path(cut.first.link), topology.path(cut.second.link)
    links = [*there[: there.index(cut.meeting) + 1], *reversed(back[: back.index(cut.meeting)])]
    return f"cut at {mechanism.joints[cut.joint].name}: " + " - ".join(mechanism.link_name(k) for k in links)


def _effect(scene: Scene, index: int) -> str:
    """What an effect is called, what there is to say of it, and what switches it."""
    effect, gate = scene.effects[index], scene.gate(index)
    switched = f", {gate.path} = {gate.value!r}" if gate else ""
    return f"{effect.title}: {effect.describe(scene.mechanism)}{switched}"


def _off(scene: Scene) -> tuple[str, ...]:
    """What is absent until an event switches it on."""
    return (f"at the start {', '.join(scene.off)} {'is' if len(scene.off) == 1 else 'are'} off",) if scene.off else ()


def _freedom(scene: Scene, topology: Topology, count: int) -> str:
    """Number of quasi-velocities less the rank of the closure at the start, and less what drives prescribe."""
    off = sum(len(cut.rows) for cut in topology.cuts if cut.joint in scene.mechanism.open_gates)
    rows, driven, integrals = len(topology.rows) - off, len(scene.driven), len(scene.mechanism.integrators)
    less = f" - {integrals} integral{'s' * (integrals != 1)}" if integrals else ""
    if not rows:
        text = f" - {_driven(driven)}" if driven else ""
        text = f" = {count} quasi-velocities{less}{text}" if less or text else ""
        return f"{count - driven - integrals}{text}, no closure"
    layout = lay_out(scene.mechanism, driven=scene.driven)
    _, speeds = drive_layout(layout, scene.mechanism, scene.effects)
    shut = layout.jacobian(layout.read_off(np.array(scene.start.poses)))
    shut = np.vstack([shut, *(speed.row for speed in mesh_speeds(layout, scene.mechanism))])
    size, told = shut.shape[1] + 2 * layout.floating, np.vstack([shut, *(speed.row for speed in speeds)])
    closed, left = (size - int(np.linalg.matrix_rank(a, tol=RANK_TOLERANCE)) for a in (shut, told))
    text = f"{left - integrals} = {count} quasi-velocities{less}"
    text += f" - rank {count - closed} of the {rows} closure rows at the start"
    if closed - left == driven:
        return text + (f" - {_driven(driven)}" if driven else "")
    return f"{text} - {closed - left} of {_driven(driven)}, the others held by the closure here"


def _text(summary: Summary, added: Sequence[Price], equations: str = "") -> str:
    """The summary in two columns, what effects add as its last entry, and the equations, if any, below it."""
    if added:
        summary = (*summary, ("added by effects", price_lines(added)))
    indent = max(len(heading) for heading, _ in summary) + 2
    lines = []
    for heading, entries in summary:
        for number, entry in enumerate(entries):
            first = (heading if number == 0 else "").ljust(indent)
            lines += textwrap.wrap(
                entry, WIDTH, initial_indent=first, subsequent_indent=" " * (indent + 2), break_long_words=False
            )
    return "\n".join([*lines, "", equations] if equations else lines)


def _expanded_lines(form: ExpandedForm) -> Iterator[str]:
    """The closed form, one entry a line."""
    u = [s.name for s in form.state.u]
    rows = [s.name for s in form.multipliers]
    right = " + ".join([*(["Q"] if form.Q is not None else []), *(["A^T lambda"] if rows else [])])
    yield f"[flight: M u_dot + h = {right or '0'}" + (", A u_dot + dA/dt u = 0]" if rows else "]")
    yield "# M is symmetric; entries that are not listed are 0"
    yield "u: " + ", ".join(u)
    if rows:
        yield "lambda: " + ", ".join(rows)
    for i, row in enumerate(u):
        for j, column in enumerate(u[i:], start=i):
            yield from _entry(f"M[{row}, {column}]", form.M[i, j])
    for i, row in enumerate(u):
        yield from _entry(f"h[{row}]", form.h[i])
    for a in form.forces:
        yield f"{a.symbol.name} = {write(a.expression, LISTING)}"
    if form.Q is not None:
        for i, row in enumerate(u):
            yield from _entry(f"Q[{row}]", form.Q[i])
    for i, row in enumerate(rows):
        for j, column in enumerate(u):
            yield from _entry(f"A[{row}, {column}]", form.A[i, j])
    for i, row in enumerate(rows):
        yield from _entry(f"(dA/dt u)[{row}]", form.A_rate[i])
    yield from _expanded_impact(form, u)


def _expanded_impact(form: ExpandedForm, u: list[str]) -> Iterator[str]:
    if not form.contacts:
        return
    loops = ("A^T Lambda + ", ", A u_plus = 0") if form.multipliers else ("", "")
    law = f"M (u_plus - u_minus) = {loops[0]}N^T P{loops[1]}"
    yield f"\n[impact: {law}, 0 <= P, 0 <= N u_plus + e N u_minus, their product 0]"
    for a in form.definitions:
        yield f"{a.symbol.name} = {write(a.expression, LISTING)}"
    for i, (point, ground) in enumerate(form.contacts):
        for j, column in enumerate(u):
            yield from _entry(f"N[{point} on {ground}, {column}]", form.N[i, j])


def _entry(name: str, value: object) -> Iterator[str]:
    if value != 0:
        yield f"{name} = {write(value, LISTING)}"
