"""``import ccgen``: its names, its version, and a run in one call."""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import ccgen
from ccgen import generator, runtime
from ccgen.generator import Mechanism, load_scene
from ccgen.generator.version import VERSION
from ccgen.runtime import Run, load_model
from ccgen.runtime import simulate as simulated

from ..support.folders import ROOT
from ..support.workshop import Workshop

SCENE = ROOT / "scenes" / "open-chain.toml"


def test_every_name_is_there_and_has_a_docstring() -> None:
    assert ccgen.__version__ == VERSION and "ccgen.simulate" in (ccgen.__doc__ or "")
    assert sorted({*generator.__all__, *runtime.__all__, "load"}) == ccgen.__all__
    assert {*ccgen.__all__, "generator", "runtime"} <= set(dir(ccgen))
    for name in ccgen.__all__:
        assert getattr(ccgen, name).__doc__, name
        for package in (runtime, generator):
            if name in package.__all__ and name != "simulate":
                assert getattr(ccgen, name) is getattr(package, name), name
    assert ccgen.Mechanism is Mechanism and ccgen.load_model is load_model
    with pytest.raises(AttributeError, match="module 'ccgen' has no attribute 'simulat'"):
        ccgen.simulat  # noqa: B018


@pytest.mark.parametrize("folder", ["root", "elsewhere"])
def test_importing_it_imports_nothing_else(folder: str, tmp_path: Path) -> None:
    """NumPy and SymPy are what takes long, then ``typing``; in the folder of the sources it is the same package."""
    code = (
        "import sys; before = {*sys.modules}; import ccgen"
        "; found = {n.partition('.')[0] for n in {*sys.modules} - before}"
        "; print(sorted(found - {'ccgen', 'importlib', 'warnings', '__future__'})"
        " + [n for n in sys.modules if n.startswith('ccgen.')])"
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


def test_the_sources_do_not_hide_an_installed_package(tmp_path: Path) -> None:
    """Python started in the checkout looks there first: what is installed as copies is found nonetheless."""
    (tmp_path / "ccgen").mkdir()
    folders = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["package-dir"]
    for file in (ROOT / folders["ccgen"]).iterdir():
        (tmp_path / "ccgen" / file.name).symlink_to(file)
    for name in ("generator", "runtime", "templates"):
        (tmp_path / "ccgen" / name).symlink_to(ROOT / folders[f"ccgen.{name}"])
    code = "import ccgen.generator, ccgen.runtime; print(ccgen.__file__, ccgen.simulate.__name__, ccgen.fit.__name__)"
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.split() == [str(tmp_path / "ccgen" / "__init__.py"), "simulate", "fit"], done.stderr


def test_a_run_in_one_call_of_a_scene_in_any_form(
    workshop: Workshop, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    scene = load_scene(SCENE)
    package = ccgen.generate(scene)
    wanted = simulated(load_model(package), until=0.1).q
    for source in (SCENE, str(SCENE), scene, scene.to_dict(), package, str(package), load_model(package)):
        run = ccgen.simulate(source, until=0.1)
        assert isinstance(run, Run) and np.array_equal(run.q, wanted)
    assert ccgen.load(SCENE).name == load_model(package).name
    for wrong in (None, 5):
        with pytest.raises(TypeError, match=f"source: found {wrong}, expected the name of a scene file"):
            ccgen.load(wrong)  # type: ignore[arg-type]


def test_only_its_names_are_listed() -> None:
    listed = [name for name in dir(ccgen) if not name.startswith("__")]
    assert listed == sorted({*ccgen.__all__, "generator", "runtime"} - {"__version__"})
