"""The table of a sweep, read from its folder; any of its runs made again."""

from __future__ import annotations

import os
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ..extras import needed
from ..files import read_path, write_whole
from ..model.model import Model
from ..run import Run
from ..simulate import simulate
from .folder import FORMAT, MANIFEST, SweepFolder, array_of, manifest_of, read_manifest
from .plan import Plan, PlanError
from .starts import start_names, starts_of
from .zarr_folder import dimensions, write_zarr

SAME = ("scene", "plan", "parameters", "tables", "samples", "versions")
"""Entries of the manifest by which a run is the same again."""


class Results:
    """What a folder of a sweep holds so far. Raises :class:`~.plan.PlanError` for a folder of none."""

    def __init__(self, path: str | PathLike[str]) -> None:
        self.path = Path(path)
        self.manifest = read_manifest(self.path)
        self.folder = SweepFolder(self.path, self.manifest)

    def __repr__(self) -> str:
        left = len(self.folder.missing())
        parts = f"{self.folder.parts - left} of {self.folder.parts} parts" if left else "whole"
        return f"<Results of {self.manifest['runs']} runs of {self.manifest['model']} in {self.path}: {parts}>"

    @property
    def files(self) -> list[Path]:
        """The Parquet files that are there, in order."""
        there = set(range(self.folder.parts)) - set(self.folder.missing())
        return [self.path / self.folder.name(part) for part in sorted(there)]

    def to_arrow(self, columns: list[str] | None = None) -> Any:
        """The table as one of pyarrow."""
        parquet, arrow = needed("pyarrow.parquet", "a sweep"), needed("pyarrow", "a sweep")
        if not self.files:
            raise PlanError(f"{self.path}: found no runs that are done, expected some; start the sweep again")
        return arrow.concat_tables([parquet.read_table(file, columns=columns) for file in self.files])

    def to_dataframe(self) -> Any:
        """The table as one of pandas; `attrs["units"]` has the unit of every column that has one."""
        needed("pandas", "a table of runs")
        frame = self.to_arrow().to_pandas()
        frame.attrs["units"] = dict(self.manifest["units"])
        return frame

    def column(self, name: str) -> Any:
        """One column (runs,), or (runs, times). Raises ``KeyError`` for one that is none."""
        known = needed("pyarrow.parquet", "a sweep").read_schema(self.files[0]).names if self.files else []
        if name not in known:
            raise KeyError(f"{name}: found no such column, expected one of {', '.join(known)}")
        return array_of(self.to_arrow([name])[name])

    def to_xarray(self) -> Any:
        """The table as an xarray dataset: columns over ``run``, those at several times over ``time`` (s) too."""
        xarray = needed("xarray", "trajectories")
        at = self.manifest["at"]
        found: dict[str, Any] = {}
        names = needed("pyarrow.parquet", "a sweep").read_schema(self.files[0]).names if self.files else []
        for name in names:
            values = self.column(name)
            units = {"units": self.manifest["units"][name]} if name in self.manifest["units"] else {}
            found[name] = (dimensions(name, values), values.astype(str) if values.dtype.kind == "O" else values, units)
        run = found.pop("run")
        coords: dict[str, Any] = {"run": run} | (
            {"time": ("time", np.array(at), {"units": "s"})} if at is not None else {}
        )
        about = {key: self.manifest[key] for key in ("model", "scene", "plan")}
        return xarray.Dataset(found, coords, {"source": FORMAT, **about})

    def to_netcdf(self, path: str | PathLike[str]) -> None:
        """Write the table as NetCDF. Raises :class:`~.plan.PlanError` where another file is, ``FileNotFoundError``
        where there is no folder for it."""
        target = read_path(path, "a NetCDF file")
        check_netcdf(target)
        table = self.to_xarray()
        write_whole(target, lambda file: file.write(bytes(table.to_netcdf(engine="scipy"))))

    def to_zarr(self, path: str | PathLike[str]) -> None:
        """Write the table as a Zarr group, part by part, so that it need not fit into memory; xarray opens it as
        :meth:`to_xarray` has it. Raises :class:`~.plan.PlanError` where runs are missing, or another file or folder
        is."""
        write_zarr(self.folder, read_path(path, "a Zarr group"))

    def run(self, model: Model, plan: Plan, number: int) -> Run:
        """One of the runs again, whole, by ``simulate``. Raises ``ValueError`` for a number that is none, for another
        model or plan, and for a run that was refused."""
        if not 0 <= number < plan.count:
            raise ValueError(f"run: found {number}, expected a number from 0 to {plan.count - 1}")
        now = manifest_of(model, plan)
        if changed := [key for key in SAME if now[key] != self.manifest[key]]:
            raise PlanError(f"{self.path / MANIFEST}: found another {', '.join(changed)} than is given; give the same")
        numbers = plan.rows(number, number + 1)
        starts = start_names(model)
        params = {name: values for name, values in numbers.items() if name not in starts}
        q, u, faults = starts_of(model, params, {k: v for k, v in numbers.items() if k in starts})
        if faults:
            raise ValueError(f"run {number}: {faults[0]}")
        found: Run = simulate(
            model,
            None if q is None else q[0],
            None if u is None else u[0],
            params={name: values[0].item() for name, values in params.items()},
            **plan.run,
        )
        return found


HEADER = 10_000
"""Bytes from the beginning of a NetCDF file in which it says what it is of: behind its dimensions."""


def check_netcdf(path: Path) -> None:
    """Raise :class:`~.plan.PlanError` unless nothing is at ``path``, or the NetCDF file of a sweep, in a folder that
    there is."""
    if not path.absolute().parent.is_dir():
        raise PlanError(f"{path}: found no folder {path.parent}, expected one; make it first")
    if os.path.lexists(path) and not is_netcdf_of_sweep(path):
        raise PlanError(
            f"{path}: found what ccgen did not write, expected a table of a sweep as NetCDF, or nothing; move it away "
            "or name another"
        )


def is_netcdf_of_sweep(path: Path) -> bool:
    """Whether a file is a NetCDF file that says that it is of a sweep."""
    try:
        with path.open("rb") as file:
            begin = file.read(HEADER)
    except OSError:
        return False
    return not path.is_symlink() and begin.startswith(b"CDF") and FORMAT.encode() in begin
