"""Motions that keep within their rows: monotone cubics beside SciPy's, rises beside the textbook's numbers, runs."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.interpolate import PchipInterpolator

from ccgen.generator.derive.following import ANGLE
from ccgen.generator.effect_base.laws_of_rise import LAWS, LawOfRise
from ccgen.generator.effect_base.motion_laws import Monotone, Rises
from ccgen.generator.effects.drive import Drive
from ccgen.generator.scene.errors import SceneError
from ccgen.runtime import methods, simulate

from ..support.tiers import all_hard_but
from ..support.workshop import Workshop

NORTON = {
    "cycloidal": (2.0, 2.0 * math.pi, 4.0 * math.pi**2),
    "3-4-5": (15.0 / 8.0, 10.0 / math.sqrt(3.0), 60.0),
    "4-5-6-7": (35.0 / 16.0, 84.0 / 25.0 * math.sqrt(5.0), 52.5),
    "harmonic": (math.pi / 2.0, math.pi**2 / 2.0, math.pi**3 / 2.0),
    "modified-trapezoidal": (2.0, 4.888124, 61.426),
}
"""The largest velocity, acceleration and jerk of a rise of 1 in a time of 1 (Norton, 2009, or by algebra)."""
SLIDER = """
name = "slider"
[ground_link]
points = {{ O = [0, 0] }}
[[link]]
name = "cart"
mass = 2
inertia = 1
com = [0, 0]
points = {{ C = [0, 0] }}
[[joint]]
name = "rail"
type = "prismatic"
between = ["ground.O", "cart.C"]
axis = [1, 0]
[[drive]]
joint = "rail"
{drive}
[run]
until = {until}
"""
BUMP = '[[0, 0], [0.5, 0], [0.55, "60 mm"], [0.65, "60 mm"], [0.7, 0], [2, 0]]'


def norton_trapezoid(x: float) -> float:
    """The modified trapezoid as the textbook prints it, with six to eight digits."""
    if x < 0.125:
        return 0.38898448 * x - 0.0309544 * math.sin(4.0 * math.pi * x)
    if x < 0.375:
        return 2.44406184 * x**2 - 0.22203097 * x + 0.00723407
    if x < 0.625:
        return 1.6110154 * x - 0.0309544 * math.sin(4.0 * math.pi * x - math.pi) - 0.3055077
    if x < 0.875:
        return -2.44406184 * x**2 + 4.6660917 * x - 1.2292648
    return 0.6110154 + 0.38898448 * x + 0.0309544 * math.sin(4.0 * math.pi * x - 3.0 * math.pi)


@pytest.mark.parametrize("seed", range(12))
def test_a_monotone_cubic_is_that_of_scipy(seed: int) -> None:
    draw = np.random.default_rng(seed)
    t = np.cumsum(draw.uniform(0.05, 1.0, draw.integers(2, 12)))
    y = draw.uniform(-1.0, 1.0, len(t)).round(1 + seed % 3)
    found, wanted = Monotone(tuple(zip(t.tolist(), y.tolist(), strict=True)), "straight"), PchipInterpolator(t, y)
    for at in draw.uniform(t[0], t[-1], 60).tolist():
        for d in (0, 1):
            assert found.slope_at(at, d) == pytest.approx(float(wanted(at, nu=d)), rel=1e-12, abs=1e-12)
    assert found.range()[0] >= y.min() and found.range()[1] <= y.max()
    if len(t) > 2:
        resting = Monotone(found.rows, "rest")
        middle = [float(s) for s in draw.uniform(t[1], t[-2], 20)] if len(t) > 3 else []
        assert [resting.at(s) for s in middle] == pytest.approx([float(wanted(s)) for s in middle], abs=1e-12)
        assert resting.slope_at(float(t[0])) == resting.slope_at(float(t[-1])) == 0.0


def test_a_periodic_monotone_cubic_is_that_of_three_periods() -> None:
    t, y = np.array([0.0, 0.3, 0.4, 1.1, 1.5]), np.array([0.2, 1.0, 0.7, -0.4, 0.2])
    found = Monotone(tuple(zip(t.tolist(), y.tolist(), strict=True)), "periodic")
    long = np.concatenate([t[:-1] - 1.5, t[:-1], t[:-1] + 1.5])
    wanted = PchipInterpolator(long, np.tile(y[:-1], 3))
    for at in np.linspace(0.0, 1.499, 50).tolist():
        assert [found.at(at), found.at(at + 3.0)] == pytest.approx([float(wanted(at))] * 2, abs=1e-12)


@pytest.mark.parametrize("law", sorted(LAWS))
def test_a_rise_has_the_numbers_of_the_textbook(law: LawOfRise) -> None:
    rise = Rises(((0.0, 0.0), (1.0, 1.0)), (law,), "rest")
    x = np.linspace(1e-9, 1.0 - 1e-9, 8001).tolist()
    told = [np.array([rise.slope_at(s, d) for s in x]) for d in range(4)]
    assert [np.abs(one).max() for one in told[1:]] == pytest.approx(NORTON[law], rel=1e-5)
    assert told[0] + told[0][::-1] == pytest.approx(1.0, abs=1e-14)
    assert told[0].min() >= -1e-15 and told[0].max() <= 1.0 + 1e-15
    for lower, higher in pairwise(told[:3]):
        change = (lower[2:] - lower[:-2]) / (x[2] - x[0])
        assert change == pytest.approx(higher[1:-1], abs=2e-3)
    if law == "modified-trapezoidal":
        assert told[0] == pytest.approx([norton_trapezoid(s) for s in x], abs=1e-6)


@pytest.mark.parametrize("law", sorted(LAWS))
def test_parts_of_a_rise_meet(law: LawOfRise) -> None:
    """Values, speeds and, unless it is harmonic, accelerations: at ends of the rise, and where its parts meet."""
    rise = Rises(((0.0, 2.0), (0.5, 2.0), (1.25, -1.0), (2.0, 0.5)), (None, law, law), "rest")
    for t, _ in rise.rows:
        for order in range(2 if law == "harmonic" else 3):
            sides = (rise.slope_at(t + side * 1e-9, order) for side in (-1.0, 1.0))
            assert sides.__next__() == pytest.approx(sides.__next__(), abs=1e-5 if order == 2 else 1e-7)
    assert set(rise.jumps(2).values()) == ({0.5, 1.25, 2.0} if law == "harmonic" else set())


def place(law: str) -> Any:
    """Where a slider is that goes through the rows of BUMP, by time."""
    rows = ((0.0, 0.0), (0.5, 0.0), (0.55, 0.06), (0.65, 0.06), (0.7, 0.0), (2.0, 0.0))
    if law == "monotone":
        return PchipInterpolator(*np.array(rows).T)

    def at(t: np.ndarray) -> np.ndarray:
        x = np.clip((t - 0.5) / 0.05, 0.0, 1.0) - np.clip((t - 0.65) / 0.05, 0.0, 1.0)
        shapes = {
            "cycloidal": x - np.sin(2.0 * np.pi * x) / (2.0 * np.pi),
            "3-4-5": 10.0 * x**3 - 15.0 * x**4 + 6.0 * x**5,
            "4-5-6-7": 35.0 * x**4 - 84.0 * x**5 + 70.0 * x**6 - 20.0 * x**7,
            "harmonic": (1.0 - np.cos(np.pi * x)) / 2.0,
            "modified-trapezoidal": np.vectorize(norton_trapezoid)(x),
        }
        return np.asarray(0.06 * shapes[law])

    return at


CASES = [(law, method) for law in ("monotone", *sorted(LAWS)) for method in methods() if method != "moreau"]


@pytest.mark.parametrize(
    "case",
    all_hard_but(("monotone", "gauss"), ("harmonic", "dop853"), ("modified-trapezoidal", "radau"), of=CASES),
    ids="-".join,
)
def test_a_driven_slider_keeps_within_its_rows(case: tuple[str, str], workshop: Workshop) -> None:
    """It is where the closed form is, steps end at the rows, and the drive's work is the energy."""
    law, method = case
    text = SLIDER.format(drive=f'position = {{ rows = {BUMP}, law = "{law}" }}', until=1.0)
    assert not workshop.scene(text).remarks
    run = simulate(workshop.model(text), method=method, rtol=1e-10)
    assert run.success, run.message
    assert {0.5, 0.55, 0.65, 0.7} <= set(run.t)
    t = np.linspace(0.0, 1.0, 401)
    x = np.array([run.at(s)[0][0] for s in t])
    assert x == pytest.approx(place(law)(t), abs=1e-7 if law == "modified-trapezoidal" else 1e-10)
    assert x.min() >= -1e-10 and x.max() <= 0.06 + 1e-10
    moves = float(np.max(run.model.energy(run.q, run.u)[0]))
    assert run.energy_drift <= 10.0 * 1e-10 * moves  # ten times rtol


