"""What is said of starts that cannot be: the joint too many, the joint that may be open, the link that is not free."""

from __future__ import annotations

from typing import Any

import pytest

from ccgen.generator.scene import SceneError, load_scene

Table = dict[str, Any]


def rod(name: str, length: float, **more: Any) -> Table:
    return {"name": name, "rod": {"mass": 1.0}, "points": {"A": [0, 0], "B": [length, 0]}, **more}


def joint(name: str, one: str, other: str) -> Table:
    return {"name": name, "between": [one, other]}


GRIP: Table = {
    "ground_link": {"points": {"O": [0, 0], "Q": [1, 0]}},
    "link": [rod("a", 0.5), rod("b", -0.5)],
    "joint": [joint("ja", "ground.O", "a.A"), joint("jb", "ground.Q", "b.A"), joint("grip", "a.B", "b.B")],
    "start": {"angles": {"a": 0, "b": 0}, "angular_velocities": {"a": 1, "b": 2}},
}
CHANGES: Table = {
    "release": [{"joint": "grip", "when": {"distance": ["a.B", "ground.Q"], "above": 1}}],
    "hold": [{"joint": "grip"}],
}


def fault(scene: Table) -> str:
    with pytest.raises(SceneError) as caught:
        load_scene(scene)
    return str(caught.value)


def test_a_joint_that_takes_hold_may_be_open() -> None:
    """Where speeds open it; as it says, such a scene begins."""
    told = 'write open = ["grip"] in [start] where grip is not to hold yet'
    assert told not in fault(GRIP)
    assert told in fault(GRIP | CHANGES)
    assert load_scene(GRIP | CHANGES | {"start": GRIP["start"] | {"open": ["grip"]}}).changes


def test_a_joint_too_many_is_counted() -> None:
    """Three rods on a plane ground, joined by one joint more than they have freedoms for; a loop that is too wide has
    no joint too many."""
    links = [rod("a", 0.5), rod("b", 0.9)]
    wide = {
        "ground_link": {"points": {"O": [0, 0], "Q": [1, 0], "R": [2, 2]}},
        "link": links,
        "joint": [joint("ja", "ground.O", "a.A"), joint("jb", "ground.Q", "b.A"), joint("jab", "a.B", "b.B")],
    }
    assert load_scene(wide).mechanism.freedoms() == 0
    many = fault(wide | {"joint": [*wide["joint"], joint("jr", "ground.R", "b.B")]})
    assert "by Grübler's count the mechanism has -2 degrees of freedom" in many
    too_wide = wide | {"ground_link": {"points": {"O": [0, 0], "Q": [3, 0]}}}
    assert "no way to close the loop" in fault(too_wide)
    assert "Grübler" not in fault(too_wide)


@pytest.mark.parametrize(("free", "missing"), [(0, 1), (1, 0)])
def test_the_link_that_is_not_free_is_named(free: int, missing: int) -> None:
    """Of two that nothing holds, whichever of them is said to be free."""
    links = [rod("a", 1.0), rod("b", 1.0)]
    links[free]["free"] = True
    told = fault({"link": links})
    assert f"link[{missing}]: found no joints that hold {'ab'[missing]}, and no free = true, which others have" in told
    assert f"or free = true to {'ab'[missing]}" in told
    links[missing]["free"] = True
    assert load_scene({"link": links}).mechanism.own_links == 2
