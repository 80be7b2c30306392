"""Events that scenes ask for: instants against closed forms, what they set and end, and what is no event."""

from __future__ import annotations

import pickle
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.special import ellipk

from ccgen.generator import SceneError
from ccgen.runtime import Event, HybridState, ensemble, simulate

from ..support.workshop import Workshop
from .test_release_and_hold import HOOK, TREBUCHET

G = 9.81
PENDULUM = """
name = "swing"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "rod"
mass = 1
inertia = 1
com = [1, 0]
points = { A = [0, 0], B = [1, 0] }
[[joint]]
name = "pin"
between = ["ground.O", "rod.A"]
[start]
angles = { rod = 0 }
[gravity]
[run]
until = 6
"""
PERIOD = 4.0 * float(ellipk(0.5)) * np.sqrt(2.0 / G)
"""Of a swing from level; the inertia about the pin is 2 kg m²."""
BALL = """
name = "ball"
[[link]]
name = "ball"
mass = 1
inertia = 1
com = [0, 0]
points = { P = [0, 0] }
[start]
position = [0, 1]
[gravity]
[[ground]]
restitution = 0.5
contacts = ["ball.P"]
[run]
until = 2
"""
FALL = float(np.sqrt(2.0 / G))


def names_and_times(run: Any) -> list[tuple[str, str, float]]:
    return [(event.name, event.direction, event.t) for event in run.events]


def test_instants_of_a_swing_are_those_of_its_closed_form(workshop: Workshop) -> None:
    text = PENDULUM + '[[event]]\nname = "down"\nwhen = "angle(pin) + pi/2"\n'
    text += '[[event]]\nname = "end"\nwhen = "rate(angle(pin))"\ndirection = "rising"\n'
    run = simulate(workshop.model(text), rtol=1e-12)
    downs = [event.t / PERIOD for event in run.events if event.name == "down"]
    ends = [event.t / PERIOD for event in run.events if event.name == "end"]
    assert downs == pytest.approx([0.25 + 0.5 * k for k in range(len(downs))], abs=1e-11)
    assert ends == pytest.approx([0.5 + k for k in range(len(ends))], abs=1e-11)
    assert (len(downs), len(ends)) == (4, 2)
    assert [event.direction for event in run.events if event.name == "down"] == ["falling", "rising"] * 2
    assert [event.number for event in run.events if event.name == "down"] == [1, 2, 3, 4]
    for event in run.events:
        q, u = run.at(event.t)
        assert (event.q == q).all() and (event.u == u).all()


def test_counting_does_not_change_a_run_by_one_bit(workshop: Workshop) -> None:
    text = PENDULUM + '[[event]]\nname = "down"\nwhen = "angle(pin) + pi/2"\n'
    counted, plain = simulate(workshop.model(text)), simulate(workshop.model(PENDULUM))
    assert counted.t.tobytes() == plain.t.tobytes() and counted.q.tobytes() == plain.q.tobytes()
    assert counted.events and not plain.events


def test_what_is_passed_and_passed_back_within_a_step_is_found(workshop: Workshop) -> None:
    text = PENDULUM + '[[event]]\nname = "deep"\nwhen = "angle(pin) + pi - 1e-10"\n'
    model = workshop.model(text)
    run = simulate(model, rtol=1e-12, until=4)
    beside = np.sqrt(2e-10 / (G / 2.0))  # the rod turns back at -pi with the angular acceleration g/2
    row = np.searchsorted(run.t, PERIOD / 2)
    assert run.t[row - 1] < PERIOD / 2 - 100 * beside and run.t[row] > PERIOD / 2 + 100 * beside
    assert [(event.direction, event.t - PERIOD / 2) for event in run.events] == [
        ("falling", pytest.approx(-beside, abs=1e-9)),
        ("rising", pytest.approx(beside, abs=1e-9)),
    ]


