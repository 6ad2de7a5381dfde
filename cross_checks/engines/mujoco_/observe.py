"""MuJoCo's own poses and wrenches."""

# Its names live in a compiled module.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from cross_checks.workshop.planar_tree import JointTree
from cross_checks.workshop.spatial_tree import SpatialTree


def observe_planar(model: mujoco.MjModel, tree: JointTree, times: np.ndarray, states: np.ndarray):
    """Return MuJoCo's own poses; angles add up along the tree, beyond one turn."""
    n = len(tree.scene.bodies)
    position, velocity = np.zeros((2, len(states), n, 2))
    index = np.array([model.body(name).id for name in tree.scene.body_names])
    for k, data in enumerate(_placed(model, times, states)):
        arm = data.xipos[index] - data.subtree_com[model.body_rootid[index]]  # cvel is about that point
        position[k] = data.xipos[index, :2]
        velocity[k] = (data.cvel[index, 3:] + np.cross(data.cvel[index, :3], arm))[:, :2]
    _, angle, _, rate = tree.poses(states[:, : model.nq], states[:, model.nq :])
    return position, angle, velocity, rate


def wrenches(model: mujoco.MjModel, tree: JointTree, times: np.ndarray, states: np.ndarray) -> np.ndarray:
    """Return what each body gets from its parent, (n_t, n_bodies, 3): force (N) and moment about the origin (N m)."""
    wrench = np.zeros((len(states), len(tree.scene.bodies), 3))
    index = np.array([model.body(name).id for name in tree.scene.body_names])
    for k, data in enumerate(_placed(model, times, states)):
        mujoco.mj_rnePostConstraint(model, data)
        reference = data.subtree_com[model.body_rootid[index]]  # cfrc_int is about that point
        moment = data.cfrc_int[index, :3] + np.cross(reference, data.cfrc_int[index, 3:])
        wrench[k] = np.column_stack((data.cfrc_int[index, 3:5], moment[:, 2]))
    return wrench


def _placed(model: mujoco.MjModel, times: np.ndarray, states: np.ndarray) -> Iterator[mujoco.MjData]:
    """Yield MuJoCo's data at each state, forces included."""
    data = mujoco.MjData(model)
    for data.time, state in zip(times, states, strict=True):
        data.qpos[:], data.qvel[:] = state[: model.nq], state[model.nq :]
        mujoco.mj_forward(model, data)
        yield data


def observe_spatial(model: mujoco.MjModel, tree: SpatialTree, states: np.ndarray):
    """Return MuJoCo's own poses."""
    n = len(tree.scene.bodies)
    position, velocity, omega = np.zeros((3, len(states), n, 3))
    theta = np.zeros((len(states), n, 4))
    index = np.array([model.body(name).id for name in tree.scene.body_names])
    for k, data in enumerate(_placed(model, np.zeros(len(states)), states)):
        arm = data.xipos[index] - data.subtree_com[model.body_rootid[index]]  # cvel is about that point
        position[k], theta[k], omega[k] = data.xipos[index], data.xquat[index], data.cvel[index, :3]
        velocity[k] = data.cvel[index, 3:] + np.cross(data.cvel[index, :3], arm)
    return position, theta, velocity, omega
