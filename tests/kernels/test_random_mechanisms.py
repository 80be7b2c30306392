"""Random mechanisms, trees with random extra joints and random effects, against the dense reference.

Hypothesis draws ten in ``make test`` and fifteen in ``make hard``, of fifty with ``CCGEN_LARGE=1``, the same ones each
time; ``make fuzz-mechanisms`` draws more.
"""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ..oracles import random_mechanisms
from ..oracles.maximal import GROUND
from ..oracles.random_mechanisms import KINDS, LAWS, LOADS, MESHES, Sketch
from ..support.random_mechanism_checks import DRAWN, EXAMPLES, check_flight, first
from ..support.workshop import Workshop


@st.composite
def sketches(choose: st.DrawFn, meshes: bool = False) -> Sketch:
    """One to six links, up to three more joints, up to three loads; with ``meshes`` up to three of these before."""
    n = choose(st.integers(1, 6))
    kinds = choose(st.lists(st.sampled_from(KINDS), min_size=n, max_size=n))
    parents = [choose(st.integers(GROUND, k - 1)) for k in range(n)]
    if choose(st.booleans()) and n > 1:  # floats: nothing on the ground
        parents = [GROUND + 1 if k else -2 for k in range(n)]
        lowest = 0
    else:
        lowest = GROUND
    pairs = st.tuples(st.sampled_from(KINDS), st.integers(lowest, n - 1), st.integers(0, n - 1))
    extra = [pair for pair in choose(st.lists(pairs, max_size=3)) if pair[1] != pair[2]]
    loads = choose(st.lists(st.sampled_from(LOADS + LAWS), max_size=3))
    if meshes:
        loads = choose(st.lists(st.sampled_from(MESHES), min_size=1, max_size=3)) + loads
    return random_mechanisms.draw(kinds, parents, extra, loads, choose(st.integers(0, 10**6)), choose(st.booleans()))


def check(sketch: Sketch, workshop: Workshop) -> None:
    check_flight(workshop.model(sketch.toml("random-mechanism")), sketch)


@pytest.mark.hard
@settings(DRAWN, max_examples=EXAMPLES)
@given(sketch=sketches())
@first(15)
def test_random_mechanisms_are_those_of_the_dense_reference(sketch: Sketch, workshop: Workshop) -> None:
    check(sketch, workshop)


@pytest.mark.hard
@settings(DRAWN, max_examples=EXAMPLES)
@given(sketch=sketches(meshes=True))
@first(15)
def test_random_gears_are_those_of_the_dense_reference(sketch: Sketch, workshop: Workshop) -> None:
    check(sketch, workshop)
