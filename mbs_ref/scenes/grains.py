"""Grains that fall into a box, in the plane and in space."""

import itertools
from collections.abc import Iterator
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from mbs_ref.scene import PlanarBody, Scene, SpatialBody, contact
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.bodies import block_inertia, sphere_inertia
from mbs_ref.scene.euler_parameters import from_axis_angle

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
