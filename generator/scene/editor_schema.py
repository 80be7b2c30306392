"""The JSON Schema of scene files, by which editors complete keys and mark what is wrong as it is typed.

It is made of the tables by which scenes are read, so that it knows every word that they know.
"""

from __future__ import annotations

import json
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

from .kinds import KEYS, TABLES
from .part_tables import ROWS_OF_PARTS, PlacedStartTable

_REF = "#/$defs/{}"


def editor_schema() -> str:
    """The schema as JSON (draft 2020-12)."""
    models: dict[str, type[BaseModel]] = {key: kind.model for key, kind in TABLES.items()}
    models["placed start"] = PlacedStartTable
    kinds, found = models_json_schema([(model, "validation") for model in models.values()])
    tables: dict[str, Any] = found["$defs"]
    names = {key: kinds[model, "validation"]["$ref"] for key, model in models.items()}
    numbers = {"type": "object", "additionalProperties": {"anyOf": [{"type": "number"}, {"type": "string"}]}}
    tables["LetTable"] |= numbers
    for name in ("PartTable", "PlaceTable"):
        tables[name]["properties"]["let"] |= numbers
    part = tables["PartTable"]["properties"]
    for key in (*ROWS_OF_PARTS, "place"):
        part[key] = {"type": "array", "items": {"$ref": names[key]}}
    part |= {"ground_link": {"$ref": names["ground_link"]}, "start": {"$ref": names["placed start"]}}
    properties: dict[str, Any] = {"name": {"type": "string", "pattern": "^[A-Za-z][A-Za-z0-9_-]*$"}}
    for key in KEYS[1:]:
        one = {"$ref": names[key]}
        properties[key] = {"type": "array", "items": one} if TABLES[key].many else one
    schema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "ccgen scene",
        "type": "object",
        "properties": properties,
        "additionalProperties": False,
        "$defs": tables,
    }
    return json.dumps(schema, indent=1, ensure_ascii=False) + "\n"
