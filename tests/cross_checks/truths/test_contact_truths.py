"""Exact motions of the contact scenes against the reference solver, and the figures of contact."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cross_checks import engines
from cross_checks.judge.one_run import judged_run
from cross_checks.metrics.contact_figures import contact_figures
from cross_checks.truths import seek_truth
from cross_checks.truths.made_by.mechanisms.unilateral import CLOSED, LOOKS, Line, Unilateral, _Walk
from cross_checks.truths.of.bouncing import impact
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import scenes
from mbs_ref.scene import PlanarBody, Scene
from mbs_ref.scene.contact import CircleOnCircle, HuntCrossleyLaw, RigidLaw
from mbs_ref.scene.events import CoordinateEvent
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Status, Trajectory

FINE = Settings(method="dop853", rtol=1e-12, samples=41, estimate="off")
EXACT = [
    ("newtons_cradle", {}, 1e-12),
    ("newtons_cradle", {"restitution": 0.6}, 1e-12),
    ("newtons_cradle", {"law": "spring_damper", "stiffness": 1e5, "damping": 30.0}, 1e-10),
    ("disc_between_walls", {}, 1e-9),
    ("disc_between_walls", {"law": "rigid"}, 1e-11),
    ("box_stack", {}, 1e-10),
    ("box_stack", {"boxes": 2, "ratio": 10.0}, 1e-10),
    ("oblique_disc", {}, 1e-10),
    ("rolling_disc", {}, 1e-10),
    ("rolling_disc", {"inertia_factor": 0.4}, 1e-10),
    ("incline", {}, 1e-10),
    ("incline", {"angle": 0.4}, 1e-10),
    ("sliding_block", {}, 1e-10),
    ("bouncing_ball", {"gravity": 9.81, "duration": 2.0}, 1e-9),
]


@pytest.mark.parametrize(("name", "parameters", "tolerance"), EXACT)
def test_the_reference_solver_meets_the_exact_motion(name, parameters, tolerance):
    scene = scenes.make(name, **parameters)
    run = simulate(scene, FINE)
    truth = seek_truth(scene, run.times)
    assert run.ok, run.message
    assert isinstance(truth, Truth), truth
    assert truth.kind == "exact"
    assert np.abs(truth.position - run.position).max() < tolerance
    assert np.abs(truth.orientation - run.orientation).max() < 10.0 * tolerance


@pytest.mark.parametrize(
    "parameters", [{}, pytest.param({"law": "progressive", "damping": 1e3}, marks=pytest.mark.slow), {"offset": 0.48}]
)
def test_the_moving_seat_meets_its_converged_motion(parameters):
    """At 0.48 m the ball meets the seat's round end, which throws it aside."""
    scene = scenes.make("ball_on_moving_seat", **parameters)
    run = simulate(scene, FINE.model_copy(update={"samples": 6}))
    truth = seek_truth(scene, run.times)
    assert isinstance(truth, Truth), truth
    assert truth.difference is not None
    assert truth.difference < 1e-11
    assert np.abs(truth.position - run.position).max() < 1e-10
    assert np.abs(truth.orientation - run.orientation).max() < 1e-10


@pytest.mark.parametrize(
    ("name", "parameters", "words"),
    [
        ("oblique_disc", {"friction": 0.9}, "stops sliding"),
        ("sliding_block", {"height": 0.1}, "not unique"),
        ("bouncing_ball", {"law": "flores", "gravity": 9.81}, "linear laws"),
        ("ball_on_driven_seat", {"law": "spring_damper"}, "of the constraint"),
    ],
)
def test_what_is_not_known_is_said(name, parameters, words):
    found = seek_truth(scenes.make(name, **parameters), np.linspace(0.0, 1.5, 4))
    assert isinstance(found, NoTruth)
    assert words in found.reason


