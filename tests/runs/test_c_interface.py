"""Simulations from C: the commands of docs/c.md, what they print against Python's run, and what the library refuses."""

from __future__ import annotations

import ctypes
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.generator import generate, load_scene
from ccgen.runtime import ensemble, load_model, simulate

from ..support.c_library import Library, Settings
from ..support.folders import ROOT
from ..support.parallel_cranks import parallel_cranks
from ..support.workshop import Workshop
from ..support.written_models import Descriptor
from .test_effects_on_and_off import OSCILLATOR
from .test_user_events import BALL

SCENE = ROOT / "scenes" / "falling-hexagon.toml"
COMMANDS = re.findall(r"```sh\n(.*?)```", (ROOT / "docs" / "c.md").read_text(), re.S)


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """A folder in which the commands of docs/c.md have been run, and what they print; not optimised, which takes a
    third of the time."""
    if os.name != "posix" or not shutil.which("cc"):
        pytest.skip("the commands are for a shell and cc")
    folder = tmp_path_factory.mktemp("c")
    for name in ("scenes", "docs"):
        (folder / name).symlink_to(ROOT / name)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["sh", "-ec", "\n".join(COMMANDS).replace("cc -O2", "cc -Wall -Wextra -Werror -O0")],
        cwd=folder,
        env={**os.environ, "PATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return folder, done.stdout


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Library:
    """The core without a model."""
    return Library(ROOT / "runtime", tmp_path_factory.mktemp("core") / "libccgen.so")


def test_the_hexagon_flies_as_from_python(built: tuple[Path, str], workshop: Workshop) -> None:
    """Times of all impacts after the third, and the energy at the end."""
    printed = built[1]
    run = simulate(workshop.model(load_scene(SCENE)))
    times = [float(t) for t in re.findall(r"^closes +t = ([\d.]+) s", printed, re.M)]
    kept = float(re.findall(r"^state +t = ([\d.]+) s", printed, re.M)[0])
    expected = [impact.t for impact in run.impacts]
    assert np.abs(np.subtract([kept, *times], expected[2:])).max() <= 1e-9
    energies = [float(e) for e in re.findall(r"^energy ([\d.]+) J", printed, re.M)]
    whole = [sum(run.model.energy(run.q[row], run.u[row])) for row in (0, -1)]
    assert np.abs(np.subtract(energies, whole)).max() <= 1e-7
    assert "the same yes\n" in printed
    assert len(re.findall(r"^end ", printed, re.M)) == 1


def test_the_walker_walks_as_from_python(built: tuple[Path, str], workshop: Workshop) -> None:
    """Steps, the events that switch the ground in them, and the strikes."""
    printed = re.findall(r"^t = +([\d.]+) s  (.+)$", built[1], re.M)
    run = simulate(workshop.model(load_scene(ROOT / "scenes" / "simplest-walker.toml")), until=12.0)
    strikes = [(float(impact.t), "a foot strikes") for impact in run.impacts if impact.energy_loss > 1e-4]
    assert [what for _, what in printed if what != "a foot strikes"] == [event.name for event in run.events]
    found = [(float(t), what) for t, what in printed]
    for t, what in [*((event.t, event.name) for event in run.events), *strikes]:
        assert min(abs(t - other) for other, said in found if said == what) <= 1e-6
    assert len(strikes) == 3 and len(run.events) == 6


def test_the_trebuchet_throws_as_far_as_from_python(built: tuple[Path, str], workshop: Workshop) -> None:
    """When its stone leaves, from where, and when and where it strikes the ground."""
    thrown = re.findall(r"^thrown at t = ([\d.]+) s from x = (-?[\d.]+) m, y = ([\d.]+) m$", built[1], re.M)
    lands = re.findall(r"^lands at t = ([\d.]+) s at x = ([\d.]+) m$", built[1], re.M)
    run = simulate(workshop.model(load_scene(ROOT / "scenes" / "trebuchet.toml")), until=7.0)
    (change,) = run.changes
    strikes = next(impact.t for impact in run.impacts if impact.t > change.t)
    stone = run.point("stone.C", [change.t, strikes]).position
    assert [[float(number) for number in one] for one in thrown] == [pytest.approx([change.t, *stone[0]], abs=1e-7)]
    assert [[float(number) for number in one] for one in lands] == [pytest.approx([strikes, stone[1, 0]], abs=1e-6)]
    header = (built[0] / "build" / "trebuchet.h").read_text()
    assert " * events by their numbers: 0 pouch lets go\n" in header


def test_the_model_is_generated_anew_behind_them(built: tuple[Path, str], tmp_path: Path) -> None:
    """What they have written is not in the way of a scene that has changed."""
    changed = tmp_path / SCENE.name
    changed.write_text(SCENE.read_text().replace("9.81", "1.62"))
    assert "1.62" in changed.read_text()
    package = generate(load_scene(changed), out=built[0] / "build")
    assert load_model(package).parameters["gravity.g"] == 1.62


def test_headers_are_written_beside_a_package_alone(workshop: Workshop, tmp_path: Path) -> None:
    model = workshop.model(load_scene(SCENE))
    with pytest.raises(
        ValueError, match=r"found a place in the model's package, .+ write it beside the package, as \w+\.h"
    ):
        model.write_header(model.folder / "values.h")
    assert not (model.folder / "values.h").exists()
    with pytest.raises(FileNotFoundError, match=r"there is no folder .+nodir; make it first"):
        model.write_header(tmp_path / "nodir" / "values.h")
    assert model.write_header(tmp_path / "values.h").read_text().startswith("/* falling-hexagon: values and start")


def test_the_documentation_says_what_it_prints(built: tuple[Path, str]) -> None:
    """Up to the sixth digit behind the point, and to the sign of what is zero to there."""

    def rounded(text: str) -> str:
        return re.sub(r"-(0\.000000)", r"\1", re.sub(r"(\d\.\d{6})\d+", r"\1", text))

    shown = re.findall(r"It prints\n\n```\n(.*?)```", (ROOT / "docs" / "c.md").read_text(), re.S)[0]
    for line in filter(lambda line: line != "...", shown.splitlines()):
        assert rounded(line) in rounded(built[1])


def test_the_library_shows_names_with_its_prefix_alone(built: tuple[Path, str]) -> None:
    nm = shutil.which("nm")
    if nm is None:
        pytest.skip("needs nm")
    listed = subprocess.run(
        [nm, "-D", "--defined-only", built[0] / "build" / "libccgen.so"], capture_output=True, text=True, check=True
    )
    names = {line.split()[-1] for line in listed.stdout.splitlines()}
    declared = set(re.findall(r"^CCGEN_PUBLIC .*?(ccgen_\w+)\(", (ROOT / "runtime" / "ccgen.h").read_text(), re.M))
    assert declared <= names and len(declared) > 10
    assert all(name.startswith("ccgen_") or name.startswith("_") for name in names)


def test_what_cannot_be_is_a_code(library: Library, workshop: Workshop) -> None:
    hexagon = workshop.model(load_scene(SCENE))
    four_bar = workshop.model(load_scene(ROOT / "scenes" / "four-bar.toml"))
    for settings, expected in (({"method": b"euler"}, "unknown_method"), ({"law": b"hooke"}, "unknown_law")):
        outcome, nothing = library.create(hexagon, **settings)
        assert outcome == expected and not nothing.address
    made = [library.create(hexagon), library.create(four_bar), library.create(hexagon, method=b"radau")]
    assert [outcome for outcome, _ in made] == ["done"] * 3
    one, other, radau = (simulation for _, simulation in made)
    assert one.step_to_event(1.0)[0] == one.forget() == "not_begun"
    assert one.reset(*hexagon.start()) == "done"
    before = one.state()
    for another in (other, radau):
        kept = another.state()
        assert another.set_state(before) == "other_state" and another.state() == kept
    assert one.step_to_event(0.6)[0] == "done" and one.state() != before
    assert one.set_state(before) == "done" and one.forget() == "done" and one.state() == before
    far = 1e200 * np.ones(len(hexagon.q_names))
    assert one.reset(far, hexagon.start()[1]) == "turned_far"
    alike = np.zeros(len(hexagon.q_names))  # all links one way: no step towards a closed loop shows from there
    assert one.reset(alike, hexagon.start()[1]) == "not_closed"
    assert one.step_to_event(1.0)[0] == "not_begun"
    assert one.reset(np.nan * far, hexagon.start()[1]) != "done"
    assert library.outcome(999) == library.outcome(-1) == "no outcome"


JAMS = """name = "jams"
[[link]]
name = "rod"
mass = 1.0
inertia = 0.08333333333333333
com = [0.5, 0]
points = { A = [0, 0] }
[gravity]
[[ground]]
restitution = 0.0
friction = 2.0
contacts = ["rod.A"]
"""


def test_an_impact_without_collision_is_an_event(library: Library, workshop: Workshop) -> None:
    """A rod that slides into jamming: the same time, impact and velocities as by Python."""
    model = workshop.model(JAMS)
    q, u = np.array([0.0, 0.0, 0.65]), np.array([-3.0, 0.0, 3.0])
    run = simulate(model, q, u, until=0.05)
    jams = library.create(model)[1]
    assert jams.reset(q, u) == "done"
    events = []
    while (event := jams.step_to_event(0.05)[1]).kind:
        events.append((event.kind, event.contact, event.impacts, event.t))
        if len(events) == 1:
            np.testing.assert_allclose(jams.motion()[2], run.impacts[0].u_plus, rtol=1e-9, atol=1e-9)
    assert len(run.impacts) == 1 and [event[:3] for event in events] == [(3, 0, 1)]
    assert events[0][3] == pytest.approx(run.impacts[0].t, rel=1e-12)


def test_a_simulation_is_used_again(library: Library, workshop: Workshop) -> None:
    """After whatever it did before, and beside another of the same model, it does the same to the last bit."""
    model = workshop.model(load_scene(SCENE))
    q, u = model.start()
    one, two = (library.create(model)[1] for _ in range(2))
    assert two.reset(q, u) == "done"
    ends = []
    for simulation in (one, two, one):
        assert simulation.reset(q, u) == "done"
        while simulation.step_to_event(1.1)[1].kind:
            two.step_to_event(0.5) if simulation is one else None
        ends.append(simulation.state())
    assert ends[0] == ends[1] == ends[2]


def test_what_is_recorded_is_what_was_reached(library: Library, workshop: Workshop) -> None:
    """Rows from the start to each event, two of one time for every impact; forgetting leaves the present one."""
    model = workshop.model(load_scene(SCENE))
    simulation = library.create(model)[1]
    q, u = model.start()
    assert simulation.reset(q, u) == "done"
    assert np.array_equal(simulation.constants(), model.kernels.constants)
    first, impacts = simulation.rows()[1][0], 0
    assert np.array_equal(first[: len(q)], q)
    for _ in range(4):
        impacts += simulation.step_to_event(2.0)[1].impacts
        t, rows = simulation.rows()
        reached = simulation.motion()
        assert t[-1] == reached[0] and np.array_equal(rows[-1, : 2 * len(q)], np.concatenate(reached[1:]))
        assert np.all(np.diff(t) >= 0.0) and np.count_nonzero(np.diff(t) == 0.0) >= impacts > 0
    assert simulation.forget() == "done"
    assert simulation.rows()[0].tolist() == [reached[0]]


def test_events_of_the_scene_are_told_as_in_python(library: Library, workshop: Workshop) -> None:
    """At the end, or at every impact, also where what was recorded is forgotten there; the motion is the same."""
    text = SCENE.read_text() + '[[event]]\nname = "low"\nwhen = "y(joint_3) - 1"\n'
    text += '[[event]]\nname = "still"\nwhen = "rate(y(joint_3))"\ndirection = "rising"\n'
    model = workshop.model(text)
    run = simulate(model, until=1.5)
    expected = [(one.t, ("low", "still").index(one.name), 1 if one.direction == "rising" else -1) for one in run.events]
    assert {indicator for _, indicator, _ in expected} == {0, 1}
    for forgets in (False, True):
        outcome, made = library.create(model, events=1)
        assert outcome == "done" and made.reset(*model.start()) == "done"
        while made.motion()[0] < 1.5:
            assert made.step_to_event(1.5)[0] == "done"
            assert made.crossings()[0] == "done"
            if forgets:
                assert made.forget() == "done"
        outcome, found, states = made.crossings()
        assert outcome == "done" and [one[1:] for one in found] == [one[1:] for one in expected]
        assert [t for t, *_ in found] == pytest.approx([t for t, *_ in expected], abs=1e-11)
        for y, one in zip(states, run.events, strict=True):
            assert y == pytest.approx(np.concatenate([one.q, one.u]), abs=1e-10)
        assert made.reset(*model.start()) == "done" and made.crossings()[1] == []
    outcome, made = library.create(model)
    assert outcome == "done" and made.reset(*model.start()) == "done"
    assert made.crossings()[0] == "bad_settings"


def test_motion_halts_at_events_of_the_scene(library: Library, workshop: Workshop) -> None:
    """In turn with those of contacts; at each the indicator is zero, and motion goes on from there to the same end."""
    text = SCENE.read_text() + '[[event]]\nname = "low"\nwhen = "y(joint_3) - 1"\n'
    text += '[[event]]\nname = "still"\nwhen = "rate(y(joint_3))"\ndirection = "rising"\n'
    model = workshop.model(text)
    tells, halts = (library.create(model, events=events)[1] for events in (1, 2))
    met: dict[Any, list[Any]] = {tells: [], halts: []}
    for one in (tells, halts):
        assert one.reset(*model.start()) == "done"
        while one.motion()[0] < 1.5:
            outcome, event = one.step_to_event(1.5)
            assert outcome == "done" and event.t == one.motion()[0]
            met[one].append((event.t, event.kind, event.contact, event.indicator))
    crosses = [(t, indicator) for t, kind, _, indicator in met[halts] if kind == 4]
    expected = [(t, indicator) for t, indicator, _ in tells.crossings()[1]]
    assert [one[1] for one in crosses] == [one[1] for one in expected]
    assert [one[0] for one in crosses] == pytest.approx([one[0] for one in expected], abs=1e-10)
    struck = [[(one[0], one[2]) for one in every if one[2] >= 0] for every in (met[halts], met[tells])]
    assert len(struck[0]) > 4 and [one[1] for one in struck[0]] == [one[1] for one in struck[1]]
    assert [one[0] for one in struck[0]] == pytest.approx([one[0] for one in struck[1]], abs=1e-9)
    assert halts.motion()[1] == pytest.approx(tells.motion()[1], abs=1e-8)
    t, rows = halts.rows()
    n = len(model.q_names)
    for when, indicator in crosses:
        row = rows[np.flatnonzero(t == when)[-1]]
        value, _, size = model.kernels.indicators(np.array([when]), row[None, :n].copy(), row[None, n : 2 * n].copy())
        assert abs(value[0, indicator]) <= 1e-9 * size[0, indicator] or when in [one[0] for one in struck[0]]


def test_events_at_one_impact_halt_once(library: Library, workshop: Workshop) -> None:
    """Both come at the impact, which motion halts behind, and neither comes again from there."""
    text = BALL + '[[event]]\nwhen = "y(ball.P)"\n[[event]]\nwhen = "rate(y(ball.P))"\ndirection = "rising"\n'
    model = workshop.model(text)
    outcome, made = library.create(model, events=2)
    assert outcome == "done" and made.reset(*model.start()) == "done"
    met = []
    while made.motion()[0] < 1.0:
        outcome, event = made.step_to_event(1.0)
        assert outcome == "done"
        met.append((event.t, event.kind, event.impacts))
    fall = float(np.sqrt(2.0 / 9.81))
    assert met == [(pytest.approx(fall), 4, 1), (pytest.approx(2 * fall), 4, 1), (1.0, 0, 0)]
    assert [one[1] for one in made.crossings()[1]] == [0, 1, 0, 1]


def test_an_interrupted_motion_halts_where_one_that_is_not_does(library: Library, workshop: Workshop) -> None:
    """Whenever it is interrupted it is not past an event, and goes on to the same; by steps that ask each time."""
    text = SCENE.read_text() + '[[event]]\nname = "low"\nwhen = "y(joint_3) - 1"\n'
    text += '[[event]]\nname = "turns"\nwhen = "rate(y(joint_3))"\n'
    model = workshop.model(text)
    ask = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_double)

    def halts(at: int) -> tuple[list[tuple[float, int]], int]:
        asked = 0

        def tick(_: object, __: float) -> int:
            nonlocal asked
            asked += 1
            return asked == at

        call = ask(tick)
        settings = {"events": 2, "method": b"moreau", "fixed_step": 0.005, "tick": ctypes.cast(call, ctypes.c_void_p)}
        outcome, made = library.create(model, **settings)
        assert outcome == "done" and made.reset(*model.start()) == "done"
        found: list[tuple[float, int]] = []
        while made.motion()[0] < 1.2:
            outcome, event = made.step_to_event(1.2)
            if outcome == "interrupted":
                assert [one for one in made.crossings()[1] if one[0] <= made.motion()[0]][len(found) :] == []
            elif event.kind == 4:
                found.append((event.t, event.indicator))
        return found, asked

    expected, asked = halts(0)
    assert len(expected) > 1 and asked > 200
    for at in np.linspace(1, asked, 60).astype(int):
        assert [one[1] for one in halts(int(at))[0]] == [one[1] for one in expected]


