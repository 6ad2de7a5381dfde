"""A method that DOP853 carries past singular poses says so, and pays for it with no accuracy."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cross_checks.truths import truth_for
from mbs_ref import scenes
from mbs_ref.scene import GROUND, PlanarBody, PointDrive, Revolute, Scene
from mbs_ref.scene.signals import Polynomial
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate, simulate_scenes
from mbs_ref.trajectory import Status, Trajectory

G = 9.81  # m/s^2


def parallelograms(loops: int, faster: float = 1.0) -> Scene:
    """Flat twice a turn; `faster` compresses time by that factor."""
    scene = scenes.make("n_four_bar", loops=loops, gravity=G * faster**2)
    bodies = tuple(
        body.model_copy(update={
            "velocity": tuple(faster * v for v in body.velocity), "angular_velocity": faster * body.angular_velocity,  # type: ignore[operator]
        })
        for body in scene.bodies
    )  # fmt: skip
    return scene.model_copy(update={"bodies": bodies, "duration": scene.duration / faster})


def pendulum(loops: int) -> Scene:
    """One body that turns as every crank of `parallelograms` does: of their first and second mass moments."""
    first, second = loops + 0.5 * (loops + 1), loops + (loops + 1) / 3.0  # kg m, kg m^2
    mass = 2.0 * first
    body = PlanarBody(name="rod", mass=mass, inertia=second - 0.25 * mass, position=(0.0, 0.5), angle=0.5 * math.pi,
                      velocity=(0.5, 0.0), angular_velocity=-1.0)  # fmt: skip
    pivot = Revolute(name="pivot", body_a=GROUND, body_b="rod", point=(0.0, 0.0))
    return Scene(name="rod", gravity=(0.0, -G), duration=10.0, bodies=(body,), joints=(pivot,))


def turned(scene: Scene, method: str, rtol: float, t_end: float) -> Trajectory:
    run = simulate(scene, Settings(method=method, rtol=rtol, t_end=t_end, estimate="off", reactions=False))
    assert run.ok, run.message
    return run


def mean_error(scene: Scene, method: str, rtols: list[float], t_end: float) -> float:
    """Geometric mean over tolerances of a crank's largest error (rad) by tolerance: one alone is a matter of chance.

    Errors at two singular poses may cancel, and what is left moves by a factor of 30 from one tolerance to the next.
    """
    truth = turned(scene, "dop853", 1e-12, t_end).orientation[:, 0]
    errors = [np.abs(turned(scene, method, rtol, t_end).orientation[:, 0] - truth).max() / rtol for rtol in rtols]
    return float(np.exp(np.mean(np.log(errors))))


@pytest.mark.parametrize(("loops", "t_end", "count"), [
    (1, 3.0, 5), pytest.param(1, 10.0, 13, marks=pytest.mark.slow), pytest.param(3, 10.0, 13, marks=pytest.mark.slow),
])  # fmt: skip
@pytest.mark.parametrize("method", ["lsodar", "dassl"])
def test_singular_poses_cost_no_accuracy(method, loops, t_end, count):
    """Beside the pendulum that moves alike and has none."""
    rtols = np.geomspace(1e-5, 1e-9, count).tolist()
    passing, free = (mean_error(scene, method, rtols, t_end) for scene in (parallelograms(loops), pendulum(loops)))
    assert passing < 4.0 * free


@pytest.mark.parametrize("loops", [1, pytest.param(3, marks=pytest.mark.slow)])
def test_radau_errs_no_more_than_the_worse_of_the_two_that_make_its_run(loops):
    rtols = np.geomspace(1e-5, 1e-9, 5 if loops == 1 else 13).tolist()
    t_end = 3.0 if loops == 1 else 10.0
    passing, free = (mean_error(scene, "radau", rtols, t_end) for scene in (parallelograms(loops), pendulum(loops)))
    assert passing < 4.0 * max(free, mean_error(parallelograms(loops), "dop853", rtols, t_end))


@pytest.mark.parametrize("samples", [2, 4, 12, 38])
@pytest.mark.parametrize("scene", ["n_four_bar", "spatial_n_four_bar"])
def test_radau_passes_whatever_samples_are_asked(scene, samples):
    """Without help it stopped in half of such runs: its stages leave the constraints, where accelerations are noise."""
    run = simulate(scenes.make(scene), Settings(method="radau", rtol=1e-8, t_end=3.0, samples=samples, estimate="off"))
    assert run.ok, run.message


@pytest.mark.parametrize("method", ["lsodar", "dassl", "radau"])
def test_the_share_that_another_method_made_is_told(method):
    run = turned(parallelograms(2), method, 1e-7, 1.5)
    share = run.used["carried_share"]
    assert 0.02 < share < 0.2  # of two passages of 50 to 100 ms
    assert f"DOP853 carried {method} past singular poses, for {share:.2g} of the time" in run.notes


def test_the_share_does_not_depend_on_the_unit_of_time():
    """The same motion a hundred times as fast."""
    own, fast = (turned(parallelograms(2, k), "lsodar", 1e-7, 1.5 / k).used["carried_share"] for k in (1.0, 100.0))
    assert fast == pytest.approx(own, rel=0.2)


def test_a_method_that_needs_no_help_tells_of_its_settings_alone():
    run = turned(parallelograms(2), "dop853", 1e-7, 1.5)
    assert run.used.keys() == {"rtol", "atol", "projection_tolerance", "samples"}
    assert (run.used["rtol"], run.used["samples"]) == (1e-7, 101)


@pytest.mark.parametrize("scene", ["n_four_bar", "spatial_n_four_bar"])
def test_a_fixed_step_that_would_end_in_a_singular_pose_is_divided(scene):
    """Taken whole, the accelerations there are noise: the loops ended 2 m off, in the other branch, with success."""
    made = scenes.make(scene)
    step = {"step": 10.0 / 20480.0, "samples": 2, "t_end": 2.5, "estimate": "off"}
    run = simulate(made, Settings(method="rk4", **step))
    truth = simulate(made, Settings(method="dop853", rtol=1e-12, estimate="off", t_end=2.5, samples=2))
    assert run.ok
    assert 5120 < run.steps < 1.05 * 5120
    assert np.abs(run.position[-1] - truth.position[-1]).max() < 1e-7


@pytest.mark.parametrize("loops", [2, 10, 40])
def test_a_tolerance_that_rounding_forbids_near_a_singular_pose_does_not_end_the_run(loops):
    """With 10 and 40 loops the run ended with singular: each shorter step ended as close to the flat pose."""
    scene = scenes.make("n_four_bar", loops=loops)
    run = simulate(scene, Settings(method="dop853", rtol=1e-13, t_end=1.0, samples=2, estimate="off"))
    assert run.ok, run.message
    assert np.abs(run.position - truth_for(scene, run.times).position).max() < 1e-11


@pytest.mark.parametrize("rtol", [1e-3, 1e-5, 1e-7, 1e-9])
@pytest.mark.parametrize("method", ["lsodar", "dassl_index1"])
def test_a_method_that_drifts_stops_where_the_drift_would_choose_the_branch(method, rtol):
    """Going on, the loops opened into the other branch, 2 m off, and reported success."""
    scene = scenes.make("n_four_bar", loops=2)
    run = simulate(scene, Settings(method=method, rtol=rtol, stabilization="none", t_end=5.0, estimate="off"))
    assert run.status is Status.SINGULAR
    truth = simulate(scene, Settings(method="dop853", rtol=1e-11, estimate="off"), run.times)
    assert np.abs(run.position - truth.position).max() < 0.05


def reach(start: float) -> Scene:
    """An arm of 1 m at an angle (rad) on a pin, whose tip is driven from rest along x by 1 m/s^2, up to x = 1 m."""
    tip = math.cos(start), math.sin(start)
    arm = PlanarBody(name="arm", mass=1.0, inertia=0.1, position=(0.5 * tip[0], 0.5 * tip[1]), angle=start)
    pin = Revolute(name="pin", body_a=GROUND, body_b="arm", point=(0.0, 0.0))
    drive = PointDrive(name="drive", body="arm", point=tip, direction=(1.0, 0.0), level="acceleration",
                       motion=Polynomial(coefficients=(1.0,)))  # fmt: skip
    return Scene(name="reach", gravity=(0.0, 0.0), bodies=(arm,), joints=(pin, drive), duration=1.0)


@pytest.mark.parametrize("close", [0.9, 0.99, 0.999, 0.9999])
@pytest.mark.parametrize("start", [0.8, 2.0, 2.6])
def test_projection_close_to_the_end_of_a_reach_finds_no_mirrored_pose(start, close):
    """The tip is at x = cos(angle) = cos(start) + t^2 / 2."""
    settings = Settings(method="dop853", t_end=math.sqrt(2.0 * (close - math.cos(start))), samples=2, reactions=False)
    for rtol in (1e-4, 1e-6, 1e-8, 1e-11):
        one = settings.model_copy(update={"rtol": rtol})
        runs = [simulate(reach(start), one.model_copy(update={"outputs": outputs})) for outputs in ("landed", "dense")]
        for run in (*runs, *simulate_scenes([reach(start)] * 2, one, threads=1, lanes=True)):
            assert run.ok, run.message
            assert run.orientation[-1, 0] == pytest.approx(math.acos(close), abs=1e-9)
