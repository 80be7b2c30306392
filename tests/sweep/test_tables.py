"""The table of a sweep in other forms: units of its columns, NetCDF and Zarr, which are the same bytes however its runs
were made."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow.parquet
import pytest
import xarray

from ccgen.runtime import Model
from ccgen.runtime.sweep.plan import PlanError
from ccgen.runtime.sweep.results import Results
from ccgen.runtime.sweep.sweep import sweep

UNITS = {
    "ground_0.restitution": "SI",
    "link_0.y(0)": "m",
    "gravity.g": "SI",
    "t": "s",
    "steps": "1",
    "impacts": "1",
    "joint_0.y": "m",
    "impact_times(2)": "s",
    "max(joint_1.force)": "N",
}


def files(folder: Path) -> dict[str, bytes]:
    """All files of a folder and those in it, by their paths."""
    return {str(one.relative_to(folder)): one.read_bytes() for one in folder.rglob("*") if one.is_file()}


def test_units_of_columns(whole: Path) -> None:
    """In the manifest, in the fields of each Parquet file, and in what is read from them."""
    results = Results(whole)
    assert results.manifest["units"] == UNITS == results.to_dataframe().attrs["units"]
    for file in results.files:
        schema = pyarrow.parquet.read_schema(file)
        found = {field.name: field.metadata[b"unit"].decode() for field in schema if field.metadata}
        assert found == UNITS
    table = results.to_xarray()
    assert {name: table[name].attrs["units"] for name in table if "units" in table[name].attrs} == UNITS
    assert table["time"].attrs == {"units": "s"}


def test_units_of_coordinates(model: Model, tmp_path: Path) -> None:
    tables = {"observe": ["q", "u", "link_0.angle"], "run": {"until": 0.1}}
    vary = [{"start": "link_0.angular_velocity", "values": [0.0, 1.0]}]
    found = sweep(model, {**tables, "vary": vary}, tmp_path / "out").manifest["units"]
    assert found["q"] == "m, m" + 6 * ", rad" and found["u"] == "m/s, m/s" + 6 * ", rad/s"
    assert found["link_0.angle"] == "rad" and found["link_0.angular_velocity(0)"] == "rad/s"


def test_dimensions(whole: Path) -> None:
    """What is read at times is over time; lists of another kind have a dimension of their own."""
    table = Results(whole).to_xarray()
    assert dict(table.sizes) == {"run": 99, "time": 3, "number of impact_times(2)": 2}
    assert table["joint_0.y"].dims == ("run", "time") and table["max(joint_1.force)"].dims == ("run",)
    assert table["impact_times(2)"].dims == ("run", "number of impact_times(2)")
    assert table["time"].values.tolist() == [0.0, 0.45, 0.9]


def test_dimensions_of_coordinates(model: Model, tmp_path: Path) -> None:
    """As many coordinates as times: they are not over time."""
    vary = [{"parameter": "gravity.g", "values": [5.0, 9.81]}]
    tables = {"observe": ["q", "joint_0.y"], "times": 8, "run": {"until": 0.1}, "vary": vary}
    table = sweep(model, tables, tmp_path / "out").to_xarray()
    assert table["q"].dims == ("run", "number of q") and table["joint_0.y"].dims == ("run", "time")


@pytest.mark.sample(2)
@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("chunk", [7, 1000])
def test_zarr_and_netcdf_are_the_same_bytes(
    model: Model, plan: Path, whole: Path, tmp_path: Path, threads: int, chunk: int
) -> None:
    """However runs were made and the sweep was stopped, and what is in them is the table."""

    def stop(done: int, count: int) -> None:
        if done >= 50:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(model, plan, tmp_path / "out", threads=threads, chunk=chunk, progress=stop)
    if chunk < 50:
        with pytest.raises(PlanError, match=r"found 1 of 3 parts, expected all; go on with the sweep"):
            Results(tmp_path / "out").to_zarr(tmp_path / "a.zarr")
        assert not (tmp_path / "a.zarr").exists()
    mine = sweep(model, plan, tmp_path / "out", threads=threads, chunk=chunk)
    for results, name in ((mine, "a"), (Results(whole), "b"), (mine, "a")):  # the last one in place of the first
        results.to_zarr(tmp_path / f"{name}.zarr")
        results.to_netcdf(tmp_path / f"{name}.nc")
    assert files(tmp_path / "a.zarr") == files(tmp_path / "b.zarr")
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()
    assert {one.name for one in tmp_path.iterdir()} == {"out", "a.zarr", "b.zarr", "a.nc", "b.nc"}
    wanted = mine.to_xarray()
    with xarray.open_zarr(tmp_path / "a.zarr", consolidated=False, chunks=None) as found:
        assert found.attrs == wanted.attrs and dict(found.sizes) == dict(wanted.sizes)
        for name in wanted.variables:
            assert found[name].dims == wanted[name].dims and found[name].attrs == wanted[name].attrs
            assert found[name].values.astype(wanted[name].dtype).tolist() == wanted[name].values.tolist() or (
                np.array_equal(found[name].values, wanted[name].values, equal_nan=True)
            )
        assert found["joint_0.y"].encoding["chunks"] == (40, 3)
    with xarray.open_dataset(tmp_path / "a.nc", engine="scipy") as other:
        assert np.array_equal(other["joint_0.y"].values, wanted["joint_0.y"].values, equal_nan=True)


def test_what_others_wrote_stays(whole: Path, tmp_path: Path) -> None:
    results = Results(whole)
    (tmp_path / "mine.nc").write_text("mine")
    (tmp_path / "mine.zarr").mkdir()
    with pytest.raises(PlanError, match=r"mine.nc: found what ccgen did not write, expected a table of a sweep"):
        results.to_netcdf(tmp_path / "mine.nc")
    with pytest.raises(PlanError, match=r"mine.zarr: found what ccgen did not write, expected a table of a sweep"):
        results.to_zarr(tmp_path / "mine.zarr")
    results.to_zarr(tmp_path / "table.zarr")
    (tmp_path / "table.zarr" / "notes.txt").write_text("mine")
    with pytest.raises(PlanError, match=r"table.zarr: found what ccgen did not write"):
        results.to_zarr(tmp_path / "table.zarr")
    assert (tmp_path / "table.zarr" / "notes.txt").read_text() == "mine"
    with pytest.raises(PlanError, match=r"nowhere.t.zarr: found no folder .*nowhere, expected one; make it first"):
        results.to_zarr(tmp_path / "nowhere" / "t.zarr")


def test_what_a_killed_zarr_left_is_replaced(whole: Path, tmp_path: Path) -> None:
    results = Results(whole)
    results.to_zarr(tmp_path / "t.zarr")
    before = files(tmp_path / "t.zarr")
    (tmp_path / "t.zarr").rename(tmp_path / ".t.zarr.part")
    next((tmp_path / ".t.zarr.part").glob("*/c/0/0")).unlink()
    results.to_zarr(tmp_path / "t.zarr")
    assert files(tmp_path / "t.zarr") == before and len(list(tmp_path.iterdir())) == 1
