"""Truths of the sky: their bounds hold, they judge solvers and not models, and say so where they end."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.judge.matrix import judge_method
from cross_checks.judge.one_run import evaluate
from cross_checks.judge.verdict import Verdict
from cross_checks.truth import NoTruth, Truth
from cross_checks.truths import seek_truth
from mbs_ref import scenes
from mbs_ref.integrators import integrators
from mbs_ref.scene.units import free_fall_time, unit_length
from mbs_ref.settings import Settings


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("figure_eight", {}),
        ("satellite", {"orbit": "geo"}),
        ("satellite", {"orbit": "gps", "zonals": True}),
        ("satellite", {"days": 0.1, "third_bodies": True, "drag": True}),
        ("satellite", {"days": 0.1, "radiation": True}),
        ("solar_system", {"model": "newton", "days": 20.0}),
    ],
)
def test_two_unlike_solutions_agree_to_twelve_digits_of_the_unit_length(name, parameters):
    scene = scenes.make(name, **parameters)
    truth = seek_truth(scene, np.linspace(0.0, scene.duration, 5))
    assert isinstance(truth, Truth), truth
    shadow = 1e3 if parameters.get("radiation") else 1.0  # its edge is not smooth
    assert truth.uncertainty < 2e-12 * unit_length(scene) * shadow


def test_the_truth_judges_the_solver_and_the_ephemeris_the_model():
    scene = scenes.make("solar_system", model="newton", days=60.0)
    record = evaluate(scene, "mbs_ref", Settings(method="gauss", rtol=1e-16))
    assert record.error.value < 0.1  # m, from the exact solution of Newton's equations ...
    assert min(record.figures.values()) < 7.5  # ... which are not all that moves planets


def test_a_method_agrees_with_the_truth_of_a_satellite():
    cell = judge_method(scenes.make("satellite", days=0.2), "mbs_ref", _method("gauss"))
    assert cell.verdict is Verdict.AGREES, cell.reason


def _method(name):
    from cross_checks import engines

    assert name in integrators()
    return engines.get("mbs_ref").method(name)


def test_very_long_runs_have_no_converged_truth_and_say_how_long_they_may_be():
    found = seek_truth(scenes.make("satellite", days=1000.0), np.array([0.0, 8.64e7]))
    assert isinstance(found, NoTruth)
    assert "converged up to" in found.reason


def test_natural_units_are_those_of_the_laboratory_on_the_ground():
    assert unit_length(scenes.make("pendulum")) == 1.0
    assert free_fall_time(scenes.make("pendulum")) == 1.0
    assert unit_length(scenes.make("solar_system", model="newton")) == pytest.approx(3.8e8, rel=0.1)  # Earth and Moon
