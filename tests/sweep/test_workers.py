"""Workers of executors: those that die are told from runs that fail, and no run is lost or made twice in the table."""

from __future__ import annotations

import functools
import importlib
import json
import math
import multiprocessing
import sys
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.generator import rebuild
from ccgen.runtime import Model, load_model
from ccgen.runtime.sweep import chunk as chunk_module
from ccgen.runtime.sweep import collected as collected_module
from ccgen.runtime.sweep import elsewhere as elsewhere_module
from ccgen.runtime.sweep.folder import SweepError
from ccgen.runtime.sweep.results import Results
from ccgen.runtime.sweep.source import build_of, model_of, source_of
from ccgen.runtime.sweep.sweep import sweep

from ..support.sweep_scene import content
from ..support.workshop import Workshop

SPAWN = multiprocessing.get_context("spawn")


class Dying(ThreadPoolExecutor):
    """An executor whose workers are gone with the third chunk and those behind it, some times."""

    def __init__(self, times: int) -> None:
        super().__init__(1)
        self.sent, self.times = 0, times

    def submit(self, call: Any, /, *given: Any, **named: Any) -> Any:
        self.sent += 1
        if self.sent >= 3 and self.times > 0:
            self.times -= 1
            return super().submit(self._die)
        return super().submit(call, *given, **named)

    def _die(self) -> None:
        raise ConnectionResetError("the worker is gone")


def test_chunks_of_workers_that_die_are_sent_again(model: Model, plan: Path, whole: Path, tmp_path: Path) -> None:
    with Dying(3) as executor:
        sweep(model, plan, tmp_path / "out", executor=executor, chunk=10)
    assert content(tmp_path / "out") == content(whole)
    with Dying(1000) as executor, pytest.raises(SweepError, match=r"workers died 4 times with the runs .* goes on"):
        sweep(model, plan, tmp_path / "other", executor=executor, chunk=10)
    sweep(model, plan, tmp_path / "other")
    assert content(tmp_path / "other") == content(whole)


def test_faults_of_the_work_are_no_deaths(model: Model, plan: Path, tmp_path: Path, monkeypatch: Any) -> None:
    def wrong(*given: Any) -> Any:
        raise ZeroDivisionError("a fault of ccgen")

    monkeypatch.setattr(elsewhere_module, "make_elsewhere", wrong)
    with ThreadPoolExecutor(1) as executor, pytest.raises(ZeroDivisionError):
        sweep(model, plan, tmp_path / "out", executor=executor)


KILLING = """
import os, signal
from ccgen.runtime.sweep.chunk import make_elsewhere as make

def kill_once(mark, first, source, chunk, threads):
    if chunk.first <= first < chunk.last:
        try:
            os.close(os.open(mark, os.O_CREAT | os.O_EXCL))
        except FileExistsError:
            pass
        else:
            os.kill(os.getpid(), signal.SIGKILL)
    return make(source, chunk, threads)
"""
"""A chunk whose worker is killed the first time that it has the run ``first``; a module that workers can import."""


@pytest.fixture
def killed_once(tmp_path: Path, monkeypatch: Any) -> Path:
    (tmp_path / "ccgen_test_killing.py").write_text(KILLING)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    sys.modules.pop("ccgen_test_killing", None)
    kill_once = importlib.import_module("ccgen_test_killing").kill_once
    mark = tmp_path / "mark"
    monkeypatch.setattr(elsewhere_module, "make_elsewhere", functools.partial(kill_once, str(mark), 55))
    return mark


def test_a_process_that_is_killed(model: Model, plan: Path, whole: Path, tmp_path: Path, killed_once: Path) -> None:
    """It takes its executor with it: a function makes another one."""

    def another() -> Executor:
        return ProcessPoolExecutor(2, mp_context=SPAWN)

    sweep(model, plan, tmp_path / "out", executor=another, chunk=7)
    assert killed_once.exists() and content(tmp_path / "out") == content(whole)


def test_an_executor_that_breaks_is_told(
    model: Model, plan: Path, whole: Path, tmp_path: Path, killed_once: Path
) -> None:
    with (
        ProcessPoolExecutor(1, mp_context=SPAWN) as executor,
        pytest.raises(SweepError, match=r"a worker of the executor died.*goes on with what is done"),
    ):
        sweep(model, plan, tmp_path / "out", executor=executor, chunk=7)
    assert list((tmp_path / "out").glob("piece-*.arrow"))  # all that was back is kept
    told: list[int] = []
    with ProcessPoolExecutor(1, mp_context=SPAWN) as executor:
        sweep(model, plan, tmp_path / "out", executor=executor, progress=lambda done, _: told.append(done))
    assert told[0] >= 40 and told[-1] == 99
    assert content(tmp_path / "out") == content(whole)


