"""Closure rows that are off, among those of a model that has none: to the bit its runs, with multipliers that are 0."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import Model, ensemble, simulate

from ..support.folders import ROOT, RUNTIME
from ..support.parallel_cranks import parallel_cranks
from ..support.workshop import Workshop

Padded = Callable[..., Model]
GATE = "spare.held"


@pytest.fixture(scope="module")
def padded(tmp_path_factory: pytest.TempPathFactory) -> Padded:
    """A model with further rows behind its first ``before`` rows: as many as ``more`` names, which are off unless they
    are not ``marked``."""
    folder = tmp_path_factory.mktemp("rows_off")
    first = folder / "rows_off.so"
    source = ROOT / "tests" / "c" / "rows_off.c"
    flags = ["-std=c11", "-Wall", "-Wextra", "-Werror", "-O1", "-fPIC", "-shared", f"-I{RUNTIME}"]
    subprocess.run(["cc", *flags, str(source), "-o", str(first)], check=True)

    def pad(model: Model, before: int, more: tuple[str, ...] = ("x", "y"), marked: bool = True) -> Model:
        own = Path(shutil.copy(first, folder / f"rows_off_{len(list(folder.iterdir()))}.so"))
        make = ctypes.CDLL(str(own)).with_rows_off
        make.restype = ctypes.c_void_p
        address = make(ctypes.c_void_p(model.kernels.address), before, len(more), more == ("x", "y"), marked)
        capsule = ctypes.pythonapi.PyCapsule_New
        capsule.restype, capsule.argtypes = ctypes.py_object, [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p]
        rows = [*model.rows[:before], *(f"spare.{name}" for name in more), *model.rows[before:]]
        gate = {"path": GATE, "value": 0.0, "domain": {"minimum": 0.0, "above": None, "maximum": 1.0}}
        data = {**model.data, "rows": rows, "parameters": [*model.data["parameters"], gate]}
        return Model(capsule(address, b"ccgen.model", None), data, {**model.parameters, GATE: 0.0})

    return pad


def cranks(workshop: Workshop) -> Model:
    """Three cranks, of which one is redundant, come to a line of all links."""
    drawing = parallel_cranks(0.8, 3)
    return workshop.model(drawing.toml())


def _scene(name: str, change: tuple[str, str] = ("", "")) -> Callable[[Workshop], Model]:
    text = (ROOT / "scenes" / f"{name}.toml").read_text(encoding="utf-8")
    assert change[0] in text
    return lambda workshop: workshop.model(text.replace(*change) if change[0] else text)


LIGHT = "mass = 1.0\ninertia = 0.03", "mass = 1e-10\ninertia = 3e-12"
"""A coupler beside which masses differ by so many orders that the elimination is not to be used."""
RUNS: dict[str, tuple[Callable[[Workshop], Model], float, int]] = {
    "open chain": (_scene("open-chain"), 0.4, 0),
    "one loop": (_scene("four-bar"), 0.6, 0),
    "light": (_scene("four-bar", LIGHT), 0.3, 1),
    "change points": (_scene("parallelogram"), 0.8, 2),
    "a line that slides": (_scene("quick-return"), 0.6, 1),
    "passes through a point": (_scene("equal-length-slider-crank"), 0.6, 1),
    "strikes": (_scene("falling-hexagon"), 1.0, 0),
    "strikes beside": (_scene("tilted-hexagon"), 0.8, 2),
    "driven": (_scene("jansen-driven"), 0.5, 2),
    "slack": (_scene("loose-slider-crank"), 0.2, 0),
    "redundant": (cranks, 0.5, 2),
}
METHODS = [("gauss", {}), ("dop853", {}), ("radau", {}), ("moreau", {"step": 2e-3}), ("gauss", {"drift": "damped"})]


def _recorded(run: Any) -> tuple[Any, ...]:
    return run.t, run.q, run.u, run.nfev, run.message, len(run.impacts)


@pytest.mark.parametrize("name", RUNS)
def test_runs_are_those_without_the_rows(name: str, workshop: Workshop, padded: Padded) -> None:
    """By every method, where rows are independent, where they are not, and at places where they come to be none."""
    make, until, before = RUNS[name]
    plain = make(workshop)
    other = padded(plain, before)
    q, u = plain.start()
    assert len(other.rows) == len(plain.rows) + 2 and other.dof == plain.dof
    for method, options in METHODS:
        one, two = (simulate(model, q, u, until=until, method=method, **options) for model in (plain, other))
        for found, wanted in zip(_recorded(two), _recorded(one), strict=True):
            assert np.array_equal(found, wanted), (method, options)
        if method == "moreau":
            continue
        t = np.linspace(0.0, one.t[-1], 5)
        for found, wanted in ((two.q, one.q), (two.reactions(t), one.reactions(t)), (two.at(t), one.at(t))):
            assert np.array_equal(np.asarray(found), np.asarray(wanted), equal_nan=True), (method, options)


@pytest.mark.parametrize("more", [("n",), ("x", "y")])
@pytest.mark.parametrize("before", [0, 1, 2])
def test_their_multipliers_are_zero(before: int, more: tuple[str, ...], workshop: Workshop, padded: Padded) -> None:
    """Also where rows are dependent, and of least norm those of the others."""
    for plain in (_scene("parallelogram")(workshop), cranks(workshop)):
        if before == 1 and more == ("x", "y"):
            continue  # between the rows of a pin
        other = padded(plain, before, more)
        q, u = plain.start()
        u = plain.motions(q)[:, 0] * 3.0
        found, wanted = other.multipliers(q, u), plain.multipliers(q, u)
        added = slice(before, before + len(more))
        assert np.array_equal(np.delete(found, added), wanted) and np.all(found[added] == 0.0)
        assert np.array_equal(other.motions(q), plain.motions(q))
        assert np.array_equal(other.reactions(q, u), plain.reactions(q, u))


def test_at_a_change_point(workshop: Workshop, padded: Padded) -> None:
    """What holds there is a limit along the branch, and rows are not short of it for those that are off."""
    plain = _scene("parallelogram")(workshop)
    other = padded(plain, 2)
    q = np.zeros(len(plain.q_names))
    u = np.array([3.0, 0.0, 3.0])
    assert np.max(np.abs(plain.closure(q))) <= 1e-15 and np.max(np.abs(plain.jacobian(q) @ u)) <= 1e-15
    assert np.array_equal(other.acceleration(q, u), plain.acceleration(q, u))
    assert np.array_equal(other.multipliers(q, u)[:2], plain.multipliers(q, u))
    assert np.all(other.multipliers(q, u)[2:] == 0.0)


def test_rows_that_vanish_and_are_not_off_are_redundant(workshop: Workshop, padded: Padded) -> None:
    """What the others are told from: these are looked at all the time."""
    plain = _scene("parallelogram")(workshop)
    one, two = (simulate(model, until=0.8) for model in (plain, padded(plain, 2, marked=False)))
    assert one.success and two.success and two.nfev != one.nfev


def test_each_run_of_many_has_rows_of_its_own_on(workshop: Workshop, padded: Padded) -> None:
    """A gate is a parameter as others are: a row that is on there, and vanishes, is redundant."""
    plain = _scene("parallelogram")(workshop)
    other = padded(plain, 2)
    gates, t = np.array([0.0, 1.0, 0.0, 1.0, 0.0]), np.linspace(0.1, 0.8, 4)
    q, u = plain.start()
    found = ensemble(other, {GATE: gates}, q, u, observe=["crank.angle"], at=t, until=0.8, threads=2)
    for row, gate in zip(found.columns["crank.angle"], gates, strict=True):
        run = simulate(other, q, u, until=0.8, params={GATE: gate})
        assert np.array_equal(row, run.values("crank.angle", t=t)["crank.angle"])
    run = simulate(plain, q, u, until=0.8)
    assert np.array_equal(found.columns["crank.angle"][0], run.values("crank.angle", t=t)["crank.angle"])
