"""The language of scenes: bodies, joints, drives and loads.

A scene is plain frozen data in SI units. Joints and attachment points are given as world points and
axes at t = 0. Traits (planar or spatial, closed loops, rheonomic terms) are computed, never typed.
The parts have files of their own and are imported from here.
"""

from mbs_ref.scene.bodies import GROUND, Body, PlanarBody, PointMass, SpatialBody, symmetric
from mbs_ref.scene.joints import (
    CoordinateDrive,
    Cylindrical,
    Distance,
    Drive,
    Joint,
    PointDrive,
    PointOnPlane,
    Prismatic,
    Revolute,
    RollingWheel,
    RotationDrive,
    Spherical,
    Universal,
    UserConstraint,
    Weld,
)
from mbs_ref.scene.loads import (
    Bushing,
    Force,
    Load,
    PointBushing,
    SpringDamper,
    Torque,
    TorqueVector,
    TorsionSpring,
    UserForce,
)
from mbs_ref.scene.scene import Scene

__all__ = [
    "GROUND", "Body", "Bushing", "CoordinateDrive", "Cylindrical", "Distance", "Drive", "Force", "Joint", "Load",
    "PlanarBody", "PointBushing", "PointDrive", "PointMass", "PointOnPlane", "Prismatic", "Revolute", "RollingWheel",
    "RotationDrive", "Scene", "SpatialBody", "Spherical", "SpringDamper", "Torque", "TorqueVector", "TorsionSpring",
    "Universal", "UserConstraint", "UserForce", "Weld", "symmetric",
]  # fmt: skip