@pytest.mark.parametrize("exponent", [1.0, 1.5, 3.0])
def test_an_elastic_impact_lasts_as_its_gamma_functions_say(exponent):
    """Of F = k d^n, v^2 = v0^2 (1 - x^p) with x = d / D, p = n + 1: twice D / v0 times the integral of (1 - x^p)^-1/2.

    For Hertz's n = 3/2 that is 2.94 D / v0 (Johnson, Contact Mechanics, 1985, eq 11.24).
    """
    mass, speed, stiffness, p = 2.0, 0.7, 1e6, exponent + 1.0
    found = impact(HuntCrossleyLaw(stiffness=stiffness, damping=0.0, exponent=exponent), mass, speed)
    deepest = (p * mass * speed**2 / (2.0 * stiffness)) ** (1.0 / p)
    twice = 2.0 * math.sqrt(math.pi) * math.gamma(1.0 + 1.0 / p) / math.gamma(0.5 + 1.0 / p)
    assert exponent != 1.5 or twice == pytest.approx(2.94, abs=5e-3)
    assert found.restitution == 1.0
    assert found.penetration == pytest.approx(deepest, rel=1e-12)
    assert found.duration == pytest.approx(twice * deepest / speed, rel=1e-9)


@pytest.mark.parametrize("law", ["spring_damper", "hunt_crossley", "flores"])
def test_figures_of_a_free_impact_are_the_exact_ones(law):
    more = {"spring_damper": {}, "hunt_crossley": {"stiffness": 1e6, "damping": 3e5}, "flores": {"stiffness": 1e6}}[law]
    ball = scenes.make("bouncing_ball", law=law, **more)
    exact = impact(ball.contacts[0].law, 1.0, 1.0)
    found = contact_figures(ball, simulate(ball, FINE.model_copy(update={"samples": 2001})))
    assert found["floor: restitution"] == pytest.approx(exact.restitution, abs=1e-9)
    assert found["floor: penetration, m"] == pytest.approx(exact.penetration, rel=1e-6)
    assert found["floor: duration, s"] == pytest.approx(exact.duration, abs=1e-9)
    assert found["floor: impulse, N s"] == pytest.approx(1.0 + exact.restitution, abs=1e-9)


def test_no_contact_claims_an_impulse_that_it_shares():
    """Two equal floors at one place: each gives half of what turns the ball."""
    ball = scenes.make("bouncing_ball")
    twice = ball.contacts[0].model_copy(update={"name": "other"})
    shared = ball.model_copy(update={"contacts": (*ball.contacts, twice)})
    found = contact_figures(shared, simulate(shared, FINE.model_copy(update={"samples": 501})))
    assert {"floor: restitution", "other: restitution"} <= found.keys()
    assert not [name for name in found if "impulse" in name]


def test_figures_of_rest_and_of_stopping():
    slid = scenes.make("sliding_block")
    found = contact_figures(slid, simulate(slid, FINE))
    assert found["corner.left: stop distance, m"] == pytest.approx(4.0 / (2.0 * 0.3 * 9.81), abs=1e-9)
    stack = scenes.make("box_stack")
    sunk = contact_figures(stack, simulate(stack, FINE))
    assert sunk["corner0.0: static sink, m"] == pytest.approx(3.0 * 9.81 / 2e6, abs=1e-9)


def test_an_event_that_rounding_moves_across_a_look_is_where_the_look_is():
    spring = Unilateral(row=(1.0,), offset=0.0, stiffness=100.0)
    walk = _Walk(Line(np.ones(1), np.zeros(1), np.array([-1.0]), np.zeros(1), (spring,)), LOOKS)
    walk.modes = [CLOSED]
    root, broken, start = 0.05 * math.pi, np.array([[True, False]]), np.array([-1.0, 0.0, 1.0])
    assert walk._first(start, broken, root + 1e-9, root + 1e-3) == root + 1e-9
    assert walk._first(start, broken, root - 1e-3, root - 1e-9) == root - 1e-9
    assert walk._first(start, broken, root - 1e-3, root + 1e-3) == pytest.approx(root, abs=1e-14)


