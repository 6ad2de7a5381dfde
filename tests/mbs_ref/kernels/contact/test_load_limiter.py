"""A string whose pull is limited: uniform deceleration beyond, in closed form, by located events and without."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mbs_ref.observables.energy import kinetic_energy, potential_energy
from mbs_ref.scene import PlanarBody, PointMass, Scene, SpringDamper
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

MASS, SPEED, STIFFNESS, LIMIT = 2.0, 3.0, 800.0, 60.0
TAUT = LIMIT / STIFFNESS  # m, where the limit is reached
LEFT = math.sqrt(SPEED**2 - LIMIT * TAUT / MASS)  # m/s, there
FAR = TAUT + 0.5 * MASS * LEFT**2 / LIMIT  # m
OMEGA = math.sqrt(STIFFNESS / MASS)
ON_STRING = math.asin(OMEGA * TAUT / SPEED) / OMEGA  # s
TURNS = ON_STRING + MASS * LEFT / LIMIT  # s, at FAR


def thrown(dimension: int = 2, damping: float = 0.0) -> Scene:
    at = (1.0, 0.0, 0.0)[:dimension]
    body = (
        PlanarBody(name="a", mass=MASS, inertia=1.0, position=at, velocity=(SPEED, 0.0))
        if dimension == 2
        else PointMass(name="a", mass=MASS, position=at, velocity=(SPEED, 0.0, 0.0))
    )
    string = SpringDamper(
        name="string", body_a="ground", body_b="a", point_a=(0.0,) * dimension, point_b=at, stiffness=STIFFNESS,
        damping=damping, rest_length=1.0, tension_only=True, limit=LIMIT,
    )  # fmt: skip
    return Scene(name="thrown", gravity=(0.0,) * dimension, bodies=(body,), loads=(string,), duration=2.0 * TURNS)


@pytest.mark.parametrize("method", ["dop853", "rk4"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_limited_string_stops_a_mass_as_its_closed_form_does_and_gives_its_energy_back(dimension, method):
    scene, times = thrown(dimension), np.array([0.0, ON_STRING, TURNS, 2.0 * TURNS])
    precision = {"step": TURNS / 200} if method == "rk4" else {"rtol": 1e-12}
    path = simulate(scene, Settings(method=method, reactions=False, **precision), times)
    assert path.ok, path.message
    stretch = path.position[:, 0, 0] - 1.0
    assert stretch == pytest.approx([0.0, TAUT, FAR, 0.0], abs=1e-8)
    assert path.velocity[-1, 0, 0] == pytest.approx(-SPEED, abs=1e-8)
    energy = kinetic_energy(scene, path) + potential_energy(scene, path)
    assert energy == pytest.approx(0.5 * MASS * SPEED**2)


def test_a_damper_never_pulls_beyond_the_limit_and_only_takes_energy():
    scene = thrown(damping=30.0)
    times = np.linspace(0.0, 0.4, 401)
    path = simulate(scene, Settings(rtol=1e-10, reactions=False, estimate="off"), times)
    pull = -MASS * np.gradient(path.velocity[:, 0, 0], times)
    assert path.velocity[0, 0, 0] * 30.0 > LIMIT  # at once
    assert pull.max() < LIMIT * (1.0 + 1e-6)
    assert pull[5] == pytest.approx(LIMIT, rel=1e-6)
    energy = kinetic_energy(scene, path) + potential_energy(scene, path)
    assert np.diff(energy).max() < 1e-9
    assert path.velocity[-1, 0, 0] > -SPEED


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_string_without_stiffness_and_damping_never_pulls(dimension):
    scene = thrown(dimension)
    none = scene.loads[0].model_copy(update={"stiffness": 0.0})
    path = simulate(scene.model_copy(update={"loads": (none,)}), Settings(estimate="off", max_steps=100))
    assert path.ok, path.message
    assert path.velocity[-1, 0, 0] == pytest.approx(SPEED, rel=1e-12)


def test_a_limit_needs_a_string():
    with pytest.raises(ValueError, match=r"limit = 60\.0 N requires tension_only = true"):
        SpringDamper(
            name="s", body_a="ground", body_b="a", point_a=(0.0, 0.0), point_b=(1.0, 0.0), stiffness=1.0, limit=60.0
        )
