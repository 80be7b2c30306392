"""A linkage in Drake: a tree of planar and revolute joints, its loops shut by ball constraints; flight alone.

Settings after its documentation: a discrete plant, whose solver (SAP) takes constraints; a continuous one takes none.
Its contacts have dissipation and no restitution: it takes no part where something strikes the floor.
"""

from collections.abc import Callable

import numpy as np
from linkage import Linkage, arm_of, as_tree, turn
from workload import Array


def start(linkage: Linkage, step: float, solver: str) -> Callable[[int, int], Array]:
    """The linkage at its start; call it with a number of steps and after how many of them states are wanted."""
    from pydrake.math import RigidTransform
    from pydrake.multibody.plant import DiscreteContactApproximation, MultibodyPlant
    from pydrake.multibody.tree import FixedOffsetFrame, PlanarJoint, RevoluteJoint, SpatialInertia, UnitInertia
    from pydrake.systems.analysis import Simulator

    tree = as_tree(linkage)
    plant = MultibodyPlant(step)
    plant.set_discrete_contact_approximation(getattr(DiscreteContactApproximation, solver))
    plant.mutable_gravity_field().set_gravity_vector([0.0, -linkage.gravity, 0.0])
    bodies = {}
    for k, (mass, inertia) in enumerate(zip(linkage.masses, linkage.inertias, strict=True)):
        unit = float(inertia / mass)
        bodies[k] = plant.AddRigidBody(f"b{k}", SpatialInertia(float(mass), np.zeros(3), UnitInertia(unit, unit, unit)))

    def place(k: int, arm: Array) -> Array:
        """An arm in the frame of a body, which is parallel to the world at the start, or a place of the ground."""
        return np.array([*(arm if k < 0 else turn(arm, linkage.start[k, 2])), 0.0])

    joints = []
    for bond in tree.bonds:
        k = bond.link
        if bond.pin is None:
            origin = RigidTransform(np.array([*linkage.start[k, :2], 0.0]))
            frame = plant.AddFrame(FixedOffsetFrame("root", plant.world_frame(), origin))
            joints.append(plant.AddJoint(PlanarJoint("root", frame, bodies[k].body_frame())))
            continue
        carrier = plant.world_frame() if bond.parent < 0 else bodies[bond.parent].body_frame()
        ends = ((carrier, bond.parent, "outer"), (bodies[k].body_frame(), k, "inner"))
        frames = [
            plant.AddFrame(FixedOffsetFrame(f"{side}{k}", on, RigidTransform(place(link, arm_of(bond.pin, link)))))
            for on, link, side in ends
        ]
        joints.append(plant.AddJoint(RevoluteJoint(f"t{k}", frames[0], frames[1], [0.0, 0.0, 1.0])))
    for pin in tree.cuts:
        ends2 = ((pin.first, pin.first_arm), (pin.second, pin.second_arm))
        held = [plant.world_body() if k < 0 else bodies[k] for k, _ in ends2]
        points = [place(k, arm) for k, arm in ends2]
        plant.AddBallConstraint(held[0], points[0], held[1], points[1])
    plant.Finalize()
    simulator = Simulator(plant)
    context = simulator.get_mutable_context()
    order = np.concatenate([np.arange(j.velocity_start(), j.velocity_start() + j.num_velocities()) for j in joints])
    speeds = np.empty(len(order))
    speeds[order] = tree.speeds()
    plant.SetVelocities(context, speeds)
    simulator.Initialize()

    def run(steps: int, every: int) -> Array:
        q, v = np.empty((steps // every, len(order))), np.empty((steps // every, len(order)))
        for row in range(steps // every):
            simulator.AdvanceTo((row + 1) * every * step)
            now = simulator.get_context()
            q[row], v[row] = plant.GetPositions(now)[order], plant.GetVelocities(now)[order]
        return tree.states(q, v)

    return run
