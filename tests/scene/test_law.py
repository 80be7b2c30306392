"""The law of impact is one for a scene, named in [run], or at contacts as in older scenes; two laws are refused."""

from __future__ import annotations

import tomllib
from typing import Any

import pytest

from ccgen.generator import chain, loop, pinned
from ccgen.generator.effect_base.contact import LAWS
from ccgen.generator.package.data import model_data
from ccgen.generator.pipeline import derive_scene
from ccgen.generator.scene import Scene, SceneError, load_scene, read_tables
from ccgen.generator.scene.read import MODELS

BALLS = """\
[chain]
links = 2
[start]
height = 1.0
[[ground]]
restitution = 0.5
friction = 0.3
{ground}
[[ground]]
point = [0, -1]
restitution = 0.7
{below}
[[touch]]
between = ["link_0.A", "link_1.B"]
radius = 0.1
restitution = 0.4
{touch}
[run]
{run}
"""
"""Every table that can name a law."""
EVERYWHERE = {"ground": "ground[0].law", "below": "ground[1].law", "touch": "touch[0].law", "run": "run.law"}
LINES = {"ground": 8, "below": 12, "touch": 17, "run": 19}


def written(**laws: str) -> str:
    """The scene with these laws."""
    return BALLS.format(**{place: f'law = "{laws[place]}"' if place in laws else "" for place in EVERYWHERE})


def scene(**laws: str) -> Scene:
    return read_tables(tomllib.loads(written(**laws)), "balls", "balls")


def test_tables_that_name_it() -> None:
    assert {kind for kind, model in MODELS.items() if "law" in model.model_fields} == {
        "run",
        "ground",
        "touch",
        "journal",
        "cam",
        "rope",
    }


def test_newtons_where_none_is_named() -> None:
    assert scene().run.law == "newton"
    assert scene().canonical() == scene(run="newton").canonical()


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("place", EVERYWHERE)
def test_one_name_anywhere_is_the_law_of_all(law: str, place: str) -> None:
    """The same scene, and so the same model, as where [run] says it."""
    assert scene(**{place: law}).run.law == law
    assert scene(**{place: law}) == scene(run=law)
    assert scene(**{place: law}).canonical() == scene(run=law).canonical()


@pytest.mark.parametrize("law", LAWS)
def test_the_same_name_in_several_places_is_no_fault(law: str) -> None:
    assert scene(**dict.fromkeys(EVERYWHERE, law)) == scene(run=law)


def test_models_of_other_laws_are_others() -> None:
    assert len({scene(run=law).canonical() for law in LAWS}) == len(LAWS)


def test_old_and_new_scenes_give_the_same_model_data() -> None:
    """Which differ by the law in the law alone."""
    derived = derive_scene(scene())
    for law in LAWS:
        new, old = (model_data(scene(**{place: law}), *derived, "0", 1) for place in ("run", "below"))
        assert new == old and new["law"] == law
        assert {key for key, value in model_data(scene(), *derived, "0", 1).items() if value != new[key]} <= {"law"}


@pytest.mark.parametrize("law", LAWS)
def test_from_python(law: str) -> None:
    for made in (loop(4, run={"law": law}), chain(2, run={"law": law}), pinned(3, run={"law": law})):
        assert made.run.law == law
    ground: list[dict[str, Any]] = [{"restitution": 0.5}]
    old = loop(4, start={"height": 1.0}, ground=[{**ground[0], "law": law}])
    assert loop(4, start={"height": 1.0}, ground=ground, run={"law": law}) == old


# the laws, the key of the fault, and what was found
DISAGREE: dict[str, tuple[dict[str, str], str, str]] = {
    "two grounds": (
        {"ground": "newton", "below": "stronge"},
        "below",
        '"newton" at ground[0].law, "stronge" at ground[1].law',
    ),
    "the first of the list comes last": (
        {"ground": "stronge", "below": "newton"},
        "below",
        '"stronge" at ground[0].law, "newton" at ground[1].law',
    ),
    "a ground and the run": (
        {"ground": "newton", "run": "poisson"},
        "ground",
        '"poisson" at run.law, "newton" at ground[0].law',
    ),
    "a touch and a ground": (
        {"below": "poisson", "touch": "stronge"},
        "touch",
        '"poisson" at ground[1].law, "stronge" at touch[0].law',
    ),
    "one of four": (
        {"ground": "poisson", "below": "poisson", "touch": "newton", "run": "poisson"},
        "touch",
        '"poisson" at run.law and ground[0].law and ground[1].law, "newton" at touch[0].law',
    ),
    "three laws": (
        {"ground": "stronge", "below": "poisson", "touch": "stronge", "run": "newton"},
        "ground",
        '"newton" at run.law, "stronge" at ground[0].law and touch[0].law, "poisson" at ground[1].law',
    ),
}


@pytest.mark.parametrize("case", DISAGREE)
def test_laws_that_differ_are_refused(case: str, tmp_path: Any) -> None:
    """One fault with the file, its line, every key and the law found there, and what to do."""
    laws, place, found = DISAGREE[case]
    file = tmp_path / "balls.toml"
    file.write_text(written(**laws))
    with pytest.raises(SceneError) as caught:
        load_scene(file)
    said = f"found {found}, expected one law for all impacts; write it once, as law in [run]"
    assert [str(fault) for fault in caught.value.faults] == [f"{file}:{LINES[place]}: {EVERYWHERE[place]}: {said}"]


@pytest.mark.parametrize("value", ["hooke", "Newton", "", 1, ["newton"]])
def test_a_wrong_name_in_the_run(value: object) -> None:
    with pytest.raises(SceneError) as caught:
        loop(4, run={"law": value})
    (fault,) = caught.value.faults
    assert fault.key == "run.law"
    names = f"{', '.join(LAWS[:-1])} or {LAWS[-1]}"
    assert fault.message.endswith(f", expected the law of all impacts: {names}; correct it")
