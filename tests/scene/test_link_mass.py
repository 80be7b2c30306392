"""Links that say what they are made of: mass, mass centre and inertia follow; what is wrong with that is told."""

from __future__ import annotations

import math
from typing import Any

import pytest

from ccgen.generator.mechanism.links import Link
from ccgen.generator.scene import SceneError, load_scene, read_tables

from ..support.folders import ROOT

TWO, THREE, ONE = {"A": [0, 0], "B": [0.5, 0]}, {"A": [0, 0], "B": [0.6, 0], "C": [0.6, 0.3]}, {"hub": [0.1, 0.2]}


def scene_of(points: dict[str, Any], bodies: dict[str, Any]) -> Any:
    link = {"name": "body", "points": points, **bodies}
    joint = {"between": ["ground.O", f"body.{next(iter(points))}"]}
    tables = {"ground_link": {"points": {"O": [0, 0]}}, "link": [link], "joint": [joint]}
    return read_tables(tables, "scene", "scene")


def link_of(points: dict[str, Any], bodies: dict[str, Any]) -> Link:
    link: Link = scene_of(points, bodies).mechanism.links[0]
    return link


# points, bodies, and mass, mass centre, inertia by closed forms
RIGHT: dict[str, tuple[dict[str, Any], dict[str, Any], tuple[float, tuple[float, float], float]]] = {
    "a rod": (TWO, {"rod": {"mass": 2}}, (2, (0.25, 0), 2 * 0.25 / 12)),
    "a rod by its length": (TWO, {"rod": {"mass_per_length": "3 kg/m"}}, (1.5, (0.25, 0), 1.5 * 0.25 / 12)),
    "a rod between two of three": (
        THREE,
        {"rod": {"mass": 2, "between": ["B", "C"]}},
        (2, (0.6, 0.15), 2 * 0.09 / 12),
    ),
    "a rod beyond its points": (
        TWO,
        {"rod": {"mass": 2, "between": [["-10 cm", 0], "B"]}},
        (2, (0.2, 0), 2 * 0.36 / 12),
    ),
    "a bar of steel": (
        TWO,
        {"rod": {"density": "7.85 g/cm^3", "width": "20 mm", "thickness": "5 mm"}},
        (0.3925, (0.25, 0), 0.3925 * (0.25 + 0.0004) / 12),
    ),
    "a mass centre at a point": (
        ONE,
        {"mass": 2, "inertia": 0.3, "com": "hub"},
        (2, (0.1, 0.2), 0.3),
    ),
    "a right triangle": (
        THREE,  # legs of 0.6 and 0.3 m: m (a² + b²)/18
        {"plate": {"mass": 2}},
        (2, (0.4, 0.1), 2 * (0.36 + 0.09) / 18),
    ),
    "a rectangle by its density": (
        ONE,
        {"plate": {"density": 1000, "thickness": 0.01, "corners": [[0, 0], [2, 0], [2, 1], [0, 1]]}},
        (20, (1, 0.5), 20 * (4 + 1) / 12),
    ),
    "a rectangle by its mass per area, clockwise": (
        ONE,
        {"plate": {"mass_per_area": 10, "corners": [[0, 1], [2, 1], [2, 0], [0, 0]]}},
        (20, (1, 0.5), 20 * (4 + 1) / 12),
    ),
    "a disc about its only point": (ONE, {"disc": {"mass": 2, "radius": "10 cm"}}, (2, (0.1, 0.2), 2 * 0.01 / 2)),
    "a ring": (
        TWO,
        {"disc": {"mass_per_area": 3, "radius": 0.2, "inner_radius": 0.1, "centre": [0, 0]}},
        (3 * math.pi * 0.03, (0, 0), 3 * math.pi * 0.03 * 0.05 / 2),
    ),
    "two rods in line, each half": (
        TWO,
        {"rod": [{"mass": 1, "between": ["A", [0.25, 0]]}, {"mass": 1, "between": [[0.25, 0], "B"]}]},
        (2, (0.25, 0), 2 * 0.25 / 12),
    ),
    "a pendulum: rod and disc": (
        TWO,
        {"rod": {"mass": 1}, "disc": {"mass": 3, "radius": 0.1, "centre": "B"}},
        (4, (0.4375, 0), 0.25 / 12 + 3 * 0.005 + 0.75 * 0.0625),
    ),
    "two points": (
        TWO,
        {"point_mass": [{"mass": 1, "at": "A"}, {"mass": 3, "at": "B"}]},
        (4, (0.375, 0), 0.75 * 0.25),
    ),
}


