"""Points and directions fixed in a body, followed along a trajectory; lengths and twists of springs."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from mbs_ref import scene as parts
from mbs_ref.scene import GROUND, PlanarBody, PointMass
from mbs_ref.scene.base.part import unit
from mbs_ref.scene.euler_parameters import floats, rotation_matrices
from mbs_ref.trajectory import Trajectory

PERP = np.array([[0.0, -1.0], [1.0, 0.0]])  # turns a plane vector by +90 degrees


@dataclass(frozen=True)
class Motion:
    """A scene and its motion: what an observable looks at."""

    scene: parts.Scene
    trajectory: Trajectory

    @cached_property
    def _known_axes(self) -> dict[int, tuple[np.ndarray, np.ndarray]]:
        return {}

    @property
    def times(self) -> np.ndarray:
        return self.trajectory.times

    def point(self, body: str, world: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
        """Return position and velocity (n_t, dimension) of the point that is at `world` (m) at t = 0."""
        if body == GROUND:
            return self._fixed(world)
        k = self.scene.body_index(body)
        arm = np.subtract(world, self.scene.bodies[k].position)
        arm_t, arm_rate = self.direction(body, arm)
        return self.trajectory.position[:, k] + arm_t, self.trajectory.velocity[:, k] + arm_rate

    def rate_at(self, body: str, place: np.ndarray) -> np.ndarray:
        """Return the velocity of the body's matter that is at `place` (n_t, dimension) at each time."""
        k = self.scene.body_index(body)
        if k < 0:
            return np.zeros_like(place)
        arm = place - self.trajectory.position[:, k]
        return self.trajectory.velocity[:, k] + _swing(self.turning(body), arm)

    def direction(self, body: str, world) -> tuple[np.ndarray, np.ndarray]:
        """Return a body-fixed vector (n_t, dimension) that equals `world` at t = 0, and its rate."""
        k = self.scene.body_index(body)
        if k < 0 or isinstance(self.scene.bodies[k], PointMass):
            return self._fixed(world)  # a particle does not turn
        start, course = self._axes(k)
        now = course @ (start.T @ floats(world))
        return now, _swing(self.turning(body), now)

    def _axes(self, k: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the body's axes at t = 0 (dimension, dimension) and at each time (n_t, dimension, dimension)."""
        if k not in self._known_axes:
            body, course = self.scene.bodies[k], self.trajectory.orientation[:, k]
            if isinstance(body, parts.SpatialBody):
                self._known_axes[k] = rotation_matrices(body.orientation), rotation_matrices(course)
            else:
                c, s = np.cos(self.angle(body.name)), np.sin(self.angle(body.name))
                self._known_axes[k] = np.eye(2), np.moveaxis(np.array([[c, -s], [s, c]]), -1, 0)
        return self._known_axes[k]

    def turning(self, body: str) -> np.ndarray:
        """Return the angular velocity (n_t,), in space (n_t, 3), rad/s; zero for ground and particles."""
        k, every = self.scene.body_index(body), self.trajectory.angular_velocity
        if k < 0 or isinstance(self.scene.bodies[k], PointMass):
            return np.zeros_like(every[:, 0])
        return every[:, k]

    def angle_about(self, body_a: str, body_b: str, axis) -> tuple[np.ndarray, np.ndarray]:
        """Return the angle (n_t,) in (-pi, pi] of b about an axis fixed in a since t = 0, and its rate."""
        zero, quarter = perpendiculars(axis)
        (z, _), (q, _) = self.direction(body_a, zero), self.direction(body_a, quarter)
        mark, _ = self.direction(body_b, zero)
        rate = np.sum((self.turning(body_b) - self.turning(body_a)) * np.cross(z, q), axis=1)
        return np.arctan2(np.sum(q * mark, axis=1), np.sum(z * mark, axis=1)), rate

    def angle(self, body: str) -> np.ndarray:
        """Return the angle turned since t = 0 (n_t,), rad; zero for ground and particles."""
        k = self.scene.body_index(body)
        start = self.scene.bodies[k]
        if k < 0 or not isinstance(start, PlanarBody):
            return np.zeros(len(self.times))
        return self.trajectory.orientation[:, k] - start.angle

    def _fixed(self, world) -> tuple[np.ndarray, np.ndarray]:
        shape = (len(self.times), self.scene.dimension)
        return np.broadcast_to(floats(world), shape), np.zeros(shape)


def _swing(omega: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """Return omega x arm (n_t, dimension)."""
    return np.cross(omega, arm) if arm.shape[1] == 3 else omega[:, None] * (arm @ PERP.T)


def perpendiculars(axis) -> tuple[np.ndarray, np.ndarray]:
    """Return two unit vectors u, w with u x w along the axis."""
    axis = unit(axis)
    helper = np.zeros(3)
    helper[np.argmin(np.abs(axis))] = 1.0
    u = unit(np.cross(helper, axis))
    return u, np.cross(axis, u)


def length_of(motion: Motion, part: parts.SpringDamper | parts.Distance) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return length, stretch beyond the rest length or the rod's (m) and rate of length (m/s); each (n_t,)."""
    (a, a_rate), (b, b_rate) = (motion.point(*end) for end in zip(part.ends, part.marks, strict=True))
    gap = b - a
    length = np.linalg.norm(gap, axis=1)
    given = part.length if isinstance(part, parts.Distance) else part.rest_length
    rest = float(np.linalg.norm(np.subtract(*part.marks))) if given is None else given
    along = np.divide(gap, length[:, None], out=np.zeros_like(gap), where=length[:, None] > 0.0)
    return length, length - rest, np.sum(along * (b_rate - a_rate), axis=1)


def pull_of(spring: parts.SpringDamper, stretch: np.ndarray, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the pull (n_t,), N, of a spring, and the part of it without its damper."""
    elastic, pull = spring.stiffness * stretch, spring.stiffness * stretch + spring.damping * rate
    if not spring.tension_only:
        return pull, elastic
    most = np.inf if spring.limit is None else spring.limit
    return np.where(stretch > 0.0, np.clip(pull, 0.0, most), 0.0), np.clip(elastic, 0.0, most)


def twist_of(motion: Motion, spring: parts.TorsionSpring) -> tuple[np.ndarray, np.ndarray]:
    """Return the relative angle beyond the rest angle (rad) and its rate (rad/s); each (n_t,)."""
    if spring.axis is not None:
        angle, rate = motion.angle_about(spring.body_a, spring.body_b, spring.axis)
        return angle - (spring.rest_angle or 0.0), rate
    turned = motion.angle(spring.body_b) - motion.angle(spring.body_a)
    offset = 0.0
    if spring.rest_angle is not None:
        offset = _initial_angle(motion, spring.body_b) - _initial_angle(motion, spring.body_a) - spring.rest_angle
    return turned + offset, motion.turning(spring.body_b) - motion.turning(spring.body_a)


def _initial_angle(motion: Motion, body: str) -> float:
    k = motion.scene.body_index(body)
    return 0.0 if k < 0 else getattr(motion.scene.bodies[k], "angle", 0.0)


def bushing_strain(motion: Motion, bushing: parts.Bushing) -> tuple[np.ndarray, np.ndarray]:
    """Return offset and rotation vector (n_t, 6) along the bushing's axes in body a, and their rates for dampers."""
    ends = zip(bushing.ends, bushing.frames, strict=True)
    here, there = (np.stack([motion.direction(body, e)[0] for e in frame.T], axis=2) for body, frame in ends)
    (a, a_rate), (b, b_rate) = (motion.point(end, at) for end, at in zip(bushing.ends, bushing.marks, strict=True))
    carried = np.cross(motion.turning(bushing.body_a), b - a)
    relative = scipy.spatial.transform.Rotation.from_matrix(np.swapaxes(here, 1, 2) @ there).as_rotvec()
    seen = [b - a, b_rate - a_rate - carried, motion.turning(bushing.body_b) - motion.turning(bushing.body_a)]
    offset, offset_rate, spin = (np.einsum("tij,ti->tj", here, v) for v in seen)
    return np.concatenate((offset, relative), axis=1), np.concatenate((offset_rate, spin), axis=1)


def gap_of(motion: Motion, bushing: parts.PointBushing) -> tuple[np.ndarray, np.ndarray]:
    """Return the gap between the marks (n_t, 2), m, and the slip at b's mark (m/s), where both forces act."""
    (a, _), (b, b_rate) = (motion.point(end, at) for end, at in zip(bushing.ends, bushing.marks, strict=True))
    return b - a, b_rate - motion.rate_at(bushing.body_a, b)
