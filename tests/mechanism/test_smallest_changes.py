"""A start changes what is sketched as little as its loops ask for: what no loop moves stays where it is."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from ccgen.generator.mechanism.assembly import follow, nearest
from ccgen.generator.mechanism.layout import Layout, lay_out
from ccgen.generator.scene import Scene, read_tables

LINK = {"mass": 1.0, "inertia": 0.1, "com": [0.0, 0.0]}


def carriages(start: dict[str, object]) -> Scene:
    """A four-bar on a carriage that slides up and down, and a second carriage that nothing connects with it."""
    links = [
        {"name": "body", "points": {"C": [0, 0], "A": [0.2, 0], "D": [0.2, -0.25]}},
        {"name": "upper", "points": {"A": [0, 0], "B": [0.3, 0]}},
        {"name": "lower", "points": {"A": [0, 0], "B": [0.3, 0]}},
        {"name": "upright", "points": {"L": [0, 0], "U": [0, 0.25]}},
        {"name": "road", "points": {"P": [0, 0]}},
    ]
    slide = {"type": "prismatic", "axis": [0, 1]}
    pins = [
        ("body.A", "upper.A"),
        ("body.D", "lower.A"),
        ("upper.B", "upright.U"),
        ("lower.B", "upright.L"),
    ]
    return read_tables(
        {
            "ground_link": {"points": {"B": [0, 0.6], "R": [2, 0.3]}},
            "link": [{**LINK, **link} for link in links],
            "joint": [
                {"name": "heave", **slide, "between": ["ground.B", "body.C"]},
                *({"between": list(pair)} for pair in pins),
                {"name": "bump", **slide, "between": ["ground.R", "road.P"]},
            ],
            "start": start,
        },
        "carriages.toml",
        "carriages",
    )


def test_carriages_of_which_nothing_is_said_stay_where_they_are() -> None:
    """Angles that do not quite close a loop move that loop alone; of two equal bars each goes half the way."""
    scene = carriages({"angles": {"upper": "-2 deg", "lower": "-5 deg", "upright": 0}})
    body, upper, lower, upright, road = scene.start.poses
    assert body == pytest.approx((0.0, 0.6, 0.0), abs=1e-14)
    assert road == pytest.approx((2.0, 0.3, 0.0), abs=1e-14)
    assert [upper[2], lower[2]] == pytest.approx([np.radians(-3.5)] * 2, abs=1e-12)
    assert upright[2] == pytest.approx(0.0, abs=1e-12)


def distance(layout: Layout, x: np.ndarray, sketch: np.ndarray) -> float:
    assert np.max(np.abs(layout.closure(x))) < 1e-9
    return float(np.sum((x - sketch) ** 2))


@pytest.mark.parametrize("seed", range(8))
def test_no_closed_configuration_is_nearer_than_the_start(seed: int) -> None:
    """SciPy's least squares under the same closure, from the sketch and from the start, finds none."""
    rng = np.random.default_rng(seed)
    layout = lay_out(carriages({}).mechanism)
    sketch = rng.uniform(-0.4, 0.4, len(layout.base) + len(layout.lines))
    sketch[[0, 4]] = 0.0  # prismatic joints hold these angles
    found = nearest(layout, sketch)
    for begin in (sketch, found):
        other = minimize(
            lambda x: np.sum((x - sketch) ** 2),
            begin,
            jac=lambda x: 2 * (x - sketch),
            method="SLSQP",
            constraints={"type": "eq", "fun": layout.closure, "jac": layout.jacobian},
            options={"ftol": 1e-15, "maxiter": 300},
        )
        if np.max(np.abs(layout.closure(other.x))) < 1e-9:
            assert distance(layout, found, sketch) <= distance(layout, other.x, sketch) + 1e-8
    assert found[len(layout.base) :] == pytest.approx(sketch[len(layout.base) :], abs=1e-12)  # no loop moves a slide


@pytest.mark.parametrize("seed", range(8))
def test_what_follows_moves_no_more_than_it_must(seed: int) -> None:
    """Bars that have to leave a dead end, all in one line, leave carriages alone; so do bars that cannot close."""
    rng = np.random.default_rng(seed)
    layout = lay_out(carriages({}).mechanism)
    count = len(layout.base)
    for angle in (rng.uniform(0.2, 1.0), 0.0):
        sketch = np.zeros(count + 2)
        sketch[1], sketch[3] = angle, np.pi / 2  # the upper bar, and the upright in line with what it hangs on
        sketch[count:] = rng.uniform(-1.0, 1.0, 2)
        for loose in ([2, 3, count, count + 1], [3, count, count + 1]):
            found = follow(layout, sketch, loose)
            held = np.setdiff1d(np.arange(count + 2), loose)
            assert np.all(found[held] == sketch[held])
            assert found[count:] == pytest.approx(sketch[count:], abs=1e-12)


@pytest.mark.parametrize(("links", "span"), [(4, 3.6), (6, 5.4), (6, 1.8)])
def test_chains_that_follow_one_link_change_least(links: int, span: float) -> None:
    """All links of a chain between two pins but the first follow it; SciPy finds nothing nearer from there."""
    scene = read_tables(
        {
            "ground_link": {"points": {"O": [0, 0], "E": [span, 0.1]}},
            "link": [{**LINK, "name": f"l{k}", "points": {"A": [0, 0], "B": [1, 0]}} for k in range(links)],
            "joint": [
                {"between": ["ground.O", "l0.A"]},
                *({"between": [f"l{k}.B", f"l{k + 1}.A"]} for k in range(links - 1)),
                {"between": [f"l{links - 1}.B", "ground.E"]},
            ],
            "start": {"angles": {"l0": 0.3}},
        },
        "chain.toml",
        "chain",
    )
    found = np.array([pose[2] for pose in scene.start.poses[1:]])

    def gap(x: np.ndarray) -> np.ndarray:
        miss = np.exp(0.3j) + np.sum(np.exp(1j * x)) - (span + 0.1j)
        return np.array([miss.real, miss.imag])

    assert scene.start.poses[0][2] == 0.3 and np.max(np.abs(gap(found))) < 1e-13
    other = minimize(
        lambda x: x @ x,
        found,
        jac=lambda x: 2 * x,
        method="SLSQP",
        constraints={"type": "eq", "fun": gap, "jac": lambda x: np.array([-np.sin(x), np.cos(x)])},
        options={"ftol": 1e-15, "maxiter": 300},
    )
    assert np.max(np.abs(gap(other.x))) < 1e-9
    assert found @ found <= other.x @ other.x + 1e-8