@pytest.mark.parametrize("settings", [{}, {"method": b"moreau", "fixed_step": 0.005}], ids=["gauss", "moreau"])
@pytest.mark.parametrize("events", [2, 3])
def test_a_motion_that_is_interrupted_all_the_time_gets_on(
    settings: dict[str, Any], events: int, library: Library, workshop: Workshop
) -> None:
    """By every second or third tick, also on the way back to events; time stepping asks at each step."""
    text = SCENE.read_text() + '[[event]]\nname = "low"\nwhen = "y(joint_3) - 1"\n'
    text += '[[event]]\nname = "turns"\nwhen = "rate(y(joint_3))"\nset = { "link_0.mass" = 1 }\n'
    model = workshop.model(text)
    ask = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_double)

    def halts(every: int) -> list[tuple[float, int]]:
        asked, calls = 0, 0

        def tick(_: object, __: float) -> int:
            nonlocal asked
            asked += 1
            return asked % every == 0

        call = ask(tick)
        outcome, made = library.create(model, events=events, tick=ctypes.cast(call, ctypes.c_void_p), **settings)
        assert outcome == "done" and made.reset(*model.start()) == "done"
        found: list[tuple[float, int]] = []
        while made.motion()[0] < 1.2 and (calls := calls + 1) < 1000:
            outcome, event = made.step_to_event(1.2)
            if outcome == "done" and event.kind == 4:
                found.append((event.t, event.indicator))
        assert made.motion()[0] == 1.2
        return found

    expected = halts(10**9)
    assert len(expected) > 1
    for every in (2, 3):
        assert halts(every) == [(pytest.approx(t, abs=1e-9), number) for t, number in expected]