@pytest.mark.parametrize("case", RIGHT)
def test_mass_follows_from_bodies(case: str) -> None:
    points, bodies, (mass, com, inertia) = RIGHT[case]
    link = link_of(points, bodies)
    assert link.mass and link.inertia
    assert (link.mass.value, link.inertia.value) == (pytest.approx(mass, rel=1e-14), pytest.approx(inertia, rel=1e-14))
    assert link.com.values() == pytest.approx(com, rel=1e-14, abs=0)
    assert (link.mass.path, link.inertia.path) == ("body.mass", "body.inertia")


def test_a_point_mass_alone_has_no_inertia() -> None:
    link = link_of(TWO, {"point_mass": {"mass": 2, "at": "B"}})
    assert link.mass and link.inertia is None and link.com.values() == (0.5, 0.0)


def test_lengths_stay_parameters_of_their_own() -> None:
    """Nothing but the numbers of the scene comes from the body: the record is that of a scene in numbers."""
    rod = scene_of(TWO, {"rod": {"mass": 2}})
    numbers = scene_of(TWO, {"mass": 2, "inertia": 2 * 0.25 / 12, "com": [0.25, 0]})
    assert rod == numbers and rod.canonical() == numbers.canonical()


def test_links_of_shipped_scenes_as_rods() -> None:
    """Of scenes/four-bar.toml crank and rocker are rods, to the last digit."""
    shipped = load_scene(ROOT / "scenes" / "four-bar.toml").mechanism.links
    for index, length, mass in ((0, 0.2, 0.4), (2, 0.5, 1.0)):
        rod = link_of({"A": [0, 0], "B": [length, 0]}, {"rod": {"mass": mass}})
        assert rod.inertia and shipped[index].inertia
        assert (rod.inertia.value, rod.com.values()) == (shipped[index].inertia.value, shipped[index].com.values())


