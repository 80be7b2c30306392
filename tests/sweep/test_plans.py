"""Plans: which numbers they give, and what is wrong with them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import qmc

from ccgen.generator import load_scene
from ccgen.generator.cli.plan_numbers import written
from ccgen.runtime import Model
from ccgen.runtime.sweep.chunk import chunk_of, make_chunk
from ccgen.runtime.sweep.plan import Plan, PlanError, plan_of, read_plan
from ccgen.runtime.sweep.starts import starts_of

from ..support.folders import SCENES
from ..support.workshop import Workshop


@pytest.fixture(scope="module")
def four_bar(workshop: Workshop) -> Model:
    return workshop.model(load_scene(SCENES / "four-bar.toml"))


def plan(model: Model, **tables: Any) -> Plan:
    return plan_of(tables, model, "plan.toml", "", Path())


MASS, HEIGHT = {"parameter": "link_0.mass"}, {"start": "link_0.y"}


def test_a_grid(model: Model) -> None:
    """All combinations, the last number moving from run to run; evenly, or by factors."""
    made = plan(
        model,
        vary=[
            {**MASS, "values": [1, 2]},
            {**HEIGHT, "from": 1, "to": 2, "count": 3},
            {"parameter": "gravity.g", "from": 1, "to": 100, "count": 3, "scale": "log"},
        ],
    )
    assert made.count == 18 and made.names == ("link_0.mass", "link_0.y(0)", "gravity.g")
    rows = made.rows(0, 18)
    assert list(rows["gravity.g"][:4]) == pytest.approx([1, 10, 100, 1])
    assert list(rows["link_0.y(0)"][:7]) == [1, 1, 1, 1.5, 1.5, 1.5, 2]
    assert list(rows["link_0.mass"]) == [1] * 9 + [2] * 9
    part = made.rows(7, 11)
    assert all(np.array_equal(part[name], rows[name][7:11]) for name in rows)


def test_rows_and_a_file(model: Model, tmp_path: Path) -> None:
    (tmp_path / "designs.csv").write_text("link_0.mass, link_1.mass\n1,2\n3,4\n")
    (tmp_path / "plan.toml").write_text(
        'combine = "rows"\n[table]\nfile = "designs.csv"\n[[vary]]\nstart = "link_0.y"\nvalues = [1.5, 1.6]\n'
    )
    rows = read_plan(tmp_path / "plan.toml", model).rows(0, 2)
    assert {name: list(values) for name, values in rows.items()} == {
        "link_0.mass": [1, 3],
        "link_1.mass": [2, 4],
        "link_0.y(0)": [1.5, 1.6],
    }


@pytest.mark.parametrize("by", ["random", "sobol", "halton", "latin"])
def test_samples(model: Model, by: str) -> None:
    """Any rows are what they are in the whole; their distributions by their quantiles; others with another seed."""
    vary = [
        {**MASS, "from": 1, "to": 3},
        {"parameter": "gravity.g", "from": 1, "to": 100, "scale": "log"},
        {**HEIGHT, "mean": 2.0, "deviation": 0.5},
    ]
    made = plan(model, vary=vary, sample={"by": by, "count": 8192, "seed": 3})
    rows = made.rows(0, 8192)
    for first, last in ((0, 1), (17, 20), (4090, 4100), (8191, 8192)):
        part = made.rows(first, last)
        assert all(np.array_equal(part[name], rows[name][first:last]) for name in rows)
    close = 0.05 if by == "random" else 0.01
    assert np.quantile(rows["link_0.mass"], [0.0, 0.25, 1.0]) == pytest.approx([1, 1.5, 3], abs=close)
    assert np.quantile(rows["gravity.g"], 0.5) == pytest.approx(10.0, rel=4 * close)
    assert np.quantile(rows["link_0.y(0)"], 0.8413447) == pytest.approx(2.5, abs=close)
    other = plan(model, vary=vary, sample={"by": by, "count": 8192, "seed": 4}).rows(0, 8192)
    assert not np.array_equal(rows["link_0.mass"], other["link_0.mass"])
    if by == "sobol":
        assert rows["link_0.mass"] == pytest.approx(1 + 2 * qmc.Sobol(3, rng=3).random(8192)[:, 0], abs=1e-12)


def test_starts_keep_loops_shut(four_bar: Model) -> None:
    """The crank where it is wanted and as fast, the others follow; a place that it cannot reach is told."""
    angles, rates = np.array([0.3, 1.0, 2.0]), np.array([1.0, -2.0, 0.0])
    q, u, faults = starts_of(four_bar, {}, {"crank.angle(0)": angles, "crank.angular_velocity(0)": rates})
    assert q is not None and u is not None and not faults
    assert np.array_equal(np.round(q[:, 0], 12), angles) and u[:, 0] == pytest.approx(rates, abs=1e-12)
    assert np.abs(four_bar.closure(q)).max() <= 1e-12
    assert np.abs(np.einsum("bij,bj->bi", four_bar.jacobian(q), u)).max() <= 1e-12
    lengths = {"coupler.length": np.array([0.1, 5.0])} if "coupler.length" in four_bar.parameters else {}
    if lengths:
        q, _, faults = starts_of(four_bar, lengths, {"crank.angle(0)": np.array([0.3, 0.3])})
        assert faults and all("cannot be closed" in why for why in faults.values())


WRONG: list[tuple[dict[str, Any], str]] = [
    ({}, r"vary: found nothing that varies, expected \[\[vary\]\] or \[table\]"),
    (
        {"vary": [{**MASS, "values": [1.0, math.nan]}]},
        r"vary\[0\].values: found \[1.0, nan\], expected a list of finite numbers",
    ),
    ({"vary": [{**MASS, "values": [1.0, -1.0]}]}, "link_0.mass: found -1.0, expected a positive number"),
    ({"vary": [{"parameter": "link_0.mas", "values": [1]}]}, "link_0.mas: found no such parameter"),
    ({"vary": [{"start": "link_0.z", "values": [1]}]}, "found 'link_0.z', expected one of link_0.x"),
    ({"vary": [{"values": [1]}]}, "found no name, expected parameter"),
    ({"vary": [{**MASS, "from": 1, "to": 2}]}, "count: found None, expected how many values"),
    (
        {"vary": [{**MASS, "from": 0, "to": 2, "count": 3, "scale": "log"}]},
        "scale: found 'log', expected linear, or from and to above",
    ),
    ({"vary": [{**MASS, "values": [1]}, {**MASS, "values": [2]}]}, "found 'link_0.mass', expected each name once"),
    ({"vary": [{**MASS, "values": [1], "count": 3}]}, "count: found beside values, expected one of both"),
    (
        {"vary": [{**MASS, "mean": 1, "deviation": 1, "from": 1}], "sample": {"count": 2}},
        "from: found beside mean and deviation, expected one of both",
    ),
    (
        {"vary": [{**MASS, "deviation": 1, "mean": 1, "to": 2}], "sample": {"count": 2}},
        "to: found beside mean and deviation, expected one of both",
    ),
    (
        {"vary": [{**MASS, "mean": 1, "deviation": 1, "scale": "log"}], "sample": {"count": 2}},
        "scale: found beside mean and deviation, expected one of both",
    ),
    (
        {"combine": "rows", "vary": [{**MASS, "values": [1]}, {**HEIGHT, "values": [1, 2]}]},
        "found rows beside link_0.mass of 1, link_0.y.0. of 2, expected equally many",
    ),
    (
        {"vary": [{**MASS, "from": 1, "to": 2}], "sample": {"by": "sobl", "count": 3}},
        "sample.by: found 'sobl', expected one of random, sobol",
    ),
    (
        {"vary": [{**MASS, "from": 1, "to": 2}], "sample": {"count": 0}},
        "sample.count: found 0, expected a whole number, at least 1",
    ),
    ({"vary": [{**MASS, "values": [1]}], "at": [0.1], "times": 3}, "at, times: found both, expected one"),
    ({"vary": [{**MASS, "values": [1]}], "at": [99.0]}, "at: found 99 s, expected a row of times from 0"),
    ({"vary": [{**MASS, "values": [1]}], "run": {"rtol": 3}}, "run: rtol: found 3"),
    (
        {"vary": [{**MASS, "values": [1]}], "observe": ["link_0.angl"]},
        "observe: found 'link_0.angl', which nothing is called",
    ),
    ({"vary": [{**MASS, "values": [1]}], "color": 1}, "color: found an unknown key, expected one of observe"),
    ({"table": {"file": "none.csv"}}, "table.file: found 'none.csv', expected a CSV file"),
]


@pytest.mark.parametrize(("tables", "text"), WRONG)
def test_wrong_plans(model: Model, tables: dict[str, Any], text: str) -> None:
    with pytest.raises(PlanError, match=f"plan.toml: .*{text}|plan.toml: {text}"):
        plan(model, **tables)


def test_every_fault_at_once(model: Model) -> None:
    with pytest.raises(PlanError) as refusal:
        plan(model, part=0, color=1, vary=[{**MASS, "values": []}], run={"until": -1})
    assert len(str(refusal.value).splitlines()) == 4
    with pytest.raises(PlanError, match="found no file, expected a plan"):
        read_plan("nowhere.toml", model)


def test_what_varies_at_the_start_may_be_observed(four_bar: Model) -> None:
    """The start's value and the output over time are two columns."""
    made = plan(
        four_bar,
        vary=[{"start": "crank.angle", "values": [0.3, 0.5]}],
        observe=["crank.angle"],
        times=3,
        run={"until": 0.1},
    )
    columns = make_chunk(four_bar, chunk_of(made, 0, 2), 1)
    assert columns["crank.angle(0)"].tolist() == [0.3, 0.5]
    assert columns["crank.angle"].shape == (2, 3)
    assert columns["crank.angle"][:, 0] == pytest.approx([0.3, 0.5], abs=1e-12)


