"""Planar mechanisms that between them use every joint, drive and load: material for checks of the core."""

from __future__ import annotations

import math

import numpy as np

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
    Weld,
)
from mbs_ref.scene.signals import HalfSine, Harmonic, Table


def _body(name: str, x: float, y: float, angle: float = 0.3, mass: float = 1.3) -> PlanarBody:
    return PlanarBody(name=name, mass=mass, inertia=0.17 * mass, position=(x, y), angle=angle)


def branched_tree() -> Scene:
    """Every joint type in one tree, moving bases included."""
    bodies = [_body("base", 0.0, 0.0), _body("arm", 1.0, 0.2, -0.4), _body("slider", 1.7, 0.9, 1.1)]
    bodies += [_body("tip", 2.4, 1.0, 0.2, 0.4), _body("hook", 0.2, -0.8), _body("free", -2.0, 1.0)]
    return Scene(
        name="branched_tree",
        gravity=(0.3, -9.81),
        bodies=(*bodies, PointMass(name="bob", mass=0.7, position=(3.2, 0.1), velocity=(0.0, 0.0))),
        joints=(
            Revolute(name="pin", body_a="base", body_b="ground", point=(-0.4, 0.1)),
            Revolute(name="elbow", body_a="base", body_b="arm", point=(0.5, 0.1)),
            Prismatic(name="slide", body_a="slider", body_b="arm", point=(1.5, 0.5), axis=(0.4, 1.0)),
            Weld(name="weld", body_a="slider", body_b="tip", point=(2.0, 1.0)),
            Distance(name="rod", body_a="tip", body_b="bob", point_a=(2.6, 0.9), point_b=(3.2, 0.1)),
            PointDrive(
                name="hook_x", body="hook", point=(0.3, -0.9), direction=(1, 0), motion=Harmonic(amplitude=0.2, omega=5)
            ),
            PointDrive(
                name="hook_y",
                body="hook",
                point=(0.3, -0.9),
                direction=(0.3, 1),
                motion=Harmonic(amplitude=0.1, omega=7),
            ),
        ),
        loads=_loads(),
    )


def _loads():
    return (
        Force(name="push", body="arm", point=(1.1, 0.4), vector=(3.0, -2.0), factor=HalfSine(peak=2.0, duration=0.4)),
        Force(name="jet", body="tip", point=(2.3, 1.1), vector=(1.0, 4.0), frame="body"),
        Torque(name="twist", body="base", torque=0.8, factor=Table(times=(0.1, 0.2, 0.2, 0.5), values=(0, 1, 2, 0))),
        SpringDamper(
            name="strut", body_a="ground", body_b="slider", point_a=(0, 2), point_b=(1.6, 1.1), stiffness=80, damping=3
        ),
        SpringDamper(
            name="belt", body_a="hook", body_b="free", point_a=(0.1, -0.7), point_b=(-1.8, 1.1), stiffness=200,
            rest_length=2.0, tension_only=True,
        ),
        TorsionSpring(name="coil", body_a="base", body_b="arm", stiffness=20, damping=0.5, rest_angle=0.1),
    )  # fmt: skip


def driven_loops() -> Scene:
    """A driven four-bar with a strut across it and a slider closed onto ground."""
    crank, coupler, rocker = _body("crank", 0.25, 0.4), _body("coupler", 1.0, 1.0), _body("rocker", 1.75, 0.6)
    shoe = _body("shoe", 2.6, 0.3, 0.0)
    return Scene(
        name="driven_loops",
        gravity=(0.0, -9.81),
        bodies=(crank, coupler, rocker, shoe),
        joints=(
            Revolute(name="a", body_a="ground", body_b="crank", point=(0.0, 0.0)),
            CoordinateDrive(name="motor", body="crank", coordinate="angle", motion=Harmonic(amplitude=0.5, omega=3.0)),
            Revolute(name="b", body_a="crank", body_b="coupler", point=(0.5, 0.8)),
            Revolute(name="c", body_a="coupler", body_b="rocker", point=(1.5, 1.1)),
            Revolute(name="d", body_a="rocker", body_b="ground", point=(2.0, 0.0)),
            Distance(name="link", body_a="rocker", body_b="shoe", point_a=(1.6, 0.9), point_b=(2.5, 0.3)),
            Prismatic(name="rail", body_a="ground", body_b="shoe", point=(2.6, 0.3), axis=(1.0, 0.0)),
        ),
    )


def seated_pair() -> Scene:
    """Three coordinate drives on one body and a body welded to it: rows share one slot."""
    return Scene(
        name="seated_pair",
        gravity=(0.0, -9.81),
        bodies=(_body("seat", 0.0, 0.0), _body("back", -0.2, 0.5)),
        joints=(
            CoordinateDrive(
                name="x", body="seat", coordinate="x", motion=HalfSine(peak=-80.0, duration=0.1, start=0.05),
                level="acceleration",
            ),
            CoordinateDrive(name="y", body="seat", coordinate="y", motion=Harmonic(amplitude=0.0, omega=1.0)),
            CoordinateDrive(name="turn", body="seat", coordinate="angle", motion=Harmonic(amplitude=0.1, omega=2.0)),
            Revolute(name="hinge", body_a="back", body_b="seat", point=(-0.2, 0.1)),
        ),
    )  # fmt: skip


EVERY = (branched_tree, driven_loops, seated_pair)


def moved_state(system, seed: int) -> np.ndarray:
    """Return a random state on the constraints, well away from the start."""
    rng = np.random.default_rng(seed)
    y = system.initial_state()
    y += 0.15 * rng.normal(size=y.size) * np.repeat([1.0, math.pi], y.size // 2)
    for k, body in enumerate(system.scene.bodies):
        if isinstance(body, PointMass):  # its third coordinate is not in use
            y[3 * k + 2] = y[y.size // 2 + 3 * k + 2] = 0.0
    system.project(0.3, y, tolerance=1e-13, most=60)
    return y
