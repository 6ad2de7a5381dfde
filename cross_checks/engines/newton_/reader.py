"""What a state of Newton's says of the links."""

from __future__ import annotations

from typing import Any

import numpy as np

from cross_checks.engines.newton_.model import trees_of
from cross_checks.linkage.links import Linkage
from mbs_ref.scene.euler_parameters import rotation_matrices


def row_of(state: Any) -> np.ndarray:
    """Return coordinates, their rates, poses and velocities, one after the other."""
    parts = (state.joint_q, state.joint_qd, state.body_q, state.body_qd)
    return np.concatenate([part.numpy().ravel() for part in parts], dtype=float)


class Reader:
    """Reads rows as `row_of` makes them; velocities are those of centres of mass."""

    def __init__(self, linkage: Linkage, model: Any) -> None:
        links = [link for tree in trees_of(linkage) for link in tree]
        self.split = np.cumsum([model.joint_coord_count, model.joint_dof_count, 7 * len(links)])
        self.order = np.argsort([link.body for link in links])  # of Newton's bodies, in the scene
        self.centres = np.array([links[k].centre for k in self.order])
        numbers = {link.body: k for k, link in enumerate(links)}
        counted = [(numbers[link.body], k) for link in linkage.links for k in range(link.size)]
        starts = model.joint_q_start.numpy(), model.joint_qd_start.numpy()
        self.places, self.rates = ([int(start[joint]) + k for joint, k in counted] for start in starts)

    def coordinates(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        q, v, *_ = np.split(state, self.split)
        return q[self.places], v[self.rates]

    def frames(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        *_, poses, twists = np.split(state, self.split)
        place, twist = poses.reshape(-1, 7)[self.order], twists.reshape(-1, 6)[self.order]
        theta = place[:, [6, 3, 4, 5]]
        turn = rotation_matrices(theta / np.linalg.norm(theta, axis=1, keepdims=True))
        centre = place[:, :3] + np.einsum("nij,nj->ni", turn, self.centres)
        return turn, centre, twist[:, :3], twist[:, 3:]
