"""A run that stops says when, why, which body or joint, and up to when its output is good."""

from __future__ import annotations

import math

import numpy as np

from mbs_ref.cores.choice import compile_scene
from mbs_ref.scene import (
    CoordinateDrive,
    Distance,
    PlanarBody,
    Revolute,
    Scene,
    SpatialBody,
    TorqueVector,
    TorsionSpring,
    UserForce,
)
from mbs_ref.scene.signals import Polynomial
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.simulate.diagnosis import independent_rows, weakest_joints
from mbs_ref.trajectory import Status


def body(name: str, x: float, y: float, angle: float = 0.0, **rest) -> PlanarBody:
    return PlanarBody(name=name, mass=1.0, inertia=0.1, position=(x, y), angle=angle, **rest)


def reach() -> Scene:
    """A slider driven away from a crank by more than their rod allows: the rod is straight at x = 3 m."""
    return Scene(
        name="reach",
        bodies=(body("crank", 0.0, 0.5, math.pi / 2), body("slider", 2.0, 1.0, velocity=(1.0, 0.0))),
        joints=(
            Revolute(name="axle", body_a="ground", body_b="crank", point=(0.0, 0.0)),
            Distance(name="rod", body_a="crank", body_b="slider", point_a=(0.0, 1.0), point_b=(2.0, 1.0)),
            CoordinateDrive(name="pull", body="slider", coordinate="x", motion=Polynomial(coefficients=(0.0, 1.0))),
            CoordinateDrive(name="rail", body="slider", coordinate="y", motion=Polynomial(coefficients=(0.0,))),
            CoordinateDrive(name="level", body="slider", coordinate="angle", motion=Polynomial(coefficients=(0.0,))),
        ),
        duration=2.0,
    )


def test_a_dead_end_names_its_joints():
    path = simulate(reach(), Settings(rtol=1e-8, project_initial=True))
    assert path.status in (Status.SINGULAR, Status.STEP_TOO_SMALL, Status.PROJECTION)
    assert "'rod'" in path.message
    assert "nearest to rank loss" in path.message
    assert f"the last good output is at t = {path.times[-1]:.9g} s" in path.message
    end = math.sqrt(8.0) - 2.0  # s: from there on (2 + t)^2 + 1 exceeds 3^2
    assert path.times[-1] <= end + 0.02
    assert path.times[-1] > end - 0.1


def test_the_weakest_joints_leave_permanent_redundancy_apart():
    twice = Revolute(name="twin", body_a="ground", body_b="crank", point=(0.0, 0.0))
    scene = reach().model_copy(update={"joints": (*reach().joints, twice)})
    system = compile_scene(scene)
    scaled = system.scaled_jacobian(0.0, system.initial_state())
    smallest, names = weakest_joints(system, scaled, independent_rows(system))
    assert smallest > 1e-2
    assert "twin" not in names


def test_what_is_not_finite_names_the_body():
    """A force that becomes NaN on the second body alone."""

    def law(t, q, v):
        force = np.zeros_like(q)
        force[1, 0] = np.nan if t > 0.3 else 1.0
        return force

    bodies = (body("still", 0.0, 0.0), body("pushed", 1.0, 0.0))
    scene = Scene(name="nan", bodies=bodies, loads=(UserForce(name="push", function=law),))
    path = simulate(scene, Settings(method="rk4", step=1e-2))
    assert path.status is Status.NON_FINITE
    assert "body 'pushed'" in path.message
    assert "at t = 0.3" in path.message
    assert "the last good output is at t = 0.3" in path.message


def test_a_spring_that_cannot_count_turns_is_named():
    inertia = (0.1, 0.1, 0.1, 0.0, 0.0, 0.0)
    wheel = SpatialBody(name="wheel", mass=1.0, inertia=inertia, angular_velocity=(0.0, 0.0, 5.0))
    axis = (0.0, 0.0, 1.0)
    scene = Scene(
        name="wound", gravity=(0.0, 0.0, 0.0), bodies=(wheel,),
        joints=(Revolute(name="axle", body_a="ground", body_b="wheel", point=(0.0, 0.0, 0.0), axis=axis),),
        loads=(TorsionSpring(name="coil", body_a="ground", body_b="wheel", stiffness=1e-3, axis=axis),
               TorqueVector(name="motor", body="wheel", vector=(0.0, 0.0, 0.1))),
    )  # fmt: skip
    path = simulate(scene, Settings(rtol=1e-8))
    assert not path.ok
    assert "load 'coil' has turned by" in path.message
    assert "cannot count turns" in path.message


def test_a_step_that_becomes_unstable_on_the_way_is_noted():
    """A spring along a hinged rod does not resist its turn at first; the frequency rises to sqrt(0.9 k / I)."""
    rod = {"type": "planar", "name": "rod", "mass": 1.0, "inertia": 1.0 / 12.0, "position": (0.5, 0.0)}
    spring = {"type": "spring_damper", "body_a": "rod", "body_b": "ground", "point_a": (1.0, 0.0)}
    scene = Scene.model_validate({
        "name": "hinged_rod", "duration": 0.1, "gravity": (0.0, 0.0),
        "bodies": [rod | {"velocity": (0.0, 15.0), "angular_velocity": 30.0}],
        "joints": [{"type": "revolute", "name": "hinge", "body_a": "rod", "body_b": "ground", "point": (0.0, 0.0)}],
        "loads": [spring | {"name": "spring", "point_b": (3.0, 0.0), "stiffness": 1e4, "rest_length": 2.0}],
    })  # fmt: skip
    notes = {
        step: simulate(scene, Settings(method="rk4", step=step, samples=21, estimate="off")).notes
        for step in (1e-4, 2.5e-2)
    }
    stated = {step: any("beyond what rk4 can bear" in note for note in every) for step, every in notes.items()}
    assert stated == {1e-4: False, 2.5e-2: True}
