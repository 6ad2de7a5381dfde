"""Contact between engines: the same scheme without events gives the same motion; a stock contact does not."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks import engines
from cross_checks.truths import seek_truth
from cross_checks.truths.truth import Truth
from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Status

SAME_SCHEME = 1e-12  # m, roundoff of some thousand steps
HEIGHT = 0.1234567  # m, no whole number of steps: gap = 0 exactly at a step is a coin toss between engines
CASES = [
    ("mujoco", "rk4", "bouncing_ball", {"law": "spring_damper_force", "height": HEIGHT}),
    ("mujoco", "rk4", "newtons_cradle", {"law": "spring_damper", "balls": 2, "stiffness": 1e5, "damping": 30.0}),
    ("mujoco", "rk4", "bouncing_ball", {"law": "progressive", "height": HEIGHT}),
    ("pinocchio", "rk4", "bouncing_ball", {"law": "progressive", "height": HEIGHT}),
    ("exudyn", "tree_rk44", "bouncing_ball", {"law": "progressive", "height": HEIGHT}),
    ("exudyn", "contact_rk44", "bouncing_ball", {"law": "spring_damper", "height": HEIGHT}),
    ("exudyn", "contact_rk44", "newtons_cradle", {"law": "spring_damper", "stiffness": 1e5, "damping": 30.0}),
]


@pytest.mark.parametrize(("name", "method", "scene", "parameters"), CASES)
def test_an_engine_without_events_equals_our_rk4_without_events(name, method, scene, parameters):
    pytest.importorskip(name)
    built = scenes.make(scene, **parameters)
    settings = Settings(method=method, step=2e-4, reactions=False)
    theirs = engines.get(name).run(built, settings)
    ours = simulate(built, Settings(method="rk4", step=2e-4, events="none", estimate="off", reactions=False))
    assert theirs.ok, theirs.message
    assert np.abs(theirs.position - ours.position).max() < SAME_SCHEME
    assert ours.velocity[-1].max() > 0.1  # touch-down and lift-off lie behind


@pytest.mark.parametrize(
    ("name", "method", "law"), [("mujoco", "rk4", "rigid"), ("exudyn", "contact_rk44", "progressive")]
)
def test_laws_that_an_engine_has_not_are_refused_by_name(name, method, law):
    pytest.importorskip(name)
    run = engines.get(name).run(scenes.make("bouncing_ball", law=law), Settings(method=method, step=1e-3))
    assert run.status is Status.REFUSED
    assert f"{law}_law" in run.message


def test_the_closed_form_is_a_truth():
    ball = scenes.make("bouncing_ball")
    run = simulate(ball, Settings(method="dop853", rtol=1e-12, samples=3))
    truth = seek_truth(ball, run.times)
    assert isinstance(truth, Truth)
    assert np.abs(truth.position - run.position).max() < 1e-10


@pytest.mark.parametrize(("engine", "method"), [("mujoco", "rk4"), ("exudyn", "contact_rk44")])
def test_a_weakness_with_friction_exempts_where_something_rubs(engine, method):
    offered = engines.get(engine).method(method)
    assert offered.exemption(scenes.make("sliding_block"))
    assert not offered.exemption(scenes.make("bouncing_ball"))