def two_discs(beside: float, duration: float = 0.4) -> Scene:
    """Two discs of radius 0.1 m that approach at 10 m/s, their paths `beside` (m) each other."""
    bodies = tuple(
        PlanarBody(name=name, mass=1.0, inertia=1.0, position=(side * 2.0, 0.5 * side * beside),
                   velocity=(-side * 5.0, 0.0))
        for name, side in (("left", -1.0), ("right", 1.0))
    )  # fmt: skip
    ends = {f"center_{end}": body.position for end, body in zip("ab", bodies, strict=True)}
    hit = CircleOnCircle(name="hit", body_a="left", body_b="right", radius_a=0.1, radius_b=0.1,
                         law=RigidLaw(restitution=0.64), **ends)  # fmt: skip
    return Scene(name="two_discs", gravity=(0.0, 0.0), duration=2.0 * duration, bodies=bodies, contacts=(hit,))


@pytest.mark.parametrize("beside", [0.0, 0.1, 0.19])
def test_an_oblique_impact_between_sparse_samples_shows_its_restitution(beside):
    scene = two_discs(beside)
    found = contact_figures(scene, simulate(scene, Settings(samples=14)))
    normal = 10.0 * math.sqrt(1.0 - (beside / 0.2) ** 2)
    assert found["hit: restitution"] == pytest.approx(0.64, abs=1e-9)
    assert found["hit: impulse, N s"] == pytest.approx(0.5 * 1.64 * normal, rel=1e-9)


@pytest.mark.parametrize("beside", [0.0, 0.1, 0.2001, 0.3])
@pytest.mark.parametrize("logs", [True, False])
def test_what_never_touches_or_is_passed_through_has_no_figures(beside, logs):
    """Free flights of an engine that misses the impact, with a log of events or without."""
    scene = two_discs(beside)
    times = np.linspace(0.0, scene.duration, 14)
    start, rate = (np.array([getattr(body, name) for body in scene.bodies]) for name in ("position", "velocity"))
    still = np.zeros((14, 2))
    path = Trajectory(times, start + times[:, None, None] * rate, still, np.broadcast_to(rate, (14, 2, 2)), still,
                      event_times=np.zeros((0, 2)) if logs else None, event_names=("hit",))  # fmt: skip
    assert contact_figures(scene, path) == {}


def test_gravity_does_not_disturb_the_restitution():
    ball = scenes.make("bouncing_ball", law="rigid", gravity=9.81, duration=0.2)
    found = contact_figures(ball, simulate(ball, FINE))
    assert found["floor: restitution"] == pytest.approx(0.5, abs=1e-9)


@pytest.mark.parametrize(("engine", "method"), [("mujoco", "rk4"), ("exudyn", "contact_rk44")])
def test_engines_are_judged_by_the_same_figures(engine, method):
    pytest.importorskip(engine)
    ball = scenes.make("disc_between_walls")
    solver = engines.get(engine)
    assert not solver.refusals(ball) + solver.method_refusals(ball, solver.method(method))
    record, _ = judged_run(ball, engine, Settings(method=method, step=1e-4, t_end=0.2, samples=21))
    assert record.error is not None
    assert record.error.value < 1e-4
    assert record.contact["right: restitution"] == pytest.approx(1.0, abs=1e-3)


def test_a_record_tells_where_a_declared_event_stopped_the_run():
    stop = CoordinateEvent(name="low", body="ball", coordinate="y", value=0.1, action="stop")
    ball = scenes.make("bouncing_ball").model_copy(update={"events": (stop,)})
    record, _ = judged_run(ball, "mbs_ref", Settings(rtol=1e-10))
    assert record.status == str(Status.STOP_EVENT)
    assert record.events["low"] == pytest.approx([0.05], abs=1e-9)
    assert record.t_end == pytest.approx(0.05, abs=1e-9)
    assert math.isclose(record.final["ball"]["position"][1], 0.1, abs_tol=1e-9)
