"""Wrong scenes and options: a sentence with the place, exit code 2, nothing written. All faults of a file at once."""

from __future__ import annotations

from pathlib import Path

import pytest

from ccgen.generator.effect_base.contact import LAWS
from ccgen.generator.scene import SceneError, chain, load_scene, loop, pinned

from ..support.command_line import ccgen

THE_LAWS = f"{', '.join(LAWS[:-1])} or {LAWS[-1]}"
"""The laws of impact as faults name them, in the order of the generator's list."""

GOOD = """\
name = "good"
[loop]
links = 4
[start]
height = 1.0
[gravity]
g = 9.81
[[ground]]
restitution = 0.5
[run]
until = 1.0
"""

BARS = """\
[ground_link]
points = { O = [0, 0], Q = [1, 0] }
[[link]]
name = "crank"
mass = 1.0
inertia = 0.1
com = [0.5, 0]
points = { A = [0, 0], B = [1, 0] }
[[link]]
name = "rocker"
mass = 1.0
inertia = 0.1
com = [0.5, 0]
points = { A = [0, 0], B = [1, 0] }
[[joint]]
between = ["ground.O", "crank.A"]
[[joint]]
between = ["crank.B", "rocker.A"]
"""

SPARE = """\
[[link]]
name = "crank"
mass = 1.0
inertia = 0.1
com = [0.5, 0]
points = { A = [0, 0], B = [1, 0], O = [1, 1] }"""

