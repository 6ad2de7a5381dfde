"""Ensembles against closed forms: linear motions carry mean and variance exactly, grids follow formulas."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy import stats
from scipy.linalg import expm
from scipy.special import ellipj

from mbs_ref import scenes
from mbs_ref.scene import GROUND, PlanarBody, PointMass, Scene, SpatialBody, SpringDamper
from mbs_ref.scene.celestial import Newton
from mbs_ref.scene.euler_parameters import rotation_matrices
from mbs_ref.scene.events import CoordinateEvent
from mbs_ref.settings import Settings
from mbs_ref.simulate.many.ensemble import (
    Source,
    Variants,
    account,
    coordinates,
    design,
    integration_error,
    not_shown,
    read_law,
    run_ensemble,
    runs,
    statistics,
    to_dict,
    values_of,
)
from mbs_ref.simulate.many.ensemble.statistics import _statistics

G, STIFFNESS, MASS = 9.81, 8.0, 2.0
BALL = Scene(name="ball", gravity=(0.0, -G), bodies=(PlanarBody(name="ball", mass=1.0, inertia=0.1),))
SPRING = SpringDamper(
    name="spring", body_a=GROUND, body_b="bob", point_a=(0.0, 0.0), point_b=(5.0, 0.0), stiffness=STIFFNESS
)
BOB = PointMass(name="bob", mass=MASS, position=(5.0, 0.0), velocity=(0.0, 0.0))
OSCILLATOR = Scene(name="oscillator", duration=2.0, bodies=(BOB,), loads=(SPRING,))


def ensemble(scene, laws, count=None, seed=0, fixed=(), rebuild=None, **settings):
    source = Source(scene, rebuild)
    targets = [source.target(name) for name in laws]
    read = {target.name: read_law(law, target.own) for target, law in zip(targets, laws.values(), strict=True)}
    return run_ensemble(
        Variants(source, targets, fixed), design(read, count, seed), Settings(samples=11, **settings), threads=1
    )


@pytest.fixture(scope="module")
def thrown():
    return ensemble(BALL, {"ball.velocity.x": "3+-0.5", "ball.velocity.y": "1..2", "ball.angular_velocity": "+-2"}, 400)


def column(made, name):
    return [f"{one.body}.{one.name}" for one in coordinates(made)].index(name)


def test_a_throw_spreads_as_its_velocity_does(thrown):
    """x = v t: mean, deviation, quantiles and extremes grow as t does."""
    (found,), t = statistics(thrown), thrown.times
    velocity = thrown.design.values[:, 0]
    k = column(thrown, "ball.x")
    assert found.count == 400
    assert found.mean[:, k] == pytest.approx(velocity.mean() * t, rel=1e-9)
    assert found.deviation[:, k] == pytest.approx(np.std(velocity, ddof=1) * t, rel=1e-9)
    assert found.least[:, k] == pytest.approx(velocity.min() * t, rel=1e-9)
    assert found.most[:, k] == pytest.approx(velocity.max() * t, rel=1e-9)
    # and the samples are those of the law: a hypercube's mean errs far less than independent samples do
    assert found.mean[-1, k] == pytest.approx(3.0 * t[-1], abs=0.1 * found.mean_error[-1, k])
    assert found.deviation[-1, k] == pytest.approx(0.5 * t[-1], abs=found.deviation_error[-1, k])
    law = stats.norm(3.0, 0.5)
    density = law.pdf(law.ppf([0.05, 0.5, 0.95]))  # a hypercube's quantiles err by two strata at most
    assert np.all(np.abs(found.quantiles[:, -1, k] / t[-1] - law.ppf([0.05, 0.5, 0.95])) < 2.0 / 400 / density)


def test_gravity_and_spin_are_where_they_belong(thrown):
    (found,), t = statistics(thrown), thrown.times
    falls = 1.5 * t - 0.5 * G * t**2
    assert found.mean[:, column(thrown, "ball.y")] == pytest.approx(falls, abs=1e-3)
    assert found.deviation[-1, column(thrown, "ball.y")] == pytest.approx(t[-1] / np.sqrt(12.0), rel=1e-2)
    assert found.deviation[-1, column(thrown, "ball.angle")] == pytest.approx(2.0 * t[-1], rel=1e-2)


def test_starts_alone_go_in_lanes_and_say_so(thrown):
    assert any("lanes" in sentence and "not in lanes" not in sentence for sentence in account(thrown, []))
    assert set(thrown.methods) == {"dop853"}
    assert thrown.counts == {"success": 400}


def test_a_stiff_scene_runs_by_an_implicit_method_in_place_of_lanes():
    scene = scenes.make("block_stack")
    name = scene.bodies[-1].name
    chosen, forced = (
        ensemble(scene, {f"{name}.velocity.x": "0+-1e-3"}, 4, t_end=0.5, method=method) for method in (None, "dop853")
    )
    assert set(chosen.methods) == {"radau"}
    assert any(
        sentence.startswith("not in lanes: stiff: stability limits the steps of dop853") for sentence in chosen.how
    )
    assert set(forced.methods) == {"dop853"}
    assert any(sentence.startswith("integrated in 8 lanes") for sentence in forced.how)


def test_an_oscillator_swings_between_the_deviations_of_its_start():
    """x = x0 cos w t + v0/w sin w t of a start that moves the spring's end with the body."""
    made = ensemble(OSCILLATOR, {"bob.position.x": "5+-0.1", "bob.velocity.x": "+-0.3"}, 100, rtol=1e-10)
    (found,), w, t = statistics(made), np.sqrt(STIFFNESS / MASS), made.times
    covariance = np.cov(made.design.values.T)
    cosine, sine = np.cos(w * t), np.sin(w * t) / w
    variance = covariance[0, 0] * cosine**2 + covariance[1, 1] * sine**2 + 2.0 * covariance[0, 1] * sine * cosine
    assert found.deviation[:, 0] == pytest.approx(np.sqrt(variance), rel=1e-8)
    assert made.design.values[:, 0] == pytest.approx(made.samples.position[:, 0, 0, 0], rel=1e-15)
    assert any("lanes" in sentence and "not in lanes" not in sentence for sentence in account(made, []))


