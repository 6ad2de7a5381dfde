"""Ladders of conformance: runs whose errors fall by an order raise no alarm, whatever the truth knows of rates."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.conformance.apart import Called
from cross_checks.conformance.ladder import _exemptible, _Rungs
from cross_checks.conformance.questions import Question
from cross_checks.engine import Method
from cross_checks.judge.ladder import settings_at
from cross_checks.judge.runs import gap
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref.scene import PlanarBody, PointMass, Scene
from mbs_ref.trajectory import Status, Trajectory

DOT = PointMass(name="dot", mass=1.0, position=(0.0, 0.0), velocity=(0.0, 0.0))
ROD = PlanarBody(name="rod", mass=3.0, inertia=12.0, position=(5.0, 0.0))
SCENE = Scene(name="two", bodies=(DOT, ROD), gravity=(0.0, 0.0), duration=2.0)
TIMES = np.linspace(0.0, 2.0, 6)
SHAPES = {"position": (6, 2, 2), "orientation": (6, 2), "velocity": (6, 2, 2), "angular_velocity": (6, 2)}
ZERO = {name: np.zeros(shape) for name, shape in SHAPES.items()}
RATES = 5.0  # errors of rates over those of poses
KNOWN = {"none": None, "all": np.zeros(6), "at one time": np.array([np.inf, 0.0, *[np.inf] * 4])}  # rates of the truth


def truth(rates: str, uncertainty: float = 1e-13) -> Truth:
    return Truth(**ZERO, uncertainty=uncertainty, kind="exact", how="rest", rate_uncertainty=KNOWN[rates])


def run(size: float, rng: np.random.Generator, steps: int = 0) -> Trajectory:
    """Return rest plus an error of about a size over the scene, larger in the rates."""
    off = {name: size * rng.normal(size=shape) for name, shape in SHAPES.items()}
    off |= {name: RATES * off[name] for name in ("velocity", "angular_velocity")}
    return Trajectory(TIMES, **off, status=Status.SUCCESS, message="", steps=steps)


def rungs(order: int, count: int, kind: str, rates: str, rng: np.random.Generator) -> _Rungs:
    """Return runs whose errors follow an order from 1e-2 to 1 at the coarsest, in one direction or in random ones."""
    method = Method("clean", kind, order, "errors by an order")  # type: ignore[arg-type]
    seed, first, aligned = int(rng.integers(2**32)), 10.0 ** rng.uniform(-2.0, 0.0), rng.random() < 0.5
    ratio = 0.5 if kind == "fixed" else 0.01
    knobs = [(0.04 if kind == "fixed" else 1e-4) * ratio**k for k in range(count)]
    power = order if kind == "fixed" else order / (order + 1.0)
    paths = [
        run(first * (knob / knobs[0]) ** power + 1e-15, np.random.default_rng(seed if aligned else seed + k), 50 * 2**k)
        for k, knob in enumerate(knobs)
    ]
    called = [Called(settings_at(method, SCENE, knob), path) for knob, path in zip(knobs, paths, strict=True)]
    return _Rungs(method, Question(SCENE, TIMES, truth(rates)), tuple(called))


@pytest.mark.parametrize(
    ("order", "rates"), [*((order, "none") for order in range(1, 13)), (2, "all"), (2, "at one time")]
)
def test_runs_that_follow_an_order_raise_no_alarm(order, rates):
    rng = np.random.default_rng(order)
    for kind, count in (("fixed", 2), ("fixed", 3), ("fixed", 4), ("adaptive", 2), ("adaptive", 4)):
        rising = rungs(order, count, kind, rates, rng)
        assert rising.shown is not None
        assert next(_exemptible(rising)) == ("truth", ""), (kind, count, rising.errors, rising.shown.weights)


@pytest.mark.parametrize("rates", KNOWN)
def test_runs_are_no_farther_apart_than_the_sum_of_their_errors_and_no_nearer_than_the_difference(rates):
    rng, known = np.random.default_rng(1), truth(rates)
    for _ in range(20):
        first, second = (run(10.0 ** rng.uniform(-8.0, -1.0), rng) for _ in range(2))
        one, other = gap(SCENE, known, first, known), gap(SCENE, known, second, known)
        apart = gap(SCENE, known, first, second)
        assert abs(one - other) - 1e-11 <= apart <= one + other + 1e-11
    everything = gap(SCENE, NoTruth("none"), first, second)
    assert everything > apart if rates == "none" else everything >= apart
    assert np.isnan(gap(SCENE, known, first, None))
