"""The method and the law of impact that docs/extending.md adds: a file and a line each, and they do what it says."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import simulate

from ..support.c_library import Library
from ..support.extending import copy_core, extend_core, extend_generator
from ..support.folders import ROOT
from ..support.workshop import Workshop


@pytest.fixture(scope="module")
def extended(tmp_path_factory: pytest.TempPathFactory) -> Library:
    """The core with the files and the lines."""
    runtime = tmp_path_factory.mktemp("extended") / "runtime"
    copy_core(runtime)
    extend_core(runtime)
    return Library(runtime, runtime / "libccgen.so")


@pytest.mark.hard
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


@pytest.mark.hard
def test_without_an_estimate_of_its_errors_a_method_needs_a_step(extended: Library, workshop: Workshop) -> None:
    model = workshop.model(load_scene(ROOT / "scenes" / "falling-hexagon.toml"))
    for method in (b"rk4", b"moreau"):
        outcome, nothing = extended.create(model, method=method)
        assert outcome == "bad_settings" and not nothing.address
        assert extended.create(model, method=method, fixed_step=1e-3)[0] == "done"


@pytest.mark.hard
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


@pytest.fixture(scope="module")
def ccgen(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The whole of ccgen with them, compiled for doubles and imported from this folder."""
    site = tmp_path_factory.mktemp("site")
    package = site / "ccgen"
    kept = shutil.ignore_patterns("__pycache__", "*.so", "*.pyd")
    shutil.copytree(ROOT / "front", package, ignore=kept)
    for name in ("generator", "templates", "runtime"):
        shutil.copytree(ROOT / name, package / name, ignore=kept)
    for name in ("docs/scripts/model_schema.py", "docs/model.md"):
        (package / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, package / name)
    extend_core(package / "runtime")
    extend_generator(package / "generator")
    run(site, str(package / "docs" / "scripts" / "model_schema.py"), "--write")
    runtime, made = package / "runtime", site / "_core.c"
    run(site, "-m", "cython", str(runtime / "_core.pyx"), "-o", str(made))
    folders = [runtime, runtime / "core", np.get_include(), sysconfig.get_path("include")]
    flags = ["-O0", "-w", "-shared", "-fPIC", "-std=c11", "-fvisibility=hidden", "-DCCGEN_PRECISION=0"]
    sources = [str(made), *map(str, (runtime / "core").rglob("*.c"))]
    target = runtime / f"_core{sysconfig.get_config_var('EXT_SUFFIX')}"
    subprocess.run(
        ["cc", *flags, *(f"-I{folder}" for folder in folders), *sources, "-lm", "-o", str(target)], check=True
    )
    return site


def run(site: Path, *arguments: str) -> str:
    """What Python prints that imports ccgen from this folder."""
    done = subprocess.run([sys.executable, *arguments], **started(site), check=False)
    assert done.returncode == 0, done.stderr
    return str(done.stdout)


def started(site: Path) -> dict[str, Any]:
    """How."""
    environment = {**os.environ, "PYTHONPATH": str(site), "CCGEN_CACHE_DIR": str(site / "cache")}
    return {"cwd": site, "env": environment, "capture_output": True, "text": True}


LAWS_OF_SCENES = """
import json, sys
from ccgen.generator import generate, load_scene
from ccgen.runtime import load_model, simulate
import ccgen.runtime as used

assert used.__path__[0].startswith(sys.argv[1])
found = {}
for name in sys.argv[2:]:
    model = load_model(generate(load_scene(f"{name}.toml"), name))
    found[name] = model.data["law"], simulate(model, until=1.0).impacts[0].u_plus.tolist()
print(json.dumps(found))
"""

TWO_RODS = """
[chain]
links = 2
hinged = true

[gravity]

[[ground]]
point = [0.0, -1.2]
restitution = {e}
contacts = ["link_1.B"]

[[ground]]
point = [0.0, -1.9]
restitution = {e}
contacts = ["link_1.B"]

[run]
law = "{law}"
"""


