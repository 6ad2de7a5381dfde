"""Engines in the sky: heyoka and REBOUND on the same scenes, and who refuses them and why."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.judge.one_run import evaluate
from cross_checks.truths import truth_for
from mbs_ref import scenes
from mbs_ref.scene.celestial import Oblateness
from mbs_ref.settings import Settings
from tests.cross_checks.engines.engine_runs import engine

FINE = Settings(method="gauss", rtol=1e-16, samples=2)
TAYLOR = Settings(method="taylor", rtol=1e-17, samples=2)


@pytest.fixture
def heyoka():
    return engine("heyoka")


@pytest.mark.parametrize(("orbit", "metres"), [("leo", 1e-5), ("molniya", 1e-4)])
def test_taylor_series_agree_with_collocation_on_a_satellite(heyoka, orbit, metres):
    scene = scenes.make("satellite", orbit=orbit, zonals=True)
    ours, theirs = engine("mbs_ref").run(scene, FINE), heyoka.run(scene, TAYLOR)
    assert theirs.ok, theirs.message
    assert theirs.steps > 10
    assert np.abs(ours.position - theirs.position).max() < metres


def test_zonal_harmonics_pull_back_in_series_too(heyoka):
    scene = scenes.make("kepler", orbits=1)
    field = {"type": "oblateness", "name": "j", "body": "center", "radius": 0.1, "zonal": (0.01, 0.0, -0.02)}
    axis = {"axis": (0.6, 0.0, 0.8)}
    loads = ({"type": "newton", "name": "newton", "gm": (1.0, 0.3)}, field | axis)
    both = type(scene).model_validate(scene.model_dump() | {"loads": loads})
    ours, theirs = engine("mbs_ref").run(both, FINE), heyoka.run(both, TAYLOR)
    assert np.abs(ours.position - theirs.position).max() < 1e-12  # m, roundoff of one orbit


@pytest.mark.parametrize("method", ["taylor", "taylor_compensated"])
def test_series_reach_the_published_pleiades(heyoka, method):
    record = evaluate(scenes.make("pleiades"), "heyoka", Settings(method=method, rtol=1e-17))
    assert record.status == "success", record.message
    assert record.error.final < 1e-11


def test_heyoka_refuses_what_it_does_not_support(heyoka):
    full = [refusal.reason for refusal in heyoka.refusals(scenes.make("solar_system"))]
    assert any("lunar_figure" in reason for reason in full)
    assert any("fixed poles" in reason for reason in full)
    assert any("free particles" in r.reason for r in heyoka.refusals(scenes.make("pendulum")))


@pytest.mark.parametrize("name", ["exudyn", "mujoco", "pinocchio"])
@pytest.mark.parametrize("scene", ["kepler", "satellite", "solar_system", "figure_eight", "outer_solar_system"])
def test_multibody_engines_refuse_the_sky_with_the_reason(name, scene):
    record = evaluate(scenes.make(scene), name, Settings())
    assert record.status in ("cannot", "engine-missing")
    if record.status == "cannot":
        assert "newton" in record.message


@pytest.mark.parametrize(
    ("field", "supported"), [({}, True), ({"pole": "earth_iau2006"}, False), ({"axis": (0.6, 0.0, 0.8)}, False)]
)
def test_rebound_supports_j2_about_a_fixed_z_axis_alone(field, supported):
    scene = scenes.make("satellite")
    loads = tuple(load.model_copy(update=field) if isinstance(load, Oblateness) else load for load in scene.loads)
    reasons = [refusal.reason for refusal in engine("rebound").refusals(scene.model_copy(update={"loads": loads}))]
    assert any("fixed z axis alone" in reason for reason in reasons) is not supported


@pytest.mark.parametrize("name", ["rebound", "heyoka"])
def test_a_uniform_field_is_refused_rather_than_left_out(name):
    scene = scenes.make("kepler").model_copy(update={"gravity": (0.0, 0.0, -1.0)})
    assert any("gravity" in refusal.reason for refusal in engine(name).refusals(scene))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "method", "order", "spin"),
    [("exudyn", "generalized_alpha", 2.0, 1e-4), ("pinocchio", "rk4", 4.0, 1e-3), ("mujoco", "rk4", 4.0, 1e-3)],
)  # Pinocchio's spin is rounding
def test_engines_of_rigid_bodies_librate_in_the_gravity_gradient(name, method, order, spin):
    """Attraction and gradient are applied as forces; particles alone remain refused."""
    other, scene = engine(name), scenes.make("librating_satellite")
    times = np.linspace(0.0, 0.25 * scene.duration, 6)
    truth = truth_for(scene, times)
    assert truth is not None
    errors = []
    for steps in (200, 400):
        path = other.run(scene, Settings(method=method, step=times[-1] / steps, reactions=False), times)
        assert path.ok, path.message
        errors.append(np.abs(path.position - truth.position).max())
        alike = np.abs(np.sum(path.orientation[:, 1] * truth.orientation[:, 1], axis=1))
        assert alike.min() > 1.0 - 1e-4
    turning = np.abs(truth.angular_velocity).max()
    assert np.abs(path.angular_velocity - truth.angular_velocity).max() < spin * turning
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.3)
    kepler = scenes.make("kepler")
    refused = other.refusals(kepler) + other.method_refusals(kepler, other.method(method))
    assert any("particles alone" in refusal.reason for refusal in refused)
