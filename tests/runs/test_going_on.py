"""Runs that go on from where another ended, or was interrupted: each bit is that of the run that was not."""

from __future__ import annotations

import pickle
import re
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene, loop
from ccgen.runtime import HybridState, simulate

from ..hard.fuzz import Toss, scene
from ..support.folders import ROOT
from ..support.tiers import hard
from ..support.workshop import Workshop

SCENES = ROOT / "scenes"
METHODS = ("gauss", "dop853", "dopri5", "radau")


def run_with_stop(model: Any, until: float, stop: float, method: str) -> dict[str, Any]:
    """What the core records of a run that also has to end a step at ``stop``."""
    q, u = model.start()
    found: dict[str, Any] = model.kernels.simulate(
        q, u, method, until, 1e-9, 1e-9, 0.0, 10**7, 200_000, None, None, (stop,), "projected"
    )
    return found


def rows_of(run: Any) -> list[Any]:
    return [run.t, run.q, run.u]


def impacts_of(run: Any) -> list[Any]:
    return [(i.t, i.contacts, i.u_plus.tobytes(), i.impulses.tobytes(), i.energy_loss) for i in run.impacts]


def held_of(run: Any) -> list[Any]:
    return [(phase.kind, phase.end, phase.contacts, phase.how) for phase in run.phases]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", ["falling-hexagon", "four-bar"])
def test_going_on_is_the_run_with_a_stop_there(name: str, method: str, workshop: Workshop, tmp_path: Path) -> None:
    model = workshop.model(load_scene(SCENES / f"{name}.toml"))
    until = 1.0
    for stop in (1e-6, 0.31, 0.77):
        whole = run_with_stop(model, until, stop, method)
        first = simulate(model, until=stop, rtol=1e-9, method=method)
        kept = HybridState.load(first.state.save(tmp_path / "state.npz"))
        assert kept.t == stop and kept.memory == first.state.memory
        second = simulate(model, until=until, state=kept)
        rows = len(second.t)
        assert second.t[0] == stop and second.method == method
        for name_, found in zip("tqu", rows_of(second), strict=True):
            assert np.array_equal(found, whole[name_][-rows:]), (name_, stop)
        assert second.state.memory == whole["state"]
        assert second.energy_drift <= 1e-6


def test_a_rough_run_goes_on_with_what_is_held(workshop: Workshop) -> None:
    """Stopped while contacts stick and slide, as after an impact; the new run begins with them held."""
    toss = Toss(n=4, planes=2, rough=True, law="poisson", restitution=0.3, friction=0.3, seed=5)
    model = workshop.model(scene(toss.n, toss.rough))
    whole = simulate(model, until=3.0)
    assert any(phase.kind == "contact" for phase in whole.phases) and len(whole.impacts) > 10
    for part in (0.2, 0.5, 0.8):
        stop = float(whole.t[int(part * len(whole.t))])
        first = simulate(model, until=stop)
        second, again = (simulate(model, until=3.0, state=first.state) for _ in range(2))
        exact = run_with_stop(model, 3.0, stop, whole.method)
        rows = len(second.t)
        assert second.success == (exact["outcome"] == "done")
        for name, found in zip("tqu", rows_of(second), strict=True):
            assert np.array_equal(found, exact[name][-rows:]), (name, stop)
        assert impacts_of(second) == impacts_of(again)
        if first.phases[-1].kind == "contact":
            assert second.phases[0].contacts == first.phases[-1].contacts
            assert second.phases[0].how == first.phases[-1].how
            t = 0.5 * (second.t[0] + second.t[1])
            assert np.isfinite(second.contact_forces(t)).all()


class _Pushes:
    """A controller that is interrupted when it is asked for the ``count``-th time."""

    def __init__(self, count: int = 0) -> None:
        self.left = count

    def __call__(self, t: float, q: Any, u: Any) -> list[float]:
        self.left -= 1
        if self.left == 0:
            raise KeyboardInterrupt
        return [2.0 * np.sin(8.0 * t) - 0.1 * float(u[3])]


