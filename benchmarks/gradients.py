"""What derivatives take: of whole runs, in plain runs, and of accelerations, in accelerations.

Prints two markdown tables. The first has runs with their derivatives by tangents, along one direction of the start and
along several, with the gradient of one number of the end by all of the start and all parameters in adjoint mode, and
with one-sided differences along as many directions. The second has Jacobians of accelerations by all coordinates and
rates, beside CasADi's of the same accelerations where it is installed. What is compared is timed in turn.
"""

import argparse
import ctypes
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec

import casadi_loop
import numpy as np
from driver import CASADI, WORK, Kernel, batch, compile_shared
from forward_dynamics import CASADI_FLAGS
from machine import machine
from turns import fastest
from workload import workload

from ccgen.generator import Scene, generate, load_scene, loop
from ccgen.runtime import Model, load_model, simulate
from ccgen.runtime.model.directions import directions_of

SIZES = (4, 6, 12, 24)
HEADER = (
    "run",
    "impacts",
    "columns",
    "run, ms",
    "tangent, 1",
    "tangent, {0}",
    "per direction",
    "differences, {0}",
    "adjoint, all",
)
JACOBIANS = ("n", "acceleration, ns", "Jacobian, ns", "in accelerations", "CasADi's, ns", "CasADi at", "ratio")


@dataclass(frozen=True)
class Case:
    """A run that is derived: its start, and how long it lasts (s)."""

    name: str
    model: Model
    q: np.ndarray
    u: np.ndarray
    until: float


def falling_hexagon() -> tuple[Model, np.ndarray, np.ndarray]:
    """Turned a little, so that its corners do not land together, 0.2 m above the ground."""
    scene = load_scene("scenes/falling-hexagon.toml")
    model = load_model(generate(scene, out=WORK / "gradients", derivatives=True))
    q, u = model.start()
    q[2:] += 0.1
    q[1] += 0.2 - float(model.gaps(q).min())
    return model, q, u


def ring(n: int) -> Model:
    scene: Scene = loop(n, gravity=True)
    return load_model(generate(scene, out=WORK / "gradients", derivatives=True))


def cases() -> list[Case]:
    """The falling hexagon to its 16th impact, and a ring in flight."""
    model, q, u = falling_hexagon()
    until = next(one.t for k, one in enumerate(simulate(model, q, u, until=2.0).impacts) if k == 15) + 1e-3
    found = [Case("falling hexagon, to its 16th impact", model, q, u, until)]
    model = ring(12)
    q, u = model.start()
    u = u + model.motions(q) @ np.random.default_rng(2).normal(size=model.dof)
    return [*found, Case("ring of 12 rods in free flight, 2 s", model, q, u, 2.0)]


def compare(case: Case, count: int, rounds: int) -> str:
    """A line of the first table."""
    model, q, u, n = case.model, case.q, case.u, len(case.q)
    rng = np.random.default_rng(1)
    few, many = ({name: rng.normal(size=(n, k)) for name in ("q0", "u0")} for k in (1, count))
    everything = ["q0", "u0", *(name for name in model.parameters if _moves(model, name))]
    covector = rng.normal(size=2 * n)

    def run() -> object:
        return simulate(model, q, u, until=case.until)

    def differences() -> object:
        ends = [simulate(model, q, u, until=case.until)]
        for k in range(count):
            moved = model.project(q + 1e-7 * many["q0"][:, k], u + 1e-7 * many["u0"][:, k])
            ends.append(simulate(model, *moved, until=case.until))
        return [(one.q[-1] - ends[0].q[-1]) / 1e-7 for one in ends[1:]]

    calls = [
        run,
        lambda: simulate(model, q, u, until=case.until).jacobian(few),
        lambda: simulate(model, q, u, until=case.until).jacobian(many),
        differences,
        lambda: simulate(model, q, u, until=case.until).vjp(covector, everything),
    ]
    plain, one, several, differ, adjoint = fastest(calls, rounds)
    columns = len(simulate(model, q, u, until=case.until).vjp(covector, everything))
    impacts = len(simulate(model, q, u, until=case.until).impacts)
    ratios = [one / plain, several / plain, (several / plain - 1.0) / count, differ / plain, adjoint / plain]
    cells = [case.name, str(impacts), str(columns), f"{1e3 * plain:.2f}", *(f"{ratio:.2f}" for ratio in ratios)]
    return "| " + " | ".join(cells) + " |"


