"""Contact in space between engines: the same scheme gives the same motion; their friction has its own traits."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks import engines
from mbs_ref import scenes
from mbs_ref.scene.contact import RegularisedCoulomb
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Status
from tests.cross_checks.engines.engine_runs import engine

SAME_SCHEME = 1e-12  # m, roundoff of some thousand steps
HEIGHT = 0.1234567  # m, no whole number of steps
CASES = [
    ("mujoco", "rk4", "bouncing_sphere", {"law": "spring_damper_force", "height": HEIGHT}),
    ("mujoco", "rk4", "colliding_spheres", {"law": "spring_damper", "damping": 30.0}),
    ("mujoco", "rk4", "bouncing_sphere", {"law": "progressive", "height": HEIGHT}),
    ("pinocchio", "rk4", "bouncing_sphere", {"law": "progressive", "height": HEIGHT}),
    ("pinocchio", "rk4", "colliding_spheres", {"law": "spring_damper", "damping": 30.0}),
    ("exudyn", "contact_rk44", "bouncing_sphere", {"law": "spring_damper", "height": HEIGHT}),
    ("exudyn", "contact_rk44", "colliding_spheres", {"law": "spring_damper", "damping": 30.0}),
]
ROLLING = 10.0 / 7.0  # m/s, 5/7 of the speed of rolling_sphere
DEPTH = 9.81e-5  # m, that the sphere of rolling_sphere sinks
FINE = 1e-4  # s


@pytest.mark.parametrize(("name", "method", "scene", "parameters"), CASES)
def test_an_engine_without_events_equals_our_rk4_without_events(name, method, scene, parameters):
    pytest.importorskip(name)
    built = scenes.make(scene, **parameters)
    theirs = engines.get(name).run(built, Settings(method=method, step=2e-4, reactions=False))
    ours = simulate(built, Settings(method="rk4", step=2e-4, events="none", estimate="off", reactions=False))
    assert theirs.ok, theirs.message
    assert np.abs(theirs.position - ours.position).max() < SAME_SCHEME
    assert np.abs(ours.velocity[-1] - ours.velocity[0]).max() > 0.1  # touch-down and lift-off lie behind


@pytest.mark.parametrize("name", ["mujoco", "pinocchio", "drake", "exudyn"])
def test_a_ball_rolls_alike_by_the_shared_force_of_a_sphere_on_a_plane(name):
    """Regularised friction turns the ball; the same scheme gives the same motion."""
    method = {"drake": "runge_kutta3_fixed", "exudyn": "generalized_alpha"}.get(name, "rk4")
    scene = scenes.make("rolling_sphere")
    friction = RegularisedCoulomb(coefficient=0.2, speed=0.05)
    (contact,) = scene.contacts
    scene = scene.model_copy(update={"contacts": (contact.model_copy(update={"friction": friction}),)})
    theirs = engine(name).run(scene, Settings(method=method, step=2e-4, t_end=0.2, samples=3))
    ours = simulate(scene, Settings(method="rk4", step=2e-4, t_end=0.2, samples=3, events="none"))
    bound = SAME_SCHEME if method == "rk4" else 1e-6  # m; of another scheme
    assert np.abs(theirs.position - ours.position).max() < bound
    assert np.abs(theirs.angular_velocity - ours.angular_velocity).max() < 1e4 * bound
    assert np.abs(ours.angular_velocity[-1]).max() > 5.0


def connected(scene, step: float, samples: int = 2):
    pytest.importorskip("exudyn")
    return engines.get("exudyn").run(scene, Settings(method="pair_contact_rk44", step=step, samples=samples))


def test_contact_connectors_of_exudyn_come_closer_with_the_step():
    """The state of contact is settled once a step: order 1."""
    built = scenes.make("bouncing_sphere", height=HEIGHT)
    truth = simulate(built, Settings(method="dop853", rtol=1e-11, samples=2))

    def error(step: float) -> float:
        run = connected(built, step)
        assert run.ok, run.message
        return float(np.abs(run.position[-1] - truth.position[-1]).max())

    assert error(2e-5) < 1e-4
    assert error(2e-5) < error(1e-4)


def test_contact_connectors_of_exudyn_part_two_spheres():
    """At its defaults the solver ends at touch-down, for it would have a shorter step than a method of fixed steps."""
    built = scenes.make("colliding_spheres", law="spring_damper")
    truth = simulate(built, Settings(method="dop853", rtol=1e-11, samples=2))
    run = connected(built, 2e-5)
    assert run.ok, run.message
    assert float(np.abs(run.position[-1] - truth.position[-1]).max()) < 1e-5


def _rolled(name: str, method: str, **parameters):
    pytest.importorskip(name)
    run = engines.get(name).run(scenes.make("rolling_sphere", **parameters), Settings(method=method, step=FINE))
    assert run.ok, run.message
    return run, float(np.linalg.norm(run.velocity[-1, 0]))


def test_exudyn_rolls_on_the_radius_of_the_sunken_surface():
    _, speed = _rolled("exudyn", "contact_rk44", release="gap")
    lever = 1.0 - DEPTH / 0.1
    assert speed == pytest.approx(2.0 / (1.0 + 0.4 / lever**2), abs=1e-6)
    assert abs(speed - ROLLING) < 1e-3


def test_mujoco_rolls_at_five_sevenths_but_hops_while_it_slides():
    run, speed = _rolled("mujoco", "rk4")
    assert abs(speed - ROLLING) < 1e-3
    assert run.position[:, 0, 2].max() > 0.1 + 2e-4  # m: off the ground


@pytest.mark.parametrize(
    ("name", "scene", "parameters", "words"),
    [
        ("exudyn", "bouncing_sphere", {"law": "progressive"}, ["progressive_law"]),
        ("exudyn", "block_stack", {"blocks": 2, "ratio": 1e4}, ["corner1.00", "endless"]),
        ("exudyn", "box_stack", {"boxes": 2, "ratio": 1e4}, ["corner1.0", "endless"]),
        ("mjx", "block_stack", {"blocks": 2, "ratio": 1e4}, ["corner1.00", "endless"]),
    ],
)
def test_what_an_engine_has_not_is_refused_by_name(name, scene, parameters, words):
    method = {"exudyn": "contact_rk44"}.get(name, "rk4")
    run = engine(name).run(scenes.make(scene, **parameters), Settings(method=method, step=1e-3))
    assert run.status is Status.REFUSED
    assert all(word in run.message for word in words)


def test_mujoco_has_no_friction_without_damping_and_says_so():
    pytest.importorskip("mujoco")
    run = engines.get("mujoco").run(scenes.make("rolling_sphere", damping=0.0), Settings(method="rk4", step=1e-3))
    assert run.status is Status.REFUSED
    assert "no friction at all" in run.message
