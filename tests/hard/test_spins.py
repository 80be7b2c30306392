"""Free loops that pass a line again and again: a signed sum of their lengths is zero, so that all links can lie in one.

Elsewhere steps shrink towards the line without end; here they pass it, as a neighbour does whose lengths miss the line.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from ccgen.generator import loop
from ccgen.runtime import Model, Run, simulate

from ..support.reach import Reach
from ..support.tiers import hard, many
from ..support.workshop import Workshop

SIZES = (4, 4, 4, 5, 6)
MISSES = 1e-3
"""Relative: how much longer a link of the neighbour is, which passes beside the line."""
FASTEST = 100.0
"""rad/s."""
WALL = 3.0
"""Metres from the middle to each wall of the box."""
OTHERS = [hard("gauss", rtol) for rtol in (1e-9, 1e-11, 1e-15)] + [hard("dop853", rtol) for rtol in (1e-9, 1e-13)]
SEEDS = range(many(12, 30))
NORMALS = ([1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0])


def loops(workshop: Workshop, n: int, walls: bool) -> Model:
    box = [{"restitution": 0.7, "normal": [x, y], "point": [-WALL * x, -WALL * y]} for x, y in NORMALS]
    model: Model = workshop.model(loop(n, ground=box) if walls else loop(n))
    return model


def in_wide_numbers(model: Model, workshop: Workshop) -> Any:
    """The same loop, free, of lengths that are multiples of 2^-53 and whose signed sum is zero without rounding.

    By what it misses its line in wide numbers, 1e-17, it would pass the line by, and turn.
    """
    count = len(model.links)
    sizes = np.array([round(model.parameters[f"link_{k}.length"] * 2**53) for k in range(count)])
    signs = np.array(min(product((-1, 1), repeat=count), key=lambda signs: abs(sizes @ np.array(signs))))
    sizes[0] -= signs[0] * (sizes @ signs)
    wide = workshop.model(loop(count), precision="wide")
    return wide.with_parameters({f"link_{k}.length": float(size) / 2**53 for k, size in enumerate(sizes)})


def lengths(n: int, rng: np.random.Generator) -> Any:
    """Half of them lie forwards in the line and half of them back; no link is nearly as long as all others."""
    while True:
        found = rng.uniform(0.3, 0.7, n)
        order = rng.permutation(n)
        signs = np.ones(n)
        signs[order[: n // 2]] = -1.0
        found[order[-1]] -= signs @ found
        if 0.2 < found[order[-1]] < 1.0 and found.max() < 0.95 * (found.sum() - found.max()):
            return found


Spin = tuple[Model, Any, Any]


def spins(workshop: Workshop, walls: bool, seed: int) -> tuple[Spin, Spin]:
    """The loop and its start, and those of the neighbour."""
    rng = np.random.default_rng(seed)
    n = int(rng.choice(SIZES))
    sizes, plain = lengths(n, rng), loops(workshop, n, walls)
    models = []
    for first in (1.0, 1.0 + MISSES):
        own = sizes * np.where(np.arange(n) == 0, first, 1.0)
        models.append(plain.with_parameters({f"link_{k}.length": float(own[k]) for k in range(n)}))
    velocities, fast = rng.normal(size=plain.start()[1].size), rng.uniform(0.1, 1.0) * FASTEST
    while True:
        turns = 0.5 * rng.normal(size=velocities.size)
        turns[:2] = 0.0
        try:
            starts = [model.project(model.assemble(model.start()[0] + turns), velocities) for model in models]
            break
        except ValueError:  # too far from closed
            continue
    one, other = (
        (model, q, u * fast / np.abs(model.velocities(q, u)[:, 2]).max())
        for model, (q, u) in zip(models, starts, strict=True)
    )
    return one, other


def spin(workshop: Workshop, walls: bool, seed: int, rtol: float, method: str = "gauss") -> tuple[Run, Run]:
    """The run, and that of the neighbour."""
    one, other = (
        simulate(model, q, u, until=1.0, rtol=rtol, method=method) for model, q, u in spins(workshop, walls, seed)
    )
    return one, other


def least_shares(model: Model, q: Any) -> Any:
    """Of the closure's singular values at each q, the smallest by the largest: 0 in a line."""
    found = np.linalg.svd(np.asarray(model.jacobian(q), dtype=float), compute_uv=False)
    return found[..., -1] / found[..., 0]


