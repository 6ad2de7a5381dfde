"""The shared judge against hand results, finite differences and exact motions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mbs_ref import observables as judge
from mbs_ref import scenes
from mbs_ref.scene import (
    CoordinateDrive,
    Distance,
    Force,
    PlanarBody,
    PointDrive,
    PointMass,
    Prismatic,
    Revolute,
    Scene,
    SpringDamper,
    Torque,
    TorsionSpring,
    UserForce,
    Weld,
)
from mbs_ref.scene.signals import Constant, Harmonic, Polynomial, Table
from mbs_ref.trajectory import Trajectory


def motion_of(times, position, angle, velocity, spin, **more) -> Trajectory:
    return Trajectory(times, np.asarray(position), np.asarray(angle), np.asarray(velocity), np.asarray(spin), **more)


def one_body(position, angle, velocity=(0.0, 0.0), spin=0.0) -> Trajectory:
    return motion_of(np.zeros(1), [[position]], [[angle]], [[velocity]], [[spin]])


def body(name="a", **more) -> PlanarBody:
    return PlanarBody(name=name, mass=2.0, inertia=0.3, **more)


def every_joint() -> Scene:
    a, b = body("a", position=(0.2, 0.1), angle=0.3), body("b", position=(1.1, -0.4), angle=-0.5)
    c = PointMass(name="c", mass=0.5, position=(2.0, 1.0), velocity=(0.0, 0.0))
    swing = Harmonic(amplitude=0.3, omega=2.0, phase=0.4)
    return Scene(
        name="every_joint",
        bodies=(a, b, c),
        joints=(
            Revolute(name="revolute", body_a="a", body_b="b", point=(0.7, 0.3)),
            Prismatic(name="prismatic", body_a="b", body_b="a", point=(0.4, 0.2), axis=(3.0, 1.0)),
            Weld(name="weld", body_a="ground", body_b="b", point=(0.0, 0.5)),
            Distance(name="distance", body_a="a", body_b="c", point_a=(0.5, 0.5), point_b=(2.0, 1.0)),
            CoordinateDrive(name="x", body="a", coordinate="x", motion=swing),
            CoordinateDrive(name="turn", body="b", coordinate="angle", motion=swing, level="velocity"),
            PointDrive(
                name="point", body="a", point=(0.9, 0.9), direction=(1.0, 2.0), motion=swing, level="acceleration"
            ),
        ),
    )


def wandering(scene: Scene, times: np.ndarray) -> Trajectory:
    """A smooth motion that starts at the scene's poses and obeys no joint."""
    rng = np.random.default_rng(7)
    start = np.array([[*b.position, getattr(b, "angle", 0.0)] for b in scene.bodies])
    rate, size = rng.uniform(1.0, 3.0, start.shape), rng.uniform(0.1, 0.4, start.shape)
    q = start + size * np.sin(rate * times[:, None, None])
    v = size * rate * np.cos(rate * times[:, None, None])
    return motion_of(times, q[..., :2], q[..., 2], v[..., :2], v[..., 2])


def test_every_residual_vanishes_at_the_scenes_own_poses():
    scene = every_joint()
    found = judge.rows(scene, wandering(scene, np.zeros(1)))
    assert len(found.joints) == 2 + 2 + 3 + 1 + 1 + 1 + 1
    assert np.max(np.abs(found.residual)) < 1e-15


def test_rates_are_the_derivatives_of_the_residuals():
    scene, step = every_joint(), 1e-4
    times = np.linspace(0.3, 2.0, 9)
    ahead, behind = (judge.constraint_residual(scene, wandering(scene, times + k * step)) for k in (1, -1))
    second_order = 1e-7  # step^2 times third derivatives of at most about 10
    np.testing.assert_allclose(
        judge.constraint_rate(scene, wandering(scene, times)), (ahead - behind) / (2 * step), atol=second_order
    )


def test_revolute_by_hand():
    scene = Scene(name="s", bodies=(body(position=(1.0, 0.0)),),
                  joints=(Revolute(name="j", body_a="ground", body_b="a", point=(0.0, 0.0)),))  # fmt: skip
    turned = one_body((0.0, 1.5), np.pi / 2, velocity=(0.0, 0.0), spin=2.0)
    np.testing.assert_allclose(judge.constraint_residual(scene, turned), [[0.0, 0.5]], atol=1e-15)
    np.testing.assert_allclose(judge.constraint_rate(scene, turned), [[2.0, 0.0]], atol=1e-15)


