"""The tracked vehicle: wheels that roll or slide, uneven ground, sprung rollers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.observables.attachment import Motion
from mbs_ref.observables.contact_gap import rolling_slip
from mbs_ref.scene import CoordinateDrive, PlanarBody, Revolute, Scene
from mbs_ref.scene.signals import Constant
from mbs_ref.scenes.tracked_vehicle import AHEAD, BUMP_HALF_WIDTH, SLOPE_RUN, foot
from mbs_ref.scenes.tracked_vehicle.running_gear import DATA
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

rolls = 0.02  # of the link's speed
WHEELS = ("idler", "roller1", "roller2", "roller3")


def profile(x: float, ground: str, height: float, front: float) -> float:
    """Return the ground's height (m) at x (m)."""
    s = x - front - AHEAD
    if ground == "bump" and 0.0 < s < 2.0 * BUMP_HALF_WIDTH:
        radius = (BUMP_HALF_WIDTH**2 + height**2) / (2.0 * height)
        return height - radius + math.sqrt(radius**2 - (s - BUMP_HALF_WIDTH) ** 2)
    if ground == "slope":
        return max(0.0, s * height / SLOPE_RUN)
    return height if ground == "step" and s > 0.0 else 0.0


def drive(t_end: float, **parameters):
    scene = scenes.make("tracked_vehicle", **parameters)
    path = simulate(scene, Settings(method="rk4", step=1e-4, t_end=t_end, samples=101, estimate="off"))
    assert path.ok, path.message
    return scene, path


def test_wheels_roll_by_default_and_stand_still_in_the_papers_model():
    scene, path = drive(0.8)
    bare, sliding = drive(0.1, model="paper")
    for wheel in WHEELS:
        slip = rolling_slip(Motion(scene, path), wheel)
        assert np.isfinite(slip).sum() > 40
        assert np.nanpercentile(np.abs(slip), 90) < rolls
        assert np.abs(sliding.angular_velocity[:, bare.body_index(wheel)]).max() < 1e-12
    assert "slides" in bare.description
    assert "slides" not in scene.description


def test_the_description_states_pins_and_rolling_resistance():
    plain, rubber = (scenes.make("tracked_vehicle", start="drawn", **more).description
                     for more in ({}, {"pins": "rubber", "rolling": 0.02}))  # fmt: skip
    assert "30 links with rubber pins on flat ground. Rolling resistance is 0.02 of a wheel's load." in rubber
    assert "30 links on flat ground." in plain
    assert "olling" not in plain


def test_slip_of_a_wheel_driven_at_a_known_rate():
    """A wheel of radius r held above a surface that passes at v turns at w: its slip is w r / v - 1."""
    radius, speed, turning = 0.25, 2.0, 9.0
    at = {"mass": 1.0, "inertia": 1.0}
    bodies = (
        PlanarBody(name="wheel", position=(0.0, radius), angular_velocity=-turning, **at),
        PlanarBody(name="belt", position=(0.0, -1.0), velocity=(-speed, 0.0), **at),
    )
    model = scenes.make("tracked_vehicle", links=20, start="drawn")
    contact = next(c for c in model.contacts if c.name == "idler.link0").model_copy(
        update={"body_a": "wheel", "body_b": "belt", "center": (0.0, radius), "radius": radius + 1e-3,
                "point_1": (-1.0, 0.0), "point_2": (1.0, 0.0), "extent": "line", "friction": None}
    )  # fmt: skip
    axle = Revolute(name="axle", body_a="ground", body_b="wheel", point=(0.0, radius))
    rails = (_held("belt", "x", -speed), _held("belt", "y"), _held("belt", "angle"))
    scene = Scene(name="belt", bodies=bodies, joints=(axle, *rails), contacts=(contact,))
    path = simulate(scene, Settings(t_end=0.1, samples=5, estimate="off"))
    assert rolling_slip(Motion(scene, path), "wheel") == pytest.approx(turning * radius / speed - 1.0, abs=0.005)


def _held(body: str, coordinate, speed: float = 0.0) -> CoordinateDrive:
    return CoordinateDrive(
        name=f"{body}.{coordinate}", body=body, coordinate=coordinate, level="velocity", motion=Constant(value=speed)
    )


