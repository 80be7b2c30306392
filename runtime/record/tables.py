"""A run as named arrays, as an xarray.Dataset, and as a pandas.DataFrame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..extras import needed
from ..model.numbers import read_row_of_times
from .outputs import Sample, units_of, values_of
from .penetration import penetration_max
from .record import Record

FORMAT_VERSION = 1


def arrays(run: Record) -> dict[str, Any]:
    """The run as named arrays without objects; contacts of impact k are impact_offsets[k]:impact_offsets[k + 1]."""
    impacts, parameters = run.impacts, dict(run.model.parameters)
    contacts = [contact for impact in impacts for contact in impact.contacts]
    joints = len(run.model.joints)

    def known(found: FloatArray, shape: tuple[int, ...]) -> FloatArray:
        return found if found.shape == shape else np.zeros(shape)

    return {
        "format": np.array("ccgen run"),
        "format_version": np.array(FORMAT_VERSION),
        "model": np.array(run.model.name),
        "q_names": _texts(run.model.q_names),
        "u_names": _texts(run.model.u_names),
        "parameter_names": _texts(parameters),
        "parameter_values": np.array(list(parameters.values()), dtype=float),
        "t": run.t,
        "q": run.q,
        "u": run.u,
        "impact_t": np.array([impact.t for impact in impacts], dtype=float),
        "impact_offsets": np.cumsum([0] + [len(impact.contacts) for impact in impacts]),
        "impact_points": _texts(point for point, _ in contacts),
        "impact_grounds": _texts(ground for _, ground in contacts),
        "impact_impulses": np.concatenate([np.zeros(0)] + [impact.impulses for impact in impacts]),
        "impact_friction": np.concatenate(
            [np.zeros(0)] + [known(impact.friction, impact.impulses.shape) for impact in impacts]
        ),
        "impact_reactions": np.reshape(
            [known(impact.reactions, (joints, 3)) for impact in impacts], (len(impacts), joints, 3)
        ),
        "impact_u_minus": np.reshape([impact.u_minus for impact in impacts], (-1, run.u.shape[1])),
        "impact_u_plus": np.reshape([impact.u_plus for impact in impacts], (-1, run.u.shape[1])),
        "impact_energy_loss": np.array([impact.energy_loss for impact in impacts], dtype=float),
        "impact_restitution_share": np.array([impact.restitution_share for impact in impacts], dtype=float),
        "phase_kinds": _texts(phase.kind for phase in run.phases),
        "phase_starts": np.array([phase.start for phase in run.phases], dtype=float),
        "phase_ends": np.array([phase.end for phase in run.phases], dtype=float),
        "phase_steps": np.array([phase.step for phase in run.phases], dtype=float),
        "phase_missed": np.array([phase.missed for phase in run.phases], dtype=float),
        "phase_taken": np.array([phase.taken for phase in run.phases], dtype=float),
        "phase_offsets": np.cumsum([0] + [len(phase.contacts) for phase in run.phases]),
        "phase_points": _texts(point for phase in run.phases for point, _ in phase.contacts),
        "phase_how": _texts(how for phase in run.phases for how in phase.how),
        "phase_grounds": _texts(ground for phase in run.phases for _, ground in phase.contacts),
        "success": np.array(run.success),
        "message": np.array(run.message),
        "nfev": np.array(run.nfev),
        "method": np.array(run.method),
        "drift": np.array(run.drift),
        "closure_max": np.array(run.closure_max),
        "penetration_max": np.array(penetration_max(run)),
        "closure_rate_max": np.array(run.closure_rate_max),
        "energy_drift": np.array(run.energy_drift),
        "unexplained": run.unexplained if run.unexplained.size else np.full(run.t.shape, np.nan),
        "rest_speed": np.array(run.rest_speed),
        "choices": np.array(run.choices),
        "chosen_at": np.array(np.inf if run.chosen_at is None else run.chosen_at, dtype=float),
        "acceleration_error": np.array(run.acceleration_error),
        **_changes(run),
        **_events(run),
    }


def _changes(run: Record) -> dict[str, Any]:
    """Joints that let go or took hold; nothing of a run in which none does."""
    if not run.changes:
        return {}
    return {
        "change_t": np.array([change.t for change in run.changes], dtype=float),
        "change_joints": _texts(change.joint for change in run.changes),
        "change_kinds": _texts(change.kind for change in run.changes),
        "change_whys": _texts(change.why for change in run.changes),
        "change_gaps": np.array([change.gap for change in run.changes], dtype=float),
        "change_energies": np.array([change.energy for change in run.changes], dtype=float),
    }


def _events(run: Record) -> dict[str, Any]:
    """Instants that the scene asked for; nothing of a run that has none. What event k set is
    event_set_offsets[k]:event_set_offsets[k + 1], and what it switched event_switch_offsets[k] and so on."""
    if not run.events:
        return {}
    before = [event.before.get(path, np.nan) for event in run.events for path in event.parameters]
    ways = [one for event in run.events for one in ((True, event.on), (False, event.off))]
    switched = [(name, way) for way, names in ways for name in names]
    return {
        "event_t": np.array([event.t for event in run.events], dtype=float),
        "event_names": _texts(event.name for event in run.events),
        "event_directions": _texts(event.direction for event in run.events),
        "event_numbers": np.array([event.number for event in run.events]),
        "event_q": np.array([event.q for event in run.events]),
        "event_u": np.array([event.u for event in run.events]),
        "event_energy": np.array([event.energy for event in run.events], dtype=float),
        "event_set_offsets": np.cumsum([0] + [len(event.parameters) for event in run.events]),
        "event_set_names": _texts(path for event in run.events for path in event.parameters),
        "event_set_values": np.array([x for event in run.events for x in event.parameters.values()], dtype=float),
        "event_set_before": np.array(before, dtype=float),
        "event_switch_offsets": np.cumsum([0] + [len(event.on) + len(event.off) for event in run.events]),
        "event_switch_names": _texts(name for name, _ in switched),
        "event_switch_on": np.array([way for _, way in switched], dtype=bool),
    }


def dataset(run: Record, names: Sequence[str] | None = None, t: ArrayLike | None = None) -> Any:
    """The run as an xarray.Dataset: rows over `t`, impacts over `impact`, their contacts over `contact`.

    What a run has none of, as impacts, is left out with its dimension. With ``names``, or at a row of times t: outputs
    over `t` alone, as :func:`dataframe` has them.
    """
    xarray = needed("xarray", "a run as a Dataset")
    if names is not None or t is not None:
        times, columns, units = _columns(run, names, t)
        by_name = {name: ("t", values, {"units": units[name]}) for name, values in columns.items()}
        over = {"t": ("t", times, {"long_name": "time", "units": "s"})}
        return xarray.Dataset(by_name, over, {"model": run.model.name})
    named = arrays(run)
    kinetic, potential = Sample(run, None).energies
    owners = np.repeat(np.arange(len(run.impacts)), np.diff(named["impact_offsets"]))
    data: dict[str, tuple[str | tuple[str, ...], Any, dict[str, str]]] = {
        "q": (("t", "coordinate"), run.q, {"long_name": "coordinates", "units": "see q_units"}),
        "u": (("t", "velocity"), run.u, {"long_name": "velocities", "units": "see u_units"}),
        "kinetic_energy": ("t", kinetic, {"units": "J"}),
        "potential_energy": ("t", potential, {"units": "J"}),
        "u_minus": (("impact", "velocity"), named["impact_u_minus"], {"units": "see u_units"}),
        "u_plus": (("impact", "velocity"), named["impact_u_plus"], {"units": "see u_units"}),
        "energy_loss": ("impact", named["impact_energy_loss"], {"units": "J"}),
        "restitution_share": ("impact", named["impact_restitution_share"], {"units": "1"}),
        "impulse": (
            "contact",
            named["impact_impulses"],
            {"units": "N s; stops: N m s" if run.model.stops else "N s"},
        ),
        "friction_impulse": ("contact", named["impact_friction"], {"units": "N s"}),
        "joint_impulse": (
            ("impact", "joint", "component"),
            named["impact_reactions"],
            {"units": "N s; the moment: N m s"},
        ),
        "parameters": ("parameter", named["parameter_values"], {"units": "SI"}),
    }
    coordinates = {
        "t": ("t", run.t, {"long_name": "time", "units": "s"}),
        "coordinate": named["q_names"],
        "q_of": ("coordinate", _texts(run.model.q_of), {"long_name": "what each coordinate is"}),
        "q_units": ("coordinate", _texts(unit_of_coordinate(name) for name in run.model.q_names)),
        "velocity": named["u_names"],
        "u_units": ("velocity", _texts(f"{unit_of_coordinate(name)}/s" for name in run.model.u_names)),
        "joint": _texts(run.model.joints),
        "component": _texts(("x", "y", "moment")),
        "impact_t": ("impact", named["impact_t"], {"units": "s"}),
        "contact_impact": ("contact", owners, {"long_name": "number of the impact, from 0"}),
        "contact_point": ("contact", named["impact_points"]),
        "contact_ground": ("contact", named["impact_grounds"]),
        "parameter": named["parameter_names"],
    }
    facts = ("model", "success", "message", "nfev", "closure_max", "penetration_max", "energy_drift")
    attributes = {name: named[name].item() for name in facts}
    attributes["success"] = int(run.success)  # netCDF has no truth values
    dataset = xarray.Dataset(data, coordinates, attributes)
    found = dataset.drop_dims([name for name, size in dataset.sizes.items() if not size])
    return found if run.impacts else found.drop_vars(["joint", "component"], errors="ignore")


def dataframe(run: Record, names: Sequence[str] | None = None, t: ArrayLike | None = None) -> Any:
    """A pandas.DataFrame over `t` (s) of outputs by name, or of coordinates, velocities and energies.

    At the rows of the run, an impact being two of the same t, before and after; or at a row of times t.

    `attrs["units"]` has the unit of every column.
    """
    pandas = needed("pandas", "a run as a DataFrame")
    times, columns, units = _columns(run, names, t)
    frame = pandas.DataFrame(columns, index=pandas.Index(times, name="t"))
    frame.attrs["units"] = units
    return frame


def _columns(
    run: Record, names: Sequence[str] | None, t: ArrayLike | None
) -> tuple[FloatArray, dict[str, FloatArray], dict[str, str]]:
    """Times, outputs there by name, or coordinates, velocities and energies, and their units."""
    times = run.t if t is None else read_row_of_times(t, run.t.dtype)
    if names is None:
        return (times, *_coordinates(Sample(run, None if t is None else times)))
    known = units_of(run.model)
    found = values_of(run, names, None if t is None else times)
    return times, found, {name: known[name] for name in found}


def _coordinates(sample: Sample) -> tuple[dict[str, FloatArray], dict[str, str]]:
    """Columns of states, with their units."""
    model, (kinetic, potential) = sample.model, sample.energies
    columns = dict(zip(model.q_names, sample.q.T, strict=True)) | dict(zip(model.u_names, sample.u.T, strict=True))
    units = {name: unit_of_coordinate(name) for name in model.q_names}
    units |= {name: f"{unit_of_coordinate(name)}/s" for name in model.u_names}
    columns |= {"kinetic_energy": kinetic, "potential_energy": potential}
    return columns, units | {"kinetic_energy": "J", "potential_energy": "J"}


def _texts(texts: Any) -> Any:
    return np.array(list(texts), dtype=np.str_)


def unit_of_coordinate(name: str) -> str:
    """The unit of a coordinate, and per second of a velocity, from its name: angles are theta_* and w_*."""
    return "rad" if name.startswith(("theta_", "w_")) else "m"
