"""Bodies in contact under gravity: stacks in the plane and in space, and grains that fall into a box."""

import itertools
from collections.abc import Iterator
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from mbs_ref.scene import GROUND, PlanarBody, Scene, SpatialBody, contact
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.bodies import block_inertia, sphere_inertia
from mbs_ref.scene.euler_parameters import from_axis_angle

BOX_WIDTH, BOX_HEIGHT = 0.4, 0.2  # m


def box_stack(
    *,
    boxes: Annotated[int, Field(ge=1, le=200)] = 3,
    mass: Positive = 1.0,
    ratio: Positive = 1.0,
    stiffness: Positive = 1e6,
    damping: NonNegative = 1000.0,
    gravity: Positive = 9.81,
) -> Scene:
    """Stack boxes, each `ratio` times as heavy as the one below; they sink by their weight over the stiffness.

    boxes, mass of the lowest (kg), ratio (1e4 with 2 boxes is heavy on light), contact stiffness (N/m) and
    damping (N s/m) of each of the two corners, gravity (m/s^2). They start just touching.
    """
    law = contact.SpringDamperLaw(stiffness=stiffness, damping=damping, release="force")
    masses = [mass * ratio**k for k in range(boxes)]
    _refuse_stack("box_stack", masses, BOX_HEIGHT, 2.0 * stiffness, gravity)
    return Scene(
        name="box_stack",
        description=f"{boxes} boxes stacked without friction, each {ratio:g} times as heavy as the one below.",
        source="Textbook statics",
        duration=1.0,
        gravity=(0.0, -gravity),
        bodies=tuple(
            PlanarBody(
                name=f"box{k}", mass=m, inertia=m * (BOX_WIDTH**2 + BOX_HEIGHT**2) / 12.0,
                position=(0.0, (k + 0.5) * BOX_HEIGHT)
            )
            for k, m in enumerate(masses)
        ),
        contacts=tuple(_box_corner(k, side, law) for k in range(boxes) for side in (0, 1)),
    )  # fmt: skip


def _refuse_stack(name: str, masses: list[float], height: float, stiffness: float, gravity: float) -> None:
    """Refuse a weight that the lowest body cannot carry, and a body whose weight is lost in rounding of positions."""
    sinks = 2.0 * sum(masses) * gravity / stiffness  # m, without damping twice as far as at rest
    if sinks >= height:
        raise ValueError(
            f"{name}: the lowest body would sink by {sinks:.3g} m, its height is {height:g} m: reduce the weight"
        )
    rounding = stiffness * np.finfo(float).eps * height * len(masses)  # N
    if min(masses) * gravity <= rounding:
        raise ValueError(
            f"{name}: the lightest body weighs {min(masses) * gravity:.3g} N, which rounding of contact forces "
            f"({rounding:.3g} N) exceeds: it must be heavier, or the contacts softer"
        )


def _box_corner(k: int, side: int, law: contact.SpringDamperLaw) -> contact.CircleOnLine:
    return contact.CircleOnLine(
        name=f"corner{k}.{side}", body_a=f"box{k}", center=((side - 0.5) * BOX_WIDTH, k * BOX_HEIGHT), radius=0.0,
        body_b=GROUND if k == 0 else f"box{k - 1}",
        point_1=(-BOX_WIDTH, k * BOX_HEIGHT), point_2=(BOX_WIDTH, k * BOX_HEIGHT),
        extent="line" if k == 0 else "segment", law=law,
    )  # fmt: skip


LENGTH, WIDTH, HEIGHT = 0.4, 0.3, 0.2  # m


def block_stack(
    *,
    blocks: Annotated[int, Field(ge=1, le=50)] = 3,
    mass: Positive = 1.0,
    ratio: Positive = 1.0,
    stiffness: Positive = 1e6,
    damping: NonNegative = 1000.0,
    gravity: Positive = 9.81,
) -> Scene:
    """Stack blocks, each `ratio` times as heavy as the one below; they sink by their weight over the stiffness.

    blocks, mass of the lowest (kg), ratio (1e4 with 2 blocks is heavy on light), contact stiffness (N/m) and
    damping (N s/m) of each of the four corners, gravity (m/s^2). They start just touching.
    """
    law = contact.SpringDamperLaw(stiffness=stiffness, damping=damping, release="force")
    masses = [mass * ratio**k for k in range(blocks)]
    _refuse_stack("block_stack", masses, HEIGHT, 4.0 * stiffness, gravity)
    return Scene(
        name="block_stack",
        description=f"{blocks} blocks stacked without friction, each {ratio:g} times as heavy as the one below.",
        source="Textbook statics",
        duration=1.0,
        gravity=(0.0, 0.0, -gravity),
        bodies=tuple(_block(k, m) for k, m in enumerate(masses)),
        contacts=tuple(
            _block_corner(k, x, y, law) for k in range(blocks) for x, y in itertools.product((-1, 1), (-1, 1))
        ),
    )  # fmt: skip


