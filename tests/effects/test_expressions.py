"""Expressions of time: their values in a model, what is refused, and that spelling does not matter."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from ccgen.generator.effect_base import expression_of_time as expressions
from ccgen.generator.effect_base.arithmetic import ExpressionError
from ccgen.generator.effect_base.expression_of_time import Expression

from ..support.active import ROD
from ..support.workshop import Workshop

EXPRESSIONS: dict[str, Callable[[float], float]] = {
    "2*sin(3*t) + 0.5": lambda t: 2 * math.sin(3 * t) + 0.5,
    " t ": lambda t: t,
    "-t**2/(1 + t)": lambda t: -(t**2) / (1 + t),
    "(1 + t)**-3": lambda t: (1 + t) ** -3,
    "+pi*cos(2*pi*t - 1e-3)": lambda t: math.pi * math.cos(2 * math.pi * t - 1e-3),
    "exp(-t)*log(1 + t)*sqrt(2 + t)*sqrt(2 + t)**3": lambda t: math.exp(-t) * math.log(1 + t) * (2 + t) ** 2,
    "tanh(10*(t - 0.5))*abs(sin(7*t) - 0.2)": lambda t: math.tanh(10 * (t - 0.5)) * abs(math.sin(7 * t) - 0.2),
    "tan(t/2)**2 + 2**0.5": lambda t: math.tan(t / 2) ** 2 + 2**0.5,
    "exp(0.5*log(1 + t))": lambda t: math.sqrt(1 + t),
    "abs(exp(-t) - 1)\n + 1": lambda t: abs(math.exp(-t) - 1) + 1,
    "sqrt(exp(t))*sqrt(t**2 + 1e-4)**-1": lambda t: math.exp(t / 2) / math.sqrt(t * t + 1e-4),
    "sin(t)*sin(t) + 0.1*sin(t + pi) - t*0": lambda t: math.sin(t) ** 2 - 0.1 * math.sin(t),
    "cos(sin(tan(t/3)))": lambda t: math.cos(math.sin(math.tan(t / 3))),
}


@pytest.fixture(scope="module")
def clockwork(workshop: Workshop) -> Any:
    """Two wheels of inertia 1 for each expression: one under it as a torque, one under its rate if it has one."""
    text = 'name = "clockwork"\n[ground_link]\npoints = { O = [0, 0] }\n'
    for k, law in enumerate(EXPRESSIONS):
        laws = [f'torque = """{law}"""', f'angle = """{law}"""\ndamping = 1' if "abs" not in law else "torque = 1"]
        for wheel, line in zip((f"a{k}", f"b{k}"), laws, strict=True):
            text += f'[[link]]\nname = "{wheel}"\nmass = 1\ninertia = 1\ncom = [0, 0]\npoints = {{ C = [0, 0] }}\n'
            text += f'[[joint]]\nname = "hub_{wheel}"\nbetween = ["ground.O", "{wheel}.C"]\n'
            text += f'[[motor]]\njoint = "hub_{wheel}"\n{line}\n'
    return workshop.model(text)


@pytest.mark.parametrize("text", EXPRESSIONS)
def test_expression_in_a_model(text: str, clockwork: Any) -> None:
    """Its value at reading, and as torque of a motor; its rate in a servo with damping alone."""
    value, index = EXPRESSIONS[text], list(EXPRESSIONS).index(text)
    parsed = expressions.parse(text)
    assert isinstance(parsed, Expression)
    rest = np.zeros(2 * len(EXPRESSIONS))
    for t in (0.0, 0.1, 0.63, 2.2):
        found = clockwork.acceleration(rest, rest, t)[2 * index : 2 * index + 2]
        assert parsed.at(t) == pytest.approx(value(t), rel=1e-14, abs=1e-14)
        assert found[0] == pytest.approx(value(t), rel=1e-13, abs=1e-13)
        if t and parsed.has_rate():
            h = 1e-4
            rate = (8 * (value(t + h) - value(t - h)) - (value(t + 2 * h) - value(t - 2 * h))) / (12 * h)
            assert found[1] == pytest.approx(rate, rel=1e-8, abs=1e-8)


@pytest.mark.parametrize(
    ("text", "value"), [("2*pi", 2 * math.pi), ("-3", -3.0), ("sqrt(2)/exp(1)", 2**0.5 / math.e), ("9**0.5", 3.0)]
)
def test_expression_without_time_is_a_number(text: str, value: float) -> None:
    assert expressions.parse(text) == pytest.approx(value, rel=1e-15)


REFUSED = {
    "": "cannot be read",
    "2 t": "cannot be read; write it like",
    "sin(2*(t + 1)": "cannot be read, with 2 ( and 1 );",
    "2*cos(t) N": "cannot be read: units stand behind a single number, not in arithmetic as N does here",
    "2*t + 3 mm": "cannot be read: units stand behind a single number, not in arithmetic as mm does here",
    "t +": "cannot be read",
    "y = 2*t": "cannot be read: an expression has no = in it; write its right side alone, or,",
    "= 2*t": "cannot be read: an expression has no = in it",
    "t >= 2 t": "cannot be read; write it like",
    "(" * 300 + "t" + ")" * 300: "cannot be read",
    "__import__('os').system('true')": "is not arithmetic",
    "__import__": "__import__ is not known here; the names are t and pi",
    "eval('t')": "eval(...) is not known here",
    "t.real": "t.real is not arithmetic",
    "().__class__": "is not arithmetic",
    "sin.__call__(t)": "is not arithmetic",
    "x + t": "x is not known here",
    "sin": "sin needs an argument in parentheses",
    "sin(t, 2)": "sin(...) takes one argument",
    "sin(x=t)": "sin(...) takes one argument",
    "sin(*t)": "is not arithmetic",
    "atan2(1)*t": "atan2(...) takes two arguments",
    "asinh(t)": "asinh(...) is not known here",
    "'t'": "is not arithmetic",
    "True": "is not arithmetic",
    "1j*t": "is not arithmetic",
    "[t]": "is not arithmetic",
    "t if t else 1": "is not arithmetic",
    "lambda: t": "is not arithmetic",
    "t // 2": "is not arithmetic",
    "t % 2": "is not arithmetic",
    "t < 1": "is not arithmetic",
    "(x := t)": "is not arithmetic",
    "t**t": "t in an exponent",
    "2**t": "t in an exponent",
    "t**0.5": "write sqrt(...)",
    "t**65": "whole numbers up to 64",
    "t**(10**10)": "whole numbers up to 64",
    "((t**8)**8)**8": "a power higher than 64",
    "(t + 1)**40*(t + 1)**40": "a power higher than 64",
    "9**9**9**9": "no finite value",
    "10**400": "no finite value",
    "1e999": "no finite value",
    "1/t": "no finite value at t = 0",
    "log(t)": "no finite value at t = 0",
    "sqrt(-1)*t": "no finite value",
    "(0-8)**0.5": "no finite value",
    "t/0": "no finite value",
    "-" * 150 + "t": "nested deeper than 100",
    "t" + " + t" * 400: "nested deeper than 100",
    "t" + " + t" * 4000: "characters",
    "t\0": "cannot be read",
}


@pytest.mark.parametrize("text", REFUSED, ids=lambda text: repr(text[:30]))
def test_refused_expression(text: str) -> None:
    with pytest.raises(ExpressionError) as caught:
        expressions.parse(text)
    assert REFUSED[text] in str(caught.value)
    assert "\n" not in str(caught.value)


def test_reading_an_expression_needs_no_algebra() -> None:
    import subprocess
    import sys

    code = (
        "import sys; from ccgen.generator.effect_base import expression_of_time as expressions;"
        "expressions.parse('sin(t)**2'); assert 'sympy' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_spelling_does_not_change_the_scene(workshop: Workshop) -> None:
    """Spaces and digits that mean the same are the same scene; numbers in quotes are parameters."""
    one, two = (
        workshop.scene(ROD + f'[[motor]]\njoint = "joint_0"\ntorque = "{text}"\n').canonical()
        for text in ("2*sin( 3*t )+0.50", "2 * sin(3*t) + .5")
    )
    assert one == two
    three, four = (
        workshop.scene(ROD + f'[[motor]]\njoint = "joint_0"\ntorque = {text}\n').canonical()
        for text in ('"5/2"', "2.5")
    )
    assert three == four
