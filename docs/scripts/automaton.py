"""The picture of the hybrid automaton in docs/events.md, made from the table in runtime/core/hybrid/automaton.c."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
NAMES = {
    "START": "start",
    "MOVE": "smooth phase",
    "MEET": "event",
    "STRIKE": "impacts",
    "SELECT": "contact transition",
    "STEP": "time stepping",
    "END": "end",
}


def diagram() -> str:
    """The table as a state diagram of Mermaid; what has no guard is what is left."""
    text = (ROOT / "runtime" / "core" / "hybrid" / "automaton.c").read_text()
    table = text.partition("TRANSITIONS[] = {")[2].partition("};")[0]
    lines = ["stateDiagram-v2", *(f"    {stage}: {name}" for stage, name in NAMES.items()), "    [*] --> START"]
    for start, guard, end in re.findall(r"\{(\w+), (\w+), (\w+)\}", table):
        if (start, end) != ("END", "END"):
            lines.append(f"    {start} --> {end}" + ("" if guard == "NULL" else f": {guard.replace('_', ' ')}"))
    lines += [f"    {stage} --> STEP: gets no further" for stage in ("MOVE", "MEET", "STRIKE", "SELECT")]
    lines += [f"    {stage} --> STRIKE: friction jams" for stage in ("MOVE", "SELECT")]
    return "\n".join([*lines, "    END --> [*]"])


if __name__ == "__main__":
    print(diagram())
