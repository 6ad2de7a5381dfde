"""What compiled scenes of bodies and joints answer alike in the plane and in space: rows, reactions, user forces."""

import ctypes
from abc import abstractmethod
from array import array
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np

from mbs_ref.cores.builder import Builder, Place
from mbs_ref.cores.events import ContactSystem
from mbs_ref.cores.in_lanes import figures_of, follows_from_states
from mbs_ref.cores.system import RANK_TOLERANCE
from mbs_ref.cores.user_rows import UserRow, write_user_rows
from mbs_ref.kernels.algebra.lanes import room_for_lanes
from mbs_ref.kernels.contact.laws import MODE_CLOSED
from mbs_ref.kernels.rigid.model import CONTROL_MODE_TIME, CONTROL_POSITION_GAIN, CONTROL_VELOCITY_GAIN, Rows
from mbs_ref.kernels.rigid.outputs import forces_at_joints, forces_in_lanes, forces_over
from mbs_ref.scene import Scene, UserConstraint, UserForce
from mbs_ref.scene.base.taylor import Taylor

MOST_AT_ONCE = 1_000_000  # numbers of reactions that are computed together: 8 MB
SURE_PIVOT = 1e-3  # relative closure pivot, the square of a singular value: rows are independent beyond doubt
_CALLBACK = ctypes.CFUNCTYPE(None, ctypes.c_double, ctypes.c_uint64)


