"""The spatial slider-crank: a loop of a revolute, a spherical, a universal and a prismatic joint."""

# Vectors are built as tuples of floats whose length the checker cannot see.
# pyright: reportArgumentType=false

from __future__ import annotations

import math

import numpy as np

from mbs_ref.scene import GROUND, Prismatic, Revolute, Scene, SpatialBody, Spherical, Universal
from mbs_ref.scene.base.part import Positive
from mbs_ref.scene.euler_parameters import from_matrix

PIVOT = np.array([0.0, 0.1, 0.12])  # m, Haug's mechanism: the crank's bearing, its axis along x


def build(
    *, crank_length: Positive = 0.08, rod_length: Positive = 0.3, crank_speed: float = 6.0, gravity: Positive = 9.81
) -> Scene:
    """Turn a crank in the y-z plane that drives a slider along x through a rod.

    crank_length, rod_length (m), crank_speed (rad/s at the start), gravity (m/s^2). ValueError where the rod
    does not reach.
    """
    pin = PIVOT + np.array([0.0, 0.0, crank_length])  # upright
    across = math.hypot(pin[1], pin[2])
    least = math.hypot(PIVOT[1], PIVOT[2]) + crank_length  # of the pin from the slider's line, at its furthest
    if rod_length <= least:
        raise ValueError(f"spatial_slider_crank: rod_length = {rod_length} must exceed {least:.4g} for a full turn")
    reach = math.sqrt(rod_length**2 - across**2)
    slide = np.array([reach, 0.0, 0.0])
    pin_rate = np.cross([crank_speed, 0.0, 0.0], pin - PIVOT)
    gap = slide - pin
    speed = float(gap @ pin_rate) / reach  # d|gap|^2/dt = 0
    gap_rate = np.array([speed, 0.0, 0.0]) - pin_rate
    along = gap / rod_length
    # the universal joint: the first axis in the rod, the second, across it, in the slider
    first = _unit(np.cross(along, [1.0, 0.0, 0.0]))
    second = _unit(np.cross([1.0, 0.0, 0.0], first))
    rod_turn = _rod_rate(gap, gap_rate, first, second)
    return Scene(
        name="spatial_slider_crank",
        description="Crank, connecting rod and slider with crossed axes; free motion under gravity.",
        source="Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), sec. 10.2 and 12.2",
        duration=2.0,
        gravity=(0.0, 0.0, -gravity),
        bodies=(
            SpatialBody(
                name="crank", mass=0.12, inertia=(1e-4, 1e-4, 1e-5, 0.0, 0.0, 0.0),
                position=_tuple(0.5 * (PIVOT + pin)), velocity=_tuple(0.5 * pin_rate),
                angular_velocity=(crank_speed, 0.0, 0.0),
            ),
            SpatialBody(
                name="rod", mass=0.5, inertia=(4e-5, 4e-3, 4e-3, 0.0, 0.0, 0.0), position=_tuple(0.5 * (pin + slide)),
                orientation=_tuple(from_matrix(np.column_stack((along, first, np.cross(along, first))))),
                velocity=_tuple(0.5 * (pin_rate + np.array([speed, 0.0, 0.0]))), angular_velocity=_tuple(rod_turn),
            ),
            SpatialBody(
                name="slider", mass=2.0, inertia=(1e-4, 1e-4, 1e-4, 0.0, 0.0, 0.0),
                position=_tuple(slide), velocity=(speed, 0.0, 0.0),
            ),
        ),
        joints=(
            Revolute(name="bearing", body_a=GROUND, body_b="crank", point=_tuple(PIVOT), axis=(1.0, 0.0, 0.0)),
            Spherical(name="crank_pin", body_a="crank", body_b="rod", point=_tuple(pin)),
            Universal(
                name="wrist", body_a="slider", body_b="rod", point=_tuple(slide),
                axis_a=_tuple(second), axis_b=_tuple(first),
            ),
            Prismatic(name="guide", body_a=GROUND, body_b="slider", point=_tuple(slide), axis=(1.0, 0.0, 0.0)),
        ),
    )  # fmt: skip


def _rod_rate(gap: np.ndarray, gap_rate: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Angular velocity of the rod: omega x gap = gap_rate, and omega has no part along first x second."""
    axis = np.cross(first, second)
    across = np.cross(gap, gap_rate) / (gap @ gap)
    return across - gap * float(axis @ across) / float(axis @ gap)


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector)


def _tuple(vector: np.ndarray) -> tuple[float, ...]:
    return tuple(float(x) for x in vector)
