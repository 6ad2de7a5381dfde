"""A run's own estimate of its error, against truths: never far below, seldom ten times above."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from cross_checks.extremes.parts import rod_chain
from cross_checks.truths import truth_for
from cross_checks.truths.of import sky
from cross_checks.truths.oracle.random_scenes import random_scene
from mbs_ref import scenes
from mbs_ref.observables.distance import largest, relative
from mbs_ref.scene import (
    GROUND,
    Force,
    PlanarBody,
    PointMass,
    Prismatic,
    Scene,
    SpatialBody,
    SpringDamper,
    UserForce,
    Weld,
)
from mbs_ref.scene.celestial import Newton, Oblateness
from mbs_ref.scene.scales import scales_of
from mbs_ref.scene.signals import HalfSine
from mbs_ref.scenes.blocks import incline as incline
from mbs_ref.settings import Settings
from mbs_ref.simulate import error_estimate, simulate
from mbs_ref.simulate.error_estimate import SAFETY, _richardson
from mbs_ref.trajectory import VISIBLE, Estimate, Status, Trajectory

TIGHT = 1e-13  # relative tolerance of a truth


def error(scene: Scene, path: Trajectory) -> float:
    """Return how far a run is from one with a far tighter tolerance, over the scene's scales."""
    fine = simulate(scene, Settings(rtol=TIGHT, estimate="off", reactions=False), path.times)
    assert fine.ok, fine.message
    return float(largest(relative(scene, path, fine, np.inf)))


def of(path: Trajectory) -> Estimate:
    assert path.estimate is not None, path.message
    return path.estimate


def assert_honest(path: Trajectory, true: float) -> None:
    assert true <= of(path).value <= 10.0 * true, f"{path.estimate} of {true}"


# --- the four runs that were far off, and called success without a word --------------------------------------


@pytest.mark.parametrize(("method", "rtol"), [("radau", 1e-8), ("dop853", 1e-5)])
def test_errors_made_close_to_a_singular_pose_follow_no_tolerance(method, rtol):
    """The flat poses of A02: what a step makes there depends on its place, so two runs agree by chance."""
    scene = scenes.make("n_four_bar", loops=1)
    path = simulate(scene, Settings(method=method, rtol=rtol, samples=41, reactions=False))

    def pendulum(_: float, state: np.ndarray) -> list[float]:
        """Three rods of 1 kg and 1 m: two cranks swing about their ends, the coupler does not turn."""
        return [state[1], -2.0 * 9.81 / (2.0 / 3.0 + 1.0) * math.cos(state[0])]

    fine = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-13}
    exact = solve_ivp(pendulum, (0.0, 10.0), [0.5 * math.pi, -1.0], t_eval=path.times, **fine).y.T
    errors = np.abs(np.column_stack((path.orientation[:, 0], path.angular_velocity[:, 0])) - exact)
    assert errors.max() > 1e-9
    assert np.all(errors <= of(path).components[:, [1, 3]] / [1.0, of(path).time] + 1e-11)


def test_a_chain_of_three_rods_after_ten_seconds_says_how_far_it_is_off_and_since_when():
    scene = rod_chain("chain", (0.9, 0.4, 0.0), (1.0, 1.0, 1.0))
    path = simulate(scene, Settings(t_end=10.0))
    true = error(scene, path)
    assert true > 0.5
    assert_honest(path, true)
    until = of(path).holds_until
    assert until is not None
    assert 3.0 < until < 10.0
    assert any(f"the digits hold until t = {until:g} s" in note for note in path.notes)
    good = path.times <= until
    fine = simulate(scene, Settings(rtol=TIGHT, estimate="off", reactions=False), path.times[good])
    assert np.abs(path.position[good] - fine.position).max() < VISIBLE * of(path).size * scales_of(scene).length


def test_a_double_pendulum_after_twenty_seconds_says_how_far_it_is_off():
    scene = scenes.make("double_pendulum", angle_1=2.0, angle_2=2.5)
    path = simulate(scene, Settings(t_end=20.0))
    true = error(scene, path)
    assert true > 1.0
    assert_honest(path, true)


