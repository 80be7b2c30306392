"""A linkage in pymunk (Chipmunk): bodies at their mass centres, pivot joints, circles at corners, one segment as floor.

Settings after its documentation: fixed steps, units chosen by the slop of contacts, which is set to a tenth of a
millimetre for metres, and more iterations of its solver where more accuracy is wanted (10 are its default).
"""

from collections.abc import Callable

import numpy as np
from linkage import Linkage
from workload import Array

RADIUS, HALF_WIDTH, SLOP = 0.01, 0.5, 1e-4


def start(linkage: Linkage, step: float, iterations: int) -> Callable[[int, int], Array]:
    """The linkage at its start; call it with a number of steps and after how many of them states are wanted."""
    import pymunk

    space = pymunk.Space()
    space.gravity = (0.0, -linkage.gravity)
    space.iterations = iterations
    space.collision_slop = SLOP
    bodies = []
    for mass, inertia, row in zip(linkage.masses, linkage.inertias, linkage.start, strict=True):
        body = pymunk.Body(float(mass), float(inertia))
        x, y, angle, vx, vy, rate = map(float, row)
        body.position, body.angle, body.velocity, body.angular_velocity = (x, y), angle, (vx, vy), rate
        space.add(body)
        bodies.append(body)
    for pin in linkage.pins:
        ends = [bodies[k] if k >= 0 else space.static_body for k in (pin.first, pin.second)]
        space.add(pymunk.PivotJoint(*ends, tuple(map(float, pin.first_arm)), tuple(map(float, pin.second_arm))))
    for corner in linkage.corners:
        circle = pymunk.Circle(bodies[corner.link], RADIUS, tuple(map(float, corner.arm)))
        circle.elasticity, circle.friction, circle.filter = linkage.restitution, 0.0, pymunk.ShapeFilter(group=1)
        space.add(circle)
    if linkage.corners:
        low = -RADIUS - HALF_WIDTH
        floor = pymunk.Segment(space.static_body, (-50.0, low), (50.0, low), HALF_WIDTH)
        floor.elasticity, floor.friction = 1.0, 0.0
        space.add(floor)

    def run(steps: int, every: int) -> Array:
        states = np.empty((steps // every, len(bodies), 6))
        for found in states:
            for _ in range(every):
                space.step(step)
            found[:] = [[*b.position, b.angle, *b.velocity, b.angular_velocity] for b in bodies]
        return states

    return run
