"""One contact alone, in the plane and in space, against motions that are known in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mbs_ref.scene import Force, PlanarBody, Scene, SpatialBody
from mbs_ref.scene.contact import (
    CircleOnLine,
    PinOnSprocket,
    RegularisedCoulomb,
    SphereOnPlane,
    SpringDamperLaw,
    StickSlip,
)
from mbs_ref.scene.signals import Polynomial
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory

G = 9.81  # m/s^2
STIFF = SpringDamperLaw(stiffness=1e5, damping=100.0, release="force")
SINK = G / 1e5  # m, of 1 kg at rest
HEADING = np.array([0.6, 0.8])  # in space, askew to both edges of the plane


def _along(dimension: int, length: float, height: float) -> tuple[float, ...]:
    """A vector that lies `length` along the floor and `height` above it."""
    return (length, height) if dimension == 2 else (*(length * HEADING).tolist(), height)


def _block(
    dimension: int, *, height: float = -SINK, speed: float = 0.0, rise: float = 0.0, gravity: float = G, **floor
) -> Scene:
    """1 kg that touches a floor at its centre of mass, so that nothing turns it."""
    pose = {"name": "block", "mass": 1.0, "position": _along(dimension, 0.0, height)}
    pose["velocity"] = _along(dimension, speed, rise)
    contact = {"name": "floor", "body_a": "block", "center": pose["position"], "radius": 0.0, "law": STIFF} | floor
    if dimension == 2:
        body = PlanarBody(inertia=1.0, **pose)  # type: ignore[arg-type]
        touch = CircleOnLine(point_1=(0.0, 0.0), point_2=(1.0, 0.0), **contact)  # type: ignore[arg-type]
    else:
        body = SpatialBody(inertia=(1.0, 1.0, 1.0, 0.0, 0.0, 0.0), **pose)  # type: ignore[arg-type]
        touch = SphereOnPlane(point=(0.0, 0.0, 0.0), normal=(0.0, 0.0, 1.0), **contact)  # type: ignore[arg-type]
    return Scene(name="block", gravity=_along(dimension, 0.0, -gravity), bodies=(body,), contacts=(touch,))


def _run(scene: Scene, t_end: float, **settings) -> Trajectory:
    chosen = {"method": "dop853", "rtol": 1e-10, "t_end": t_end, "samples": 3} | settings
    run = simulate(scene, Settings(**chosen))
    assert run.ok, run.message
    return run


def _advance(run: Trajectory, rates: bool = False) -> float:
    """Return place (m) or speed (m/s) along the heading at the end."""
    end = (run.velocity if rates else run.position)[-1, 0]
    return float(end[0] if len(end) == 2 else end[:2] @ HEADING)


@pytest.mark.parametrize("dimension", [2, 3])
def test_smooth_friction_slows_by_its_closed_form(dimension):
    """v' = -mu g tanh(v / v_s) has sinh(v / v_s) = sinh(v_0 / v_s) exp(-mu g t / v_s)."""
    mu, creep, start, t = 0.3, 0.5, 1.2, 0.4
    run = _run(_block(dimension, speed=start, friction=RegularisedCoulomb(coefficient=mu, speed=creep)), t)
    exact = creep * math.asinh(math.sinh(start / creep) * math.exp(-mu * G * t / creep))
    assert _advance(run, rates=True) == pytest.approx(exact, rel=1e-8)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_block_lets_go_at_the_static_limit_and_slides_at_the_sliding_one(dimension):
    """A pull that grows by 10 N a second: the block lets go at mu_s m g and then has mu m g against it."""
    mu, static, rate = 0.2, 0.5, 10.0
    grip = StickSlip(coefficient=mu, static=static, stiffness=1e6, damping=1e3)
    scene = _block(dimension, friction=grip)
    place = scene.bodies[0].position
    ramp = Polynomial(coefficients=(0.0, rate))
    pull = Force(name="pull", body="block", point=place, vector=_along(dimension, 1.0, 0.0), factor=ramp)
    scene = scene.model_copy(update={"loads": (pull,)})
    lets_go, end = static * G / rate, 0.9
    held = _run(scene, 0.98 * lets_go)
    yields = 2 * static * G / 1e6  # m, what the sticking spring gives
    assert abs(_advance(held)) < yields
    exact = 0.5 * rate * (end**2 - lets_go**2) - mu * G * (end - lets_go)
    assert _advance(_run(scene, end), rates=True) == pytest.approx(exact, rel=1e-4)


