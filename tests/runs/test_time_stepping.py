"""Time stepping: of first order against known answers, and never a rise of energy; and runs that go on by it where
event by event they do not."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import Run, simulate

from ..hard.fuzz import Toss
from ..hard.fuzz import run as thrown
from ..hard.fuzz import scene as toss_scene
from ..support.folders import SCENES
from ..support.workshop import Workshop

G = 9.81
BALL = """
name = "ball"
[[link]]
name = "ball"
mass = 1.0
inertia = 0.1
com = [0, 0]
points = { A = [0, 0] }
[gravity]
g = 9.81
[[ground]]
point = [0, 0]
normal = [0, 1]
restitution = 0.5
contacts = ["ball.A"]
[start]
position = [0, 1]
"""
CRADLE = """
name = "cradle"
[ground_link]
points = { axle = [0, 0] }
""" + "".join(
    f"""
[[link]]
name = "body_{k}"
mass = 1
inertia = 1
com = [0, 0]
points = {{ axle = [0, 0] }}
[[joint]]
name = "joint_{k}"
between = ["{f"body_{k - 1}.axle" if k else "ground.axle"}", "body_{k}.axle"]
"""
    for k in range(3)
)
SLOPE = math.radians(20.0)
BLOCK = f"""
name = "block"
[[link]]
name = "block"
mass = 1
inertia = 1
com = [0, 0]
points = {{ A = [-0.5, 0], B = [0.5, 0] }}
[gravity]
g = 9.81
direction = [{-math.sin(SLOPE)}, {-math.cos(SLOPE)}]
[[ground]]
point = [0, 0]
normal = [0, 1]
friction = 0.6
restitution = 0.0
contacts = ["block.A", "block.B"]
[start]
velocity = [2, 0]
"""


def stepped(model: Any, step: float, until: float, *start: Any) -> Run:
    run: Run = simulate(model, *start, until=until, method="moreau", step=step)
    assert run.success, run.message
    assert [phase.kind for phase in run.phases] == ["steps"]
    assert run.impacts == ()
    energy = np.sum(run.model.energy(run.q, run.u), axis=0)
    assert np.max(np.diff(energy), initial=0.0) <= 1e-14 * max(1.0, abs(energy[0]))
    if model.contacts:
        assert run.model.gaps(run.q).min() >= -1e-13
    return run


def halves(errors: list[float]) -> None:
    """Errors go down with the step, halved every time: to an eighth by three times, but for a scatter of two."""
    assert errors[0] > 0.0
    assert errors[-1] <= 0.25 * errors[0], errors


def test_a_balls_accumulation(workshop: Workshop) -> None:
    """It rests after sqrt(2 h / g) (1 + e) / (1 - e), having bounced without end."""
    model, rest = workshop.model(BALL), math.sqrt(2.0 / G) * 3.0
    late = []
    for step in (1e-3, 5e-4, 2.5e-4, 1.25e-4):
        run = stepped(model, step, 1.5)
        moves = run.t[np.abs(run.u[:, 1]) > 1e-6][-1]
        late.append(abs(float(moves) - rest))
        assert abs(run.q[-1, 1]) <= 1e-12
    halves(late)


def test_three_bodies_in_a_row(workshop: Workshop) -> None:
    """Touching and struck together with e = 1: speeds (-1/3, 2/3, 2/3), in one step, whatever its length."""
    stops = "".join(f'[[stop]]\njoint = "joint_{k}"\nlowest = 0.0\nrestitution = 1.0\n' for k in (1, 2))
    model = workshop.model(CRADLE + stops)
    for step in (1e-2, 1e-4):
        run = stepped(model, step, 2 * step, [0.0, 0.0, 0.0], [1.0, 0.0, 0.0])
        np.testing.assert_allclose(run.u[-1], [-1 / 3, 2 / 3, 2 / 3], atol=1e-12)


def test_a_blocks_stop_on_a_slope(workshop: Workshop) -> None:
    """It slides up, stops after v^2 / (2 g (sin + mu cos)), and stays: friction holds it. The midpoint rule is exact
    for its deceleration, so that the step in which it stops is all that is missed, a part of what it would go in it."""
    model = workshop.model(BLOCK)
    way = 4.0 / (2.0 * G * (math.sin(SLOPE) + 0.6 * math.cos(SLOPE)))
    for step in (1.1e-3, 5e-4, 2.3e-4, 1.25e-4):
        run = stepped(model, step, 0.5)
        assert abs(run.q[-1, 0] - run.q[0, 0] - way) <= 0.5 * G * step**2 + 1e-3 * step
        assert np.abs(run.u[-1]).max() <= 1e-9


def test_a_fall_that_ends_event_by_event(workshop: Workshop) -> None:
    """The rough hexagon's first impacts, forced into steps: first order."""
    model = workshop.model(toss_scene(6, rough=True)).with_parameters(
        {"ground_1.point.y": -1e3, "ground_0.normal.x": 0.2}
    )
    q, u = model.start()
    u[3:] += 0.3
    q, u = model.project(q, u)
    exact = simulate(model, q, u, until=0.75, rtol=1e-11)
    assert exact.success and len(exact.impacts) >= 2
    off = [
        float(np.abs(stepped(model, step, 0.75, q, u).q[-1] - exact.q[-1]).max()) for step in (8e-4, 4e-4, 2e-4, 1e-4)
    ]
    halves(off)


