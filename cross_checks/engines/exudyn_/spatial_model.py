"""An Exudyn system of spatial bodies, read through sensors of world positions and rotation matrices."""

# Its items take their arguments by names that type checkers cannot see.
# pyright: reportCallIssue=false, reportArgumentType=false, reportAttributeAccessIssue=false

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np

from cross_checks.linkage.tree import FIXED
from mbs_ref.scene import Scene, SpatialBody
from mbs_ref.scene.euler_parameters import from_matrix, rotation_matrices


@dataclass
class Spatial:
    """An Exudyn system of spatial bodies, read through sensors of world positions and rotation matrices."""

    scene: Scene
    container: Any
    mbs: Any
    bodies: dict[int, int] = field(default_factory=dict)  # scene body -> Exudyn object
    sensors: list[int] = field(default_factory=list)
    notes: tuple[str, ...] = ()

    def poses(self, rows: np.ndarray):
        n = len(self.scene.bodies)
        position, velocity, omega = np.zeros((3, len(rows), n, 3))
        theta = np.tile([1.0, 0.0, 0.0, 0.0], (len(rows), n, 1))
        column = 0
        for k, body in enumerate(self.scene.bodies):
            position[:, k], velocity[:, k] = rows[:, column : column + 3], rows[:, column + 3 : column + 6]
            column += 6
            if isinstance(body, SpatialBody):
                omega[:, k] = rows[:, column : column + 3]
                turned = rows[:, column + 3 : column + 12].reshape(-1, 3, 3)
                theta[:, k] = [from_matrix(m) if np.isfinite(m).all() else np.full(4, np.nan) for m in turned]
                column += 12
        return position, theta, velocity, omega

    def reactions(self, rows: np.ndarray) -> dict[str, np.ndarray]:
        return {}

    def axes(self, body: str) -> np.ndarray:
        """Return the body's axes (3, 3) at t = 0."""
        k = self.scene.body_index(body)
        owner = self.scene.bodies[k] if k != FIXED else None
        return rotation_matrices(owner.orientation) if isinstance(owner, SpatialBody) else np.eye(3)

    def marker(self, body: str, point) -> int:
        """Return a marker at a world point (t = 0)."""
        k = self.scene.body_index(body)
        where = np.array(point, dtype=float)
        if k != FIXED:
            where = self.axes(body).T @ (where - self.scene.bodies[k].position)
        rigid = k == FIXED or isinstance(self.scene.bodies[k], SpatialBody)
        kind = item.MarkerBodyRigid if rigid else item.MarkerBodyPosition
        return self.mbs.AddMarker(kind(bodyNumber=self.bodies[k], localPosition=where.tolist()))

    def frame(self, body: str, point, axes: np.ndarray) -> int:
        """Return a marker at a world point (t = 0) with the given world axes (3, 3)."""
        k = self.scene.body_index(body)
        centre = self.scene.bodies[k].position if k != FIXED else np.zeros(3)
        to_body = self.axes(body).T
        place = exu.HT(rotation=to_body @ axes, translation=to_body @ np.subtract(point, centre))
        return self.mbs.AddMarker(item.MarkerBodyRigid(bodyNumber=self.bodies[k], localHT=place))

    def pair(self, part, point_a, point_b) -> list[int]:
        return [self.marker(part.body_a, point_a), self.marker(part.body_b, point_b)]
