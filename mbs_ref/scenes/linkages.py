"""Linkages that draw a straight line, driven at constant speed."""

import math
from typing import Any, Literal

import numpy as np

from mbs_ref.scene import GROUND, CoordinateDrive, PlanarBody, Revolute, Scene
from mbs_ref.scene.base.part import Positive, dot
from mbs_ref.scene.signals import Constant
from mbs_ref.scenes import read_data

SWING = 0.25  # rad, of the crank to both sides of its middle
LINKAGES: dict[str, dict[str, Any]] = read_data("linkages")["linkages"]


def straight_line_linkage(
    *, kind: Literal["peaucellier", "watt", "chebyshev"] = "peaucellier", speed: Positive = 0.8
) -> Scene:
    """Swing a straight-line linkage by its crank.

    kind: Peaucellier's, whose pin Q stays on a line, or Watt's or Chebyshev's, whose coupler's middle nearly does;
    speed of the crank (rad/s). Rods are uniform, of 1 kg/m.
    """
    data = LINKAGES[kind]
    start, end, _, middle = data["crank"]
    pins = pins_of(kind, middle - SWING)
    rates = {name: speed * np.imag(x) / 1e-30 for name, x in pins_of(kind, middle - SWING + 1e-30j).items()}
    drive = CoordinateDrive(
        name="drive", body="crank", coordinate="angle", motion=Constant(value=speed), level="velocity"
    )
    rods = {"crank": (start, end)} | {rod: tuple(rod) for rod in data["rods"]}
    ends: dict[str, list[str]] = {pin: [GROUND] if pin in data["fixed"] else [] for pin in pins}
    for rod, pair in rods.items():
        for pin in pair:
            ends[pin].append(rod)
    return Scene(
        name="straight_line_linkage",
        description=f"{kind.capitalize()}'s linkage of {len(rods)} rods, swung at constant speed.",
        source="Dijksman, Motion Geometry of Mechanisms, Cambridge 1976; proportions of Chebyshev's 1 : 2 : 2.5",
        duration=2.0 * SWING / speed,
        gravity=(0.0, -9.81),
        bodies=tuple(_rod(rod, *(pins[p] for p in pair), *(rates[p] for p in pair)) for rod, pair in rods.items()),
        joints=(
            *(
                Revolute(name=f"{pin}.{rod}", body_a=held[0], body_b=rod, point=tuple(pins[pin].tolist()))
                for pin, held in ends.items() for rod in held[1:]
            ),
            drive,
        ),
    )  # fmt: skip


def pins_of(kind: str, angle: Any) -> dict[str, np.ndarray]:
    """Return the place (2,), m, of every pin at an angle of the crank (rad), which may be complex."""
    data = LINKAGES[kind]
    pins: dict[str, Any] = {name: np.array(place) for name, place in data["fixed"].items()}
    start, end, length, _ = data["crank"]
    pins[end] = pins[start] + length * np.array([np.cos(angle), np.sin(angle)])
    for name, (one, other, near, far, side) in data["meet"].items():
        way = pins[other] - pins[one]
        square = dot(way, way)
        along = 0.5 * (near**2 - far**2 + square) / square
        pins[name] = pins[one] + along * way + side * np.sqrt(near**2 / square - along**2) * (way[::-1] * [-1.0, 1.0])
    return pins


def _rod(name: str, one: Any, other: Any, rate: Any, other_rate: Any) -> PlanarBody:
    way, turning = other - one, other_rate - rate
    square = float(dot(way, way))
    length = math.sqrt(square)
    return PlanarBody(
        name=name, mass=length, inertia=length * square / 12.0, position=tuple((0.5 * (one + other)).tolist()),
        angle=math.atan2(way[1], way[0]), velocity=tuple((0.5 * (rate + other_rate)).tolist()),
        angular_velocity=float(way[0] * turning[1] - way[1] * turning[0]) / square,
    )  # fmt: skip