def test_a_stiffness_and_a_start_vary_together():
    made = ensemble(OSCILLATOR, {"bob.position.x": "5+-0.1", "spring.stiffness": "7..9", "bob.mass": "1.5..2.5"}, 12,
                    rtol=1e-10)  # fmt: skip
    start, stiffness, mass = made.design.values.T
    w = np.sqrt(stiffness / mass)
    expected = 5.0 + (start - 5.0)[:, None] * np.cos(w[:, None] * made.times)
    assert values_of(made)[:, :, 0] == pytest.approx(expected, rel=1e-8)


def test_a_grid_of_pendulums_follows_the_elliptic_functions():
    """Released from the horizontal: sin(theta/2) = k cd(w t), k = sin(pi/4), w^2 = g/L."""
    rebuild = partial(scenes.make, "pendulum")
    made = ensemble(rebuild(), {"length": "0.5:2:4", "gravity": "5:10:2"}, rebuild=rebuild, t_end=3.0, rtol=1e-11)
    assert made.design.points.shape == (8, 2)
    for (length, gravity), found in zip(made.design.points, statistics(made), strict=True):
        _, cn, dn, _ = ellipj(np.sqrt(gravity / length) * made.times, 0.5)
        theta = 2.0 * np.arcsin(np.sqrt(0.5) * cn / dn)
        assert found.count == 1
        expected = -length * np.column_stack((np.sin(theta), np.cos(theta)))
        assert found.mean == pytest.approx(expected, abs=1e-8)
    assert not not_shown(made, statistics(made))


