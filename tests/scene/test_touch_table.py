"""What is wrong in a ``[[touch]]``: every fault with its key, what was found, and what to do."""

from __future__ import annotations

import pytest

from ccgen.generator.effects.touch import Touch
from ccgen.generator.scene import SceneError

from ..support.outline_scenes import box_on_ramp
from ..support.touching_scenes import cradle, disc_on_plank
from ..support.workshop import Workshop

PAIR = cradle(2, 0.0)
PLANK = disc_on_plank(0.3, 0.2, "restitution = 0.0\nfriction = 0.5")
BALLS = 'between = ["ball_0.C", "ball_1.C"]'
ROLLING = 'between = ["disc.C", "plank"]'
BAD: dict[str, tuple[str, str, str, str, tuple[str, ...]]] = {
    "no such point": (PAIR, BALLS, 'between = ["ball_0.X", "ball_1.C"]', "touch[0].between[0]", ('"ball_0.X"', "H, C")),
    "no such link": (
        PAIR,
        BALLS,
        'between = ["ball_0.C", "ball_7"]',
        "touch[0].between[1]",
        ('"ball_7"', "expected a joint or link.point", "the joints are"),
    ),
    "one link": (
        PAIR,
        BALLS,
        'between = ["ball_0.C", "ball_0.H"]',
        "touch[0].between",
        ("two places on ball_0", "on two links"),
    ),
    "a pin on both": (PAIR, BALLS, 'between = ["hook_0", "ball_0.C"]', "touch[0].between", ("two places on ball_0",)),
    "ground on ground": (PAIR, BALLS, 'between = ["ground.P0", "ground.P1"]', "touch[0].between", ("on ground",)),
    "three": (
        PAIR,
        BALLS,
        'between = ["ball_0.C", "ball_1.C", "ball_1.H"]',
        "touch[0].between",
        ("expected a disc's centre", "write 2 values"),
    ),
    "edge first": (
        PLANK,
        ROLLING,
        'between = [["plank.A", "plank.B"], "disc.C"]',
        "touch[0].between[0]",
        ('["plank.A", "plank.B"]', "second place"),
    ),
    "no edge": (
        PLANK,
        ROLLING,
        'between = ["plank.A", "disc"]',
        "touch[0].between[1]",
        ('"disc"', "it has the points disc.C; name two"),
    ),
    "edge of two links": (
        PLANK,
        ROLLING,
        'between = ["disc.C", ["plank.A", "ground.Q"]]',
        "touch[0].between[1]",
        ("two points of one link", "they are on different links"),
    ),
    "edge without length": (
        PLANK,
        ROLLING,
        'between = ["disc.C", ["plank.A", "plank.A"]]',
        "touch[0].between[1]",
        ("at the same place", "an edge has a direction"),
    ),
    "unknown end": (
        PLANK,
        ROLLING,
        'between = ["disc.C", ["plank.A", "plank.Z"]]',
        "touch[0].between[1]",
        ("plank.Z: plank has the points A, B",),
    ),
    "no radius": (PAIR, "radius = 0.25", "", "touch[0].radius", ("missing", "expected the radius")),
    "radius zero": (PAIR, "radius = 0.25", "radius = 0", "touch[0].radius", ("with the sum 0", "positive", "give one")),
    "edge alone": (PLANK, "radius = [0.1, 0.02]", "radius = [0, 0]", "touch[0].radius", ("with the sum 0",)),
    "negative radius": (PAIR, "radius = 0.25", "radius = -0.2", "touch[0].radius", ("found -0.2", "not negative")),
    "negative in a list": (PAIR, "radius = 0.25", "radius = [1, -2]", "touch[0].radius[1]", ("found -2",)),
    "three radii": (PAIR, "radius = 0.25", "radius = [1, 2, 3]", "touch[0].radius", ("write 2 values",)),
    "restitution": (PAIR, "restitution = 1.0", "restitution = 1.5", "touch[0].restitution", ("from 0 to 1",)),
    "friction": (PLANK, "friction = 0.5", "friction = -1.0", "touch[0].friction", ("found -1", "positive")),
    "law": (PAIR, "restitution = 1.0", 'restitution = 1.0\nlaw = "hooke"', "touch[0].law", ("newton, poisson",)),
    "unknown key": (PAIR, "radius = 0.25", "radius = 0.25\nradii = 1", "touch[0].radii", ("unknown key", "radius")),
    "start inside": (PAIR, "radius = 0.25", "radius = 0.26", "touch[0]", ("ball_0.C inside ball_1.C by", "radii")),
    "start inside aloft": (
        "[chain]\nlinks = 3\n[start]\nheight = 3.0\nangles = [0, 2.0, -2.0]\n"
        '[[touch]]\nbetween = ["link_0.A", "link_2.B"]\nradius = 0.1\nrestitution = 0\n',
        "radius = 0.1",
        "radius = 0.7",
        "touch[0]",
        ("link_0.A inside link_2.B by",),
    ),
    "start in the edge": (
        PLANK,
        "radius = [0.1, 0.02]",
        "radius = [0.1, 0.03]",
        "touch[0]",
        ("disc.C inside plank by 0.01 m",),
    ),
}


