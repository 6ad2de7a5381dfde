"""What turns on the hull: sprocket, idler and rollers, on axles of the hull or on sprung trailing arms.

The numbers of the vehicle and their origin are in scenes/data/tracked_vehicle.json.
"""

import math
from dataclasses import dataclass

import numpy as np

from mbs_ref.scene import Joint, Load, PlanarBody, Prismatic, Revolute, SpringDamper, TorsionSpring, contact
from mbs_ref.scenes import read_data

DATA = read_data("tracked_vehicle")
PITCH, HEIGHT, TEETH = (DATA[name]["value"] for name in ("pitch", "link_height", "teeth"))
PITCH_RADIUS = PITCH / (2.0 * math.sin(math.pi / TEETH))  # m
APOTHEM = PITCH / (2.0 * math.tan(math.pi / TEETH))  # m
AXLE_HEIGHT = PITCH_RADIUS + 0.5 * HEIGHT  # m, of sprocket and idler above ground
ROLLER_RADIUS = DATA["roller"]["radius"]  # m
Point = tuple[float, float]
BAR, SLIDE = DATA["suspension"], DATA["tensioner"]


@dataclass(frozen=True)
class Wheel:
    """A wheel in the plane at t = 0."""

    name: str
    kind: str  # of the data: sprocket, idler, roller
    center: Point  # m
    radius: float  # m; of the sprocket the pitch radius
    is_sprung: bool = False
    slides: bool = False

    @property
    def carrier(self) -> str:
        """The body that its axle is on."""
        return f"{self.name}.arm" if self.is_sprung else f"{self.name}.slide" if self.slides else "chassis"

    @property
    def pivot(self) -> Point:
        """Where its arm hangs on the hull: ahead and above."""
        slope = math.radians(BAR["arm_slope_deg"])
        (x, y), length = self.center, BAR["arm_length"]
        return x + length * math.cos(slope), y + length * math.sin(slope)


def wheels_of(base: float, rollers: int, upper: int, suspension: bool, tensioned: bool) -> list[Wheel]:
    """Return everything that turns, for a wheel base (m)."""
    top, small = AXLE_HEIGHT + PITCH_RADIUS - 0.5 * HEIGHT, 0.5 * ROLLER_RADIUS
    ends = [
        Wheel("sprocket", "sprocket", (0.0, AXLE_HEIGHT), PITCH_RADIUS),
        Wheel("idler", "idler", (base, AXLE_HEIGHT), APOTHEM - 0.5 * HEIGHT, slides=tensioned),
    ]
    below = [
        Wheel(f"roller{k + 1}", "roller", (x, HEIGHT + ROLLER_RADIUS), ROLLER_RADIUS, suspension)
        for k, x in enumerate(_spread(base, rollers))
    ]
    above = [Wheel(f"upper{k + 1}", "roller", (x, top - small), small) for k, x in enumerate(_spread(base, upper))]
    return [*ends, *below, *above]


def _spread(base: float, count: int) -> list[float]:
    return [float(x) for x in base * np.arange(1, count + 1) / (count + 1)]


def gear_bodies(wheels: list[Wheel]) -> list[PlanarBody]:
    """Return wheels, arms and the idler's slide."""
    turning = [
        PlanarBody(name=w.name, mass=DATA[w.kind]["mass"], inertia=DATA[w.kind]["inertia"], position=w.center)
        for w in wheels
    ]
    arms = [
        PlanarBody(
            name=w.carrier, mass=BAR["arm_mass"], inertia=BAR["arm_inertia"],
            position=(0.5 * (w.center[0] + w.pivot[0]), 0.5 * (w.center[1] + w.pivot[1])),
        )
        for w in wheels if w.is_sprung
    ]  # fmt: skip
    slides = [
        PlanarBody(name=w.carrier, mass=SLIDE["mass"], inertia=SLIDE["inertia"], position=w.center)
        for w in wheels if w.slides
    ]  # fmt: skip
    return [*turning, *arms, *slides]


def gear_joints(wheels: list[Wheel]) -> list[Joint]:
    """Return the axles, the pivots of the arms, and the slide along which the idler tightens the track."""
    pivots = [
        Revolute(name=f"{w.carrier}.pivot", body_a="chassis", body_b=w.carrier, point=w.pivot)
        for w in wheels if w.is_sprung
    ]  # fmt: skip
    slides = [
        Prismatic(name=f"{w.carrier}.guide", body_a="chassis", body_b=w.carrier, point=w.center, axis=(1.0, 0.0))
        for w in wheels if w.slides
    ]  # fmt: skip
    axles = [Revolute(name=f"{w.name}.axle", body_a=w.carrier, body_b=w.name, point=w.center) for w in wheels]
    return [*pivots, *slides, *axles]


def tensioners(wheels: list[Wheel], preload: float) -> list[Load]:
    """Return the spring behind each sliding axle, which pushes with `preload` (N) where the vehicle is drawn."""
    return [
        SpringDamper(
            name=f"{w.name}.tensioner", body_a="chassis", body_b=w.carrier,
            point_a=(w.center[0] - SLIDE["length"], w.center[1]), point_b=w.center, stiffness=SLIDE["stiffness"],
            damping=SLIDE["damping"], rest_length=SLIDE["length"] + preload / SLIDE["stiffness"],
        )
        for w in wheels if w.slides
    ]  # fmt: skip


def torsion_bars(wheels: list[Wheel], weight: float) -> list[Load]:
    """Return the springs, each wound to bear its share of the hull's `weight` (N) as the arms stand at t = 0."""
    sprung = [w for w in wheels if w.is_sprung]
    wound = [weight / len(sprung) * (w.pivot[0] - w.center[0]) / BAR["stiffness"] for w in sprung]
    return [
        TorsionSpring(
            name=f"{w.name}.bar", body_a="chassis", body_b=w.carrier, stiffness=BAR["stiffness"],
            damping=BAR["damping"], rest_angle=angle,
        )
        for w, angle in zip(sprung, wound, strict=True)
    ]  # fmt: skip


def contact_law(kind: str, law: str) -> contact.ContactLaw:
    """Return the law of link_wheel, link_ground or sprocket_pin: the first alone may be a constraint."""
    data = DATA["contact"][kind]
    if law == "constraint" and kind == "link_wheel":
        return contact.ConstraintLaw()
    if law != "spring_damper":
        return contact.ProgressiveLaw(stiffness=data["k"], damping=data["c_progressive"])
    return contact.SpringDamperLaw(stiffness=data["k"], damping=data["c_kv"], release="force")


def friction(coefficient: float, rolling: float = 0.0, radius: float = 0.0) -> contact.Smooth | None:
    """Return friction that creeps where it would stick, of a wheel that may resist rolling; None without any."""
    law = {"coefficient": coefficient, "speed": DATA["friction_creep"]["value"]}
    if rolling:
        return contact.RollingFriction(lever=rolling * radius, rate=law["speed"] / radius, **law)
    return contact.RegularisedCoulomb(**law) if coefficient else None