def test_events_do_what_the_scene_says(library: Library, workshop: Workshop) -> None:
    """A spring of 8 N/m on 2 kg that is cut at 0.5 s and comes again at 1.5 s with four times its stiffness; the same
    from a state, by the same bits, and anew from the start."""
    text = OSCILLATOR + '[[event]]\nname = "cut"\nwhen = "t - 0.5"\noff = ["coil"]\n'
    text += '[[event]]\nwhen = "t - 1.5"\non = ["coil"]\nset = { "coil.stiffness" = "32 + 0*slide(rail)" }\n'
    text += '[[event]]\nwhen = "rate(slide(rail))"\nstop = true\ntimes = 2\n[[event]]\nwhen = "t - 1"\n'
    model = workshop.model(text)
    x, v = 1.0 + 0.5 * np.cos(1.0), -np.sin(1.0)
    y, phase = x + v - 1.0, np.arctan2(v / 4.0, x + v - 1.0)
    first, second = (1.5 + (phase + turns * np.pi) / 4.0 for turns in (1, 2))
    made, other = (library.create(model, events=3, rtol=1e-12)[1] for _ in range(2))
    assert made.reset(*model.start()) == "done"
    for again in range(2):
        met, states = [], []
        while not met or met[-1][1] != 5:
            outcome, event = made.step_to_event(4.0)
            assert outcome == "done"
            met.append((event.t, event.kind, event.indicator))
            states.append(made.state())
            if len(met) == 1:
                assert made.parameters()["coil.on"] == 0.0 and made.motion()[2] == pytest.approx([v], abs=1e-11)
        assert met == [(0.5, 4, 0), (1.5, 4, 1), (pytest.approx(second, abs=1e-11), 5, 2)] and first > 1.5
        assert made.motion()[1] == pytest.approx([1.0 + np.hypot(y, v / 4.0)], abs=1e-11)
        assert made.parameters() | {"coil.stiffness": 32.0, "coil.on": 1.0} == made.parameters()
        if not again:
            end = made.state()
            assert other.reset(*model.start()) == "done" and other.set_state(states[0]) == "done"
            assert other.parameters()["coil.on"] == 0.0 and other.step_to_event(4.0)[1].kind == 4
            other.step_to_event(4.0)
            assert np.array_equal(np.concatenate(other.motion()[1:]), np.concatenate(made.motion()[1:]))
            assert made.reset(*model.start()) == "done" and made.parameters()["coil.stiffness"] == 8.0
    assert made.state() == end
    told = library.create(model, events=1)[1]
    assert told.reset(*model.start()) == "done" and told.set_state(end) == "other_state"


