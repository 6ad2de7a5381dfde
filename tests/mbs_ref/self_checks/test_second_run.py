"""A fixed-step run against one with half the step: what it catches, what it passes, what it says."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cross_checks.truths import kepler
from mbs_ref import scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.system import Poses
from mbs_ref.scene import GROUND, Force, PlanarBody, PointMass, Scene, SpringDamper
from mbs_ref.scene.celestial import Newton
from mbs_ref.scene.signals import HalfSine
from mbs_ref.scenes.incline import build as incline
from mbs_ref.scenes.kepler import build as orbit
from mbs_ref.self_checks import step_judgement
from mbs_ref.self_checks.energy_watch import phase_error
from mbs_ref.self_checks.second_run import LEAST, SEEN, UNSEEN, Size, disagreement, least_size, size_of
from mbs_ref.self_checks.step_judgement import LOOSE
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Status


def line(error: float) -> Poses:
    x = np.linspace(0.0, 2.0, 5)
    places = np.stack([x, x + error * x**2], axis=1)[:, None]
    return Poses(places, np.zeros((5, 1)), np.zeros((5, 1, 2)), np.zeros((5, 1)))


def test_the_error_is_richardsons_and_the_first_output_beyond_the_bound_is_named():
    size = size_of(Size(), line(0.0))
    found = disagreement(line(0.0), line(0.009), size, smaller=2.0)
    assert found.share == pytest.approx(2.0 * 0.009 * 4.0 / 2.0)
    assert found.first == 3  # 0.00225, 0.009, 0.02025: the fourth output is beyond
    assert disagreement(line(0.0), line(0.0), size, smaller=2.0).first is None
    assert disagreement(line(0.0), line(np.nan), size, smaller=2.0).share == math.inf


def test_orientations_that_differ_by_sign_are_the_same():
    turned = np.tile([1.0, 0.0, 0.0, 0.0], (3, 1, 1))
    still = np.zeros((3, 1, 3))
    one, same = Poses(still, turned, still, still), Poses(still, -turned, still, still)
    assert disagreement(one, same, size_of(Size(), one), 16.0).share == 0.0


def test_a_motion_is_as_large_as_the_furthest_run_and_what_is_not_finite_is_not_large():
    assert size_of(Size(), line(0.0), line(2.0)).length == 10.0
    assert size_of(Size(), line(0.0), line(np.nan)).length == 2.0
    assert size_of(Size(), line(0.0)).angle == LEAST


def test_what_nobody_sees_is_no_motion_to_a_wide_tolerance():
    hand = Scene(name="hand", bodies=(PlanarBody(name="hand", mass=4.0, inertia=1.0),))  # gyrates at 0.5 m
    assert least_size(hand, 1e-3, SEEN) == Size(0.5 * UNSEEN, UNSEEN)
    assert least_size(hand, 1e-6, SEEN) == Size(1e-6 / SEEN, 1e-6 / SEEN)
    assert least_size(hand, 0.0, SEEN) == Size(LEAST, LEAST)
    assert least_size(plunge(1.0), 1e-3, SEEN).length == LEAST  # particles have no size


@pytest.mark.parametrize("size", [1.0, 1e-4, 1e-7])
def test_a_small_machine_may_err_no_more_than_a_large_one(size):
    """The default absolute tolerance, 1e-3 m, is wider than the small ones' whole motion."""
    bodies = (PlanarBody(name="disc", mass=1.0, inertia=size**2, position=(0.75 * size, 0.0)),)
    load = SpringDamper(name="spring", body_a=GROUND, body_b="disc", point_a=(0.0, 0.0), point_b=(0.75 * size, 0.0),
                        stiffness=100.0, rest_length=0.5 * size)  # fmt: skip
    scene = Scene(name="disc", gravity=(0.0, 0.0), bodies=bodies, loads=(load,))
    path = simulate(scene, Settings(method="dop853", rtol=1e-3, t_end=10.0, samples=51))
    exact = size * (0.5 + 0.25 * np.cos(10.0 * path.times))
    assert path.status is Status.UNRESOLVED or np.abs(path.position[:, 0, 0] - exact).max() < SEEN * size


@pytest.mark.parametrize("rtol", [1e-2, 1e-3, 1e-4, 1e-5])
def test_a_block_at_rest_is_resolved_however_little_it_trembles(rtol):
    path = simulate(incline(angle=0.26, friction=0.3), Settings(method="dop853", rtol=rtol, t_end=1.0, samples=21))
    assert path.ok, path.message
    assert np.abs(path.orientation - path.orientation[0]).max() < SEEN * UNSEEN


def plunge(sideways: float) -> Scene:
    """A close pass of a hundredth of the distance, gone through between two outputs."""
    still = (0.0, 0.0, 0.0)
    bodies = (
        PointMass(name="center", mass=1.0, position=still, velocity=still),
        PointMass(name="planet", mass=1.0, position=(1.0, 0.0, 0.0), velocity=(0.0, sideways, 0.0)),
    )
    return Scene(name="plunge", gravity=still, bodies=bodies, loads=(Newton(name="newton", gm=(1.0, 0.0)),))


@pytest.mark.parametrize("sideways", [0.1, 0.0])
def test_a_close_pass_between_outputs_is_seen_in_what_follows(sideways):
    settings = Settings(method="rk4", step=1e-3, t_end=1.5, samples=4)
    path = simulate(plunge(sideways), settings)
    assert path.status is Status.UNRESOLVED
    for word in ("'planet'", "estimated", "last good output is at t = 1 s", "keep"):
        assert word in path.message
    assert simulate(plunge(sideways), settings.model_copy(update={"unresolved": "keep"})).ok


