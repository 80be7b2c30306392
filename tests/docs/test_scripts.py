"""The scripts behind the figures of the documentation and the benchmarks run, small where they can be."""

from __future__ import annotations

import importlib
import importlib.util
import re
import subprocess
import sys
from pathlib import Path

import pytest

from ccgen.generator import loop
from ccgen.generator.pipeline import derive_scene, plan_scene
from ccgen.generator.planning.choose import DYADS, TIP_TO_ROOT
from ccgen.generator.program.program import lower

from ..support.folders import ROOT
from ..support.tiers import all_hard_but

FOLDERS = (ROOT / "docs" / "scripts", ROOT / "benchmarks")
OTHERS = ("casadi", "heyoka", "matplotlib")
"""Packages that not every machine has."""

SMALL = {
    "docs/scripts/near_chains.py": ("--links 12 --seeds 1 --tries 2", r"\| 12 \| 1 \| \d+ \|"),
    "docs/scripts/counts.py": (
        "--links 4 --long 25 --cells 1 --depths 1 --cranks",
        r"25 segments +2978, longest chain 144",
    ),
    "docs/scripts/folding.py": ("four-bar", r"\| four-bar \| \d+ \| \d+ \|"),
    "docs/scripts/accuracy.py": ("", r"rtol 1e-12: times to"),
    "docs/scripts/laws.py": (
        "1 --seed 6",
        r"\| newton \| 1 \| 1 \| .*\n\| poisson \| 1 \| 1 \| .*\n\| stronge \| 1 \| 1 \|",
    ),
    "docs/scripts/compliance.py": ("--decades 1 --chart chart.png", r"\| linear, nothing lost \| 1e\+04 \| \d+ \|"),
    "benchmarks/formulations.py": ("--links 3 --limit 1.5 --repeats 1", r"\| 3 \| 249 \|"),
}
"""Arguments with which a script takes seconds, and what it then says."""


@pytest.mark.parametrize(
    "path", [path for folder in FOLDERS for path in sorted(folder.glob("*.py"))], ids=lambda p: p.stem
)
def test_every_script_knows_what_it_imports(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Names that it takes from ccgen are there."""
    text = path.read_text()
    for package in OTHERS:
        if re.search(rf"^(import|from) {package}\b", text, re.MULTILINE):
            pytest.importorskip(package)
    monkeypatch.syspath_prepend(str(path.parent))
    spec = importlib.util.spec_from_file_location(f"script_{path.stem}", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, module)
    spec.loader.exec_module(module)


@pytest.mark.sample(1)
@pytest.mark.parametrize("script", all_hard_but("docs/scripts/accuracy.py", of=SMALL))
def test_scripts_run_small(script: str, tmp_path: Path) -> None:
    arguments, said = SMALL[script]
    done = subprocess.run(
        [sys.executable, str(ROOT / script), *arguments.split()],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert re.search(said, done.stdout), done.stdout


@pytest.mark.hard
def test_near_chains_runs_by_both_plans(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A row of 8 links for a hundredth of a second, once."""
    monkeypatch.syspath_prepend(str(FOLDERS[0]))
    near_chains = importlib.import_module("near_chains")
    text = near_chains.runs(near_chains.near_chain(8, 1), str(tmp_path), until=0.01, rounds=1)
    assert text.count("tip to root") == text.count("dyads") == 3


@pytest.mark.slow
def test_tables_hold_the_figures_of_a_ring_of_24() -> None:
    """From tip to root: docs/counts.md plain and folded, docs/formulations.md and its data."""
    program, folded = (lower(derive_scene(loop(24, gravity=True), fold, TIP_TO_ROOT)[1]) for fold in (False, True))
    whole = [sum(function.counts().total for function in one.functions) for one in (program, folded)]
    own = [one.function("acceleration").counts().total for one in (program, folded)]
    row = f"| loop24, tip to root | {whole[0]} | {whole[1]} | {own[0]} | {own[1]} |"
    assert row in (ROOT / "docs" / "counts.md").read_text()
    assert f"| 24 | {own[0]} |" in (ROOT / "docs" / "formulations.md").read_text()
    data = (ROOT / "docs" / "data" / "formulations.csv").read_text().splitlines()
    (line,) = [line for line in data if line.startswith("recursive,loop,24,")]
    assert line.split(",")[4] == str(own[0])


@pytest.mark.hard
def test_tables_hold_the_figures_of_a_machine_that_walks(monkeypatch: pytest.MonkeyPatch) -> None:
    """One crank: dyads are closed, and the order from tip to root is counted on its best tree."""
    monkeypatch.syspath_prepend(str(FOLDERS[0]))
    counts = importlib.import_module("counts")
    scene = counts.walking(1)
    assert plan_scene(scene)[1].plan.name == DYADS
    text = (ROOT / "docs" / "counts.md").read_text()
    assert f"| operations | {counts.acceleration(scene)} | 3645 |" in text
    assert f"| from tip to root | {counts.acceleration(scene, TIP_TO_ROOT)} | 10423 |" in text
