"""MuJoCo's elements for loads, world poses and velocities of all bodies, and forces of the shared force code."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager

import mujoco
import numpy as np

from cross_checks.engine import Refusal
from cross_checks.engines.mujoco_.contact import contact_refusals
from cross_checks.linkage.forces import Applied, shared_refusals
from cross_checks.linkage.links import Linkage, Z, rest_length, rest_turn
from cross_checks.linkage.motion import Motion
from mbs_ref.kernels.jit import strict_jit
from mbs_ref.scene import Force, SpringDamper, Torque, TorqueVector, TorsionSpring
from mbs_ref.scene.signals import Constant

SAME_AXIS = 1e-9  # of directions of length 1


def add_tendon(spec, frames, name: str, ends: Iterable[tuple[int, np.ndarray]]):
    """Return a tendon between two points, each in the frame of its body."""
    tendon = spec.add_tendon(name=name)
    for end, (body, point) in enumerate(ends):
        frames[body].add_site(name=f"{name}/{end}", pos=point)
        tendon.wrap_site(f"{name}/{end}")
    return tendon


def _linear(coefficient: float) -> np.ndarray:
    """Return a linear law in the shape of the specification's polynomial coefficients."""
    return np.array([coefficient, 0.0, 0.0])


def _add_spring(spec, frames, linkage: Linkage, load: SpringDamper) -> None:
    ends = ((load.body_a, load.point_a), (load.body_b, load.point_b))
    places = [(linkage.scene.body_index(body), linkage.local(body, point)) for body, point in ends]
    tendon, rest = add_tendon(spec, frames, load.name, places), rest_length(load)
    tendon.stiffness, tendon.damping = _linear(load.stiffness), _linear(load.damping)
    tendon.springlength = (0.0 if load.tension_only else rest, rest)


def turning(linkage: Linkage, load: TorsionSpring) -> dict[str, float] | None:
    """Return by MuJoCo's joints what the angle of a torsion spring is a sum of; None where it is no such sum.

    Between bodies that no hinge parts it is an empty sum: the spring is inside of one body, and moves nothing.
    """
    axis = Z if load.axis is None else np.asarray(load.axis) / np.linalg.norm(load.axis)
    paths = [list(linkage.path(name)) for name in (load.body_b, load.body_a)]
    weights: dict[str, float] = {}
    for path, other, sign in ((*paths, 1.0), (*paths[::-1], -1.0)):
        for link in path:
            for k, (kind, along) in enumerate(link.freedoms if link not in other else ()):
                if kind == "slide":
                    continue
                if kind != "turn" or np.abs(np.cross(along, axis)).max() > SAME_AXIS:
                    return None
                weights[f"{link.name}/{k}"] = sign * float(np.sign(along @ axis))
    return weights


def _add_torsion(spec, frames, linkage: Linkage, load: TorsionSpring) -> None:
    """Add the spring and damper of one hinge, whose damping MuJoCo's Euler takes implicitly; else of a tendon."""
    weights = turning(linkage, load)
    if not weights:
        return
    rest = rest_turn(linkage.scene, load)
    first, sign = next(iter(weights.items()))
    hinge = spec.joint(first)
    if len(weights) == 1 and not np.any((hinge.stiffness, hinge.damping)):
        hinge.stiffness, hinge.damping, hinge.springref = _linear(load.stiffness), _linear(load.damping), sign * rest
        return
    tendon = spec.add_tendon(name=load.name)
    for label, weight in weights.items():
        tendon.wrap_joint(label, weight)
    tendon.stiffness, tendon.damping, tendon.springlength = _linear(load.stiffness), _linear(load.damping), (0.0, 0.0)
    if rest:
        _motor(spec, load.name, mujoco.mjtTrn.mjTRN_TENDON, load.name, load.stiffness * rest)


def _motor(spec, name: str, transmission, target: str, force: float, refsite: str = "", gear=(1.0, 0, 0, 0, 0, 0)):
    """A constant force: the actuator's bias alone, so that no control input is needed."""
    motor = spec.add_actuator(name=name, trntype=transmission, target=target, gear=gear)
    if refsite:
        motor.refsite = refsite
    motor.biastype = mujoco.mjtBias.mjBIAS_AFFINE
    motor.gaintype = mujoco.mjtGain.mjGAIN_FIXED
    motor.gainprm[0] = 0.0
    motor.biasprm[0] = force


def _add_push(spec, frames, linkage: Linkage, load: Force | Torque | TorqueVector) -> None:
    """Add a constant force or torque at a site, along its axes or along those of a site at rest."""
    scene, scale = linkage.scene, getattr(load.factor, "value", 0.0)
    k = scene.body_index(load.body)
    point = load.point if isinstance(load, Force) else scene.bodies[k].position
    frames[k].add_site(name=load.name, pos=linkage.local(load.body, point))
    vector = scale * (load.torque * Z if isinstance(load, Torque) else np.resize((*load.vector, 0.0), 3))
    gear = (*vector, 0.0, 0.0, 0.0) if isinstance(load, Force) else (0.0, 0.0, 0.0, *vector)
    reference = f"{load.name}/world" if getattr(load, "frame", "body") == "world" else ""
    if reference:
        spec.worldbody.add_site(name=reference, pos=linkage.local("ground", point))
    _motor(spec, load.name, mujoco.mjtTrn.mjTRN_SITE, load.name, 1.0, reference, gear)


LOADS = {
    **dict.fromkeys((Force, Torque, TorqueVector), _add_push), SpringDamper: _add_spring, TorsionSpring: _add_torsion,
}  # fmt: skip


def load_refusals(linkage: Linkage) -> list[str]:
    """Return why MuJoCo's own elements cannot stand for the scene's loads, load by load."""
    reasons = []
    for load in linkage.scene.loads:
        where = f"load {load.name!r}"
        if type(load) not in LOADS:
            reasons.append(f"{where}: mujoco does not yet support {load.type}")
        elif isinstance(load, Force | Torque | TorqueVector) and not isinstance(load.factor, Constant):
            reasons.append(f"{where} varies in time, which mujoco does not yet support")
        elif isinstance(load, SpringDamper) and load.tension_only and load.damping:
            reasons.append(f"{where}: a mujoco tendon damps while slack, so tension_only allows no damping")
        elif isinstance(load, SpringDamper) and load.limit is not None:
            reasons.append(f"{where}: a mujoco tendon has no limit of its pull")
        elif isinstance(load, TorsionSpring) and turning(linkage, load) is None:
            reasons.append(f"{where} needs hinges between its bodies in the mujoco adapter, and there are none")
    return reasons


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
    own, located = own_refusals(linkage), shared_refusals(linkage.scene)
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
