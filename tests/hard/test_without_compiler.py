"""Installed and used where no C compiler is: that of the ziglang package compiles the runtime and the models.

The path has ``sh`` alone, as in a bare container. Takes minutes and a package index.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from ..support.folders import ROOT

NOT_SOURCES = shutil.ignore_patterns(".*", "build", "results", "*.so", "__pycache__", "*.egg-info", "_core.c", "_*.c")


@pytest.mark.hard
@pytest.mark.skipif("CCGEN_LARGE" not in os.environ, reason="takes minutes; runs in make figures")
def test_zig_is_compiler_enough(tmp_path: Path) -> None:
    shutil.copytree(ROOT, tmp_path / "source", ignore=NOT_SOURCES)
    subprocess.run([sys.executable, "-m", "venv", tmp_path / "venv"], check=True)
    (tmp_path / "tools").mkdir()
    (tmp_path / "tools" / "sh").symlink_to(shutil.which("sh") or "")
    hidden = ("CC", "PATH", "CCGEN_CACHE_DIR", "VIRTUAL_ENV", "PYTHONPATH")
    environment = {name: value for name, value in os.environ.items() if name not in hidden}
    environment |= {"PATH": str(tmp_path / "tools"), "HOME": str(tmp_path), "CCGEN_CACHE_DIR": str(tmp_path / "cache")}

    def run(*command: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [str(tmp_path / "venv" / "bin" / command[0]), *command[1:]],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )

    if run("python", "-m", "pip", "download", "--no-deps", "ziglang>=0.12").returncode:
        pytest.skip("no package index here, or none with ziglang")
    installed = run("python", "-m", "pip", "install", "./source[zig]")
    assert installed.returncode == 0, installed.stdout + installed.stderr
    done = run("ccgen", "run", str(ROOT / "scenes" / "falling-hexagon.toml"))
    assert done.returncode == 0, done.stderr
    assert "impacts: 7" in done.stdout
    assert '"compiler": "clang' in (tmp_path / "build" / "falling_hexagon" / "build.json").read_text()
