"""Every program of benchmarks/ runs, with its smallest sizes; where a peer is missing it says which, and is skipped."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

from ..support.folders import ROOT

BENCHMARKS = ROOT / "benchmarks"
SMALLEST = {
    "batch": "--links 6 --rounds 1",
    "build_time": "--links 6 --repeats 1",
    "cluster": "--runs 16 --chunks 8 --rounds 1",
    "drop": "--rounds 1",
    "engines": "--quick --limit 5 --cases hexagon ring",
    "ensemble": "--rounds 1 --drops 100 --flights 100",
    "flight": "--until 0.1 --rounds 1",
    "formulations": "--links 2 --limit 20 --repeats 1",
    "forward_dynamics": "--links 6 --rounds 1",
    "gradients": "--rounds 1 --directions 2 --links 6",
    "identification": "--rounds 1",
    "orbits": "--rounds 1",
    "scene_events": "--rounds 1 --throws 20",
    "shared_lanes": "--rounds 1",
    "threads": "--rounds 1",
    "walking": "--cranks 1 --rounds 1",
    "with_contacts": "--rtol 1e-6 --rounds 1 --links 3",
}
APART = {"since"}
"""It installs two commits of the repository: no matter of minutes."""
MISSING = ("is not installed", "No module named")


def programs() -> set[str]:
    """Those that are called, not imported by others."""
    return {file.stem for file in BENCHMARKS.glob("*.py") if "ArgumentParser" in file.read_text(encoding="utf-8")}


def test_every_program_is_tried() -> None:
    assert programs() - APART == set(SMALLEST)


@pytest.mark.hard
@pytest.mark.parametrize("name", SMALLEST)
def test_it_runs(name: str) -> None:
    command = [sys.executable, f"benchmarks/{name}.py", *SMALLEST[name].split()]
    done = subprocess.run(
        command, cwd=ROOT, env={**os.environ}, capture_output=True, text=True, timeout=900, check=False
    )
    said = done.stderr.strip()
    if done.returncode and any(words in said for words in MISSING):
        pytest.skip(said.splitlines()[-1])
    assert done.returncode == 0, said[-2000:]
    assert "|" in done.stdout, "no table"


def test_flights_and_drops_take_the_methods_that_choose_their_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those programs have a peer that is seldom there; this part of them needs none."""
    from ccgen.runtime import methods

    monkeypatch.syspath_prepend(str(BENCHMARKS))
    for name in ("flight", "drop"):
        module = _loaded(BENCHMARKS / f"{name}.py")
        found = {one.name.removeprefix("ccgen, ").partition(",")[0] for one in module.ours(None, None, None, 1.0)}
        assert found == set(methods(estimating=True)), name


def _loaded(file: Path):  # type: ignore[no-untyped-def]
    spec = importlib.util.spec_from_file_location(f"benchmark_{file.stem}", file)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module
