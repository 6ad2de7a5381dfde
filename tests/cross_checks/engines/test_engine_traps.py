"""Silent failures of the engines, provoked and caught: resets, NaN, halved steps, renamed settings."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cross_checks.engine import End, Plan
from mbs_ref import scenes
from mbs_ref.observables import constraint_residual
from mbs_ref.scene import GROUND, PlanarBody, PointMass, Prismatic, Revolute, Scene, SpringDamper
from mbs_ref.trajectory import Status
from tests.cross_checks.engines.engine_runs import engine, run

STIFF = Scene(
    name="stiff",
    bodies=(PointMass(name="bob", mass=1.0, position=(1.0, 0.0), velocity=(0.0, 1.0)),),
    loads=(
        SpringDamper(
            name="spring", body_a=GROUND, body_b="bob", point_a=(0.0, 0.0), point_b=(1.0, 0.0), stiffness=1e10,
            rest_length=0.9,
        ),
    ),
)  # fmt: skip


def spinning(rate: float) -> Scene:
    """Two hinged rods at a rate (rad/s) that no step of a millisecond resolves."""
    rods = tuple(
        PlanarBody(name=name, mass=1.0, inertia=0.1, position=(x, 0.0), velocity=(0.0, 0.5 * rate), angular_velocity=w)
        for name, x, w in (("near", 0.5, rate), ("far", 1.5, -rate))
    )
    pins = (
        Revolute(name="base", body_a=GROUND, body_b="near", point=(0.0, 0.0)),
        Revolute(name="elbow", body_a="near", body_b="far", point=(1.0, 0.0)),
    )
    return Scene(name="spinning", bodies=rods, joints=pins)


def test_mujocos_silent_reset_is_a_status():
    result = run("mujoco", "rk4", STIFF, step=1e-3, samples=11)
    assert result.status is Status.RESET
    assert "mujoco reset its state" in result.message
    assert "mjWARN_BAD" in result.message
    assert len(result.times) < 11
    assert np.isfinite(result.position).all()


def test_mujocos_warnings_leave_no_file_behind(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    test_mujocos_silent_reset_is_a_status()
    assert not list(tmp_path.iterdir())


def test_mujocos_clock_alone_betrays_a_reset():
    mujoco = pytest.importorskip("mujoco")
    from cross_checks.engines.mujoco_ import clock_end

    data = mujoco.MjData(mujoco.MjSpec().compile())
    times = np.array([0.0, 0.25, 0.5, 0.75])
    plan = Plan(engine("mujoco").method("rk4"), times, step=1e-3)
    assert clock_end(data, times + 1e-12, plan) == End(4)
    end = clock_end(data, np.array([0.0, 0.25, 0.1, 0.35]), plan)
    assert (end.samples, end.status) == (2, Status.RESET)
    assert "before t = 0.5 s and reports t = 0.1 s" in end.message


@pytest.mark.parametrize("method", ["tree_rk44", "trapezoidal", "generalized_alpha"])
def test_exudyns_overflow_is_a_status_and_never_a_sample(method):
    heavy = Scene(name="heavy", gravity=(0.0, -1e308), bodies=(STIFF.bodies[0],))
    for scene in (heavy, spinning(1e160)):
        result = run("exudyn", method, scene, step=1e-2, t_end=10.0, samples=11)
        assert result.status in (Status.NON_FINITE, Status.NOT_CONVERGED)
        assert " t = " in result.message
        assert len(result.times) < 11
        assert np.isfinite(result.position).all()


def test_pinocchios_nan_is_a_status():
    result = run("pinocchio", "rk4", spinning(1e160), step=1e-3, samples=11)
    assert result.status is Status.NON_FINITE
    assert "NaN or infinity arose before t = " in result.message
    assert len(result.times) >= 1
    assert np.isfinite(result.position).all()


def test_exudyn_takes_every_step_it_was_asked_for():
    for method in ("generalized_alpha", "trapezoidal", "tree_rk44"):
        assert run("exudyn", method, scenes.make("pendulum"), samples=3, t_end=1.0).steps == 1000


def test_exudyn_warns_of_no_renamed_setting(recwarn):
    run("exudyn", "generalized_alpha", scenes.make("slider_crank"), samples=3, t_end=0.01)
    run("exudyn", "tree_dopri5", scenes.make("pendulum_chain", links=2), samples=3, t_end=0.01)
    assert not [str(warning.message) for warning in recwarn]


def test_exudyns_trapezoidal_rule_is_its_index_2_newmark():
    """So it is offered once."""
    assert "newmark_index2" not in [method.name for method in engine("exudyn").methods()]


@pytest.mark.parametrize(("name", "method"), [("mujoco", "rk4"), ("exudyn", "generalized_alpha"), ("pinocchio", "rk4")])
def test_a_run_repeats_bit_for_bit(name, method):
    scene = scenes.make("n_four_bar", loops=1)
    first, second = (run(name, method, scene, t_end=1.0, samples=5) for _ in range(2))
    assert np.array_equal(first.position, second.position)
    assert np.array_equal(first.velocity, second.velocity)


def test_pinocchio_refuses_a_chain_that_would_fill_the_memory():
    long = scenes.make("pendulum_chain", links=400)
    refusals = engine("pinocchio").refusals(long)
    assert any("2.0 GB for 400 coordinates" in refusal.reason for refusal in refusals)
    assert all(refusal.permanent for refusal in refusals)
    assert engine("pinocchio").refusals(scenes.make("pendulum_chain", links=300)) == []


def test_angles_count_turns():
    """A free fly-wheel turns 10 rad; a rotation matrix alone would have forgotten one turn."""
    wheel = PlanarBody(name="wheel", mass=1.0, inertia=1.0, angle=1.0, angular_velocity=10.0)
    scene = Scene(name="wheel", bodies=(wheel,))
    for name, method in (("mujoco", "rk4"), ("pinocchio", "rk4"), ("exudyn", "trapezoidal"), ("exudyn", "tree_rk44")):
        result = run(name, method, scene, t_end=1.0, samples=3)
        assert result.orientation[-1, 0] == pytest.approx(11.0, abs=1e-9)


@pytest.mark.parametrize("name", ["mujoco", "pinocchio"])
def test_poses_are_the_engines_own(name):
    """A body placed wrongly in the engine's model would break a joint by the judge's count."""
    scene = scenes.make("pendulum_chain", links=5)
    result = run(name, "rk4", scene, t_end=0.5, samples=6)
    assert np.abs(constraint_residual(scene, result)).max() < 1e-14
    assert math.dist(result.position[-1, -1], result.position[0, -1]) > 0.1


def test_the_kinematic_trees_own_centres_of_mass_are_those_reported():
    exu = pytest.importorskip("exudyn")
    from cross_checks.engines.exudyn_.model import build_tree

    scene = mixed_slides()
    model = build_tree(scene)
    sensors = [
        model.mbs.AddSensor(
            exu.itemInterface.SensorKinematicTree(
                objectNumber=model.number, linkNumber=k, localPosition=centre,
                storeInternal=True, writeToFile=False, outputVariableType=exu.OutputVariableType.Position,
            )
        )
        for k, centre in enumerate(model.centres)
    ]  # fmt: skip
    model.mbs.Assemble()
    options = exu.SimulationSettings()
    options.solution.file.write = False
    options.timeIntegration.endTime = 0.5
    model.mbs.SolveDynamic(options, solverType=exu.DynamicSolverType.RK44)
    stored = [model.mbs.GetSensorStoredData(sensor) for sensor in model.sensors]
    position, *_ = model.poses(np.hstack([data[-1:, 1:] for data in stored]))
    for link, sensor in zip(model.linkage.links, sensors, strict=True):
        own = model.mbs.GetSensorStoredData(sensor)[-1, 1:3]
        assert own == pytest.approx(position[0, link.body], abs=1e-13)


def mixed_slides() -> Scene:
    bodies = (
        PlanarBody(name="a", mass=1.0, inertia=0.1, position=(0.5, 0.2), angle=0.3),
        PlanarBody(name="b", mass=1.0, inertia=0.1, position=(1.5, 0.1), angle=-0.8),
        PlanarBody(name="c", mass=1.0, inertia=0.1, position=(2.5, 0.4), angle=1.0),
    )
    joints = (
        Revolute(name="pin", body_a=GROUND, body_b="a", point=(0.1, 0.0)),
        Prismatic(name="slide", body_a="b", body_b="a", point=(1.0, 0.3), axis=(1.0, 2.0)),
        Revolute(name="elbow", body_a="b", body_b="c", point=(2.0, 0.0)),
    )
    return Scene(name="slides", gravity=(1.0, -9.81), bodies=bodies, joints=joints)


def test_what_engines_do_as_they_come_is_what_their_packages_say():
    """Read from the packages themselves: a release may change a default."""
    spec = pytest.importorskip("mujoco").MjSpec()
    given = engine("mujoco").as_shipped
    assert (given.method, given.step) == ("euler", spec.option.timestep)
    assert spec.option.integrator == 0  # Euler
    time = pytest.importorskip("exudyn").SimulationSettings().timeIntegration
    given = engine("exudyn").as_shipped
    assert given.step == (time.endTime - time.startTime) / time.numberOfSteps
    assert given.method == "generalized_alpha"  # what SolveDynamic takes unless told otherwise


def test_exudyn_says_what_went_wrong_and_not_in_which_file_of_ours():
    scene = scenes.make("android_vertebral", model="paper")
    found = run("exudyn", "tree_rk44", scene, step=1e-3, t_end=0.01)
    assert not found.ok
    assert "singular" in found.message
    assert "Python file" not in found.message


@pytest.mark.parametrize("method", ["generalized_alpha", "trapezoidal"])
def test_light_bodies_fall_as_heavy_ones_with_exudyn(method):
    """Masses cancel; a Newton iteration that ends at so many newtons would not know it."""
    heavy, light = (
        run("exudyn", method, scenes.make("double_pendulum", mass_1=mass, mass_2=0.6 * mass), step=1e-3, t_end=1.0)
        for mass in (1.0, 1e-6)
    )
    assert light.status is heavy.status is Status.SUCCESS
    assert np.max(np.abs(light.position - heavy.position)) <= 1e-9
