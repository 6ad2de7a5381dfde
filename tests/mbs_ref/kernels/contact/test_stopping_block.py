"""A block slides and spins to rest on a horizontal floor, where no friction is needed to hold it."""

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.scene.contact import RegularisedCoulomb, StickSlip
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

FRICTION, STIFFNESS, G = 0.18, 1e6, 9.81
STICKS = StickSlip(coefficient=FRICTION, stiffness=STIFFNESS, damping=1000.0)


def block(friction, velocity: tuple[float, float, float], spin: float) -> Scene:
    stack = scenes.make("block_stack", blocks=1, stiffness=STIFFNESS)
    sunk = (0.0, 0.0, 0.1 - 0.25 * G / STIFFNESS)
    start = {"position": sunk, "velocity": velocity, "angular_velocity": (0.0, 0.0, spin)}
    contacts = tuple(contact.model_copy(update={"friction": friction}) for contact in stack.contacts)
    return stack.model_copy(update={"bodies": (stack.bodies[0].model_copy(update=start),), "contacts": contacts})


def end(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    path = simulate(scene, Settings(method="dop853", rtol=1e-8, estimate="off", reactions=False))
    assert path.ok, path.message
    assert np.abs(path.velocity[-1]).max() < 1e-6
    return path.position[-1, 0], path.orientation[-1, 0]


def test_a_block_that_does_not_spin_stops_after_the_distance_of_coulomb():
    velocity = (0.3, 0.1, 0.0)
    position, orientation = end(block(STICKS, velocity, 0.0))
    stop = np.array(velocity) * np.hypot(*velocity[:2]) / (2.0 * FRICTION * G)
    assert position[:2] == pytest.approx(stop[:2], abs=1e-6)  # m: braked, it leans by mu m g h^2/(k L^2)
    assert orientation == pytest.approx((1.0, 0.0, 0.0, 0.0), abs=1e-6)


@pytest.mark.parametrize(("velocity", "spin"), [((0.5, 0.0, 0.0), 0.1), ((0.05, 0.1, 0.0), 3.0)])
def test_a_block_that_spins_stops_where_smooth_friction_stops_it(velocity, spin):
    smooth = RegularisedCoulomb(coefficient=FRICTION, speed=1e-4)
    for ours, limit in zip(end(block(STICKS, velocity, spin)), end(block(smooth, velocity, spin)), strict=True):
        assert ours == pytest.approx(limit, abs=1e-6)


@pytest.mark.parametrize(("mass", "angle"), [(40.0, 0.1745), (7.0, 0.1745), (40.0, 0.28)])
def test_an_undamped_block_on_an_incline_is_held_to_roundoff(mass, angle):
    """Its corners are not sunk alike: what turns it by rounding alone is balanced by forces within the block."""
    scene = scenes.make("incline", mass=mass, angle=angle, damping=0.0)
    path = simulate(scene, Settings(method="dop853", rtol=1e-12, estimate="off", reactions=False))
    assert np.abs(path.position - path.position[0]).max() < 1e-13
    assert np.abs(path.angular_velocity).max() < 1e-10
