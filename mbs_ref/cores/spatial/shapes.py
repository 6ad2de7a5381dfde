"""Contact parts -> the arrays of the spatial contact groups."""

from __future__ import annotations

import math
from typing import Any, NamedTuple, Protocol

import numpy as np

from mbs_ref.cores.event_arrays import Places
from mbs_ref.cores.near_pairs import Ball, near_pairs
from mbs_ref.kernels.contact import laws as shared
from mbs_ref.kernels.contact.near_pairs import NearPairs
from mbs_ref.kernels.spatial import model as arrays
from mbs_ref.scene import Scene
from mbs_ref.scene.base.directions import normals, unit
from mbs_ref.scene.contact import SphereOnPlane, SphereOnSphere

_ENDS = {"plane": shared.ENDS_NONE, "rectangle": shared.ENDS_OPEN, "capped": shared.ENDS_CAPPED}


class Axes(Places, Protocol):
    """Bodies that also have axes."""

    def direction(self, name: str, world: Any) -> np.ndarray: ...


class _Shape(NamedTuple):
    """One row of ContactPairs, with the marks in world axes at t = 0."""

    kind: int
    center: tuple[float, ...]
    radius: float
    origin: tuple[float, ...]
    half: tuple[float, float]
    axes: tuple[np.ndarray, ...] = tuple(np.eye(3))  # two edges and the normal, right-handed
    ends: int = shared.ENDS_NONE
    thickness: float = math.inf


def _plane(part: SphereOnPlane) -> _Shape:
    normal = unit(part.normal)
    edge = normals(part.normal)[0] if part.edge is None else unit(part.edge)
    return _Shape(
        kind=shared.PAIR_FLAT,
        center=part.center,
        radius=part.radius,
        origin=part.point,
        half=(math.inf, math.inf) if part.size is None else (0.5 * part.size[0], 0.5 * part.size[1]),
        axes=(edge, np.cross(normal, edge), normal),
        ends=_ENDS[part.extent],
        thickness=math.inf if part.thickness is None else part.thickness,
    )


def _sphere(part: SphereOnSphere) -> _Shape:
    half = part.radius_b, part.radius_b
    return _Shape(shared.PAIR_ROUND, part.center_a, part.radius_a, part.center_b, half)


_SHAPES: dict[type, Any] = {SphereOnPlane: _plane, SphereOnSphere: _sphere}


def contact_pairs(scene: Scene, places: Axes) -> arrays.ContactPairs:
    """Return the shapes in body axes."""
    parts, count = scene.contacts, len(scene.contacts)
    shapes: list[_Shape] = [_SHAPES[type(part)](part) for part in parts]
    pairs = list(zip(parts, shapes, strict=True))
    sticking = [part.friction is not None and part.friction.STICKS for part in parts]
    return arrays.ContactPairs(
        kind=np.array([s.kind for s in shapes], dtype=np.int64),
        a=np.array([places.body(p.body_a) for p in parts], dtype=np.int64),
        b=np.array([places.body(p.body_b) for p in parts], dtype=np.int64),
        center=np.array([places.point(p.body_a, s.center) for p, s in pairs]).reshape(count, 3),
        radius=np.array([s.radius for s in shapes], dtype=float),
        origin=np.array([places.point(p.body_b, s.origin) for p, s in pairs]).reshape(count, 3),
        axes=np.array([[places.direction(p.body_b, x) for x in s.axes] for p, s in pairs]).reshape(count, 3, 3),
        half=np.array([s.half for s in shapes], dtype=float).reshape(count, 2),
        ends=np.array([s.ends for s in shapes], dtype=np.int64),
        thickness=np.array([s.thickness for s in shapes], dtype=float),
        deflection=np.where(sticking, np.cumsum(sticking) - 1, -1).astype(np.int64).reshape(count),
        sticking=np.array([sum(sticking)], dtype=np.int64),
    )


def contact_balls(pairs: arrays.ContactPairs) -> NearPairs:
    """Return what every pair's shapes lie in, and the list of near pairs."""
    return near_pairs([(_ball(pairs, k), _other_ball(pairs, k)) for k in range(len(pairs.kind))], 3)


def _ball(pairs: arrays.ContactPairs, k: int) -> Ball:
    return Ball(int(pairs.a[k]), tuple(pairs.center[k]), float(pairs.radius[k]))


def _other_ball(pairs: arrays.ContactPairs, k: int) -> Ball | None:
    """Return None for a surface without ends or without a back, which reaches far below itself."""
    plane = pairs.kind[k] == shared.PAIR_FLAT
    if plane and (pairs.ends[k] == shared.ENDS_NONE or math.isinf(pairs.thickness[k])):
        return None
    reach = math.hypot(*pairs.half[k]) if plane else float(pairs.half[k, 0])
    return Ball(int(pairs.b[k]), tuple(pairs.origin[k]), reach)
