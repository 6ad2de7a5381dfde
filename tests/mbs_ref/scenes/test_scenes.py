"""The registry of scenes: what it offers and how it refuses."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cross_checks.truths import truth_for
from mbs_ref import scenes
from mbs_ref.scene.toml import builder
from mbs_ref.scene.traits import traits


def test_lists_every_scene_of_the_first_issue():
    expected = {
        "pendulum", "pendulum_chain", "n_four_bar", "double_pendulum", "slider_crank", "driven_pendulum",
        "spring_pendulum",
    }  # fmt: skip
    assert expected <= set(scenes.names())


@pytest.mark.parametrize("name", scenes.names())
def test_every_scene_builds_with_its_defaults_and_says_where_it_is_from(name):
    scene, info = scenes.make(name), scenes.describe(name)
    assert scene.name == name
    assert scene.parameters == info.parameters
    assert scene.source
    assert info.summary.endswith(".")


def test_parameters_reach_the_scene_and_are_kept():
    scene = scenes.make("pendulum_chain", links="3")  # text, as the command line gives it
    assert len(scene.bodies) == 3
    assert scene.parameters["links"] == 3


@pytest.mark.parametrize(
    ("name", "parameters", "words"),
    [
        ("pendulum_chian", {}, ["pendulum_chian", "did you mean 'pendulum_chain'"]),
        ("pendulum_chain", {"link": 3}, ["link", "3", "did you mean 'links'"]),
        ("pendulum_chain", {"links": 0}, ["links", "0", "greater than or equal to 1"]),
        ("pendulum_chain", {"links": 2.5}, ["links", "2.5", "integer"]),
        ("pendulum_chain", {"gravity": float("nan")}, ["gravity", "nan", "finite"]),
        ("pendulum", {"length": -1.0}, ["length", "-1.0", "greater than 0"]),
        ("slider_crank", {"rod_length": 0.2}, ["rod_length", "0.2", "exceed"]),
    ],
)
def test_a_wrong_choice_is_named_with_what_is_allowed(name, parameters, words):
    with pytest.raises(ValueError) as caught:
        scenes.make(name, **parameters)
    assert all(word in str(caught.value) for word in words), str(caught.value)


@pytest.mark.parametrize(
    ("name", "present", "absent"),
    [
        ("pendulum_chain", {"planar"}, {"closed-loop", "rheonomic", "free-body"}),
        ("n_four_bar", {"closed-loop"}, {"rheonomic", "free-body"}),
        ("slider_crank", {"closed-loop"}, {"rheonomic"}),
        ("driven_pendulum", {"rheonomic"}, {"closed-loop", "free-body"}),
        ("spring_pendulum", {"unconstrained", "point-mass"}, {"closed-loop"}),
    ],
)
def test_traits(name, present, absent):
    found = traits(scenes.make(name))
    assert present <= found
    assert not absent & found


def test_a_scene_file_is_described_by_the_comments_at_its_head_alone():
    assert builder('# Swing.\n#\n# At 1 µm.\nname = "made"\n# a choice\n').__doc__ == "Swing.\n\nAt 1 µm."


def test_every_scene_takes_another_duration():
    """Its truth is the same."""
    short = scenes.make("slider_crank", crank_speed=3.0, duration=0.5)
    assert short.duration == 0.5
    assert scenes.label(short.name, short.parameters) == "slider_crank crank_speed=3.0 duration=0.5"
    truths = [truth_for(scenes.make("pendulum", **given), np.array([0.0, 0.5])) for given in ({}, {"duration": 0.5})]
    assert np.array_equal(truths[0].position, truths[1].position)
    for wrong in (0.0, -1.0, math.inf, math.nan, "long", True):
        with pytest.raises(ValueError, match=r"pendulum: duration = .* must be a finite number greater than 0"):
            scenes.make("pendulum", duration=wrong)
