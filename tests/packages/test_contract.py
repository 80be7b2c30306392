"""What generated models, the core and Python agree on is written once, or its copies are compared entry by entry."""

from __future__ import annotations

import re
from dataclasses import fields
from functools import cache
from pathlib import Path
from typing import get_args

import pytest

from ccgen.generator.compile import core_recipe
from ccgen.generator.effect_base.contact import Law
from ccgen.generator.package import parts
from ccgen.generator.write_c.precision import PRECISIONS
from ccgen.generator.write_c.render import Sizes
from ccgen.runtime import _core, methods
from ccgen.runtime.loading import package
from ccgen.runtime.model import forces
from ccgen.runtime.precision import CORES

from ..support.c_declarations import declared, enumerators, expanded, headers, members, normal, pointer, prototype
from ..support.folders import ROOT, RUNTIME
from ..support.written_models import Written

FACE = RUNTIME / "face" / "declarations.pxi"
CORE = RUNTIME / "core"


def test_sizes_are_those_of_the_contract() -> None:
    """And the generator gives them in the same order."""
    counts = [name for name, type_ in members(headers(), "ccgen_model").items() if type_ == "int"]
    assert counts == ["version", *(field.name for field in fields(Sizes)), "lanes"]


def test_a_model_with_everything_gives_every_member(tmp_path: Path) -> None:
    """Of a structure in which C sets what is not named to zero."""
    from ccgen.generator import load_scene

    file = tmp_path / "everything.toml"
    file.write_text(SCENE_WITH_EVERYTHING)
    setting = {key: [0] for key in ("stops_at", "value_of", "value_to", "value_within", "value_forgets")}
    setting |= {key: [0] for key in ("joint_of", "gate_of", "held_before", "change_by")} | {"limits": [0.0]}
    source, _ = Written(load_scene(file), tmp_path).source(
        "everything",
        {
            "partner": [0],
            "row_held": [-1],
            "driven": [0, -1],
            "latched_at": [0],
            "sides": [1],
            "directions": [0],
            "rated": [1],
            **setting,
        },
        derivatives=True,
    )
    descriptor = source.partition("const struct ccgen_model ")[2]
    assert sorted(re.findall(r"^    \.(\w+) = ", descriptor, re.M)) == sorted(members(headers(), "ccgen_model"))


SCENE_WITH_EVERYTHING = """
name = "everything"

[chain]
links = 2
hinged = true
length = 1.0
mass = 1.0
inertia = 0.1

[gravity]

[[ground]]
point = [0, -3]
restitution = 0.5
friction = 0.3

[[damper]]
between = ["ground.O", "link_1.B"]
damping = 0.1

[[event]]
when = "angle(joint_1)"
set = { "link_0.mass" = 2 }

[[compliant_ground]]
point = [0, -4]
load = 10
restitution = 0.5

[[drive]]
joint = "joint_0"
speed = 1.0

[[input]]
name = "push"
joint = "joint_1"

[[motor]]
joint = "joint_1"
angle = 0.5
stiffness = 3.0
limit = 1.0
"""


# -- what Cython is told of the core -----------------------------------------------------------------------------------


@cache
def face() -> str:
    """The declarations, with C's names of what they name."""
    text = re.sub(r"#.*|\bnogil\b|\bnoexcept\b", "", FACE.read_text())
    text = text.partition("OUTCOMES = ")[0]
    text = re.sub(r"\breal\b", "double", text)
    text = re.sub(r"\bbint\b", "int", text)
    return re.sub(r",[ \t]*\n\s+", ", ", text)


def face_types() -> dict[str, str]:
    """Named types of functions, and enumerations, which are whole numbers."""
    functions = re.findall(r"^ctypedef (.*)\(\*(\w+)\)\((.*)\)", face(), re.M)
    return {name: pointer(result, parameters) for result, name, parameters in functions}


def as_in_c(type_: str) -> str:
    """A type of the face with C's names: enumerations are whole numbers."""
    for name in re.findall(r"^    enum (\w+):", face(), re.M):
        type_ = re.sub(rf"\b{name}\b(?=.)|^{name}$", "int", type_)
    return expanded(type_, face_types())


