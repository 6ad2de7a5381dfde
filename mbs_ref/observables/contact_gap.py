"""Gap, its rate and the sliding speed of a contact along a motion, from world poses alone (plane)."""

from __future__ import annotations

import numpy as np

from mbs_ref.observables.attachment import Motion
from mbs_ref.scene.contact import CircleOnCircle, CircleOnLine


def shapes_known(contact) -> bool:
    """Return whether `gap_of` knows the contact's shapes."""
    return isinstance(contact, CircleOnLine | CircleOnCircle) and len(_centers(contact)[0]) == 2


def gap_of(motion: Motion, contact) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the gap (m, negative inside), its rate and the sliding speed (m/s), each (n_t,)."""
    first, second = _centers(contact)
    center, _ = motion.point(contact.body_a, first)
    other, _ = motion.point(contact.body_b, second)
    apart = center - other
    if isinstance(contact, CircleOnLine):
        along, _ = motion.direction(contact.body_b, np.subtract(contact.point_2, contact.point_1))
        along = along / np.linalg.norm(along, axis=1, keepdims=True)
        normal = np.column_stack((-along[:, 1], along[:, 0]))
        distance, back, reach = np.sum(normal * apart, axis=1), contact.radius, contact.radius
    else:
        distance = np.linalg.norm(apart, axis=1)
        normal = apart / distance[:, None]
        back, reach = contact.radius_a, contact.radius_a + contact.radius_b
    place = center - back * normal
    relative = motion.rate_at(contact.body_a, place) - motion.rate_at(contact.body_b, place)
    tangent = np.column_stack((normal[:, 1], -normal[:, 0]))
    return distance - reach, np.sum(normal * relative, axis=1), np.sum(tangent * relative, axis=1)


def _centers(contact) -> tuple[tuple[float, ...], tuple[float, ...]]:
    if isinstance(contact, CircleOnLine):
        return contact.center, contact.point_1
    return contact.center_a, contact.center_b
