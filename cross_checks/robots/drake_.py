"""A robot file as Drake's own parser reads it."""

from pathlib import Path

import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from cross_checks.robots import base_of
from cross_checks.robots.parity import Dynamics, Unreadable, Values


def by_drake(path: Path, q: Values, v: Values) -> Dynamics:
    """Return the dynamics that Drake computes; the root of a URDF is welded to the world."""
    plant = MultibodyPlant(0.0)
    try:
        Parser(plant).AddModels(str(path))
        if path.suffix == ".urdf" and (root := base_of(path)) != "world":  # which Drake takes for its own
            plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(root))
        plant.Finalize()
        joints = [plant.GetJointByName(name) for name in q]
    except RuntimeError as error:
        raise Unreadable(str(error).strip().splitlines()[0]) from error
    context = plant.CreateDefaultContext()
    places, rates = plant.GetPositions(context).copy(), np.zeros(plant.num_velocities())
    index = [joint.velocity_start() for joint in joints]
    places[[joint.position_start() for joint in joints]], rates[index] = list(q.values()), list(v.values())
    plant.SetPositions(context, places)
    plant.SetVelocities(context, rates)
    mass = plant.CalcMassMatrix(context)
    gravity = -plant.CalcGravityGeneralizedForces(context)
    return Dynamics(mass[np.ix_(index, index)], gravity[index], (plant.CalcBiasTerm(context) + gravity)[index])


READER = by_drake
