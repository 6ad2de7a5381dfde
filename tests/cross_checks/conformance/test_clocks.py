"""Loops that take longer than they report, and calls that are dear for another reason, as a collector at work."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.conformance import clock
from cross_checks.conformance.apart import Called
from cross_checks.conformance.questions import Question
from cross_checks.truths.truth import Truth
from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Timing, Trajectory

RK4 = Settings(method="rk4", step=1e-2)
BUILD = 5.0  # s of every call besides its loop


def run(cpu: float, loop: float, wall: float | None = None, steps: int = 100) -> Called:
    """Return a call whose loop works for `cpu` (s) and reports `loop`."""
    still, timing = np.zeros((1, 1)), Timing(build_s=BUILD, loop_s=loop)
    path = Trajectory(np.zeros(1), still[..., None], still, still[..., None], still, steps=steps, timing=timing)
    return Called(RK4, path, wall_s=BUILD + (cpu if wall is None else wall), cpu_s=BUILD + cpu)


@pytest.mark.parametrize(("share", "is_reported"), [(0.0, True), (0.4, True), (0.55, True), (0.7, False), (1.0, False)])
def test_a_clock_that_leaves_out_much_of_the_work_is_detected(share, is_reported):
    short, long = run(0.1, 0.1 * share), run(1.0, 1.0 * share)
    wrong = clock.uncounted(lambda: (short, long), short, long)
    both = f"costs 9.00e-01 s more, of which the loop's clock reports {0.9 * share:.2e} s"
    assert (both in wrong) is is_reported


def test_a_dear_call_must_come_again_to_count():
    short, dear, usual = run(0.1, 0.1), run(1.0, 0.2), run(0.2, 0.2)
    assert not clock.uncounted(lambda: (short, usual), short, dear)
    assert clock.uncounted(lambda: (short, dear), short, dear)


def test_threads_and_short_runs_are_not_compared():
    """Two threads use twice the time that passes; a difference below 0.1 s may be anything."""
    short, threads = run(0.2, 0.1, wall=0.1), run(2.0, 1.0, wall=1.0)
    assert not clock.uncounted(lambda: (short, threads), short, threads)
    short, quick = run(0.01, 0.001), run(0.09, 0.001)
    assert not clock.uncounted(lambda: (short, quick), short, quick)


def test_the_span_grows_until_the_work_can_be_compared(monkeypatch):
    spans: list[float] = []

    def called(engine, scene, settings, times):
        spans.append(float(times[-1]))
        return run(1e-3 * times[-1], 4e-4 * times[-1])

    monkeypatch.setattr(clock, "called", called)
    scene, times = scenes.make("pendulum"), np.array([0.0, 1.0])
    truth = Truth(np.zeros((2, 1, 2)), np.zeros((2, 1)), 0.0, "exact", "")
    assert clock.uncounted_work(None, Question(scene, times, truth), RK4)  # type: ignore[arg-type]
    assert spans == [1.0, 4.0, 16.0, 64.0, 256.0, 1.0, 256.0]


@pytest.mark.parametrize(
    ("loop", "wall", "steps", "words"),
    [(0.0, 1.0, 1, "not timed"), (2.0, 1.0, 1, "are reported of a call"), (1e-6, 1.0, 10**6, "beyond any processor")],
)
def test_a_time_that_cannot_be_is_named(loop, wall, steps, words):
    assert words in clock.impossible_time([run(wall, loop, steps=steps)])
    assert not clock.impossible_time([run(1.0, 0.9, steps=1000)])
