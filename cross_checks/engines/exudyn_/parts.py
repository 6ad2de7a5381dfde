"""Joints and loads in redundant coordinates."""

import math

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np

from cross_checks.engines.exudyn_.model import Redundant
from cross_checks.linkage.links import FIXED, Z, lifted, rest_length, rest_turn
from mbs_ref import scene
from mbs_ref.scene.base.part import normals, unit
from mbs_ref.scene.signals import motion_segments, piece_at

PARALLEL = 1e-9  # sine of the angle between a spring's axis and a joint's
CALLS = "{} {!r} calls Python at every residual"


def add_joint(model: Redundant, joint) -> None:
    """Add a joint; in space it stops some of six relative motions, along z of a frame whose z axis is the joint's."""
    if model.scene.planar or type(joint) not in STOPPED:
        JOINTS[type(joint)](model, joint)
        return
    axis = getattr(joint, "axis", Z)
    frame = np.column_stack((*normals(axis), unit(axis)))
    markers = [model.frame(body, joint.point, frame) for body in joint.ends]
    model.mbs.AddObject(item.ObjectJointGeneric(markerNumbers=markers, constrainedAxes=STOPPED[type(joint)]))


def _pin(model: Redundant, joint: scene.Revolute | scene.Weld) -> int:
    return model.mbs.AddObject(item.ObjectJointRevolute2D(markerNumbers=model.pair(joint, joint.point, joint.point)))


def _watch_force(model: Redundant, joint: str, number: int, width: int) -> None:
    """Record the force of a joint, in the plane."""
    model.forces[joint] = sum(model.widths)
    model.watch(item.SensorObject, {"objectNumber": number}, exu.OutputVariableType.Force, width)


def _add_weld(model: Redundant, joint: scene.Weld) -> None:
    """Hold a body at a point and at its angle; a particle has none."""
    _pin(model, joint)
    bodies = [model.scene.body_index(name) for name in (joint.body_a, joint.body_b)]
    if all(k == FIXED or isinstance(model.scene.bodies[k], scene.PlanarBody) for k in bodies):
        markers = [model.coordinate(body, 2) for body in (joint.body_a, joint.body_b)]
        model.mbs.AddObject(item.ObjectConnectorCoordinate(markerNumbers=markers))


def _add_prismatic(model: Redundant, joint: scene.Prismatic) -> None:
    markers = [model.marker(body, joint.point, rigid=True) for body in (joint.body_a, joint.body_b)]
    axis = unit(lifted(joint.axis))
    along, across = model.axes(joint.body_a).T @ axis, model.axes(joint.body_b).T @ np.cross(Z, axis)
    model.mbs.AddObject(
        item.ObjectJointPrismatic2D(markerNumbers=markers, axisMarker0=list(along), normalMarker1=list(across))
    )


def _add_distance(model: Redundant, joint: scene.Distance) -> None:
    length = joint.length or float(np.linalg.norm(np.subtract(joint.point_b, joint.point_a)))
    markers = model.pair(joint, joint.point_a, joint.point_b)
    number = model.mbs.AddObject(item.ObjectConnectorDistance(markerNumbers=markers, distance=length))
    if model.scene.planar:
        _watch_force(model, joint.name, number, 1)


def _add_drive(model: Redundant, joint: scene.CoordinateDrive) -> None:
    coordinate = ("x", "y", "angle").index(joint.coordinate)
    motion = motion_segments(joint.motion, joint.level)
    markers = [model.coordinate("ground", 0), model.coordinate(joint.body, coordinate)]

    def place(mbs, t, number, offset) -> float:
        return piece_at(motion, t).value(t)

    def speed(mbs, t, number, offset) -> float:
        return piece_at(motion, t).rate(t)

    model.mbs.AddObject(
        item.ObjectConnectorCoordinate(markerNumbers=markers, offsetUserFunction=place, offsetUserFunction_t=speed)
    )
    model.notes += (CALLS.format("drive", joint.name),)


def _add_spring(model: Redundant, load: scene.SpringDamper) -> None:
    limit = load.limit or math.inf

    def pull(mbs, t, number, stretch, stretch_rate, stiffness, damping, force) -> float:
        return min(limit, max(0.0, stiffness * stretch + damping * stretch_rate)) if stretch > 0.0 else 0.0

    law = {"springForceUserFunction": pull} if load.tension_only else {}
    model.mbs.AddObject(
        item.ObjectConnectorSpringDamper(
            markerNumbers=model.pair(load, load.point_a, load.point_b), referenceLength=rest_length(load),
            stiffness=load.stiffness, damping=load.damping, **law,
        )
    )  # fmt: skip
    if load.tension_only:
        model.notes += (CALLS.format("load", load.name),)


