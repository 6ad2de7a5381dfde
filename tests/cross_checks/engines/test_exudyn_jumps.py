"""A force that jumps at the end of a step, where Newton's iteration has no answer: Exudyn halves the step."""

import numpy as np
import pytest

from cross_checks import engines
from cross_checks.engines.exudyn_ import run as solver
from mbs_ref import Settings, scenes, simulate
from mbs_ref.scene import PlanarBody, Scene, SpringDamper

STEP = 0.01  # s


@pytest.mark.parametrize("method", ["generalized_alpha", "trapezoidal"])
def test_steps_are_halved_where_a_damped_string_becomes_taut(method):
    body = PlanarBody(name="a", mass=1.0, inertia=1.0, position=(1.0, 0.0), velocity=(1.0, 0.0))
    string = SpringDamper(
        name="string", body_a="ground", body_b="a", point_a=(0.0, 0.0), point_b=(1.0, 0.0), stiffness=100.0,
        damping=50.0, rest_length=1.5, tension_only=True,
    )  # fmt: skip
    scene = Scene(name="thrown", gravity=(0.0, 0.0), bodies=(body,), loads=(string,), duration=1.0)
    times = np.linspace(0.0, 1.0, 11)
    run = engines.get("exudyn").run(scene, Settings(method=method, step=STEP), times)
    assert run.ok, run.message
    assert any("steps that may be halved began anew" in note for note in run.notes)
    truth = simulate(scene, Settings(rtol=1e-11, estimate="off"), times)
    assert run.position == pytest.approx(truth.position, abs=STEP)  # at 1 m/s, one step late
    assert np.array_equal(run.times, times)


def test_halving_without_end_stops_and_is_no_success(monkeypatch):
    """The steps of a heavy top at 5 ms fall to Exudyn's smallest, 1e-8 s, and remain there."""
    monkeypatch.setattr(solver, "HALVED", 10)
    scene = scenes.make("heavy_top")
    run = engines.get("exudyn").run(scene, Settings(method="generalized_alpha", step=5e-3), np.linspace(0.0, 2.0, 21))
    assert run.status == "not-converged"
    assert "halved steps are more than 10 times as many" in run.message
    assert run.steps <= 10 * 400
    assert run.times[-1] < 2.0
