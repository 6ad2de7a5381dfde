"""Parts of the equations of motion alone, against closed forms: Baumgarte's terms, the gyroscopic torque."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mbs_ref.cores.choice import compile_scene
from mbs_ref.scene import PlanarBody, Prismatic, Scene, SpatialBody, UserForce
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


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_users_law_is_told_time_places_and_speeds_and_its_forces_move_the_bodies(dimension):
    """Two free bodies, round ones in space: the accelerations are forces over masses and torques over inertias."""
    rates = 3 if dimension == 2 else 6
    told: list[tuple[float, np.ndarray, np.ndarray]] = []

    def law(t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        told.append((t, q.copy(), v.copy()))
        return t * np.arange(1.0, 2.0 * rates + 1.0).reshape(2, rates)

    masses, inertias = np.array([[2.0], [5.0]]), np.array([[0.5], [0.8]])
    places = [(1.0, 2.0, 3.0)[:dimension], (-4.0, 0.5, 7.0)[:dimension]]
    speeds, spins = [(0.1, 0.2, 0.3)[:dimension], (-0.4, 0.6, 0.5)[:dimension]], [(1.0, -2.0, 3.0), (4.0, 5.0, -6.0)]
    if dimension == 2:
        bodies = [
            PlanarBody(name=f"b{k}", mass=masses[k, 0], inertia=inertias[k, 0], position=places[k], angle=0.3 + k,
                       velocity=speeds[k], angular_velocity=spins[k][2]) for k in range(2)
        ]  # fmt: skip
    else:
        bodies = [
            SpatialBody(name=f"b{k}", mass=masses[k, 0], inertia=(*(inertias[k, 0],) * 3, 0.0, 0.0, 0.0),
                        position=places[k], velocity=speeds[k], angular_velocity=spins[k]) for k in range(2)
        ]  # fmt: skip
    scene = Scene(
        name="pushed", gravity=(0.0,) * dimension, bodies=tuple(bodies), loads=(UserForce(name="push", function=law),)
    )
    system = compile_scene(scene)
    y = system.initial_state()
    slope = system.derivative(0.7, y)
    t, q, v = told[-1]
    turning = np.array(spins) if dimension == 3 else np.array(spins)[:, 2:]
    assert t == 0.7
    np.testing.assert_array_equal(q[:, :dimension], places)
    assert q[:, dimension].tolist() == ([0.3, 1.3] if dimension == 2 else [1.0, 1.0])
    np.testing.assert_array_equal(v, np.hstack((speeds, turning)))
    wanted = 0.7 * np.arange(1.0, 2.0 * rates + 1.0).reshape(2, rates)
    wanted /= np.hstack((np.repeat(masses, dimension, axis=1), np.repeat(inertias, rates - dimension, axis=1)))
    np.testing.assert_allclose(slope[-2 * rates :].reshape(2, rates), wanted, rtol=1e-12)


def test_a_free_body_turns_by_eulers_equations():
    """I w' = -w x I w in body axes (Euler 1758), about a product of inertia too."""
    inertia = np.array([[2.0, 0.3, -0.1], [0.3, 3.0, 0.4], [-0.1, 0.4, 4.0]])
    spin = np.array([1.0, 2.0, -0.5])
    body = SpatialBody(
        name="top", mass=1.0, inertia=(2.0, 3.0, 4.0, 0.3, -0.1, 0.4), angular_velocity=tuple(spin.tolist())
    )
    scene = Scene(name="top", gravity=(0.0, 0.0, 0.0), bodies=(body,))
    brief = 1e-3  # s
    run = simulate(scene, Settings(method="dop853", rtol=1e-12, t_end=brief, samples=2, estimate="off"))
    turning = -np.linalg.solve(inertia, np.cross(spin, inertia @ spin))  # in body axes, which are the world's at first
    found = (run.angular_velocity[-1, 0] - run.angular_velocity[0, 0]) / brief
    assert np.linalg.norm(turning) > 0.2
    assert found == pytest.approx(turning, abs=math.ceil(np.linalg.norm(spin) ** 3) * brief)
