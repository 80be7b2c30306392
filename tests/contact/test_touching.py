"""Discs of links that touch discs and edges of other links: rows against geometry, impacts, words and pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import simulate

from ..support.closed_forms import closed_form, put_in
from ..support.player_page import data_of
from ..support.touching_scenes import cradle, disc_on_plank
from ..support.workshop import Workshop

LINKS = """
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
points = { A = [0.1, 0.1], B = [1.1, 0.4] }
"""

FLOATING = (
    "[ground_link]\npoints = { O = [0.3, -0.2], Q = [1.4, 0.5] }\n"
    + LINKS
    + '[[joint]]\nbetween = ["a.B", "b.A"]\n[[joint]]\nbetween = ["b.B", "c.A"]\n'
)
SLIDING = (
    "[ground_link]\npoints = { O = [0.3, -0.2], Q = [1.4, 0.5] }\n"
    + LINKS
    + '[[joint]]\nbetween = ["ground.O", "a.A"]\n'
    '[[joint]]\ntype = "pin-in-slot"\nbetween = ["a.B", "b.A"]\naxis = [1, 2]\n'
    '[[joint]]\ntype = "prismatic"\nbetween = ["b.B", "c.A"]\naxis = "20 deg"\nangle = "40 deg"\n'
)

TOUCHES = """
[[touch]]
between = ["a.M", "c.B"]
radius = [0.02, 0.03]
restitution = 0.3
friction = 0.4
[[touch]]
between = ["c.B", "a"]
radius = [0.01, 0.015]
restitution = 0.3
friction = 0.4
[[touch]]
between = ["a.M", ["c.B", "c.A"]]
radius = 0.01
restitution = 0.3
friction = 0.4
[[touch]]
between = ["c.B", "ground"]
radius = [0.01, 0.02]
restitution = 0.3
friction = 0.4
[[touch]]
between = ["ground.Q", "b"]
radius = [0.02, 0.005]
restitution = 0.3
friction = 0.4
[[touch]]
between = ["ground.Q", "c.B"]
radius = 0.02
restitution = 0.3
friction = 0.4
""".replace('"a"]', '["a.A", "a.B"]]')

SIDES: tuple[tuple[str, float, tuple[str, ...], float], ...] = (
    ("a.M", 0.02, ("c.B",), 0.03),
    ("c.B", 0.01, ("a.A", "a.B"), 0.015),
    ("a.M", 0.01, ("c.B", "c.A"), 0.0),
    ("c.B", 0.01, ("ground.O", "ground.Q"), 0.02),
    ("ground.Q", 0.02, ("b.A", "b.B"), 0.005),
    ("ground.Q", 0.02, ("c.B",), 0.02),
)
"""What the tables say, for a geometry of its own."""


class Geometry:
    """Gaps and sliding of :data:`SIDES` from positions and velocities of bodies, by nothing that the model derives."""

    def __init__(self, model: Any) -> None:
        self.model = model

    def point(self, name: str, q: Any) -> complex:
        return complex(*self.model.point(name, q))

    def spin(self, name: str, q: Any, u: Any) -> float:
        link = name.partition(".")[0]
        return 0.0 if link == "ground" else float(self.model.velocities(q, u)[self.model.links.index(link), 2])

    def velocity(self, name: str, place: complex, q: Any, u: Any) -> complex:
        """Of the material point of a body that is at a place."""
        link = name.partition(".")[0]
        if link == "ground":
            return 0j
        k = self.model.links.index(link)
        pose, (x, y, w) = self.model.poses(q)[k], self.model.velocities(q, u)[k]
        return complex(x, y) + 1j * w * (place - complex(pose[0], pose[1]))

    def nearest(self, side: Any, q: Any) -> tuple[complex, complex]:
        """The disc's centre and the nearest point of the other body."""
        centre, ends = self.point(side[0], q), [self.point(name, q) for name in side[2]]
        if len(ends) == 1:
            return centre, ends[0]
        edge = ends[1] - ends[0]
        share = ((centre - ends[0]) / edge).real
        return centre, ends[0] + np.clip(share, 0.0, 1.0) * edge

    def gaps(self, q: Any) -> Any:
        pairs = [self.nearest(side, q) for side in SIDES]
        return np.array([abs(a - b) - s[1] - s[3] for (a, b), s in zip(pairs, SIDES, strict=True)])

    def slips(self, q: Any, u: Any) -> Any:
        """Along the tangent, of the material points at the touching place, as far as the surfaces are apart."""
        found = []
        for side in SIDES:
            centre, foot = self.nearest(side, q)
            normal = (centre - foot) / abs(centre - foot)
            tangent = -1j * normal
            moving = self.velocity(side[0], centre - side[1] * normal, q, u)
            still = self.velocity(side[2][0], foot + side[3] * normal, q, u)
            found.append(((moving - still) * np.conj(tangent)).real)
        return np.array(found)

    def inside(self, q: Any) -> Any:
        """How far the nearest point is inside its edge, as a share of the edge; none for discs."""
        found = []
        for side in SIDES:
            ends = [self.point(name, q) for name in side[2]]
            share = ((self.point(side[0], q) - ends[0]) / (ends[-1] - ends[0])).real if len(ends) > 1 else 0.5
            found.append(min(share, 1 - share))
        return np.array(found)


