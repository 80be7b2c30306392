"""What a run is asked for: defaults, limits, and the refusal of what cannot be simulated."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .._core import DRIFTS, GAINS, methods
from ..arrays import FloatArray
from ..faults import Faults
from ..model.assembly import project, put_onto_closure
from ..model.drives import drive_misses, drive_rows, drive_speeds, put_where_driven
from ..model.kinks import kinks_until
from ..model.model import Model
from ..model.numbers import read_numbers, told
from ..model.time_scales import ends_of_pieces
from ..model.tolerances import start_miss
from .without_value import check_values

STEP_BUDGET = 10_000_000
"""Steps of a run, refused ones included."""
RATE_BUDGET = 200_000
"""Steps, refused ones and events included, within a characteristic time, or a tenth of the duration if that is less."""
METHODS, ESTIMATING = methods(), methods(estimating=True)
"""All, and those that choose their steps."""
TIME_STEPPING = "moreau"
"""The method without events: docs/theory, section 5.11."""
LEAST = {"float": 1e-6, "double": 1e-15, "wide": 1e-18}
"""Least tolerance by the precision of a model's numbers."""
DRIVEN = 1e-6
"""A start that the closure puts this far from where its driven joints are to be, or this part of its speeds from how
fast, is refused: loops of a state may miss by as much (JOINT_MISS). What is nearer is put right."""
DEPTH = 1e-8
"""A start deeper inside a ground than this, relative to the mechanism's length, is refused; less is rounding."""

NUMBERS, YES_OR_NO = (float, int, np.floating, np.integer), (bool, np.bool_)
"""Kinds that arguments may be of; a union of them, made anew at every call, would take a microsecond of a short run."""


class Settings(NamedTuple):
    """How a run goes: ``step`` is that of steps of fixed length, else zero; ``own_rtol`` the scene's tolerance."""

    until: float
    rtol: float
    atol: float
    step: float
    method: str
    drift: str
    on_gain: str
    own_rtol: float


def _breaking(model: Model) -> str:
    """The first joint that lets go at a force or an impulse; empty where none does."""
    changes = (model.data.get("switching") or {}).get("changes", ())
    return next((str(one["joint"]) for one in changes if one["force"] or one["impulse"]), "")


def settings_of(
    model: Model,
    until: float | None,
    rtol: float | None,
    atol: float | None,
    step: float | None,
    method: str | None,
    drift: str | None,
    on_gain: str | None,
    *,
    controlled: bool,
    before: Mapping[str, Any] | None = None,
) -> Settings:
    """What is asked for, and for the rest what a run ``before`` had, if this goes on from it, or what the scene says.

    Raises ``ValueError`` for what cannot be simulated.
    """
    faults = Faults()
    if before is not None:
        if method is not None and not _is_one_of(method, (before["method"],)):
            faults.add(
                f"method: found {method!r}, expected {before['method']!r}, by which the state was reached; begin from "
                "its q and u to go on by another"
            )
        atol = before["atol"] if rtol is None and atol is None else atol
        rtol = before["rtol"] if rtol is None else rtol
        method, step = before["method"], (before["step"] or None) if step is None else step
        drift = before["drift"] if drift is None else drift
        on_gain = before["on_gain"] if on_gain is None else on_gain
    drift = DRIFTS[0] if drift is None else drift
    scene, least = model.data["run"], LEAST[model.precision]
    on_gain = scene["on_gain"] if on_gain is None else on_gain
    own = max(scene["rtol"], least)
    end: float = scene["until"] if until is None else until
    relative: float = own if rtol is None else rtol
    absolute: float = (scene["atol"] or relative) if atol is None else atol
    name = default_method(controlled=controlled) if method is None else method
    with faults.collecting():
        check_until(end)
    with faults.collecting():
        check_rtol(relative, least)
    if atol is not None:
        with faults.collecting():
            check_positive("atol", atol)
    with faults.collecting():
        check_method(name, step)
    if _is_one_of(name, (TIME_STEPPING,)) and (breaking := _breaking(model)):
        faults.add(
            f"method: found {name!r}, expected one that finds impacts, because {breaking} lets go at a force or an "
            "impulse, which steps over impacts do not tell; choose another"
        )
    if step is not None:
        with faults.collecting():
            check_step(step, end)
    if not _is_one_of(drift, DRIFTS):
        faults.add(f"drift: found {drift!r}, expected one of {', '.join(DRIFTS)}; choose one")
    if not _is_one_of(on_gain, GAINS):
        faults.add(f"on_gain: found {on_gain!r}, expected one of {', '.join(GAINS)}; choose one")
    faults.stop_if_any()
    return Settings(float(end), float(relative), float(absolute), float(step or 0.0), name, drift, on_gain, own)


def default_method(*, controlled: bool = False) -> str:
    """The fastest where motions are smooth, and with contacts the most exact in the same time, "gauss"; where a
    controller is asked for every state (``controlled``), "dop853", which asks for fewer."""
    return "dop853" if controlled else "gauss"