@pytest.mark.parametrize("method", ["dop853", "lsodar"])
@pytest.mark.parametrize("figure", [False, True])
def test_two_orbits_close_to_a_collision_say_how_far_they_are_off(method, figure):
    """A figure of 1e-30 moves nothing; with it no energy is known to be conserved."""
    scene = scenes.builder_of("kepler")(eccentricity=1.0 - 1e-4, orbits=2.0)
    times = np.linspace(0.0, 4.0 * math.pi, 101)
    exact = sky.kepler(scene, times).position
    if figure:
        load = Oblateness(name="figure", body=scene.bodies[0].name, radius=1e-3, zonal=(1e-30,))
        scene = scene.model_copy(update={"loads": (*scene.loads, load)})
    path = simulate(scene, Settings(method=method, rtol=1e-6), times)
    true = float(np.linalg.norm(path.position - exact, axis=2).max())
    assert true > 0.1
    assert_honest(path, true)


# --- what it must not miss -----------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["dop853", pytest.param("lsodar", marks=pytest.mark.slow)])
@pytest.mark.parametrize("gap", [1e-2, 1e-6, 1e-8])
@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10])
def test_a_near_collision_is_not_off_by_more_than_it_says(method, gap, rtol):
    scene = scenes.builder_of("kepler")(eccentricity=1.0 - gap, orbits=2.0)
    path = simulate(scene, Settings(method=method, rtol=rtol, t_end=4.0 * math.pi, samples=9))
    if path.ok:
        assert np.linalg.norm(path.position - sky.kepler(scene, path.times).position, axis=2).max() < of(path).value


@pytest.mark.parametrize("method", ["dop853", "lsodar", "radau"])
@pytest.mark.parametrize("rtol", [
    1e-2, pytest.param(1e-4, marks=pytest.mark.slow), 1e-6, pytest.param(1e-8, marks=pytest.mark.slow), 1e-10,
])  # fmt: skip
def test_a_tolerance_is_not_taken_at_its_word(method, rtol):
    scene = scenes.make("slider_crank")
    path = simulate(scene, Settings(method=method, rtol=rtol, t_end=2.0))
    assert_honest(path, error(scene, path))


@pytest.mark.parametrize(
    ("name", "method", "rtol", "t_end"),
    [("kepler", "gauss", 1.72e-9, 11.408386643190838), ("bouncing_ball", "dop853", 1.69e-8, 0.20791137153657277)],
)
def test_a_companion_that_takes_the_same_long_step_is_not_believed(name, method, rtol, t_end):
    """Both take the step that errs most alike: a growing one at the start, the one from an impact to an output."""
    scene = scenes.make(name)
    path = simulate(scene, Settings(method=method, rtol=rtol, atol=rtol, t_end=t_end, samples=21))
    exact = truth_for(scene, path.times)
    assert exact is not None
    far = np.linalg.norm(path.position - exact.position, axis=2).max() / scales_of(scene).length
    assert 0.0 < far <= of(path).value


@pytest.mark.parametrize(("method", "step"), [("euler", 1e-3), ("rk4", 2e-2), ("dop853", 0.1), ("radau", 0.02)])
def test_a_step_says_what_it_costs(method, step):
    scene = scenes.make("pendulum")
    path = simulate(scene, Settings(method=method, step=step, t_end=4.0, samples=11))
    assert_honest(path, error(scene, path))


def test_outputs_that_end_every_step_do_not_hide_it():
    """Between outputs close to each other a tolerance has no say, nor has a step longer than the way between them."""
    scene, times = scenes.make("pendulum"), np.linspace(0.0, 4.0, 41)
    for settings in (Settings(rtol=1e-3), Settings(method="rk4", step=1.0)):
        path = simulate(scene, settings, times)
        assert path.steps <= 41
        assert_honest(path, error(scene, path))


