"""What impulses of contacts do, in one function: from impulses to the motion they give and the rates they change.

The derivation has the three parts (theory, 5.2): 𝓕 = NᵀP + TᵀF, M Δu = AᵀΛ + 𝓕 with A Δu = 0, and the rates N Δu, T Δu.
Here they are joined, so that what depends on the configuration alone, the factors of the elimination first of all, is
computed once for however many columns of impulses.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import sympy as sp

from ..equations.equations import Argument, Assignment, Block, Equations, Kernel, Output
from .slices import Slicer

NAME = "contact_response"


def responses(equations: Equations) -> dict[str, tuple[Kernel, tuple[Block, ...]]]:
    """Kernels that answer impulses of the contacts by name, each with its blocks; one for each plan of elimination.

    Their inputs are q and ``count`` columns of impulses, along the normals and then, where there is friction, along the
    tangents; their outputs are as many columns of Δu and of the rates of the gaps and then of the slips.
    """
    kernels = {kernel.name: kernel for kernel in equations.kernels}
    if "contact_impulse" not in kernels:
        return {}
    pushes = [kernels[name] for name in ("contact_impulse", "slip_impulse") if name in kernels]
    rates = [kernels[name] for name in ("gap_rates", "slips") if name in kernels]
    found = {}
    for kernel in equations.kernels:
        if kernel.name.startswith("impulse") and kernel.outputs[0].name == "du":
            joined = _joined(equations, kernel, pushes, rates)
            found[joined[0].name] = joined
    return found


def _joined(
    equations: Equations, impulse: Kernel, pushes: list[Kernel], rates: list[Kernel]
) -> tuple[Kernel, tuple[Block, ...]]:
    q, f, y = impulse.inputs
    slicer = Slicer(equations)
    still: dict[sp.Basic, sp.Basic] = dict.fromkeys(y.symbols, sp.S.Zero)
    given = [kernel.outputs[0].entries for kernel in pushes]
    blocks = slicer.blocks(entry for entries in given for entry in entries)
    done = {a.symbol for block in blocks for a in block.assignments}
    sums = [sp.Add(*entries) for entries in zip(*given, strict=True)]
    forces = _named("generalized impulses of the contacts", f.symbols, sums)
    blocks += _settled([forces], still)
    jumps = impulse.outputs[0].entries
    roots = [*jumps, *(entry for guard in impulse.guards for entry in guard)]
    solved = slicer.blocks(roots, done)
    done |= {a.symbol for block in solved for a in block.assignments}
    blocks += _settled(solved, still)
    u = rates[0].inputs[1]
    blocks += _settled([_named("jumps of the quasi-velocities", u.symbols, jumps)], still)
    changed = [entry for kernel in rates for entry in kernel.outputs[0].entries]
    blocks += _settled(slicer.blocks(changed, done), still)
    behind = impulse.name.removeprefix("impulse")
    symbols = tuple(s for kernel in pushes for s in kernel.inputs[1].symbols)
    rough = len(pushes) > 1
    meaning = "impulses of the contacts" + (", then the tangential ones" if rough else "")
    kernel = Kernel(
        NAME + behind,
        (q, Argument("P", symbols, f"{meaning}, N s")),
        (
            Output("du", tuple(s.xreplace(still) for s in u.symbols), "jumps of the quasi-velocities, loops held shut"),
            Output("rates", tuple(e.xreplace(still) for e in changed), "N du, m/s" + (", then T du" if rough else "")),
        ),
        "what impulses of the contacts change, column by column" + impulse.purpose.partition("y")[2],
        impulse.guards,
        impulse.otherwise and NAME + impulse.otherwise.removeprefix("impulse"),
        columns=("P", "du", "rates"),
    )
    read = [entry for output in kernel.outputs for entry in output.entries]
    return kernel, _read_by(blocks, [*read, *(entry for guard in impulse.guards for entry in guard)])


def _read_by(blocks: Sequence[Block], roots: Iterable[sp.Expr]) -> tuple[Block, ...]:
    """The blocks without what the roots do not depend on, as what was a factor of zeros."""
    read = {s for root in roots for s in root.free_symbols}
    found = []
    for block in reversed(blocks):
        kept = []
        for a in reversed(block.assignments):
            if a.symbol in read:
                read |= a.expression.free_symbols
                kept.append(a)
        if kept:
            found.append(replace(block, assignments=tuple(reversed(kept))))
    return tuple(reversed(found))


def _named(title: str, symbols: Iterable[sp.Symbol], values: Iterable[sp.Expr]) -> Block:
    return Block(title, tuple(Assignment(s, value) for s, value in zip(symbols, values, strict=True)))


def _settled(blocks: Iterable[Block], known: dict[sp.Basic, sp.Basic]) -> list[Block]:
    """The blocks with what is ``known`` put in; what becomes a number or another name by that is known from then on."""
    found = []
    for block in blocks:
        kept = []
        for a in block.assignments:
            value = a.expression.xreplace(known)
            if value.is_Number or value.is_Symbol or (-value).is_Symbol:
                known[a.symbol] = value
            else:
                kept.append(Assignment(a.symbol, value))
        if kept:
            found.append(replace(block, assignments=tuple(kept)))
    return found
