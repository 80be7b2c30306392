"""The formulations that the benchmark compares: each gives the exact accelerations, the recursion the known counts."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from ..support.folders import ROOT
from ..support.tiers import all_hard_but

SCRIPT = ROOT / "benchmarks" / "derivations.py"
RECURSIVE = {"chain": 60 * 3 - 73 + 6, "loop": 98 * 4 - 46 + 1}
"""Operations of the acceleration (docs/counts.md), and those that gravity adds."""


def derive(formulation: str, family: str, links: int, limit: float = 60.0) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(SCRIPT), formulation, family, str(links), str(limit)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.sample(1)
@pytest.mark.parametrize(("family", "links"), [("chain", 3), ("loop", 4)])
@pytest.mark.parametrize("formulation", all_hard_but("recursive", of=["recursive", "closed_form", "kane", "lagrange"]))
def test_all_give_the_accelerations_of_maximal_coordinates(formulation: str, family: str, links: int) -> None:
    done = derive(formulation, family, links)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["error"] < 1e-12
    if formulation == "recursive":
        assert (found["equations"], found["solve"]) == (RECURSIVE[family], 0)


def test_a_derivation_over_its_limit_is_given_up() -> None:
    assert derive("lagrange", "loop", 8, limit=0.2).returncode == 3
