"""Simulates a model through flight and impact: one compiled run, and the record made from it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ._core import DRIFTS, methods
from .advance import Advance
from .dead_point import cut, dead_point
from .drives import drive_misses, drive_rows, drive_speeds, driven_against
from .failed_impact import failed_impact
from .forces import along, impulses_of_joints
from .frames import FloatArray
from .inputs import Given, supply_of
from .model import Model
from .run import Impact, Phase, Run

STEP_BUDGET = 10_000_000
"""Steps of a run, refused ones included."""
SECOND_BUDGET = 200_000
"""Steps, refused ones and events included, of one simulated second."""
LEAST = {"float": 1e-6, "double": 1e-15, "wide": 1e-18}
"""Least tolerance by the precision of a model's numbers."""
DRIVEN = 1e-6
"""A start whose driven joints move otherwise than prescribed by more than this part of its speeds is refused."""
AUDITED = 4
"""Rows of a run, at most, at which the rounding of its accelerations is measured."""
GOES_ON = ("done", "interrupted", "no_memory")
"""Ends of a run that say nothing of the motion after it."""
DEPTH = 1e-8
"""A start deeper inside a ground than this, relative to the mechanism's length, is refused; less is rounding."""


def simulate(
    model: Model,
    q0: ArrayLike | None = None,
    u0: ArrayLike | None = None,
    until: float | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    method: str | None = None,
    params: Mapping[str, float] | None = None,
    inputs: Given = None,
    *,
    step: float | None = None,
    drift: str = "projected",
    progress: Callable[[float], object] | None = None,
    keep_interrupted: bool = False,
) -> Run | Any:
    """Integrate ``model`` from (``q0``, ``u0``) at t = 0 to ``until`` (s).

    A batch of starts, ``q0`` (b, nq) and ``u0`` (b, nu) or one for all, gives a list of runs, made side by side on the
    machine's processors and equal to single runs in every bit. Where Ctrl-C ends it and ``keep_interrupted`` is set,
    the list holds the runs of the first starts: those done, and those in progress as far as they came.

    Start, end and tolerances come from the scene unless given; ``atol`` is ``rtol`` unless given. Where the scene's
    ``rtol`` is less than the model's numbers allow, as 1e-9 is in floats, the least that they allow is taken: 1e-6 in
    floats, 1e-15 in doubles, 1e-18 in wide numbers. ``params`` are values by scene path for this run only.
    ``step`` (s) fixes the step size instead of choosing it by the error estimate; a run has at most ten million steps.
    ``method`` is one of :func:`ccgen.runtime.methods`: "gauss", "dop853", "dopri5" or "radau", for stiff scenes; unless
    given, :func:`default_method`. ``drift`` says how the loops are kept shut: "projected" after every step; for
    comparison, "left" as the integration leaves them, or "damped" by Baumgarte's stabilisation. While contacts are
    held, loops and contacts are projected in any case.
    ``progress`` is called with the time reached, now and then. The start is projected onto the closure. Ctrl-C raises
    ``KeyboardInterrupt``, or with ``keep_interrupted`` ends the run there and keeps it.

    ``inputs`` are values of the model's inputs: constants by name or in order; a table ``{"t": [...], name: [...]}``,
    interpolated linearly and constant outside; or a controller, called as ``inputs(t, q, u)`` whenever accelerations
    are needed. What a controller raises ends the run and is raised here.

    The run's ``success`` is false when it stopped before the end; ``message`` then says where, why, and what to try,
    and the run holds everything up to there. Raises ``ValueError`` for arguments that cannot be simulated: wrong
    shapes, numbers that are not finite, an unknown method, too short a ``step``, a start inside a ground.
    """
    if not isinstance(model, Model):
        raise TypeError(f"model: found {type(model).__name__}, expected a Model; load one with load_model(folder)")
    if q0 is not None and np.ndim(q0) == 2:
        from .batch import simulate_batch

        options: dict[str, Any] = {"until": until, "rtol": rtol, "atol": atol, "method": method, "params": params}
        options |= {"inputs": inputs, "step": step, "drift": drift, "keep_interrupted": keep_interrupted}
        return simulate_batch(model, q0, u0, progress=progress, **options)
    model = model.with_parameters(params) if params else model.as_it_is()
    if model.precision == "float" and model.contacts:
        raise ValueError(
            f"{model.name}: found a model in floats with contacts, expected none: floats are too coarse to find "
            'impacts; generate it with precision="double"'
        )
    supply, kinks = supply_of(model.inputs, inputs, model.core.Supply)
    settings = model.data["run"]
    until = _positive("until", settings["until"] if until is None else until)
    least = LEAST[model.precision]
    rtol = _positive("rtol", max(settings["rtol"], least) if rtol is None else rtol)
    atol = _positive("atol", (settings["atol"] or rtol) if atol is None else atol)
    fixed = 0.0 if step is None else _step(step, until)
    name = default_method(model, controlled=callable(inputs)) if method is None else method
    if name not in methods():
        raise ValueError(f"method: found {name!r}, expected one of {', '.join(methods())}")
    if drift not in DRIFTS:
        raise ValueError(f"drift: found {drift!r}, expected one of {', '.join(DRIFTS)}")
    if not least <= rtol < 1.0:
        raise ValueError(f"rtol: found {rtol}, expected a number from {least:g} to 1")
    q, u = _start(model, q0, u0)
    stops = _stops(model, kinks)
    found = model.kernels.simulate(
        q, u, name, until, rtol, atol, fixed, STEP_BUDGET, SECOND_BUDGET, progress, supply, stops, drift
    )
    if found["outcome"] == "interrupted" and not keep_interrupted:
        raise KeyboardInterrupt
    if model.data["drives"] and found["outcome"] not in GOES_ON:
        own = max(settings["rtol"], least)
        exact = Advance(model, name, drift, found["hold_t"], found["held"], (own, own), inputs, supply)
        if met := dead_point(model, found["t"], found["q"], found["u"], fixed, exact):
            found = cut(found, met.rows) | {"met": met.text}
    tolerances = (0.0, 0.0) if fixed else (rtol, atol)
    advance = Advance(model, name, drift, found["hold_t"], found["held"], tolerances, inputs, supply)
    return _record(model, advance, until, found, fixed > 0.0)


