"""Contacts of granules along a motion, from poses alone; pairs are found by SciPy's k-d tree."""

from typing import NamedTuple

import numpy as np

from mbs_ref.observables.attachment import Motion
from mbs_ref.scene.base.part import unit
from mbs_ref.scene.contact import Granules


class Touching(NamedTuple):
    """What touches at one moment."""

    ends: np.ndarray  # (n, 2) bodies a and b, -1 for a wall
    gap: np.ndarray  # (n,) m, negative
    normal: np.ndarray  # (n, dimension) from b to a


def touching_granules(part: Granules, position: np.ndarray) -> Touching:
    """Return what touches where the centres are at `position` (n_bodies, dimension), m."""
    from scipy.spatial import KDTree  # a large import for few

    radius = np.broadcast_to(part.radius, len(position))
    pairs = KDTree(position).query_pairs(2.0 * float(radius.max()), output_type="ndarray")
    pairs = pairs[np.all(radius[pairs] > 0.0, axis=1)]
    apart = position[pairs[:, 0]] - position[pairs[:, 1]]
    distance = np.linalg.norm(apart, axis=1)
    found = [Touching(pairs, distance - radius[pairs].sum(axis=1), apart / np.maximum(distance, 1e-300)[:, None])]
    own = np.flatnonzero(radius)
    for wall in part.walls:
        normal, ends = unit(wall.normal), np.column_stack((own, np.full(len(own), -1)))
        gap = (position[own] - wall.point) @ normal - radius[own]
        found.append(Touching(ends, gap, np.broadcast_to(normal, position[own].shape)))
    ends, gap, normal = map(np.concatenate, zip(*found, strict=True))
    return Touching(ends[gap < 0.0], gap[gap < 0.0], normal[gap < 0.0])


def granular_power(motion: Motion, part: Granules) -> np.ndarray:
    """Return the power (n_t,), W, of the forces at all contacts of the granules."""
    return np.array([_power(motion, part, k) for k in range(len(motion.times))])


def _power(motion: Motion, part: Granules, k: int) -> float:
    path, law = motion.trajectory, part.law.numbers()
    (ends, gap, normal), centres = touching_granules(part, path.position[k]), path.position[k]
    place = centres[ends[:, 0]] - np.broadcast_to(part.radius, len(centres))[ends[:, :1]] * normal
    arm, turning = place[:, None] - centres[ends], path.angular_velocity[k][ends]  # (n, 2, ...)
    turned = np.stack((-arm[..., 1], arm[..., 0]), axis=-1)
    swing = np.cross(turning, arm) if centres.shape[1] == 3 else turning[..., None] * turned
    u = np.where(ends[..., None] < 0, 0.0, path.velocity[k][ends] + swing)
    slip = u[:, 0] - u[:, 1]
    rate = np.sum(slip * normal, axis=1)
    force = law.stiffness * (-gap) ** law.exponent - law.damping * (-gap) ** law.damping_exponent * rate
    force = np.maximum(force, 0.0) if law.release == "force" else force
    speed = np.linalg.norm(slip - rate[:, None] * normal, axis=1)
    drag = part.friction.coefficient * np.tanh(speed / part.friction.speed) if part.friction else 0.0
    return float(np.sum(force * (rate - drag * speed)))