def _add_torsion(model: Redundant, load: scene.TorsionSpring) -> None:
    """Add a spring between the angles of two planar bodies, or about z of a frame whose z axis is the spring's."""
    ends, rest = (load.body_a, load.body_b), rest_turn(model.scene, load)
    if model.scene.planar:
        markers, kind = [model.coordinate(body, 2) for body in ends], item.ObjectConnectorCoordinateSpringDamper
    else:
        frame, kind = np.column_stack((*normals(load.axis), unit(load.axis))), item.ObjectConnectorTorsionalSpringDamper
        markers = [model.frame(body, model.centre(body), frame) for body in ends]
    law = {"stiffness": load.stiffness, "damping": load.damping, "offset": rest}
    model.mbs.AddObject(kind(markerNumbers=markers, **law))


def _add_bushing(model: Redundant, load: scene.Bushing) -> None:
    """Add a torque against the rotation vector, by Exudyn's intrinsic formulation."""
    markers = [model.frame(*end) for end in zip(load.ends, load.marks, load.frames, strict=True)]
    law = {"stiffness": np.diag(load.stiffness), "damping": np.diag(load.damping)}
    model.mbs.AddObject(
        item.ObjectConnectorRigidBodySpringDamper(markerNumbers=markers, useIntrinsicFormulation=True, **law)
    )


def _add_point_bushing(model: Redundant, load: scene.PointBushing) -> None:
    markers = model.pair(load, *load.marks)
    model.mbs.AddObject(
        item.ObjectConnectorCartesianSpringDamper(markerNumbers=markers, stiffness=[load.stiffness] * 3)
    )


def has_connector(whole: scene.Scene, load: scene.Load) -> bool:
    """Return whether a connector of Exudyn's acts as the load does.

    Its torsional spring measures another angle where no joint holds the axis (1.12: 0.03 off after 1 s). Its intrinsic
    bushing acts in the middle between both frames: on the same torque where that is as stiff about every axis. Its
    Cartesian damper acts at both marks, with a couple where they are apart.
    """
    if isinstance(load, scene.PointBushing):
        return load.damping == 0.0
    if isinstance(load, scene.Bushing):
        turns = [values[3:] for values in (load.stiffness, load.damping)]
        return not any(load.stiffness[:3] + load.damping[:3]) and all(len(set(values)) == 1 for values in turns)
    if not isinstance(load, scene.TorsionSpring) or load.axis is None:
        return type(load) in LOADS
    ends, axis = {load.body_a, load.body_b}, unit(load.axis)
    return any(
        {joint.body_a, joint.body_b} == ends and np.linalg.norm(np.cross(unit(joint.axis), axis)) < PARALLEL
        for joint in whole.joints
        if isinstance(joint, scene.Revolute | scene.Cylindrical | scene.Prismatic) and joint.axis is not None
    )


def _add_push(model: Redundant, load: scene.Force | scene.Torque | scene.TorqueVector) -> None:
    """Add a force or torque; along body axes Exudyn takes it in the body's own. A particle has none."""
    force, body = isinstance(load, scene.Force), model.scene.bodies[model.scene.body_index(load.body)]
    vector = load.torque * Z if isinstance(load, scene.Torque) else lifted(load.vector)
    follows = getattr(load, "frame", "world") == "body" and not isinstance(body, scene.PointMass)
    if follows:
        vector = model.axes(load.body).T @ vector
    rigid = (follows or not force) if model.scene.planar else None
    marker = model.marker(load.body, load.point if force else body.position, rigid=rigid)
    kind, constant = (item.LoadForceVector if force else item.LoadTorqueVector), getattr(load.factor, "value", None)
    if constant is not None:
        model.mbs.AddLoad(kind(markerNumber=marker, loadVector=(constant * vector).tolist(), bodyFixed=follows))
        return
    signal = load.factor.segments()

    def scaled(mbs, t, unit) -> list[float]:
        return [piece_at(signal, t).value(t) * c for c in unit]

    model.mbs.AddLoad(
        kind(markerNumber=marker, loadVector=vector.tolist(), bodyFixed=follows, loadVectorUserFunction=scaled)
    )
    model.notes += (CALLS.format("load", load.name),)


JOINTS = {
    scene.Revolute: lambda model, joint: _watch_force(model, joint.name, _pin(model, joint), 3),
    scene.Spherical: lambda model, joint: model.mbs.AddObject(
        item.ObjectJointSpherical(markerNumbers=model.pair(joint, joint.point, joint.point))
    ),
    scene.Weld: _add_weld, scene.Prismatic: _add_prismatic, scene.Distance: _add_distance,
    scene.CoordinateDrive: _add_drive,
}  # fmt: skip
STOPPED = {  # in space: relative motions along x, y, z of the joint, then about them
    scene.Revolute: [1, 1, 1, 1, 1, 0], scene.Weld: [1, 1, 1, 1, 1, 1], scene.Prismatic: [1, 1, 0, 1, 1, 1],
    scene.Cylindrical: [1, 1, 0, 1, 1, 0],
}  # fmt: skip
LOADS = {
    **dict.fromkeys((scene.Force, scene.Torque, scene.TorqueVector), _add_push),
    scene.SpringDamper: _add_spring, scene.TorsionSpring: _add_torsion, scene.Bushing: _add_bushing,
    scene.PointBushing: _add_point_bushing,
}  # fmt: skip
