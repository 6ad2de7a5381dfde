"""Taylor series of particles: their equations, order, closed forms, collisions, refusals and estimates."""

from __future__ import annotations

import math
import re
from functools import partial

import numpy as np
import pytest

from cross_checks.truths import truth_for
from mbs_ref import scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.kernels.particles import series as particles
from mbs_ref.observables.distance import distances
from mbs_ref.scene import PointMass, Scene
from mbs_ref.scene.celestial import Newton, Oblateness
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Status
from tests.mbs_ref.integrators.series_defect import defect

AXIS = (0.6, 0.0, 0.8)
FINE = Settings(method="taylor", rtol=1e-13, estimate="off")


def bodies(*parts: tuple[tuple[float, ...], tuple[float, ...]]) -> tuple[PointMass, ...]:
    return tuple(
        PointMass(name="abcd"[k], mass=1.0, position=place, velocity=speed) for k, (place, speed) in enumerate(parts)
    )


def cluster(**more) -> Scene:
    """Two oblate bodies, one without extent and one that attracts nothing, in a uniform field."""
    parts = bodies(
        ((0.0, 0.0, 0.0), (0.1, 0.0, -0.2)), ((1.3, -0.7, 0.9), (-0.3, 0.5, 0.2)),
        ((-1.1, 0.4, 1.2), (0.2, -0.6, 0.1)), ((0.2, 1.5, -0.8), (0.7, 0.1, 0.4)),
    )  # fmt: skip
    loads = (
        Newton(name="n", gm=(1.0, 0.5, 0.3, 0.0)),
        Oblateness(name="ja", body="a", radius=0.5, zonal=(0.1,), axis=AXIS),
        Oblateness(name="jb", body="b", radius=0.4, zonal=(-0.2,), axis=AXIS),
    )
    return Scene(name="cluster", gravity=(0.1, -0.2, 0.3), bodies=parts, loads=loads, **more)


def test_series_obey_the_equations_of_motion():
    """Where terms of order 25 are roundoff, and with an error of the order where they are not."""
    system = compile_scene(cluster())
    off = partial(defect, particles, system, system.initial_state())
    assert max(off(24, h) for h in (0.0, 0.1, 0.2)) < 1e-13
    assert math.log2(off(9, 0.2) / off(9, 0.1)) == pytest.approx(9.0, abs=1.0)


@pytest.mark.parametrize(("name", "parameters", "error"), [
    ("kepler", {}, 1e-10), ("kepler", {"eccentricity": 0.95, "orbits": 1.0}, 1e-10), ("figure_eight", {}, 1e-11),
    ("satellite", {"orbit": "molniya", "j2": False}, 1e-3),
])  # fmt: skip
def test_runs_reach_the_truth(name, parameters, error):
    """The truths are Kepler's equation, and collocation in extended precision."""
    scene = scenes.make(name, **parameters)
    run = simulate(scene, FINE)
    assert distances(scene, run, truth_for(scene, run.times))[..., 0].max() < error


def test_oblate_bodies_keep_their_common_momentum():
    scene = cluster(duration=3.0).model_copy(update={"gravity": (0.0, 0.0, 0.0)})
    run, other = (simulate(scene, FINE.model_copy(update={"method": method})) for method in ("taylor", "gauss"))
    momentum = np.einsum("b,tbc->tc", (1.0, 0.5, 0.3, 0.0), run.velocity)
    assert np.abs(momentum - momentum[0]).max() < 1e-13
    assert np.abs(run.position - other.position).max() < 1e-11


def test_outputs_and_bodies_at_rest_cost_no_steps():
    scene = scenes.make("satellite", orbit="molniya")
    few, many = (simulate(scene, FINE.model_copy(update={"samples": n})) for n in (2, 400))
    assert few.steps == many.steps
    assert np.abs(many.position[:, 0]).max() == 0.0


@pytest.mark.parametrize(("samples", "late"), [(1000, 0.0023), (2, 1.4)])
@pytest.mark.parametrize("method", ["taylor", "gauss"])
def test_bodies_that_meet_end_the_run(method, samples, late):
    """From rest at 2 m two with gm = 1 are 2 x apart after sqrt(2) (acos(sqrt(x)) + sqrt(x (1 - x))) s (free fall)."""
    fall = math.sqrt(2.0) * (math.acos(math.sqrt(0.9)) + 0.3)
    still = bodies(((-1.0, 0.0, 0.0), (0.0, 0.0, 0.0)), ((1.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    newton = Newton(name="n", gm=(1.0, 1.0), radius=(0.8, 1.0))
    scene = Scene(name="fall", gravity=(0.0, 0.0, 0.0), bodies=still, loads=(newton,), duration=2.2)
    run = simulate(scene, Settings(method=method, samples=samples, estimate="off"))
    assert run.status is Status.COLLISION
    end, gap = (float(re.search(pattern, run.message)[1]) for pattern in (r"t = (\S+) s", r"are (\S+) m apart"))
    assert fall * (1.0 - 1e-9) <= end <= fall + late
    assert gap <= 1.8
    assert run.times[-1] <= fall


def test_a_fall_into_a_point_stops_where_time_does_not_resolve_it():
    still = bodies(((-1.0, 0.0, 0.0), (0.0, 0.0, 0.0)), ((1.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    newton = Newton(name="n", gm=(1.0, 1.0))
    scene = Scene(name="fall", gravity=(0.0, 0.0, 0.0), bodies=still, loads=(newton,), duration=4.0)
    run = simulate(scene, FINE)
    assert run.status is Status.STEP_TOO_SMALL
    assert run.steps < 1000


def test_a_body_alone_falls_on_a_parabola():
    alone = bodies(((1.0, 2.0, 3.0), (0.5, -0.25, 0.125)))
    scene = Scene(name="throw", gravity=(0.1, -0.2, -9.81), bodies=alone, duration=2.0)
    run = simulate(scene, FINE)
    exact = np.array([1.0, 2.0, 3.0]) + 2.0 * np.array([0.5, -0.25, 0.125]) + 2.0 * np.array([0.1, -0.2, -9.81])
    assert run.position[-1, 0] == pytest.approx(exact, rel=1e-14)


@pytest.mark.parametrize(("name", "parameters", "why"), [
    ("satellite", {"zonals": True}, "'earth_j' has a pole that precesses, or harmonics beyond J2"),
    ("satellite", {"third_bodies": True}, "'sun' is a third_body"),
    ("solar_system", {"model": "j2"}, "bodies are oblate along different axes"),
])  # fmt: skip
def test_scenes_without_series_are_refused_with_the_reason(name, parameters, why):
    with pytest.raises(ValueError, match="'taylor' cannot run") as raised:
        simulate(scenes.make(name, **parameters), FINE)
    assert why in str(raised.value)


@pytest.mark.parametrize("name", ["kepler", "satellite", "figure_eight"])
def test_estimates_contain_the_error(name):
    scene = scenes.make(name)
    times = np.linspace(0.0, scene.duration, 20)
    truth = truth_for(scene, times)
    for rtol in (1e-5, 1e-8, 1e-11):
        run = simulate(scene, Settings(method="taylor", rtol=rtol), times)
        error = distances(scene, run, truth)[..., 0].max()
        assert run.estimate is not None
        assert error < run.estimate.value * run.estimate.length < 1e3 * error
