"""Other engines drive the tracked vehicle: their dynamics and loop closure, our contact forces."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks import engines
from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

agreed = 1e-4  # m
MODELS = [{}, {"suspension": True, "ground": "bump"}]


def apart(scene, name: str, settings: Settings, t_end: float) -> float:
    """Largest distance of any body from our RK4 at a step twenty times below the contacts' half period."""
    pytest.importorskip(name)
    times = np.linspace(0.0, t_end, 11)
    ours = simulate(scene, Settings(method="rk4", step=5e-5, estimate="off", reactions=False), times)
    theirs = engines.get(name).run(scene, settings, times)
    assert ours.ok, ours.message
    assert theirs.ok, theirs.message
    return float(np.abs(theirs.position - ours.position).max())


@pytest.mark.parametrize("model", MODELS, ids=["rolling", "sprung"])
def test_pinocchio_starts_to_drive_the_track(model):
    scene = scenes.make("tracked_vehicle", **model)
    assert apart(scene, "pinocchio", Settings(method="rk4", step=1e-4, reactions=False), 0.05) < agreed


@pytest.mark.slow
@pytest.mark.parametrize("model", MODELS, ids=["rolling", "sprung"])
@pytest.mark.parametrize(
    ("name", "method", "step"), [("pinocchio", "rk4", 1e-4), ("exudyn", "generalized_alpha", 1e-4)]
)
def test_engines_drive_half_a_second(model, name, method, step):
    scene = scenes.make("tracked_vehicle", **model)
    assert apart(scene, name, Settings(method=method, step=step, reactions=False), 0.5) < agreed