@pytest.mark.skipif(os.name != "posix" or not shutil.which("cc"), reason="needs cc")
@pytest.mark.hard
def test_the_law_is_that_of_scenes_that_name_it(ccgen: Path) -> None:
    """In [run], or at a ground as older scenes do; grounds that disagree are refused, as with any other law."""
    scenes = {"own": ("plastic", 0.5), "newton": ("newton", 0.5), "none": ("newton", 0.0)}
    texts = {name: TWO_RODS.format(law=law, e=e) for name, (law, e) in scenes.items()}
    texts["ground"] = at_grounds(texts["own"], "plastic")
    for name, text in texts.items():
        (ccgen / f"{name}.toml").write_text(text)
    found = json.loads(run(ccgen, "-c", LAWS_OF_SCENES, str(ccgen), *texts))
    laws = {name: law for name, (law, _) in found.items()}
    assert laws == {"own": "plastic", "newton": "newton", "none": "newton", "ground": "plastic"}
    after = {name: np.array(u) for name, (_, u) in found.items()}
    for name in ("own", "ground"):
        assert np.abs(after[name] - after["none"]).max() <= 1e-12
        assert np.abs(after[name] - after["newton"]).max() > 0.1
    (ccgen / "beside.toml").write_text(at_grounds(texts["own"], "newton", "plastic"))
    refused = subprocess.run([sys.executable, *SHOW, "beside.toml"], **started(ccgen), check=False)
    assert refused.returncode == 2 and not refused.stdout
    told = (
        'ground[1].law: found "newton" at ground[0].law, "plastic" at ground[1].law, expected one law for all impacts;'
    )
    assert told in refused.stderr and len(refused.stderr.splitlines()) == 1
    three = TWO_RODS.format(law="newton", e=0.5).replace("[[ground]]", '[[ground]]\nlaw = "plastic"', 1)
    (ccgen / "three.toml").write_text(three.replace("point = [0.0, -1.9]", 'law = "poisson"\npoint = [0.0, -1.9]'))
    refused = subprocess.run([sys.executable, *SHOW, "three.toml"], **started(ccgen), check=False)
    told = 'found "newton" at run.law, "plastic" at ground[0].law, "poisson" at ground[1].law, expected one law'
    assert told in refused.stderr and len(refused.stderr.splitlines()) == 1


SHOW = ("-c", "from ccgen.generator.cli import main; main()", "show")


def at_grounds(text: str, *laws: str) -> str:
    """The scene with laws at its first grounds, and none in ``[run]``."""
    before, *grounds = text.partition("[run]")[0].split("[[ground]]\n")
    named = [f'law = "{law}"\n' for law in laws] + [""] * (len(grounds) - len(laws))
    return before + "".join(f"[[ground]]\n{law}{ground}" for law, ground in zip(named, grounds, strict=True))


STEPS = """
from ccgen.generator import generate, load_scene
from ccgen.runtime import load_model, methods, simulate
from ccgen.runtime.cost.accuracy import compare

assert {*methods()} - {*methods(estimating=True)} == {"rk4", "moreau"}
model = load_model(generate(load_scene("own.toml"), "own"))
try:
    simulate(model, method="rk4")
except ValueError as error:
    print(error)
exact, coarse = simulate(model, until=0.1), simulate(model, until=0.1, method="rk4", step=1e-3)
assert abs(exact.q[-1] - coarse.q[-1]).max() < 1e-8 and len(coarse.t) == 101
assert abs(coarse.at(0.0505)[0] - exact.at(0.0505)[0]).max() < 1e-8
assert simulate(model, state=coarse.state, until=0.2).success
assert {one.method for one in compare(model, exact, tolerances=[1e-6])} == {*methods(estimating=True)}
"""


@pytest.mark.hard
@pytest.mark.skipif(os.name != "posix" or not shutil.which("cc"), reason="needs cc")
def test_such_a_method_is_refused_without_a_step_in_python_and_by_the_command(ccgen: Path) -> None:
    (ccgen / "own.toml").write_text(TWO_RODS.format(law="plastic", e=0.5))
    said = run(ccgen, "-c", STEPS)
    expected = "step: found none beside method 'rk4', which has no estimate of its errors to choose steps by, expected"
    assert said.startswith(expected) and "dop853" in said and "moreau" not in said
    command = ("-c", "from ccgen.generator.cli import main; main()", "run", "own.toml", "--method", "rk4")
    assert "t = 0.1 s" in run(ccgen, *command, "--step", "1e-3", "--until", "0.1")
    refused = subprocess.run([sys.executable, *command], **started(ccgen), check=False)
    assert refused.returncode == 2 and not refused.stdout
    assert refused.stderr.startswith(f"--{expected}") and "Traceback" not in refused.stderr
