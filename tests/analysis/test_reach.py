"""Inverse kinematics against closed forms: arms, a five-bar, a slider-crank; what is out of reach, and how far."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import OutOfReach, reach
from ccgen.runtime.analysis.wants import read_wanted
from ccgen.runtime.faults import Faults

from ..oracles.maximal import Array
from ..support.folders import SCENES
from ..support.mixed_joints import KINDS, mixed
from ..support.platforms import ARM, FIVE_BAR, FORE, STOPPED, UPPER
from ..support.workshop import Workshop

OVER = ARM + '[[ground]]\nrestitution = 0\npoint = [0, -0.1]\ncontacts = ["fore.T"]\n'


def arm_angles(x: float, y: float, bend: float) -> Array:
    """Absolute angles of the two links of the arm with its tip at (x, y); its elbow turns in the direction ``bend``."""
    far = np.hypot(x, y)
    elbow = bend * np.arccos((far**2 - UPPER**2 - FORE**2) / (2.0 * UPPER * FORE))
    upper = np.arctan2(y, x) - np.arctan2(FORE * np.sin(elbow), UPPER + FORE * np.cos(elbow))
    return np.array([upper, upper + elbow])


@pytest.fixture(scope="module")
def arm(workshop: Workshop) -> Any:
    return workshop.model(ARM)


# -- reached -----------------------------------------------------------------------------------------------------------


def test_both_elbows_of_an_arm(arm: Any) -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        far, way, bend = rng.uniform(0.25, 0.95), rng.uniform(-3.0, 3.0), rng.choice([-1.0, 1.0])
        x, y = far * np.cos(way), far * np.sin(way)
        wanted = arm_angles(x, y, bend)
        found = reach(
            arm, wanted + rng.uniform(-0.15, 0.15, 2) * abs(np.sin(wanted[1] - wanted[0])), {"fore.T": (x, y)}
        )
        assert found == pytest.approx(wanted, abs=1e-12)


def test_from_a_stretched_arm(arm: Any) -> None:
    """Straight at the target, from where no velocity leads to it."""
    found = reach(arm, [0.5, 0.5], {"fore.T": (0.6 * np.cos(0.5), 0.6 * np.sin(0.5))})
    bend = np.sign(found[1] - found[0])
    assert found == pytest.approx(arm_angles(0.6 * np.cos(0.5), 0.6 * np.sin(0.5), bend), abs=1e-12)


def test_at_the_very_edge(arm: Any) -> None:
    found = reach(arm, [0.3, 0.9], {"fore.T": (0.6, 0.8)})
    assert arm.point("fore.T", found) == pytest.approx([0.6, 0.8], abs=1e-12)
    assert found == pytest.approx([np.arctan2(0.8, 0.6)] * 2, abs=1e-6)


def test_angles_heights_and_nearest(arm: Any) -> None:
    assert reach(arm, [0.3, 0.9], angles={"elbow": "-90 deg"})[1] == pytest.approx(0.3 - np.pi / 2, abs=1e-13)
    assert reach(arm, [0.3, 0.9], angles={"fore": 1.2, "upper": "0.1 rad"}) == pytest.approx([0.1, 1.2], abs=1e-13)
    assert reach(arm, [0.3, 6.9], angles={"fore": 0.5})[1] == pytest.approx(0.5 + 2.0 * np.pi, abs=1e-13)
    start = np.array([0.3, 0.9])
    found = reach(arm, start, {"fore.T": (None, 0.5)})
    assert arm.point("fore.T", found)[1] == pytest.approx(0.5, abs=1e-13)
    # the nearest in the joints: their displacements go with what the height feels of them
    moved = np.array([found[0] - start[0], found[1] - found[0] - (start[1] - start[0])])
    feels = np.array([UPPER * np.cos(found[0]) + FORE * np.cos(found[1]), FORE * np.cos(found[1])])
    assert moved[0] * feels[1] == pytest.approx(moved[1] * feels[0], abs=1e-12)


def test_five_bar_by_its_two_arms(workshop: Workshop) -> None:
    """Each side is an arm; a start with loops open is put right too."""
    model = workshop.model(FIVE_BAR)
    q, _ = model.start()
    for x, y in ((0.1, 0.35), (0.15, 0.3), (-0.02, 0.38)):
        found = reach(model, q, {"tip": (x, y)})
        assert np.max(np.abs(model.closure(found))) <= 1e-15
        for crank, base in (("left", 0.0), ("right", 0.2)):
            far = np.hypot(x - base, y)
            bend = np.arccos((0.2**2 + far**2 - 0.3**2) / (2.0 * 0.2 * far)) * (1.0 if crank == "left" else -1.0)
            wanted = np.arctan2(y, x - base) + bend
            assert model.poses(found)[model.links.index(crank), 2] == pytest.approx(wanted, abs=1e-12)
    again = reach(model, q + 0.2, {"tip": (0.1, 0.35)})
    assert again == pytest.approx(reach(model, q, {"tip": (0.1, 0.35)}), abs=1e-11)


def test_lengths_of_slides(workshop: Workshop) -> None:
    """The crank's angle of a slider-crank from its piston's place, by the cosine rule."""
    model = workshop.model(load_scene(SCENES / "slider-crank.toml"))
    q, _ = model.start()
    found = reach(model, q, slides={"guide": 0.7})
    wanted = np.arccos((0.2**2 + 0.7**2 - 0.6**2) / (2.0 * 0.2 * 0.7))
    assert found[0] == pytest.approx(wanted, abs=1e-12)
    quick = workshop.model(load_scene(SCENES / "quick-return.toml"))
    q, _ = quick.start()
    along = float(quick.slides(q)["slot"]) + 0.02  # of a joint that is cut
    assert quick.slides(reach(quick, q, slides={"slot": along}))["slot"] == pytest.approx(along, abs=1e-13)


def test_stops_bar_one_elbow(workshop: Workshop) -> None:
    """At 90° forward the stop is in the way; backward it is not."""
    stopped = workshop.model(STOPPED)
    far = np.hypot(UPPER, FORE)
    found = reach(stopped, [0.2, 1.2], {"fore.T": (far, 0.0)})
    assert found == pytest.approx(arm_angles(far, 0.0, -1.0), abs=1e-12)


@pytest.mark.sample(2)
@pytest.mark.parametrize("number", range(len(KINDS)))
def test_random_mechanisms_find_back(number: int, workshop: Workshop) -> None:
    """Where a motion has led from here is reached from here, told by all that can be wanted."""
    model, q, _ = mixed(workshop, number)
    rng, free = np.random.default_rng(number), model.motions(q)
    for _ in range(5):
        step = free @ rng.normal(size=free.shape[1])
        there = model.assemble(q + 0.3 * step / np.max(np.abs(step)))
        name = str(rng.choice(model.points[len(model.joints) :]))
        found = reach(model, q, {name: tuple(model.point(name, there))})
        assert model.point(name, found) == pytest.approx(model.point(name, there), abs=1e-12)
        assert np.max(np.abs(model.closure(found)), initial=0.0) <= 1e-13
        moved = [model.displacements() @ (one - q) for one in (found, there)]
        assert np.linalg.norm(moved[0]) <= np.linalg.norm(moved[1]) * (1.0 + 1e-9)  # nearest, so no farther
        angles, slides = model.joint_angles(there), model.slides(there)
        found = reach(model, q, None, angles, slides)  # all but where a floating one is
        assert model.displacements()[: len(model.joints)] @ (found - there) == pytest.approx(0.0, abs=1e-10)


@pytest.mark.parametrize("number", range(len(KINDS)))
def test_derivatives_of_what_is_wanted(number: int, workshop: Workshop) -> None:
    """Rows and second derivatives along q + u t against differences."""
    model, q, u = mixed(workshop, number)
    named = read_wanted(
        model,
        {name: (0, 0) for name in model.points if np.any(model.point_jacobian(name, q))},
        dict.fromkeys(model.joint_angles(q), 0.0),
        dict.fromkeys(model.slides(q), 0.0),
        Faults(),
    )
    h, weights = 1e-2, np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
    path = q + u * h * np.arange(-4, 5)[:, None]
    for one, _ in named:
        values = np.array([one.value(at) for at in path])
        rates = np.array([one.rows(at) @ u for at in path])
        assert rates[4] == pytest.approx(weights @ values / h, abs=1e-8)
        assert one.bias(q, u[None])[0] == pytest.approx(weights @ rates / h, abs=1e-8)


# -- out of reach ------------------------------------------------------------------------------------------------------


def test_how_far_out_of_reach(arm: Any) -> None:
    for x, y in ((2.0, 0.0), (1.0, 1.0), (-3.0, 4.0), (0.1, 0.05), (1.0 + 1e-4, 0.0), (1.0 + 1e-9, 0.0)):
        far = np.hypot(x, y)
        edge = UPPER + FORE if far > 1.0 else UPPER - FORE
        with pytest.raises(
            OutOfReach, match=r"points: fore\.T: found \(.*\) m, expected what is within reach"
        ) as caught:
            reach(arm, [0.3, 0.9], {"fore.T": (x, y)})
        assert caught.value.misses["fore.T"] == pytest.approx(abs(far - edge), abs=1e-12)
        assert arm.point("fore.T", caught.value.q) == pytest.approx([x * edge / far, y * edge / far], abs=1e-7)
        again = pickle.loads(pickle.dumps(caught.value))
        assert str(again) == str(caught.value) and again.misses == caught.value.misses
    with pytest.raises(OutOfReach, match=r"found \(2, 0\) m.*the nearest is \(1, 0\) m, 1 m away$"):
        reach(arm, [0.3, 0.9], {"fore.T": (2.0, 0.0)})


def test_out_of_reach_behind_a_stop(workshop: Workshop) -> None:
    stopped = workshop.model(STOPPED)
    edge = np.sqrt(UPPER**2 + FORE**2 + 2.0 * UPPER * FORE * np.cos(np.radians(100.0)))
    with pytest.raises(OutOfReach, match=r"m away; elbow on stop_0\.lowest is closed there") as caught:
        reach(stopped, [0.3, 0.9], {"fore.T": (0.3, 0.4)})
    assert caught.value.misses["fore.T"] == pytest.approx(edge - 0.5, abs=1e-10)


def test_out_of_reach_below_the_ground(workshop: Workshop) -> None:
    over = workshop.model(OVER)
    with pytest.raises(OutOfReach, match=r"fore\.T on ground_0 is closed there") as caught:
        reach(over, [0.3, 0.9], {"fore.T": (0.5, -0.3)})
    assert caught.value.misses["fore.T"] == pytest.approx(0.2, abs=1e-9)
    assert over.point("fore.T", caught.value.q) == pytest.approx([0.5, -0.1], abs=1e-8)


def test_out_of_reach_of_a_closed_loop(workshop: Workshop) -> None:
    """Of the five-bar's tip: both arms stretched is beyond, on the middle line."""
    model = workshop.model(FIVE_BAR)
    with pytest.raises(OutOfReach) as caught:
        reach(model, model.start()[0], {"tip": (0.1, 0.9)})
    assert caught.value.misses["tip"] == pytest.approx(0.9 - np.sqrt(0.5**2 - 0.1**2), abs=1e-12)
    assert np.max(np.abs(model.closure(caught.value.q))) <= 1e-14


