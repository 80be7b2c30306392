"""What is told of an instant is told with the parameters and effects of that instant: against closed forms."""

from __future__ import annotations

import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.generator.cli.report import energy_moved, energy_scale, print_audit, print_events, row
from ccgen.runtime import ensemble, load_model, load_run, simulate
from ccgen.runtime.pictures import player
from ccgen.runtime.pictures.frames import frame_times, sample
from ccgen.runtime.pictures.gif import drawn_frames
from ccgen.runtime.pictures.view import view_of

from ..support.workshop import Workshop
from .test_effects_on_and_off import OSCILLATOR
from .test_release_and_hold import TREBUCHET
from .test_user_events import BALL, FALL, G

ROD = """
name = "rod"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "rod"
mass = 1
inertia = 0.1
com = [0.5, 0]
points = { A = [0, 0], B = [1, 0] }
[[joint]]
name = "h"
between = ["ground.O", "rod.A"]
[[torsion]]
name = "ts"
joint = "h"
stiffness = 2
angle = "-90 deg"
[start]
angles = { rod = "-60 deg" }
[gravity]
[run]
until = 2
"""
HEAVY = {"rod.mass": 3.0, "ts.stiffness": 10.0, "rod.points.B.x": 2.0}
SET = '[[event]]\nname = "heavy"\nwhen = "t - 1"\nset = { "rod.mass" = 3, "ts.stiffness" = 10, "rod.points.B.x" = 2 }\n'
FLOOR = '[[ground]]\nname = "floor"\npoint = [0, -1.98]\nrestitution = 0.5\ncontacts = ["rod.B"]\n'


def check(values: Any, heavy: bool) -> None:
    """Energies, the free end and the torsion, of the rod before or after the event."""
    m, k, length = (3.0, 10.0, 2.0) if heavy else (1.0, 2.0, 1.0)
    angle, rate = values["rod.angle"], values["rod.angular_velocity"]
    bent = angle + math.pi / 2
    assert values["kinetic_energy"] == pytest.approx(0.5 * (0.1 + 0.25 * m) * rate**2, abs=1e-12)
    potential = m * G * 0.5 * np.sin(angle) + 0.5 * k * bent**2
    assert values["potential_energy"] == pytest.approx(potential, abs=1e-12)
    assert values["energy"] == pytest.approx(values["kinetic_energy"] + potential, abs=1e-12)
    assert values["rod.B.y"] == pytest.approx(length * np.sin(angle), abs=1e-12)
    assert values["rod.B.vx"] == pytest.approx(-length * rate * np.sin(angle), abs=1e-12)
    alpha = (-k * bent - m * G * 0.5 * np.cos(angle)) / (0.1 + 0.25 * m)
    ay = length * (alpha * np.cos(angle) - rate**2 * np.sin(angle))
    known = np.isfinite(values["rod.B.ay"])
    assert np.count_nonzero(~known) <= 1
    assert values["rod.B.ay"][known] == pytest.approx(ay[known], abs=1e-9)


NAMES = ("rod.angle", "rod.angular_velocity", "kinetic_energy", "potential_energy", "energy", "rod.B.y", "rod.B.vx")


def check_run(run: Any) -> None:
    for begin, end, heavy in ((0.0, 1.0 - 1e-9, False), (1.0, 2.0, True)):
        check(run.values(*NAMES, "rod.B.ay", t=np.linspace(begin, end, 9)), heavy)
    at_rows = run.values(*NAMES, "rod.B.ay")
    change = int(np.flatnonzero(run.t == 1.0)[0])
    assert run.t[change + 1] == 1.0  # before and after
    check({name: values[: change + 1] for name, values in at_rows.items()}, False)
    check({name: values[change + 1 :] for name, values in at_rows.items()}, True)


@pytest.fixture(scope="module")
def heavy(workshop: Workshop) -> Any:
    return simulate(workshop.model(ROD + SET))


def test_outputs_have_the_parameters_of_their_instant(heavy: Any) -> None:
    check_run(heavy)
    then = heavy.model_at(1.0)
    assert [heavy.model_at(t).parameters["rod.mass"] for t in (0.0, 0.999, 1.0, 2.0)] == [1.0, 1.0, 3.0, 3.0]
    assert then is heavy.model_at(2.0) and heavy.model.parameters["rod.mass"] == 1.0
    with pytest.raises(ValueError, match=r"t: found 2.5, expected a time within the run, from 0.0 to 2.0 s"):
        heavy.model_at(2.5)
    point = heavy.point("rod.B", 1.5)
    named = heavy.values("rod.B.x", "rod.B.y", "rod.B.ax", t=1.5)
    assert point.position.tolist() == [named["rod.B.x"], named["rod.B.y"]]
    assert point.acceleration[0] == named["rod.B.ax"]


