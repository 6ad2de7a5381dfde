"""Pinocchio and Exudyn on the simplified android, with the same applied forces: dynamics is what is compared."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks import engines
from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

agreed = 1e-5  # m
force_agreed = 1.0  # N, of some 15 kN


@pytest.mark.parametrize(("name", "method"), [("pinocchio", "rk4"), ("exudyn", "tree_rk44")])
def test_the_simplified_android(name, method):
    pytest.importorskip(name)
    scene = scenes.make("android_simplified")
    ours = simulate(scene, Settings(rtol=1e-9, samples=41))
    theirs = engines.get(name).run(scene, Settings(method=method, step=5e-4, samples=41))
    assert theirs.ok, theirs.message
    assert np.abs(theirs.position - ours.position).max() < agreed
    for joint, force in theirs.reactions.items():
        assert np.abs(force[:, :2] - ours.reactions[joint][:, :2]).max() < force_agreed
