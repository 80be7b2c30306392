"""A routine over lanes: the same assignments as for one state, with the type that each quantity has.

What depends on the state, on time or on inputs is a vector, one number per lane; what depends on parameters alone is a
number, the same in all lanes. C mixes the two in sums and products, so no expression changes.
"""

from __future__ import annotations

from collections.abc import Iterable

from ..program.dialects import C
from ..program.rolling import Lines, Loop
from ..program.routine import Routine
from ..program.terms import ZERO, Assign, Name, Term, leaves
from .routines import Slots, clears, declared, lengths, meanings, outputs

VECTOR, NUMBER = "ccgen_lanes", "double"
GIVEN = ("q", "u", "t", "inputs")
STATE = ("q", "u")
FILLED = ("u_dot", "lambda")
ASKED = "lambda"


class Lanes:
    """Knows which names are vectors, from the names of arrays and arguments and from what was typed before."""

    def __init__(self, vectors: Iterable[str]) -> None:
        self.vectors = set(vectors)

    def is_vector(self, term: Term) -> bool:
        """Whether the value of a term is a vector."""
        return any((leaf.name if isinstance(leaf, Name) else leaf.array) in self.vectors for leaf in leaves(term))

    def line(self, line: Assign) -> tuple[str, str]:
        """The assignment with its type in front; what lies in an array is a vector in any case."""
        if not isinstance(line.target, Name):
            return C.text(line.target), self.vector(line.value)
        vector = self.is_vector(line.value)
        if vector:
            self.vectors.add(line.target.name)
        else:
            self.vectors.discard(line.target.name)
        return declared(line, VECTOR if vector else NUMBER, C)

    def vector(self, term: Term) -> str:
        """The term as a vector."""
        return C.text(term) if self.is_vector(term) else f"CCGEN_ALL({C.text(term)})"

    def part(self, part: Lines | Loop) -> Slots:
        """A block or a loop of blocks."""
        if isinstance(part, Lines):
            return {"title": part.title, "rounds": 0, "lines": [self.line(line) for line in part.lines]}
        blocks = [self.part(block) for block in part.body]
        return {"title": part.title, "rounds": part.rounds, "modules": part.modules, "body": blocks}


def over_states(routine: Routine) -> Slots:
    """What ``lanes.c.j2`` prints of a routine over states that lie one after the other.

    They are turned into lanes and back. Times are lanes already, and inputs the same in all.
    """
    arrays = {name: size for name, size in lengths(routine.function.kernel).items() if size and name != "t"}

    def passed(name: str, kind: str) -> str:
        if name == "t":
            return name
        lanes = f"({kind}){name}_lanes" if name in arrays else "NULL"
        return f"{name} ? {lanes} : NULL" if name == ASKED and name in arrays else lanes

    given = [passed(name, "const double *") for name in GIVEN]
    return {
        "signature": signature(""),
        "arrays": arrays,
        "turned": [name for name in STATE if name in arrays],
        "same": [name for name in GIVEN if name not in (*STATE, "t") and name in arrays],
        "call": ", ".join(["k", *given, *(passed(name, "double *") for name in FILLED)]),
        "asked": ASKED if ASKED in arrays else None,
        "unused": [name for name in (*GIVEN, *FILLED) if name not in arrays and name != "t"],
    }


def signature(ending: str) -> str:
    """Arguments of the functions over lanes; names of arrays have an ending."""
    arguments = [*(f"const double *{name}{ending}" for name in GIVEN), *(f"double *{name}{ending}" for name in FILLED)]
    return ", ".join(["const double *k", *arguments])


def over_lanes(routine: Routine, packed_from: int) -> Slots:
    """What ``lanes.c.j2`` prints of a routine over states side by side."""
    lanes = Lanes({*GIVEN, "c", "s", *(name for name, _ in routine.arrays)})
    angles = routine.angles
    start = f" + {angles.first}" if angles.first else ""
    loads = [lanes.line(line) for line in routine.loads]
    sections = [lanes.part(part) for part in routine.statements if not part.late]
    late = [lanes.part(part) for part in routine.statements if part.late]
    kept = [f"({lanes.vector(guard.pivot)} > {lanes.vector(guard.least or ZERO)})" for guard in routine.guards]
    return {
        "purpose": routine.function.kernel.purpose,
        "counts": str(routine.function.counts()),
        "meanings": meanings(routine),
        "signature": signature("_lanes"),
        "stored": [name for name in GIVEN if name not in (*routine.unused, "t")],
        "filled": [name for name in FILLED if name not in routine.unused],
        "timed": "t" not in routine.unused,
        "packed": packed_from if routine.reads("k_abreast") else None,
        "arrays": routine.arrays,
        "angles": {"count": len(angles.order), "read": angles.array + start} if angles.order else None,
        "loads": loads,
        "sections": sections,
        "late": late,
        "asked": ASKED if ASKED not in routine.unused else None,
        "asked_outputs": outputs(routine, lanes.vector, asked=True),
        "clears": clears(routine),
        "outputs": outputs(routine, lanes.vector, asked=False),
        "unused": [name if name == "k" else f"{name}_lanes" for name in routine.unused],
        "lost_rank": f"ccgen_bits(~({' & '.join(kept)}))" if kept else "0",
    }