# what is wrong: scene with one line replaced, old line, new line(s), line of the fault, its key, words of the message
CASES: dict[str, tuple[str, str, str, int, str, tuple[str, ...]]] = {
    "unknown key": (GOOD, "links = 4", "links = 4\nlenght = 1", 4, "loop.lenght", ("unknown key", 'write "length"')),
    "unknown table": (GOOD, "[run]", "[runs]", 10, "runs", ("unknown key", 'write "run"')),
    "wrong type": (GOOD, "g = 9.81", 'g = "fast"', 7, "gravity.g", ('found "fast"', "expected", "without quotes")),
    "not a whole number": (GOOD, "links = 4", "links = 4.0", 3, "loop.links", ("found 4.0", "whole number")),
    "true is no number": (GOOD, "g = 9.81", "g = true", 7, "gravity.g", ("found true", "finite number")),
    "zero links": (GOOD, "links = 4", "links = 0", 3, "loop.links", ("found 0", "a whole number from 1 to 2000")),
    "two links in a loop": (GOOD, "links = 4", "links = 2", 3, "loop.links", ("found 2", "at least 3")),
    "missing links": (
        GOOD,
        "links = 4",
        "mass = 1",
        2,
        "loop.links",
        ("missing", "a whole number from 1 to 2000", "add it"),
    ),
    "negative mass": (GOOD, "links = 4", "links = 4\nmass = -1", 4, "loop.mass", ("found -1", "positive number")),
    "zero mass": (GOOD, "links = 4", "links = 4\nmass = 0", 4, "loop.mass", ("found 0", "positive number")),
    "one negative mass": (
        GOOD,
        "links = 4",
        "links = 4\nmass = [\n1,\n-2,\n3, 4]",
        6,
        "loop.mass[1]",
        ("found -2", "positive number"),
    ),
    "negative inertia": (GOOD, "links = 4", "links = 4\ninertia = -1.0", 4, "loop.inertia", ("found -1", "positive")),
    "zero length": (GOOD, "links = 4", "links = 4\nlength = 0.0", 4, "loop.length", ("found 0", "positive number")),
    "length without inertia": (
        GOOD,
        "links = 4",
        "links = 4\nlength = 1e-200",
        2,
        "loop.inertia",
        ("positive finite",),
    ),
    "tilt of a pinned chain": (
        GOOD,
        "[loop]\nlinks = 4\n[start]\nheight = 1.0",
        "[pinned]\nlinks = 4\n[start]\ntilt = 0.1",
        5,
        "start.tilt",
        ("the ground holds", "remove it"),
    ),
    "list too short": (GOOD, "links = 4", "links = 4\nlength = [1, 1]", 4, "loop.length", ("found 2", "expected one")),
    "com of wrong shape": (
        GOOD,
        "links = 4",
        "links = 4\ncom = [[1, 2, 3]]",
        4,
        "loop.com[0]",
        ("[1, 2, 3]", "[x, y]"),
    ),
    "two numbers for com": (
        GOOD,
        "links = 4",
        "links = 4\ncom = [1, 2, 3]",
        4,
        "loop.com",
        ("found 3 values", "expected one or 4"),
    ),
    "loop that cannot close": (
        GOOD,
        "links = 4",
        "links = 4\nlength = [1, 1, 5, 1]",
        4,
        "loop.length",
        ("link_2", "misses by 2 m"),
    ),
    "nan": (GOOD, "g = 9.81", "g = nan", 7, "gravity.g", ("found nan", "finite number")),
    "infinite position": (
        GOOD,
        "height = 1.0",
        "position = [0, inf]",
        5,
        "start.position[1]",
        ("found inf", "[x, y] in m"),
    ),
    "no angle": (GOOD, "height = 1.0", 'tilt = "ten"', 5, "start.tilt", ('found "ten"', "10 deg")),
    "height and position": (
        GOOD,
        "height = 1.0",
        "height = 1.0\nposition = [0, 1]",
        5,
        "start.height",
        ("beside a position", "remove"),
    ),
    "too few angles": (GOOD, "height = 1.0", "angles = [1, 2]", 5, "start.angles", ("found 2 values", "expected 4")),
    "angle of no link": (
        GOOD,
        "height = 1.0",
        "angles = { link_9 = 1 }",
        5,
        "start.angles.link_9",
        ("unknown link", "link_0"),
    ),
    "start inside the ground": (
        GOOD,
        "height = 1.0",
        "height = -0.25",
        5,
        "start.height",
        ("joint_0 inside ground_0 by 0.25 m", "expected", "raise"),
    ),
    "start inside by position": (
        GOOD,
        "height = 1.0",
        "position = [0, -0.25]",
        8,
        "ground[0]",
        ("joint_0 inside ground_0 by 0.25 m",),
    ),
    "no restitution": (GOOD, "restitution = 0.5", "", 8, "ground[0].restitution", ("missing", "from 0 to 1")),
    "a law of impact that is none": (
        GOOD,
        "restitution = 0.5",
        'restitution = 0.5\nlaw = "keller"',
        10,
        "ground[0].law",
        ("keller", THE_LAWS),
    ),
    "restitution above one": (
        GOOD,
        "restitution = 0.5",
        "restitution = 1.5",
        9,
        "ground[0].restitution",
        ("found 1.5", "from 0 to 1"),
    ),
    "normal without direction": (
        GOOD,
        "restitution = 0.5",
        "restitution = 0.5\nnormal = [0, 0]",
        10,
        "ground[0].normal",
        ("not both zero",),
    ),
    "contact that is nothing": (
        GOOD,
        "restitution = 0.5",
        'restitution = 0.5\ncontacts = ["joint_0", "joint_9"]',
        10,
        "ground[0].contacts[1]",
        ("joint_9", "the joints are joint_0"),
    ),
    "contact with no such point": (
        GOOD,
        "restitution = 0.5",
        'restitution = 0.5\ncontacts = ["link_0.C"]',
        10,
        "ground[0].contacts[0]",
        ("link_0 has the points A, B",),
    ),
    "one ground table": (GOOD, "[[ground]]", "[ground]", 8, "ground", ("array of tables", "[[ground]]")),
    "run without end": (GOOD, "until = 1.0", "until = 0", 11, "run.until", ("found 0", "positive number")),
    "a law of all impacts that is none": (
        GOOD,
        "until = 1.0",
        'law = "keller"',
        11,
        "run.law",
        ('found "keller"', f"the law of all impacts: {THE_LAWS}", "correct it"),
    ),
    "two laws of impact": (
        GOOD,
        "restitution = 0.5\n[run]",
        'restitution = 0.5\nlaw = "newton"\n[run]\nlaw = "stronge"',
        10,
        "ground[0].law",
        ('found "stronge" at run.law, "newton" at ground[0].law', "expected one law", "as law in [run]"),
    ),
    "loose tolerance": (GOOD, "until = 1.0", "rtol = 2.0", 11, "run.rtol", ("found 2", "between 0 and 1")),
    "name that is no name": (GOOD, 'name = "good"', 'name = "6 bars"', 1, "name", ('"6 bars"', "letters")),
    "name of Python": (GOOD, 'name = "good"', 'name = "class"', 1, "name", ('"class"', "change it")),
    "two forms": (GOOD, "[gravity]", "[chain]\nlinks = 2\n[gravity]", 6, "chain", ("beside [loop]", "remove one")),
    "joint without link": (
        GOOD,
        "[gravity]",
        '[[joint]]\nbetween = ["a.A", "b.B"]\n[gravity]',
        6,
        "joint",
        ("[[link]]",),
    ),
    "twice the same key": (
        GOOD,
        "links = 4",
        "links = 4\nlinks = 5",
        4,
        "loop.links",
        ("found a second time", "line 3 has it too"),
    ),
    "a table twice": (GOOD, "[run]", "[run]\nrtol = 1e-8\n[run]", 12, "run", ("found a second time", "line 10 has")),
    "no TOML": (GOOD, "links = 4", "links 4", 3, "", ("no valid TOML", "write KEY = VALUE")),
    "unknown link": (
        BARS,
        'between = ["crank.B", "rocker.A"]',
        'between = ["crank.B", "rod.A"]',
        18,
        "joint[1].between[1]",
        ('there is no link "rod"', "crank, rocker, ground"),
    ),
    "unknown point": (
        BARS,
        'between = ["crank.B", "rocker.A"]',
        'between = ["crank.C", "rocker.A"]',
        18,
        "joint[1].between[0]",
        ("expected a point of crank: A, B",),
    ),
    "no point": (
        BARS,
        'between = ["crank.B", "rocker.A"]',
        'between = ["crank", "rocker.A"]',
        18,
        "joint[1].between[0]",
        ('expected "link.point"',),
    ),
    "joint with itself": (
        BARS,
        'between = ["crank.B", "rocker.A"]',
        'between = ["crank.B", "crank.A"]',
        18,
        "joint[1].between",
        ("expected points of two links",),
    ),
    "duplicate link": (BARS, "[[joint]]", f"{SPARE}\n[[joint]]", 16, "link[2].name", ("a second time", "rename")),
    "duplicate joint": (
        BARS,
        'between = ["crank.B", "rocker.A"]',
        'name = "joint_0"\nbetween = ["crank.B", "rocker.A"]',
        18,
        "joint[1].name",
        ("a second time", "rename"),
    ),
    "link called ground": (
        BARS,
        "[[joint]]",
        SPARE.replace("crank", "ground") + "\n[[joint]]",
        16,
        "link[2].name",
        ("[ground_link]",),
    ),
    "point with a dash": (BARS, "O = [0, 0],", "O = [0, 0], a-b = [1, 1],", 2, "ground_link.points.a-b", ("letters",)),
    "link not connected": (
        BARS,
        '[[joint]]\nbetween = ["crank.B", "rocker.A"]\n',
        "",
        9,
        "link[1]",
        ("connect rocker with the ground", "add a [[joint]]"),
    ),
    "jointed points in one place": (
        BARS,
        "points = { A = [0, 0], B = [1, 0] }\n[[link]]",
        "points = { A = [0, 0], B = [0, 0] }\n[[link]]",
        8,
        "link[0].points",
        ("A and B in one place", "length above zero"),
    ),
    "negative inertia of a link": (BARS, "inertia = 0.1\n", "inertia = -0.1\n", 6, "link[0].inertia", ("found -0.1",)),
    "point with three numbers": (
        BARS,
        "Q = [1, 0]",
        "Q = [1, 0, 0]",
        2,
        "ground_link.points.Q",
        ("[1, 0, 0]", "write 2 values"),
    ),
    "another kind of joint": (
        BARS,
        'between = ["ground.O", "crank.A"]',
        'type = "ball"\nbetween = ["ground.O", "crank.A"]',
        16,
        "joint[0].type",
        ('found "ball"', '"revolute"'),
    ),
    "held but placed": (BARS, "[ground_link]", "[start]\nheight = 1\n[ground_link]", 2, "start.height", ("holds",)),
    "joints that cannot close": (
        BARS.replace("Q = [1, 0]", "Q = [9, 0]"),
        'between = ["crank.B", "rocker.A"]\n',
        'between = ["crank.B", "rocker.A"]\n[[joint]]\nbetween = ["rocker.B", "ground.Q"]\n',
        17,
        "joint[1]",
        ("misses by 7 m", "expected 0"),
    ),
}


