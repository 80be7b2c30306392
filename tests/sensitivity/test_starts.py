"""What starts move by: of scenes whose loops are closed anew, of drives, and of those that were given."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import sensitivities, simulate

from ..oracles.maximal import WIDE
from ..support.derivative_checks import difference
from ..support.derived_scenes import FOUR_BAR, LIFTER
from ..support.folders import ROOT
from ..support.workshop import Workshop

SHORT = 1e-9
"""A run (s) so short that its end is its start, to 1e-8."""

STEP = 2.0**-10
"""Of the differences: joints miss by more than what a start lets pass, a millionth of the length."""


def by_differences(wide: Any, model: Any, names: list[str]) -> Any:
    def start(name: str, h: float) -> Any:
        return np.concatenate(wide.with_parameters({name: model.parameters[name] + WIDE(h)}).start())

    return np.array([difference(lambda h, name=name: start(name, h), STEP) for name in names], dtype=float).T


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    ("scene", "changed"),
    [("four-bar", False), ("four-bar", True), ("lifter", False), ("jansen-driven", False), ("lifter", True)],
)
def test_a_scene_closes_its_loops_anew(scene: str, changed: bool, workshop: Workshop) -> None:
    """Also where its parameters are no longer those that its start is written for."""
    texts = {"four-bar": FOUR_BAR, "lifter": LIFTER}
    text = 'name = "starts"\n' + texts[scene] if scene in texts else (ROOT / "scenes" / f"{scene}.toml").read_text()
    model, wide = workshop.model(text, derivatives=True), workshop.model(text, "wide")
    lengths = [name for name in model.parameters if ".points." in name and name not in model.data["rests_on"]][:4]
    names = [*lengths, *(name for name in model.parameters if name.startswith("drive_"))]
    if changed:
        values = {name: model.parameters[name] * 1.02 for name in lengths}
        model, wide = model.with_parameters(values), wide.with_parameters(values)
    found = sensitivities(model, names, until=SHORT)
    wanted = by_differences(wide, model, names)
    size = np.maximum(np.max(np.abs(wanted), axis=0), 1.0)
    rates = float(np.max(np.abs(model.acceleration(*model.start(), contacts=()))))
    # the run has gone on for a nanosecond
    assert np.max(np.abs(found.jacobian - wanted) / size) < 1e-8 * max(1.0, rates)


def test_a_start_that_is_given_is_put_onto_the_closure(workshop: Workshop) -> None:
    text = 'name = "starts"\n' + FOUR_BAR
    model, wide = workshop.model(text, derivatives=True), workshop.model(text, "wide")
    q, u = model.start()
    found = sensitivities(model, ("q0", "u0", "coupler.points.B.x"), q0=q, u0=u, until=SHORT)
    n = len(q)

    def given(column: int, h: float) -> Any:
        q0, u0 = q.astype(WIDE), u.astype(WIDE)
        moved = np.eye(2 * n + 1, dtype=WIDE)[column] * WIDE(h)
        values = {"coupler.points.B.x": model.parameters["coupler.points.B.x"] + moved[-1]}
        return np.concatenate(wide.with_parameters(values).project(q0 + moved[:n], u0 + moved[n : 2 * n]))

    wanted = [difference(lambda h, k=k: given(k, h), 2.0**-12) for k in range(2 * n + 1)]
    assert found.jacobian == pytest.approx(np.array(wanted, dtype=float).T, abs=2e-7)


def test_a_driven_joint_of_a_start_that_is_given_moves_as_its_speed(workshop: Workshop) -> None:
    """Of a mechanism that its drive moves all the way a start is known by the speed: given or the scene's, it moves
    alike."""
    model = workshop.model('name = "starts"\n' + LIFTER, derivatives=True)
    (speed,) = (name for name in model.parameters if name.startswith("drive_"))
    q, u = model.start()
    own, given = (sensitivities(model, speed, q0=one, u0=other, until=0.02) for one, other in ((None, None), (q, u)))
    h = 2.0**-12
    ends = [simulate(model, params={speed: model.parameters[speed] + k * h}, until=0.02) for k in (-1.0, 1.0)]
    wanted = [(getattr(ends[1], of)[-1] - getattr(ends[0], of)[-1]) / (2.0 * h) for of in ("q", "u")]
    for found in (own, given):
        assert found.jacobian.ravel() == pytest.approx(np.concatenate(wanted), rel=1e-6, abs=1e-6)


def test_a_drive_takes_its_joint_on_from_where_a_start_has_it(workshop: Workshop) -> None:
    """A drive that gives a speed alone begins anywhere: coordinates of the start move the run, that of its joint too,
    and so do lengths where the scene's configuration, assembled by these, goes with rates that are given."""
    drive = '[[link]]\nname = "tail"\nrod = { mass = 1.0 }\npoints = { A = [0, 0], B = [0.3, 0] }\n[[joint]]\n'
    drive += 'between = ["rocker.B", "tail.A"]\n[[drive]]\njoint = "motor"\nspeed = 10\n'
    text = (ROOT / "scenes" / "four-bar.toml").read_text()
    model = workshop.model(text[: text.index("[start]")] + drive + text[text.index("[start]") :], derivatives=True)
    q, u = model.start()
    lengths = ["crank.points.B.x", "coupler.points.B.x"]
    h, options = 2.0**-12, {"until": 0.3, "rtol": 1e-11}

    def ends(one: Any, params: Any = None) -> Any:
        run = simulate(model, one, u, params=params, **options)
        return np.concatenate([run.q[-1], run.u[-1]])

    found = sensitivities(model, "q0", ["q", "u"], q, u, **options).jacobian.reshape(2 * len(q), -1)
    for k, way in enumerate(h * np.eye(len(q))):
        wanted = (8.0 * (ends(q + way) - ends(q - way)) - ends(q + 2.0 * way) + ends(q - 2.0 * way)) / (12.0 * h)
        assert found[:, k] == pytest.approx(wanted, rel=1e-6, abs=1e-6)
    assert np.abs(found[:, model.q_of.index("crank.angle")]).max() > 0.1
    found = sensitivities(model, lengths, ["q", "u"], None, u, **options).jacobian.reshape(2 * len(q), -1)
    for k, name in enumerate(lengths):
        one, other = (ends(None, {name: model.parameters[name] + way}) for way in (h / 16.0, -h / 16.0))
        assert found[:, k] == pytest.approx((one - other) / (h / 8.0), rel=1e-5, abs=1e-5)


