"""Interpolants of multistep codes begin where their steps begin, so that no event is found twice."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from mbs_ref import scenes
from mbs_ref.integrators import integrators
from mbs_ref.integrators.loop.multistep import joined
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.simulate.plan import make_plan


def test_a_joined_interpolant_takes_the_value_and_slope_of_its_beginning_and_keeps_those_of_its_end():
    inside, start, slope = Polynomial([0.3, -1.0, 2.0, 0.7]), 1.7, -4.0
    begin, end, tiny = 0.4, 1.1, 1e-6
    between = joined(
        lambda t: np.array([inside(t)]),
        lambda t: np.array([inside.deriv()(t)]),
        (begin, np.array([start]), np.array([slope])),
        end,
    )
    assert between(begin)[0] == pytest.approx(start, abs=1e-15)
    assert (between(begin + tiny) - between(begin))[0] / tiny == pytest.approx(slope, abs=1e-4)
    assert between(end)[0] == pytest.approx(inside(end), abs=1e-15)
    assert (between(end) - between(end - tiny))[0] / tiny == pytest.approx(inside.deriv()(end), abs=1e-4)


@pytest.mark.parametrize(("name", "rtol", "t_end"), [("painleve_rod", 1e-4, 0.0275), ("rocking_block", 1e-3, None)])
def test_a_contact_just_left_or_reached_is_not_found_again_without_end(name, rtol, t_end):
    settings = Settings(method="lsodar", rtol=rtol, t_end=t_end, estimate="off", reactions=False)
    run = simulate(scenes.make(name), settings)
    assert run.ok, run.message
    assert run.events < 100


SHORT = {"tracked_vehicle": 0.01, "android_vertebral": 0.02, "android_spatial": 0.1, "suspension_rig": 0.3}
SOUND = [name for name, each in integrators().items()
         if each.locates_events and each.kind == "adaptive" and not each.weakness]  # fmt: skip


def _has_events(scene: Scene) -> bool:
    return bool(scene.contacts or scene.events or any(getattr(load, "tension_only", False) for load in scene.loads))


def _takes(scene: Scene, settings: Settings) -> bool:
    try:
        make_plan(scene, settings, None)
    except ValueError:
        return False
    return True


@pytest.mark.slow
@pytest.mark.parametrize("name", scenes.names())
def test_events_do_not_multiply(name):
    """Every method that takes the scene has about as many events as DOP853 at 1e-11."""
    scene, off = scenes.make(name), {}
    if not _has_events(scene):
        return
    settings = Settings(method="dop853", rtol=1e-11, max_steps=200_000, samples=11, estimate="off", reactions=False,
                        t_end=scene.duration * SHORT.get(name, 1.0))  # fmt: skip
    exact = simulate(scene, settings)
    for method, rtol in itertools.product(SOUND, (1e-5, 1e-7, 1e-9)):
        own = settings.model_copy(update={"method": method, "rtol": rtol})
        if _takes(scene, own):
            run = simulate(scene, own)
            if not run.ok or run.events > 1.2 * exact.events + 2:
                off[method, rtol] = run.events, run.message
    assert off == {}, f"not {exact.events} events"
