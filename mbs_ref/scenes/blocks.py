"""Blocks on rough ground, from equilibrium: resting on an incline, and sliding to rest."""

import math
from collections.abc import Iterator
from typing import Annotated, Any

import scipy
from pydantic import Field

from mbs_ref.scene import PlanarBody, Scene
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.contact import CircleOnLine, Friction, SpringDamperLaw, StickSlip

LENGTH, HEIGHT = 0.4, 0.1  # m


def incline(
    *,
    angle: Annotated[float, Field(ge=0.0, lt=1.5)] = 0.17453292519943295,
    friction: NonNegative = 0.3,
    mass: Positive = 2.0,
    stiffness: Positive = 1e5,
    damping: NonNegative = 400.0,
    gravity: Positive = 9.81,
) -> Scene:
    """Rest a block on an incline: it sticks where tan(angle) <= mu, else slides at g (sin - mu cos).

    angle of the incline (rad; 10 degrees), friction (mu), mass (kg), contact stiffness (N/m) and damping
    (N s/m) of each corner, gravity (m/s^2).
    """
    grip = StickSlip(coefficient=friction, stiffness=stiffness, damping=damping)
    pull = min(math.tan(angle), friction)
    return _resting_block(
        name="incline", description="A block laid on an incline.", angle=angle, speed=0.0, friction=grip, mass=mass,
        height=HEIGHT, stiffness=stiffness, damping=damping, gravity=gravity, pull=pull,
    )  # fmt: skip


def _tilt(height: float, sink: float, pull: float) -> float:
    """Return the angle (rad) at which two corners, sunk by `sink` together, leave no moment about the centre.

    With x, y of a corner from the centre and its force proportional to its depth: sum (x + pull y) depth = 0.
    """

    def moment(tilt: float) -> float:
        c, s = math.cos(tilt), math.sin(tilt)
        left, right = 0.5 * (sink + LENGTH * s), 0.5 * (sink - LENGTH * s)
        x = 0.5 * LENGTH * c * (right - left) + 0.5 * height * s * (left + right)
        y = 0.5 * LENGTH * s * (right - left) - 0.5 * height * c * (left + right)
        return x + pull * y

    return (
        float(scipy.optimize.root_scalar(moment, bracket=(-0.1, 0.1), xtol=1e-18, rtol=1e-15).root) if height else 0.0
    )


def _resting_block(
    *, name: str, description: str, angle: float, speed: float, friction: Friction, mass: float, height: float,
    stiffness: float, damping: float, gravity: float, pull: float,
) -> Scene:  # fmt: skip
    """Return a block on two corners in equilibrium of normal force and of moments.

    `pull` is friction over normal force, uphill positive. The axes are those of the incline; gravity is turned.
    """
    normal = mass * gravity * math.cos(angle)
    sink = normal / stiffness
    tilt = _tilt(height, sink, pull)
    center = (0.0, 0.5 * height * math.cos(tilt) - 0.5 * sink)
    law = SpringDamperLaw(stiffness=stiffness, damping=damping, release="force")
    return Scene(
        name=name,
        description=description,
        source="Coulomb 1785",
        duration=1.5,
        gravity=(gravity * math.sin(angle), -gravity * math.cos(angle)),
        bodies=(
            PlanarBody(
                name="block", mass=mass, inertia=mass * (LENGTH**2 + height**2) / 12.0, position=center, angle=tilt,
                velocity=(speed, 0.0),
            ),
        ),
        contacts=tuple(_corners(center, tilt, height, law=law, friction=friction)),
    )  # fmt: skip


def _corners(center: tuple[float, float], tilt: float, height: float, **law: Any) -> Iterator[CircleOnLine]:
    """Yield the contacts of a block's corners with the ground, the lower ones first; a slab has no others."""
    c, s = math.cos(tilt), math.sin(tilt)
    for y, level in ((-0.5, ""), (0.5, "upper."))[: 2 if height else 1]:
        for x, side in ((-0.5, "left"), (0.5, "right")):
            ahead, up = x * LENGTH, y * height
            corner = (center[0] + c * ahead - s * up, center[1] + s * ahead + c * up)
            yield CircleOnLine(name=f"corner.{level}{side}", body_a="block", center=corner, radius=0.0,
                               point_1=(0.0, 0.0), point_2=(1.0, 0.0), **law)  # fmt: skip


def sliding_block(
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
    return _resting_block(
        name="sliding_block", description="A block thrown along rough ground stops and stays.", angle=0.0, speed=speed,
        friction=grip, mass=mass, height=height, stiffness=stiffness, damping=damping, gravity=gravity, pull=friction,
    )  # fmt: skip
