"""Engines in space against exact motions and against the reference solver."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cross_checks import engines
from cross_checks.judge.one_run import evaluate
from cross_checks.truths import seek_truth
from cross_checks.truths.truth import Truth
from mbs_ref import scenes
from mbs_ref.observables.distance import farthest
from mbs_ref.scene import GROUND, Bushing, PointMass, Revolute, Scene, SpatialBody, Spherical, TorsionSpring
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from tests.cross_checks.engines.loaded_scenes import loaded_top

PAIRS = (
    ("exudyn", "generalized_alpha", 2),
    ("exudyn", "rotation_vector", 2),
    ("mujoco", "rk4", 4),
    ("pinocchio", "rk4", 4),
)


def installed(name: str) -> None:
    try:
        engines.get(name)
    except engines.EngineMissing as error:
        pytest.skip(str(error))


@pytest.mark.parametrize(("engine", "method", "order"), PAIRS)
def test_the_order_shows_on_a_tumbling_body(engine, method, order):
    installed(engine)
    scene = scenes.make("torque_free_top", turns=1.0)
    end = scene.duration
    records = [evaluate(scene, engine, Settings(method=method, step=end / n, t_end=end, samples=5)) for n in (100, 200)]
    coarse, fine = (record.measure("orientation_error") or 0.0 for record in records)
    assert np.log2(coarse / fine) == pytest.approx(order, abs=0.2)


@pytest.mark.parametrize(("engine", "method", "order"), PAIRS)
@pytest.mark.parametrize(
    ("name", "step"), [("spatial_chain", 2.5e-3), ("double_gyroscope", 2.5e-4), ("flyball_governor", 2e-4)]
)
def test_trees_agree_with_the_reference(engine, method, order, name, step):
    """What a method of order 2 errs falls to a quarter at half of the step: extrapolated, it is as close as others."""
    installed(engine)
    scene = scenes.make(name)
    times = np.linspace(0.0, 0.1, 3)
    own = simulate(scene, Settings(rtol=1e-10, reactions=False, estimate="off"), times)

    def gap(step: float) -> np.ndarray:
        path = engines.get(engine).run(scene, Settings(method=method, step=step, reactions=False), times)
        assert path.ok, path.message
        return path.position - own.position

    left = (4.0 * gap(0.5 * step) - gap(step)) / 3.0 if order == 2 else gap(step)
    assert np.abs(left).max() < 1e-9


def test_exudyn_follows_bricard_and_mujoco_bends_it():
    """The redundant loop: generalized-alpha converges with order 2; MuJoCo's soft loop stays away at every step."""
    installed("exudyn")
    installed("mujoco")
    scene = scenes.make("bricard")
    times = np.linspace(0.0, 0.5, 3)
    own = simulate(scene, Settings(rtol=1e-10, reactions=False), times)

    def gap(engine: str, method: str, step: float) -> float:
        path = engines.get(engine).run(scene, Settings(method=method, step=step, reactions=False), times)
        return float(np.abs(path.position - own.position).max())

    halved = gap("exudyn", "generalized_alpha", 5e-3) / gap("exudyn", "generalized_alpha", 2.5e-3)
    assert halved == pytest.approx(4.0, rel=0.1)
    assert gap("mujoco", "rk4", 2.5e-3) == pytest.approx(gap("mujoco", "rk4", 5e-3), rel=0.01)


@pytest.mark.parametrize(
    ("name", "parameters", "bound"),
    [
        ("torque_free_top", {"turns": 10.0, "axis": 1}, 1e-10),
        ("torque_free_top", {"turns": 10.0, "axis": 2}, 2e-10),
        ("torque_free_top", {"turns": 10.0, "axis": 3, "spin": 1e4}, 2e-10),
        pytest.param("torque_free_top", {"turns": 10.0, "axis": 3}, 2e-10, marks=pytest.mark.slow),
        pytest.param("torque_free_top", {"turns": 10.0, "spin": 1e4}, 2e-10, marks=pytest.mark.slow),
        ("torque_free_top", {"turns": 10.0, "tilt": 0.0, "axis": 3}, 1e-10),
        ("torque_free_top", {"turns": 10.0, "inertia_1": 3.0, "inertia_3": 2.0, "inertia_2": 4.0}, 1e-10),
        ("heavy_top", {"motion": "steady"}, 1e-11),
        ("heavy_top", {"motion": "nutation"}, 1e-11),
        ("spherical_pendulum", {}, 1e-10),
        ("spherical_pendulum", {"speed": 5.0}, 1e-10),
        ("spatial_n_four_bar", {"loops": 1}, 1e-7),
    ],
)
def test_exact_motions_and_the_reference_agree(name, parameters, bound):
    """Two independent ways to one motion: elliptic functions, and Euler parameters integrated."""
    scene = scenes.make(name, **parameters)
    record = evaluate(scene, "mbs_ref", Settings(rtol=1e-13, samples=21, estimate="off"))
    assert record.status == "success"
    assert record.error is not None, record.notes
    assert record.error.value < bound  # m, at a radius of gyration
    assert record.measure("compliance_position") is not None
    assert record.measure("compliance_position") < 1e-12