def test_so_do_runs_from_files_and_pickles_and_those_that_go_on(heavy: Any, workshop: Workshop, tmp_path: Path) -> None:
    model = workshop.model(ROD + SET)
    file = heavy.save(tmp_path / "run.npz")
    check_run(load_run(file, load_model(model.folder)))
    check_run(pickle.loads(pickle.dumps(heavy)))
    with np.load(file) as arrays:
        first, last = arrays["event_set_offsets"]
        told = dict(zip(arrays["event_set_names"].tolist(), arrays["event_set_values"].tolist(), strict=True))
        assert (first, last, told) == (0, 3, HEAVY)
        assert arrays["event_set_before"].tolist() == [model.parameters[path] for path in arrays["event_set_names"]]
    on = simulate(model, state=heavy.state, until=2.5)
    check(on.values(*NAMES, "rod.B.ay", t=np.linspace(2.0, 2.5, 5)), True)


def test_what_a_function_answers_counts_alike(heavy: Any, workshop: Workshop) -> None:
    model = workshop.model(ROD + '[[event]]\nname = "heavy"\nwhen = "t - 1"\n')
    check_run(simulate(model, on_event={"heavy": lambda event: HEAVY}))


def test_tables_and_ensembles_have_the_same(heavy: Any, workshop: Workshop) -> None:
    energies = heavy.values("kinetic_energy", "potential_energy")
    frame = heavy.to_dataframe()
    assert frame["kinetic_energy"].tolist() == energies["kinetic_energy"].tolist()
    assert frame["potential_energy"].tolist() == energies["potential_energy"].tolist()
    many = ensemble(
        workshop.model(ROD + SET), observe=["energy", "rod.B.y"], params={"rod.inertia": [0.1]}, at=[0.5, 1.5]
    )
    assert many["energy"][0] == pytest.approx(heavy.values("energy", t=[0.5, 1.5])["energy"], abs=1e-12)
    assert many["rod.B.y"][0] == pytest.approx(heavy.values("rod.B.y", t=[0.5, 1.5])["rod.B.y"], abs=1e-12)


