"""A planar scene compiled: three coordinates a body, joint rows, reactions; callable from Python."""

from typing import Any

import numpy as np

from mbs_ref.cores.builder import Builder, assembled, forces, torsion_springs
from mbs_ref.cores.jointed_system import JointedSystem
from mbs_ref.cores.system import Poses
from mbs_ref.cores.user_rows import variable
from mbs_ref.kernels.border.groups import floats
from mbs_ref.kernels.planar import model as arrays
from mbs_ref.kernels.planar.model import PlanarScratch
from mbs_ref.kernels.rigid.model import rigid_scratch
from mbs_ref.scene import PointMass, Scene
from mbs_ref.scene.joints import PlanarPlace
from mbs_ref.scene.scales import Scales

_HELD_INERTIA = 1.0  # kg m^2 in the idle third slot of a point mass: nothing ever turns it


class _Builder(Builder):
    """Planar bodies, joints and loads."""

    def groups(self) -> Any:
        inertia = [_HELD_INERTIA if isinstance(b, PointMass) else b.inertia for b in self.scene.bodies]
        rest = torsion_springs(
            self, lambda x: self.angle(x.body_b) - self.angle(x.body_a) if x.rest_angle is None else x.rest_angle
        )
        own = {"forces": forces(self), "torsion_springs": rest}
        return assembled(self, arrays.PlanarGroups, np.full((2, self.n), 3), floats(inertia)[:, None], **own)


class PlanarSystem(JointedSystem):
    """A planar scene as arrays and compiled functions.

    State y = concatenate(q.ravel(), v.ravel()) with q, v of shape (n_bodies, 3) in scene order: m, m,
    rad and their rates.
    """

    CORE, BUILDER = "planar", _Builder
    RATES = SHARED = 3

    def _new_scratch(self) -> Any:
        groups = self.groups
        slots, state = len(groups.slots.body), 6 * self.n_bodies
        scratch = rigid_scratch(PlanarScratch, self.n_bodies, slots, state, groups.loops, rates=3)
        scratch.kinematics.pose[:, 2] = 1.0
        return scratch

    def initial_state(self) -> np.ndarray:
        v = [(*body.velocity, vars(body).get("angular_velocity", 0.0)) for body in self.scene.bodies]
        q = np.column_stack((self.builder.centres, self.builder.angles))[:-1]
        return np.concatenate((q.ravel(), np.array(v).ravel()))

    @staticmethod
    def state_units(scene: Scene, scales: Scales) -> np.ndarray:
        q = np.tile([scales.length, scales.length, 1.0], len(scene.bodies))
        return np.concatenate((q, q / scales.time))

    def poses(self, states: np.ndarray) -> Poses:
        n = self.n_bodies
        q, v = states.reshape(-1, 2, n, 3).transpose(1, 0, 2, 3)
        return Poses(q[:, :, :2].copy(), q[:, :, 2].copy(), v[:, :, :2].copy(), v[:, :, 2].copy())

    def orientations(self, states: np.ndarray) -> np.ndarray:
        return states[:, 2 : 3 * self.n_bodies : 3]

    def states_of(self, poses: Poses) -> np.ndarray:
        q = np.concatenate((poses.position, poses.orientation[:, :, None]), axis=2)
        v = np.concatenate((poses.velocity, poses.angular_velocity[:, :, None]), axis=2)
        return np.concatenate((q.reshape(len(q), -1), v.reshape(len(v), -1)), axis=1)

    def mass_matrix(self) -> np.ndarray:
        bodies = self.groups.bodies
        return self._in_scene_order(np.column_stack((bodies.mass, bodies.mass, bodies.inertia))).ravel()

    @property
    def n_coordinates(self) -> int:
        """Coordinates in use: three a rigid body, two a point mass."""
        return sum(2 if isinstance(b, PointMass) else 3 for b in self.scene.bodies)

    def _coordinates(self, body: int, arm: np.ndarray, size: int, first: int) -> PlanarPlace:
        kin = self.scratch.kinematics
        v, turns = kin.motion[body], body < self.n_bodies and self.groups.bodies.rigid[body] == 1
        held = body == self.n_bodies
        x, y = (variable(kin.pose[body, c], v[c], 0.0, size, None if held else first + c) for c in range(2))
        angle = variable(v[3], v[2], 0.0, size, first + 2 if turns else None)
        c, s = np.cos(angle), np.sin(angle)
        return PlanarPlace(x + c * arm[0] - s * arm[1], y + s * arm[0] + c * arm[1], angle)

    @staticmethod
    def turned(turns: np.ndarray, arms: np.ndarray) -> np.ndarray:
        c, s = np.cos(turns), np.sin(turns)
        along, across = arms[..., 0], arms[..., 1]
        return np.stack((c * along - s * across, s * along + c * across), axis=-1)

    @staticmethod
    def _about(arms: np.ndarray, forces: np.ndarray) -> np.ndarray:
        forces[..., 2] -= arms[..., 0] * forces[..., 1] - arms[..., 1] * forces[..., 0]
        return forces
