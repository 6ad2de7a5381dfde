"""Lengths and twists of springs along a motion."""

from __future__ import annotations

import numpy as np

from mbs_ref.observables.attachment import Motion
from mbs_ref.scene import Bushing, SpringDamper, TorsionSpring


def length_of(motion: Motion, spring: SpringDamper) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return length, stretch beyond the rest length (m) and rate of length (m/s); each (n_t,)."""
    a, a_rate = motion.point(spring.body_a, spring.point_a)
    b, b_rate = motion.point(spring.body_b, spring.point_b)
    gap = b - a
    length = np.linalg.norm(gap, axis=1)
    initial = float(np.linalg.norm(np.subtract(spring.point_b, spring.point_a)))
    rest = spring.rest_length if spring.rest_length is not None else initial
    along = np.divide(gap, length[:, None], out=np.zeros_like(gap), where=length[:, None] > 0.0)
    return length, length - rest, np.sum(along * (b_rate - a_rate), axis=1)


def twist_of(motion: Motion, spring: TorsionSpring) -> tuple[np.ndarray, np.ndarray]:
    """Return the relative angle beyond the rest angle (rad) and its rate (rad/s); each (n_t,)."""
    turned = motion.angle(spring.body_b) - motion.angle(spring.body_a)
    offset = 0.0
    if spring.rest_angle is not None:
        offset = _initial_angle(motion, spring.body_b) - _initial_angle(motion, spring.body_a) - spring.rest_angle
    return turned + offset, motion.spin(spring.body_b) - motion.spin(spring.body_a)


def _initial_angle(motion: Motion, body: str) -> float:
    k = motion.scene.body_index(body)
    return 0.0 if k < 0 else getattr(motion.scene.bodies[k], "angle", 0.0)


def gap_of(motion: Motion, bushing: Bushing) -> tuple[np.ndarray, np.ndarray]:
    """Return the gap between the marks (n_t, 2), m, and the slip at b's mark (m/s), where both forces act."""
    a, _ = motion.point(bushing.body_a, bushing.point)
    b, b_rate = motion.point(bushing.body_b, bushing.point)
    return b - a, b_rate - motion.rate_at(bushing.body_a, b)
