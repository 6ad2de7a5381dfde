"""A run that leaves the numbers is no success, and shows finite outputs alone."""

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Status


@pytest.mark.parametrize("gravity", [9.81, 9.81 * 1.001, 30.0])
@pytest.mark.parametrize("step", [5.0, 3.0, 1.0])
@pytest.mark.parametrize("method", ["euler", "rk4", "dop853"])
def test_a_step_of_many_periods_never_ends_in_success_with_nan(method, step, gravity):
    scene = scenes.make("pendulum").model_copy(update={"gravity": (0.0, -gravity)})
    with np.errstate(all="ignore"):
        run = simulate(scene, Settings(method=method, step=step, estimate="off"))
    outputs = (run.position, run.orientation, run.velocity, run.angular_velocity)
    assert all(np.isfinite(values).all() for values in outputs)
    assert run.ok or run.status is Status.NON_FINITE
