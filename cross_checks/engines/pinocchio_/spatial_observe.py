"""Pinocchio's own poses and reactions in space."""

# It is installed under a prefix that only the interpreter knows.
# pyright: reportMissingImports=false

from __future__ import annotations

import numpy as np
import pinocchio as pin

from cross_checks.engines.pinocchio_.dynamics import RightHandSide
from cross_checks.engines.pinocchio_.spatial_build import SpatialMechanism
from cross_checks.workshop.spatial_reactions import about, mark, spatial_tree_reactions


def poses_in_space(mechanism: SpatialMechanism, states: np.ndarray):
    """Return positions, Euler parameters, velocities and angular velocities over the samples."""
    n = mechanism.n_q
    samples = []
    for y in states:
        pin.forwardKinematics(mechanism.model, mechanism.data, mechanism.configured(y[:n]), y[n:])
        samples.append(mechanism.poses())
    position, theta, velocity, omega = (np.array(part) for part in zip(*samples, strict=True))
    return position, theta, velocity, omega


def reactions_in_space(mechanism: SpatialMechanism, rhs: RightHandSide, contact_data, times, states, poses) -> dict:
    """Return reactions by recursive Newton-Euler with loads and loop forces applied from outside."""
    tree, model, data, n = mechanism.tree, mechanism.model, mechanism.data, mechanism.n_q
    wrench = np.zeros((len(states), len(tree.scene.bodies), 6))
    loops = {joint.name: np.zeros((len(states), 6)) for joint in mechanism.closing}
    for k, (t, y) in enumerate(zip(times, states, strict=True)):
        q, v = mechanism.configured(y[:n]), y[n:]
        acceleration = rhs(t, y)[n:].copy()
        pin.forwardKinematics(model, data, q, v)  # neither ABA nor RNEA leaves world placements behind
        outside = list(mechanism.load_forces(t)) if mechanism.applied else [pin.Force.Zero() for _ in data.oMi]
        for joint, contact, solved in zip(mechanism.closing, mechanism.contacts, contact_data, strict=True):
            on_first = solved.oMc1.act(solved.contact_force)
            loops[joint.name][k] -= np.concatenate((on_first.linear, on_first.angular))
            outside[contact.joint1_id] += data.oMi[contact.joint1_id].actInv(on_first)
            outside[contact.joint2_id] -= data.oMi[contact.joint2_id].actInv(on_first)
        pin.rnea(model, data, q, v, acceleration, pin.StdVec_Force(outside))
        for body, joint in mechanism.first.items():
            force = data.oMi[joint].act(data.f[joint])
            wrench[k, body] = np.concatenate((force.linear, force.angular))
    reactions = spatial_tree_reactions(tree, poses, wrench)
    one_body = {edge.joint.name for edge in tree.edges if edge.joint is not None and edge.body not in mechanism.first}
    # inside one body of pinocchio: a weld, or a point mass on a ball joint
    reactions = {name: value for name, value in reactions.items() if name not in one_body}
    return reactions | {joint.name: about(loops[joint.name], mark(tree, joint, poses)) for joint in mechanism.closing}