def along(function: Any, h: float = 2e-3) -> tuple[Any, Any]:
    """First and second derivatives at zero by central differences of order 8."""
    values = [function(k * h) for k in range(-4, 5)]
    first = [1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280]
    second = [-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560]
    return (
        sum(c * v for c, v in zip(first, values, strict=True)) / h,
        sum(c * v for c, v in zip(second, values, strict=True)) / h**2,
    )


def kernel(model: Any, name: str, q: Any, u: Any) -> Any:
    return model.kernels.of_state(name, q[None].copy(), u[None].copy())[0]


@pytest.fixture(scope="module", params=["floating", "sliding"])
def touching(request: pytest.FixtureRequest, workshop: Workshop) -> Any:
    form = {"floating": FLOATING, "sliding": SLIDING}[request.param]
    start = "" if request.param == "floating" else "[start]\nangles = { a = 0.3, b = 1.2 }\n"
    return workshop.model(form + TOUCHES + start)


@pytest.mark.sample(1)
def test_rows_are_those_of_the_geometry(touching: Any) -> None:
    """Gaps, rates, sliding and what both accelerate at with u' = 0, at random states on both branches of every edge."""
    rng, shape = np.random.default_rng(4), Geometry(touching)
    n, branches = len(touching.q_names), []
    for _ in range(60):
        q, u = rng.normal(size=n), rng.normal(size=n)
        gaps = shape.gaps(q)
        assert touching.gaps(q) == pytest.approx(gaps, abs=1e-13)
        assert kernel(touching, "slips", q, u) == pytest.approx(shape.slips(q, u), abs=1e-12)
        u *= 0.3 * min(1.0, float(gaps.min()) * 4)  # so that nothing is passed on the way
        rate, bias = along(lambda x, q=q, u=u: shape.gaps(q + x * u))
        turning, _ = along(lambda x, q=q, u=u: shape.slips(q + x * u, u))
        smooth = [abs(min(shape.inside(q + x * u)[k] for x in (-0.01, 0, 0.01))) > 0.01 for k in range(len(SIDES))]
        smooth = np.array(smooth) & (gaps > 0.05)
        for name, wanted, accuracy in (
            ("gap_rates", rate, 1e-10),
            ("gap_bias", bias, 1e-7),
            ("slip_bias", turning, 1e-10),
        ):
            assert kernel(touching, name, q, u)[smooth] == pytest.approx(wanted[smooth], abs=accuracy), name
        branches += [(k, bool(shape.inside(q)[k] > 0)) for k in np.flatnonzero(smooth)]
    assert {k for k, _ in branches} == set(range(len(SIDES)))
    assert {(k, inside) for k in (1, 2, 3, 4) for inside in (True, False)} <= set(branches)