def test_pieces_are_as_cams_have_them(workshop: Workshop) -> None:
    """Each with a law of its own, a rest where there is no value, and begun anew where it is periodic."""
    pieces = (
        '{ start = "10 mm", begin = 0.1, ends = "periodic", pieces = [ { to = 0.3 }, '
        '{ to = 0.5, value = "50 mm", law = "3-4-5" }, { to = 0.6 }, { to = 0.9, value = 0.02 }, '
        '{ to = 1.1, value = 0.01, law = "4-5-6-7" } ] }'
    )
    run = simulate(workshop.model(SLIDER.format(drive=f"position = {pieces}", until=2.5)), rtol=1e-11)
    assert run.success, run.message

    def wanted(t: float) -> float:
        t = 0.1 + (t - 0.1) % 1.0
        x, y, z = (min(max((t - a) / h, 0.0), 1.0) for a, h in ((0.3, 0.2), (0.6, 0.3), (0.9, 0.2)))
        first = 10.0 * x**3 - 15.0 * x**4 + 6.0 * x**5
        second, third = y - math.sin(2.0 * math.pi * y) / (2.0 * math.pi), 35 * z**4 - 84 * z**5 + 70 * z**6 - 20 * z**7
        return 0.01 + 0.04 * first - 0.03 * second - 0.01 * third

    for t in np.linspace(0.0, 2.5, 300).tolist():
        assert run.at(t)[0][0] == pytest.approx(wanted(t), abs=1e-10)