@pytest.mark.parametrize(("ground", "height"), [("flat", 0.02), ("bump", 0.05), ("slope", 0.1), ("step", 0.025)])
def test_a_foot_rests_on_the_drawn_ground(ground, height):
    """A foot that may only sink stands a radius off the profile, less its own sag."""
    start = {"flat": 0.2, "bump": 0.8, "slope": 1.0, "step": 2.0}[ground]
    above = 0.03 * math.hypot(1.0, height if ground == "slope" else 0.0)  # m, a foot's radius across the surface
    body = PlanarBody(name="link", mass=1.0, inertia=1.0, position=(start, profile(start, ground, height, 0.0) + above))
    parts = tuple(foot("foot", "link", body.position, "progressive", "hard", ground, height, 0.0))
    upright = (_held("link", "x"), _held("link", "angle"))
    scene = Scene(name="foot", bodies=(body,), joints=upright, contacts=parts, gravity=(0.0, -9.81))
    path = simulate(scene, Settings(t_end=0.05, samples=6, estimate="off"))
    assert path.ok, path.message
    assert np.abs(path.position[:, 0, 1] - body.position[1]).max() < 3e-5  # m: twice m g / k


@pytest.mark.parametrize("soil", ["dry_sand", "clay"])
def test_a_foot_sinks_as_bekkers_law_says(soil):
    """p = (k_c / b + k_phi) z^n over half a link's sole bears the weight; released at that depth it stays there."""
    data, sole, mass = DATA["soils"][soil], DATA["soils"]["sole"], 90.0
    pressure = mass * 9.81 / (sole["width"] * sole["length"])
    depth = (pressure / (data["k_c"] / sole["width"] + data["k_phi"])) ** (1.0 / data["n"])
    body = PlanarBody(name="link", mass=mass, inertia=1.0, position=(0.0, 0.03 - depth))
    parts = tuple(foot("foot", "link", (0.0, 0.03 - depth), "progressive", soil, "flat", 0.02, 0.0))
    upright = (_held("link", "x"), _held("link", "angle"))
    scene = Scene(name="foot", bodies=(body,), joints=upright, contacts=parts, gravity=(0.0, -9.81))
    path = simulate(scene, Settings(t_end=1.0, samples=6, estimate="off"))
    assert path.ok, path.message
    assert depth > 0.001  # m
    assert np.abs(path.position[:, 0, 1] - body.position[1]).max() < 1e-10


@pytest.mark.slow
def test_a_vehicle_rests_in_sand():
    scene = scenes.make("tracked_vehicle", torque=0.0, soil="dry_sand")
    path = simulate(scene, Settings(t_end=10.0, samples=11, estimate="off"))
    assert path.ok, path.message
    assert np.abs(path.position - path.position[:1]).max() < 1e-9  # m
    feet = [path.contacts[part.name][0] for part in scene.contacts if part.body_b == "ground"]
    assert sum(foot[2] for foot in feet) == pytest.approx(9.81 * sum(body.mass for body in scene.bodies))
    assert 0.02 < max(foot[0] for foot in feet) < 0.06


@pytest.mark.slow
def test_a_slope_pitches_the_hull_by_its_angle():
    height = 0.1
    scene, path = drive(1.9, suspension=True, ground="slope", height=height)
    level, flat = drive(1.9, suspension=True)
    hull = scene.body_index("chassis")
    pitch = path.orientation[-5:, hull].mean() - flat.orientation[-5:, level.body_index("chassis")].mean()
    assert math.degrees(pitch) == pytest.approx(math.degrees(math.atan(height)), abs=0.6)


def test_a_vehicle_without_torque_rests():
    """Ground bears the weight, both runs of the track are tight, and nothing moves for five seconds."""
    scene = scenes.make("tracked_vehicle", torque=0.0)
    path = simulate(scene, Settings(t_end=5.0, samples=11, estimate="off"))
    assert path.ok, path.message
    assert np.abs(path.position - path.position[:1]).max() < 1e-9  # m
    feet = sum(path.contacts[part.name][0, 2] for part in scene.contacts if part.body_b == "ground")
    assert feet == pytest.approx(9.81 * sum(body.mass for body in scene.bodies), rel=1e-9)
    tension = [np.hypot(*path.reactions[name][0, :2]) for name in ("pin10", "pin25")]
    assert tension == pytest.approx([5000.0, 5000.0], rel=0.1)  # N: half of the preload, less what the idler gives