def stops_of(model: Model, kinks: FloatArray, until: float, step: float) -> FloatArray:
    """Times at which steps end: kinks of the inputs and of the effects, and, unless steps have a fixed length ``step``
    (s), where loads change faster than elsewhere."""
    own = kinks_until(model, until)
    if not step:
        own = own + ends_of_pieces(model, own, until)
    return np.unique(np.concatenate([kinks, own])) if own else kinks


def check_calls(progress: object, keep_interrupted: object) -> None:
    """Raise ``TypeError`` unless these arguments of a run are a function, or nothing, and yes or no."""
    faults = Faults()
    if progress is not None and not callable(progress):
        faults.note(TypeError(f"progress: found {progress!r}, expected a function of the time reached, or None"))
    if not isinstance(keep_interrupted, YES_OR_NO):
        faults.note(TypeError(f"keep_interrupted: found {keep_interrupted!r}, expected True or False"))
    faults.stop_if_any()


def check_positive(name: str, value: Any, of: str = "") -> None:
    """Raise ``ValueError`` unless an argument is a positive number ``of`` something."""
    if not _is_number(value) or not 0.0 < value < math.inf:
        raise ValueError(f"{name}: found {_shown(value)}, expected a positive number{of}; correct it")


def check_until(until: Any) -> None:
    """Raise ``ValueError`` unless this is a time at which a run can end: 0 too, where it has the start alone."""
    if not _is_number(until) or until != 0.0:
        check_lasting(until)


def check_lasting(until: Any) -> None:
    """Raise ``ValueError`` unless this is an end up to which something moves, as of a run that is measured."""
    check_positive("until", until, " of seconds")


def check_rtol(rtol: Any, least: float = LEAST["double"]) -> None:
    """Raise ``ValueError`` unless a relative tolerance is one that the model's numbers allow."""
    if not _is_number(rtol) or not least <= rtol < 1.0:
        raise ValueError(
            f"rtol: found {_shown(rtol)}, expected a number between 0 and 1, at least {least:g} by the model's "
            "numbers; correct it"
        )


def check_method(name: object, step: object) -> None:
    """Raise ``ValueError`` unless there is such a method, and it can choose its steps where no ``step`` is given."""
    if not _is_one_of(name, METHODS):
        raise ValueError(f"method: found {name!r}, expected one of {', '.join(METHODS)}; choose one")
    if step is None and name not in ESTIMATING:
        raise ValueError(
            f"step: found none beside method {name!r}, which has no estimate of its errors to choose steps by, "
            f"expected a number of seconds; give one, or choose one of {', '.join(ESTIMATING)}"
        )


def check_step(step: Any, until: Any) -> None:
    """Raise ``ValueError`` unless a step size gets a run to its end within its budget, which any that is lost in the
    last digit of time does not."""
    check_positive("step", step, " of seconds")
    if _is_number(until) and until / step >= STEP_BUDGET + 1:
        raise ValueError(
            f"step: found {step:g} s for a run to t = {until:g} s, expected at least {until / STEP_BUDGET:g} s, with "
            f"which {STEP_BUDGET} steps reach it; take a longer step or an earlier end"
        )


def _is_one_of(value: object, words: Sequence[str]) -> bool:
    return isinstance(value, str) and value in words


def _is_number(value: object) -> bool:
    if not isinstance(value, NUMBERS) or isinstance(value, bool):
        return False
    return not isinstance(value, int) or abs(value) <= sys.float_info.max


def _shown(value: object) -> str:
    return str(value) if _is_number(value) else told(value)


def read_start(model: Model, q0: ArrayLike | None, u0: ArrayLike | None) -> tuple[FloatArray, FloatArray]:
    """One state, that of the scene where none is given.

    Raises ``ValueError`` with all that is wrong with its numbers.
    """
    if q0 is None or u0 is None:
        own_q, own_u = model.start()
        q0, u0 = own_q if q0 is None else q0, own_u if u0 is None else u0
    size = (len(model.q_names),)
    if not (isinstance(q0, np.ndarray) and isinstance(u0, np.ndarray) and q0.shape == size == u0.shape):
        _check_shapes(model, q0, u0)
    (qs, us), _ = model._state(q0, u0, ("q0", "u0"))
    return qs[0], us[0]


def _check_shapes(model: Model, q0: ArrayLike, u0: ArrayLike) -> None:
    """Both are numbers of one state."""
    faults, shapes = Faults(), []
    for name, given in (("q0", q0), ("u0", u0)):
        with faults.collecting():
            shapes.append(read_numbers(given, name, model.core.REAL).shape)
    faults.stop_if_any()
    n = len(model.q_names)
    if any(len(shape) != 1 for shape in shapes):
        raise ValueError(f"q0, u0: found shapes {shapes[0]} and {shapes[1]}, expected ({n},) for both")


