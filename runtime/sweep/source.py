"""Where a worker elsewhere has its model from: the folder of its package, or the files of that, compiled there."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from ..loading.load import reopen
from ..loading.package import RECORD
from ..model.model import Model
from ..model.start import Begin

Packages = Mapping[str, Mapping[str, bytes]]
"""Files of packages, by the name of each package and of each file."""
Rebuild = Callable[[Packages, str], Path]
"""Compiles packages for the machine that it is called on, or finds them done, and gives the folder of one of them, as
:func:`ccgen.generator.rebuild` does."""


class NoModelError(Exception):
    """A worker has no model, with the reason; the next try brings the package's files along."""


@dataclass(frozen=True)
class Source:
    """A model as it is sent: ``folder`` of its package, ``name`` and ``hash`` of the model, ``values`` of parameters,
    and where it begins if that is not the scene's start.

    ``files`` are those of its package, for workers that cannot load it from the folder; ``rebuild`` makes a package of
    them.
    """

    folder: Path
    name: str
    hash: str
    values: tuple[tuple[str, float], ...]
    begin: Begin | None = None
    rebuild: Rebuild | None = None
    files: tuple[tuple[str, tuple[tuple[str, bytes], ...]], ...] = ()

    def with_files(self) -> Source:
        """The same with the files of its package."""
        return replace(self, files=((self.folder.name, tuple(_files(self.folder))),))


def source_of(model: Model, rebuild: Rebuild | None) -> Source:
    """What is sent of a model. Raises ``TypeError`` for one that is in no package."""
    if model.folder is None:
        raise TypeError(f"{model.name}: found a model without a package, which cannot be sent; load it from one")
    values = tuple(model.parameters.items())
    return Source(model.folder, model.name, str(model.data["hash"]), values, model._begin, rebuild)


@lru_cache(maxsize=16)
def model_of(source: Source) -> Model:
    """The model in this process, loaded once. Raises :class:`NoModelError` where that is not possible."""
    values = dict(source.values)
    try:
        return reopen(source.folder, source.name, source.hash, values, source.begin)
    except (FileNotFoundError, ImportError) as error:
        if not source.files or source.rebuild is None:
            raise NoModelError(str(error)) from None
    packages = {name: dict(files) for name, files in source.files}
    return reopen(source.rebuild(packages, source.folder.name), source.name, source.hash, values, source.begin)


def build_of(model: Model) -> dict[str, Any]:
    """What a model's last digits hang on beside its numbers: the ``compiler``, its ``flags`` and the ``processor`` of
    its package, and the hash of the ``runtime``."""
    assert model.folder is not None
    record = json.loads((model.folder / RECORD).read_text())
    return {key: record[key] for key in ("compiler", "flags", "processor")} | {"runtime": hash_of_runtime(model)}


def hash_of_runtime(model: Model) -> str:
    """Of the compiled core that makes the runs, and of the Python beside it that prepares and reads them."""
    found = hashlib.sha256(Path(str(model.core.__file__)).read_bytes())
    for file in python_sources():
        found.update(file.read_bytes())
    return found.hexdigest()


def python_sources() -> list[Path]:
    """Those of the runtime, in order."""
    return sorted(Path(__file__).parents[1].rglob("*.py"))


@lru_cache(maxsize=16)
def build_here(source: Source) -> dict[str, Any]:
    """What has built the model in this process."""
    return build_of(model_of(source))


def _files(folder: Path) -> list[tuple[str, bytes]]:
    return [(file.name, file.read_bytes()) for file in sorted(folder.iterdir()) if file.is_file()]
