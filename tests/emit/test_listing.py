"""A listing can be read back and evaluated, and compared with another; what is not a listing is refused by its line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from numpy.typing import NDArray

from ccgen.generator import chain, load_scene, loop, pinned
from ccgen.generator.derive.expanded import expand
from ccgen.generator.mechanism.topology import span
from ccgen.generator.pipeline import listing
from ccgen.generator.program.compare import compare
from ccgen.generator.program.reading import Listing, ListingError, read_listing
from ccgen.generator.scene.scene import Scene

from ..support.folders import ROOT

Values = NDArray[np.float64]

SCENES = {
    "loop": lambda: loop(3, gravity=True),
    "chain": lambda: chain(2),
    "hinged": lambda: chain(2, hinged=True, gravity=True),
    "pinned": lambda: pinned(2, gravity=True),
    "four-bar": lambda: load_scene(ROOT / "scenes" / "four-bar.toml"),
}
SEEDS = range(5)

SMALL = """# ccgen equations, format 1
[state]
q: theta_0
[parameters]
m_0 = 2.0  # body.mass
[first]
a = m_0*cos(theta_0)
b = 1/2*a**2
[kernel energy: energy]
q: theta_0
energy[0] = a + b
"""


def _draw(listing_: Listing, kernel: str, seed: int) -> dict[str, Values]:
    random = np.random.default_rng(seed)
    return {name: random.uniform(-2.0, 2.0, len(symbols)) for name, symbols in listing_.kernels[kernel].inputs.items()}


class Dense:
    """M, h, A and the rest of the expanded closed form as numbers, and a dense solve with them."""

    def __init__(self, scene: Scene) -> None:
        form = expand(scene.mechanism, span(scene.mechanism), scene.effects)
        symbols = [sp.Symbol(p.symbol) for p in scene.mechanism.parameters()]
        symbols += [sp.Symbol(p.symbol) for effect in scene.effects for p in effect.parameters()]
        values = [p.value for p in scene.mechanism.parameters()]
        values += [p.value for effect in scene.effects for p in effect.parameters()]
        data = dict(zip(symbols, values, strict=True))
        self.names = [*form.state.q, *form.state.u]
        self.numbers = {
            name: sp.lambdify([self.names], sp.Matrix(matrix).subs(data), "numpy")
            for name, matrix in {"M": form.M, "h": form.h, "A": form.A, "bias": form.A_rate}.items()
        }
        self.rows = form.A.rows

    def at(self, name: str, q: Values, u: Values) -> Values:
        return np.array(self.numbers[name]([*q, *u]), dtype=float)

    def solve(self, q: Values, u: Values, force: Values, rate: Values) -> tuple[Values, Values]:
        """x and λ of M x = Aᵀλ + force, A x = rate."""
        mass, jacobian = self.at("M", q, u), self.at("A", q, u).reshape(self.rows, len(u))
        matrix = np.block([[mass, -jacobian.T], [jacobian, np.zeros((self.rows, self.rows))]])
        found = np.linalg.solve(matrix, np.concatenate([force, rate]))
        return found[: len(u)], found[len(u) :]


def _close(found: Values, expected: Values) -> bool:
    return bool(np.max(np.abs(found - expected), initial=0.0) <= 1e-12 * np.max(np.abs(expected), initial=1.0))


@pytest.mark.parametrize("name", SCENES)
def test_the_listing_alone_gives_the_accelerations(name: str) -> None:
    scene = SCENES[name]()
    read, dense = read_listing(listing(scene)), Dense(scene)
    for seed in SEEDS:
        given = _draw(read, "acceleration", seed)
        q, u = given["q"], given["u"]
        found = read.evaluate("acceleration", given)
        u_dot, multipliers = dense.solve(q, u, -dense.at("h", q, u).ravel(), -dense.at("bias", q, u).ravel())
        assert _close(found["u_dot"], u_dot)
        assert dense.rows == 0 or _close(found["lambda"], multipliers)


@pytest.mark.parametrize("name", SCENES)
def test_the_listing_alone_gives_the_velocity_jumps(name: str) -> None:
    scene = SCENES[name]()
    read, dense = read_listing(listing(scene)), Dense(scene)
    for seed in SEEDS:
        given = _draw(read, "impulse", seed)
        found = read.evaluate("impulse", given)
        jump, impulses = dense.solve(given["q"], np.zeros_like(given["f"]), given["f"], given["y"])
        assert _close(found["du"], jump)
        assert dense.rows == 0 or _close(found["Lambda"], impulses)


def test_states_come_in_batches() -> None:
    read = read_listing(listing(loop(3)))
    single = [_draw(read, "acceleration", seed) for seed in SEEDS]
    batch = {name: np.stack([given[name] for given in single], axis=-1) for name in ("q", "u")}
    found = read.evaluate("acceleration", batch)["u_dot"]
    assert found.shape == (5, len(single))
    for column, given in enumerate(single):
        assert _close(found[:, column], read.evaluate("acceleration", given)["u_dot"])


def test_arrays_keep_their_size_where_zeros_are_left_out() -> None:
    read = read_listing(listing(pinned(12)))
    found = read.evaluate("reactions", _draw(read, "reactions", 0))["reaction"]
    assert found.shape == (3 * 13,)
    assert np.all(found[2::3] == 0.0)


def test_arguments_without_entries_are_read() -> None:
    inputs = read_listing(listing(chain(2))).kernels["impulse"].inputs
    assert list(inputs) == ["q", "f", "y"]
    assert inputs["y"] == []


def test_parameters_have_their_paths() -> None:
    read = read_listing(listing(loop(3, gravity=True)))
    assert read.paths["m_1"] == "link_1.mass"
    assert read.parameters["g"] == 9.81
    assert read.state["q"] == ["x_0", "y_0", "theta_0", "theta_1", "theta_2"]


def test_unknown_kernels_and_missing_arguments_are_errors() -> None:
    read = read_listing(SMALL)
    assert read.evaluate("energy", {"q": np.zeros(1)})["energy"] == pytest.approx([4.0])
    with pytest.raises(KeyError, match="momentum"):
        read.evaluate("momentum", {"q": np.zeros(1)})
    with pytest.raises(KeyError, match="q"):
        read.evaluate("energy", {})


@pytest.mark.parametrize(
    "expression",
    [
        "__import__('os').system('true')",
        "open('x')",
        "a.__class__",
        "(lambda: 1)()",
        "[a]",
        "[x for x in a]",
        "a[0]",
        "a if a else b",
        "a < 1",
        "a and m_0",
        "'text'",
        "True",
        "1j",
        "a // 2",
        "a @ a",
        "~1",
        "f'{a}'",
        "(b := 2)",
        "sin(a, a)",
        "sin(a, out=a)",
        "sin(*a)",
        "sin + a",
        "sin(sin)",
        "a(1)",
        "a**a",
        "a**-1",
        "9**9**9**9",
        "a +",
        "a b",
        "",
        "(" * 500 + "a" + ")" * 500,
        "-" * 5000 + "a",
    ],
)
def test_expressions_that_are_not_arithmetic_are_refused_by_their_line(expression: str) -> None:
    lines = SMALL.splitlines()
    lines[7] = f"b = {expression}"
    with pytest.raises(ListingError, match=r"^small\.txt:8: "):
        read_listing("\n".join(lines), "small.txt")
    lines = SMALL.splitlines()
    lines[10] = f"energy[0] = {expression}"
    with pytest.raises(ListingError, match=r"^small\.txt:11: "):
        read_listing("\n".join(lines), "small.txt")


@pytest.mark.parametrize(
    ("line", "text", "says"),
    [
        (1, "# something else", "expected"),
        (7, "a = m_0*cos(phi_0)", "phi_0 which is never defined"),
        (7, "a = b", "b before it is defined"),
        (8, "a = 1", "a is defined twice"),
        (8, "m_0 = 1", "m_0 is defined twice"),
        (8, "cos = 1", "cos is defined twice"),
        (8, "__builtins__ = 1", "expected"),
        (8, "a b = 1", "expected"),
        (8, "b == 1", "expected"),
        (5, "m_0 = heavy", "not a number: heavy"),
        (8, "b[0] = 1", "outside a kernel"),
        (8, "just words", "expected"),
        (10, "q: theta_0; x", "expected"),
        (11, "energy[0] = c", "c which is never defined"),
    ],
)
def test_lines_that_do_not_belong_are_refused(line: int, text: str, says: str) -> None:
    lines = SMALL.splitlines()
    lines[line - 1] = text
    with pytest.raises(ListingError, match=rf"^small\.txt:{line}: .*{says}"):
        read_listing("\n".join(lines), "small.txt")


def test_equal_texts_are_the_same() -> None:
    text = listing(pinned(2))
    report = compare(text, text)
    assert report.same
    assert not report.text


def test_another_way_of_writing_agrees_in_numbers() -> None:
    text = listing(pinned(2))
    other = text.replace("w2_0 = w_0**2", "w2_0 = w_0*w_0")
    report = compare(text, other, "before", "after")
    assert not report.same
    assert report.text.startswith("--- before\n+++ after\n")
    assert "-w2_0 = w_0**2\n" in report.text
    assert "+w2_0 = w_0*w_0\n" in report.text
    assert "agree" in report.numbers


@pytest.mark.parametrize(
    ("old", "new", "kernels"),
    [
        ("w2_0 = w_0**2", "w2_0 = w_0**3", ("acceleration", "reactions")),
        ("I_0 = ", "I_0 = 1", ("acceleration", "energy", "impulse")),
    ],
)
def test_another_number_is_found_and_its_kernels_named(old: str, new: str, kernels: tuple[str, ...]) -> None:
    text = listing(pinned(2))
    assert old in text
    report = compare(text, text.replace(old, new))
    assert not report.same
    assert "differ" in report.numbers
    assert all(f"{kernel} differs by" in report.numbers for kernel in kernels)
    assert "closure differs" not in report.numbers


def test_listings_of_different_mechanisms_have_no_common_numbers() -> None:
    report = compare(listing(pinned(2)), listing(pinned(3)))
    assert not report.same
    assert "different coordinates" in report.numbers


def test_a_kernel_in_one_listing_only_is_named(tmp_path: Path) -> None:
    file = tmp_path / "scene.toml"
    file.write_text('name = "loop3"\n[loop]\nlinks = 3\n[start]\nheight = 1\n[[ground]]\nrestitution = 0.5\n')
    report = compare(listing(loop(3)), listing(load_scene(file)))
    assert "gaps is in one of them only" in report.numbers
    assert "acceleration" not in report.numbers


def test_what_cannot_be_read_cannot_be_compared() -> None:
    with pytest.raises(ListingError, match=r"^right:8: "):
        compare(SMALL, SMALL.replace("b = 1/2*a**2", "b = a."), "left", "right")
