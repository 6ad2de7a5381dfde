"""Blocks stacked on the ground in space, each on four corners; heavy on light if asked."""

from __future__ import annotations

import itertools
from typing import Annotated

from pydantic import Field

from mbs_ref.scene import GROUND, Scene, SpatialBody
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.contact import SphereOnPlane, SpringDamperLaw
from mbs_ref.scene.inertia import block

LENGTH, WIDTH, HEIGHT = 0.4, 0.3, 0.2  # m


def build(
    *,
    blocks: Annotated[int, Field(ge=1, le=50)] = 3,
    mass: Positive = 1.0,
    ratio: Positive = 1.0,
    stiffness: Positive = 1e6,
    damping: NonNegative = 1000.0,
    gravity: Positive = 9.81,
) -> Scene:
    """Stack blocks, each `ratio` times as heavy as the one below; they sink by their weight over the stiffness.

    blocks, mass of the lowest (kg), ratio (1e4 with 2 blocks is heavy on light), contact stiffness (N/m) and
    damping (N s/m) of each of the four corners, gravity (m/s^2). They start just touching.
    """
    law = SpringDamperLaw(stiffness=stiffness, damping=damping, release="force")
    return Scene(
        name="block_stack",
        description=f"{blocks} blocks stacked without friction, each {ratio:g} times as heavy as the one below.",
        source="Textbook statics",
        duration=1.0,
        gravity=(0.0, 0.0, -gravity),
        bodies=tuple(_block(k, mass * ratio**k) for k in range(blocks)),
        contacts=tuple(
            _corner(k, x, y, law) for k in range(blocks) for x, y in itertools.product((-1, 1), (-1, 1))
        ),
    )  # fmt: skip


def _block(k: int, mass: float) -> SpatialBody:
    inertia = block(mass, LENGTH, WIDTH, HEIGHT)
    return SpatialBody(name=f"block{k}", mass=mass, inertia=inertia, position=(0.0, 0.0, (k + 0.5) * HEIGHT))


def _corner(k: int, x: int, y: int, law: SpringDamperLaw) -> SphereOnPlane:
    on_block = {"extent": "rectangle", "size": (2 * LENGTH, 2 * WIDTH), "edge": (1.0, 0.0, 0.0), "thickness": HEIGHT}
    return SphereOnPlane(
        name=f"corner{k}.{(x + 1) // 2}{(y + 1) // 2}", body_a=f"block{k}", radius=0.0,
        center=(0.5 * x * LENGTH, 0.5 * y * WIDTH, k * HEIGHT), body_b=GROUND if k == 0 else f"block{k - 1}",
        point=(0.0, 0.0, k * HEIGHT), normal=(0.0, 0.0, 1.0), law=law, **({} if k == 0 else on_block),
    )  # fmt: skip