def test_gravity_set_at_the_lowest_point_gives_the_swing_of_its_closed_form(workshop: Workshop) -> None:
    text = PENDULUM + '[[event]]\nname = "down"\nwhen = "angle(pin) + pi/2"\ndirection = "falling"\n'
    text += 'set = { "gravity.g" = "2*9.81 + 0*t" }\n'
    text += '[[event]]\nname = "back"\nwhen = "x(rod.B)"\nstop = true\ntimes = 2\n'
    model = workshop.model(text)
    run = simulate(model, rtol=1e-12)
    swing = 2.0 * float(ellipk(0.25)) * np.sqrt(2.0 / (2.0 * G))  # sin² of half its width is ω²/4 over 2g/2, 1/4
    assert run.t[-1] - PERIOD / 4 == pytest.approx(swing, abs=1e-10)
    down, first, second = run.events
    assert (down.t, down.name, first.name, second.number) == (first.t, "down", "back", 2)
    assert down.parameters == {"gravity.g": 2 * G} and down.energy == pytest.approx(-G, abs=1e-10)
    assert run.energy_drift < 1e-10 and run.success and run.message.startswith("ended at")
    assert model.parameters["gravity.g"] == G
    # forces before and after: m (g + ω²) at the lowest point, by each gravity
    before, after = run.reactions([down.t - 1e-9, down.t + 1e-9])[:, 0, :2]
    assert before == pytest.approx([0.0, 2 * G], abs=1e-6) and after == pytest.approx([0.0, 3 * G], abs=1e-6)
    middle = run.at(PERIOD / 4 + swing / 2)
    assert middle[1] == pytest.approx([0.0], abs=1e-9) and middle[0] == pytest.approx([-np.pi / 2 - np.pi / 3])


def test_a_run_that_an_event_has_ended_goes_on(workshop: Workshop) -> None:
    text = PENDULUM + '[[event]]\nname = "down"\nwhen = "angle(pin) + pi/2"\nstop = true\nset = { "gravity.g" = 5 }\n'
    model = workshop.model(text)
    run = simulate(model, rtol=1e-12)
    then = simulate(model, state=run.state, until=6, rtol=1e-12)
    assert run.t[-1] == then.t[0] and run.state is not None and run.state.parameters["gravity.g"] == 5.0
    assert [event.direction for event in then.events] == ["rising"]
    copy = pickle.loads(pickle.dumps(run))
    assert (copy.at(0.3)[0] == run.at(0.3)[0]).all() and copy.events[0].parameters == {"gravity.g": 5.0}


def test_bounces_are_events_of_heights_and_of_their_rates(workshop: Workshop) -> None:
    text = BALL + '[[event]]\nname = "floor"\nwhen = "y(ball.P)"\n'
    text += '[[event]]\nname = "turn"\nwhen = "rate(y(ball.P))"\n'
    run = simulate(workshop.model(text), rtol=1e-12)
    floor = [event for event in run.events if event.name == "floor"]
    turns = [event for event in run.events if event.name == "turn"]
    bounces = FALL * np.array([1.0, 2.0, 2.5, 2.75])
    tops = FALL * np.array([1.5, 2.25, 2.625])
    assert [event.t for event in floor[:4]] == [impact.t for impact in run.impacts[:4]]
    assert [event.t for event in floor[:4]] == pytest.approx(bounces, abs=1e-12)
    assert {event.direction for event in floor} == {"falling"}  # it comes to zero from above, and does not pass it
    assert [event.t for event in turns if event.direction == "falling"][:3] == pytest.approx(tops, abs=1e-11)
    assert [event.t for event in turns if event.direction == "rising"][:3] == [impact.t for impact in run.impacts[:3]]
    rests = 3.0 * FALL  # from then on the ball lies still
    assert all(event.t < rests + 1e-9 for event in run.events)
    assert {event.t for event in floor} < {impact.t for impact in run.impacts} and len(floor) > 20


