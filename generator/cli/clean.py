"""Removes what ccgen wrote into folders and says what stays: ``python -m ccgen.generator.cli.clean``, for make."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from ..package.parts import discard, is_package
from .folders import forget_results, is_picture


def clean(folder: Path) -> list[Path]:
    """Remove packages, results and then empty folders at and below ``folder``; returns what stays."""
    from ccgen.runtime.sweep.results import is_netcdf_of_sweep
    from ccgen.runtime.sweep.zarr_folder import discard_zarr, is_zarr_of_sweep

    if is_netcdf_of_sweep(folder):
        folder.unlink()
    if folder.is_symlink() or not folder.is_dir():
        return [folder] if os.path.lexists(folder) else []
    if is_package(folder):
        discard(folder)
    elif is_zarr_of_sweep(folder):
        discard_zarr(folder)
    else:
        forget_results(folder)
        forget_sweep(folder)
    if not folder.exists():
        return []
    left = [path for inside in sorted(folder.iterdir()) for path in clean(inside)]
    if not left:
        folder.rmdir()
    return left


def forget_sweep(folder: Path) -> None:
    """Remove what a sweep has written into ``folder``; nothing where no manifest of one can be read.

    Its files are told by their names, its chart by what that says itself."""
    from ccgen.runtime.sweep.chart import CHART
    from ccgen.runtime.sweep.folder import MANIFEST, is_of_sweep, read_manifest
    from ccgen.runtime.sweep.plan import PlanError

    try:
        read_manifest(folder)
    except PlanError:
        return
    files = [file for file in folder.iterdir() if file.is_file() and not file.is_symlink()]
    for file in files:
        own = is_of_sweep(file.name) or (file.name == CHART and is_picture(file))
        if own and file.name != MANIFEST:
            file.unlink()
    (folder / MANIFEST).unlink()  # the last: a sweep whose removal was stopped can still be told


if __name__ == "__main__":
    for path in [path for name in sys.argv[1:] for path in clean(Path(name))]:
        print(f"left: {path}, which ccgen did not write")