def test_a_free_top_for_a_hundred_turns():
    scene = scenes.make("torque_free_top", turns=100.0)
    record = evaluate(scene, "mbs_ref", Settings(rtol=1e-13, estimate="off"))
    assert record.measure("orientation_error") is not None
    assert record.measure("orientation_error") < 1e-9  # rad
    truth = seek_truth(scene, np.array([0.0, scene.duration]))
    assert isinstance(truth, Truth)
    assert truth.uncertainty < 1e-11


def test_pinocchio_closes_loops_in_space_and_refuses_what_it_cannot():
    """Hinges as two points, a crossed-axes loop through its spherical joint; nothing closes by a rod or a plane."""
    installed("pinocchio")
    pinocchio = engines.get("pinocchio")
    for name, end in (("bricard", 0.5), ("spatial_slider_crank", 0.2)):
        scene = scenes.make(name)
        times = np.linspace(0.0, end, 3)
        truth = seek_truth(scene, times)
        assert isinstance(truth, Truth)
        path = pinocchio.run(scene, Settings(method="dop853", rtol=1e-10, reactions=False), times)
        assert path.ok, path.message
        assert max(farthest(scene, path, truth)[:2]) < 1e-9
    refused = pinocchio.refusals(scenes.make("spherical_pendulum"))
    assert "closes a loop as rod" in refused[0].reason


def test_a_mass_on_a_ball_joint_is_one_body_with_its_parent_to_pinocchio():
    """A particle has no orientation; as a ball joint's body it would leave the joint without inertia."""
    installed("pinocchio")
    rod = SpatialBody(name="rod", mass=2.0, inertia=(0.3, 0.2, 0.1, 0.0, 0.0, 0.0), position=(0.5, 0.0, 0.0),
                      angular_velocity=(0.0, 0.0, 1.0), velocity=(0.0, 0.5, 0.0))  # fmt: skip
    bob = PointMass(name="bob", mass=1.0, position=(1.0, 0.0, 0.0), velocity=(0.0, 1.0, 0.0))
    joints = (
        Spherical(name="pivot", body_a=GROUND, body_b="rod", point=(0.0, 0.0, 0.0)),
        Spherical(name="hook", body_a="rod", body_b="bob", point=bob.position),
    )
    scene = Scene(name="hung", gravity=(0.0, 0.0, -9.81), bodies=(rod, bob), joints=joints)
    times = np.linspace(0.0, 1.0, 5)
    own = simulate(scene, Settings(rtol=1e-12), times)
    path = engines.get("pinocchio").run(scene, Settings(method="dop853", rtol=1e-11), times)
    assert path.ok, path.message
    assert np.abs(path.position - own.position).max() < 1e-8
    assert path.reactions.keys() == {"pivot"}  # what holds the bob is inside of that one body
    np.testing.assert_allclose(path.reactions["pivot"], own.reactions["pivot"], atol=1e-6)


@pytest.mark.parametrize(
    ("engine", "settings", "name"),
    [
        ("pinocchio", {"method": "dop853", "rtol": 1e-11}, "double_gyroscope"),
        ("pinocchio", {"method": "dop853", "rtol": 1e-11}, "spatial_slider_crank"),
        ("mujoco", {"method": "rk4", "step": 1e-4}, "double_gyroscope"),
        ("mujoco", {"method": "rk4", "step": 1e-3}, "spatial_chain"),
    ],
)
def test_reactions_in_space_are_the_references(engine, settings, name):
    installed(engine)
    scene = scenes.make(name)
    times = np.linspace(0.0, 0.1, 3)
    own = simulate(scene, Settings(rtol=1e-11), times)
    path = engines.get(engine).run(scene, Settings(**settings), times)
    assert path.reactions.keys() == own.reactions.keys()
    for joint, found in path.reactions.items():
        np.testing.assert_allclose(found, own.reactions[joint], atol=1e-6 * max(1.0, np.abs(found).max()))


SWINGS = [  # rad, how near each comes at 1 ms
    ("mbs_ref", "rk4", 1e-10), ("mujoco", "rk4", 1e-10), ("pinocchio", "rk4", 1e-10), ("exudyn", "tree_rk44", 1e-10),
    ("exudyn", "generalized_alpha", 1e-6), ("exudyn", "rotation_vector", 1e-6), ("drake", "runge_kutta3_fixed", 1e-8),
    ("dart", "symplectic_euler", 1e-3),
]  # fmt: skip