@pytest.mark.parametrize(
    ("event", "outcome"),
    [
        ('set = { "coil.stiffness" = "slide(rail) - 2" }', "cannot_set"),
        ('set = { "cart.mass" = "0*t" }', "cannot_set"),
        ('set = { "cart.mass" = "exp(1000 + t)" }', "cannot_set"),
        ('on = ["floor"]', "inside"),
    ],
)
def test_what_events_cannot_do_ends_the_motion(event: str, outcome: str, library: Library, workshop: Workshop) -> None:
    text = OSCILLATOR.replace("[run]", 'off = ["floor"]\n[run]')
    text += '[[ground]]\nname = "floor"\npoint = [0, 1]\ncontacts = ["cart.A"]\nrestitution = 0\n'
    text += '[[event]]\nwhen = "t - 9"\non = ["floor"]\n'
    model = workshop.model(text + f'[[event]]\nwhen = "t - 0.5"\n{event}\n')
    made = library.create(model, events=3)[1]
    assert made.reset(*model.start()) == "done" and made.step_to_event(1.0)[0] == outcome
    assert made.motion()[0] == 0.5 and made.parameters() == dict(model.settable)  # nothing has been set
    found = ensemble(model, {"coil.length": [1.0, 1.1]})
    assert list(found.status) == ["stopped"] * 2
    assert found.reason == tuple(simulate(model, params={"coil.length": length}).message for length in (1.0, 1.1))


