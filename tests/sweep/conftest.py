"""What tests of sweeps share: a hexagon that is dropped, a plan of 99 runs, and the folder of these, never stopped."""

from __future__ import annotations

from pathlib import Path

import pytest

from ccgen.generator import load_scene
from ccgen.runtime import Model
from ccgen.runtime.sweep.sweep import sweep

from ..support.sweep_scene import PLAN, SCENE
from ..support.workshop import Workshop


@pytest.fixture(scope="session")
def model(workshop: Workshop) -> Model:
    return workshop.model(load_scene(SCENE))


@pytest.fixture(scope="session")
def plan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("plan") / "plan.toml"
    file.write_text(PLAN)
    return file


@pytest.fixture(scope="session")
def whole(model: Model, plan: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a sweep that was never stopped."""
    folder = tmp_path_factory.mktemp("whole") / "out"
    sweep(model, plan, folder)
    return folder