def default_method(model: Model, *, controlled: bool = False) -> str:
    """The fastest where motions are smooth, "gauss"; for a model with contacts, whose flights impacts cut short, and
    where a controller is asked for every state (``controlled``), "dop853"."""
    return "dop853" if model.contacts or controlled else "gauss"


def _stops(model: Model, kinks: FloatArray) -> FloatArray:
    """Times at which steps end: kinks of the inputs and of the effects."""
    own = [model.parameters[path] for path in model.data["instants"]]
    if not own and not kinks.size:
        return kinks
    return np.unique(np.concatenate([kinks, own]))


def _positive(name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not 0.0 < value < math.inf:
        raise ValueError(f"{name}: found {value!r}, expected a positive number")
    return float(value)


def _step(step: float, until: float) -> float:
    """A step size by which a run gets to its end within its budget, which any that is lost in the last digit of time
    does not."""
    fixed = _positive("step", step)
    if until / fixed >= STEP_BUDGET + 1:
        raise ValueError(
            f"step: found {fixed:g} s for a run to t = {until:g} s, expected at least {until / STEP_BUDGET:g} s, with "
            f"which {STEP_BUDGET} steps reach it; take a longer step or an earlier end"
        )
    return fixed


def _start(model: Model, q0: ArrayLike | None, u0: ArrayLike | None) -> tuple[FloatArray, FloatArray]:
    if q0 is None or u0 is None:
        own_q, own_u = model.start()
        q0, u0 = own_q if q0 is None else q0, own_u if u0 is None else u0
    if np.ndim(q0) != 1 or np.ndim(u0) != 1:
        n = len(model.q_names)
        raise ValueError(f"q0, u0: found shapes {np.shape(q0)} and {np.shape(u0)}, expected ({n},) for both")
    _check_energy(model, q0, u0)
    q, u = model.project(q0, u0)
    if model.data["drives"]:
        _check_driven(model, q, u)
    depths = -model.gaps(q) if model.contacts else np.zeros(0)
    if depths.size and depths.max() > 0.0 and depths.max() > DEPTH * model.length:
        point, ground = model.contacts[int(np.argmax(depths))]
        if ground in model.stops:
            _check_limits(model, ground)
            raise ValueError(f"the start has {point} beyond {ground} by {depths.max():.6g} rad; turn the start")
        advice = "raise or move the start" if ground in model.ground_planes() else "change the start or the radii"
        raise ValueError(f"the start has {point} inside {ground} by {depths.max():.6g} m; {advice}")
    return q, u


def _check_energy(model: Model, q0: ArrayLike, u0: ArrayLike) -> None:
    """The energy of a start is a number: of speeds from about 1e154 m/s on it is not."""
    energies = dict(zip(("kinetic", "potential"), model.energy(q0, u0), strict=True))
    for kind, energy in energies.items():
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


def _check_driven(model: Model, q: FloatArray, u: FloatArray) -> None:
    """A start has driven joints where they are to be, and as fast."""
    places, speeds = drive_misses(model, q), drive_rows(model) @ u - drive_speeds(model)
    for drive, place, speed in zip(model.data["drives"], places, speeds, strict=True):
        unit = "m" if drive["slides"] else "rad"
        if abs(place) > DRIVEN * max(1.0, model.length):
            raise ValueError(
                f"q0: the driven joint {drive['joint']} is {abs(place):.3g} {unit} from where it is to be at t = 0; "
                "take q0 from model.start()"
            )
        if abs(speed) > DRIVEN * max(1.0, float(np.abs(u).max())):
            raise ValueError(
                f"u0: the driven joint {drive['joint']} misses the speed that is prescribed at t = 0 by "
                f"{abs(speed):.3g} {unit}/s; take u0 from model.start()"
            )


def _record(model: Model, advance: Advance, until: float, found: dict[str, Any], fixed: bool) -> Run:
    """The run from what the core recorded, with its audits."""
    impacts = _impacts(model, found)
    t, q, u = found["t"], found["q"], found["u"]
    spent = found["work"]
    for impact, row in zip(impacts, found["after"], strict=True):
        spent[row:] -= impact.energy_loss
    closure_max, closure_rate_max, energy_drift = model.kernels.audit(q, u, spent)

    return Run(
        model=model,
        t=t,
        q=q,
        u=u,
        impacts=impacts,
        phases=_phases(model, found, impacts),
        success=found["outcome"] == "done",
        message=_message(model, until, found, fixed),
        nfev=int(found["evaluations"]),
        closure_max=closure_max,
        energy_drift=energy_drift,
        advance=advance,
        motion=along(advance, found),
        method=advance.method,
        drift=advance.drift,
        closure_rate_max=closure_rate_max,
        acceleration_error=_acceleration_error(model, found),
    )


def _acceleration_error(model: Model, found: dict[str, Any]) -> float:
    """What refinement has left; without it, the rounding at a few rows."""
    if model.kernels.refined:
        return float(found["inexact"])
    every = found["t"].size // AUDITED + 1
    q, u = np.ascontiguousarray(found["q"][::every]), np.ascontiguousarray(found["u"][::every])
    lost, whole = model.kernels.rounding(q, u).max(axis=0).tolist()
    return lost / max(whole, model.usual) if lost else 0.0


def _impacts(model: Model, found: dict[str, Any]) -> tuple[Impact, ...]:
    if not found["impact_t"].size:
        return ()  # most runs: they need not pay for the arrays
    records = []
    reactions = impulses_of_joints(model, found)
    for i, t in enumerate(found["impact_t"]):
        part = slice(found["first"][i], found["first"][i + 1])
        records.append(
            Impact(
                t=t.item(),
                contacts=tuple(model.contacts[c] for c in found["contacts"][part]),
                u_minus=found["u_minus"][i],
                u_plus=found["u_plus"][i],
                impulses=found["impulses"][part],
                energy_loss=found["energy_loss"][i].item(),
                friction=found["friction"][part],
                reactions=reactions[i],
            )
        )
    return tuple(records)


def _phases(model: Model, found: dict[str, Any], impacts: tuple[Impact, ...]) -> tuple[Phase, ...]:
    """Flights and contacts, and the impacts that end them."""
    start, end = found["t"][0].item(), found["t"][-1].item()
    if not impacts and not found["held"]:
        return (Phase("flight", start, end),) if end > start else ()
    changes = zip(found["hold_t"], found["held"], [[], *found["held"]], strict=False)
    marks: list[tuple[float, int, list[tuple[int, str]]]] = [
        (t.item(), 1, held) for t, held, before in changes if held != before
    ]
    marks += [(impact.t, 0, []) for impact in impacts]
    phases: list[Phase] = []
    now, held = start, list[tuple[int, str]]()
    for t, change, new in [*sorted(marks, key=lambda mark: mark[:2]), (end, 0, [])]:
        if t > now:
            contacts = tuple(model.contacts[contact] for contact, _ in held)
            phases.append(Phase("contact" if held else "flight", now, t, contacts, tuple(how for _, how in held)))
            now = t
        if change:
            held = new
        elif t < end or any(impact.t == t for impact in impacts):
            phases.append(Phase("impact", t, t))
    return tuple(phases)


def _message(model: Model, until: float, found: dict[str, Any], fixed: bool) -> str:
    """One sentence on how the run, with steps of ``fixed`` length or not, ended; what to try when it ended early."""
    t, outcome = found["t_end"], found["outcome"]
    if outcome == "done":
        return f"reached t = {until:g} s"
    if "met" in found:
        return f"stopped at t = {t:.12g} s: {found['met']}"
    contact = "a contact"
    if found["contact"] >= 0:
        contact = "{} on {}".format(*model.contacts[found["contact"]])
    reasons = {
        "accumulation": f"events of {contact} and others follow each other without time between them; change the "
        "start or the coefficients of restitution a little",
        "not_finite": "an acceleration is not a finite number; check the parameters and the start",
        "step_too_small": "no step is small enough for the tolerance; "
        "ask for a larger rtol, or, where a loop lies in a line, for another",
        "not_closed": "the loops cannot be kept closed; ask for a smaller rtol",
        **{key: failed_impact(key, contact, model.data["law"]) for key in ("repeats", "jammed", "gained")},
        "budget": f"{STEP_BUDGET} steps are spent; ask for a larger rtol or an earlier end",
        "crowded": f"{SECOND_BUDGET} steps and events within the last simulated second are spent; ask for a larger "
        "rtol, or change the start a little if the mechanism is jammed there",
        "escaped": f"a step of fixed length takes {contact.replace(' on ', ' behind the surface of ')}; take a smaller "
        "step, or leave its length to rtol"
        if fixed
        else f"{contact} gets behind its surface however short the step, as at a change point where the motion "
        "jumps; change the start or the lengths a little",
        "interrupted": "interrupted",
        "no_convergence": "the stages of a step do not converge; ask for a smaller step or for another method",
        "not_kept": "the next step would gain or lose more than a tenth of the energy in motion; take a smaller "
        "step, or leave its length to rtol",
        "inexact": "masses differ so much that no digit of the accelerations is sure; make light links that carry "
        "heavy ones heavier, or leave them out",
        "no_memory": "memory ran out; record less by ending earlier",
    }
    reason = reasons[outcome]
    if outcome in ("repeats", "jammed", "gained") and (hit := driven_against(model, found["q"][-1], found["u"][-1])):
        driven = ", ".join(drive["joint"] for drive in model.data["drives"])
        reason = (
            f"{hit[0]} is driven into {hit[1]} by {driven}, whose prescribed motion no impact can change; keep it "
            "clear of there, or move the joint by a [[motor]], which can give way"
        )
    return f"stopped at t = {t:.12g} s: {reason}"