def test_impulses_act_on_both_links(touching: Any) -> None:
    """M (u+ - u-) is a normal impulse along the row of the gap and, within Coulomb's limit, one along that of sliding:
    what acts on one link is the opposite of what acts on the other."""
    rng = np.random.default_rng(9)
    n, compared = len(touching.q_names), np.zeros(len(SIDES), dtype=int)
    unit = np.eye(n)
    for _ in range(12):
        q = rng.normal(size=n)

        def kinetic(u: Any, q: Any = q) -> float:
            return float(touching.energy(q, u)[0])

        mass = np.array([[kinetic(a + b) - kinetic(a) - kinetic(b) for b in unit] for a in unit])
        normals = np.array([touching.gap_rates(q, a) for a in unit]).T
        tangents = np.array([kernel(touching, "slips", q, a) for a in unit]).T
        u = rng.normal(size=n)
        for k in np.flatnonzero(normals @ u < -0.1):
            after, impulses = touching.impact(q, u, [touching.contacts[k]])
            left = mass @ (after - u) - impulses[0] * normals[k]
            pull = left @ tangents[k] / (tangents[k] @ tangents[k])
            assert left == pytest.approx(pull * tangents[k], abs=1e-10)
            assert normals[k] @ after == pytest.approx(-0.3 * normals[k] @ u, abs=1e-10)
            assert abs(pull) <= 0.4 * impulses[0] * (1 + 1e-10)
            slip = tangents[k] @ after
            assert abs(slip) <= 1e-10 or pull == pytest.approx(-0.4 * impulses[0] * np.sign(slip), rel=1e-9)
            compared[k] += 1
    assert np.all(compared >= 2), compared


@pytest.mark.hard
def test_listing_folded_and_wide_have_the_same_rows(workshop: Workshop) -> None:
    """The listing read back, folded parameters and long doubles: gaps, rates and both biases of the compiled model."""
    from ccgen.generator.pipeline import listing
    from ccgen.generator.program.reading import read_listing

    scene = workshop.scene(FLOATING + TOUCHES)
    model, wide = workshop.model(scene), workshop.model(scene, "wide")
    rng = np.random.default_rng(5)
    q, u = rng.normal(size=(8, 5)), rng.normal(size=(8, 5))
    read = [read_listing(listing(scene, fold=fold)) for fold in (False, True)]
    for name, output in (("gaps", "gap"), ("gap_rates", "rate"), ("gap_bias", "bias"), ("slip_bias", "bias")):
        wanted = (
            model.gaps(q) if name == "gaps" else np.array([kernel(model, name, *one) for one in zip(q, u, strict=True)])
        )
        for listed in read:
            given = {"q": q.T, "u": u.T}
            needed = {key: given[key] for key in listed.kernels[name].inputs if key in given}
            found = listed.evaluate(name, needed)[output].T
            assert found == pytest.approx(wanted, rel=1e-11, abs=1e-11)
    assert np.asarray(wide.gaps(q), dtype=float) == pytest.approx(model.gaps(q), abs=1e-15)


@pytest.mark.hard
def test_the_closed_form_has_the_same_rows(workshop: Workshop) -> None:
    """N of the expanded form, its names put in, against the compiled rates of the gaps."""
    import sympy as sp

    from ccgen.generator.equations.step import step

    scene = workshop.scene(FLOATING + TOUCHES)
    form, model = closed_form(scene), workshop.model(scene)
    parameters = {sp.Symbol(p.symbol): p.value for p in scene.mechanism.parameters()}
    parameters |= {sp.Symbol(p.symbol): p.value for effect in scene.effects for p in effect.parameters()}
    rng = np.random.default_rng(6)
    for _ in range(3):
        q = rng.normal(size=5)
        values = parameters | dict(zip(form.state.q, map(float, q), strict=True))
        put_in(values, form.definitions)
        rows = np.array(form.N.xreplace(values).evalf(), dtype=float)
        wanted = np.array([model.gap_rates(q, unit) for unit in np.eye(5)]).T
        assert rows == pytest.approx(wanted, abs=1e-12)
    assert len(form.definitions) < 100 and form.N.count_ops() < 200
    assert any(a.expression.has(step) for a in form.definitions)


# -- words and pictures ------------------------------------------------------------------------------------------------


