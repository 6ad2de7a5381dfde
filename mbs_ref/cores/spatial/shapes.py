"""Contact parts -> the arrays of the spatial contact groups."""

from __future__ import annotations

import math
from typing import Any, Protocol

import numpy as np

from mbs_ref.cores.near_pairs import Ball, near_pairs
from mbs_ref.cores.spatial.elements import normals, unit
from mbs_ref.kernels.contact import laws as shared
from mbs_ref.kernels.contact.near_pairs import NearPairs
from mbs_ref.kernels.spatial import model as arrays
from mbs_ref.scene import Scene
from mbs_ref.scene.contact import SphereOnPlane, SphereOnSphere, StickSlip

_ENDS = {"plane": shared.ENDS_NONE, "rectangle": shared.ENDS_OPEN, "capped": shared.ENDS_CAPPED}


class Places(Protocol):
    """What the builder knows of bodies."""

    def body(self, name: str) -> int: ...

    def point(self, name: str, world: Any) -> np.ndarray: ...

    def direction(self, name: str, world: Any) -> np.ndarray: ...


def contact_pairs(scene: Scene, places: Places) -> arrays.ContactPairs:
    """Return the shapes in body axes."""
    parts: list[Any] = list(scene.contacts)
    flat = [isinstance(part, SphereOnPlane) for part in parts]
    count = len(parts)
    sticking = [isinstance(part.friction, StickSlip) for part in parts]
    centers = [p.center if f else p.center_a for p, f in zip(parts, flat, strict=True)]
    origins = [p.point if f else p.center_b for p, f in zip(parts, flat, strict=True)]
    thickness = [p.thickness if f and p.thickness is not None else math.inf for p, f in zip(parts, flat, strict=True)]
    return arrays.ContactPairs(
        kind=np.array([arrays.PAIR_PLANE if f else arrays.PAIR_SPHERE for f in flat], dtype=np.int64),
        a=np.array([places.body(p.body_a) for p in parts], dtype=np.int64),
        b=np.array([places.body(p.body_b) for p in parts], dtype=np.int64),
        center=np.array([places.point(p.body_a, x) for p, x in zip(parts, centers, strict=True)]).reshape(count, 3),
        radius=np.array([p.radius if f else p.radius_a for p, f in zip(parts, flat, strict=True)], dtype=float),
        origin=np.array([places.point(p.body_b, x) for p, x in zip(parts, origins, strict=True)]).reshape(count, 3),
        axes=np.array([[places.direction(p.body_b, x) for x in _axes(p)] for p in parts]).reshape(count, 3, 3),
        half=np.array([_half(p) for p in parts], dtype=float).reshape(count, 2),
        ends=np.array([_ENDS[p.extent] if f else shared.ENDS_NONE for p, f in zip(parts, flat, strict=True)],
                      dtype=np.int64),
        thickness=np.array(thickness, dtype=float),
        deflection=np.where(sticking, np.cumsum(sticking) - 1, -1).astype(np.int64).reshape(count),
        sticking=np.array([sum(sticking)], dtype=np.int64),
    )  # fmt: skip


def _axes(part: SphereOnPlane | SphereOnSphere) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return two edges and the normal, right-handed; for spheres any three."""
    if isinstance(part, SphereOnSphere):
        return np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
    normal = unit(part.normal)
    edge = normals(part.normal)[0] if part.edge is None else unit(part.edge)
    return edge, np.cross(normal, edge), normal


def _half(part: SphereOnPlane | SphereOnSphere) -> tuple[float, float]:
    if isinstance(part, SphereOnSphere):
        return part.radius_b, part.radius_b
    return (math.inf, math.inf) if part.size is None else (0.5 * part.size[0], 0.5 * part.size[1])


def contact_balls(pairs: arrays.ContactPairs) -> NearPairs:
    """Return what every pair's shapes lie in, and the list of near pairs."""
    return near_pairs([(_ball(pairs, k), _other_ball(pairs, k)) for k in range(len(pairs.kind))], 3)


def _ball(pairs: arrays.ContactPairs, k: int) -> Ball:
    return Ball(int(pairs.a[k]), tuple(pairs.center[k]), float(pairs.radius[k]))


def _other_ball(pairs: arrays.ContactPairs, k: int) -> Ball | None:
    """Return None for a surface without ends or without a back, which reaches far below itself."""
    plane = pairs.kind[k] == arrays.PAIR_PLANE
    if plane and (pairs.ends[k] == shared.ENDS_NONE or math.isinf(pairs.thickness[k])):
        return None
    reach = math.hypot(*pairs.half[k]) if plane else float(pairs.half[k, 0])
    return Ball(int(pairs.b[k]), tuple(pairs.origin[k]), reach)
