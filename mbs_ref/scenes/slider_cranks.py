"""Slider-cranks: one closed loop with a prismatic joint, in the plane and in space."""

import math

import numpy as np

from mbs_ref.scene import GROUND, PlanarBody, Prismatic, Revolute, Scene, SpatialBody, Spherical, Universal
from mbs_ref.scene.base.part import Positive, dot, unit
from mbs_ref.scene.euler_parameters import from_matrix


def slider_crank(
    *,
    crank_length: Positive = 0.5,
    rod_length: Positive = 1.2,
    crank_mass: Positive = 1.0,
    rod_mass: Positive = 1.5,
    slider_mass: Positive = 2.0,
    crank_angle: float = 0.7853981633974483,
    crank_speed: float = 6.0,
    gravity: Positive = 9.81,
) -> Scene:
    """Turn a crank that drives a slider through a rod, started with a given crank speed.

    crank_length, rod_length (m; the rod is the longer), masses (kg), crank_angle (rad), crank_speed
    (rad/s), gravity (m/s^2). ValueError where the rod does not let the crank turn round.
    """
    if rod_length <= crank_length:
        raise ValueError(f"slider_crank: rod_length = {rod_length} must exceed crank_length = {crank_length}")
    crank, rod, slider = crank_rod_slider(
        crank_length, rod_length, crank_mass, rod_mass, slider_mass, crank_angle, crank_speed
    )
    pin = (crank_length * math.cos(crank_angle), crank_length * math.sin(crank_angle))
    return Scene(
        name="slider_crank",
        description="A uniform crank and connecting rod move a block along the x axis; free motion under gravity.",
        source="Textbook mechanism; Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), ch. 5",
        duration=2.0,
        gravity=(0.0, -gravity),
        bodies=(crank, rod, slider),
        joints=(
            Revolute(name="main_bearing", body_a=GROUND, body_b="crank", point=(0.0, 0.0)),
            Revolute(name="crank_pin", body_a="crank", body_b="rod", point=pin),
            Revolute(name="wrist_pin", body_a="rod", body_b="slider", point=slider.position),
            Prismatic(name="guide", body_a=GROUND, body_b="slider", point=slider.position, axis=(1.0, 0.0)),
        ),
    )


def crank_rod_slider(r, length, m_crank, m_rod, m_slider, phi, phi_dot):
    """Consistent positions and velocities from the crank angle: r sin(phi) + l sin(psi) = 0."""
    psi = -math.asin(r * math.sin(phi) / length)
    psi_dot = -r * math.cos(phi) * phi_dot / (length * math.cos(psi))
    pin, pin_dot = _along(r, phi, phi_dot)
    half, half_dot = _along(0.5 * length, psi, psi_dot)
    crank = PlanarBody(
        name="crank", mass=m_crank, inertia=m_crank * r**2 / 12.0, position=(0.5 * pin[0], 0.5 * pin[1]), angle=phi,
        velocity=(0.5 * pin_dot[0], 0.5 * pin_dot[1]), angular_velocity=phi_dot,
    )  # fmt: skip
    rod = PlanarBody(
        name="rod", mass=m_rod, inertia=m_rod * length**2 / 12.0,
        position=(pin[0] + half[0], pin[1] + half[1]), angle=psi,
        velocity=(pin_dot[0] + half_dot[0], pin_dot[1] + half_dot[1]), angular_velocity=psi_dot,
    )  # fmt: skip
    slider = PlanarBody(
        name="slider", mass=m_slider, inertia=0.01 * m_slider,  # it never turns: any inertia does
        position=(pin[0] + 2.0 * half[0], 0.0), velocity=(pin_dot[0] + 2.0 * half_dot[0], 0.0),
    )  # fmt: skip
    return crank, rod, slider


def _along(length: float, angle: float, rate: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """The end of a vector of fixed length, and its velocity."""
    c, s = math.cos(angle), math.sin(angle)
    return (length * c, length * s), (-length * s * rate, length * c * rate)


PIVOT = np.array([0.0, 0.1, 0.12])  # m, Haug's mechanism: the crank's bearing, its axis along x


def spatial_slider_crank(
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
    speed = float(dot(gap, pin_rate)) / reach  # d|gap|^2/dt = 0
    gap_rate = np.array([speed, 0.0, 0.0]) - pin_rate
    along = gap / rod_length
    # the universal joint: the first axis in the rod, the second, across it, in the slider
    first = unit(np.cross(along, [1.0, 0.0, 0.0]))
    second = unit(np.cross([1.0, 0.0, 0.0], first))
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
                orientation=tuple(from_matrix(np.column_stack((along, first, np.cross(along, first)))).tolist()),
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
    across = np.cross(gap, gap_rate) / dot(gap, gap)
    return across - gap * float(dot(axis, across)) / float(dot(axis, gap))


def _tuple(vector: np.ndarray) -> tuple[float, float, float]:
    x, y, z = vector.tolist()
    return x, y, z
