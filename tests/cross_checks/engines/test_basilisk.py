"""Basilisk: orders on satellites, and what is refused; the mapping is asked where the engine is not installed, too."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cross_checks.engine.celestial import no_satellites, normalized_zonals, planet_of
from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.scene.celestial import Oblateness
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from tests.cross_checks.engines.engine_runs import distance, engine, observed_order

TIMES = np.linspace(0.0, 4320.0, 3)
HELD = "rk4_held_air"


def reasons(name: str, **parameters) -> str:
    return "; ".join(no_satellites(scenes.make(name, **parameters)))


def test_a_planet_at_rest_with_satellites_is_what_is_asked_for():
    assert not reasons("satellite", zonals=True, drag=True)
    assert not reasons("kepler")
    assert planet_of(scenes.make("satellite")) == 0


def test_what_does_not_fit_is_refused_by_name():
    assert "body1, body2, body3 attract" in reasons("figure_eight")
    held = reasons("satellite", third_bodies=True, radiation=True)
    assert all(word in held for word in ("third_body 'sun'", "third_body 'moon'", "radiation_pressure 'light'"))
    scene = scenes.make("satellite")
    tilted = scene.loads[2].model_copy(update={"axis": (0.6, 0.0, 0.8)})
    assert isinstance(tilted, Oblateness)
    moved = scene.bodies[0].model_copy(update={"velocity": (1.0, 0.0, 0.0)})
    bad = {"loads": (*scene.loads[:2], tilted), "bodies": (moved, scene.bodies[1]), "gravity": (0.0, 0.0, -1.0)}
    told = "; ".join(no_satellites(scene.model_copy(update=bad)))
    assert all(word in told for word in ("fixed z axis", "must rest in the origin", "no uniform field"))


def test_normalized_zonals_are_the_published_ones():
    """EGM2008's C_20, C_30 and C_40, fully normalized (Pavlis et al. 2012), as they are distributed."""
    found = normalized_zonals(scenes.make("satellite", zonals=True).loads[2].zonal)  # pyright: ignore
    assert found[:2] == [1.0, 0.0]
    assert found[2:5] == pytest.approx([-0.484165143790815e-3, 0.957161207093473e-6, 0.539965866638991e-6], rel=1e-12)
    assert -found[2] * math.sqrt(5.0) == pytest.approx(1.08262617385222e-3, rel=1e-15)


def error(scene: Scene, method: str, **accuracy) -> float:
    ours = simulate(scene, Settings(method="gauss", rtol=1e-16, estimate="off"), TIMES)
    theirs = engine("basilisk").run(scene, Settings(method=method, **accuracy), TIMES)
    assert theirs.ok, theirs.message
    return distance(ours, theirs)


@pytest.mark.parametrize(("method", "order"), [("rk4", 4.0), ("rk2", 2.0)])
def test_the_order_shows_on_a_satellite_over_an_oblate_earth(method, order):
    scene = scenes.make("satellite", zonals=True)
    errors = [error(scene, method, step=step) for step in (21.6, 10.8)]
    assert observed_order(errors) == pytest.approx(order, abs=0.3)


def test_embedded_pairs_follow_their_tolerance():
    scene = scenes.make("satellite", orbit="molniya")
    coarse, fine = (error(scene, "rkf78", rtol=rtol) for rtol in (1e-10, 1e-13))
    assert fine < coarse / 50.0
    assert fine < 1e-3  # m


def test_held_air_is_of_first_order_and_converges_to_the_same():
    scene = scenes.make("satellite", drag=True)
    errors = [error(scene, HELD, step=step) for step in (2.7, 1.35)]
    assert observed_order(errors) == pytest.approx(1.0, abs=0.3)
    assert errors[-1] < 2e-3  # m, of 40 m that the air does


def test_methods_that_hide_the_held_air_are_refused():
    found, air, none = engine("basilisk"), scenes.make("satellite", drag=True), scenes.make("satellite")
    assert "first order" in found.method_refusals(air, found.method("rk4"))[0].reason
    assert "there is none" in found.method_refusals(none, found.method(HELD))[0].reason
