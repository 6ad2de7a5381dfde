"""The augmented system from the shared judge alone, whole and dense: an oracle apart from every compiled kernel.

The judge gives C_dot and the rates of springs from world poses and velocities, and both are linear in the
velocities: unit velocities give C_q and the directions of forces without any differencing. Only gamma and a
bushing's gradient are differenced, along a motion without acceleration, by a stencil of order 8.
Coordinates are x, y, theta of a planar body and (R', omega) in world axes in space, a particle's own alone.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from cross_checks.engine.plan import initial_sample
from mbs_ref import Trajectory, observables
from mbs_ref import scene as parts
from mbs_ref.observables.attachment import Motion, bushing_strain, gap_of, length_of, twist_of
from mbs_ref.scene import GROUND, PointMass, Scene, SpatialBody
from mbs_ref.scene.euler_parameters import from_axis_angle, product, rotation_matrices
from mbs_ref.scene.scene import with_rates
from mbs_ref.scene.signals import values

STENCIL = ((1, 4 / 5), (2, -1 / 5), (3, 4 / 105), (4, -1 / 280))  # first derivative, order 8 (Fornberg 1988)
# m or rad in a step of the stencil, at rates (m/s, rad/s) of at least SLOWEST. With h the step in s the error is
# (h omega)^8 / 630 of a turn, and up to (h v / L)^8 9! / 630 of a rod L whose ends pass each other at v: roundoff is
# 1e-13, and fast rods reach 1e-11. Extended precision has room for a step 5 times shorter, an error 4e5 times less.
REACH, SHORT_REACH, SLOWEST = 5e-3, 1e-3, 5.0
CUTOFF = 1e-9  # of the largest singular value of the scaled C_q: below is a redundant row
AUGMENTED_CUTOFF = 1e-13  # of the augmented matrix, whose small singular values are the squares of those of C_q


@dataclass(frozen=True)
class Solution:
    """The result of the dense solve; `condition` is that of the scaled C_q over its nonzero singular values."""

    acceleration: np.ndarray  # (n_bodies, width) m/s^2, rad/s^2; zero where a particle has no coordinate
    wrenches: dict[str, np.ndarray]  # joint -> force and torque on its last body at the joint's mark: N, N m
    condition: float
    redundant: int  # rows


@dataclass(frozen=True)
class Moment:
    """A scene at one pose, with its velocities."""

    scene: Scene
    time: float  # s
    position: np.ndarray  # (n, dimension) m
    orientation: np.ndarray  # (n,) rad, or (n, 4) Euler parameters
    rate: np.ndarray  # (n, width) m/s, rad/s; width 3 in the plane and 6 in space

    @staticmethod
    def of(scene: Scene, path: Trajectory, sample: int) -> "Moment":
        """Return a sample of a trajectory."""
        spin = path.angular_velocity[sample].reshape(len(scene.bodies), -1)
        rate = np.concatenate((path.velocity[sample], spin), axis=1)
        return Moment(scene, float(path.times[sample]), path.position[sample], path.orientation[sample], rate)

    @staticmethod
    def start(scene: Scene) -> "Moment":
        """Return the scene at t = 0."""
        return Moment.of(scene, initial_sample(scene), 0)

    @property
    def planar(self) -> bool:
        return self.orientation.ndim == 1

    @cached_property
    def used(self) -> np.ndarray:
        """Which entries of `rate` are coordinates (n, width)."""
        used = np.ones(self.rate.shape, dtype=bool)
        for k, body in enumerate(self.scene.bodies):
            if isinstance(body, PointMass):
                used[k, self.scene.dimension :] = False
        return used

    def with_rates(self, rates: np.ndarray) -> Motion:
        """Return a motion with a sample of this pose for each row of rates (k, n_coordinates)."""
        full = np.zeros((len(rates), *self.rate.shape), dtype=self.rate.dtype)
        full[:, self.used] = rates
        return self._path(self.time * np.ones(len(rates)), full, np.zeros(len(rates)), full[:1])

    def moved(self, rate: np.ndarray) -> Motion:
        """Return samples of moving on at a steady rate for the times of the stencil, at that rate."""
        full = np.zeros((1, *self.rate.shape), dtype=self.rate.dtype)
        full[0, self.used] = rate
        steps = self.span(rate) * np.array([sign * k for k, _ in STENCIL for sign in (1.0, -1.0)])
        return self._path(self.time + steps, np.repeat(full, len(steps), axis=0), steps, full)

    def displaced(self, step: np.ndarray) -> "Moment":
        """Return the moment with its pose moved and turned by a step (n_coordinates,), m and rad."""
        full = np.zeros((1, *self.rate.shape), dtype=self.rate.dtype)
        full[0, self.used] = step
        path = self._path(np.zeros(1), full, np.ones(1), full).trajectory
        return replace(self, position=path.position[0], orientation=path.orientation[0])

    def span(self, rate: np.ndarray) -> float:
        """Return the stencil's step (s) for a motion at that rate."""
        reach = REACH if self.rate.dtype == np.float64 else SHORT_REACH
        return reach / max(SLOWEST, float(np.abs(rate).max(initial=0.0)))

    def _path(self, times: np.ndarray, rates: np.ndarray, steps: np.ndarray, course: np.ndarray) -> Motion:
        dimension = self.scene.dimension
        linear, angular = rates[:, :, :dimension], rates[:, :, dimension:]
        position = self.position + steps[:, None, None] * course[:, :, :dimension]
        if self.planar:
            orientation = self.orientation + steps[:, None] * course[:, :, 2]
            return Motion(self.scene, Trajectory(times, position, orientation, linear, angular[:, :, 0]))
        orientation = _turned(self.orientation, course[0, :, 3:], steps)
        return Motion(self.scene, Trajectory(times, position, orientation, linear, angular))