@pytest.mark.parametrize("coordinates", ["cartesian", "relative"])
def test_outputs_that_end_every_step_are_judged_by_steps_of_twice_the_size(coordinates):
    scene = scenes.make("pendulum_chain", links=5)
    path = simulate(scene, Settings(coordinates=coordinates, rtol=1e-6, reactions=False))
    assert path.rhs_calls <= 12 * path.steps + 12  # as many as stages: a slope at a step's end serves the next step
    assert "twice the size" in of(path).how
    assert error(scene, path) <= of(path).value <= 30.0 * error(scene, path)


@pytest.mark.parametrize("seed", [140, 207, 213, 739])
def test_steps_that_declared_breakpoints_end_are_not_taken_for_doubled_ones(seed):
    scene = random_scene(seed, most=3)
    path = simulate(scene, Settings(method="dop853", rtol=1e-6, t_end=8.0 * scene.duration, reactions=False))
    assert scene.breakpoints()
    assert error(scene, path) <= of(path).value


@pytest.mark.parametrize(("method", "stiffness"), [("generalized_alpha", 1e7), ("radau", 1e12)])
def test_a_motion_that_steps_damp_away_before_the_first_output_is_missed(method, stiffness):
    """A slider rings on a stiff spring; hundreds of steps of a millisecond leave nothing of it, as half of them do."""
    body = PlanarBody(name="slider", mass=1.0, inertia=0.1, position=(1.1, 0.0))
    guide = Prismatic(name="guide", body_a=GROUND, body_b="slider", point=(1.1, 0.0), axis=(1.0, 0.0))
    spring = SpringDamper(name="spring", body_a=GROUND, body_b="slider", point_a=(0.0, 0.0), point_b=(1.1, 0.0),
                          stiffness=stiffness, rest_length=1.0)  # fmt: skip
    scene = Scene(name="ringing", bodies=(body,), joints=(guide,), loads=(spring,))
    path = simulate(scene, Settings(method=method, step=1e-3, t_end=1.0, samples=3))
    exact = 1.0 + 0.1 * np.cos(math.sqrt(stiffness) * path.times)
    assert of(path).value > np.abs(path.position[:, 0, 0] - exact).max() > 0.03
    assert path.status is Status.UNRESOLVED


def test_a_drift_off_the_constraints_that_two_runs_share_is_measured():
    """Index 1 lets a body that hangs on a weld fall through roundoff, in every run alike."""
    body = PlanarBody(name="body", mass=3.0, inertia=0.4, position=(0.7, 0.3), angle=0.4)
    weld = Weld(name="weld", body_a=GROUND, body_b="body", point=(0.1, -0.2))
    load = Force(name="load", body="body", point=(0.9, 0.1), vector=(700.0, -300.0))
    scene = Scene(name="hung", bodies=(body,), joints=(weld,), loads=(load,))
    path = simulate(scene, Settings(method="dassl_index1", rtol=1e-12, t_end=20.0, samples=5))
    drift = float(np.linalg.norm(path.position[-1, 0] - path.position[0, 0]))
    assert drift > 1e-13
    assert of(path).components[-1, 0] * scales_of(scene).length >= drift


def plunge(sideways: float) -> Scene:
    """A close pass of a hundredth of the distance, gone through between two outputs."""
    still = (0.0, 0.0, 0.0)
    bodies = (
        PointMass(name="center", mass=1.0, position=still, velocity=still),
        PointMass(name="planet", mass=1.0, position=(1.0, 0.0, 0.0), velocity=(0.0, sideways, 0.0)),
    )
    return Scene(name="plunge", gravity=still, bodies=bodies, loads=(Newton(name="newton", gm=(1.0, 0.0)),))


@pytest.mark.parametrize("sideways", [0.1, 0.0])
def test_a_close_pass_between_outputs_is_seen_in_what_follows(sideways):
    path = simulate(plunge(sideways), Settings(method="rk4", step=1e-3, t_end=1.5, samples=4))
    assert of(path).holds_until == 1.0
    assert any("the digits hold until t = 1 s" in note for note in path.notes)


