"""A fixed-step run against one with half the step: what it catches, what it passes, what it says."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mbs_ref import scenes, step_judgement
from mbs_ref.celestial import Newton
from mbs_ref.scene import Force, PlanarBody, PointMass, Scene
from mbs_ref.second_run import SEEN, disagreement
from mbs_ref.settings import Settings
from mbs_ref.signals import HalfSine
from mbs_ref.simulate import simulate
from mbs_ref.step_judgement import LOOSE
from mbs_ref.system import Poses
from mbs_ref.trajectory import Status


def line(error: float) -> Poses:
    x = np.linspace(0.0, 2.0, 5)
    places = np.stack([x, x + error * x**2], axis=1)[:, None]
    return Poses(places, np.zeros((5, 1)), np.zeros((5, 1, 2)), np.zeros((5, 1)))


def test_the_error_is_richardsons_and_the_first_output_beyond_the_bound_is_named():
    found = disagreement(line(0.0), line(0.009), smaller=2.0)
    assert found.share == pytest.approx(2.0 * 0.009 * 4.0 / 2.0)
    assert found.first == 3  # 0.00225, 0.009, 0.02025: the fourth output is beyond
    assert disagreement(line(0.0), line(0.0), smaller=2.0).first is None
    assert disagreement(line(0.0), line(np.nan), smaller=2.0).share == math.inf


def test_orientations_that_differ_by_sign_are_the_same():
    turned = np.tile([1.0, 0.0, 0.0, 0.0], (3, 1, 1))
    still = np.zeros((3, 1, 3))
    assert disagreement(Poses(still, turned, still, still), Poses(still, -turned, still, still), 16.0).share == 0.0


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
    assert simulate(many, settings).ok
    monkeypatch.setattr(step_judgement, "LONG", 1000)
    assert simulate(many, settings).status is Status.UNRESOLVED
