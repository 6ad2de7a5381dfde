"""A small planar tracked vehicle: the papers' third system, with a track of any length.

The ground under a tracked vehicle: flat, and what stands on it, as shapes that touch a link's round feet.

Every shape's contact is continuous: a bump is the top of a buried circle, a slope a second half-plane, a step a
surface with a solid end. So they may touch one foot at once, as ground and kerb do.
"""

import math
from collections.abc import Iterator
from functools import cache
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from mbs_ref.scene import GROUND, Load, PlanarBody, PointBushing, Revolute, Scene, Torque, TorsionSpring
from mbs_ref.scene.base.part import BELIEVABLE_ONLY, NonNegative, Positive, of_paper
from mbs_ref.scene.contact import BekkerLaw, CircleOnCircle, CircleOnLine, Contact, PinOnSprocket
from mbs_ref.scene.signals import Table
from mbs_ref.scenes.tracked_vehicle import running_gear as gear
from mbs_ref.scenes.tracked_vehicle.running_gear import DATA, HEIGHT, contact_law, friction

Kind = Literal["flat", "bump", "slope", "step"]
RADIUS = 0.5 * HEIGHT  # m, of a foot
AHEAD = 0.5  # m, between the front of the track at t = 0 and the obstacle
FAR = 1e3  # m, length of a step's top
BUMP_HALF_WIDTH = 0.3  # m, where its circle leaves the ground
SLOPE_RUN = 1.0  # m, in which a slope gains its height


def foot(
    name: str, link: str, center: tuple[float, float], law: str, soil: str, ground: Kind, height: float, front: float
):
    """Yield the contacts of one foot with the ground: flat, and the obstacle of `height` m beyond `front` (m)."""
    rub = friction(DATA["contact"]["link_ground"]["mu"])
    press = contact_law("link_ground", law) if soil == "hard" else _sinking(soil)
    body = {"body_a": link, "law": press, "friction": rub}
    yield CircleOnLine(
        name=name, center=center, radius=RADIUS, body_b=GROUND, point_1=(0.0, 0.0), point_2=(1.0, 0.0), **body
    )
    if ground != "flat":
        yield _obstacle(f"{name}.{ground}", center, ground, height, front + AHEAD, body)


def _sinking(soil: str) -> BekkerLaw:
    """Return the law of half a link's sole on a soil."""
    own, sole = DATA["soils"][soil], DATA["soils"]["sole"]
    return BekkerLaw(
        cohesive=own["k_c"], frictional=own["k_phi"], exponent=own["n"], width=sole["width"], length=sole["length"],
        damping=sole["c_progressive"],
    )  # fmt: skip


def _obstacle(name: str, center: tuple[float, float], ground: Kind, height: float, start: float, body: dict) -> Contact:
    if ground == "bump":
        radius = (BUMP_HALF_WIDTH**2 + height**2) / (2.0 * height)
        below = (start + BUMP_HALF_WIDTH, height - radius)
        return CircleOnCircle(
            name=name, center_a=center, radius_a=RADIUS, body_b=GROUND, center_b=below, radius_b=radius, **body
        )
    ends = ((start, height), (start + FAR, height)) if ground == "step" else ((start, 0.0), (start + SLOPE_RUN, height))
    extent = "capped" if ground == "step" else "line"
    return CircleOnLine(
        name=name, center=center, radius=RADIUS, body_b=GROUND, point_1=ends[0], point_2=ends[1], extent=extent, **body
    )


FEET = (-0.25, 0.25)  # of the pitch: where a link's two round feet are
SLIDING = " Without friction at idler and rollers nothing turns them: the track slides under them."

BELIEVABLE: dict[str, Any] = {"wheel_friction": 0.4, "preload": 10_000.0, "start": "equilibrium"}
PAPER: dict[str, Any] = {"wheel_friction": 0.0, "preload": 0.0, "start": "drawn"}


