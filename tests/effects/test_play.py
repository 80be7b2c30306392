"""Springs with play: periods in closed form, energy and order across both ends of the play, and wrong tables."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ccgen.generator.scene import SceneError
from ccgen.runtime import Model, simulate, static_equilibrium

from ..support.workshop import Workshop

INERTIA, MASS, STIFFNESS = 0.02, 1.5, 8.0
PLAY = math.radians(2.0)
ROTOR = (
    'name = "rotor"\n[ground_link]\npoints = { O = [0, 0] }\n[[link]]\nname = "rotor"\nmass = 1\n'
    f'inertia = {INERTIA}\ncom = [0, 0]\npoints = {{ O = [0, 0] }}\n[[joint]]\nname = "shaft"\n'
    'between = ["ground.O", "rotor.O"]\n'
)
COUPLING = f'[[torsion]]\nname = "coupling"\njoint = "shaft"\nstiffness = {STIFFNESS}\nangle = 0.3\nplay = "2 deg"\n'
SLIDER = (
    'name = "slider"\n[ground_link]\npoints = { O = [0, 0], P = [0, 1] }\n[[link]]\nname = "body"\n'
    f'mass = {MASS}\ninertia = 0.02\ncom = [0, 0]\npoints = {{ C = [0, 0] }}\n[[joint]]\nname = "guide"\n'
    'type = "prismatic"\nbetween = ["ground.O", "body.C"]\naxis = [0, 1]\nangle = 0\n'
)
ROD = (
    f'[[spring]]\nname = "rod"\nbetween = ["ground.P", "body.C"]\nstiffness = {STIFFNESS}\n'
    'length = 0.6\nplay = "2 cm"\n'
)


def period(speed: float, play: float, omega: float) -> float:
    """Twice through the play at constant speed, and a half swing on either side of it."""
    return 2.0 * play / speed + 2.0 * math.pi / omega


CASES = {
    "turning": (ROTOR + COUPLING, 0.3, PLAY, math.sqrt(STIFFNESS / INERTIA), 2.5),
    "sliding": (SLIDER + ROD, 0.4, 0.02, math.sqrt(STIFFNESS / MASS), 0.15),
}


def swinging(t: float, speed: float, play: float, omega: float) -> float:
    """The way from rest at t, begun in the middle of the play with ``speed``."""
    t %= period(speed, play, omega)
    half = 0.5 * period(speed, play, omega)
    sign, t = (1.0, t) if t < half else (-1.0, t - half)
    free = 0.5 * play / speed
    if t < free:
        return sign * speed * t
    if t < half - free:
        return sign * (0.5 * play + speed / omega * math.sin(omega * (t - free)))
    return sign * speed * (half - t)


@pytest.mark.parametrize("kind", CASES)
@pytest.mark.parametrize(("method", "most"), [("gauss", 10), ("dop853", 20), ("dopri5", 1000), ("radau", 100)])
def test_swings_through_the_play(kind: str, method: str, most: float, workshop: Workshop) -> None:
    """Ten periods, 40 kinks: where it is, and its energy."""
    text, rest, play, omega, speed = CASES[kind]
    model = workshop.model(text)
    until = 10.3 * period(speed, play, omega)
    run = simulate(model, [rest], [speed], until=until, rtol=1e-10, method=method)
    assert run.q[-1, 0] - rest == pytest.approx(swinging(until, speed, play, omega), abs=most * 1e-10)
    assert run.energy_drift <= most * 1e-10
    times = np.linspace(0.0, until, 97)
    wanted = [rest + swinging(t, speed, play, omega) for t in times]
    assert run.at(times)[0][:, 0] == pytest.approx(wanted, abs=most * 1e-10)


@pytest.mark.parametrize(("method", "order"), [("dopri5", 5), ("radau", 5), ("dop853", 8)])
def test_methods_keep_their_order_across_play(method: str, order: int, workshop: Workshop) -> None:
    text, rest, play, omega, speed = CASES["turning"]
    model = workshop.model(text)
    until = 1.3 * period(speed, play, omega)
    errors = [
        abs(simulate(model, [rest], [speed], until=until, step=h / omega, method=method).q[-1, 0] - rest
            - swinging(until, speed, play, omega))
        for h in (0.4, 0.2)
    ]  # fmt: skip
    assert errors[1] > 1e-15 and math.log2(errors[0] / errors[1]) >= order - 0.7


@pytest.mark.parametrize("kind", CASES)
def test_damping_acts_in_engagement_alone(kind: str, workshop: Workshop) -> None:
    """Through the play the speed stays as it is; each engagement takes the same part of it: a spring and a damper that
    push until both together do no more, which is the closed form of half a swing."""
    text, rest, play, omega, speed = CASES[kind]
    inertia = INERTIA if kind == "turning" else MASS
    damping = 0.3 * math.sqrt(STIFFNESS * inertia)
    model = workshop.model(text + f"damping = {damping}\n")
    run = simulate(model, [rest], [speed], until=4.0 * period(speed, play, omega), rtol=1e-11)
    free = np.abs(run.q[:, 0] - rest) < 0.5 * play * (1.0 - 1e-9)
    speeds = np.unique(np.round(np.abs(run.u[free, 0]), 9))[::-1]
    decay, swing = 0.15 * omega, omega * math.sqrt(1.0 - 0.15**2)
    end = (math.pi - math.atan2(2.0 * 0.15 * math.sqrt(1.0 - 0.15**2), 1.0 - 2.0 * 0.15**2)) / swing
    left = math.exp(-decay * end) * abs(math.cos(swing * end) - decay / swing * math.sin(swing * end))
    assert len(speeds) >= 4
    assert speeds[1:] / speeds[:-1] == pytest.approx(np.full(len(speeds) - 1, left), abs=1e-6)
    assert run.energy_drift <= 1e-9


def test_a_weight_hangs_at_the_end_of_the_play(workshop: Workshop) -> None:
    model = workshop.model(SLIDER + ROD + "[gravity]\n")
    found = static_equilibrium(model, [0.2])
    assert found.q == pytest.approx([1.0 - 0.6 - 0.01 - MASS * 9.81 / STIFFNESS], abs=1e-10)


def test_without_play_it_is_the_spring(workshop: Workshop) -> None:
    """In the limit: of a play that goes to zero, what is off goes with it."""
    plain: Model = workshop.model(ROTOR + COUPLING.replace('play = "2 deg"\n', ""))
    model = workshop.model(ROTOR + COUPLING)
    wanted = simulate(plain, [0.3], [2.5], until=0.3, rtol=1e-11).q[-1]
    off = [
        abs(simulate(model, [0.3], [2.5], until=0.3, rtol=1e-11, params={"coupling.play": play}).q[-1] - wanted)[0]
        for play in (1e-4, 1e-6)
    ]
    assert off[1] / off[0] == pytest.approx(0.01, rel=0.05)


WRONG = [
    (ROTOR, '[[torsion]]\njoint = "shaft"\ndamping = 1\nplay = 0.1\n', "torsion[0].play", "found without stiffness"),
    (ROTOR, COUPLING.replace("2 deg", "2 cm"), "torsion[0].play", "that is a length, not an angle"),
    (ROTOR, COUPLING.replace('"2 deg"', "0"), "torsion[0].play", "a positive one"),
    (SLIDER, ROD + 'acts = "pull"\n', "spring[0].play", "expected a spring that acts both ways"),
    (SLIDER, ROD.replace("length = 0.6\n", ""), "spring[0].play", "found without a length"),
]


@pytest.mark.parametrize(("scene", "table", "key", "words"), WRONG)
def test_wrong_tables(scene: str, table: str, key: str, words: str, workshop: Workshop) -> None:
    with pytest.raises(SceneError) as caught:
        workshop.scene(scene + table)
    assert [fault.key for fault in caught.value.faults] == [key]
    assert words in caught.value.faults[0].message
