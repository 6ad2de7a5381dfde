"""The sum of all that accelerates a scene's particles."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from cross_checks.certify.sky import figures, gravity, relativity, ring, satellites, tide
from cross_checks.certify.sky.numbers import Field, real
from mbs_ref.scene import Scene, celestial

# what each part of mbs_ref.scene.celestial does; Newton's gravity acts among all, and an epoch is a date
FIELDS: dict[type, Callable[[Scene, Any], Field]] = {
    celestial.Newton: gravity.newton,
    celestial.Relativity: relativity.post_newtonian,
    celestial.Oblateness: figures.zonal_harmonics,
    celestial.LunarFigure: figures.lunar_figure,
    celestial.Tide: tide.lagging_tide,
    celestial.Ring: ring.fixed_ring,
    celestial.ThirdBody: satellites.third_body,
    celestial.Drag: satellites.drag,
    celestial.StandardDrag: satellites.standard_drag,
    celestial.RadiationPressure: satellites.sunlight,
}


def acceleration(scene: Scene) -> Field:
    """Return the field of all loads of a celestial scene and its uniform gravity."""
    parts = [FIELDS[type(load)](scene, load) for load in scene.loads if type(load) is not celestial.Epoch]
    uniform = real(scene.gravity)

    def total(t: np.ndarray, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        return sum((part(t, x, v) for part in parts), np.broadcast_to(uniform, x.shape))

    return total