class JointedSystem(ContactSystem):
    """A system whose `groups` and `scratch` hold constraint rows in slots; `place` gives each joint's."""

    changed = "contact_modes", "near_pairs", "granules", "world"
    BUILDER: ClassVar[type[Builder]]
    RATES: ClassVar[int]  # of a body
    SHARED: ClassVar[int]  # numbers a body in each array that a user's force law sees
    n_bodies: int
    place: Mapping[int, Place]  # of each joint's rows

    def __init__(self, scene: Scene) -> None:
        self.scene, self.n_bodies = scene, len(scene.bodies)
        self.builder = self.BUILDER(scene)
        self.place = self.builder.place
        self._set_arrays(self.builder.groups())
        self._begin()

    def _begin(self) -> None:
        """Prepare for a run, with arrays that no run has changed."""
        self._set_record()
        self.user_error, self.user_times = None, array("d")
        self._keep_alive = self._connect_user_forces(), self._connect_user_rows()

    def twin(self) -> Self:
        other = super().twin()
        other._begin()
        return other

    def _connect_user_forces(self) -> Any:
        laws: list[Any] = [load for load in self.scene.loads if isinstance(load, UserForce)]
        if not laws:
            return None

        def call(t: float, address: int) -> None:
            data = np.ctypeslib.as_array((ctypes.c_double * (3 * self.SHARED * self.n_bodies)).from_address(address))
            q, v, f = data.reshape(3, self.n_bodies, self.SHARED)
            self.user_times.append(t)
            try:
                for law in laws:
                    f[:, : self.RATES] += np.asarray(law.function(t, q.copy(), v[:, : self.RATES].copy()), dtype=float)
            except BaseException as error:
                self.user_error = error
                f[:] = np.nan

        callback = _CALLBACK(call)
        self.groups.world.user_force[0] = ctypes.cast(callback, ctypes.c_void_p).value
        return callback

    def _connect_user_rows(self) -> Any:
        own = [k for k in self.place if isinstance(self.scene.joints[k], UserConstraint)]
        rows = [self._user_row(k, self.place[k]) for k in own]
        if not rows:
            return None

        def call(t: float, _address: int) -> None:
            try:
                write_user_rows(rows, self._coordinates, self.RATES, t, self.scratch.rows)
            except BaseException as error:
                self.user_error = error
                for user in rows:
                    self.scratch.rows.residual[user.slot, user.row] = np.nan
                    self.scratch.rows.gamma[user.slot, user.row] = np.nan

        callback = _CALLBACK(call)
        self.groups.world.user_rows[0] = ctypes.cast(callback, ctypes.c_void_p).value
        return callback

    def _user_row(self, k: int, at: Place) -> UserRow:
        joint: Any = self.scene.joints[k]
        sides = self.groups.slots.body[at.slot]
        arms = self.builder.arms([joint, joint], ["body_a", "body_b"])
        bodies = int(sides[at.side]), int(sides[1 - at.side])
        return UserRow(joint.formula(), joint.name, at.slot, at.row, at.side, bodies, (arms[0], arms[1]))

    @abstractmethod
    def _coordinates(self, body: int, arm: np.ndarray, size: int, first: int) -> Sequence[Taylor]:
        """Return a body's place (mbs_ref.scene.joints.PLACES) at the state in the scratch; see `UserRow`."""

    @property
    def n_positions(self) -> int:
        return int(self.groups.bodies.start[0])

    def set_mode_time(self, t: float) -> None:
        self.groups.world.control[CONTROL_MODE_TIME] = t

    def steady_course(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return X y (n_state,) and the matrix of X where every body keeps its present rates: see `steady_motion`."""
        course = np.zeros_like(y)
        course[: self.n_positions] = self.derivative(0.0, y)[: self.n_positions]
        return course, np.zeros((len(y), len(y)))

    def norms(self, y: np.ndarray) -> np.ndarray:
        """Return what else the state keeps besides the joints' rows."""
        return np.zeros(0)

    def set_baumgarte(self, gain: float) -> None:
        self.groups.world.control[CONTROL_VELOCITY_GAIN] = 2.0 * gain
        self.groups.world.control[CONTROL_POSITION_GAIN] = gain * gain

    def _in_scene_order(self, values: np.ndarray) -> np.ndarray:
        result = np.empty_like(values)
        result[self.groups.bodies.scene_index] = values
        return result

    @property
    def prunes_pairs(self) -> bool:
        return bool(self.groups.near_pairs.skin[0])

    @property
    def n_closure_rows(self) -> int:
        return int(self.groups.loops.count.sum())

    @property
    def n_spare_rows(self) -> int:
        return int(np.sum(self.groups.loops.count - self.groups.loops.most))

    def rows(self, every: bool = False) -> list[tuple[int, int, int]]:
        """Return (joint, slot, row in slot) of every constraint row, joint after joint, then the closed contacts'.

        A contact's joint is -1; with `every` the rows of open constraint contacts, which are empty, come too.
        """
        slots, modes = self.groups.contact_laws.slot, self.groups.contact_modes.mode
        held = [slot for slot, mode in zip(slots, modes, strict=False) if slot >= 0 and (every or mode == MODE_CLOSED)]
        return self._joint_rows + [(-1, int(slot), 0) for slot in held]

    @cached_property
    def _joint_rows(self) -> list[tuple[int, int, int]]:
        return [(k, at.slot, at.row + r) for k, at in sorted(self.place.items()) for r in range(at.n_rows)]

    def row_joints(self) -> list[str]:
        """Return the joint of each row, or its contact."""
        contacts = dict(zip(self.groups.contact_laws.slot.tolist(), self.event_sources, strict=False))
        return [self.scene.joints[k].name if k >= 0 else contacts[slot] for k, slot, _ in self.rows()]

    def residuals(self, t: float, y: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        self.compliance(t, y)
        rows = self.scratch.rows
        result = {}
        for k, at in sorted(self.place.items()):
            here = at.slot, slice(at.row, at.row + at.n_rows)
            result[self.scene.joints[k].name] = (rows.residual[here].copy(), rows.rate[here].copy())
        return result

    def jacobian(self, t: float, y: np.ndarray) -> np.ndarray:
        """Return C_q (n_rows, n_bodies times the rates of one) in scene order, rows in the order of `rows`."""
        return self._jacobians([t], y[None])[0][0]

    def _jacobians(self, times: Sequence[float], states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return C_q at several times and states (n_t, n_rows, ...), and the mass matrices as `mass_matrix`."""
        slot, row = np.array(self.rows(), np.int64).reshape(-1, 3).T[1:]
        count, scene_index = len(slot), np.append(self.groups.bodies.scene_index, self.n_bodies)
        blocks, masses = np.empty((len(states), 2, count, self.RATES)), []
        for out, t, y in zip(blocks, times, states, strict=True):
            self.compliance(t, y)
            out[:] = self.scratch.rows.jacobian[slot, :, row].swapaxes(0, 1)
            masses.append(self.mass_matrix())
        result = np.zeros((len(states), count, self.n_bodies + 1, self.RATES))
        for side in range(2):
            result[:, np.arange(count), scene_index[self.groups.slots.body[slot, side]]] += blocks[:, side]
        return result[:, :, :-1].reshape(len(states), count, self.RATES * self.n_bodies), np.array(masses)

    def right_side(self) -> np.ndarray:
        """Return gamma (n_rows,) of the rows last evaluated, in the order of `rows`."""
        return np.array([self.scratch.rows.gamma[slot, row] for _, slot, row in self.rows()])

    @property
    def n_constraints(self) -> int:
        return len(self.rows())

    def rank(self, t: float, y: np.ndarray) -> int:
        if self.has_sure_rank(t, y):
            return len(self.rows())
        scaled = self.scaled_jacobian(t, y)
        if scaled.size == 0:
            return 0
        values = np.linalg.svd(scaled, compute_uv=False)
        return int(np.sum(values > RANK_TOLERANCE * values[0]))

    def has_sure_rank(self, t: float, y: np.ndarray) -> bool:
        with np.errstate(all="ignore"):
            self.derivative(t, y)
        complete = int(self.scratch.closures.rank.sum()) == self.n_closure_rows
        return complete and self.regularity() > SURE_PIVOT

    def independent_rows(self, t: float, y: np.ndarray) -> np.ndarray:
        """Return which rows to keep where dependent ones cannot be borne: as many as the mechanism's own rank."""
        return np.arange(len(self.rows()))

    def scaled_jacobians(self, times: Sequence[float], states: np.ndarray) -> np.ndarray:
        scaled, mass = self._jacobians(times, states)
        if mass.ndim == 3:
            scaled = np.linalg.solve(np.linalg.cholesky(mass), scaled.swapaxes(1, 2)).swapaxes(1, 2)
        else:
            scaled /= np.sqrt(mass)[:, None]
        return scaled / np.linalg.norm(scaled, axis=2, keepdims=True)

    @abstractmethod
    def mass_matrix(self) -> np.ndarray:
        """Return M in scene order and world axes at the state last evaluated, or its diagonal: kg and kg m^2."""

    def applied_forces(self, t: float, y: np.ndarray) -> np.ndarray:
        """Return forces and torques (n_bodies, rates; N, N m) of gravity, all loads and, in space, -omega x J omega."""
        self.derivative(t, y)
        return self._in_scene_order(self.scratch.kinematics.force[: self.n_bodies])

    def multipliers(self, t: float, y: np.ndarray) -> np.ndarray:
        """Return lambda (n_rows,) in the order of `rows`; minimum-norm where rows are dependent."""
        values = self._multipliers_by_slot(t, y)
        return np.array([values[slot, row] for _, slot, row in self.rows()])

    def _multipliers_by_slot(self, t: float, y: np.ndarray) -> np.ndarray:
        """Return lambda (n_slots, rows a slot) as the arrays have the rows; leave C_q at (t, y) in the scratch."""
        dy = self.derivative(t, y)
        result = self.scratch.rows.multiplier.copy()
        if not len(self.groups.loops.slot) or self.scratch.closures.rank.sum() == self.n_closure_rows or not len(dy):
            return result
        force, acceleration = self.applied_forces(t, y).ravel(), self.accelerations(t, y).ravel()
        mass = self.mass_matrix()
        unbalanced = force - (mass @ acceleration if mass.ndim == 2 else mass * acceleration)
        found = np.linalg.lstsq(self.jacobian(t, y).T, unbalanced, rcond=RANK_TOLERANCE)[0]
        for value, (_, slot, row) in zip(found, self.rows(), strict=True):
            result[slot, row] = value
        return result

    def reactions_over(
        self, times: np.ndarray, states: np.ndarray, pivots: np.ndarray | None = None, in_lanes: bool = False
    ) -> dict[str, np.ndarray]:
        if not len(times):
            return {}
        of, forces = self.builder.reporting, np.empty((len(times), len(self.place), self.RATES))
        pivots = np.empty(len(times)) if pivots is None else pivots
        each = max(1, MOST_AT_ONCE // max(1, forces[:1].size))
        for start in range(0, len(times), each):
            block = slice(start, start + each)
            self._fill(times[block], states[block], forces[block], pivots[block], in_lanes)
            turns = self.orientations(states[block])[:, of.body]
            forces[block] = self._about(self.turned(turns, of.arm), of.sign * forces[block])
        return dict(zip(of.names, forces.swapaxes(0, 1).copy(), strict=True))

    def pivots(self, times: np.ndarray, states: np.ndarray) -> np.ndarray:
        pivots = np.empty(len(times))
        self._filled(times, states, np.empty((len(times), len(self.place), self.RATES)), pivots)
        return pivots

    def _fill(self, times: np.ndarray, states: np.ndarray, out: np.ndarray, pivots: np.ndarray, in_lanes: bool) -> None:
        """Fill out (n_t, n_joints, rates) with the joints' forces on their bodies, in the modes that held then."""
        if in_lanes and follows_from_states(self):
            pivots[:] = 1.0  # without closures
            self._fill_in_lanes(states, out)
            return
        dependent = np.flatnonzero(self._filled(times, states, out, pivots) != self.n_closure_rows)
        for k in dependent.tolist():
            self.recall_modes(times[k])
            multiplier = self._multipliers_by_slot(times[k], states[k])
            forces_at_joints(self.builder.reporting.rows, multiplier, self.scratch.rows.jacobian, out[k])

    def _fill_in_lanes(self, states: np.ndarray, out: np.ndarray) -> None:
        room = self.room
        room.figures[:] = figures_of(self)[:, None]
        rows = next(group for group in room.kept[1] if isinstance(group, Rows))
        y, dy = room_for_lanes(states.shape[1]), room_for_lanes(states.shape[1])
        given = self.builder.reporting.rows, rows.multiplier, rows.jacobian, y, dy
        forces_in_lanes(room.model, room.work, *given, np.ascontiguousarray(states), out)

    def _filled(self, times: np.ndarray, states: np.ndarray, out: np.ndarray, pivots: np.ndarray) -> np.ndarray:
        """Fill out and pivots as `forces_over`; return the rank of the closures (n_t,)."""
        scratch, ranks = self.scratch, np.empty(len(times), dtype=np.int64)
        given = self.record, self.builder.reporting.rows, scratch.rows, scratch.closures.rank
        times, states = np.ascontiguousarray(times), np.ascontiguousarray(states)
        forces_over(self.model, self.work, *given, times, states, out, pivots, ranks)
        return ranks

    @abstractmethod
    def orientations(self, states: np.ndarray) -> np.ndarray:
        """Return the bodies' orientations as `poses` does."""

    @staticmethod
    @abstractmethod
    def turned(turns: np.ndarray, arms: np.ndarray) -> np.ndarray:
        """Return arms (..., dimension) that turn with bodies along world axes, at orientations of the bodies."""

    @staticmethod
    @abstractmethod
    def _about(arms: np.ndarray, forces: np.ndarray) -> np.ndarray:
        """Turn forces (..., rates) on bodies into force and torque about points with these arms (..., dimension)."""
