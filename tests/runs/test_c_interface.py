"""Simulations from C: the commands of docs/c.md, what they print against Python's run, and what the library refuses."""

from __future__ import annotations

import ctypes
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import simulate

from ..support.folders import ROOT
from ..support.workshop import Workshop

SCENE = ROOT / "scenes" / "falling-hexagon.toml"
COMMANDS = re.findall(r"```sh\n(.*?)```", (ROOT / "docs" / "c.md").read_text(), re.S)


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """A folder in which the commands of docs/c.md have been run, and what they print."""
    if os.name != "posix" or not shutil.which("cc"):
        pytest.skip("the commands are for a shell and cc")
    folder = tmp_path_factory.mktemp("c")
    for name in ("scenes", "docs"):
        (folder / name).symlink_to(ROOT / name)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["sh", "-ec", "\n".join(COMMANDS).replace("cc -O2", "cc -Wall -Wextra -Werror -O2")],
        cwd=folder,
        env={**os.environ, "PATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return folder, done.stdout


def test_the_hexagon_flies_as_from_python(built: tuple[Path, str], workshop: Workshop) -> None:
    """Times of all impacts after the third, and the energy at the end."""
    printed = built[1]
    run = simulate(workshop.model(load_scene(SCENE)))
    times = [float(t) for t in re.findall(r"^closes +t = ([\d.]+) s", printed, re.M)]
    kept = float(re.findall(r"^state +t = ([\d.]+) s", printed, re.M)[0])
    expected = [impact.t for impact in run.impacts]
    assert np.abs(np.subtract([kept, *times], expected[2:])).max() <= 1e-9
    energies = [float(e) for e in re.findall(r"^energy ([\d.]+) J", printed, re.M)]
    whole = [sum(run.model.energy(run.q[row], run.u[row])) for row in (0, -1)]
    assert np.abs(np.subtract(energies, whole)).max() <= 1e-7
    assert printed.endswith("the same yes\n")
    assert len(re.findall(r"^end ", printed, re.M)) == 1


def test_the_documentation_says_what_it_prints(built: tuple[Path, str]) -> None:
    """Up to the sixth digit behind the point."""

    def rounded(text: str) -> str:
        return re.sub(r"(\d\.\d{6})\d+", r"\1", text)

    shown = re.findall(r"It prints\n\n```\n(.*?)```", (ROOT / "docs" / "c.md").read_text(), re.S)[0]
    for line in filter(lambda line: line != "...", shown.splitlines()):
        assert rounded(line) in rounded(built[1])


def test_the_library_shows_names_with_its_prefix_alone(built: tuple[Path, str]) -> None:
    nm = shutil.which("nm")
    if nm is None:
        pytest.skip("needs nm")
    listed = subprocess.run(
        [nm, "-D", "--defined-only", built[0] / "build" / "libccgen.so"], capture_output=True, text=True, check=True
    )
    names = {line.split()[-1] for line in listed.stdout.splitlines()}
    declared = set(re.findall(r"^CCGEN_PUBLIC .*?(ccgen_\w+)\(", (ROOT / "runtime" / "ccgen.h").read_text(), re.M))
    assert declared <= names and len(declared) > 10
    assert all(name.startswith("ccgen_") or name.startswith("_") for name in names)


class _Settings(ctypes.Structure):
    """The first members of ``struct ccgen_settings``; the rest is zero."""

    _fields_ = (
        ("parameters", ctypes.POINTER(ctypes.c_double)),
        ("length", ctypes.c_double),
        ("angular", ctypes.c_void_p),
        ("law", ctypes.c_int),
        ("acceleration_scale", ctypes.c_double),
        ("method", ctypes.c_char_p),
        ("rest", ctypes.c_double * 32),
    )


def _settings(model: Any, method: bytes | None = None) -> _Settings:
    values = list(model.parameters.values())
    return _Settings((ctypes.c_double * len(values))(*values), model.length, method=method)


def test_what_cannot_be_is_a_code(built: tuple[Path, str], workshop: Workshop) -> None:
    library: Any = ctypes.CDLL(str(built[0] / "build" / "libccgen.so"))
    library.ccgen_outcome_name.restype = ctypes.c_char_p
    library.ccgen_state_size.restype = ctypes.c_size_t
    library.ccgen_state_size.argtypes = library.ccgen_destroy.argtypes = [ctypes.c_void_p]
    library.ccgen_get_state.argtypes = library.ccgen_set_state.argtypes = [ctypes.c_void_p, ctypes.c_void_p]
    library.ccgen_reset.argtypes = [ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p]

    def create(model: Any, method: bytes | None = None) -> tuple[str, ctypes.c_void_p]:
        made, settings = ctypes.c_void_p(), _settings(model, method)
        address = ctypes.c_void_p(model.kernels.address)
        code = library.ccgen_create(address, ctypes.byref(settings), ctypes.byref(made))
        return library.ccgen_outcome_name(code).decode(), made

    hexagon = workshop.model(load_scene(SCENE))
    four_bar = workshop.model(load_scene(ROOT / "scenes" / "four-bar.toml"))
    refused, nothing = create(hexagon, b"euler")
    assert refused == "unknown_method" and not nothing
    one, other, radau = create(hexagon), create(four_bar), create(hexagon, b"radau")
    assert [made[0] for made in (one, other, radau)] == ["done"] * 3
    q, u = (np.ascontiguousarray(x) for x in hexagon.start())
    assert library.ccgen_reset(one[1], 0.0, q.ctypes.data, u.ctypes.data) == 0
    state = ctypes.create_string_buffer(library.ccgen_state_size(one[1]))
    library.ccgen_get_state(one[1], state)
    before = state.raw
    for made in (other, radau):
        assert library.ccgen_outcome_name(library.ccgen_set_state(made[1], state)) == b"other_state"
    assert library.ccgen_set_state(one[1], state) == 0
    library.ccgen_get_state(one[1], state)
    assert state.raw == before
    far = 1e200 * np.ones(len(q))  # coordinates of which no loop is known to be shut
    code = library.ccgen_reset(one[1], 0.0, far.ctypes.data, u.ctypes.data)
    assert library.ccgen_outcome_name(code) == b"not_closed"
    assert library.ccgen_outcome_name(999) == b"no outcome"
    for made in (one, other, radau):
        library.ccgen_destroy(made[1])
