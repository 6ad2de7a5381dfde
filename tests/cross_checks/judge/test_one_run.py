"""One run, judged: an engine's failures are answers."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from cross_checks.engine import Method
from cross_checks.judge.ladder import STEPS, rungs
from cross_checks.judge.one_run import evaluate
from cross_checks.truths.truth import NoTruth
from mbs_ref import scenes
from mbs_ref.scene.events import CoordinateEvent
from mbs_ref.scene.scales import free_fall_time
from mbs_ref.settings import Settings
from tests.cross_checks.conftest import raising, spoiled

PENDULUM = scenes.make("pendulum")


def judged(engine="swing", scene=PENDULUM, **settings):
    record = evaluate(scene, engine, Settings(**settings))
    json.dumps(record.to_dict(), allow_nan=False)  # NaN never reaches a record
    return record


def test_a_good_run(swing):
    record = judged(step=1e-3)
    assert record.status == "success"
    assert record.measure("position_error") == pytest.approx(1e-6)
    assert record.at_most("velocity_error") < 1e-6
    assert record.error.truth.startswith("exact")
    assert record.measure("compliance_position") == pytest.approx(1e-6)
    assert record.final["bob"].keys() == {"position", "velocity"}
    assert record.versions["swing"] == "1.0"
    assert record.measure("energy_drift") < 1e-4
    assert record.measure("momentum_drift") is None
    assert {len(part) for part in record.history.values()} == {101}


def test_refusals_come_with_every_reason(swing):
    record = judged(scene=scenes.make("spring_pendulum"), method="loops")
    assert record.status == "cannot"
    assert "spring_damper" in record.message
    assert "closed-loop" in record.message


def test_a_missing_package(swing):
    record = judged("absent")
    assert (record.status, record.final, record.error) == ("engine-missing", {}, None)


def test_unknown_names_are_the_callers_mistake(swing):
    with pytest.raises(ValueError, match="nobody"):
        judged("nobody")
    with pytest.raises(ValueError, match="sceond"):
        judged(method="sceond")


@pytest.mark.parametrize(
    ("trouble", "status", "words"),
    [
        (raising(RuntimeError("singular")), "engine-error", "singular"),
        (raising(ZeroDivisionError("by zero")), "engine-error", "by zero"),
        (raising(MemoryError("9 GiB")), "out-of-memory", "memory is exhausted: 9 GiB; request fewer samples"),
        (raising(MemoryError()), "out-of-memory", "memory is exhausted; request fewer samples"),
        (raising(ValueError("stabilization = 'baumgarte' is not offered")), "cannot", "baumgarte"),
        (raising(ValueError("cannot reshape")), "engine-error", "ValueError: cannot reshape"),
        (spoiled(50), "non-finite", "after t = 4.9 s"),
        (spoiled(0), "non-finite", "from the start"),
        (lambda path: replace(path, times=path.times % 5.0), "reset", "clock jumped"),
        (lambda path: path.at(slice(30)), "engine-error", "30 of 101"),
    ],
)
def test_failures_are_statuses_with_sentences(swing, trouble, status, words):
    swing(trouble)
    record = judged(step=1e-3)
    assert record.status == status
    assert words in record.message


def test_a_broken_adapter_is_seen(swing):
    swing(raising(TypeError("wrong argument")))
    with pytest.raises(TypeError):
        judged()


def test_a_run_that_a_declared_event_stops_is_on_time():
    fall = CoordinateEvent(name="low", body=PENDULUM.bodies[0].name, coordinate="y", value=-0.3, action="stop")
    scene = PENDULUM.model_copy(update={"events": (fall,), "name": "stopped"})
    record = evaluate(
        scene, "mbs_ref", Settings(rtol=1e-6, estimate="off", samples=101), truth=NoTruth("none is asked")
    )
    assert (record.status, record.message.count("clock")) == ("stop-event", 0)


def test_the_steps_of_a_ladder_count_in_free_fall_times():
    satellite = scenes.make("satellite")
    coarse = rungs(Method("rk4", "fixed", 4, "made up"), satellite)[0]
    assert coarse.step == pytest.approx(STEPS[0] * free_fall_time(satellite), rel=0.2)
