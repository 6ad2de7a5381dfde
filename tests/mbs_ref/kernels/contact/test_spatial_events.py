"""Contacts as constraints, springs that go slack and declared events in space, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from cross_checks.truths.of.seats import Shaker, flights
from mbs_ref.observables.energy import kinetic_energy
from mbs_ref.scene import PointDrive, PointMass, Prismatic, Scene, SpatialBody, SpringDamper
from mbs_ref.scene.contact import ConstraintLaw, SphereOnPlane, SphereOnSphere
from mbs_ref.scene.events import CoordinateEvent, DistanceEvent
from mbs_ref.scene.signals import Harmonic
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Status

FINE = Settings(method="dop853", rtol=1e-12, estimate="off")
ALONG = np.array([1.0, 2.0, 2.0]) / 3.0
G = 9.81
METHODS = {
    "dop853": (FINE, 1e-11),
    "rk4": (Settings(method="rk4", step=5e-4), 1e-8),
    "radau": (Settings(method="radau", rtol=1e-10), 1e-9),
    "generalized_alpha": (Settings(method="generalized_alpha", step=2.5e-4), 3e-6),
    "dassl": (Settings(method="dassl", rtol=1e-9), 3e-6),
    "lsodar": (Settings(method="lsodar", rtol=1e-8), 3e-6),
}


def _at(distance: float) -> tuple[float, float, float]:
    x, y, z = (distance * ALONG).tolist()
    return x, y, z


def _point(position: tuple[float, ...], velocity: tuple[float, ...]) -> PointMass:
    return PointMass(name="mass", mass=1.0, position=position, velocity=velocity)


# --- contacts as constraints ----------------------------------------------------------------------


def _dome(speed: float) -> Scene:
    """A particle that slides from the top of a fixed sphere of 1 m, in a direction between two axes."""
    along = speed / math.sqrt(2.0)
    touch = SphereOnSphere(
        name="dome", body_a="mass", center_a=(0.0, 0.0, 1.0), radius_a=0.0, body_b="ground", center_b=(0.0, 0.0, 0.0),
        radius_b=1.0, law=ConstraintLaw(),
    )  # fmt: skip
    bodies = (_point((0.0, 0.0, 1.0), (along, along, 0.0)),)
    return Scene(name="dome", gravity=(0.0, 0.0, -G), duration=1.0, bodies=bodies, contacts=(touch,))


@pytest.mark.parametrize("name", METHODS)
def test_a_particle_leaves_a_sphere_where_its_weight_no_longer_bends_its_path(name):
    """At cos(phi) = (2 + v0^2 / (g R)) / 3, and from there on a parabola."""
    settings, tolerance = METHODS[name]
    run = simulate(_dome(1.0), settings)
    assert run.ok, run.message
    assert run.event_times is not None
    left, height = run.event_times[0, 0], (2.0 + 1.0 / G) / 3.0
    slide, _ = quad(lambda phi: 1.0 / math.sqrt(1.0 + 2.0 * G * (1.0 - math.cos(phi))), 0.0, math.acos(height))
    assert left == pytest.approx(slide, abs=tolerance)
    speed, reach = math.sqrt(height * G), math.sqrt(1.0 - height**2)
    after = run.times > left
    flight = run.times[after] - left
    fallen = height - speed * reach * flight - 0.5 * G * flight**2
    assert run.position[after, 0, 2] == pytest.approx(fallen, abs=10.0 * tolerance)
    gone = (reach + speed * height * flight) / math.sqrt(2.0)
    assert run.position[after, 0, 0] == pytest.approx(gone, abs=10.0 * tolerance)
    assert np.linalg.norm(run.position[~after, 0], axis=1) == pytest.approx(1.0, abs=tolerance)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("method", ["lsodar", "dassl", "radau"])
def test_it_leaves_once(method, rtol):
    """It leaves without speed: in the first steps after, its height is less than what they err."""
    run = simulate(_dome(1.0), Settings(method=method, rtol=rtol, estimate="off", reactions=False))
    assert run.ok, run.message
    assert run.events == 1


def test_a_fast_particle_leaves_the_sphere_at_once():
    run = simulate(_dome(math.sqrt(1.01 * G)), FINE)
    assert run.ok, run.message
    assert run.position[:, 0, 2] == pytest.approx(1.0 - 0.5 * G * run.times**2, abs=1e-11)


def test_a_ball_on_a_driven_plate_lifts_off_and_lands():
    """The seat moves by A sin(w t) along its normal, which is that of gravity too and lies askew in space."""
    amplitude, omega, radius = 0.02, 30.0, 0.05
    speed = _at(amplitude * omega)
    inertia = (0.01, 0.02, 0.02, 0.001, 0.0, 0.0)
    ball = SpatialBody(name="ball", mass=1.0, inertia=inertia, position=_at(radius), velocity=speed)
    seat = SpatialBody(name="seat", mass=2.0, inertia=inertia, position=_at(0.0), velocity=speed)
    guide = Prismatic(name="guide", body_a="ground", body_b="seat", point=_at(0.0), axis=_at(1.0))
    shake = PointDrive(
        name="shake", body="seat", point=_at(0.0), direction=_at(1.0), motion=Harmonic(amplitude=amplitude, omega=omega)
    )  # fmt: skip
    touch = SphereOnPlane(
        name="touch", body_a="ball", center=_at(radius), radius=radius, body_b="seat", point=_at(0.0), normal=_at(1.0),
        law=ConstraintLaw(),
    )  # fmt: skip
    run = simulate(Scene(
        name="shaken", gravity=_at(-G), duration=0.6, bodies=(ball, seat), joints=(guide, shake), contacts=(touch,)
    ), FINE)  # fmt: skip
    assert run.ok, run.message
    assert run.event_times is not None
    flight = flights(Shaker(amplitude, omega, G), 0.6)
    assert isinstance(flight, list)
    first = flight[0]
    assert run.event_times[:2, 0] == pytest.approx([first.t0, first.t1], abs=1e-12)
    assert np.min(run.contacts["touch"][:, 1:4] @ ALONG) >= 0.0


def _plate(spin: float) -> Scene:
    """A particle that slides without friction on a free plate that tumbles, pressed on by its own motion across it."""
    plate = SpatialBody(
        name="plate", mass=2.0, inertia=(0.3, 0.5, 0.7, 0.0, 0.0, 0.0), position=(0.0, 0.0, 0.0),
        angular_velocity=(0.3, -spin, 0.4),
    )  # fmt: skip
    place = np.array([0.4, 0.1, 0.2])
    velocity = tuple((np.cross((0.3, -spin, 0.4), place) + np.array([1.0, 0.3, 0.0])).tolist())
    touch = SphereOnPlane(
        name="top", body_a="mass", center=tuple(place.tolist()), radius=0.0, body_b="plate", point=(0.0, 0.0, 0.2),
        normal=(0.0, 0.0, 1.0), law=ConstraintLaw(),
    )  # fmt: skip
    mass = PointMass(name="mass", mass=1.0, position=tuple(place.tolist()), velocity=velocity)
    return Scene(name="plate", gravity=(0.0, 0.0, 0.0), duration=0.4, bodies=(plate, mass), contacts=(touch,))


def test_a_particle_on_a_tumbling_plate_keeps_energy_and_momentum_while_it_is_pressed_on():
    scene = _plate(3.0)
    run = simulate(scene, FINE)
    assert run.ok, run.message
    pressed = np.linalg.norm(run.contacts["top"][:, 1:4], axis=1)
    assert pressed.min() > 1e-2
    energy = kinetic_energy(scene, run)
    assert energy == pytest.approx(np.full(len(energy), energy[0]), rel=1e-11)
    momentum = 2.0 * run.velocity[:, 0] + run.velocity[:, 1]
    assert momentum == pytest.approx(np.tile(momentum[0], (len(momentum), 1)), abs=1e-11)


# --- springs that go slack ------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["dop853", "radau", "lsodar", "dassl"])
def test_a_tether_in_space_is_taut_for_half_an_oscillation(method):
    """Thrown at 2 m/s from 1 m, taut at 2 m from t = 0.5 s to 1.5 s, back at 1 m at 2 s."""
    spring = SpringDamper(
        name="tether", body_a="ground", body_b="mass", point_a=(0.0, 0.0, 0.0), point_b=_at(1.0),
        stiffness=math.pi**2, rest_length=2.0, tension_only=True,
    )  # fmt: skip
    gravity = (0.0, 0.0, 0.0)
    scene = Scene(name="tether", gravity=gravity, duration=2.0, bodies=(_point(_at(1.0), _at(2.0)),), loads=(spring,))
    run = simulate(scene, Settings(method=method, rtol=1e-10, estimate="off"))
    assert run.event_names == ("tether",)
    assert run.event_times is not None
    assert run.event_times[:, 0] == pytest.approx([0.5, 1.5], abs=1e-7)
    assert run.position[-1, 0] == pytest.approx(np.array(_at(1.0)), abs=1e-7)


# --- declared events ------------------------------------------------------------------------------


def _thrown(*events) -> Scene:
    """A particle thrown upwards at 3 m/s and sideways at 1 m/s from the origin."""
    bodies = (_point((0.0, 0.0, 0.0), (1.0, 0.0, 3.0)),)
    return Scene(name="thrown", gravity=(0.0, 0.0, -G), duration=1.0, bodies=bodies, events=events)


def test_coordinates_and_rates_in_space_cross_their_values_at_the_times_of_free_fall():
    run = simulate(_thrown(
        CoordinateEvent(name="down", body="mass", coordinate="z", value=0.2, crossing="falling"),
        CoordinateEvent(name="top", body="mass", coordinate="z", rate=True),
        CoordinateEvent(name="away", body="mass", coordinate="x", value=0.25),
    ), FINE)  # fmt: skip
    assert run.event_times is not None
    times = {run.event_names[int(k)]: t for t, k in run.event_times}
    assert times == pytest.approx(
        {"down": (3.0 + math.sqrt(9.0 - 0.4 * G)) / G, "top": 3.0 / G, "away": 0.25}, abs=1e-12
    )


def test_a_distance_in_space_stops_the_run():
    """Of a particle that passes the origin at 1 m: |r| = 2 m at t = sqrt(3) s."""
    event = DistanceEvent(
        name="far", body_a="ground", body_b="mass", point_a=(0.0, 0.0, 0.0), point_b=(0.0, 1.0, 0.0), value=2.0,
        action="stop",
    )  # fmt: skip
    bodies = (_point((0.0, 1.0, 0.0), (0.6, 0.0, 0.8)),)
    run = simulate(Scene(name="far", gravity=(0.0, 0.0, 0.0), duration=3.0, bodies=bodies, events=(event,)), FINE)
    assert run.status is Status.STOP_EVENT
    assert run.times[-1] == pytest.approx(math.sqrt(3.0), abs=1e-12)


def test_what_a_dimension_does_not_have_is_refused():
    with pytest.raises(ValueError, match="'angle' is for the plane"):
        _thrown(CoordinateEvent(name="turn", body="mass", coordinate="angle"))
    with pytest.raises(ValueError, match="capped"):
        SphereOnPlane(
            name="edge", body_a="mass", center=(0.0, 0.0, 1.0), radius=0.1, point=(0.0, 0.0, 0.0),
            normal=(0.0, 0.0, 1.0), extent="capped", size=(1.0, 1.0), edge=(1.0, 0.0, 0.0), law=ConstraintLaw(),
        )  # fmt: skip
