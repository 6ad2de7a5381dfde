"""The solar system against JPL DE440 (Park et al. 2021), level by level; REBOUND on the same scenes."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks import engines
from cross_checks.ephemerides import Observed, observe
from cross_checks.judge.one_run import evaluate
from cross_checks.metrics.errors import significant_figures
from cross_checks.truths.truth import NoTruth
from mbs_ref import scenes
from mbs_ref.settings import Settings

FINE = Settings(method="gauss", rtol=1e-16, samples=2, estimate="off")
OBSERVED = NoTruth("only the observed places are compared with")  # a truth of the equations takes a minute to make


def figures(model: str, days: float) -> tuple[float, float]:
    """Return the worst planet's and the Moon's significant figures."""
    found = dict(evaluate(scenes.make("solar_system", model=model, days=days), "mbs_ref", FINE, truth=OBSERVED).figures)
    moon = found.pop("moon", np.nan)
    return min(found.values()), moon


@pytest.mark.parametrize(
    ("model", "days", "planets", "moon"),
    [
        ("lumped", 200.0, 4.5, None),
        ("newton", 360.0, 5.4, 4.2),
        ("gr", 360.0, 8.6, 4.1),
        ("j2", 360.0, 8.6, 5.7),
        ("asteroids", 360.0, 9.5, 5.7),
        ("full", 360.0, 9.5, 6.8),
    ],
)
def test_each_level_of_physics_buys_its_figures(model, days, planets, moon):
    worst, lunar = figures(model, days)
    assert worst >= planets
    assert moon is None or lunar >= moon


@pytest.mark.parametrize("spin", [False, True])
def test_rigid_bodies_with_euler_parameters_have_the_same_figures_and_unit_norms(spin):
    points = evaluate(scenes.make("solar_system", model="newton", days=200.0), "mbs_ref", FINE, truth=OBSERVED)
    scene = scenes.make("solar_system", model="newton", days=200.0, formulation="euler_parameters", spin=spin)
    record = evaluate(scene, "mbs_ref", Settings(method="dop853", rtol=1e-12, samples=2))
    assert record.status == "success", record.message
    assert record.figures == pytest.approx(points.figures, abs=0.01)
    assert record.measure("compliance_position") < 1e-14  # of theta . theta = 1, with projection
    assert record.at_most("orientation_error") < 1e-7  # rad, after 480 turns of Jupiter


def test_rigid_planets_know_newtons_gravity_alone():
    with pytest.raises(ValueError, match="euler_parameters allow: lumped, newton"):
        scenes.make("solar_system", formulation="euler_parameters")
    with pytest.raises(ValueError, match="a point mass does not turn"):
        scenes.make("solar_system", model="newton", spin=True)


@pytest.mark.slow
@pytest.mark.parametrize(("days", "planets"), [(3652.5, 8.0), (36525.0, 6.6)])
def test_ten_and_a_hundred_years(days, planets):
    assert figures("full", days)[0] >= planets


def test_the_excerpt_is_enough_for_the_default(monkeypatch):
    from mbs_ref import ephemeris

    monkeypatch.setattr(ephemeris, "is_complete", lambda: False)
    record = evaluate(scenes.make("solar_system"), "mbs_ref", FINE, truth=OBSERVED)
    assert min(record.figures.values()) >= 8.0
    assert any("committed excerpt" in note for note in record.notes)


def test_the_moon_owes_its_figures_to_its_own_shape_and_little_to_the_tide():
    # 0.8 m after 360 days, seen from the Earth; the same J2 and C22 as DE440 do that, and a pole good to 0.02 degrees
    scene = scenes.make("solar_system")
    found = {}
    for left_out in ((), ("earth_tide",), ("moon_figure",)):
        loads = tuple(load for load in scene.loads if load.name not in left_out)
        changed = scene.model_copy(update={"loads": loads})
        path = engines.get("mbs_ref").run(changed, FINE)
        observed = observe(scene, scene.duration)
        assert isinstance(observed, Observed)
        found[left_out] = significant_figures(changed, path, observed)["moon"]
    assert found[()] > 8.5
    assert found[("earth_tide",)] > 8.5
    assert found[("moon_figure",)] < 5.8


def test_pleiades_to_1e_12():
    record = evaluate(scenes.make("pleiades"), "mbs_ref", FINE)
    assert record.error is not None
    assert record.error.final < 1e-12


def test_kepler_against_the_closed_form():
    record = evaluate(scenes.make("kepler", eccentricity=0.9), "mbs_ref", FINE)
    assert record.error is not None
    assert record.error.value < 1e-10


@pytest.fixture
def rebound():
    try:
        return engines.get("rebound")
    except engines.EngineMissing as missing:
        pytest.skip(str(missing))


@pytest.mark.parametrize("model", ["newton", "gr"])
def test_ias15_agrees_with_gauss(rebound, model):
    scene = scenes.make("solar_system", model=model, days=100.0)
    ours = engines.get("mbs_ref").run(scene, FINE)
    theirs = rebound.run(scene, Settings(method="ias15", rtol=1e-9, samples=2))
    one_centimetre = 1e-2  # m, of 1e12: roundoff of both
    assert np.abs(ours.position - theirs.position).max() < one_centimetre


def test_kept_energy_does_not_prove_a_right_moon(rebound):
    scene = scenes.make("solar_system", model="newton", days=360.0)
    record = evaluate(scene, "rebound", Settings(method="whfast", step=86400.0, samples=2), truth=OBSERVED)
    assert record.status == "success"
    assert record.figures["moon"] < 2.5
    assert min(v for k, v in record.figures.items() if k not in ("moon", "earth")) > 5.0


def test_others_refuse_with_the_reason():
    for name in ("exudyn", "mujoco", "pinocchio"):
        record = evaluate(scenes.make("kepler"), name, Settings())
        assert record.status in ("cannot", "engine-missing")
        assert record.message


def test_rebound_refuses_what_it_cannot(rebound):
    reasons = [refusal.reason for refusal in rebound.refusals(scenes.make("solar_system"))]
    assert any("lunar_figure" in reason for reason in reasons)
    assert any("free particles" in r.reason for r in rebound.refusals(scenes.make("pendulum")))