def test_wound_torsion_bars_bear_the_hull():
    """The arms' bars balance the hull where it is drawn: it sinks by the sprocket's and idler's share alone."""
    hulls = [scenes.make("tracked_vehicle", links=20, suspension=sprung).bodies[0] for sprung in (False, True)]
    assert hulls[1].position[1] == pytest.approx(hulls[0].position[1], abs=4e-3)


def test_wheels_on_constraints_go_as_those_on_stiff_springs():
    """No depth at the wheels; on springs, first slack, the hull sinks by up to twice m g / k on three rollers."""
    scene, held = drive(0.05, model="paper", law="constraint")
    _, soft = drive(0.05, model="paper")
    hull = scene.body_index("chassis")
    depths = [held.contacts[part.name][:, 0] for part in scene.contacts if part.law.HOLDS]
    closed = [held.contacts[part.name][:, 1:3].any(axis=1) for part in scene.contacts if part.law.HOLDS]
    assert max(float(np.abs(d[c]).max()) for d, c in zip(depths, closed, strict=True) if c.any()) < 1e-11
    borne = sum(body.mass for body in scene.bodies if not body.name.startswith("link"))
    sag = 2.0 * 9.81 * borne / (3.0 * DATA["contact"]["link_wheel"]["k"])  # m
    lower = held.position[:, hull, 1] - soft.position[:, hull, 1]
    assert 0.1 * sag < lower[-1] < sag
    assert np.abs(held.position[:, hull, 0] - soft.position[:, hull, 0]).max() < sag


@pytest.mark.parametrize(
    ("chosen", "words"),
    [({"law": "constraint"}, r"wheel_friction = 0\.4 must be 0 with law = 'constraint'"),
     ({"model": "paper", "start": "equilibrium"}, r"start = 'equilibrium' does not go with model = 'paper'")],
)  # fmt: skip
def test_choices_that_contradict_each_other_are_refused(chosen, words):
    with pytest.raises(ValueError, match=words):
        scenes.make("tracked_vehicle", **chosen)


def test_a_step_higher_than_a_foot_is_refused():
    with pytest.raises(ValueError, match="of a step must not exceed half a link"):
        scenes.make("tracked_vehicle", ground="step", height=0.05)


def test_rubber_pins_rest_strained_and_without_hinges():
    """The drawn links are bent where they go round; the torsion springs are unstrained in a line."""
    drawn = scenes.make("tracked_vehicle", pins="rubber", start="drawn", torque=0.0)
    hinged = scenes.make("tracked_vehicle", start="drawn", torque=0.0)
    assert len(drawn.joints) == len(hinged.joints) - 30
    turns = [load for load in drawn.loads if load.name.endswith(".turn")]
    angle: dict[str, float] = {body.name: getattr(body, "angle", 0.0) for body in drawn.bodies}
    bent = [abs(angle[x.body_b] - angle[x.body_a] - getattr(x, "rest_angle", 0.0)) for x in turns]
    assert max(bent) == pytest.approx(2.0 * np.pi / 10)  # a tooth's pitch, and never a whole turn
    assert sum(bent) == pytest.approx(2.0 * np.pi)


@pytest.mark.slow
def test_a_vehicle_on_rubber_pins_rests_in_its_equilibrium():
    scene = scenes.make("tracked_vehicle", pins="rubber", torque=0.0)
    path = simulate(scene, Settings(estimate="off", reactions=False, t_end=10.0), np.linspace(0.0, 10.0, 6))
    assert np.abs(path.position - path.position[0]).max() < 1e-9  # m


def test_rolling_resistance_of_the_wheels_takes_a_lever_of_their_radius():
    scene = scenes.make("tracked_vehicle", rolling=0.05, start="drawn")
    levers = {c.name: c.friction.lever / c.radius for c in scene.contacts if hasattr(c.friction, "lever")}
    assert list(levers.values()) == pytest.approx([0.05] * len(levers))
    assert len(levers) == 4 * 30
    with pytest.raises(ValueError, match=r"rolling = 0\.05 requires wheel_friction"):
        scenes.make("tracked_vehicle", rolling=0.05, wheel_friction=0.0)
