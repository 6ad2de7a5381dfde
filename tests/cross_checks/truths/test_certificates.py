"""Certificates of truths: what is kept, what makes a truth depart from it, and who may not be judged."""

from __future__ import annotations

from dataclasses import replace

import pytest

from cross_checks.judge.bounds import AGREEMENT
from cross_checks.judge.certify import certify
from cross_checks.records.record import Error
from cross_checks.truths import certificate
from cross_checks.truths.certificate import Certificate, departure, holds, read, stored, write
from cross_checks.truths.truth import ONE_FIGURE, NoTruth
from mbs_ref import scenes
from mbs_ref.scene.scales import unit_length

QUICK = ("n_four_bar", "pendulum", "spring_pendulum", "torque_free_top")
EVERY = certificate.every()


def test_every_kept_certificate_judges_agreement_and_is_confirmed():
    assert len(EVERY) >= 12
    for kept in EVERY:
        near = AGREEMENT * unit_length(scenes.make(kept.scene, **kept.parameters))  # what a verdict calls agreement
        assert ONE_FIGURE * kept.uncertainty <= near, kept.scene
        assert kept.confirmed_to is None or kept.confirmed_to < near, kept.scene


@pytest.mark.parametrize("name", QUICK)
def test_the_truth_made_again_is_the_one_certified(name):
    scene = scenes.make(name)
    kept, fresh = stored(scene), certify(scene, confirm=False)
    assert kept is not None
    assert isinstance(fresh, Certificate)
    assert holds(kept, fresh), f"{departure(kept, fresh):.1e} m apart"


@pytest.mark.slow
@pytest.mark.parametrize("kept", EVERY, ids=certificate.file_name)
def test_every_truth_made_again_is_the_one_certified(kept):
    fresh = certify(scenes.make(kept.scene, **kept.parameters), confirm=False)
    if isinstance(fresh, NoTruth):
        pytest.skip(fresh.reason)  # an ephemeris that is not installed here
    assert holds(kept, fresh), f"{departure(kept, fresh):.1e} m apart"


def pendulum() -> Certificate:
    found = certify(scenes.make("pendulum"), confirm=False)
    assert isinstance(found, Certificate)
    return found


def test_a_certificate_survives_the_disk(tmp_path):
    made = pendulum()
    file = write(made, tmp_path)
    assert file.name == "pendulum.json"
    assert read(file) == made
    assert stored(scenes.make("pendulum"), tmp_path) == made
    assert stored(scenes.make("pendulum", length=2.0), tmp_path) is None
    file.write_text("{}")
    with pytest.raises(ValueError, match=r"pendulum\.json holds no certificate"):
        read(file)


def test_the_known_digits_are_the_published_ones():
    """Simple pendulum released horizontally, t = 10 s: x = -0.2750874625761, y = -0.9614192050991 m."""
    made = pendulum()
    assert made.end["bob"] == pytest.approx([-0.2750874625761, -0.9614192050991], abs=1e-13)
    assert made.decimals >= 14


def test_a_truth_that_moved_departs():
    made = pendulum()
    x, y = made.end["bob"]
    assert x is not None
    moved = replace(made, end={"bob": [x + 10.0 * made.uncertainty, y]})
    assert holds(made, made)
    assert not holds(moved, made)
    with pytest.raises(ValueError, match="different truths"):
        departure(replace(made, t_end=3.0), made)


def test_no_truth_no_certificate():
    assert isinstance(certify(scenes.make("pendulum_chain", links=1000)), NoTruth)


def test_an_error_below_the_uncertainty_is_not_judged():
    near, far = (Error(value, "converged: made up", 1e-10, value) for value in (0.9e-10, 1.1e-10))
    assert (near.is_judged, far.is_judged) == (False, True)
    assert near.bound == pytest.approx(1.9e-10)


def test_the_papers_android_has_a_certificate_of_its_own():
    """The papers' android has a certificate of its own, which is not that of the believable one."""
    bare, full = scenes.make("android_simplified", model="paper"), scenes.make("android_simplified")
    found, other = stored(bare), stored(full)
    assert found is not None
    assert other is not None
    assert found.parameters == bare.parameters
    assert other.parameters == full.parameters
    with pytest.raises(ValueError, match="different truths"):
        departure(found, other)