def test_what_an_event_does_to_the_energy_is_a_jump_and_no_drift(
    heavy: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    """Energies of the instant: m g y and k/2 of the square of the bend, before and after; the kinetic one grows with
    the inertia about the pin."""
    (event,) = heavy.events
    angle, rate = heavy.at(1.0)[0][0], heavy.at(1.0)[1][0]
    bent = angle + math.pi / 2
    jump = 2 * G * 0.5 * math.sin(angle) + 0.5 * 8 * bent**2 + 0.5 * 0.5 * rate**2
    assert event.energy == pytest.approx(jump, abs=1e-12)
    energy = heavy["energy"]
    assert energy[-1] - energy[0] == pytest.approx(jump, abs=1e-11)
    assert heavy.energy_drift < 1e-11
    print_events(heavy)
    print_audit(heavy)
    told = capsys.readouterr().out
    assert f"rod.points.B.x from 1 to 2, the energy jumps by {jump:.6g} J" in told
    assert f"above its lowest beside jumps of {abs(jump):.3g} J in all at events; method" in told


def test_the_energy_that_moves_is_that_between_events(heavy: Any) -> None:
    """The jump at the event is none that moves, nor the distance of one zero of potentials from the other."""
    most = 0.0
    for begin, end in ((0.0, 1.0 - 1e-12), (1.0, 2.0)):
        values = heavy.values("energy", "potential_energy", t=np.linspace(begin, end, 2000))
        most = max(most, values["energy"].max() - values["potential_energy"].min())
    assert energy_moved(heavy) == pytest.approx(most, rel=0.02) and energy_moved(heavy) <= most + 1e-9
    assert most < 0.3 * abs(heavy.events[0].energy)
    # a radian in a characteristic time, whose square is the length over a metre, on earth
    assert energy_scale(heavy) == pytest.approx(max(0.5 * 0.35 / 1.0, 0.5 * 0.85 / 2.0))


def test_impacts_are_told_with_the_energies_of_their_instant(workshop: Workshop) -> None:
    """The heavy rod, of twice the length, bounces: restitution 1/2 leaves a quarter of its kinetic energy."""
    model = workshop.model(ROD + SET + FLOOR)
    run = simulate(model)
    impact, then = run.impacts[0], run.in_force.at_impact(0)
    assert impact.t > 1.0
    angle = -math.pi + math.asin(1.98 / 2.0)
    assert run.at(impact.t)[0] == pytest.approx([angle], abs=1e-12)
    before, after = (0.5 * 0.85 * u[0] ** 2 for u in (impact.u_minus, impact.u_plus))
    assert impact.energy_loss == pytest.approx(before - after) and after == pytest.approx(0.25 * before)
    cells = row(model, run, 0, then)
    left = after + 3 * G * 0.5 * math.sin(angle) + 5.0 * (angle + math.pi / 2) ** 2
    assert float(cells[-1]) == pytest.approx(left, abs=1e-8)
    assert float(cells[2]) == pytest.approx(2.0 * impact.u_minus[0] * math.cos(angle), abs=1e-8)
    t = np.array([0.5, 1.0, 1.2])
    gap = run.values("floor.rod.B.gap", "rod.B.y", t=t)
    assert gap["floor.rod.B.gap"] == pytest.approx(gap["rod.B.y"] + 1.98, abs=1e-12)
    content = player.content(run)
    assert content["impacts"][0]["contacts"][0]["at"] == pytest.approx([2.0 * math.cos(angle), -1.98], abs=1e-4)


def test_pictures_have_the_lengths_of_their_instant(heavy: Any) -> None:
    content = player.content(heavy)
    assert content["links"][0]["outline"] == [[0.0, 0.0], [1.0, 0.0]]
    ((frame, later),) = content["later"]
    assert content["t"][frame] == 1.0 and later["links"][0]["outline"] == [[0.0, 0.0], [2.0, 0.0]]
    assert later["massCentres"][0]["mass"] == 3.0 and "grounds" not in later
    chart = content["chart"]
    energy = np.array(next(one["values"] for one in chart["columns"] if one["name"] == "energy"))
    twice = int(np.flatnonzero(np.diff(chart["t"]) == 0)[0])
    assert chart["t"][twice] == 1.0
    assert energy[twice + 1] - energy[twice] == pytest.approx(heavy.events[0].energy, abs=1e-4)
    frames = sample(heavy, frame_times(heavy, 30.0))
    view = view_of(frames)
    low = 2.0 * np.sin(frames.poses[frames.t >= 1.0, 0, 2]).min()
    assert view.centre[0, 1] - view.half[1] < low
    drawn = drawn_frames(heavy, 25, 100, "a test")
    lengths = {max(np.ptp(np.array(line.get_data()), axis=1).max() for line in bars(figure)) for figure in drawn}
    assert max(lengths) > 1.9


def bars(figure: Any) -> list[Any]:
    """Lines of two points that are drawn of links."""
    return [
        line for line in figure.axes[0].lines if len(line.get_xdata()) == 2 and line.get_solid_capstyle() == "round"
    ]


def test_what_is_off_is_not_drawn_and_has_no_gap(workshop: Workshop) -> None:
    text = BALL.replace("until = 2", "until = 1.5")
    text += '[[spring]]\nname = "coil"\nbetween = ["ground.O", "ball.P"]\nstiffness = 0.001\nlength = 1\n'
    text = text.replace("[[link]]", "[ground_link]\npoints = { O = [0, 2] }\n[[link]]", 1)
    text += '[[event]]\nname = "top"\nwhen = "rate(y(ball.P))"\ndirection = "falling"\noff = ["ground_0", "coil"]\n'
    run = simulate(workshop.model(text))
    top = run.events[0].t
    gaps = run.values("ground_0.ball.P.gap", "ground_0.ball.P.gap_rate", "ball.P.y", t=[0.3, 1.4])
    assert gaps["ground_0.ball.P.gap"][0] == pytest.approx(gaps["ball.P.y"][0])
    assert np.isnan(gaps["ground_0.ball.P.gap"][1]) and np.isnan(gaps["ground_0.ball.P.gap_rate"][1])
    content = player.content(run)
    assert [ground["name"] for ground in content["grounds"]] == ["ground_0"]
    assert [part["name"] for part in content["parts"]] == ["coil"] and content["groundPoints"]
    ((frame, later),) = content["later"]
    assert content["t"][frame] == pytest.approx(top, abs=1e-8)
    assert later["grounds"] == later["parts"] == []
    assert "groundPoints" not in later  # the ground keeps what the spring hung on, as it does that of a joint let go
    figure: Any = run.plot()
    heights = figure.subfigs[1].axes[1].lines[0].get_xydata()
    assert heights[np.isfinite(heights[:, 1]), 0].max() == pytest.approx(top, abs=0.01)
    poses = figure.subfigs[0].axes
    hatched = [sum(patch.get_hatch() is not None for patch in axes.patches) for axes in poses]
    times = [float(axes.get_title().split("=")[1].split()[0].strip("$")) for axes in poses]
    assert hatched == [int(t < top - 1e-3) for t in times] and set(hatched) == {0, 1}  # of rounded times


def test_energies_are_without_what_is_off(workshop: Workshop) -> None:
    """The cart's spring of 8 N/m and 1 m is cut at half a second."""
    text = OSCILLATOR + '[[event]]\nname = "cut"\nwhen = "t - 0.5"\noff = ["coil"]\n'
    values = simulate(workshop.model(text)).values("potential_energy", "rail.slide", t=[0.4, 0.6, 2.0])
    assert values["potential_energy"] == pytest.approx([4.0 * (values["rail.slide"][0] - 1.0) ** 2, 0.0, 0.0])


def test_a_run_in_which_joints_let_go_has_them_too(workshop: Workshop) -> None:
    """The stone's mass is doubled in flight, after its joint has let go: twice its energies from then on."""
    mass = 5.0
    text = TREBUCHET + '[[event]]\nname = "later"\nwhen = "t - 1.25"\nset = { "stone.mass" = 10 }\n'
    run = simulate(workshop.model(text), until=1.3)
    assert run.changes and run.changes[0].t < 1.25
    (event,) = run.events
    before, after = run.values("energy", t=[event.t - 1e-9, event.t])["energy"]
    assert after - before == pytest.approx(event.energy, abs=1e-5)
    speed, y = (run.values(f"stone.{what}", t=event.t)[f"stone.{what}"] for what in ("C.speed", "C.y"))
    assert event.energy == pytest.approx(mass * (0.5 * speed**2 + G * y), rel=1e-6)


def test_each_impact_is_told_with_the_mass_of_its_time(workshop: Workshop) -> None:
    """Heights count from where the ball strikes: what is left is kinetic energy."""
    text = BALL + '[[event]]\nwhen = "t - 0.8"\nset = { "ball.mass" = 2 }\n'
    run = simulate(workshop.model(text))
    assert FALL < 0.8 < run.impacts[1].t
    for number, mass in ((0, 1.0), (1, 2.0)):
        impact = run.impacts[number]
        cells = row(run.model, run, number, run.in_force.at_impact(number))
        assert float(cells[-1]) == pytest.approx(0.5 * mass * impact.u_plus[1] ** 2, abs=1e-8)
        assert float(cells[-2]) == pytest.approx(1.5 * mass * impact.u_plus[1] ** 2, abs=1e-8)  # restitution 1/2


def test_an_event_at_an_impact_comes_after_it(workshop: Workshop) -> None:
    """The ball of 1 kg strikes, and is of 2 kg from then on: three rows of one time, and an impact of 1 kg."""
    text = BALL + '[[event]]\nwhen = "y(ball.P)"\ndirection = "falling"\nset = { "ball.mass" = 2 }\n'
    run = simulate(workshop.model(text.replace("until = 2", "until = 0.6")))
    (impact,), (event,) = run.impacts, run.events
    assert event.t == impact.t and impact.energy_loss == pytest.approx(0.75 * G)
    at = np.flatnonzero(run.t == impact.t)
    assert run["energy"][at] == pytest.approx([G, 0.25 * G, 0.5 * G]) and event.energy == pytest.approx(0.25 * G)
    cells = row(run.model, run, 0, run.in_force.at_impact(0))
    assert float(cells[-1]) == pytest.approx(0.25 * G, abs=1e-8)
    assert run.values("energy", t=impact.t)["energy"] == pytest.approx(0.5 * G)