def _moves(model: Model, name: str) -> bool:
    """Whether there are derivatives by a parameter."""
    return name not in model.data["rests_on"] and name not in model.data["instants"]


def accelerate(n: int, rounds: int) -> str:
    """A line of the second table, at one state of W(n)."""
    model, calls = ring(n), max(2000 // n, 1)
    q, u, _ = workload(n).coordinates(root=0)
    q, u = model.project(q[0], u[0])
    along = directions_of(model, ("q", "u"))
    t, kernels = np.zeros(1), model.kernels
    timed: list[Callable[[], object]] = [
        lambda: kernels.repeat_acceleration(t, q[None], u[None], 8 * calls),
        lambda: kernels.repeat_jacobian(q, u, 0.0, along.by, along.blocks, calls),
    ]
    theirs = casadi_kernels(n, q, u)
    timed += [lambda one=one: batch(one, calls) for one in theirs]  # type: ignore[misc]
    seconds = np.array(fastest(timed, rounds))
    plain, ours, others = 1e9 * seconds[0] / (8 * calls), 1e9 * seconds[1] / calls, 1e9 * seconds[2:] / calls
    cells = [str(n), f"{plain:.0f}", f"{ours:.0f}", f"{ours / plain:.2f}"]
    if theirs:
        _agree(model, q, u, theirs)
        best = int(np.argmin(others))
        cells += [f"{others[best]:.0f}", theirs[best].name, f"{ours / others[best]:.2f}"]
    else:
        cells += ["–", "–", "–"]
    return "| " + " | ".join(cells) + " |"


def _agree(model: Model, q: np.ndarray, u: np.ndarray, theirs: Sequence[Kernel]) -> None:
    """Jacobians of the angles' accelerations by angles and rates are the same, whichever link the place is that of."""
    n = len(q)
    angles = np.arange(2, n)
    columns = np.concatenate([angles, n + angles])
    ours = model.acceleration_jacobian(q, u, contacts=())
    ours = np.hstack(ours) if isinstance(ours, tuple) else ours
    for one in theirs:
        other = one.u_dot.reshape(2 * n, n).T
        wrong = np.max(np.abs((other - ours[:, : 2 * n])[np.ix_(angles, columns)])) / np.max(np.abs(ours))
        assert wrong < 1e-8, f"CasADi's Jacobian at {one.name} differs by {wrong:.1g}"


def casadi_kernels(n: int, q: np.ndarray, u: np.ndarray) -> list[Kernel]:
    """CasADi's Jacobian of the same accelerations under every set of flags; none where it is not installed."""
    if find_spec("casadi") is None:
        return []
    source, found = casadi_loop.write_jacobian(n, WORK), []
    for k, flags in enumerate(CASADI_FLAGS):
        path = source.with_name(f"{source.stem}_{k}.so")
        if compile_shared(source, [*flags.split(), "-march=native"], path, 60.0):
            function = getattr(ctypes.CDLL(str(path)), casadi_loop.JACOBIAN)
            address = ctypes.cast(function, ctypes.c_void_p).value or 0
            # one state: the result, which is larger than u, is never moved on from
            out = np.zeros(2 * len(q) ** 2)
            found.append(Kernel(flags, CASADI, address, q[None], u[None], out, np.empty(0), np.empty(0)))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=40, help="the best of so many is told")
    parser.add_argument("--directions", type=int, default=8, help="how many directions besides one")
    parser.add_argument("--links", type=int, nargs="*", default=SIZES, metavar="N", help="sizes of the second table")
    given = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    print(f"{machine()}\n")
    header = " | ".join(HEADER).format(given.directions)
    print(f"| {header} |\n|" + "---|" * len(HEADER))
    for case in cases():
        print(compare(case, given.directions, given.rounds), flush=True)
    print("\n| " + " | ".join(JACOBIANS) + " |\n|" + "---|" * len(JACOBIANS))
    for n in given.links:
        print(accelerate(n, 5 * given.rounds), flush=True)


if __name__ == "__main__":
    main()
