"""A scene is compiled without the code of what it does not have: its motion is the same with all of it."""

import numpy as np
import pytest

from mbs_ref import Settings, scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.system import System
from mbs_ref.kernels.answers import FEATURES, PRUNED
from mbs_ref.simulate.one_run import run_legs, start_run
from mbs_ref.simulate.plan import make_plan

SHARE, STEPS = 0.2, 400  # of the duration; the most steps


def moved(scene):
    """Return the state and its rate at the start, then the states and events of a short run."""
    plan = make_plan(scene, Settings(method="dop853", rtol=1e-6, samples=5, t_end=SHARE * scene.duration,
                                     max_steps=STEPS), None)  # fmt: skip
    system = compile_scene(scene)
    y = system.initial_state()
    start_run(system, plan, y)
    rate = system.derivative(0.0, y)
    run = run_legs(system, plan, y.copy())
    return rate, run.states, system.contact_events() if system.event_sources else np.zeros(0)


CASES = [*((name, {}) for name in scenes.names()), ("granular_column", {"search": True})]


@pytest.mark.parametrize(("name", "parameters"), CASES, ids=str)
def test_code_of_what_a_scene_lacks_changes_nothing(name, parameters, monkeypatch):
    scene = scenes.make(name, **parameters)
    own = moved(scene)
    monkeypatch.setattr(System, "features", property(lambda self: set(FEATURES)))
    for mine, whole in zip(own, moved(scene), strict=True):
        assert np.array_equal(mine, whole, equal_nan=True)


def test_many_pairs_are_pruned_and_a_few_are_not():
    """The motion is the same either way: what shows is the cost alone."""
    assert PRUNED in compile_scene(scenes.make("tracked_vehicle")).features
    assert PRUNED not in compile_scene(scenes.make("bouncing_ball")).features
