"""Outputs interpolated inside of steps: closed forms, the order of the interpolant, and what it spares."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ellipj

from mbs_ref import scenes
from mbs_ref.scene import GROUND, PointMass, Scene, SpringDamper
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.simulate.many.lanes import why_not_in_lanes

DENSE = Settings(outputs="dense", estimate="off", reactions=False)
G, LENGTH, REST = 9.81, 2.0, 5.0
RATE = 2.0  # rad/s, of the oscillator: sqrt(8 N/m / 2 kg)


def dense(scene, **settings):
    path = simulate(scene, DENSE.model_copy(update=settings))
    assert path.ok, path.message
    return path


def oscillator():
    spring = SpringDamper(
        name="spring", body_a=GROUND, body_b="bob", point_a=(0.0, 0.0), point_b=(REST, 0.0), stiffness=8.0
    )
    bob = PointMass(name="bob", mass=2.0, position=(REST, 0.0), velocity=(1.0, 0.0))
    return Scene(name="oscillator", duration=2.0, bodies=(bob,), loads=(spring,))


def swing(times):
    """A pendulum released from the horizontal: sin(theta/2) = k cd(w t), k = sin(pi/4), w^2 = g/L."""
    _, cn, dn, _ = ellipj(math.sqrt(G / LENGTH) * times, 0.5)
    theta = 2.0 * np.arcsin(math.sqrt(0.5) * cn / dn)
    return LENGTH * np.column_stack((-np.sin(theta), -np.cos(theta)))


def test_the_interpolant_has_order_seven():
    """Between fixed steps: an output's error is that of the step's end and, of order 8 in the step, its own."""
    errors = []
    for step in (0.2, 0.1):
        path = dense(oscillator(), method="dop853", step=step, samples=97)
        exact = REST + np.sin(RATE * path.times) / RATE
        errors.append(np.max(np.abs(path.position[:, 0, 0] - exact)))
        assert path.steps == round(2.0 / step)
        assert not any("multiple of the step" in note for note in path.notes)
    assert 7.0 < math.log2(errors[0] / errors[1]) < 9.0


@pytest.mark.parametrize("rtol", [1e-5, 1e-7, 1e-9])
def test_outputs_of_a_pendulum_follow_elliptic_functions_in_few_steps(rtol):
    scene = scenes.make("pendulum", length=LENGTH, gravity=G)
    path = dense(scene, t_end=3.0, samples=301, rtol=rtol)
    landed = dense(scene, t_end=3.0, samples=301, rtol=rtol, outputs="landed")
    assert 0.0 < np.max(np.linalg.norm(path.position[:, 0] - swing(path.times), axis=1)) < 100.0 * rtol
    assert np.max(np.abs(np.linalg.norm(path.position[:, 0], axis=1) - LENGTH)) < 1e-13  # on the constraint
    assert 4 * path.steps < landed.steps
    assert 2 * path.rhs_calls < landed.rhs_calls
    assert landed.cut_steps > 0.9 * landed.steps
    assert path.cut_steps <= 1  # the last one ends at the end


def test_outputs_between_impacts_lie_on_the_parabola():
    scene = scenes.make("bouncing_ball").model_copy(update={"gravity": (0.0, -G)})
    path, exact = dense(scene, samples=501), simulate(scene, Settings(rtol=1e-12, samples=501, estimate="off"))
    assert path.event_times is not None
    assert exact.event_times is not None
    assert len(path.event_times) == len(exact.event_times) > 0
    assert np.max(np.abs(path.position - exact.position)) < 1e-8
    free = path.times < path.event_times[0, 0]
    t, speed = path.times[free], path.velocity[0, 0, 1]
    height = path.position[0, 0, 1] + speed * t - 0.5 * G * t**2
    assert np.max(np.abs(path.position[free, 0, 1] - height)) < 1e-9


def test_loops_are_closed_at_outputs():
    path = dense(scenes.make("slider_crank"), rtol=1e-6, samples=401)
    assert path.step_compliance is not None
    assert path.step_compliance[:, 1].max() < 1e-12
    truth = simulate(scenes.make("slider_crank"), Settings(rtol=1e-12, samples=401, estimate="off"))
    assert np.max(np.linalg.norm(path.position - truth.position, axis=2)) < 1e-4


def test_the_estimate_bounds_the_interpolants_error_too():
    scene = scenes.make("pendulum", length=LENGTH, gravity=G)
    path = simulate(scene, Settings(outputs="dense", rtol=1e-6, t_end=3.0, samples=301))
    assert path.estimate is not None
    error = np.max(np.linalg.norm(path.position[:, 0] - swing(path.times), axis=1))
    assert error < path.estimate.value * path.estimate.length < 1e4 * error


def test_who_has_no_interpolant_says_so():
    with pytest.raises(ValueError, match=r"'rk4' has no interpolant of its order; allowed: dop853"):
        simulate(scenes.make("pendulum"), Settings(method="rk4", step=1e-2, outputs="dense"))
    assert "dense" in why_not_in_lanes(scenes.make("pendulum"), DENSE)
    path = dense(scenes.make("pleiades"), method="auto", t_end=0.1)
    assert path.method == "dop853"
    assert "no interpolant" in path.reason
