"""Power of parts that are not conservative: dampers, time-dependent loads, user forces, drives."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import scipy

from mbs_ref import scene as parts
from mbs_ref.observables.attachment import Motion, bushing_strain, gap_of, length_of, pull_of, twist_of
from mbs_ref.scene.base.attached import COORDINATES
from mbs_ref.scene.base.part import unit
from mbs_ref.scene.contact import Contact, Granules
from mbs_ref.scene.signals import prescribed, values


class Touching(NamedTuple):
    """What touches at one moment."""

    ends: np.ndarray  # (n, 2) bodies a and b, -1 for a wall
    gap: np.ndarray  # (n,) m, negative
    normal: np.ndarray  # (n, dimension) from b to a


def touching_granules(part: Granules, position: np.ndarray) -> Touching:
    """Return what touches where the centres are at `position` (n_bodies, dimension), m."""
    radius = np.broadcast_to(part.radius, len(position))
    pairs = scipy.spatial.KDTree(position).query_pairs(2.0 * float(radius.max()), output_type="ndarray")
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


def _granular_power(motion: Motion, part: Granules, k: int) -> float:
    """Return the power (W) of the forces at all contacts of the granules at sample k."""
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


def powers(motion: Motion, is_conservative: Callable) -> np.ndarray | None:
    """Return the power (n_t,), W, of all parts without a potential; None if there are none."""
    terms = [LOADS[type(load)](motion, load) for load in motion.scene.loads if _works(load, is_conservative)]
    terms += [DRIVES[type(j)](motion, j) for j in motion.scene.joints if type(j) in DRIVES]
    terms += [contact_power(motion, contact) for contact in motion.scene.contacts]
    return np.sum(terms, axis=0) if terms else None


def contact_power(motion: Motion, contact: Contact) -> np.ndarray:
    """Return the power (n_t,), W, of a contact's force on both bodies, at the point where it acts."""
    force, place = np.split(motion.trajectory.contacts[contact.name][:, 1:], 2, axis=1)
    slip = motion.rate_at(contact.body_a, place) - motion.rate_at(contact.body_b, place)
    return np.sum(force * slip, axis=1)


def _works(load, is_conservative: Callable) -> bool:
    damping = getattr(load, "damping", None)
    return not is_conservative(load) if damping is None else bool(np.any(np.asarray(damping) > 0.0))


def _damper(motion: Motion, load: parts.SpringDamper) -> np.ndarray:
    _, stretch, rate = length_of(motion, load)
    pull, elastic = pull_of(load, stretch, rate)
    return -(pull - elastic) * rate


def _force(motion: Motion, load: parts.Force) -> np.ndarray:
    _, rate = motion.point(load.body, load.point)
    return values(load.factor, motion.times) * np.sum(rate * _vector(motion, load), axis=1)


def _vector(motion: Motion, load: parts.Force | parts.TorqueVector) -> np.ndarray:
    return np.asarray(load.vector) if load.frame == "world" else motion.direction(load.body, load.vector)[0]


def _torque_vector(motion: Motion, load: parts.TorqueVector) -> np.ndarray:
    return values(load.factor, motion.times) * np.sum(motion.turning(load.body) * _vector(motion, load), axis=1)


def _user_force(motion: Motion, load: parts.UserForce) -> np.ndarray:
    path = motion.trajectory
    shape = (len(path.times), len(motion.scene.bodies), -1)
    q = np.concatenate([path.position, path.orientation.reshape(shape)], axis=2)
    v = np.concatenate([path.velocity, path.angular_velocity.reshape(shape)], axis=2)
    return np.array([np.sum(np.asarray(load.function(t, q[k], v[k])) * v[k]) for k, t in enumerate(path.times)])


def _coordinate_drive(motion: Motion, joint: parts.CoordinateDrive) -> np.ndarray:
    _, rate = prescribed(joint.motion, joint.level, motion.times)
    column = COORDINATES[motion.scene.dimension].index(joint.coordinate)
    return motion.trajectory.reactions[joint.name][:, column] * rate


def _turn_drive(motion: Motion, joint: parts.RotationDrive) -> np.ndarray:
    torque = motion.trajectory.reactions[joint.name][:, 3:]
    return np.sum(torque * (motion.turning(joint.body_b) - motion.turning(joint.body_a)), axis=1)


def _point_drive(motion: Motion, joint: parts.PointDrive) -> np.ndarray:
    _, rate = prescribed(joint.motion, joint.level, motion.times)
    return motion.trajectory.reactions[joint.name][:, : motion.scene.dimension] @ unit(joint.direction) * rate


LOADS: dict[type, Callable[[Motion, Any], np.ndarray]] = {
    parts.SpringDamper: _damper,
    parts.TorsionSpring: lambda motion, load: -load.damping * twist_of(motion, load)[1] ** 2,
    parts.Force: _force,
    parts.Torque: lambda motion, load: values(load.factor, motion.times) * load.torque * motion.turning(load.body),
    parts.TorqueVector: _torque_vector,
    parts.Bushing: lambda motion, load: -(bushing_strain(motion, load)[1] ** 2) @ np.asarray(load.damping),
    parts.PointBushing: lambda motion, load: -load.damping * np.sum(gap_of(motion, load)[1] ** 2, axis=1),
    Granules: lambda motion, load: np.array([_granular_power(motion, load, k) for k in range(len(motion.times))]),
    parts.UserForce: _user_force,
}
DRIVES = {parts.CoordinateDrive: _coordinate_drive, parts.PointDrive: _point_drive, parts.RotationDrive: _turn_drive}
