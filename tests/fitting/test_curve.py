"""Dimensions from a curve: mechanisms that drew it are found again."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import fit, follow

from ..support.folders import ROOT
from ..support.workshop import Workshop


def drawn(model: Any, of: str, count: int) -> tuple[Any, Any]:
    """Angles of the crank all around, and where the point is there."""
    q, _ = model.start()
    angles = model.poses(q)[0, 2] + np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return angles, np.array([model.point(of, one) for one in follow(model, q, angles={"crank": angles}).q])


def lengths(model: Any) -> list[str]:
    return [path for path in model.parameters if ".points." in path and "crank" not in path]


@pytest.mark.parametrize("timed", [True, False])
def test_a_four_bar_is_found_again(timed: bool, workshop: Workshop) -> None:
    model = workshop.model(load_scene(ROOT / "scenes" / "four-bar.toml"), derivatives=True)
    angles, curve = drawn(model, "coupler.tip", 24)
    rng, paths = np.random.default_rng(4), lengths(model)
    off = {path: model.parameters[path] * (1.0 + 0.1 * rng.uniform(-1.0, 1.0)) for path in paths}
    asked = {"of": "coupler.tip", "crank": "crank", "vary": paths, "params": off}
    found = fit(model, curve, angles=angles if timed else None, **asked)
    assert found.converged and found.in_order and found.largest <= 1e-12
    assert max(abs(found.values[path] / model.parameters[path] - 1.0) for path in paths) <= 1e-9
    assert np.abs(np.array([found.model.point("coupler.tip", q) for q in found.q]) - curve).max() <= 1e-12
    assert np.abs(found.model.closure(found.q)).max() <= 1e-12
    assert np.abs((found.angles - angles + np.pi) % (2.0 * np.pi) - np.pi).max() <= 1e-9


@pytest.mark.hard
@pytest.mark.parametrize("seed", [3, 4, 5, 6])
def test_jansens_leg_is_found_again(seed: int, workshop: Workshop) -> None:
    """Eleven lengths and places, each up to 10 % off; with seed 5 the crank cannot go round at first."""
    model = workshop.model(load_scene(ROOT / "scenes" / "jansen-leg.toml"), derivatives=True)
    angles, curve = drawn(model, "shin.F", 36)
    rng, paths = np.random.default_rng(seed), lengths(model)
    off = {path: model.parameters[path] * (1.0 + 0.1 * rng.uniform(-1.0, 1.0)) for path in paths}
    found = fit(model, curve, of="shin.F", crank="crank", vary=paths, params=off, angles=angles)
    assert found.converged and found.largest <= 1e-10 * np.ptp(curve)
    assert max(abs(found.values[path] / model.parameters[path] - 1.0) for path in paths) <= 1e-9


def test_what_cannot_be_is_refused(workshop: Workshop) -> None:
    model = workshop.model(load_scene(ROOT / "scenes" / "four-bar.toml"), derivatives=True)
    angles, curve = drawn(model, "coupler.tip", 24)
    asked: dict[str, Any] = {"of": "coupler.tip", "crank": "crank", "vary": ["rocker.points.B.x"]}
    with pytest.raises(ValueError) as caught:
        fit(model, curve[:, :1], of="coupler.top", crank="crunk", vary=["rocker.length"])
    for part in ("rocker.length", "expected at least two points", "coupler.top", "crunk"):
        assert part in str(caught.value), str(caught.value)
    with pytest.raises(ValueError, match=r"angles: found shape \(3,\), expected a finite number for each point"):
        fit(model, curve, angles=angles[:3], **asked)
    short = {"rocker.points.B.x": 0.3 * model.parameters["rocker.points.B.x"]}
    with pytest.raises(ValueError, match=r"cannot be assembled|gets to"):
        fit(model, curve, angles=angles, params=short, **asked | {"vary": ["coupler.points.tip.x"]})
    plain = workshop.model(load_scene(ROOT / "scenes" / "four-bar.toml"))
    with pytest.raises(ValueError, match="found a model without derivatives"):
        fit(plain, curve, **asked)


def test_a_crank_that_leaves_freedoms_is_refused(workshop: Workshop) -> None:
    model = workshop.model("[chain]\nlinks = 2\nhinged = true\n", derivatives=True)
    curve = np.array([[1.0, 0.0], [0.9, 0.2]])
    point = model.points[-1]
    with pytest.raises(ValueError, match="found 1 freedoms left with the angle of link_0 given"):
        fit(model, curve, of=point, crank=model.links[0], vary=[next(p for p in model.parameters if "length" in p)])
