"""Bodies and joints that several families share."""

from __future__ import annotations

import math

from mbs_ref.scene import GROUND, PlanarBody, Revolute, Scene

GRAVITY = 9.81  # m/s^2
LENGTH, MASS = 1.0, 1.0  # m, kg, of a uniform rod
INERTIA = MASS * LENGTH**2 / 12.0  # kg m^2, about its centre
ROD_RATE = math.sqrt(1.5 * GRAVITY / LENGTH)  # rad/s: theta'' = -rate^2 sin(theta) of a rod hinged at its end


def rod(name: str, foot: tuple[float, float], angle: float, mass: float = MASS, **rates) -> PlanarBody:
    """Return a uniform rod from `foot` (m) at an angle (rad) from the x axis."""
    centre = (foot[0] + 0.5 * LENGTH * math.cos(angle), foot[1] + 0.5 * LENGTH * math.sin(angle))
    return PlanarBody(name=name, mass=mass, inertia=mass / 12.0 * LENGTH**2, position=centre, angle=angle, **rates)


def tip(foot: tuple[float, float], angle: float) -> tuple[float, float]:
    """Return where the rod ends (m)."""
    return foot[0] + LENGTH * math.cos(angle), foot[1] + LENGTH * math.sin(angle)


def rod_chain(name: str, angles: tuple[float, ...], masses: tuple[float, ...], gravity: float = GRAVITY) -> Scene:
    """Return rods hinged in a row, the first to the origin, at angles (rad) from the x axis, at rest."""
    feet = [(0.0, 0.0)]
    for angle in angles:
        feet.append(tip(feet[-1], angle))
    names = [f"rod{k + 1}" for k in range(len(angles))]
    bodies = tuple(rod(n, f, a, m) for n, f, a, m in zip(names, feet, angles, masses, strict=False))
    joints = tuple(
        Revolute(name=f"hinge{k + 1}", body_a=GROUND if k == 0 else names[k - 1], body_b=names[k], point=feet[k])
        for k in range(len(names))
    )
    return Scene(name=name, gravity=(0.0, -gravity), bodies=bodies, joints=joints)
