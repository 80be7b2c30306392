"""The Jacobian of the accelerations that an implicit method takes from generated derivatives, and what it saves."""

from __future__ import annotations

import subprocess
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.generator import generate, load_scene, loop
from ccgen.runtime import load_model, simulate

from ..support.active import ARM
from ..support.core_objects import core_objects
from ..support.folders import ROOT, RUNTIME
from ..support.workshop import Workshop


def stiff_beam(rods: int) -> Any:
    """A pendulum of rods with stiff, well damped springs between them: their vibration dies out within 0.1 ms."""
    names = [f"rod_{i}" for i in range(rods)]
    springs = [{"joint": f"bend_{i}", "stiffness": 3000.0 * rods, "damping": 3.0 * rods} for i in range(1, rods)]
    return load_scene(
        {
            "name": f"stiff-beam-{rods}",
            "ground_link": {"points": {"B": [0, 0]}},
            "link": [
                {"name": name, "rod": {"mass": 1 / rods}, "points": {"A": [0, 0], "B": [1 / rods, 0]}} for name in names
            ],
            "joint": [
                {"name": f"bend_{i}", "between": [f"{before}.B", f"{name}.A"]}
                for i, (before, name) in enumerate(zip(["ground", *names], names, strict=False))
            ],
            "torsion": springs,
            "gravity": {},
            "start": {"angles": {name: 0.1 * i / rods for i, name in enumerate(names)}},
        }
    )


@pytest.mark.slow
def test_derivatives_save_evaluations(workshop: Workshop) -> None:
    """The same motion, to the tolerance from that in wide numbers by an explicit method; with derivatives one
    evaluation a step in the place of 16."""
    until = 0.02
    exact = simulate(workshop.model(stiff_beam(8), "wide"), until=until, rtol=1e-14, method="dop853")
    plain = simulate(workshop.model(stiff_beam(8)), until=until, rtol=1e-8, method="radau")
    quick = simulate(workshop.model(stiff_beam(8), derivatives=True), until=until, rtol=1e-8, method="radau")
    assert exact.success
    for run in (plain, quick):
        assert run.success
        assert 3 * len(run.t) < len(exact.t)
        assert np.max(np.abs(run.q[-1] - exact.q[-1])) <= 1e-10
        assert np.max(np.abs(run.u[-1] - exact.u[-1])) <= 1e-8
    assert abs(len(quick.t) - len(plain.t)) <= 0.01 * len(plain.t)
    assert quick.nfev <= 11 * len(quick.t) and plain.nfev <= 16 * len(plain.t)  # differences of 16 are kept for a while
    assert 1.2 * quick.nfev <= plain.nfev


def test_differences_are_coarse_in_floats(workshop: Workshop) -> None:
    """In floats differences have three digits, with which iterations hardly converge where stiffness is 10^4 times that
    of the motion; derivatives have all."""
    exact = simulate(workshop.model(stiff_beam(8)), until=1.0, rtol=1e-9, method="radau")
    plain, quick = (
        simulate(workshop.model(stiff_beam(8), "float", derivatives=given), until=1.0, rtol=1e-3, method="radau")
        for given in (False, True)
    )
    assert quick.success
    assert np.max(np.abs(quick.q[-1] - exact.q[-1])) <= 1e-2
    assert 4 * quick.nfev <= plain.nfev


@pytest.mark.hard
def test_what_a_controller_does_is_not_in_the_model(workshop: Workshop) -> None:
    """With a controller derivatives are differences, which know of it: to the bit the motion of a model without them.
    A table depends on time alone, and so needs none."""
    text = ARM + '[[input]]\nname = "knee"\njoint = "joint_2"\n'
    plain, other = workshop.model(text), workshop.model(text, derivatives=True)
    table = {"t": [0.0, 0.2, 0.5], "knee": [0.0, 1.0, -1.0]}

    def spring(t: float, q: Any, u: Any) -> dict[str, float]:
        return {"knee": -40.0 * (q[1] - q[0]) - 8.0 * (u[1] - u[0])}

    for given, fewer in ((spring, False), (table, True)):
        one, two = (simulate(x, until=0.5, method="radau", inputs=given) for x in (plain, other))
        assert one.success and two.success
        assert (two.nfev < one.nfev) == fewer
        assert np.array_equal(one.q, two.q) != fewer
        assert np.max(np.abs(one.q[-1] - two.q[-1])) <= 1e-7


ROUGH = {"normal": [0.0, 1.0], "point": [0.0, 0.0], "restitution": 0.0, "friction": 0.3}
STEEP = {"normal": [0.5, 1.0], "point": [0.0, 0.0], "restitution": 0.0, "friction": 0.2}

RUNS: dict[str, tuple[Callable[[], Any], tuple[float, float], set[tuple[str, ...]]]] = {
    "stiff rocker": (lambda: load_scene(ROOT / "scenes" / "stiff-rocker.toml"), (1.0, 1e-3), {()}),
    "driven walker": (lambda: load_scene(ROOT / "scenes" / "jansen-driven.toml"), (1.0, 1e-3), {()}),
    "rough hexagon": (
        lambda: loop(6, gravity=True, start={"height": 0.01}, ground=[ROUGH]),
        (1.0, 1e-5),
        {(), ("sticks",), ("sticks", "sticks")},
    ),
    "square on a slope": (
        lambda: loop(4, gravity=True, start={"height": 0.01}, ground=[STEEP]),
        (0.6, 1e-3),
        {(), ("slides forward",), ("slides forward", "slides forward")},
    ),
    "ratchet": (lambda: load_scene(ROOT / "scenes" / "ratchet.toml"), (1.0, 1e-4), {(), ("smooth",)}),
    "loose slider-crank": (
        lambda: load_scene(ROOT / "scenes" / "loose-slider-crank.toml"),
        (0.2, 1e-6),
        {(), ("slides forward",), ("slides forward", "slides backward")},
    ),
}

BOUND = 1e-7
"""Of the differences, in parts of the largest derivative; they reach about 1e-11 where surfaces bend little."""


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", RUNS)
def test_known_where_contacts_are_held(name: str, tmp_path: Path) -> None:
    """Along a run, against differences of accelerations with the same contacts held (tests/c/jacobian.c)."""
    made, given, least = RUNS[name]
    folder = generate(made(), out=tmp_path, derivatives=True)
    load_model(folder).write_header(tmp_path / "values.h")
    sources = [ROOT / "tests" / "c" / "jacobian.c", *(folder / f"{x}.c" for x in ("model", "lanes", "derivatives"))]
    folders = [f"-I{tmp_path}", f"-I{folder}", f"-I{ROOT / 'runtime'}", f"-I{RUNTIME / 'core'}"]
    command = ["cc", "-O1", "-std=c11", f"-DMODEL={folder.name}", '-DVALUES="values.h"', *folders]
    program = tmp_path / "jacobian"
    subprocess.run([*command, *map(str, sources), *core_objects(RUNTIME, ["-O1"]), "-lm", "-o", program], check=True)
    done = subprocess.run([program, *map(str, given)], capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    met = defaultdict[tuple[str, ...], int](int)
    for line in done.stdout.splitlines():
        numbers, *modes = line.split(";")
        known, most, wrong = map(float, numbers.split())
        assert not known or wrong <= BOUND * max(most, 1.0), line
        met[tuple(modes)] += bool(known)
    assert least <= {modes for modes, count in met.items() if count}, dict(met)
