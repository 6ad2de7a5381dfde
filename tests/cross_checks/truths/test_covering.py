"""The covering set of variants covers all pairs, and a small part of it meets its truths."""

from __future__ import annotations

import itertools

import pytest

from mbs_ref import scenes
from tests.cross_checks.truths.covering import FAULTS, outcome, pairwise, values, variants

QUICK = ("spherical_pendulum", "colliding_spheres", "incline", "rolling_disc", "bouncing_ball", "oblique_disc")
EVERY = 9  # of the variants of these scenes one is run here


def test_every_pair_of_values_occurs_and_the_first_variant_is_the_default():
    choices = values("colliding_spheres")
    rows = pairwise(choices)
    assert rows[0] == scenes.describe("colliding_spheres").parameters
    for a, b in itertools.combinations(choices, 2):
        assert {(row[a], row[b]) for row in rows} >= set(itertools.product(choices[a], choices[b]))
    assert len(rows) < 30


def test_values_are_choices_and_ends_of_ranges():
    found = values("incline") | values("android_spatial")
    assert found["angle"][1] == 0.0
    assert 1.49 < found["angle"][2] < 1.5
    assert found["oblique"] == [15.0, -45.0, 45.0]
    assert found["law"] == ["progressive", "spring_damper"]
    assert found["belts"] == [True, False]


@pytest.mark.parametrize(
    ("name", "parameters"), [one for scene in QUICK for one in variants(scene)[1::EVERY]], ids=lambda x: str(x)[:40]
)
def test_a_variant_meets_its_truth(name, parameters):
    found = outcome(name, parameters)
    assert found.kind not in FAULTS, found


def test_a_wrong_truth_is_detected(monkeypatch):
    monkeypatch.setattr("cross_checks.truths.of.sliding.DISC_ROUNDOFF", 1e-12)
    monkeypatch.setattr("tests.cross_checks.truths.covering.WRONG", -1.0)
    monkeypatch.setattr("tests.cross_checks.truths.covering.ESTIMATES", -1.0)
    assert outcome("rolling_disc", {}).kind == "wrong"
