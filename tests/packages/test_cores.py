"""Cores for other numbers than doubles: compiled when they are first asked for, once, and said so."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from ccgen.generator.compile import core, core_recipe
from ccgen.generator.compile.compiler import CompileError, Compiler
from ccgen.runtime import precision

from ..support.folders import ROOT, RUNTIME
from ..support.tiers import hard


def test_every_type_of_numbers_has_its_module() -> None:
    assert core_recipe.MODULES == precision.CORES and core_recipe.PRECISIONS.keys() == precision.CORES.keys()


def test_all_that_is_compiled_counts(tmp_path: Path) -> None:
    """A changed header, or file of C or of Cython, is another core; what is not read is not."""
    for file in (*core_recipe.c_files(RUNTIME), *core_recipe.read_files(RUNTIME)):
        copy = tmp_path / file.relative_to(RUNTIME)
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes(file.read_bytes())
    first = core_recipe.digest(tmp_path)
    assert first == core_recipe.digest(RUNTIME)
    (tmp_path / "core" / "notes.txt").write_text("not read")
    assert core_recipe.digest(tmp_path) == first
    for name in ("model.h", "core/base/real.h", "core/algebra/orthogonal.c", "face/arrays.pxi", "_float.pyx"):
        kept = (tmp_path / name).read_bytes()
        (tmp_path / name).write_bytes(kept + b" ")
        assert core_recipe.digest(tmp_path) != first, name
        (tmp_path / name).write_bytes(kept)


@pytest.fixture
def made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What has been compiled: here nothing is, in a cache of its own."""
    found: list[str] = []

    def compile_(compiler: Compiler, precision: str, runtime: Path, folder: Path, target: Path, tell: object) -> None:
        found.append(precision)
        target.write_bytes(b"compiled")

    monkeypatch.setattr(core, "_compile", compile_)
    monkeypatch.setenv("CCGEN_CACHE_DIR", str(tmp_path / "cache"))
    return found


def test_a_core_is_compiled_once_and_again_where_it_is_damaged(made: list[str]) -> None:
    file = core.core_file("float", print)
    assert core.core_file("float", print) == file and made == ["float"]
    file.write_bytes(b"compi")
    assert core.core_file("float", print) == file and made == ["float"] * 2
    assert core.core_file("wide", print) != file and made[2:] == ["wide"]


@pytest.mark.parametrize("variable", ["CFLAGS", "LDFLAGS"])
def test_other_flags_are_another_core(made: list[str], monkeypatch: pytest.MonkeyPatch, variable: str) -> None:
    file = core.core_file("float", print)
    monkeypatch.setenv(variable, "-fsanitize=address")
    assert core.core_file("float", print) != file and len(made) == 2


def test_a_core_that_was_compiled_needs_no_compiler(made: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """One that is damaged, of other flags or for other numbers is none; neither does it stand for what $CC names."""

    def none() -> Compiler:
        raise CompileError("no C compiler found")

    monkeypatch.delenv("CC", raising=False)
    find_compiler = core.find_compiler
    file = core.core_file("float", print)
    monkeypatch.setattr(core, "find_compiler", none)
    assert core.core_file("float", print) == file and made == ["float"]
    for variable, numbers in (("CFLAGS", "float"), ("LDFLAGS", "float"), ("CC", "float"), ("OTHER", "wide")):
        with monkeypatch.context() as changed, pytest.raises(CompileError, match="no C compiler found"):
            changed.setenv(variable, "-g")
            core.core_file(numbers, print)
    file.write_bytes(b"compi")
    with pytest.raises(CompileError, match="no C compiler found"):
        core.core_file("float", print)
    monkeypatch.setattr(core, "find_compiler", find_compiler)
    assert core.core_file("float", print) == file and made == ["float"] * 2


def test_what_fails_is_said_in_a_sentence(tmp_path: Path) -> None:
    code = (
        "import importlib, sys\nfrom ccgen.runtime import precision\n"
        "precision.CORES['float'] = '_none'\n"
        "try: precision.core_of('float')\nexcept ImportError as error: print(error)\n"
    )
    for environment, said in (
        ({"CC": "no-such-compiler"}, "CC names 'no-such-compiler', which is not a program"),
        ({"CCGEN_CACHE_DIR": str(ROOT / "Makefile" / "cache")}, "cannot be written"),
    ):
        done = subprocess.run(
            [sys.executable, "-c", code],
            cwd=tmp_path,
            env={**os.environ, **environment},
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
        assert done.stdout.startswith("found no core for float numbers in this installation"), done.stderr
        assert said in done.stdout and "Traceback" not in done.stdout


@pytest.mark.parametrize("terminal", [False, hard(True)])
def test_how_far_it_is_is_said_on_a_terminal_alone(terminal: bool, tmp_path: Path) -> None:
    """A pipe or a file gets no word, also where many processes compile; the last words of what fails are in the
    error."""
    code = (
        "from ccgen.runtime import precision\nprecision.CORES['float'] = '_none'\n"
        "try: precision.core_of('float')\nexcept ImportError as error: print('no-such-flag' in str(error))\n"
    )
    environment = {**os.environ, "CFLAGS": "-no-such-flag", "CCGEN_CACHE_DIR": str(tmp_path / "cache")}
    here, there = os.openpty() if terminal else os.pipe()
    command = [sys.executable, "-c", code]
    done = subprocess.run(
        command, env=environment, cwd=tmp_path, stdout=subprocess.PIPE, stderr=there, timeout=120, check=False
    )
    os.set_blocking(here, False)
    try:
        said = os.read(here, 100_000)
    except BlockingIOError:
        said = b""
    os.close(here)
    os.close(there)
    assert done.stdout == b"True\n"
    assert said.startswith(b"ccgen: compiling the core for float numbers") if terminal else said == b""


def test_a_failing_compiler_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CCGEN_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setenv("CFLAGS", "-no-such-flag")
    monkeypatch.setattr(core_recipe, "c_files", lambda runtime: [RUNTIME / "core" / "algebra" / "orthogonal.c"])
    with pytest.raises(CompileError, match="the C compiler failed"):
        core.core_file("float", lambda line: None)
    assert not list((tmp_path / "cache" / "cores").iterdir())
