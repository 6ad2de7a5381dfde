"""A small planar tracked vehicle: the papers' third system, with a track of any length."""

from __future__ import annotations

import json
import math
from importlib.resources import files
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from mbs_ref.scene import GROUND, PlanarBody, Revolute, Scene, Torque
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.contact import (
    CircleOnLine,
    Contact,
    ContactLaw,
    PinOnSprocket,
    ProgressiveLaw,
    RegularisedCoulomb,
    SpringDamperLaw,
)
from mbs_ref.scene.signals import Table

DATA: dict[str, Any] = json.loads((files("mbs_ref.scenes") / "data" / "tracked_vehicle.json").read_text())
PITCH, HEIGHT, TEETH = (DATA[name]["value"] for name in ("pitch", "link_height", "teeth"))
PITCH_RADIUS = PITCH / (2.0 * math.sin(math.pi / TEETH))  # m
APOTHEM = PITCH / (2.0 * math.tan(math.pi / TEETH))  # m
AXLE_HEIGHT = PITCH_RADIUS + 0.5 * HEIGHT  # m, of sprocket and idler above ground
ROLLER_RADIUS = DATA["roller"]["radius"]  # m
FEET = (-0.25, 0.25)  # of the pitch: where a link's two round feet are


def build(
    *,
    links: Annotated[int, Field(ge=20, le=2000, multiple_of=2)] = 30,
    rollers: Annotated[int, Field(ge=0, le=100)] = 3,
    upper_rollers: Annotated[int, Field(ge=0, le=100)] = 0,
    law: Literal["progressive", "spring_damper"] = "progressive",
    torque: NonNegative = 2000.0,
    ramp: Positive = 0.5,
    gravity: Positive = 9.81,
) -> Scene:
    """Drive a tracked vehicle on flat ground by a torque ramp on its sprocket; a torque of 0 leaves it at rest.

    links (even; 30 is the small vehicle, 42 with 7 rollers and 1 upper roller has the 54 bodies of the
    papers' kind), rollers below and above, contact law, torque (N m) between chassis and sprocket reached
    at the end of ramp (s), gravity (m/s^2).
    """
    track = _pins(links)
    wheels = _wheels((links - TEETH) // 2 * PITCH, rollers, upper_rollers)
    base = wheels["idler"][0][0]
    return Scene(
        name="tracked_vehicle",
        description=f"Chassis, sprocket, idler, {rollers + upper_rollers} rollers and {links} links on flat ground.",
        source="Fox 2001, tracked off-highway vehicle; numbers and their origin in scenes/data/tracked_vehicle.json",
        duration=2.0,
        gravity=(0.0, -gravity),
        bodies=(_chassis(base), *_wheel_bodies(wheels), *_links(track)),
        joints=(*_axles(wheels), *_chain(track)),
        loads=_drive(torque, ramp),
        contacts=tuple(_contacts(track, wheels, law)),
    )


def _pins(links: int) -> np.ndarray:
    """Return the pins (links, 2) counterclockwise from the top of the sprocket: the inside is on the left."""
    straight = (links - TEETH) // 2
    base = straight * PITCH
    half = TEETH // 2
    around = 0.5 * math.pi + 2.0 * math.pi / TEETH * np.arange(half + 1)
    left = PITCH_RADIUS * np.column_stack((np.cos(around), np.sin(around)))
    inner = PITCH * np.arange(1, straight)
    below = np.column_stack((inner, np.full(straight - 1, -PITCH_RADIUS)))
    above = np.column_stack((base - inner, np.full(straight - 1, PITCH_RADIUS)))
    pins = np.vstack((left, below, (base, 0.0) - left, above))
    return pins + np.array([0.0, AXLE_HEIGHT])


def _wheels(base: float, rollers: int, upper: int) -> dict[str, tuple[tuple[float, float], float]]:
    """Return centre and radius (m) of everything that turns on the chassis."""
    spread = base * np.arange(1, rollers + 1) / (rollers + 1)
    over = base * np.arange(1, upper + 1) / (upper + 1)
    wheels = {"sprocket": ((0.0, AXLE_HEIGHT), PITCH_RADIUS), "idler": ((base, AXLE_HEIGHT), APOTHEM - 0.5 * HEIGHT)}
    wheels |= {f"roller{k + 1}": ((float(x), HEIGHT + ROLLER_RADIUS), ROLLER_RADIUS) for k, x in enumerate(spread)}
    top = AXLE_HEIGHT + PITCH_RADIUS - 0.5 * HEIGHT
    small = 0.5 * ROLLER_RADIUS
    return wheels | {f"upper{k + 1}": ((float(x), top - small), small) for k, x in enumerate(over)}


def _chassis(base: float) -> PlanarBody:
    data = DATA["chassis"]
    place = (0.5 * base, AXLE_HEIGHT + data["axle_below_centre"])
    return PlanarBody(name="chassis", mass=data["mass"], inertia=data["inertia"], position=place)


def _wheel_bodies(wheels: dict) -> list[PlanarBody]:
    kinds = [name if name in ("sprocket", "idler") else "roller" for name in wheels]
    return [
        PlanarBody(name=name, mass=DATA[kind]["mass"], inertia=DATA[kind]["inertia"], position=center)
        for kind, (name, (center, _)) in zip(kinds, wheels.items(), strict=True)
    ]


def _links(pins: np.ndarray) -> list[PlanarBody]:
    ahead = np.roll(pins, -1, axis=0)
    along = ahead - pins
    return [
        PlanarBody(
            name=f"link{k}", mass=DATA["link"]["mass"], inertia=DATA["link"]["inertia"],
            position=tuple(0.5 * (a + b)), angle=math.atan2(d[1], d[0]),
        )
        for k, (a, b, d) in enumerate(zip(pins, ahead, along, strict=True))
    ]  # fmt: skip


def _axles(wheels: dict) -> list[Revolute]:
    return [Revolute(name=f"{name}.axle", body_a="chassis", body_b=name, point=c) for name, (c, _) in wheels.items()]


def _chain(pins: np.ndarray) -> list[Revolute]:
    """Pin k joins link k - 1 to link k; the last one closes the track."""
    n = len(pins)
    return [
        Revolute(name=f"pin{k % n}", body_a=f"link{k - 1}", body_b=f"link{k % n}", point=tuple(pins[k % n]))
        for k in range(1, n + 1)
    ]


def _drive(torque: float, ramp: float) -> tuple[Torque, ...]:
    """Clockwise on the sprocket: the vehicle drives along +x."""
    if torque == 0.0:
        return ()
    signal = Table(times=(0.0, ramp), values=(0.0, 1.0))
    return (
        Torque(name="drive", body="sprocket", torque=-torque, factor=signal),
        Torque(name="drive.reaction", body="chassis", torque=torque, factor=signal),
    )


def _law(kind: str, law: str) -> ContactLaw:
    data = DATA["contact"][kind]
    if law == "progressive":
        return ProgressiveLaw(stiffness=data["k"], damping=data["c_progressive"])
    return SpringDamperLaw(stiffness=data["k"], damping=data["c_kv"], release="force")


def _contacts(pins: np.ndarray, wheels: dict, law: str) -> list[Contact]:
    ahead = np.roll(pins, -1, axis=0)
    contacts: list[Contact] = []
    for k, (a, b) in enumerate(zip(pins, ahead, strict=True)):
        along = (b - a) / PITCH
        inner = 0.5 * HEIGHT * np.array([-along[1], along[0]])
        middle = 0.5 * (a + b)
        contacts += [_foot(k, side, middle + FEET[side] * PITCH * along, law) for side in (0, 1)]
        contacts += [
            CircleOnLine(
                name=f"{name}.link{k}", body_a=name, center=center, radius=radius, body_b=f"link{k}",
                point_1=tuple(a + inner), point_2=tuple(b + inner), extent="segment", thickness=0.5 * HEIGHT,
                law=_law("link_wheel", law),
            )
            for name, (center, radius) in wheels.items()
            if name != "sprocket"
        ]  # fmt: skip
        contacts.append(_tooth(k, a, wheels["sprocket"][0], law))
    return contacts


def _foot(k: int, side: int, center: np.ndarray, law: str) -> CircleOnLine:
    friction = RegularisedCoulomb(
        coefficient=DATA["contact"]["link_ground"]["mu"], speed=DATA["friction_creep"]["value"]
    )
    return CircleOnLine(
        name=f"foot{k}.{side}", body_a=f"link{k}", center=tuple(center), radius=0.5 * HEIGHT, body_b=GROUND,
        point_1=(0.0, 0.0), point_2=(1.0, 0.0), law=_law("link_ground", law), friction=friction,
    )  # fmt: skip


def _tooth(k: int, pin: np.ndarray, axle: tuple[float, float], law: str) -> PinOnSprocket:
    seat = DATA["pin_seat"]
    return PinOnSprocket(
        name=f"tooth.pin{k}", body_a=f"link{k}", center=tuple(pin), body_b="sprocket", axle=axle, teeth=TEETH,
        pitch_radius=PITCH_RADIUS, addendum_radius=DATA["sprocket"]["addendum_radius"], first_seat=0.5 * math.pi,
        clearance=seat["clearance"], flank_angle=math.radians(seat["flank_angle_deg"]), law=_law("sprocket_pin", law),
    )  # fmt: skip
