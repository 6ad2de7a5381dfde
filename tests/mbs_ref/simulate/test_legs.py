"""Legs between breakpoints: what a run reports does not depend on where its outputs and breakpoints lie."""

import itertools
import signal
import time

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.integrators.loop.leg import progress
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.simulate.legs import Interrupts

STEP = 1e-2  # s


@pytest.fixture(scope="module")
def settings():
    return Settings(method="rk4", step=STEP, stabilization="none", estimate="off")


@pytest.mark.parametrize("name", ["slider_crank", "driven_pendulum"])
def test_an_output_reports_the_largest_compliance_since_the_one_before(name, settings):
    scene = scenes.make(name)
    every = simulate(scene, settings, np.arange(41) * STEP)
    some = np.array([0, 7, 8, 25, 40])
    few = simulate(scene, settings, some * STEP)
    between = [every.step_compliance[a + 1 : b + 1, 1].max() for a, b in itertools.pairwise(some)]
    assert few.position == pytest.approx(every.position[some], abs=1e-13)  # times differ in their last digit
    assert few.step_compliance[1:, 1] == pytest.approx(between, rel=1e-3, abs=1e-14)


def test_a_breakpoint_on_an_output_loses_no_sample():
    scene = scenes.make("android_simplified", model="paper")
    (inner,) = (t for t in scene.breakpoints() if 0.0 < t < 0.2)
    times = np.array([0.0, 0.5 * inner, inner, 0.2])
    run = simulate(scene, Settings(rtol=1e-6, estimate="off"), times)
    assert np.array_equal(run.times, times)
    assert np.isfinite(run.position).all()


def test_ctrl_c_of_one_run_does_not_stop_the_next():
    """The thread may read a signal's number after the run that it stopped has ended."""
    for _ in range(200):
        first, second = progress(0.0), progress(0.0)
        with Interrupts(first, 10) as stopped:
            signal.raise_signal(signal.SIGINT)
        assert stopped.received
        with Interrupts(second, 10) as other:
            time.sleep(1e-4)
        assert not other.received
