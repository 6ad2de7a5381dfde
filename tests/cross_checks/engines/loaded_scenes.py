"""Scenes that carry every load the outside engines translate."""

from __future__ import annotations

from mbs_ref import scenes
from mbs_ref.scene import (
    GROUND,
    Bushing,
    Force,
    PlanarBody,
    PointMass,
    Prismatic,
    Revolute,
    Scene,
    SpringDamper,
    Torque,
    TorqueVector,
    TorsionSpring,
    Weld,
)
from mbs_ref.scene.signals import Constant, HalfSine


def loaded_tree() -> Scene:
    """A turned slider with a rod, a welded plate and a pinned particle, under springs, forces and a torque."""
    slider = PlanarBody(name="slider", mass=1.0, inertia=0.2, position=(1.0, 0.5), angle=0.3)
    rod = PlanarBody(name="rod", mass=2.0, inertia=0.3, position=(1.5, 0.2), angle=-0.4)
    plate = PlanarBody(name="plate", mass=0.5, inertia=0.1, position=(2.0, 0.4), angle=1.1)
    pinned = PointMass(name="pinned", mass=0.3, position=(1.8, -0.1), velocity=(0.0, 0.0))
    free = PlanarBody(
        name="free", mass=1.0, inertia=0.1, position=(-1.0, 2.0), velocity=(1.0, -2.0), angular_velocity=3.0
    )
    return Scene(
        name="loaded",
        gravity=(0.5, -9.81),
        bodies=(plate, rod, slider, free, pinned),
        joints=(
            Prismatic(name="guide", body_a="slider", body_b=GROUND, point=(1.0, 0.5), axis=(2.0, 1.0)),
            Revolute(name="hinge", body_a="rod", body_b="slider", point=(1.2, 0.4)),
            Weld(name="glue", body_a="rod", body_b="plate", point=(1.7, 0.3)),
            Revolute(name="nail", body_a="plate", body_b="pinned", point=(1.8, -0.1)),
        ),
        loads=(
            Force(name="push", body="rod", point=(1.9, 0.0), vector=(3.0, -1.0), factor=Constant(value=2.0)),
            Force(name="thrust", body="plate", point=(2.1, 0.6), vector=(-2.0, 1.0), frame="body"),
            Torque(name="twist", body="free", torque=0.4),
            SpringDamper(
                name="strut", body_a="plate", body_b="free", point_a=(2.1, 0.5), point_b=(-0.9, 2.1),
                stiffness=5.0, damping=0.3, rest_length=1.0,
            ),
            TorsionSpring(name="coil", body_a="slider", body_b="plate", stiffness=4.0, damping=0.2, rest_angle=0.5),
            TorsionSpring(name="clock", body_a=GROUND, body_b="free", stiffness=2.0),
        ),
    )  # fmt: skip


def loaded_top() -> Scene:
    """Return a top with a spring, a bushing, a torque in its own axes, and a pulse that ends within the run."""
    scene = scenes.make("heavy_top", spin=5.0)  # a bushing knows no more than half a turn
    top = scene.bodies[0]
    above = (top.position[0], top.position[1], top.position[2] + 0.3)  # type: ignore[misc]
    loads = (
        SpringDamper(name="spring", body_a="ground", body_b=top.name, point_a=(0.4, 0.1, 0.2), point_b=above,
                     stiffness=30.0, damping=0.2),
        Bushing(name="bush", body_a=top.name, body_b="ground", point=above, stiffness=(3.0, 2.0, 1.0, 0.3, 0.2, 0.1)),
        TorqueVector(name="twist", body=top.name, vector=(0.0, 0.1, 0.2), frame="body"),
        Force(name="knock", body=top.name, point=above, vector=(1.0, 2.0, 0.5),
              factor=HalfSine(peak=1.0, duration=0.033)),
    )  # fmt: skip
    return scene.model_copy(update={"loads": loads, "duration": 0.1})