@pytest.mark.parametrize(("name", "method", "bound"), SWINGS)
@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (1.0, 2.0, 0.5)])
@pytest.mark.parametrize(("first", "second", "sign"), [("plate", GROUND, -1.0), (GROUND, "plate", 1.0)])
def test_a_hinges_spring_swings_about_its_rest_angle(name, method, bound, axis, first, second, sign):
    """theta = rest (1 - cos(omega t)) about an axis through the centre, omega^2 = k / I."""
    installed(name)
    stiffness, inertia, rest = 8.0, 2.0, 0.3
    moments = (1.0, 1.0, inertia) if axis[0] == 0.0 else (inertia,) * 3
    plate = SpatialBody(name="plate", mass=1.0, inertia=(*moments, 0.0, 0.0, 0.0), position=(0.0, 0.0, 0.0))
    hinge = Revolute(name="hinge", body_a=GROUND, body_b="plate", point=(0.0, 0.0, 0.0), axis=axis)
    ends = {"body_a": first, "body_b": second}
    spring = TorsionSpring(name="spring", **ends, stiffness=stiffness, rest_angle=rest, axis=axis)
    scene = Scene(name="plate", gravity=(0.0, 0.0, 0.0), bodies=(plate,), joints=(hinge,), loads=(spring,))
    run = engines.get(name).run(scene, Settings(method=method, step=1e-3, t_end=1.0, samples=5))
    assert run.ok, run.message
    turned = run.orientation[:, 0, 1:] @ np.array(axis) / np.linalg.norm(axis)
    angle = 2.0 * np.arctan2(turned, run.orientation[:, 0, 0])
    exact = sign * rest * (1.0 - np.cos(np.sqrt(stiffness / inertia) * run.times))
    assert angle == pytest.approx(exact, abs=bound)


SHARERS = [  # m, how near each comes
    ("mujoco", "rk4", {"step": 1e-4}, 1e-7),
    ("pinocchio", "dop853", {"rtol": 1e-11}, 1e-7),
    ("drake", "runge_kutta3", {"rtol": 1e-9}, 1e-7),
    ("exudyn", "generalized_alpha", {"step": 1e-4}, 5e-8),
    pytest.param("exudyn", "generalized_alpha", {"step": 5e-5}, 1.25e-8, marks=pytest.mark.slow),
]


@pytest.mark.parametrize(("name", "method", "accuracy", "bound"), SHARERS)
def test_springs_bushings_torques_and_pulses_in_space_act_as_the_references_do(name, method, accuracy, bound):
    installed(name)
    scene, times = loaded_top(), np.linspace(0.0, 0.1, 3)
    own = simulate(scene, Settings(rtol=1e-11, reactions=False, estimate="off"), times)
    path = engines.get(name).run(scene, Settings(method=method, reactions=False, **accuracy), times)
    assert path.ok, path.message
    place, turn = farthest(scene, path, own)[:2]
    assert place < 2.0 * bound
    assert turn < 10.0 * bound


@pytest.mark.parametrize("joined", [pytest.param(False, marks=pytest.mark.slow), True], ids=["free", "on a ball"])
@pytest.mark.parametrize(
    ("load", "own"),
    [({"stiffness": 3.0, "damping": 0.5, "rest_angle": 0.3, "axis": (0.0, 0.0, 1.0)}, False),
     ({"stiffness": (0.0, 0.0, 0.0, 3.0, 3.0, 3.0), "damping": (0.0, 0.0, 0.0, 0.5, 0.5, 0.5)}, True),
     ({"stiffness": (0.0, 0.0, 0.0, 3.0, 3.0, 0.0)}, False)],
    ids=["torsion spring", "isotropic bushing", "bushing"],
)  # fmt: skip
def test_exudyn_turns_two_tumbling_bodies_by_a_spring(load, own, joined):
    """Its own connectors act where they have the same law, the shared force code elsewhere."""
    installed("exudyn")
    still = {"mass": 2.0, "inertia": (0.1, 0.2, 0.3, 0.0, 0.0, 0.0)}
    one = SpatialBody(name="a", angular_velocity=(0.3, 0.5, 0.1), **still)
    two = SpatialBody(
        name="b", position=(1.0, 0.0, 0.0), velocity=(0.0, 0.6, 0.7), angular_velocity=(0.5, -0.7, 0.6), **still
    )
    ends: dict[str, Any] = {"name": "spring", "body_a": "a", "body_b": "b"}
    spring = TorsionSpring(**ends, **load) if "axis" in load else Bushing(**ends, point=(0.0, 0.0, 0.0), **load)
    ball = (Spherical(name="ball", body_a="a", body_b="b", point=(0.0, 0.0, 0.0)),) if joined else ()
    scene, times = Scene(name="two", bodies=(one, two), loads=(spring,), joints=ball), np.linspace(0.0, 1.0, 6)
    fine = simulate(scene, Settings(rtol=1e-10, estimate="off"), times)
    path = engines.get("exudyn").run(scene, Settings(method="generalized_alpha", step=1e-3), times)
    assert path.ok, path.message
    assert any("shared force code" in note for note in path.notes) != own
    assert farthest(scene, path, fine)[1] < 1e-5  # rad; by its torsional spring 0.03