def test_an_event_that_opens_loops_ends_the_motion(library: Library, workshop: Workshop) -> None:
    text = (ROOT / "scenes" / "four-bar.toml").read_text()
    model = workshop.model(text + '[[event]]\nwhen = "t - 0.1"\nset = { "coupler.points.B.x" = "3 + 0*t" }\n')
    made = library.create(model, events=3)[1]
    assert made.reset(*model.start()) == "done" and made.step_to_event(1.0)[0] == "opened"
    q, u = model.start()
    found = ensemble(model, q0=[q] * 4, u0=[u] * 4, until=0.5, threads=1)
    assert list(found.status) == ["stopped"] * 4 and "opens the loops by" in found.reason[3]


@pytest.mark.parametrize(("by", "outcome"), [(5e-7, "done"), (2e-6, "opened")])
def test_loops_may_open_by_a_millionth(by: float, outcome: str, library: Library, workshop: Workshop) -> None:
    """Of the longest link, of 0.35 m; what is nearer is closed again."""
    text = (ROOT / "scenes" / "four-bar.toml").read_text()
    plain = workshop.model(text)
    length = plain.parameters["coupler.points.B.x"] + by * plain.length
    model = workshop.model(text + f'[[event]]\nwhen = "t - 0.1"\nset = {{ "coupler.points.B.x" = {length!r} }}\n')
    made = library.create(model, events=3)[1]
    assert made.reset(*model.start()) == "done" and made.step_to_event(1.0)[0] == outcome
    assert simulate(model, until=0.2).success == (outcome == "done")


