"""The compiled loop over Pinocchio's headers, against exact motions and Pinocchio from Python."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.conformance.probes import probes
from cross_checks.engine import Plan, plan_run
from cross_checks.judge.one_run import evaluate
from mbs_ref import scenes
from mbs_ref.scene import PlanarBody, Scene
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Status
from tests.cross_checks.engines.engine_runs import distance, engine, run

TREES = ("pendulum_chain", "spatial_chain", "double_gyroscope", "heavy_top", "torque_free_top")
ROUNDOFF = 1e-10  # rad/s^2: what the thin rods of a chain make of the last bit
SHORT = {"t_end": 0.2, "samples": 3, "reactions": False}


@pytest.fixture(autouse=True)
def can_be_compiled():
    """Skip, with the reason, where the program cannot be compiled."""
    engine("pinocchio_cpp")
    from cross_checks.engines.pinocchio_cpp_ import compiler

    if compiler.obstacle():
        pytest.skip(compiler.obstacle())


JOINTS = ("revolute", "prismatic", "cylindrical", "universal", "spherical", "weld")


@pytest.mark.parametrize(
    "scene",
    [*map(scenes.make, TREES), probes()["prismatic", 2], *(probes()[kind, 3] for kind in JOINTS)],
    ids=lambda scene: scene.name,
)
def test_accelerations_are_those_of_pinocchio_from_python(scene):
    plan = plan_run(engine("pinocchio_cpp"), scene, Settings(method="rk4"), None)
    assert isinstance(plan, Plan)
    built = engine("pinocchio_cpp").build(scene, plan)
    state = built.start + 0.1 * np.random.default_rng(0).standard_normal(len(built.start))
    assert built.tree.derivative(state) == pytest.approx(built.rhs(0.0, state), rel=1e-10, abs=ROUNDOFF)


@pytest.mark.parametrize("name", TREES)
def test_dop853_takes_the_steps_of_scipys(name):
    """The same tableau, first step and control: only roundoff differs."""
    scene = scenes.make(name)
    first, second = (run(x, "dop853", scene, rtol=1e-8, **SHORT) for x in ("pinocchio", "pinocchio_cpp"))
    assert (second.steps, second.rhs_calls) == (first.steps, first.rhs_calls)
    assert distance(first, second) < 1e-11


def test_rk4_has_order_4_on_a_tumbling_body():
    scene = scenes.make("torque_free_top", turns=1.0)
    end = scene.duration
    settings = [Settings(method="rk4", step=end / n, t_end=end, samples=5) for n in (100, 200)]
    coarse, fine = (evaluate(scene, "pinocchio_cpp", s).measure("orientation_error") or 0.0 for s in settings)
    assert np.log2(coarse / fine) == pytest.approx(4, abs=0.2)


def test_steps_that_run_out_or_overflow_are_a_status():
    spent = run("pinocchio_cpp", "dop853", scenes.make("pendulum"), rtol=1e-10, max_steps=5)
    assert spent.status is Status.TOO_MANY_STEPS
    assert "max_steps = 5 were used up at t = " in spent.message
    wheel = PlanarBody(name="wheel", mass=1.0, inertia=1.0, angular_velocity=1e200)
    falling = Scene(name="falling", gravity=(0.0, -1e308), bodies=(wheel,))
    lost = run("pinocchio_cpp", "rk4", falling, t_end=10.0, samples=3)
    assert lost.status is Status.NON_FINITE


@pytest.mark.parametrize(
    ("name", "words"), [("n_four_bar", "drives trees"), ("spring_pendulum", "part type"), ("bricard", "drives trees")]
)
def test_loops_and_loads_are_left_to_pinocchio_from_python(name, words):
    assert any(words in refusal.reason for refusal in engine("pinocchio_cpp").refusals(scenes.make(name)))


@pytest.mark.parametrize("missing", ["compiler", "headers"])
def test_what_is_missing_is_the_reason_of_a_refusal(missing, monkeypatch, tmp_path):
    from cross_checks.engines.pinocchio_cpp_ import compiler

    if missing == "compiler":
        monkeypatch.setenv("CXX", "no-such-compiler")
    else:
        monkeypatch.setattr(compiler, "_prefix", lambda: tmp_path)
    compiler.obstacle.cache_clear()
    try:
        result = run("pinocchio_cpp", "rk4", scenes.make("pendulum"))
    finally:
        compiler.obstacle.cache_clear()
    assert result.status is Status.REFUSED
    assert ("no C++ compiler was found" if missing == "compiler" else "lacks Pinocchio's headers") in result.message