def nearest_in_rings(place: Array) -> float:
    """How far a place is from those at 0.1 m to 0.5 m from both (0, 0) and (0.2, 0): of the five-bar's tip."""
    feet = np.array([[0.0, 0.0], [0.2, 0.0]])
    candidates = [place]
    for foot in feet:
        way = (place - foot) / np.linalg.norm(place - foot)
        candidates += [foot + edge * way for edge in (0.1, 0.5)]
    for one in (0.1, 0.5):
        for other in (0.1, 0.5):  # corners: where circles about both feet meet
            x = (one**2 - other**2 + 0.2**2) / 0.4
            candidates += [np.array([x, sign * np.sqrt(max(one**2 - x**2, 0.0))]) for sign in (1.0, -1.0)]
    spans = np.linalg.norm(np.array(candidates)[:, None] - feet, axis=2)
    inside = np.all((spans >= 0.1 - 1e-12) & (spans <= 0.5 + 1e-12), axis=1)
    return float(min(np.linalg.norm(np.array(candidates)[inside] - place, axis=1)))


@pytest.mark.hard
def test_everywhere_around_a_five_bar(workshop: Workshop) -> None:
    """Within reach it is there; beyond it is as far as the place is from two rings."""
    model, rng = workshop.model(FIVE_BAR), np.random.default_rng(6)
    q, beyond = model.start()[0], 0
    for _ in range(25):
        place = rng.uniform([-0.6, -0.7], [0.8, 0.7])
        far = nearest_in_rings(place)
        try:
            found = reach(model, q, {"tip": tuple(place)})
        except OutOfReach as refusal:
            assert refusal.misses["tip"] == pytest.approx(far, abs=1e-9) and far > 0.0
            beyond += 1
        else:
            assert model.point("tip", found) == pytest.approx(place, abs=1e-13)
    assert 5 <= beyond <= 20


