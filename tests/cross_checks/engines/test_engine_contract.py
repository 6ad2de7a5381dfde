"""What every engine and each of its methods must do, whatever it is inside."""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
import pytest

from cross_checks import engines
from mbs_ref import scenes
from mbs_ref.observables import rows
from mbs_ref.scene import GROUND, PlanarBody, PointOnPlane, Revolute, Scene, SpatialBody
from mbs_ref.scene.contact import RigidLaw, SphereOnPlane
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Status
from tests.cross_checks.engines.engine_runs import engine, run, settings_of

EXACT_END = np.array([-0.2750874625761, -0.9614192050991])  # m, A01 at t = 10 s, elliptic functions
one_millimetre_drift = 1e-3  # m, allowed to second-order methods at a step of 2.5 ms
LOOSE = {1: 1.5, 2: 2.0 * one_millimetre_drift}  # m, what a first- or second-order method may miss at 2.5 ms


def outside() -> list[str]:
    """Return the engines that other people wrote."""
    return [name for name in ("exudyn", "mujoco", "pinocchio") if name in engines.names()]


def every_method() -> list[tuple[str, str]]:
    found = []
    for name in ("mbs_ref", *outside()):
        try:
            found += [(name, method.name) for method in engines.get(name).methods()]
        except engines.EngineMissing:
            continue
    return found


PACKAGES = {"exudyn": "exudyn", "mujoco": "mujoco", "pinocchio": "pinocchio"}  # engine -> what it is imported as


@pytest.mark.parametrize("name", PACKAGES)
def test_an_engine_that_is_missing_here_is_said_to_be(name):
    """The lists of methods below are made where tests are collected: an engine that is lost leaves no trace there."""
    if find_spec(PACKAGES[name]) is None:
        pytest.skip(f"{name} is not installed")
    assert name in outside()
    assert {method for engine, method in every_method() if engine == name} >= LEAST[name]


LEAST = {  # methods that tests rely on
    "exudyn": {"generalized_alpha", "trapezoidal", "tree_rk44", "tree_rk67", "tree_dopri5"},
    "mujoco": {"rk4", "euler", "implicit", "implicitfast"},
    "pinocchio": {"dop853", "rk4"},
}

each_method = pytest.mark.parametrize(("name", "method"), every_method())
each_engine = pytest.mark.parametrize("name", outside())


@each_method
def test_a_scene_is_refused_with_reasons_or_swings_to_the_exact_end(name, method):
    scene = scenes.make("pendulum")
    chosen = engine(name).method(method)
    result = run(name, method, scene, step=2.5e-3, samples=11, estimate="off")  # the miss is judged here
    if engine(name).method_refusals(scene, chosen):
        assert result.status is Status.REFUSED
        assert result.message
        assert len(result.times) == 0
        return
    if name == "mbs_ref" and chosen.wrong_limit and not result.ok:
        assert "t = " in result.message  # raw index 3: stopping with the reason is what is asked of it
        return
    assert result.ok
    assert result.message == "reached t = 10 s"
    miss = np.linalg.norm(result.position[-1, 0] - EXACT_END)
    assert miss < LOOSE.get(chosen.order or 1, 1e-6)


@each_method
def test_poses_and_velocities_come_at_the_asked_times_in_the_scenes_order(name, method):
    scene = scenes.make("double_pendulum")
    if engine(name).method_refusals(scene, engine(name).method(method)):
        return
    times = np.array([0.0, 0.01, 0.04, 0.1])
    result = engine(name).run(scene, settings_of(name, method, estimate="off"), times)
    if name == "mbs_ref" and method == "dassl_index3":  # raw index 3 must stop, and say when and why
        assert not result.ok
        assert "t = " in result.message
        return
    assert result.ok
    assert np.array_equal(result.times, times)
    assert result.position.shape == result.velocity.shape == (4, 2, 2)
    assert result.orientation.shape == result.angular_velocity.shape == (4, 2)
    for k, body in enumerate(scene.bodies):
        assert result.position[0, k] == pytest.approx(body.position, abs=1e-15)
        assert isinstance(body, PlanarBody)
        assert result.orientation[0, k] == pytest.approx(body.angle, abs=1e-15)
        assert result.velocity[0, k] == pytest.approx(body.velocity, abs=1e-14)
    assert result.timing.loop_s > 0.0
    assert result.steps > 0


