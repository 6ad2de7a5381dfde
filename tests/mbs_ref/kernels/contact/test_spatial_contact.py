"""Contact in space with located events: order, restitution, friction in the tangent plane, balances, refusals."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from cross_checks.truths import seek_truth
from cross_checks.truths.of.bouncing import impact
from cross_checks.truths.of.sliding import stop_of_slip
from cross_checks.truths.truth import Truth
from mbs_ref import scenes
from mbs_ref.observables import energy_balance, momentum_drift
from mbs_ref.scene import Scene, SpatialBody
from mbs_ref.scene.contact import (
    RegularisedCoulomb,
    RigidLaw,
    SphereOnPlane,
    SphereOnSphere,
    SpringDamperLaw,
    StickSlip,
)
from mbs_ref.scene.toml import dumps, loads
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Status, Trajectory

FINE = Settings(method="dop853", rtol=1e-12, estimate="off")
LAWS = {
    "spring_damper": {}, "spring_damper_force": {}, "progressive": {"damping": 3e4},
    "hunt_crossley": {"stiffness": 1e6, "damping": 3e5}, "lankarani_nikravesh": {"stiffness": 1e6},
    "flores": {"stiffness": 1e6}, "rigid": {},
}  # fmt: skip
G = 9.81  # m/s^2
LAW = SpringDamperLaw(stiffness=1e5, damping=200.0, release="force")
BALL = (0.004, 0.004, 0.004, 0.0, 0.0, 0.0)  # kg m^2, a sphere of 1 kg and 0.1 m


def _run(scene: Scene, settings: Settings = FINE, **update) -> Trajectory:
    trajectory = simulate(scene, settings.model_copy(update=update))
    assert trajectory.ok, trajectory.message
    return trajectory


def _restitution(scene: Scene, settings: Settings = FINE) -> float:
    normal = np.array(scene.contacts[0].normal)
    return float(_run(scene, settings).velocity[-1, 0] @ normal)


def _exact(scene: Scene) -> float:
    return impact(scene.contacts[0].law, 1.0, 1.0).restitution


def _errors(law: str, events: str, counts: tuple[int, ...], **parameters) -> np.ndarray:
    ball = scenes.make("bouncing_sphere", law=law, **parameters)
    rk4 = Settings(method="rk4", step=0.4, events=events, refuse_unstable=False, estimate="off")  # type: ignore[arg-type]
    settings = [rk4.model_copy(update={"step": 0.4 / n}) for n in counts]
    return np.array([abs(_restitution(ball, each) - _exact(ball)) for each in settings])


@pytest.mark.parametrize("law", ["spring_damper", "progressive"])
def test_located_events_restore_the_order_of_rk4(law):
    errors = _errors(law, "located", (375, 1500, 6000), **LAWS[law])
    assert np.all(np.log(errors[:-1] / errors[1:]) / np.log(4.0) > 3.6)
    assert np.log(errors[0] / errors[-1]) / np.log(16.0) > 3.7
    assert _errors(law, "located", (24_000,), **LAWS[law])[0] < 1e-11


@pytest.mark.parametrize(
    ("law", "order"), [("spring_damper", 1.0), pytest.param("progressive", 2.0, marks=pytest.mark.slow)]
)
def test_without_events_the_order_is_lost(law, order):
    """Averaged over where in a step touch-down and lift-off fall."""

    def mean(count: int) -> float:
        counts = [count + k * count // 11 for k in range(6)]
        heights = [0.1 + phase * 0.4 / count for phase in (0.05, 0.3, 0.55, 0.8)]
        return float(np.mean([_errors(law, "none", (c,), height=h, **LAWS[law])[0] for c in counts for h in heights]))

    assert math.log(mean(400) / mean(3200)) / math.log(8.0) == pytest.approx(order, abs=0.35)


@pytest.mark.parametrize("law", LAWS)
def test_restitution_of_every_law_is_exact(law):
    ball = scenes.make("bouncing_sphere", law=law, **LAWS[law])
    assert _restitution(ball) == pytest.approx(_exact(ball), abs=1e-9)


@pytest.mark.parametrize(
    "settings",
    [Settings(method="radau", rtol=1e-10), Settings(method="lsodar", rtol=1e-11)],
    ids=lambda settings: settings.method,
)
def test_every_integrator_locates(settings):
    ball = scenes.make("bouncing_sphere")
    assert _restitution(ball, settings) == pytest.approx(_exact(ball), abs=1e-9)


@pytest.mark.parametrize("spin", [0.0, 15.0])
@pytest.mark.parametrize("settings", [FINE, Settings(method="rk4", step=1e-3)], ids=lambda s: s.method)
def test_a_sphere_slides_then_rolls_at_five_sevenths(settings, spin):
    scene = scenes.make("rolling_sphere", spin=spin)
    run = _run(scene, settings)
    truth = seek_truth(scene, run.times)
    assert isinstance(truth, Truth)
    assert np.abs(run.position - truth.position).max() < 1e-10
    assert np.abs(np.abs(np.sum(run.orientation * truth.orientation, axis=2)) - 1.0).max() < 1e-10
    end, _, final = stop_of_slip(scene)
    assert run.event_times is not None
    turning = 1e-8 if spin == 0.0 else 1e-5  # s: numerical errors turn the last of the slip about
    assert run.event_times[-1, 0] == pytest.approx(end, abs=turning)
    assert run.velocity[-1, 0] == pytest.approx(final, abs=1e-10)
    if spin == 0.0:
        assert np.linalg.norm(run.velocity[-1, 0]) == pytest.approx(2.0 * 5.0 / 7.0, abs=1e-10)


@pytest.mark.parametrize("rtol", [1e-6, 1e-7])
def test_the_end_of_sliding_is_one_event(rtol):
    """Errors of Newton's iteration turn the last of the slip about, which is no event."""
    scene = scenes.make("rolling_sphere")
    run = _run(scene, Settings(method="radau", rtol=rtol))
    assert run.event_times is not None
    assert run.event_times[:, 0].tolist() == pytest.approx([stop_of_slip(scene)[0]], abs=1e-7)


