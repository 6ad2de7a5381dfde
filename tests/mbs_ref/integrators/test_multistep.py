"""Interpolants of multistep codes begin where their steps begin, so that no event is found twice."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from mbs_ref import scenes
from mbs_ref.integrators import integrators
from mbs_ref.integrators.loop.multistep import joined
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory


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


@pytest.mark.parametrize(("name", "rtol"), [("painleve_rod", 1e-4), ("rocking_block", 1e-3)])
def test_a_contact_just_left_or_reached_is_not_found_again_without_end(name, rtol):
    run = simulate(scenes.make(name), Settings(method="lsodar", rtol=rtol, estimate="off", reactions=False))
    assert run.ok, run.message
    assert run.events < 100


SHORT = {"tracked_vehicle": 0.01, "android_vertebral": 0.02, "android_spatial": 0.1, "suspension_rig": 0.3}
ADAPTIVE = [name for name, each in integrators().items() if each.locates_events and each.kind == "adaptive"]


@cache
def _run(name: str, method: str, rtol: float) -> Trajectory:
    scene = scenes.make(name)
    t_end = scene.duration * SHORT.get(name, 1.0)
    settings = Settings(method=method, rtol=rtol, max_steps=200_000, samples=11, t_end=t_end)
    return simulate(scene, settings.model_copy(update={"estimate": "off", "reactions": False}))


@pytest.mark.slow
@pytest.mark.parametrize("rtol", [1e-5, 1e-7, 1e-9])
@pytest.mark.parametrize("method", ADAPTIVE)
@pytest.mark.parametrize("name", scenes.names())
def test_events_do_not_multiply(name, method, rtol):
    """Every method has about as many events as DOP853 at 1e-11, in every scene that has any."""
    exact = _run(name, "dop853", 1e-11)
    if not exact.events:
        pytest.skip("no events")
    try:
        run = _run(name, method, rtol)
    except ValueError as refusal:
        pytest.skip(str(refusal))
    if integrators()[method].weakness and not run.ok:
        pytest.skip(integrators()[method].weakness)
    assert run.ok, run.message
    assert run.events <= 1.2 * exact.events + 2
