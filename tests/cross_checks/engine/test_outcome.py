"""Planning a run and judging its end, apart from any engine."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.engine import End, end_of
from cross_checks.engine.plan import default_step, step_counts, step_grid
from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Status

TIMES = np.array([0.0, 0.1, 0.2, 0.4])


def test_steps_are_counted_between_output_times():
    assert step_counts(TIMES, 0.05) == (2, 2, 4)
    assert step_counts(np.linspace(0.0, 10.0, 101), 1e-3) == (100,) * 100


def test_a_step_that_misses_an_output_time_names_the_neighbours():
    with pytest.raises(ValueError, match=r"step = 0.06 s .* interval 0.1 s\); allowed: 0.1 or 0.05"):
        step_counts(TIMES, 0.06)


def test_a_step_longer_than_the_interval_is_an_error():
    with pytest.raises(ValueError, match="does not divide the output times"):
        step_counts(TIMES, 0.2)


def test_the_default_step_divides_and_is_a_millisecond_at_most():
    assert default_step(TIMES) == pytest.approx(1e-3)
    step = default_step(np.array([0.0, 0.0025]))
    assert step == pytest.approx(0.0025 / 3)


def test_without_asked_times_samples_fall_on_steps():
    grid = step_grid(scenes.make("pendulum"), Settings(step=0.04, t_end=1.0, samples=4))
    assert grid == pytest.approx([0.0, 0.32, 0.68, 1.0])
    assert len(step_grid(scenes.make("pendulum"), Settings(step=0.5, t_end=1.0))) == 3


def test_a_sample_that_is_not_finite_ends_the_run_before_it():
    states = np.zeros((4, 2))
    assert end_of(states, TIMES, End(4)) == End(4)
    states[2, 1] = np.nan
    end = end_of(states, TIMES, End(4))
    assert (end.samples, end.status) == (2, Status.NON_FINITE)
    assert end.message == "NaN or infinity arose before t = 0.2 s; the last finite sample is at t = 0.1 s"
    kept = End(2, Status.RESET, "reset")
    assert end_of(states, TIMES, kept) is kept
