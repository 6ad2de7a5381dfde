"""Springs that go slack, and events that a scene declares."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cross_checks import engines
from mbs_ref import scenes
from mbs_ref.scene import PlanarBody, PointMass, Scene, SpringDamper
from mbs_ref.scene.events import CoordinateEvent, DistanceEvent
from mbs_ref.scene.toml import dumps, loads
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Status

FINE = Settings(method="dop853", rtol=1e-12, estimate="off")


def _tether(damping: float = 0.0, **more) -> Scene:
    """A particle thrown away from ground on a slack tether: free, half an oscillation, free again."""
    spring = SpringDamper(
        name="tether", body_a="ground", body_b="mass", point_a=(0.0, 0.0), point_b=(1.0, 0.0), stiffness=math.pi**2,
        damping=damping, rest_length=2.0, tension_only=True,
    )  # fmt: skip
    mass = PointMass(name="mass", mass=1.0, position=(1.0, 0.0), velocity=(2.0, 0.0))
    return Scene(name="tether", duration=2.0, bodies=(mass,), loads=(spring,), **more)


def _tether_error(count: int, events: str) -> float:
    """The mean over some steps near 2 s / count: where in a step a kink falls decides the error without events."""
    settings = [Settings(method="rk4", step=2.0 / (count + k), events=events) for k in range(0, 12, 3)]  # type: ignore[arg-type]
    return float(np.mean([abs(simulate(_tether(), each).position[-1, 0, 0] - 1.0) for each in settings]))


@pytest.mark.parametrize(("events", "least", "most"), [("located", 3.7, 4.3), ("none", 1.5, 3.2)])
def test_a_tether_that_goes_slack_keeps_the_order_where_its_kinks_are_located(events, least, most):
    """Taut from t = 0.5 to 1.5, back at x = 1 at t = 2."""
    observed = math.log(_tether_error(37, events) / _tether_error(333, events)) / math.log(9.0)
    assert least < observed < most


@pytest.mark.parametrize("method", ["dop853", "radau", "lsodar", "dassl"])
def test_the_kinks_are_events(method):
    run = simulate(_tether(), Settings(method=method, rtol=1e-9, estimate="off"))
    assert run.event_times is not None
    assert run.event_names == ("tether",)
    assert run.event_times[:, 0] == pytest.approx([0.5, 1.5], abs=1e-6)


@pytest.mark.parametrize("name", ["tether", "bouncing_ball", "newtons_cradle"])
def test_an_event_is_found_in_a_few_tries(name):
    """Of four evaluations each, and one afterwards; twenty and more where an event is bracketed by bisection."""
    scene = _tether() if name == "tether" else scenes.make(name)
    run = simulate(scene, Settings(method="rk4", step=scene.duration / 2000.0, samples=2, estimate="off"))
    assert run.ok
    assert run.rhs_calls - 4 * run.steps <= 4 * 5 * run.events + 1


def test_a_located_kink_is_at_its_place_to_the_roundoff_of_the_function():
    """The tether is taut at t = 1/2, at 2 m/s: two margins of 1e-13 of 1 m, and the roundoff of the clock."""
    run = simulate(_tether(), Settings(method="rk4", step=2e-3, estimate="off"))
    assert run.event_times is not None
    assert 0.0 <= run.event_times[0, 0] - 0.5 < 1e-13 + 1e-15


def test_a_damped_tether_lets_go_before_it_is_slack_and_never_pushes():
    fine = simulate(_tether(damping=2.0), FINE)
    plain = simulate(_tether(damping=2.0), FINE.model_copy(update={"events": "none", "rtol": 1e-9}))
    assert fine.events == 3  # taut, let go where the force is zero, slack
    assert np.abs(fine.position[-1] - plain.position[-1]).max() < 1e-6


def test_a_pendulum_reports_where_it_passes():
    pendulum = scenes.make("pendulum")
    name = pendulum.bodies[0].name
    watched = pendulum.model_copy(update={"events": (
        CoordinateEvent(name="lowest", body=name, coordinate="x"),
        CoordinateEvent(name="turns", body=name, coordinate="x", rate=True, crossing="rising"),
    )})  # fmt: skip
    long = FINE.model_copy(update={"t_end": 6.0})
    run, plain = simulate(watched, long), simulate(pendulum, long)
    assert run.event_times is not None
    lowest = run.event_times[run.event_times[:, 1] == 0, 0]
    turns = run.event_times[run.event_times[:, 1] == 1, 0]
    assert len(lowest) > 1
    assert np.abs(run.position - plain.position).max() < 1e-9  # looking changes nothing
    at = np.array([0.0, *lowest])
    assert np.abs(simulate(pendulum, FINE, times=at).position[1:, 0, 0]).max() < 1e-9
    turned = simulate(pendulum, FINE, times=np.array([0.0, *turns]))
    assert np.abs(turned.velocity[1:, 0, 0]).max() < 1e-8
    assert np.all(turned.position[1:, 0, 0] < 0.0)  # on the left alone


@pytest.mark.parametrize(
    "settings",
    [
        FINE,
        Settings(method="rk4", step=1e-2),
        Settings(method="radau", rtol=1e-10),
        Settings(method="lsodar", rtol=1e-11),
        Settings(method="dassl", rtol=1e-9),
    ],
)
def test_a_run_stops_at_a_declared_distance_with_its_state(settings):
    stop = DistanceEvent(name="far", body_a="ground", body_b="ball", point_a=(0.0, 0.0), point_b=(1.0, 0.0),
                         value=2.0, action="stop")  # fmt: skip
    ball = PlanarBody(name="ball", mass=1.0, inertia=1.0, position=(1.0, 0.0), velocity=(1.0, 1.0))
    run = simulate(Scene(name="thrown", duration=5.0, bodies=(ball,), events=(stop,)), settings)
    assert run.status is Status.STOP_EVENT
    assert "'far'" in run.message
    assert math.hypot(*run.position[-1, 0]) == pytest.approx(2.0, abs=1e-9)
    assert run.times[-1] == pytest.approx(0.5 * (math.sqrt(7.0) - 1.0), abs=1e-9)


def test_declared_events_go_through_toml_and_refuse_nonsense():
    event = CoordinateEvent(name="low", body="mass", coordinate="y", crossing="falling", action="stop")
    scene = _tether(events=(event,))
    assert loads(dumps(scene)) == scene
    with pytest.raises(ValueError, match="no body of the scene"):
        _tether(events=(event.model_copy(update={"body": "nobody"}),))
    with pytest.raises(ValueError, match="must be located"):
        simulate(scene, Settings(method="rk4", step=1e-2, events="none", estimate="off"))


@pytest.mark.parametrize("name", ["mujoco", "exudyn", "pinocchio"])
def test_engines_without_events_say_so(name):
    pytest.importorskip(name)
    engine = engines.get(name)
    with pytest.raises(ValueError, match="locates no events"):
        engine.run(scenes.make("pendulum"), Settings(events="located"))
    assert "coordinate_event" in engine.refusals(_tether(events=(CoordinateEvent(
        name="low", body="mass", coordinate="y"),)))[0].reason  # fmt: skip
