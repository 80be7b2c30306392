"""The folder of a sweep: ``manifest.json`` says what its rows follow from, ``part-000000.parquet`` … hold them."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import re
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np

from ..extras import needed
from ..model.model import Model
from .plan import Plan, PlanError
from .source import build_of
from .units import units_of_table

FORMAT = "ccgen sweep 2"
"""What a manifest begins with, and what other files made of the table say that they are of."""
MANIFEST, LOCK = "manifest.json", ".lock"
ELSEWHERE = "built_elsewhere"
"""Entry of a manifest for what built the models of workers that compiled theirs themselves; no condition to go on."""
NAME = re.compile(r"^part-(\d{6})\.parquet$")
PIECE = re.compile(r"^piece-(\d{10})-(\d{10})\.arrow$")
"""File of the runs from one number to another, the last one left out."""
UNFINISHED = re.compile(r"^\..*\.part$")
SPARE = 1.1
"""Times as much room as the table takes is asked for before the first run."""


class SweepError(Exception):
    """A sweep that cannot go on, and what to do; what is done stays, and is gone on from."""


def manifest_of(model: Model, plan: Plan) -> dict[str, Any]:
    """All that rows follow from. Where any of it is other than it was, a folder is not gone on with."""
    versions = {"pyarrow": needed("pyarrow", "a sweep").__version__, "numpy": np.__version__}
    drawn = [(axis.samples.by, axis.drawn.values()) for axis in plan.axes if axis.samples is not None]
    if any(by != "random" or any(one.kind == "normal" for one in those) for by, those in drawn):
        versions["scipy"] = needed("scipy", "a quasi-random sample").__version__
    return {
        "format": FORMAT,
        "model": model.name,
        "scene": model.data["hash"],
        "parameters": _hash(json.dumps(dict(model.parameters), sort_keys=True)),
        "start": None if model._begin is None else _hash(json.dumps(model._begin)),
        **build_of(model),
        "versions": versions,
        "plan": _hash(plan.text),
        "plan_text": plan.text,
        "samples": [
            {"by": axis.samples.by, "seed": axis.samples.seed, "count": axis.size, "names": list(axis.drawn)}
            for axis in plan.axes
            if axis.samples is not None
        ],
        "tables": [_hash_of(axis.columns) for axis in plan.axes if axis.samples is None],
        "vary": list(plan.names),
        "units": units_of_table(model, plan),
        "observe": list(plan.observe),
        "at": None if plan.at is None else list(plan.at),
        "runs": plan.count,
        "part": plan.part,
    }


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _hash_of(columns: Mapping[str, Any]) -> str:
    found = hashlib.sha256()
    for name, values in columns.items():
        found.update(name.encode() + b"\0" + np.ascontiguousarray(values).tobytes())
    return found.hexdigest()


class SweepFolder:
    """The parts of a sweep on disk, each written whole or not at all."""

    def __init__(self, path: Path, manifest: Mapping[str, Any]) -> None:
        self.path, self.manifest = path, dict(manifest)
        self.parts = -(-int(manifest["runs"]) // int(manifest["part"]))

    @classmethod
    @contextmanager
    def held(cls, path: Path, manifest: Mapping[str, Any]) -> Iterator[SweepFolder]:
        """A new folder, or one that is gone on with, held by one program at a time; what others left unfinished is
        removed.

        Raises :class:`PlanError` where it holds another sweep, or what ccgen did not write, and :class:`SweepError`
        where another program is at work. Nothing is written before it is held but the lock."""
        import fcntl

        _check(path, manifest)
        try:
            path.mkdir(parents=True, exist_ok=True)
            lock = (path / LOCK).open("w")
        except OSError as error:
            raise PlanError(f"{path}: cannot be written: {error.strerror}; name another folder") from error
        with lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                raise SweepError(f"{path}: another ccgen sweep is writing here; wait for it") from None
            before = _check(path, manifest)  # again: another may have begun one since
            for one in path.iterdir():
                if UNFINISHED.match(one.name):
                    one.unlink()
            made = cls(path, manifest if before is None else before)
            if before is None:
                try:
                    made.write_manifest()
                except SweepError as error:
                    raise PlanError(str(error)) from error
            yield made

    def write_manifest(self) -> None:
        """Raises :class:`SweepError` where that cannot be done."""
        self.write(MANIFEST, (json.dumps(self.manifest, indent=1, sort_keys=True) + "\n").encode())

    def built(self, build: Mapping[str, Any]) -> None:
        """Note that rows come from a model that was built like this, where that is another way than the manifest's."""
        others = self.manifest.get(ELSEWHERE, [])
        if any(self.manifest[key] != build[key] for key in build) and build not in others:
            self.manifest[ELSEWHERE] = sorted([*others, dict(build)], key=lambda one: json.dumps(one, sort_keys=True))
            self.write_manifest()

    def name(self, part: int) -> str:
        return f"part-{part:06d}.parquet"

    def rows(self, part: int) -> tuple[int, int]:
        """First and last run of a part."""
        size = int(self.manifest["part"])
        return part * size, min((part + 1) * size, int(self.manifest["runs"]))

    def missing(self) -> list[int]:
        """Parts that are not there."""
        there = {one.name for one in self.path.iterdir()}
        return [part for part in range(self.parts) if self.name(part) not in there]

    def check_room(self, row_bytes: int) -> None:
        """Raise :class:`PlanError` where what is missing does not fit onto the disk."""
        runs = sum(last - first for first, last in map(self.rows, self.missing()))
        wanted, free = int(SPARE * runs * row_bytes), shutil.disk_usage(self.path).free
        if wanted > free:
            raise PlanError(
                f"{self.path}: found {free / 1e9:.3g} GB of room, expected {wanted / 1e9:.3g} GB for {runs} runs; name "
                "a folder elsewhere, or observe less"
            )

    def write_part(self, part: int, table: Any) -> None:
        """Write the table of a part, the same bytes for the same rows."""
        arrow, parquet = needed("pyarrow", "a sweep"), needed("pyarrow.parquet", "a sweep")
        buffer = arrow.BufferOutputStream()
        parquet.write_table(table, buffer, compression="zstd", compression_level=3)
        self.write(self.name(part), buffer.getvalue().to_pybytes())

    def write(self, name: str, content: bytes) -> None:
        """Write a file whole and put it in place, also where the machine stops at that moment. Raises
        :class:`SweepError` where it cannot be written, as on a disk that is full."""
        unfinished = self.path / f".{name}.part"
        try:
            with unfinished.open("wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            unfinished.replace(self.path / name)
            self._sync()
        except OSError as error:
            with suppress(OSError):
                unfinished.unlink(missing_ok=True)
            full = error.errno in (errno.ENOSPC, errno.EDQUOT)
            why, advice = ("the disk is full", "make room") if full else (f"{error.strerror or error}", "mend that")
            raise SweepError(
                f"{self.path}: {name} cannot be written: {why}; {advice} and start again: it goes on where it stopped"
            ) from error

    def _sync(self) -> None:
        """Have the names of the folder on disk too."""
        descriptor = os.open(self.path, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def _check(path: Path, manifest: Mapping[str, Any]) -> dict[str, Any] | None:
    """The manifest of the sweep that is there, None where there is none. Raises :class:`PlanError` for another sweep,
    and for what ccgen did not write."""
    if path.exists() and not path.is_dir():
        raise PlanError(f"{path}: found a file, expected a folder, or nothing; name another")
    if (path / MANIFEST).exists():
        before = read_manifest(path)
        changed = [key for key in manifest if before.get(key) != manifest[key] and key != "plan_text"]
        if changed:
            raise PlanError(
                f"{path}: found a sweep with another {', '.join(changed)}, expected the same to go on with; name "
                "another folder, or move this one away"
            )
        return before
    if path.exists() and any(not UNFINISHED.match(one.name) and one.name != LOCK for one in path.iterdir()):
        raise PlanError(f"{path}: found files and no {MANIFEST}, expected a sweep or an empty folder; name another")
    return None


def table_of(columns: Mapping[str, Any], units: Mapping[str, str]) -> Any:
    """A table of Arrow of columns by name; a column that has a unit says so in its field's metadata."""
    arrow = needed("pyarrow", "a sweep")
    arrays = {name: _array(arrow, values) for name, values in columns.items()}
    fields = [
        arrow.field(name, one.type, metadata={"unit": units[name]} if name in units else None)
        for name, one in arrays.items()
    ]
    return arrow.table(list(arrays.values()), schema=arrow.schema(fields))


def _array(arrow: Any, values: Any) -> Any:
    """A column of Arrow; of several numbers a row, a list of fixed length."""
    if isinstance(values, list):
        return arrow.array(values, type=arrow.string())
    if values.dtype.kind == "U":
        return arrow.array(values.tolist(), type=arrow.string())
    if values.dtype.kind == "f":
        values = values.astype(float)
    if values.ndim == 2:
        flat = arrow.array(np.ascontiguousarray(values).ravel())
        return arrow.FixedSizeListArray.from_arrays(flat, values.shape[1])
    return arrow.array(values)


def array_of(column: Any) -> Any:
    """What a column of an Arrow table holds: (runs,), or (runs, n) of a list; texts as objects."""
    column = column.combine_chunks()
    if str(column.type).startswith("fixed_size_list"):
        return np.asarray(column.flatten()).reshape(len(column), -1)
    return np.asarray(column.to_numpy(zero_copy_only=False))


def is_of_sweep(name: str) -> bool:
    """Whether a file of this name in the folder of a sweep is the sweep's own."""
    return name in (MANIFEST, LOCK) or any(kind.match(name) for kind in (NAME, PIECE, UNFINISHED))


def read_manifest(path: Path) -> dict[str, Any]:
    """Raises :class:`PlanError` where a folder has none, or one that cannot be read."""
    try:
        found = json.loads((path / MANIFEST).read_text())
        if isinstance(found, dict) and found.get("format") == FORMAT:
            return found
    except FileNotFoundError:
        raise PlanError(f"{path}: found no {MANIFEST}, expected the folder of a sweep; correct the name") from None
    except (OSError, ValueError):
        pass
    raise PlanError(f"{path / MANIFEST}: found no manifest of a sweep, expected one; it is damaged")
