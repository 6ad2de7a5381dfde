"""Runs of one scene object, of which the compiled system is used again: no run changes another one."""

from __future__ import annotations

import numpy as np
import pytest

from mbs_ref import Scene, Settings, scenes, simulate
from mbs_ref.cores.relative import no_tree
from mbs_ref.cores.system import Poses
from mbs_ref.scene.traits import touching
from mbs_ref.simulate import simulate_scenes
from mbs_ref.trajectory import Trajectory

SHARE = 1e-2  # of a scene's duration
FEW = ("pendulum", "n_four_bar", "slider_crank", "heavy_top", "spring_pendulum")


def variants(scene: Scene) -> list[Settings]:
    """Return settings that use a system in different ways."""
    t_end = SHARE * scene.duration
    plain = Settings(t_end=t_end, samples=4, rtol=1e-6)
    bare = plain.model_copy(update={"estimate": "off", "reactions": False})
    changes: list[dict] = [
        {"method": "rk4", "rtol": None, "step": t_end / 20}, {"method": "lsodar"}, {"outputs": "dense"},
        {"stabilization": "baumgarte"},
    ]  # fmt: skip
    changes += [] if any(no_tree(scene)) else [{"coordinates": "relative"}]
    return [plain, *(bare.model_copy(update=change) for change in changes)]


def run(scene: Scene, settings: Settings, start: Poses | None = None) -> Trajectory | str:
    try:
        return simulate(scene, settings, start=start)
    except ValueError as error:
        return str(error)


def assert_same(one: Trajectory | str, other: Trajectory | str) -> None:
    if isinstance(one, str) or isinstance(other, str):
        assert one == other
        return
    for name in ("status", "message", "notes", "steps", "rejected_steps", "rhs_calls", "method", "used"):
        assert getattr(one, name) == getattr(other, name), name
    for part, same in zip(Poses.of(one), Poses.of(other), strict=True):
        np.testing.assert_array_equal(part, same)
    np.testing.assert_array_equal(one.step_compliance, other.step_compliance)
    assert one.reactions.keys() == other.reactions.keys()
    for name, force in one.reactions.items():
        np.testing.assert_array_equal(force, other.reactions[name])
    assert (one.estimate is None) == (other.estimate is None)
    if one.estimate and other.estimate:
        assert one.estimate.value == other.estimate.value


def assert_unchanged(scene: Scene) -> None:
    settings = variants(scene)
    alone = [run(scene.model_copy(), chosen) for chosen in settings]
    for k in (*range(len(settings)), *range(len(settings) - 1, -1, -1)):
        assert_same(run(scene, settings[k]), alone[k])
    if isinstance(alone[0], Trajectory) and alone[0].ok:
        start = Poses(*(part[-1:] for part in Poses.of(alone[0])))
        apart = run(scene.model_copy(), settings[0], start)
        assert_same(run(scene, settings[0], start), apart)
        assert_same(run(scene, settings[0]), alone[0])


@pytest.mark.parametrize("name", FEW)
def test_a_run_is_the_same_whatever_ran_before(name):
    assert_unchanged(scenes.make(name))


@pytest.mark.slow
@pytest.mark.parametrize("name", scenes.names())
def test_a_run_of_any_scene_is_the_same_whatever_ran_before(name):
    scene = scenes.make(name)
    if not (touching(scene) or scene.events):
        assert_unchanged(scene)


def test_lanes_do_not_see_the_stabilization_of_a_run_before():
    scene = scenes.make("slider_crank")
    chosen = Settings(t_end=0.05, samples=3, rtol=1e-6, estimate="off", reactions=False)
    (alone,) = simulate_scenes([scene.model_copy()], chosen, lanes=True)
    simulate(scene, chosen.model_copy(update={"stabilization": "baumgarte"}))
    (after,) = simulate_scenes([scene], chosen, lanes=True)
    assert_same(after, alone)
