"""Accelerations as functions of ``casadi.external``: what C gives beside Python, side by side on threads too."""

from __future__ import annotations

import ctypes
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import acceleration_function

from ..support.bounced import BOUNCED
from ..support.c_library import HIDDEN
from ..support.core_objects import core_objects
from ..support.folders import RUNTIME, SCENES
from ..support.workshop import Workshop

DRIVEN = '\n[[input]]\nname = "push"\njoint = "motor"\n'


def compiled(source: Path, package: Path) -> Path:
    """The library of a file that ``write_casadi`` has written, as docs/c.md has it; not optimised."""
    own = [str(path) for path in sorted(package.glob("*.c")) if path.name != "_binding.c"]
    library = source.with_suffix(".so")
    flags = ("-std=c11", "-O0", "-shared", "-fPIC", "-fvisibility=hidden", f"-I{RUNTIME}", f"-I{RUNTIME / 'core'}")
    core = core_objects(RUNTIME, HIDDEN)
    subprocess.run(["cc", *flags, str(source), *own, *core, "-lm", "-o", str(library)], check=True)
    return library


def test_it_is_the_function_of_python(workshop: Workshop, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """At states beside the closure, their Jacobian, and 40 of them on four threads."""
    casadi = pytest.importorskip("casadi", reason="needs the package casadi: pip install 'ccgen[casadi]'")
    model = workshop.model((SCENES / "four-bar.toml").read_text() + DRIVEN, derivatives=True)
    model = model.with_parameters({"gravity.g": 1.62})
    function = acceleration_function(model, inputs=0.3, t=0.25)
    written = function.write_casadi(tmp_path / "loop.c", "four_bar_moves")
    external: Any = casadi.external("four_bar_moves", str(compiled(written, model.folder)))
    assert external.size_in(0) == (len(function.columns), 1) and external.size_out(0) == (function.count, 1)
    jacobian = external.jacobian()
    states = function.x0 + 0.1 * np.sin(np.arange(40.0)[:, None] + np.arange(len(function.x0)))
    one_by_one = np.array([np.array(external(x)).ravel() for x in states])
    wanted = np.array([function(x) for x in states])
    assert np.abs(one_by_one - wanted).max() <= 1e-13 * np.abs(wanted).max()  # other sums than the optimised ones
    for x in states[:3]:
        exact = function.jacobian(x)
        assert np.abs(np.array(jacobian(x, 0.0)) - exact).max() <= 1e-13 * np.abs(exact).max()
    side_by_side = external.map(len(states), "thread", 4)(states.T)
    assert np.array_equal(np.array(side_by_side).T, one_by_one)
    with pytest.raises(RuntimeError, match="four_bar_moves"):
        external(np.full(len(function.x0), np.nan))
    assert capfd.readouterr().err == "four_bar_moves: no acceleration: not_finite\n"


def test_more_calls_at_once_than_it_has_simulations_for_are_told(
    workshop: Workshop, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """CasADi checks out a simulation for each call: the 65th has none, which is said, and fails; what has been given
    back is given out again."""
    model = workshop.model((SCENES / "four-bar.toml").read_text() + DRIVEN, derivatives=True)
    function = acceleration_function(model, inputs=0.3, t=0.25)
    written = function.write_casadi(tmp_path / "loop.c", "four_bar_moves")
    library = ctypes.CDLL(str(compiled(written, model.folder)))
    library.four_bar_moves_incref()
    assert [library.four_bar_moves_checkout() for _ in range(64)] == list(range(64))
    assert capfd.readouterr().err == ""
    assert library.four_bar_moves_checkout() == library.jac_four_bar_moves_checkout() == -1
    message = "four_bar_moves: no acceleration: found more calls at once than 64, expected as many at most; "
    assert capfd.readouterr().err == 2 * f"{message}use fewer threads\n"
    vector = (ctypes.c_double * 64)()
    pointers = (ctypes.POINTER(ctypes.c_double) * 1)(vector)
    assert library.four_bar_moves(pointers, pointers, None, None, -1) == 1
    library.four_bar_moves_release(7)
    assert library.four_bar_moves_checkout() == 7
    library.four_bar_moves_decref()


def test_what_is_written_is_of_its_parameters(workshop: Workshop, tmp_path: Path) -> None:
    """The same bytes each time, and others for another mass."""
    model = workshop.model(BOUNCED, derivatives=True)
    function = acceleration_function(model, contacts=())
    texts = [function.write_casadi(tmp_path / "one.c", "moves").read_text() for _ in range(2)]
    path = next(name for name in model.parameters if name.endswith(".mass"))
    heavy = acceleration_function(model.with_parameters({path: 7.25}), contacts=())
    other = heavy.write_casadi(tmp_path / "one.c", "moves").read_text()
    assert texts[0] == texts[1] != other and f"7.25, /* {path} */" in other


def test_wrong_use_is_refused(workshop: Workshop, tmp_path: Path) -> None:
    touching = workshop.model(BOUNCED, derivatives=True)
    with pytest.raises(ValueError, match=r"contacts: found None, expected \(\): in C accelerations are those of fl"):
        acceleration_function(touching).write_casadi(tmp_path / "moves.c")
    function = acceleration_function(touching, contacts=())
    package = str(touching.folder.name)
    for name in ("a__b", "1st", "jac", f"{package}_q", "ccgen_moves", "while", "double", "printf", ""):
        with pytest.raises(ValueError, match=f"name: found {name!r}, expected"):
            function.write_casadi(tmp_path / "moves.c", name)
    with pytest.raises(ValueError, match=r"found a place in the model's package"):
        function.write_casadi(touching.folder / "moves.c")
    with pytest.raises(FileNotFoundError, match="there is no folder"):
        function.write_casadi(tmp_path / "nowhere" / "moves.c")
    assert list(tmp_path.iterdir()) == []


def test_a_file_is_called_as_its_function(workshop: Workshop, tmp_path: Path) -> None:
    function = acceleration_function(workshop.model(load_scene(SCENES / "four-bar.toml"), derivatives=True))
    text = function.write_casadi(tmp_path / "leg.c").read_text()
    assert "\n#define EXTERNAL leg\n" in text and "\n#define EXTERNAL_INPUTS 0\n" in text
