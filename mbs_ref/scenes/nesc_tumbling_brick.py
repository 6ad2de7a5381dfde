"""NASA's check case 2 of atmospheric flight: a brick tumbles freely."""

from __future__ import annotations

import math

import numpy as np

from mbs_ref.scene import Scene, SpatialBody
from mbs_ref.scene.base.part import Positive
from mbs_ref.scene.euler_parameters import rotation_matrices
from mbs_ref.scenes.nesc_dropped_sphere import FOOT, SLUG

MASS = 0.155404754 * SLUG  # kg
ROLL, PITCH, YAW = (moment * SLUG * FOOT**2 for moment in (0.001894220, 0.006211019, 0.007194665))  # kg m^2
RATES_DEG = (10.0, 20.0, 30.0)  # deg/s, roll, pitch, yaw about body axes, against the stars
LEVEL = (math.sqrt(0.5), 0.0, -math.sqrt(0.5), 0.0)  # body x, y, z north, east, down at latitude and longitude 0


def build(*, duration: Positive = 30.0) -> Scene:
    """Let a brick with three different moments of inertia tumble, no torque acting.

    duration (s). Axes do not turn: z is the Earth's, x points from its centre to the start over the equator. The brick
    falls as the sphere of case 1 does, which turns nothing; the scene stays with its centre of mass.
    """
    omega = rotation_matrices(np.array(LEVEL)) @ np.radians(RATES_DEG)
    return Scene(
        name="nesc_tumbling_brick",
        description="A brick tumbles freely, 10, 20 and 30 deg/s about its principal axes.",
        source="Jackson, Shelton, Jackson, Castro, Hill, NASA/TM-2015-218675, atmospheric check case 2",
        duration=duration,
        gravity=(0.0, 0.0, 0.0),
        bodies=(
            SpatialBody(
                name="brick", mass=MASS, inertia=(ROLL, PITCH, YAW, 0.0, 0.0, 0.0), orientation=LEVEL,
                angular_velocity=tuple(omega.tolist()),
            ),
        ),
    )  # fmt: skip