def test_an_impact_that_an_event_ends_is_in_the_run(workshop: Workshop) -> None:
    text = BALL + '[[event]]\nname = "floor"\nwhen = "y(ball.P)"\nstop = true\ntimes = 2\n'
    model = workshop.model(text)
    run = simulate(model, rtol=1e-12)
    assert len(run.impacts) == 2 and run.t[-1] == run.impacts[-1].t
    assert run.at(run.t[-1])[1][1] == pytest.approx(0.25 * np.sqrt(2 * G))
    assert run.state is not None
    then = simulate(model, state=run.state, until=2.75 * FALL + 1e-3, rtol=1e-12)
    assert [impact.t for impact in then.impacts] == pytest.approx([2.5 * FALL, 2.75 * FALL])


def test_restitution_set_at_an_impact_is_that_of_the_next(workshop: Workshop) -> None:
    text = BALL + '[[event]]\nname = "floor"\nwhen = "y(ball.P)"\nset = { "ground_0.restitution" = 1 }\n'
    run = simulate(workshop.model(text), rtol=1e-12, until=3.5 * FALL)
    assert [impact.t for impact in run.impacts] == pytest.approx(FALL * np.array([1.0, 2.0, 3.0]))
    assert run.impacts[0].energy_loss == pytest.approx(0.75 * G)
    assert run.impacts[1].energy_loss == pytest.approx(0.0, abs=1e-9)


def test_a_start_on_zero_is_no_event_before_it_has_been_left(workshop: Workshop) -> None:
    text = PENDULUM + '[[event]]\nname = "level"\nwhen = "angle(pin)"\n'
    text += '[[event]]\nname = "clock"\nwhen = "t"\n'
    run = simulate(workshop.model(text), rtol=1e-12)
    assert names_and_times(run) == [("level", "rising", pytest.approx(PERIOD, abs=1e-4))]


def test_two_events_at_one_instant_both_happen(workshop: Workshop) -> None:
    text = PENDULUM + '[[event]]\nwhen = "x(rod.B)"\nset = { "gravity.g" = 1 }\n'
    text += '[[event]]\nwhen = "angle(pin) + pi/2"\nset = { "gravity.g" = 2 }\nstop = true\n'
    run = simulate(workshop.model(text))
    assert [event.name for event in run.events] == ["event_0", "event_1"]
    assert run.events[0].t == run.events[1].t == run.t[-1]
    assert [event.before for event in run.events] == [{"gravity.g": 9.81}, {"gravity.g": 1.0}]
    assert run.state is not None and run.state.parameters["gravity.g"] == 2.0  # the later table's


def test_functions_answer_with_values_or_stop(workshop: Workshop) -> None:
    text = PENDULUM + '[[event]]\nname = "down"\nwhen = "angle(pin) + pi/2"\n[[event]]\nname = "end"\nwhen = "t - 5"\n'
    model = workshop.model(text)
    seen: list[Event] = []

    def down(event: Event) -> dict[str, float] | None:
        seen.append(event)
        return {"gravity.g": 2 * G} if event.number == 1 else None

    run = simulate(model, rtol=1e-12, on_event={"down": down, "end": lambda event: "stop"})
    swing = 2.0 * float(ellipk(0.25)) * np.sqrt(1.0 / G)
    assert [event.t for event in seen][:2] == pytest.approx([PERIOD / 4, PERIOD / 4 + swing], abs=1e-10)
    assert run.t[-1] == 5.0 and run.success
    with pytest.raises(TypeError, match="found 7 from the function of 'down'"):
        simulate(model, on_event={"down": lambda event: 7})  # type: ignore[dict-item, return-value]
    with pytest.raises(ValueError, match="found 'dwn', expected the name of an event; those of the scene are down"):
        simulate(model, on_event={"dwn": down})
    with pytest.raises(ValueError, match="the scene has no"):
        simulate(workshop.model(PENDULUM), on_event={"down": down})


