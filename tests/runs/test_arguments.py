"""Wrong numbers and shapes are refused by the name of the argument; an interrupted run stops or is kept."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from ..support.workshop import Workshop

BAD_NUMBERS = [np.nan, np.inf, -np.inf]
STATE_METHODS = ["acceleration", "multipliers", "reactions", "energy", "velocities", "gap_rates", "project"]
Q_METHODS = ["poses", "closure", "jacobian", "gaps", "assemble"]


@pytest.fixture(scope="module")
def model(workshop: Workshop) -> Any:
    from ccgen.generator import loop

    return workshop.model(loop(4, gravity=True, start={"height": 1.0}, ground=[{"restitution": 0.5}]))


def spoiled(x: np.ndarray, number: float) -> np.ndarray:
    x = x.copy()
    x[1] = number
    return x


def misshapen(x: np.ndarray) -> list[Any]:
    return [x[:-1], np.append(x, 0.0), x[0], [], x[:, None], np.ones((2, x.size + 1)), np.ones((1, 1, x.size))]


def refuses(argument: str, call: Any, *args: Any, **kwargs: Any) -> None:
    """A ``ValueError`` whose one sentence names the argument."""
    with pytest.raises(ValueError, match=rf"\b{argument}\b") as caught:
        call(*args, **kwargs)
    assert "\n" not in str(caught.value)
    assert "expected" in str(caught.value) or "must" in str(caught.value)


@pytest.mark.quick
@pytest.mark.parametrize("number", BAD_NUMBERS)
@pytest.mark.parametrize("method", STATE_METHODS)
def test_states_that_are_not_finite(model: Any, method: str, number: float) -> None:
    q, u = model.start()
    call = getattr(model, method)
    refuses("q", call, spoiled(q, number), u)
    refuses("u", call, q, spoiled(u, number))
    refuses("u", call, np.array([q, q]), np.array([u, spoiled(u, number)]))


@pytest.mark.quick
@pytest.mark.parametrize("method", STATE_METHODS)
def test_states_of_wrong_shape(model: Any, method: str) -> None:
    q, u = model.start()
    call = getattr(model, method)
    for wrong in misshapen(q):
        refuses("q", call, wrong, u)
    for wrong in misshapen(u):
        refuses("u", call, q, wrong)
    refuses("u", call, np.array([q, q]), np.array([u, u, u]))
    refuses("u", call, q, np.array([u]))
    refuses("u", call, np.array([q, q]), u)


@pytest.mark.quick
@pytest.mark.parametrize("method", Q_METHODS)
def test_configurations_that_are_wrong(model: Any, method: str) -> None:
    q, _ = model.start()
    for number in BAD_NUMBERS:
        refuses("q", getattr(model, method), spoiled(q, number))
    for wrong in misshapen(q):
        refuses("q", getattr(model, method), wrong)
    refuses("q", model.point, "joint_0", spoiled(q, np.nan))
    refuses("q", model.point, "joint_0", q[:-1])


@pytest.mark.parametrize("method", ["acceleration", "multipliers", "reactions"])
@pytest.mark.parametrize("time", [*BAD_NUMBERS, [0.0, 1.0], np.zeros(3)], ids=str)
def test_times_that_are_wrong(model: Any, method: str, time: Any) -> None:
    refuses("t", getattr(model, method), *model.start(), t=time)


@pytest.mark.quick
@pytest.mark.parametrize("argument", ["poses", "velocities"])
def test_poses_that_are_wrong(model: Any, argument: str) -> None:
    poses = model.poses(model.start()[0])
    for wrong in (
        poses[:-1],
        poses[:, :2],
        poses.ravel(),
        *(np.where(poses == poses[1, 2], x, poses) for x in BAD_NUMBERS),
    ):
        given = {"poses": poses, "velocities": 0 * poses} | {argument: wrong}
        refuses(argument, model.state_from_poses, **given)


WRONG_RESTITUTIONS = [*BAD_NUMBERS, -0.1, 1.1, [0.5, np.nan], [0.5, -0.1], [0.5], [0.5, 0.5, 0.5], [[0.5, 0.5]], []]


@pytest.mark.parametrize("restitution", WRONG_RESTITUTIONS, ids=str)
def test_restitutions_that_are_wrong(model: Any, restitution: Any) -> None:
    contacts = [("joint_0", "ground_0"), ("joint_1", "ground_0")]
    q, u = model.start()
    refuses("restitution", model.impact, q, u, contacts, restitution)
    model.impact(q, u, contacts, [0.5, 0.25])


@pytest.mark.parametrize("number", BAD_NUMBERS)
def test_impacts_from_wrong_states(model: Any, number: float) -> None:
    q, u = model.start()
    contacts = [("joint_0", "ground_0")]
    refuses("q", model.impact, spoiled(q, number), u, contacts)
    refuses("u", model.impact, q, spoiled(u, number), contacts)
    refuses("u", model.impact, q, u[:-1], contacts)


@pytest.mark.parametrize("argument", ["q0", "u0"])
def test_runs_from_wrong_states(model: Any, argument: str) -> None:
    """The sentence may say q for q0 and u for u0."""
    from ccgen.runtime import simulate

    x = dict(zip(("q0", "u0"), model.start(), strict=True))[argument]
    alone = [np.array([x])] if argument == "u0" else []  # several q0 are a batch
    for wrong in (*(spoiled(x, number) for number in BAD_NUMBERS), *misshapen(x), *alone):
        refuses(f"{argument[0]}0?", simulate, model, until=0.1, **{argument: wrong})


@pytest.mark.quick
@pytest.mark.parametrize("argument", ["until", "rtol", "atol", "step"])
@pytest.mark.parametrize("wrong", [*BAD_NUMBERS, 0.0, -1.0, [1.0, 2.0], "1", True], ids=repr)
def test_runs_with_wrong_numbers(model: Any, argument: str, wrong: Any) -> None:
    from ccgen.runtime import simulate

    if argument == "until" and type(wrong) is float and wrong == 0.0:
        assert len(simulate(model, until=wrong).t) == 1  # the row of the start
        return
    refuses(argument, simulate, model, **{argument: wrong})


@pytest.mark.quick
def test_a_wrong_call_leaves_the_model_usable(model: Any) -> None:
    q, u = model.start()
    before = model.acceleration(q, u)
    refuses("q", model.acceleration, spoiled(q, np.nan), u)
    assert np.array_equal(model.acceleration(q, u), before)


# -- interruption --------------------------------------------------------------------------------------------------


def interrupting(after: int) -> Any:
    """A progress callback that is interrupted at its call number ``after``."""
    times: list[float] = []

    def progress(time: float) -> None:
        times.append(time)
        if len(times) == after:
            raise KeyboardInterrupt

    return progress


@pytest.fixture(scope="module")
def spinning(workshop: Workshop) -> tuple[Any, np.ndarray, np.ndarray]:
    """A ring that never stops."""
    from ccgen.generator import loop

    model = workshop.model(loop(4))
    q, u = model.start()
    return model, *model.project(q, np.arange(1.0, 1 + u.size))


LONG = {"until": 1e6, "rtol": 1e-9}


def test_an_interrupt_in_progress_propagates(spinning: tuple[Any, np.ndarray, np.ndarray]) -> None:
    from ccgen.runtime import simulate

    with pytest.raises(KeyboardInterrupt):
        simulate(*spinning, **LONG, progress=interrupting(3))


def test_an_interrupted_run_can_be_kept(spinning: tuple[Any, np.ndarray, np.ndarray]) -> None:
    from ccgen.runtime import simulate

    run = simulate(*spinning, **LONG, progress=interrupting(3), keep_interrupted=True)
    assert not run.success
    assert "interrupted" in run.message
    assert 0 < run.t[-1] < 1e6
    assert len(run.t) == len(run.q) == len(run.u) > 2
    assert run.closure_max <= 1e-11
    assert run.energy_drift <= 1e-6


def test_another_error_in_progress_propagates(spinning: tuple[Any, np.ndarray, np.ndarray]) -> None:
    from ccgen.runtime import simulate

    def progress(time: float) -> None:
        raise RuntimeError("the window is gone")

    for keep in (False, True):
        with pytest.raises(RuntimeError, match="the window is gone"):
            simulate(*spinning, **LONG, progress=progress, keep_interrupted=keep)


# -- steps that do not get anywhere --------------------------------------------------------------------------------


@pytest.mark.parametrize(("step", "until"), [(5e-324, 1.0), (1e-17, 1.0), (1e-300, 1e-290), (1e-3, 2e4), (0.5, 1e7)])
def test_a_step_that_cannot_reach_the_end_is_refused_at_once(workshop: Workshop, step: float, until: float) -> None:
    """Too short to move time, or more of them than a run may have; both numbers are named, and nothing is evaluated."""
    from ccgen.runtime import simulate

    text = "name = 'driven'\n[chain]\nlinks = 1\nhinged = true\n[[input]]\nname = 'torque'\njoint = 'joint_0'\n"
    model = workshop.model(text)
    evaluated: list[float] = []

    def inputs(t: float, q: np.ndarray, u: np.ndarray) -> float:
        evaluated.append(t)
        return 0.0

    said = re.escape(f"step: found {step:g} s for a run to t = {until:g} s, expected at least")
    with pytest.raises(ValueError, match=said):
        simulate(model, until=until, step=step, inputs=inputs)
    assert not evaluated
    simulate(model, until=1e-3, step=1e-3, inputs=inputs)
    assert evaluated


def test_the_shortest_step_that_is_not_refused_reaches_the_end(workshop: Workshop) -> None:
    """Ten million steps and no more: a pendulum is at the end after the last of them."""
    from ccgen.generator import chain
    from ccgen.runtime import simulate
    from ccgen.runtime.simulation.arguments import STEP_BUDGET

    pendulum = workshop.model(chain(1, hinged=True))
    with pytest.raises(ValueError, match="expected at least 1e-12 s"):
        simulate(pendulum, until=1e-5, step=1e-5 / (STEP_BUDGET + 1))
    run = simulate(pendulum, [0.0], [1.0], until=1e-5, step=1e-11, method="dopri5")
    assert run.success and run.t.size == 1_000_001 and run.q[-1, 0] == pytest.approx(1e-5, rel=1e-12)


# -- all faults of a call at once ----------------------------------------------------------------------------------


def said(call: Any, *args: Any, kind: type[Exception] = ValueError, **kwargs: Any) -> list[str]:
    """The lines of what a call is refused with."""
    with pytest.raises(kind) as caught:
        call(*args, **kwargs)
    assert type(caught.value) is kind or kind is KeyError
    return str(caught.value).splitlines()


WRONG_RUN = {
    "until": -1.0,
    "rtol": 5,
    "atol": 0.0,
    "method": "foo",
    "drift": "away",
    "step": "soon",
    "progress": 3,
    "keep_interrupted": "yes",
    "inputs": [1.0],
    "params": {"link_0.mass": -1.0, "link_9.mass": 1.0},
}
"""Wrong arguments of a run: each is named at the beginning of a line."""


@pytest.mark.quick
def test_all_wrong_arguments_of_a_run_are_told(model: Any) -> None:
    from ccgen.runtime import simulate

    for start, names in (({}, []), ({"q0": ["a"] * 5, "u0": [1j] * 5}, ["q0", "u0"]), ({"q0": [[1.0]]}, ["q0, u0"])):
        lines = said(simulate, model, **WRONG_RUN, **start)
        expected = [
            *(name for name in WRONG_RUN if name != "params"),
            "link_0.mass: found -1.0, expected",
            "link_9.mass: found no such parameter, expected one of the model, as link_",
            *names,
        ]
        for name in expected:
            assert [line for line in lines if line.startswith(name)], (name, lines)
        assert len(lines) == len(expected)


@pytest.mark.quick
def test_what_is_wrong_with_a_start_is_told_beside_the_rest(model: Any) -> None:
    from ccgen.runtime import simulate

    q, _ = model.start()
    lines = said(simulate, model, q - 2.0 * (np.arange(len(q)) == 1), method="foo", until=np.nan)
    assert [line.partition(" ")[0] for line in lines] == ["until:", "method:", "the"]
    assert "the start has" in lines[2]


@pytest.mark.quick
def test_all_wrong_parameters_are_told(model: Any) -> None:
    wrong = {"link_0.mass": -1.0, "link_1.mass": np.nan, "ground_0.restitution": 2.0}
    lines = said(model.with_parameters, wrong)
    assert [line.partition(":")[0] for line in lines] == list(wrong)
    lines = said(model.with_parameters, {"link_9.mass": 1.0, "wind.speed": 1.0}, kind=KeyError)
    told = "found no such parameter, expected one of the model, as "
    assert [line.partition(told)[0] for line in lines] == ["link_9.mass: ", "wind.speed: "]
    assert all(line.endswith("; correct the name") and told in line for line in lines)
    assert len(said(model.with_parameters, {"link_9.mass": 1.0, "link_0.mass": -1.0})) == 2
    assert "parameters: found int" in said(model.with_parameters, 3, kind=TypeError)[0]


@pytest.mark.quick
def test_all_that_is_wrong_with_a_state_is_told(model: Any) -> None:
    q, u = model.start()
    for wrong_q, wrong_u in ((spoiled(q, np.nan), u[:-1]), ("abc", ["a"] * len(u)), (q + 0j, [[1.0], [1.0, 2.0]])):
        lines = said(model.acceleration, wrong_q, wrong_u, t="soon", inputs=3.0)
        assert [line.partition(":")[0] for line in lines] == ["q", "u", "t", "inputs"]
    assert said(model.acceleration, q, u, t=[0.0, 1.0], inputs=3.0)[0].startswith("t: found [0.0, 1.0]")
    assert np.isfinite(model.acceleration(q, u)).all()


COMPLEX = [1j, np.complex128(1.0), np.ones(5, dtype=complex)]


@pytest.mark.quick
@pytest.mark.parametrize("number", COMPLEX, ids=["python", "numpy", "array"])
def test_complex_numbers_lose_nothing(model: Any, number: Any) -> None:
    """They are refused by name, where NumPy would drop what is imaginary."""
    q, u = model.start()
    wrong = q + number if np.ndim(number) == 0 else q * number[0]
    assert said(model.energy, wrong, u) == [f"q: found {complex(wrong[0])!r}, expected real numbers"]
    refuses("poses", model.state_from_poses, model.poses(q) + 0j, 0.0 * model.poses(q))
    refuses("t", model.acceleration, q, u, t=number if np.ndim(number) == 0 else number[0])
    refuses("restitution", model.impact, q, u, [("joint_0", "ground_0")], number if np.ndim(number) == 0 else number[0])


@pytest.mark.quick
def test_numbers_of_other_kinds_are_numbers(model: Any) -> None:
    from fractions import Fraction

    q, u = model.start()
    for same in ([Fraction(float(x)) for x in q], q.astype(object), [float(x) for x in q], np.asfortranarray(q)):
        assert np.array_equal(model.poses(same), model.poses(q))
    assert np.array_equal(model.energy(np.zeros(len(q), dtype=int), u), model.energy(np.zeros(len(q)), u))
    refuses("q", model.poses, [10**400] * len(q))


@pytest.mark.quick
def test_files_that_have_no_name(model: Any) -> None:
    from ccgen.generator import load_scene
    from ccgen.runtime import HybridState, load_model, simulate

    run = simulate(model, until=0.1)
    calls = (
        load_model,
        load_scene,
        run.plot,
        run.save,
        run.animate,
        run.state.save,
        HybridState.load,
        model.write_header,
    )
    for call in calls:
        with pytest.raises(TypeError, match=r"path: found 3, expected .+"):
            call(3)


@pytest.mark.quick
def test_a_state_that_is_not_there_is_asked_for(tmp_path: Any) -> None:
    from ccgen.runtime import HybridState

    for path, found in ((tmp_path / "none.npz", "no such file"), (tmp_path, "a folder")):
        (line,) = said(HybridState.load, path, kind=FileNotFoundError)
        expected = "the .npz file that HybridState.save wrote; correct the path"
        assert line == f"{path}: found {found}, expected {expected}"


@pytest.mark.quick
def test_a_file_that_is_no_state_is_not_called_a_pickle(model: Any, tmp_path: Any) -> None:
    from ccgen.runtime import HybridState

    for content in (b"[chain]\nlinks = 2\n", b"", b"\x80\x04N.", b"PK\x03\x04 and nothing"):
        (tmp_path / "a.toml").write_bytes(content)
        (line,) = said(HybridState.load, tmp_path / "a.toml")
        assert "a.toml: found no" in line and "HybridState.save" in line and "pickle" not in line