def test_the_same_seed_gives_the_same_numbers_to_the_bit():
    laws = {"ball.velocity.x": "3+-0.5"}
    first, again, other = (ensemble(BALL, laws, 10, seed) for seed in (1, 1, 2))
    assert np.array_equal(first.samples.position, again.samples.position)
    assert not np.any(first.samples.position[:, -1, :, 0] == other.samples.position[:, -1, :, 0])


def test_a_loop_that_does_not_close_is_a_row_and_no_crash():
    crank = scenes.make("slider_crank")
    laws = {"crank.angular_velocity": "10+-1"}
    broken = ensemble(crank, laws, 4, t_end=0.05)
    assert broken.counts == {"inconsistent": 4}
    assert np.isnan(broken.samples.position).all()
    assert statistics(broken) == [None]
    said = "\n".join(account(broken, [None]))
    assert "--keep" in said
    assert "omit 4 of 4 runs" in said


def test_a_projected_start_says_by_how_much_and_a_kept_velocity_is_as_asked():
    crank = scenes.make("slider_crank")
    laws = {"crank.angular_velocity": "10+-1"}
    projected = ensemble(crank, laws, 4, t_end=0.05, project_initial=True)
    assert projected.counts == {"success": 4}
    asked = projected.design.values[:, 0]
    found = projected.samples.angular_velocity[:, 0, crank.body_index("crank")]
    assert np.all(projected.corrections[:, 1] >= np.abs(found - asked) * (1.0 - 1e-12))
    assert projected.corrections[:, 1].min() > 0.1
    assert any("starts of 4 runs were projected" in one for one in account(projected, statistics(projected)))
    kept = ensemble(crank, laws, 4, t_end=0.05, fixed=("crank.angular_velocity",))
    assert kept.counts == {"success": 4}
    assert kept.samples.angular_velocity[:, 0, crank.body_index("crank")] == pytest.approx(asked, rel=1e-12)
    with pytest.raises(ValueError, match=r"crank.angle varies a pose"):
        ensemble(crank, {"crank.angle": "+-0.1"}, 4, fixed=("crank.angular_velocity",))


def test_when_an_event_ends_the_runs_is_told():
    """A ball falls a metre in sqrt(2/g); two of three reach that within the duration."""
    ground = CoordinateEvent(name="ground", body="ball", coordinate="y", value=-1.0, action="stop")
    made = ensemble(BALL.model_copy(update={"events": (ground,)}), {"gravity.y": "-5:-1:3"}, t_end=1.0)
    assert [str(status) for status in made.statuses] == ["stop-event", "stop-event", "success"]
    fallen = np.sqrt(2.0 / np.array([5.0, 3.0]))
    assert made.reached == pytest.approx([*fallen, 1.0], rel=1e-9)
    inside = made.times <= fallen[0]
    assert np.isnan(made.samples.position[0, ~inside]).all()
    assert made.samples.position[0, inside, 0, 1] == pytest.approx(-2.5 * made.times[inside] ** 2, abs=1e-9)
    told = f"an event ended 2 runs, at {fallen.mean():.6g} s on average, standard deviation {fallen.std(ddof=1):.4g} s"
    assert any(told in one for one in account(made, statistics(made)))
    assert not integration_error(made)[0].any()


def test_runs_that_cannot_be_are_counted_and_left_out():
    made = ensemble(BALL, {"ball.mass": "0.1+-1", "ball.velocity.x": "+-1"}, 20)
    refused = made.design.values[:, 0] <= 0.0
    assert 5 < refused.sum() < 15
    assert made.counts == {"success": 20 - refused.sum(), "refused": refused.sum()}
    assert np.array_equal(made.ended_well, ~refused)
    (found,) = statistics(made)
    assert found.count == 20 - refused.sum()
    assert found.mean[-1, 0] == pytest.approx(made.design.values[~refused, 1].mean(), rel=1e-9)
    assert any("refused: " in one and "mass" in one for one in account(made, [found]))


