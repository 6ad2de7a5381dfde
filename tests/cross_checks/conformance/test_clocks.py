"""Loops that take longer than they say, and calls that are dear for another reason, as a collector at work."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.conformance import ladder
from cross_checks.conformance.ladder import Run
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Timing, Trajectory

COARSE, FINE = Settings(method="rk4", step=1e-2), Settings(method="rk4", step=1e-3)


def run(settings: Settings, cpu: float, loop: float) -> Run:
    still = np.zeros((1, 1))
    path = Trajectory(np.zeros(1), np.zeros((1, 1, 2)), still, np.zeros((1, 1, 2)), still, timing=Timing(loop_s=loop))
    return Run(settings, path, wall_s=cpu, cpu_s=cpu)


@pytest.mark.parametrize(("again", "accused"), [((0.015, 0.013), False), ((0.310, 0.013), True)])
def test_a_dear_call_is_a_lie_where_it_comes_again(monkeypatch, again, accused):
    asked = []

    def timed(engine, question, settings):
        asked.append(settings)
        return run(COARSE, 0.011, 0.010) if settings is COARSE else run(FINE, *again)

    monkeypatch.setattr(ladder, "timed", timed)
    told = ladder._untold_work(None, None, [run(COARSE, 0.011, 0.010), run(FINE, 0.300, 0.013)])
    assert ("loop's time tells" in told) is accused
    assert asked == [COARSE, FINE]


def test_a_clock_that_tells_is_not_asked_again(monkeypatch):
    monkeypatch.setattr(ladder, "timed", None)
    assert not ladder._untold_work(None, None, [run(COARSE, 0.030, 0.028), run(FINE, 0.300, 0.280)])
