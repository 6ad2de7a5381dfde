"""Pinocchio's own motion and reactions."""

from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from cross_checks.engines.pinocchio_.build import Mechanism
from cross_checks.engines.pinocchio_.loop import RightHandSide
from cross_checks.linkage.motion import Motion, about, tree_reactions


def motions_of(mechanism: Mechanism, states: np.ndarray) -> Iterator[Motion]:
    """Yield Pinocchio's own motion at each state."""
    linkage, n = mechanism.linkage, mechanism.n_q
    for y in states:
        q = mechanism.configured(y[:n])
        pin.forwardKinematics(mechanism.model, mechanism.data, q, y[n:])
        bodies = [_of_body(mechanism, k) for k in range(len(linkage.links))]
        position, turn, velocity, omega = map(np.array, zip(*bodies, strict=True))
        yield Motion(position, turn, velocity, omega, linkage.turned(q))


def _of_body(mechanism: Mechanism, k: int) -> tuple:
    """Return position, turn, velocity and angular velocity at the kinematics in `data`."""
    centre = mechanism.centre[k]
    world, moving = mechanism.data.oMi[mechanism.joint[k]], mechanism.data.v[mechanism.joint[k]]
    turn = pin.Quaternion(world.rotation)
    velocity = world.rotation @ (moving.linear + np.cross(moving.angular, centre))
    return world.act(centre), (turn.w, turn.x, turn.y, turn.z), velocity, world.rotation @ moving.angular


def reactions_of(mechanism: Mechanism, rhs: RightHandSide, contact_data, times, states, poses) -> dict:
    """Return reactions by recursive Newton-Euler with loads and loop forces applied from outside."""
    linkage, model, data, n = mechanism.linkage, mechanism.model, mechanism.data, mechanism.n_q
    wrench = np.zeros((len(states), len(linkage.links), 6))
    loops = {name: np.zeros((len(states), 6)) for name in mechanism.closing}
    for k, (t, y, motion) in enumerate(zip(times, states, motions_of(mechanism, states), strict=True)):
        q, v = mechanism.configured(y[:n]), y[n:]
        acceleration = rhs(t, y)[n:].copy()
        pin.forwardKinematics(model, data, q, v)  # neither ABA nor RNEA leaves world placements behind
        outside = [pin.Force.Zero() for _ in data.oMi]
        if mechanism.applied is not None:
            loads = mechanism.applied.wrenches(t, motion)
            for body, (centre, load) in enumerate(zip(motion.position, loads, strict=True)):
                joint, at_centre = mechanism.joint[body], pin.SE3(np.eye(3), centre)
                outside[joint] += data.oMi[joint].actInv(at_centre.act(pin.Force(load[:3], load[3:])))
        for name, contact, solved in zip(mechanism.closing, mechanism.contacts, contact_data, strict=True):
            on_first = solved.oMc1.act(solved.contact_force)
            loops[name][k] -= on_first.vector
            outside[contact.joint1_id] += data.oMi[contact.joint1_id].actInv(on_first)
            outside[contact.joint2_id] -= data.oMi[contact.joint2_id].actInv(on_first)
        pin.rnea(model, data, q, v, acceleration, pin.StdVec_Force(outside))
        for body, joint in mechanism.first.items():
            wrench[k, body] = data.oMi[joint].act(data.f[joint]).vector
    # a weld, or a particle on a ball joint, is inside one body of pinocchio
    inner = {link.joint for link in linkage.links if not link.freedoms}
    reactions = {name: value for name, value in tree_reactions(linkage, poses, wrench).items() if name not in inner}
    joints = {joint.name: joint for joint in linkage.scene.joints}
    return reactions | {name: about(linkage, poses, joints[name], loop) for name, loop in loops.items()}
