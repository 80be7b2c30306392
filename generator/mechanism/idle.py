"""Links that nothing gives any inertia: where the open chain's mass matrix is singular."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from .layout import Complex, Layout, Real, lay_out
from .links import GROUND, INTEGRATES
from .mechanism import Mechanism
from .topology import Topology, span

SINGULAR = 1e-12
"""An eigenvalue of the scaled mass matrix below this counts as zero."""

_TRIALS = 3


def idle_links(
    mechanism: Mechanism, driven: Collection[int] = (), poses: Sequence[Sequence[float]] | None = None
) -> tuple[int, ...]:
    """Links that can move without moving any mass or inertia, with the loops cut open: at ``poses`` (x, y, angle of
    each link), or in a general configuration.

    What ``driven`` joints do is prescribed: it need not be resisted.

    The recursion divides by what resists each coordinate of the open chain (theory, 4.4), which is positive exactly if
    the open chain's mass matrix is positive definite.
    """
    try:
        topology = span(mechanism, driven)
    except ValueError:
        return ()  # links that nothing joins are reported elsewhere
    layout = lay_out(mechanism, frozenset(branch.joint for branch in topology.branches), driven)
    rng = np.random.default_rng(0)
    size = len(mechanism.links) + len(layout.lines)
    best: tuple[float, tuple[int, ...]] = (-1.0, ())
    moves = _displacements(mechanism, topology, layout, driven)
    if not moves.size and not layout.floating:
        return ()
    places = rng.uniform(-3.0, 3.0, (_TRIALS, size)) if poses is None else [layout.read_off(np.array(poses))]
    for x in places:
        matrix = _mass_matrix(mechanism, layout, x, moves)
        least, links = _idle(mechanism, matrix, moves, layout)
        best = max(best, (least, links))
    return best[1] if best[0] <= SINGULAR else ()


def _displacements(mechanism: Mechanism, topology: Topology, layout: Layout, driven: Collection[int]) -> Real:
    """Rates of all angles and lengths for each free coordinate of the open chain, (nl + ns, coordinates), but the base.

    A link on a driven pin turns with its parent as one on a prismatic joint does; a driven length has no rate.
    """
    links, size = range(len(mechanism.links)), len(mechanism.links) + len(layout.lines)
    leaders = {topology.root: topology.root}
    for branch in topology.branches:  # from the root outwards
        held = branch.follows or (branch.joint in driven and not branch.slides)
        leaders[branch.link] = leaders[branch.parent] if held else branch.link
    columns = [np.isin(np.arange(size), [k for k in links if leaders[k] == link]).astype(float) for link in links]
    free = {branch.joint for branch in topology.branches} - set(driven)
    columns += [np.eye(size)[len(links) + k] for k, line in enumerate(layout.lines) if line.joint in free]
    moving = [column for column in columns if column.any()]
    return np.array(moving).reshape(len(moving), size).T


def _mass_matrix(mechanism: Mechanism, layout: Layout, x: Real, moves: Real) -> Real:
    links = mechanism.links
    centres: Complex = layout.arms.copy()
    for k, link in enumerate(links):
        centres[k, k] += complex(*link.com.values())
    turned = layout.turned(x)
    speeds = centres @ turned @ moves
    if layout.floating:
        speeds = np.column_stack([speeds, np.ones(len(links)), 1j * np.ones(len(links))])
    mass = np.array([link.mass.value if link.mass else 0.0 for link in links])
    inertia = np.array(
        [INTEGRATES if link.integrates else link.inertia.value if link.inertia else 0.0 for link in links]
    )
    spins = np.zeros((len(links), speeds.shape[1]))
    spins[:, : moves.shape[1]] = moves[: len(links)]
    return np.asarray((speeds.conj().T * mass @ speeds).real + spins.T * inertia @ spins, dtype=float)


def _idle(mechanism: Mechanism, matrix: Real, moves: Real, layout: Layout) -> tuple[float, tuple[int, ...]]:
    """Least eigenvalue of the matrix scaled to a diagonal of ones, and the links that move in its null space."""
    diagonal = np.diag(matrix)
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    values, vectors = np.linalg.eigh(matrix * np.outer(scale, scale))
    if values[0] > SINGULAR:
        return float(values[0]), ()
    null = np.abs(vectors[:, values <= SINGULAR] * scale[:, None]).max(axis=1)[: moves.shape[1]]
    moving = moves @ (null > 1e-6 * null.max())
    links = {k for k in range(len(mechanism.links)) if moving[k] > 0.0}
    for k, line in enumerate(layout.lines):
        if moving[len(mechanism.links) + k] > 0.0:
            joint = mechanism.joints[line.joint]
            links |= {joint.second.link if joint.second.link != GROUND else joint.first.link}
    light = [k for k in sorted(links) if not (mechanism.links[k].mass and mechanism.links[k].inertia)]
    return float(values[0]), tuple(light)
