"""What effects cost: operations counted by derivation, times measured in turn, and ``ccgen cost --effects``."""

from __future__ import annotations

import csv
import re
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.generator import Scene, chain, generate, load_scene
from ccgen.generator.cli.price import _motion
from ccgen.generator.pipeline import derive_scene, fold_price, prices
from ccgen.generator.program.prices import GROUPS, Price, added, spent
from ccgen.generator.program.program import Counts, Program, lower
from ccgen.runtime import load_model, simulate
from ccgen.runtime.cost.timing import evaluation_times, price, run_times, sample

from ..support.command_line import ccgen, written
from ..support.effect_examples import EXAMPLES, SCENE
from ..support.folders import ROOT
from ..support.tiers import hard
from ..support.workshop import Workshop

HEXAGON = ROOT / "scenes" / "falling-hexagon.toml"
SWING = """\
name = "swing"
[chain]
links = 2
hinged = true
[gravity]
[[torsion]]
joint = "joint_1"
stiffness = 3
damping = 0.2
[[input]]
name = "push"
link = "link_1"
[run]
until = 0.5
rtol = 1e-8
"""


def _program(scene: Scene, fold: bool = False) -> Program:
    return lower(derive_scene(scene, fold)[1])


# -- operations ----------------------------------------------------------------------------------------------------


Priced = tuple[Scene, tuple[Price, ...], dict[str, Any]]


def _priced(scene: Scene) -> Priced:
    """The scene, the prices of all its effects, and what its kernels count."""
    return scene, prices(scene), _counts(_program(scene))


@pytest.fixture(scope="module")
def all_priced(workshop: Workshop) -> Priced:
    """All effects together. Each price is derived anew, so that they are asked for once."""
    return _priced(workshop.scene(SCENE + "".join(EXAMPLES.values())))


@pytest.mark.sample(4)
@pytest.mark.parametrize("key", EXAMPLES)
def test_a_price_is_the_difference_of_two_scene_files(key: str, workshop: Workshop) -> None:
    """Kernel by kernel, against the scene whose text has no such table."""
    _check_price(key, _priced(workshop.scene(SCENE + EXAMPLES[key])), workshop.scene(SCENE))


@pytest.mark.hard
@pytest.mark.large(8)
@pytest.mark.parametrize("key", EXAMPLES)
def test_so_it_is_beside_all_other_effects(key: str, all_priced: Priced, workshop: Workshop) -> None:
    others = "".join(text for other, text in EXAMPLES.items() if other != key)
    _check_price(key, all_priced, workshop.scene(SCENE + others))


def _check_price(key: str, priced: Priced, bare: Any) -> None:
    scene, every, with_ = priced
    (found,) = (p for p in every if p.title in (key, f"{key}_0"))
    without = _counts(_program(bare))
    for group, names in GROUPS.items():
        difference = np.sum([with_.get(name, ZERO) - without.get(name, ZERO) for name in names], axis=0)
        counts = found.added[group]
        kinds = (counts.sums, counts.products, counts.quotients, counts.angles, counts.functions)
        assert list(kinds) == list(difference), group
    acts = key != "law"  # which is told, and acts on nothing until something names it
    assert any(counts != Counts() for counts in found.added.values()) == acts
    own = {p.path for p in _parameters(scene)} - {p.path for p in _parameters(bare)}
    assert {p.path for p in found.parameters} == own


ZERO = np.zeros(5, dtype=int)


def _counts(program: Program) -> dict[str, Any]:
    found = {}
    for function in program.functions:
        c = function.counts()
        found[function.kernel.name] = np.array([c.sums, c.products, c.quotients, c.angles, c.functions])
    return found


def _parameters(scene: Scene) -> tuple[Any, ...]:
    return tuple(p for effect in scene.effects for p in effect.parameters())


def test_prices_by_hand(workshop: Workshop) -> None:
    """A spring and damper on one hinged rod without a load: the moment k φ + c ω, and its quotient by the inertia.

    To the energy it adds ½ k φ², and the power −c ω² is new.
    """
    text = 'name = "x"\n[chain]\nlinks = 1\nhinged = true\n[[torsion]]\njoint = "joint_0"\nstiffness = 2\ndamping = 1\n'
    (found,) = prices(workshop.scene(text))
    assert found.added["acceleration"] == Counts(sums=1, products=3)
    assert found.added["energy and power"] == Counts(sums=0, products=5)
    assert found.added["events"] == Counts()


