"""What a spatial joint is made of: elementary constraint rows between body-fixed points and directions."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from mbs_ref.cores.joint_graph import Edge, Layout, edges, span_graph
from mbs_ref.scene import Cylindrical, PointDrive, Revolute, RotationDrive, Scene


@dataclass(frozen=True)
class SharedPoint:
    """Three rows r_b - r_a = 0 along the world axes."""

    point_a: tuple[float, ...]  # m, world, t = 0
    point_b: tuple[float, ...]  # m, world, t = 0
    rows: int = 3


@dataclass(frozen=True)
class Product:
    """One row e_a . e_b = 0."""

    along_a: np.ndarray  # unit vector, world, t = 0
    along_b: np.ndarray  # unit vector, world, t = 0
    rows: int = 1


@dataclass(frozen=True)
class OnPlane:
    """One row n . (r_b - r_a) = 0, n fixed in body a."""

    point: tuple[float, ...]  # m, world, t = 0
    normal: np.ndarray  # unit vector, world, t = 0
    rows: int = 1


@dataclass(frozen=True)
class Rod:
    """One row |r_b - r_a| = length."""

    point_a: tuple[float, ...]  # m, world, t = 0
    point_b: tuple[float, ...]  # m, world, t = 0
    length: float  # m
    rows: int = 1


@dataclass(frozen=True)
class Turn:
    """One row sin(angle - motion) = 0 about an axis."""

    zero: np.ndarray  # unit vector, world, t = 0, perpendicular to the axis
    quarter: np.ndarray  # axis x zero
    rows: int = 1


@dataclass(frozen=True)
class Prescribed:
    """One row direction . (r - r(0)) = motion."""

    point: tuple[float, ...]  # m, world, t = 0
    direction: np.ndarray  # unit vector, world
    rows: int = 1


Element = SharedPoint | Product | OnPlane | Rod | Turn | Prescribed


def unit(vector: Any) -> np.ndarray:
    """Return the vector at length one."""
    vector = np.asarray(vector, dtype=float)
    return vector / math.hypot(*vector)


def normals(axis: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return two unit vectors that make a right-handed frame with the axis, axis last."""
    axis = unit(axis)
    first = unit(np.cross(np.eye(3)[int(np.argmin(np.abs(axis)))], axis))
    return first, np.cross(axis, first)


def _second_mark(joint: Any) -> tuple[float, ...]:
    return joint.point if joint.point_b is None else joint.point_b


def _parallel(axis: Any) -> list[Element]:
    return [Product(normal, unit(axis)) for normal in normals(axis)]


def _locked() -> list[Element]:
    x, y, z = np.eye(3)
    return [Product(x, y), Product(y, z), Product(z, x)]


def _prismatic(joint: Any) -> list[Element]:
    across: list[Element] = [OnPlane(joint.point, normal) for normal in normals(joint.axis)]
    return [*across, *_locked()]


def _cylindrical(joint: Any) -> list[Element]:
    across: list[Element] = [OnPlane(joint.point, normal) for normal in normals(joint.axis)]
    return [*across, *_parallel(joint.axis)]


def _distance(joint: Any) -> list[Element]:
    length = math.dist(joint.point_a, joint.point_b) if joint.length is None else joint.length
    return [Rod(joint.point_a, joint.point_b, length)]


def _coordinate_drive(joint: Any, centre: tuple[float, ...]) -> list[Element]:
    return [Prescribed(centre, np.eye(3)["xyz".index(joint.coordinate)])]


_ELEMENTS: dict[str, Callable[[Any], list[Element]]] = {
    "spherical": lambda j: [SharedPoint(j.point, j.point)],
    "revolute": lambda j: [SharedPoint(j.point, _second_mark(j)), *_parallel(j.axis)],
    "universal": lambda j: [SharedPoint(j.point, j.point), Product(unit(j.axis_a), unit(j.axis_b))],
    "cylindrical": _cylindrical,
    "prismatic": _prismatic,
    "weld": lambda j: [SharedPoint(j.point, _second_mark(j)), *_locked()],
    "distance": _distance,
    "point_on_plane": lambda j: [OnPlane(j.point, unit(j.normal))],
    "point_drive": lambda j: [Prescribed(j.point, unit(j.direction))],
    "rotation_drive": lambda j: [Turn(*normals(j.axis))],
}


def elements(joint: Any, scene: Scene) -> list[Element]:
    """Return the elementary rows of a spatial joint, in the order of its rows."""
    if joint.type == "coordinate_drive":
        return _coordinate_drive(joint, scene.bodies[scene.body_index(joint.body)].position)
    return _ELEMENTS[joint.type](joint)


ROW_COUNT = {
    "spherical": 3, "revolute": 5, "universal": 4, "cylindrical": 4, "prismatic": 5, "weld": 6,
}  # fmt: skip


def row_count(joint: Any) -> int:
    """Return the number of constraint rows of a spatial joint."""
    return ROW_COUNT.get(joint.type, 1)


def _fits(edge: Edge, joint: Any, scene: Scene) -> bool:
    """Return whether the joint's rows stay independent of the edge's in every pose.

    A drive goes with the joint that keeps its axis; three drives along x, y, z go together.
    """
    present: list[Any] = [scene.joints[k] for k in edge.joints]
    kinds = {j.type for j in present}
    if isinstance(joint, RotationDrive):
        keeps_axis = len(present) == 1 and isinstance(present[0], Revolute | Cylindrical)
        return keeps_axis and _is_parallel(present[0].axis, joint.axis)
    if joint.type == "coordinate_drive":
        return kinds == {"coordinate_drive"} and all(j.coordinate != joint.coordinate for j in present)
    if isinstance(joint, PointDrive) and kinds == {"point_drive"}:
        directions = np.array([unit(j.direction) for j in (*present, joint)])
        same_point = all(j.point == joint.point for j in present)
        return same_point and len(directions) <= 3 and np.linalg.matrix_rank(directions, tol=0.1) == len(directions)
    return False


def _is_parallel(first: Any, second: Any) -> bool:
    return float(np.linalg.norm(np.cross(unit(first), unit(second)))) < 1e-9


def spatial_layout(scene: Scene) -> Layout:
    """Lay out a spatial scene."""
    return span_graph(scene, edges(scene, row_count, _fits))