def write(folder: Path, text: str) -> Path:
    path = folder / "scene.toml"
    path.write_text(text)
    return path


@pytest.mark.parametrize("case", CASES)
def test_fault(case: str, tmp_path: Path) -> None:
    text, old, new, line, key, words = CASES[case]
    assert old in text
    path = write(tmp_path, text.replace(old, new, 1))
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    assert len(caught.value.faults) == 1, str(caught.value)
    fault = caught.value.faults[0]
    assert (fault.file, fault.line, fault.key) == (str(path), line, key)
    assert str(fault).startswith(f"{path}:{line}: {key}")
    for word in words:
        assert word in fault.message
    assert "\n" not in fault.message
    assert list(tmp_path.iterdir()) == [path]


def test_the_scenes_are_good(tmp_path: Path) -> None:
    for text in (GOOD, BARS):
        load_scene(write(tmp_path, text))


def test_all_faults_at_once(tmp_path: Path) -> None:
    text = BARS.replace('"rocker.A"', '"rod.A"').replace("mass = 1.0", "mass = -1.0") + (
        "[[joint]]\nbetween = [1, 2]\nkind = 3\n[gravity]\ng = 'down'\nh = 1\n"
        "[[ground]]\nrestitution = 2\n[run]\nuntil = nan\n"
    )
    with pytest.raises(SceneError) as caught:
        load_scene(write(tmp_path, text))
    assert [(fault.line, fault.key) for fault in caught.value.faults] == [
        (5, "link[0].mass"),
        (11, "link[1].mass"),
        (18, "joint[1].between[1]"),
        (20, "joint[2].between[0]"),
        (20, "joint[2].between[1]"),
        (21, "joint[2].kind"),
        (23, "gravity.g"),
        (24, "gravity.h"),
        (26, "ground[0].restitution"),
        (28, "run.until"),
    ]
    assert len(str(caught.value).splitlines()) == 10


