"""The observed order of convergence of every fixed-step method: it finds what a fixed tolerance cannot."""

from __future__ import annotations

import numpy as np
import pytest

from mbs_ref import scenes
from tests.cross_checks.engines.engine_runs import distance, engine, observed_order, run
from tests.cross_checks.engines.test_engine_contract import every_method

T_END = 0.5  # s
STEPS = {1: (1e-3, 5e-4), 2: (5e-3, 2.5e-3), 4: (1e-2, 5e-3), 6: (2.5e-2, 1.25e-2)}  # s, by documented order
FIXED = [
    (name, method)
    for name, method in every_method()
    if engine(name).method(method).kind == "fixed"
    and not method.endswith(("_tight", "_gains"))
    and not engine(name).method_refusals(scenes.make("double_pendulum"), engine(name).method(method))
]
ADAPTIVE = [
    (name, method)
    for name, method in every_method()
    if engine(name).method(method).kind == "adaptive"
    and method != "dassl_index3"  # see test_integrators
    and not engine(name).method_refusals(scenes.make("double_pendulum"), engine(name).method(method))
]
LOOPS = [("pinocchio", "rk4"), ("exudyn", "generalized_alpha"), ("exudyn", "trapezoidal")]


@pytest.fixture(scope="module")
def truth():
    """The double pendulum converged by two unlike codes to 1e-12 m."""
    scene = scenes.make("double_pendulum")
    first = run("pinocchio", "dop853", scene, rtol=1e-13, t_end=T_END, samples=2)
    second = run("exudyn", "tree_rk67", scene, step=5e-4, t_end=T_END, samples=2)
    assert distance(first, second) < 1e-12
    return first


@pytest.mark.parametrize(("name", "method"), FIXED)
def test_order_in_a_tree(name, method, truth):
    scene = scenes.make("double_pendulum")
    order = engine(name).method(method).order or 0
    errors = [distance(run(name, method, scene, step=h, t_end=T_END, samples=2), truth) for h in STEPS[order]]
    assert observed_order(errors) == pytest.approx(order, abs=0.35)


@pytest.mark.parametrize(("name", "method"), ADAPTIVE)
def test_an_adaptive_method_follows_its_tolerance(name, method, truth):
    scene = scenes.make("double_pendulum")
    errors = [distance(run(name, method, scene, rtol=r, t_end=T_END, samples=2), truth) for r in (1e-5, 1e-7, 1e-9)]
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 1e-8


@pytest.mark.parametrize(("name", "method"), LOOPS)
def test_order_in_a_loop(name, method):
    """The slider-crank away from its dead centres, against this project's tightest outside solution."""
    scene = scenes.make("slider_crank")
    fine = run("pinocchio", "dop853", scene, rtol=1e-12, t_end=0.1, samples=2)
    order = engine(name).method(method).order or 0
    errors = [distance(run(name, method, scene, step=h, t_end=0.1, samples=2), fine) for h in STEPS[order]]
    assert observed_order(errors) == pytest.approx(order, abs=0.35)
    assert np.isfinite(errors).all()
