"""Scenes whose initial state breaks a joint are named before an engine snaps them together."""

from __future__ import annotations

import numpy as np

from cross_checks.engine.plan import broken_start, inconsistency
from mbs_ref import scenes
from mbs_ref.scene import Revolute
from tests.cross_checks.linkage.test_motion import mixed_tree


def test_a_loop_that_starts_open_is_named():
    scene = scenes.make("n_four_bar", loops=1)
    opened = [
        joint.model_copy(update={"point_b": (joint.point[0], joint.point[1] + 0.25)}) if joint.name == "A1" else joint
        for joint in scene.joints
        if isinstance(joint, Revolute)
    ]
    assert inconsistency(scene, 1e-9) == ""
    assert "'A1' starts 0.25 m open" in inconsistency(scene.model_copy(update={"joints": tuple(opened)}), 1.0)


def test_the_worst_gap_names_its_joint():
    scene = mixed_tree()
    assert broken_start(scene.model_copy(update={"joints": ()}), 0.0) == ""
    bad = scene.joints[-1].model_copy(update={"length": 2.0})
    broken = broken_start(scene.model_copy(update={"joints": (*scene.joints[:-1], bad)}), 1e-9)
    assert f"breaks joint 'string' by {2.0 - np.hypot(0.3, 0.8):.3g} (m, rad)" in broken
