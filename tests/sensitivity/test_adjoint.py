"""Adjoint mode: the same derivatives as in tangent mode, of loops that are thrown onto the ground."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.runtime import sensitivities, simulate

from ..hard import fuzz
from ..support.run_differences import RTOL, relative
from ..support.thrown_loops import directions, parameters, throws
from ..support.tiers import hard
from ..support.workshop import Workshop

ALIKE = 1e-10


def closest(t: float, q: Any, u: Any) -> tuple[Any, Any, Any]:
    """A function of the state that is no output: two numbers."""
    weights = np.arange(1.0, len(q) + 1.0)
    return np.array([weights @ q**2, weights @ u]), np.array([2.0 * weights * q, 0.0 * u]), np.array([0.0 * q, weights])


@pytest.mark.parametrize(
    ("n", "rough", "stays", "count"),
    [(4, False, False, 3), (4, True, False, 3), (4, False, True, 3), hard(4, True, True, 6), hard(6, True, False, 20)],
)
def test_it_gives_the_derivatives_of_tangent_mode(
    n: int, rough: bool, stays: bool, count: int, workshop: Workshop
) -> None:
    models = (workshop.model(fuzz.scene(n, rough), derivatives=True),) * 2
    outputs = ["q", "u", "kinetic_energy", closest, "impact_times"]
    met = 0
    for model, _, q, u, end, rng in throws(models, n, rough, 11, count, stays):
        names = parameters(rough, stays)
        wrt = directions(q, names, rng) if met % 2 else ["q0", "u0", *names]
        options: dict[str, Any] = {"q0": q, "u0": u, "until": end, "rtol": RTOL, "at": [end, 0.6 * end]}
        try:
            tangent = sensitivities(model, wrt, outputs, mode="tangent", **options)
        except ValueError as why:
            with pytest.raises(ValueError, match=r"found|has no derivative") as again:
                sensitivities(model, wrt, outputs, mode="adjoint", **options)
            assert str(again.value) == str(why)
            continue
        adjoint = sensitivities(model, wrt, outputs, mode="adjoint", **options)
        assert relative(adjoint.jacobian, tangent.jacobian) < ALIKE
        run = simulate(model, q, u, until=end, rtol=RTOL)
        covector = rng.normal(size=(2, len(tangent.jacobian)))
        pulled = run.vjp(covector, wrt, outputs, at=options["at"])
        assert relative(pulled, covector @ tangent.jacobian) < ALIKE
        assert run.vjp(covector[:0], wrt, outputs, at=options["at"]).shape == (0, pulled.shape[1])
        met += 1
    assert met >= count / 2