def test_a_law_costs_what_it_takes_instead_of_a_number(workshop: Workshop) -> None:
    """Where a load names it: -k φ³, two products for the power and one for the gain, once."""
    text = 'name = "x"\n[chain]\nlinks = 1\nhinged = true\n'
    text += '[[motor]]\njoint = "joint_0"\ntorque = "stiff - angle(joint_0)"\n'
    text += '[[law]]\nname = "stiff"\nvalue = "-k*angle(joint_0)**3"\nparameters = { k = 3 }\n'
    motor, law = prices(workshop.scene(text))
    assert (motor.title, law.title) == ("motor_0", "stiff")
    assert law.added["acceleration"] == Counts(products=3)
    assert motor.added["acceleration"].products > 3 and motor.added["acceleration"].sums > 0


def test_functions_are_counted(workshop: Workshop) -> None:
    text = 'name = "x"\n[chain]\nlinks = 1\nhinged = true\n[[motor]]\njoint = "joint_0"\ntorque = "LAW"\n'
    laws = {"exp(t)": (0, 1), "sin(2*t)*tanh(t)": (1, 1), "abs(t)": (0, 0), "tan(t) + log(2 + t)": (0, 2)}
    for law, expected in laws.items():
        (found,) = prices(workshop.scene(text.replace("LAW", law)))
        counts = found.added["acceleration"]
        assert (counts.angles, counts.functions) == expected, law


def test_a_scene_without_effects_has_no_prices() -> None:
    assert prices(chain(2)) == ()
    assert spent(_program(chain(2)))["events"] == Counts()


def test_folding_has_a_price() -> None:
    scene = load_scene(HEXAGON)
    found = fold_price(scene).added
    assert found == added(_program(scene, True), _program(scene))
    assert found["acceleration"] == Counts(products=-12)


# -- scenes without an effect --------------------------------------------------------------------------------------


@pytest.mark.parametrize("key", EXAMPLES)
def test_a_scene_without_an_effect_is_the_scene_that_never_had_it(key: str, workshop: Workshop) -> None:
    others = "".join(text for other, text in EXAMPLES.items() if other != key)
    scene, bare = workshop.scene(SCENE + others + EXAMPLES[key]), workshop.scene(SCENE + others)
    index = next(i for i, effect in enumerate(scene.effects) if effect.title in (key, f"{key}_0"))
    assert scene.without(index).canonical() == bare.canonical()


def test_a_scene_without_its_ground_starts_where_it_started(workshop: Workshop) -> None:
    """A height is measured from the ground; without one the scene keeps its place, and is no other scene's twin."""
    text = 'name = "x"\n[loop]\nlinks = 4\n[start]\nheight = 2.0\n'
    slope = "[[ground]]\nnormal = [0.6, 0.8]\npoint = [3, 5]\nrestitution = 0.5\n"
    scene, bare = workshop.scene(text + slope), workshop.scene(text)
    assert scene.start.poses != bare.start.poses
    without = scene.without(0)
    assert without.effects == () and without.start.poses == scene.start.poses
    assert without.canonical() != bare.canonical()
    x, y = scene.start.poses[0][:2]
    placed = workshop.scene(text.replace("height = 2.0", f"position = [{x!r}, {y!r}]"))
    assert without.canonical() == placed.canonical()
    assert np.array(placed.start.poses) == pytest.approx(np.array(scene.start.poses), abs=1e-14)


# -- times ---------------------------------------------------------------------------------------------------------


def test_a_price_is_of_differences_within_a_round() -> None:
    """Disturbances that fall on whole rounds do not enter what is added."""
    weather = np.array([0.0, 50.0, 3.0, 900.0, 7.0])
    found = price(10.0 + weather, np.array([12.0, 12.5, 12.0, 11.5, 12.0]) + weather)
    assert (found.without, found.with_) == (10.0, 12.0)
    assert (found.added, found.spread) == pytest.approx((2.0, 0.0))


def test_costly_laws_are_seen(workshop: Workshop, tmp_path: Path) -> None:
    """720 exponentials take at least 0.7 µs, on any machine of today: more than other work beside them can hide."""
    laws = [" + ".join(f"exp(-t*{k})" for k in range(90 * i + 1, 90 * i + 91)) for i in range(8)]
    torques = "".join(f'[[torque]]\nlink = "link_0"\ntorque = "{law}"\n' for law in laws)
    scene = workshop.scene(f'name = "x"\n[chain]\nlinks = 1\nhinged = true\n{torques}')
    with_ = load_model(generate(scene, tmp_path / "with"))
    for _ in laws:
        scene = scene.without(0)
    without = load_model(generate(scene, tmp_path / "without"))
    run = simulate(with_, until=1.0)
    times = evaluation_times([without, with_], run, rounds=30)
    assert times.shape == (2, 30) and np.all(times > 0.0)
    found = price(times[0], times[1])
    assert found.added > 0.7e-6
    assert found.with_ > found.without + 0.7e-6