def test_unknown_key_hides_nothing(tmp_path: Path) -> None:
    text = GOOD.replace("links = 4", "links = 4\ncolour = 1\nlength = [1, 1, 5, 1]")
    with pytest.raises(SceneError) as caught:
        load_scene(write(tmp_path, text))
    assert [fault.key for fault in caught.value.faults] == ["loop.colour", "loop.length"]


def test_wrong_values_hide_nothing(tmp_path: Path) -> None:
    """A wrong mass or restitution does not keep the rest of its table from being checked."""
    text = '[loop]\nlinks = 4\nmass = -1.0\n[[ground]]\nrestitution = 1.5\nnormal = [0, 0]\ncontacts = ["joint_9"]\n'
    with pytest.raises(SceneError) as caught:
        load_scene(write(tmp_path, text))
    assert [(fault.line, fault.key) for fault in caught.value.faults] == [
        (3, "loop.mass"),
        (5, "ground[0].restitution"),
        (6, "ground[0].normal"),
        (7, "ground[0].contacts[0]"),
    ]


def test_files_that_are_none(tmp_path: Path) -> None:
    for path in (tmp_path / "missing.toml", tmp_path):
        with pytest.raises(SceneError, match="expected a scene file"):
            load_scene(path)
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe")
    with pytest.raises(SceneError, match="UTF-8"):
        load_scene(binary)
    with pytest.raises(SceneError, match=r"found no links, expected one of \[loop\]"):
        load_scene(write(tmp_path, ""))