@pytest.mark.sample(1)
@pytest.mark.parametrize("method", [hard(one) if one == "radau" else one for one in METHODS])
@pytest.mark.parametrize("where", ["onto the ground", hard("in the air")])
def test_an_interrupted_run_goes_on_as_if_it_had_not_been(where: str, method: str, workshop: Workshop) -> None:
    """Wherever accelerations are asked for, within steps, searches for events and choices of what is held: the pieces
    joined are the whole run."""
    push = [{"name": "push", "joint": "joint_1"}]
    ground = {"restitution": 0.3, "friction": 0.4}
    if where == "in the air":
        made = loop(5, gravity=True, input=push)
    else:
        made = loop(
            3, gravity=True, start={"height": 0.02, "angular_velocities": [0.7, 0.7, 0.7]}, ground=[ground], input=push
        )
    model = workshop.model(made)
    options: dict[str, Any] = {"until": 0.7, "method": method, "rtol": 1e-8, "keep_interrupted": True}
    whole, counted = simulate(model, inputs=_Pushes(), **options), _Pushes()
    assert whole.success, whole.message
    assert where == "in the air" or (len(whole.impacts) > 3 and whole.phases[-1].kind == "contact")
    simulate(model, inputs=counted, **options)
    inside = 0
    every = -counted.left - 1
    for count in sorted({*range(1, 9), *np.linspace(1, every, 60).astype(int)}):
        first = simulate(model, inputs=_Pushes(count), **options)
        assert not first.success and "interrupted" in first.message
        state = pickle.loads(pickle.dumps(first.state))
        second = simulate(model, inputs=_Pushes(), state=state, **{**options, "method": None})
        joined = [np.concatenate([a[:-1], b]) for a, b in zip(rows_of(first), rows_of(second), strict=True)]
        for part, all_ in zip(joined, rows_of(whole), strict=True):
            assert np.array_equal(part, all_), count
        assert impacts_of(first) + impacts_of(second) == impacts_of(whole)
        assert second.state.memory == whole.state.memory
        inside += len(first.t) > 1
    assert inside > 40


