"""Grains fall into a box, every one against every other: what the broad phase is for."""

from __future__ import annotations

import itertools
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from mbs_ref.scene import PlanarBody, Scene, SpatialBody
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.contact import CircleOnCircle, CircleOnLine, Contact, ProgressiveLaw, SphereOnPlane, SphereOnSphere
from mbs_ref.scene.inertia import sphere

RADIUS = 0.05  # m
SPACING = 2.2 * RADIUS  # m
STAGGER = 0.3 * RADIUS  # m, layers are shifted by up to this: a regular lattice is a coincidence
CLEARANCE = 0.5 * RADIUS  # m, to walls and floor at t = 0


def build(
    *,
    grains: Annotated[int, Field(ge=2, le=300)] = 20,
    across: Annotated[int, Field(ge=1, le=50)] = 4,
    space: bool = False,
    stiffness: Positive = 1e5,
    damping: NonNegative = 1e5,
    mass: Positive = 0.1,
    gravity: Positive = 9.81,
) -> Scene:
    """Drop grains into a box: discs, or with `space` spheres, without friction.

    grains, how many across, whether in space; stiffness (N/m) and damping (N s/m^2) of the progressive law, mass
    of a grain (kg), gravity (m/s^2).
    """
    law = ProgressiveLaw(stiffness=stiffness, damping=damping)
    dimension = 3 if space else 2
    centers = [_place(k, across, dimension) for k in range(grains)]
    kind = _spheres if space else _discs
    bodies, pairs = kind(centers, mass, law)
    walls = list(_walls(len(centers), centers, across * SPACING + CLEARANCE, law, dimension))
    return Scene(
        name="granular_column",
        description=f"{grains} grains fall into a box; {len(pairs) + len(walls)} pairs may touch.",
        source="Cundall and Strack, Geotechnique 29 (1979) 47",
        duration=0.5,
        gravity=tuple([0.0] * (dimension - 1) + [-gravity]),
        bodies=tuple(bodies),
        contacts=(*walls, *pairs),
    )


def _place(k: int, across: int, dimension: int) -> tuple[float, ...]:
    """Return the centre of grain k at t = 0, the last coordinate upwards."""
    layer, within = divmod(k, across ** (dimension - 1))
    cell = np.array([*reversed(np.unravel_index(within, (across,) * (dimension - 1))), layer], dtype=float)
    shift = STAGGER * np.sin(2.4 * layer + np.arange(dimension - 1))
    low = CLEARANCE + RADIUS + STAGGER
    return tuple((SPACING * cell + low + np.append(shift, -STAGGER)).tolist())


def _discs(centers: list, mass: float, law: ProgressiveLaw) -> tuple[list[Any], list[Contact]]:
    inertia = 0.5 * mass * RADIUS**2
    bodies = [PlanarBody(name=f"g{k}", mass=mass, inertia=inertia, position=c) for k, c in enumerate(centers)]
    pairs: list[Contact] = [
        CircleOnCircle(name=f"g{i}.g{j}", body_a=f"g{i}", center_a=centers[i], radius_a=RADIUS, body_b=f"g{j}",
                       center_b=centers[j], radius_b=RADIUS, law=law)
        for i, j in itertools.combinations(range(len(centers)), 2)
    ]  # fmt: skip
    return bodies, pairs


def _spheres(centers: list, mass: float, law: ProgressiveLaw) -> tuple[list[Any], list[Contact]]:
    inertia = sphere(mass, RADIUS)
    bodies = [SpatialBody(name=f"g{k}", mass=mass, inertia=inertia, position=c) for k, c in enumerate(centers)]
    pairs: list[Contact] = [
        SphereOnSphere(name=f"g{i}.g{j}", body_a=f"g{i}", center_a=centers[i], radius_a=RADIUS, body_b=f"g{j}",
                       center_b=centers[j], radius_b=RADIUS, law=law)
        for i, j in itertools.combinations(range(len(centers)), 2)
    ]  # fmt: skip
    return bodies, pairs


def _walls(grains: int, centers: list, width: float, law: ProgressiveLaw, dimension: int):
    """Yield the floor and the walls under every grain."""
    for axis, side in [(dimension - 1, 0), *itertools.product(range(dimension - 1), (0, 1))]:
        normal, point = np.zeros(dimension), np.zeros(dimension)
        normal[axis], point[axis] = 1.0 - 2.0 * side, side * (width + 2.0 * STAGGER)
        for k in range(grains):
            name = f"wall{axis}{side}.g{k}"
            shared = {"name": name, "body_a": f"g{k}", "center": centers[k], "radius": RADIUS, "law": law}
            if dimension == 3:
                ends: dict[str, Any] = {"point": tuple(point), "normal": tuple(normal)}
                yield SphereOnPlane(**shared, **ends)
            else:
                along = np.array([normal[1], -normal[0]])  # the free side is on its left
                yield CircleOnLine(**shared, point_1=tuple(point), point_2=tuple(point + along))