@pytest.fixture(scope="module")
def jammed(workshop: Workshop) -> Run:
    """The first toss of nine rods whose friction jams between several contacts, so that it goes on by steps for a
    while: a few in a hundred do, and rounding decides which."""
    model = workshop.model(toss_scene(9, rough=True))
    for seed in range(64, 164):
        toss = Toss(n=9, planes=2, rough=True, law="poisson", restitution=0.3, friction=1.2, seed=seed)
        found: Run = thrown(model, toss, until=1.8, rtol=1e-9)
        assert found.success, found.message
        steps = [phase for phase in found.phases if phase.kind == "steps"]
        starts = np.searchsorted(found.t, [phase.start for phase in steps])
        if np.abs(found.u[starts]).max(initial=0.0) > 1e-3:  # it moves there
            return found
    pytest.fail("none of 100 tosses goes on by steps while it moves")


def test_a_run_that_jams_goes_on_by_steps(jammed: Run) -> None:
    """The phase says by which steps and what they miss; they are a small part of the run, and lose energy only."""
    steps = [phase for phase in jammed.phases if phase.kind == "steps"]
    assert steps and sum(phase.end - phase.start for phase in steps) <= 1e-3 * jammed.t[-1]
    energy = np.sum(jammed.model.energy(jammed.q, jammed.u), axis=0)
    for phase in steps:
        rows = np.flatnonzero((jammed.t >= phase.start) & (jammed.t <= phase.end))
        assert len(rows) > 10
        assert 0.0 < phase.step <= (phase.end - phase.start) / 10 * (1 + 1e-9)
        assert phase.step == pytest.approx(np.diff(jammed.t[rows]).max(), rel=1e-6)
        assert 0.0 <= phase.missed < 1e-6
        assert np.max(np.diff(energy[rows])) <= 1e-13 * abs(energy[0])
    assert jammed.energy_drift <= 1e-9 * abs(energy[0])
    assert jammed.closure_max <= 1e-12
    assert jammed.model.gaps(jammed.q).min() >= -1e-11


def test_the_plot_shows_where_a_run_stepped(jammed: Run) -> None:
    """Hatched, in the axes of energy, heights and closure."""
    over_time = [axes for axes in jammed.plot().axes if axes.get_ylabel()]
    steps = sum(phase.kind == "steps" for phase in jammed.phases)
    hatched = [sum(bool(patch.get_hatch()) for patch in axes.patches) for axes in over_time]
    assert steps and hatched == [steps, steps, steps]


