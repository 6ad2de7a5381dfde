"""A rigid body turning freely: Euler's top, also about its intermediate axis."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbs_ref.scene import Scene, SpatialBody
from mbs_ref.scene.base.part import Positive
from mbs_ref.scene.euler_parameters import rotation_matrices


def build(
    *,
    turns: Annotated[float, Field(gt=0.0, le=1e6)] = 100.0,
    spin: Positive = 10.0,
    axis: Literal[1, 2, 3] = 2,
    tilt: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.1,
    inertia_1: Positive = 1.0,
    inertia_2: Positive = 2.0,
    inertia_3: Positive = 3.0,
) -> Scene:
    """Spin a free body nearly about one principal axis and let it turn many times.

    turns (duration in turns at `spin`), spin (rad/s about the chosen axis), axis (1, 2 or 3; the one with
    the intermediate moment tumbles), tilt (rates about the other two axes, as a share of spin), inertia_1,
    inertia_2, inertia_3 (principal moments, kg m^2). The body starts turned away from the world axes.
    """
    omega = np.full(3, tilt * spin)
    omega[axis - 1] = spin
    start = np.array([1.0, 2.0, 3.0, 4.0]) / math.sqrt(30.0)  # a turn of no special kind
    return Scene(
        name="torque_free_top",
        description=f"A free rigid body, {turns:g} turns at {spin:g} rad/s about its principal axis {axis}.",
        source="Landau and Lifshitz, Mechanics, 3rd ed., sec. 37; exact in Jacobi's elliptic functions",
        duration=turns * 2.0 * math.pi / spin,
        gravity=(0.0, 0.0, 0.0),
        bodies=(
            SpatialBody(
                name="top", mass=1.0, inertia=(inertia_1, inertia_2, inertia_3, 0.0, 0.0, 0.0),
                orientation=tuple(start.tolist()), angular_velocity=tuple((rotation_matrices(start) @ omega).tolist()),
            ),
        ),
    )  # fmt: skip
