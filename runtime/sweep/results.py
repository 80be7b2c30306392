"""The table of a sweep, read from its folder; any of its runs made again."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ..extras import needed
from ..model.model import Model
from ..run import Run
from ..simulate import simulate
from .folder import MANIFEST, SweepFolder, manifest_of, read_manifest
from .plan import Plan, PlanError
from .starts import start_names, starts_of

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
        """The table as one of pandas."""
        needed("pandas", "a table of runs")
        return self.to_arrow().to_pandas()

    def column(self, name: str) -> Any:
        """One column (runs,), or (runs, times). Raises ``KeyError`` for one that is none."""
        known = needed("pyarrow.parquet", "a sweep").read_schema(self.files[0]).names if self.files else []
        if name not in known:
            raise KeyError(f"{name}: found no such column, expected one of {', '.join(known)}")
        column = self.to_arrow([name])[name].combine_chunks()
        if hasattr(column, "flatten") and str(column.type).startswith("fixed_size_list"):
            return np.asarray(column.flatten()).reshape(len(column), -1)
        return np.asarray(column.to_numpy(zero_copy_only=False))

    def to_xarray(self) -> Any:
        """The table as an xarray dataset: columns over ``run``, those at several times over ``time`` (s) too."""
        xarray = needed("xarray", "trajectories")
        at = self.manifest["at"]
        found: dict[str, Any] = {}
        names = needed("pyarrow.parquet", "a sweep").read_schema(self.files[0]).names if self.files else []
        for name in names:
            values = self.column(name)
            over = "time" if name not in ("q", "u") and not name.startswith("impact_times(") else f"number of {name}"
            dims = ("run",) if values.ndim == 1 else ("run", over)
            found[name] = (dims, values.astype(str) if values.dtype.kind == "O" else values)
        run = found.pop("run")
        coords: dict[str, Any] = {"run": run} | ({"time": np.array(at)} if at is not None else {})
        return xarray.Dataset(found, coords)

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