def test_events_that_set_again_and_again_end_the_motion(library: Library, workshop: Workshop) -> None:
    text = OSCILLATOR + '[[event]]\nwhen = "sin(1e4*t)"\nset = { "coil.stiffness" = "8 + 0*t" }\n'
    made = library.create(model := workshop.model(text), events=3, method=b"dopri5", fixed_step=1e-4)[1]
    assert made.reset(*model.start()) == "done"
    outcome, count = "done", 0
    while outcome == "done" and made.motion()[0] < 4.0:
        outcome, count = made.step_to_event(4.0)[0], count + 1
    assert outcome == "set_without_end" and count == 10_001


def test_without_a_method_it_is_that_of_python(library: Library, workshop: Workshop) -> None:
    model = workshop.model(load_scene(SCENE))
    run = simulate(model, until=1.5, rtol=1e-9)
    simulation = library.create(model)[1]
    assert simulation.reset(*model.start()) == "done"
    while simulation.step_to_event(1.5)[1].kind:
        pass
    assert run.impacts and np.array_equal(simulation.rows()[0], run.t)


def test_accelerations_are_those_of_python(library: Library, workshop: Workshop) -> None:
    """Of a loop that is not shut, driven by what is given; and a simulation that has begun stays where it is."""
    text = (ROOT / "scenes" / "four-bar.toml").read_text() + '\n[[input]]\nname = "push"\njoint = "motor"\n'
    model = workshop.model(text, derivatives=True)
    simulation = library.create(model)[1]
    q, u = model.start()
    assert simulation.reset(q, u) == "done"
    simulation.step_to_event(0.1)
    before, rows = simulation.state(), simulation.rows()
    q, u, push = q + 0.05, u + np.arange(len(u)), np.array([1.5])
    outcome, u_dot = simulation.acceleration(q, u, push)
    assert outcome == "done" and np.array_equal(u_dot, model.acceleration(q, u, inputs=push))
    outcome, u_dot, by = simulation.derived(q, u, push)
    assert outcome == "done" and np.array_equal(u_dot, model.acceleration(q, u, inputs=push))
    assert np.array_equal(by, model.derivatives("acceleration", q, u, inputs=push, wrt=("q", "u", "push")))
    none = simulation.derived(q, u)  # the inputs of the settings, which are none
    assert none[0] == "done" and np.array_equal(none[1], model.acceleration(q, u)) and not np.array_equal(none[2], by)
    assert simulation.state() == before and np.array_equal(simulation.rows()[1], rows[1])


