"""One scene with every spatial part in general position, and a general state of it."""

from __future__ import annotations

import numpy as np

from mbs_ref.scene import (
    Bushing,
    CoordinateDrive,
    Cylindrical,
    Distance,
    Force,
    PointDrive,
    PointMass,
    PointOnPlane,
    Prismatic,
    Revolute,
    RotationDrive,
    Scene,
    SpatialBody,
    Spherical,
    SpringDamper,
    TorqueVector,
    TorsionSpring,
    Universal,
    Weld,
)
from mbs_ref.scene.signals import Harmonic


def every_part() -> Scene:
    """Two closed loops, every joint and load but a user's own."""
    rng = np.random.default_rng(1)

    def vector() -> tuple[float, float, float]:
        x, y, z = rng.standard_normal(3).tolist()
        return x, y, z

    def body(name: str) -> SpatialBody:
        root = rng.standard_normal((3, 3))
        inertia = np.trace(root @ root.T) * np.eye(3) - root @ root.T  # a body's: moments obey the triangle rule
        theta = rng.standard_normal(4)
        return SpatialBody(
            name=name, mass=float(rng.uniform(1.0, 3.0)),
            position=vector(), velocity=vector(), angular_velocity=vector(),
            inertia=(inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2], inertia[1, 2]),
            orientation=tuple((theta / np.linalg.norm(theta)).tolist()),
        )  # fmt: skip

    bodies = tuple(body(name) for name in "abcdefgh")
    wave = Harmonic(amplitude=0.3, omega=2.0, phase=0.3)
    first = vector()
    across = tuple(np.cross(first, vector()).tolist())
    place = (1.0, 2.0, 3.0)
    return Scene(
        name="every_part",
        gravity=(0.0, 0.0, -9.81),
        bodies=(*bodies, PointMass(name="p", mass=2.0, position=place, velocity=(0.0, 0.0, 1.0))),
        joints=(
            Spherical(name="spherical", body_a="ground", body_b="a", point=vector()),
            Revolute(name="revolute", body_a="a", body_b="b", point=vector(), axis=(hinge := vector())),
            Universal(name="universal", body_a="c", body_b="a", point=vector(), axis_a=first, axis_b=across),
            Cylindrical(name="cylindrical", body_a="b", body_b="d", point=vector(), axis=vector()),
            Prismatic(name="prismatic", body_a="d", body_b="e", point=vector(), axis=vector()),
            Weld(name="weld", body_a="e", body_b="f", point=vector()),
            Distance(name="distance", body_a="c", body_b="f", point_a=vector(), point_b=vector()),
            PointOnPlane(name="plane", body_a="d", body_b="g", point=vector(), normal=vector()),
            RotationDrive(name="turn", body_a="a", body_b="b", axis=hinge, motion=wave),
            PointDrive(name="push", body="h", point=vector(), direction=vector(), motion=wave),
            CoordinateDrive(name="lift", body="h", coordinate="z", motion=wave),
            Spherical(name="held", body_a="g", body_b="p", point=place),
            Spherical(name="closing", body_a="g", body_b="b", point=vector()),
        ),
        loads=(
            SpringDamper(name="spring", body_a="a", body_b="h", point_a=vector(), point_b=vector(), stiffness=10.0,
                         damping=1.0, rest_length=0.2),
            Bushing(name="bushing", body_a="c", body_b="d", point=vector(), stiffness=(1.0, 2.0, 3.0, 4.0, 5.0, 6.0),
                    damping=(0.1, 0.2, 0.3, 0.4, 0.5, 0.6)),
            TorsionSpring(name="torsion", body_a="a", body_b="b", axis=hinge, stiffness=2.0, damping=0.1),
            Force(name="force", body="g", point=vector(), vector=vector(), frame="body", factor=wave),
            TorqueVector(name="torque", body="h", vector=vector(), frame="body"),
        ),
    )  # fmt: skip


def general_state(system) -> np.ndarray:
    """The scene's pose with rates that keep nothing."""
    y = system.initial_state()
    y[system.n_positions :] = np.random.default_rng(2).standard_normal(len(y) - system.n_positions)
    return y
