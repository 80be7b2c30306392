"""What a scene gives its start stays where loops are closed with other values of parameters."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import ensemble, sensitivities, simulate

from ..support.slider_crank import SLIDER_CRANK as BODIES
from ..support.workshop import Workshop

CRANK, TURN, RATE = 0.2, np.pi / 3, 5.0

SLIDER_CRANK = (
    'name = "kept"'
    + BODIES.replace("LENGTH", "0.5")
    + """[start]
angles = { crank = "60 deg" }
angular_velocities = { crank = 5 }
[gravity]
[run]
until = 0.1
"""
)

FIVE_BAR = """
name = "five"
[ground_link]
points = { O = [0, 0], Q = [0.8, 0] }
[[link]]
name = "left"
rod = { mass = 1 }
points = { A = [0, 0], B = [0.4, 0] }
[[link]]
name = "upper"
rod = { mass = 1 }
points = { A = [0, 0], B = [0.6, 0] }
[[link]]
name = "lower"
rod = { mass = 1 }
points = { A = [0, 0], B = [0.6, 0] }
[[link]]
name = "right"
rod = { mass = 1 }
points = { A = [0, 0], B = [0.3, 0] }
[[joint]]
name = "o"
between = ["ground.O", "left.A"]
[[joint]]
between = ["left.B", "upper.A"]
[[joint]]
between = ["upper.B", "lower.B"]
[[joint]]
between = ["lower.A", "right.B"]
[[joint]]
name = "q"
between = ["ground.Q", "right.A"]
[start]
angles = { left = "100 deg", right = "70 deg" }
angular_velocities = { right = -2LEFT }
[gravity]
[run]
until = 0.1
"""


def at_crank(length: float) -> dict[str, float]:
    """The slider-crank whose crank stands and turns as given, in closed form."""
    rise = CRANK * np.sin(TURN)
    con = -np.arcsin(rise / length)
    con_rate = -CRANK * RATE * np.cos(TURN) / (length * np.cos(con))
    x = CRANK * np.cos(TURN) + length * np.cos(con)
    vx = -CRANK * RATE * np.sin(TURN) - length * con_rate * np.sin(con)
    return {"crank.angle": TURN, "con.angle": con, "slide": x, "rates": [RATE, con_rate, vx]}  # type: ignore[dict-item]


def state_at(length: float, names: tuple[str, ...]) -> np.ndarray[Any, Any]:
    found, rates = at_crank(length), at_crank(length)["rates"]
    order = ["crank.angle", "con.angle", "slide"]
    keys = [name if name in found else "slide" for name in names]
    return np.array([found[key] for key in keys] + [rates[order.index(key)] for key in keys])  # type: ignore[index]


@pytest.fixture
def crank(workshop: Workshop) -> Any:
    return workshop.model(SLIDER_CRANK, derivatives=True)


@pytest.mark.parametrize("length", [0.3, 0.500001, 0.7, 2.0])
def test_the_crank_stands_and_turns_as_given_whatever_the_length(crank: Any, length: float) -> None:
    q, u = crank.with_parameters({"con.points.B.x": length}).start()
    wanted = state_at(length, crank.q_of)
    assert np.append(q, u) == pytest.approx(wanted, abs=1e-13)


def test_where_the_crank_cannot_stand_there_all_gives_way(crank: Any) -> None:
    """A connecting rod that does not reach down from the crank's pin."""
    short = crank.with_parameters({"con.points.B.x": 0.15})
    q, u = short.start()
    assert np.abs(short.closure(q)).max() < 1e-15
    assert q[crank.q_of.index("crank.angle")] < TURN - 0.1
    assert u[crank.q_of.index("crank.angle")] == pytest.approx(RATE, rel=1e-12)


@pytest.mark.parametrize("length", [0.5, 0.3])
def test_the_start_moves_with_a_length_as_in_closed_form(crank: Any, length: float) -> None:
    """Derivatives of the start by the length, against differences of the closed form, from the scene's own length and
    from another."""
    model, h = crank.with_parameters({"con.points.B.x": length}), 1e-6
    run = simulate(model, until=1e-9)
    outputs = [*crank.q_of, "crank.angular_velocity", "con.angular_velocity"]
    found = sensitivities(model, ["con.points.B.x", "con.mass"], outputs, until=1e-9)
    wanted = (state_at(length + h, crank.q_of) - state_at(length - h, crank.q_of)) / (2.0 * h)
    n = len(crank.q_of)
    rates = [n + crank.q_of.index(name) for name in ("crank.angle", "con.angle")]
    for name, value in zip(outputs, wanted[[*range(n), *rates]], strict=True):
        assert found[name][0] == pytest.approx(value, abs=1e-6), name
        assert found[name][1] == pytest.approx(0.0, abs=1e-7), name
    assert run.success


def test_what_moves_the_start_itself_is_not_held(crank: Any) -> None:
    """A direction in u0 beside a parameter: each column is that of its own."""
    both = sensitivities(crank, ["u0", "con.points.B.x"], ["crank.angular_velocity"])["crank.angular_velocity"]
    alone = [
        sensitivities(crank, [name], ["crank.angular_velocity"])["crank.angular_velocity"]
        for name in ("u0", "con.points.B.x")
    ]
    assert both == pytest.approx(np.concatenate(alone), rel=1e-12)


