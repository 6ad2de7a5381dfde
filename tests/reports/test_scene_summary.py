import pytest

from mbs_ref import scenes
from reports.scene_summary import summary

KNOWN = [  # bodies, loops, freedoms by Gruebler's count, or as the papers say where it fails
    ("slider_crank", {}, 3, 1, 1),
    ("n_four_bar", {"loops": 2}, 5, 2, 1),
    ("bricard", {}, 5, 1, 1),
    ("pendulum_chain", {"links": 3}, 3, 0, 3),
    ("spatial_chain", {"links": 3}, 3, 0, 9),
    ("kepler", {}, 2, 0, 6),
]


@pytest.mark.parametrize(("name", "parameters", "bodies", "loops", "freedoms"), KNOWN)
def test_bodies_loops_and_freedoms(name, parameters, bodies, loops, freedoms):
    found = summary(scenes.make(name, **parameters))
    assert (found.bodies, found.loops, found.freedoms) == (bodies, loops, freedoms)


def test_a_forgotten_joint_is_seen():
    crank = scenes.make("slider_crank")
    found = summary(crank.model_copy(update={"joints": crank.joints[1:]}))
    assert (found.loops, found.freedoms) == (0, 3)
    assert "3 degrees of freedom" in found.sentence()


def test_size_and_mass():
    found = summary(scenes.make("pendulum"))
    assert found.mass == 1.0
    assert found.length == pytest.approx(1.0)