def test_a_function_may_change_what_a_controller_does(workshop: Workshop) -> None:
    """A torque of 3 N m until 0.5 s and -1 N m after: Euler's closed form without gravity."""
    text = PENDULUM.replace("[gravity]\n", '[[input]]\nname = "crank"\njoint = "pin"\n')
    text += '[[event]]\nname = "later"\nwhen = "t - 0.5"\n'
    mode = {"torque": 3.0}
    run = simulate(
        workshop.model(text),
        inputs=lambda t, q, u: [mode["torque"]],
        on_event={"later": lambda event: mode.update(torque=-1.0)},
        until=1.5,
        rtol=1e-12,
    )
    assert run.u[-1] == pytest.approx([(3.0 * 0.5 - 1.0) / 2.0], abs=1e-9)
    assert run.q[-1] == pytest.approx([3 * 0.5**2 / 4 + 0.75 * 1.0 - 0.25], abs=1e-9)


def test_a_thrown_stone_is_stopped_where_it_lands(workshop: Workshop) -> None:
    text = TREBUCHET + '[[event]]\nname = "lands"\nwhen = "y(stone.C) + 3"\ndirection = "falling"\nstop = true\n'
    text += '[[event]]\nname = "top"\nwhen = "rate(y(stone.C))"\ndirection = "falling"\n'
    model = workshop.model(text.replace("until = 3", "until = 10"))
    run = simulate(model, rtol=1e-11)
    (change,) = run.changes
    free = run.point("stone.C", [change.t])
    (x, y), (vx, vy) = free.position[0], free.velocity[0]
    fall = (vy + np.sqrt(vy**2 + 2 * G * (y + 3.0))) / G
    assert run.t[-1] == pytest.approx(change.t + fall, abs=1e-9)
    assert run.point("stone.C").position[-1] == pytest.approx([x + vx * fall, -3.0], abs=1e-8)
    tops = [event for event in run.events if event.name == "top" and event.t > change.t]
    assert [event.t for event in tops] == [pytest.approx(change.t + vy / G, abs=1e-9)]


def test_gravity_set_while_a_joint_is_open_goes_through_all_structures(workshop: Workshop) -> None:
    text = TREBUCHET + '[[event]]\nname = "top"\nwhen = "rate(y(stone.C))"\ndirection = "falling"\n'
    text += 'set = { "gravity.g" = 3 }\n'
    text += '[[event]]\nname = "lands"\nwhen = "y(stone.C) + 3"\ndirection = "falling"\nstop = true\n'
    run = simulate(workshop.model(text.replace("until = 3", "until = 20")), rtol=1e-11)
    (change,) = run.changes
    top = next(event for event in run.events if event.name == "top" and event.t > change.t)
    height = run.point("stone.C", [top.t]).position[0, 1] + 3.0
    assert run.t[-1] - top.t == pytest.approx(np.sqrt(2 * height / 3.0), abs=1e-8)
    assert run.state is not None and run.state.parameters["pouch.held"] == 0.0


