"""A contact that holds ends where its point passes an open end, however short it stays there."""

from __future__ import annotations

from math import asin

import numpy as np
import pytest

from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

RADIUS, GRAVITY = 0.1, 9.81  # m, m/s^2
CELLS = [(dimension, method) for dimension in (2, 3) for method in ("dop853", "radau", "lsodar")]


def slider(seed: int, dimension: int) -> tuple[Scene, float]:
    """Return a ball at rest on a plate along which x = sin(omega t) moves it, and when its point passes the end (s).

    It passes the end by less than it is pressed in; so all but close to there, the depth is smaller than the distance
    from the end.
    """
    random = np.random.default_rng(seed)
    omega, depth = 10.0 ** random.uniform(1.3, 3.0), 10.0 ** random.uniform(-5.0, -3.0)  # rad/s, m
    excess = depth * 10.0 ** random.uniform(-3.0, -0.3)  # m
    flat, end = dimension == 2, 1.0 - excess
    place = (0.0, RADIUS - depth) if flat else (0.0, 0.0, RADIUS - depth)
    contact = {"name": "plate", "body_a": "ball", "body_b": "ground", "center": place, "radius": RADIUS}
    contact["law"] = {"type": "spring_damper_law", "stiffness": GRAVITY / depth}
    if flat:
        contact |= {"type": "circle_on_line", "point_1": (-3.0, 0.0), "point_2": (end, 0.0), "extent": "segment"}
    else:
        contact |= {"type": "sphere_on_plane", "point": (0.0, 0.0, 0.0), "normal": (0.0, 0.0, 1.0),
                    "edge": (1.0, 0.0, 0.0), "size": (2.0 * end, 4.0), "extent": "rectangle"}  # fmt: skip
    scene = Scene.model_validate({
        "name": "slider", "duration": 2.0 / omega, "gravity": (*(0.0,) * (dimension - 1), -GRAVITY),
        "bodies": [{
            "type": "planar" if flat else "spatial", "name": "ball", "mass": 1.0,
            "inertia": 0.1 if flat else (0.1, 0.1, 0.1, 0.0, 0.0, 0.0),
            "position": place, "velocity": (omega, *(0.0,) * (dimension - 1)),
        }],
        "joints": [{
            "type": "coordinate_drive", "name": "drive", "body": "ball", "coordinate": "x",
            "motion": {"type": "harmonic", "amplitude": 1.0, "omega": omega},
        }],
        "contacts": [contact],
    })  # fmt: skip
    return scene, asin(end) / omega


def check(seeds: range, dimension: int, method: str) -> None:
    for seed in seeds:
        scene, first = slider(seed, dimension)
        for samples in (2, 101):
            run = simulate(scene, Settings(method=method, rtol=1e-8, samples=samples, estimate="off"))
            assert run.event_times is not None
            assert run.event_times[:, 0].min(initial=np.inf) == pytest.approx(first, rel=1e-6), (seed, samples)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_short_way_past_an_end_is_an_event(dimension):
    check(range(120, 124), dimension, "dop853")


@pytest.mark.slow
@pytest.mark.parametrize(("dimension", "method"), CELLS)
def test_short_ways_past_an_end_are_events_of_all_methods(dimension, method):
    check(range(200, 240), dimension, method)
