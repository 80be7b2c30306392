"""Scenes of polygons that touch, which tests of words, rows and motions share."""

from __future__ import annotations

import math
from collections.abc import Sequence

from .touching_scenes import free_body

RATCHET = """\
[ground_link]
points = { O = [0, 0], P = [-0.10, 0.13] }
[[link]]
name = "wheel"
mass = 0.5
inertia = 2.5e-3
com = [0, 0]
points = { O = [0, 0], POINTS }
[[link]]
name = "pawl"
mass = 0.05
inertia = 6e-05
com = [0.06, 0]
points = { P = [0, 0], tip = [0.12, 0] }
[[joint]]
name = "axle"
between = ["ground.O", "wheel.O"]
[[joint]]
name = "pawl_pin"
between = ["ground.P", "pawl.P"]
[start]
angles = { wheel = "5 deg", pawl = "-8 deg" }
[gravity]
[[torque]]
link = "wheel"
torque = "-0.15*sin(2*pi*t)"
[[joint_friction]]
joints = ["axle"]
viscous = 0.01
"""
"""A wheel with teeth, without what touches them; what stands for POINTS follows from :func:`teeth`."""

TEETH = 8


def ratchet(touches: str) -> str:
    """A wheel of eight teeth that is turned to and fro, and a pawl whose round tip lets it turn one way."""
    points = []
    for k in range(TEETH):
        turn = 2 * math.pi * k / TEETH
        for name, radius in (("T", 0.1), ("R", 0.08)):
            points.append(f"{name}{k} = [{radius * math.cos(turn):.12f}, {radius * math.sin(turn):.12f}]")
    return RATCHET.replace("POINTS", ", ".join(points)) + touches


def teeth_as_polygon() -> str:
    """All teeth in one table."""
    corners = ", ".join(f'"wheel.T{k}", "wheel.R{k}"' for k in range(TEETH))
    return (
        f'[[touch]]\nname = "teeth"\nbetween = ["pawl.tip", [{corners}, "wheel.T0"]]\nradius = 0.004\nrestitution = 0\n'
    )


def teeth_one_by_one() -> str:
    """A table for every edge of every tooth."""
    return "".join(
        f'[[touch]]\nbetween = ["pawl.tip", ["wheel.R{k}", "wheel.T{end % TEETH}"]]\nradius = 0.004\nrestitution = 0\n'
        for k in range(TEETH)
        for end in (k, k + 1)
    )


def box_on_ramp(slope: float, mu: float, skin: float = 0.01) -> str:
    """A square box of 0.2 m that lies on the upper edge of a fixed triangle, 1 m from where that begins."""
    high = 3.0 * math.tan(slope)
    along, up = complex(math.cos(slope), math.sin(slope)), complex(-math.sin(slope), math.cos(slope))
    centre = 2.0 * along + (0.1 + skin) * up
    corners = "C = [0, 0], A = [-0.1, -0.1], B = [0.1, -0.1], D = [0.1, 0.1], E = [-0.1, 0.1]"
    return (
        f"[ground_link]\npoints = {{ O = [0, 0], Q = [3, 0], R = [3, {high!r}] }}\n"
        + free_body("box", 2.0, 2.0 * 0.04 / 6, corners)
        + '[gravity]\n[[touch]]\nname = "lies"\n'
        'between = [["box.A", "box.B", "box.D", "box.E", "box.A"], ["ground.O", "ground.Q", "ground.R", "ground.O"]]\n'
        f"radius = {skin!r}\nrestitution = 0\n{f'friction = {mu!r}' if mu else ''}\n"
        f"[start]\nangles = {{ box = {slope!r} }}\nslides = {{ x_box = {centre.real!r}, y_box = {centre.imag!r} }}\n"
    )


def flush_boxes(
    widths: Sequence[float], masses: Sequence[float], restitution: float = 0.0, skin: float = 0.01, more: str = ""
) -> str:
    """Smooth boxes, 0.2 m high, each flush on the one below; the lowest stands on level ground. Edges have a skin. What
    is in ``more`` acts on them."""
    bodies, touches, slides = "", "", []
    for k, (width, mass) in enumerate(zip(widths, masses, strict=True)):
        x, y = 0.5 * width, 0.1
        corners = f"A = [{-x!r}, {-y}], B = [{x!r}, {-y}], D = [{x!r}, {y}], E = [{-x!r}, {y}]"
        bodies += free_body(f"b{k}", mass, mass * (width**2 + 0.04) / 12, f"C = [0, 0], {corners}")
        slides.append(f"y_b{k} = {0.1 + k * (0.2 + skin)!r}")
        if k:
            outlines = (", ".join(f'"b{of}.{corner}"' for corner in "ABDEA") for of in (k, k - 1))
            between = ", ".join(f"[{outline}]" for outline in outlines)
            touches += f"[[touch]]\nbetween = [{between}]\nradius = {skin!r}\nrestitution = {restitution!r}\n"
    return (
        f"[ground_link]\npoints = {{ O = [0, 0] }}\n{bodies}[gravity]\n[[ground]]\npoint = [0, 0]\nnormal = [0, 1]\n"
        f'restitution = {restitution!r}\ncontacts = ["b0.A", "b0.B"]\n{touches}{more}'
        f"[start]\nslides = {{ {', '.join(slides)} }}\n"
    )