def test_arrays_of_a_run_have_its_events(workshop: Workshop, tmp_path: Path) -> None:
    text = PENDULUM + '[[event]]\nname = "down"\nwhen = "angle(pin) + pi/2"\n'
    run = simulate(workshop.model(text))
    with np.load(run.save(tmp_path / "run.npz")) as saved:
        assert saved["event_names"].tolist() == ["down"] * 4
        assert saved["event_t"].tolist() == [event.t for event in run.events]
        assert saved["event_directions"].tolist() == ["falling", "rising"] * 2
        assert saved["event_q"].shape == (4, 1)
    with np.load(simulate(workshop.model(PENDULUM)).save(tmp_path / "plain.npz")) as saved:
        assert not [name for name in saved if name.startswith("event")]


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        ('when = "angle(pn)"', "pn in angle(...) is no joint; the joints are pin"),
        ('when = "angle(rod)"', "the joints are pin; write direction(rod) for the angle of that link"),
        ('when = "y(B)"', "B in y(...) is no point; the joints are pin; write rod.B"),
        ('when = "y(rod)"', "write rod.A or rod.B"),
        ('when = "angle(pin) > 2"', "it comes to zero where both sides are equal: write their difference"),
        ('when = "2*pi"', "it has neither t nor a quantity that moves"),
        ('when = "angl(pin)"', "angl(...) is not known here"),
        ('when = "slide(pin)"', "pin in slide(...) does not slide; it only turns"),
        ('when = "rate(angle(pin) + t)"', "rate(...) is of one quantity alone"),
        ('when = "x(rod.C)"', "rod.C in x(...) is no point; rod has the points A, B"),
        ('when = "distance(rod.B)"', "distance(...) is of a point and a point"),
        ('when = "t - foo"', "foo is not known here"),
        ('when = "t^2"', "write ** for ^"),
        ('when = "t**0.5"', "exponents are whole numbers"),
        (
            'when = "direction(pin)"',
            "pin in direction(...) is no link that moves; the links are rod; write angle(pin) for",
        ),
        ('when = "t - 1"\nset = { "gravty.g" = 1 }', 'found "gravty.g", expected the path of a parameter, as "gravity'),
        ('when = "t - 1"\nset = { "rod.mass" = -1 }', "found -1, expected a number that is more than 0"),
        ('when = "t - 1"\nset = { "gravity.g" = true }', "event[0].set.gravity.g: found true, expected values of par"),
        ('when = "t - 1"\nset = { "gravity.g" = "1/0" }', "it has no finite value"),
        ('when = "t - 1"\nset = { "gravity.g" = "1/(t - t)" }', "it divides by what is always zero"),
        ('when = "2/(angle(pin) - angle(pin))"', "it divides by what is always zero"),
        ('when = "(t - t)**-1 + t"', "it divides by what is always zero"),
        ('when = "t - 1"\nset = { "gravity.on" = 0 }', "to switch an effect write its name in on or off"),
        ('when = "t - 1"\nstop = true\ntimes = 0', "found 0, expected beside stop: how often it comes"),
        ('when = "t - 1"\ntimes = 2', "found 2 without stop, expected it beside stop = true"),
        ('when = "t - 1"\nstop = 2', "found 2, expected true, if the run ends there, or false"),
        ('when = "t - 1"\ndirection = "up"', '"rising", "falling" or "either"'),
        ('name = "e"\nwhen = "t - 1"\n[[event]]\nname = "e"\nwhen = "t"', 'found "e" a second time'),
    ],
)
def test_wrong_events_are_told_in_sentences(workshop: Workshop, lines: str, told: str) -> None:
    with pytest.raises(SceneError) as found:
        workshop.scene(PENDULUM + f"[[event]]\n{lines}\n")
    assert told in str(found.value) and len(found.value.faults) == 1


def test_what_comes_at_once_behind_a_set_comes_at_the_end_too(workshop: Workshop) -> None:
    """A point of a cart jumps over a place where it is set: in one run, and in one that ends there and goes on."""
    text = JUMP + '[[event]]\nname = "set"\nwhen = "t - 0.5"\nset = { "cart.points.B.x" = 2 }\n'
    model = workshop.model(text + '[[event]]\nname = "over"\nwhen = "x(cart.B) - 0.5"\nset = { "cart.mass" = 3 }\n')
    whole, first = simulate(model, until=1.0), simulate(model, until=0.5)
    told = [(event.t, event.name, event.number) for event in whole.events]
    assert told == [(0.5, "set", 1), (0.5, "over", 1)]
    assert [(event.t, event.name, event.number) for event in first.events] == told
    assert first.state is not None and first.state.parameters["cart.mass"] == 3.0
    found = ensemble(model, {"cart.inertia": [1.0, 2.0]}, until=0.5, observe=["energy"])
    assert found["energy"] == pytest.approx([1.5, 1.5])


JUMP = """
name = "jump"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "cart"
mass = 2
inertia = 1
com = [0, 0]
points = { A = [0, 0], B = [-2, 0] }
[[joint]]
name = "rail"
type = "prismatic"
between = ["ground.O", "cart.A"]
axis = [1, 0]
[start]
sliding_velocities = { rail = 1 }
[run]
until = 4
"""


