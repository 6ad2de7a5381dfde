"""Rods, sleds and closed forms of their motion that several families share."""

import math
from pathlib import Path

import numpy as np

from cross_checks.truths.made_by.numerics.closed_forms import amplitude, quarter_period
from mbs_ref.scene import GROUND, Force, PlanarBody, Revolute, Scene
from mbs_ref.scene.signals import Constant, HalfSine
from mbs_ref.scene.toml import read_builder

GRAVITY = 9.81  # m/s^2
LENGTH, MASS = 1.0, 1.0  # m, kg, of a uniform rod
INERTIA = MASS * LENGTH**2 / 12.0  # kg m^2, about its centre
ROD_RATE = math.sqrt(1.5 * GRAVITY / LENGTH)  # rad/s: theta'' = -rate^2 sin(theta) of a rod hinged at its end


def made(name: str, **parameters: float) -> Scene:
    """Return the scene of a file of the folder `scenes`, with the parameters that it declares."""
    return read_builder(Path(__file__).parent / "scenes" / f"{name}.toml")(**parameters)


def rod(name: str, foot: tuple[float, float], angle: float, mass: float = MASS, **rates) -> PlanarBody:
    """Return a uniform rod from `foot` (m) at an angle (rad) from the x axis."""
    centre = (foot[0] + 0.5 * LENGTH * math.cos(angle), foot[1] + 0.5 * LENGTH * math.sin(angle))
    return PlanarBody(name=name, mass=mass, inertia=mass / 12.0 * LENGTH**2, position=centre, angle=angle, **rates)


def tip(foot: tuple[float, float], angle: float) -> tuple[float, float]:
    """Return where the rod ends (m)."""
    return foot[0] + LENGTH * math.cos(angle), foot[1] + LENGTH * math.sin(angle)


def pin(name: str, a: str, b: str, point: tuple[float, float]) -> Revolute:
    """Return a hinge of two bodies at a point (m)."""
    return Revolute(name=name, body_a=a, body_b=b, point=point)


def rod_chain(name: str, angles: tuple[float, ...], masses: tuple[float, ...], gravity: float = GRAVITY) -> Scene:
    """Return rods hinged in a row, the first to the origin, at angles (rad) from the x axis, at rest."""
    feet = [(0.0, 0.0)]
    for angle in angles:
        feet.append(tip(feet[-1], angle))
    names = [GROUND, *(f"rod{k + 1}" for k in range(len(angles)))]
    bodies = tuple(rod(n, f, a, m) for n, f, a, m in zip(names[1:], feet, angles, masses, strict=False))
    joints = tuple(pin(f"hinge{k + 1}", names[k], names[k + 1], feet[k]) for k in range(len(angles)))
    return Scene(name=name, gravity=(0.0, -gravity), bodies=bodies, joints=joints)


def sled(name: str, force: float, mass: float = 1.0, signal: HalfSine | None = None, duration: float = 1.0) -> Scene:
    """Return a free body that is pushed along x by a force (N), times a signal; duration in s."""
    push = Force(name="push", body="sled", point=(0.0, 0.0), vector=(force, 0.0), factor=signal or Constant(value=1.0))
    return Scene(name=name, duration=duration, loads=(push,), bodies=(PlanarBody(name="sled", mass=mass, inertia=1.0),))


def hanging(theta: np.ndarray, reach: float = LENGTH) -> np.ndarray:
    """Return places (n_t, 1, 2), m, that hang `reach` (m) from the origin at angles (n_t,) from the lowest place."""
    return reach * np.stack([np.sin(theta), -np.cos(theta)], axis=-1)[:, None]


def swing(times: np.ndarray, rate: float, start: float) -> np.ndarray:
    """Return the angle (n_t,), rad, of a pendulum theta'' = -rate^2 sin(theta) that starts at rest at `start`.

    Angles are counted from the lowest place; `start` is in (0, pi).

    sin(theta/2) = k sn(K + rate t | k^2), k = sin(start/2) (Whittaker 1904, section 44).
    """
    k = np.sin(np.longdouble(start) / 2)
    phase = amplitude(quarter_period(k * k) + np.longdouble(rate) * times.astype(np.longdouble), k * k)
    return (2 * np.arcsin(k * np.sin(phase))).astype(float)


def half_sine_push(since: np.ndarray, duration: float, peak: float) -> np.ndarray:
    """Return the way (n_t,) m of a body at rest accelerated by peak sin(pi s / duration) (m/s^2) from s = 0 s on."""
    inside = np.clip(since, 0.0, duration)
    turn = math.pi / duration
    way = peak / turn * (inside - np.sin(turn * inside) / turn)
    return way + 2.0 * peak / turn * np.maximum(since - duration, 0.0)
