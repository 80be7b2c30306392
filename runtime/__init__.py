"""Loads generated models and simulates them: ``simulate(load_model("build/loop6"))``. Needs NumPy alone."""

from ._core import methods
from .analysis.crank import DrivingTorque, driving_torque
from .analysis.equilibrium import Equilibrium, static_equilibrium
from .analysis.follow import Followed, follow
from .analysis.inverse_dynamics import inverse_dynamics, momentum
from .analysis.linearise import Linear, Modes, linearise
from .analysis.reach import OutOfReach, reach
from .directional import directional
from .ensemble.ensemble import ensemble
from .ensemble.reduction import Reduction
from .ensemble.table import Ensemble
from .fitting.curve import Fitted, fit
from .fitting.identify import Identified, identify
from .functions.acceleration_function import AccelerationFunction, acceleration_function
from .functions.run_function import RunFunction, run_function
from .load_run import load_run
from .loading.load import load_model
from .model.model import Model
from .orbits.bifurcation import Bifurcation
from .orbits.branch import Branch, continue_orbit
from .orbits.doubling import double_period
from .orbits.find import find_orbit
from .orbits.orbit import Orbit
from .record.event import Event
from .record.hybrid_state import HybridState
from .record.impact import Impact
from .record.phase import Phase
from .run import Run
from .sensitivities import sensitivities
from .sensitivity.jacobian import Sensitivities
from .simulate import simulate

__all__ = [
    "AccelerationFunction",
    "Bifurcation",
    "Branch",
    "DrivingTorque",
    "Ensemble",
    "Equilibrium",
    "Event",
    "Fitted",
    "Followed",
    "HybridState",
    "Identified",
    "Impact",
    "Linear",
    "Model",
    "Modes",
    "Orbit",
    "OutOfReach",
    "Phase",
    "Reduction",
    "Run",
    "RunFunction",
    "Sensitivities",
    "acceleration_function",
    "continue_orbit",
    "directional",
    "double_period",
    "driving_torque",
    "ensemble",
    "find_orbit",
    "fit",
    "follow",
    "identify",
    "inverse_dynamics",
    "linearise",
    "load_model",
    "load_run",
    "methods",
    "momentum",
    "reach",
    "run_function",
    "sensitivities",
    "simulate",
    "static_equilibrium",
]
