"""Effects that events switch: against closed forms, and the gait of the simplest walker."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ccgen.generator import SceneError, load_scene
from ccgen.generator.cli.report import print_events
from ccgen.runtime import ensemble, simulate

from ..support.command_line import ccgen
from ..support.workshop import Workshop
from .test_release_and_hold import TREBUCHET
from .test_user_events import BALL, FALL, G

SCENES = Path(__file__).parents[2] / "scenes"
OSCILLATOR = """
name = "oscillator"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "cart"
mass = 2
inertia = 1
com = [0, 0]
points = { A = [0, 0] }
[[joint]]
name = "rail"
type = "prismatic"
between = ["ground.O", "cart.A"]
axis = [1, 0]
[[spring]]
name = "coil"
between = ["ground.O", "cart.A"]
stiffness = 8
length = 1
[start]
slides = { rail = 1.5 }
[run]
until = 4
rtol = 1e-12
"""
"""x = 1 + cos(2t)/2 while the spring acts."""


def test_a_spring_that_is_off_pulls_no_more_and_takes_its_energy_along(
    workshop: Workshop, capsys: pytest.CaptureFixture[str]
) -> None:
    text = OSCILLATOR + '[[event]]\nname = "cut"\nwhen = "t - 0.5"\noff = ["coil"]\n'
    text += '[[event]]\nname = "again"\nwhen = "t - 1.5"\non = ["coil"]\n'
    model = workshop.model(text)
    run = simulate(model)
    x, v = 1.0 + 0.5 * np.cos(1.0), -np.sin(1.0)
    assert run.at(0.9)[0] == pytest.approx([x + 0.4 * v], abs=1e-11)
    cut, again = run.events
    assert cut.energy == pytest.approx(-0.5 * 8 * (x - 1.0) ** 2, abs=1e-10)
    assert (cut.on, cut.off, again.on, again.off) == ((), ("coil",), ("coil",), ())
    print_events(run)
    told = capsys.readouterr().out.splitlines()
    assert told[0] == f"event cut, rising, at t = 0.5 s: coil off, the energy jumps by {cut.energy:.6g} J"
    assert told[1].startswith("event again, rising, at t = 1.5 s: coil on, the energy")
    y = x + v
    assert again.energy == pytest.approx(0.5 * 8 * (y - 1.0) ** 2, abs=1e-10)
    later = 1.0 + (y - 1.0) * np.cos(2 * 1.7) + v / 2.0 * np.sin(2 * 1.7)
    assert run.at(1.5 + 1.7)[0] == pytest.approx([later], abs=1e-10)
    assert run.energy_drift < 1e-11
    assert run.accelerations([0.4, 1.0, 2.0])[:, 0] == pytest.approx(
        [-4 * 0.5 * np.cos(0.8), 0.0, -4 * (run.at(2.0)[0][0] - 1.0)], abs=1e-9
    )


def test_files_say_what_was_switched(workshop: Workshop, tmp_path: Path) -> None:
    text = OSCILLATOR + '[[damper]]\nname = "pot"\nbetween = ["ground.O", "cart.A"]\ndamping = 1\n'
    for when, keys in (
        (0.5, 'off = ["coil"]'),
        (1.0, 'on = ["coil"]\noff = ["pot"]'),
        (1.5, 'set = { "cart.mass" = 3 }'),
    ):
        text += f'[[event]]\nwhen = "t - {when}"\n{keys}\n'
    run = simulate(workshop.model(text), until=2.0)
    with np.load(run.save(tmp_path / "run.npz")) as arrays:
        assert arrays["event_switch_offsets"].tolist() == [0, 1, 3, 3]
        assert arrays["event_switch_names"].tolist() == ["coil", "coil", "pot"]
        assert arrays["event_switch_on"].tolist() == [False, True, False]
        assert arrays["event_set_before"].tolist() == [2.0]


def test_a_run_goes_on_without_what_is_off(workshop: Workshop) -> None:
    text = OSCILLATOR + '[[event]]\nname = "cut"\nwhen = "t - 0.5"\noff = ["coil"]\nstop = true\n'
    model = workshop.model(text)
    run = simulate(model)
    assert run.t[-1] == 0.5 and run.state is not None and run.state.changed == {"coil.on"}
    then = simulate(model, state=run.state, until=1.0)
    assert then.q[-1] == pytest.approx([1.0 + 0.5 * np.cos(1.0) - 0.5 * np.sin(1.0)], abs=1e-11)
    stiffer = simulate(model, params={"coil.stiffness": 18.0}, until=0.4)
    assert stiffer.q[-1] == pytest.approx([1.0 + 0.5 * np.cos(1.2)], abs=1e-11)


def test_what_is_off_at_the_start_acts_when_it_is_switched_on(workshop: Workshop) -> None:
    text = OSCILLATOR.replace("[run]", 'sliding_velocities = { rail = 1 }\noff = ["coil"]\n[run]')
    text += '[[event]]\nwhen = "slide(rail) - 2"\non = ["coil"]\n'
    run = simulate(workshop.model(text))
    event = run.events[0]
    assert event.t == pytest.approx(0.5, abs=1e-13)
    assert run.at(1.5)[0] == pytest.approx([1.0 + np.cos(2.0) + 0.5 * np.sin(2.0)], abs=1e-11)


@pytest.mark.parametrize(
    "effect",
    [
        "",
        '[[damper]]\nname = "other"\nbetween = ["ground.O", "cart.A"]\ndamping = 1\n',
        '[[rope]]\nname = "other"\nbetween = ["ground.O", "cart.A"]\nlength = 3\nrestitution = 0.5\n',
        '[[touch]]\nname = "other"\nbetween = ["ground.O", "cart.A"]\nradius = [0.1, 0.1]\nrestitution = 0.5\n',
        '[[compliant_touch]]\nname = "other"\nbetween = ["ground.O", "cart.A"]\nradius = [0.1, 0.1]\nload = 9\n'
        "depth = 0.01\n",
    ],
)
def test_effects_that_are_off_act_between_points_at_one_place(effect: str, workshop: Workshop) -> None:
    """A cart begins where a spring has its other end, with 1 m/s; 0 times a direction that is none would be no load."""
    others = ', "other"' if effect else ""
    text = OSCILLATOR.replace(
        "rail = 1.5 }", f'rail = 0 }}\nsliding_velocities = {{ rail = 1 }}\noff = ["coil"{others}]'
    )
    text += effect + '[[event]]\nwhen = "slide(rail) - 2"\ndirection = "rising"\non = ["coil"]\n'
    text += f'[[event]]\nwhen = "t - 9"\non = ["coil"{others}]\n'
    run = simulate(workshop.model(text))
    assert run.success and [event.t for event in run.events] == [pytest.approx(2.0, abs=1e-12)] and not run.impacts
    assert run.at(3.0)[0] == pytest.approx([1.0 + np.cos(2.0) + 0.5 * np.sin(2.0)], abs=1e-10)


def test_a_ground_that_is_off_lets_through_and_catches_below_no_more(workshop: Workshop) -> None:
    """Through the ground at the second time, on to a lower one."""
    text = BALL.replace("until = 2", "until = 3")
    text += '[[ground]]\npoint = [0, -2]\nrestitution = 0\ncontacts = ["ball.P"]\n'
    text += '[[event]]\nname = "top"\nwhen = "rate(y(ball.P))"\ndirection = "falling"\noff = ["ground_0"]\n'
    run = simulate(workshop.model(text), rtol=1e-12)
    top = 1.5 * FALL
    falls = float(np.sqrt(2 * 2.25 / G))
    assert [impact.t for impact in run.impacts] == pytest.approx([FALL, top + falls], abs=1e-11)
    assert run.impacts[1].contacts == (("ball.P", "ground_1"),)
    index = [run.model.contacts.index(("ball.P", ground)) for ground in ("ground_0", "ground_1")]
    forces = run.contact_forces([0.1, 2.9])
    assert forces[:, index, 0] == pytest.approx(np.array([[0.0, 0.0], [0.0, G]]), abs=1e-9)


def test_a_ground_that_is_switched_on_above_a_point_ends_the_run(workshop: Workshop) -> None:
    text = (
        BALL + '[[event]]\nwhen = "t - 0.1"\noff = ["ground_0"]\n[[event]]\nwhen = "y(ball.P) + 1"\non = ["ground_0"]\n'
    )
    run = simulate(workshop.model(text))
    assert not run.success and "what changes here has ball.P inside ground_0 by 1 m" in run.message
    assert run.at(run.t[-1])[0][1] == pytest.approx(-1.0)


def test_gates_of_folded_models_are_all_that_can_be_set(workshop: Workshop, tmp_path: Path) -> None:
    text = OSCILLATOR + '[[event]]\nname = "cut"\nwhen = "t - 0.5"\noff = ["coil"]\n'
    model, plain = workshop.model(text, fold=True), workshop.model(text)
    assert list(model.settable) == ["coil.on"]
    free = simulate(model, params={"coil.on": 0.0}, until=0.4)
    assert free.q[-1] == pytest.approx([1.5], abs=1e-12)
    assert simulate(model).q[-1] == pytest.approx(simulate(plain).q[-1], abs=1e-11)
    found = ensemble(model, {"coil.on": [0.0, 1.0]}, observe=["q"], until=0.4)
    assert found["q"][:, 0] == pytest.approx([1.5, 1.0 + 0.5 * np.cos(0.8)], abs=1e-11)
    with pytest.raises(ValueError, match=r"coil\.mass|coil\.stiffness: found a new value for oscillator, whose"):
        model.with_parameters({"coil.stiffness": 3.0, "coil.on": 0.0})
    header = model.write_header(tmp_path / "one.h").read_text()
    assert "1.0, /* coil.on */" in header and "coil.stiffness" not in header
    (tmp_path / "one.toml").write_text(text)
    done = ccgen("run", "one.toml", "--fold", "--set", "coil.on=0", "--until", "0.4", at=tmp_path)
    assert done.returncode == 0 and "t = 0.4 s" in done.stdout
    assert "coil.on = 1.0" in ccgen("show", "one.toml", at=tmp_path).stdout


def test_a_function_of_an_event_may_switch_too(workshop: Workshop) -> None:
    """Its answer wins over the table, and what is no gate's value is told."""
    text = OSCILLATOR + '[[event]]\nname = "cut"\nwhen = "t - 0.5"\noff = ["coil"]\n'
    model = workshop.model(text + '[[event]]\nname = "later"\nwhen = "t - 1"\n')
    kept = simulate(model, on_event={"cut": lambda _: {"coil.on": 1.0}, "later": lambda _: {"coil.on": 0}}, until=2.0)
    cut, later = kept.events
    assert (cut.on, cut.off, cut.parameters, later.off, later.parameters) == ((), (), {}, ("coil",), {})
    x, v = 1.0 + 0.5 * np.cos(2.0), -np.sin(2.0)
    assert kept.q[-1] == pytest.approx([x + v], abs=1e-11)
    half = simulate(model, on_event={"cut": lambda _: {"coil.on": 0.5}})
    told = "stopped at t = 0.5 s by the answer to cut: coil.on: found 0.5, expected 1 or 0"
    assert not half.success and half.message == told and half.t[-1] == 0.5