def test_an_event_may_leave_no_finite_acceleration(workshop: Workshop) -> None:
    """Beside an effect that holds values, which are looked for first: the run says so, and has come up to there."""
    text = JUMP + '[[spring]]\nname = "coil"\nbetween = ["ground.O", "cart.A"]\nstiffness = 8\nlength = 1\n'
    text += "[[compliant_ground]]\npoint = [-5, 0]\nnormal = [1, 0]\nload = 100\ndepth = 0.05\nrestitution = 0.5\n"
    text += 'contacts = ["cart.A"]\n'
    text += '[[event]]\nwhen = "t - 0.5"\nset = { "coil.stiffness" = 1e308, "cart.mass" = 1e-5 }\n'
    run = simulate(workshop.model(text.replace("{ rail = 1 }", "{ rail = 1 }\nslides = { rail = 1.5 }")))
    assert not run.success and run.t[-1] == 0.5 and "an acceleration is not a finite number" in run.message


OPENED = """
name = "opened"
[ground_link]
points = { O = [0, 0], Q = [2, 0] }
[[link]]
name = "crank"
mass = 1.0
inertia = 0.1
com = [0.5, 0]
points = { A = [0, 0], B = [1, 0] }
[[link]]
name = "coupler"
mass = 1.0
inertia = 0.1
com = [1, 0]
points = { A = [0, 0], B = [2, 0] }
[[link]]
name = "rocker"
mass = 1.0
inertia = 0.1
com = [0.75, 0]
points = { A = [0, 0], B = [1.5, 0] }
[[joint]]
between = ["ground.O", "crank.A"]
[[joint]]
between = ["crank.B", "coupler.A"]
[[joint]]
between = ["coupler.B", "rocker.B"]
[[joint]]
between = ["ground.Q", "rocker.A"]
[gravity]
[start]
angles = { crank = "60 deg", coupler = "10 deg", rocker = "80 deg" }
[[event]]
when = "t - 0.2"
set = { "coupler.points.B.x" = 1.9 }
"""


def test_a_length_that_opens_a_loop_ends_the_run(workshop: Workshop) -> None:
    """Also where the nearest closed place is near: nothing is moved there without a word."""
    run = simulate(workshop.model(OPENED), until=0.5)
    assert not run.success and run.t[-1] == pytest.approx(0.2, abs=1e-12)
    assert re.search(r"what events have set opens the loops by 0\.\d+ m; set what leaves them shut", run.message)


def test_the_speed_of_a_drive_is_not_set(workshop: Workshop) -> None:
    drive = '[[drive]]\njoint = "pin"\nspeed = 1\n[[event]]\nname = "now"\nwhen = "t - 1"\n'
    with pytest.raises(SceneError, match="a driven joint keeps the speed with which it began"):
        workshop.scene(f'{PENDULUM}{drive}set = {{ "drive_0.speed" = 5 }}\n')
    model = workshop.model(PENDULUM + drive)
    run = simulate(model, until=2.0, on_event={"now": lambda event: {"drive_0.speed": 5.0}})
    assert not run.success and "a driven joint keeps its first speed" in run.message


def test_what_cannot_be_set_ends_the_run(workshop: Workshop) -> None:
    """A scene's own value that is out of range: where, which event, and all that came before is kept."""
    text = PENDULUM + '[[event]]\nname = "now"\nwhen = "t - 1"\nset = { "rod.mass" = "angle(pin)" }\n'
    run = simulate(workshop.model(text))
    assert not run.success and run.t[-1] == 1.0 and run.events[0].name == "now" and not run.events[0].parameters
    assert re.match(r"stopped at t = 1 s by now: .*rod\.mass.*positive", run.message)