def _block(k: int, mass: float) -> SpatialBody:
    inertia = block_inertia(mass, LENGTH, WIDTH, HEIGHT)
    return SpatialBody(name=f"block{k}", mass=mass, inertia=inertia, position=(0.0, 0.0, (k + 0.5) * HEIGHT))


def _block_corner(k: int, x: int, y: int, law: contact.SpringDamperLaw) -> contact.SphereOnPlane:
    on_block = {"extent": "rectangle", "size": (2 * LENGTH, 2 * WIDTH), "edge": (1.0, 0.0, 0.0), "thickness": HEIGHT}
    return contact.SphereOnPlane(
        name=f"corner{k}.{(x + 1) // 2}{(y + 1) // 2}", body_a=f"block{k}", radius=0.0,
        center=(0.5 * x * LENGTH, 0.5 * y * WIDTH, k * HEIGHT), body_b=GROUND if k == 0 else f"block{k - 1}",
        point=(0.0, 0.0, k * HEIGHT), normal=(0.0, 0.0, 1.0), law=law, **({} if k == 0 else on_block),
    )  # fmt: skip


MOST_PAIRED = 300  # grains whose pairs may be parts of the scene: 45 000
GRAIN_RADIUS = 0.05  # m
SPACING = 2.2 * GRAIN_RADIUS  # m
STAGGER = 0.3 * GRAIN_RADIUS  # m, layers are shifted by up to this: a regular lattice is a coincidence
CLEARANCE = 0.5 * GRAIN_RADIUS  # m, to walls and floor at t = 0
ROUNDING = 0.4 * GRAIN_RADIUS  # m, radius of the edges of shapes that are not round ...
CORES = {"round": (0.0,) * 3, "capsule": (0.0, 0.0, 0.03), "box": (0.018, 0.0165, 0.015)}  # m ... within a round grain
AXIS, TURN = (1.0, 2.0, 3.0), 0.7  # by which grain k + 1 is turned from grain k, rad


def granular_column(
    *,
    grains: Annotated[int, Field(ge=2, le=100_000)] = 20,
    across: Annotated[int, Field(ge=1, le=50)] = 4,
    space: bool = False,
    stiffness: Positive = 1e5,
    damping: NonNegative = 1e5,
    mass: Positive = 0.1,
    friction: NonNegative = 0.0,
    slip: Positive = 1e-2,
    search: bool = False,
    shape: Literal["round", "capsule", "box"] = "round",
    gravity: Positive = 9.81,
) -> Scene:
    """Drop grains into a box: discs, or with `space` spheres.

    grains, how many across, whether in space; stiffness (N/m) and damping (N s/m^2) of the progressive law, mass
    of a grain (kg), coefficient of friction and the speed (m/s) at which it is reached, whether a neighbour search
    finds the pairs (up to 300 grains they may be parts of the scene), the shape of grains (capsules and boxes with
    rounded edges need the search and space), gravity (m/s^2).
    """
    if grains > MOST_PAIRED and not search:
        raise ValueError(f"grains = {grains}: more than {MOST_PAIRED} need search = true")
    if shape != "round" and not (search and space):
        raise ValueError(f"shape = {shape!r} needs search = true and space = true")
    law = contact.ProgressiveLaw(stiffness=stiffness, damping=damping)
    rubbing = contact.RegularisedCoulomb(coefficient=friction, speed=slip) if friction else None
    dimension = 3 if space else 2
    centers = [_grain_place(k, across, dimension) for k in range(grains)]
    bodies, walls = _grains(centers, mass, dimension, shape), _walls(across * SPACING + CLEARANCE, dimension)
    touch: dict[str, Any] = {"law": law, "friction": rubbing}
    size = {"radius": (ROUNDING,), "half": (CORES[shape],)} if shape != "round" else {"radius": (GRAIN_RADIUS,)}
    group = contact.Granules(name="grains", **size, walls=walls, **touch)
    return Scene(
        name="granular_column",
        description=f"{grains} grains fall into a box.",
        source="Cundall and Strack, Geotechnique 29 (1979) 47",
        duration=0.5,
        gravity=tuple([0.0] * (dimension - 1) + [-gravity]),
        bodies=tuple(bodies),
        loads=(group,) if search else (),
        contacts=() if search else (*_on_walls(centers, walls, touch), *_pairs(centers, touch)),
    )


