"""Truths of the sky: their bounds hold, they judge solvers and not models, and say so where they end."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest

import cross_checks
from cross_checks.judge.cell import judged, truth_of
from cross_checks.judge.one_run import evaluate
from cross_checks.judge.runs import Runs
from cross_checks.judge.vocabulary import Verdict
from cross_checks.truths import seek_truth
from cross_checks.truths.made_by.sky import particles
from cross_checks.truths.made_by.sky.particles import converge
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import scenes
from mbs_ref.integrators import integrators
from mbs_ref.scene import PointMass, Scene
from mbs_ref.scene.celestial import Newton
from mbs_ref.scene.scales import free_fall_time, unit_length
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("figure_eight", {}),
        ("satellite", {"orbit": "geo"}),
        pytest.param("satellite", {"orbit": "gps", "days": 0.2, "zonals": True}, marks=pytest.mark.slow),
        pytest.param("satellite", {"days": 0.01, "third_bodies": True, "drag": True}, marks=pytest.mark.slow),
        ("satellite", {"days": 0.01, "radiation": True}),
        ("nesc_sphere_in_air", {}),
        ("solar_system", {"model": "newton", "days": 20.0}),
        ("solar_system", {"model": "gr_sun", "days": 2.0}),
        ("solar_system", {"days": 2.0}),
    ],
)
def test_two_unlike_solutions_agree_and_the_solver_agrees_with_them(name, parameters):
    scene = scenes.make(name, **parameters)
    times = np.linspace(0.0, scene.duration, 3)
    truth = seek_truth(scene, times)
    assert isinstance(truth, Truth), truth
    spacing = float(np.spacing(np.abs(truth.position).max()))
    assert truth.uncertainty < 1e-14 * unit_length(scene) + 2 * spacing
    run = simulate(scene, Settings(method="gauss", rtol=1e-18, estimate="off"), times)
    roundoff = 1e-13 * unit_length(scene) + 4 * spacing  # of double precision, some turns long
    assert np.abs(run.position - truth.position).max() < truth.uncertainty + roundoff


# data and words, with the values of signals (mbs_ref.scene.signals), files, a compiler, and the distance of two motions
ALLOWED = (
    "mbs_ref.scene", "mbs_ref.scenes", "mbs_ref.files", "mbs_ref.kernels.jit",
    "mbs_ref.observables.distance",
)  # fmt: skip


def test_no_truth_is_made_by_the_solver():
    folder = Path(cross_checks.__file__).parent / "truths"
    files = [file for file in folder.rglob("*.py") if file.parent.name != "oracle"]  # which holds mechanisms, no truths
    assert {file.parent.name for file in files} >= {"truths", "of", "made_by", "proofs", "checker"}
    for file in files:
        for node in ast.walk(ast.parse(file.read_text())):
            names = [node.module] if isinstance(node, ast.ImportFrom) else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            for name in names:
                ours = (name or "").startswith("mbs_ref.")
                assert not ours or any(name == a or name.startswith(f"{a}.") for a in ALLOWED), f"{file.name}: {name}"


def test_a_collision_ends_what_is_known():
    stone = PointMass(name="stone", mass=1.0, position=(7e6, 0.0, 0.0), velocity=(0.0, 0.0, 0.0))
    earth = stone.model_copy(update={"name": "earth", "position": (0.0, 0.0, 0.0)})
    fall = Newton(name="n", gm=(3.986e14, 0.0), radius=(6.378e6, 0.0))
    scene = Scene(name="fall", gravity=(0.0, 0.0, 0.0), bodies=(earth, stone), loads=(fall,))
    assert isinstance(converge(scene, np.array([0.0, 100.0])), Truth)
    found = converge(scene, np.array([0.0, 600.0]))
    assert isinstance(found, NoTruth)
    assert "'earth' and 'stone' collide" in found.reason


def test_the_truth_judges_the_solver_and_the_ephemeris_the_model():
    scene = scenes.make("solar_system", model="newton", days=60.0)
    record = evaluate(scene, "mbs_ref", Settings(method="gauss", rtol=1e-16))
    assert record.error.value < 0.1  # m, from the exact solution of Newton's equations ...
    assert min(record.figures.values()) < 7.5  # ... which are not all that moves planets


def test_a_method_agrees_with_the_truth_of_a_satellite():
    scene, runs = scenes.make("satellite", days=0.05), Runs()
    cell, _ = judged(runs, scene, "mbs_ref", _method("gauss"), truth_of(runs, scene))
    assert cell.verdict is Verdict.AGREES, cell.reason


def _method(name):
    from cross_checks import engines

    assert name in integrators()
    return engines.get("mbs_ref").method(name)


def test_very_long_runs_have_no_converged_truth_and_say_how_long_they_may_be():
    found = seek_truth(scenes.make("satellite", days=1000.0), np.array([0.0, 8.64e7]))
    assert isinstance(found, NoTruth)
    assert "converged up to" in found.reason


def test_two_solutions_are_apart_by_a_distance(monkeypatch):
    """An uncertainty is of a point in space: what three components differ by adds up."""
    scene, times = scenes.make("figure_eight"), np.linspace(0.0, 0.1, 2)
    place = np.zeros((2, 3, 3))
    monkeypatch.setattr(particles, "_solve_twice", lambda *_: (place, place + 1.0, place))
    truth = converge(scene, times)
    assert isinstance(truth, Truth)
    assert truth.uncertainty >= 3.0**0.5


def test_natural_units_are_those_of_the_laboratory_on_the_ground():
    assert unit_length(scenes.make("pendulum")) == 1.0
    assert free_fall_time(scenes.make("pendulum")) == 1.0
    assert unit_length(scenes.make("solar_system", model="newton")) == pytest.approx(3.8e8, rel=0.1)  # Earth and Moon


@pytest.mark.parametrize(("bound", "costly"), [(2.0, True), (1e9, False)])
def test_a_truth_of_many_bodies_and_free_fall_times_is_called_costly(monkeypatch, bound, costly):
    """Two bodies over more than one free-fall time: half of four pairs, times more than one."""
    scene = scenes.make("kepler", orbits=1)
    monkeypatch.setattr(particles, "COSTLY", bound)
    assert scene.duration > free_fall_time(scene)
    truth = converge(scene, np.array([0.0, scene.duration]))
    assert isinstance(truth, Truth)
    assert truth.is_costly is costly
