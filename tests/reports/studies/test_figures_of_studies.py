"""Figures of studies, recomputed from made-up runs."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Trajectory
from reports.studies import androids, contact, space
from reports.studies.papers import lessons


def test_the_range_of_crashes(monkeypatch):
    """HIC36 is made up as a product of powers; a half sine of the peak force stops the mass."""

    def hic(mass: float, duration: float, speed: float) -> float:
        return mass**0.3 * duration**-1.5 * speed**2.5

    def made(name, *, mass, speed_change_km_h, peak_force, **more):
        duration = mass * speed_change_km_h / 3.6 / (peak_force * 2.0 / np.pi)  # s
        return SimpleNamespace(hic=hic(mass, duration, speed_change_km_h), duration=duration)

    monkeypatch.setattr(lessons, "scenes", SimpleNamespace(make=made))
    monkeypatch.setattr(lessons, "finished", lambda scene: None)
    monkeypatch.setattr(lessons, "crash_results", lambda scene, path: SimpleNamespace(measures={"HIC36": scene.hic}))
    found = lessons.crash_range()
    for name, exponent in (("mass", 0.3), ("duration", -1.5), ("speed", 2.5)):
        assert found.figures[f"range.exponent.{name}"] == pytest.approx(exponent)
    assert found.figures["range.force_least"] == pytest.approx(50.0 * 40.0 / 3.6 / 0.2)
    assert found.figures["range.force_most"] == pytest.approx(100.0 * 60.0 / 3.6 / 0.1)
    every = [hic(m, t, v) for m in lessons.MASSES for t in lessons.DURATIONS for v in lessons.SPEEDS]
    assert found.figures["range.HIC36_least"] == pytest.approx(min(every))
    assert found.figures["range.HIC36_most"] == pytest.approx(max(every))
    (drawn,) = found.curves.values()
    for duration in lessons.DURATIONS:
        expected = [hic(75.0, duration, v) for v in lessons.SPEEDS]
        assert drawn.lines[f"{duration:g} s"] == pytest.approx(expected, rel=1e-5)


def test_the_order_of_a_ladder_is_that_of_all_its_steps(monkeypatch):
    """The errors fall with the third power of the step, but for noise in the middle."""
    noise = iter((1.0, 3.0, 0.2, 5.0, 1.0))
    exact = contact.impact(contact._ball("rigid").contacts[0].law, 1.0, 1.0).restitution

    def run(ball, settings):
        return SimpleNamespace(velocity=np.full((2, 1, 2), exact + next(noise) * settings.step**3))

    monkeypatch.setattr(contact, "simulate", run)
    row = contact.ladder("rigid", "none")
    assert row["order"] == pytest.approx(3.0, rel=1e-4)
    assert row[str(contact.STEPS[0])] == pytest.approx((0.4 / contact.STEPS[0]) ** 3, rel=1e-6)


def test_paths_are_apart_by_their_largest_distance(monkeypatch):
    monkeypatch.setattr(androids, "truth_for", lambda scene, times: None)  # which takes seconds
    monkeypatch.setattr(androids, "off_truth", lambda scene, path: None)
    scene = scenes.make("android_simplified")
    rng, times = np.random.default_rng(1), androids.ladder.grid(scene)
    n, bodies = len(times), len(scene.bodies)
    one, other = (Trajectory(times, rng.normal(size=(n, bodies, 2)), *(rng.normal(size=shape) for shape in (
        (n, bodies), (n, bodies, 2), (n, bodies)))) for _ in range(2))  # fmt: skip
    measured = androids.Measured()
    row = androids.add_convergence(measured, scene, dict(zip(androids.UNLIKE, (one, other), strict=True)))
    for label, body in androids.WATCHED.items():
        gap = np.linalg.norm((one.position - other.position)[:, scene.body_index(body)], axis=1)
        assert row[label] == pytest.approx(gap[1:].max())


def test_what_a_bounce_exchanges_and_loses():
    """At 1 m/s, 1 kg: the contact takes 1/2 J and returns e^2/2."""
    ball = contact._ball("progressive")
    e = contact.impact(ball.contacts[0].law, 1.0, 1.0).restitution
    found = contact.balance(ball, Settings(method="dop853", rtol=1e-10, estimate="off"), longest=2e-3)
    assert found.exchanged == pytest.approx(0.5 * (1.0 + e**2), rel=1e-2)
    assert found.energy[-1] - found.energy[0] == pytest.approx(-0.5 * (1.0 - e**2), rel=1e-6)
    assert found.work[-1] == pytest.approx(-0.5 * (1.0 - e**2), rel=1e-4)


@pytest.mark.parametrize("rigid", [True, False])
def test_bodies_whose_cost_is_compared_fall_alike(rigid):
    """Twenty of 1 kg in a row, at rest, a metre apart."""
    scene = space._falling(rigid)
    assert scene.gravity == (0.0, 0.0, -9.81)
    assert [body.position for body in scene.bodies] == [(float(k), 0.0, 0.0) for k in range(20)]
    assert {(body.type, body.mass, body.velocity) for body in scene.bodies} == {
        ("spatial" if rigid else "point_mass", 1.0, (0.0, 0.0, 0.0))}  # fmt: skip


def test_a_cost_ratio_is_of_rigid_bodies_over_points_by_their_least_loops(monkeypatch):
    path = lambda loop_s: SimpleNamespace(timing=SimpleNamespace(loop_s=loop_s))  # noqa: E731
    asked: list[Any] = []
    monkeypatch.setattr(space, "interleaved", lambda runs, count: asked.extend([*runs, count]) or [
        [path(6.0), path(3.0)], [path(2.0), path(1.5)]])  # fmt: skip
    assert space._cost_ratio() == 2.0
    *runs, count = asked
    assert (count, [run.args[0] for run in runs]) == (9, [space._falling(True), space._falling(False)])
    assert [run.args[1] for run in runs] == [Settings(
        method="rk4", step=1e-4, t_end=0.2, samples=2, stabilization="none", estimate="off")] * 2  # fmt: skip
