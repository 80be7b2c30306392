"""The equations for a person: a summary, then the listing or the expanded closed form, as text or LaTeX."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator

import numpy as np

from ..derive.equations import Equations
from ..derive.expanded import ExpandedForm, expand
from ..effects.effect import Effect
from ..mechanism.assembly import lay_out
from ..mechanism.joints import Joint, PointRef
from ..mechanism.links import Parameter
from ..mechanism.mechanism import Mechanism
from ..mechanism.topology import Cut, Topology, span
from ..program.program import lower
from ..scene.scene import Scene
from .expressions import LISTING, write
from .latex import Summary, expanded_document, recursive_document

WIDTH = 120
RANK_TOLERANCE = 1e-9
"""Singular values of the closure's Jacobian (m) below this count as zero."""


def show_text(scene: Scene, latex: bool, expanded: bool) -> str:
    """The text that ``ccgen show`` prints. Raises ``ValueError`` for an expanded form of too many links."""
    from ..pipeline import derive_scene
    from .listing import name_index, write_listing

    acting = [effect.title for effect in scene.effects if type(effect).loads is not Effect.loads]
    if expanded and acting:
        raise ValueError(
            f"the expanded form knows gravity and grounds, not {', '.join(acting)}; leave out --expand to see the "
            "recursive equations"
        )
    form = expand(scene.mechanism, span(scene.mechanism), scene.effects) if expanded else None
    topology, equations = derive_scene(scene)
    summary = summarize(scene, topology, equations)
    if form:
        return expanded_document(summary, form) if latex else _text(summary, "\n".join(_expanded_lines(form)))
    if latex:
        return recursive_document(summary, equations)
    return _text(summary, write_listing(scene.name, equations, name_index(scene, topology)).rstrip("\n"))


def summarize(scene: Scene, topology: Topology, equations: Equations) -> Summary:
    """Links, joints, loops, degrees of freedom, coordinates, effects, and operation counts, as headings with lines."""
    mechanism, state = scene.mechanism, equations.state
    links, joints = mechanism.links, mechanism.joints
    root = mechanism.link_name(topology.root)
    effects = [_effect(e.title, e.parameters()) for e in scene.effects]
    contacts = ", ".join(f"{c.name} on {c.ground}" for c in equations.contacts)
    inputs = ", ".join(name for effect in scene.effects for name in effect.inputs())
    counts = [f"{f.kernel.name}: {f.counts()}" for f in lower(equations).functions if f.sections]
    return (
        ("model", (scene.name,)),
        ("links", (f"{len(links)}: " + ", ".join(link.name for link in links),)),
        ("joints", (f"{len(joints)}: " + (", ".join(_joint(mechanism, j) for j in joints) or "none"),)),
        ("root", (f"{root}, floating" if topology.floating else root,)),
        ("loops", tuple(_loop(mechanism, topology, cut) for cut in topology.cuts) or ("none",)),
        ("degrees of freedom", (_freedom(scene, topology, len(state.u)), _mobility(len(links), len(joints)))),
        ("coordinates q", (", ".join(s.name for s in state.q),)),
        ("quasi-velocities u", (", ".join(s.name for s in state.u),)),
        ("effects", tuple(effects) or ("none",)),
        *([("contacts", (contacts,))] if contacts else []),
        *([("inputs", (inputs,))] if inputs else []),
        ("operations", tuple(counts)),
    )


def _mobility(links: int, joints: int) -> str:
    """Grübler's count, which knows nothing of lengths: joints that lose rank make the true number larger."""
    return f"{3 * links - 2 * joints} by Grübler's count: 3 x {links} links - 2 x {joints} joints"


def _joint(mechanism: Mechanism, joint: Joint) -> str:
    return f"{joint.name} ({_point(mechanism, joint.first)} = {_point(mechanism, joint.second)})"


def _point(mechanism: Mechanism, ref: PointRef) -> str:
    return f"{mechanism.link_name(ref.link)}.{ref.point}"


def _loop(mechanism: Mechanism, topology: Topology, cut: Cut) -> str:
    """The links around the loop that a cut joint closes, from its first side to its second."""
    there, back = topology.path(cut.first.link), topology.path(cut.second.link)
    links = [*there[: there.index(cut.meeting) + 1], *reversed(back[: back.index(cut.meeting)])]
    return f"cut at {mechanism.joints[cut.joint].name}: " + " - ".join(mechanism.link_name(k) for k in links)


def _freedom(scene: Scene, topology: Topology, count: int) -> str:
    """Number of quasi-velocities less the rank of the closure at the start."""
    rows = 2 * len(topology.cuts)
    if not rows:
        return f"{count}, no closure"
    angles = np.array([pose[2] for pose in scene.start.poses])
    rank = int(np.linalg.matrix_rank(lay_out(scene.mechanism).jacobian(angles), tol=RANK_TOLERANCE))
    return f"{count - rank} = {count} quasi-velocities - rank {rank} of the {rows} closure rows at the start"


def _effect(kind: str, parameters: tuple[Parameter, ...]) -> str:
    return f"{kind}: " + ", ".join(f"{p.path} = {p.value!r}" for p in parameters)


def _text(summary: Summary, equations: str) -> str:
    """The summary in two columns, and the equations below it."""
    indent = max(len(heading) for heading, _ in summary) + 2
    lines = []
    for heading, entries in summary:
        for number, entry in enumerate(entries):
            first = (heading if number == 0 else "").ljust(indent)
            lines += textwrap.wrap(
                entry, WIDTH, initial_indent=first, subsequent_indent=" " * (indent + 2), break_long_words=False
            )
    return "\n".join([*lines, "", equations])


def _expanded_lines(form: ExpandedForm) -> Iterator[str]:
    """The closed form, one entry a line."""
    u = [s.name for s in form.state.u]
    rows = [s.name for s in form.multipliers]
    yield "[flight: " + ("M u_dot + h = A^T lambda, A u_dot + dA/dt u = 0]" if rows else "M u_dot + h = 0]")
    yield "# M is symmetric; entries that are not listed are 0"
    yield "u: " + ", ".join(u)
    if rows:
        yield "lambda: " + ", ".join(rows)
    for i, row in enumerate(u):
        for j, column in enumerate(u[i:], start=i):
            yield from _entry(f"M[{row}, {column}]", form.M[i, j])
    for i, row in enumerate(u):
        yield from _entry(f"h[{row}]", form.h[i])
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
