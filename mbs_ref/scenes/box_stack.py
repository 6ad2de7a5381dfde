"""Boxes stacked on the ground, heavy on light if asked."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from mbs_ref.scene import GROUND, PlanarBody, Scene
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.contact import CircleOnLine, SpringDamperLaw

WIDTH, HEIGHT = 0.4, 0.2  # m


def build(
    *,
    boxes: Annotated[int, Field(ge=1, le=200)] = 3,
    mass: Positive = 1.0,
    ratio: Positive = 1.0,
    stiffness: Positive = 1e6,
    damping: NonNegative = 1000.0,
    gravity: Positive = 9.81,
) -> Scene:
    """Stack boxes, each `ratio` times as heavy as the one below; they sink by their weight over the stiffness.

    boxes, mass of the lowest (kg), ratio (1e4 with 2 boxes is heavy on light), contact stiffness (N/m) and
    damping (N s/m) of each of the two corners, gravity (m/s^2). They start just touching.
    """
    law = SpringDamperLaw(stiffness=stiffness, damping=damping, release="force")
    masses = [mass * ratio**k for k in range(boxes)]
    return Scene(
        name="box_stack",
        description=f"{boxes} boxes stacked without friction, each {ratio:g} times as heavy as the one below.",
        source="Textbook statics",
        duration=1.0,
        gravity=(0.0, -gravity),
        bodies=tuple(
            PlanarBody(
                name=f"box{k}", mass=m, inertia=m * (WIDTH**2 + HEIGHT**2) / 12.0, position=(0.0, (k + 0.5) * HEIGHT)
            )
            for k, m in enumerate(masses)
        ),
        contacts=tuple(_corner(k, side, law) for k in range(boxes) for side in (0, 1)),
    )  # fmt: skip


def _corner(k: int, side: int, law: SpringDamperLaw) -> CircleOnLine:
    return CircleOnLine(
        name=f"corner{k}.{side}", body_a=f"box{k}", center=((side - 0.5) * WIDTH, k * HEIGHT), radius=0.0,
        body_b=GROUND if k == 0 else f"box{k - 1}", point_1=(-WIDTH, k * HEIGHT), point_2=(WIDTH, k * HEIGHT),
        extent="line" if k == 0 else "segment", law=law,
    )  # fmt: skip
