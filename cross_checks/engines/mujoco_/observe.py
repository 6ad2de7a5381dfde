"""MuJoCo's own motion and wrenches."""

from collections.abc import Iterator

import mujoco
import numpy as np

from cross_checks.linkage.links import Linkage
from cross_checks.linkage.motion import Motion
from mbs_ref.kernels.jit import strict_jit


class Observer:
    """Reads the bodies of a scene from MuJoCo's data."""

    def __init__(self, model: mujoco.MjModel, linkage: Linkage) -> None:
        self.model, self.linkage = model, linkage
        self.index = np.array([model.body(name).id for name in linkage.scene.body_names])
        self.root = model.body_rootid[self.index]

    def motion(self, data: mujoco.MjData) -> Motion:
        """Return the motion that the data's kinematics have."""
        angle = self.linkage.turned(data.qpos)
        return _motion(data.xipos, data.xquat, data.cvel, data.subtree_com, self.index, self.root, angle)

    def placed(self, times: np.ndarray, states: np.ndarray) -> Iterator[mujoco.MjData]:
        """Yield MuJoCo's data at each state, forces included."""
        data = mujoco.MjData(self.model)
        for data.time, state in zip(times, states, strict=True):
            data.qpos[:], data.qvel[:] = state[: self.model.nq], state[self.model.nq :]
            mujoco.mj_forward(self.model, data)
            yield data

    def motions(self, times: np.ndarray, states: np.ndarray) -> Iterator[Motion]:
        """Yield the motion at each state."""
        return map(self.motion, self.placed(times, states))

    def wrenches(self, times: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Return what each body gets from its parent, (n_t, n_bodies, 6): N, and N m about the world's origin."""
        wrench = np.zeros((len(states), len(self.index), 6))
        for k, data in enumerate(self.placed(times, states)):
            mujoco.mj_rnePostConstraint(self.model, data)
            force = data.cfrc_int[self.index, 3:]
            reference = data.subtree_com[self.root]  # cfrc_int is about that point
            wrench[k] = np.column_stack((force, data.cfrc_int[self.index, :3] + np.cross(reference, force)))
        return wrench


@strict_jit
def _motion(xipos, xquat, cvel, subtree_com, index, root, angle):
    """Return the motion; cvel is about the centre of mass of a body's whole tree."""
    n = index.shape[0]
    position, turn, velocity, omega = np.empty((n, 3)), np.empty((n, 4)), np.empty((n, 3)), np.empty((n, 3))
    for b in range(n):
        position[b], turn[b], omega[b] = xipos[index[b]], xquat[index[b]], cvel[index[b], :3]
        arm, spin, speed = position[b] - subtree_com[root[b]], omega[b], cvel[index[b], 3:]
        for c in range(3):
            i, j = (c + 1) % 3, (c + 2) % 3
            velocity[b, c] = speed[c] + spin[i] * arm[j] - spin[j] * arm[i]
    return Motion(position, turn, velocity, omega, angle)
