"""The listing ``equations.txt``: what a person reads and what is compared, one named quantity a line.

Lines ``name = expression`` can be read back and evaluated (``program/reading.py``). Lines that begin with ``|`` are
equations for the reader: each link's Gibbs function S, and the equation 0 = ∂V/∂v of each quasi-acceleration and
multiplier v, which the lines below them solve.
"""

from __future__ import annotations

from collections.abc import Iterator

from ..equations.equations import Block, Equations
from ..mechanism.topology import Topology
from ..program.dialects import LISTING, write
from ..scene.scene import Scene

HEAD = "ccgen equations, format 1"


def write_listing(name: str, equations: Equations, index: tuple[str, ...]) -> str:
    """The whole listing. ``index`` says what the numbers in names stand for."""
    return "\n".join([*_lines(name, equations, index)]) + "\n"


def _lines(name: str, equations: Equations, index: tuple[str, ...]) -> Iterator[str]:
    yield f"# {HEAD}"
    yield f"# model {name}"
    yield from (f"# {line}" for line in index)
    yield "\n[state]"
    yield "q: " + ", ".join(s.name for s in equations.state.q)
    yield "u: " + ", ".join(s.name for s in equations.state.u)
    yield "\n[parameters]"
    for p in equations.parameters:
        yield f"{p.symbol} = {p.value!r}  # {p.path}"
    if equations.folded:
        yield "# folded: these values stand in the equations as numbers"
    for p in equations.folded:
        yield f"# {p.symbol} = {p.value!r}  {p.path}"
    for block in equations.blocks:
        yield from _block(block)
    for kernel in equations.kernels:
        yield f"\n[kernel {kernel.name}: {kernel.purpose}]"
        for argument in kernel.inputs:
            yield f"{argument.name}: " + ", ".join(s.name for s in argument.symbols)
        for output in kernel.outputs:
            last = len(output.entries) - 1  # written even if zero: it tells the size
            for i, entry in enumerate(output.entries):
                if entry != 0 or len(output.entries) < 64 or i == last:
                    yield f"{output.name}[{i}] = {write(entry, LISTING)}"


def _block(block: Block) -> Iterator[str]:
    yield f"\n[{block.title}]"
    if block.gibbs:
        yield f"| {block.gibbs.symbol} = {write(block.gibbs.expression, LISTING)}"
    for equation in block.stationary:
        yield f"| {equation.symbol}: 0 = {write(equation.expression, LISTING)}"
    for a in block.assignments:
        yield f"{a.symbol.name} = {write(a.expression, LISTING)}"


def name_index(scene: Scene, topology: Topology) -> tuple[str, ...]:
    """What the numbers in names stand for: links, joints, and the cut joints of the loops."""
    links = ", ".join(f"{k} {link.name}" for k, link in enumerate(scene.mechanism.links))
    joints = ", ".join(f"{j} {joint.name}" for j, joint in enumerate(scene.mechanism.joints))
    cuts = ", ".join(scene.mechanism.joints[cut.joint].name for cut in topology.cuts)
    root = scene.mechanism.link_name(topology.root)
    meshes = ", ".join(f"{row.joint} {row.mesh.name}" for row in topology.meshes)
    told = (f"links: {links}", f"joints: {joints or 'none'}", f"root: {root}; cut joints: {cuts or 'none'}")
    return (*told, f"meshes: {meshes}") if meshes else told
