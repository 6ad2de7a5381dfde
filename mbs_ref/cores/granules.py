"""Granules of a scene -> the arrays of their spheres, walls and law, and room for the list of near pairs."""

from typing import Any

import numpy as np

from mbs_ref.cores.events import RELEASES
from mbs_ref.kernels.border.groups import empty, floats, ints
from mbs_ref.kernels.contact import neighbours
from mbs_ref.scene import Scene
from mbs_ref.scene.base.part import unit
from mbs_ref.scene.base.rows import Axes
from mbs_ref.scene.contact import FrictionNumbers, Granules

SKIN = 0.4  # of the mean radius
ROOM = {2: 12, 3: 32}  # neighbours a sphere, by dimension: three times those of equal spheres at their densest


def granules(scene: Scene, places: Axes) -> neighbours.Granules:
    """Return the arrays."""
    parts = [load for load in scene.loads if isinstance(load, Granules)]
    if not parts:
        return empty(neighbours.Granules, dimension=scene.dimension, **{"n + 1": 1})
    (part,) = parts
    radius = np.broadcast_to(part.radius, len(scene.bodies))
    chosen = np.flatnonzero(radius)
    law, friction = part.law.numbers(), part.friction.numbers() if part.friction else FrictionNumbers()
    d, n, normals = scene.dimension, len(chosen), [unit(wall.normal) for wall in part.walls]
    numbers: dict[str, Any] = {
        "stiffness": law.stiffness, "dashpot": law.damping, "exponent": law.exponent,
        "damping_exponent": law.damping_exponent, "coefficient": friction.coefficient, "creep": friction.creep,
        "skin": SKIN * float(np.mean(radius[chosen])),
    }  # fmt: skip
    lengths = {"n": n, "n + 1": n + 1, "dimension": d, "most": ROOM[d] * n, "buckets": 1 << (2 * n - 1).bit_length()}
    return empty(neighbours.Granules, **lengths)._replace(
        body=ints([places.body(scene.bodies[k].name) for k in chosen]),
        radius=radius[chosen],
        normal=floats(normals, d),
        offset=floats(n @ np.array(wall.point) for n, wall in zip(normals, part.walls, strict=True)),
        release=ints([RELEASES[law.release]]),
        built=np.full((n, d), np.nan),
        **{name: np.array([value]) for name, value in numbers.items()},
    )
