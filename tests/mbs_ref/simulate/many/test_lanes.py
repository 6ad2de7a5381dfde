"""Starts of one scene in vector lanes: the steps of runs alone, whatever runs beside them, and a sentence where not."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.truths.oracle.random_scenes import DURATION, random_scene
from mbs_ref import scenes
from mbs_ref.cores.relative import no_tree
from mbs_ref.cores.system import Poses
from mbs_ref.kernels.algebra.lanes import WIDTH
from mbs_ref.scene import GROUND, PlanarBody, Revolute, Scene, TorsionSpring
from mbs_ref.settings import Settings
from mbs_ref.simulate import error_estimate, simulate, simulate_scenes, simulate_starts
from mbs_ref.simulate.many import lanes as many_lanes
from mbs_ref.simulate.many.lanes import NOTE, why_not_in_lanes
from mbs_ref.trajectory import Status
from tests.mbs_ref.cores.test_relative import planar_tree, spatial_tree

ROUNDOFF = 1e-11  # relative: of motions of some radians, over which the last digit grows
PROJECTED = 1e-13  # m, what steps leave of the constraints
SHORT = Settings(t_end=0.3, samples=4, rtol=1e-7, coordinates="relative")
COUNT = 2 * WIDTH + 3
# s, of a rod that falls from the horizontal: it swings as a point at 2/3 m, and this is the period of one at 1 m,
PERIOD = 2.3678419475762373 * np.sqrt(2.0 / 3.0)  # by elliptic functions


def chain():
    return scenes.make("pendulum_chain", links=3)


def loop():
    return scenes.make("slider_crank")


def loop_in_space():
    return scenes.make("spatial_slider_crank")


def with_torsion(scene):
    """Return the scene with a torsion spring and its damper at the hinge between bodies f and g."""
    j7 = next(joint for joint in scene.joints if joint.name == "j7")
    spring = TorsionSpring(name="t", body_a="f", body_b="g", axis=j7.axis, stiffness=3.0, damping=0.2)
    return scene.model_copy(update={"loads": (*scene.loads, spring)})


def poses(path):
    return Poses(path.position, path.orientation, path.velocity, path.angular_velocity)


def is_beside(path):
    return any(note.startswith(NOTE) for note in path.notes)


def some(all_of, places):
    return Poses(*(part[places] for part in all_of))


@pytest.fixture(scope="module", params=[chain, planar_tree, lambda: with_torsion(spatial_tree()), loop, loop_in_space])
def scene(request):
    return request.param()


@pytest.fixture(scope="module")
def starts(scene):
    return poses(simulate(scene, Settings(t_end=1.0, samples=COUNT, rtol=1e-11, estimate="off", reactions=False)))


def assert_close(path, alone):
    for name in ("status", "message", "steps", "rejected_steps", "cut_steps", "events", "method", "used"):
        assert getattr(path, name) == getattr(alone, name)
    assert path.notes[0] in (NOTE, f"{NOTE}, in relative coordinates")
    assert path.notes[1:] == alone.notes
    assert path.step_compliance is not None
    is_exact = "relative" in path.notes[0] and path.position.shape[2] == 2  # no rows, and no Euler parameters
    left = 0.0 if is_exact else PROJECTED
    np.testing.assert_allclose(path.step_compliance, alone.step_compliance, rtol=0.0, atol=left)
    for part, other in zip(poses(path), poses(alone), strict=True):
        assert np.max(np.abs(part - other)) < ROUNDOFF * max(1.0, float(np.max(np.abs(other))))
    assert path.estimate is not None
    assert path.estimate.how == alone.estimate.how
    assert path.estimate.components == pytest.approx(alone.estimate.components, rel=0.1, abs=ROUNDOFF)
    assert path.reactions.keys() == alone.reactions.keys()
    forces, others = (np.array([*one.reactions.values()]) for one in (path, alone))
    assert np.max(np.abs(forces - others), initial=0.0) <= ROUNDOFF * np.max(np.abs(others), initial=0.0)


def test_runs_in_lanes_take_the_steps_of_runs_alone(scene, starts):
    own = SHORT.model_copy(update={"coordinates": "cartesian" if any(no_tree(scene)) else "relative"})
    for k, path in enumerate(simulate_starts(scene, starts, SHORT, threads=2, lanes=True)):
        assert_close(path, simulate(scene, own, start=some(starts, slice(k, k + 1))))


def test_a_run_does_not_depend_on_those_beside_it(scene, starts):
    lean = SHORT.model_copy(update={"estimate": "off", "reactions": False})
    every = simulate_starts(scene, starts, lean, threads=1, lanes=True)
    places = [COUNT - 1, 4, 0]
    few = simulate_starts(scene, some(starts, places), lean, threads=2, lanes=True)
    for k, path in zip(places, few, strict=True):
        for part, other in zip(poses(path), poses(every[k]), strict=True):
            assert np.array_equal(part, other)


def test_a_pendulum_is_back_after_the_period_of_elliptic_functions():
    scene = scenes.make("pendulum_chain", links=1)
    start = some(poses(simulate(scene, SHORT)), slice(0, 1))
    path = simulate_starts(scene, start, Settings(rtol=1e-9, t_end=2.0 * PERIOD, samples=3), lanes=True)[0]
    assert is_beside(path)
    assert path.estimate is not None
    error = np.linalg.norm(path.velocity[-1] - path.velocity[0])  # m/s: an error in place is of second order
    assert 0.0 < error < 1e-6
    assert error < path.estimate.value * path.estimate.length / path.estimate.time


def test_errors_fall_with_the_tolerance():
    scene = chain()
    start = some(poses(simulate(scene, SHORT)), slice(0, 1))
    ends = [simulate_starts(scene, start, Settings(rtol=rtol, samples=2, estimate="off"), lanes=True)[0].position[-1]
            for rtol in (1e-4, 1e-6, 1e-8, 1e-12)]  # fmt: skip
    errors = [np.max(np.abs(end - ends[-1])) for end in ends[:-1]]
    assert errors[0] > 10.0 * errors[1] > 100.0 * errors[2] > 0.0


REFUSED = {
    "stanford_arm": (Settings(), "has a user-constraint, which lanes cannot evaluate"),
    "kepler": (Settings(), "particles have a core of their own"),
    "pendulum": (Settings(step=1e-2, method="rk4"), "dop853 with tolerances"),
    "double_pendulum": (Settings(outputs="dense"), "lanes end steps at outputs"),
    "slider_crank": (Settings(stabilization="baumgarte"), "lanes project"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_lanes_cannot_is_as_without_them_and_says_why(name):
    settings, why = REFUSED[name]
    scene, settings = scenes.make(name), settings.model_copy(update={"t_end": 0.1, "samples": 3, "estimate": "off"})
    assert why in why_not_in_lanes(scene, settings)
    start = some(poses(simulate(scene, settings)), slice(0, 1))
    with_lanes, without = (simulate_starts(scene, start, settings, lanes=lanes)[0] for lanes in (True, False))
    assert np.array_equal(with_lanes.position, without.position)
    assert with_lanes.notes != without.notes
    assert any(why in note and note.startswith("not in lanes: ") for note in with_lanes.notes)


def test_a_start_with_redundant_rows_runs_alone_and_says_so():
    """Three cranks of one length hold a coupler twice as often as one of them must."""
    cranks = [PlanarBody(name=f"crank{x}", mass=1.0, inertia=0.1, position=(x, 0.5), angle=0.5 * np.pi)
              for x in (0.0, 1.0, 2.0)]  # fmt: skip
    coupler = PlanarBody(name="coupler", mass=1.0, inertia=0.4, position=(1.0, 1.0))
    pins = [Revolute(name=f"{end}{x}", body_a=f"crank{x}", body_b=body, point=(x, y))
            for x in (0.0, 1.0, 2.0) for end, body, y in (("foot", GROUND, 0.0), ("head", "coupler", 1.0))]  # fmt: skip
    bodies = (*cranks, coupler)
    scene = Scene(name="three_cranks", gravity=(1.0, -9.81), duration=0.1, bodies=bodies, joints=tuple(pins))
    lean = Settings(samples=2, rtol=1e-6, estimate="off", reactions=False)
    alone = simulate(scene, lean)
    path = simulate_starts(scene, some(poses(alone), slice(0, 1)), lean, lanes=True)[0]
    assert alone.ok, alone.message
    assert path.notes[0] == "not in lanes: 1 constraint rows are redundant"
    assert np.array_equal(path.position, alone.position)


EVENTFUL = {  # a scene, its parameters, and the time (s) that its runs take
    "a force that a gap ends": ("bouncing_ball", {}, 0.2),
    "impacts, then rest on a constraint": ("bouncing_ball", {"law": "rigid", "gravity": 9.81}, 0.6),
    "two bodies that meet": ("newtons_cradle", {}, 0.4),
    "sticking in the plane": ("incline", {"angle": 0.2}, 0.2),
    "sticking in space": ("bouncing_sphere", {"law": "spring_damper"}, 0.2),
    "belts, stops and a pulse with breakpoints": ("android_simplified", {}, 0.12),
    "a prescribed motion": ("driven_pendulum", {}, 0.3),
    "rows that others repeat": ("spatial_n_four_bar", {"loops": 1}, 0.3),
    "a rolling wheel": ("bicycle", {}, 0.3),
}


@pytest.mark.parametrize("what", EVENTFUL)
def test_events_and_rows_in_lanes_are_those_of_runs_alone(what):
    name, parameters, duration = EVENTFUL[what]
    scene = scenes.make(name, **parameters)
    rtol = 1e-8
    settings = Settings(t_end=duration, samples=4, rtol=rtol, estimate="off")
    first = simulate(scene, Settings(t_end=0.5 * duration, samples=WIDTH + 2, rtol=1e-10, estimate="off"))
    starts = some(poses(first), [0] * WIDTH if name == "driven_pendulum" else slice(0, WIDTH + 1))
    settings = settings.model_copy(update={"coordinates": "cartesian" if any(no_tree(scene)) else "relative"})
    count = 0
    for k, path in enumerate(simulate_starts(scene, starts, settings, threads=1, lanes=True)):
        alone = simulate(scene, settings, start=some(starts, slice(k, k + 1)))
        assert is_beside(path)
        assert path.status is alone.status
        assert path.steps == pytest.approx(alone.steps, rel=0.1)  # at the limit of stability roundoff rejects a step
        assert path.notes[1:] == alone.notes
        for part, other in zip(poses(path), poses(alone), strict=True):
            assert np.max(np.abs(part - other)) < rtol * max(1.0, float(np.max(np.abs(other))))
        for mine, forces in ((path.reactions, alone.reactions), (path.contacts, alone.contacts)):
            for part, force in forces.items():
                np.testing.assert_allclose(mine[part], force, rtol=0.0, atol=1e-6 * max(1.0, np.max(np.abs(force))))
        if alone.event_times is not None:
            np.testing.assert_allclose(path.event_times, alone.event_times, rtol=0.0, atol=1e-9)
            count += len(alone.event_times)
    assert count > 0 or not (scene.contacts or scene.loads)


def test_runs_pass_a_singular_pose_in_their_lanes(monkeypatch):
    """A parallelogram whose bars fall in line goes on as one, at the energy that it began with."""
    scene, rtol = scenes.make("n_four_bar", loops=2), 1e-9
    starts = poses(simulate(scene, Settings(t_end=0.5, samples=WIDTH + 2, rtol=1e-11, estimate="off")))
    settings = Settings(t_end=1.0, samples=21, rtol=rtol, estimate="off", reactions=False)
    alone = [simulate(scene, settings, start=some(starts, slice(k, k + 1))) for k in range(WIDTH + 2)]
    monkeypatch.setattr(many_lanes, "run_legs", lambda *_: pytest.fail("a run left its lane"))
    paths = simulate_starts(scene, starts, settings, threads=1, lanes=True)
    assert sum("singular pose" in " ".join(path.notes) for path in paths) > 2
    for path, other in zip(paths, alone, strict=True):
        assert np.max(np.abs(path.position - other.position)) < rtol
        energy = energies(scene, path)
        assert np.max(np.abs(energy - energy[0])) < 100.0 * rtol * np.max(np.abs(energy))


def test_all_companions_of_a_batch_are_in_lanes(monkeypatch):
    """Of some runs steps of twice the size show no order: a run with a tenth of the tolerance follows."""
    scene = scenes.make("spatial_chain", links=4)
    starts = poses(simulate(scene, Settings(t_end=0.5, samples=4 * WIDTH, rtol=1e-9, estimate="off")))
    settings = Settings(t_end=1.0, samples=34, rtol=1e-6, reactions=False, coordinates="relative")
    alone = [simulate(scene, settings, start=some(starts, slice(k, k + 1))) for k in range(4 * WIDTH)]
    for module in (many_lanes, error_estimate):
        monkeypatch.setattr(module, "run_legs", lambda *_: pytest.fail("a run left its lane"))
    paths = simulate_starts(scene, starts, settings, threads=1, lanes=True)
    assert 1 < sum("1/10 of the tolerance" in path.estimate.how for path in paths) < len(paths)
    for path, other in zip(paths, alone, strict=True):
        assert path.estimate.how == other.estimate.how
        assert path.estimate.components == pytest.approx(other.estimate.components, rel=0.1, abs=ROUNDOFF)
        assert path.estimate.cost_s > 0.0


def test_a_companion_by_another_method_runs_alone(monkeypatch):
    def by_another(system, plan, run):
        request = error_estimate._by_another_method(plan)
        return request, request, False

    monkeypatch.setattr(error_estimate, "SECOND_METHOD", "radau")
    monkeypatch.setattr(error_estimate, "_is_coarsened", lambda *_: False)
    monkeypatch.setattr(error_estimate, "_first_two", by_another)
    scene = loop()
    starts = poses(simulate(scene, Settings(t_end=1.0, samples=3, rtol=1e-9, estimate="off")))
    for k, path in enumerate(simulate_starts(scene, starts, SHORT, threads=1, lanes=True)):
        alone = simulate(
            scene, SHORT.model_copy(update={"coordinates": "cartesian"}), start=some(starts, slice(k, k + 1))
        )
        assert is_beside(path)
        assert "radau instead of dop853" in path.estimate.how
        assert path.estimate.components == pytest.approx(alone.estimate.components, rel=0.1, abs=ROUNDOFF)


def energies(scene, path):
    """Return kinetic and potential energy (J) of planar bodies at every output (n_t,)."""
    mass, inertia = (np.array([getattr(body, name) for body in scene.bodies]) for name in ("mass", "inertia"))
    kinetic = 0.5 * (mass * np.sum(path.velocity**2, axis=2) + inertia * path.angular_velocity**2)
    return np.sum(kinetic - mass * (path.position @ scene.gravity), axis=1)


@pytest.mark.parametrize("seed", range(12))
def test_random_mechanisms_move_in_lanes_as_alone(seed):
    scene, rtol = random_scene(seed), 1e-9
    settings = Settings(t_end=DURATION, samples=3, rtol=rtol, estimate="off")
    settings = settings.model_copy(update={"coordinates": "cartesian" if any(no_tree(scene)) else "relative"})
    path, again = simulate_scenes([scene, scene], settings, threads=1, lanes=True)
    alone = simulate(scene, settings)
    assert is_beside(path) or "redundant" in path.notes[0]
    assert (path.status, len(path.times)) == (alone.status, len(alone.times))
    for part, twin, other in zip(poses(path), poses(again), poses(alone), strict=True):
        assert np.array_equal(part, twin)
        assert np.max(np.abs(part - other)) < 10.0 * rtol * max(1.0, float(np.max(np.abs(other))))


def test_balls_bounce_when_mechanics_lets_them():
    """A ball that falls from h lands after sqrt(2 h / g), and again after 2 e v / g, 2 e^2 v / g, ... ."""
    gravity, share = 9.81, 0.5
    heights = np.linspace(0.05, 0.2, WIDTH + 3)
    many = [scenes.make("bouncing_ball", law="rigid", gravity=gravity, height=h, speed=0.0, restitution=share,
                        duration=0.5) for h in heights]  # fmt: skip
    for height, path in zip(heights, simulate_scenes(many, Settings(rtol=1e-10, samples=3), lanes=True), strict=True):
        assert is_beside(path)
        assert path.event_times is not None
        speed = np.sqrt(2.0 * gravity * height)
        flights = [speed / gravity, *(2.0 * share**n * speed / gravity for n in range(1, 4))]
        expected = np.cumsum(flights)
        expected = expected[expected < 0.5]
        np.testing.assert_allclose(path.event_times[: len(expected), 0], expected, rtol=0.0, atol=1e-9)


def test_a_run_with_contacts_does_not_depend_on_those_beside_it():
    scene, lean = scenes.make("bouncing_ball"), Settings(t_end=0.2, samples=3, estimate="off")
    starts = poses(simulate(scene, Settings(t_end=0.1, samples=COUNT, rtol=1e-10, estimate="off")))
    every = simulate_starts(scene, starts, lean, threads=1, lanes=True)
    places = [COUNT - 1, 4, 0]
    for k, path in zip(places, simulate_starts(scene, some(starts, places), lean, threads=2, lanes=True), strict=True):
        for part, other in zip(poses(path), poses(every[k]), strict=True):
            assert np.array_equal(part, other)
        assert np.array_equal(path.event_times, every[k].event_times)


def test_each_scene_is_projected_to_the_tolerance_of_its_own_size():
    sizes, loose = (1e4, 1.0, 0.01), Settings(t_end=0.2, samples=4, rtol=1e-5, estimate="off")
    many = [scenes.make("slider_crank", crank_length=0.5 * size, rod_length=1.2 * size) for size in sizes]
    for size, scene, path in zip(sizes, many, simulate_scenes(many, loose, lanes=True), strict=True):
        alone = simulate(scene, loose)
        assert is_beside(path)
        assert path.step_compliance is not None
        assert alone.step_compliance is not None
        left, other = (np.max(one.step_compliance[:, 1]) for one in (path, alone))
        assert left < max(2.0 * other, 1e-15 * size)


def test_a_run_that_ends_early_says_so_and_leaves_the_others_alone():
    scene = scenes.make("pendulum_chain", links=2)
    starts = poses(simulate(scene, SHORT))
    starts.position[1] += 0.1
    starts.velocity[2, 1] += 1e-3
    paths = simulate_starts(scene, starts, SHORT, lanes=True)
    assert [path.status for path in paths] == [Status.SUCCESS, Status.INCONSISTENT, Status.INCONSISTENT, Status.SUCCESS]
    few = SHORT.model_copy(update={"max_steps": 3})
    path = simulate_starts(scene, some(starts, slice(0, 1)), few, lanes=True)[0]
    alone = simulate(scene, few, start=some(starts, slice(0, 1)))
    assert (path.status, path.message) == (alone.status, alone.message) == (Status.TOO_MANY_STEPS, alone.message)
    assert len(path.times) == len(alone.times)


def test_no_starts_give_no_runs():
    scene = chain()
    none = some(poses(simulate(scene, SHORT)), slice(0, 0))
    assert simulate_starts(scene, none, SHORT, lanes=True) == []


def heavier(scene, share, gravity):
    """Return a scene with other masses, inertias and gravity."""
    changes = [{"mass": share * body.mass, "inertia": share**1.5 * body.inertia} for body in scene.bodies]
    bodies = [body.model_copy(update=change) for body, change in zip(scene.bodies, changes, strict=True)]
    return scene.model_copy(update={"bodies": tuple(bodies), "gravity": (0.3 * share, -gravity)})


def test_scenes_of_one_build_take_the_steps_of_scenes_alone():
    """Some of another build and duration lie between them, one with a contact, and one that breaks a constraint."""
    many = [heavier(scenes.make("pendulum_chain", links=3), 0.5 + 0.1 * k, 3.0 + k) for k in range(COUNT)]
    many += [planar_tree(), scenes.make("pendulum_chain", links=2), scenes.make("bouncing_ball"), many[0]]
    many[4] = many[4].model_copy(update={"duration": 7.0})
    torn = many[5].bodies[0].model_copy(update={"velocity": (1.0, 0.0)})
    many[5] = many[5].model_copy(update={"bodies": (torn, *many[5].bodies[1:])})
    settings = SHORT.model_copy(update={"t_end": None})
    paths = simulate_scenes(many, settings, threads=2, lanes=True)
    assert paths[5].status is Status.INCONSISTENT
    assert [k for k, path in enumerate(paths) if not is_beside(path)] == [5]
    for k, path in enumerate(paths):
        if is_beside(path):
            assert_close(path, simulate(many[k], settings))
    for part, other in zip(poses(paths[0]), poses(paths[-1]), strict=True):
        assert np.array_equal(part, other)


def test_each_pendulum_is_back_after_the_periods_of_its_own_gravity():
    """At k^2 times the gravity the period is a k-th: all of them are back at once, after k swings."""
    swings = range(1, WIDTH + 3)
    scene = scenes.make("pendulum_chain", links=1, gravity=9.81)
    many = [scene.model_copy(update={"gravity": (0.0, -9.81 * k**2)}) for k in swings]
    settings = Settings(rtol=1e-10, t_end=PERIOD, samples=2, estimate="off")
    for k, path in zip(swings, simulate_scenes(many, settings, lanes=True), strict=True):
        assert is_beside(path)
        assert 0.0 < np.linalg.norm(path.velocity[-1] - path.velocity[0]) < 1e-7 * k
