"""Many starts and scenes in one call: every run is what `simulate` makes of it alone, to the bit."""

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.system import Poses
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate, simulate_scenes, simulate_starts
from mbs_ref.trajectory import Status

CASES = {
    "pendulum_chain": {"links": 3},
    "slider_crank": {},
    "heavy_top": {},
    "kepler": {"orbits": 1.0},
    "bouncing_ball": {},
    "rolling_sphere": {},
}
SHORT = Settings(t_end=0.3, samples=4, rtol=1e-7)


def poses(path):
    return Poses(path.position, path.orientation, path.velocity, path.angular_velocity)


def one(all_of, k):
    return Poses(*(part[k : k + 1] for part in all_of))


@pytest.fixture(scope="module", params=CASES)
def scene(request):
    return scenes.make(request.param, **CASES[request.param])


@pytest.fixture(scope="module")
def along(scene):
    """A run whose outputs are the starts."""
    return simulate(scene, SHORT.model_copy(update={"samples": 6, "rtol": 1e-11, "estimate": "off"}))


def assert_same(path, alone):
    for name in ("status", "message", "steps", "rhs_calls", "events", "notes"):
        assert getattr(path, name) == getattr(alone, name)
    for part, other in zip(poses(path), poses(alone), strict=True):
        assert np.array_equal(part, other)
    assert path.estimate is not None
    assert np.array_equal(path.estimate.components, alone.estimate.components)
    assert path.reactions.keys() == alone.reactions.keys()
    assert all(np.array_equal(path.reactions[name], alone.reactions[name]) for name in path.reactions)
    assert all(np.array_equal(path.contacts[name], alone.contacts[name]) for name in path.contacts)


def test_starts_of_one_scene_run_as_alone(scene, along):
    starts = poses(along)
    batch = simulate_starts(scene, starts, SHORT, threads=2)
    assert len(batch) == len(along.times)
    for k, path in enumerate(batch):
        assert_same(path, simulate(scene, SHORT, start=one(starts, k)))


def test_a_start_on_a_motion_goes_on_with_it(scene, along):
    if scene.contacts:
        pytest.skip("a start says where bodies are, not how far a contact has slipped")
    half = Settings(t_end=along.times[-1] - along.times[2], rtol=1e-11, samples=2, estimate="off")
    path = simulate(scene, half, start=one(poses(along), 2))
    size = max(1.0, float(np.abs(along.position).max()))
    assert np.max(np.abs(path.position[-1] - along.position[-1])) < 1e-8 * size


def test_states_and_poses_say_the_same(scene, along):
    system = compile_scene(scene)
    again = system.poses(system.states_of(poses(along)))
    for part, other in zip(again, poses(along), strict=True):
        assert part == pytest.approx(other, rel=1e-14, abs=1e-14)  # roundoff of turning rates


def test_relative_coordinates_start_anywhere_too():
    scene = scenes.make("pendulum_chain", links=3)
    starts = poses(simulate(scene, SHORT))
    relative = SHORT.model_copy(update={"coordinates": "relative", "rtol": 1e-10})
    batches = (simulate_starts(scene, starts, settings) for settings in (relative, SHORT))
    for path, other in zip(*batches, strict=True):
        assert np.max(np.abs(path.position - other.position)) < 1e-6


def test_scenes_run_as_alone():
    family = [scenes.make("pendulum_chain", links=links) for links in (1, 2, 3)]
    for path, scene in zip(simulate_scenes(family, SHORT, threads=2), family, strict=True):
        assert_same(path, simulate(scene, SHORT))


def test_a_start_that_breaks_a_joint_stops_itself_alone():
    scene = scenes.make("pendulum")
    starts = poses(simulate(scene, SHORT))
    starts.position[1] += 0.1
    states = [path.status for path in simulate_starts(scene, starts, SHORT)]
    assert states == [Status.SUCCESS, Status.INCONSISTENT, Status.SUCCESS, Status.SUCCESS]


def test_arrays_of_another_shape_are_refused():
    scene = scenes.make("pendulum")
    starts = poses(simulate(scene, SHORT))
    with pytest.raises(ValueError, match=r"starts.velocity has the shape \(3, 1, 2\); allowed: \(4, 1, 2\)"):
        simulate_starts(scene, starts._replace(velocity=starts.velocity[:3]), SHORT)


def test_a_start_of_several_samples_is_refused():
    scene = scenes.make("pendulum")
    with pytest.raises(ValueError, match=r"starts.position has the shape \(4, 1, 2\); allowed: \(1, 1, 2\)"):
        simulate(scene, SHORT, start=poses(simulate(scene, SHORT)))


def test_a_start_whose_euler_parameters_have_another_norm_is_refused():
    scene = scenes.make("heavy_top")
    start = one(poses(simulate(scene, SHORT)), 0)
    longer = start._replace(orientation=1.1 * start.orientation)
    for run in (lambda: simulate(scene, SHORT, start=longer), lambda: simulate_starts(scene, longer, SHORT)):
        with pytest.raises(ValueError, match=r"body 'top' = .* has the norm 1.1; Euler parameters have 1"):
            run()
