"""The gravity gradient on rigid satellites, against sums over point masses, closed forms and what is conserved."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cross_checks.truths import seek_truth
from cross_checks.truths.made_by.numerics.closed_forms import amplitude, quarter_period
from mbs_ref import scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.observables.energy import energy_balance
from mbs_ref.scene import PointMass, Scene, SpatialBody
from mbs_ref.scene.celestial import GravityGradient, Newton
from mbs_ref.scene.euler_parameters import rotation_matrices
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

GM_EARTH = 3.986004415e14  # m^3/s^2, EGM2008
SHARE = math.sqrt(3.0 * (160.0 - 40.0) / 180.0)  # of the orbit's rate: sqrt(3 (roll - yaw) / pitch), Wertz eq 18-41


def tumbling(spin=(0.3, -0.2, 0.4), distance=50.0, gm=2.0e3) -> Scene:
    """A body of any attitude close to a light planet that feels it, too."""
    theta = np.array([1.0, -2.0, 0.5, 1.5]) / math.sqrt(7.5)
    return Scene(
        name="tumbling", duration=20.0, gravity=(0.0, 0.0, 0.0),
        bodies=(
            PointMass(name="planet", mass=100.0, position=(0.0, 0.0, 0.0), velocity=(0.0, -0.05, 0.0)),
            SpatialBody(name="moon", mass=10.0, inertia=(20.0, 35.0, 50.0, 0.0, 0.0, 0.0),
                        position=(distance, 0.3 * distance, -0.2 * distance), velocity=(0.0, 5.0, 1.0),
                        orientation=tuple(theta.tolist()), angular_velocity=spin),
        ),
        loads=(
            Newton(name="newton", gm=(gm, gm / 10.0)),
            GravityGradient(name="gradient", body="moon", planet="planet", gm=gm),
        ),
    )  # fmt: skip


def test_force_and_torque_are_those_of_six_point_masses():
    """m / 6 at +-sqrt(3 s_k / m) along axis k, with s_k = (tr J - 2 J_k) / 2, have the body's mass and inertia.

    What is left is of fourth order in size over distance: 16 times less of the force at twice the distance.
    """
    left = []
    for distance in (50.0, 100.0):
        scene = tumbling(distance=distance)
        moon = scene.bodies[1]
        assert isinstance(moon, SpatialBody)
        system = compile_scene(scene)
        force = system.applied_forces(0.0, system.initial_state())[1]  # type: ignore[attr-defined]
        axes, inertia = rotation_matrices(moon.orientation), np.array(moon.inertia[:3])
        omega = np.array(moon.angular_velocity)
        world = axes @ np.diag(inertia) @ axes.T
        force[3:] += np.cross(omega, world @ omega)  # what is no torque of gravity's
        reach = np.sqrt(3.0 * (0.5 * inertia.sum() - inertia) / moon.mass)
        arms = np.concatenate([axes.T * reach[:, None], -axes.T * reach[:, None]])
        assert np.allclose(moon.mass / 6.0 * (np.sum(arms**2) * np.eye(3) - arms.T @ arms), world)
        places = np.array(moon.position) + arms
        pulls = -2.0e3 * moon.mass / 6.0 * places / np.linalg.norm(places, axis=1)[:, None] ** 3
        off = np.concatenate((pulls.sum(axis=0), np.cross(arms, pulls).sum(axis=0))) - force
        left.append([np.linalg.norm(off[part]) / np.linalg.norm(force[part]) for part in (slice(3), slice(3, 6))])
    (force_near, torque_near), (force_far, torque_far) = left
    assert force_near < 1e-4
    assert force_near / force_far == pytest.approx(16.0, rel=0.2)
    assert torque_near / torque_far == pytest.approx(4.0, rel=0.2)


def test_energy_and_momentum_are_kept_at_any_attitude():
    scene = tumbling()
    run = simulate(scene, Settings(rtol=1e-12, samples=21, estimate="off"))
    assert run.ok, run.message
    balance = energy_balance(scene, run)
    assert balance.drift is not None
    assert np.abs(balance.drift).max() < 1e-9 * abs(balance.energy[0])
    momentum = 100.0 * run.velocity[:, 0] + 10.0 * run.velocity[:, 1]
    assert np.abs(momentum - momentum[0]).max() < 1e-10
    axes = rotation_matrices(run.orientation[:, 1])
    spin = np.einsum("tij,j,tkj,tk->ti", axes, [20.0, 35.0, 50.0], axes, run.angular_velocity[:, 1])
    orbital = np.cross(run.position, run.velocity * np.array([100.0, 10.0])[:, None]).sum(axis=1)
    total = orbital + spin
    assert np.abs(total - total[0]).max() < 1e-9 * np.abs(total[0]).max()
    assert np.abs(spin - spin[0]).max() > 1.0  # it is the gradient that turns the body


def pitch_of(run) -> np.ndarray:
    """Return the angle from the local vertical (n_t,), rad."""
    angle = 2.0 * np.unwrap(np.arctan2(run.orientation[:, 1, 3], run.orientation[:, 1, 0]), period=np.pi)
    place = run.position[:, 1]
    return np.mod(angle - np.unwrap(np.arctan2(place[:, 1], place[:, 0])) + np.pi, 2.0 * np.pi) - np.pi


def test_small_librations_have_the_linear_theorys_frequency():
    scene = scenes.make("librating_satellite", pitch=0.05)
    run = simulate(scene, Settings(rtol=1e-12, samples=201, estimate="off"))
    rate = math.sqrt(GM_EARTH / scene.bodies[1].position[0] ** 3)
    expected = math.radians(0.05) * np.cos(SHARE * rate * run.times)
    assert np.abs(pitch_of(run) - expected).max() < 1e-5 * math.radians(0.05)


def test_large_librations_are_a_pendulums():
    """(2 a)'' = -(share n)^2 sin 2 a on a circle: sin a = k sn(K + share n t | k^2), k = sin(a_0)."""
    scene = scenes.make("librating_satellite", pitch=50.0)
    run = simulate(scene, Settings(rtol=1e-12, samples=201, estimate="off"))
    rate = math.sqrt(GM_EARTH / scene.bodies[1].position[0] ** 3)
    k = np.sin(np.longdouble(math.radians(50.0)))
    phase = amplitude(quarter_period(k**2) + SHARE * rate * run.times, k**2)
    assert np.abs(pitch_of(run) - np.arcsin(k * np.sin(phase)).astype(float)).max() < 1e-9


@pytest.mark.parametrize("eccentricity", [0.0, 0.2])
def test_its_truth_judges_it_and_its_norm_holds(eccentricity):
    scene = scenes.make("librating_satellite", eccentricity=eccentricity)
    run = simulate(scene, Settings(rtol=1e-12, samples=11, estimate="off"))
    truth = seek_truth(scene, run.times)
    size = scene.bodies[1].position[0]
    assert np.abs(run.position - truth.position).max() < 1e-10 * size
    assert np.abs(run.orientation - truth.orientation).max() < 1e-10
    assert np.abs(np.sum(run.orientation**2, axis=2) - 1.0).max() < 1e-14


def test_a_particle_has_no_extent():
    load = GravityGradient(name="gradient", body="b", planet="a", gm=1.0)
    places = {"a": (0.0, 0.0, 0.0), "b": (1.0, 0.0, 0.0)}
    bodies = tuple(PointMass(name=n, mass=1.0, position=x, velocity=(0.0, 0.0, 0.0)) for n, x in places.items())
    with pytest.raises(ValueError, match="no extent to feel the gradient over"):
        Scene(name="s", gravity=(0.0, 0.0, 0.0), bodies=bodies, loads=(load,))
