"""What a sweep is told apart by: a folder, or a run of it, is refused where anything that its rows follow from is other
than it was; and pictures of maps."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy

from ccgen.runtime import Model, ensemble
from ccgen.runtime.sweep import source as source_module
from ccgen.runtime.sweep.chart import draw_sweep
from ccgen.runtime.sweep.folder import manifest_of
from ccgen.runtime.sweep.plan import Plan, PlanError, plan_of, read_plan
from ccgen.runtime.sweep.results import Results
from ccgen.runtime.sweep.source import hash_of_runtime, python_sources
from ccgen.runtime.sweep.sweep import sweep

from ..support.workshop import Workshop

SHORT = {"until": 0.01}


def plan_for(model: Model, **tables: Any) -> Plan:
    return plan_of({"run": SHORT, **tables}, model, "plan.toml", repr(tables), Path())


def test_a_table_that_has_changed(model: Model, tmp_path: Path) -> None:
    """Its numbers are in no hash of the plan's text, which names the file alone."""
    table, text = tmp_path / "designs.csv", '[run]\nuntil = 0.01\n[table]\nfile = "designs.csv"\n'
    table.write_text("link_0.mass\n1\n2\n")
    (tmp_path / "plan.toml").write_text(text)
    results = sweep(model, read_plan(tmp_path / "plan.toml", model), tmp_path / "out")
    assert results.run(model, read_plan(tmp_path / "plan.toml", model), 1).model.parameters["link_0.mass"] == 2.0
    table.write_text("link_0.mass\n1\n3\n")
    changed = read_plan(tmp_path / "plan.toml", model)
    with pytest.raises(PlanError, match=r"manifest.json: found another tables than is given; give the same"):
        results.run(model, changed, 0)
    with pytest.raises(PlanError, match="found a sweep with another tables, expected the same to go on with"):
        sweep(model, changed, tmp_path / "out")


NORMAL = {"parameter": "link_0.mass", "mean": 2.0, "deviation": 0.1}
EVEN = {"parameter": "link_0.mass", "from": 1.0, "to": 2.0}


@pytest.mark.parametrize(
    ("vary", "by", "asked"), [(NORMAL, "random", True), (EVEN, "sobol", True), (EVEN, "random", False)]
)
def test_what_draws_is_recorded(
    model: Model, tmp_path: Path, monkeypatch: Any, vary: dict[str, Any], by: str, asked: bool
) -> None:
    """SciPy makes normal numbers, and samples but random ones: another version is refused, where it has drawn."""
    plan = plan_for(model, vary=[vary], sample={"by": by, "count": 2})
    sweep(model, plan, tmp_path / "out")
    assert manifest_of(model, plan)["versions"].get("scipy") == (scipy.__version__ if asked else None)
    monkeypatch.setattr(scipy, "__version__", "another")
    if not asked:
        sweep(model, plan, tmp_path / "out")
        return
    with pytest.raises(PlanError, match="found a sweep with another versions, expected the same"):
        sweep(model, plan, tmp_path / "out")
    with pytest.raises(PlanError, match="found another versions than is given"):
        Results(tmp_path / "out").run(model, plan, 0)


def test_the_runtime_is_the_core_and_its_python(model: Model, tmp_path: Path, monkeypatch: Any) -> None:
    """A line of any of its files makes it another."""
    names = {"/".join(file.parts[-2:]) for file in python_sources()}
    assert {"ensemble/compiled.py", "sweep/starts.py", "model/assembly.py"} <= names
    plan = plan_for(model, vary=[{"parameter": "link_0.mass", "values": [1, 2]}])
    sweep(model, plan, tmp_path / "out")
    before = hash_of_runtime(model)
    files = []
    for number, file in enumerate(python_sources()):
        files.append(tmp_path / f"{number:03d}.py")
        files[-1].write_bytes(file.read_bytes())
    monkeypatch.setattr(source_module, "python_sources", lambda: files)
    assert hash_of_runtime(model) == before
    files[-1].write_text(files[-1].read_text() + "\n")
    assert hash_of_runtime(model) != before
    with pytest.raises(PlanError, match="found a sweep with another runtime, expected the same"):
        sweep(model, plan, tmp_path / "out")


TWICE = """
name = "twice"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "a"
mass = 1.0
inertia = 0.1
com = [0.5, 0]
points = { A = [0, 0], B = [1, 0], B2 = [1, 0] }
[[link]]
name = "b"
mass = 1.0
inertia = 0.1
com = [0.5, 0]
points = { A = [0, 0], A2 = [0, 0], B = [1, 0] }
[[joint]]
name = "j0"
between = ["ground.O", "a.A"]
[[joint]]
name = "j1"
between = ["a.B", "b.A"]
[[joint]]
name = "j2"
between = ["a.B2", "b.A2"]
[gravity]
g = 9.81
"""
"""Two joints at one point: the second holds nothing while its points stay where they are."""


