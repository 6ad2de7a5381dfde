"""The same scene at another length, gravity with it: a relative tolerance gives the same relative error."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.cores.system import Poses
from mbs_ref.scene import Scene
from mbs_ref.scene.scales import scales_of
from mbs_ref.self_checks.state_gap import state_gaps
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

FACTOR = {"dop853": 1.5, "lsodar": 1.5, "radau": 3.0, "dassl": 5.0}  # radau errs by Newton's rest, too; IDA by chance
T_END = 1.0  # s
POINTS = ("point", "point_a", "point_b")  # of a joint


def scaled(scene: Scene, k: float) -> Scene:
    """Return the scene k times as long, which takes the same time."""

    def longer(part, *fields):
        return part.model_copy(update={name: tuple(k * x for x in getattr(part, name)) for name in fields})

    bodies = tuple(
        longer(body, "position", "velocity").model_copy(update={"inertia": (k * k * np.array(body.inertia)).tolist()})
        for body in scene.bodies
    )
    joints = tuple(longer(joint, *(f for f in POINTS if getattr(joint, f, None))) for joint in scene.joints)
    return longer(scene, "gravity").model_copy(update={"bodies": bodies, "joints": joints})


def poses(scene: Scene, settings: Settings, k: float) -> Poses:
    """Return the motion of the scene at k times its length, in units of that."""
    run = simulate(scaled(scene, k), settings)
    assert run.ok, run.message
    return Poses(run.position / k, run.orientation, run.velocity / k, run.angular_velocity)


@cache
def truth(name: str) -> tuple[Scene, Poses]:
    scene = scenes.make(name)
    return scene, poses(scene, Settings(rtol=1e-12, t_end=T_END, samples=11, estimate="off", reactions=False), 1.0)


@pytest.mark.parametrize("name", ["slider_crank", "heavy_top"])
@pytest.mark.parametrize("method", FACTOR)
@pytest.mark.parametrize("stabilization", ["projection", "none"])
def test_errors_follow_the_length(name, method, stabilization):
    scene, exact = truth(name)
    settings = Settings(method=method, rtol=1e-8, t_end=T_END, samples=11, estimate="off", reactions=False,
                        stabilization=stabilization)  # fmt: skip
    errors = [state_gaps(scene, scales_of(scene), poses(scene, settings, k), exact).max() for k in (1e-2, 1.0, 1e2)]
    assert max(errors) < FACTOR[method] * min(errors)