def test_file_name_that_is_no_name(tmp_path: Path) -> None:
    path = tmp_path / "2 bars.toml"
    path.write_text("[chain]\nlinks = 2\n")
    with pytest.raises(SceneError, match=r"the file's name .* add a name"):
        load_scene(path)


@pytest.mark.parametrize(("make", "links"), [(loop, 0), (loop, 1), (loop, 2), (chain, 0), (pinned, 1), (loop, -3)])
def test_too_few_links(make: object, links: int) -> None:
    with pytest.raises(SceneError, match="links: found"):
        make(links)  # type: ignore[operator]


# Command line

REFUSED = [
    (["--links", "0"], "--links"),
    (["--links", "1"], "--links"),
    (["--links", "2"], "--links"),
    (["--links", "-6"], "--links"),
    (["--links", "six"], "--links"),
    (["--links", "1", "--pinned"], "--links"),
    (["--links", "0", "--open"], "--links"),
    (["--links", "4", "--open", "--pinned"], "--open"),
    (["--links", "4", "--hinged"], "--hinged"),
    (["--gravity"], "--gravity"),
    (["--links", "4", "--scene", "scene.toml"], "--links"),
    (["--scene", "scene.toml", "--gravity"], "--gravity"),
    (["--scene", "missing.toml"], "missing.toml"),
    (["--lnks", "6"], "--lnks"),
    (["--links", "4", "run", "scene.toml"], "--links"),
    (["--links", "6", "--out", "scene.toml/below"], "--out"),
    (["run", "scene.toml", "--until", "-1"], "--until"),
    (["run", "scene.toml", "--until", "nan"], "--until"),
    (["run", "scene.toml", "--rtol", "0"], "--rtol"),
    (["run", "scene.toml", "--out", "scene.toml"], "--out"),
    (["run", "missing.toml"], "missing.toml"),
    (["run"], "SCENE"),
    (["show", "missing.toml"], "missing.toml"),
    (["diff", "scene.toml", "missing"], "missing"),
    (["diff", "scene.toml", "scene.toml/below"], "below"),
    ([], "--links"),
]


@pytest.mark.sample(13)
@pytest.mark.parametrize(
    ("options", "named"), REFUSED, ids=lambda value: " ".join(value) if isinstance(value, list) else ""
)
def test_refused_options(options: list[str], named: str, tmp_path: Path) -> None:
    write(tmp_path, GOOD)
    result = ccgen(*options, at=tmp_path)
    assert result.returncode == 2, result.stderr
    assert named in result.stderr
    assert "Traceback" not in result.stderr
    assert result.stdout == ""
    assert [path.name for path in tmp_path.iterdir()] == ["scene.toml"]


def test_every_fault_on_standard_error(tmp_path: Path) -> None:
    write(tmp_path, GOOD.replace("links = 4", "links = 4\nmass = -1").replace("9.81", "nan"))
    for options in (["--scene", "scene.toml"], ["run", "scene.toml"], ["show", "scene.toml"]):
        result = ccgen(*options, at=tmp_path)
        assert result.returncode == 2
        lines = result.stderr.splitlines()
        assert [line.split(" ")[:2] for line in lines] == [
            ["scene.toml:4:", "loop.mass:"],
            ["scene.toml:8:", "gravity.g:"],
        ]
    assert [path.name for path in tmp_path.iterdir()] == ["scene.toml"]