@each_method
def test_initial_velocities_of_a_moving_mechanism_are_reproduced(name, method):
    scene = scenes.make("slider_crank")
    if engine(name).method_refusals(scene, engine(name).method(method)):
        return
    result = run(name, method, scene, t_end=2e-3, samples=2)
    for k, body in enumerate(scene.bodies):
        assert result.velocity[0, k] == pytest.approx(body.velocity, abs=1e-13)
        assert isinstance(body, PlanarBody)
        assert result.angular_velocity[0, k] == pytest.approx(body.angular_velocity, abs=1e-13)
    assert np.abs(rows(scene, result.at(slice(1))).rate).max() < 1e-13


@each_engine
def test_methods_are_documented_and_have_ladders(name):
    methods = engine(name).methods()
    assert len({method.name for method in methods}) == len(methods)
    for method in methods:
        assert method.description
        assert list(method.ladder) == sorted(method.ladder, reverse=True)
        assert len(method.ladder) >= 4
    assert engine(name).method(None) is methods[0]
    assert engine(name).version()


@each_engine
def test_an_unknown_method_names_the_allowed(name):
    with pytest.raises(ValueError, match=r"method = 'simplectic' is unknown to .*; allowed: .*rk4"):
        engine(name).run(scenes.make("pendulum"), Settings(method="simplectic"))


@each_engine
@pytest.mark.parametrize(
    ("setting", "value"),
    [("stabilization", "projection"), ("stop_on_compliance", True), ("project_initial", True), ("baumgarte_gain", 3.0)],
)
def test_a_setting_that_is_not_offered_is_an_error(name, setting, value):
    with pytest.raises(ValueError, match=f"{setting} = .* is not offered by {name}; allowed: "):
        engine(name).run(scenes.make("pendulum"), Settings.model_validate({setting: value}))


@pytest.mark.parametrize(("name", "method"), [pair for pair in every_method() if pair[0] != "mbs_ref"])
def test_the_other_kind_of_accuracy_is_an_error(name, method):
    adaptive = engine(name).method(method).kind == "adaptive"
    wrong = {"step": 1e-3} if adaptive else {"rtol": 1e-6}
    with pytest.raises(ValueError, match=f"{next(iter(wrong))}.*: {method} takes "):
        engine(name).run(scenes.make("pendulum"), Settings.model_validate({"method": method, **wrong}))


@each_engine
def test_a_step_that_does_not_divide_the_output_names_those_that_do(name):
    method = next(m.name for m in engine(name).methods() if m.kind == "fixed")
    with pytest.raises(ValueError, match=r"step = 0\.03 s does not divide .*allowed: 0\.0333333333333 or 0\.025"):
        engine(name).run(scenes.make("pendulum"), Settings(method=method, step=0.03), np.array([0.0, 0.1, 0.2]))


@each_engine
def test_inconsistent_initial_velocities_are_named_not_snapped(name):
    rod = PlanarBody(name="rod", mass=1.0, inertia=0.1, position=(0.5, 0.0), velocity=(0.0, 1.0))
    pin = Revolute(name="pin", body_a=GROUND, body_b="rod", point=(0.0, 0.0))
    result = engine(name).run(Scene(name="broken", bodies=(rod,), joints=(pin,)), Settings())
    assert result.status is Status.INCONSISTENT
    assert "'pin' by 0 (m, rad) and 1 (m/s, rad/s)" in result.message


@each_engine
def test_all_that_an_engine_lacks_is_refused_together(name):
    body = SpatialBody(name="stone", mass=1.0, inertia=(1.0, 1.0, 1.0, 0.0, 0.0, 0.0), position=(0.0, 0.0, 0.0))
    table = PointOnPlane(name="table", body_a=GROUND, body_b="stone", point=(0.0, 0.0, 0.0), normal=(0.0, 0.0, 1.0))
    wall = SphereOnPlane(name="wall", body_a="stone", center=(0.0, 0.0, 0.0), radius=0.1, body_b=GROUND,
                         point=(1.0, 0.0, 0.0), normal=(-1.0, 0.0, 0.0), law=RigidLaw(restitution=0.5))  # fmt: skip
    scene = Scene(name="space", bodies=(body,), joints=(table,), contacts=(wall,), gravity=(0.0, 0.0, -9.81))
    reasons = [refusal.reason for refusal in engine(name).refusals(scene)]
    assert {"'point_on_plane'", "'rigid_law'"} <= {reason.split()[-1] for reason in reasons}
    result = engine(name).run(scene, Settings())
    assert result.status is Status.REFUSED
    assert all(reason in result.message for reason in reasons)
    assert result.position.shape == (0, 1, 3)