@pytest.mark.hard
def test_the_simplest_walker_has_the_gait_of_massless_feet_in_the_limit(workshop: Workshop) -> None:
    model = workshop.model(load_scene(SCENES / "simplest-walker.toml"))
    periods = []
    for foot in (1e-4, 5e-5):
        leg = {"left.mass": 1 + foot, "left.com.x": 1 / (1 + foot), "left.inertia": foot / (1 + foot)}
        run = simulate(model, until=80.0, params=leg | {"right.mass": foot})
        assert run.success, run.message
        strikes = [impact for impact in run.impacts if impact.energy_loss > 1e-4]
        assert len(strikes) == 20
        periods.append(float(np.diff([impact.t for impact in strikes])[-4:].mean()))
        last = [event.name for event in run.events][-4:]
        assert sorted(last) == ["left_ahead", "left_through", "right_ahead", "right_through"]
    limit = 2 * periods[1] - periods[0]
    assert limit == pytest.approx(3.88246375285, abs=2e-8)
    assert abs(periods[1] - limit) > 1e-5  # the feet's mass is seen


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        (
            '[[event]]\nwhen = "t - 1"\noff = ["coli"]',
            'found "coli", expected an effect; those that can be switched are coil',
        ),
        ('[[event]]\nwhen = "t - 1"\noff = ["coil"]\non = ["coil"]', 'found "coil" in on too'),
        (
            '[[input]]\nname = "push"\njoint = "rail"\n[[event]]\nwhen = "t - 1"\noff = ["push"]',
            "a [[input]], expected an",
        ),
    ],
)
def test_wrong_switches_are_told_in_sentences(workshop: Workshop, lines: str, told: str) -> None:
    with pytest.raises(SceneError) as found:
        workshop.scene(OSCILLATOR + lines)
    assert told in str(found.value) and len(found.value.faults) == 1


