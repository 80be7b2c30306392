"""The layers of the core by their real includes, and their sizes; ``--write`` puts both into docs/architecture.md."""

from __future__ import annotations

import argparse
import re
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCREEN = 60
"""Lines that a function may have."""

CORE = ROOT / "runtime" / "core"
PAGE = ROOT / "docs" / "architecture.md"
GRAPH = "<!-- includes -->\n", "\n<!-- end of includes -->"
SIZES = "<!-- sizes -->\n", "\n<!-- end of sizes -->"


def layers() -> list[str]:
    """The folders of the core in the order of the table."""
    section = PAGE.read_text(encoding="utf-8").partition("## The core in C")[2].partition("Where is")[0]
    return re.findall(r"^\| `(\w+)` \|", section, re.MULTILINE)


def files(layer: str) -> list[Path]:
    """Sources and headers of a layer."""
    return sorted(path for path in (CORE / layer).iterdir() if path.suffix in (".c", ".h"))


def includes() -> dict[str, set[str]]:
    """Per layer the others from which its files include."""
    return {
        layer: {
            name
            for file in files(layer)
            for name in re.findall(r'^#include "(\w+)/', file.read_text(encoding="utf-8"), re.MULTILINE)
        }
        - {layer}
        for layer in layers()
    }


def reduced(graph: Mapping[str, set[str]]) -> dict[str, set[str]]:
    """The transitive reduction of a graph without circles: what follows from other edges is left out."""

    def reached(start: str) -> set[str]:
        return graph[start].union(*(reached(one) for one in graph[start]))

    return {
        node: {one for one in to if not any(one in reached(other) for other in to - {one})}
        for node, to in graph.items()
    }


def picture() -> str:
    """The reduced graph for Mermaid, in the order of the table."""
    graph, order = reduced(includes()), layers()
    lines = [f"    {layer} --> {one}" for layer in reversed(order) for one in reversed(order) if one in graph[layer]]
    return "\n".join(["```mermaid", "graph TD", *lines, "```"])


def functions(file: Path) -> list[tuple[str, int]]:
    """Names of the functions of a file, each with how many lines it has.

    By our format: from the line in column 0 that begins its head to the brace in column 0 that ends it.
    """
    found, head = [], 0
    lines = file.read_text(encoding="utf-8").splitlines()
    for number, line in enumerate(lines):
        if re.match(r"[a-z]", line):
            head = number
        elif line == "{":
            body = next(end for end in range(number, len(lines)) if lines[end] == "}")
            name = re.search(r"(\w+)\(", lines[head])
            found.append((name[1] if name else "", body - head + 1))
    return found


def sizes() -> str:
    """Lines of C, the longest function, and the constants of each layer."""
    rows = ["| layer | lines | longest function | lines of it | constants |", "|---|---|---|---|---|"]
    whole, longest, constants = 0, ("", 0), 0
    for layer in layers():
        texts = [file.read_text(encoding="utf-8") for file in files(layer)]
        lines = sum(text.count("\n") for text in texts)
        own = sum(
            len(re.findall(r"^(?:static )?const (?:double|int|long) \w+\s*=", text, re.MULTILINE)) for text in texts
        )
        name, long = max((one for file in files(layer) for one in functions(file)), key=lambda one: one[1])
        rows.append(f"| `{layer}` | {lines} | `{name}` | {long} | {own} |")
        whole, constants, longest = whole + lines, constants + own, max(longest, (name, long), key=lambda one: one[1])
    return "\n".join([*rows, f"| the core | {whole} | `{longest[0]}` | {longest[1]} | {constants} |"])


def page() -> str:
    """docs/architecture.md with picture and table as they are now."""
    text = PAGE.read_text(encoding="utf-8")
    for (begin, end), new in ((GRAPH, picture()), (SIZES, sizes())):
        before, _, rest = text.partition(begin)
        text = before + begin + new + end + rest.partition(end)[2]
    return text


def main() -> None:
    """Print picture and table, or write them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="write both into docs/architecture.md")
    if parser.parse_args().write:
        PAGE.write_text(page(), encoding="utf-8")
    else:
        print(picture(), sizes(), sep="\n\n")


if __name__ == "__main__":
    main()
