"""Polygons and lines of edges that touch: rows against geometry, motions against closed forms and single edges."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.generator.documents.show import show_text
from ccgen.runtime import simulate, static_equilibrium

from ..support.outline_scenes import box_on_ramp, ratchet, teeth_as_polygon, teeth_one_by_one
from ..support.tiers import hard
from ..support.touching_scenes import G
from ..support.workshop import Workshop
from .test_touching import Geometry, along, kernel

STAR = ("c.P", "c.Q", "c.R", "c.S", "c.T")
"""Concave at R and T; cut at Q besides, where half a turn is exceeded."""
HOOK = ("a.A", "a.M", "a.B")
BODIES = """\
[ground_link]
points = { O = [0.3, -0.2], Q = [1.4, 0.5] }
[[link]]
name = "a"
mass = 1.0
inertia = 0.2
com = [0.4, 0.1]
points = { A = [0.1, 0.2], B = [1.0, -0.1], M = [0.5, 0.3] }
[[link]]
name = "b"
mass = 1.5
inertia = 0.1
com = [0.3, 0]
points = { A = [0, 0], B = [0.8, 0] }
[[link]]
name = "c"
mass = 0.7
inertia = 0.3
com = [0.2, -0.1]
points = { A = [0.1, 0.1], P = [0, 0], Q = [0.5, -0.1], R = [0.35, 0.15], S = [0.4, 0.5], T = [0.25, 0.2] }
[[joint]]
between = ["a.B", "b.A"]
[[joint]]
between = ["b.B", "c.A"]
[[touch]]
between = [["a.A", "a.M", "a.B"], ["c.P", "c.Q", "c.R", "c.S", "c.T", "c.P"]]
radius = [0.02, 0.01]
restitution = 0.3
friction = 0.4
"""


def nearest(corners: list[complex], closed: bool, place: complex) -> complex:
    """The nearest point of an outline."""
    ring = [*corners, corners[0]] if closed else corners
    feet = []
    for a, b in pairwise(ring):
        share = float(np.clip(((place - a) / (b - a)).real, 0.0, 1.0))
        feet.append(a + share * (b - a))
    return min(feet, key=lambda foot: abs(foot - place))


def around(corners: list[complex], place: complex) -> bool:
    """Whether a polygon goes round a place: the angles at which its edges are seen sum to a full turn."""
    seen = np.array([*corners, corners[0]]) - place
    return abs(float(np.sum(np.angle(seen[1:] / seen[:-1])))) > np.pi


@pytest.mark.hard
def test_rows_are_those_of_the_nearest_points(workshop: Workshop) -> None:
    """Of all pairs of a corner and the other outline the least gap is the distance less radii; its rate, its sliding
    and what both accelerate at are those of the geometry, by nothing that the model derives."""
    model = workshop.model(BODIES)
    shape, rng, compared = Geometry(model), np.random.default_rng(3), 0
    tips = [*HOOK, *(name for name in STAR if name not in ("c.R", "c.T"))]
    assert {name for name, _ in model.contacts} == set(tips)
    assert [sum(1 for name, _ in model.contacts if name == tip) for tip in tips] == [3, 3, 3, 2, 2, 2]
    where: set[tuple[str, str]] = set()
    for _ in range(60):
        q, u = rng.normal(size=5), rng.normal(size=5)
        gaps, rates = model.gaps(q), kernel(model, "gap_rates", q, u)
        for tip in tips:
            other, closed = (STAR, True) if tip in HOOK else (HOOK, False)
            r1, r2 = (0.02, 0.01) if tip in HOOK else (0.01, 0.02)

            def apart(
                x: float, tip: str = tip, other: Any = other, closed: bool = closed, q: Any = q, u: Any = u
            ) -> Any:
                at = q + x * u
                centre = shape.point(tip, at)
                return centre, nearest([shape.point(name, at) for name in other], closed, centre)

            own = [k for k, contact in enumerate(model.contacts) if contact[0] == tip]
            k = min(own, key=lambda i: abs(float(gaps[i]) + r1 + r2))
            centre, foot = apart(0.0)
            outwards = -1 if closed and around([shape.point(name, q) for name in other], centre) else 1
            assert gaps[k] == pytest.approx(outwards * abs(centre - foot) - r1 - r2, abs=1e-13)
            normal = outwards * (centre - foot) / abs(centre - foot)

            def sliding(
                x: float,
                tip: str = tip,
                other: Any = other,
                radii: Any = (r1, r2),
                apart: Any = apart,
                state: Any = (q, u),
                outwards: int = outwards,
            ) -> float:
                (place, near), at = apart(x), state[0] + x * state[1]
                n = outwards * (place - near) / abs(place - near)
                moving = shape.velocity(tip, place - radii[0] * n, at, state[1])
                still = shape.velocity(other[0], near + radii[1] * n, at, state[1])
                return float(((moving - still) * np.conj(-1j * n)).real)

            assert kernel(model, "slips", q, u)[k] == pytest.approx(sliding(0.0), abs=1e-12)
            drift = shape.velocity(tip, centre, q, u) - shape.velocity(other[0], foot, q, u)
            assert rates[k] == pytest.approx((drift * np.conj(normal)).real, abs=1e-12)
            h, on = 2e-4, set()
            for x in (-2e-3, 0.0, 2e-3):
                corners = [shape.point(name, q + x * u) for name in other]
                away, name = min((abs(p - apart(x)[1]), name) for p, name in zip(corners, other, strict=True))
                on.add(name if away < 1e-12 else "near one" if away < 0.02 else "an edge")
            if len(on) > 1 or "near one" in on or abs(centre - foot) < 0.1:
                continue  # the branch changes, or the line turns too fast for differences
            _, bias = along(lambda x, apart=apart, s=outwards: s * abs(np.subtract(*apart(x))), h)
            turning, _ = along(sliding, h)
            assert kernel(model, "gap_bias", q, u)[k] == pytest.approx(bias, abs=1e-5 * max(1, abs(bias)))
            assert kernel(model, "slip_bias", q, u)[k] == pytest.approx(turning, abs=1e-7 * max(1, abs(turning)))
            where.add((tip, on.pop()))
            compared += 1
    assert compared > 150 and {name for _, name in where} >= {"an edge", "c.P", "c.Q", "c.S", "a.A", "a.B"}


@pytest.mark.hard
def test_inside_of_a_polygon_all_its_gaps_are_negative(workshop: Workshop) -> None:
    """By the angles at which edges are seen, not by crossings; what is nearest there pushes outwards."""
    model = workshop.model(BODIES)
    shape, rng, met = Geometry(model), np.random.default_rng(4), 0
    for q in rng.normal(size=(1500, 5)):
        distances = model.gaps(q) + 0.03
        corners = [shape.point(name, q) for name in STAR]
        for tip in HOOK:
            own = [k for k, contact in enumerate(model.contacts) if contact[0] == tip]
            inside = around(corners, shape.point(tip, q))
            assert np.all((distances[own] < 0.0) == inside)
            if inside:
                met += 1
                k = max(own, key=lambda i: float(distances[i]))
                u = rng.normal(size=5)
                h = 1e-6 * abs(distances[k]) / np.max(np.abs(u))
                slope = (model.gaps(q + h * u)[k] - model.gaps(q - h * u)[k]) / (2.0 * h)
                assert model.gap_rates(q, u)[k] == pytest.approx(slope, abs=1e-6)
    assert met > 20


@pytest.mark.hard
def test_a_ratchet_moves_as_with_a_table_for_every_edge(workshop: Workshop) -> None:
    """Half as many contacts, and the same impacts and motion, as far as that is known with a table for every edge.

    There a corner is touched twice, and runs by two methods at any tolerance differ by up to 4e-8. Those of the polygon
    agree to their tolerance.
    """
    whole, single = (workshop.model(ratchet(touches)) for touches in (teeth_as_polygon(), teeth_one_by_one()))
    assert (len(whole.contacts), len(single.contacts)) == (8, 16)
    runs = [simulate(model, until=1.0, rtol=1e-11, atol=1e-13) for model in (whole, single)]
    strikes = [
        [impact for impact in run.impacts if np.max(np.abs(impact.u_plus - impact.u_minus)) > 1e-5] for run in runs
    ]
    assert len(strikes[0]) == len(strikes[1]) >= 5
    for one, other in zip(*strikes, strict=True):
        assert one.t == pytest.approx(other.t, abs=5e-8)
        assert one.u_plus == pytest.approx(other.u_plus, abs=1e-6)
    finer = simulate(whole, until=1.0, rtol=1e-13, atol=1e-15, method="gauss")
    for t in np.linspace(0, 1, 11):
        assert runs[0].at(t)[0] == pytest.approx(runs[1].at(t)[0], abs=5e-8)
        assert runs[0].at(t)[0] == pytest.approx(finer.at(t)[0], abs=1e-11)
    assert min(float(np.min(run.model.gaps(run.q))) for run in runs) > -1e-9


SLOPE = 0.3


@pytest.mark.parametrize(
    ("mu", "share"), [hard(0.0, np.sin(SLOPE)), (0.1, np.sin(SLOPE) - 0.1 * np.cos(SLOPE)), hard(0.6, 0.0)]
)
def test_a_box_on_a_ramp(mu: float, share: float, workshop: Workshop) -> None:
    """Lies on two corners: a = g (sin - mu cos), or none where mu > tan; forces share its weight by statics."""
    model = workshop.model(box_on_ramp(SLOPE, mu))
    run = simulate(model, until=0.5, rtol=1e-11)
    assert run.success, run.message
    down = run.model.point("box.C", run.q[-1]) - run.model.point("box.C", run.q[0])
    wanted = -0.5 * G * share * 0.25 * np.array([np.cos(SLOPE), np.sin(SLOPE)])
    assert down == pytest.approx(wanted, abs=1e-9)
    if mu == 0.6:
        forces = dict(zip(model.contacts, model.contact_forces(*model.start()), strict=True))
        lower, upper = forces["box.A", "lies"][0], forces["box.B", "lies"][0]
        assert lower + upper == pytest.approx(2 * G * np.cos(SLOPE))
        lever = 0.11 * np.sin(SLOPE) * 2 * G  # of friction at the skin, about the box's centre
        assert (lower - upper) * 0.1 == pytest.approx(lever)
        found = static_equilibrium(model)
        assert found.q == pytest.approx(model.start()[0], abs=1e-9)


@pytest.mark.hard
def test_what_is_said_and_drawn(workshop: Workshop) -> None:
    scene = workshop.scene(ratchet(teeth_as_polygon()))
    shown = show_text(scene, False, False)
    assert "teeth: pawl.tip against wheel (polygon of 16 edges), 8 contacts, teeth.radius" in " ".join(shown.split())
    model = workshop.model(scene)
    assert ("pawl.tip", "teeth.R0-R1") in model.contacts
    edges = [disc for disc in model.discs if disc.end is not None]
    assert len(edges) == 16 and len(model.discs) == 17


@pytest.mark.hard
@pytest.mark.large(1)
@pytest.mark.parametrize("corners", [26, 52])
def test_corners_pass_a_disc_but_by_touching_it(corners: int, workshop: Workshop) -> None:
    """A heavy wheel turns by up to 300 rad below a disc on a guide, whose gap comes and goes with its corners."""
    scene = {
        "name": f"wheel{corners}",
        "ground_link": {"points": {"O": [0, 0]}},
        "link": [
            {"name": "wheel", "mass": 1e3, "inertia": 1e3, "com": [0, 0], "points": {"O": [0, 0]}}
            | {"around": {"count": corners, "points": {"T": [1, 0]}}},
            {"name": "ball", "mass": 0.5, "inertia": 0.01, "com": [0, 0], "points": {"C": [0, 0]}},
        ],
        "joint": [
            {"between": ["ground.O", "wheel.O"]},
            {"name": "guide", "type": "prismatic", "between": ["ground.O", "ball.C"], "axis": "90 deg"},
        ],
        "touch": [{"between": ["ball.C", "wheel"], "radius": [0.02, 0], "restitution": 0.5}],
        "start": {"slides": {"guide": 1.5}},
    }
    model, rng = workshop.model(load_scene(scene)), np.random.default_rng(1)
    for _ in range(150):
        rate = 10.0 ** rng.uniform(0.0, 2.5)
        q = np.array([rng.uniform(0.0, 6.0), 1.021 + rng.uniform(0.0, 0.02)])
        run = simulate(model, q, [rate, -rate * 10.0 ** rng.uniform(-4.5, -2.0)], until=min(2.0, 300.0 / rate))
        gaps = model.gaps(run.at(np.linspace(0.0, run.t[-1], 4001))[0])
        assert run.success and gaps.min() >= -1e-9