def test_a_start_without_an_effect_wants_an_event_that_brings_it(workshop: Workshop) -> None:
    text = OSCILLATOR.replace("[run]", 'off = ["coil"]\n[run]')
    with pytest.raises(SceneError, match=r"expected an effect that an \[\[event\]\] switches on"):
        workshop.scene(text)


def test_effects_are_switched_beside_joints_that_change(workshop: Workshop) -> None:
    """A stone of 5 kg that a sling has let go is slowed down by a drag, until that is off."""
    text = TREBUCHET + '[[drag]]\npoint = "stone.C"\nlinear = 2\n[[event]]\nwhen = "t - 2"\noff = ["drag_0"]\n'
    run = simulate(workshop.model(text))
    (let_go,) = run.changes
    assert run.success and let_go.t < 1.9
    stone = run.model.links.index("stone")
    slow, free = (run.point("stone.C", [t]) for t in (1.95, 2.5))
    for at, drag in ((slow, 2.0), (free, 0.0)):
        wanted = np.array([0.0, -G]) - drag / 5.0 * at.velocity[0]
        assert at.acceleration[0] == pytest.approx(wanted, abs=1e-9)
    first, last = (run.model.velocities(*run.at(t))[stone, :2] for t in (2.0, 3.0))
    assert last - first == pytest.approx([0.0, -G], abs=1e-9)
    assert run.energy_drift < 1e-6 and run.model_at(2.5).off == ("drag_0",)


