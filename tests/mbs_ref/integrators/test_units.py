"""The same scene in other units of length and time: a relative tolerance gives the same relative error."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from cross_checks.conformance.symmetry.placement import Placement, image, moved
from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.scene.scales import scales_of
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory

ALIKE = 2.0  # the largest error over the least
UNITS = ((1.0, 1.0), (1e-2, 1.0), (1e2, 1.0), (1.0, 1e3))  # what a metre and a second become
SPAN = {"n_four_bar": 0.5, "heavy_top": 0.5, "satellite": 3000.0}  # s
RTOL = 1e-7
SPREAD = (0.5, 0.7, 1.0, 1.4, 2.0)  # of RTOL: roundoff leads IDA to other steps, and its error is a matter of chance
METHODS = {"dop853": (1.0,), "lsodar": (1.0,), "radau": (1.0,), "dassl": SPREAD}
CASES = [(name, method) for name in ("n_four_bar", "heavy_top") for method in ("dop853", "lsodar", "radau")]
CASES += [("satellite", "dop853"), ("satellite", "lsodar"), ("n_four_bar", "dassl")]
CASES += [pytest.param("heavy_top", "dassl", marks=pytest.mark.slow)]


def placed(scene: Scene, length: float, time: float) -> Placement:
    d = scene.dimension
    return Placement(np.eye(d), np.zeros(d), length=length, time=time)


def run(name: str, place: Placement, method: str, rtol: float) -> Trajectory:
    settings = Settings(method=method, rtol=rtol, t_end=SPAN[name] * place.time, samples=6, estimate="off")
    path = simulate(image(scenes.make(name), place), settings)
    assert path.ok, path.message
    return path


@cache
def tight(name: str) -> Trajectory:
    return run(name, placed(scenes.make(name), 1.0, 1.0), "dop853", 1e-12)


def error(name: str, units: tuple[float, float], method: str, rtol: float) -> float:
    """Return the largest error in position over the scene's length."""
    scene = scenes.make(name)
    place = placed(scene, *units)
    wanted, _ = moved(tight(name), place)
    far = np.abs(run(name, place, method, rtol).position - wanted).max()
    return float(far / (units[0] * scales_of(scene).length))


@pytest.mark.parametrize(("name", "method"), CASES)
def test_errors_follow_the_units(name, method):
    errors = [np.median([error(name, units, method, k * RTOL) for k in METHODS[method]]) for units in UNITS]
    assert max(errors) < ALIKE * min(errors), errors


@pytest.mark.parametrize("length", [1e-3, 1.0, 1.5e11])
@pytest.mark.parametrize("name", ["kepler", "pleiades", "n_four_bar"])
def test_scales_follow_the_units(name, length):
    scene = scenes.make(name)
    there, here = scales_of(image(scene, placed(scene, length, 1.0))), scales_of(scene)
    assert there.length == pytest.approx(length * here.length)
    assert there.time == pytest.approx(here.time)


def test_an_orbit_has_one_size_wherever_it_begins():
    """Its semi-major axis, 1 m; in a moment of an orbit that is all but open, the distance."""
    scene = scenes.make("kepler", eccentricity=0.9, orbits=1)
    path = simulate(scene, Settings(rtol=1e-12, samples=7, estimate="off"))
    center, planet = scene.bodies
    for place, velocity in zip(path.position[:, 1], path.velocity[:, 1], strict=True):
        there = planet.model_copy(update={"position": tuple(place), "velocity": tuple(velocity)})
        assert scales_of(scene.model_copy(update={"bodies": (center, there)})).length == pytest.approx(1.0)
    assert scales_of(scenes.make("kepler", eccentricity=0.999, orbits=1e-6)).length == pytest.approx(1e-3)
