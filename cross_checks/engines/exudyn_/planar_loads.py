"""Planar loads in redundant coordinates."""

# Its items take their arguments by names that type checkers cannot see.
# pyright: reportCallIssue=false, reportArgumentType=false, reportAttributeAccessIssue=false

from __future__ import annotations

import exudyn.itemInterface as item
import numpy as np

from cross_checks.engines.exudyn_.loads import add_load, pull_only
from cross_checks.engines.exudyn_.planar_model import Redundant, in_body
from cross_checks.linkage.tree import FIXED
from mbs_ref.scene import Force, PlanarBody, SpringDamper, Torque, TorsionSpring


def _add_force(model: Redundant, load: Force) -> None:
    vector = np.array(load.vector)
    body = model.scene.bodies[model.scene.body_index(load.body)]
    fixed = load.frame == "body" and isinstance(body, PlanarBody)
    if fixed:
        vector = in_body(body.angle, vector)
    marker = model.marker(load.body, load.point, rigid=fixed)
    add_load(model, item.LoadForceVector, marker, [*vector, 0.0], load, bodyFixed=fixed)


def _add_torque(model: Redundant, load: Torque) -> None:
    body = model.scene.bodies[model.scene.body_index(load.body)]
    marker = model.marker(load.body, body.position, rigid=True)
    add_load(model, item.LoadTorqueVector, marker, [0.0, 0.0, load.torque], load)


def _add_spring(model: Redundant, load: SpringDamper) -> None:
    markers = [model.marker(load.body_a, load.point_a), model.marker(load.body_b, load.point_b)]
    initial = float(np.hypot(*np.subtract(load.point_b, load.point_a)))
    rest = initial if load.rest_length is None else load.rest_length
    law = {"springForceUserFunction": pull_only} if load.tension_only else {}
    model.mbs.AddObject(
        item.ObjectConnectorSpringDamper(
            markerNumbers=markers, referenceLength=rest, stiffness=load.stiffness, damping=load.damping, **law
        )
    )
    if load.tension_only:
        model.notes += (f"load {load.name!r} calls Python at every residual",)


def _add_torsion(model: Redundant, load: TorsionSpring) -> None:
    markers = [model.coordinate(body, 2) for body in (load.body_a, load.body_b)]
    bodies = [model.scene.body_index(name) for name in (load.body_a, load.body_b)]
    angles = [getattr(model.scene.bodies[k], "angle", 0.0) if k != FIXED else 0.0 for k in bodies]
    initial = angles[1] - angles[0]
    rest = initial if load.rest_angle is None else load.rest_angle
    model.mbs.AddObject(
        item.ObjectConnectorCoordinateSpringDamper(
            markerNumbers=markers, stiffness=load.stiffness, damping=load.damping, offset=rest - initial
        )
    )


LOADS = {Force: _add_force, Torque: _add_torque, SpringDamper: _add_spring, TorsionSpring: _add_torsion}