def test_numbers_with_units(four_bar: Model, tmp_path: Path) -> None:
    """As scenes write them; read by the command, since the runtime knows no units."""
    file = tmp_path / "plan.toml"
    file.write_text(
        'at = [0, "500 ms"]\n[run]\nuntil = "0.5 s"\n'
        '[[vary]]\nstart = "crank.angle"\nfrom = "0 deg"\nto = "2*pi"\ncount = 3\n'
        '[[vary]]\nparameter = "crank.mass"\nvalues = ["200 g", 1]\n'
    )
    plan = read_plan(file, four_bar, written)
    rows = plan.rows(0, plan.count)
    assert rows["crank.mass"].tolist() == [0.2, 1.0] * 3 and plan.at == (0.0, 0.5) and plan.run["until"] == 0.5
    assert rows["crank.angle(0)"].tolist() == [0, 0, np.pi, np.pi, 2 * np.pi, 2 * np.pi]
    file.write_text(
        '[run]\nuntil = "3 kg"\n[[vary]]\nstart = "crank.angle"\nfrom = "20 mm"\nto = "1 rda"\ncount = 3\n'
        '[[vary]]\nparameter = "crank.mass"\nvalues = ["heavy"]\n'
    )
    with pytest.raises(PlanError) as refused:
        read_plan(file, four_bar, written)
    lines = str(refused.value).splitlines()
    assert [line.split(": ")[1] for line in lines] == ["run.until", "vary[0].from", "vary[0].to", "vary[1].values"]
    assert lines[1] == (
        f'{file}: vary[0].from: found "20 mm": that is a length, not an angle in rad; write one such as "30 deg"'
    )
    with pytest.raises(PlanError, match=r"vary\[1\].values: found \['heavy'\], expected a list of finite numbers"):
        read_plan(file, four_bar)
