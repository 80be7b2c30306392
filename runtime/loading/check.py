"""A package's ``model.json`` against its schema, before anything of it is used."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from functools import cache
from operator import ge, gt, le
from pathlib import Path
from typing import Any

SCHEMA = Path(__file__).with_name("model.schema.json")
"""Written by the generator; docs/model.md has it as a table."""

TYPES: Mapping[str, tuple[type, ...]] = {
    "object": (dict,),
    "array": (list,),
    "string": (str,),
    "integer": (int,),
    "number": (int, float),
    "boolean": (bool,),
    "null": (type(None),),
}
BOUNDS = (("minimum", "at least", ge), ("exclusiveMinimum", "more than", gt), ("maximum", "at most", le))


def fault(data: object) -> str:
    """The first fault of the data: its key, what was found and what is expected; empty if there is none."""
    schema = _schema()
    return next(_faults(data, schema, schema["$defs"], ""), "")


@cache
def _schema() -> dict[str, Any]:
    return dict(json.loads(SCHEMA.read_text(encoding="utf-8")))


def _faults(value: Any, said: Mapping[str, Any], tables: Mapping[str, Any], key: str) -> Iterator[str]:
    """Faults of a value, by the part of JSON Schema that the schema is written in."""
    if "$ref" in said:
        said = {**tables[said["$ref"].rpartition("/")[2]], **said}
    if "anyOf" in said:
        if all(any(_faults(value, one, tables, key)) for one in said["anyOf"]):
            yield _sentence(key, value, " or ".join(_kind(one) for one in said["anyOf"]))
        return
    expected = said.get("type", "")
    if expected and (not isinstance(value, TYPES[expected]) or (isinstance(value, bool) and expected != "boolean")):
        yield _sentence(key, value, _kind(said))
    elif "enum" in said and value not in said["enum"]:
        yield _sentence(key, value, f"one of {', '.join(map(repr, said['enum']))}")
    elif isinstance(value, dict):
        yield from _faults_inside(value, said, tables, key)
    elif isinstance(value, list):
        if not said.get("minItems", 0) <= len(value) <= said.get("maxItems", len(value)):
            yield f"{key}: found {len(value)} values, expected {said['minItems']}"
        kinds = said.get("prefixItems") or [said["items"]] * len(value)
        for index, (item, kind) in enumerate(zip(value, kinds, strict=False)):
            yield from _faults(item, kind, tables, f"{key}[{index}]")
    else:
        for name, words, holds in BOUNDS:
            if name in said and not holds(value, said[name]):
                yield _sentence(key, value, f"{words} {said[name]}")


def _faults_inside(
    value: Mapping[str, Any], said: Mapping[str, Any], tables: Mapping[str, Any], key: str
) -> Iterator[str]:
    before, known = f"{key}." if key else "", said.get("properties", {})
    for name in said.get("required", ()):
        if name not in value:
            yield f"{before}{name}: found nothing, expected {known[name]['description']}"
    others = said["additionalProperties"]
    for name, item in value.items():
        if name not in known and not others:
            yield f"{before}{name}: found a key that no model has"
        else:
            yield from _faults(item, known.get(name, others), tables, f"{before}{name}")


def _kind(said: Mapping[str, Any]) -> str:
    return (
        "an object"
        if "$ref" in said
        else {"array": "an array", "object": "an object", "null": "null"}.get(
            said.get("type", ""), f"a {said.get('type', '')}"
        )
    )


def _sentence(key: str, value: object, expected: str) -> str:
    text = repr(value)
    return f"{key or 'the whole'}: found {text if len(text) < 40 else text[:36] + '...'}, expected {expected}"