def _turned(theta: np.ndarray, omega: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Return orientations (n_steps, n, 4) after turning from theta (n, 4) at omega (n, 3) for each of the steps."""
    return np.stack([_turned_one(e, w, steps) for e, w in zip(theta, omega, strict=True)], axis=1)


def _turned_one(theta: np.ndarray, omega: np.ndarray, steps: np.ndarray) -> np.ndarray:
    angles = np.linalg.norm(omega) * steps
    return product(from_axis_angle(omega, angles), theta) if angles.any() else np.broadcast_to(theta, (len(steps), 4))


def _derivative(samples: np.ndarray, span: float) -> np.ndarray:
    """Return d/ds at s = 0 of samples taken along the stencil (8, ...) with steps of `span`."""
    pairs = samples.reshape(len(STENCIL), 2, *samples.shape[1:])
    weights = np.array([weight for _, weight in STENCIL])
    return np.tensordot(weights, pairs[:, 0] - pairs[:, 1], axes=1) / span


@dataclass(frozen=True)
class Augmented:
    """M a + C_q^T lambda = Q and C_q a = gamma at one moment."""

    moment: Moment
    mass: np.ndarray  # (n_q, n_q)
    jacobian: np.ndarray  # (n_rows, n_q)
    force: np.ndarray  # (n_q,)
    gamma: np.ndarray  # (n_rows,)
    drift: np.ndarray  # (n_rows,) C_t
    joints: tuple[str, ...]  # (n_rows,)

    @cached_property
    def scaled(self) -> np.ndarray:
        """C_q L^-T with M = L L^T, each row at length one: metres, radians and masses drop out."""
        return np.linalg.solve(self.root, self.jacobian.T).T / self.row_scale[:, None]

    @cached_property
    def root(self) -> np.ndarray:
        return np.linalg.cholesky(self.mass)

    @cached_property
    def row_scale(self) -> np.ndarray:
        return np.linalg.norm(np.linalg.solve(self.root, self.jacobian.T), axis=0)

    @cached_property
    def kept(self) -> np.ndarray:
        """The singular values of independent rows."""
        if not len(self.gamma):
            return np.ones(1)
        singular_values = np.linalg.svd(self.scaled, compute_uv=False)
        return singular_values[singular_values > CUTOFF * singular_values[0]]

    @property
    def redundant(self) -> int:
        """Rows that others imply."""
        return len(self.gamma) - len(self.kept) if len(self.gamma) else 0

    @property
    def condition(self) -> float:
        return float(self.kept[0] / self.kept[-1])

    def consistent_rates(self) -> np.ndarray:
        """Return the velocities nearest in the mass norm that keep every row: C_q v = -C_t."""
        v = self.moment.rate[self.moment.used]
        if not len(self.gamma):
            return v
        gap = (self.jacobian @ v + self.drift) / self.row_scale
        step = np.linalg.lstsq(self.scaled, gap, rcond=CUTOFF)[0]
        return v - np.linalg.solve(self.root.T, step)

    def solve(self) -> Solution:
        """Factor the whole augmented matrix, scaled by the masses, through its singular values."""
        size, rows = len(self.force), len(self.gamma)
        matrix = np.block([[np.eye(size), self.scaled.T], [self.scaled, np.zeros((rows, rows))]])
        right = np.concatenate((np.linalg.solve(self.root, self.force), self.gamma / self.row_scale))
        solution = np.linalg.lstsq(matrix, right, rcond=AUGMENTED_CUTOFF)[0]
        acceleration = np.zeros(self.moment.rate.shape)
        acceleration[self.moment.used] = np.linalg.solve(self.root.T, solution[:size])
        lam = solution[size:] / self.row_scale
        return Solution(acceleration, self.wrenches(lam), self.condition, self.redundant)

    def wrenches(self, lam: np.ndarray) -> dict[str, np.ndarray]:
        """Return every joint's force and torque of the multipliers (n_rows,)."""
        return {joint.name: self._wrench(joint, lam) for joint in self.moment.scene.joints}

    def _wrench(self, joint: Any, lam: np.ndarray) -> np.ndarray:
        """Return -C_q^T lambda of one joint on its last body, or ground, moved to the joint's mark."""
        own = np.array([name == joint.name for name in self.joints])
        full = np.zeros_like(self.moment.rate)
        full[self.moment.used] = -lam[own] @ self.jacobian[own]
        name, sign = getattr(joint, "body_b", None) or joint.body, 1.0
        if name == GROUND:
            name, sign = joint.body_a, -1.0
        k, d = self.moment.scene.body_index(name), self.moment.scene.dimension
        force, torque = sign * full[k, :d], sign * full[k, d:]
        arm = self._arm(joint, name, k)
        return np.concatenate((force, torque - np.atleast_1d(_cross(arm, force))))

    def _arm(self, joint: Any, name: str, k: int) -> np.ndarray:
        side = "point_b" if not isinstance(joint, parts.Drive) and name == joint.body_b else "point_a"
        mark = getattr(joint, side, None) or getattr(joint, "point", None)
        if mark is None:
            return np.zeros(self.moment.scene.dimension)
        here = self.moment.with_rates(np.zeros((1, int(self.moment.used.sum()))))
        return here.point(name, mark)[0][0] - self.moment.position[k]


def _cross(a: np.ndarray, b: np.ndarray) -> Any:
    return a[0] * b[1] - a[1] * b[0] if len(a) == 2 else np.cross(a, b)


def consistent(scene: Scene) -> Scene:
    """Return the scene with the velocities nearest in the mass norm that its joints allow."""
    system = augmented(Moment.start(scene))
    rate = np.zeros(system.moment.rate.shape)
    rate[system.moment.used] = system.consistent_rates()
    return with_rates(scene, rate)


class JudgedRows(NamedTuple):
    """The joints' rows of the judge at one moment, without the norms of Euler parameters."""

    residual: np.ndarray  # (n_rows,) C: m, rad
    jacobian: np.ndarray  # (n_rows, n_q) C_q
    drift: np.ndarray  # (n_rows,) C_t
    joints: tuple[str, ...]  # (n_rows,)
    mine: np.ndarray  # which of all rows they are


def judged_rows(moment: Moment) -> JudgedRows:
    """Return C, C_q and C_t of every joint at a moment."""
    rows = observables.rows(moment.scene, unit_rates(moment).trajectory)
    names = {joint.name for joint in moment.scene.joints}
    mine = np.array([name in names for name in rows.joints], dtype=bool)
    rates = rows.rate[:, mine]
    joints = tuple(name for name, own in zip(rows.joints, mine, strict=True) if own)
    return JudgedRows(rows.residual[0, mine], (rates[:-1] - rates[-1]).T, rates[-1], joints, mine)


def unit_rates(moment: Moment) -> Motion:
    """Return the pose with every unit velocity in turn, and last with none."""
    count = int(moment.used.sum())
    return moment.with_rates(np.vstack((np.eye(count), np.zeros(count))))


def augmented(moment: Moment) -> Augmented:
    """Assemble the system at a moment."""
    rows = judged_rows(moment)
    v = moment.rate[moment.used]
    course = observables.constraint_rate(moment.scene, moment.moved(v).trajectory)[:, rows.mine]
    gamma = -_derivative(course, moment.span(v))
    force = _forces(moment, unit_rates(moment))
    return Augmented(moment, _mass(moment), rows.jacobian, force, gamma, rows.drift, rows.joints)


def _mass(moment: Moment) -> np.ndarray:
    width = moment.rate.shape[1]
    blocks = np.zeros((len(moment.scene.bodies), width, len(moment.scene.bodies), width), dtype=moment.rate.dtype)
    for k, body in enumerate(moment.scene.bodies):
        d = moment.scene.dimension
        blocks[k, :d, k, :d] = body.mass * np.eye(d)
        blocks[k, d:, k, d:] = _inertia(moment, k)
    full = blocks.reshape(moment.used.size, moment.used.size)
    return full[np.ix_(moment.used.ravel(), moment.used.ravel())]


def _inertia(moment: Moment, k: int) -> np.ndarray:
    body: Any = moment.scene.bodies[k]
    if isinstance(body, PointMass):
        return np.eye(moment.rate.shape[1] - moment.scene.dimension)  # cut out again: it has no such coordinates
    if not isinstance(body, SpatialBody):
        return np.array([[body.inertia]])
    turned = rotation_matrices(moment.orientation[k])
    return turned @ body.inertia_matrix @ turned.T


def _forces(moment: Moment, units: Motion) -> np.ndarray:
    """Return Q (n_q,): gravity, -omega x J omega, and every load by the power of unit velocities."""
    full = np.zeros_like(moment.rate)
    for k, body in enumerate(moment.scene.bodies):
        full[k, : moment.scene.dimension] = body.mass * np.asarray(moment.scene.gravity)
        if isinstance(body, SpatialBody):
            omega = moment.rate[k, 3:]
            full[k, 3:] = -np.cross(omega, _inertia(moment, k) @ omega)
    now = moment.with_rates(moment.rate[moment.used][None])
    terms = [LAWS[type(load)](moment, now, units, load) for load in moment.scene.loads]
    return full[moment.used] + (np.sum(terms, axis=0) if terms else 0.0)


def _factor(moment: Moment, load: Any) -> Any:
    return values(load.factor, np.array([moment.time]))[0]


def _push(moment: Moment, now: Motion, units: Motion, load: parts.Force | parts.TorqueVector) -> np.ndarray:
    vector = np.asarray(load.vector) if load.frame == "world" else now.direction(load.body, load.vector)[0][0]
    ways = units.point(load.body, load.point)[1] if isinstance(load, parts.Force) else units.turning(load.body)
    return _factor(moment, load) * (ways[:-1] @ vector)


def _torque(moment: Moment, now: Motion, units: Motion, load: parts.Torque) -> np.ndarray:
    return _factor(moment, load) * load.torque * units.turning(load.body)[:-1]


def _spring(moment: Moment, now: Motion, units: Motion, load: parts.SpringDamper) -> np.ndarray:
    _, (stretch,), (rate,) = length_of(now, load)
    tension = load.stiffness * stretch + load.damping * rate
    if load.tension_only and (stretch <= 0.0 or tension < 0.0):
        tension = 0.0
    if load.limit is not None and tension > load.limit:
        tension = load.limit
    return -tension * length_of(units, load)[2][:-1]


def _torsion_spring(moment: Moment, now: Motion, units: Motion, load: parts.TorsionSpring) -> np.ndarray:
    (angle,), (rate,) = twist_of(now, load)
    return -(load.stiffness * angle + load.damping * rate) * twist_of(units, load)[1][:-1]


def _point_bushing(moment: Moment, now: Motion, units: Motion, load: parts.PointBushing) -> np.ndarray:
    (gap,), (slip,) = gap_of(now, load)
    return -gap_of(units, load)[1][:-1] @ (load.stiffness * gap + load.damping * slip)


def _bushing(moment: Moment, now: Motion, units: Motion, load: parts.Bushing) -> np.ndarray:
    """The gradient of its energy, which the rotation vector makes unlike the torques K phi, and the dampers."""
    strain, rate = (part[0] for part in bushing_strain(now, load))
    touched = [moment.scene.body_index(body) for body in (load.body_a, load.body_b)]
    result = -bushing_strain(units, load)[1][:-1] @ (np.asarray(load.damping) * rate)
    owner = np.nonzero(moment.used)[0]
    for k in np.flatnonzero(np.isin(owner, touched)):
        unit = np.zeros(len(owner), dtype=moment.rate.dtype)
        unit[k] = 1.0
        slope = _derivative(bushing_strain(moment.moved(unit), load)[0], moment.span(unit))
        result[k] -= slope @ (np.asarray(load.stiffness) * strain)
    return result


LAWS = {
    parts.Force: _push, parts.Torque: _torque, parts.TorqueVector: _push, parts.SpringDamper: _spring,
    parts.TorsionSpring: _torsion_spring, parts.PointBushing: _point_bushing, parts.Bushing: _bushing,
}  # fmt: skip