def test_prismatic_weld_and_distance_by_hand():
    joints = (
        Prismatic(name="p", body_a="ground", body_b="a", point=(0.0, 0.0), axis=(1.0, 0.0)),
        Weld(name="w", body_a="ground", body_b="a", point=(0.0, 0.0)),
        Distance(name="d", body_a="ground", body_b="a", point_a=(0.0, -3.0), point_b=(0.0, 0.0)),
    )
    scene = Scene(name="s", bodies=(body(),), joints=joints)
    moved = one_body((4.0, 0.0), 2.0 * np.pi + 0.1)
    expected = [[0.0, 0.1, 4.0, 0.0, 0.1, 2.0]]  # a full turn is no violation
    np.testing.assert_allclose(judge.constraint_residual(scene, moved), expected, atol=1e-14)


def test_drives_count_from_the_pose_at_the_start():
    ramp = Polynomial(coefficients=(5.0, 2.0))
    joints = (CoordinateDrive(name="x", body="a", coordinate="x", motion=ramp),
              PointDrive(name="p", body="a", point=(1.0, 0.0), direction=(0.0, -4.0), motion=Constant()))  # fmt: skip
    scene = Scene(name="s", bodies=(body(position=(1.0, 0.0)),), joints=joints)
    path = motion_of(np.array([0.5]), [[(2.0, 0.25)]], [[0.0]], [[(2.0, 1.0)]], [[0.0]])
    np.testing.assert_allclose(judge.constraint_residual(scene, path), [[0.0, -0.25]], atol=1e-15)
    np.testing.assert_allclose(judge.constraint_rate(scene, path), [[0.0, -1.0]], atol=1e-15)


def oscillator(damping: float, **more) -> tuple[Scene, Trajectory]:
    """A point mass on a spring along x, m = 1, k = 4, underdamped: x = 1 + exp(-g t) cos-like, exact."""
    scene = Scene(name="o", bodies=(PointMass(name="m", mass=1.0, position=(2.0, 0.0), velocity=(0.0, 0.0)),),
                  loads=(SpringDamper(name="k", body_a="ground", body_b="m", point_a=(0.0, 0.0), point_b=(2.0, 0.0),
                                      stiffness=4.0, damping=damping, rest_length=1.0),), **more)  # fmt: skip
    times = np.linspace(0.0, 3.0, 301)
    g = 0.5 * damping
    w = np.sqrt(4.0 - g**2)
    x = np.exp(-g * times) * (np.cos(w * times) + g / w * np.sin(w * times))
    v = -np.exp(-g * times) * 4.0 / w * np.sin(w * times)
    zero = np.zeros_like(x)
    path = motion_of(times, np.stack([1.0 + x, zero], 1)[:, None], zero[:, None],
                     np.stack([v, zero], 1)[:, None], zero[:, None])  # fmt: skip
    return scene, path


@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_exact_oscillation_keeps_its_energy_balance(damping):
    balance = judge.energy_balance(*oscillator(damping))
    assert np.max(np.abs(balance.drift)) < 1e-10  # J, of 2 J
    assert balance.resolution < 1e-9
    lost = balance.energy[0] - balance.energy[-1]
    assert (lost > 0.5) if damping else (abs(lost) < 1e-14)


def test_exact_pendulum_keeps_its_energy():
    scene = scenes.make("pendulum")
    speed = np.sqrt(2 * 9.81)  # m/s, at the lowest point
    path = motion_of(np.array([0.0, 1.0]), [[(-1.0, 0.0)], [(0.0, -1.0)]], np.zeros((2, 1)),
                     [[(0.0, 0.0)], [(speed, 0.0)]], np.zeros((2, 1)))  # fmt: skip
    np.testing.assert_allclose(judge.energy_balance(scene, path).drift, 0.0, atol=1e-14)


