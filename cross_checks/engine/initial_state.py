"""Do the bodies' own poses and velocities at t = 0 satisfy every joint? Engines snap or drift silently if not."""

import math
from dataclasses import dataclass

import numpy as np

from mbs_ref import Trajectory
from mbs_ref.observables import rows
from mbs_ref.scene import Revolute, Scene, Weld

# By dimension: the name of a body's orientation, and the orientation and angular velocity of a particle.
TURNING = {2: ("angle", 0.0, 0.0), 3: ("orientation", (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0))}


@dataclass(frozen=True)
class Gap:
    """How far a joint's worst row is from satisfied at t = 0."""

    joint: str
    position: float  # m or rad
    velocity: float  # m/s or rad/s


def initial_sample(scene: Scene) -> Trajectory:
    """Return the scene's own initial state as a trajectory of one sample."""
    orientation, level, still = TURNING[scene.dimension]
    names = ("position", ()), (orientation, level), ("velocity", ()), ("angular_velocity", still)
    parts = [[getattr(body, name, default) for body in scene.bodies] for name, default in names]
    position, turn, velocity, spin = (np.array(part, dtype=float)[None] for part in parts)
    return Trajectory(np.zeros(1), position, turn, velocity, spin)


def worst_gap(scene: Scene) -> Gap | None:
    """Return the joint farthest from satisfied; None where there is no joint."""
    constraints = rows(scene, initial_sample(scene))
    if not constraints.joints:
        return None
    size = np.maximum(np.abs(constraints.residual[0]), np.abs(constraints.rate[0]))
    joint = constraints.joints[int(np.argmax(size))]
    own = np.array([name == joint for name in constraints.joints])
    return Gap(joint, float(np.abs(constraints.residual[0, own]).max()), float(np.abs(constraints.rate[0, own]).max()))


def open_loop(scene: Scene) -> str:
    """Return a sentence on a joint whose two marks are apart at t = 0: engines take one world point a joint."""
    for joint in scene.joints:
        if isinstance(joint, Revolute | Weld) and joint.point_b is not None:
            gap = math.dist(joint.point, joint.point_b)
            if gap > 0.0:
                return f"joint {joint.name!r} starts {gap:.3g} m open, and only mbs_ref closes such loops"
    return ""


def inconsistency(scene: Scene, tolerance: float) -> str:
    """Return why engines that take one world point a joint cannot start the scene, or nothing."""
    return open_loop(scene) or broken_start(scene, tolerance)


def broken_start(scene: Scene, tolerance: float) -> str:
    """Return a sentence on the worst gap above the tolerance, or nothing."""
    gap = worst_gap(scene)
    if gap is None or max(gap.position, gap.velocity) <= tolerance:
        return ""
    return (
        f"the initial state breaks joint {gap.joint!r} by {gap.position:.3g} (m, rad) and "
        f"{gap.velocity:.3g} (m/s, rad/s), more than initial_tolerance = {tolerance:g}"
    )
