"""What a state of an OpenSim model says of the links."""

from __future__ import annotations

from typing import Any

import numpy as np
import opensim  # pyright: ignore[reportMissingImports]

from cross_checks.linkage.links import Linkage


def values(state: Any) -> np.ndarray:
    """Return a copy of Simbody's state vector."""
    return np.array(state.getY().to_numpy())


class Reader:
    """Reads state vectors in a state of its own."""

    def __init__(self, linkage: Linkage, model: Any, joints: list[Any], state: Any) -> None:
        self.model, self.state = model, opensim.State(state)
        self.bodies = [model.getBodySet().get(link.name) for link in linkage.of_body]
        self.centres = np.array([link.centre for link in linkage.of_body])
        self.counted = [
            joint.get_coordinates(k)
            for joint, link in zip(joints, linkage.links, strict=True)
            for k in ((1, 2, 0) if link.kind == "planar" else range(link.size))[: link.size]  # it turns, then slides
        ]

    def _put(self, state: np.ndarray) -> None:
        self.state.setY(opensim.Vector.createFromMat(state))
        self.model.realizeVelocity(self.state)

    def coordinates(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        self._put(state)
        places = [coordinate.getValue(self.state) for coordinate in self.counted]
        return np.array(places), np.array([coordinate.getSpeedValue(self.state) for coordinate in self.counted])

    def frames(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        self._put(state)
        placed = [body.getTransformInGround(self.state) for body in self.bodies]
        moving = [body.getVelocityInGround(self.state) for body in self.bodies]
        turns = [place.R().asMat33() for place in placed]
        turn = np.array([[[matrix.get(i, j) for j in range(3)] for i in range(3)] for matrix in turns])
        omega = np.array([velocity.get(0).to_numpy() for velocity in moving])
        arm = np.einsum("nij,nj->ni", turn, self.centres)
        centre = np.array([place.p().to_numpy() for place in placed]) + arm
        speed = np.array([velocity.get(1).to_numpy() for velocity in moving]) + np.cross(omega, arm)
        return turn, centre, speed, omega
