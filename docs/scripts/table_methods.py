"""What type checkers and editors are told of a mechanism's methods; ``--write`` puts it into
generator/table_methods.pyi, ``--check`` fails where that is another text.

``Mechanism`` makes its methods of the tables of scenes when they are called, which nothing sees that does not run it.
"""

from __future__ import annotations

import argparse
import inspect
import json
import keyword
import textwrap
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ccgen.generator import Mechanism
from ccgen.generator.scene import TABLES
from ccgen.generator.scene.editor_schema import editor_schema

PLACE = Path(__file__).resolve().parents[2] / "generator" / "table_methods.pyi"
WIDTH = 120
HEAD = '''"""The methods of :class:`~.builder.Mechanism` for tables; docs/scripts/table_methods.py writes this."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from .builder import Mechanism

Number = float | np.floating[Any] | np.integer[Any] | str
"""A number, or a text: a number with its unit, or arithmetic over names of ``let``."""
Whole = int | np.integer[Any] | str
Array = NDArray[Any]

class TableMethods:
    """Each adds a table; where its schema has no default, a key that is not given is a fault of the scene."""
'''
WORDS = {"boolean": "bool", "string": "str", "object": "Mapping[str, Any]", "null": "None"}

Schema = Mapping[str, Any]


def type_of(schema: Schema) -> list[str]:
    """The types of values that a JSON Schema allows, to be joined by ``|``."""
    for several in ("anyOf", "oneOf"):
        if several in schema:
            return joined(type_of(one) for one in schema[several])
    if "$ref" in schema:
        return [WORDS["object"]]
    if "enum" in schema:
        return [f"Literal[{', '.join(map(json.dumps, schema['enum']))}]"]
    kinds = schema.get("type", [])
    return joined(of_kind(kind, schema) for kind in ([kinds] if isinstance(kinds, str) else kinds)) or ["Any"]


def of_kind(kind: str, schema: Schema) -> list[str]:
    """Those of one kind of value."""
    if kind in ("number", "integer"):
        return ["Number" if kind == "number" else "Whole"]
    if kind == "array":
        items = type_of(schema.get("items", {}))
        numbers = items == ["Any"] or {"Number", "Whole", "Array"} & {*items}
        return [f"Sequence[{' | '.join(items)}]", *(["Array"] if numbers else [])]
    inner = schema.get("additionalProperties") or next(iter(schema.get("patternProperties", {}).values()), None)
    return [f"Mapping[str, {' | '.join(type_of(inner))}]"] if kind == "object" and inner else [WORDS[kind]]


def joined(several: Iterator[list[str]]) -> list[str]:
    """All of them once; numbers may be texts anyway."""
    found = list(dict.fromkeys(one for types in several for one in types))
    return [one for one in found if one != "str" or not {"Number", "Whole"} & {*found}]


def parameters(key: str, schema: Schema) -> Iterator[str]:
    """Those of a method as they are written."""
    known = inspect.signature(getattr(Mechanism(), key)).parameters.values()
    for place, one in enumerate(known):
        if one.kind is one.VAR_KEYWORD:
            yield f"**{one.name}: {' | '.join(type_of(schema['additionalProperties']))}"
            continue
        if one.kind is one.KEYWORD_ONLY and not any(before.kind is one.KEYWORD_ONLY for before in [*known][:place]):
            yield "*"
        types = [kind for kind in type_of(schema["properties"][one.name]) if kind != "None"]
        if key == "part" and one.name == "name":
            types.append("Mechanism")
        assert not keyword.iskeyword(one.name)
        yield f"{one.name}: {' | '.join(types)} | None = None"


def method(key: str, schema: Schema) -> str:
    """One method: its parameters, a line each, and its docstring."""
    lines = "".join(f"        {one},\n" for one in ("self", *parameters(key, schema)))
    said = getattr(Mechanism(), key).__doc__ or ""
    first, _, told = said.strip().partition("\n\n")
    wrapped = [
        textwrap.fill(line, WIDTH, initial_indent=" " * 8, subsequent_indent=" " * 12) for line in told.splitlines()
    ]
    text = "\n".join((first, "", *wrapped, " " * 8)) if wrapped else first
    assert "\\" not in text and '"""' not in text
    return f'\n    def {key}(\n{lines}    ) -> Mechanism:\n        """{text}"""\n'


def stub() -> str:
    """The whole file."""
    schema = json.loads(editor_schema())
    tables = schema["properties"]

    def of(key: str) -> Schema:
        one = tables[key]["items"] if TABLES[key].many else tables[key]
        found: Schema = schema["$defs"][one["$ref"].rpartition("/")[2]]
        return found

    return HEAD + "".join(method(key, of(key)) for key in TABLES)


def main() -> None:
    """Print it, write it, or compare it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="write generator/table_methods.pyi")
    parser.add_argument("--check", action="store_true", help="fail where generator/table_methods.pyi is another text")
    asked = parser.parse_args()
    if asked.write:
        PLACE.write_text(stub(), encoding="utf-8")
    elif asked.check and PLACE.read_text(encoding="utf-8") != stub():
        raise SystemExit(f"{PLACE}: is not that of the tables; run docs/scripts/table_methods.py --write")
    elif not asked.check:
        print(stub(), end="")


if __name__ == "__main__":
    main()
