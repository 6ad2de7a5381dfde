"""Engines of minimal coordinates: their base class, and loads and contacts of a linkage by our own force code.

Contact forces are clipped by the state instead of switched at located events, so a one-step method is of
order 2 where a force starts with a kink, and of order 1 where it jumps.
"""

from typing import Any, ClassVar, NamedTuple, Protocol, get_args

import numpy as np

from cross_checks.engine import Engine, Plan, Poses, Refusal
from cross_checks.linkage.links import Linkage, closure_refusals
from cross_checks.linkage.motion import Motion, arrays_of, composed, motion_of, poses_of, project, rotated
from mbs_ref import Scene
from mbs_ref.cores.choice import compile_scene
from mbs_ref.kernels.border.questions import apply_loads
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.planar.dynamics import load_state as load_planar
from mbs_ref.kernels.spatial.marks import cross, plus, put, symmetric_times, triple
from mbs_ref.kernels.spatial.orientation import load_state as load_spatial
from mbs_ref.scene.celestial import CelestialLoad, Epoch, GravityGradient, Newton
from mbs_ref.scene.contact import ConstraintLaw, FloresLaw, LankaraniNikraveshLaw, RigidLaw, StickSlip
from mbs_ref.scene.euler_parameters import from_matrix
from mbs_ref.scene.events import Event
from mbs_ref.scene.joints import Drive, PointOnPlane, RollingWheel, UserConstraint
from mbs_ref.scene.scales import is_celestial
from mbs_ref.scene.traits import PART_TYPES

BY_SHARED_CODE = "come from the shared force code, called through Python"
SHARED = f"loads and contacts {BY_SHARED_CODE}"
LOCATED = (RigidLaw, LankaraniNikraveshLaw, FloresLaw, ConstraintLaw, StickSlip)  # need located events
RIGID_SKY = (Newton, GravityGradient, Epoch)  # what acts on rigid bodies, too
_LACKS = (
    *(set(get_args(CelestialLoad)) - set(RIGID_SKY)), *get_args(get_args(Event)[0]), *Drive.__subclasses__(), *LOCATED,
    PointOnPlane, RollingWheel, UserConstraint,
)  # fmt: skip
PARTS = frozenset(PART_TYPES) - {part.model_fields["type"].default for part in _LACKS}  # of links and shared forces
MECHANISM = frozenset(
    {"planar", "point_mass", "spatial"}
    | {"revolute", "prismatic", "weld", "distance", "spherical", "cylindrical", "universal"}
)  # bodies and joints, which links stand for


def shared_refusals(scene: Scene) -> list[Refusal]:
    """Return why the shared force code cannot act on a scene: free particles, and contacts that need located events."""
    sky = sorted({load.type for load in scene.loads if isinstance(load, RIGID_SKY)}) if is_celestial(scene) else []
    return [
        Refusal(f"part type {kind!r}: shared forces act on rigid bodies, and this scene has particles alone", False)
        for kind in sky
    ] + [
        Refusal(f"contact {c.name!r}: {c.law.type} or its friction needs located events", False)
        for c in scene.contacts
        if isinstance(c.law, LOCATED) or isinstance(c.friction, LOCATED)
    ]


class Core(NamedTuple):
    """Where our force code has a scene's bodies, and what it leaves: forces in an order of its own."""

    angle: np.ndarray  # (n_bodies,) rad at t = 0, of planar bodies
    theta: np.ndarray  # (n_bodies, 4) Euler parameters at t = 0, of spatial bodies
    rigid: np.ndarray  # (n_bodies,) 1.0; 0.0 for particles, which transmit no torque
    order: np.ndarray  # (n_bodies,) scene index
    force: np.ndarray  # (n_bodies, 3 or 6) N, N m
    q: np.ndarray  # (n_bodies,) first place of a body in the state; in space alone, as all that follow
    v: np.ndarray  # (n_bodies + 1,) the same of its velocity, and the state's size
    inertia: np.ndarray  # (n_bodies, 6) kg m^2, world axes
    omega: np.ndarray  # (n_bodies, 3) rad/s