def face_structures() -> dict[str, dict[str, str]]:
    found = re.findall(r"^    struct (\w+):\n((?:        .*\n)+)", face(), re.M)
    return {
        name: {
            member: as_in_c(type_)
            for line in body.splitlines()
            if line.strip() not in ("", "pass")
            for member, type_ in declared(line.strip())
        }
        for name, body in found
    }


@pytest.mark.parametrize("structure", sorted(face_structures()))
def test_structures_of_the_face_are_those_of_the_core(structure: str) -> None:
    """Each member that Cython is told of has the type that it has in C; one that it only clears may be any pointer."""
    core = members(headers(), structure)
    for name, type_ in face_structures()[structure].items():
        found = core[name]
        assert type_ == found or (type_ == "void *" and found.endswith("*")), name


def face_functions() -> dict[str, tuple[str, str]]:
    """Per function its name in C, and its type."""
    found = re.findall(r'^    ((?:[\w]+ )+\**)(\w+)(?: "(\w+)")?\(([^*].*)\)\s*$', face(), re.M)
    return {
        name: (in_c or name, as_in_c(pointer(as_in_c(normal(result)), ", ".join(map(as_in_c, parameters.split(","))))))
        for result, name, in_c, parameters in found
    }


@pytest.mark.parametrize("function", sorted(face_functions()))
def test_functions_of_the_face_are_those_of_the_core(function: str) -> None:
    name, type_ = face_functions()[function]
    assert type_ == prototype(headers(), name)


def test_the_checks_see_what_the_face_declares() -> None:
    assert len(face_functions()) > 20
    assert {"ccgen_model", "system", "run", "ccgen_settings"} <= face_structures().keys()
    assert len(face_structures()["ccgen_model"]) > 25


# -- enumerations ------------------------------------------------------------------------------------------------------


def listed(file: str, name: str) -> dict[str, tuple[str, ...]]:
    return enumerators(re.sub(r"/\*.*?\*/", "", (CORE / file).read_text(), flags=re.DOTALL), name)


def test_enumerations_are_read_from_the_core() -> None:
    """Names, numbers and order of each are those of its list in C."""
    outcomes = listed("base/outcome.h", "ALL_OUTCOMES")
    assert tuple(text for (text,) in outcomes.values()) == _core.OUTCOMES
    drifts = listed("record/run.h", "ALL_DRIFTS")
    assert tuple(text for (text,) in drifts.values()) == _core.DRIFTS
    modes = listed("constraints/active_set.h", "ALL_CONTACT_MODES")
    assert {int(number): text for number, text in modes.values()} == _core.MODES
    obstacles = listed("interface/forces.h", "ALL_OBSTACLES")
    assert tuple(text for (text,) in obstacles.values()) == _core.OBSTACLES
    assert tuple(listed("methods/all_methods.h", "ALL_METHODS")) == methods()
    gains = listed("record/run.h", "ALL_GAINS")
    assert tuple(text for (text,) in gains.values()) == _core.GAINS


def test_words_for_contacts_in_python_are_modes_of_the_core() -> None:
    assert {*forces.RUBS, "smooth", "touches", "carried"} == set(_core.MODES.values()) - {"apart"}


def test_laws_of_scenes_are_those_of_the_core() -> None:
    assert set(get_args(Law)) == set(listed("impact/all_laws.h", "ALL_LAWS"))


def test_precisions_are_those_of_the_runtime() -> None:
    """Each has a compiled core, by the recipe that setup.py follows too."""
    assert set(PRECISIONS) == set(CORES) == set(core_recipe.PRECISIONS) == set(core_recipe.MODULES)
    made = {core_recipe.MODULES[name]: number for name, number in core_recipe.PRECISIONS.items()}
    assert set(made) == set(CORES.values()) and "core_recipe" in (ROOT / "setup.py").read_text()
    face_header = (CORE / "interface" / "face.h").read_text()
    capsules = dict(re.findall(r'(?:CCGEN_PRECISION == (\d)|#else)\n#define CCGEN_CAPSULE "(.*)"', face_header))
    for name, precision in PRECISIONS.items():
        assert precision.capsule == capsules["" if precision.double else made[CORES[name]]]


def test_files_of_a_package_have_the_same_names_for_both() -> None:
    assert (package.RECORD, package.DATA) == (parts.RECORD, parts.DATA)