def test_what_built_the_models_of_workers_is_noted(
    model: Model, plan: Path, whole: Path, tmp_path: Path, monkeypatch: Any
) -> None:
    """Each way that is not the manifest's own, once; the sweep is gone on with all the same."""
    own = build_of(model)
    ways = [own, own | {"flags": ["-O3"]}, own | {"compiler": "another 1.0"}, own | {"flags": ["-O3"]}]
    monkeypatch.setattr(chunk_module, "build_here", lambda source: ways.pop() if ways else own)

    def stop(done: int, count: int) -> None:
        if done >= 50:
            raise KeyboardInterrupt

    with ThreadPoolExecutor(1) as executor, pytest.raises(KeyboardInterrupt):
        sweep(model, plan, tmp_path / "out", executor=executor, chunk=10, progress=stop)
    sweep(model, plan, tmp_path / "out")
    manifest = Results(tmp_path / "out").manifest
    noted = manifest.pop("built_elsewhere")
    assert len(noted) == 2 and own | {"compiler": "another 1.0"} in noted and own | {"flags": ["-O3"]} in noted
    assert manifest == Results(whole).manifest
    assert {key: manifest[key] for key in own} == own


@pytest.mark.hard
def test_dask_with_a_worker_that_is_killed(
    model: Model, plan: Path, whole: Path, tmp_path: Path, killed_once: Path
) -> None:
    """Two worker processes, of which one is killed while it works."""
    distributed = pytest.importorskip("distributed")
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None)
    with cluster, distributed.Client(cluster) as client:
        sweep(model, plan, tmp_path / "out", executor=client, chunk=10)
    assert killed_once.exists() and content(tmp_path / "out") == content(whole)


def test_pieces_are_taken_up_by_other_chunks(
    model: Model, plan: Path, whole: Path, tmp_path: Path, monkeypatch: Any
) -> None:
    """Ctrl-C within a part keeps what is done of it, in one piece if none is due; what goes on cuts it anew."""
    monkeypatch.setattr(collected_module, "EVERY", math.inf)

    def stop(done: int, count: int) -> None:
        if done >= 57:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(model, plan, tmp_path / "out", chunk=3, progress=stop)
    assert [file.name for file in Results(tmp_path / "out").files] == ["part-000000.parquet"]
    assert [file.name for file in (tmp_path / "out").glob("piece*")] == ["piece-0000000040-0000000058.arrow"]
    told: list[int] = []
    sweep(model, plan, tmp_path / "out", chunk=5, progress=lambda done, _: told.append(done))
    assert told[0] == 58 and content(tmp_path / "out") == content(whole)


def test_workers_without_the_package_compile_it(
    model: Model, plan: Path, whole: Path, tmp_path: Path, monkeypatch: Any
) -> None:
    """As on a machine whose processor lacks what the model was compiled for, or that does not see its folder."""
    assert model.folder is not None
    source = source_of(model, rebuild).with_files()
    record = json.loads((model.folder / "build.json").read_text())
    monkeypatch.setattr(type(source), "__hash__", object.__hash__)  # no model of an earlier test

    def gone(folder: Path, *given: Any) -> Model:
        if folder == model.folder:
            raise ImportError("it was compiled for a processor with avx512f, which this one has not")
        return reopen(folder, *given)

    from ccgen.runtime.sweep import source as source_module

    reopen = source_module.reopen
    made = rebuild({name: dict(files) for name, files in source.files}, model.folder.name)
    assert made != model.folder and load_model(made).data == model.data
    again = json.loads((made / "build.json").read_text())
    assert again["parts"]["model.c"] == record["parts"]["model.c"] and again["flags"] == record["flags"]
    model_of.cache_clear()
    monkeypatch.setattr(source_module, "reopen", gone)
    with (
        ThreadPoolExecutor(1) as executor,
        pytest.raises(SweepError, match=r"a worker cannot load the model: .*avx512f"),
    ):
        sweep(model, plan, tmp_path / "none", executor=executor)
    with ThreadPoolExecutor(2) as executor:
        monkeypatch.setattr(
            source_module.Source, "with_files", lambda self: source_module.replace(self, files=source.files)
        )
        sweep(model, plan, tmp_path / "out", executor=executor, rebuild=rebuild)
    model_of.cache_clear()
    assert content(tmp_path / "out") == content(whole)


def test_derivatives_are_compiled_again(workshop: Workshop) -> None:
    """A package that was asked for with derivatives has them where it is rebuilt too."""
    text = 'name = "pendulum"\n[chain]\nlinks = 1\nhinged = true\n[gravity]\ng = 9.81\n[run]\nuntil = 1.0\n'
    model = workshop.model(text, derivatives=True)
    source = source_of(model, rebuild).with_files()
    made = load_model(rebuild({name: dict(files) for name, files in source.files}, model.folder.name))
    assert made.folder != model.folder
    q = np.array([0.3])
    found = made.derivatives("acceleration", q, np.zeros(1), wrt="q")
    assert np.array_equal(found, model.derivatives("acceleration", q, np.zeros(1), wrt="q"))
    assert found.ravel() == pytest.approx(1.5 * 9.81 * math.sin(0.3), rel=1e-12)  # of -3/2 g cos(q), a rod of 1 m
