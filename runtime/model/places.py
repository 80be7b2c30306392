"""Outputs that have derivatives, by name: of which function of the model each is an entry."""

from __future__ import annotations

from .compiled import Compiled

RATES = {"angle": "angular_velocity", "slide": "slide_rate", "x": "vx", "y": "vy"}
"""What the rate of a coordinate is called."""


def rate_of(coordinate: str) -> str:
    """The name of the rate of a coordinate."""
    owner, _, kind = coordinate.rpartition(".")
    return f"{owner}.{RATES[kind]}"


def places_of(model: Compiled) -> dict[str, tuple[str, tuple[int, ...]]]:
    """Outputs by name: what is derived, and the entry of it."""
    found: dict[str, tuple[str, tuple[int, ...]]] = {}
    for i, name in enumerate(model.q_of):
        owner, _, kind = name.rpartition(".")
        if kind != "slide" or owner not in model.joint_gates:  # else it is that of the drive, and not of the link
            found[name], found[rate_of(name)] = ("q", (i,)), ("u", (i,))
    for k, link in enumerate(model.links):
        found.setdefault(f"{link}.angle", ("poses", (k, 2)))
        found.setdefault(f"{link}.angular_velocity", ("velocities", (k, 2)))
    for k, point in enumerate(model.points):
        for axis, letter in enumerate("xy"):
            found.setdefault(f"{point}.{letter}", ("points", (k, axis)))
    for k, joint in enumerate(model.joints):
        for part, letter in enumerate(("fx", "fy", "moment")):
            found[f"{joint}.{letter}"] = "reactions", (k, part)
    for k, (point, ground) in enumerate(model.contacts):
        found[f"{ground}.{point}.gap"] = "gaps", (k,)
        found[f"{ground}.{point}.gap_rate"] = "gap_rates", (k,)
    for k, name in enumerate(("kinetic_energy", "potential_energy")):
        found[name] = "energy", (k,)
    for k, (name, _) in enumerate(model.told):
        found[name] = "outputs", (k,)
    return found
