"""Loads generated models and simulates them: ``simulate(load_model("build/loop6"))``. Needs NumPy alone."""

from ._core import methods
from .analysis import inverse_dynamics, momentum
from .crank import DrivingTorque, driving_torque
from .equilibrium import Equilibrium, static_equilibrium
from .load import load_model
from .model import Model
from .run import Impact, Phase, Run
from .simulate import simulate

__all__ = [
    "DrivingTorque",
    "Equilibrium",
    "Impact",
    "Model",
    "Phase",
    "Run",
    "driving_torque",
    "inverse_dynamics",
    "load_model",
    "methods",
    "momentum",
    "simulate",
    "static_equilibrium",
]