def tracked_vehicle(
    *,
    model: Literal["believable", "paper"] = "believable",
    links: Annotated[int, Field(ge=20, le=2000, multiple_of=2)] = 30,
    rollers: Annotated[int, Field(ge=0, le=100)] = 3,
    upper_rollers: Annotated[int, Field(ge=0, le=100)] = 0,
    law: Literal["progressive", "spring_damper", "constraint"] = "progressive",
    torque: NonNegative = 2000.0,
    ramp: Positive = 0.5,
    gravity: Positive = 9.81,
    wheel_friction: Annotated[NonNegative, BELIEVABLE_ONLY] = BELIEVABLE["wheel_friction"],
    preload: Annotated[NonNegative, BELIEVABLE_ONLY] = BELIEVABLE["preload"],
    start: Annotated[Literal["equilibrium", "drawn"], BELIEVABLE_ONLY] = BELIEVABLE["start"],
    suspension: bool = False,
    pins: Literal["hinge", "rubber"] = "hinge",
    rolling: NonNegative = 0.0,
    soil: Literal["hard", "dry_sand", "sandy_loam", "clay"] = "hard",
    ground: Literal["flat", "bump", "slope", "step"] = "flat",
    height: Annotated[float, Field(gt=0.0, le=0.3)] = 0.02,
) -> Scene:
    """Drive a tracked vehicle by a torque ramp on its sprocket; a torque of 0 leaves it at rest.

    model: "paper" is the papers' bare one, without friction at the wheels, without preload, and started as it is drawn,
    where nothing is in equilibrium; it refuses these three parameters. links (even; 30 is the small vehicle, 42
    with 7 rollers and 1 upper roller has the 54 bodies of the papers' kind), rollers below and above, contact law,
    torque (N m) between chassis and sprocket reached at the end of ramp (s), gravity (m/s^2). With law = "constraint"
    idler and rollers are held on the links while they touch; feet, which need friction, and teeth keep the progressive
    law. wheel_friction, Coulomb's coefficient of idler and rollers on the links, which turns them. preload (N) of the
    spring that pushes the idler ahead on its slide where the vehicle is drawn; 0 fixes its axle. start: in the static
    equilibrium without torque (up to 250 bodies), or as drawn. suspension: rollers on trailing arms with torsion bars.
    pins: hinges, or rubber bushings, which pull the links straight. rolling: coefficient of the wheels' rolling
    resistance on the links, which needs wheel_friction.
    soil: hard, or one into which feet sink by Bekker's pressure-sinkage law, without a rut behind them.
    ground: flat, or half a metre ahead of the track a bump, a slope or a step of `height` (m; a slope's over 1 m of
    way; a step no higher than half a link).
    """
    if model == "paper":
        given = {"wheel_friction": wheel_friction, "preload": preload, "start": start}
        wheel_friction, preload, start = of_paper(PAPER, given, BELIEVABLE).values()
    if ground == "step" and height > 0.5 * gear.HEIGHT:
        raise ValueError(f"height = {height} m of a step must not exceed half a link, {0.5 * gear.HEIGHT} m")
    if law == "constraint" and wheel_friction:
        raise ValueError(
            f"wheel_friction = {wheel_friction} must be 0 with law = 'constraint', which has no friction; "
            "give model = 'paper'"
        )
    if rolling and not wheel_friction:
        raise ValueError(f"rolling = {rolling} requires wheel_friction > 0")
    drawn = _drawn(
        links, rollers, upper_rollers, law, gravity, (wheel_friction, rolling), preload, suspension, pins, soil, ground,
        height,
    )  # fmt: skip
    placed = _settled(drawn.model_dump_json()) if start == "equilibrium" else drawn
    return placed.model_copy(update={"loads": (*_drive(torque, ramp), *placed.loads)})


@cache
def _settled(drawn: str) -> Scene:
    """Return the scene that is drawn, in JSON, at rest in equilibrium."""
    from mbs_ref.simulate.equilibrium import at_equilibrium  # compiled code, which few who list scenes need

    return at_equilibrium(Scene.model_validate_json(drawn))


def _drawn(links, rollers, upper_rollers, law, gravity, rub, preload, suspension, pins, soil, ground, height) -> Scene:
    """Return the vehicle without its torque: chain straight and tangent, every contact at depth 0."""
    track = _pins(links)
    base = (links - gear.TEETH) // 2 * gear.PITCH
    wheels = gear.wheels_of(base, rollers, upper_rollers, suspension, preload > 0.0)
    hull = _chassis(base)
    front = base + gear.PITCH_RADIUS
    return Scene(
        name="tracked_vehicle",
        description=_description(links, rollers + upper_rollers, rub, suspension, pins, ground, height),
        source="Fox 2001, tracked off-highway vehicle; numbers and their origin in scenes/data/tracked_vehicle.json",
        duration=2.0,
        gravity=(0.0, -gravity),
        bodies=(hull, *gear.gear_bodies(wheels), *_links(track)),
        joints=(*gear.gear_joints(wheels), *(_chain(track) if pins == "hinge" else ())),
        loads=(
            *gear.torsion_bars(wheels, hull.mass * gravity),
            *gear.tensioners(wheels, preload),
            *(_rubber(track) if pins == "rubber" else ()),
        ),
        contacts=(
            *(part for k in range(links) for part in _link_contacts(k, track, wheels, law, rub)),
            *_ground_contacts(track, law, soil, ground, height, front),
        ),
    )


def _description(links: int, rollers: int, rub: tuple, suspension: bool, pins: str, ground: str, height: float) -> str:
    arms = ", on trailing arms with torsion bars," if suspension else ""
    where = "flat ground" if ground == "flat" else f"ground with a {ground} of {height:g} m"
    joined = " with rubber pins" if pins == "rubber" else ""
    more = (f" Rolling resistance is {rub[1]:g} of a wheel's load." if rub[1] else "") if rub[0] else SLIDING
    return f"Chassis, sprocket, idler, {rollers} rollers{arms} and {links} links{joined} on {where}.{more}"