def test_samples_are_rows_of_the_run(workshop: Workshop) -> None:
    run = simulate(workshop.model(SWING), until=10.0, rtol=1e-10)
    t, q, u = sample(run)
    assert len(t) == len(q) == len(u) == 64 < run.t.size
    assert (t[0], t[-1]) == (0.0, 10.0)
    assert np.all(np.isin(t, run.t)) and np.all(np.diff(t) > 0)
    assert np.array_equal(q[-1], run.q[-1])


def test_runs_are_timed_as_the_scene_asks(workshop: Workshop) -> None:
    model = workshop.model(SWING)
    runs, seconds = run_times([model, model], budget=0.0)
    assert [run.t[-1] for run in runs] == [0.5, 0.5]
    assert seconds.shape == (2, 3) and np.all(seconds > 0.0)


def test_timing_lets_other_threads_run(workshop: Workshop) -> None:
    model = workshop.model(SWING)
    q, u = model.start()
    arguments = (np.zeros(1), q[None], u[None], 20_000_000)
    thread = threading.Thread(target=model.kernels.repeat_acceleration, args=arguments)
    thread.start()
    time.sleep(0.01)
    assert thread.is_alive()
    thread.join()


def test_timing_wants_as_many_of_each(workshop: Workshop) -> None:
    model = workshop.model(SWING)
    for t, states in ((2, 1), (0, 0)):
        with pytest.raises(ValueError, match="expected equally many, at least 1"):
            model.kernels.repeat_acceleration(np.zeros(t), np.zeros((states, 2)), np.zeros((states, 2)), 1)


# -- command line --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("folded", [False, hard(True)])
def test_cost_of_effects(folded: bool, tmp_path: Path) -> None:
    (tmp_path / "swing.toml").write_text(SWING)
    done = ccgen("cost", "swing.toml", "--effects", "--out", "figures", *(["--fold"] if folded else []), at=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert written(tmp_path) == ["figures/.ccgen.json", "figures/effects.csv", "swing.toml"]
    with (tmp_path / "figures" / "effects.csv").open(newline="") as file:
        rows = {row["effect"]: row for row in csv.DictReader(file)}
    assert list(rows) == ["gravity", "torsion_0", "push", "folding"]
    scene = load_scene(tmp_path / "swing.toml")
    counted = dict(zip(rows, [*prices(scene, folded), fold_price(scene)], strict=True))
    for title, row in rows.items():
        for group, counts in counted[title].added.items():
            assert int(row[f"{group.replace(' ', '_')}_sums"]) == counts.sums
            assert int(row[f"{group.replace(' ', '_')}_products"]) == counts.products
        for unit in ("ns", "us_per_s"):
            without, with_, spread = (float(row[f"{unit}_{what}"]) for what in ("without", "with", "spread"))
            assert without > 0 and with_ > 0 and spread >= 0
        assert row["motion"] == ("another" if title in ("gravity", "torsion_0") else "the same")
        assert any(line.startswith(f"{title} ") for line in done.stdout.splitlines())
    assert ("swing, folded: " in done.stdout) == folded


def test_a_motion_that_stops_early_is_said(workshop: Workshop) -> None:
    """A torque that is no number from t = 0.5 on ends its run there; without it the rod swings on."""
    rod = 'name = "rod"\n[chain]\nlinks = 1\nhinged = true\n[gravity]\n'
    ends = simulate(workshop.model(rod + '[[torque]]\nlink = "link_0"\ntorque = "sqrt(0.5 - t)"\n'), until=2.0)
    goes_on = simulate(workshop.model(rod), until=2.0)
    assert not ends.success and goes_on.success
    assert re.fullmatch(r"another, stops at 0\.(49\d*|5) s", _motion(goes_on, ends))
    assert _motion(ends, goes_on) == "another"


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("swing.toml", "--fold"), "--fold: found without --effects"),
        (("swing.toml", "--effects", "--error", "1e-6"), "--error: found beside --effects"),
        (("nothing.toml", "--effects"), "nothing.toml"),
        (("swing.toml", "--effects", "--out", "swing.toml"), "--out swing.toml: found a file"),
    ],
)
def test_wrong_input_of_cost(options: tuple[str, ...], words: str, tmp_path: Path) -> None:
    (tmp_path / "swing.toml").write_text(SWING)
    done = ccgen("cost", *options, at=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert words in done.stderr
    assert written(tmp_path) == ["swing.toml"]
