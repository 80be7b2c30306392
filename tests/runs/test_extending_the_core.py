"""The method and the law of impact that docs/extending.md adds: a file and a line each, and they do what it says."""

from __future__ import annotations

import re
import shutil

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import simulate

from ..support.c_library import Library
from ..support.folders import ROOT
from ..support.workshop import Workshop

TEXT = (ROOT / "docs" / "extending.md").read_text()


@pytest.fixture(scope="module")
def extended(tmp_path_factory: pytest.TempPathFactory) -> Library:
    """The core with the two files and the two lines."""
    runtime = tmp_path_factory.mktemp("extended") / "runtime"
    for name in ("core", "ccgen.h", "model.h"):
        copy = shutil.copytree if (ROOT / "runtime" / name).is_dir() else shutil.copy
        runtime.mkdir(exist_ok=True)
        copy(ROOT / "runtime" / name, runtime / name)
    for file, code in re.findall(r"In `runtime/(core/\S+\.[ch])`:\n\n```c\n(.*?)```", TEXT, re.S):
        (runtime / file).write_text(code)
    for file, line in re.findall(r"a line in `runtime/(core/\S+\.h)`:\n\n```c\n(.*?)```", TEXT, re.S):
        was = (runtime / file).read_text()
        now = re.sub(r"#define ALL_\w+\(.*?\n\n", lambda _, line=line: f"{line}\n", was, flags=re.S)
        assert now.count("\\\n") == was.count("\\\n") + 1
        (runtime / file).write_text(now)
    return Library(runtime, runtime / "libccgen.so")


def test_the_method_has_its_order(extended: Library, workshop: Workshop) -> None:
    """The third impact of the falling hexagon: half the step, a sixteenth of the error."""
    model = workshop.model(load_scene(ROOT / "scenes" / "falling-hexagon.toml"))
    exact, errors = simulate(model, rtol=1e-13).impacts[2].t, []
    for step in (4e-3, 2e-3, 1e-3):
        outcome, made = extended.create(model, method=b"rk4", fixed_step=step)
        assert outcome == "done" and made.reset(*model.start()) == "done"
        times = [made.step_to_event(1.0) for _ in range(3)]
        assert {found for found, _ in times} == {"done"}
        errors.append(abs(times[-1][1].t - exact))
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert np.all(np.abs(orders - 4.0) < 0.3), orders


def test_the_law_ends_all_approach(extended: Library, workshop: Workshop) -> None:
    """Of a scene with restitution 0.5: velocities after the first impact are those of Newton's law without any."""
    model = workshop.model(load_scene(ROOT / "scenes" / "falling-hexagon.toml"))
    after = {}
    for law, e in ((b"plastic", 0.5), (b"newton", 0.0), (b"newton", 0.5)):
        other = model.with_parameters({"ground_0.restitution": e})
        outcome, made = extended.create(other, law=law)
        assert outcome == "done" and made.reset(*model.start()) == "done"
        assert made.step_to_event(1.0)[1].impacts == 1
        after[law, e] = made.motion()[2]
    assert np.abs(after[b"plastic", 0.5] - after[b"newton", 0.0]).max() <= 1e-12
    assert np.abs(after[b"plastic", 0.5] - after[b"newton", 0.5]).max() > 0.1