def test_values_of_functions_go_on_with_the_state(workshop: Workshop, tmp_path: Path) -> None:
    """A run that goes on has what the function had set, also from a file; another value, and another model, are told
    of."""
    text = PENDULUM + '[[event]]\nname = "now"\nwhen = "t - 1"\n'
    model = workshop.model(text)

    def heavier(event: Event) -> dict[str, float]:
        return {"gravity.g": 20.0}

    answers = {"now": heavier}
    whole, half = (simulate(model, until=end, on_event=answers) for end in (3.0, 2.0))
    assert half.state is not None and half.state.parameters["gravity.g"] == 20.0
    again = HybridState.load(half.state.save(tmp_path / "half.npz"))
    for state, more in ((half.state, {"on_event": answers}), (again, {})):
        then = simulate(model, state=state, until=3.0, **more)  # type: ignore[arg-type]
        assert then.q[-1] == pytest.approx(whole.q[-1], abs=1e-8)
        assert then.state is not None and then.state.changed == {"gravity.g"}
    other = simulate(model, until=0.5, params={"rod.mass": 3.0}).state
    of_another = simulate(workshop.model(BALL), until=0.1).state
    for state, more, told in (
        (half.state, {"params": {"gravity.g": 5.0}}, r"found one with another gravity\.g"),
        (other, {}, r"found one with another rod\.mass"),
        (of_another, {}, "found one of ball, expected one of "),
    ):
        with pytest.raises(ValueError, match=told):
            simulate(model, state=state, until=3.0, on_event=answers, **more)  # type: ignore[arg-type]


LAST = [
    ('when = "t - 0.2"\nset = { "coupler.points.B.x" = 1.9 }\nstop = true\n', 0.2),
    ('when = "t - 0.5"\nset = { "coupler.points.B.x" = 1.9 }\n', 0.5),
    ('when = "t - 0.2"\nstop = true\n[[event]]\nwhen = "t - 0.2"\nset = { "coupler.points.B.x" = 1.9 }\n', 0.2),
]


@pytest.mark.parametrize(("event", "end"), LAST)
def test_what_opens_a_loop_at_the_end_loses_no_run(workshop: Workshop, event: str, end: float) -> None:
    """At the end of the run, or where the same instant ends it: what was simulated is there, and what was wrong."""
    run = simulate(workshop.model(OPENED.partition("[[event]]")[0] + "[[event]]\n" + event), until=0.5)
    assert not run.success and run.t[-1] == pytest.approx(end, abs=1e-12)
    assert f"stopped at t = {end} s: " in run.message and "what events have set opens the loops by" in run.message


def test_who_has_set_what_cannot_be_is_told(workshop: Workshop) -> None:
    """A scene's own value ends the run, whatever a function answers beside it; so does what a function answers."""
    bad = 'set = { "rod.mass" = "-t" }\n'
    text = PENDULUM + '[[event]]\nname = "now"\nwhen = "t - 1"\n'
    model, plain = workshop.model(text + bad), workshop.model(text)
    for answer in (None, {}, {"gravity.g": 5.0}):
        run = simulate(model, on_event={"now": lambda event, answer=answer: answer})  # type: ignore[misc]
        assert not run.success and "stopped at t = 1 s by now: " in run.message and "rod.mass" in run.message
    run = simulate(model, until=1.5, on_event={"now": lambda event: {"rod.mass": np.int64(2)}})
    assert run.success and repr(run.events[0].parameters) == "{'rod.mass': 2.0}"
    for wrong, told in (
        ({"rod.mass": -2.0}, "rod.mass: found -2.0, expected a positive number"),
        ({"rod.mass": "2 kg"}, "rod.mass: found '2 kg', expected a number"),
        ({"rod.mas": 2.0}, "rod.mas: found no such parameter, expected one of the model, as "),
        ({"rod.mass": np.nan, "rod.mas": 2.0}, "rod.mass: found nan, expected a finite number; rod.mas: found no "),
    ):
        run = simulate(plain, on_event={"now": lambda event, wrong=wrong: wrong})  # type: ignore[misc]
        assert not run.success and run.message.startswith(f"stopped at t = 1 s by the answer to now: {told}")
        (event,) = run.events
        assert run.t[-1] == event.t == 1.0 and not event.parameters
        assert run.q[-1] == pytest.approx(simulate(plain, until=1.0).q[-1], abs=1e-12)


def test_what_a_function_of_an_event_raises_simulate_raises(workshop: Workshop) -> None:
    def broken(event: Event) -> None:
        raise ZeroDivisionError(event.name)

    model = workshop.model(PENDULUM + '[[event]]\nname = "now"\nwhen = "t - 1"\n')
    with pytest.raises(ZeroDivisionError, match="now"):
        simulate(model, on_event={"now": broken})


