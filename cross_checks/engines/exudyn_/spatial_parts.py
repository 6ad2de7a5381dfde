"""Joints and loads in space."""

# Its items take their arguments by names that type checkers cannot see.
# pyright: reportCallIssue=false, reportArgumentType=false, reportAttributeAccessIssue=false

from __future__ import annotations

import exudyn.itemInterface as item
import numpy as np

from cross_checks.engines.exudyn_.loads import add_load, pull_only
from cross_checks.engines.exudyn_.planar_joints import rod
from cross_checks.engines.exudyn_.spatial_model import Spatial
from cross_checks.linkage.links import rest_length
from cross_checks.linkage.tree import FIXED
from mbs_ref.scene import (
    Cylindrical,
    Distance,
    Force,
    Prismatic,
    Revolute,
    SpatialBody,
    Spherical,
    SpringDamper,
    TorqueVector,
    TorsionSpring,
    Weld,
)
from mbs_ref.scene.base.directions import normals, unit


def _generic(model: Spatial, joint, axis, fixed: list[int]) -> None:
    """A joint along z of a frame whose z axis is the joint's; `fixed` tells the six relative motions it stops."""
    first, second = normals(axis)
    frame = np.column_stack((first, second, np.asarray(axis, dtype=float) / np.linalg.norm(axis)))
    markers = [model.frame(body, joint.point, frame) for body in (joint.body_a, joint.body_b)]
    model.mbs.AddObject(item.ObjectJointGeneric(markerNumbers=markers, constrainedAxes=fixed))


def _spatial_spherical(model: Spatial, joint: Spherical) -> None:
    model.mbs.AddObject(item.ObjectJointSpherical(markerNumbers=model.pair(joint, joint.point, joint.point)))


def _spatial_distance(model: Spatial, joint: Distance) -> None:
    length = joint.length or float(np.linalg.norm(np.subtract(joint.point_b, joint.point_a)))
    model.mbs.AddObject(rod(model.pair(joint, joint.point_a, joint.point_b), length))


def _spatial_spring(model: Spatial, load: SpringDamper) -> None:
    law = {"springForceUserFunction": pull_only} if load.tension_only else {}
    model.mbs.AddObject(
        item.ObjectConnectorSpringDamper(
            markerNumbers=model.pair(load, load.point_a, load.point_b),
            referenceLength=rest_length(load), stiffness=load.stiffness, damping=load.damping, **law,
        )
    )  # fmt: skip


def _spatial_torsion(model: Spatial, load: TorsionSpring) -> None:
    """A spring and damper about z of a frame whose z axis is the spring's; Exudyn knows no more than half a turn."""
    assert load.axis is not None  # scenes in space give it
    frame = np.column_stack((*normals(load.axis), unit(load.axis)))
    ends = [(name, model.scene.body_index(name)) for name in (load.body_a, load.body_b)]
    places = [model.scene.bodies[k].position if k != FIXED else np.zeros(3) for _, k in ends]
    markers = [model.frame(name, place, frame) for (name, _), place in zip(ends, places, strict=True)]
    model.mbs.AddObject(
        item.ObjectConnectorTorsionalSpringDamper(
            markerNumbers=markers, stiffness=load.stiffness, damping=load.damping, offset=load.rest_angle or 0.0
        )
    )


def _spatial_push(model: Spatial, load: Force | TorqueVector) -> None:
    """A force or torque; along body axes Exudyn takes it in the body's own. A point mass has none."""
    force = isinstance(load, Force)
    body = model.scene.bodies[model.scene.body_index(load.body)]
    marker = model.marker(load.body, load.point if force else body.position)
    follows = load.frame == "body" and isinstance(body, SpatialBody)
    vector = model.axes(load.body).T @ load.vector if follows else np.array(load.vector)
    kind = item.LoadForceVector if force else item.LoadTorqueVector
    add_load(model, kind, marker, vector.tolist(), load, bodyFixed=follows)


SPATIAL_PARTS = {
    Spherical: _spatial_spherical,
    Revolute: lambda model, joint: _generic(model, joint, joint.axis, [1, 1, 1, 1, 1, 0]),
    Cylindrical: lambda model, joint: _generic(model, joint, joint.axis, [1, 1, 0, 1, 1, 0]),
    Prismatic: lambda model, joint: _generic(model, joint, joint.axis, [1, 1, 0, 1, 1, 1]),
    Weld: lambda model, joint: _generic(model, joint, (0.0, 0.0, 1.0), [1, 1, 1, 1, 1, 1]),
    Distance: _spatial_distance,
    SpringDamper: _spatial_spring,
    TorsionSpring: _spatial_torsion,
    Force: _spatial_push,
    TorqueVector: _spatial_push,
}
