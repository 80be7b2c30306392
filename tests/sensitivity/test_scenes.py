"""Derivatives of runs of all kinds of contacts, by all parameters of their scenes: beside differences in wide
numbers."""

from __future__ import annotations

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import sensitivities, simulate

from ..support.derived_scenes import DERIVED
from ..support.folders import ROOT
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


@pytest.mark.hard
def test_a_drive_that_leaves_no_motion_is_derived_where_digits_are_refined(workshop: Workshop) -> None:
    """Whatever pushes a walker of four legs whose shaft is driven, its jump is zero: rounding in its place is no lost
    digit. Its places follow from lengths and speeds alone."""
    model = workshop.model(load_scene(ROOT / "scenes" / "gallery" / "klann.toml"), derivatives=True)
    assert model.kernels.refined
    names, h = ["shaft.points.B.x", "drive_0.speed"], 2.0**-16
    found = sensitivities(model, names, until=0.2).jacobian.reshape(-1, len(names))
    for k, name in enumerate(names):
        values = ({name: model.parameters[name] + way} for way in (h, -h))
        one, other = (
            np.concatenate([run.q[-1], run.u[-1]]) for run in (simulate(model, until=0.2, params=x) for x in values)
        )
        assert found[:, k] == pytest.approx((one - other) / (2.0 * h), rel=1e-5, abs=1e-5)
