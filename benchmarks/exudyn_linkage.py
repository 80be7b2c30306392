"""A linkage in Exudyn: planar bodies and revolute joints, by its implicit solvers; flight alone.

Settings after its documentation: the generalised-α solver for constrained systems with the spectral radius it has by
default, or the trapezoidal rule of index 2; Newton's method to 1e-10 where its default is 1e-8, so that steps alone
limit accuracy. Of contacts with restitution it has penalty laws between spheres and between contours, none of a point
on a plane by Newton's law: it takes no part where something strikes the floor.
"""

from collections.abc import Callable

import numpy as np
from linkage import Linkage
from workload import Array

NEWTON = 1e-10


def start(linkage: Linkage, step: float, solver: str) -> Callable[[int, int], Array]:
    """The linkage at its start; call it with a number of steps and after how many of them states are wanted."""
    import exudyn as exu
    import exudyn.itemInterface as items  # noqa: N813

    system = exu.SystemContainer().AddSystem()
    bodies, sensors = [], []
    for mass, inertia, row in zip(linkage.masses, linkage.inertias, linkage.start, strict=True):
        pose, speeds = [float(x) for x in row[:3]], [float(x) for x in row[3:]]
        node = system.AddNode(items.NodeRigidBody2D(referenceCoordinates=pose, initialVelocities=speeds))
        body = system.AddObject(
            items.ObjectRigidBody2D(physicsMass=float(mass), physicsInertia=float(inertia), nodeNumber=node)
        )
        marker = system.AddMarker(items.MarkerBodyMass(bodyNumber=body))
        system.AddLoad(items.LoadMassProportional(markerNumber=marker, loadVector=[0.0, -linkage.gravity, 0.0]))
        bodies.append(body)
        for kind in (exu.OutputVariableType.Coordinates, exu.OutputVariableType.Coordinates_t):
            sensors.append(
                system.AddSensor(
                    items.SensorNode(nodeNumber=node, storeInternal=True, writeToFile=False, outputVariableType=kind)
                )
            )
    ground = system.AddObject(items.ObjectGround())
    for pin in linkage.pins:
        ends = ((pin.first, pin.first_arm), (pin.second, pin.second_arm))
        markers = [
            system.AddMarker(
                items.MarkerBodyPosition(
                    bodyNumber=bodies[k] if k >= 0 else ground, localPosition=[*map(float, arm), 0.0]
                )
            )
            for k, arm in ends
        ]
        system.AddObject(items.ObjectJointRevolute2D(markerNumbers=markers))
    system.Assemble()
    kinds = {
        "generalised alpha": exu.DynamicSolverType.GeneralizedAlpha,
        "trapezoidal": exu.DynamicSolverType.TrapezoidalIndex2,
    }

    def run(steps: int, every: int) -> Array:
        settings = exu.SimulationSettings()
        integration = settings.timeIntegration
        integration.numberOfSteps, integration.endTime = steps, steps * step
        integration.verboseMode = 0
        integration.newton.useModifiedNewton = True
        integration.newton.relativeTolerance = integration.newton.absoluteTolerance = NEWTON
        settings.solutionSettings.writeSolutionToFile = False
        settings.solutionSettings.sensorsWritePeriod = every * step
        settings.displayComputationTime = False
        system.SolveDynamic(settings, solverType=kinds[solver])
        tables = [np.array(system.GetSensorStoredData(sensor))[-(steps // every) :, 1:4] for sensor in sensors]
        states = np.stack([np.hstack(tables[k : k + 2]) for k in range(0, len(tables), 2)], axis=1)
        states[..., :3] += linkage.start[:, :3]
        return states

    return run
