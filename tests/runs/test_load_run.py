"""Runs made again from their files: all that they answer is as before, to the bit."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import Model, Run, load_model, load_run, simulate

from ..support.folders import SCENES
from ..support.workshop import Workshop
from .test_release_and_hold import TREBUCHET

WALKER = (SCENES / "simplest-walker.toml").read_text(encoding="utf-8")


def same(run: Run, other: Run) -> None:
    """All outputs at rows and between them, the state, and what is recorded."""
    t = np.linspace(run.t[0], run.t[-1], 29)
    assert type(other) is type(run) and repr(other) == repr(run)
    assert dict(other.outputs) == dict(run.outputs) and dict(other.model.parameters) == dict(run.model.parameters)
    for times in (None, t):
        one, two = run.values(*run.outputs, t=times), other.values(*run.outputs, t=times)
        assert all(np.array_equal(one[name], two[name], equal_nan=True) for name in one)
    assert all(np.array_equal(a, b) for a, b in zip(run.at(t), other.at(t), strict=True))
    assert run.phases == other.phases and run.changes == other.changes and run.message == other.message
    assert [repr(impact) for impact in run.impacts] == [repr(impact) for impact in other.impacts]
    assert [repr(event) for event in run.events] == [repr(event) for event in other.events]
    assert not other.q.flags.writeable


@pytest.mark.sample(2)
@pytest.mark.parametrize("scene", ["falling-hexagon", "trebuchet", "simplest-walker"])
def test_a_run_answers_as_before(scene: str, workshop: Workshop, tmp_path: Path) -> None:
    """With impacts; with joints that let go; with events that switch effects, whose models lie beside its own."""
    texts = {"trebuchet": TREBUCHET, "simplest-walker": WALKER}
    model = workshop.model(texts.get(scene) or load_scene(SCENES / f"{scene}.toml"))
    run = simulate(model, until=1.3 if scene != "simplest-walker" else 4.5)
    same(run, load_run(run.save(tmp_path / "run.npz"), load_model(model.folder)))


def test_it_goes_on_from_there(workshop: Workshop, tmp_path: Path) -> None:
    model = workshop.model(load_scene(SCENES / "falling-hexagon.toml"))
    run = simulate(model, until=0.8, params={"ground_0.restitution": 0.25})
    loaded = load_run(run.save(tmp_path / "run.npz"), model)
    values = {"ground_0.restitution": 0.25}
    on = [simulate(model, state=one.state, until=1.2, params=values) for one in (run, loaded)]
    assert np.array_equal(on[0].q, on[1].q) and len(on[0].impacts) == len(on[1].impacts) > 0


def test_time_stepping_and_inputs_are_kept(workshop: Workshop, tmp_path: Path) -> None:
    """States between steps in time; forces under a table of inputs. A controller is no part of a file: rows remain."""
    model = workshop.model(PUSHED)
    table = {"t": [0.0, 1.0, 2.0], "push": [0.0, 3.0, -1.0]}
    run = simulate(model, inputs=table)
    same(run, load_run(run.save(tmp_path / "table.npz"), model))
    stepped = simulate(model, inputs=table, method="moreau", step=1e-2)
    same(stepped, load_run(stepped.save(tmp_path / "steps.npz"), model))
    controlled = simulate(model, inputs=lambda t, q, u: [-2.0 * u[0]])
    loaded = load_run(controlled.save(tmp_path / "controlled.npz"), model)
    assert np.array_equal(loaded["cart.C.x"], controlled["cart.C.x"])
    with pytest.raises(ValueError, match="without its controller"):
        loaded.at(0.123)


PUSHED = """
name = "pushed"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "cart"
mass = 2
inertia = 0.1
com = [0, 0]
points = { C = [0, 0] }
[[joint]]
name = "rail"
type = "prismatic"
between = ["ground.O", "cart.C"]
axis = [1, 0]
[[input]]
name = "push"
joint = "rail"
[run]
until = 2
"""


def test_files_that_are_none_are_refused(workshop: Workshop, tmp_path: Path) -> None:
    model: Model = workshop.model(PUSHED)
    run = simulate(model)
    file = run.save(tmp_path / "run.npz")
    with pytest.raises(FileNotFoundError, match=r"none\.npz: found no such file, expected the \.npz file of a run"):
        load_run(tmp_path / "none.npz", model)
    with pytest.raises(FileNotFoundError, match="found a folder"):
        load_run(tmp_path, model)
    with pytest.raises(TypeError, match="model: found str"):
        load_run(file, "build/pushed")  # type: ignore[arg-type]
    other = workshop.model(load_scene(SCENES / "falling-hexagon.toml"))
    with pytest.raises(ValueError, match=r"found a run of pushed, expected one of falling-hexagon"):
        load_run(file, other)
    (tmp_path / "text.npz").write_text("no run")
    assert run.state is not None
    run.state.save(tmp_path / "state.npz")
    (tmp_path / "cut.npz").write_bytes(file.read_bytes()[:-200])
    for name in ("text", "state", "cut"):
        with pytest.raises(
            ValueError, match=rf"{name}\.npz: found no run, expected a file as ccgen run \(result\.npz\)"
        ):
            load_run(tmp_path / f"{name}.npz", model)


@pytest.mark.parametrize("version", [None, 1, 1000])
def test_files_of_another_ccgen_are_refused_in_words(version: int | None, workshop: Workshop, tmp_path: Path) -> None:
    """As those before contacts lost their shares of friction, which have no number."""
    model = workshop.model(PUSHED)
    with np.load(simulate(model).save(tmp_path / "run.npz")) as found:
        arrays = {name: array for name, array in found.items() if name != "record_version"}
    if version is not None:
        arrays["record_version"] = np.array(version)
    np.savez(tmp_path / "other.npz", **arrays)
    told = rf"other\.npz: found a run as another ccgen records it, record_version {version or 1}, expected 3"
    with pytest.raises(ValueError, match=told):
        load_run(tmp_path / "other.npz", model)


def test_a_file_makes_nothing_but_records_of_runs(workshop: Workshop, tmp_path: Path) -> None:
    """Names of other classes, and what the text should not hold, are refused, whatever they say."""
    model = workshop.model(PUSHED)
    file = simulate(model).save(tmp_path / "run.npz")
    with np.load(file) as found:
        arrays = dict(found)
    text = arrays["record"].tobytes().decode()
    for wrong in (
        text.replace("run.Run", "subprocess.Popen"),
        text.replace("simulation.advance.Advance", "files.write_whole"),
        text.replace('["package","', '["package","../'),
        '{"array":["float64",0,1000000000]}',
        '{"again":3}',
        "[" * 100_000,
        "{}",
        "1",
    ):
        assert wrong != text
        arrays["record"] = np.frombuffer(wrong.encode(), dtype=np.uint8)
        np.savez(tmp_path / "wrong.npz", **arrays)
        with pytest.raises(ValueError, match="found no run"):
            load_run(tmp_path / "wrong.npz", model)


def test_damage_anywhere_is_told(workshop: Workshop, tmp_path: Path) -> None:
    """A file without one of its arrays is no run, or the run as it was where the array is there for readers alone."""
    model = workshop.model(PUSHED)
    run = simulate(model)
    whole = run.save(tmp_path / "run.npz").read_bytes()
    with zipfile.ZipFile(io.BytesIO(whole)) as archive:
        names = archive.namelist()
    refused = 0
    for left_out in names:
        with zipfile.ZipFile(io.BytesIO(whole)) as archive, zipfile.ZipFile(tmp_path / "part.npz", "w") as part:
            for name in names:
                if name != left_out:
                    part.writestr(name, archive.read(name))
        try:
            same(run, load_run(tmp_path / "part.npz", model))
        except ValueError:
            refused += 1
    assert 5 <= refused < len(names)


def test_a_model_that_has_changed_is_told(workshop: Workshop, tmp_path: Path) -> None:
    model = workshop.model(PUSHED)
    file = simulate(model).save(tmp_path / "run.npz")
    with pytest.raises(ImportError, match="found another model"):
        load_run(file, workshop.model(PUSHED.replace("mass = 2", "mass = 3")))
