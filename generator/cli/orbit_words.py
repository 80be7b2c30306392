"""The words of ``ccgen orbit``: sections, guesses, exchanged parts and ranges as a command line says them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..scene import Scene
from .plan_numbers import written
from .refusal import Faults, fail

if TYPE_CHECKING:
    from ccgen.runtime import Model
    from ccgen.runtime.arrays import FloatArray


def read_section(text: str) -> float | tuple[str, str] | tuple[str, float]:
    """A time, ``0.2`` or ``2*pi/3``, a contact, ``ball.C,ground_0``, or a coordinate and its value, ``rod.angle=0.3``;
    exit code 2 for what is neither."""
    if "=" in text:
        from ccgen.runtime.orbits.values import unit_of

        name, _, value = (part.strip() for part in text.partition("="))
        try:
            return name, float(written(value, unit_of(name) if name else None))
        except ValueError as error:
            fail(f'--section: found "{text}", expected a coordinate and its value, as rod.angle=0.3; {error}')
    if "," in text:
        point, _, surface = (part.strip() for part in text.partition(","))
        return point, surface
    try:
        return float(written(text, "s"))
    except ValueError as error:
        fail(
            f'--section: found "{text}", expected a time as 0.2, a contact as ball.C,ground_0, or a coordinate as '
            f"rod.angle=0.3; {error}"
        )


def read_along(text: str, scene: Scene | None) -> tuple[str, float, float]:
    """A parameter and its range, ``ball.restitution=0.3:0.7``, in units that the parameter of the ``scene`` can have;
    exit code 2 for what is none."""
    expected = f'--along: found "{text}", expected PARAM=LOW:HIGH, such as bounce.restitution=0.3:0.7'
    path, sign, ends = (part.strip() for part in text.partition("="))
    low, colon, high = (part.strip() for part in ends.partition(":"))
    if not (path and sign and colon and low and high):
        fail(expected)
    try:
        return path, written(low, None, path, scene), written(high, None, path, scene)
    except ValueError as error:
        fail(f"{expected}; {error}")


def read_pairs(texts: Sequence[str], option: str) -> dict[str, str]:
    """What options of this kind say, ``NAME=TEXT``; exit code 2, and all that is wrong, where one says nothing."""
    faults, found = Faults(), dict[str, str]()
    for text in texts:
        name, sign, rest = (part.strip() for part in text.partition("="))
        if not (name and sign and rest):
            faults.add(f'{option}: found "{text}", expected NAME=VALUE')
        elif name in found:
            faults.add(f"{option} {name}: found twice, expected once; leave one out")
        else:
            found[name] = rest
    faults.stop_if_any()
    return found


def guess_of(model: Model, given: Mapping[str, str]) -> tuple[FloatArray, FloatArray]:
    """The state (n,), (n,) that is the scene's start but for what is ``given``; exit code 2 for names or numbers that
    are wrong."""
    from ccgen.runtime.orbits.values import names_of, unit_of

    names, faults = names_of(model), Faults()
    state = np.concatenate(model.start())
    for name, text in given.items():
        if name not in names:
            faults.add(f"--guess: found {name}, expected one of {', '.join(names)}")
            continue
        try:
            state[names.index(name)] = written(text, unit_of(name))
        except ValueError as error:
            faults.add(f'--guess {name}: found "{text}", expected a number in {unit_of(name)}; {error}')
    faults.stop_if_any()
    return state[: len(model.q_of)], state[len(model.q_of) :]


def relabel_of(model: Model, given: Mapping[str, str]) -> tuple[FloatArray, FloatArray] | None:
    """The matrix (2 n, 2 n) and column (2 n,) by which parts are exchanged, or none: each ``given`` coordinate becomes
    what stands behind it, another one, with a minus or not, or a number; rates follow. Exit code 2 for other words."""
    from ccgen.runtime.orbits.values import unit_of

    if not given:
        return None
    names, faults = list(model.q_of), Faults()
    n = len(names)
    places, column = np.eye(n), np.zeros(n)
    for name, text in given.items():
        if name not in names:
            faults.add(f"--relabel: found {name}, expected one of {', '.join(names)}")
            continue
        row = names.index(name)
        places[row] = 0.0
        other = text.removeprefix("-").strip()
        if other in names:
            places[row, names.index(other)] = -1.0 if text.startswith("-") else 1.0
            continue
        try:
            column[row] = float(written(text, unit_of(name)))
        except ValueError as error:
            expected = f"a number, or one of {', '.join(names)} with or without a minus"
            faults.add(f'--relabel {name}: found "{text}", expected {expected}; {error}')
    faults.stop_if_any()
    return np.asarray(np.kron(np.eye(2), places), dtype=np.float64), np.concatenate([column, np.zeros(n)])
