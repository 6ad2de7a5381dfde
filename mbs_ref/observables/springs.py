"""Lengths and twists of springs along a motion."""

import numpy as np

from mbs_ref.observables.attachment import Motion
from mbs_ref.scene import Bushing, PointBushing, SpringDamper, TorsionSpring


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


def pull_of(spring: SpringDamper, stretch: np.ndarray, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the pull (n_t,), N, of a spring, and the part of it without its damper."""
    elastic, pull = spring.stiffness * stretch, spring.stiffness * stretch + spring.damping * rate
    if not spring.tension_only:
        return pull, elastic
    most = np.inf if spring.limit is None else spring.limit
    return np.where(stretch > 0.0, np.clip(pull, 0.0, most), 0.0), np.clip(elastic, 0.0, most)


def twist_of(motion: Motion, spring: TorsionSpring) -> tuple[np.ndarray, np.ndarray]:
    """Return the relative angle beyond the rest angle (rad) and its rate (rad/s); each (n_t,)."""
    if spring.axis is not None:
        angle, rate = motion.angle_about(spring.body_a, spring.body_b, spring.axis)
        return angle - (spring.rest_angle or 0.0), rate
    turned = motion.angle(spring.body_b) - motion.angle(spring.body_a)
    offset = 0.0
    if spring.rest_angle is not None:
        offset = _initial_angle(motion, spring.body_b) - _initial_angle(motion, spring.body_a) - spring.rest_angle
    return turned + offset, motion.spin(spring.body_b) - motion.spin(spring.body_a)


def _initial_angle(motion: Motion, body: str) -> float:
    k = motion.scene.body_index(body)
    return 0.0 if k < 0 else getattr(motion.scene.bodies[k], "angle", 0.0)


def bushing_strain(motion: Motion, bushing: Bushing) -> tuple[np.ndarray, np.ndarray]:
    """Return offset and rotation vector (n_t, 6) along the bushing's axes in body a, and their rates for dampers."""
    x, y = (np.asarray(v) / np.linalg.norm(v) for v in (bushing.x_axis, bushing.y_axis))
    axes = (x, y, np.cross(x, y))
    bodies = (bushing.body_a, bushing.body_b)
    here, there = (np.stack([motion.direction(body, e)[0] for e in axes], axis=2) for body in bodies)
    (a, a_rate), (b, b_rate) = motion.point(bushing.body_a, bushing.point), motion.point(bushing.body_b, bushing.point)
    carried = np.cross(motion.turning(bushing.body_a), b - a)
    from scipy.spatial.transform import Rotation  # takes long to import

    relative = Rotation.from_matrix(np.swapaxes(here, 1, 2) @ there).as_rotvec()
    seen = [b - a, b_rate - a_rate - carried, motion.turning(bushing.body_b) - motion.turning(bushing.body_a)]
    offset, offset_rate, spin = (np.einsum("tij,ti->tj", here, v) for v in seen)
    return np.concatenate((offset, relative), axis=1), np.concatenate((offset_rate, spin), axis=1)


def gap_of(motion: Motion, bushing: PointBushing) -> tuple[np.ndarray, np.ndarray]:
    """Return the gap between the marks (n_t, 2), m, and the slip at b's mark (m/s), where both forces act."""
    a, _ = motion.point(bushing.body_a, bushing.point)
    b, b_rate = motion.point(bushing.body_b, bushing.point)
    return b - a, b_rate - motion.rate_at(bushing.body_a, b)
