"""Generated packages compiled again from their own files, for the machine at hand: nothing is derived."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import partial
from pathlib import Path

from .compile.cache import cache_folder, fetch_or_build, key_of
from .compile.compiled_package import compile_package
from .compile.compiler import Compiler, cythonize, find_compiler
from .compile.kept_steps import Steps
from .package.parts import DATA, EXTENSION, KEY, RECORD

MADE = (KEY, RECORD, "_binding.c")
"""Files that compiling makes, beside the extension module."""


def rebuild(packages: Mapping[str, Mapping[str, bytes]], name: str) -> Path:
    """The folder of the package ``name``, compiled here from the files of ``packages``, by package and file; the others
    lie beside it.

    For a model that was generated on another machine, whose processor or Python this one has not: a worker of a sweep
    calls it. What has been compiled before is taken from the cache, and two processes that ask at once compile once.
    Raises ``CompileError`` where there is no compiler or it fails, ``OutputError`` where the cache cannot be written.
    """
    compiler = find_compiler()
    texts = {one: _sources(files) for one, files in packages.items()}
    said = [f"{one}/{file}\n{text.decode()}" for one, files in texts.items() for file, text in sorted(files.items())]
    place = cache_folder() / "rebuilt" / key_of(*said, compiler.version, *compiler.command, *compiler.flags())[:32]
    for one, files in texts.items():
        key = key_of(one, *said, compiler.version, *compiler.command, *compiler.flags())
        fetch_or_build(key, place / one, partial(_build, files, one, compiler, key))
    return place / name


def _sources(files: Mapping[str, bytes]) -> dict[str, bytes]:
    """Those of a package's files that it is compiled from, and its data."""
    return {name: text for name, text in files.items() if name not in MADE and not EXTENSION.fullmatch(name)}


def _build(files: Mapping[str, bytes], name: str, compiler: Compiler, key: str, folder: Path) -> None:
    """Write and compile them in an empty folder."""
    for file, text in files.items():
        (folder / Path(file).name).write_bytes(text)
    steps = Steps()
    cythonize(folder, steps)
    compile_package(compiler, folder, name, json.loads(files[DATA])["hash"], key, steps)
