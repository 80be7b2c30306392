"""Uniform bodies against closed forms, and polygons against integrals over triangles that SymPy takes."""

from __future__ import annotations

import cmath
import math
import random
from fractions import Fraction

import pytest
import sympy as sp

from ccgen.generator.mechanism.uniform_bodies import (
    Mass,
    crossing_edges,
    disc,
    point,
    polygon,
    polygon_area,
    rod,
    together,
)


def test_a_rod_has_a_twelfth_of_its_length_squared() -> None:
    assert rod(2.0, 1 + 1j, 4 + 5j) == Mass(2.0, 2.5 + 3j, 2.0 * 25 / 12)
    assert rod(2.0, 0j, 3 + 0j, width=1.0).inertia == pytest.approx(2.0 * (9 + 1) / 12, rel=1e-15)


def test_numbers_are_those_that_are_written() -> None:
    """0.4 kg over 0.2 m: 1/750 kg m² as on paper, where products of doubles are off in the last digit."""
    assert rod(0.4, 0j, 0.2 + 0j).inertia == 1.0 / 750.0 != 0.4 * 0.2 * 0.2 / 12.0


@pytest.mark.parametrize("turn", [0.0, 0.3, 2.0])
@pytest.mark.parametrize("way", [1, -1])
def test_a_rectangle(turn: float, way: int) -> None:
    """m (a² + b²)/12, wherever it lies, however it is turned and whichever way its corners go round."""
    a, b, mass, centre = 0.7, 0.3, 2.5, 3 - 2j
    local = [complex(x, y) for x, y in ((-a, -b), (a, -b), (a, b), (-a, b))][::way]
    corners = [centre + 0.5 * z * cmath.exp(1j * turn) for z in local]
    found = polygon(mass, corners)
    assert polygon_area(corners) == pytest.approx(a * b, rel=1e-14)
    assert found.inertia == pytest.approx(mass * (a * a + b * b) / 12, rel=1e-13)
    assert found.com == pytest.approx(centre, rel=1e-14)


@pytest.mark.parametrize("count", [3, 4, 5, 6, 7, 60])
def test_a_regular_polygon(count: int) -> None:
    """m R²/2 (1 − 2/3 sin²(π/n)) about its centre, of circumradius R; with many corners that of a disc."""
    radius = 0.4
    corners = [radius * cmath.exp(2j * math.pi * k / count) for k in range(count)]
    expected = 3.0 * radius**2 / 2 * (1 - 2 / 3 * math.sin(math.pi / count) ** 2)
    found = polygon(3.0, corners)
    assert found.inertia == pytest.approx(expected, rel=1e-14)
    assert abs(found.com) < 1e-15
    assert polygon_area(corners) == pytest.approx(count / 2 * radius**2 * math.sin(2 * math.pi / count), rel=1e-14)


def test_what_is_symmetric_has_its_centre_on_the_axis() -> None:
    """Exactly: a coordinate of the mass centre that is zero is no parameter."""
    assert polygon(1.0, [-0.1 - 0.3j, 0.1 - 0.3j, 0.1 + 0.3j, -0.1 + 0.3j]).com == 0j
    assert polygon(1.0, [0j, 0.7 - 0.1j, 0.7 + 0.1j]).com.imag == 0.0


@pytest.mark.sample(2)
@pytest.mark.parametrize("seed", range(5))
def test_a_random_star_by_integrals(seed: int) -> None:
    """Triangles from the centre to each edge, each integrated symbolically over its two parameters, add up to it."""
    draw = random.Random(seed)
    count = draw.randint(5, 9)
    places = [
        (Fraction(round(1000 * r * math.cos(w)), 1000), Fraction(round(1000 * r * math.sin(w)), 1000))
        for k in range(count)
        for r, w in [(draw.uniform(0.2, 2.0), 2 * math.pi * (k + draw.uniform(-0.3, 0.3)) / count)]
    ]
    s, r = sp.symbols("s r")
    area, first, second = sp.Integer(0), [sp.Integer(0)] * 2, sp.Integer(0)
    for one, other in zip(places, [*places[1:], places[0]], strict=True):
        a, b = (sp.Matrix([sp.Rational(v.numerator, v.denominator) for v in p]) for p in (one, other))
        where = s * (a + r * (b - a))
        stretch = s * (a[0] * b[1] - a[1] * b[0])

        def over(integrand: sp.Expr, stretch: sp.Expr = stretch) -> sp.Expr:
            return sp.integrate(sp.expand(integrand * stretch), (s, 0, 1), (r, 0, 1))

        area += over(sp.Integer(1))
        first = [total + over(where[axis]) for axis, total in enumerate(first)]
        second += over(where.dot(where))
    centre = [total / area for total in first]
    about = second / area - centre[0] ** 2 - centre[1] ** 2
    corners = [complex(float(x), float(y)) for x, y in places]
    assert crossing_edges(corners) is None
    found = polygon(1.5, corners)
    assert polygon_area(corners) == pytest.approx(float(area), rel=1e-15)
    assert (found.com.real, found.com.imag) == pytest.approx(tuple(map(float, centre)), rel=1e-15, abs=1e-17)
    assert found.inertia == pytest.approx(1.5 * float(about), rel=1e-15)


