"""Models and runs go to other processes and come back: a model by its folder and parameters, a run with its model."""

from __future__ import annotations

import copy
import multiprocessing
import pickle
import shutil
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.generator import generate, load_scene
from ccgen.runtime import Model, Run, load_model, simulate

SCENE = """
name = "rod"
[chain]
links = 1
hinged = true
[[input]]
name = "torque"
joint = "joint_0"
[gravity]
[[ground]]
point = [0, -0.5]
restitution = 0.5
[run]
until = 1.0
"""


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A rod that turns about its end and falls on a floor."""
    folder = tmp_path_factory.mktemp("rod")
    (folder / "rod.toml").write_text(SCENE)
    return generate(load_scene(folder / "rod.toml"), folder)


def controller(t: float, q: Any, u: Any) -> float:
    return -0.1 * float(u[0])


def same(one: Run, other: Run) -> bool:
    """Equal in every bit, and able to go on from every row alike."""
    arrays = [run._arrays() for run in (one, other)]
    between = (one.t[:-1] + one.t[1:]) / 2
    states = zip(one.at(between), other.at(between), strict=True)
    forces = zip(
        (one.contact_forces(one.t), one.reactions(between)),
        (other.contact_forces(other.t), other.reactions(between)),
        strict=True,
    )
    return (
        all(np.array_equal(arrays[0][name], arrays[1][name]) for name in arrays[0])
        and (one.method, one.drift, one.phases) == (other.method, other.drift, other.phases)
        and all(np.array_equal(a, b) for a, b in (*states, *forces))
    )


def work(model: Model, mass: float) -> Run:
    run: Run = simulate(model, params={"link_0.mass": mass}, inputs=controller)
    return run


@pytest.mark.sample(1)
@pytest.mark.parametrize("start", ["spawn", "fork", "forkserver"])
@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of forks beside threads, by the Python
def test_process_pools(start: str, package: Path) -> None:
    model, masses = load_model(package), (0.5, 1.0, 2.0)
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context(start)) as pool:
        runs = list(pool.map(work, [model] * len(masses), masses))
    assert [run.model.parameters["link_0.mass"] for run in runs] == list(masses)
    assert all(len(run.impacts) > 1 for run in runs)
    assert all(same(run, work(model, mass)) for run, mass in zip(runs, masses, strict=True))


@pytest.mark.parametrize(
    "again", [copy.copy, copy.deepcopy, lambda thing: pickle.loads(pickle.dumps(thing))], ids=["copy", "deep", "pickle"]
)
def test_copies_are_their_own(again: Any, package: Path) -> None:
    model = load_model(package)
    model.parameters["gravity.g"] = 1.62
    other = again(model)
    assert other.parameters["gravity.g"] == 1.62 and other.folder == package
    other.parameters["gravity.g"] = 5.0
    assert model.parameters["gravity.g"] == 1.62
    for inputs in (None, 0.3, {"t": [0.0, 0.5, 1.0], "torque": [0.0, 1.0, -1.0]}, controller):
        run = simulate(model, inputs=inputs)
        assert same(again(run), run)
        found = again(run)
        with pytest.raises(ValueError, match="read-only"):
            found.q[0, 0] = 1.0
        with pytest.raises(ValueError, match="read-only"):
            found.impacts[0].u_minus[0] = 1.0


def test_inputs_changed_after_the_run_change_nothing(package: Path) -> None:
    table = {"t": [0.0, 1.0], "torque": [0.0, 1.0]}
    run = simulate(load_model(package), inputs=table)
    table["torque"][1] = 50.0
    assert same(pickle.loads(pickle.dumps(run)), run)


def test_a_controller_without_a_name_stays_behind(package: Path) -> None:
    run = simulate(load_model(package), inputs=lambda t, q, u: 0.1)
    assert same(copy.deepcopy(run), run)
    found = pickle.loads(pickle.dumps(run))
    assert all(np.array_equal(one, other) for one, other in zip(found.at(run.t), run.at(run.t), strict=True))
    with pytest.raises(ValueError, match="pickled without its controller"):
        found.at((run.t[0] + run.t[1]) / 2)


def test_a_pickle_finds_its_model_or_says_why_not(package: Path, tmp_path: Path) -> None:
    place = tmp_path / "rod"
    shutil.copytree(package, place)
    pickled = pickle.dumps(load_model(place))
    shutil.rmtree(place)
    with pytest.raises(FileNotFoundError, match=f"{place}: found no model, expected rod; generate it there again"):
        pickle.loads(pickled)
    (tmp_path / "rod.toml").write_text(SCENE.replace("restitution = 0.5", "restitution = 0.4"))
    generate(load_scene(tmp_path / "rod.toml"), tmp_path)
    with pytest.raises(ImportError, match=f"{place}: found another model"):
        pickle.loads(pickled)


def test_a_folded_model_is_pickled(package: Path, tmp_path: Path) -> None:
    model = load_model(generate(load_scene(package.parent / "rod.toml"), tmp_path, fold=True))
    assert pickle.loads(pickle.dumps(model)).acceleration([0.1], [0.2]) == model.acceleration([0.1], [0.2])


def test_a_model_without_a_package_is_not_pickled(package: Path) -> None:
    model = load_model(package)
    with pytest.raises(TypeError, match="found a model without a package, which cannot be pickled"):
        pickle.dumps(Model(model._descriptor, model.data))
