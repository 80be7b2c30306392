"""Engines that are installed fly and strike in the motions in which they are compared."""

from __future__ import annotations

import csv
import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

from ..support.folders import ROOT

pytestmark = pytest.mark.hard
ENGINES = ("mujoco", "pymunk", "exudyn", "pydrake")
CASES = ("hexagon", "drop", "ring", "four-bar", "machine")


@pytest.mark.skipif(
    not any(importlib.util.find_spec(name) for name in ENGINES),
    reason="no engine is installed; pip install 'ccgen[engines]'",
)
def test_engines_run_quickly(tmp_path: Path) -> None:
    """Errors shrink with the step where nothing strikes; ccgen at its tightest is better than any of them."""
    path = tmp_path / "rows.csv"
    done = subprocess.run(
        [sys.executable, str(ROOT / "benchmarks" / "engines.py"), "--quick", "--csv", str(path)],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "left out: " in done.stdout
    rows = list(csv.DictReader(path.open(newline="")))
    assert {row["case"] for row in rows} == set(CASES)
    for case in CASES:
        own = [row for row in rows if row["case"] == case]
        best = min(float(row["error"]) for row in own if row["tool"].startswith("ccgen"))
        others = [row for row in own if not row["tool"].startswith("ccgen")]
        assert others
        assert best < min(float(row["error"]) for row in others)
    for tool in {row["tool"] for row in rows if row["case"] == "ring"}:
        errors = [float(row["error"]) for row in rows if (row["case"], row["tool"]) == ("ring", tool)]
        assert errors[-1] < errors[0], tool
