"""A sweep's files are the same bytes however its runs are made, and wherever it was killed."""

from __future__ import annotations

import errno
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import Model, simulate
from ccgen.runtime.sweep import folder as folder_module
from ccgen.runtime.sweep.folder import SweepError
from ccgen.runtime.sweep.plan import PlanError, read_plan
from ccgen.runtime.sweep.results import Results
from ccgen.runtime.sweep.sweep import sweep

from ..support.sweep_scene import PLAN, PROGRAM, content
from ..support.tiers import all_hard_but


def test_rows_are_the_plans_runs(model: Model, plan: Path, whole: Path) -> None:
    results, read = Results(whole), read_plan(plan, model)
    table = results.to_dataframe()
    assert list(table["run"]) == list(range(read.count)) == list(range(99))
    assert dict(table["status"].value_counts()) == {"done": 66, "refused": 33}
    assert all(
        ("inside ground_0" in reason) == (status == "refused")
        for reason, status in zip(table["reason"], table["status"], strict=True)
    )
    for run in (4, 50, 97):
        row = table.iloc[run]
        params = {name: row[name] for name in ("ground_0.restitution", "gravity.g")}
        q, _ = model.start()
        q[1] = row["link_0.y(0)"]
        alone = simulate(model, q, params=params, until=0.9)
        assert row["impacts"] == len(alone.impacts)
        assert row["max(joint_1.force)"] == pytest.approx(
            alone.values("joint_1.force", t=[0, 0.45, 0.9])["joint_1.force"].max(), rel=1e-12
        )
        again = results.run(model, read, run)
        assert row["joint_0.y"].tolist() == again.values("joint_0.y", t=[0, 0.45, 0.9])["joint_0.y"].tolist()
        assert np.abs(again.q[-1] - alone.q[-1]).max() <= 1e-9
    assert results.column("joint_0.y").shape == (99, 3)
    assert results.to_xarray()["joint_0.y"].dims == ("run", "time")


@pytest.mark.sample(2)
@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("chunk", [1, 7, 1000])
def test_threads_and_chunks_leave_no_trace(
    model: Model, plan: Path, whole: Path, tmp_path: Path, threads: int, chunk: int
) -> None:
    sweep(model, plan, tmp_path / "out", threads=threads, chunk=chunk)
    assert content(tmp_path / "out") == content(whole)


@pytest.mark.sample(1)
@pytest.mark.parametrize("instant", all_hard_but(0, 1, 2, of=range(20)))
def test_killed_and_gone_on_with(model: Model, plan: Path, whole: Path, tmp_path: Path, instant: int) -> None:
    """Killed at some instant of its time, several times, and started again."""
    rng = np.random.default_rng(instant)
    command = [sys.executable, "-c", PROGRAM, str(model.folder), str(plan), str(tmp_path / "out")]
    for _ in range(2):
        running = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(rng.uniform(0.3, 1.5))
        running.send_signal(signal.SIGKILL)
        running.wait()
    sweep(model, plan, tmp_path / "out")
    assert content(tmp_path / "out") == content(whole)


def test_executors(model: Model, plan: Path, whole: Path, tmp_path: Path) -> None:
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as executor:
        sweep(model, plan, tmp_path / "processes", executor=executor)
    with ThreadPoolExecutor(2) as threads:
        sweep(model, plan, tmp_path / "threads", executor=threads, chunk=5)
    assert content(tmp_path / "processes") == content(tmp_path / "threads") == content(whole)


def test_another_sweep_is_not_mixed_in(model: Model, plan: Path, tmp_path: Path) -> None:
    sweep(model, plan, tmp_path / "out")
    before = content(tmp_path / "out")
    other = tmp_path / "other.toml"
    other.write_text(PLAN.replace("12.0]", "13.0]"))
    with pytest.raises(PlanError, match="found a sweep with another plan, tables, expected the same to go on with"):
        sweep(model, other, tmp_path / "out")
    with pytest.raises(PlanError, match="found a sweep with another parameters, expected"):
        sweep(model.with_parameters({"link_0.mass": 2.0}), plan, tmp_path / "out")
    assert content(tmp_path / "out") == before
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("mine")
    with pytest.raises(PlanError, match=r"found files and no manifest.json, expected a sweep or an empty folder"):
        sweep(model, plan, tmp_path / "mine")
    with pytest.raises(PlanError, match=r"found no manifest.json, expected the folder of a sweep"):
        Results(tmp_path / "mine")


def test_a_full_disk_is_told_and_gone_on_with(
    model: Model, plan: Path, whole: Path, tmp_path: Path, monkeypatch: Any
) -> None:
    written = []

    def full(descriptor: int) -> None:
        written.append(descriptor)
        if len(written) == 5:  # the manifest and one part are there, and their names
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(folder_module.os, "fsync", full)
    with pytest.raises(SweepError, match=r"part-000001.parquet cannot be written: the disk is full; make room"):
        sweep(model, plan, tmp_path / "out")
    assert [name for name in content(tmp_path / "out") if name.endswith("parquet")] == ["part-000000.parquet"]
    monkeypatch.undo()
    sweep(model, plan, tmp_path / "out")
    assert content(tmp_path / "out") == content(whole)


def test_too_little_room_is_told_before(model: Model, plan: Path, tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.setattr(folder_module.shutil, "disk_usage", lambda path: os.terminal_size((10, 10)) and _Usage())
    with pytest.raises(PlanError, match=r"found 1e-06 GB of room, expected .* GB for 99 runs"):
        sweep(model, plan, tmp_path / "out")
    assert [name for name in content(tmp_path / "out") if name.endswith("parquet")] == []


class _Usage:
    free = 1000


def test_one_program_at_a_time(model: Model, plan: Path, tmp_path: Path) -> None:
    import fcntl

    (tmp_path / "out").mkdir()
    with (tmp_path / "out" / ".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        with pytest.raises(SweepError, match="another ccgen sweep is writing here"):
            sweep(model, plan, tmp_path / "out")
    assert list(content(tmp_path / "out")) == [".lock"]  # nothing is written where another may be writing
