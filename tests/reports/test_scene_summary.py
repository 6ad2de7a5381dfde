import math
import re

import pytest

from mbs_ref import scenes
from mbs_ref.scene.scales import scales_of
from mbs_ref.simulate.linearised import stiffness_at_start
from reports.scene_summary import Summary, summary

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


@pytest.mark.parametrize("name", ["puma560", "stanford_arm", "straight_line_linkage"])
def test_a_drive_closes_no_loop(name):
    """It takes freedoms, and connects nothing that its joint does not."""
    driven = scenes.make(name)
    free = driven.model_copy(update={"joints": tuple(one for one in driven.joints if "drive" not in one.type)})
    assert summary(driven).loops == summary(free).loops
    assert summary(driven).joints > summary(free).joints


def test_a_forgotten_joint_is_seen():
    crank = scenes.make("slider_crank")
    found = summary(crank.model_copy(update={"joints": crank.joints[1:]}))
    assert (found.loops, found.freedoms) == (0, 3)
    assert "3 degrees of freedom" in found.sentence()


@pytest.mark.parametrize(("name", "parameters"), [("pendulum", {"length": 0.37, "mass": 2.3}),
                                                  ("spring_pendulum", {}), ("pendulum_chain", {"links": 3}),
                                                  ("solar_system", {}), ("slider_crank", {})])  # fmt: skip
def test_the_sentence_states_every_figure_in_its_unit(name, parameters):
    scene = scenes.make(name, **parameters)
    found = summary(scene)
    assert found.length == pytest.approx(scales_of(scene).length)
    assert found.mass == pytest.approx(sum(body.mass for body in scene.bodies))
    fastest = stiffness_at_start(scene).fastest / math.tau if found.freedoms else 0.0
    assert (found.fastest_hz or 0.0) == pytest.approx(fastest)
    figures = [len(scene.bodies), len(scene.joints), found.loops, found.freedoms, found.length, found.mass]
    figures += [found.fastest_hz] if found.fastest_hz else []
    assert [float(x) for x in re.findall(r"(?<![\w.])\d[\d.]*(?:e[+-]?\d+)?", found.sentence())] == [
        float(f"{x:.3g}") for x in figures]  # fmt: skip
    units = ["m, mass", "kg, fastest", "Hz"] if found.fastest_hz else ["m, mass", "kg"]
    assert re.findall(r"(?:m|kg|Hz)(?:, \w+)?(?= |$)", found.sentence().partition("; size")[2]) == units


def test_bodies_that_no_joint_connects_are_counted():
    """Two chains on the ground are two groups; particles alone are not listed as groups."""
    chain = scenes.make("double_pendulum")
    apart = chain.model_copy(update={"joints": chain.joints[:1]})
    assert (summary(chain).groups, summary(apart).groups) == (1, 2)
    assert "groups" not in summary(apart).sentence()  # each body is one
    crank = scenes.make("n_four_bar")
    loose = crank.model_copy(update={"joints": tuple(joint for joint in crank.joints if joint.ends[0] == "ground")})
    assert (" groups that no joint connects" in summary(loose).sentence()) == (
        1 < summary(loose).groups < len(loose.bodies)
    )


@pytest.mark.parametrize(("figures", "sentence"), [
    ((1, 1, 1, 1, 1, 0.5, 2.0, None), "1 body, 1 joint, 1 closed loop, 1 degree of freedom; size 0.5 m, mass 2 kg"),
    ((3, 2, 2, 0, 0, 1234.5, 1e-4, 98.765), "3 bodies in 2 groups that no joint connects, 2 joints, 0 closed loops, "
                                            "0 degrees of freedom; size 1.23e+03 m, mass 0.0001 kg, "
                                            "fastest frequency 98.8 Hz"),
    ((2, 2, 0, 2, None, 1.0, 1.0, None), "2 bodies, 0 joints, 2 closed loops, freedoms not counted; size 1 m, "
                                         "mass 1 kg"),
])  # fmt: skip
def test_the_sentence_as_a_whole(figures, sentence):
    assert Summary(*figures).sentence() == sentence
