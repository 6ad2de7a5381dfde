"""A scene compiled: what every core offers to integrators, checks and reports."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from copy import copy
from functools import cache, cached_property
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np

from mbs_ref.cores.in_lanes import SideBySide, side_by_side
from mbs_ref.cores.joint_graph import graph_of
from mbs_ref.kernels import answers as core
from mbs_ref.kernels.border.blocks import Block, address_places, without_log
from mbs_ref.kernels.border.handles import QUESTIONS, Model, Work, make_handle
from mbs_ref.scene import Scene, UserConstraint, UserForce
from mbs_ref.scene.base.rows import Rod, SharedPoint
from mbs_ref.scene.contact import Granules
from mbs_ref.scene.scales import Scales, scales_of
from mbs_ref.trajectory import Trajectory

COMPANION_NOISE = 3.0  # `noise` of a companion's events over the run's; a search ends 1 to 2 times it beyond a root
RANK_TOLERANCE = 1e-10  # singular values of the scaled C_q below this share of the largest count as zero


class Poses(NamedTuple):
    """World poses and velocities as a Trajectory holds them."""

    position: np.ndarray  # (n_t, n_bodies, dimension) m
    orientation: np.ndarray  # (n_t, n_bodies) rad, or (n_t, n_bodies, 4) Euler parameters
    velocity: np.ndarray  # (n_t, n_bodies, dimension) m/s
    angular_velocity: np.ndarray  # (n_t, n_bodies) rad/s, or (n_t, n_bodies, 3) world axes

    @classmethod
    def of(cls, path: Trajectory) -> "Poses":
        """Return those of a trajectory."""
        return cls(path.position, path.orientation, path.velocity, path.angular_velocity)


@cache
def _answers(name: str, groups: tuple[str, ...]) -> np.ndarray:
    """Return the first words of the handles of a core of this name, which answers groups of questions."""
    return core.connected(name, np.zeros(QUESTIONS, dtype=np.int64), groups)


class System(ABC):
    """A compiled scene. A core implements the abstract methods and sets scene, groups and scratch.

    The state y is one vector; `derivative` is its rate.
    """

    CORE: ClassVar[str]  # of mbs_ref.kernels.answers
    scene: Scene
    groups: Any  # the scene's arrays
    _memory: np.ndarray  # of a twin: what a run changes
    expansion: Any = None  # in Taylor series (mbs_ref.cores.series), once it is built
    changed: ClassVar[tuple[str, ...]] = ()  # groups that a run writes to, besides the scratch
    keeps_itself: ClassVar[bool] = False  # whether every state keeps the constraints, so that none needs `project`
    user_error: BaseException | None = None  # what a user's force law raised, if it did

    # Connected at first use: checking a scene does not wait for the compiler.
    @cached_property
    def handles(self) -> tuple[np.ndarray, np.ndarray]:
        """Handles of the scene's arrays and of the scratch, by which the core answers (kernels/border/calls.py)."""
        # scratch comes from `empty`, which follows the declarations
        handles = make_handle(self.groups), make_handle(self.scratch, checked=True)
        for handle in handles:
            handle[:QUESTIONS] = _answers(self.CORE, self.answered)
        return handles

    @cached_property
    def answered(self) -> tuple[str, ...]:
        """The groups of questions that the scene makes necessary (mbs_ref.kernels.answers)."""
        events = core.EVENTS if self.event_sources else core.UNEVENTFUL
        loops = core.LOOPS if self.n_closure_rows else core.OPEN
        has = self.features
        return core.MOTION, events, loops, *(name if name in has else core.NO + name for name in core.FEATURES)

    @property
    def features(self) -> set[str]:
        """What the scene has of mbs_ref.kernels.answers.FEATURES."""
        scene = self.scene
        grains = [isinstance(load, Granules) for load in scene.loads]
        has = {
            core.LOADS: not all(grains), core.GRANULES: any(grains),
            core.ROWS: not {type(row) for rows in graph_of(scene)[0] for row in rows} <= {SharedPoint, Rod},
            core.GRIPS: any(contact.friction and contact.friction.STICKS for contact in scene.contacts),
            core.HELD: any(contact.holds for contact in scene.contacts),
            core.SWITCHES: len(self.event_sources) > len(scene.contacts),
            core.PRUNED: self.prunes_pairs,
            core.REFINED: bool(self.n_closure_rows or self.event_sources),
        }  # fmt: skip
        return {name for name, is_there in has.items() if is_there}

    @cached_property
    def model(self) -> Model:
        """What compiled code receives of the scene."""
        return Model(self.handles[0].ctypes.data)

    @cached_property
    def work(self) -> Work:
        """What compiled code receives of the scratch."""
        return Work(self.handles[1].ctypes.data)

    @cached_property
    def own_handles(self) -> tuple[Any, Any]:
        """Model and scratch as the core's own code takes them, by the types of its handles."""
        model, work = core.HANDLES[self.CORE]
        return model(*self.model), work(*self.work)

    def prepare(self, group: str) -> None:
        """Have the answers to a group of questions compiled and connected (mbs_ref.kernels.answers)."""
        for handle in self.handles:
            core.prepare(self.CORE, handle, group)

    @cached_property
    def room(self) -> SideBySide:
        """Room for systems of this one's build."""
        return side_by_side(self)

    def _set_arrays(self, groups: Any) -> None:
        """Take groups that no run has changed, and copy those that a run changes."""
        self.groups, self._before_runs = groups, [without_log(getattr(groups, name)) for name in self.changed]
        self.scratch = self._new_scratch()
        self._scratch_kind = type(self.scratch)

    @abstractmethod
    def _new_scratch(self) -> Any:
        """Return the scratch of one run."""

    @cached_property
    def _untouched(self) -> Block:
        return Block([*self._before_runs, *self._new_scratch()])

    @cached_property
    def scratch(self) -> Any:
        """Arrays of one run, of a twin."""
        return self._scratch_kind(*self._untouched.groups(self._memory, slice(len(self.changed), None)))

    def twin(self) -> Self:
        """Return another system of the scene, as it is before any run; both share what no run changes."""
        other, (model, work), kind = copy(self), self.handles, self._scratch_kind
        for name in ("scratch", "model", "work", "own_handles", "expansion", "room"):
            vars(other).pop(name, None)
        other._memory = self._untouched.copy()
        changed = self._untouched.groups(other._memory, slice(len(self.changed)))
        other.groups = self.groups._replace(**dict(zip(self.changed, changed, strict=True)))
        other.handles = model.copy(), work.copy()
        places = address_places(type(self.groups), self.changed), address_places(kind, kind._fields)
        addresses = other._memory.ctypes.data + self._untouched.starts
        for handle, where, own in zip(other.handles, places, np.split(addresses, [len(places[0])]), strict=True):
            handle[where] = own
        return other

    @cached_property
    def calls_users(self) -> bool:
        """Whether a force or a constraint is a user's own function."""
        return not {UserForce, UserConstraint}.isdisjoint(map(type, (*self.scene.loads, *self.scene.joints)))

    def beside(self) -> "System":
        """Return a system for a companion run, a twin if runs change modes or times; it locates events elsewhere."""
        if not (self.event_sources or self.calls_users):
            return self
        other = self.twin()
        other.spread_events(COMPANION_NOISE)
        return other

    def derivative(self, t: float, y: np.ndarray) -> np.ndarray:
        """Return dy/dt."""
        dy = np.empty_like(y)
        core.call_derivative(self.model, self.work, float(t), y, dy)
        return dy

    def compliance(self, t: float, y: np.ndarray) -> tuple[float, float]:
        """Return max |C| (m, rad) and max |C_dot| (m/s, rad/s)."""
        return core.call_compliance(self.model, self.work, float(t), y)

    def project(self, t: float, y: np.ndarray, tolerance: float = 1e-13, most: int = 20) -> float:
        """Move y onto the constraints in place; return max |C| left."""
        return core.call_project(self.model, self.work, float(t), y, tolerance, most)

    def free_direction(self, t: float, y: np.ndarray, random: np.random.Generator) -> np.ndarray:
        """Return a random direction (n_state,) along the constraints at (t, y), its largest entry 1."""
        self.derivative(t, y)
        x = self.along_constraints(random.standard_normal(len(y)))
        return x / max(1e-12, float(np.abs(x).max()))

    def along_constraints(self, x: np.ndarray) -> np.ndarray:
        """Return the part of a displacement and its rates (n_state,) that the constraints last evaluated allow."""
        self.prepare(core.TANGENT)
        x = x.copy()
        core.call_tangent(self.model, self.work, x)
        return x

    @cached_property
    def scales(self) -> Scales:
        """The length and the time that the scene's errors count in."""
        return scales_of(self.scene)

    @property
    def redundant(self) -> "System":
        """The system whose state shows whether a start keeps the joints; itself where it has constraint rows."""
        return self

    def all_reduced(self, full: np.ndarray) -> np.ndarray:
        """Return this system's states (n, n_state) of those of `redundant` (n, n_full)."""
        return full

    def all_full(self, states: np.ndarray) -> np.ndarray:
        """Return the states (n, n_full) of `redundant` that this system's (n, n_state) mean."""
        return states

    def reduced(self, full: np.ndarray) -> np.ndarray:
        """Return this system's state of one of `redundant`."""
        return self.all_reduced(full[None])[0]

    @property
    def n_positions(self) -> int:
        """Entries of the state that are positions and orientations; the rates follow. Half of it by default."""
        return len(self.initial_state()) // 2

    def start_contacts(self, t: float, y: np.ndarray, located: bool) -> None:
        """Set every contact's mode by the state; without `located` forces are clipped by the state instead."""
        core.call_start_modes(self.model, self.work, float(t), y, located)

    def contact_forces(self, times: np.ndarray, states: np.ndarray) -> dict[str, np.ndarray]:
        """Return for each contact depth (m), force on body_a (N) and its point (m), world axes: (n_t, 5 or 7)."""
        return {}

    def contact_oscillators(self, t: float, y: np.ndarray, speed: float) -> np.ndarray:
        """Return k W (1/s^2), c W (1/s) and k (N/m) of each contact (n, 3), W its normal mobility.

        k and c are the slopes of the law at the depth where an impact at `speed` (m/s) ends without loss.
        """
        return np.zeros((0, 3))

    def taut_strings(self) -> AbstractContextManager[bool]:
        """Let every tension-only spring pull and push meanwhile; return whether there is any."""
        return nullcontext(False)

    def recall_modes(self, t: float) -> None:
        """Set every contact's mode to the one that held at t (s) in the last run."""
        return None

    def spread_events(self, factor: float, lag: float = 0.0) -> None:
        """Locate events `factor` times as far beyond their roots, and again `lag` times where a held contact opens."""
        return None

    @property
    def event_sources(self) -> tuple[str, ...]:
        """Return the names of what may have events: contacts, tension-only springs, declared events."""
        return ()

    def contact_events(self) -> np.ndarray:
        """Return time (s) and place in `event_sources` (n_events, 2) of the events located so far."""
        return np.zeros((0, 2))

    def regularity(self) -> float:
        """Return how far the last evaluated pose is from a singular one: 1 far, 0 there."""
        return core.call_regularity(self.work)

    def pivots(self, times: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Return `regularity` (n_t,) at the times and states of the last run, in the contact modes that held then."""
        return np.ones(len(times))

    def scaled_jacobian(self, t: float, y: np.ndarray) -> np.ndarray:
        """Return C_q (n_rows, n) of the joints' rows, each at length 1 and mass-scaled: metres and radians compare."""
        return self.scaled_jacobians([t], y[None])[0]

    def scaled_jacobians(self, times: Sequence[float], states: np.ndarray) -> np.ndarray:
        """Return `scaled_jacobian` (n_t, n_rows, n) at several times and states."""
        return np.zeros((len(states), 0, 0))

    def row_joints(self) -> list[str]:
        """Return the joint of each of these rows."""
        return []

    def accelerations(self, t: float, y: np.ndarray) -> np.ndarray:
        """Return the bodies' accelerations, world axes: (n_bodies, 3) in the plane, m/s^2 and rad/s^2; (n_bodies, 6)
        in space; (n_bodies, 3) of particles.
        """
        return self.derivative(t, y)[self.n_positions :].reshape(-1, 3)

    @abstractmethod
    def __init__(self, scene: Scene) -> None:
        """Compile a scene."""

    @abstractmethod
    def initial_state(self) -> np.ndarray:
        """Return y at t = 0."""

    @staticmethod
    @abstractmethod
    def state_units(scene: Scene, scales: Scales) -> np.ndarray:
        """Return what each entry of a scene's state counts in (n_state,): L, 1 rad, and the same over T."""

    @abstractmethod
    def poses(self, states: np.ndarray) -> Poses:
        """Turn states (n_t, n_state) into world poses and velocities."""

    @abstractmethod
    def states_of(self, poses: Poses) -> np.ndarray:
        """Return states (n_t, n_state) of world poses and velocities, which need not satisfy the joints."""

    def set_mode_time(self, t: float) -> None:
        """Choose the signals' segments: the ones that contain t (s)."""
        return None

    def set_baumgarte(self, gain: float) -> None:
        """Set C'' + 2 g C' + g^2 C = 0 with g in 1/s; 0 switches it off (Baumgarte 1972)."""
        return None

    def residuals(self, t: float, y: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Return C and C_dot of every joint by name."""
        return {}

    def reactions_over(
        self, times: np.ndarray, states: np.ndarray, pivots: np.ndarray | None = None, in_lanes: bool = False
    ) -> dict[str, np.ndarray]:
        """Return the force and torque (n_t, 3 or 6) of each joint on its last body, at the joint point, in world axes.

        The times are those of the last run, whose modes hold. `pivots` (n_t,) receive the smallest relative pivot of
        the closures. With `in_lanes` states are evaluated side by side where they alone determine the forces.
        """
        return {}

    def rank(self, t: float, y: np.ndarray) -> int:
        """Return the rank of C_q, mass-scaled so that metres and radians compare; 0 where there are no rows."""
        return 0

    def has_sure_rank(self, t: float, y: np.ndarray) -> bool:
        """Return whether the elimination alone shows that all rows are independent, by far."""
        return False

    @property
    def n_coordinates(self) -> int:
        """Coordinates in use: the state's positions, unless a core stores more."""
        return self.n_positions

    @property
    def n_constraints(self) -> int:
        """Constraint rows."""
        return 0

    @property
    def n_spare_rows(self) -> int:
        """Rows of closed loops that depend on others in every pose."""
        return 0

    @property
    def prunes_pairs(self) -> bool:
        """Whether pairs of shapes that are far from each other are not examined."""
        return False

    @property
    def n_closure_rows(self) -> int:
        """Constraint rows that close loops; 0 for a tree, whose rows are independent."""
        return 0