def _plate(heading: float, angle: float, speed: float = 0.0, friction: float = 0.3) -> Scene:
    """A plate on four corners level with its centre of mass, on an incline: friction makes no moment."""
    normal = G * math.cos(angle)
    depth = normal / 4e5  # m, 1 kg
    direction = np.array([math.cos(heading), math.sin(heading), 0.0])
    gravity = G * math.sin(angle) * direction - np.array([0.0, 0.0, normal])
    grip = StickSlip(coefficient=friction, stiffness=1e5, damping=200.0)
    corners = [(x, y, -depth) for x in (-0.2, 0.2) for y in (-0.1, 0.1)]
    return Scene(
        name="plate", gravity=tuple(gravity.tolist()),
        bodies=(
            SpatialBody(name="plate", mass=1.0, inertia=(0.004, 0.014, 0.018, 0.0, 0.0, 0.0),
                        position=(0.0, 0.0, -depth), velocity=tuple((speed * direction).tolist())),
        ),
        contacts=tuple(
            SphereOnPlane(name=f"corner{k}", body_a="plate", center=corner, radius=0.0, point=(0.0, 0.0, 0.0),
                          normal=(0.0, 0.0, 1.0), law=LAW, friction=grip)
            for k, corner in enumerate(corners)
        ),
    )  # fmt: skip


@pytest.mark.parametrize("heading", [0.0, 2.2])
def test_a_plate_sticks_below_the_angle_of_friction_and_slides_above_it(heading):
    stuck = _run(_plate(heading, 0.2))
    assert np.abs(stuck.velocity[-1]).max() < 1e-10
    slid = _run(_plate(heading, 0.4))
    pull = G * (math.sin(0.4) - 0.3 * math.cos(0.4))
    assert slid.position[-1, 0, :2] == pytest.approx(
        [0.5 * pull * math.cos(heading), 0.5 * pull * math.sin(heading)], abs=1e-9
    )


def test_a_thrown_plate_stops_after_its_stop_distance_and_stays():
    run = _run(_plate(0.9, 0.0, speed=1.0))
    assert np.linalg.norm(run.position[-1, 0, :2]) == pytest.approx(1.0 / (2.0 * 0.3 * G), abs=1e-9)
    assert np.abs(run.velocity[-1]).max() < 1e-10


def test_sliding_across_a_slope_turns_downhill():
    """A particle on a rough incline steeper than friction: energy and friction's work tell its speed."""
    scene = _plate(0.0, 0.5)
    body: Any = scene.bodies[0]
    thrown = scene.model_copy(update={"bodies": (body.model_copy(update={"velocity": (0.0, 2.0, 0.0)}),)})
    run = _run(thrown, samples=2001)
    path = np.sum(np.linalg.norm(np.diff(run.position[:, 0], axis=0), axis=1))
    fall = G * math.sin(0.5) * run.position[-1, 0, 0]
    speed = np.sum(run.velocity[-1] ** 2)
    assert 0.5 * speed == pytest.approx(2.0 + fall - 0.3 * G * math.cos(0.5) * path, abs=1e-6)  # path by chords
    assert run.velocity[-1, 0, 0] > 3.0 * abs(run.velocity[-1, 0, 1])
    assert run.event_times is not None
    assert not len(run.event_times)  # a direction that turns is no event


