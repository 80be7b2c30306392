"""The thresholds of the core: their order, and how they are told."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import pytest
from typer.testing import CliRunner

from ccgen.generator.cli.app import app
from ccgen.runtime import _core
from ccgen.runtime.model.thresholds import thresholds
from ccgen.runtime.precision import CORES, core_of

from ..support.folders import ROOT
from ..support.workshop import Workshop

FALLING = ROOT / "scenes" / "falling-hexagon.toml"


@pytest.mark.parametrize("precision", CORES)
def test_what_one_lets_pass_another_catches(precision: str) -> None:
    core = core_of(precision)
    wrong = [
        (less, more)
        for less, more in core.TOLERANCE_ORDERS
        if not 0.0 < core.TOLERANCES[less].value < core.TOLERANCES[more].value
    ]
    assert not wrong
    assert len(core.TOLERANCE_ORDERS) >= 20


def test_every_threshold_decides_something_in_the_core() -> None:
    """Each name is used in a file of the core beside the table."""
    folder = ROOT / "runtime" / "core"
    code = "\n".join(file.read_text() for file in folder.rglob("*.c") if file.name != "tolerances.c")
    assert not [name for name in _core.TOLERANCES if not re.search(rf"\b{name}\b", code)]


def test_every_threshold_stands_under_a_layer_that_asks_for_it() -> None:
    """In the order of the layers."""
    folder, wrong = ROOT / "runtime" / "core", []
    for name, one in _core.TOLERANCES.items():
        code = "\n".join(file.read_text() for file in (folder / one.layer).glob("*.c"))
        wrong += [] if re.search(rf"\b{name}\b", code) else [(name, one.layer)]
    assert not wrong


def test_reasons_are_words() -> None:
    """Other thresholds stand in parentheses only, so that a reason is understood without them."""
    for name, one in _core.TOLERANCES.items():
        for text in (one.decides, one.because):
            words = re.sub(r"\([^()]*\)", "", text)
            assert len(words) > 10 and not set(re.findall(r"\w+", words)) & _core.TOLERANCES.keys(), (name, text)


ELSEWHERE = {
    "complementarity/friction.c": (1, "shifts that break ties of the pivots, tried one after another"),
    "hybrid/time_stepping.c": (1, "how long time stepping is tried before event by event"),
    "interface/simulation.c": (1, "the default of rtol"),
    "steps/pace.c": (1, "how long a run may take"),
    "steps/step_control.c": (4, "the first step of Hairer, Norsett, Wanner, and an error of zero"),
    "steps/step_search.c": (1, "roots end at the last digit; a zero is taken for just behind it"),
}
"""Files of the core with small numbers that decide nothing but the pace: in how many lines, and what they are."""


def test_small_numbers_stand_in_the_table() -> None:
    """Numbers of 1e-4 and less are in the table, but for those of methods and what is named above."""
    folder, found = ROOT / "runtime" / "core", Counter[str]()
    for file in sorted(folder.rglob("*.c")):
        code = re.sub(r"/\*.*?\*/", "", file.read_text(), flags=re.S)
        small = [line for line in code.splitlines() if re.search(r"(?<![\w.])[\d.]+e-0?([4-9]|[1-9]\d+)\b", line)]
        if small and file.parent.name != "methods":
            found[file.relative_to(folder).as_posix()] = len(small)
    assert found == {name: count for name, (count, _) in ELSEWHERE.items()}


def test_sizes_follow_length_and_time(workshop: Workshop) -> None:
    """A model four times as large has four times the lengths, twice the time and twice the speeds under gravity."""
    from ccgen.generator import load_scene

    model = workshop.model(load_scene(FALLING))
    larger = model.with_parameters({path: 4.0 * value for path, value in model.parameters.items() if "length" in path})
    factors = {"": 1.0, "length": 4.0, "speed": 2.0, "time": 2.0, "unit": 1.0, "tolerance": 1.0}
    for small, large in zip(thresholds(model), thresholds(larger), strict=True):
        assert large.size == pytest.approx(factors[small.of] * small.size, rel=1e-14), small.name


def test_the_command_prints_each_with_its_reason(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    printed = CliRunner().invoke(app, ["show", str(FALLING), "--tolerances"])
    assert printed.exit_code == 0, printed.output
    for name, one in _core.TOLERANCES.items():
        assert re.search(
            rf"^{name}  .*\n    {re.escape(one.decides)}\n    because: {re.escape(one.because)}$", printed.output, re.M
        ), name
    assert "characteristic time 1 s: about half a swing under gravity" in printed.output
    headings = re.findall(r"^\[(\w+)\]$", printed.output, re.M)
    assert headings == [*dict.fromkeys(one.layer for one in _core.TOLERANCES.values())]
    follow = {name for name, one in _core.TOLERANCES.items() if one.of == "tolerance"}
    assert set(re.findall(r"^(\w+)  .*, follows rtol$", printed.output, re.M)) == follow != set()
    for scale in {one.of for one in _core.TOLERANCES.values()} - {""}:
        assert re.search(rf"^    {scale} +\S", printed.output, re.M), f"{scale} is not told at the top"
    both = CliRunner().invoke(app, ["show", str(FALLING), "--tolerances", "--latex"])
    assert both.exit_code == 2
    assert "--tolerances" in both.stderr
