"""The slider-crank: one closed loop with a prismatic joint."""

from __future__ import annotations

import math

from mbs_ref.scene import GROUND, PlanarBody, Prismatic, Revolute, Scene
from mbs_ref.scene.base.part import Positive


def build(
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