def test_states_between_steps_are_on_the_closure(jammed: Run) -> None:
    """And between the rows: half a step from each, of what moves at metres per second."""
    phase = next(phase for phase in jammed.phases if phase.kind == "steps")
    t = np.linspace(phase.start, phase.end, 57)[1:-1]
    q, u = jammed.at(t)
    assert np.abs(jammed.model.closure(q)).max() <= 1e-12
    rows = np.searchsorted(jammed.t, t, side="right") - 1
    assert np.abs(q - jammed.q[rows]).max() <= 100.0 * phase.step * np.abs(u).max()
    assert np.isnan(jammed.contact_forces(t)).all()


def test_a_run_within_steps_can_be_left_and_gone_on_with(jammed: Run) -> None:
    """The last step before is shorter for that, which moves what follows by less than steps may miss."""
    model, end = jammed.model, 1.6
    q, u = jammed.q[0], jammed.u[0]
    stretches = [(phase.start, phase.end) for phase in jammed.phases if phase.kind == "steps"]
    within = [start + part * (stop - start) for start, stop in stretches for part in (0.5, 0.3, 0.7, 0.9)]
    runs = (simulate(model, q, u, until=middle, rtol=1e-9) for middle in within)
    first = next(run for run in runs if run.phases[-1].kind == "steps")  # rounding decides whether it jams again
    second = simulate(model, state=first.state, until=end)
    straight = simulate(model, q, u, until=end, rtol=1e-9)
    assert first.phases[-1].kind == second.phases[0].kind == "steps"
    assert first.success and second.success and straight.success
    assert abs(second.q[-1] - straight.q[-1]).max() <= 1e-6


def test_a_method_without_events_needs_a_step(workshop: Workshop) -> None:
    with pytest.raises(ValueError, match="step: found none beside method 'moreau'"):
        simulate(workshop.model(BALL), method="moreau")


def test_what_a_motor_holds_against_a_stop_stays(workshop: Workshop) -> None:
    """A pendulum that its motor presses on a stop comes to rest there: no work is done by what does not move."""
    model = workshop.model(
        """
name = "pressed"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "arm"
mass = 1.0
inertia = 0.1
com = [0.5, 0]
points = { A = [0, 0] }
[[joint]]
name = "axle"
between = ["ground.O", "arm.A"]
[[motor]]
joint = "axle"
torque = 2.0
[[stop]]
joint = "axle"
highest = 0.5
restitution = 0.3
"""
    )
    for step in (1e-2, 1e-3, 1e-4):
        run = simulate(model, until=2.0, method="moreau", step=step)
        assert run.success, run.message
        assert abs(run.q[-1, 0] - 0.5) <= 1e-12 and abs(run.u[-1, 0]) <= 1e-9


def test_a_force_that_holds_part_of_the_weight_takes_no_speed(workshop: Workshop) -> None:
    """On smooth ground: what slides goes on as it is, and turns."""
    model = workshop.model(BALL + '[[force]]\npoint = "ball.A"\nvector = [0, 5]\n')
    for step in (1e-2, 1e-3):
        run = simulate(model, [0.0, 0.0, 0.0], [1.0, 0.0, 0.3], until=0.1, method="moreau", step=step)
        assert run.success, run.message
        np.testing.assert_allclose(run.u[-1], [1.0, 0.0, 0.3], atol=1e-9)
        assert np.isnan(run.contact_forces(run.t[-1])).all()


def test_a_driven_joint_turns_as_it_is_told_by_steps_in_time(workshop: Workshop) -> None:
    text = (SCENES / "parallelogram.toml").read_text()
    model = workshop.model(text + '[[drive]]\njoint = "motor"\nspeed = 10.0\n')
    run = simulate(model, until=1.0, method="moreau", step=1e-3)
    assert run.success, run.message
    crank = run.values("motor.angle", t=[0.0, 1.0])["motor.angle"]
    assert crank[1] - crank[0] == pytest.approx(10.0, abs=1e-9) and run.closure_max <= 1e-12
