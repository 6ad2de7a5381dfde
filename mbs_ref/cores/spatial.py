"""A spatial scene compiled: its arrays, Euler parameters, joint rows, reactions; callable from Python."""

from functools import cached_property
from typing import Any

import numpy as np
import scipy

from mbs_ref.cores.builder import Builder, assembled, ends, forces, torsion_springs
from mbs_ref.cores.jointed_system import JointedSystem
from mbs_ref.cores.system import Poses
from mbs_ref.cores.user_rows import variable
from mbs_ref.kernels.border.groups import absent, floats, ints
from mbs_ref.kernels.rigid.model import TorsionSprings, rigid_scratch
from mbs_ref.kernels.spatial import model as arrays
from mbs_ref.kernels.spatial.model import SpatialScratch
from mbs_ref.kernels.spatial.orientation import write_poses
from mbs_ref.scene import Bushing, Scene, SpatialBody, TorsionSpring, symmetric
from mbs_ref.scene.base.part import normals
from mbs_ref.scene.base.taylor import Taylor
from mbs_ref.scene.celestial import CelestialPart, Epoch, GravityGradient, Newton, at_most_one
from mbs_ref.scene.euler_parameters import conjugate, parameter_matrix, rotated
from mbs_ref.scene.joints import SpatialPlace
from mbs_ref.scene.scales import Scales
from mbs_ref.scene.traits import deflecting

_HELD_INERTIA = (1.0, 1.0, 1.0, 0.0, 0.0, 0.0)  # kg m^2 in the idle block of a point mass: nothing ever turns it


class _Builder(Builder):
    """Spatial bodies, joints and loads."""

    def groups(self) -> Any:
        rigid = np.array([isinstance(b, SpatialBody) for b in self.scene.bodies], dtype=int)
        inertia = [b.inertia if isinstance(b, SpatialBody) else _HELD_INERTIA for b in self.scene.bodies]
        own = {
            "forces": forces(self), "torsion_springs": _torsion_springs(self), "bushings": _bushings(self),
            "attraction": _attraction(self), "gradients": _gradients(self),
        }  # fmt: skip
        widths = np.array((3 + 4 * rigid, 3 + 3 * rigid))
        return assembled(self, arrays.SpatialGroups, widths, floats(inertia, 6), **own)


def _torsion_springs(build: _Builder) -> TorsionSprings:
    loads = [x for x in build.scene.loads if isinstance(x, TorsionSpring)]
    if not loads:
        return absent(TorsionSprings)
    (zero, quarter), a = zip(*(normals(x.axis) for x in loads), strict=True), [x.body_a for x in loads]
    return torsion_springs(
        build,
        lambda load: load.rest_angle or 0.0,
        zero=build.directions(a, zero),
        quarter=build.directions(a, quarter),
        mark=build.directions([x.body_b for x in loads], zero),
    )


def _bushings(build: _Builder) -> arrays.Bushings:
    loads = [x for x in build.scene.loads if isinstance(x, Bushing)]
    if not loads:
        return absent(arrays.Bushings)
    names, frames = [[x.ends[k] for x in loads] for k in range(2)], np.array([x.frames for x in loads])
    point_a, point_b = (build.points(names[k], [x.marks[k] for x in loads]) for k in range(2))
    axes_a, axes_b = (build.turns(names[k]) @ frames[:, k] for k in range(2))
    stiffness, damping = floats([x.stiffness for x in loads], 6), floats([x.damping for x in loads], 6)
    return arrays.Bushings(*ends(build, loads), point_a, point_b, axes_a, axes_b, stiffness, damping)


def _attraction(build: _Builder) -> arrays.Attraction:
    """Return Newton's gm in elimination order; ValueError where a load acts on scenes of particles alone."""
    known = (Newton, Epoch, GravityGradient)
    others = [x.name for x in build.scene.loads if isinstance(x, CelestialPart) and not isinstance(x, known)]
    newton = at_most_one([x for x in build.scene.loads if isinstance(x, Newton)])
    if others:
        raise ValueError(
            f"loads {', '.join(others)} act in scenes of free point masses alone; rigid bodies know newton "
            "and gravity_gradient"
        )
    if newton and len(newton.gm) != build.n:
        raise ValueError(f"load {newton.name!r}: gm needs {build.n} entries, one a body; got {len(newton.gm)}")
    return arrays.Attraction(floats(newton.gm[i] for i in build.layout.order) if newton else np.zeros(0))