LANDING = (
    OSCILLATOR
    + """
[[link]]
name = "ball"
mass = 1
inertia = 1
com = [0, 0]
points = { C = [0, 0] }
[[joint]]
name = "fall"
type = "prismatic"
between = ["ground.O", "ball.C"]
axis = [0, 1]
[[compliant_ground]]
contacts = ["ball.C"]
load = 200
depth = 0.01
restitution = 0.4
[gravity]
"""
).replace("rail = 1.5", "rail = 1.5, fall = 0.2")


def test_what_others_hold_stays_as_it_is(workshop: Workshop) -> None:
    """A ball presses on a ground whose damping knows how fast it came, while a spring elsewhere is cut."""
    plain = simulate(workshop.model(LANDING), until=1.0)
    run = simulate(workshop.model(LANDING + '[[event]]\nname = "cut"\nwhen = "t - 0.21"\noff = ["coil"]\n'), until=1.0)
    (cut,) = run.events
    ball = run.model.links.index("ball")
    assert cut.t == 0.21 and run.model.poses(run.at(0.21)[0])[ball, 1] < -1e-3
    at = np.linspace(0.2, 1.0, 30)
    found, wanted = (one.model.poses(one.at(at)[0])[:, ball, 1] for one in (run, plain))
    np.testing.assert_allclose(found, wanted, atol=1e-9)
    assert run.energy_drift < 1e-9