def test_tolerances_and_budgets_of_what_goes_on(workshop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each tolerance that is given counts; a run that its budget has ended goes on with a new one."""
    model = workshop.model(load_scene(SCENES / "falling-hexagon.toml"))
    first = simulate(model, until=0.2, rtol=1e-8)
    loose = simulate(model, until=1.0, state=first.state, atol=1e-3)
    assert loose.state.settings["rtol"] == 1e-8 and loose.state.settings["atol"] == 1e-3
    follows = simulate(model, until=1.0, state=first.state, rtol=1e-6)
    assert follows.state.settings["rtol"] == follows.state.settings["atol"] == 1e-6
    with monkeypatch.context() as few:
        few.setattr(import_module("ccgen.runtime.simulation.one_run"), "STEP_BUDGET", 12)
        stopped = simulate(model, until=1.0)
    assert not stopped.success and "are spent" in stopped.message
    assert simulate(model, until=1.0, state=stopped.state).success


VIBRATING = """
name = "vibrating"
[chain]
links = 1
hinged = true
[[torsion]]
joint = "joint_0"
stiffness = 1e6
[start]
angles = [1e-5]
[run]
until = 1.0
"""
"""A rod that swings 276 times in the second; what it turns in a step goes as its amplitude."""


def test_a_flight_that_spends_its_rate_stops_and_goes_on(workshop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without contacts there is nothing to step over. Steps of hundred-thousandths of a radian get nowhere."""
    model = workshop.model(VIBRATING)
    with monkeypatch.context() as few:
        few.setattr(import_module("ccgen.runtime.simulation.one_run"), "RATE_BUDGET", 50)
        stopped = simulate(model)
    assert not stopped.success and "are spent" in stopped.message
    assert simulate(model, state=stopped.state).success


@pytest.mark.parametrize("method", METHODS)
def test_steps_that_turn_links_spend_no_rate(method: str, workshop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten steps and more in each characteristic time, all of which get the motion on: the run is the one that has the
    usual budget."""
    model = workshop.model(load_scene(SCENES / "four-bar.toml"))
    usual = simulate(model, until=1.0, method=method)
    with monkeypatch.context() as few:
        few.setattr(import_module("ccgen.runtime.simulation.one_run"), "RATE_BUDGET", 3)
        run = simulate(model, until=1.0, method=method)
    assert run.success, run.message
    assert len(run.t) > 30
    for found, wanted in zip(rows_of(run), rows_of(usual), strict=True):
        assert np.array_equal(found, wanted)


GAINING = """
name = "kane"
[chain]
links = 2
hinged = true
[start]
angles = ["-70 deg", "-60 deg"]
angular_velocities = [1.0, 0.5]
[gravity]
[[ground]]
point = [0, -1.8057182352]
restitution = 0.7
friction = 0.5
contacts = ["link_1.B"]
[run]
until = 0.6
"""
"""A double pendulum whose tip strikes rough ground: by Newton's law its first impact would add energy."""


def test_what_becomes_of_a_gain_may_change_on_the_way(workshop: Workshop) -> None:
    """Gone on with as before, unless told otherwise."""
    model = workshop.model(GAINING)
    for before, other in (("reduce", "stop"), ("stop", "reduce")):
        state = simulate(model, until=0.3, on_gain=before).state
        for given, holds in ((None, before), (before, before), (other, other)):
            run = simulate(model, state=state, on_gain=given)
            assert run.success == (holds == "reduce"), (before, given)
            assert ("would add energy" in run.message) == (holds == "stop")
            assert run.state.settings["on_gain"] == holds


def test_damaged_states_are_refused(workshop: Workshop, tmp_path: Path) -> None:
    """Whatever byte of the file is changed: a sentence, or the state as it was."""
    model = workshop.model(load_scene(SCENES / "falling-hexagon.toml"))
    state = simulate(model, until=0.9).state
    whole = state.save(tmp_path / "state.npz").read_bytes()
    rng = np.random.default_rng(1)
    for place in rng.integers(0, len(whole), 200):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << int(rng.integers(8))
        (tmp_path / "damaged.npz").write_bytes(damaged)
        try:
            found = HybridState.load(tmp_path / "damaged.npz")
        except ValueError as error:
            assert "found no state of a run" in str(error)
        else:
            assert found.memory == state.memory
    for place in range(100, len(state.memory), 4):  # numbers of the core's own record, by which it reads arrays
        memory = bytearray(state.memory)
        memory[place : place + 4] = b"\xff\xff\xff\x7e"
        try:
            simulate(model, until=0.9001, state=HybridState(**{**vars(state), "memory": bytes(memory)}))
        except ValueError as error:
            assert "another model, method or precision" in str(error)


@pytest.mark.parametrize("bits", [0x80, 0xC0])
def test_damage_in_several_places_does_not_cancel(bits: int, workshop: Workshop) -> None:
    """The top bits of two numbers, as two signs: what is multiplied carries upwards alone."""
    model = workshop.model(load_scene(SCENES / "falling-hexagon.toml"))
    state = simulate(model, until=0.9).state
    rng = np.random.default_rng(2)
    for _ in range(300):
        memory = bytearray(state.memory)
        for word in rng.choice(np.arange(16, len(memory) // 8), 2, replace=False):
            memory[8 * word + 7] ^= bits
        with pytest.raises(ValueError, match="another model, method or precision"):
            simulate(model, until=0.9001, state=HybridState(**{**vars(state), "memory": bytes(memory)}))


@pytest.mark.parametrize("method", [*METHODS, "moreau"])
@pytest.mark.parametrize("name", ["falling-hexagon", "four-bar"])
def test_going_on_to_where_it_is(name: str, method: str, workshop: Workshop) -> None:
    """One row, that of the state, and the same state after it: at the start, in flight, and where contacts are held."""
    model = workshop.model(load_scene(SCENES / f"{name}.toml"))
    step = 0.01 if method == "moreau" else None
    for t in (0.0, 0.1, 1.0):
        state = simulate(model, until=t, method=method, step=step).state
        run = simulate(model, until=t, state=state)
        assert run.success and run.t.tolist() == [t] and not len(run.impacts)
        assert np.array_equal(run.q, [state.q]) and np.array_equal(run.u, [state.u])
        assert run.state.t == t and run.state.memory == state.memory
        once, again = (simulate(model, until=t + 0.1, state=one) for one in (state, run.state))
        assert all(map(np.array_equal, rows_of(once), rows_of(again)))


def test_what_is_no_state_of_the_model_is_refused(workshop: Workshop, tmp_path: Path) -> None:
    model, other = (workshop.model(load_scene(SCENES / f"{name}.toml")) for name in ("four-bar", "falling-hexagon"))
    state = simulate(model, until=0.1).state
    with pytest.raises(ValueError, match="state: found one of four-bar, expected one of falling-hexagon"):
        simulate(other, until=1.0, state=state)
    with pytest.raises(ValueError, match=r"until: found 0\.05, expected the state's t = 0\.1 or more"):
        simulate(model, until=0.05, state=state)
    with pytest.raises(ValueError, match="method: found 'radau', expected 'gauss'"):
        simulate(model, until=1.0, state=state, method="radau")
    with pytest.raises(ValueError, match="q0, u0: found beside a state"):
        simulate(model, *model.start(), until=1.0, state=state)
    with pytest.raises(ValueError, match=r"state: found one with another crank.mass, expected"):
        simulate(model, until=1.0, state=state, params={"crank.mass": 2.0})
    with pytest.raises(TypeError, match="state: found bytes, expected a HybridState"):
        simulate(model, until=1.0, state=b"")  # type: ignore[arg-type]
    (tmp_path / "none.npz").write_bytes(b"nothing")
    with pytest.raises(ValueError, match="found no state of a run"):
        HybridState.load(tmp_path / "none.npz")
    damaged = HybridState(**{**vars(state), "memory": b"\0" * len(state.memory)})
    with pytest.raises(ValueError, match="another model, method or precision"):
        simulate(model, until=1.0, state=damaged)
    shorter = HybridState(**{**vars(state), "memory": state.memory[:-8]})
    with pytest.raises(ValueError, match="another model, method or precision"):
        simulate(model, until=1.0, state=shorter)


def test_all_that_a_phase_remembers_is_part_of_the_state() -> None:
    """Where the list of the state leaves one out, runs that go on may differ from those that were not ended."""
    core = ROOT / "runtime" / "core"
    declared = re.search(r"struct progress \{\n(.*?)\n\};", (core / "steps" / "step.h").read_text(), re.S)
    assert declared
    plain = re.sub(r"/\*.*?\*/", "", declared[1], flags=re.S)
    members = {name for line in plain.split(";") for name in re.findall(r"(\w+)(?:\[\d+\])?\s*(?:,|$)", line.strip())}
    assert {"since", "energy", "energy_end", "follows"} <= members
    listed = set(re.findall(r"\bat->(\w+)", (core / "hybrid" / "state.c").read_text()))
    assert members == listed


@pytest.mark.parametrize("name", ["t", "q", "u"])
def test_a_state_that_was_edited_is_refused(name: str, workshop: Workshop, tmp_path: Path) -> None:
    """It goes on from its memory: another t, q or u beside that would be taken without a word, and not be heeded."""
    model = workshop.model(VIBRATING)
    file = simulate(model, until=0.1).state.save(tmp_path / "state.npz")
    with np.load(file) as found:
        arrays = dict(found)
    arrays[name] = arrays[name] + 1e-3
    np.savez(file, **arrays)
    state = HybridState.load(file)
    with pytest.raises(ValueError, match=rf"^state\.{name}: found .*, expected .*, where the run was left"):
        simulate(model, state=state)
