"""What a solver must do to be believed: refuse, keep time, converge, keep its joints closed, agree, fail aloud."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.engine import Engine
from cross_checks.judge.matrix import judge_method
from cross_checks.judge.one_run import evaluate
from cross_checks.judge.verdict import Verdict
from cross_checks.truths import known
from mbs_ref import scenes
from mbs_ref.scene import GROUND, PointMass, Scene, UserForce
from mbs_ref.scene import Distance as Rod
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Status

ORDER_OFF = 0.35  # how far an observed order may be from the documented one
BUDGET = 10.0  # s of a ladder
ROUNDOFF = 1e-9  # m; joints closed better than this need not close better still
COARSE, FINE = 2e-2, 2.5e-3  # s
LONG = {"android_vertebral"}  # its truth takes half a minute
WRONG = (Verdict.WRONG_LIMIT, Verdict.DIVERGED, Verdict.FAILED)


def accepted(engine: Engine, method):
    """Return the scenes with a truth that this method takes; those with contacts last, where orders are lost."""
    made = [scenes.make(name) for name in known() if name in scenes.names() and name not in LONG]
    made.sort(key=lambda scene: bool(scene.contacts))
    return [s for s in made if not engine.refusals(s) and not engine.method_refusals(s, method)]


def impossible() -> Scene:
    """A scene in space under a Python force: few engines take either."""
    stone = PointMass(name="stone", mass=1.0, position=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0))
    wind = UserForce(name="wind", function=lambda t, q, v: 0.0 * q)
    return Scene(name="impossible", gravity=(0.0, 0.0, -9.81), bodies=(stone,), loads=(wind,))


def open_pendulum() -> Scene:
    """A particle that starts along its rod: the velocity breaks the constraint."""
    bob = PointMass(name="bob", mass=1.0, position=(1.0, 0.0), velocity=(1.0, 0.0))
    rod = Rod(name="rod", body_a=GROUND, body_b="bob", point_a=(0.0, 0.0), point_b=(1.0, 0.0))
    return Scene(name="open", gravity=(0.0, -9.81), bodies=(bob,), joints=(rod,))


def test_it_says_who_it_is(engine, engine_name):
    assert engine.name == engine_name
    assert engine.package
    assert engine.version()
    methods = engine.methods()
    assert methods, "an engine offers one method at least"
    assert len({m.name for m in methods}) == len(methods)
    for method in methods:
        assert method.description
        assert list(method.ladder) == sorted(method.ladder, reverse=True), "ladders go from coarse to fine"
    assert engine.method(None) is methods[0] or engine.method(None) == methods[0]


def test_it_runs_something(engine):
    assert any(accepted(engine, method) for method in engine.methods()), "it refuses every scene with a known truth"


def test_what_it_cannot_model_is_refused_before_any_step(engine):
    scene = impossible()
    reasons = [r.reason for r in engine.refusals(scene)]
    if not reasons:
        pytest.skip("it claims to model a spatial scene with a Python force")
    result = engine.run(scene, Settings())
    assert result.status is Status.REFUSED
    assert len(result.times) == 0
    assert all(reason in result.message for reason in reasons)


def test_unknown_methods_are_errors(engine):
    scene = next(s for m in engine.methods() for s in accepted(engine, m))
    with pytest.raises(ValueError, match="no_such_method"):
        engine.run(scene, Settings(method="no_such_method"))


def test_inconsistent_starts_are_named_not_snapped(engine):
    if engine.refusals(open_pendulum()):
        pytest.skip("it does not take a rod to a particle")
    result = engine.run(open_pendulum(), settings_for(engine.methods()[0], FINE))
    assert result.status is Status.INCONSISTENT, "the velocity along the rod was accepted or changed silently"
    assert result.message


def test_poses_come_at_the_asked_times(engine):
    for method in engine.methods():
        for scene in accepted(engine, method)[:1]:
            times = np.array([0.0, 0.02, 0.04, 0.1])
            result = engine.run(scene, settings_for(method, FINE), times)
            assert result.ok, f"{method.name}: {result.message}"
            assert np.array_equal(result.times, times)
            assert result.position.shape == (4, len(scene.bodies), scene.dimension)
            start = [body.position for body in scene.bodies]
            assert result.position[0] == pytest.approx(np.array(start), abs=1e-12)
            assert result.timing.loop_s > 0.0, "the loop must be timed"


def test_the_documented_order_is_observed(engine):
    seen = []
    for method in engine.methods():
        if method.kind != "fixed" or method.order is None or method.wrong_limit:
            continue
        for scene in accepted(engine, method)[:1]:
            cell = judge_method(scene, engine.name, method, BUDGET)
            told = f"{method.name}: {method.order} is documented, and the ladder shows no order: {cell.reason}"
            assert cell.order is not None or cell.verdict in (Verdict.AGREES, Verdict.BELOW_TRUTH), told
            if cell.order is not None:
                seen.append(method.name)
                told = f"{method.name}: order {cell.order:.2f} observed, {method.order} documented"
                assert abs(cell.order - method.order) < ORDER_OFF, told
    if not seen:
        pytest.skip("no method has a fixed step and a documented order")


def test_it_agrees_with_every_truth_it_takes_on(engine):
    wrong = []
    for method in engine.methods():
        for scene in accepted(engine, method):
            cell = judge_method(scene, engine.name, method, BUDGET)
            if cell.verdict in WRONG and not method.wrong_limit:
                wrong.append(f"{scene.name} by {method.name}: {cell.verdict}: {cell.reason}")
    assert not wrong, "\n".join(wrong)


def test_joints_close_better_with_finer_steps(engine):
    for method in engine.methods():
        for scene in accepted(engine, method):
            if not scene.joints or method.wrong_limit:
                continue
            times = np.linspace(0.0, 0.2, 11)
            records = [evaluate(scene, engine.name, settings_for(method, h), times) for h in (COARSE, FINE)]
            found = [r.measure("compliance_position") for r in records if r.status == "success"]
            gaps = [gap for gap in found if gap is not None]
            if len(gaps) == 2:
                told = f"{scene.name} by {method.name}: joints open from {gaps[0]} to {gaps[1]}"
                assert gaps[1] <= max(gaps[0], ROUNDOFF), told


def test_a_hopeless_step_is_never_a_success_with_nonsense_in_it(engine):
    """Absurd accuracy must end in a status, a refusal or finite poses; a NaN or a lost clock is not success."""
    for method in engine.methods():
        for scene in accepted(engine, method)[:2]:
            settings = settings_for(method, scene.duration / 2)
            times = np.array([0.0, scene.duration / 2, scene.duration])
            try:
                result = engine.run(scene, settings, times)
            except ValueError:  # it refuses the setting, aloud
                continue
            if result.ok:
                assert np.isfinite(result.position).all()
                assert np.array_equal(result.times, times)
            else:
                assert result.message, "a failure needs its sentence"


def settings_for(method, step: float) -> Settings:
    """Return a setting in the terms the method takes."""
    if method.kind == "fixed":
        return Settings(method=method.name, step=step, estimate="off")  # judged here
    return Settings(method=method.name, rtol=1e-4 * step, atol=1e-4 * step, estimate="off")