@pytest.mark.parametrize("law", sorted(LAWS))
def test_cams_have_the_same_laws(law: LawOfRise, workshop: Workshop) -> None:
    """The lift in the equations, piece by piece, is that of the rise over time."""
    lift = f'[{{ to = "60 deg" }}, {{ to = "180 deg", lift = 0.02, law = "{law}" }}, {{ to = "360 deg", lift = 0 }}]'
    scene = workshop.scene(CAM.format(lift=lift))
    (cam,) = (effect for effect in scene.effects if type(effect).__name__ == "Cam")
    a, b = math.pi / 3.0, math.pi
    rise = Rises(((a, 0.0), (b, 0.02)), (law,), "rest")
    for one in cam.profile.lifts():
        if not a - 1e-9 <= one.start < b - 1e-9:
            continue
        values = {sp.Symbol(p.symbol): p.value for p in cam.parameters()} | {ANGLE: 0.0}
        for at in np.linspace(one.start, one.end, 7).tolist():
            values[ANGLE] = at
            expression = one.law.subs(
                {symbol: values[s] for symbol in one.law.free_symbols for s in values if s == symbol}
            )
            assert float(expression) == pytest.approx(rise.at(at), abs=1e-15)
            for order in (0, 1, 2):
                piece = next(p for p in cam.profile.pieces if p.start == one.start)
                assert piece.lift(at, order) == pytest.approx(_inside(rise, at, order, one), abs=1e-7)


def test_a_follower_goes_as_the_modified_trapezoid_says(workshop: Workshop) -> None:
    """Pressed by its weight onto a cam that a drive turns slowly: the lift over time is that of the rise."""
    lift = (
        '[{ to = "60 deg" }, { to = "180 deg", lift = 0.02, law = "modified-trapezoidal" }, '
        '{ to = "360 deg", lift = 0, law = "modified-trapezoidal" }]'
    )
    text = CAM.format(lift=lift).replace('"ground.G"', '"ground.O"').replace("axis = [0, -1]", "axis = [0, 1]")
    text = text.replace("guide = 0.5", "guide = 0.12").replace("restitution = 0", 'restitution = 0\nangle = "90 deg"')
    run = simulate(workshop.model(text + '[[drive]]\njoint = "axle"\nspeed = -2\n[gravity]\n[run]\nuntil = 3\n'))
    assert run.success and not run.impacts, run.message
    ends = ((0.0, 0.12), (math.pi / 3.0, 0.12), (math.pi, 0.14), (2.0 * math.pi, 0.12))
    rise = Rises(ends, (None, "modified-trapezoidal", "modified-trapezoidal"), "rest")
    place = run.model.q_of.index("guide.slide")
    for t in np.linspace(0.0, 3.0, 100).tolist():
        assert run.at(t)[0][place] == pytest.approx(rise.at(2.0 * t), abs=1e-12)