def test_a_scene_that_the_solver_refuses_is_a_row_too():
    """Two spheres a metre apart whose radii add up to more."""
    spheres = tuple(PointMass(name=f"p{k}", mass=1.0, position=(k, 0.0, 0.0), velocity=(0.0, 0.0, 0.0)) for k in (0, 1))
    newton = Newton(name="newton", gm=(1e-9, 1e-9), radius=(0.4, 0.1))
    scene = Scene(name="pair", gravity=(0.0, 0.0, 0.0), bodies=spheres, loads=(newton,))
    made = ensemble(scene, {"newton.radius.0": "0.5:1.5:5"})
    assert [str(status) for status in made.statuses] == ["success", "success", "refused", "refused", "refused"]
    assert "overlap at t = 0" in made.messages[-1]


def test_another_number_of_bodies_is_refused():
    rebuild = partial(scenes.make, "pendulum_chain")
    made = ensemble(rebuild(links=2), {"links": "2:3:2"}, rebuild=rebuild, t_end=0.1)
    assert [str(status) for status in made.statuses] == ["success", "refused"]
    assert "changes the number or names of bodies" in made.messages[1]


def test_a_spread_below_the_integration_error_is_said_not_to_be_shown():
    laws = {"bob.velocity.x": "1+-1e-9"}
    rough = ensemble(OSCILLATOR, laws, 8, method="rk4", step=0.05)
    (found,), w = statistics(rough), np.sqrt(STIFFNESS / MASS)
    exact = 5.0 + rough.design.values * np.sin(w * rough.times) / w
    true_error = np.abs(values_of(rough)[:, :, 0] - exact).max(axis=0)
    assert true_error[-1] > found.deviation[-1, 0]
    assert np.all(integration_error(rough)[:, 0] >= true_error * (1.0 - 1e-9))
    assert [one.name for one in not_shown(rough, [found])] == ["x"]
    assert any("the spread of bob.x is not shown" in one for one in account(rough, [found]))
    error = integration_error(rough)[-1, 0]
    for share, is_hidden in ((0.05, False), (0.2, True)):  # of the spread
        (wider,) = statistics(rough)
        scaled = replace(wider, deviation=np.full_like(wider.deviation, error / share))
        assert bool(not_shown(rough, [scaled])) == is_hidden
    fine = ensemble(OSCILLATOR, {"bob.velocity.x": "1+-0.1"}, 8)
    assert not not_shown(fine, statistics(fine))
    blind = ensemble(OSCILLATOR, {"bob.velocity.x": "1+-0.1"}, 8, estimate="off")
    assert np.isnan(integration_error(blind)).all()
    assert any("spread is unknown" in one for one in account(blind, statistics(blind)))


def test_a_motion_that_is_lost_in_chaos_shows_no_spread_of_turns_either():
    rebuild = partial(scenes.make, "double_pendulum", angle_1=2.0)
    made = ensemble(rebuild(), {"angle_2": "+-1%"}, 8, rebuild=rebuild, t_end=30.0)
    found = statistics(made)
    assert {f"{one.body}.{one.name}" for one in not_shown(made, found)} >= {"upper.angle", "lower.angle"}
    assert any("any number of turns" in one for one in account(made, found))


def test_standard_errors_are_what_repeated_samples_scatter_by():
    """Of 2000 samplings of 60 draws each, of a law with tails and of one without."""
    random = np.random.default_rng(1)
    for draws in (random.normal(size=(60, 2000)), random.uniform(size=(60, 2000))):
        found = _statistics(draws[:, None])
        assert np.mean(found.mean_error) == pytest.approx(draws.mean(axis=0).std(), rel=0.06)
        assert np.mean(found.deviation_error) == pytest.approx(draws.std(axis=0, ddof=1).std(), rel=0.08)


