"""Loads and contacts of jointed bodies that MuJoCo's own cannot be, applied by the shared force code at every stage."""

# Its names live in a compiled module.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import mujoco
import numpy as np

from cross_checks.engine import Refusal
from cross_checks.engines.mujoco_.contact import contact_refusals
from cross_checks.engines.mujoco_.refusals import part_refusals
from cross_checks.workshop.planar_forces import AppliedForces
from cross_checks.workshop.planar_forces import contact_refusals as located_refusals
from cross_checks.workshop.planar_tree import JointTree, joint_tree
from mbs_ref.scene import PointBushing, Scene

type Callback = Callable[[mujoco.MjModel, mujoco.MjData], None]


def takes_shared_forces(scene: Scene) -> bool:
    """Return whether a planar tree touches things in a way that only the shared force code knows."""
    if scene.dimension == 3 or not (scene.contacts and scene.joints) or joint_tree(scene).closures:
        return False
    bushed = any(isinstance(load, PointBushing) for load in scene.loads)
    return bool(bushed or part_refusals(scene) or contact_refusals(scene))


def force_refusals(scene: Scene) -> list[Refusal]:
    """Return what of a planar scene's loads and contacts neither MuJoCo nor the shared force code can be."""
    if takes_shared_forces(scene):
        return located_refusals(scene)
    bushings = [load for load in scene.loads if isinstance(load, PointBushing)]
    untaught = [Refusal(f"load {b.name!r}: mujoco is not yet taught point_bushing", False) for b in bushings]
    return untaught + part_refusals(scene) + contact_refusals(scene)


@contextmanager
def passive(act: Callback | None) -> Iterator[None]:
    """Let MuJoCo call `act` whenever it asks for passive forces: at every stage of every step."""
    mujoco.set_mjcb_passive(act)
    try:
        yield
    finally:
        mujoco.set_mjcb_passive(None)


def shared_forces(model: mujoco.MjModel, tree: JointTree) -> Callback:
    """Return what sets the forces on all bodies."""
    applied = AppliedForces(tree)
    index = np.array([model.body(name).id for name in tree.scene.body_names])
    root, pushed = model.body_rootid[index], np.ix_(index, (0, 1, 5))
    turns, start = _turns(model, tree), tree.angle[:-1]
    q, v = np.empty((2, len(index), 3))

    def act(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        place, twist = data.xipos[index], data.cvel[index]
        arm, rate = place - data.subtree_com[root], twist[:, 2]  # cvel is about subtree_com, turning about z
        q[:, :2], q[:, 2] = place[:, :2], start + turns @ data.qpos
        v[:, 0], v[:, 1], v[:, 2] = twist[:, 3] - rate * arm[:, 1], twist[:, 4] + rate * arm[:, 0], rate
        data.xfrc_applied[pushed] = applied.of_poses(data.time, q, v)

    return act


def _turns(model: mujoco.MjModel, tree: JointTree) -> np.ndarray:
    """Return which coordinates turn each body, (n_bodies, n_q)."""
    columns = np.zeros((len(tree.scene.bodies), model.nq))
    for k in range(len(tree.scene.bodies)):
        for edge in tree.path(k):
            if edge.kind in ("revolute", "free"):
                columns[k, edge.start + edge.size - 1] = 1.0
    return columns
