"""Rolling: repeated blocks of assignments become loops over arrays, with the same values."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pytest
import sympy as sp

from ccgen.generator.program import rolling
from ccgen.generator.program.dialects import C
from ccgen.generator.program.rolling import LEAST_ROUNDS, Lines, Loop, Rolled, roll
from ccgen.generator.program.terms import Assign, Name

ROUNDS = 9


def block(title: str, *lines: tuple[str, str]) -> Lines:
    """A block from names and expressions."""
    return Lines(title, tuple(Assign(Name(name), C.term(sp.sympify(text))) for name, text in lines))


def texts(lines: Iterable[Assign]) -> list[tuple[str, str]]:
    """Targets and values as C writes them."""
    return [(C.text(line.target), C.text(line.value)) for line in lines]


def inputs(array: str, count: int) -> dict[str, rolling.Place]:
    """Names ``b_0`` … that lie in an array ``k``."""
    return {f"{array}_{k}": ("k", k) for k in range(count)}


def straight_values(blocks: Sequence[Lines], values: Mapping[str, float]) -> dict[str, float]:
    """All names of blocks, computed as they stand."""
    names = dict(values)
    for block in blocks:
        for name, text in texts(block.lines):
            assert name not in names, f"{name} is assigned twice"
            names[name] = eval(text, {}, names)
    return names


def rolled_values(rolled: Rolled, given_: Mapping[str, rolling.Place], values: Mapping[str, float]) -> dict[str, float]:
    """All names that can be read after the rolled code, by the scoping rules of C."""
    scope: dict[str, Any] = {array: [float("nan")] * size for array, size in rolled.arrays}
    for name, (array, index) in given_.items():
        assert array not in rolled.arrays
        entries = scope.setdefault(array, [float("nan")] * 99)
        entries[index] = values[name]
        if name in rolled.scalars:
            scope[name] = values[name]
    scope |= {name: value for name, value in values.items() if name not in given_}

    def assign(lines: Iterable[Assign], names: dict[str, Any]) -> None:
        assigned = set()
        for name, text in texts(lines):
            assert name not in assigned, f"{name} is declared twice"
            assigned.add(name)
            value = eval(text, {}, names)
            if "[" in name:
                array, _, index = name[:-1].partition("[")
                names[array][eval(index, {}, names)] = value
            else:
                names[name] = value

    for part in rolled.statements:
        if isinstance(part, Lines):
            assign(part.lines, scope)
            continue
        for i in range(part.rounds):
            for block in part.body:
                assign(block.lines, scope | {"i": i})
    found = {name: scope[array][index] for name, (array, index) in rolled.places.items()}
    return scope | found


def check(
    blocks: Sequence[Lines], given_: Mapping[str, rolling.Place], results: Iterable[str], reserved: Iterable[str] = ()
) -> Rolled:
    """Roll, and compare every result with the code as it stood."""
    rolled = roll(blocks, given_, results, reserved)
    numbers = np.random.default_rng(1).uniform(1.0, 2.0, len(given_))
    values = dict(zip(given_, map(float, numbers), strict=True)) | {"start": 1.25}
    wanted, found = straight_values(blocks, values), rolled_values(rolled, given_, values)
    for name in results:
        assert found[name] == wanted[name], name
    return rolled


def chain_blocks(rounds: int = ROUNDS) -> list[Lines]:
    """a_0 = start, a_k = a_(k-1) + b_k."""
    first = block("link 0", ("a_0", "start*b_0"))
    return [first, *(block(f"link {k}", (f"a_{k}", f"a_{k - 1}*b_{k} + b_0")) for k in range(1, rounds + 1))]


def loops(rolled: Rolled) -> list[Loop]:
    return [part for part in rolled.statements if isinstance(part, Loop)]


def test_a_repeated_block_becomes_one_loop() -> None:
    rolled = check(chain_blocks(), inputs("b", 30), [f"a_{ROUNDS}"])
    (loop,) = loops(rolled)
    assert loop.rounds == ROUNDS
    assert loop.title == f"link 1 to link {ROUNDS}"
    assert texts(loop.body[0].lines) == [("a[i + 1]", "b_0 + a[i]*k[i + 1]")]
    assert rolled.arrays == [("a", ROUNDS + 1)]
    assert rolled.places["a_3"] == ("a", 3)
    assert "b_0" in rolled.scalars


def test_blocks_that_count_down_become_a_loop() -> None:
    blocks = [block("start", (f"a_{ROUNDS}", "start*2"))]
    blocks += [block(f"{k}", (f"a_{k}", f"a_{k + 1} + b_{k}*b_{2 * k + 1}")) for k in range(ROUNDS - 1, -1, -1)]
    rolled = check(blocks, inputs("b", 2 * ROUNDS), ["a_0"])
    assert [loop.rounds for loop in loops(rolled)] == [ROUNDS]


def test_branches_side_by_side_become_one_loop() -> None:
    blocks = []
    for k in range(ROUNDS):
        blocks += [block(f"{k}", (f"a_{k}", f"b_{k}*2")), block(f"{k}", (f"d_{k}", f"a_{k} + b_{k + 20}*3"))]
    rolled = check(blocks, inputs("b", 50), [f"d_{ROUNDS - 1}", "d_4"])
    (loop,) = loops(rolled)
    assert len(loop.body) == 2


@pytest.mark.parametrize("local", [True, False])
@pytest.mark.parametrize("order", ["{k}_{n}", "{n}_{k}"])
def test_columns_with_different_standing_numbers_keep_their_names(local: bool, order: str) -> None:
    """t_k_7 and t_k_8 in one block are two names, inside of a block and across blocks."""
    blocks = []
    for k in range(ROUNDS):
        one, two = (f"t_{order.format(k=k, n=n)}" for n in (70, 80))
        blocks.append(block(f"link {k}", (one, f"b_{k}*2"), (two, f"{one} + b_{k}"), (f"a_{k}", f"{one}*{two}")))
    results = [f"a_{k}" for k in range(ROUNDS)]
    results += [] if local else [f"t_{order.format(k=k, n=n)}" for k in range(ROUNDS) for n in (70, 80)]
    rolled = check(blocks, inputs("b", ROUNDS), results)
    (loop,) = loops(rolled)
    written = [name.partition("[")[0] for name, _ in texts(loop.body[0].lines)]
    assert len(set(written)) == 3


def test_two_runs_of_one_name_do_not_share_elements() -> None:
    """Two branches whose names differ in a standing number only: x_1_k and x_2_k."""
    blocks = []
    for branch in (1, 2):
        blocks.append(block("start", (f"x_{branch}_0", f"start*{branch}")))
        for k in range(1, ROUNDS):
            blocks.append(block(f"link {k}", (f"x_{branch}_{k}", f"x_{branch}_{k - 1}*b_{k}")))
    rolled = check(blocks, inputs("b", ROUNDS), [f"x_{branch}_{k}" for branch in (1, 2) for k in range(ROUNDS)])
    assert len(loops(rolled)) == 2
    assert len(set(rolled.places.values())) == len(rolled.places)


def test_rows_and_columns_of_one_name_do_not_share_elements() -> None:
    """x_1_k and x_k_1 would both be called x_1[k]: one of them at most may lie there."""
    rows = [block(f"{k}", (f"x_1_{k}", f"b_{k}*2")) for k in range(2, ROUNDS)]
    columns = [block(f"{k}", (f"x_{k}_1", f"b_{k} + 3")) for k in range(2, ROUNDS)]
    results = [name for part in rows + columns for name, _ in texts(part.lines)]
    rolled = check(rows + columns, inputs("b", ROUNDS), results)
    assert len(set(rolled.places.values())) == len(rolled.places)


def test_names_that_move_together_do_not_share_elements() -> None:
    """p_k_k, p_k_(k+1) and p_k_(k-1) are three columns."""
    blocks = []
    for k in range(1, ROUNDS):
        lines = [(f"p_{k}_{k + d}", f"b_{k} + {d + 2}") for d in (-1, 0, 1, 2)]
        blocks.append(block(f"{k}", *lines, (f"a_{k}", " - ".join(name for name, _ in lines))))
    results = [name for part in blocks for name, _ in texts(part.lines)]
    rolled = check(blocks, inputs("b", ROUNDS), results)
    assert len(loops(rolled)) == 1
    assert len(set(rolled.places.values())) == len(rolled.places)


def test_irregular_strides_stay_straight() -> None:
    blocks = [block(f"{k}", (f"a_{k}", f"b_{k * k} + start")) for k in range(ROUNDS)]
    assert not loops(check(blocks, inputs("b", ROUNDS**2), [f"a_{ROUNDS - 1}"]))


def test_inputs_that_lie_unevenly_stay_straight() -> None:
    """Names run evenly, but their places in the array do not."""
    places: dict[str, rolling.Place] = {f"b_{k}": ("k", k * k) for k in range(ROUNDS)}
    blocks = [block(f"{k}", (f"a_{k}", f"b_{k} + start")) for k in range(ROUNDS)]
    assert not loops(check(blocks, places, [f"a_{ROUNDS - 1}"]))


@pytest.mark.parametrize("rounds", [1, 2, LEAST_ROUNDS - 1, LEAST_ROUNDS])
def test_few_rounds_stay_straight(rounds: int) -> None:
    rolled = check(chain_blocks(rounds), inputs("b", 30), [f"a_{rounds}"])
    assert len(loops(rolled)) == (rounds >= LEAST_ROUNDS)


def test_different_expressions_stay_straight() -> None:
    blocks = [block(f"{k}", (f"a_{k}", f"b_{k} {'+-'[k % 2]} start*{k}.5")) for k in range(ROUNDS)]
    assert not loops(check(blocks, inputs("b", ROUNDS), [f"a_{ROUNDS - 1}"]))


def test_reserved_names_are_refused_as_arrays() -> None:
    blocks, places, results = chain_blocks(), inputs("b", 30), [f"a_{ROUNDS}"]
    assert not loops(check(blocks, places, results, reserved={"a"}))
    assert loops(check(blocks, places, results, reserved={"b"}))


def test_reserved_names_are_refused_inside_of_blocks() -> None:
    """A name that lives inside a block must not hide an argument of the function."""
    blocks = [block(f"{k}", (f"q_{k}", f"b_{k}*2"), (f"a_{k}", f"q_{k}*q_{k}")) for k in range(ROUNDS)]
    rolled = check(blocks, inputs("b", ROUNDS), [f"a_{ROUNDS - 1}"], reserved={"q"})
    (loop,) = loops(rolled)
    assert "q" not in {name for name, _ in texts(loop.body[0].lines)}


def test_results_can_be_spelled_after_a_loop() -> None:
    rolled = roll(chain_blocks(), inputs("b", 30), [f"a_{ROUNDS}"], [])
    term = C.term(sp.sympify(f"2*a_{ROUNDS} - aa_{ROUNDS}"))
    assert C.text(rolled.placed(term)) == f"2.0*a[{ROUNDS}] - aa_{ROUNDS}"