def _inside(rise: Rises, at: float, order: int, one: Any) -> float:
    """A derivative within a piece, at its ends too."""
    return rise.slope_at(min(max(at, one.start + 1e-9), one.end - 1e-9), order)


CAM = """
name = "cam"
[ground_link]
points = {{ O = [0, 0], G = [0, 1] }}
[[link]]
name = "shaft"
mass = 1
inertia = 0.1
com = [0, 0]
points = {{ O = [0, 0] }}
[[link]]
name = "lifter"
mass = 1
inertia = 1
com = [0, 0]
points = {{ P = [0, 0] }}
[[joint]]
name = "axle"
between = ["ground.O", "shaft.O"]
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.G", "lifter.P"]
axis = [0, -1]
[[cam]]
centre = "shaft.O"
follower = "lifter.P"
base = 0.1
radius = 0.02
restitution = 0
lift = {lift}
[start]
slides = {{ guide = 0.5 }}
"""


def test_a_spline_that_leaves_its_rows_is_remarked_on(workshop: Workshop) -> None:
    for order, low, high in ((5, -0.658012, 0.0829052), (3, -0.2475, 0.0837)):
        (said,) = workshop.scene(
            SLIDER.format(drive=f"position = {{ rows = {BUMP}, order = {order} }}", until=1)
        ).remarks
        found = [float(word) for word in said.replace(",", " ").split() if _is_number(word)]
        assert "drive[0].position: the spline of order" in said and 'law = "monotone"' in said
        assert found[1:3] == pytest.approx([low, high], rel=2e-3)
    wave = [[k / 24.0, math.sin(2.0 * math.pi * (k / 24.0 + 0.02))] for k in range(25)]
    wave[-1][1] = wave[0][1]
    assert not workshop.scene(
        SLIDER.format(drive=f'position = {{ rows = {wave}, order = 5, ends = "periodic" }}', until=1)
    ).remarks


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