@pytest.mark.parametrize("rtol", [1e-5, 1e-10])
@pytest.mark.parametrize("speed", [1.0, 24.0])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_block_that_stops_is_held_up_to_the_static_limit(dimension, speed, rtol):
    """Thrown against a pull between the sliding and the static limit: it stops after v^2 / 2 (mu g + F/m) and stays."""
    mu, static, pull = 0.2, 0.5, 0.35 * G
    grip = StickSlip(coefficient=mu, static=static, stiffness=1e6, damping=1e3)
    scene = _block(dimension, friction=grip, speed=speed)
    back = Force(name="pull", body="block", point=scene.bodies[0].position, vector=_along(dimension, -pull, 0.0))
    stops = speed / (mu * G + pull)
    run = _run(scene.model_copy(update={"loads": (back,)}), 2 * stops, rtol=rtol)
    assert _advance(run) == pytest.approx(speed * stops / 2, abs=2 * pull / 1e6 + 10 * rtol * speed)
    assert abs(_advance(run, rates=True)) < 1e-6 * speed + rtol


@pytest.mark.parametrize("events", ["located", "none"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_what_is_deeper_than_the_surface_is_thick_is_behind_it(dimension, events):
    deep = {"height": -0.05, "gravity": 0.0}
    inside = _run(_block(dimension, thickness=0.06, **deep), 1e-3, events=events)
    assert inside.velocity[-1, 0, -1] > 1.0  # pushed out by 5000 N
    behind = _run(_block(dimension, thickness=0.04, **deep), 1e-3, events=events)
    assert np.all(behind.velocity[-1, 0] == 0.0)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_body_found_behind_a_surface_passes_through_it_freely(dimension):
    run = _run(_block(dimension, height=-0.05, gravity=0.0, rise=2.0, thickness=0.04), 0.1)
    assert run.position[-1, 0, -1] == pytest.approx(0.15, abs=1e-12)


ROOT, WIDTH, OUT = 0.002, 0.006, 0.004  # m: clearance; the pin beside the seat's radius, and beyond the pitch circle


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("flank", [0.0, 0.35, 0.6])
def test_a_tooth_pushes_a_pin_across_its_flank(flank, side):
    """The flank is a straight line at `flank` from the gap's radius, `clearance` away from the seat.

    The pin is at (side WIDTH, OUT) from the seat at angle 0.7: the wall's line through the tangent point is
    followed point by point, and its nearest point tells depth and direction.
    """
    pitch, angle = 0.1, 0.7
    radial, across = np.array([math.cos(angle), math.sin(angle)]), np.array([math.sin(angle), -math.cos(angle)])
    pin = (pitch + OUT) * radial + side * WIDTH * across
    line = pitch * radial + side * ROOT * (math.cos(flank) * across) - ROOT * math.sin(flank) * radial
    direction = math.cos(flank) * radial + side * math.sin(flank) * across
    nearest = line
    for reach in (0.1, 1e-4, 1e-7):  # m, about the nearest so far
        wall = nearest + np.linspace(-reach, reach, 4001)[:, None] * direction
        nearest = wall[np.argmin(np.sum((wall - pin) ** 2, axis=1))]
    inward = nearest - pin
    bodies = (
        PlanarBody(name="pin", mass=1.0, inertia=1.0, position=tuple(pin)),
        PlanarBody(name="wheel", mass=1.0, inertia=1.0),
    )
    tooth = PinOnSprocket(
        name="tooth", body_a="pin", center=tuple(pin), body_b="wheel", axle=(0.0, 0.0), teeth=12, pitch_radius=pitch,
        addendum_radius=pitch + 0.02, first_seat=angle, clearance=ROOT, flank_angle=flank,
        law=SpringDamperLaw(stiffness=1e4),
    )  # fmt: skip
    scene = Scene(name="tooth", gravity=(0.0, 0.0), bodies=bodies, contacts=(tooth,))
    depth, *force = _run(scene, 1e-4).contacts["tooth"][0, :3]
    assert depth == pytest.approx(np.linalg.norm(inward), rel=1e-6)
    assert np.array(force) == pytest.approx(1e4 * inward, rel=1e-4, abs=1e-3)