def _collision(law: Any, friction: Any = None, spin: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Scene:
    scene = scenes.make("colliding_spheres")
    pair = scene.contacts[0].model_copy(update={"law": law, "friction": friction})
    turning = scene.bodies[0].model_copy(update={"angular_velocity": spin})
    return scene.model_copy(update={"contacts": (pair,), "bodies": (turning, scene.bodies[1]), "parameters": {}})


@pytest.mark.parametrize("law", ["rigid", "spring_damper"])
def test_an_oblique_collision_is_exact(law):
    scene = scenes.make("colliding_spheres", law=law)
    run = _run(scene, samples=5)
    truth = seek_truth(scene, run.times)
    assert isinstance(truth, Truth)
    assert np.abs(run.position - truth.position).max() < 1e-10


def test_friction_between_spheres_keeps_momentum_and_only_loses_energy():
    scene = _collision(LAW, RegularisedCoulomb(coefficient=0.3), (3.0, -20.0, 10.0))
    run = _run(scene, samples=3001)
    drift = momentum_drift(scene, run)
    assert drift is not None
    assert drift.max() < 1e-13
    assert np.abs(run.angular_velocity[-1, 1]).max() > 0.1
    balance = energy_balance(scene, run)
    assert balance.drift is not None
    assert np.abs(balance.drift).max() < balance.resolution < 0.02


def test_what_slides_throughout_an_impact_is_pushed_by_coulombs_share():
    """Impulses from the velocities alone: 0.3 of the normal one across it, which turns the other sphere."""
    scene = _collision(LAW, RegularisedCoulomb(coefficient=0.3), (30.0, -200.0, 100.0))
    run = _run(scene, samples=301)
    impulse = run.velocity[0, 0] - run.velocity[-1, 0]  # N s, of 1 kg
    apart = run.position[:, 1] - run.position[:, 0]
    normal = apart[np.argmin(np.linalg.norm(apart, axis=1))]
    normal /= np.linalg.norm(normal)
    across = np.linalg.norm(impulse - (impulse @ normal) * normal)
    assert across == pytest.approx(0.3 * (impulse @ normal), rel=0.03)  # the normal turns, and slip begins at 1 mm/s
    inertia, radius = scene.bodies[1].inertia[0], scene.contacts[0].radius_b
    assert inertia * np.linalg.norm(run.angular_velocity[-1, 1]) == pytest.approx(radius * across, rel=0.03)


def test_a_sphere_lands_on_a_free_plate_of_finite_size():
    """Beyond the edge it misses; a solid corner acts as a point does."""

    def fall(x: float, extent: str, contact: Any = None) -> Trajectory:
        ball = SpatialBody(name="ball", mass=1.0, inertia=BALL, position=(x, x, 0.2), velocity=(0.1, 0.0, -1.0))
        plate = SpatialBody(name="plate", mass=3.0, inertia=(0.3, 0.2, 0.5, 0.0, 0.0, 0.0))
        floor = SphereOnPlane(
            name="floor", body_a="ball", center=ball.position, radius=0.1, body_b="plate", point=(0.0, 0.0, 0.0),
            normal=(0.0, 0.0, 1.0), edge=(1.0, 0.0, 0.0), size=(1.0, 1.0), extent=extent, thickness=0.1, law=LAW,
        )  # fmt: skip
        gravity = (0.0, 0.0, 0.0)
        scene = Scene(name="plate", bodies=(ball, plate), contacts=(contact or floor,), gravity=gravity, duration=0.3)
        run = _run(scene)
        drift = momentum_drift(scene, run)
        assert drift is not None
        assert drift.max() < 1e-13
        return run

    # kg, of ball and plate where they meet: 0.1 s at 0.1 m/s further along x
    mass = 1.0 / (1.0 + 1.0 / 3.0 + 0.3**2 / 0.3 + 0.31**2 / 0.2)
    exact = -1.0 + (1.0 + impact(LAW, mass, 1.0).restitution) * mass
    assert fall(0.3, "rectangle").velocity[-1, 0, 2] == pytest.approx(exact, abs=2e-3)  # the plate tilts meanwhile
    assert fall(0.55, "rectangle").velocity[-1, 0, 2] == -1.0
    corner = SphereOnSphere(
        name="corner", body_a="ball", center_a=(0.53, 0.53, 0.2), radius_a=0.1, body_b="plate",
        center_b=(0.5, 0.5, 0.0), radius_b=0.0, law=LAW,
    )  # fmt: skip
    capped, point = fall(0.53, "capped"), fall(0.53, "capped", corner)
    assert capped.velocity[-1, 0, 2] > -0.9
    assert capped.position[-1] == pytest.approx(point.position[-1], abs=1e-11)


def test_a_row_of_spheres_hands_the_speed_on():
    centers = [(0.0, 0.0, 0.101 * k) for k in range(5)]
    spheres = [
        SpatialBody(name=f"s{k}", mass=1.0, inertia=BALL, position=c, velocity=(0.0, 0.0, 1.0 if k == 0 else 0.0))
        for k, c in enumerate(centers)
    ]
    pairs = [
        SphereOnSphere(name=f"pair{k}", body_a=f"s{k}", center_a=centers[k], radius_a=0.05, body_b=f"s{k + 1}",
                       center_b=centers[k + 1], radius_b=0.05, law=RigidLaw(restitution=1.0))
        for k in range(4)
    ]  # fmt: skip
    scene = Scene(name="row", bodies=tuple(spheres), contacts=tuple(pairs), gravity=(0.0, 0.0, 0.0), duration=0.2)
    assert _run(scene).velocity[-1, :, 2] == pytest.approx([0.0, 0.0, 0.0, 0.0, 1.0], abs=1e-12)


def test_a_sphere_at_rest_exactly_at_the_surface():
    still = _run(scenes.make("bouncing_sphere", height=0.0, speed=0.0, tilt=0.0))
    assert np.all(still.position == still.position[0])
    sunk = _run(scenes.make("bouncing_sphere", height=0.0, speed=0.0, gravity=G, duration=3.0))
    normal = scenes.make("bouncing_sphere").contacts[0].normal
    assert sunk.position[-1, 0] @ normal == pytest.approx(0.05 - 9.81e-4, abs=1e-10)


def test_a_fast_sphere_does_not_pass_a_thin_plate():
    plate = scenes.make(
        "bouncing_sphere", speed=50.0, plate=0.01, height=0.1234567, stiffness=1e8, damping=100.0, duration=0.05
    )
    exact = 50.0 * impact(plate.contacts[0].law, 1.0, 50.0).restitution
    assert _restitution(plate) == pytest.approx(exact, rel=1e-8)
    refused = simulate(plate, Settings(method="rk4", step=1e-3, estimate="off"))
    assert refused.status is Status.REFUSED
    assert "0.00028" in refused.message


def test_heavy_on_light_settles_exactly_and_is_refused_where_unstable():
    scene = scenes.make("block_stack", blocks=2, ratio=1e4)
    run = _run(scene, samples=5)
    truth = seek_truth(scene, run.times)
    assert isinstance(truth, Truth)
    assert np.abs(run.position - truth.position).max() < 1e-9
    assert simulate(scene, Settings(method="rk4", step=1e-3, estimate="off")).status is Status.REFUSED


def test_contacts_go_through_toml_and_refuse_nonsense():
    for name in ("block_stack", "rolling_sphere", "colliding_spheres"):
        scene = scenes.make(name)
        assert loads(dumps(scene)) == scene
    plane: dict[str, Any] = {
        "name": "floor", "body_a": "ball", "center": (0.0, 0.0, 1.0), "radius": 1.0, "point": (0.0, 0.0, 0.0),
        "normal": (0.0, 0.0, 1.0), "law": LAW,
    }  # fmt: skip
    with pytest.raises(ValueError, match="no direction"):
        SphereOnPlane(**plane | {"normal": (0.0, 0.0, 0.0)})
    with pytest.raises(ValueError, match="a rectangle needs size and edge"):
        SphereOnPlane(**plane, extent="rectangle")
    with pytest.raises(ValueError, match="perpendicular"):
        SphereOnPlane(**plane, extent="rectangle", size=(1.0, 1.0), edge=(0.0, 0.1, 1.0))
    with pytest.raises(ValueError, match=r"no force that friction could use; .* or take a law with a force"):
        SphereOnPlane(**plane | {"law": RigidLaw(restitution=1.0)}, friction=RegularisedCoulomb(coefficient=0.1))
    planar = scenes.make("bouncing_ball")
    with pytest.raises(ValueError, match="use circle_on_line"):
        planar.model_copy(update={"contacts": (SphereOnPlane(**plane),)}).model_validate(
            planar.model_dump() | {"contacts": [SphereOnPlane(**plane)]}
        )