def test_wants_that_contradict(arm: Any) -> None:
    with pytest.raises(OutOfReach, match=r"each is within reach alone, not all together") as caught:
        reach(arm, [0.3, 0.9], {"fore.T": (0.5, 0.6)}, {"fore": "30 deg"})
    assert set(caught.value.misses) == {"fore.T", "fore"} and min(caught.value.misses.values()) > 0.05
    assert str(caught.value).count("expected what is within reach") == 2


# -- wrong use ---------------------------------------------------------------------------------------------------------


def test_wrong_wants_are_refused(arm: Any) -> None:
    with pytest.raises(ValueError) as caught:
        reach(arm, [0.3, 0.9], {"tip": (0, 0), "ground.O": (0, 0), "fore.T": 1}, {"wrist": 2}, {"guide": 1})
    assert str(caught.value).splitlines() == [
        "points: name: found point 'tip', expected one of: shoulder, elbow, upper.A, upper.B, fore.A, fore.T",
        "points: found 'ground.O', which is on the ground, expected a point that moves",
        "angles: found 'wrist', expected a link, or a joint that turns, of: upper, fore, shoulder, elbow",
        "slides: found 'guide', expected a sliding joint of: none",
        "points: fore.T: found 1, expected (x, y) in m, of which one may be None",
    ]
    with pytest.raises(ValueError) as caught:
        reach(arm, [0.3, 0.9], {"fore.T": (1,), "elbow": (None, None), "upper.B": ("a", 0)}, {"fore": "30"})
    assert str(caught.value).splitlines() == [
        "points: fore.T: found (1,), expected (x, y) in m, of which one may be None",
        "points: elbow: found (None, None), expected (x, y) in m, of which one may be None",
        "points: upper.B: found 'a', expected numbers",
        "angles: fore: found '30', expected a number of rad or a text as \"30 deg\"",
    ]
    for wrong in ({"fore": np.nan}, {"fore": [1.0, 2.0]}):
        with pytest.raises(ValueError, match=r"angles: fore: found .*, expected a finite number"):
            reach(arm, [0.3, 0.9], angles=wrong)
    with pytest.raises(ValueError, match=r"found nothing wanted, expected at least one; or use model\.assemble"):
        reach(arm, [0.3, 0.9])
    with pytest.raises(ValueError, match="points: found list, expected a mapping by name"):
        reach(arm, [0.3, 0.9], [0.5, 0.6])  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"q: found shape \(2, 2\), expected one configuration \(2,\)"):
        reach(arm, [[0.3, 0.9], [0.3, 0.9]], {"fore.T": (0.5, 0.6)})