def passes(run: Run, k: int) -> bool:
    """Whether the motion from row k to the next, a cubic here, passes a line."""
    h, change = run.t[k + 1] - run.t[k], run.q[k + 1] - run.q[k]
    a, b = h * run.u[k] - change, change - h * run.u[k + 1]
    x = np.linspace(0.0, 1.0, 101)[:, None]
    return float(least_shares(run.model, run.q[k] + x * (change + (1 - x) * ((1 - x) * a + x * b))).min()) < 2e-3


@pytest.mark.parametrize(("seed", "bound"), [(387, 7e-13), hard(540, 7e-13), hard(588, 7e-13), hard(667, 7e-13)])
def test_velocities_behind_lines_are_those_of_wide_numbers(
    seed: int, bound: float, workshop: Workshop, reach: Reach
) -> None:
    """Of some thousand spins the closure leaves most of a velocity unknown in these; 540 turns back beside a line."""
    (model, q, u), _ = spins(workshop, False, seed)
    run = simulate(model, q, u, until=1.0, rtol=1e-15, method="gauss")
    wide = in_wide_numbers(model, workshop)
    rows = [k for k in range(len(run.t) - 1) if passes(run, k)]
    assert rows
    misses = []
    for k in rows:
        start = wide.project(run.q[k], run.u[k])
        exact = simulate(wide, *start, until=run.t[k + 1] - run.t[k], rtol=1e-17, method="gauss")
        assert exact.success and len(exact.t) < 100, exact.message
        mass, miss = model.mass_matrix(run.q[k + 1]), np.asarray(run.u[k + 1] - exact.u[-1], dtype=float)
        misses.append(float(np.sqrt(miss @ mass @ miss / (run.u[k + 1] @ mass @ run.u[k + 1]))))
    reach(f"spin {seed}: velocities behind lines, of their size", max(misses), bound)


@pytest.mark.sample(1)
@pytest.mark.parametrize("walls", [False, True], ids=["free", "walls"])
@pytest.mark.parametrize("rtol", [1e-11, hard(1e-13), hard(1e-15)])
@pytest.mark.parametrize("count", [10, hard(many(60, 170))])
def test_lines_are_passed(count: int, rtol: float, walls: bool, workshop: Workshop, reach: Reach) -> None:
    """Those that come close to a line and turn back lose most."""
    _pass_lines(range(count), rtol, walls, "gauss", (1e-12, 1e-11), workshop, reach)


@pytest.mark.parametrize("seed", [318, hard(49)])
def test_walls_are_struck_behind_lines(seed: int, workshop: Workshop, reach: Reach) -> None:
    """The step that ends at the wall is shorter than it was made for: for that, no stage of it may lie at the line."""
    _pass_lines((seed,), 1e-13, True, "gauss", (1e-12, 1e-12), workshop, reach)


@pytest.mark.parametrize("until", [0.80081, 0.80082])
def test_runs_end_close_behind_a_strike_behind_a_line(until: float, workshop: Workshop) -> None:
    """The end of the run must not make a step longer that is to end between two stages: it was taken without end."""
    (model, q, u), _ = spins(workshop, True, 49)
    run = simulate(model, q, u, until=until, rtol=1e-11, method="gauss")
    assert run.success, run.message
    assert len(run.t) < 1000


def beside_lines(run: Run) -> list[float]:
    """Times of the run up to a hundredth of a step before and after it passes a line first, and as near as rounding."""
    shares = least_shares(run.model, run.q)  # least at one end of a step that passes a line, by any method
    near = [k for k in range(len(run.t) - 1) if min(shares[k : k + 2]) <= min(shares[max(k - 1, 0) : k + 3])]
    k = next((k for k in near if passes(run, k)), None)
    if k is None:
        return []
    h, change = run.t[k + 1] - run.t[k], run.q[k + 1] - run.q[k]
    a, b = h * run.u[k] - change, change - h * run.u[k + 1]
    found = minimize_scalar(
        lambda x: least_shares(run.model, run.q[k] + x * (change + (1 - x) * ((1 - x) * a + x * b))),
        bounds=(0.0, 1.0),
        method="bounded",
        options={"xatol": 1e-10},
    )
    parts = found.x + np.array([sign * 10.0**-d for sign in (-1, 1) for d in (2, 3, 4, 5, 6, 8, 10)])
    return [float(t) for t in run.t[k] + parts[(parts > 0.0) & (parts < 1.0)] * h]


