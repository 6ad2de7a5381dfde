"""Grains that fall into a box, in the plane and in space."""

import itertools
from collections.abc import Iterator
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from mbs_ref.scene import GROUND, PlanarBody, Scene, SpatialBody, contact
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.bodies import block_inertia, sphere_inertia
from mbs_ref.scene.euler_parameters import from_axis_angle

MOST_PAIRED = 300  # grains whose pairs may be parts of the scene: 45 000
GRAIN_RADIUS = 0.05  # m
SPACING = 2.2 * GRAIN_RADIUS  # m
STAGGER = 0.3 * GRAIN_RADIUS  # m, layers are shifted by up to this: a regular lattice is a coincidence
SHIFT = 0.08 * GRAIN_RADIUS  # m, at random, so that no grains touch
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
    ledge: Annotated[int, Field(ge=0, le=50)] = 0,
    seed: Annotated[int, Field(ge=0)] = 0,
    spread: Annotated[float, Field(ge=0.0, le=0.6)] = 0.0,
    gravity: Positive = 9.81,
) -> Scene:
    """Drop grains into a box: discs, or with `space` spheres.

    grains, how many across, whether in space; stiffness (N/m) and damping (N s/m^2) of the progressive law, mass
    of a grain (kg), coefficient of friction and the speed (m/s) at which it is reached, whether a neighbour search
    finds the pairs (up to 300 grains they may be parts of the scene), the shape of grains (capsules and boxes with
    rounded edges need the search and space), of how many fixed grains a ledge consists from which they fall (0: none,
    but a floor and two walls; else discs without the search), what shifts their start at random (0: nothing), by
    which share radii are smaller at random at most (of what is round), gravity (m/s^2).
    """
    if spread and shape != "round":
        raise ValueError(f"spread = {spread} needs shape = 'round'")
    if ledge and (search or space):
        raise ValueError(f"ledge = {ledge} needs search = false and space = false")
    if grains > MOST_PAIRED and not search:
        raise ValueError(f"grains = {grains}: more than {MOST_PAIRED} need search = true")
    if shape != "round" and not (search and space):
        raise ValueError(f"shape = {shape!r} needs search = true and space = true")
    law = contact.ProgressiveLaw(stiffness=stiffness, damping=damping)
    rubbing = contact.RegularisedCoulomb(coefficient=friction, speed=slip) if friction else None
    dimension = 3 if space else 2
    centers = [_grain_place(k, across, dimension) for k in range(grains)]
    random = np.random.default_rng(seed)
    if seed:
        shifts = random.uniform(-SHIFT, SHIFT, (grains, dimension))
        centers = [tuple(place) for place in (np.array(centers) + shifts).tolist()]
    radii = (GRAIN_RADIUS * (1.0 - spread * random.random(grains))).tolist()
    bodies, walls = _grains(centers, mass, dimension, shape), _walls(across * SPACING + CLEARANCE, dimension)
    touch: dict[str, Any] = {"law": law, "friction": rubbing}
    size: dict[str, Any] = {"radius": (ROUNDING,), "half": (CORES[shape],)}
    if shape == "round":
        size = {"radius": tuple(radii[: grains if spread else 1])}
    group = contact.Granules(name="grains", **size, walls=walls, **touch)
    grown = list(zip(centers, radii, strict=True))
    held = _on_ledge(grown, ledge, walls[1], touch) if ledge else _on_walls(grown, walls, touch)
    return Scene(
        name="granular_column",
        description=f"{grains} grains fall into a box.",
        source="Cundall and Strack, Geotechnique 29 (1979) 47",
        duration=2.0 if ledge else 0.5,  # s; a heap then rests
        gravity=tuple([0.0] * (dimension - 1) + [-gravity]),
        bodies=tuple(bodies),
        loads=(group,) if search else (),
        contacts=() if search else (*held, *_pairs(grown, touch)),
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
    kinds: dict[int, Any] = {2: (PlanarBody, 0.5 * mass * GRAIN_RADIUS**2),
                             3: (SpatialBody, sphere_inertia(mass, GRAIN_RADIUS))}  # fmt: skip
    body, inertia = kinds[dimension]
    turned = [{}] * len(centers)
    if shape != "round":
        inertia = block_inertia(mass, *(2.0 * (half + ROUNDING) for half in CORES[shape]))
        axis = np.array(AXIS)
        turned = [{"orientation": tuple(from_axis_angle(axis, TURN * k).tolist())} for k in range(len(centers))]
    return [body(name=f"g{k}", mass=mass, inertia=inertia, position=c, **turned[k]) for k, c in enumerate(centers)]


def _walls(width: float, dimension: int) -> tuple[contact.Wall, ...]:
    """Return the floor and the walls."""
    walls = []
    for axis, side in [(dimension - 1, 0), *itertools.product(range(dimension - 1), (0, 1))]:
        normal, point = np.zeros(dimension), np.zeros(dimension)
        normal[axis], point[axis] = 1.0 - 2.0 * side, side * (width + 2.0 * STAGGER)
        walls.append(contact.Wall(point=tuple(point), normal=tuple(normal)))
    return tuple(walls)


def _pairs(grown: list, touch: dict[str, Any]) -> Iterator[Any]:
    """Yield a contact for every pair of grains, each with a centre and a radius."""
    kind = contact.SphereOnSphere if len(grown[0][0]) == 3 else contact.CircleOnCircle
    for (i, (first, radius)), (j, (second, other)) in itertools.combinations(enumerate(grown), 2):
        ends = {"body_a": f"g{i}", "center_a": first, "body_b": f"g{j}", "center_b": second}
        yield kind(name=f"g{i}.g{j}", **ends, radius_a=radius, radius_b=other, **touch)


def _on_ledge(grown: list, ledge: int, wall: contact.Wall, touch: dict[str, Any]) -> Iterator[Any]:
    """Yield a contact for every grain with a wall and with each fixed grain, whose tops are at height 0."""
    yield from _on_walls(grown, (wall,), touch)
    for (k, (center, radius)), m in itertools.product(enumerate(grown), range(ledge)):
        ends = {"body_a": f"g{k}", "center_a": center, "radius_a": radius, "body_b": GROUND}
        place = ((2 * m + 1) * GRAIN_RADIUS, -GRAIN_RADIUS)
        yield contact.CircleOnCircle(name=f"ledge{m}.g{k}", **ends, center_b=place, radius_b=GRAIN_RADIUS, **touch)


def _on_walls(grown: list, walls: tuple[contact.Wall, ...], touch: dict[str, Any]) -> Iterator[Any]:
    """Yield a contact for every grain and wall."""
    for (w, wall), (k, (center, radius)) in itertools.product(enumerate(walls), enumerate(grown)):
        own: dict[str, Any] = {"name": f"wall{w}.g{k}", "body_a": f"g{k}", "center": center, "radius": radius}
        if len(center) == 3:
            own |= {"point": wall.point, "normal": wall.normal}
            yield contact.SphereOnPlane(**own, **touch)
        else:
            along = np.array([wall.normal[1], -wall.normal[0]])  # the free side is on its left
            yield contact.CircleOnLine(**own, **touch, point_1=wall.point, point_2=tuple(wall.point + along))
