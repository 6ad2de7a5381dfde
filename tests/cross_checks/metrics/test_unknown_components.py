"""A component that the truth lacks, or knows less well than the difference, is unknown with a bound, and never 0."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from cross_checks.judge.measure import error_of, measure
from cross_checks.metrics.metric import Judged, from_truth, known_to
from cross_checks.truths.truth import ONE_FIGURE, Truth
from mbs_ref.scene import PlanarBody, PointMass, Scene
from mbs_ref.scene.scales import scales_of
from mbs_ref.trajectory import Status, Trajectory
from reports.cli import main

DOT = PointMass(name="dot", mass=1.0, position=(0.0, 0.0), velocity=(0.0, 0.0))
ROD = PlanarBody(name="rod", mass=3.0, inertia=12.0, position=(5.0, 0.0))
SCENE = Scene(name="two", bodies=(DOT, ROD), gravity=(0.0, 0.0), duration=2.0)
TIMES = np.linspace(0.0, 2.0, 6)
KNOWN, RATES = 1e-9, 1e-6  # m; m/s and rad/s


def run(place: float, turn: float, speed: float, spin: float) -> Trajectory:
    """Return a run whose rod is off at the first sample, and by nothing later."""
    first = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])[:, None] * np.array([0.0, 1.0])
    ahead = np.array([0.6, 0.8])
    return Trajectory(
        TIMES, first[..., None] * ahead * place, first * turn, first[..., None] * ahead * speed, first * spin,
        status=Status.SUCCESS, message="",
    )  # fmt: skip


def truth(**given) -> Truth:
    zero, flat = np.zeros((6, 2, 2)), np.zeros((6, 2))
    whole = Truth(zero, flat, KNOWN, "exact", "by hand", velocity=zero, angular_velocity=flat,
                  rate_uncertainty=np.full(6, RATES))  # fmt: skip
    return replace(whole, **given)


def test_what_differs_by_more_than_the_truth_doubts_is_known():
    found = measure(Judged(SCENE, run(0.2, 0.3, 0.4, 0.5), truth()))
    names = ("position_error", "orientation_error", "velocity_error", "angular_velocity_error")
    assert [found["measures"][name] for name in names] == pytest.approx([0.2, 0.3, 0.4, 0.5])
    assert found["bounds"] == {}


def test_what_differs_by_less_is_below_the_difference_and_the_doubt():
    apart = 8.0 * KNOWN, 5.0 * KNOWN, 2.0 * RATES, 9.0 * RATES
    found = measure(Judged(SCENE, run(*apart), truth()))
    arm = math.sqrt(12.0 / 3.0)
    assert {name: found["measures"][name] for name in found["bounds"]} == dict.fromkeys(found["bounds"])
    assert found["bounds"] == pytest.approx({
        "position_error": apart[0] + KNOWN, "velocity_error": 3.0 * RATES, "angular_velocity_error": 10.0 * RATES,
        "orientation_error": apart[1] + KNOWN / arm,
    })  # fmt: skip
    assert ONE_FIGURE == 10.0


def test_a_truth_without_rates_leaves_them_unknown_and_unbounded():
    for bare in (truth(velocity=None, angular_velocity=None), truth(rate_uncertainty=None)):
        found = measure(Judged(SCENE, run(0.2, 0.3, 0.4, 0.5), bare))
        assert found["measures"]["velocity_error"] is found["measures"]["angular_velocity_error"] is None
        assert found["bounds"] == {}


def test_unknown_rates_do_not_raise_the_error_and_poses_count_as_they_are():
    scales = scales_of(SCENE)
    error, curve = error_of(Judged(SCENE, run(2.0 * KNOWN, 0.0, 9.0 * RATES, 9.0 * RATES), truth()))
    assert error is not None
    assert error.value == pytest.approx(2.0 * KNOWN / scales.length)
    assert not error.is_judged
    assert error.worst.startswith("position of rod at t = 0 s")
    assert curve == pytest.approx([error.value, 0.0, 0.0, 0.0, 0.0, 0.0])
    louder, _ = error_of(Judged(SCENE, run(8.0 * KNOWN, 0.0, 11.0 * RATES, 0.0), truth()))
    assert louder is not None
    assert louder.value == pytest.approx(11.0 * RATES / scales.speed)
    assert louder.uncertainty == known_to(SCENE, truth()) == pytest.approx(KNOWN / 2.0)


def test_times_that_the_truth_does_not_cover_are_unknown():
    late = truth()
    late.position[:5], late.orientation[:5] = np.nan, np.nan
    late = replace(late, velocity=None)
    errors = from_truth(SCENE, run(0.2, 0.3, 0.4, 0.5), late)
    assert np.isnan(errors.sizes[:5, :, :3]).all()
    error, curve = error_of(Judged(SCENE, run(0.2, 0.3, 0.4, 0.0), late))
    assert error is not None
    assert curve == [None] * 5 + [0.0]


def test_json_has_null_and_the_bound(tmp_path):
    store = ["--store", str(tmp_path / "runs.sqlite"), "--json"]
    top = CliRunner().invoke(main, ["simulate", "torque_free_top", "-p", "turns=100", "--rtol", "1e-13", *store])
    record = json.loads(top.stdout)
    assert record["measures"]["angular_velocity_error"] is None
    assert 0.0 < record["bounds"]["angular_velocity_error"] < 1e-6  # rad/s
    orbit = json.loads(CliRunner().invoke(main, ["simulate", "kepler", *store]).stdout)
    assert orbit["measures"]["orientation_error"] is orbit["measures"]["angular_velocity_error"] is None
    assert not orbit["bounds"].keys() & {"orientation_error", "angular_velocity_error"}
    text = CliRunner().invoke(main, ["simulate", "torque_free_top", "-p", "turns=100", "--rtol", "1e-13", *store[:2]])
    assert f"below {record['bounds']['angular_velocity_error']:.3g} rad/s" in text.output
