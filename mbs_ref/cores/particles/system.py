"""A scene of particles compiled: three coordinates a body, no constraints."""

from __future__ import annotations

import itertools

import numpy as np

from mbs_ref.cores.particles.build import build_particles
from mbs_ref.cores.system import Poses, System
from mbs_ref.kernels.particles.model import particle_scratch
from mbs_ref.scene import Scene
from mbs_ref.scene.scales import Scales
from mbs_ref.scene.units import free_fall_time


class ParticleSystem(System):
    """Particles in space as arrays and compiled functions.

    State y = concatenate(q.ravel(), v.ravel()) with q, v of shape (n_bodies, 3): m, m/s. Raises ValueError
    where two bodies that attract each other are at one place, or start inside each other.
    """

    CORE = "particles"

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.n_bodies = len(scene.bodies)
        self.groups = build_particles(scene)
        self.scratch = particle_scratch(self.n_bodies)
        self._refuse_coincidence()

    def _refuse_coincidence(self) -> None:
        particles = self.groups.particles
        for i, j in itertools.combinations(range(self.n_bodies), 2):
            gap = float(np.linalg.norm(np.subtract(self.scene.bodies[i].position, self.scene.bodies[j].position)))
            names = f"bodies {self.scene.bodies[i].name!r} and {self.scene.bodies[j].name!r}"
            if gap == 0.0 and max(particles.gm[i], particles.gm[j]) > 0.0:
                raise ValueError(f"{names} coincide at t = 0; their attraction is infinite")
            if gap < particles.radius[i] + particles.radius[j]:
                raise ValueError(f"{names} overlap at t = 0: {gap:.6g} m apart, less than the sum of their radii")

    def twin(self) -> ParticleSystem:
        return ParticleSystem(self.scene)

    def initial_state(self) -> np.ndarray:
        """Return y (6 n_bodies,) at t = 0."""
        q = [body.position for body in self.scene.bodies]
        v = [body.velocity for body in self.scene.bodies]
        return np.concatenate((np.ravel(q), np.ravel(v))).astype(float)

    @staticmethod
    def state_units(scene: Scene, scales: Scales) -> np.ndarray:
        """Return L for every position and L / T for every velocity (6 n_bodies,).

        T is the free-fall time over L, where bodies are closer than L at the start, too.
        """
        time = free_fall_time(scene, scales.length)
        return np.repeat([scales.length, scales.length / time], 3 * len(scene.bodies))

    def poses(self, states: np.ndarray) -> Poses:
        """Turn states (n_t, n_state) into world poses and velocities; particles do not turn."""
        n = self.n_bodies
        q, v = np.moveaxis(states.reshape(len(states), 2, n, 3), 1, 0)
        turn = np.zeros((len(states), n, 4))
        turn[:, :, 0] = 1.0
        return Poses(q, turn, v, np.zeros_like(v))

    def states_of(self, poses: Poses) -> np.ndarray:
        """Return states (n_t, 6 n_bodies)."""
        count = len(poses.position)
        return np.concatenate((poses.position.reshape(count, -1), poses.velocity.reshape(count, -1)), axis=1)

    def set_mode_time(self, t: float) -> None:
        """No field has signals."""

    def set_baumgarte(self, gain: float) -> None:
        """There is nothing to stabilize."""

    def residuals(self, t: float, y: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        return {}
