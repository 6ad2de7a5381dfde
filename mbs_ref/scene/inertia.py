"""Inertia of uniform solids about their centre, as SpatialBody takes it: xx, yy, zz, xy, xz, yz in kg m^2."""

from __future__ import annotations


def sphere(mass: float, radius: float) -> tuple[float, float, float, float, float, float]:
    """Return 2/5 m r^2 about every axis."""
    moment = 0.4 * mass * radius**2
    return moment, moment, moment, 0.0, 0.0, 0.0


def block(mass: float, a: float, b: float, c: float) -> tuple[float, float, float, float, float, float]:
    """Return the inertia of a block with the sides a, b, c (m) along x, y, z."""
    share = mass / 12.0
    return share * (b * b + c * c), share * (a * a + c * c), share * (a * a + b * b), 0.0, 0.0, 0.0