def test_a_run_that_its_scene_ends_ends_whatever_a_function_answers(workshop: Workshop) -> None:
    model = workshop.model(PENDULUM + '[[event]]\nname = "now"\nwhen = "t - 1"\nstop = true\n')
    run = simulate(model, on_event={"now": lambda event: {"gravity.g": 5.0}})
    assert run.t[-1] == 1.0 and "ended at t = 1 s by now" in run.message and run.state is not None
    assert run.state.parameters["gravity.g"] == 5.0


def test_an_instant_that_cannot_be_set_is_blamed_on_the_event_that_cannot(workshop: Workshop) -> None:
    """Beside a joint that a function has take hold, and an event of the same kind that has not come."""
    text = HOOK.format(more="at = 5", height=-1.5).replace("until = 1", "until = 2")
    at_once = '[[event]]\nname = "{0}"\nwhen = "t - {1}"\nset = {{ "rod.mass" = "{2}" }}\n'
    told = '[[event]]\nname = "a"\nwhen = "t - 0.5"\n'
    for last in ("t - 1", "3"):
        events = told + at_once.format("b", 0.5, "t - 1") + at_once.format("z", 100, last)
        model = workshop.model(text.replace("[[hold]]", events + "[[hold]]"))
        run = simulate(model, on_event={"a": lambda event: {"grip.held": 1}})
        assert run.message == "stopped at t = 0.5 s by b: rod.mass: found -0.5, expected a positive number"
        assert [(event.name, dict(event.parameters)) for event in run.events] == [("a", {}), ("b", {})]
        assert run.t[-1] == 0.5 and not run.changes and run.model_at(0.5).parameters["grip.held"] == 0.0


def test_an_answer_that_is_in_force_already_stays(workshop: Workshop) -> None:
    events = '[[event]]\nname = "a"\nwhen = "t - 0.5"\n[[event]]\nname = "b"\nwhen = "t - 1"\n'
    answers = {"a": lambda event: {"gravity.g": 9.81}, "b": lambda event: {"gravity.g": 20.0}}
    run = simulate(workshop.model(PENDULUM + events), until=2.0, on_event=answers)
    assert [event.done for event in run.events] == [("gravity.g stays 9.81",), ("gravity.g from 9.81 to 20",)]
    assert len(run.stretches) == 2


def test_wide_numbers_that_events_set_are_those_that_are_told(workshop: Workshop) -> None:
    """Expressions that no double has: the energy is accounted for to the digits of wide numbers."""
    text = PENDULUM + '[[event]]\nwhen = "t - 0.5"\nset = { "gravity.g" = "10/3 + t/7" }\n'
    run = simulate(workshop.model(text, "wide"), until=2.0, rtol=1e-17)
    assert run.success and run.energy_drift < 3e-17


def test_what_cannot_be_switched_says_what_the_scene_lacks(workshop: Workshop) -> None:
    text = PENDULUM + '[[event]]\nname = "a"\nwhen = "t - 0.5"\n[[spring]]\nbetween = ["ground.O", "rod.B"]\n'
    model = workshop.model(text + "stiffness = 1\nlength = 1\n")
    for path, told in (
        ("spring_0.on", "an [[event]] of the scene names it"),
        ("pin.held", "a [[release]] or a [[hold]]"),
    ):
        run = simulate(model, on_event={"a": lambda event, path=path: {path: 0}})  # type: ignore[misc]
        assert f"by the answer to a: {path}: found no such parameter" in run.message and told in run.message
    model = workshop.model(HOOK.format(more="at = 5", height=-1.5).replace("[[hold]]", LATER + "[[hold]]"))
    run = simulate(model, on_event={"later": lambda event: {"grip.held": True}})
    assert [change.kind for change in run.changes] == ["hold"]


LATER = '[[event]]\nname = "later"\nwhen = "t - 0.5"\n'
