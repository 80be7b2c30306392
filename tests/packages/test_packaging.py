"""What the installed packages need and what they do not."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from ..support.folders import ROOT
from ..support.workshop import Workshop

SCENE = ROOT / "scenes" / "falling-hexagon.toml"

WITHOUT = """
import sys

class Without:
    names = "sympy Cython pydantic typer jinja2 networkx matplotlib scipy rich PIL xarray filelock platformdirs".split()

    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in self.names or name.startswith(("ccgen.generator", "ccgen.templates")):
            raise ImportError(f"{name} is not here")

sys.meta_path.insert(0, Without())
"""


def python(code: str, at: Path) -> str:
    """What a Python program prints, run in a process of its own in the folder ``at``."""
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=at, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def models(workshop: Workshop, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of generated packages."""
    from ccgen.generator import generate, load_scene, loop

    folder = tmp_path_factory.mktemp("models")
    generate(loop(6), folder)
    generate(load_scene(SCENE), folder)
    return folder


def test_the_runtime_needs_numpy_alone(models: Path) -> None:
    code = """
from ccgen.runtime import load_model, simulate
run = simulate(load_model("falling_hexagon"), until=0.6)
print(len(run.impacts), run.success, run.at(0.3)[0].shape, run.save("run.npz"))
import falling_hexagon
print(falling_hexagon.model.dof)
"""
    assert python(WITHOUT + code, models).splitlines() == ["2 True (8,) run.npz", "6"]


def test_a_generated_package_is_a_module(models: Path) -> None:
    code = f"""
import sys
sys.path.insert(0, {str(models)!r})
import loop6
q, u = loop6.model.start()
print(type(loop6.model).__name__, loop6.model.name, loop6.poses(q).shape, loop6.acceleration(q, u).shape)
dynamics = "acceleration multipliers reactions energy impact"
geometry = "poses velocities point state_from_poses closure assemble project"
print([name for name in f"{{dynamics}} {{geometry}}".split() if getattr(loop6, name) != getattr(loop6.model, name)])
"""
    assert python(code, models.parent).splitlines() == ["Model loop6 (6, 3) (8,)", "[]"]


def test_importing_the_runtime_is_not_importing_the_generator(tmp_path: Path) -> None:
    code = "import sys, ccgen.runtime; print(sorted(name for name in sys.modules if name.startswith('ccgen.')))"
    assert "generator" not in python(code, tmp_path)
    code = "import sys, ccgen.runtime; print([n for n in ('sympy', 'matplotlib', 'Cython') if n in sys.modules])"
    assert python(code, tmp_path) == "[]\n"


def test_the_command_line_starts_without_sympy(tmp_path: Path) -> None:
    code = "import sys, ccgen.generator.cli.build, ccgen.generator.cli.run; print('sympy' in sys.modules)"
    assert python(code, tmp_path) == "False\n"


def tools(folder: Path, *names: str) -> Path:
    """A folder with links to these programs alone, for a path without compilers."""
    folder.mkdir()
    for name in names:
        found = shutil.which(name)
        assert found, name
        (folder / name).symlink_to(found)
    return folder


@pytest.mark.skipif(importlib.util.find_spec("ziglang") is not None, reason="ziglang brings a compiler")
def test_make_without_a_compiler_says_what_to_install(tmp_path: Path) -> None:
    path = tools(tmp_path / "tools", "sh", "make", "test", "echo")
    shutil.copy(ROOT / "Makefile", tmp_path)
    for file in ("pyproject.toml", "setup.py"):
        (tmp_path / file).write_text("")
    environment = {name: value for name, value in os.environ.items() if name != "CC"} | {"PATH": str(path)}
    command = ["make", "hexagon", f"BIN={Path(sys.executable).parent}"]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "make: found no C compiler, expected cc, gcc or clang; install one" in done.stderr
    for line in ("apt install gcc", "dnf install gcc", "xcode-select --install", "-m pip install ziglang"):
        assert line in done.stderr
    assert len(done.stderr.splitlines()) <= 8 and "pip" not in done.stdout


def test_what_a_job_prints_is_whole_however_often_it_is_looked_at() -> None:
    """A compiler's error among it: the file has one place for whoever writes and reads."""
    spec = importlib.util.spec_from_file_location("environment", ROOT / "backend" / "environment.py")
    assert spec and spec.loader
    environment = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(environment)
    code = "for k in range(20_000): print('line', k, flush=True)"
    job = environment.Job("counts", sys.executable, "-c", code)
    lines, looks = [f"line {k}" for k in range(20_000)], 0
    while job.process.poll() is None:
        job.text()
        looks += 1
    told = job.text().splitlines()
    job.printed.close()
    assert looks > 1 and told == lines


def test_building_asks_for_zig_where_there_is_no_compiler(tmp_path: Path) -> None:
    """With one on the path, or named by $CC, it does not."""
    code = (
        f"import sys; sys.path.insert(0, {str(ROOT / 'backend')!r}); from setuptools import build_meta\n"
        "usual = lambda given: ['usual']\n"
        "build_meta.get_requires_for_build_wheel = build_meta.get_requires_for_build_editable = usual\n"
        "import compiled_by_any as backend\n"
        "print(backend.get_requires_for_build_wheel(), backend.get_requires_for_build_editable())\n"
        "print(callable(backend.build_wheel), callable(backend.build_editable), callable(backend.build_sdist))\n"
    )
    zig, none = "['usual', 'ziglang>=0.12']", "['usual']"
    (tmp_path / "with").mkdir()
    (tmp_path / "with" / "clang").write_text("#!/bin/sh\n")
    (tmp_path / "with" / "clang").chmod(0o755)
    for environment, needed in (
        ({"PATH": str(tmp_path)}, zig),
        ({"PATH": str(tmp_path / "with")}, none),
        ({"PATH": str(tmp_path), "CC": "tcc"}, none),
    ):
        done = subprocess.run(
            [sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=60, check=False
        )
        assert done.stdout.splitlines() == [f"{needed} {needed}", "True True True"], done.stderr


def test_every_folder_of_code_is_installed() -> None:
    """pyproject.toml lists them by hand; a file that Python does not import must be named as data of its folder."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    packages = {f"ccgen.{'.'.join(file.parent.relative_to(ROOT).parts)}" for file in ROOT.glob("*/**/__init__.py")}
    ours = {name for name in packages if name.split(".")[1] in ("generator", "runtime", "templates")}
    assert ours <= set(settings["packages"])
    for file in (*ROOT.glob("generator/**/*.*"), *ROOT.glob("runtime/**/*.html")):
        if file.suffix not in (".py", ".pyc"):
            folder = f"ccgen.{'.'.join(file.parent.relative_to(ROOT).parts)}"
            assert any(file.match(pattern) for pattern in settings["package-data"].get(folder, [])), file


def test_the_version_to_cite_is_that_of_the_package() -> None:
    from ccgen.generator.version import VERSION

    lines = (ROOT / "CITATION.cff").read_text(encoding="utf-8").splitlines()
    assert f"version: {VERSION}" in lines and f"## [{VERSION}] - " in (ROOT / "CHANGELOG.md").read_text()


def test_types_of_all_packages_are_for_those_who_use_them() -> None:
    data = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["package-data"]
    for folder, package in {"front": "ccgen", "generator": "ccgen.generator", "runtime": "ccgen.runtime"}.items():
        assert (ROOT / folder / "py.typed").is_file() and "py.typed" in data[package]
