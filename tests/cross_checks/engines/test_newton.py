"""Newton: symplectic Euler on trees of every joint, what single precision leaves, and refusals."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cross_checks.engine import SINGLE
from cross_checks.judge.one_run import evaluate
from mbs_ref import scenes
from mbs_ref.scene import (
    GROUND,
    Cylindrical,
    PlanarBody,
    PointMass,
    Prismatic,
    Revolute,
    Scene,
    SpatialBody,
    Universal,
    Weld,
)
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from tests.cross_checks.engines.engine_runs import distance, engine, observed_order, run

FEATHERSTONE = "featherstone"
AT = np.linspace(0.0, 0.3, 4)
DOWN = (0.0, 0.0, -9.81)


@pytest.fixture(autouse=True)
def newton():
    return engine("newton")


@pytest.mark.parametrize("name", ["pendulum", "double_pendulum", "torque_free_top", "double_gyroscope"])
def test_the_order_shows(name):
    errors = []
    for step in (2e-3, 1e-3):
        record = evaluate(scenes.make(name), "newton", Settings(method=FEATHERSTONE, step=step, t_end=0.3, samples=4))
        assert record.status == "success", record.message
        errors.append(record.error.value)
    assert observed_order(errors) == pytest.approx(1.0, abs=0.25)


def brick(name: str, x: float) -> SpatialBody:
    """Return a body that turns about y through the origin, by 2 rad/s."""
    return SpatialBody(
        name=name, mass=1.0, inertia=(0.02, 0.03, 0.04, 0.0, 0.0, 0.0), position=(x, 0.0, 0.0),
        velocity=(0.0, 0.0, -2.0 * x), orientation=(0.8, 0.6, 0.0, 0.0), angular_velocity=(0.0, 2.0, 0.0),
    )  # fmt: skip


def hung(first: Any, second: Any) -> Scene:
    """Return two bricks along x, one hung on the other."""
    return Scene(name="hung", gravity=DOWN, bodies=(brick("a", 0.5), brick("b", 1.5)), joints=(first, second))


def hinge(a: str, b: str, x: float, axis=(0.0, 1.0, 0.0)) -> Revolute:
    return Revolute(name=f"{a}_{b}", body_a=a, body_b=b, point=(x, 0.0, 0.0), axis=axis)


BETWEEN = {"body_a": "a", "body_b": "b", "point": (1.0, 0.0, 0.0)}
ROOT = hinge(GROUND, "a", 0.0)
CART = Scene(
    name="cart",
    gravity=(0.0, -9.81),
    bodies=(
        PlanarBody(name="cart", mass=2.0, inertia=0.1, position=(0.0, 0.0)),
        PlanarBody(name="rod", mass=1.0, inertia=0.1, position=(0.5, 0.0)),
        PointMass(name="tip", mass=0.5, position=(1.0, 0.0), velocity=(0.0, 0.0)),
        PlanarBody(name="thrown", mass=1.0, inertia=0.1, position=(2.0, 0.0), velocity=(1.0, 2.0), angular_velocity=9),
    ),
    joints=(
        Prismatic(name="rail", body_a=GROUND, body_b="cart", point=(0.0, 0.0), axis=(1.0, 0.0)),
        Revolute(name="pin", body_a="cart", body_b="rod", point=(0.0, 0.0)),
        Revolute(name="end", body_a="rod", body_b="tip", point=(1.0, 0.0)),
    ),
)
JOINTED = {
    "planar": CART,
    "tilted hinges": hung(ROOT, hinge("a", "b", 1.0, axis=(1.0, 0.0, 1.0))),
    "universal": hung(ROOT, Universal(name="u", **BETWEEN, axis_a=(0.0, 1.0, 0.0), axis_b=(0.0, 0.0, 1.0))),
    "universal from b": hung(
        ROOT, Universal(name="u", body_a="b", body_b="a", point=(1.0, 0.0, 0.0), axis_a=(1.0, 0.0, 0.0),
                        axis_b=(0.0, 1.0, 0.0))),
    "cylindrical": hung(ROOT, Cylindrical(name="c", **BETWEEN, axis=(1.0, 0.0, 0.0))),
    "prismatic": hung(ROOT, Prismatic(name="p", **BETWEEN, axis=(1.0, 0.0, 1.0))),
    "weld": hung(ROOT, Weld(name="w", **BETWEEN)),
}  # fmt: skip


@pytest.mark.parametrize("scene", JOINTED.values(), ids=JOINTED)
def test_every_joint_gives_our_motion(scene):
    ours = simulate(scene, Settings(rtol=1e-10, estimate="off"), AT)
    coarse, fine = (run_at(scene, step) for step in (2e-3, 1e-3))
    assert fine.ok, fine.message
    # extrapolated, what is left is of second order
    left = np.abs(2.0 * fine.position - coarse.position - ours.position).max()
    assert left < 0.05 * distance(fine, ours) < 1e-3
    assert observed_order([distance(coarse, ours), distance(fine, ours)]) == pytest.approx(1.0, abs=0.1)


def run_at(scene: Scene, step: float):
    return engine("newton").run(scene, Settings(method=FEATHERSTONE, step=step), AT)


def test_named_schemes_give_the_same_numbers():
    """Symplectic Euler on joint coordinates is what MuJoCo calls Euler."""
    scene = scenes.make("double_pendulum")
    ours, theirs = (run(*pair, scene, step=1e-3, t_end=0.3) for pair in (("newton", FEATHERSTONE), ("mujoco", "euler")))
    assert distance(ours, theirs) < 300 * SINGLE * 10.0  # m; 300 steps of a chain of 2 m, magnified little


def test_single_precision_is_declared(newton):
    assert {method.roundoff for method in newton.methods()} == {SINGLE}
    path = run("newton", FEATHERSTONE, scenes.make("pendulum"), step=1e-2, t_end=0.1)
    assert any("single precision" in note for note in path.notes)


def test_samples_do_not_change_the_end():
    scene = scenes.make("double_pendulum")
    sparse, dense = (run("newton", FEATHERSTONE, scene, step=1e-2, t_end=0.3, samples=n) for n in (2, 31))
    np.testing.assert_array_equal(sparse.position[-1], dense.position[-1])


def test_refusals_name_the_part(newton):
    (refusal,) = newton.refusals(scenes.make("n_four_bar", loops=1))
    assert refusal.reason.endswith("closes a loop as point, which newton does not implement")
    assert "'spring_damper'" in newton.refusals(scenes.make("spring_pendulum"))[0].reason
    assert "'circle_on_line'" in " ".join(r.reason for r in newton.refusals(scenes.make("bouncing_ball")))
