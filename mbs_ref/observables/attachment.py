"""Points and directions fixed in a body, followed along a trajectory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbs_ref.scene import GROUND, PlanarBody, Scene
from mbs_ref.trajectory import Trajectory

PERP = np.array([[0.0, -1.0], [1.0, 0.0]])  # turns a plane vector by +90 degrees


@dataclass(frozen=True)
class Motion:
    """A scene and its motion: what an observable looks at."""

    scene: Scene
    trajectory: Trajectory

    def __post_init__(self) -> None:
        if self.scene.dimension != 2:
            raise ValueError(f"scene {self.scene.name} has dimension {self.scene.dimension}; known here: 2")

    @property
    def times(self) -> np.ndarray:
        return self.trajectory.times

    def point(self, body: str, world: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
        """Return position and velocity (n_t, 2) of the point that is at `world` (m) at t = 0."""
        if body == GROUND:
            return self._fixed(world)
        k = self.scene.body_index(body)
        arm = np.subtract(world, self.scene.bodies[k].position)
        arm_t, arm_rate = self.direction(body, arm)
        return self.trajectory.position[:, k] + arm_t, self.trajectory.velocity[:, k] + arm_rate

    def rate_at(self, body: str, place: np.ndarray) -> np.ndarray:
        """Return the velocity (n_t, 2) of the body's matter that is at `place` (n_t, 2) at each time."""
        k = self.scene.body_index(body)
        if k < 0:
            return np.zeros_like(place)
        arm = place - self.trajectory.position[:, k]
        return self.trajectory.velocity[:, k] + self.spin(body)[:, None] * (arm @ PERP.T)

    def direction(self, body: str, world) -> tuple[np.ndarray, np.ndarray]:
        """Return a body-fixed vector (n_t, 2) that equals `world` at t = 0, and its rate."""
        k = self.scene.body_index(body)
        if k < 0 or not isinstance(self.scene.bodies[k], PlanarBody):
            return self._fixed(world)  # a particle does not turn
        turned = self.angle(body)
        vector = np.asarray(world, dtype=float)
        now = np.cos(turned)[:, None] * vector + np.sin(turned)[:, None] * (PERP @ vector)
        return now, self.trajectory.angular_velocity[:, k, None] * (now @ PERP.T)

    def angle(self, body: str) -> np.ndarray:
        """Return the angle turned since t = 0 (n_t,), rad; zero for ground and particles."""
        k = self.scene.body_index(body)
        start = self.scene.bodies[k]
        if k < 0 or not isinstance(start, PlanarBody):
            return np.zeros(len(self.times))
        return self.trajectory.orientation[:, k] - start.angle

    def spin(self, body: str) -> np.ndarray:
        """Return the angular velocity (n_t,), rad/s; zero for ground and particles."""
        k = self.scene.body_index(body)
        if k < 0 or not isinstance(self.scene.bodies[k], PlanarBody):
            return np.zeros(len(self.times))
        return self.trajectory.angular_velocity[:, k]

    def _fixed(self, world) -> tuple[np.ndarray, np.ndarray]:
        shape = (len(self.times), 2)
        return np.broadcast_to(np.asarray(world, dtype=float), shape), np.zeros(shape)
