"""Loads and contacts of a linkage by our own force code, for other engines: then dynamics is what is compared.

Contact forces are clipped by the state instead of switched at located events, so a one-step method is of
order 2 where a force starts with a kink, and of order 1 where it jumps.
"""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol, get_args

import numpy as np

from cross_checks.linkage.links import Linkage
from cross_checks.linkage.motion import IN_PLANE, Motion, arrays_of, composed, motion_of, project, rotated
from cross_checks.workshop.method import Refusal
from mbs_ref.cores.choice import compile_scene
from mbs_ref.kernels.border.questions import apply_loads
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.planar.dynamics import load_state as load_planar
from mbs_ref.kernels.spatial.orientation import load_state as load_spatial
from mbs_ref.kernels.spatial.vectors import add, cross, put, symmetric_times
from mbs_ref.scene import Scene
from mbs_ref.scene.celestial import CelestialLoad
from mbs_ref.scene.contact import ConstraintLaw, FloresLaw, LankaraniNikraveshLaw, RigidLaw, StickSlip
from mbs_ref.scene.euler_parameters import from_matrix
from mbs_ref.scene.events import Event
from mbs_ref.scene.joints import Drive, PointOnPlane, RollingWheel, UserConstraint
from mbs_ref.scene.traits import PART_TYPES

SHARED = "loads and contacts come from the shared force code, called through Python"
LOCATED = (RigidLaw, LankaraniNikraveshLaw, FloresLaw, ConstraintLaw, StickSlip)  # need located events
_LACKS = (
    *get_args(CelestialLoad), *get_args(get_args(Event)[0]), *Drive.__subclasses__(), *LOCATED,
    PointOnPlane, RollingWheel, UserConstraint,
)  # fmt: skip
PARTS = frozenset(PART_TYPES) - {part.model_fields["type"].default for part in _LACKS}  # of links and shared forces
MECHANISM = frozenset(
    {"planar", "point_mass", "spatial"}
    | {"revolute", "prismatic", "weld", "distance", "spherical", "cylindrical", "universal"}
)  # bodies and joints, which links stand for


def contact_refusals(scene: Scene) -> list[Refusal]:
    """Return why the scene's contacts need located events, contact by contact."""
    return [
        Refusal(f"contact {c.name!r}: {c.law.type} or its friction needs located events", False)
        for c in scene.contacts
        if isinstance(c.law, LOCATED) or isinstance(c.friction, LOCATED)
    ]


class Core(NamedTuple):
    """Where our force code has a scene's bodies, and what it leaves: forces in an order of its own."""

    angle: np.ndarray  # (n_bodies,) rad at t = 0, of planar bodies
    theta: np.ndarray  # (n_bodies, 4) Euler parameters at t = 0, of spatial bodies
    rigid: np.ndarray  # (n_bodies,) 1.0; 0.0 for particles
    q: np.ndarray  # (n_bodies,) first place of a body in the state
    v: np.ndarray  # (n_bodies + 1,) the same of its velocity, and the state's size
    order: np.ndarray  # (n_bodies,) scene index
    columns: np.ndarray  # (3 or 6,) where the force's entries are among force and torque in space
    force: np.ndarray  # (n_bodies, 3 or 6) N, N m
    inertia: np.ndarray  # (n_bodies, 6) kg m^2, world axes; in space alone
    omega: np.ndarray  # (n_bodies, 3) rad/s; in space alone


@jit
def planar_wrenches(model, work, core, t, motion):
    """Return force and torque (n_bodies, 6) of all loads, contacts and gravity in the plane."""
    y = np.zeros(core.v[-1])
    for b in range(core.rigid.shape[0]):
        q, v = core.q[b], core.v[b]
        y[q], y[q + 1] = motion.position[b, 0], motion.position[b, 1]
        y[v], y[v + 1] = motion.velocity[b, 0], motion.velocity[b, 1]
        y[q + 2] = (core.angle[b] + motion.angle[b]) * core.rigid[b]
        y[v + 2] = motion.omega[b, 2] * core.rigid[b]
    load_planar(model, work, y)
    apply_loads(model, work, t)
    return spread(core)


@jit
def spatial_wrenches(model, work, core, t, motion):
    """Return the same in space; contacts that stick have no deflection."""
    y = np.zeros(core.v[-1])
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
    wrench = spread(core)
    for i, b in enumerate(core.order):
        if core.rigid[b] == 1.0:  # the core counts the gyroscopic torque among its forces
            add(wrench[b], 3, cross(core.omega[i], symmetric_times(core.inertia[i], core.omega[i])))
    return wrench


@jit
def spread(core):
    """Return the core's forces as (n_bodies, 6) in the scene's order; particles bear no torque."""
    wrench = np.zeros((core.order.shape[0], 6))
    for i, b in enumerate(core.order):
        for c in range(core.columns.shape[0]):
            wrench[b, core.columns[c]] = core.force[i, c]
        for c in range(3, 6):
            wrench[b, c] *= core.rigid[b]
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


class Applied:
    """Forces and torques of all loads, contacts and gravity on the bodies of a linkage."""

    def __init__(self, linkage: Linkage) -> None:
        self.tree = arrays_of(linkage)
        self.planar = linkage.scene.dimension == 2
        self.system: Any = compile_scene(linkage.scene)
        start = self.system.initial_state()
        self.system.start_contacts(0.0, start, located=False)
        bodies, kinematics, n = self.system.groups.bodies, self.system.scratch.kinematics, len(linkage.links)
        places = np.full((2, n + 1), len(start))
        places[:, bodies.scene_index] = (
            (3 * bodies.scene_index, 3 * (n + bodies.scene_index)) if self.planar else (bodies.q, bodies.v)
        )
        gyroscopic = (np.zeros((0, 6)), np.zeros((0, 3))) if self.planar else (kinematics.inertia, kinematics.omega)
        self.core = Core(
            linkage.angle, linkage.theta, linkage.rigid, *places, bodies.scene_index,
            np.array(IN_PLANE if self.planar else range(6)), kinematics.force, *gyroscopic,
        )  # fmt: skip

    def wrenches(self, t: float, motion: Motion) -> np.ndarray:
        """Return force (N) and torque about the centre of mass (N m), (n_bodies, 6), world axes."""
        self.system.set_mode_time(t)
        evaluate = planar_wrenches if self.planar else spatial_wrenches
        return evaluate(self.system.model, self.system.work, self.core, t, motion)

    def in_plane(self, t: float, pose: np.ndarray, rate: np.ndarray) -> np.ndarray:
        """Return the forces (n_bodies, 3) of planar poses and velocities (n_bodies, 3): N, N, N m."""
        none, turn = np.zeros(len(pose)), pose[:, 2] - self.core.angle
        place, speed = np.column_stack((pose[:, :2], none)), np.column_stack((rate[:, :2], none))
        motion = Motion(place, self.core.theta, speed, np.column_stack((none, none, rate[:, 2])), turn)
        return self.wrenches(t, motion)[:, IN_PLANE]

    def generalized(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the generalized forces (n_v,) of the linkage's coordinates and rates (see `motion_of`)."""
        self.system.set_mode_time(t)
        evaluate = planar_generalized if self.planar else spatial_generalized
        return evaluate(self.system.model, self.system.work, self.core, self.tree, t, q, v)


def applied(linkage: Linkage) -> Applied | None:
    """Return what acts besides gravity, gravity included; None where gravity is all."""
    return Applied(linkage) if linkage.loaded else None


class Reader(Protocol):
    """What an engine's state says of the links, in the scene's order of bodies."""

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
