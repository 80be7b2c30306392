"""Small motions about a state: state matrices on the motions that keep loops shut, modes (theory, eq. 11.4).

Coordinates depend on each other through the loops. As many of them as the mechanism has degrees of freedom are the
states here, by name, and the others follow (R. A. Wehage, E. J. Haug, Journal of Mechanical Design 104, 1982).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..extras import needed
from ..model.drives import drive_rows
from ..model.forces import Contacts
from ..model.inputs import Values
from ..model.model import Model, check_model
from ..model.numbers import read_names, read_numbers, told
from ..model.places import places_of, rate_of
from ..precision import need_doubles

EASY = 0.5
"""The next state is the first coordinate that moves at least this part as far as the one that moves farthest."""


@dataclass(frozen=True)
class Modes:
    """Modes of small motions, each pair of conjugate ones once, the slowest first.

    ``values`` (k,) are the eigenvalues s in 1/s, with an imaginary part that is not negative; ``frequencies`` (k,) are
    ``abs(s) / 2π`` in Hz, ``damping`` (k,) the ratios ``−Re s / abs(s)`` (zero where s is zero), and ``shapes`` (nq, k)
    what all coordinates move by, complex, the largest entry being 1.
    """

    values: np.ndarray[Any, np.dtype[np.complexfloating[Any, Any]]]
    frequencies: FloatArray
    damping: FloatArray
    shapes: np.ndarray[Any, np.dtype[np.complexfloating[Any, Any]]]


@dataclass(frozen=True)
class Linear:
    """x' = A x + B v, y = C x + D v, for what is small beside a state and its inputs.

    ``states`` names x, coordinates and then their rates, ``inputs`` v, and ``outputs`` y; ``shapes`` (nq, dof) is what
    all coordinates move by with each coordinate of x. SI units and radians.
    """

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    shapes: FloatArray

    def modes(self) -> Modes:
        """Eigenvalues of A, and how the mechanism moves with each."""
        values, vectors = np.linalg.eig(self.A)
        size = float(np.max(np.abs(values), initial=0.0))
        kept = np.flatnonzero(values.imag >= -1e-12 * size)
        kept = kept[np.lexsort((values[kept].imag, values[kept].real, np.round(np.abs(values[kept]), 12)))]
        values, shapes = values[kept].astype(complex), self.shapes @ vectors[: self.shapes.shape[1], kept]
        for k in range(shapes.shape[1]):
            shapes[:, k] /= shapes[np.argmax(np.abs(shapes[:, k])), k] or 1.0
        speed = np.abs(values)
        damping = np.divide(-values.real, speed, out=np.zeros(len(speed)), where=speed > 0.0)
        return Modes(values, speed / (2.0 * np.pi), damping, shapes)

    def to_control(self) -> Any:
        """A ``StateSpace`` of the package control (python-control), with these names, dots as ``_``: it takes no dots.

        Raises ``ImportError`` where that package is missing.
        """
        control = needed("control", "a state space of python-control")
        signals = {"states": self.states, "inputs": self.inputs, "outputs": self.outputs}
        names = {kind: [name.replace(".", "_") for name in given] for kind, given in signals.items()}
        return control.ss(self.A, self.B, self.C, self.D, **names)


def linearise(
    model: Model,
    q: ArrayLike,
    u: ArrayLike | None = None,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    *,
    values: Values | None = None,
    t: float = 0.0,
    contacts: Contacts = None,
) -> Linear:
    """State matrices about the state q (nq,), u (nu,), at rest unless given, under the ``values`` of the inputs.

    The state need not be at rest or in equilibrium: then these are the matrices of what a neighbouring motion that
    keeps the loops shut, and driven joints as they are, differs by at first. ``inputs`` are names of the model's inputs
    (all of them by default). ``outputs`` are names as runs know them: coordinates and their rates (the states by
    default), a link's ``angle`` and ``angular_velocity``, a point's ``x`` and ``y``, a joint's ``fx``, ``fy`` and
    ``moment``, a contact's ``gap`` and ``gap_rate``, ``kinetic_energy``, ``potential_energy``, and what effects tell.

    Effects that ``[start] off`` names are absent.
    Raises ``ValueError`` as ``Model.derivatives`` does, for a model without derivatives, with integrals over time or
    in other numbers than doubles, for a state whose loops are not shut, and for names that are none.
    """
    check_model(model)
    need_doubles(model.precision, model.name, "linearise")
    if model.data.get("integrators"):
        found = ", ".join(one["name"] for one in model.data["integrators"])
        raise ValueError(f"{model.name}: found {found}, expected a model without integrals over time")
    state = read_numbers(q, "q")
    rates = np.zeros(len(model.u_names)) if u is None else read_numbers(u, "u")
    for name, given, count in (("q", state, len(model.q_names)), ("u", rates, len(model.u_names))):
        if given.shape != (count,):
            raise ValueError(f"{name}: found shape {given.shape}, expected one state ({count},)")
    if values is not None and not model.inputs:
        raise ValueError(f"values: found {told(values)}, expected None; the model has no inputs")
    _check_shut(model, state, rates)
    chosen = tuple(model.inputs if inputs is None else read_names(inputs, "inputs", "inputs"))
    if wrong := [name for name in chosen if name not in model.inputs]:
        raise ValueError(f"inputs: found {', '.join(wrong)}, expected some of {', '.join(model.inputs) or 'none'}")
    at = _At(model, state, rates, t, values, contacts)
    own = [model.q_of[i] for i in at.independent]
    names = (*own, *map(rate_of, own))
    wanted = names if outputs is None else tuple(read_names(outputs, "outputs", "outputs"))
    A, B = at.matrices(chosen)
    C, D = at.outputs(wanted, chosen)
    return Linear(A, B, C, D, names, chosen, wanted, at.along)


def _check_shut(model: Model, q: FloatArray, u: FloatArray) -> None:
    if not model.rows:
        return
    miss, rate = float(np.max(np.abs(model.closure(q)))), float(np.max(np.abs(model.jacobian(q) @ u)))
    speed = max(float(np.max(np.abs(u))), 1.0) * model.length
    if miss > 1e-6 * model.length or rate > 1e-6 * speed:
        raise ValueError(
            f"{model.name}: found loops that are open by {miss:.1e} m and open at {rate:.1e} m/s, expected shut ones; "
            "take the state of model.project"
        )


class _At:
    """A model at a state, and how coordinates and rates follow from those that are independent."""

    def __init__(
        self, model: Model, q: FloatArray, u: FloatArray, t: float, values: Values | None, contacts: Contacts
    ) -> None:
        self.model, self.q, self.u, self.t, self.values, self.contacts = model, q, u, t, values, contacts
        free = model.motions(q)
        self.independent = independent(free, 1.0 / model.coordinate_units)
        self.along = np.array(
            np.linalg.solve(free[self.independent].T, free.T).T if free.shape[1] else free, dtype=float
        )
        self.turning = self._turning()

    def _turning(self) -> FloatArray:
        """What the rates (nu, dof) change by with the independent coordinates, their own rates held: A δu = −δA u."""
        model, dof = self.model, len(self.independent)
        bent = -model.derivatives("closure_rate", self.q, self.u, wrt={"q": self.along}) if dof else np.zeros((0, 0))
        rows = np.vstack([model.jacobian(self.q), drive_rows(model), np.eye(len(self.q))[self.independent]])
        wanted = np.zeros((len(rows), dof))
        wanted[: len(bent)] = bent
        return np.asarray(np.linalg.lstsq(rows, wanted, rcond=None)[0])

    def _derived(self, of: str, inputs: Sequence[str]) -> tuple[FloatArray, FloatArray]:
        """By the states, and by the inputs."""
        still = np.zeros_like(self.along)
        q, u = np.hstack([self.along, still]), np.hstack([self.turning, self.along])

        def by(wrt: Any) -> FloatArray:
            return self.model.derivatives(of, self.q, self.u, self.t, self.values, wrt, self.contacts)

        return by({"q": q, "u": u}), by(tuple(inputs))

    def matrices(self, inputs: Sequence[str]) -> tuple[FloatArray, FloatArray]:
        dof = len(self.independent)
        states, given = self._derived("acceleration", inputs)
        A, B = np.zeros((2 * dof, 2 * dof)), np.zeros((2 * dof, len(inputs)))
        A[:dof, dof:] = np.eye(dof)
        A[dof:], B[dof:] = states[self.independent], given[self.independent]
        return A, B

    def outputs(self, names: Sequence[str], inputs: Sequence[str]) -> tuple[FloatArray, FloatArray]:
        dof, places = len(self.independent), places_of(self.model)
        C, D = np.zeros((len(names), 2 * dof)), np.zeros((len(names), len(inputs)))
        if wrong := [name for name in names if name not in places]:
            raise ValueError(
                f"outputs: found {', '.join(wrong)}, expected some of {', '.join(places)}; of others there are no "
                "derivatives"
            )
        derived: dict[str, tuple[FloatArray, FloatArray]] = {
            "q": (np.hstack([self.along, np.zeros_like(self.along)]), np.zeros((len(self.q), len(inputs)))),
            "u": (np.hstack([self.turning, self.along]), np.zeros((len(self.q), len(inputs)))),
        }
        for row, name in enumerate(names):
            of, index = places[name]
            if of not in derived:
                derived[of] = self._derived(of, inputs)
            C[row], D[row] = (part[index] for part in derived[of])
        return C, D


def independent(basis: FloatArray, weights: FloatArray) -> list[int]:
    """As many rows of the ``basis`` (nq, dof) as it has columns, far from depending on each other; of like ones the
    first."""
    left, found = basis * weights[:, None], list[int]()
    for _ in range(basis.shape[1]):
        sizes = np.linalg.norm(left, axis=1)
        sizes[found] = 0.0
        row = int(np.argmax(sizes >= EASY * sizes.max()))
        found.append(row)
        direction = left[row] / sizes[row]
        left = left - np.outer(left @ direction, direction)
    return sorted(found)
