"""Parts of the examination: what its scenes hold, what its broken engines break, and what counts as noise."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cross_checks.conformance import ladder
from cross_checks.conformance.bounces import bounces
from cross_checks.conformance.broken_engines import _dead_on_welds, _late, mistakes
from cross_checks.conformance.probes import probes
from cross_checks.conformance.symmetry import violation
from mbs_ref import scenes
from mbs_ref.scene import Weld
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Status, Trajectory

RNG = np.random.default_rng(6)


def motion(scene: Any, times: np.ndarray) -> Trajectory:
    n, b, d = len(times), len(scene.bodies), scene.dimension
    turns, spins = ((4,), (3,)) if d == 3 else ((), ())
    return Trajectory(times, *(RNG.normal(size=(n, b, *shape)) for shape in ((d,), turns, (d,), spins)))


def test_a_bounce_has_the_part_that_it_is_for():
    for kind, scene in bounces():
        (contact,) = scene.contacts
        assert kind in (contact.type, contact.law.type)
        assert len(scene.bodies) == 1 + ("on_circle" in contact.type or "on_sphere" in contact.type)


def test_every_broken_engine_differs_from_the_good_one_somewhere():
    listed = [
        *(*probes().values(), *(scene for _, scene in bounces())),
        scenes.make("pendulum"),
        scenes.make("n_four_bar"),
    ]
    times = np.linspace(0.0, 1.0, 5)
    for mistake in mistakes():
        changes = any(mistake.change(scene) != scene for scene in listed)
        spoils = False
        for scene in listed[-4:]:
            path = motion(scene, times)
            path = replace(path, timing=replace(path.timing, loop_s=1.0))
            spoiled = mistake.spoil(scene, path)
            spoils |= any(not np.array_equal(getattr(spoiled, name), getattr(path, name)) for name in (
                "times", "position", "orientation", "velocity", "angular_velocity"))  # fmt: skip
            spoils |= spoiled.timing.loop_s != 1.0
        assert changes or spoils or mistake.run.__name__ != "<lambda>", mistake.name


def test_an_engine_that_a_weld_stops_runs_without_one():
    good: Any = SimpleNamespace(run=lambda scene, settings, times: motion(scene, times))
    times = np.linspace(0.0, 1.0, 3)
    plain = scenes.make("pendulum")
    weld = Weld(name="weld", body_a="ground", body_b="rod", point=(0.0, 0.0))
    welded = plain.model_copy(update={"joints": (weld,)})
    assert _dead_on_welds(good, plain, Settings(), times).ok
    assert _dead_on_welds(good, welded, Settings(), times).status is Status.NON_FINITE


@pytest.mark.parametrize("settings", [Settings(method="rk4", step=0.04), Settings(method="rk4", step=0.5), Settings()])
def test_a_late_engine_gives_states_of_earlier_times(settings):
    asked: list[np.ndarray] = []
    good: Any = SimpleNamespace(run=lambda scene, settings, times: asked.append(times) or motion(scene, times))
    times = np.array([0.0, 0.3, 0.7])
    path = _late(good, scenes.make("pendulum"), settings, times)
    assert np.array_equal(path.times, times)
    assert asked[0][0] == 0.0
    assert (asked[0][1:] < times[1:]).all()
    assert (asked[0][1:] > 0.0).all()


def test_a_deviation_counts_by_the_finest_run(monkeypatch):
    """An error within roundoff by chance at a coarse step does not acquit a finer run that is not."""
    made: Any = SimpleNamespace(runs=[1, 2, 3], bar=0.0, posterior=lambda *given: None)
    monkeypatch.setattr(ladder, "_sentence", lambda what, shown, errors, floor, bar: f"off by {errors}")
    curves = [np.array([error]) for error in (1e-3, 1e-16, 1e-5)]
    assert ladder._Rungs.deviation(made, "energy", curves, 1e-12) == "off by [0.001, 1e-16, 1e-05]"
    assert ladder._Rungs.deviation(made, "energy", curves, 1e-4) == ""


@pytest.mark.parametrize(("nudge", "tolerance"), [(1e-3, 1e-2), (1e-2, 1e-3)])
def test_noise_is_the_largest_of_a_nudge_and_of_another_tolerance(nudge, tolerance):
    scene, times = scenes.make("pendulum"), np.linspace(0.0, 1.0, 3)
    plain = motion(scene, times)

    def run(scene, settings, times):
        offset = nudge if scene.name == "nudged" else tolerance if settings.rtol != 1e-6 else 0.0
        return replace(plain, position=plain.position + offset * np.array([0.6, 0.8]))

    engine: Any = SimpleNamespace(name="made", run=run)
    assert violation._noise(engine, scene, Settings(rtol=1e-6), times, plain) == pytest.approx(1e-2)