@jit
def planar_wrenches(model, work, core, t, motion):
    """Return force and torque (n_bodies, 6) of all loads, contacts and gravity in the plane."""
    pose, rate, wrench = motion.position.copy(), motion.velocity.copy(), np.zeros((core.rigid.shape[0], 6))
    pose[:, 2] = (core.angle + motion.angle) * core.rigid
    rate[:, 2] = motion.omega[:, 2] * core.rigid
    load_planar(model, work, np.concatenate((pose.ravel(), rate.ravel())))
    apply_loads(model, work, t)
    for i, b in enumerate(core.order):
        wrench[b, 0], wrench[b, 1], wrench[b, 5] = core.force[i, 0], core.force[i, 1], core.force[i, 2] * core.rigid[b]
    return wrench


@jit
def spatial_wrenches(model, work, core, t, motion):
    """Return the same in space; contacts that stick have no deflection."""
    y, wrench = np.zeros(core.v[-1]), np.zeros((core.rigid.shape[0], 6))
    for b in range(core.rigid.shape[0]):
        q, v = core.q[b], core.v[b]
        put(y, q, motion.position[b])
        put(y, v, motion.velocity[b])
        if core.rigid[b] == 1.0:
            theta = composed(motion.turn[b], core.theta[b])
            y[q + 3], y[q + 4], y[q + 5], y[q + 6] = theta
            put(y, v + 3, rotated((theta[0], -theta[1], -theta[2], -theta[3]), motion.omega[b]))
    load_spatial(model, work, y)
    apply_loads(model, work, t)
    for i, b in enumerate(core.order):
        put(wrench[b], 0, core.force[i])
        if core.rigid[b] == 1.0:  # the core counts the gyroscopic torque among its forces
            gyroscopic = cross(core.omega[i], symmetric_times(core.inertia[i], core.omega[i]))
            put(wrench[b], 3, plus(triple(core.force[i], 3), gyroscopic))
    return wrench


@jit
def planar_generalized(model, work, core, tree, t, q, v):
    """Return the generalized forces (n_v,) of a planar linkage's coordinates and rates."""
    motion, axes = motion_of(tree, q, v)
    return project(tree, motion, axes, planar_wrenches(model, work, core, t, motion))


@jit
def spatial_generalized(model, work, core, tree, t, q, v):
    """Return the same of a spatial linkage."""
    motion, axes = motion_of(tree, q, v)
    return project(tree, motion, axes, spatial_wrenches(model, work, core, t, motion))


@jit
def planar_at_poses(model, work, core, t, pose, rate):
    """Return the generalized forces (n, n_bodies, 3) of n states of a planar scene, as `Applied.at_poses`."""
    out, bodies = np.empty(pose.shape), pose.shape[1]
    still, turning = np.zeros((bodies, 4)), np.zeros((bodies, 3))
    for k in range(pose.shape[0]):
        turning[:, 2] = rate[k, :, 2]
        motion = Motion(pose[k], still, rate[k], turning, pose[k, :, 2] - core.angle)
        wrench = planar_wrenches(model, work, core, t, motion)
        out[k, :, :2], out[k, :, 2] = wrench[:, :2], wrench[:, 5]
    return out


@jit
def spatial_at_poses(model, work, core, t, pose, rate):
    """Return the same (n, n_bodies, 7) in space: omega is 2 theta' conj(theta), and 2 torque theta acts on theta."""
    out, bodies, angle = np.empty(pose.shape), pose.shape[1], np.zeros(pose.shape[1])
    turn, omega = np.empty((bodies, 4)), np.empty((bodies, 3))
    for k in range(pose.shape[0]):
        for b in range(bodies):
            theta, still = pose[k, b, 3:], core.theta[b]
            unit = theta / np.sqrt(np.sum(theta**2))
            turned = composed(unit, (still[0], -still[1], -still[2], -still[3]))
            spin = composed(rate[k, b, 3:], (theta[0], -theta[1], -theta[2], -theta[3]))
            turn[b, 0], turn[b, 1], turn[b, 2], turn[b, 3] = turned
            omega[b, 0], omega[b, 1], omega[b, 2] = 2.0 * spin[1], 2.0 * spin[2], 2.0 * spin[3]
        motion = Motion(pose[k, :, :3].copy(), turn, rate[k, :, :3].copy(), omega, angle)
        wrench = spatial_wrenches(model, work, core, t, motion)
        for b in range(bodies):
            push = composed((0.0, wrench[b, 3], wrench[b, 4], wrench[b, 5]), pose[k, b, 3:])
            out[k, b, :3] = wrench[b, :3]
            for c in range(4):
                out[k, b, 3 + c] = 2.0 * push[c]
    return out


