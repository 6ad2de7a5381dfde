"""A block that slides to rest on rough ground."""

from __future__ import annotations

from mbs_ref.scene import Scene
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.contact import StickSlip
from mbs_ref.scenes.incline import resting_block


def build(
    *,
    friction: NonNegative = 0.3,
    speed: Positive = 2.0,
    mass: Positive = 2.0,
    height: NonNegative = 0.0,
    stiffness: Positive = 1e5,
    damping: NonNegative = 400.0,
    gravity: Positive = 9.81,
) -> Scene:
    """Slide a block to rest: it stops after v^2 / (2 mu g) and stays.

    friction (mu), speed (m/s), mass (kg), height (m), contact stiffness (N/m) and damping (N s/m) of each
    corner, gravity (m/s^2). It starts on its sunk, tilted corners, so that nothing rocks while it slides; a
    slab without height does not tilt, and its motion is known exactly.
    """
    grip = StickSlip(coefficient=friction, stiffness=stiffness, damping=damping)
    return resting_block(
        name="sliding_block", description="A block thrown along rough ground stops and stays.", angle=0.0, speed=speed,
        friction=grip, mass=mass, height=height, stiffness=stiffness, damping=damping, gravity=gravity, pull=friction,
    )  # fmt: skip
