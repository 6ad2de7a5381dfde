"""Contact with located events: order of convergence, exact restitution, balances, refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cross_checks.truths import seek_truth
from cross_checks.truths.of.bouncing import impact
from cross_checks.truths.truth import Truth
from mbs_ref import scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.observables import energy_balance, momentum_drift
from mbs_ref.scene import PlanarBody, Scene
from mbs_ref.scene.contact import CircleOnLine, ProgressiveLaw, RigidLaw, SpringDamperLaw
from mbs_ref.scene.toml import dumps, loads
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.simulate.linearised import stiffness
from mbs_ref.trajectory import Status

FINE = Settings(method="dop853", rtol=1e-12, estimate="off")
LAWS = {
    "spring_damper": {}, "spring_damper_force": {}, "progressive": {"damping": 3e4},
    "hunt_crossley": {"stiffness": 1e6, "damping": 3e5}, "lankarani_nikravesh": {"stiffness": 1e6},
    "flores": {"stiffness": 1e6}, "rigid": {},
}  # fmt: skip


def _restitution(law: str, settings: Settings, **parameters) -> float:
    trajectory = simulate(scenes.make("bouncing_ball", law=law, **parameters), settings)
    assert trajectory.ok, trajectory.message
    return float(trajectory.velocity[-1, 0, 1])


def _errors(law: str, events: str, counts: tuple[int, ...], **parameters) -> np.ndarray:
    ball = scenes.make("bouncing_ball", law=law, **parameters)
    exact = impact(ball.contacts[0].law, 1.0, 1.0).restitution
    rk4 = Settings(method="rk4", step=0.4, events=events, refuse_unstable=False, estimate="off")  # type: ignore[arg-type]
    settings = [rk4.model_copy(update={"step": 0.4 / n}) for n in counts]
    return np.array([abs(_restitution(law, each, **parameters) - exact) for each in settings])


@pytest.mark.parametrize("law", ["spring_damper", "progressive"])
def test_located_events_restore_the_order_of_rk4(law):
    errors = _errors(law, "located", (375, 1500, 6000), **LAWS[law])
    assert np.all(np.log(errors[:-1] / errors[1:]) / np.log(4.0) > 3.7)
    assert _errors(law, "located", (24_000,), **LAWS[law])[0] < 1e-11


@pytest.mark.parametrize(
    ("law", "order"), [("spring_damper", 1.0), pytest.param("progressive", 2.0, marks=pytest.mark.slow)]
)
def test_without_events_the_order_is_lost(law, order):
    """Averaged over where in a step touch-down and lift-off fall: this alone decides the sign of the error."""

    def mean(count: int) -> float:
        counts = [count + k * count // 11 for k in range(6)]
        heights = [0.1 + phase * 0.4 / count for phase in (0.05, 0.3, 0.55, 0.8)]
        return float(np.mean([_errors(law, "none", (c,), height=h, **LAWS[law])[0] for c in counts for h in heights]))

    observed = math.log(mean(400) / mean(3200)) / math.log(8.0)
    assert observed == pytest.approx(order, abs=0.35)


@pytest.mark.parametrize("law", LAWS)
def test_restitution_of_every_law_is_exact(law):
    ball = scenes.make("bouncing_ball", law=law, **LAWS[law])
    exact = impact(ball.contacts[0].law, 1.0, 1.0).restitution
    assert _restitution(law, FINE, **LAWS[law]) == pytest.approx(exact, abs=1e-9)


def test_nominal_restitutions_are_not_returned():
    """Published damping factors aim at 0.5 and return these."""
    assert _restitution("lankarani_nikravesh", FINE, stiffness=1e6) == pytest.approx(0.725, abs=1e-3)
    assert _restitution("flores", FINE, stiffness=1e6) == pytest.approx(0.470, abs=1e-3)


@pytest.mark.parametrize(
    "settings",
    [
        FINE,
        Settings(method="radau", rtol=1e-10),
        Settings(method="lsodar", rtol=1e-11),
        Settings(method="radau", step=2e-4),
        Settings(method="generalized_alpha", step=2e-5),
    ],
)
def test_every_integrator_locates(settings):
    tolerance = 1e-6 if settings.method == "generalized_alpha" else 1e-9  # the former is of order 2
    exact = impact(scenes.make("bouncing_ball").contacts[0].law, 1.0, 1.0).restitution
    assert _restitution("spring_damper", settings) == pytest.approx(exact, abs=tolerance)


def test_a_moving_finite_seat_keeps_momentum_and_order():
    scene = scenes.make("ball_on_moving_seat", offset=0.48)
    truth = simulate(scene, FINE)
    runs = [simulate(scene, Settings(method="rk4", step=h, estimate="off")) for h in (2e-3, 5e-4)]
    errors = [np.abs(run.position[-1] - truth.position[-1]).max() for run in runs]
    assert math.log(errors[0] / errors[1]) / math.log(4.0) > 3.3
    drift = momentum_drift(scene, truth)
    assert drift is not None
    assert drift.max() < 1e-13


def test_stop_distance_rolling_and_incline():
    slid = simulate(scenes.make("sliding_block"), FINE)
    assert slid.position[-1, 0, 0] == pytest.approx(4.0 / (2 * 0.3 * 9.81), abs=1e-5)  # the tilt relaxes after the stop
    assert abs(slid.velocity[-1, 0, 0]) < 1e-10
    assert simulate(scenes.make("rolling_disc"), FINE).velocity[-1, 0, 0] == pytest.approx(2 * 2 / 3, abs=1e-9)
    sphere = simulate(scenes.make("rolling_disc", inertia_factor=0.4), FINE)
    assert sphere.velocity[-1, 0, 0] == pytest.approx(2 * 5 / 7, abs=1e-9)
    slip = simulate(scenes.make("incline", angle=0.4), FINE)
    pull = 9.81 * (math.sin(0.4) - 0.3 * math.cos(0.4))
    assert slip.position[-1, 0, 0] == pytest.approx(0.5 * pull * 1.5**2, abs=1e-9)
    stick = simulate(scenes.make("incline"), FINE)
    assert abs(stick.velocity[-1, 0, 0]) < 1e-10


@pytest.mark.parametrize("rtol", [1e-7, 1e-9, 1e-10])
def test_radau_reaches_the_end_of_sliding_where_friction_turns_within_a_step(rtol):
    scene = scenes.make("rolling_sphere")
    run = simulate(scene, Settings(method="radau", rtol=rtol, estimate="off"))
    truth = simulate(scene, FINE)
    assert run.status is Status.SUCCESS, run.message
    assert run.event_times[0, 0] == pytest.approx(truth.event_times[0, 0], abs=100.0 * rtol)


def test_oblique_impact_takes_the_sliding_impulse():
    after = simulate(scenes.make("oblique_disc"), FINE).velocity[-1, 0]
    assert after[0] == pytest.approx(3.0 - 0.2 * (1.0 + after[1]), abs=1e-10)


def test_cradle_and_walls():
    cradle = simulate(scenes.make("newtons_cradle"), FINE)
    assert cradle.velocity[-1, :, 0] == pytest.approx([0.0, 0.0, 0.0, 0.0, 1.0], abs=1e-12)
    scene = scenes.make("disc_between_walls")
    run = simulate(scene, FINE.model_copy(update={"t_end": 2 * (0.8 / 5.0 + math.pi * math.sqrt(1e-5))}))
    assert run.position[-1, 0] == pytest.approx([0.5, 0.0], abs=1e-9)


def test_stack_rests_on_its_static_sink():
    heights = simulate(scenes.make("box_stack"), FINE).position[-1, :, 1]
    assert heights == pytest.approx([0.1 - 1.4715e-5, 0.3 - 2.4525e-5, 0.5 - 2.943e-5], abs=1e-9)


def test_a_ball_at_rest_exactly_at_the_surface():
    still = simulate(scenes.make("bouncing_ball", height=0.0, speed=0.0), FINE)
    assert np.all(still.position[:, 0, 1] == 0.05)
    sunk = simulate(scenes.make("bouncing_ball", height=0.0, speed=0.0, gravity=9.81, duration=3.0), FINE)
    assert sunk.position[-1, 0, 1] == pytest.approx(0.05 - 9.81e-4, abs=1e-10)


def test_a_fast_ball_does_not_pass_a_thin_plate():
    plate = scenes.make(
        "bouncing_ball", speed=50.0, plate=0.01, height=0.1234567, stiffness=1e8, damping=100.0, duration=0.05
    )
    exact = 50.0 * impact(plate.contacts[0].law, 1.0, 50.0).restitution
    assert simulate(plate, FINE).velocity[-1, 0, 1] == pytest.approx(exact, rel=1e-8)
    refused = simulate(plate, Settings(method="rk4", step=1e-3))
    assert refused.status is Status.REFUSED
    assert "0.00028" in refused.message


@pytest.mark.parametrize(
    ("name", "chosen", "words"),
    [("box_stack", {"boxes": 200, "ratio": 3.0}, r"box_stack.*lowest body would sink by 1\.3\d*e\+90 m"),
     ("block_stack", {"blocks": 1, "mass": 1e6, "stiffness": 1e7, "gravity": 10.0}, r"0\.5 m, its height is 0\.2 m"),
     ("block_stack", {"blocks": 50, "ratio": 0.333}, r"block_stack.*highest body weighs 3\.9\d*e-23 N, which")],
)  # fmt: skip
def test_a_stack_that_double_precision_or_its_own_weight_forbids_is_refused(name, chosen, words):
    with pytest.raises(ValueError, match=words):
        scenes.make(name, **chosen)


def test_heavy_on_light_agrees_between_methods_and_is_refused_where_unstable():
    scene = scenes.make("box_stack", boxes=2, ratio=1e4)
    a, b = simulate(scene, FINE), simulate(scene, Settings(method="radau", rtol=1e-9))
    assert a.position[-1] == pytest.approx(b.position[-1], abs=1e-7)
    assert simulate(scene, Settings(method="rk4", step=1e-3)).status is Status.REFUSED


@pytest.mark.parametrize("height", [0.01, 0.05, 0.2, 0.45])
def test_a_sliding_block_of_any_height_stops_where_its_friction_has_taken_its_energy(height):
    """Friction is mu m g in all, however the corners share it, so that the block slides v^2 / (2 mu g)."""
    block = scenes.make("sliding_block", height=height)
    run = simulate(block, FINE)
    speed, friction = block.bodies[0].velocity[0], block.contacts[0].friction.coefficient
    assert run.ok, run.message
    assert run.position[-1, 0, 0] - run.position[0, 0, 0] == pytest.approx(speed**2 / (2 * 9.81 * friction), rel=1e-4)
    assert np.abs(run.velocity[-1]).max() < 1e-3 * speed


def test_eigenvalues_of_a_closed_contact():
    system = compile_scene(scenes.make("bouncing_ball", height=0.0))
    y = system.initial_state()
    system.start_contacts(0.0, y, True)
    found = stiffness(system, 0.0, y)
    assert found.fastest == pytest.approx(100.0, rel=1e-6)  # sqrt(k/m)
    assert found.fastest_decay == pytest.approx(20.0, rel=1e-6)  # c / 2m
    assert (found.oscillation_rule, found.damping_rule) == pytest.approx((0.01, 0.025))


def test_a_short_contact_inside_one_step_is_seen():
    """A stiff floor sends the ball back within a step of 20 ms, in 1 ms: both ends of the step are in the air."""
    ball = scenes.make("bouncing_ball", stiffness=1e7, damping=0.0, height=0.0504)
    run = simulate(ball, Settings(method="rk4", step=2e-2, refuse_unstable=False))
    truth = seek_truth(ball, run.times)
    assert isinstance(truth, Truth)
    assert run.events == 2
    assert run.estimate is not None  # a step in 60 radians of the contact's oscillation: the rebound is another
    assert np.abs(run.position - truth.position).max() < run.estimate.value * run.estimate.length
    fine = simulate(ball, FINE, run.times)
    assert np.abs(fine.position - truth.position).max() < 1e-9
    with pytest.raises(ValueError, match="speed at touch-down"):
        simulate(scenes.make("bouncing_ball", law="flores"), Settings(method="rk4", step=1e-3, events="none"))


def test_of_two_short_touches_inside_one_step_neither_is_missed():
    """Two balls graze a ceiling at 1 m above, at 0.1 and 0.3 s of one step of 0.5 s, each 1 mm short of its summit."""
    speeds, summit = {"low": 1.0, "high": 3.0}, 1e-3  # m/s upwards; m beyond the ceiling, were it not there
    places = {name: (x, 0.9 - speed**2 / 19.62 + summit) for x, (name, speed) in enumerate(speeds.items())}
    balls = [
        PlanarBody(name=name, mass=1.0, inertia=0.1, position=places[name], velocity=(0.0, speeds[name]))
        for name in speeds
    ]
    ceilings = [
        CircleOnLine(
            name=name, law=RigidLaw(restitution=1.0), body_a=name, center=places[name], radius=0.1, body_b="ground",
            point_1=(9.0, 1.0), point_2=(-9.0, 1.0),
        )
        for name in speeds
    ]  # fmt: skip
    scene = Scene(
        name="ceiling", duration=0.5, gravity=(0.0, -9.81), bodies=tuple(balls), contacts=tuple(ceilings),
    )  # fmt: skip
    run = simulate(scene, Settings(method="rk4", step=0.5, samples=2, estimate="off"))
    fall = math.sqrt(2.0 * 9.81 * summit)  # m/s, at the ceiling
    touches = [(speed - fall) / 9.81 for speed in speeds.values()]
    assert run.event_times is not None
    assert sorted(set(np.round(run.event_times[:, 0], 9))) == pytest.approx(touches, abs=1e-9)
    assert run.velocity[-1, :, 1] == pytest.approx([-fall - 9.81 * (0.5 - t) for t in touches], abs=1e-9)


def test_reported_forces_balance_the_energy():
    scene = scenes.make("bouncing_ball", damping=0.0)
    run = simulate(scene, FINE.model_copy(update={"samples": 4001}))
    balance = energy_balance(scene, run)
    assert balance.drift is not None
    assert np.abs(balance.drift).max() < balance.resolution < 2e-4  # J, of 0.5: what 4000 samples of a power resolve
    assert run.contacts["floor"][:, 0].max() == pytest.approx(0.01, rel=1e-3)  # v0 sqrt(m/k)


def test_contacts_go_through_toml_and_refuse_nonsense():
    scene = scenes.make("tracked_vehicle", links=20, start="drawn")
    assert loads(dumps(scene)) == scene
    ball = PlanarBody(name="ball", mass=1.0, inertia=1.0)
    line = {"name": "floor", "body_a": "ball", "center": (0.0, 1.0), "radius": 1.0, "point_1": (0.0, 0.0)}
    with pytest.raises(ValueError, match="no direction"):
        CircleOnLine(**line, point_2=(0.0, 0.0), law=ProgressiveLaw(stiffness=1.0))  # type: ignore[arg-type]
    floor = CircleOnLine(**line, point_2=(1.0, 0.0), law=SpringDamperLaw(stiffness=1.0))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="names must differ"):
        Scene(name="twice", bodies=(ball,), contacts=(floor, floor))


def test_tracked_vehicle_drives_alike_under_three_integrators():
    scene = scenes.make("tracked_vehicle", model="paper")
    short = {"t_end": 0.1, "samples": 5, "reactions": False, "estimate": "off"}
    fine = simulate(scene, Settings(method="dop853", rtol=1e-9, **short))
    rk4 = simulate(scene, Settings(method="rk4", step=1e-4, **short))
    lsodar = simulate(scene, Settings(method="lsodar", rtol=1e-8, **short))
    assert all(run.ok for run in (fine, rk4, lsodar))
    assert fine.step_compliance is not None
    assert fine.step_compliance[:, 1].max() < 1e-12
    assert np.abs(rk4.position[-1] - fine.position[-1]).max() < 1e-6
    assert np.abs(lsodar.position[-1] - fine.position[-1]).max() < 1e-4
