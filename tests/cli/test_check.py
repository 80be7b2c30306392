"""``ccgen check`` and the choice of a compiler."""

from __future__ import annotations

from pathlib import Path

import pytest

from ccgen.generator.compile import compiler
from ccgen.generator.compile.compiler import CompileError, find_compiler

from ..support.command_line import ccgen


def program(folder: Path, name: str, text: str) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / name).write_text(f"#!/bin/sh\n{text}\n")
    (folder / name).chmod(0o755)
    return folder / name


def test_an_installation_that_works_says_so(tmp_path: Path) -> None:
    done = ccgen("check", at=tmp_path)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0].startswith("ccgen ") and lines[1].startswith("compiler ") and lines[-1] == "ccgen works here"
    differences = [float(line.split()[1]) for line in lines if line.startswith("difference")]
    assert len(differences) == 3 and all(0.0 <= value <= 1e-9 for value in differences)
    assert list(tmp_path.iterdir()) == []


def test_one_without_a_compiler_says_what_to_install(tmp_path: Path) -> None:
    done = ccgen("check", at=tmp_path, environment={"PATH": str(tmp_path), "CC": ""})
    assert done.returncode == 2
    assert "no C compiler found" in done.stderr and "pip install 'ccgen[zig]'" in done.stderr


@pytest.mark.hard
def test_a_compiler_that_gives_wrong_numbers_is_found_out(tmp_path: Path) -> None:
    """Gravity is a hundredth more in all that it compiles."""
    more = "case $last in *.c) sed -i 's/double g = /double g = 1.01*/' $last ;; esac"
    swap = f'for last; do :; done; {more}; exec cc "$@"'
    wrong = program(tmp_path / "bin", "wrong-cc", swap)
    done = ccgen("check", at=tmp_path, environment={"CC": str(wrong)})
    assert done.returncode == 1
    assert "wrong: found a difference beyond 1e-09" in done.stderr and "works" not in done.stdout


def test_a_compiler_that_is_to_be_installed_yet_is_passed_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As the cc of macOS before its tools are installed: it is on the path and fails."""
    program(tmp_path, "cc", "exit 1")
    program(tmp_path, "clang", "echo clang version 99")
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    assert find_compiler().command == (str(tmp_path / "clang"),)
    (tmp_path / "clang").unlink()
    monkeypatch.setattr(compiler.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(CompileError, match=r"cc --version fails"):
        find_compiler()
