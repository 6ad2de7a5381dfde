"""Energy and work across contact events agree to the integrator's accuracy."""

from __future__ import annotations

import numpy as np

from mbs_ref import scenes
from mbs_ref.settings import Settings
from reports.studies.contact import balance


def test_the_balance_closes_over_bounces_that_lose_energy():
    ball = scenes.make("bouncing_ball", law="progressive", damping=3e4, gravity=9.81, duration=1.0)
    found = balance(ball, Settings(method="dop853", rtol=1e-11), longest=2e-4)
    assert found.work[-1] < -0.1  # J
    assert np.abs(found.drift).max() < 1e-8