def test_contacts_do_not_push_on_accelerations_in_flight(library: Library, workshop: Workshop) -> None:
    """A hexagon that lies on its corner falls on."""
    model = workshop.model(load_scene(SCENE))
    q, u = model.start()
    q[1] -= model.gaps(q).min()
    simulation = library.create(model)[1]
    outcome, u_dot = simulation.acceleration(q, u)
    assert outcome == "done" and np.array_equal(u_dot, model.acceleration(q, u, contacts=()))
    assert np.abs(u_dot[1] + model.parameters["gravity.g"]) <= 1e-12


def test_accelerations_that_cannot_be_are_codes(library: Library, workshop: Workshop) -> None:
    hexagon = workshop.model(load_scene(SCENE))
    simulation = library.create(hexagon)[1]
    q, u = hexagon.start()
    assert simulation.derived(q, u)[0] == "no_derivatives"
    assert simulation.acceleration(np.full_like(q, np.inf), u)[0] == "not_finite"
    assert simulation.acceleration(np.full_like(q, 1e200), u)[0] == "turned_far"
    cranks = parallel_cranks(1.1, 3)
    redundant = workshop.model(cranks.toml(), derivatives=True)
    q, _ = redundant.state_from_poses(cranks.poses, np.zeros_like(cranks.poses))
    turning = library.create(redundant)[1]
    outcome, u_dot, _ = turning.derived(q, np.ones(len(q)))
    assert outcome == "dependent" and np.all(np.isfinite(u_dot))


def test_a_model_of_another_contract_is_refused(library: Library, workshop: Workshop) -> None:
    model = workshop.model(load_scene(SCENE))
    other = Descriptor.from_buffer_copy(Descriptor.from_address(model.kernels.address))
    other.version += 1
    made = ctypes.c_void_p()
    code = library.calls.ccgen_create(ctypes.byref(other), ctypes.byref(Settings()), ctypes.byref(made))
    assert library.outcome(code) == "other_contract" and not made.value