@pytest.mark.sample(1)
@pytest.mark.parametrize("walls", [False, True], ids=["free", "walls"])
@pytest.mark.parametrize(("method", "rtol"), [("gauss", 1e-13), ("dop853", 1e-11), *OTHERS])
def test_states_beside_lines(method: str, rtol: float, walls: bool, workshop: Workshop, reach: Reach) -> None:
    """Looks between rows, and runs that end there, have the run's energy as the rows have it, and take no more steps.

    No step can end there: velocities would be put back where rows are all but dependent.
    """
    looks, ends, rows = [0.0], [0.0], [0.0]
    for seed in range(70):
        (model, q, u), _ = spins(workshop, walls, seed)
        run = simulate(model, q, u, until=1.0, rtol=rtol, method=method)
        for t in beside_lines(run):
            k = int(np.searchsorted(run.t, t)) - 1
            whole = np.sum(model.energy(run.q[k], run.u[k]))
            looks.append(abs(np.sum(model.energy(*run.at(t))) / whole - 1.0))
            last = simulate(model, run.q[k], run.u[k], until=t - run.t[k], rtol=rtol, method=method)
            assert last.success, (seed, t, last.message)
            ends.append(abs(np.sum(model.energy(last.q[-1], last.u[-1])) / whole - 1.0))
            rows.append(len(last.t))
    assert len(looks) > 100
    case = f"beside lines{' between walls' if walls else ''} by {method}, rtol {rtol:g}"
    bound = 1e-11 + 20.0 * rtol
    reach(f"looks {case}: energy, of that of the row before", max(looks), bound)
    reach(f"runs that end {case}: energy, of that at the start", max(ends), bound)
    reach(f"runs that end {case}: rows", max(rows), 25.0)


@pytest.mark.parametrize("method", ["gauss", "dop853"])
def test_runs_go_on_from_beside_lines(method: str, workshop: Workshop, reach: Reach) -> None:
    """A run that ends there goes on from its state as the whole run does."""
    energies, misses = [0.0], [0.0]
    for seed in range(25):
        (model, q, u), _ = spins(workshop, False, seed)
        run = simulate(model, q, u, until=1.0, rtol=1e-11, method=method)
        whole = np.sum(model.energy(q, u))
        for t in beside_lines(run)[::3]:
            first = simulate(model, q, u, until=t, rtol=1e-11, method=method)
            behind = min(t + 0.02, 1.0)
            second = simulate(model, state=first.state, until=behind, rtol=1e-11, method=method)
            assert second.success and len(second.t) < 100, (seed, t, second.message)
            energies.append(abs(np.sum(model.energy(second.q[-1], second.u[-1])) / whole - 1.0))
            misses.append(float(np.abs(second.u[-1] - run.at(behind)[1]).max() / np.abs(u).max()))
    assert len(misses) > 30
    reach(f"runs that go on from beside lines, {method}: energy, of that at the start", max(energies), 1e-10)
    reach(f"runs that go on from beside lines, {method}: velocities beside the whole run", max(misses), 1e-9)


@pytest.mark.parametrize("method", ["gauss", "dop853"])
def test_velocities_beside_lines_are_those_of_wide_numbers(method: str, workshop: Workshop, reach: Reach) -> None:
    """A look in doubles beside the end of a run in wide numbers."""
    worst = [0.0]
    for seed in (6, 11):
        (model, q, u), _ = spins(workshop, False, seed)
        run = simulate(model, q, u, until=1.0, rtol=1e-13, method=method)
        wide = in_wide_numbers(model, workshop)
        for t in beside_lines(run):
            k = int(np.searchsorted(run.t, t)) - 1
            exact = simulate(wide, *wide.project(run.q[k], run.u[k]), until=t - run.t[k], rtol=1e-17, method="gauss")
            assert exact.success, exact.message
            misses = np.abs(np.asarray(run.at(t)[1] - exact.u[-1], dtype=float))
            worst.append(float(misses.max() / np.abs(run.u[k]).max()))
    assert len(worst) > 20
    reach(f"looks beside lines by {method}: velocities, of the largest, beside wide numbers", max(worst), 1e-12)


