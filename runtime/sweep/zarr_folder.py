"""The table of a sweep as Zarr: an array for each column, a chunk for each part, written part by part."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

import numpy as np

from ..ensemble.observed import column_of
from ..extras import needed
from .folder import FORMAT, SweepFolder, array_of
from .plan import PlanError

GROUP = "zarr.json"
"""File of a group and of each array that says what it is."""
NAMES = re.compile(r"zarr\.json|\d+")
"""Names of the files of an array."""


def write_zarr(folder: SweepFolder, path: Path) -> None:
    """Write the whole table of a sweep as a Zarr group (format 3) at ``path``, the same bytes for the same rows.

    It is put in place once it is whole, for one that ccgen has written before. Raises :class:`PlanError` for what else
    is there, and where runs are missing; ``ImportError`` without zarr."""
    zarr, parquet = needed("zarr", "a table as Zarr"), needed("pyarrow.parquet", "a sweep")
    check_zarr(path)
    if left := len(folder.missing()):
        raise PlanError(
            f"{folder.path}: found {folder.parts - left} of {folder.parts} parts, expected all; go on with the sweep"
        )
    unfinished = path.with_name(f".{path.name}.part")
    discard_zarr(unfinished)  # of a program that was killed
    about = {key: folder.manifest[key] for key in ("model", "scene", "plan")}
    group = zarr.create_group(unfinished, zarr_format=3, attributes={"source": FORMAT, **about})
    arrays: dict[str, Any] = {}
    for part in range(folder.parts):
        table = parquet.read_table(folder.path / folder.name(part))
        for name in table.column_names:
            values = array_of(table[name])
            if name not in arrays:
                arrays[name] = _array(group, folder, name, values)
            first, last = folder.rows(part)
            arrays[name][first:last] = values
    if (at := folder.manifest["at"]) is not None:
        time = group.create_array("time", shape=(len(at),), dtype="f8", dimension_names=("time",), attributes=SECONDS)
        time[:] = np.array(at)
    discard_zarr(path)
    unfinished.rename(path)


SECONDS = {"units": "s"}


def _array(group: Any, folder: SweepFolder, name: str, values: Any) -> Any:
    """An array for a column of which some ``values`` (runs, ...) are known, with room for all."""
    texts, units = values.dtype.kind == "O", folder.manifest["units"]
    return group.create_array(
        name,
        shape=(folder.manifest["runs"], *values.shape[1:]),
        chunks=(folder.manifest["part"], *values.shape[1:]),
        dtype=str if texts else values.dtype,
        fill_value="" if texts else np.nan if values.dtype.kind == "f" else 0,
        dimension_names=dimensions(name, values),
        attributes={"units": units[name]} if name in units else {},
    )


def dimensions(name: str, values: Any) -> tuple[str, ...]:
    """What a column's values (runs,) or (runs, n) are over."""
    if values.ndim == 1:
        return ("run",)
    return ("run", "time" if column_of(name).kind == "output" else f"number of {name}")


def check_zarr(path: Path) -> None:
    """Raise :class:`PlanError` unless nothing is there, or a table that ccgen has written as Zarr and nothing else."""
    if not path.absolute().parent.is_dir():
        raise PlanError(f"{path}: found no folder {path.parent}, expected one; make it first")
    if os.path.lexists(path) and not (is_zarr_of_sweep(path) and all(map(_is_own, _files(path)))):
        raise PlanError(
            f"{path}: found what ccgen did not write, expected a table of a sweep as Zarr, or nothing; move it away or "
            "name another"
        )


def is_zarr_of_sweep(path: Path) -> bool:
    """Whether a folder is a Zarr group that says that it is of a sweep."""
    try:
        return not path.is_symlink() and f'"source": "{FORMAT}"' in (path / GROUP).read_text()
    except (OSError, UnicodeDecodeError):
        return False


def discard_zarr(path: Path) -> None:
    """Remove the files of a Zarr group, and folders that are empty then."""
    for file in _files(path):
        if _is_own(file):
            file.unlink()
    for inside in sorted((one for one in path.rglob("*") if one.is_dir()), reverse=True):
        if not any(inside.iterdir()):
            inside.rmdir()
    if path.is_dir() and not any(path.iterdir()):
        path.rmdir()


def _files(path: Path) -> list[Path]:
    return [one for one in path.rglob("*") if one.is_symlink() or not one.is_dir()]


def _is_own(file: Path) -> bool:
    return bool(NAMES.fullmatch(file.name)) and not file.is_symlink()