def test_discs_and_rings() -> None:
    assert disc(2.0, 1j, 0.5) == Mass(2.0, 1j, 2.0 * 0.25 / 2)
    ring = disc(2.0, 0j, 0.5, 0.3)
    assert ring.inertia == pytest.approx(2.0 * (0.25 + 0.09) / 2, rel=1e-15)
    full, hole = 2.0 * 0.25 / 0.16, 2.0 * 0.09 / 0.16  # of the same density: the ring is a disc less a disc
    assert ring.inertia == pytest.approx(disc(full, 0j, 0.5).inertia - disc(hole, 0j, 0.3).inertia, rel=1e-14)


def test_several_bodies_by_parallel_axes() -> None:
    """Two halves of a rod are the rod, two rectangles the square that they make up."""
    whole = together([rod(1.0, 0j, 1 + 0j), rod(1.0, 1 + 0j, 2 + 0j)])
    assert (whole.mass, whole.com) == (2.0, 1 + 0j)
    assert whole.inertia == pytest.approx(rod(2.0, 0j, 2 + 0j).inertia, rel=1e-15)
    halves = [polygon(1.0, [0j, 2 + 0j, 2 + 1j, 1j]), polygon(1.0, [1j, 2 + 1j, 2 + 2j, 2j])]
    assert together(halves).inertia == pytest.approx(polygon(2.0, [0j, 2 + 0j, 2 + 2j, 2j]).inertia, rel=1e-15)
    assert together([point(1.0, -1j), point(3.0, 1j)]) == Mass(4.0, 0.5j, 3.0)


CROSSING: dict[str, tuple[list[complex], tuple[int, int] | None]] = {
    "a square": ([0j, 1 + 0j, 1 + 1j, 1j], None),
    "a dart": ([0j, 1 + 1j, 2 + 0j, 1 + 3j], None),
    "a corner in line": ([0j, 1 + 0j, 2 + 0j, 2 + 1j], None),
    "a bow tie": ([0j, 1 + 1j, 1 + 0j, 1j], (0, 2)),
    "a spike": ([0j, 2 + 0j, 1 + 0j, 1 + 1j], (0, 1)),
    "a spike at the first corner": ([1 + 0j, 2 + 0j, 2 + 1j, 0j, 3 + 0j], (0, 3)),
    "a triangle in line": ([0j, 1 + 0j, 2 + 0j], (0, 2)),
    "a corner twice in a row": ([0j, 1 + 0j, 1 + 0j, 1j], (1, 1)),
    "a corner that touches an edge": ([0j, 2 + 0j, 2 + 2j, 1 + 0j, 2j], (0, 2)),
    "a corner that lies on another": ([0j, 1 + 1j, 2 + 0j, 2 + 2j, 1 + 1j, 2j], (0, 3)),
    "a touch by one last place": ([0j, 0.1 + 0.3j, 1 + 0j, 1 + 1j, 0.1 + 0.30000000000000004j, 1j], None),
}


@pytest.mark.parametrize("case", CROSSING)
@pytest.mark.parametrize("scale", [1.0, 1e-150, 3e120])
def test_outlines_that_cross(case: str, scale: float) -> None:
    corners, edges = CROSSING[case]
    assert crossing_edges([scale * z for z in corners]) == edges