def test_a_run_knows_whether_its_start_is_that_of_the_scene(workshop: Workshop) -> None:
    """The length of the coupler moves the start by assembly, or by projection."""
    model = workshop.model('name = "starts"\n' + FOUR_BAR, derivatives=True)
    q, u = model.start()
    name = "coupler.points.B.x"
    run = simulate(model, until=0.1)
    assert run.jacobian(name) == pytest.approx(sensitivities(model, name, until=0.1).jacobian, rel=1e-11)
    other = simulate(model, q, 1.1 * u, until=0.1)
    given = sensitivities(model, name, q0=q, u0=1.1 * u, until=0.1)
    assert other.jacobian(name) == pytest.approx(given.jacobian, rel=1e-11)
    assert not np.allclose(run.jacobian(name), other.jacobian(name))


def test_a_start_that_is_open_is_refused(workshop: Workshop) -> None:
    model = workshop.model('name = "starts"\n' + FOUR_BAR, derivatives=True)
    q, u = model.start()
    with pytest.raises(ValueError, match=r"q0: found a start that is open by 0\.0.* take it from model\.project"):
        sensitivities(model, "u0", q0=q + np.array([1e-3, 0, 0]), u0=u, until=0.1)


def test_what_is_not_given_of_a_start_moves_as_the_scenes(workshop: Workshop) -> None:
    """u0 alone is combined with the scene's configuration, which moves with a length."""
    model = workshop.model(load_scene(ROOT / "scenes" / "four-bar.toml"), derivatives=True)
    path, u0, h = "crank.points.B.x", 1.1 * model.start()[1], 2.0**-11
    found = sensitivities(model, [path], ["q", "u"], u0=u0, until=0.3, rtol=1e-12)
    ends = []
    for k in (1, -1, 2, -2):
        run = simulate(model, u0=u0, until=0.3, rtol=1e-12, params={path: model.parameters[path] + k * h})
        ends.append(np.concatenate([run.q[-1], run.u[-1]]))
    wanted = (8.0 * (ends[0] - ends[1]) - (ends[2] - ends[3])) / (12.0 * h)
    assert found.jacobian.ravel() == pytest.approx(wanted, rel=1e-7, abs=1e-7)