@pytest.mark.parametrize("size", [1.0, 1e-4, 1e-7])
def test_a_small_machine_is_as_honest_as_a_large_one(size):
    """The default absolute tolerance, 1e-3 m, is wider than the small ones' whole motion."""
    bodies = (PlanarBody(name="disc", mass=1.0, inertia=size**2, position=(0.75 * size, 0.0)),)
    load = SpringDamper(name="spring", body_a=GROUND, body_b="disc", point_a=(0.0, 0.0), point_b=(0.75 * size, 0.0),
                        stiffness=100.0, rest_length=0.5 * size)  # fmt: skip
    scene = Scene(name="disc", gravity=(0.0, 0.0), bodies=bodies, loads=(load,))
    path = simulate(scene, Settings(method="dop853", rtol=1e-3, t_end=10.0, samples=51))
    exact = size * (0.5 + 0.25 * np.cos(10.0 * path.times))
    assert np.abs(path.position[:, 0, 0] - exact).max() <= of(path).value


def pushed(duration: float) -> Scene:
    push = HalfSine(peak=1.0, duration=duration, start=0.50031)
    force = Force(name="push", body="sled", point=(0.0, 0.0), vector=(1.0 / duration, 0.0), factor=push)
    return Scene(name="sled", bodies=(PlanarBody(name="sled", mass=1.0, inertia=1.0),), loads=(force,))


@pytest.mark.parametrize("method", ["euler", "rk4"])
@pytest.mark.parametrize("duration", [1e-3, 1e-6])
def test_a_declared_pulse_shorter_than_a_step_gets_steps_of_its_own(method, duration):
    """The speed after it is 2/pi m/s, whatever its duration."""
    scene = pushed(duration)
    path = simulate(scene, Settings(method=method, step=1e-2, t_end=1.0))
    assert path.velocity[-1, 0, 0] == pytest.approx(2.0 / math.pi, rel=0.06 if method == "euler" else 1e-3)
    assert_honest(path, float(np.max(np.abs(path.position[-1, 0, 0] - 2.0 / math.pi * (1.0 - 0.50031 - duration / 2)))))


@pytest.mark.parametrize(("width", "notes"), [(1e-4, 1), (0.2, 0)])
def test_a_pulse_of_a_users_force_between_the_steps_is_noted(width, notes):
    def pulse(t, q, v):
        return np.array([[1.0 / width if 0.31234 <= t < 0.31234 + width else 0.0, 0.0, 0.0]])

    load = UserForce(name="push", function=pulse)
    scene = Scene(name="sled", bodies=(PlanarBody(name="sled", mass=1.0, inertia=1.0),), loads=(load,))
    path = simulate(scene, Settings(t_end=1.0, samples=11))
    assert len([note for note in path.notes if "'push'" in note and "which no step resolves" in note]) == notes


@pytest.mark.parametrize("step", [0.012, 0.016, 0.02, 0.02415, 0.03])
def test_steps_longer_than_a_contact_have_no_smaller_estimate_than_error(step):
    """A contact of 10 ms is one step, of any step's half, too: two runs are alike and wrong."""
    scene = scenes.make("disc_between_walls")
    run = simulate(scene, Settings(method="radau", step=step, t_end=1.16, samples=21))
    assert error(scene, run) <= of(run).value


@pytest.mark.parametrize(("method", "step"), [("rk4", 1e-2), ("rk4", 3e-3), ("euler", 1e-3)])
@pytest.mark.parametrize("sideways", [0.2, 0.1])
def test_fixed_steps_past_a_close_encounter_have_no_smaller_estimate_than_error(method, step, sideways):
    times = np.linspace(0.0, 1.5, 21)
    fine = simulate(plunge(sideways), Settings(method="dop853", rtol=1e-13, estimate="off"), times)
    path = simulate(plunge(sideways), Settings(method=method, step=step), times)
    errors = np.linalg.norm(path.position - fine.position, axis=2).max(axis=1) / scales_of(plunge(sideways)).length
    assert np.all(errors <= of(path).components[:, 0])


