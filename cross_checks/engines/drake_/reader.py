"""What a plant's state (q, v) says of the links."""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant

from cross_checks.linkage.links import Linkage


class Reader:
    """Reads states in a context of its own."""

    def __init__(self, plant: MultibodyPlant, linkage: Linkage) -> None:
        self.plant, self.context = plant, plant.CreateDefaultContext()
        self.joints = [plant.GetJointByName(f"{link.name}/joint") for link in linkage.links]
        by_body = sorted(linkage.links, key=lambda link: link.body)
        self.bodies = [plant.GetBodyByName(link.name) for link in by_body]
        self.centres = np.array([link.centre for link in by_body])
        counted = [(j, k) for j, link in zip(self.joints, linkage.links, strict=True) for k in range(link.size)]
        self.places = [joint.position_start() + k for joint, k in counted]  # a planar joint slides, then turns
        self.speeds = [plant.num_positions() + joint.velocity_start() + k for joint, k in counted]

    def start(self, linkage: Linkage) -> np.ndarray:
        """Return the state at t = 0: a free body's rates are its angular velocity, then its velocity."""
        self.plant.SetDefaultContext(self.context)
        state = self.plant.GetPositionsAndVelocities(self.context).copy()
        for joint, link in zip(self.joints, linkage.links, strict=True):
            rates = link.rates[[3, 4, 5, 0, 1, 2]] if link.kind == "free" else link.rates
            first = self.plant.num_positions() + joint.velocity_start()
            state[first : first + len(rates)] = rates
        return state

    def coordinates(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return state[self.places], state[self.speeds]

    def frames(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        self.plant.SetPositionsAndVelocities(self.context, state)
        placed = [self.plant.EvalBodyPoseInWorld(self.context, body) for body in self.bodies]
        moving = [self.plant.EvalBodySpatialVelocityInWorld(self.context, body) for body in self.bodies]
        turn = np.array([pose.rotation().matrix() for pose in placed])
        omega = np.array([velocity.rotational() for velocity in moving])
        arm = np.einsum("nij,nj->ni", turn, self.centres)
        centre = np.array([pose.translation() for pose in placed]) + arm
        speed = np.array([velocity.translational() for velocity in moving]) + np.cross(omega, arm)
        return turn, centre, speed, omega