def checked_start(
    model: Model, q0: ArrayLike | None, u0: ArrayLike | None, begin: float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """A state from which a run can begin at t = ``begin`` (s), put onto the closure. Raises ``ValueError`` for others.

    Where driven joints are to be is known of t = 0; later they go on from where they are.
    """
    q0, u0 = read_start(model, q0, u0)
    _check_energy(model, q0, u0)
    driven = model.data["drives"] and begin == 0.0
    if driven:
        _check_speeds(model, u0, float(model.core.TOLERANCES["DRIVEN"].value))
    (q,), (u,) = put_onto_closure(model, q0[None], u0[None], single=True)
    if driven:
        q, u = _put_right(model, q, u)
    _check_outside(model, q, begin)
    check_values(model, q, u, begin)
    return q, u


def _check_outside(model: Model, q: FloatArray, begin: float) -> None:
    """A start, or the state at t = ``begin`` (s) from which a run goes on after a change, is inside nothing."""
    depths = -model.gaps(q) if model.contacts else np.zeros(0)
    if not depths.size or depths.max() <= max(0.0, DEPTH * model.length):
        return
    point, ground = model.contacts[int(np.argmax(depths))]
    deep = f"{depths.max():.6g} {'rad' if ground in model.stops else 'm'}"
    if ground in model.stops | model.slide_ends:
        _check_limits(model, ground)
        advice = "turn the start" if ground in model.stops else "move the start"
        found = f"has {point} beyond {ground} by {deep}"
    elif ground in {rope.name for rope in model.ropes}:
        found, advice = f"needs {ground} to be longer by {deep}", "change the start, or make it longer"
    else:
        found = f"has {point} inside {ground} by {deep}"
        advice = "raise or move the start" if ground in model.ground_planes() else "change the start or the radii"
    if begin:
        raise ValueError(f"what changes here {found}; let it come where there is room")
    raise ValueError(f"the start {found}; {advice}")


def _check_energy(model: Model, q0: FloatArray, u0: FloatArray) -> None:
    """The energy of a start is a number: of speeds from about 1e154 m/s on it is not."""
    found = model.kernels.of_state("energy", q0[None], u0[None])[0]
    if model.core.all_finite(found):
        return
    energies = found.tolist()
    for kind, energy in zip(("kinetic", "potential"), energies, strict=True):
        if not math.isfinite(energy):
            what, largest = ("u0", u0) if kind == "kinetic" else ("q0", q0)
            raise ValueError(
                f"{what}: found a start with a {kind} energy of {energy} J, expected a finite number; the largest "
                f"entry is {float(np.abs(largest).max()):.3g}"
            )


def _check_limits(model: Model, limit: str) -> None:
    """The limits of the stop that has ``limit`` leave room between them, as parameters set them."""
    lowest, highest = (f"{limit.rpartition('.')[0]}.{end}" for end in ("lowest", "highest"))
    low, high = (model.parameters.get(name) for name in (lowest, highest))
    if low is not None and high is not None and low >= high:
        raise ValueError(f"{lowest}: found {low:.6g}, expected less than {highest}, which is {high:.6g}; set both")


def _check_speeds(model: Model, u: FloatArray, part: float) -> None:
    """The velocities of a start have driven joints as fast as they are to be, to this ``part`` of the fastest.

    A driven joint keeps the speed with which it begins. As it is given, that may miss by what a step may leave of it
    (DRIVEN of the core), the root of rounding and ten times the usual tolerance: so states of other runs are starts.
    """
    most = part * max(1.0, float(np.abs(u).max()))
    for drive, miss in zip(model.data["drives"], drive_rows(model) @ u - drive_speeds(model), strict=True):
        if abs(miss) > most:
            unit = "m" if drive["slides"] else "rad"
            raise ValueError(
                f"u0: the driven joint {drive['joint']} misses the speed that is prescribed at t = 0 by "
                f"{abs(miss):.3g} {unit}/s, expected {most:.3g} {unit}/s at most; take u0 from model.start()"
            )


def _put_right(model: Model, q: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A start on the closure with driven joints where they are to be, and as fast, to rounding; ``ValueError`` for one
    that is too far from that."""
    places = np.abs(drive_misses(model, q))
    for drive, place in zip(model.data["drives"], places, strict=True):
        if place > DRIVEN * max(1.0, model.length):
            raise ValueError(
                f"q0: the driven joint {drive['joint']} is {place:.3g} {'m' if drive['slides'] else 'rad'} from where "
                "it is to be at t = 0; take q0 from model.start()"
            )
    _check_speeds(model, u, max(DRIVEN, float(model.core.TOLERANCES["DRIVEN"].value)))
    speeds = np.abs(drive_rows(model) @ u - drive_speeds(model))
    near = start_miss(model.core.REAL, model.length)
    if places.max() <= near and speeds.max() <= near / model.length * max(1.0, float(np.abs(u).max())):
        return q, u
    return project(model, *put_where_driven(model, q, u))