def test_beyond_the_time_until_which_digits_hold_the_estimate_is_the_motion_itself():
    """A body leaves its unstable axis, and turns upside down."""
    body = SpatialBody(name="top", mass=1.0, inertia=(1.0, 2.0, 3.0, 0.0, 0.0, 0.0), angular_velocity=(1e-3, 1.0, 5e-4))
    scene = Scene(name="top", gravity=(0.0, 0.0, 0.0), bodies=(body,))
    estimate = of(simulate(scene, Settings(method="dop853", rtol=1e-2), np.linspace(0.0, 120.0, 13)))
    assert estimate.holds_until is not None
    lost = estimate.times > estimate.holds_until
    assert np.all(estimate.components[lost, 1] > 3.0)
    assert np.all(estimate.components[~lost, 1] < 0.05)


# --- what it must not cry about -------------------------------------------------------------------------------


@pytest.mark.parametrize("rtol", [1e-2, 1e-5])
def test_a_block_at_rest_has_digits_however_little_it_trembles(rtol):
    path = simulate(incline(angle=0.26, friction=0.3), Settings(method="dop853", rtol=rtol, t_end=1.0, samples=21))
    assert path.ok, path.message
    assert of(path).holds_until is None


@pytest.mark.parametrize("settings", [Settings(rtol=1e-5), Settings(method="rk4", step=2e-3 * math.pi)])
def test_outputs_once_a_period_do_not_hide_how_far_the_motion_goes(settings):
    """Five orbits, looked at where each begins: errors of 1e-4 m are none on orbits of 2 m."""
    path = simulate(scenes.make("kepler", eccentricity=0.2, orbits=5.0), settings, 2.0 * math.pi * np.arange(6.0))
    assert path.ok, path.message
    assert of(path).holds_until is None


def test_what_a_tolerance_may_do_is_not_said():
    path = simulate(scenes.make("pendulum"), Settings(rtol=1e-8, t_end=1.0))
    assert of(path).value < 1e-6
    assert of(path).remark() == ""
    assert of(path).holds_until is None


def test_an_estimate_far_above_the_tolerance_is_said():
    scene = scenes.make("kepler", eccentricity=0.2, orbits=30.0)
    path = simulate(scene, Settings(rtol=1e-8, samples=31))
    assert any("more than 100 times the relative tolerance" in note for note in path.notes)


# --- how it is made ------------------------------------------------------------------------------------------


def test_it_is_switched_off_and_timed_outside_of_the_loop():
    scene = scenes.make("pendulum")
    off = simulate(scene, Settings(rtol=1e-8, estimate="off"))
    on = simulate(scene, Settings(rtol=1e-8))
    assert off.estimate is None
    assert np.array_equal(on.position, off.position)
    assert on.rhs_calls == off.rhs_calls
    assert of(on).cost_s > 0.0
    assert of(on).over_time.shape == on.times.shape
    assert np.all(np.diff(of(on).over_time) >= 0.0)


def test_a_run_without_a_digit_is_no_success():
    path = simulate(scenes.make("pendulum"), Settings(method="rk4", step=0.5, t_end=10.0, samples=2))
    assert path.status is Status.UNRESOLVED
    assert "no output has a digit" in path.message


def test_where_no_companion_ends_nothing_vouches_for_the_rest():
    """Only the first 400 evaluations succeed: those of the run itself, which needs fewer."""
    calls = []

    def tired(t, q, v):
        calls.append(t)
        return np.full((1, 3), np.nan if len(calls) > 400 and t > 0.5 else 1.0)

    scene = Scene(name="tired", bodies=(PlanarBody(name="sled", mass=1.0, inertia=1.0),),
                  loads=(UserForce(name="push", function=tired),))  # fmt: skip
    path = simulate(scene, Settings(method="rk4", step=1.25e-2, t_end=1.0, samples=5, reactions=False))
    assert of(path).value == math.inf
    assert of(path).to_dict()["value"] is None
    assert of(path).holds_until == 0.5
    assert "did not end" in of(path).how


def test_a_tolerance_at_roundoff_is_compared_with_a_coarser_one():
    scene = scenes.make("slider_crank")
    path = simulate(scene, Settings(rtol=2e-13, t_end=0.5))
    assert "10 times the tolerance" in of(path).how
    assert of(path).value > error(scene, path)