def test_a_hypercubes_mean_scatters_by_less_than_its_standard_error():
    """Of exp(x) y, which no sum of functions of x and of y is: over 300 seeds."""
    laws = {"x": read_law("0+-1", None), "y": read_law("-1..3", None)}
    drawn = np.array([design(laws, 20, seed).values for seed in range(300)])
    values = np.exp(drawn[:, :, 0]) * drawn[:, :, 1]
    told = np.sqrt(np.mean(values.var(axis=1, ddof=1) / 19))
    assert values.mean(axis=1).std() < told
    assert values.mean() == pytest.approx(np.exp(0.5), abs=4.0 * told / np.sqrt(300))


def test_every_point_of_a_grid_has_statistics_of_its_own():
    made = ensemble(BALL, {"gravity.y": "-10:-5:2", "ball.velocity.y": "1..2"}, 10)
    first, second = statistics(made)
    assert made.design.count == first.count == second.count == 10
    assert second.mean[-1, 1] - first.mean[-1, 1] == pytest.approx(0.5 * 5.0, rel=1e-9)
    assert second.deviation[:, 1] == pytest.approx(first.deviation[:, 1], abs=1e-12)


def test_ctrl_c_keeps_whole_portions(monkeypatch):
    made_so_far = []

    def interrupted(*arguments, **keywords):
        if made_so_far:
            raise KeyboardInterrupt
        made_so_far.append(1)
        return original(*arguments, **keywords)

    original = runs.simulate_starts
    monkeypatch.setattr(runs, "simulate_starts", interrupted)
    made = ensemble(BALL, {"ball.velocity.x": "3+-0.5"}, 50)
    assert not made.is_complete
    assert 0 < len(made.statuses) == len(made.samples.position) < 50
    (found,) = statistics(made)
    assert found.count == len(made.statuses)
    assert any("interrupted after" in one for one in account(made, [found]))
    assert len(to_dict(made)["runs"]) == len(made.statuses)


def test_the_pace_is_that_of_runs_after_the_solver_is_loaded(thrown):
    slow = replace(thrown, marks=((100, 10.0), (250, 11.0), (400, 13.0)))
    assert (slow.wall_s, slow.runs_per_s) == (13.0, 100.0)
    assert replace(thrown, marks=((400, 8.0),)).runs_per_s == 50.0


def test_samples_that_no_memory_holds_are_refused_before_any_run():
    with pytest.raises(ValueError, match="GiB"):
        ensemble(BALL, {"ball.velocity.x": "3+-0.5"}, 10_000_000)


def test_settings_that_make_no_sense_are_an_error_and_no_rows():
    with pytest.raises(ValueError, match="rk5"):
        ensemble(BALL, {"ball.velocity.x": "3+-0.5", "ball.position.x": "1..2", "ball.mass": "1..2"}, 5, method="rk5")


def test_a_body_in_space_is_turned_about_the_axes_of_the_world():
    """A brick that rests stays where it was turned to; one whose scene varies, too, all the same."""
    quarter = (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5))  # about z
    brick = SpatialBody(name="brick", mass=1.0, inertia=(1.0, 1.1, 1.2, 0.0, 0.0, 0.0), orientation=quarter)
    scene = Scene(name="brick", gravity=(0.0, 0.0, 0.0), bodies=(brick,))
    laws = {"brick.turn.x": "+-0.5", "brick.turn.z": "-1..1"}
    for more in ({}, {"brick.mass": "1..2"}):
        made = ensemble(scene, laws | more, 6)
        assert made.counts == {"success": 6}
        assert [one.name for one in coordinates(made)] == ["x", "y", "z"]
        for (x, z), theta in zip(made.design.values[:, :2], made.samples.orientation[:, -1, 0], strict=True):
            turn = expm(np.array([[0.0, -z, 0.0], [z, 0.0, -x], [0.0, x, 0.0]]))  # of the vector (x, 0, z)
            about_z = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
            assert np.allclose(rotation_matrices(theta), turn @ about_z, atol=1e-12)
