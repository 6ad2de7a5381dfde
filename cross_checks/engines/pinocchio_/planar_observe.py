"""Pinocchio's own planar poses and reactions."""

# It is installed under a prefix that only the interpreter knows.
# pyright: reportMissingImports=false

from __future__ import annotations

import numpy as np
import pinocchio as pin

from cross_checks.engines.pinocchio_.dynamics import RightHandSide
from cross_checks.engines.pinocchio_.planar_build import Mechanism
from cross_checks.workshop.planar_reactions import about, mark, tree_reactions
from cross_checks.workshop.planar_tree import FIXED


def poses_of(mechanism: Mechanism, states: np.ndarray):
    """Return Pinocchio's own centres of mass and velocities; angles add up along the tree, beyond one turn."""
    tree, model, data = mechanism.tree, mechanism.model, mechanism.data
    n = len(tree.scene.bodies)
    position, velocity = np.zeros((2, len(states), n, 2))
    for k, y in enumerate(states):
        pin.forwardKinematics(model, data, y[: tree.size], y[tree.size :])
        for body, placement in mechanism.placement.items():
            joint = mechanism.joint[body]
            world = data.oMi[joint]
            centre = placement.translation
            motion = data.v[joint]
            position[k, body] = world.act(centre)[:2]
            velocity[k, body] = (world.rotation @ (motion.linear + np.cross(motion.angular, centre)))[:2]
    _, angle, _, rate = tree.poses(states[:, : tree.size], states[:, tree.size :])
    return position, angle, velocity, rate


def reactions_of(mechanism: Mechanism, rhs: RightHandSide, contact_data, times, states: np.ndarray, poses) -> dict:
    """Return reactions by recursive Newton-Euler with loads and loop forces applied from outside."""
    tree, model, data = mechanism.tree, mechanism.model, mechanism.data
    n = tree.size
    wrench = np.zeros((len(states), len(tree.scene.bodies), 3))
    loops = np.zeros((len(tree.closures), len(states), 3))
    for k, (t, y) in enumerate(zip(times, states, strict=True)):
        acceleration = rhs(t, y)[n:].copy()
        pin.forwardKinematics(model, data, y[:n], y[n:])  # neither ABA nor RNEA leaves world placements behind
        outside = [pin.Force.Zero() for _ in range(model.njoints)]
        if mechanism.applied is not None:
            for body, (fx, fy, turn) in enumerate(mechanism.applied.on_bodies(t, y[:n], y[n:])):
                load = pin.Force(np.array([fx, fy, 0.0]), np.array([0.0, 0.0, turn]))
                joint = mechanism.joint[body]
                at_centre = pin.SE3(np.eye(3), data.oMi[joint].act(mechanism.placement[body].translation))
                outside[joint] += data.oMi[joint].actInv(at_centre.act(load))
        for c, (contact, solved) in enumerate(zip(mechanism.contacts, contact_data, strict=True)):
            on_first = solved.oMc1.act(solved.contact_force)
            loops[c, k] = -_planar(on_first)
            outside[contact.joint1_id] += data.oMi[contact.joint1_id].actInv(on_first)
            outside[contact.joint2_id] -= data.oMi[contact.joint2_id].actInv(on_first)
        pin.rnea(model, data, y[:n], y[n:], acceleration, pin.StdVec_Force(outside))
        for body, joint in mechanism.joint.items():
            if body != FIXED:
                wrench[k, body] = _planar(data.oMi[joint].act(data.f[joint]))
    reactions = tree_reactions(tree, poses, wrench)
    welded = [edge.joint for edge in tree.edges if edge.kind == "weld"]  # one body with its parent to Pinocchio
    reactions = {name: reaction for name, reaction in reactions.items() if name not in welded}
    loop = {j.name: about(loops[c], mark(tree, j, poses)) for c, j in enumerate(tree.closures)}
    return reactions | loop


def _planar(force) -> np.ndarray:
    """Return force and moment of a world wrench in the plane."""
    return np.array([force.linear[0], force.linear[1], force.angular[2]])