@pytest.mark.parametrize(("order", "factor"), [(1.0, 2.0), (4.0, 16.0 / 15.0)])
def test_what_two_runs_differ_by_is_extrapolated_to_the_error_of_the_coarser(order, factor):
    """e = C h^p of a step h and its half: the coarser errs by 2^p / (2^p - 1) of their difference (Richardson)."""
    assert _richardson(2.0**order) == pytest.approx(SAFETY * factor)


def test_where_both_companions_fail_another_method_is_the_witness(monkeypatch):
    """Companions by the run's own method may take one step, and so do not end."""
    rerun = error_estimate._rerun

    def failing(system, plan, *given):
        few = plan.options._replace(max_steps=1)
        return rerun(system, replace(plan, options=few) if plan.integrator.name == "radau" else plan, *given)

    monkeypatch.setattr(error_estimate, "_rerun", failing)
    path = simulate(scenes.make("pendulum"), Settings(method="radau", rtol=1e-8))
    assert path.ok, path.message
    assert "dop853 instead of radau" in of(path).how
    assert of(path).value < 1e-5


@pytest.fixture
def companions(monkeypatch) -> list[tuple[str, float]]:
    """Method and tolerance of every further run of a parallelogram's."""
    made, rerun = [], error_estimate._rerun

    def noted(system, plan, *given):
        made.append((plan.integrator.name, plan.options.rtol))
        return rerun(system, plan, *given)

    monkeypatch.setattr(error_estimate, "_rerun", noted)
    return made


@pytest.mark.parametrize(
    ("method", "rtol", "expected"),
    [
        ("dop853", 1e-8, [("dop853", 1e-11)]),
        ("dop853", 1e-12, [("dop853", 1e-13), ("dop853", 1e-11)]),  # nothing tighter is left
        ("dop853", 5e-13, [("dop853", 5e-12), ("lsodar", 5e-13)]),  # a coarser run is the first
    ],
)
def test_close_to_a_singular_pose_the_second_run_is_far_tighter_or_a_third_follows(companions, method, rtol, expected):
    simulate(scenes.make("n_four_bar", loops=1), Settings(method=method, rtol=rtol, t_end=1.0, samples=3))
    assert [name for name, _ in companions] == [name for name, _ in expected]
    assert [at for _, at in companions] == pytest.approx([at for _, at in expected], rel=1e-6)


@pytest.mark.parametrize("settings", [Settings(rtol=1e-8), Settings(method="rk4", step=1e-2)])
def test_ctrl_c_in_a_companion_starts_no_further_one(companions, monkeypatch, settings):
    """Of the fixed step, it comes in the second one."""
    rerun = error_estimate._rerun

    def interrupted(*given):
        run = rerun(*given)
        return run._replace(status=Status.INTERRUPTED) if len(companions) == 1 + bool(settings.step) else run

    monkeypatch.setattr(error_estimate, "_rerun", interrupted)
    chosen = settings.model_copy(update={"t_end": 1.0, "samples": 3})
    path = simulate(scenes.make("n_four_bar", loops=1), chosen)
    assert path.estimate is None
    assert len(companions) == 1 + bool(settings.step)


def test_where_the_first_companion_ends_no_other_method_follows_those_that_do_not(companions, monkeypatch):
    """A method that takes far shorter steps there may cost far more than all of them."""
    rerun = error_estimate._rerun

    def failing(*given):
        run = rerun(*given)
        return run if len(companions) == 1 else run._replace(status=Status.STEP_TOO_SMALL)

    monkeypatch.setattr(error_estimate, "_rerun", failing)
    simulate(scenes.make("n_four_bar", loops=1), Settings(rtol=1e-12, t_end=1.0, samples=3))
    assert companions == [("dop853", pytest.approx(rtol)) for rtol in (1e-13, 1e-11)]


def test_where_a_sphere_stops_sliding_radau_has_an_estimate():
    """Its iteration fails at the search for that time at some tolerances; a shorter step then decides."""
    path = simulate(scenes.make("rolling_sphere"), Settings(method="radau", rtol=1e-8))
    assert path.ok, path.message
    assert of(path).value < 1e-7
