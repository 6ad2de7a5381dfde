"""Granules of a scene -> the arrays of their spheres, walls and law, and room for the list of near pairs."""

from typing import Any

import numpy as np

from mbs_ref.cores.events import RELEASES
from mbs_ref.kernels.border.groups import empty, floats, ints
from mbs_ref.kernels.contact import neighbours
from mbs_ref.scene import PointMass, Scene
from mbs_ref.scene.base.part import unit
from mbs_ref.scene.base.rows import Axes
from mbs_ref.scene.contact import FrictionNumbers, Granules

SKIN = 0.4  # of the mean radius
ROOM = {2: 12, 3: 32}  # neighbours a sphere, by dimension: three times those of equal spheres at their densest


def granules(scene: Scene, places: Axes) -> neighbours.Granules:
    """Return the arrays; ValueError where the part contradicts the scene."""
    parts = [load for load in scene.loads if isinstance(load, Granules)]
    if not parts:
        return empty(neighbours.Granules, dimension=scene.dimension, **{"n + 1": 1})
    if len(parts) > 1:
        raise ValueError(f"loads {', '.join(repr(x.name) for x in parts)} are all granules; give one")
    part = parts[0]
    radius = _radii(scene, part)
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


def _radii(scene: Scene, part: Granules) -> np.ndarray:
    """Return the radius of every body (n_bodies,), m; 0 for one that touches nothing."""
    count = len(scene.bodies)
    if len(part.radius) not in (1, count):
        raise ValueError(f"load {part.name!r}: radius needs 1 entry or {count}, one a body; got {len(part.radius)}")
    radius = np.resize(np.array(part.radius, dtype=float), count)
    points = [body.name for body, r in zip(scene.bodies, radius, strict=True) if r and isinstance(body, PointMass)]
    if part.friction and points:
        raise ValueError(f"load {part.name!r} has friction, which turns point mass {points[0]!r}; leave it out")
    return radius
