"""Twins of a system share what no run changes, and begin as before any run; outputs recall the modes of their times."""

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.simulate.legs import run_legs, start_run
from mbs_ref.simulate.one_run import compiled

SETTINGS = Settings(t_end=0.8, samples=201, rtol=1e-7)


def run(system, plan):
    """Return the states of a run from the scene's start."""
    y = system.initial_state()
    start_run(system, plan, y)
    return run_legs(system, plan, y)


@pytest.fixture(params=["cartesian", "relative"])
def bounced(request):
    """Return a plan, a system after a run with bounces, and the run."""
    scene = scenes.make("bouncing_ball", damping=0.0, gravity=9.81)
    plan, system, _ = compiled(scene, SETTINGS.model_copy(update={"coordinates": request.param}), None)
    return plan, system, run(system, plan)


def test_a_twin_shares_the_scene_and_begins_before_any_run(bounced):
    plan, system, first = bounced
    twin, events = system.twin(), system.contact_events()
    assert len(events) > 1
    assert not len(twin.contact_events())
    assert twin.redundant.groups.bodies is system.redundant.groups.bodies
    second = run(twin, plan)
    np.testing.assert_array_equal(second.states, first.states)
    np.testing.assert_array_equal(twin.contact_events(), events)
    noise = system.redundant.groups.contact_modes.noise.copy()
    beside = system.beside()
    run(beside, plan)
    assert not np.array_equal(beside.redundant.groups.contact_modes.noise, noise)
    np.testing.assert_array_equal(system.redundant.groups.contact_modes.noise, noise)
    np.testing.assert_array_equal(system.contact_events(), events)


def test_forces_at_outputs_are_those_of_their_own_modes_in_any_order(bounced):
    _, system, done = bounced
    forces = system.contact_forces(done.times, done.states)["floor"]
    backwards = system.contact_forces(done.times[::-1], done.states[::-1])["floor"]
    np.testing.assert_array_equal(backwards[::-1], forces)
    touching = forces[:, 0] > 1e-9
    assert 0 < np.sum(touching) < len(touching)
    np.testing.assert_array_equal(forces[:, 2] > 0.0, touching)