def pushed(duration: float) -> Scene:
    push = HalfSine(peak=1.0, duration=duration, start=0.50031)
    force = Force(name="push", body="sled", point=(0.0, 0.0), vector=(1.0 / duration, 0.0), factor=push)
    return Scene(name="sled", bodies=(PlanarBody(name="sled", mass=1.0, inertia=1.0),), loads=(force,))


@pytest.mark.parametrize("duration", [1e-3, 1e-6])
def test_a_declared_pulse_shorter_than_a_step_gets_steps_of_its_own(duration):
    """The speed after it is 2/pi m/s, whatever its duration."""
    path = simulate(pushed(duration), Settings(method="rk4", step=1e-2, t_end=1.0))
    assert path.ok, path.message
    assert path.velocity[-1, 0, 0] == pytest.approx(2.0 / math.pi, rel=1e-3)
    crude = simulate(pushed(duration), Settings(method="euler", step=1e-2, t_end=1.0))
    assert crude.status is Status.UNRESOLVED  # four steps of order 1 are 5 % off
    kept = simulate(pushed(duration), Settings(method="euler", step=1e-2, t_end=1.0, unresolved="keep"))
    assert kept.velocity[-1, 0, 0] == pytest.approx(2.0 / math.pi, rel=0.06)


@pytest.mark.parametrize("step", [0.01, 0.1, 0.2, 0.4])
def test_what_passes_is_within_the_bound_of_the_truth(step):
    fine = simulate(scenes.make("pendulum"), Settings(rtol=1e-12, t_end=4.0, samples=11))
    path = simulate(scenes.make("pendulum"), Settings(method="rk4", step=step, t_end=4.0, samples=11))
    error = np.abs(path.position - fine.position).max() / np.abs(fine.position - fine.position[0]).max()
    assert path.ok == (error < SEEN)
    assert path.ok == (step < 0.15)


def test_outputs_closer_than_the_step_do_not_hide_it():
    """Forty outputs a step cut the steps of both runs: those of the second are halved all the same."""
    path = simulate(scenes.make("pendulum"), Settings(method="euler", step=1.0, t_end=1.0), np.linspace(0.0, 1.0, 41))
    assert path.status is Status.UNRESOLVED


@pytest.mark.parametrize("method", ["dop853", "lsodar", "radau"])
@pytest.mark.parametrize("rtol", [1e-2, 1e-3, 1e-5])
def test_a_coarse_tolerance_is_not_taken_at_its_word(method, rtol):
    """Three orbits of eccentricity 0.6 at it are right to the bound, or unresolved."""
    scene = scenes.make("kepler", orbits=3.0)
    settings = Settings(method=method, rtol=rtol, atol=rtol, t_end=18.0, samples=19)
    if method == "radau":  # is made for mechanisms
        scene, settings = scenes.make("pendulum"), settings.model_copy(update={"t_end": 20.0})
    fine = simulate(scene, Settings(rtol=1e-12, t_end=settings.t_end, samples=19))
    path = simulate(scene, settings)
    error = np.abs(path.position - fine.position).max() / np.abs(fine.position - fine.position[0]).max()
    assert path.status is (Status.SUCCESS if error < max(SEEN, LOOSE * rtol) else Status.UNRESOLVED)
    if not path.ok:
        assert f"relative tolerance of {rtol:g}" in path.message
        assert "a tenth of it takes body" in path.message
        assert simulate(scene, settings.model_copy(update={"unresolved": "keep"})).ok


def test_a_long_run_is_run_again(monkeypatch):
    """Errors of an orbit's phase grow with the square of time."""
    many = scenes.make("kepler", eccentricity=0.2, orbits=300.0)
    settings = Settings(method="dop853", rtol=1e-8, atol=1e-8)
    monkeypatch.setattr(step_judgement, "ASTRAY", math.inf)
    assert simulate(many, settings).ok
    monkeypatch.setattr(step_judgement, "LONG", 1000)
    assert simulate(many, settings).status is Status.UNRESOLVED


@pytest.mark.parametrize("method", ["dop853", "lsodar"])
@pytest.mark.parametrize("gap", [1e-2, 1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10])
def test_energy_tells_of_a_near_collision_gone_wrong(method, gap, rtol):
    """Two orbits of eccentricity 1 - gap: right to the bound, or unresolved; the tolerance itself promises nothing."""
    scene = orbit(eccentricity=1.0 - gap, orbits=2.0)
    path = simulate(scene, Settings(method=method, rtol=rtol, t_end=4.0 * math.pi, samples=9))
    error = np.abs(path.position - kepler.solve(scene, path.times).position).max()
    assert not path.ok or error < 2.0 * SEEN  # m, on orbits of 2 m
    if gap >= 1e-2:
        assert path.ok


def test_energy_says_nothing_where_work_is_done():
    system = compile_scene(pushed(1e-3))
    y = system.initial_state()
    faster = np.stack([y, 2.0 * y + 1.0])
    assert phase_error(system, np.array([0.0, 1.0]), faster, 1000) == (0.0, 0.0)


@pytest.mark.parametrize(
    "settings", [Settings(method="dop853", rtol=1e-5), Settings(method="rk4", step=2e-3 * math.pi)]
)
def test_outputs_once_a_period_do_not_hide_how_far_the_motion_goes(settings):
    """Five orbits, looked at where each begins: the errors of 1e-4 m are none on orbits of 2 m."""
    scene = orbit(eccentricity=0.2, orbits=5.0)
    path = simulate(scene, settings, 2.0 * math.pi * np.arange(6.0))
    error = np.abs(path.position - kepler.solve(scene, path.times).position).max()
    assert path.ok, path.message
    assert error > SEEN * np.abs(path.position - path.position[0]).max()
    assert error < SEEN