WRONG = {
    "both": (f'position = {{ rows = {BUMP}, order = 3, law = "monotone" }}', "it has order beside law"),
    "neither": (f"position = {{ rows = {BUMP} }}", "it has neither order nor law"),
    "another law": (f'position = {{ rows = {BUMP}, law = "cubic" }}', r"position\.law: found"),
    "straight on": (f'position = {{ rows = {BUMP}, law = "3-4-5", ends = "straight" }}', "rests at the last row"),
    "order 1": (f"position = {{ rows = {BUMP}, order = 1 }}", 'in place of the order law = "monotone"'),
    "jumps again": (
        'position = { rows = [[0, 0], [1, 1], [3, 0]], law = "harmonic", ends = "periodic" }',
        "whose acceleration does not jump",
    ),
    "backward": ("position = { pieces = [{ to = 1, value = 1 }, { to = 1, value = 2 }] }", "piece 1 ends at 1 s"),
    "no pieces": ("position = { pieces = [] }", r"position\.pieces: "),
    "a law of rest": ('position = { pieces = [{ to = 1, law = "3-4-5" }] }', "so it rests; leave the law out"),
    "not closed": ('position = { pieces = [{ to = 1, value = 1 }], ends = "periodic" }', "end with the start"),
    "a unit": ('position = { pieces = [{ to = 1, value = "1 kg" }] }', r"position\.pieces\[0\]\.value: .*kg"),
    "other key": ("position = { pieces = [{ to = 1, lift = 1 }] }", r"position\.pieces\[0\]\.lift: found"),
    "at its begin": ("position = { pieces = [{ to = 0, value = 1 }] }", "piece 0 ends at 0 s, where it begins at 0; "),
    "before its begin": (
        "position = { pieces = [{ to = 1, value = 1 }], begin = 2 }",
        'piece 0 ends at 1 s, where it begins at 2; write a later end, or an earlier "begin"$',
    ),
    "pieces straight on": (
        'position = { pieces = [{ to = 1, value = 1 }], ends = "straight" }',
        r'ends: found "straight", expected what it does before and after, "rest" \(stay\) or "periodic" \(begin anew\)',
    ),
    "misspelt beside pieces": (
        "position = { pieces = [{ to = 1, value = 1 }], strat = 0.5 }",
        'strat: found an unknown key, expected one of pieces, start, begin, ends; write "start"$',
    ),
    "of rows beside pieces": (
        'position = { pieces = [{ to = 1, value = 1 }], law = "cycloidal" }',
        "law: found an unknown key, expected one of pieces, start, begin, ends; remove it$",
    ),
    "rows beside pieces": (
        f"position = {{ pieces = [{{ to = 1, value = 1 }}], rows = {BUMP} }}",
        "rows: found an unknown key, expected one of pieces, start, begin, ends; remove it$",
    ),
    "of pieces beside rows": (
        f"position = {{ rows = {BUMP}, order = 3, begin = 1 }}",
        "begin: found an unknown key, expected one of rows, order, law, ends; remove it$",
    ),
    "misspelt pieces": (
        "position = { peices = [{ to = 1, value = 1 }] }",
        'peices: found an unknown key, expected one of pieces, start, begin, ends; write "pieces"$',
    ),
    "pieces are told of": ("position = [0, 1]", "an expression of t, or rows or pieces over time; "),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_motions(case: str, workshop: Workshop) -> None:
    drive, said = WRONG[case]
    with pytest.raises(SceneError, match=said):
        workshop.scene(SLIDER.format(drive=drive, until=1))


@pytest.mark.parametrize(("law", "parts"), [("cycloidal", 1), ("modified-trapezoidal", 5)])
@pytest.mark.parametrize("form", ["rows", "pieces"])
def test_rows_between_parts_of_laws_count(form: str, law: str, parts: int, workshop: Workshop) -> None:
    """500 rows are taken, of ``parts`` from station to station and one at the end, and no more."""
    most = 499 // parts

    def drive(rises: int) -> str:
        if form == "rows":
            return f'position = {{ rows = {[[k, k % 2] for k in range(rises + 1)]}, law = "{law}" }}'
        pieces = ", ".join(f'{{ to = {k + 1}, value = {(k + 1) % 2}, law = "{law}" }}' for k in range(rises))
        return f"position = {{ pieces = [{pieces}] }}"

    taken = workshop.scene(SLIDER.format(drive=drive(most), until=1)).effects[0]
    assert isinstance(taken, Drive) and isinstance(taken.law, Rises) and len(taken.law.rows) == parts * most + 1
    with pytest.raises(SceneError, match=rf"there are {most + (2 if form == 'rows' else 1)} {form}.* at most 500 rows"):
        workshop.scene(SLIDER.format(drive=drive(most + 1), until=1))


@pytest.mark.parametrize(
    "angle", ['{ pieces = [{ to = 1, value = "2*l" }], start = "l" }', '{ rows = [[0, "l"], [1, "2*l"]], order = 3 }']
)
def test_pieces_and_rows_in_parts_know_the_names_of_the_part(angle: str, workshop: Workshop) -> None:
    part = SLIDER.format(drive=f"position = {angle}", until=1).partition("[run]")[0].partition("[[link]]")
    inner = ("\n" + part[1] + part[2]).replace("\n[[", "\n[[part.")
    place = '[[place]]\npart = "unit"\nname = "one"\n'
    law = workshop.scene(f'{part[0]}[[part]]\nname = "unit"\nlet = {{ l = 0.5 }}\n{inner}{place}').effects[0].law
    assert (law.at(0.0), law.at(1.0)) == (0.5, 1.0)


def test_what_stands_behind_a_wrong_key_of_pieces_is_told(workshop: Workshop) -> None:
    """The scene is read on with an end that pieces may have."""
    drive = 'position = { pieces = [{ to = 1, value = 1 }], ends = "straight" }'
    with pytest.raises(SceneError) as caught:
        workshop.scene(SLIDER.format(drive=drive, until=1).replace('joint = "rail"', 'joint = "road"'))
    assert {fault.key for fault in caught.value.faults} == {"drive[0].position.ends", "drive[0].joint"}