def _pins(links: int) -> np.ndarray:
    """Return the pins (links, 2) counterclockwise from the top of the sprocket: the inside is on the left."""
    straight = (links - gear.TEETH) // 2
    base = straight * gear.PITCH
    half = gear.TEETH // 2
    around = 0.5 * math.pi + 2.0 * math.pi / gear.TEETH * np.arange(half + 1)
    left = gear.PITCH_RADIUS * np.column_stack((np.cos(around), np.sin(around)))
    inner = gear.PITCH * np.arange(1, straight)
    below = np.column_stack((inner, np.full(straight - 1, -gear.PITCH_RADIUS)))
    above = np.column_stack((base - inner, np.full(straight - 1, gear.PITCH_RADIUS)))
    pins = np.vstack((left, below, (base, 0.0) - left, above))
    return pins + np.array([0.0, gear.AXLE_HEIGHT])


def _chassis(base: float) -> PlanarBody:
    data = gear.DATA["chassis"]
    place = (0.5 * base, gear.AXLE_HEIGHT + data["axle_below_centre"])
    return PlanarBody(name="chassis", mass=data["mass"], inertia=data["inertia"], position=place)


def _links(pins: np.ndarray) -> list[PlanarBody]:
    ahead = np.roll(pins, -1, axis=0)
    along = ahead - pins
    return [
        PlanarBody(
            name=f"link{k}", mass=gear.DATA["link"]["mass"], inertia=gear.DATA["link"]["inertia"],
            position=tuple(0.5 * (a + b)), angle=math.atan2(d[1], d[0]),
        )
        for k, (a, b, d) in enumerate(zip(pins, ahead, along, strict=True))
    ]  # fmt: skip


def _chain(pins: np.ndarray) -> list[Revolute]:
    """Pin k joins link k - 1 to link k; the last one closes the track."""
    n = len(pins)
    return [
        Revolute(name=f"pin{k % n}", body_a=f"link{k - 1}", body_b=f"link{k % n}", point=tuple(pins[k % n]))
        for k in range(1, n + 1)
    ]


def _rubber(pins: np.ndarray) -> Iterator[Load]:
    """Yield what holds link k - 1 and link k together: a ring of rubber, unstrained where both are in a line."""
    data, n, along = gear.DATA["pin_rubber"], len(pins), np.roll(pins, -1, axis=0) - pins
    angles = np.arctan2(along[:, 1], along[:, 0])
    for k in range(1, n + 1):
        ends: dict[str, Any] = {"body_a": f"link{k - 1}", "body_b": f"link{k % n}"}
        turns = float(2.0 * math.pi * np.round((angles[k % n] - angles[k - 1]) / (2.0 * math.pi)))
        yield PointBushing(name=f"pin{k % n}", point=tuple(pins[k % n]), **data["radial"], **ends)
        yield TorsionSpring(name=f"pin{k % n}.turn", rest_angle=turns, **data["torsion"], **ends)


def _drive(torque: float, ramp: float) -> tuple[Torque, ...]:
    """Clockwise on the sprocket: the vehicle drives along +x."""
    if torque == 0.0:
        return ()
    signal = Table(times=(0.0, ramp), values=(0.0, 1.0))
    return (
        Torque(name="drive", body="sprocket", torque=-torque, factor=signal),
        Torque(name="drive.reaction", body="chassis", torque=torque, factor=signal),
    )


def _link_contacts(
    k: int, pins: np.ndarray, wheels: list[gear.Wheel], law: str, rub: tuple[float, float]
) -> Iterator[Contact]:
    """Yield what wheels and sprocket touch of link k."""
    a, b = pins[k], pins[(k + 1) % len(pins)]
    along = (b - a) / gear.PITCH
    inner = 0.5 * gear.HEIGHT * np.array([-along[1], along[0]])
    for wheel in wheels[1:]:
        yield CircleOnLine(
            name=f"{wheel.name}.link{k}", body_a=wheel.name, center=wheel.center, radius=wheel.radius,
            body_b=f"link{k}", point_1=tuple(a + inner), point_2=tuple(b + inner), extent="segment",
            thickness=0.5 * gear.HEIGHT, law=gear.contact_law("link_wheel", law),
            friction=gear.friction(*rub, wheel.radius),
        )  # fmt: skip
    yield _tooth(k, a, wheels[0].center, law)


def _ground_contacts(pins: np.ndarray, law: str, soil: str, ground, height: float, front: float) -> Iterator[Contact]:
    for k, (a, b) in enumerate(zip(pins, np.roll(pins, -1, axis=0), strict=True)):
        for side in (0, 1):
            center = tuple(0.5 * (a + b) + FEET[side] * (b - a))
            yield from foot(f"foot{k}.{side}", f"link{k}", center, law, soil, ground, height, front)


def _tooth(k: int, pin: np.ndarray, axle: tuple[float, float], law: str) -> PinOnSprocket:
    seat = gear.DATA["pin_seat"]
    return PinOnSprocket(
        name=f"tooth.pin{k}", body_a=f"link{k}", center=tuple(pin), body_b="sprocket", axle=axle, teeth=gear.TEETH,
        pitch_radius=gear.PITCH_RADIUS, addendum_radius=gear.DATA["sprocket"]["addendum_radius"],
        first_seat=0.5 * math.pi, clearance=seat["clearance"], flank_angle=math.radians(seat["flank_angle_deg"]),
        law=gear.contact_law("sprocket_pin", law),
    )  # fmt: skip
