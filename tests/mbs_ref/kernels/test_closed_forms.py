"""Parts of the equations of motion alone, against closed forms: Baumgarte's terms, the gyroscopic torque."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mbs_ref.scene import PlanarBody, Prismatic, Scene, SpatialBody
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate


@pytest.mark.parametrize("dimension", [2, 3])
def test_baumgartes_terms_damp_a_violation_critically(dimension):
    """C'' + 2 g C' + g^2 C = 0 with C(0) = 0, C'(0) = v has C(t) = v t exp(-g t) (Baumgarte 1972)."""
    speed, gain = 1e-3, 20.0
    velocity = (0.0, speed, 0.0)[:dimension]
    axis = (1.0, 0.0, 0.0)[:dimension]
    if dimension == 2:
        body = PlanarBody(name="cart", mass=2.0, inertia=1.0, velocity=velocity)  # type: ignore[arg-type]
    else:
        body = SpatialBody(name="cart", mass=2.0, inertia=(1.0, 1.0, 1.0, 0.0, 0.0, 0.0), velocity=velocity)  # type: ignore[arg-type]
    rail = Prismatic(name="rail", body_a="ground", body_b="cart", point=(0.0,) * dimension, axis=axis)
    scene = Scene(name="cart", gravity=(0.0,) * dimension, bodies=(body,), joints=(rail,))
    settings = Settings(
        method="rk4", step=1e-3, t_end=0.2, samples=5, stabilization="baumgarte", baumgarte_gain=gain,
        initial_tolerance=1.0, estimate="off",
    )  # fmt: skip
    run = simulate(scene, settings)
    assert run.ok, run.message
    exact = speed * run.times * np.exp(-gain * run.times)
    assert run.position[:, 0, 1] == pytest.approx(exact, abs=1e-6 * speed)


def test_a_free_body_turns_by_eulers_equations():
    """I w' = -w x I w in body axes (Euler 1758), about a product of inertia too."""
    inertia = np.array([[2.0, 0.3, -0.1], [0.3, 3.0, 0.4], [-0.1, 0.4, 4.0]])
    spin = np.array([1.0, 2.0, -0.5])
    body = SpatialBody(
        name="top", mass=1.0, inertia=(2.0, 3.0, 4.0, 0.3, -0.1, 0.4), angular_velocity=tuple(spin.tolist())
    )
    scene = Scene(name="top", gravity=(0.0, 0.0, 0.0), bodies=(body,))
    brief = 1e-3  # s
    run = simulate(scene, Settings(method="dop853", rtol=1e-12, t_end=brief, samples=2))
    turning = -np.linalg.solve(inertia, np.cross(spin, inertia @ spin))  # in body axes, which are the world's at first
    found = (run.angular_velocity[-1, 0] - run.angular_velocity[0, 0]) / brief
    assert np.linalg.norm(turning) > 0.2
    assert found == pytest.approx(turning, abs=math.ceil(np.linalg.norm(spin) ** 3) * brief)
