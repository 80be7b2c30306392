"""Integrals over time that a scene's effects ask for: the bodies that have what integrates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..effect_base.effect import Effect
from ..mechanism.integrators import with_integrators
from .bodies import Bodies
from .errors import Path


def integrating(bodies: Bodies, effects: Sequence[tuple[Path, Effect]]) -> Bodies:
    """The bodies with an integrator for each integral of the ``effects``, also of those that are off."""
    asking = [name for _, effect in effects for name in effect.integrals()]
    if not asking:
        return bodies
    count = len(asking)
    return replace(
        bodies,
        mechanism=with_integrators(bodies.mechanism, asking),
        sketch=(*bodies.sketch, *(0.0 for _ in asking)),
        rates=(*bodies.rates, *(0.0 for _ in asking)) if bodies.rates else (),
        link_rows=(*bodies.link_rows, *(-1 for _ in asking)) if bodies.link_rows else (),
        joint_rows=(*bodies.joint_rows, *(-1 for _ in range(count))) if bodies.joint_rows else (),
    )
