"""A scene at rest: where statics has a closed form, the solver reaches it, and nothing moves from there."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from mbs_ref import at_equilibrium, scenes
from mbs_ref.scene import (
    GROUND,
    Bushing,
    PlanarBody,
    Prismatic,
    Revolute,
    Scene,
    SpatialBody,
    SpringDamper,
    TorsionSpring,
)
from mbs_ref.scene.contact import CircleOnLine, ProgressiveLaw
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.simulate.equilibrium import NoEquilibrium

G, MASS, STIFFNESS = 9.81, 2.0, 300.0  # m/s^2, kg, N/m and N m/rad
DOWN = (0.0, -G)
still = 1e-9  # m


def body(*position: float, name: str = "body") -> PlanarBody:
    return PlanarBody(name=name, mass=MASS, inertia=0.1, position=position)


def require_rest(scene: Scene) -> None:
    path = simulate(scene, Settings(t_end=2.0, samples=11, estimate="off"))
    assert path.ok, path.message
    assert np.abs(path.position - path.position[:1]).max() < still


def test_a_chain_hangs_straight_down():
    scene = scenes.make("pendulum_chain", links=3, start="equilibrium")
    assert scene.parameters["start"] == "equilibrium"
    hanging = np.array([(0.0, -0.5 - k) for k in range(3)])
    assert np.abs(np.array([b.position for b in scene.bodies]) - hanging).max() < still
    require_rest(scene)


def test_a_pendulum_near_its_upper_equilibrium_ends_in_the_lower_one():
    hinge = Revolute(name="hinge", body_a=GROUND, body_b="body", point=(0.0, 0.0))
    drawn = Scene(name="upright", gravity=DOWN, bodies=(body(math.sin(1e-4), math.cos(1e-4)),), joints=(hinge,))
    assert at_equilibrium(drawn).bodies[0].position == pytest.approx((0.0, -1.0), abs=still)


def test_springs_strained_in_equilibrium_keep_their_law():
    """From unstrained springs the slider sags by m g / k, and the bar turns until k a = m g cos a."""
    rail = Prismatic(name="rail", body_a=GROUND, body_b="slider", point=(0.0, 0.0), axis=(0.0, 1.0))
    hinge = Revolute(name="hinge", body_a=GROUND, body_b="bar", point=(3.0, 0.0))
    spring = SpringDamper(
        name="spring", body_a=GROUND, body_b="slider", point_a=(0.0, 1.0), point_b=(0.0, 0.0), stiffness=STIFFNESS
    )
    bar = TorsionSpring(name="twist", body_a=GROUND, body_b="bar", stiffness=STIFFNESS)
    bodies = body(0.0, 0.0, name="slider"), body(4.0, 0.0, name="bar")
    drawn = Scene(name="sag", gravity=DOWN, bodies=bodies, joints=(rail, hinge), loads=(spring, bar))
    scene = at_equilibrium(drawn)
    slider, turned = scene.bodies
    angle: Any = brentq(lambda a: STIFFNESS * a - MASS * G * math.cos(a), 0.0, 1.0, xtol=1e-14)
    assert slider.position[1] == pytest.approx(-MASS * G / STIFFNESS, abs=still)
    assert isinstance(turned, PlanarBody)
    assert turned.angle == pytest.approx(-angle, abs=still)
    require_rest(scene)


def test_a_ball_sinks_into_the_floor_below_it():
    law = ProgressiveLaw(stiffness=1e4, damping=1e3)
    touch = CircleOnLine(
        name="floor", body_a="body", center=(0.0, 0.2), radius=0.1, point_1=(-1.0, 0.0), point_2=(1.0, 0.0), law=law
    )
    scene = at_equilibrium(Scene(name="ball", gravity=DOWN, bodies=(body(0.0, 0.2),), contacts=(touch,)))
    assert scene.bodies[0].position[1] == pytest.approx(0.1 - MASS * G / 1e4, abs=still)
    require_rest(scene)


def test_a_pendulum_in_space_hangs_below_its_joint():
    scene = scenes.make("spherical_pendulum", start="equilibrium")
    assert scene.bodies[0].position == pytest.approx((0.0, 0.0, -1.0), abs=still)
    require_rest(scene)


def test_a_body_in_space_hangs_on_a_strained_bushing():
    """It sinks by m g/k and turns by m g x/k_r where its weight has an arm x; it starts there and stays."""
    stiff, turns, arm = 1e5, 400.0, 0.1  # N/m, N m/rad, m
    part = Bushing(name="rubber", body_a=GROUND, body_b="body", point=(0.0, 0.0, 0.0), x_axis=(0.0, 1.0, 0.0),
                   y_axis=(0.0, 0.0, 1.0), stiffness=(stiff,) * 3 + (turns,) * 3)  # fmt: skip
    heavy = SpatialBody(name="body", mass=MASS, inertia=(0.1, 0.1, 0.1, 0.0, 0.0, 0.0), position=(arm, 0.0, 0.0))
    scene = at_equilibrium(Scene(name="rubber", gravity=(0.0, 0.0, -G), bodies=(heavy,), loads=(part,)))
    angle = brentq(lambda a: turns * a - MASS * G * arm * math.cos(a), 0.0, 1.0, xtol=1e-15)
    sunk = (arm * math.cos(angle), 0.0, -arm * math.sin(angle) - MASS * G / stiff)
    assert scene.bodies[0].position == pytest.approx(sunk, abs=still)
    require_rest(scene)
    again = at_equilibrium(scene)
    assert again.bodies[0].position == pytest.approx(sunk, abs=still)


def test_a_soft_spring_rests_to_rounding_beside_a_stiff_one_that_starts_strained():
    """At the start the stiff one accelerates by 5e5 m/s^2, of which 1e-10 would leave the soft one 3e-7 m away."""
    springs, guides = [], []
    for k, stiffness in enumerate((1e7, STIFFNESS)):
        at = {"body_a": GROUND, "body_b": f"body{k}"}
        guides.append(Prismatic(name=f"guide{k}", point=(k, 0.1), axis=(0.0, 1.0), **at))
        springs.append(SpringDamper(name=f"spring{k}", point_a=(k, 1.1), point_b=(k, 0.1), stiffness=stiffness,
                                    rest_length=1.1, **at))  # fmt: skip
    bodies = (body(0.0, 0.1, name="body0"), body(1.0, 0.1, name="body1"))
    scene = at_equilibrium(Scene(name="two", gravity=DOWN, bodies=bodies, joints=tuple(guides), loads=tuple(springs)))
    sunk = [0.0 - MASS * G / stiffness for stiffness in (1e7, STIFFNESS)]
    assert [b.position[1] for b in scene.bodies] == pytest.approx(sunk, abs=1e-13)


def test_what_falls_forever_has_no_equilibrium():
    with pytest.raises(NoEquilibrium, match=r"9\.81 m/s\^2"):
        at_equilibrium(Scene(name="fall", gravity=DOWN, bodies=(body(0.0, 0.0),)))