def _grain_place(k: int, across: int, dimension: int) -> tuple[float, ...]:
    """Return the centre of grain k at t = 0, the last coordinate upwards."""
    layer, within = divmod(k, across ** (dimension - 1))
    cell = np.array([*reversed(np.unravel_index(within, (across,) * (dimension - 1))), layer], dtype=float)
    shift = STAGGER * np.sin(2.4 * layer + np.arange(dimension - 1))
    low = CLEARANCE + GRAIN_RADIUS + STAGGER
    return tuple((SPACING * cell + low + np.append(shift, -STAGGER)).tolist())


def _grains(centers: list, mass: float, dimension: int, shape: str) -> list[Any]:
    """Return discs or spheres, or bodies with the inertia of the block around their shape."""
    flat: dict[str, Any] = {"mass": mass, "inertia": 0.5 * mass * GRAIN_RADIUS**2}
    solid: dict[str, Any] = {"mass": mass, "inertia": sphere_inertia(mass, GRAIN_RADIUS)}
    body, own = (SpatialBody, solid) if dimension == 3 else (PlanarBody, flat)
    if shape == "round":
        return [body(name=f"g{k}", position=c, **own) for k, c in enumerate(centers)]
    own["inertia"] = block_inertia(mass, *(2.0 * (half + ROUNDING) for half in CORES[shape]))
    turns = [tuple(from_axis_angle(np.array(AXIS), TURN * k).tolist()) for k in range(len(centers))]
    return [SpatialBody(name=f"g{k}", position=c, orientation=turns[k], **own) for k, c in enumerate(centers)]


def _walls(width: float, dimension: int) -> tuple[contact.Wall, ...]:
    """Return the floor and the walls."""
    walls = []
    for axis, side in [(dimension - 1, 0), *itertools.product(range(dimension - 1), (0, 1))]:
        normal, point = np.zeros(dimension), np.zeros(dimension)
        normal[axis], point[axis] = 1.0 - 2.0 * side, side * (width + 2.0 * STAGGER)
        walls.append(contact.Wall(point=tuple(point), normal=tuple(normal)))
    return tuple(walls)


def _pairs(centers: list, touch: dict[str, Any]) -> Iterator[Any]:
    """Yield a contact for every pair of grains."""
    kind = contact.SphereOnSphere if len(centers[0]) == 3 else contact.CircleOnCircle
    for i, j in itertools.combinations(range(len(centers)), 2):
        ends = {"body_a": f"g{i}", "center_a": centers[i], "body_b": f"g{j}", "center_b": centers[j]}
        yield kind(name=f"g{i}.g{j}", **ends, radius_a=GRAIN_RADIUS, radius_b=GRAIN_RADIUS, **touch)


def _on_walls(centers: list, walls: tuple[contact.Wall, ...], touch: dict[str, Any]) -> Iterator[Any]:
    """Yield a contact for every grain and wall."""
    for (w, wall), (k, center) in itertools.product(enumerate(walls), enumerate(centers)):
        own: dict[str, Any] = {"name": f"wall{w}.g{k}", "body_a": f"g{k}", "center": center, "radius": GRAIN_RADIUS}
        if len(center) == 3:
            own |= {"point": wall.point, "normal": wall.normal}
            yield contact.SphereOnPlane(**own, **touch)
        else:
            along = np.array([wall.normal[1], -wall.normal[0]])  # the free side is on its left
            yield contact.CircleOnLine(**own, **touch, point_1=wall.point, point_2=tuple(wall.point + along))
