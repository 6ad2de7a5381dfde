"""Planar loads: tendons, and actuators without control."""

# Its names live in a compiled module.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import mujoco
import numpy as np

from cross_checks.engines.mujoco_.planar_places import add_site, add_tendon, hinge_name
from cross_checks.workshop.planar_tree import JointTree
from cross_checks.workshop.prescribed import constant_value
from mbs_ref.scene import Force, SpringDamper, Torque, TorsionSpring


def _add_spring(spec, frames, tree: JointTree, load: SpringDamper) -> None:
    tendon = add_tendon(spec, frames, tree, load)
    initial = float(np.hypot(*np.subtract(load.point_b, load.point_a)))
    rest = initial if load.rest_length is None else load.rest_length
    tendon.stiffness, tendon.damping = linear(load.stiffness), linear(load.damping)
    tendon.springlength = (0.0 if load.tension_only else rest, rest)


def linear(coefficient: float) -> np.ndarray:
    """Return a linear law in the shape of the specification's polynomial coefficients."""
    return np.array([coefficient, 0.0, 0.0])


def _add_torsion(spec, frames, tree: JointTree, load: TorsionSpring) -> None:
    """The relative angle is a sum of hinge angles: a fixed tendon over the tree's path.

    Between bodies that no hinge parts the spring is inside of one body, and moves nothing.
    """
    weights: dict[str, float] = {}
    for name, sign in ((load.body_b, 1.0), (load.body_a, -1.0)):
        for edge in tree.path(tree.scene.body_index(name)):
            if edge.kind in ("revolute", "free"):
                label = hinge_name(tree.scene.body_names[edge.body])
                weights[label] = weights.get(label, 0.0) + sign
    turning = {label: weight for label, weight in weights.items() if weight}
    if not turning:
        return
    tendon = spec.add_tendon(name=load.name)
    for label, weight in turning.items():
        tendon.wrap_joint(label, weight)
    tendon.stiffness, tendon.damping, tendon.springlength = linear(load.stiffness), linear(load.damping), (0.0, 0.0)
    a, b = (tree.scene.body_index(name) for name in (load.body_a, load.body_b))
    initial = tree.angle[b] - tree.angle[a]
    rest = initial if load.rest_angle is None else load.rest_angle
    if rest != initial:
        _motor(spec, load.name, mujoco.mjtTrn.mjTRN_TENDON, load.name, load.stiffness * (rest - initial))


def _motor(spec, name: str, transmission, target: str, force: float, refsite: str = "", gear=(1.0, 0, 0, 0, 0, 0)):
    """A constant force: the actuator's bias alone, so that no control input is needed."""
    motor = spec.add_actuator(name=name, trntype=transmission, target=target, gear=gear)
    if refsite:
        motor.refsite = refsite
    motor.biastype = mujoco.mjtBias.mjBIAS_AFFINE
    motor.gaintype = mujoco.mjtGain.mjGAIN_FIXED
    motor.gainprm[0] = 0.0
    motor.biasprm[0] = force


def _add_force(spec, frames, tree: JointTree, load: Force) -> None:
    scale = constant_value(load.factor) or 0.0
    in_body = load.frame == "body"
    site = add_site(spec, frames, tree, load.body, load.point, load.name, turned_to_world=True)
    reference = "" if in_body else add_site(spec, frames, tree, "ground", load.point, f"{load.name}/world")
    gear = (*(scale * c for c in load.vector), 0.0, 0.0, 0.0, 0.0)
    _motor(spec, load.name, mujoco.mjtTrn.mjTRN_SITE, site, 1.0, reference, gear)


def _add_torque(spec, frames, tree: JointTree, load: Torque) -> None:
    point = tree.position[tree.scene.body_index(load.body)]
    site = add_site(spec, frames, tree, load.body, point, load.name)
    gear = (0.0, 0.0, 0.0, 0.0, 0.0, load.torque * (constant_value(load.factor) or 0.0))
    _motor(spec, load.name, mujoco.mjtTrn.mjTRN_SITE, site, 1.0, "", gear)


LOADS = {Force: _add_force, Torque: _add_torque, SpringDamper: _add_spring, TorsionSpring: _add_torsion}