def test_two_springs_of_one_hinge_and_one_across_two_hinges_are_all_counted():
    """MuJoCo has them as a joint's spring, a tendon of that joint, and a tendon of both."""
    installed("mujoco")
    axis, scene = (0.0, 1.0, 0.0), hinged()
    springs = [("ground", "rod0", 5.0, 0.1), ("ground", "rod0", 3.0, -0.2), ("ground", "rod1", 4.0, 0.3)]
    loads = tuple(
        TorsionSpring(name=f"s{k}", body_a=a, body_b=b, stiffness=stiffness, damping=0.1, rest_angle=rest, axis=axis)
        for k, (a, b, stiffness, rest) in enumerate(springs)
    )
    scene = scene.model_copy(update={"loads": loads})
    times = np.linspace(0.0, 0.5, 3)
    own = simulate(scene, Settings(rtol=1e-12, reactions=False, estimate="off"), times)
    path = engines.get("mujoco").run(scene, Settings(method="rk4", step=1e-3, reactions=False), times)
    assert not path.notes  # no shared force code
    assert np.abs(path.position - own.position).max() < 1e-9


def hinged() -> Scene:
    """Two rods on parallel hinges."""
    rods = tuple(
        SpatialBody(name=f"rod{k}", mass=1.0, inertia=(0.01, 0.1, 0.1, 0.0, 0.0, 0.0), position=(k + 0.5, 0.0, 0.0))
        for k in range(2)
    )
    hinges = tuple(
        Revolute(name=f"hinge{k}", body_a=a, body_b=f"rod{k}", point=(float(k), 0.0, 0.0), axis=(0.0, 1.0, 0.0))
        for k, a in enumerate((GROUND, "rod0"))
    )
    return Scene(name="rods", gravity=(0.0, 0.0, -9.81), bodies=rods, joints=hinges)


@pytest.mark.parametrize(("method", "order"), [("tree_euler", 1), ("tree_rk44", 4), ("tree_rk67", 6)])
def test_exudyns_kinematic_tree_has_its_order_in_space(method, order):
    installed("exudyn")
    times = np.array([0.0, 0.4])
    own = simulate(hinged(), Settings(rtol=1e-13, reactions=False, estimate="off"), times)
    steps = {1: (1e-3, 5e-4), 4: (1e-2, 5e-3), 6: (4e-2, 2e-2)}[order]

    def error(step: float) -> float:
        path = engines.get("exudyn").run(hinged(), Settings(method=method, step=step, reactions=False), times)
        assert path.ok, path.message
        return float(np.abs(path.position - own.position).max())

    assert np.log2(error(steps[0]) / error(steps[1])) == pytest.approx(order, abs=0.4)


def test_exudyns_kinematic_tree_names_what_it_does_not_support():
    installed("exudyn")
    exudyn = engines.get("exudyn")
    for name, joint in (("spatial_chain", "'ball1'"), ("torque_free_top", "'top'"), ("bricard", "closes a loop")):
        reasons = exudyn.method_refusals(scenes.make(name), exudyn.method("tree_rk44"))
        assert any(joint in refusal.reason for refusal in reasons)


@pytest.mark.parametrize(
    ("name", "method", "step"), [("exudyn", "generalized_alpha", 1e-3), ("pinocchio", "rk4", 2e-4)]
)
def test_an_oblique_crash_in_space_agrees(name, method, step):
    """Exudyn by its own elements but for contacts, Pinocchio by the shared force code."""
    installed(name)
    scene, times = scenes.make("android_spatial"), np.linspace(0.0, 0.1, 6)
    fine = simulate(scene, Settings(rtol=1e-10, estimate="off", reactions=False), times)
    path = engines.get(name).run(scene, Settings(method=method, step=step, reactions=False), times)
    assert path.ok, path.message
    assert farthest(scene, path, fine)[0] < 1e-3  # m
