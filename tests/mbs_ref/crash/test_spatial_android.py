"""The android in space: straight ahead the planar one; obliquely its own mirror image, and what a pulse gives."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cross_checks.truths import seek_truth
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import scenes
from mbs_ref.crash.in_space import in_space
from mbs_ref.observables.constraints import constraint_residual
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

BARE: dict[str, Any] = {"model": "paper"}
SETTINGS = Settings(rtol=1e-12, samples=21, estimate="off", reactions=False)


def test_a_straight_crash_is_the_planar_ones():
    planar = simulate(scenes.make("android_simplified", **BARE), SETTINGS)
    spatial = simulate(scenes.make("android_spatial", oblique=0.0, **BARE), SETTINGS)
    assert planar.ok, planar.message
    assert spatial.ok, spatial.message
    assert np.abs(spatial.position[:, :, :2] - planar.position).max() < 1e-10
    assert np.abs(spatial.position[:, :, 2]).max() < 1e-12
    turned = 2.0 * np.arctan2(spatial.orientation[:, :, 3], spatial.orientation[:, :, 0])
    apart = np.mod(turned - planar.orientation + np.pi, 2.0 * np.pi) - np.pi
    assert np.abs(apart).max() < 1e-10


def test_an_oblique_crash_is_the_mirror_image_of_its_opposite():
    right, left = (simulate(scenes.make("android_spatial", oblique=angle, **BARE), SETTINGS) for angle in (20.0, -20.0))
    assert right.ok, right.message
    assert np.abs(right.position * [1.0, 1.0, -1.0] - left.position).max() < 1e-9
    assert right.position[:, 0, 2].max() > 0.05  # m: the head goes to the side that the pulse comes from
    assert np.abs(constraint_residual(scenes.make("android_spatial", oblique=20.0, **BARE), right)).max() < 1e-12


def test_articulated_bodies_move_alike():
    """Other equations for the same tree: ball joints, contacts and belts in relative coordinates."""
    scene = scenes.make("android_spatial", oblique=20.0, **BARE)
    runs = [simulate(scene, SETTINGS.model_copy(update={"coordinates": kind})) for kind in ("cartesian", "relative")]
    assert all(run.ok for run in runs)
    assert np.abs(runs[0].position - runs[1].position).max() < 1e-9


def test_the_sideways_momentum_is_the_pulses():
    """Without belts nothing holds it sideways, for contacts have no friction: momentum along z is the pulse's."""
    scene = scenes.make("android_spatial", oblique=30.0, belts=False, **BARE)
    run = simulate(scene, SETTINGS.model_copy(update={"t_end": 0.1}))
    moved = [(body.mass, k) for k, body in enumerate(scene.bodies) if not body.name.startswith("seat")]
    momentum = sum(mass * run.velocity[:, k, 2] for mass, k in moved)
    pushes = [load for load in scene.loads if load.type == "force"]
    duration = pushes[0].factor.duration  # type: ignore[union-attr]
    impulse = duration / np.pi * (1.0 - np.cos(np.pi * np.minimum(run.times, duration) / duration))
    assert np.allclose(momentum, sum(load.vector[2] for load in pushes) * impulse, rtol=1e-8, atol=1e-6)


def test_parts_without_a_counterpart_are_named():
    with pytest.raises(ValueError, match="has no counterpart in space yet"):
        in_space(scenes.make("android_simplified"), "s", "", 0.0)


def test_a_straight_crash_from_the_rear_is_the_planar_ones():
    """With stops and body contacts, whose planar depths test_believable_androids holds within what is declared."""
    full: dict[str, Any] = {"impact": "rear"}
    planar = simulate(scenes.make("android_simplified", **full), SETTINGS)
    spatial = simulate(scenes.make("android_spatial", oblique=0.0, **full), SETTINGS)
    assert planar.ok, planar.message
    assert spatial.ok, spatial.message
    assert np.abs(spatial.position[:, :, :2] - planar.position).max() < 1e-10


def test_a_crash_from_the_rear_needs_stops():
    with pytest.raises(ValueError, match="impact = 'rear' needs stops"):
        scenes.make("android_spatial", impact="rear", **BARE)


@pytest.mark.parametrize("parameters", [pytest.param({}, marks=pytest.mark.slow), BARE])
def test_a_straight_crash_meets_the_planar_truth_lifted_into_space(parameters):
    """Positions, Euler parameters and rates; an oblique pulse has no truth."""
    scene, times = scenes.make("android_spatial", oblique=0.0, **parameters), np.linspace(0.0, 0.1, 11)
    truth, run = seek_truth(scene, times), simulate(scene, SETTINGS, times)
    assert isinstance(truth, Truth), truth
    assert truth.angular_velocity is not None
    assert np.abs(run.position - truth.position).max() < 1e-10
    assert np.abs(run.angular_velocity - truth.angular_velocity).max() < 1e-7
    assert np.abs(np.sum(run.orientation * truth.orientation, axis=2)).min() > 1.0 - 1e-12
    assert isinstance(seek_truth(scenes.make("android_spatial"), times), NoTruth)
