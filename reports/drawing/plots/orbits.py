"""Orbits of the planets seen from north of the ecliptic, the Sun at rest in the middle."""

from __future__ import annotations

from typing import Any

import numpy as np

from cross_checks.records.plots.plot import new_figure, to_data
from mbs_ref.scene.celestial import AU_M

OBLIQUITY = np.radians(84_381.406 / 3600.0)  # of the ecliptic of J2000, IAU 2006
Places = dict[str, tuple[tuple[float, float, float], ...]]
INNER = ("mercury", "venus", "earth", "mars")


def inner_orbits(year: Places) -> dict[str, Any]:
    """Return the figure of the inner planets from barycentric places by body (n_t, 3), m, equatorial axes."""
    return _orbits(year, [name for name in year if name in INNER])


def outer_orbits(year: Places) -> dict[str, Any]:
    """Return the same of the others; the Moon would hide behind the Earth."""
    return _orbits(year, [name for name in year if name not in (*INNER, "sun", "moon")])


def _orbits(year: Places, shown: list[str]) -> dict[str, Any]:
    figure = new_figure("x, au", "y, au", x_log=False, y_log=False)
    sun = np.array(year["sun"])
    for name in shown:
        seen = (np.array(year[name]) - sun) / AU_M
        y = np.cos(OBLIQUITY) * seen[:, 1] + np.sin(OBLIQUITY) * seen[:, 2]
        figure.add_scatter(x=seen[:, 0].round(4).tolist(), y=y.round(4).tolist(), mode="lines", name=name)
        figure.add_scatter(x=[seen[-1, 0]], y=[y[-1]], mode="markers", showlegend=False, hoverinfo="skip")
    figure.add_scatter(x=[0.0], y=[0.0], mode="markers", name="sun", marker={"color": "#d97706", "size": 10})
    figure.update_yaxes(scaleanchor="x")
    return to_data(figure)