FLAT = {"A": [0, 0], "B": [1, 0], "C": [1, 1], "D": [0, 1]}
# points, bodies, and all that is told: key below the link, words
WRONG: dict[str, tuple[dict[str, Any], dict[str, Any], dict[str, str]]] = {
    "nothing": (
        TWO,
        {},
        {
            "mass": "missing, expected the mass in kg, a positive number, or 0 for a link without mass; add it, or a",
            "inertia": "rod = { mass = ... }, plate, disc or point_mass",
            "com": "missing, expected the centre of mass",
        },
    ),
    "mass beside a rod": (
        TWO,
        {"rod": {"mass": 1}, "mass": 1, "inertia": 1, "com": [0, 0]},
        {
            "mass": "found mass beside rod, expected no mass, because that follows from the rod; remove it, or write "
            'point_mass = { mass = ..., at = "A" }',
            "inertia": "found inertia beside rod, expected no inertia, because that follows from the rod; remove it",
            "com": "found com beside rod",
        },
    ),
    "a rod without mass": (
        TWO,
        {"rod": {}},
        {"rod": "found no mass, expected one of mass, mass_per_length, mass_per_area, density; add one"},
    ),
    "a mass in two ways": (
        TWO,
        {"rod": {"mass": 1, "mass_per_length": 2}},
        {"rod.mass_per_length": "found mass_per_length beside mass, expected one of"},
    ),
    "a rod of three points": (
        THREE,
        {"rod": {"mass": 1}},
        {"rod.between": "missing, expected the two ends of the rod, because the link has 3 points: A, B, C; add"},
    ),
    "a rod of one point": (ONE, {"rod": {"mass": 1}}, {"rod.between": "because the link has 1 point: hub"}),
    "a rod without length": (
        {"A": [0, 0], "B": [0, 0]},
        {"rod": {"mass": 1}},
        {"rod": "found A and B in one place, expected two ends of a rod"},
    ),
    "ends that are no points": (
        TWO,
        {"rod": {"mass": 1, "between": ["A", "Z"]}},
        {"rod.between[1]": 'found "Z", expected a point of the link: A, B, or [x, y] in m'},
    ),
    "a mass centre that is no point": (
        TWO,
        {"mass": 1, "inertia": 1, "com": "Z"},
        {"com": 'found "Z", expected a point of the link: A, B, or [x, y] in m; correct the name or add the point'},
    ),
    "a mass centre that is a number": (TWO, {"mass": 1, "inertia": 1, "com": 0.5}, {"com": "found 0.5, expected the"}),
    "three ends": (TWO, {"rod": {"mass": 1, "between": ["A", "B", "A"]}}, {"rod.between": "write 2 values"}),
    "a number for a rod": (TWO, {"rod": 0.4}, {"rod": "found 0.4, expected a uniform rod between two points, { mass"}),
    "no rods": (TWO, {"rod": []}, {"rod": "found [], expected a uniform rod"}),
    "a density without thickness and width": (
        TWO,
        {"rod": {"density": 7850}},
        {
            "rod.thickness": "missing, expected how thick the body is across the plane in m, because a",
            "rod.width": "missing, expected how wide the rod is in the plane in m, because density is given",
        },
    ),
    "a thickness without density": (
        ONE,
        {"disc": {"mass": 1, "radius": 1, "thickness": 1}},
        {"disc.thickness": "found thickness without density, expected it only with one; remove it"},
    ),
    "an unknown key in a rod": (TWO, {"rod": {"masss": 1}}, {"rod.masss": "found an unknown key, expected one of"}),
    "a negative mass": (TWO, {"rod": {"mass": "-400 g"}}, {"rod.mass": 'found "-400 g" (-0.4), expected a mass in kg'}),
    "a length for a mass": (TWO, {"rod": {"mass": "2 m"}}, {"rod.mass": "that is a length, not a mass in kg"}),
    "a plate of two points": (
        TWO,
        {"plate": {"mass": 1}},
        {"plate.corners": "missing, expected at least three corners, because the link has 2 points: A, B; add them"},
    ),
    "two corners": (FLAT, {"plate": {"mass": 1, "corners": ["A", "B"]}}, {"plate.corners": "write 3 values"}),
    "a plate that crosses itself": (
        FLAT,
        {"plate": {"mass": 1, "corners": ["A", "B", "D", "C"]}},
        {"plate.corners": "found an outline whose edges B-D and C-A cross or touch, expected one"},
    ),
    "points that are no outline": (
        {**FLAT, "hub": [0.5, 0.5], "edge": [1, 0.2]},
        {"plate": {"mass": 1}},
        {"plate": "found an outline whose edges B-C and hub-edge cross or touch"},
    ),
    "a plate without area": (
        FLAT,
        {"plate": {"mass_per_area": 1, "corners": ["A", "B", [2, 0]]}},
        {
            "plate.corners": "found an outline whose edges A-B and [2, 0]-A cross or touch: the corners lie in a line, "
            'expected some beside it; write rod = { mass = ..., between = ["A", [2, 0]] } for a bar'
        },
    ),
    "a corner twice": (
        FLAT,
        {"plate": {"mass": 1, "corners": ["A", "B", "B", "C"]}},
        {"plate.corners": "found the corners B and B in one place, expected an outline; leave one of them out"},
    ),
    "a corner that is no point, and a mass that is none": (
        FLAT,
        {"plate": {"mass": "x", "corners": ["A", "B", "Z"]}},
        {"plate.mass": "x is not known here", "plate.corners[2]": 'found "Z", expected a point of'},
    ),
    "a disc without radius": (ONE, {"disc": {"mass": 1}}, {"disc.radius": "missing, expected the radius in m"}),
    "a disc of a link with two points": (
        TWO,
        {"disc": {"mass": 1, "radius": 1}},
        {"disc.centre": "missing, expected the centre of the disc, because the link has 2 points: A, B; add"},
    ),
    "a hole as large as its disc": (
        ONE,
        {"disc": {"mass": 1, "radius": 1, "inner_radius": 1}},
        {"disc.inner_radius": "found 1 m, expected less than the radius, 1 m"},
    ),
    "a point mass nowhere": (TWO, {"point_mass": {"mass": 1}}, {"point_mass.at": "missing, expected where it is"}),
    "a point mass at no point": (TWO, {"point_mass": {"mass": 1, "at": "Z"}}, {"point_mass.at": 'found "Z", expected'}),
    "keys of bodies at the link": (
        TWO,
        {"rod": {"mass": 1}, "length": 1, "density": 1, "radius": 1},
        {"length": "write rod = { mass = ... }", "density": "it is a plate's", "radius": "it is a disc's"},
    ),
    "too large": (
        {"A": [0, 0], "B": [1, 0]},
        {"rod": {"mass": 1e300, "width": 1e200}},
        {"rod": "found a mass of 1e+300 kg and an inertia of inf kg m², expected positive finite"},
    ),
    "too long": (
        {"A": [1e308, 1e308], "B": [-1e308, -1e308]},
        {"rod": {"mass_per_length": 1}},
        {"rod": "found a mass of inf kg"},
    ),
    "too wide": (
        {"A": [0, 0], "B": [1e200, 0], "C": [0, 1e200]},
        {"plate": {"mass_per_area": 1}},
        {"plate": "found a mass of inf kg"},
    ),
    "too far from each other": (
        {"A": [-1e200, 0], "B": [1e200, 0]},
        {"point_mass": [{"mass": 1, "at": "A"}, {"mass": 1, "at": "B"}]},
        {"point_mass": "found a mass of 2 kg and an inertia of inf kg m²"},
    ),
    "too small": (
        {"A": [0, 0], "B": [1e-200, 0]},
        {"rod": {"mass": 1}},
        {"rod": "found a mass of 1 kg and an inertia of 0 kg m², expected positive finite numbers"},
    ),
    "one of several": (
        TWO,
        {"rod": [{"mass": 1}, {"mass": 0}], "disc": [{"mass": 1, "radius": 1, "centre": "Z"}]},
        {"rod[1].mass": "found 0, expected a mass in kg, a positive number", "disc[0].centre": 'found "Z"'},
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_wrong_bodies(case: str) -> None:
    points, bodies, told = WRONG[case]
    with pytest.raises(SceneError) as caught:
        scene_of(points, bodies)
    assert {fault.key.removeprefix("link[0].") for fault in caught.value.faults} == told.keys(), str(caught.value)
    for fault in caught.value.faults:
        assert told[fault.key.removeprefix("link[0].")] in fault.message
        assert "\n" not in fault.message


def test_wrong_bodies_hide_nothing_else() -> None:
    link = {"name": "body", "points": TWO, "rod": {"mass": 1, "between": ["A", "Z"]}, "plate": {"masss": 1}}
    tables = {
        "ground_link": {"points": {"O": [0, 0]}},
        "link": [link],
        "joint": [{"between": ["ground.O", "body.A"]}, {"between": ["ground.O", "body.Q"]}],
        "torque": [{"link": "nix", "torque": 1}],
    }
    with pytest.raises(SceneError) as caught:
        read_tables(tables, "scene", "scene")
    assert {fault.key for fault in caught.value.faults} >= {
        "link[0].rod.between[1]", "link[0].plate.masss", "joint[1].between[1]",
    }  # fmt: skip
