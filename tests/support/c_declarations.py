"""Declarations of C headers, and of Cython's copies of them, as names and types that can be compared."""

from __future__ import annotations

import ctypes
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from .folders import RUNTIME

TYPES = {"char", "int", "long", "double", "size_t", "void"}
"""Words that end a type, and are no names."""


def headers() -> str:
    """All headers that programs and the compiled face of the runtime see, without their comments."""
    files = [RUNTIME / "model.h", RUNTIME / "ccgen.h", *sorted((RUNTIME / "core").rglob("*.h"))]
    return "\n".join(plain(file) for file in files)


def plain(file: Path) -> str:
    """A file of C without comments and without lines of the preprocessor."""
    text = re.sub(r"/\*.*?\*/|//[^\n]*", " ", file.read_text(encoding="utf-8"), flags=re.DOTALL)
    text = re.sub(r"\\\n", " ", text)
    return re.sub(r"^[ \t]*#.*$", "", text, flags=re.MULTILINE)


def members(text: str, struct: str) -> dict[str, str]:
    """Types of the members of a structure, by name and in order."""
    found = re.search(rf"\bstruct {struct} \{{(.*?)\n\}};", text, re.DOTALL)
    assert found, struct
    types = function_types(text)
    return {
        name: expanded(type_, types)
        for statement in found[1].split(";")
        if statement.strip()
        for name, type_ in declared(statement)
    }


def fields_of(header: Path, struct: str) -> tuple[tuple[str, Any], ...]:
    """Members of a structure for ``ctypes``; texts are bytes, other pointers have no type."""
    types = {"const char *": ctypes.c_char_p, "int": ctypes.c_int, "long": ctypes.c_long, "double": ctypes.c_double}
    types["size_t"] = ctypes.c_size_t
    found = members(plain(header), struct)
    return tuple(
        (name, ctypes.c_void_p if "*" in type_ and type_ not in types else types[type_])
        for name, type_ in found.items()
    )


def function_types(text: str) -> dict[str, str]:
    """Types of functions that have names, as pointers to them: ``ccgen_of_q *``."""
    found = re.findall(r"typedef ([\w ]+?) (\w+)\(([^;]*)\);", text)
    return {f"{name} *": pointer(result, parameters) for result, name, parameters in found}


def prototype(text: str, function: str) -> str:
    """The type of a function, as that of a pointer to it."""
    found = re.search(rf"^(?:CCGEN_PUBLIC )?((?:[a-z_]\w* )+\**){function}\(([^;{{]*)\);", text, re.MULTILINE)
    assert found, function
    return pointer(found[1], found[2])


def enumerators(text: str, name: str) -> dict[str, tuple[str, ...]]:
    """Entries of a list ``#define name(X) X(ENTRY, ...)``: what else each has, by name and in order."""
    (body,) = re.findall(rf"#define {name}\(\w+\)((?:.*\\\n)*.*)", text)
    entries = re.findall(r"\b(?:X|LAW|METHOD)\(([^()]*?(?:\"[^\"]*\"[^()]*)?)\)", body)
    found = {}
    for entry in entries:
        key, *rest = (part.strip() for part in re.findall(r'"[^"]*"|[^,"]+', entry) if part.strip())
        found[key] = tuple(part.strip('"') for part in rest)
    return found


def declared(statement: str) -> Iterator[tuple[str, str]]:
    """Names and types of one declaration, without its semicolon."""
    if function := re.fullmatch(r"\s*(.*?)\(\*(\w+)\)\s*\((.*)\)[\w ]*", statement, re.DOTALL):
        yield function[2], pointer(function[1], function[3])
        return
    first, *others = statement.split(",")
    base, stars, name = re.fullmatch(r"\s*(.*?)([* ]+)(\w+(?:\[\w+\])?)\s*", first, re.DOTALL).groups()  # type: ignore[union-attr]
    for one in (stars + name, *others):
        yield re.sub(r"[* \[\]\n]", "", one), normal(base + " " + "*" * one.count("*"))


def pointer(result: str, parameters: str) -> str:
    """The type of a pointer to a function."""
    types = [unnamed(one) for one in parameters.split(",") if one.strip() not in ("", "void")]
    return f"{normal(result)} (*)({', '.join(types)})"


def unnamed(parameter: str) -> str:
    """The type of a parameter, with or without its name."""
    words = re.findall(r"\w+|\*", re.sub(r"\b(struct|enum)\s+", r"\1_", parameter))
    before = set(words[:-1]) - {"const", "*"}
    named = words[-1] != "*" and words[-1] not in TYPES and before
    return normal(" ".join(words[:-1] if named else words))


def normal(type_: str) -> str:
    """A type with its words one space apart; enumerations are whole numbers, a structure has its name alone."""
    type_ = re.sub(r"\benum[ _]\w+", "int", type_)
    type_ = re.sub(r"\bstruct[ _]", "", type_)
    return " ".join(re.findall(r"\w+|\*", type_))


def expanded(type_: str, types: Mapping[str, str]) -> str:
    """A type in which the names of others are what they stand for."""
    return types.get(type_, type_)
