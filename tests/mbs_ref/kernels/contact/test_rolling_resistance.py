"""Rolling resistance: the deceleration of a wheel, and what it leaves alone."""

from __future__ import annotations

import numpy as np
import pytest

from mbs_ref import observables as judge
from mbs_ref.scene import PlanarBody, Scene, SpatialBody
from mbs_ref.scene.contact import CircleOnLine, RollingFriction, SphereOnPlane, SphereOnSphere, SpringDamperLaw
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

R, SPEED, LEVER, G, SPIN = 0.1, 2.0, 0.005, 9.81, 7.0  # m, m/s, m, m/s^2, rad/s
LAW = SpringDamperLaw(stiffness=1e5, damping=200.0, release="force")
FRICTION = RollingFriction(coefficient=0.6, speed=1e-4, lever=LEVER, rate=1e-3)
DEPTH = G / 1e5  # m, at rest


def wheel(dimension: int) -> tuple[Scene, float]:
    """Return a disc or a sphere of 1 kg that rolls along x, and I/(m r^2)."""
    shape, middle = (0.5, 0.4)[dimension - 2], (0.0, R - DEPTH, 0.0) if dimension == 2 else (0.0, 0.0, R - DEPTH)
    inertia, ends = shape * R**2, {"body_a": "wheel", "radius": R, "law": LAW, "friction": FRICTION}
    if dimension == 2:
        body = PlanarBody(name="wheel", mass=1.0, inertia=inertia, position=middle[:2], velocity=(SPEED, 0.0),
                          angular_velocity=-SPEED / R)  # fmt: skip
        touch = CircleOnLine(name="ground", center=middle[:2], point_1=(0.0, 0.0), point_2=(1.0, 0.0), **ends)
        return Scene(name="wheel", duration=1.0, gravity=(0.0, -G), bodies=(body,), contacts=(touch,)), shape
    ball = SpatialBody(name="wheel", mass=1.0, inertia=(inertia, inertia, inertia, 0.0, 0.0, 0.0), position=middle,
                       velocity=(SPEED, 0.0, 0.0), angular_velocity=(0.0, SPEED / R, SPIN))  # fmt: skip
    plane = SphereOnPlane(name="ground", center=middle, point=(0.0, 0.0, 0.0), normal=(0.0, 0.0, 1.0), **ends)
    return Scene(name="wheel", duration=1.0, gravity=(0.0, 0.0, -G), bodies=(ball,), contacts=(plane,)), shape


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_wheel_slows_down_by_its_lever(dimension):
    """m a = -f and I a/r = f r - e N: a = -g e/r / (1 + I/(m r^2)); spin about the normal goes on."""
    scene, shape = wheel(dimension)
    path = simulate(scene, Settings(method="dop853", rtol=1e-9, estimate="off"), np.linspace(0.0, 0.3, 7))
    slowing = G * LEVER / R / (1.0 + shape)
    slip = FRICTION.speed * np.arctanh(slowing / (G * FRICTION.coefficient))  # m/s, at which friction slows the wheel
    ahead = slip * shape / (1.0 + shape)  # m/s: it begins without slip, and keeps its momentum about the floor
    np.testing.assert_allclose(path.velocity[1:, 0, 0], SPEED - slowing * path.times[1:] + ahead, atol=1e-8)
    if dimension == 3:
        np.testing.assert_allclose(path.angular_velocity[:, 0, 2], SPIN, rtol=1e-8)
    force, place = path.contacts["ground"][-1, 1:].reshape(2, dimension)
    assert place[0] - path.position[-1, 0, 0] == pytest.approx(LEVER, rel=1e-6)  # it acts ahead of the wheel
    assert force[-1] == pytest.approx(G, rel=1e-6)
    energy = judge.kinetic_energy(scene, path)
    turning = path.angular_velocity[:, 0] if dimension == 2 else path.angular_velocity[:, 0, 1]
    lost = force[-1] * LEVER * np.trapezoid(np.abs(turning), path.times)
    assert energy[0] - energy[-1] == pytest.approx(lost, rel=1e-3)


def test_it_is_a_couple_between_two_bodies():
    """Rolling spheres that collide keep their momentum and angular momentum to roundoff."""
    balls = tuple(
        SpatialBody(name=name, mass=1.0, inertia=(0.004, 0.004, 0.004, 0.0, 0.0, 0.0), position=(x, y, 0.0),
                    velocity=(-10.0 * x, 0.0, 0.0), angular_velocity=(1.0, spin, 30.0))
        for name, x, y, spin in (("a", -0.11, 0.02, 5.0), ("b", 0.11, 0.0, -8.0))
    )  # fmt: skip
    touch = SphereOnSphere(name="touch", body_a="a", body_b="b", center_a=balls[0].position, radius_a=R,
                           center_b=balls[1].position, radius_b=R, law=LAW, friction=FRICTION)  # fmt: skip
    scene = Scene(name="pair", duration=0.1, gravity=(0.0, 0.0, 0.0), bodies=balls, contacts=(touch,))
    path = simulate(scene, Settings(method="dop853", rtol=1e-9, estimate="off"), np.array([0.0, 0.1]))
    spun = np.sum(np.cross(path.position, path.velocity) + 0.004 * path.angular_velocity, axis=1)
    np.testing.assert_allclose(spun[1], spun[0], atol=1e-13)
    np.testing.assert_allclose(path.velocity.sum(axis=1)[1], path.velocity.sum(axis=1)[0], atol=1e-14)
    assert np.abs(path.angular_velocity[1] - path.angular_velocity[0]).max() > 0.1