def test_runs_side_by_side_begin_there_too(crank: Any) -> None:
    """To the bit as a run alone."""
    lengths = np.array([0.3, 0.5, 0.7])
    table = ensemble(crank, {"con.points.B.x": lengths}, observe=["crank.angle", "slider.C.x"])
    for k, length in enumerate(lengths.tolist()):
        alone = simulate(crank, params={"con.points.B.x": length})
        assert table["slider.C.x"][k] == alone["slider.C.x"][-1]
        assert table["crank.angle"][k] == alone["crank.angle"][-1]


def test_a_sweep_over_another_part_of_the_start_keeps_what_it_does_not_vary(crank: Any) -> None:
    """Over the crank's angle its rate stays; over the slider's place, which leaves the crank none, it gives way."""
    from ccgen.runtime.sweep.starts import starts_of

    names = crank.q_of
    _, u, faults = starts_of(crank, {}, {"crank.angle(0)": np.array([0.3, 2.0])})
    assert u is not None and not faults
    assert u[:, names.index("crank.angle")] == pytest.approx([RATE, RATE], rel=1e-12)
    q, u, faults = starts_of(crank, {}, {"con.angle(0)": np.array([-0.2])})
    assert q is not None and u is not None and not faults
    assert q[0, names.index("con.angle")] == pytest.approx(-0.2, abs=1e-13)
    assert u[0, names.index("crank.angle")] == pytest.approx(RATE, rel=1e-12)


def test_what_is_sketched_gives_way_altogether(workshop: Workshop) -> None:
    """Angles of two links, of which the loop leaves one free: none of them is held, and the rate of one is."""
    model = workshop.model(SLIDER_CRANK.replace('"60 deg" }', '"60 deg", con = "-20 deg" }'))
    assert "kept_places" not in model.data["start"]
    q, _ = model.start()
    other, u = model.with_parameters({"con.points.B.x": 0.7}).start()
    assert abs(other - q)[model.q_of.index("crank.angle")] > 1e-3
    assert u[model.q_of.index("crank.angle")] == pytest.approx(RATE, rel=1e-12)


@pytest.mark.parametrize("driven", [False, True])
def test_two_freedoms_keep_what_is_given_of_both(workshop: Workshop, driven: bool) -> None:
    """The speed of one crank is given, or that of its drive, which is another then."""
    text = FIVE_BAR.replace("LEFT", "" if driven else ", left = 3")
    text += '[[drive]]\njoint = "o"\nspeed = 3\n' if driven else ""
    model = workshop.model(text)
    left, right = (model.q_of.index(f"{name}.angle") for name in ("left", "right"))
    q, u = model.start()
    changed = {"upper.points.B.x": 0.65, "right.points.B.x": 0.33}
    if driven:
        changed[next(path for path in model.parameters if path.endswith(".speed"))] = 4.0
    other, rates = model.with_parameters(changed).start()
    assert other[[left, right]] == pytest.approx(np.radians([100, 70]), abs=1e-13)
    assert rates[[left, right]] == pytest.approx([4.0 if driven else 3.0, -2.0], abs=1e-12)
    assert np.abs(other - q).max() > 0.01
    assert np.abs(rates - u).max() > 0.01


@pytest.mark.parametrize("driven", [False, True])
@pytest.mark.parametrize("away", [0.0, 0.05])
def test_starts_of_two_freedoms_move_as_differences_say(workshop: Workshop, away: float, driven: bool) -> None:
    """By a length, and by a drive's speed; from the scene's own lengths, and from others."""
    text = FIVE_BAR.replace("LEFT", "" if driven else ", left = 3")
    text += '[[drive]]\njoint = "o"\nspeed = 3\n' if driven else ""
    model = workshop.model(text, derivatives=True).with_parameters({"lower.points.B.x": 0.6 + away})
    wrt = ["upper.points.B.x", *(path for path in model.parameters if path.endswith(".speed"))]
    angles = list(model.q_of)
    rates = [name.replace(".angle", ".angular_velocity") for name in angles]
    found = sensitivities(model, wrt, [*angles, *rates], until=1e-9)
    for k, path in enumerate(wrt):
        h, value = 1e-5, model.parameters[path]
        low, high = (np.append(*model.with_parameters({path: value + step}).start()) for step in (-h, h))
        for name, difference in zip([*angles, *rates], (high - low) / (2.0 * h), strict=True):
            assert found[name][k] == pytest.approx(difference, abs=2e-6), (name, path)


def test_a_start_of_its_own_goes_with_copies_and_pickles(crank: Any, tmp_path: Any) -> None:
    from ccgen.runtime import load_run

    poses, velocities = (f(*crank.start()[: k + 1]) for k, f in enumerate((crank.poses, crank.velocities)))
    q, u = crank.with_parameters({"con.points.B.x": 0.5}).start()
    own = crank.with_start(poses, 2.0 * velocities)
    for one in (own, own.with_parameters({"con.mass": 3.0}), pickle.loads(pickle.dumps(own))):
        assert one.start()[0] == pytest.approx(q, abs=1e-14)
        assert one.start()[1] == pytest.approx(2.0 * u, abs=1e-13)
    assert crank.start()[1] == pytest.approx(u, abs=1e-14)
    run = simulate(own)
    run.save(tmp_path / "run.npz")
    assert load_run(tmp_path / "run.npz", crank).model.start()[1] == pytest.approx(2.0 * u, abs=1e-13)
    with pytest.raises(ValueError, match="poses: joints miss"):
        crank.with_start(poses + 0.1, velocities)