BOX = box_on_ramp(0.3, 0.5)
RING = '["box.A", "box.B", "box.D", "box.E", "box.A"]'
BAD |= {
    "two corners": (BOX, RING, '["box.A", "box.B", "box.A"]', "touch[0].between[0]", ("three corners or more",)),
    "edges that cross": (
        BOX,
        RING,
        '["box.A", "box.D", "box.B", "box.E", "box.A"]',
        "touch[0].between[0]",
        ("round a polygon", "the edges box.A-box.D and box.B-box.E cross"),
    ),
    "line that crosses": (
        BOX,
        RING,
        '["box.A", "box.D", "box.B", "box.E"]',
        "touch[0].between[0]",
        ("the edges box.A-box.D and box.B-box.E cross",),
    ),
    "corner twice": (
        BOX,
        RING,
        '["box.A", "box.A", "box.B", "box.D"]',
        "touch[0].between[0]",
        ("the edge box.A-box.A has no length",),
    ),
    "corner that is none": (BOX, '"box.D", ', '"box.Z", ', "touch[0].between[0]", ("box.Z: box has the points C, A",)),
    "corners of two links": (BOX, '"box.D", ', '"ground.O", ', "touch[0].between[0]", ("on different links",)),
    "link with corners": (
        BOX,
        '["ground.O", "ground.Q", "ground.R", "ground.O"]',
        '"ground"',
        "touch[0].between[1]",
        ("it has the points ground.O, ground.Q, ground.R; list those that are its corners",),
    ),
    "disc behind a polygon": (
        BOX,
        '["ground.O", "ground.Q", "ground.R", "ground.O"]',
        '"ground.O"',
        "touch[0].between[1]",
        ('"ground.O"', "centre first; swap the sides"),
    ),
    "sharp polygons": (BOX, "radius = 0.01", "radius = 0", "touch[0].radius", ("with the sum 0", "positive")),
    "polygons of one link": (
        BOX,
        '["ground.O", "ground.Q", "ground.R", "ground.O"]',
        '["box.A", "box.B"]',
        "touch[0].between",
        ("two places on box", "on two links"),
    ),
    "polygon in a polygon": (BOX, "radius = 0.01", "radius = 0.011", "touch[0]", ("inside ground by 0.001 m", "radii")),
    "corner in a polygon": (
        BOX,
        "box = 0.3",
        "box = 0.6",
        "touch[0]",
        ("inside the polygon of ground", "two open lines"),
    ),
}
"""Of polygons."""


@pytest.mark.parametrize("case", BAD, ids=lambda case: case.replace(" ", "-"))
def test_faults_name_key_and_advice(case: str, workshop: Workshop) -> None:
    text, old, new, key, words = BAD[case]
    assert old in text
    with pytest.raises(SceneError) as caught:
        workshop.scene(
            text.replace(old, new).replace("ball_0 = -0.5", "ball_0 = 0.0" if "inside" in case else "ball_0 = -0.5")
        )
    (fault,) = caught.value.faults
    assert f" {key}: " in f" {fault}" and all(word in str(fault) for word in words), str(fault)


def test_all_faults_at_once(workshop: Workshop) -> None:
    wrong = PAIR.replace(BALLS, 'between = ["ball_0.X", ["ball_1.C", "ball_0.C"]]').replace(
        "radius = 0.25", "radius = 0"
    )
    with pytest.raises(SceneError) as caught:
        workshop.scene(wrong)
    assert [fault.key for fault in caught.value.faults] == [
        "touch[0].between[0]",
        "touch[0].between[1]",
        "touch[0].radius",
    ]


def test_edges_of_welded_links(workshop: Workshop) -> None:
    """A link with two points is an edge also where others are welded to it, or it to others, even with like names."""
    welds = "".join(
        f'[[link]]\nname = "{name}"\nmass = 0.1\ninertia = 0.01\ncom = [0, 0]\npoints = {{ P = [0, 0]{more} }}\n'
        f'[[joint]]\ntype = "weld"\nbetween = ["{to}", "{name}.P"]\n'
        for name, more, to in (
            ("nub", ", R = [0, 0.3]", "plank.B"),
            ("nub_end", "", "nub.R"),
            ("post", ", R = [0, 9]", "ground.O"),
        )
    )
    edges = ("plank", "nub", "ground", "post")
    touches = "".join(f'[[touch]]\nbetween = ["disc.C", "{edge}"]\nradius = 0.01\nrestitution = 0\n' for edge in edges)
    scene = workshop.scene(PLANK.replace("[[touch]]", welds + touches + "[[touch]]", 1))
    found = [(effect.pair.other.start, effect.pair.other.end) for effect in scene.effects if isinstance(effect, Touch)]
    names = [tuple(f"{scene.mechanism.link_name(end.link)}.{end.point}" for end in ends) for ends in found]
    assert names == [
        ("plank.A", "plank.B"),
        ("plank.nub_P", "plank.nub_R"),
        ("ground.O", "ground.Q"),
        ("ground.post_P", "ground.post_R"),
        ("plank.A", "plank.B"),
    ]


def test_a_joint_that_slides_is_a_place_of_its_second_link(workshop: Workshop) -> None:
    """A slider may touch a fixed disc, or an edge of what it slides on."""
    scene = workshop.scene(
        '[ground_link]\npoints = { O = [0, 0], Q = [1, 0], R = [1, 1] }\n[[link]]\nname = "car"\nmass = 1.0\n'
        'inertia = 0.1\ncom = [0, 0]\npoints = { C = [0, 0] }\n[[joint]]\nname = "rail"\ntype = "prismatic"\n'
        'between = ["ground.O", "car.C"]\naxis = [1, 0]\n'
        '[[touch]]\nbetween = ["rail", "ground.Q"]\nradius = 0.1\nrestitution = 0.5\n'
        '[[touch]]\nbetween = ["rail", ["ground.Q", "ground.R"]]\nradius = 0.1\nrestitution = 0.5\n'
    )
    assert [effect.pair.disc.start.link for effect in scene.effects] == [0, 0]