def test_work_of_time_dependent_and_user_loads_is_counted():
    """A free body pushed by F(t) = t^2 and a user's F = 3 along x, turned by a torque cos t."""
    loads = (Force(name="f", body="a", point=(0.0, 0.0), vector=(1.0, 0.0), factor=Polynomial(coefficients=(0, 0, 1))),
             UserForce(name="u", function=lambda t, q, v: np.array([[3.0, 0.0, 0.0]])),
             Torque(name="t", body="a", torque=1.0, factor=Harmonic(amplitude=1.0, omega=1.0, phase=np.pi / 2)),
             )  # fmt: skip
    scene = Scene(name="s", bodies=(body(),), loads=loads)
    t = np.linspace(0.0, 2.0, 101)
    speed, spin = (t**3 / 3 + 3 * t) / 2.0, np.sin(t) / 0.3
    zero = np.zeros_like(t)
    path = motion_of(t, np.stack([(t**4 / 12 + 1.5 * t**2) / 2, zero], 1)[:, None], ((1 - np.cos(t)) / 0.3)[:, None],
                     np.stack([speed, zero], 1)[:, None], spin[:, None])  # fmt: skip
    balance = judge.energy_balance(scene, path)
    assert balance.energy[-1] > 10.0
    np.testing.assert_allclose(balance.drift, 0.0, atol=1e-10)


def test_constant_force_and_torsion_spring_have_potentials():
    loads = (Force(name="f", body="a", point=(1.0, 0.0), vector=(0.0, 5.0)), Torque(name="t", body="a", torque=2.0),
             TorsionSpring(name="s", body_a="ground", body_b="a", stiffness=8.0, rest_angle=0.5))  # fmt: skip
    scene = Scene(name="s", bodies=(body(),), loads=loads)
    found = judge.potential_energy(scene, one_body((0.0, 0.0), np.pi / 2))
    np.testing.assert_allclose(found, [-5.0 - 2.0 * np.pi / 2 + 4.0 * (np.pi / 2 - 0.5) ** 2])


def test_a_drives_work_needs_its_reaction():
    square = Polynomial(coefficients=(0, 0, 1))
    drive = CoordinateDrive(name="d", body="a", coordinate="x", motion=square)
    scene = Scene(name="s", bodies=(body(),), joints=(drive,))
    t = np.linspace(0.0, 1.0, 21)
    zero = np.zeros_like(t)
    made = (t, np.stack([t**2, zero], 1)[:, None], zero[:, None], np.stack([2 * t, zero], 1)[:, None], zero[:, None])
    silent = judge.energy_balance(scene, motion_of(*made))
    assert silent.drift is None
    assert "d does work" in silent.reason
    pulled = judge.energy_balance(scene, motion_of(*made, reactions={"d": np.tile([4.0, 0.0, 0.0], (21, 1))}))
    np.testing.assert_allclose(pulled.drift, 0.0, atol=1e-13)


def test_a_jump_in_a_load_is_said_not_integrated():
    step = Table(times=(0.5, 0.5), values=(0.0, 1.0))
    scene = Scene(name="s", bodies=(body(),), loads=(Torque(name="t", body="a", torque=1.0, factor=step),))
    assert "jumps" in judge.energy_balance(scene, wandering(scene, np.linspace(0.0, 1.0, 21))).reason


def test_momentum_of_a_free_pair_is_conserved_and_that_of_a_held_body_is_not_judged():
    spring = SpringDamper(name="k", body_a="a", body_b="b", point_a=(0.0, 0.0), point_b=(1.0, 0.0), stiffness=1.0)
    pair = Scene(name="s", bodies=(body("a"), body("b", position=(1.0, 0.0))), loads=(spring,))
    t = np.linspace(0.0, 1.0, 5)
    apart = np.stack([-np.sin(t), np.zeros(5)], 1), np.stack([-np.cos(t), np.zeros(5)], 1)
    position = np.stack([apart[0], -apart[0]], 1)
    path = motion_of(t, position, np.zeros((5, 2)), np.stack([apart[1], -apart[1]], 1), np.zeros((5, 2)))
    np.testing.assert_allclose(judge.momentum_drift(pair, path), 0.0, atol=1e-15)
    assert judge.momentum_drift(scenes.make("pendulum"), one_body((-1.0, 0.0), 0.0)) is None
    faster = replace(path, angular_velocity=path.angular_velocity + 5.0 * t[:, None])  # 0.3 kg m^2 each, evenly
    np.testing.assert_allclose(judge.momentum_drift(pair, faster), 2.0 * 0.3 * 5.0 * t, atol=1e-14)
    spinning = one_body((2.0, 0.0), 0.0, velocity=(0.0, 3.0), spin=1.0)
    single = Scene(name="s", bodies=(body(),))
    np.testing.assert_allclose(judge.angular_momentum(single, spinning), [2.0 * 2.0 * 3.0 + 0.3])