def _gradients(build: _Builder) -> arrays.Gradients:
    loads = [x for x in build.scene.loads if isinstance(x, GravityGradient)]
    if not loads:
        return absent(arrays.Gradients)
    planet, body = (ints([build.body(getattr(x, end)) for x in loads]) for end in ("planet", "body"))
    return arrays.Gradients(planet, body, floats(x.gm for x in loads))


RANK_POSES = 3  # random poses, besides the first, in which the rank of the loops is looked at
RANK_STEP = 0.05  # m, rad: how far they are from the first
INDEPENDENT = 1e-8  # relative pivot: above roundoff, 1e-12, and below what RANK_STEP away from a singular pose has
PROJECTED = 1e-11  # m, rad: a pose off the constraints by more tells nothing about ranks


def _after(first: np.ndarray, count: int) -> np.ndarray:
    """Return `count` places (n, count) from each first one (n,) on."""
    return first[:, None] + np.arange(count)


class SpatialSystem(JointedSystem):
    """A spatial scene as arrays and compiled functions.

    State y = concatenate(q, u, s) in scene order; a rigid body has q = R, theta0..theta3 (m, 1) and
    u = R', omega (m/s, rad/s, omega in body axes), a point mass q = R and u = R'. s holds the two deflections (m)
    of every contact that can stick.
    """

    CORE, BUILDER = "spatial", _Builder
    RATES, SHARED = 6, 7

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.groups.loops.most[:] = self._closure_ranks()

    def _new_scratch(self) -> Any:
        groups = self.groups
        sticking, slots, n = len(deflecting(self.scene)), len(groups.slots.body), self.n_bodies
        state = int(groups.bodies.start[0]) + 3 * (n + len(self.rigid)) + 2 * sticking
        scratch = rigid_scratch(SpatialScratch, n, slots, state, groups.loops, rates=6, n_sticking=sticking)
        scratch.kinematics.turned[:] = np.eye(3)
        scratch.kinematics.inertia[:n] = groups.bodies.inertia
        return scratch

    def initial_state(self) -> np.ndarray:
        return self._start.copy()

    @cached_property
    def _start(self) -> np.ndarray:
        """y at t = 0."""
        q, u = list[float](), list[float]()
        for body, axes in zip(self.scene.bodies, self.builder.axes[:-1], strict=True):
            q += body.position
            u += body.velocity
            if isinstance(body, SpatialBody):
                q += (np.array(body.orientation) / np.linalg.norm(body.orientation)).tolist()
                u += (axes.T @ body.angular_velocity).tolist()
        return np.concatenate((q, u, np.zeros(2 * len(deflecting(self.scene)))))

    @staticmethod
    def state_units(scene: Scene, scales: Scales) -> np.ndarray:
        """Return L for places and deflections, 1 for Euler parameters, L / T and 1 rad / T for rates (n_state,)."""
        length = [scales.length]
        rigid = [isinstance(body, SpatialBody) for body in scene.bodies]
        q = [unit for turns in rigid for unit in 3 * length + turns * 4 * [1.0]]
        u = [unit for turns in rigid for unit in 3 * length + turns * 3 * [1.0]]
        return np.concatenate((q, np.divide(u, scales.time), 2 * len(deflecting(scene)) * length))

    @cached_property
    def rigid(self) -> np.ndarray:
        """Scene indices of the rigid bodies."""
        return np.array([k for k, b in enumerate(self.scene.bodies) if isinstance(b, SpatialBody)], dtype=int)

    def _closure_ranks(self) -> np.ndarray:
        """Return how many rows of each closure are independent at the pose, near the first, where most are.

        A contact's closure has one row, while it is closed.
        """
        loops = self.groups.loops
        of_contact = np.isin(loops.slot, self.groups.contact_laws.slot)
        if of_contact.all():
            return loops.count
        y = self.initial_state()
        self.project(0.0, y, 1e-14, 50)
        best = self._ranks_at(y)
        generator = np.random.default_rng(0)
        for _ in range(RANK_POSES):
            near = self._moved(y, generator.standard_normal(len(y)))
            if self.project(0.0, near, 1e-14, 50) < PROJECTED:
                best = max(best, self._ranks_at(near), key=np.sum)
        return np.where(of_contact, loops.count, best)

    def _ranks_at(self, y: np.ndarray) -> np.ndarray:
        """Return how many pivots of each closure stand out from roundoff."""
        self.derivative(0.0, y)
        closures = self.scratch.closures
        found = np.arange(self.RATES) < closures.rank[:, None]
        scale = np.take_along_axis(closures.scale, closures.order, axis=1)
        return np.sum(closures.inverse * scale * INDEPENDENT < 1.0, axis=1, where=found)

    def _moved(self, y: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Return y moved along the constraints by about RANK_STEP in the direction of x."""
        self.derivative(0.0, y)
        x, moved = self.along_constraints(x), y.copy()
        moved[: self.n_positions] += RANK_STEP / max(1e-12, np.abs(x).max()) * x[: self.n_positions]
        return moved

    def steady_course(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return X y and the matrix of X: R' stays, theta' = theta (0, omega) / 2, omega' = -omega(0) x omega."""
        course, matrix = super().steady_course(y)
        for q, v, rigid in zip(self.groups.bodies.q, self.groups.bodies.v, self.groups.bodies.rigid, strict=True):
            if rigid:
                x, z, w = y[v + 3 : v + 6]
                spin = np.array(((0.0, -w, z), (w, 0.0, -x), (-z, x, 0.0)))
                matrix[v + 3 : v + 6, v + 3 : v + 6] = -spin
                matrix[q + 3, q + 4 : q + 7] = -0.5 * y[v + 3 : v + 6]
                matrix[q + 4 : q + 7, q + 3] = 0.5 * y[v + 3 : v + 6]
                matrix[q + 4 : q + 7, q + 4 : q + 7] = -0.5 * spin
        return course, matrix

    def norms(self, y: np.ndarray) -> np.ndarray:
        bodies = self.groups.bodies
        return np.array([y[q + 3 : q + 7] @ y[q + 3 : q + 7] for q in bodies.q[bodies.rigid == 1]])

    def orientations(self, states: np.ndarray) -> np.ndarray:
        bodies, theta = self.groups.bodies, np.zeros((len(states), self.n_bodies, 4))
        turns = bodies.rigid == 1
        theta[:, :, 0] = 1.0
        theta[:, bodies.scene_index[turns]] = states[:, _after(bodies.q[turns] + 3, 4)]
        return theta

    def poses(self, states: np.ndarray) -> Poses:
        poses = Poses(*(np.empty((len(states), self.n_bodies, count)) for count in (3, 4, 3, 3)))
        write_poses(self.groups.bodies, np.ascontiguousarray(states), *poses)
        return poses

    def states_of(self, poses: Poses) -> np.ndarray:
        # nothing has slipped yet
        bodies, count = self.groups.bodies, len(poses.position)
        states = np.zeros((count, len(self.initial_state())))
        order, turns = bodies.scene_index, bodies.rigid == 1
        states[:, _after(bodies.q, 3)] = poses.position[:, order]
        states[:, _after(bodies.v, 3)] = poses.velocity[:, order]
        own, q, v = order[turns], bodies.q[turns] + 3, bodies.v[turns] + 3
        theta, omega = poses.orientation[:, own], poses.angular_velocity.take(own, axis=1)
        states[:, _after(q, 4)] = theta
        states[:, _after(v, 3)] = rotated(conjugate(theta), omega)
        return states

    def mass_matrix(self) -> np.ndarray:
        inertia = self._in_scene_order(self.scratch.kinematics.inertia[: self.n_bodies])
        result = np.zeros((6 * self.n_bodies, 6 * self.n_bodies))
        for k, body in enumerate(self.scene.bodies):
            result[6 * k : 6 * k + 3, 6 * k : 6 * k + 3] = body.mass * np.eye(3)
            result[6 * k + 3 : 6 * k + 6, 6 * k + 3 : 6 * k + 6] = symmetric(tuple(inertia[k]))
        return result

    def independent_rows(self, t: float, y: np.ndarray) -> np.ndarray:
        every = len(self.rows())
        if not self.n_spare_rows:
            return np.arange(every)
        order = scipy.linalg.qr(self.scaled_jacobian(t, y).T, mode="r", pivoting=True)[-1]
        return np.sort(order[: every - self.n_spare_rows])

    def accelerations(self, t: float, y: np.ndarray) -> np.ndarray:
        self.derivative(t, y)
        return self._in_scene_order(self.scratch.tree.acceleration[: self.n_bodies])

    def rank(self, t: float, y: np.ndarray) -> int:
        """Return the rank of C_q, the norm rows of the Euler parameters included."""
        return super().rank(t, y) + len(self.rigid)

    @property
    def n_constraints(self) -> int:
        """Joint rows and one norm row a rigid body."""
        return super().n_constraints + len(self.rigid)

    def _coordinates(self, body: int, arm: np.ndarray, size: int, first: int) -> SpatialPlace:
        kin, held = self.scratch.kinematics, body == self.n_bodies
        rates = kin.velocity[body]
        centre = [variable(kin.position[body, c], rates[c], 0.0, size, None if held else first + c) for c in range(3)]
        theta = self._parameters(body, size, first + 3)
        e0, e1, e2, e3 = theta
        x, y, z = arm
        turned = (
            x * (1.0 - 2.0 * (e2 * e2 + e3 * e3)) + 2.0 * (y * (e1 * e2 - e0 * e3) + z * (e1 * e3 + e0 * e2)),
            y * (1.0 - 2.0 * (e1 * e1 + e3 * e3)) + 2.0 * (x * (e1 * e2 + e0 * e3) + z * (e2 * e3 - e0 * e1)),
            z * (1.0 - 2.0 * (e1 * e1 + e2 * e2)) + 2.0 * (x * (e1 * e3 - e0 * e2) + y * (e2 * e3 + e0 * e1)),
        )
        return SpatialPlace(*(place + offset for place, offset in zip(centre, turned, strict=True)), *theta)

    def _parameters(self, body: int, size: int, first: int) -> list[Taylor]:
        """Return the Euler parameters: theta' = E^T omega / 2 and, at steady omega, theta'' = -|omega|^2 theta / 4."""
        if body == self.n_bodies or not self.groups.bodies.rigid[body]:
            return [variable(value, 0.0, 0.0, size, None) for value in (1.0, 0.0, 0.0, 0.0)]
        kin = self.scratch.kinematics
        omega, theta = kin.omega[body], kin.theta[body] / np.linalg.norm(kin.theta[body])
        turning = 0.5 * parameter_matrix(theta)
        first_rates = np.zeros((4, size))
        first_rates[:, 0] = omega @ turning
        first_rates[:, first : first + 3] = turning.T
        second = -0.25 * float(omega @ omega) * theta
        return [Taylor(float(theta[k]), first_rates[k], float(second[k])) for k in range(4)]

    @staticmethod
    def turned(turns: np.ndarray, arms: np.ndarray) -> np.ndarray:
        return rotated(turns, arms)

    @staticmethod
    def _about(arms: np.ndarray, forces: np.ndarray) -> np.ndarray:
        (x, y, z), (a, b, c) = np.moveaxis(arms, -1, 0), np.moveaxis(forces[..., :3], -1, 0)
        for k, moment in enumerate((y * c - z * b, z * a - x * c, x * b - y * a)):
            forces[..., 3 + k] -= moment
        return forces
