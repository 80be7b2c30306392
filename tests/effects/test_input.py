"""Inputs: the same laws by other ways, controllers and tables, and wrong ones."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import simulate

from ..oracles.maximal import Array
from ..support.active import ARM, SINGLE, Wrong, check_refusal
from ..support.workshop import Workshop


def test_constant_input_is_the_effect(workshop: Workshop) -> None:
    effects = (
        '[[force]]\npoint = "link_2.B"\nvector = [1.5, 0]\n[[torque]]\nlink = "link_1"\ntorque = -0.7\n'
        '[[motor]]\njoint = "joint_2"\ntorque = 0.3\n'
    )
    inputs = (
        '[[input]]\nname = "push"\npoint = "link_2.B"\ndirection = [7, 0]\n[[input]]\nname = "turn"\nlink = "link_1"\n'
        '[[input]]\nname = "knee"\njoint = "joint_2"\n'
    )
    values = {"push": 1.5, "turn": -0.7, "knee": 0.3}
    one, other = workshop.model(ARM + effects), workshop.model(ARM + inputs)
    q, u = one.start()
    u = u + 1.0
    assert np.max(np.abs(other.acceleration(q, u, 0.0, values) - one.acceleration(q, u))) <= 1e-14
    wanted, found = simulate(one, q, u, until=2.0), simulate(other, q, u, until=2.0, inputs=values)
    assert wanted.t.shape == found.t.shape
    assert np.max(np.abs(found.q - wanted.q)) <= 1e-11
    assert found.energy_drift == pytest.approx(wanted.energy_drift, abs=1e-11)
    assert np.max(np.abs(found.at(1.3)[0] - wanted.at(1.3)[0])) <= 1e-11
    for same in ([1.5, -0.7, 0.3], np.array([1.5, -0.7, 0.3]), {"t": [0.0], **{k: [v] for k, v in values.items()}}):
        assert np.array_equal(simulate(other, q, u, until=2.0, inputs=same).q, found.q)
    constant = simulate(other, q, u, until=2.0, inputs=lambda t, q, u: values, method=found.method)
    assert np.array_equal(constant.q, found.q)


def test_inputs_are_zero_unless_given(workshop: Workshop) -> None:
    model = workshop.model(ARM + '[[input]]\nname = "knee"\njoint = "joint_2"\n')
    plain = workshop.model(ARM)
    q, u = plain.start()
    assert not np.array_equal(model.acceleration(q, u, 0.0, 2.0), plain.acceleration(q, u))
    for none in (None, {}, [0.0], 0.0):
        assert np.max(np.abs(model.acceleration(q, u, 0.0, none) - plain.acceleration(q, u))) <= 1e-14
    run = simulate(model, until=1.0)
    end = run.q[-1]
    run.model.acceleration(q, u, 0.0, 2.0)
    assert np.max(np.abs(run.at(1.0 - 1e-13)[0] - end)) <= 1e-11
    assert np.max(np.abs(end - simulate(plain, until=1.0).q[-1])) <= 1e-8


def test_controller_is_the_law(workshop: Workshop) -> None:
    """A proportional-derivative law in Python against the same law as an effect."""
    law = '[[motor]]\njoint = "joint_1"\nangle = "0.5*sin(2*t)"\nstiffness = 20\ndamping = 1.5\n'
    effect = workshop.model(ARM + law)
    model = workshop.model(ARM + '[[input]]\nname = "knee"\njoint = "joint_1"\n')
    asked = []

    def control(t: float, q: Array, u: Array) -> float:
        asked.append((t, q, u))
        wanted, rate = 0.5 * math.sin(2 * t), math.cos(2 * t)
        return float(20 * (wanted - (q[1] - q[0])) + 1.5 * (rate - (u[1] - u[0])))

    wanted, found = simulate(effect, until=3.0, rtol=1e-11), simulate(model, until=3.0, rtol=1e-11, inputs=control)
    assert len(asked) >= found.nfev
    assert len({id(q) for _, q, _ in asked}) == len(asked), "states are the controller's to keep"
    for t in (1.0, 2.0, 3.0):
        assert np.max(np.abs(np.concatenate(found.at(t)) - np.concatenate(wanted.at(t)))) <= 1e-9
    assert found.energy_drift <= 1e-9


def test_table_of_inputs_is_the_table_of_a_motor(workshop: Workshop) -> None:
    rows = [(0.2, 1.0), (0.6, -3.0), (0.9, 2.0)]
    effect = workshop.model(ARM + f'[[motor]]\njoint = "joint_1"\ntable = {[list(row) for row in rows]}\n')
    model = workshop.model(ARM + '[[input]]\nname = "knee"\njoint = "joint_1"\n')
    t, values = zip(*rows, strict=True)
    wanted = simulate(effect, until=2.0, rtol=1e-11)
    found = simulate(model, until=2.0, rtol=1e-11, inputs={"t": t, "knee": values})
    assert {0.2, 0.6, 0.9} <= set(wanted.t) & set(found.t)
    for instant in (0.2, 0.4, 0.6, 0.77, 0.9, 1.5, 2.0):
        assert np.max(np.abs(found.at(instant)[0] - wanted.at(instant)[0])) <= 1e-9


def test_what_a_controller_raises_ends_the_run(workshop: Workshop) -> None:
    model = workshop.model(ARM + '[[input]]\nname = "knee"\njoint = "joint_2"\n')
    times = []

    def control(t: float, q: Array, u: Array) -> list[float]:
        times.append(t)
        if t > 0.5:
            raise LookupError("no more set points")
        return [0.0]

    with pytest.raises(LookupError, match="no more set points"):
        simulate(model, until=2.0, inputs=control)
    assert times[-1] > 0.5
    assert sum(t > 0.5 for t in times) == 1
    assert simulate(model, until=2.0).success


def test_ctrl_c_in_a_controller_is_ctrl_c(workshop: Workshop) -> None:
    model = workshop.model(ARM + '[[input]]\nname = "knee"\njoint = "joint_2"\n')

    def control(t: float, q: Array, u: Array) -> float:
        if t > 0.5:
            raise KeyboardInterrupt
        return 0.0

    with pytest.raises(KeyboardInterrupt):
        simulate(model, until=2.0, inputs=control)
    run = simulate(model, until=2.0, inputs=control, keep_interrupted=True)
    assert not run.success
    assert "interrupted" in run.message


BAD_INPUTS: dict[str, tuple[Any, str]] = {
    "unknown name": ({"knie": 1.0}, "inputs: found 'knie', expected one of knee, push"),
    "too few": ([1.0], r"inputs: found shape (1,), expected (2,): knee, push"),
    "too many": ([1.0, 2.0, 3.0], "inputs: found shape (3,)"),
    "a number for two": (1.0, "inputs: found shape ()"),
    "text": ("full", "inputs: found 'full', expected numbers"),
    "text by name": ({"push": "full"}, "inputs: push: found 'full', expected numbers"),
    "a list by name": ({"push": [1.0, 2.0]}, "inputs: push: found shape (2,), expected a number"),
    "not finite": ({"push": math.nan}, "inputs: push: found nan, expected finite numbers"),
}
BAD_RUNS: dict[str, tuple[Any, str]] = {
    "table without growth": ({"t": [0, 0], "push": [1, 2]}, "inputs: t: found no row of times that grow"),
    "table without rows": ({"t": [], "push": []}, "inputs: t: found no row of times that grow"),
    "short row": ({"t": [0, 1], "push": [1]}, "inputs: push: found shape (1,), expected (2,)"),
    "unknown row": ({"t": [0, 1], "pull": [1, 2]}, "inputs: found 'pull', expected one of t, knee, push"),
    "controller gives nothing": (lambda t, q, u: None, "inputs at t = 0: found None, expected values of knee, push"),
    "controller gives one": (lambda t, q, u: [1.0], "inputs at t = 0: found shape (1,)"),
    "controller gives nan": (lambda t, q, u: [1.0, math.nan], "inputs at t = 0: found nan"),
}


@pytest.fixture(scope="module")
def two_inputs(workshop: Workshop) -> Any:
    text = (
        '[[input]]\nname = "knee"\njoint = "joint_2"\n[[input]]\nname = "push"\npoint = "joint_1"\ndirection = [1, 1]\n'
    )
    return workshop.model(ARM + text)


@pytest.mark.parametrize("case", [*BAD_INPUTS, *BAD_RUNS])
def test_wrong_inputs_are_sentences(case: str, two_inputs: Any) -> None:
    given, words = {**BAD_INPUTS, **BAD_RUNS}[case]
    with pytest.raises(ValueError, match=re.escape(words)):
        simulate(two_inputs, inputs=given)
    if case in BAD_INPUTS:
        for function in (two_inputs.acceleration, two_inputs.multipliers, two_inputs.reactions):
            with pytest.raises(ValueError, match=re.escape(words)):
                function(*two_inputs.start(), 0.0, given)


def test_a_model_without_inputs_takes_none(workshop: Workshop) -> None:
    model = workshop.model(ARM)
    assert model.inputs == ()
    calls: list[Callable[[], object]] = [
        lambda: model.acceleration(*model.start(), 0.0, [1.0]),
        lambda: simulate(model, inputs=lambda t, q, u: []),
        lambda: simulate(model, inputs={"t": [0, 1]}),
    ]
    for call in calls:
        with pytest.raises(ValueError, match="the model has no inputs"):
            call()


def test_direction_is_a_unit_vector(workshop: Workshop) -> None:
    """Also when its parameters are changed; along an axis there are none."""
    model = workshop.model(SINGLE + '[[input]]\nname = "jet"\npoint = "body.C"\ndirection = [30, 40]\n')
    q = u = np.zeros(3)
    assert model.acceleration(q, u, 0.0, 10.0) == pytest.approx([3.0, 4.0, 0.0], rel=1e-15)
    model.parameters["jet.direction.x"] = 0.8
    assert model.acceleration(q, u, 0.0, 2.0) == pytest.approx([0.5**0.5, 0.5**0.5, 0.0], rel=1e-15)
    axis = workshop.model(SINGLE + '[[input]]\nname = "jet"\npoint = "body.C"\ndirection = [0, -3]\nframe = "link"\n')
    assert not [path for path in axis.parameters if path.startswith("jet")]
    assert axis.acceleration([0, 0, math.pi / 2], u, 0.0, 2.0) == pytest.approx([1.0, 0.0, 0.0], abs=1e-15)


BAD: dict[str, Wrong] = {
    "input without name": ('[[input]]\nlink = "link_0"', 1, "input[0].name", "missing, expected a name"),
    "input on nothing": (
        '[[input]]\nname = "a"',
        1,
        "input[0]",
        "found no point, joint or link, expected one of them; add one",
    ),
    "input on two things": (
        '[[input]]\nname = "a"\nlink = "link_0"\njoint = "joint_0"',
        3,
        "input[0].link",
        "found link beside joint, expected one of point, joint and link; remove one",
    ),
    "input without direction": (
        '[[input]]\nname = "a"\npoint = "link_0.B"',
        1,
        "input[0].direction",
        "missing, expected the direction of the force",
    ),
    "input without a direction's length": (
        '[[input]]\nname = "a"\npoint = "link_0.B"\ndirection = [0, 0]',
        4,
        "input[0].direction",
        "expected a direction, not both zero",
    ),
    "torque with a direction": (
        '[[input]]\nname = "a"\njoint = "joint_0"\ndirection = [0, 1]',
        4,
        "input[0].direction",
        "found direction without point",
    ),
    "input called t": (
        '[[input]]\nname = "t"\njoint = "joint_0"',
        2,
        "input[0].name",
        'found "t", the name of the time',
    ),
    "input at no joint": ('[[input]]\nname = "a"\njoint = "b"', 3, "input[0].joint", "the joints are joint_0"),
    "input on no link": ('[[input]]\nname = "a"\nlink = "b"', 3, "input[0].link", "the links are link_0"),
    "input on no point": (
        '[[input]]\nname = "a"\npoint = "b"\ndirection = [1, 0]',
        3,
        "input[0].point",
        'found "b", expected a joint or link.point that moves',
    ),
    "same name twice": (
        '[[input]]\nname = "a"\nlink = "link_0"\n[[input]]\nname = "a"\nlink = "link_0"',
        5,
        "input[1].name",
        'found "a" a second time',
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_wrong_table(case: str, workshop: Workshop) -> None:
    check_refusal(BAD[case], workshop)
