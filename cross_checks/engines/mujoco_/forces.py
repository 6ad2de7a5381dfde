"""World poses and velocities of all bodies, and forces of the shared force code where MuJoCo has no element."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import mujoco
import numpy as np

from cross_checks.engine import Refusal
from cross_checks.engines.mujoco_.contact import contact_refusals
from cross_checks.engines.mujoco_.loads import load_refusals
from cross_checks.linkage.forces import Applied
from cross_checks.linkage.forces import contact_refusals as located_refusals
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


type Callback = Callable[[mujoco.MjModel, mujoco.MjData], None]


def own_refusals(linkage: Linkage) -> list[Refusal]:
    """Return why MuJoCo's own elements cannot stand for all loads and contacts."""
    reasons = load_refusals(linkage) + contact_refusals(linkage.scene)
    return [Refusal(reason, permanent=False) for reason in reasons]


def takes_shared_forces(linkage: Linkage) -> bool:
    """Return whether a tree needs the shared force code; a loop's soft constraints would act against it."""
    return bool(not linkage.closures and own_refusals(linkage))


def force_refusals(linkage: Linkage) -> list[Refusal]:
    """Return why neither MuJoCo nor the shared force code can stand for the loads and contacts."""
    own, located = own_refusals(linkage), located_refusals(linkage.scene)
    return own + located if own and (linkage.closures or located) else []


@contextmanager
def passive(act: Callback | None) -> Iterator[None]:
    """Let MuJoCo call `act` whenever it computes passive forces: at every stage of every step."""
    mujoco.set_mjcb_passive(act)
    try:
        yield
    finally:
        mujoco.set_mjcb_passive(None)


def shared_forces(model: mujoco.MjModel, linkage: Linkage) -> Callback:
    """Return what sets the forces on all bodies."""
    applied, observer = Applied(linkage), Observer(model, linkage)

    def act(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        data.xfrc_applied[observer.index] = applied.wrenches(data.time, observer.motion(data))

    return act
