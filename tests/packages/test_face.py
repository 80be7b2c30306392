"""``import ccgen``: its names, its version, and a run in one call."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import ccgen
from ccgen.generator import Mechanism, load_scene
from ccgen.generator.version import VERSION
from ccgen.runtime import Run, load_model
from ccgen.runtime import simulate as simulated

from ..support.folders import ROOT
from ..support.workshop import Workshop

SCENE = ROOT / "scenes" / "open-chain.toml"


def test_every_name_is_there_and_has_a_docstring() -> None:
    assert ccgen.__version__ == VERSION and "ccgen.simulate" in (ccgen.__doc__ or "")
    assert set(ccgen.__all__) <= set(dir(ccgen))
    for name in ccgen.__all__:
        assert getattr(ccgen, name).__doc__, name
    assert ccgen.Mechanism is Mechanism and ccgen.load_model is load_model
    with pytest.raises(AttributeError, match="module 'ccgen' has no attribute 'simulat'"):
        ccgen.simulat  # noqa: B018


@pytest.mark.parametrize("folder", ["root", "elsewhere"])
def test_importing_it_imports_nothing_else(folder: str, tmp_path: Path) -> None:
    """NumPy and SymPy are what takes long; in the folder of the sources it is the same package."""
    code = (
        "import sys, ccgen; print(sorted(n for n in sys.modules if n in ('numpy', 'sympy') or n.startswith('ccgen.')))"
        "; from ccgen.generator.version import VERSION; print(ccgen.__version__ == VERSION)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=ROOT if folder == "root" else tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.splitlines() == ["[]", "True"], done.stderr


def test_a_run_in_one_call_of_a_scene_in_any_form(
    workshop: Workshop, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    scene = load_scene(SCENE)
    package = ccgen.generate(scene)
    wanted = simulated(load_model(package), until=0.1).q
    for source in (SCENE, str(SCENE), scene, package, str(package), load_model(package)):
        run = ccgen.simulate(source, until=0.1)
        assert isinstance(run, Run) and np.array_equal(run.q, wanted)
    assert ccgen.load(SCENE).name == load_model(package).name