def _before_line(run: Run, k: int, share: float) -> float:
    """About when the motion from row k to the next, on its way to a line, has that share: looked for three times, each
    time between the neighbours of the last."""
    begin, end = float(run.t[k]), float(run.t[k + 1])
    for _ in range(3):
        t = np.linspace(begin, end, 41)[1:-1]
        shares = least_shares(run.model, run.at(t)[0])
        before = slice(0, int(np.argmin(shares)) + 1)
        best = int(np.argmin(np.abs(np.log(shares[before] / share))))
        begin, end = t[max(best - 1, 0)], t[min(best + 1, t.size - 1)]
    return float(t[best])


@pytest.mark.parametrize(
    ("method", "seeds"), [("gauss", (6, 11)), hard("gauss", SEEDS), hard("dop853", SEEDS)], ids=str
)
def test_forces_beside_lines_are_those_of_wide_numbers(
    method: str, seeds: Sequence[int], workshop: Workshop, reach: Reach
) -> None:
    """From a tenth down to 2.5e-4 from a line, at usual and at tight tolerances."""
    far, near = [0.0], [0.0]
    for seed, rtol in product(seeds, (1e-8, 1e-11)):
        (model, q, u), _ = spins(workshop, False, seed)
        if len(model.links) > 4:  # whose lines are passed at 0
            continue
        run = simulate(model, q, u, until=1.0, rtol=rtol, method=method)
        wide = in_wide_numbers(model, workshop)
        for k in [k for k in range(len(run.t) - 1) if passes(run, k)][:3]:
            for share in (1e-1, 1e-2, 1e-3, 5e-4, 3e-4):
                x = _before_line(run, k, share)
                here = float(least_shares(model, run.at(x)[0]))
                if here < 2.5e-4:
                    continue
                start = wide.project(run.q[k], run.u[k])
                exact = simulate(wide, *start, until=x - run.t[k], rtol=1e-17, method="gauss")
                forces = np.asarray(wide.reactions(exact.q[-1], exact.u[-1]), dtype=float)
                miss = float(np.abs(run.reactions(x) - forces).max() / np.abs(forces).max())
                (far if here > 1e-3 else near).append(miss)
    assert len(near) > len(seeds)
    reach(f"forces nearer to lines than 1e-3, {method}, {len(seeds)} spins: of the largest", max(near), 1e-6)
    reach(f"forces farther from lines than 1e-3, {method}, {len(seeds)} spins: of the largest", max(far), 1e-6)


@pytest.mark.sample(1)
@pytest.mark.parametrize("walls", [False, True], ids=["free", "walls"])
@pytest.mark.parametrize("rtol", [hard(1e-11), 1e-13, hard(1e-15)])
@pytest.mark.parametrize(
    ("count", "method"),
    [
        *[(5, "dop853"), (5, "dopri5"), (2, "radau")],
        *[hard(many(20, 60), "dop853"), hard(many(15, 40), "dopri5"), hard(3, "radau")],
    ],
)
def test_lines_are_passed_by_other_methods(
    count: int, method: str, rtol: float, walls: bool, workshop: Workshop, reach: Reach
) -> None:
    """Away from lines each of some thousand steps may miss a part of rtol."""
    bounds = 1e-11 + 20.0 * rtol, min(1e-11 + 100.0 * rtol, 1e-9)
    _pass_lines(range(count), rtol, walls, method, bounds, workshop, reach)


def _pass_lines(
    seeds: Sequence[int],
    rtol: float,
    walls: bool,
    method: str,
    energies: tuple[float, float],
    workshop: Workshop,
    reach: Reach,
) -> None:
    """What the energy of 97 in 100 runs, and of all, may be off by."""
    rises, steps = [], []
    for seed in seeds:
        run, beside = spin(workshop, walls, seed, rtol, method)
        assert run.success and beside.success, (seed, run.message, beside.message)
        energy = np.sum(run.model.energy(run.q, run.u), axis=0) / np.sum(run.model.energy(run.q[0], run.u[0]))
        rises.append(float(np.max(energy - np.minimum.accumulate(energy))))
        if not run.impacts:
            rises.append(float(np.abs(energy - 1.0).max()))
        steps.append(len(run.t) / len(beside.t))
    by = "" if method == "gauss" else f" by {method}"
    case = f"{len(seeds)} loops past lines{' between walls' if walls else ''}{by}, rtol {rtol:g}"
    reach(f"{case}: energy, of that at the start, of 97 in 100", float(np.quantile(rises, 0.97)), energies[0])
    reach(f"{case}: energy, of that at the start, of all", max(rises), energies[1])
    reach(f"{case}: rows, of those of a neighbour that misses the line", max(steps), 3.0)
