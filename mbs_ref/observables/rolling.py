"""How well wheels roll: the speed of their rim against that of the surface they press on."""

from __future__ import annotations

import numpy as np

from mbs_ref.observables.attachment import Motion

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
