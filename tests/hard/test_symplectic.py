"""A million fixed steps of the symplectic method: energy bounded, without trend."""

from __future__ import annotations

import platform
from typing import Any

import numpy as np
import pytest

from ccgen.generator import loop
from ccgen.generator.compile.compiler import find_compiler
from ccgen.generator.compile.processor import processor
from ccgen.runtime import simulate
from ccgen.runtime.analysis.inverse_dynamics import momentum

from ..oracles import polygons
from ..oracles.maximal import Array
from ..support.reach import Reach
from ..support.workshop import Workshop

STEPS = 1_000_000
BLOCKS = 50
SLIGHT = 0.004
"""Roundings a step: what code leaves as a trend that rounds products before it adds them (x86-64-v2: 0.0033)."""


def rounds_products() -> bool:
    """Whether models are compiled so; other processors add to a product in one operation."""
    compiler = find_compiler()
    needs = processor(compiler.command, compiler.flags())["needs"]
    return platform.machine() == "x86_64" and isinstance(needs, list) and "fma" not in needs


def trend(energy: Array) -> tuple[float, float]:
    """Slope of a relative energy per run and its standard error, from means of blocks.

    Rounding makes a random walk of the energy, whose values are not independent but whose increments are: the slope is
    their mean, and its error theirs."""
    blocks = energy[: energy.size // BLOCKS * BLOCKS].reshape(BLOCKS, -1).mean(axis=1)
    increments = np.diff(blocks)
    return float(BLOCKS * increments.mean()), float(BLOCKS * increments.std(ddof=1) / np.sqrt(increments.size))


def at_rest_as_a_whole(model: Any, q: Array, u: Array) -> Array:
    """The velocities without the motion as one body: angles then stay small, and their last digits too."""
    rigid = np.zeros((3, u.size))
    rigid[0, 0] = rigid[1, 1] = 1.0
    rigid[2, 2:] = 1.0
    masses = np.array([momentum(model, q, row) for row in rigid]) @ rigid.T
    left: Array = u - np.linalg.solve(masses, rigid @ momentum(model, q, u)) @ rigid
    return left


@pytest.mark.hard
def test_four_rods_a_million_steps(workshop: Workshop, reach: Reach) -> None:
    """Unequal rods, no two of which are ever in line with the others."""
    h, lengths = 0.1, [1.0, 1.7, 1.4, 1.2]
    values = {f"link_{k}.length": length for k, length in enumerate(lengths)}
    values |= {f"link_{k}.com.x": length / 2 for k, length in enumerate(lengths)}
    values |= {f"link_{k}.inertia": length**2 / 12 for k, length in enumerate(lengths)}
    model = workshop.model(loop(4)).with_parameters(values)
    q = np.array([0.0, 0.0, 0.7853981633974481, 2.3781536464445105, 4.326827755757286, 5.773692537091301])
    q, u = model.project(model.assemble(q), np.array([0.0, 0.0, 1.0, -0.5, 0.4, -0.1]))
    run = simulate(model, q, at_rest_as_a_whole(model, q, u), until=STEPS * h, step=h, method="gauss")
    assert run.success, run.message
    kinetic = model.energy(run.q, run.u)[0]
    energy = kinetic / kinetic[0] - 1.0
    slope, error = trend(energy)
    name = f"four rods, a million steps of {h:g} s"
    reach(f"{name}: energy, relative", np.max(np.abs(energy)), 1e-12)
    if rounds_products():
        bias = abs(slope) / STEPS / float(np.finfo(float).eps)
        reach(f"{name}: its trend, roundings a step", bias, SLIGHT)
    else:
        reach(f"{name}: its trend, in standard errors", abs(slope) / error, 3.0)
    reach(f"{name}: closure, m", run.closure_max, 1e-13)


@pytest.mark.hard
def test_six_rods_a_million_steps(workshop: Workshop, reach: Reach) -> None:
    """The free hexagon turns, drifts and is chaotic: the last digits of its angles grow with them."""
    model = workshop.model(loop(6))
    q, u = model.state_from_poses(*polygons.perturbed(6))
    run = simulate(model, q, u, until=STEPS * 0.005, step=0.005, method="gauss")
    assert run.success, run.message
    kinetic = model.energy(run.q, run.u)[0]
    energy = kinetic / kinetic[0] - 1.0
    slope, error = trend(energy)
    reach("free hexagon, a million steps of 0.005 s: energy, relative", np.max(np.abs(energy)), 1e-10)
    reach("free hexagon, a million steps of 0.005 s: its trend, in standard errors", abs(slope) / error, 3.0)
    reach("free hexagon, a million steps of 0.005 s: closure, m", run.closure_max, 1e-11)
