"""Derivatives of runs of all kinds of contacts, by all parameters of their scenes: beside differences in wide
numbers."""

from __future__ import annotations

import pytest

from ccgen.runtime import sensitivities

from ..support.derived_scenes import DERIVED
from ..support.run_differences import RTOL, along, relative, unit_directions
from ..support.workshop import Workshop


@pytest.mark.sample(5)
@pytest.mark.parametrize("scene", DERIVED)
def test_derivatives_are_those_of_differences(scene: str, workshop: Workshop) -> None:
    text, until, passed = DERIVED[scene]
    text = 'name = "derived"\n' + text
    model, wide = workshop.model(text, derivatives=True), workshop.model(text, "wide")
    # one by one, but those at the end of what they may be, to both sides of which there is no difference
    names = [
        name for name, value in model.parameters.items() if not (name.endswith("restitution") and value in (0.0, 1.0))
    ]
    found = sensitivities(model, names, ["q", "u", "impact_times"], until=until, rtol=RTOL)
    kinds = [one.kind for one in found.passed]
    assert all(kinds.count(kind) >= passed.count(kind) for kind in passed), kinds
    wanted = along(wide, model, unit_directions(names), until)
    assert relative(found.jacobian, wanted) < 1e-9
