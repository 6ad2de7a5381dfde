"""Gap and sliding speed of a contact along a motion, from world poses alone, and how well wheels roll (plane)."""

import numpy as np

from mbs_ref.observables.attachment import Motion
from mbs_ref.scene.contact import CircleOnLine, RoundPair, SphereOnPlane


def shapes_known(contact) -> bool:
    """Return whether `gap_of` supports the contact's shapes."""
    return isinstance(contact, CircleOnLine | SphereOnPlane | RoundPair)


def gap_of(motion: Motion, contact) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the gap (m, negative inside), its rate and the sliding speed (m/s), each (n_t,); in space its size."""
    gap, normal, relative = relative_motion(motion, contact)
    closing = np.sum(normal * relative, axis=1)
    if normal.shape[1] == 3:
        return gap, closing, np.linalg.norm(relative - closing[:, None] * normal, axis=1)
    tangent = np.column_stack((normal[:, 1], -normal[:, 0]))
    return gap, closing, np.sum(tangent * relative, axis=1)


def relative_motion(motion: Motion, contact) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the gap (n_t,), m, the normal on body b and the velocity (m/s) of a on b there, each (n_t, dimension)."""
    first, second, normal = _shapes(contact)
    center, _ = motion.point(contact.body_a, first)
    other, _ = motion.point(contact.body_b, second)
    apart = center - other
    if len(normal):
        normal, _ = motion.direction(contact.body_b, normal / np.linalg.norm(normal))
        distance, back, reach = np.sum(normal * apart, axis=1), contact.radius, contact.radius
    else:
        distance = np.linalg.norm(apart, axis=1)
        normal = apart / distance[:, None]
        back, reach = contact.radius_a, contact.radius_a + contact.radius_b
    place = center - back * normal
    return distance - reach, normal, motion.rate_at(contact.body_a, place) - motion.rate_at(contact.body_b, place)


def _shapes(contact) -> tuple[tuple[float, ...], tuple[float, ...], np.ndarray]:
    """Return the centre on body a, a point on body b, and the normal of a flat surface or (0,), all at t = 0."""
    if isinstance(contact, CircleOnLine):
        along = np.subtract(contact.point_2, contact.point_1)
        return contact.center, contact.point_1, np.array((-along[1], along[0]))
    if isinstance(contact, SphereOnPlane):
        return contact.center, contact.point, np.array(contact.normal)
    return contact.center_a, contact.center_b, np.empty(0)


SLOWEST = 0.5  # m/s, of the surface against the axle; below it a ratio says little


def rolling_slip(motion: Motion, wheel: str) -> np.ndarray:
    """Return rim speed over surface speed less 1, (n_t,), both along the rim and against the axle, weighted by force.

    The surface is what the wheel's contacts press on, at the points of contact; nan where the wheel carries nothing or
    the surface is slower than SLOWEST.
    """
    path = motion.trajectory
    hub = motion.scene.body_index(wheel)
    place, speed = path.position[:, hub], path.velocity[:, hub]
    rim, surface, load = np.zeros((3, len(path.times)))
    for part in motion.scene.contacts:
        if part.body_a != wheel:
            continue
        force, point = np.hypot(*path.contacts[part.name][:, 1:3].T), path.contacts[part.name][:, 3:5]
        arm = np.where(force[:, None] > 0.0, point - place, 0.0)
        along = np.column_stack((-arm[:, 1], arm[:, 0])) / np.maximum(np.hypot(*arm.T), 1e-300)[:, None]
        rim += force * np.sum((motion.rate_at(wheel, point) - speed) * along, axis=1)
        surface += force * np.sum((motion.rate_at(part.body_b, point) - speed) * along, axis=1)
        load += force
    known = np.abs(surface) > SLOWEST * load
    return np.where(known, rim / np.where(known, surface, 1.0) - 1.0, np.nan)
