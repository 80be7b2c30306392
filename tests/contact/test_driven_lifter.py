"""An eccentric that a drive turns under a guided lifter, with friction: no impulse changes how they slide."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import simulate

from ..support.workshop import Workshop

SPEED, ECCENTRIC, RADIUS, MASS = 50.0, 0.01, 0.03, 0.3
SCENE: dict[str, Any] = {
    "name": "lifter",
    "ground_link": {"points": {"O": [0, 0]}},
    "link": [
        {"name": "shaft", "disc": {"mass": 2, "radius": 0.02, "centre": "O"}, "points": {"O": [0, 0], "E": [0.01, 0]}},
        {"name": "lifter", "mass": MASS, "inertia": 0.01, "com": [0, 0.1], "points": {"A": [-0.05, 0], "B": [0.05, 0]}},
    ],
    "joint": [
        {"name": "axle", "between": ["ground.O", "shaft.O"]},
        {"name": "guide", "type": "prismatic", "between": ["ground.O", "lifter.A"], "axis": [0, 1]},
    ],
    "touch": [
        {"between": ["shaft.E", ["lifter.A", "lifter.B"]], "radius": [RADIUS, 0], "restitution": 0.3, "friction": 0.2}
    ],
    "drive": [{"joint": "axle", "speed": SPEED}],
    "gravity": {},
    "start": {"angles": {"shaft": 0, "lifter": 0}, "slides": {"guide": RADIUS}},
}


@pytest.mark.parametrize("law", ["newton", "poisson", "stronge"])
@pytest.mark.parametrize("e", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("mu", [1e-6, 0.2, 1.5])
def test_it_is_thrown_as_without_friction(law: str, e: float, mu: float, workshop: Workshop) -> None:
    """The shaft does not give way and the guide bears the friction: P = m (1 + e) v, by every law. It runs on."""
    model = workshop.model(load_scene(SCENE | {"run": {"law": law}}))
    model = model.with_parameters({"touch_0.restitution": e, "touch_0.friction": mu})
    q, u = model.start()
    after, impulse = model.impact(q, u, list(model.contacts))
    struck = SPEED * ECCENTRIC * (1.0 + e)
    np.testing.assert_allclose(after, [SPEED, struck], rtol=1e-14)
    assert impulse[0] == pytest.approx(MASS * struck, rel=1e-14)
    run = simulate(model, until=0.3)
    assert run.success and len(run.impacts) >= 2 and run.energy_drift < 1e-12
