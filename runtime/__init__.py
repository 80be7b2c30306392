"""Loads generated models and simulates them: ``simulate(load_model("build/loop6"))``. Needs NumPy alone."""

from ._core import methods
from .model import Model, load_model, open_model
from .run import Impact, Phase, Run
from .simulate import simulate

__all__ = ["Impact", "Model", "Phase", "Run", "load_model", "methods", "open_model", "simulate"]
