"""An editable installation: a folder of links on Python's path, which type checkers and editors can follow."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest

from ..support.folders import ROOT

FOLDERS = ("backend", "front", "generator", "runtime", "templates")
FILES = ("pyproject.toml", "setup.py", "MANIFEST.in", "README.md", "LICENSE")
BUILD = (
    "import sys; sys.path.insert(0, 'backend'); import compiled_by_any as made; print(made.build_editable('wheels'))"
)
WITHOUT_LINKS = f"""
import os
def symlink(*arguments, **options):
    raise OSError("a privilege is not held")
os.symlink = symlink
{BUILD}
"""


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A copy of what is installed, in a folder with a space in its name."""
    for name in ("setuptools", "Cython"):
        pytest.importorskip(name, reason=f"{name} is not installed")
    place = tmp_path / "my checkout"
    for name in FOLDERS:
        shutil.copytree(ROOT / name, place / name, ignore=shutil.ignore_patterns("__pycache__", "*.so"))
    for name in FILES:
        shutil.copy(ROOT / name, place)
    return place


def installed(checkout: Path, code: str = BUILD) -> tuple[Path, list[str], str]:
    """An environment of its own with the checkout, the files of the wheel, and what building it printed.

    What of the core has been compiled is taken from there.
    """
    environment = {**os.environ, "CCGEN_BUILD_BASE": str(ROOT / ".cache" / "setuptools")}
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=checkout, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    folder = checkout.parent / "environment"
    venv.create(folder, with_pip=False, clear=True)
    (site,) = folder.glob("lib/python*/site-packages")
    (wheel,) = (checkout / "wheels").glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
        names = archive.namelist()
    wheel.unlink()
    (site / "numpy.pth").write_text(str(Path(pytest.importorskip("numpy").__file__).parents[1]))
    return folder / "bin" / "python", names, done.stdout


def told(python: Path, code: str) -> str:
    """What Python prints, started elsewhere; the last line of its error where there is one."""
    done = subprocess.run([python, "-c", code], cwd=python.parent, capture_output=True, text=True, check=False)
    return done.stdout.strip() or done.stderr.strip().splitlines()[-1]


PLACES = "import ccgen, ccgen.runtime, ccgen.runtime._core as core; print(ccgen.__file__, core.__file__, sep='\\n')"


@pytest.mark.slow
def test_its_path_has_the_package_as_links(checkout: Path) -> None:
    """No program finds it; a new module is there at once; where the checkout is moved it is installed anew."""
    python, names, _ = installed(checkout)
    outside = [name for name in names if ".dist-info/" not in name]
    assert len(outside) == 1 and outside[0].endswith(".pth")
    (path,) = [file.read_text().strip() for file in python.parents[1].glob("lib/python*/site-packages/__editable__*")]
    package = Path(path) / "ccgen"
    assert Path(path).parent == checkout
    front, core = told(python, PLACES).splitlines()
    assert Path(front) == package / "__init__.py" and Path(front).samefile(checkout / "front" / "__init__.py")
    assert Path(core).parent == package / "runtime" and (checkout / "runtime" / Path(core).name).is_file()
    assert (package / "py.typed").is_file() and (package / "generator" / "py.typed").is_file()
    (checkout / "runtime" / "added.py").write_text("told = 3\n")
    assert told(python, "import ccgen.runtime.added as added; print(added.told)") == "3"
    moved = checkout.rename(checkout.with_name("moved"))
    assert told(python, "import ccgen") == "ModuleNotFoundError: No module named 'ccgen'"
    python, _, _ = installed(moved)
    assert Path(told(python, PLACES).splitlines()[0]).is_relative_to(moved)


@pytest.mark.slow
def test_without_links_python_alone_finds_it(checkout: Path) -> None:
    """And the installation says that nothing else does."""
    python, names, said = installed(checkout, WITHOUT_LINKS)
    assert (
        "type checkers and editors will not find it: found no way to make links here (a privilege is not held)" in said
    )
    assert any(name.startswith("__editable__") and name.endswith("_finder.py") for name in names)
    front, core = told(python, PLACES).splitlines()
    assert Path(front) == checkout / "front" / "__init__.py" and Path(core).parent == checkout / "runtime"
    assert not (checkout / ".editable").exists()