# by dimension: forces and torques, the same of linkages' coordinates, and of bodies' own
CODE = {
    2: (planar_wrenches, planar_generalized, planar_at_poses),
    3: (spatial_wrenches, spatial_generalized, spatial_at_poses),
}


class Applied:
    """Forces and torques of all loads, contacts and gravity on the bodies of a linkage."""

    def __init__(self, linkage: Linkage) -> None:
        self.tree = arrays_of(linkage)
        self.evaluate, self.project, self.place = CODE[linkage.scene.dimension]
        self.system: Any = compile_scene(linkage.scene)
        start = self.system.initial_state()
        self.system.start_contacts(0.0, start, located=False)
        bodies, kinematics = self.system.groups.bodies, self.system.scratch.kinematics
        places = np.full((2, len(linkage.links) + 1), len(start))
        places[:, bodies.scene_index] = bodies.q, bodies.v
        gyroscopic = getattr(kinematics, "inertia", np.zeros((0, 6))), getattr(kinematics, "omega", np.zeros((0, 3)))
        start = linkage.angle, linkage.theta, linkage.rigid
        self.core = Core(*start, bodies.scene_index, kinematics.force, places[0], places[1], *gyroscopic)

    def wrenches(self, t: float, motion: Motion) -> np.ndarray:
        """Return force (N) and torque about the centre of mass (N m), (n_bodies, 6), world axes."""
        self.system.set_mode_time(t)
        return self.evaluate(*self.system.own_handles, self.core, t, motion)

    def at_poses(self, t: float, pose: np.ndarray, rate: np.ndarray) -> np.ndarray:
        """Return the generalized forces (N, N m) of places and of angles or Euler parameters, and of their rates.

        All are (n, n_bodies, 3) in the plane and (n, n_bodies, 7) in space, of n states at one time (s).
        """
        self.system.set_mode_time(t)
        return self.place(*self.system.own_handles, self.core, t, pose, rate)

    def generalized(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the generalized forces (n_v,) of the linkage's coordinates and rates (see `motion_of`)."""
        self.system.set_mode_time(t)
        return self.project(*self.system.own_handles, self.core, self.tree, t, q, v)


def applied(linkage: Linkage) -> Applied | None:
    """Return what acts besides gravity, gravity included; None where gravity is all."""
    return Applied(linkage) if linkage.loaded else None


class Reader(Protocol):
    """Read links' coordinates and frames from an engine's state, in the scene's order of bodies."""

    def coordinates(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return coordinates and rates of a planar scene's freedoms, each (n_v,)."""
        ...

    def frames(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return turns since t = 0 (n, 3, 3), centres of mass (n, 3), their velocities, and angular velocities."""
        ...


def read(linkage: Linkage, reader: Reader, state: np.ndarray) -> Motion:
    """Return the motion of an engine's state; turns are NaN where a matrix is not finite."""
    matrices, position, velocity, omega = (np.array(part) for part in reader.frames(state))
    turn = np.array([from_matrix(m) if np.isfinite(m).all() else np.full(4, np.nan) for m in matrices])
    return Motion(position, turn, velocity, omega, linkage.turned(reader.coordinates(state)[0]))


class LinkageEngine(Engine):
    """An engine whose model has a `linkage`, a `reader` of its states, and `applied` forces or None."""

    lacks: ClassVar[frozenset[str]] = frozenset()  # parts of links and shared forces that it cannot represent
    extra: ClassVar[frozenset[str]] = frozenset()  # parts that its own elements represent
    closes: ClassVar[frozenset[str]] = frozenset()  # kinds of closures that it represents (see Closure.kind)
    takes_loads: ClassVar[bool] = True  # whether forces from the shared force code can be applied

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        cls.part_types = (PARTS if cls.takes_loads else MECHANISM) - cls.lacks | cls.extra

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        return closure_refusals(self.name, scene, self.closes) + shared_refusals(scene)

    def poses(self, model: Any, plan: Plan, states: np.ndarray) -> Poses:
        return poses_of(model.linkage, (read(model.linkage, model.reader, state) for state in states))

    def notes(self, model: Any, plan: Plan) -> tuple[str, ...]:
        return (SHARED,) if model.applied else ()
