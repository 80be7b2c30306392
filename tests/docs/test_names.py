"""Every name that a listing of a mechanism prints stands in the table of docs/theory.md, section 9."""

from __future__ import annotations

import re

import pytest

from ccgen.generator import load_scene
from ccgen.generator.pipeline import listing

from ..support.effect_examples import EXAMPLES, SCENE
from ..support.folders import ROOT
from ..support.outline_scenes import box_on_ramp
from ..support.touching_scenes import disc_on_plank
from ..support.workshop import Workshop

PLACES = {"k": r"(\d+|g)", "j": r"\d+", "l": r"\d+", "i": r"\d+", "B": r"\w+", "O": r"\w+", "e": r"\d+", "f": r"\d+"}
"""What stands for a place in the table's names: links, joints, a ground or contact, points."""
AXES = {"x": "[xyn]", "y": "[xyn]", "n": "[xyn]", "xx": "[xyn]{2}", "xy": "[xyn]{2}", "ly": r"\d+[xyn]", "we": r"w\d+"}
SCENES = (
    "falling-hexagon",
    "four-bar",
    "jansen-driven",
    "loose-slider-crank",
    "strandbeest",
    "flyer",
    "massless-coupler",
    "n-four-bar",
    "newtons-cradle",
    "open-chain",
    "quick-return",
    "slider-crank",
)
SLOTS = """\
name = "slots"
[ground_link]
points = { Q = [1, 0] }
[[link]]
name = "a"
mass = 1.0
inertia = 0.1
com = [0.5, 0.2]
points = { A = [1, 0.3], B = [0.5, 0.1] }
[[link]]
name = "b"
mass = 1.0
inertia = 0.1
com = [0.5, 0]
points = { A = [0, 0], B = [1, 0] }
[[link]]
name = "c"
mass = 1.0
inertia = 0.1
com = [0.5, 0]
points = { A = [0, 0], B = [1, 0] }
[[joint]]
type = "pin-in-slot"
axis = "20 deg"
between = ["b.A", "a.A"]
[[joint]]
type = "pin-in-slot"
axis = "50 deg"
between = ["c.A", "b.B"]
[[joint]]
type = "prismatic"
axis = [1, 1]
angle = 0.1
between = ["a.B", "c.A"]
[gravity]
g = 9.81
"""
"""Afloat: lines of the parent and of the link itself, a link that follows, a slot that is cut."""


def patterns() -> list[re.Pattern[str]]:
    """The names of the table as patterns."""
    text = (ROOT / "docs" / "theory.md").read_text()
    section = text[text.index("## 9. Names") : text.index("## 10. References")]
    cells = [line.split("|")[1] for line in section.splitlines() if line.startswith("| `")]
    names = [name for cell in cells for name in re.findall("`([^`]+)`", cell) if not name.startswith("_")]
    return [re.compile(_pattern(name)) for name in names]


def _pattern(name: str) -> str:
    first, *rest = name.split("_")
    return "_".join([first, *(PLACES.get(part) or AXES.get(part) or part for part in rest)])


def names(text: str) -> set[str]:
    """State, parameters and everything that is given a name in a listing."""
    state = re.findall(r"^[qu]: (.+)$", text, re.MULTILINE)
    found = {name for line in state for name in line.split(", ")}
    return found | set(re.findall(r"^([A-Za-z]\w*) = ", text, re.MULTILINE))


def unknown(text: str) -> list[str]:
    known = patterns()
    bare = {re.sub("(_fixed)?(_v)?$", "", name) for name in names(text)}
    return sorted(name for name in bare if not any(pattern.fullmatch(name) for pattern in known))


@pytest.mark.sample(5)
@pytest.mark.parametrize("scene", SCENES)
def test_every_name_is_in_the_table(scene: str) -> None:
    assert unknown(listing(load_scene(ROOT / "scenes" / f"{scene}.toml"))) == []


def test_every_name_of_slots_in_slots_is_in_the_table(workshop: Workshop) -> None:
    text = listing(workshop.scene(SLOTS))
    assert {"slide_0", "along_0_x", "Psi_1_x", "psi_1", "slid_0_x", "drift_1_x", "MR_2", "across_1_y"} <= names(text)
    assert unknown(text) == []


def test_every_name_of_links_that_touch_is_in_the_table(workshop: Workshop) -> None:
    text = listing(workshop.scene(disc_on_plank(0.3, 0.2, "restitution = 0.0\nfriction = 0.5")))
    assert {"span_touch_0", "inside_touch_0", "off_touch_0_x", "turn_touch_0", "rt_0_1", "ft_0"} <= names(text)
    assert unknown(text) == []


def test_every_name_of_ropes_and_journals_is_in_the_table(workshop: Workshop) -> None:
    text = listing(
        workshop.scene(
            SCENE
            + EXAMPLES["rope"]
            + EXAMPLES["rope"].replace('["link_1.B"]', "[]").replace("length = 4\n", "")
            + EXAMPLES["rope"].replace('["link_1.B"]', '["link_1.A", "link_1.B"]').replace("4", "9")
            + EXAMPLES["journal"]
            + EXAMPLES["journal"].replace('["link_0.A", "link_0.B"]', '"ground.O"').replace("2.5", "9.0")
        )
    )
    assert {"fixed_rope_2", "span_rope_0_1", "pull_rope_1_x", "L_rope_1", "e_rope_0"} <= names(text)
    assert {"inside_journal_0", "off_journal_0_x", "tangent_journal_1_x", "along_journal_0", "f_journal_0"} <= names(
        text
    )
    assert unknown(text) == []


def test_every_name_of_polygons_that_touch_is_in_the_table(workshop: Workshop) -> None:
    text = listing(workshop.scene(box_on_ramp(0.3, 0.5)))
    assert {"span_touch_0_1_2", "least_foot_touch_0_3_1_x", "turn_touch_0_0", "start_touch_0_0_1_x"} <= names(text)
    assert unknown(text) == []


def test_a_name_that_is_not_in_the_table_is_found() -> None:
    assert unknown("strange_0_x = 1\nPhi_0_xx = 2\nPhi_0_xx_fixed = 2\nrs_g_3_x = 1\n") == ["strange_0_x"]


def test_every_name_of_cams_is_in_the_table(workshop: Workshop) -> None:
    face = EXAMPLES["cam"].replace('follower = "link_2.B"', 'follower = ["link_2.A", "link_2.B"]')
    face = face.replace("radius = 0.01\n", "").replace("[{ to", '[{ to = "1 deg" }, { to')
    waves = EXAMPLES["cam"].partition("lift = ")[0] + 'lift = "0.01*cos(angle) + 0.001*exp(sin(2*angle))"\n'
    text = listing(workshop.scene(SCENE + EXAMPLES["cam"] + face + waves))
    assert {"from_cam_0_1", "lever_cam_0", "aside_cam_1", "part_cam_2_0_1", "b_cam_0", "l_cam_0_0"} <= names(text)
    assert unknown(text) == []