def test_what_is_said_of_touches(workshop: Workshop, capsys: pytest.CaptureFixture[str]) -> None:
    """Show describes the pair and counts what it costs; impacts and phases name the disc and the table."""
    from ccgen.generator.cli.report import print_contacts, print_impacts
    from ccgen.generator.documents.show import show_text

    scene = workshop.scene(cradle(3, 0.0))
    shown = show_text(scene, False, False)
    assert "touch_0: ball_0.C against ball_1.C, touch_0.radius = 0.25, touch_0.restitution = 1.0" in shown
    assert "ball_0.C on touch_0, ball_1.C on touch_1" in shown
    assert [line.split()[:2] for line in shown.splitlines() if "touch_" in line and "events" in line] == [
        ["touch_0", "events"],
        ["touch_1", "events"],
    ]
    model = workshop.model(scene)
    run = simulate(model, until=0.6)
    print_impacts(model, run)
    assert "ball_0.C on touch_0" in capsys.readouterr().out
    resting = workshop.model(disc_on_plank(0.3, 0.2, "restitution = 0.0\nfriction = 0.5"))
    print_contacts(resting, simulate(resting, until=0.1))
    assert "disc.C" in capsys.readouterr().out


def test_a_run_from_inside_is_refused(workshop: Workshop) -> None:
    model = workshop.model(cradle(3, 0.0))
    with pytest.raises(ValueError, match=r"ball_0\.C inside touch_0 by .* change the start or the radii"):
        simulate(model, q0=[0.1, 0.0, 0.0], until=0.1)
    with pytest.raises(ValueError, match=r"ball_1\.C inside touch_1 by 0\.1 m"):
        simulate(model, until=0.1, params={"touch_1.radius": 0.3})


@pytest.mark.parametrize("name", ["touch_0.radius.disc.C", "touch_0.radius.plank", "touch_0.friction"])
def test_parameters_that_cannot_be(name: str, workshop: Workshop) -> None:
    """As a scene refuses them; zero is a point, a thin edge, or smooth."""
    model = workshop.model(disc_on_plank(0.3, 0.2, "restitution = 0.0\nfriction = 0.5"))
    with pytest.raises(ValueError, match=f"{name}: found -0.1, expected a number that is not negative"):
        model.with_parameters({name: -0.1})
    assert model.with_parameters({name: 0.0}).parameters[name] == 0.0


def test_points_of_the_ground(touching: Any) -> None:
    """They have places, for one state and for many, and follow their parameters."""
    q = np.zeros((3, len(touching.q_names)))
    assert touching.point("ground.Q", q[0]).tolist() == [1.4, 0.5]
    assert touching.point("ground.Q", q).tolist() == [[1.4, 0.5]] * 3
    moved = touching.with_parameters({"ground.points.Q.x": 2.0})
    assert moved.point("ground.Q", q[0]).tolist() == [2.0, 0.5]


def test_edges_and_what_is_fixed_are_drawn(touching: Any, workshop: Workshop, tmp_path: Path) -> None:
    """Discs with a spoke, edges as what is at most their half thickness away, and those of the ground in the page."""
    edges = [disc for disc in touching.discs if disc.end is not None]
    assert [(disc.link, disc.radius) for disc in edges] == [(0, 0.015), (2, 0.0), (-1, 0.02), (1, 0.005)]
    for disc in edges:
        start, end = complex(*disc.centre), complex(*disc.end)
        for point in disc.outline @ [1, 1j]:
            share = np.clip(((point - start) / (end - start)).real, 0, 1)
            assert abs(point - start - share * (end - start)) == pytest.approx(disc.radius, abs=1e-15)
    fixed = [disc for disc in touching.discs if disc.fixed]
    assert [disc.radius for disc in fixed] == [0.02] * 3 and fixed[1].centre.tolist() == [1.4, 0.5]
    q, u = touching.start()
    run = simulate(touching, q0=q, u0=u, until=0.01)
    run.plot(tmp_path / "run.png")
    content = data_of(run.animate(tmp_path / "run.html").read_text(encoding="utf-8"))
    assert content["fixed"]["discs"] == [[1.4, 0.5, 0.02]] * 2 and len(content["fixed"]["edges"]) == 1
    assert [len(link["edges"]) for link in content["links"]] == [1, 1, 1]
    assert (tmp_path / "run.png").stat().st_size > 1000