def test_parameters_that_joints_rest_on(workshop: Workshop) -> None:
    """Another value would open a joint that the equations leave out: refused before the first run."""
    model, path = workshop.model(TWICE), "a.points.B2.x"
    with pytest.raises(PlanError, match=rf"vary\[0\].parameter: found '{path}', expected another parameter: only with"):
        plan_for(model, vary=[{"parameter": path, "values": [1.0, 1.5]}])
    with pytest.raises(ValueError, match=f"{path}: found 1.5, expected 1.0, because only with that j2 holds"):
        ensemble(model, {path: [1.0, 1.5]}, until=0.01)
    assert set(ensemble(model, {path: [1.0, 1.0]}, until=0.01).status) == {"done"}


MAPS = [
    ("grid", [1.0, 2.0], [1.0, 2.0], "QuadMesh"),
    ("rows", [1.0, 1.0, 2.0, 2.0], [1.0, 2.0, 1.0, 2.0], "QuadMesh"),
    ("rows", [1.0, 1.0, 2.0, 2.0], [1.0, 1.0, 2.0, 2.0], "PathCollection"),
    ("rows", [1.0, 2.0, 3.0], [1.0, 2.0, 2.0], "PathCollection"),
]


@pytest.mark.parametrize(("combine", "masses", "inertias", "kind"), MAPS)
def test_maps_have_cells_where_there_is_a_grid(
    model: Model, tmp_path: Path, combine: str, masses: list[float], inertias: list[float], kind: str
) -> None:
    """Four rows of two and two values need not be four places; then they are drawn as points."""
    vary = [{"parameter": "link_0.mass", "values": masses}, {"parameter": "link_0.inertia", "values": inertias}]
    plan = plan_for(model, combine=combine, vary=vary, observe=["joint_0.y"])
    figure = draw_sweep(sweep(model, plan, tmp_path / "out"), tmp_path / "sweep.png")
    panel = figure.axes[0]
    assert [type(drawn).__name__ for drawn in panel.collections] == [kind]
    drawn = panel.collections[0].get_array()
    assert np.ma.count(drawn) == (4 if combine == "grid" else len(masses))
    assert panel.get_title() == "joint_0.y [m]" and panel.get_xlabel() == "link_0.mass"


@pytest.mark.parametrize("names", [["link_0.mass"], ["link_0.mass", "gravity.g"]])
def test_what_is_drawn_at_random_has_histograms_too(model: Model, tmp_path: Path, names: list[str]) -> None:
    """Beside a curve or a map the runs are counted, all of them, over the values that the table has."""
    vary = [{"parameter": name, "from": 1.0, "to": 2.0} for name in names]
    plan = plan_for(model, vary=vary, sample={"by": "latin", "count": 50}, observe=["joint_0.y", "potential_energy"])
    results = sweep(model, plan, tmp_path / "out")
    figure = draw_sweep(results, tmp_path / "sweep.png")
    panels = [axes for axes in figure.axes if axes.get_ylabel() == "runs"]
    assert [axes.get_xlabel() for axes in panels] == ["joint_0.y [m]", "potential_energy [J]"]
    for axes, name in zip(panels, ("joint_0.y", "potential_energy"), strict=True):
        assert sum(bar.get_height() for bar in axes.patches) == 50
        values = results.column(name)
        ends = axes.patches[0].get_x(), axes.patches[-1].get_x() + axes.patches[-1].get_width()
        assert values.max() == values.min() or ends == pytest.approx((values.min(), values.max()))
    assert len([axes for axes in figure.axes if axes.get_title()]) == 2
    grid = plan_for(model, vary=[{**one, "count": 3} for one in vary], observe=["joint_0.y"])
    figure = draw_sweep(sweep(model, grid, tmp_path / "grid"), tmp_path / "grid.png")
    assert not [axes for axes in figure.axes if axes.get_ylabel() == "runs"]


def test_a_map_says_which_time_it_is_of(model: Model, tmp_path: Path) -> None:
    vary = [{"parameter": "link_0.mass", "values": [1.0, 2.0]}, {"parameter": "link_0.inertia", "values": [1.0, 2.0]}]
    plan = plan_for(model, vary=vary, observe=["joint_0.y", "max(joint_0.y)"], at=[0.0, 0.005])
    figure = draw_sweep(sweep(model, plan, tmp_path / "out"), tmp_path / "sweep.png")
    titles = [axes.get_title() for axes in figure.axes if axes.get_title()]
    assert titles == ["joint_0.y [m] at t = 0.005 s", "max(joint_0.y) [m]"]
