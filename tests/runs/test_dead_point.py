"""A joint driven past a dead point: where and when it comes to a stop, as geometry has it, and what is kept."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from copy import deepcopy
from importlib import import_module
from typing import Any

import numpy as np
import pytest

from ccgen.generator.cli.report import energy_moved
from ccgen.runtime import driving_torque, simulate
from ccgen.runtime.simulation.dead_point import Way, cut, dead_point

from ..support.command_line import ccgen
from ..support.driven_crank import CRANK, L, R
from ..support.workshop import Workshop

A, B, C, D = 0.2, 0.5, 0.5, 0.6
"""Crank, coupler, rocker and frame."""


def link(name: str, length: float) -> str:
    return (
        f'[[link]]\nname = "{name}"\nmass = 1.0\ninertia = 0.02\ncom = [{length / 2}, 0]\n'
        f"points = {{ A = [0, 0], B = [{length}, 0] }}\n"
    )


FOUR_BAR = f"""
name = "jam"
[ground_link]
points = {{ O = [0, 0], Q = [{D}, 0] }}
{link("crank", A)}{link("coupler", B)}{link("rocker", C)}
[[joint]]
between = ["ground.O", "crank.A"]
[[joint]]
between = ["crank.B", "coupler.A"]
[[joint]]
between = ["coupler.B", "rocker.B"]
[[joint]]
name = "swing"
between = ["ground.Q", "rocker.A"]
[gravity]
[run]
until = 3.0
[start]
angles = {{ crank = "90 deg", coupler = "20 deg", rocker = "100 deg" }}
"""
INNER = math.pi - math.acos((D * D + C * C - (B - A) ** 2) / (2 * C * D))
"""Angle of the rocker where crank and coupler fold onto each other, by the law of cosines."""
OUTER = math.pi - math.acos((D * D + C * C - (B + A) ** 2) / (2 * C * D))
"""And where they are stretched."""


def driven(workshop: Workshop, motion: str) -> Any:
    return workshop.model(f'{FOUR_BAR}\n[[drive]]\njoint = "swing"\n{motion}\n')


def where(run: Any) -> tuple[float, float, float]:
    """Where the message says the run ended (s), how far the joint had turned (rad) and when it stands still (s)."""
    said = re.match(r"stopped at t = (\S+) s: swing comes to a stop after (\S+)°, at t = (\S+) s: ", run.message)
    assert said, run.message
    end, turned, stop = map(float, said.groups())
    return end, math.radians(turned), stop


WAYS: list[Mapping[str, Any]] = [
    *({"method": method, "rtol": rtol} for method in ("gauss", "dop853", "dopri5", "radau") for rtol in (1e-3, 1e-9)),
    {"rtol": 1e-13},
    {"drift": "left"},
    *({"method": method, "step": step} for method in ("gauss", "dop853") for step in (0.4, 0.01)),
]


@pytest.mark.parametrize("way", WAYS, ids=str)
def test_the_stop_is_where_the_links_are_in_line(way: Mapping[str, Any], workshop: Workshop) -> None:
    """Whatever the steps: angle and time to the digits that are printed, and rows before it only."""
    model = driven(workshop, "speed = 1")
    start = float(model.start()[0][2])
    run = simulate(model, **way)
    end, turned, stop = where(run)
    assert not run.success and "crank and coupler are in line there" in run.message and "[[motor]]" in run.message
    loose = way.get("drift") == "left"
    assert turned == pytest.approx(INNER - start, rel=1e-5)
    assert stop == pytest.approx(INNER - start, rel=1e-6 if loose else 1e-8)
    assert run.t[-1] == pytest.approx(end, rel=1e-11) and run.t[-1] < stop
    if "step" not in way:
        assert stop - run.t[-1] < 1e-3
    assert np.abs(run.q[:, 2] - start - run.t).max() <= 1e-12
    tolerance = way.get("rtol", 1e-9)
    kinetic = run.model.energy(run.q, run.u)[0]
    assert kinetic.max() <= 1e4 * kinetic[0]
    if "step" not in way:
        assert run.energy_drift <= max(1e4 * tolerance, 1e-4) * energy_moved(run)


def test_the_other_way_round_is_the_other_stop(workshop: Workshop) -> None:
    model = driven(workshop, "speed = -0.5")
    run = simulate(model)
    _, turned, stop = where(run)
    way = OUTER - float(model.start()[0][2])
    assert way < 0.0
    assert turned == pytest.approx(way, rel=1e-5) and stop == pytest.approx(-2.0 * way, rel=1e-8)


def test_a_motion_of_time_stops_when_it_gets_there(workshop: Workshop) -> None:
    """One that turns back before it gets there does not."""
    run = simulate(driven(workshop, 'angle = "1.95 + 0.7*sin(3*t)"'))
    _, turned, stop = where(run)
    assert stop == pytest.approx(math.asin((INNER - 1.95) / 0.7) / 3.0, rel=1e-8)
    assert turned == pytest.approx(INNER - 1.95, rel=1e-5)
    assert simulate(driven(workshop, 'angle = "2.2 + 0.4*sin(3*t)"')).success


def test_the_torque_stops_there_too(workshop: Workshop) -> None:
    """Found another way, by walking along the configurations, to the same digits."""
    run = simulate(driven(workshop, "speed = 1"))
    turned = math.degrees(where(run)[1])
    with pytest.raises(ValueError, match=rf"comes to a stop after {turned:.6g}°"):
        driving_torque(workshop.model(FOUR_BAR), "swing", 1.0)


def test_events_do_not_change_what_is_told(workshop: Workshop) -> None:
    """Events cut runs into stretches: the way is that since the run began, or since the state that it goes on from."""
    event = '[[event]]\nwhen = "t - 0.1"\nset = { "rocker.mass" = 2 }\n'
    model = workshop.model(f'{FOUR_BAR}\n[[drive]]\njoint = "swing"\nspeed = 1\n{event}')
    start = float(model.start()[0][2])
    turned, stop = where(simulate(model))[1:]
    assert turned == pytest.approx(INNER - start, rel=1e-5) and stop == pytest.approx(INNER - start, rel=1e-8)
    then = simulate(model, state=simulate(model, until=0.25).state, until=3.0)
    said = re.match(r"stopped at t = \S+ s: swing comes to a stop after (\S+)° since t = 0.25 s, at t = ", then.message)
    assert said and math.radians(float(said[1])) == pytest.approx(INNER - start - 0.25, rel=1e-5)


def test_changes_of_joints_do_not_change_what_is_told(workshop: Workshop) -> None:
    """A latch that opens, and a scene that looks for changes in stretches: the way is that since the run began."""
    flap = link("flap", 0.1) + '[[joint]]\nname = "latch"\nbetween = ["ground.Z", "flap.A"]\n'
    change = '[[release]]\njoint = "latch"\nat = 0.3\n[[drive]]\njoint = "swing"\nspeed = 1\n'
    ground = f"points = {{ O = [0, 0], Q = [{D}, 0]"
    model = workshop.model(
        FOUR_BAR.replace(ground, f"{ground}, Z = [9, 9]").replace("[gravity]", f"{flap}[gravity]") + change
    )
    start = float(driven(workshop, "speed = 1").start()[0][2])
    turned, stop = where(simulate(model))[1:]
    assert turned == pytest.approx(INNER - start, rel=1e-5) and stop == pytest.approx(INNER - start, rel=1e-8)


def test_a_slider_stops_where_crank_and_rod_are_stretched(workshop: Workshop) -> None:
    model = workshop.model(f'{CRANK}\n[[drive]]\njoint = "guide"\nspeed = 0.25\n')
    q, _ = model.start()
    run = simulate(model, until=9.0)
    way = L + R - float(model.slides(q)["guide"])
    said = re.search(r"guide comes to a stop after (\S+) m, at t = (\S+) s: crank and rod are in line", run.message)
    assert said, run.message
    assert float(said[1]) == pytest.approx(way, rel=1e-5) and float(said[2]) == pytest.approx(4.0 * way, rel=1e-8)


LEASHED = """
name = "leashed"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "cart"
mass = 1.0
inertia = 0.1
com = [0, 0]
points = { C = [0, 0] }
[[link]]
name = "rod"
mass = 1.0
inertia = 0.02
points = { A = [0, 0], B = [-0.5, 0] }
com = [-0.25, 0]
[[joint]]
name = "rail"
type = "prismatic"
axis = 0
between = ["ground.O", "cart.C"]
[[joint]]
between = ["cart.C", "rod.A"]
[[rope]]
between = ["rod.B", "ground.O"]
length = 0.8
restitution = 0
[[drive]]
joint = "rail"
speed = 0.7
[start]
angles = { rod = "60 deg" }
slides = { rail = 0.9 }
"""


@pytest.mark.parametrize("way", [{}, {"method": "dop853", "rtol": 1e-6}, {"step": 0.02}], ids=str)
def test_a_cart_on_a_leash_stops_where_rod_and_rope_are_in_line(way: Mapping[str, Any], workshop: Workshop) -> None:
    """Contacts that are held stop a drive as loops do: at the length of the rope and of the rod."""
    run = simulate(workshop.model(LEASHED), until=2.0, **way)
    said = re.search(
        r"rail comes to a stop after (\S+) m, at t = (\S+) s: no motion keeps ground.O on rope_0", run.message
    )
    assert said, run.message
    assert float(said[1]) == pytest.approx(1.3 - 0.9, rel=1e-5) and float(said[2]) == pytest.approx(0.4 / 0.7, rel=1e-8)
    assert run.phases[-1].contacts == (("ground.O", "rope_0"),)


def test_redundant_joints_hide_no_dead_point(workshop: Workshop) -> None:
    """A second crank beside the first, whose pins the loops do not need: rows depend on each other everywhere."""
    beside = 'between = ["ground.O", "twin.A"]\n[[joint]]\nbetween = ["twin.B", "coupler.A"]\n'
    text = FOUR_BAR.replace("[gravity]", f"{link('twin', A)}[[joint]]\n{beside}[gravity]")
    text = text.replace('crank = "90 deg"', 'crank = "90 deg", twin = "90 deg"')
    model = workshop.model(f'{text}\n[[drive]]\njoint = "swing"\nspeed = 1\n')
    start = float(model.start()[0][model.links.index("rocker")])
    _, turned, stop = where(simulate(model))
    assert turned == pytest.approx(INNER - start, rel=1e-5) and stop == pytest.approx(INNER - start, rel=1e-8)


def test_a_dead_point_that_is_passed_is_none(workshop: Workshop) -> None:
    """The crank itself turns round and round, through both."""
    run = simulate(workshop.model(f'{FOUR_BAR}\n[[drive]]\njoint = "joint_0"\nspeed = 5.0\n'))
    assert run.success, run.message


def test_a_change_point_is_none(workshop: Workshop) -> None:
    """Rows become dependent just as much where a parallelogram is flat, but it can go on: velocities do not grow."""
    motion = '[[drive]]\njoint = "swing"\nspeed = 3\n'
    equal = FOUR_BAR.replace(link("rocker", C), link("rocker", A)).replace(link("coupler", B), link("coupler", D))
    equal = equal.replace('coupler = "20 deg", rocker = "100 deg"', 'coupler = "0 deg", rocker = "90 deg"')
    parallel, jam = workshop.model(equal + motion), driven(workshop, "speed = 1")
    for model, flat, stops in ((parallel, math.pi / 6, False), (jam, INNER - float(jam.start()[0][2]), True)):
        run = simulate(model, until=flat * (1 - 1e-8), rtol=1e-12)
        assert run.success, run.message
        found = dead_point(model, run.t, run.q, run.u, 0.0, lambda t, q, u, h: (q, u), Way(0.0, {}))
        assert (found is not None) == stops
        assert found is None or found.t == pytest.approx(flat, rel=1e-8)


def test_another_end_is_no_dead_point(workshop: Workshop) -> None:
    """Numbers that are none end a driven run far from where it would be stopped."""
    load = '[[torque]]\nlink = "crank"\ntorque = "1e200*exp(900*t)"\n'
    run = simulate(driven(workshop, f"speed = 0.1\n{load}"))
    assert not run.success and "comes to a stop" not in run.message


def test_what_is_cut_is_a_run_of_its_own(workshop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    """Impacts, held contacts, phases and forces up to the last row that is kept, wherever that is."""
    module = import_module("ccgen.runtime.simulation.one_run")
    record, seen = module.run_of, []
    monkeypatch.setattr(module, "run_of", lambda *given: (seen.append(deepcopy(given)), record(*given))[1])
    ground = "[[ground]]\npoint = [0, -0.8]\nrestitution = 0.4\nfriction = 0.3\n"
    model = workshop.model(f"name = 'flail'\n[chain]\nlinks = 2\nhinged = true\n[gravity]\n{ground}")
    whole = simulate(model, [0.0, 0.3], [0.0, 0.0], until=2.0)
    (_, advance, until, found, fixed, _) = seen[0]
    assert len(whole.impacts) > 5 and len(found["held"]) > 3
    changes = [int(np.searchsorted(whole.t, t, side="right")) for t in found["hold_t"]]
    for rows in sorted({1, 2, *found["after"], *(k + 1 for k in found["after"]), *changes, len(whole.t)}):
        run = record(model, advance, until, cut(deepcopy(found), rows), fixed, None)
        assert np.array_equal(run.t, whole.t[:rows]) and np.array_equal(run.q, whole.q[:rows])
        assert len(run.impacts) == sum(k < rows for k in found["after"])
        assert all(np.array_equal(a.friction, b.friction) for a, b in zip(run.impacts, whole.impacts, strict=False))
        assert run.phases[:-1] == whole.phases[: max(len(run.phases) - 1, 0)]
        inner = run.t[0] + 0.999 * (run.t[-1] - run.t[0])
        assert np.array_equal(run.contact_forces(inner), whole.contact_forces(inner))


def test_the_command_says_it(tmp_path: Any) -> None:
    (tmp_path / "jam.toml").write_text(f'{FOUR_BAR}\n[[drive]]\njoint = "swing"\nspeed = 1\n')
    done = ccgen("run", "jam.toml", "-q", at=tmp_path)
    assert done.returncode == 3 and done.stdout == ""
    assert re.fullmatch(r"jam: stopped at t = 0\.69\d* s: swing comes to a stop after 39\.8121°, .*\n", done.stderr)
