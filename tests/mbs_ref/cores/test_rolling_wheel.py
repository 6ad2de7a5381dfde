"""A knife-edged wheel against closed forms of a disc, its rows against derivatives, modes against a top's."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mbs_ref import observables, scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.scene import RollingWheel, Scene, SpatialBody, Spherical
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.simulate.linearised import steady_motion_at_start
from mbs_ref.trajectory import Trajectory

MASS, RADIUS, GRAVITY = 2.0, 0.4, 9.81  # kg, m, m/s^2
ACROSS, ALONG = MASS * RADIUS**2 / 4.0, MASS * RADIUS**2 / 2.0  # kg m^2, of a uniform thin disc


def disc(lean: float, velocity, omega) -> Scene:
    """A disc whose axis is y turned about x by `lean` (rad); it touches the ground z = 0 at the origin."""
    half, centre = lean / 2.0, (0.0, -RADIUS * math.sin(lean), RADIUS * math.cos(lean))
    axis = (0.0, math.cos(lean), math.sin(lean))
    body = SpatialBody(
        name="disc", mass=MASS, inertia=(ACROSS, ALONG, ACROSS, 0.0, 0.0, 0.0), position=centre,
        orientation=(math.cos(half), math.sin(half), 0.0, 0.0), velocity=velocity, angular_velocity=omega,
    )  # fmt: skip
    wheel = RollingWheel(name="wheel", body="disc", point=centre, axis=axis, radius=RADIUS, normal=(0.0, 0.0, 1.0))
    return Scene(name="disc", gravity=(0.0, 0.0, -GRAVITY), duration=2.0, bodies=(body,), joints=(wheel,))


def rolling(lean: float, omega) -> Scene:
    """Return the disc whose lowest point is at rest."""
    centre = np.array((0.0, -RADIUS * math.sin(lean), RADIUS * math.cos(lean)))
    return disc(lean, tuple(np.cross(omega, centre).tolist()), tuple(omega))


def test_a_leaning_disc_rolls_in_a_circle():
    """Leaning steadily it turns at a constant rate, at a constant height."""
    lean, speed = 0.3, 3.0  # rad; rad/s about the disc's axis, turning included
    turn = _turn_rate(lean, speed)
    axis = np.array((0.0, math.cos(lean), math.sin(lean)))
    across = np.array((0.0, -math.sin(lean), math.cos(lean)))
    omega = speed * axis + turn * math.cos(lean) * across  # the turn's part along the axis is in `speed`
    scene = rolling(lean, omega)
    path = simulate(scene, Settings(rtol=1e-11, samples=41, estimate="off"))
    now = observables.constraint_rate(scene, path)
    height = path.position[:, 0, 2]
    assert np.abs(height - RADIUS * math.cos(lean)).max() < 1e-9
    assert np.abs(now).max() < 1e-11
    heading = np.unwrap(np.arctan2(path.velocity[:, 0, 1], path.velocity[:, 0, 0]))
    assert heading - heading[0] == pytest.approx(turn * path.times, abs=1e-8)


def _turn_rate(lean: float, speed: float) -> float:
    """Solve for the turn rate W (rad/s) of a disc that leans steadily, `speed` about its axis.

    Seen from axes that turn with W nothing changes: the angular momentum L about the centre, C speed along the axis and
    A W cos(lean) across it, gains W z x L, the moment of the contact's force m (g z + W z x v) on the rim.
    """
    axis = np.array((0.0, math.cos(lean), math.sin(lean)))
    across = np.array((0.0, -math.sin(lean), math.cos(lean)))
    up = np.array((0.0, 0.0, 1.0))

    def lack(turn: float) -> float:
        omega = speed * axis + turn * math.cos(lean) * across
        momentum = ALONG * speed * axis + ACROSS * turn * math.cos(lean) * across
        velocity = np.cross(omega, RADIUS * across)
        force = MASS * (GRAVITY * up + turn * np.cross(up, velocity))
        return float((np.cross(-RADIUS * across, force) - turn * np.cross(up, momentum))[0])

    here, there = 0.0, 1.0 if lack(0.0) * lack(1.0) < 0.0 else -1.0
    while lack(here) * lack(there) > 0.0:
        there *= 1.5
    for _ in range(200):
        middle = 0.5 * (here + there)
        here, there = (middle, there) if lack(here) * lack(middle) > 0.0 else (here, middle)
    return 0.5 * (here + there)


def test_rates_and_gamma_are_derivatives_along_the_motion():
    scene = disc(0.4, (0.3, -0.2, 0.5), (0.7, 2.0, -1.1))  # keeps nothing: it slips and lifts
    system = compile_scene(scene)
    y = system.initial_state()
    h = 1e-5  # s

    def moved(step: float) -> np.ndarray:
        k1 = system.derivative(0.0, y)
        k2 = system.derivative(step / 2, y + step / 2 * k1)
        k3 = system.derivative(step / 2, y + step / 2 * k2)
        k4 = system.derivative(step, y + step * k3)
        return y + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)

    after, before = (system.residuals(0.0, moved(step))["wheel"] for step in (h, -h))
    _, rate = system.residuals(0.0, y)["wheel"]
    assert np.abs(rate).min() > 0.01
    assert (after[0] - before[0])[2] / (2 * h) == pytest.approx(rate[2], abs=1e-8)  # the height's own rate
    assert after[1] == pytest.approx(before[1], abs=1e-10)  # C_q qdd = gamma
    y[: system.n_positions] += 1e-3 * np.random.default_rng(5).standard_normal(system.n_positions)
    residual, rate = system.residuals(0.0, y)["wheel"]
    seen = observables.rows(scene, Trajectory(np.zeros(1), *system.poses(y[None])))
    mine = [k for k, name in enumerate(seen.joints) if name == "wheel"]
    assert np.linalg.norm(seen.residual[0, mine]) == pytest.approx(np.linalg.norm(residual), rel=1e-9)
    assert np.linalg.norm(seen.rate[0, mine]) == pytest.approx(np.linalg.norm(rate), rel=1e-9)


def test_projection_puts_the_wheel_on_the_ground_and_stops_its_slip():
    system = compile_scene(disc(0.4, (0.3, -0.2, 0.5), (0.7, 2.0, -1.1)))
    y = system.initial_state()
    y += 1e-3 * np.random.default_rng(3).standard_normal(len(y))
    assert system.project(0.0, y) < 1e-12
    position, velocity = system.compliance(0.0, y)
    assert position < 1e-12
    assert velocity < 1e-12


@pytest.mark.parametrize("share", [0.5, 2.0])
def test_an_upright_disc_falls_below_a_speed(share):
    """(A + m r^2) a'' + (C (C + m r^2) w^2 / A - m g r) a = 0: a thin disc is stable from w^2 = g / (3 r) on."""
    spin = math.sqrt(share * GRAVITY / (3.0 * RADIUS))
    found = steady_motion_at_start(rolling(0.0, (0.0, spin, 0.0))).eigenvalues
    arm = MASS * RADIUS**2
    square = (MASS * GRAVITY * RADIUS - ALONG * (ALONG + arm) * spin**2 / ACROSS) / (ACROSS + arm)
    expected = np.emath.sqrt(square)
    assert sorted(found[found != 0.0], key=lambda x: (x.real, x.imag)) == pytest.approx(
        sorted((expected, -expected), key=lambda x: (x.real, x.imag)), abs=1e-11
    )


@pytest.mark.parametrize("spin", [20.0, 60.0])
def test_a_sleeping_top_has_the_roots_of_its_quadratic(spin):
    """A q'' - i C s q' - m g l q = 0 of the tilt q = x + i y, A about the fixed point (Goldstein, sec. 5-7)."""
    mass, arm, axial, across = 1.0, 0.3, 0.02, 0.04
    top = SpatialBody(name="top", mass=mass, inertia=(across, across, axial, 0.0, 0.0, 0.0), position=(0.0, 0.0, arm),
                      angular_velocity=(0.0, 0.0, spin))  # fmt: skip
    pivot = Spherical(name="pivot", body_a="ground", body_b="top", point=(0.0, 0.0, 0.0))
    scene = Scene(name="sleeping", gravity=(0.0, 0.0, -GRAVITY), duration=1.0, bodies=(top,), joints=(pivot,))
    found = steady_motion_at_start(scene).eigenvalues
    roots = np.roots([across + mass * arm**2, -1j * axial * spin, -mass * GRAVITY * arm])
    for root in (*roots, *roots.conj()):
        assert np.abs(found - root).min() < 1e-10
    assert np.count_nonzero(found) == 4


def test_what_is_not_steady_says_why():
    assert "accelerated" in steady_motion_at_start(scenes.make("spherical_pendulum")).reason
    assert "contacts" in steady_motion_at_start(scenes.make("rolling_sphere")).reason
    scene = rolling(0.0, (0.0, 3.0, 0.0))
    disc_body = scene.bodies[0].model_copy(update={"inertia": (ACROSS, ALONG, 1.5 * ACROSS, 0.0, 0.0, 0.0)})
    lopsided = scene.model_copy(update={"bodies": (disc_body,)})
    assert "the equations change along the motion" in steady_motion_at_start(lopsided).reason


def test_a_wheel_that_lies_flat_is_refused():
    with pytest.raises(ValueError, match="lies flat"):
        RollingWheel(
            name="w", body="b", point=(0.0, 0.0, 1.0), axis=(0.0, 0.0, 2.0), radius=1.0, normal=(0.0, 0.0, 1.0)
        )
