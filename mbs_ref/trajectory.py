"""The result of every engine: world poses and velocities at the output times, and how the run ended."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Any, NamedTuple

import numpy as np

from mbs_ref.display import facts

POSES = ("position", "orientation", "velocity", "angular_velocity")


class World(NamedTuple):
    """What distinguishes motions in the plane from those in space: the numbers of a body's pose and rates."""

    name: str
    columns: tuple[str, ...]  # of a body in files and tables
    orientation: str  # the name of a rigid body's orientation: an angle (rad), or Euler parameters
    unturned: float | tuple[float, ...]  # the orientation of what does not turn
    still: float | tuple[float, ...]  # the angular velocity of what does not turn, rad/s


WORLDS = {
    2: World("plane", ("x", "y", "angle", "vx", "vy", "rate"), "angle", 0.0, 0.0),
    3: World("space", ("x", "y", "z", "e0", "e1", "e2", "e3", "vx", "vy", "vz", "wx", "wy", "wz"), "orientation",
             (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
}  # by dimension  # fmt: skip


class Status(StrEnum):
    """How a run ended. Only SUCCESS guarantees samples at every output time."""

    SUCCESS = "success"
    NON_FINITE = "non-finite"  # NaN or infinity occurred
    STEP_TOO_SMALL = "step-too-small"  # t + h == t, or the error test could not be met
    TOO_MANY_STEPS = "too-many-steps"
    COMPLIANCE = "compliance"  # the papers' test |C| < h failed, and the settings end the run there
    PROJECTION = "projection"  # the constraints could not be restored
    INCONSISTENT = "inconsistent"  # initial conditions break a constraint
    NOT_CONVERGED = "not-converged"  # an implicit step's iteration failed
    SINGULAR = "singular"  # a singular pose where the branch of the motion is ambiguous
    UNRESOLVED = "unresolved"  # by the run's own error estimate no output after the start has a correct digit
    COLLISION = "collision"  # two bodies came closer than the sum of their radii
    ENDLESS_EVENTS = "endless-events"  # contact events accumulate: endless bouncing (Zeno), or more than the limit
    STOP_EVENT = "stop-event"  # an event that the scene declares ended the run; its state is the last sample
    REFUSED = "refused"  # stopped before the first step, with the reason
    RESET = "reset"  # the engine restarted, or skipped time, without reporting it
    INTERRUPTED = "interrupted"
    ENGINE_ERROR = "engine-error"  # the engine reported failure


@dataclass(frozen=True)
class Timing:
    """Wall-clock seconds of the three phases of a run."""

    build_s: float = 0.0
    first_call_s: float = 0.0
    loop_s: float = 0.0


VISIBLE = 0.01  # error over the motion's size from which a plot shows it
NO_DIGIT = 0.1  # error over the motion's size from which no digit is correct
NOTABLE = 100.0  # error over the tolerance from which a note reports it; the tolerance bounds single steps


@dataclass(frozen=True)
class Estimate:
    """Estimated global error of a run, in the measure by which truths judge errors.

    A component is the largest error over bodies of position, orientation, velocity or angular velocity, divided by
    the scene's scales (mbs_ref.scene.scales). Only poses decide which digits are correct: rates jump at impacts.
    """

    times: np.ndarray  # (n_t,) s
    components: np.ndarray  # (n_t, 4) of position, orientation and their rates; infinite where there is no estimate
    how: str  # how it was estimated, one sentence
    size: float  # largest displacement or turn of the motion
    tolerance: float  # rtol times the largest coordinate
    cost_s: float  # s of wall time, outside of `timing`
    length: float = 1.0  # m, the scene's length scale
    time: float = 1.0  # s, the scene's time scale

    @property
    def over_time(self) -> np.ndarray:
        """The largest component (n_t,)."""
        return np.max(self.components, axis=1)

    @property
    def value(self) -> float:
        """The largest over the outputs."""
        return float(self.over_time[-1])

    @property
    def poses(self) -> np.ndarray:
        """The larger of position and orientation (n_t,)."""
        return np.maximum(*self.components[:, :2].T)

    @property
    def holds_until(self) -> float | None:
        """The last output time (s) before the pose error exceeds VISIBLE of the motion; None if it never does."""
        beyond = np.flatnonzero(self.poses > max(VISIBLE * self.size, self.tolerance))
        return float(self.times[max(beyond[0] - 1, 0)]) if len(beyond) else None

    @property
    def is_void(self) -> bool:
        """Whether the first output after the start may have no correct digit."""
        return bool(np.any(self.poses[1:2] > max(NO_DIGIT * self.size, self.tolerance)))

    def remark(self) -> str:
        """Return a sentence if the estimate far exceeds the tolerance, else nothing."""
        if self.holds_until is not None:
            largest = self.poses[-1] / self.size
            return (
                f"the digits hold until t = {self.holds_until:.6g} s: later the error of poses may exceed {VISIBLE:g} "
                f"of the motion's size; at the end it may be {largest:.2g} of it"
            )
        if self.poses[-1] > NOTABLE * self.tolerance:
            return (
                f"the error of poses may be {self.poses[-1]:.2g} of the scene's size, more than {NOTABLE:g} times the "
                f"relative tolerance, which is {self.tolerance:.2g} here"
            )
        return ""

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON; the value is None where it is infinite."""
        value = self.value if np.isfinite(self.value) else None
        return {"value": value, "unit": "of the scene", "how": self.how, "holds_until": self.holds_until,
                "motion_size": self.size, "cost_s": self.cost_s, "length": self.length, "time": self.time}  # fmt: skip


def pose_shapes(n_bodies: int, dimension: int) -> tuple[tuple[int, ...], ...]:
    """Return the shapes of position, orientation, velocity and angular velocity of all bodies at one time."""
    world, vectors = WORLDS[dimension], (n_bodies, dimension)
    return vectors, (n_bodies, *np.shape(world.unturned)), vectors, (n_bodies, *np.shape(world.still))


def pose_columns(bodies: Sequence[str], poses: Iterable[np.ndarray]) -> dict[str, np.ndarray]:
    """Return columns such as rod.x, rod.angle and rod.vx (n,) of the four arrays of poses and velocities (n, ...)."""
    rows = np.concatenate([part.reshape(len(part), len(bodies), -1) for part in poses], axis=2)
    words = next(world.columns for world in WORLDS.values() if len(world.columns) == rows.shape[2])
    return {f"{body}.{word}": rows[:, k, c] for k, body in enumerate(bodies) for c, word in enumerate(words)}


@dataclass(frozen=True)
class Trajectory:
    """World poses and velocities in the scene's body order; n_t is the number of output times that were reached."""

    times: np.ndarray  # (n_t,) s
    position: np.ndarray  # (n_t, n_bodies, dimension) m, centre of mass
    orientation: np.ndarray  # (n_t, n_bodies) rad in the plane; (n_t, n_bodies, 4) Euler parameters in space
    velocity: np.ndarray  # (n_t, n_bodies, dimension) m/s
    angular_velocity: np.ndarray  # (n_t, n_bodies) rad/s; (n_t, n_bodies, 3) world axes in space
    status: Status = Status.SUCCESS
    message: str = ""  # one sentence for the user
    steps: int = 0
    rejected_steps: int = 0
    rhs_calls: int = 0
    events: int = 0  # contact events located
    method_switches: int | None = None  # changes between families such as Adams and BDF, where the method reports it
    timing: Timing = field(default_factory=Timing)
    # joint -> (n_t, 3), in space (n_t, 6): force on body_b at the joint point (N, world axes) and torque (N m)
    reactions: dict[str, np.ndarray] = field(default_factory=dict)
    # contact -> (n_t, 5), in space (n_t, 7): depth (m), force on body_a (N, world axes), its point (m)
    contacts: dict[str, np.ndarray] = field(default_factory=dict)
    event_times: np.ndarray | None = None  # (n_events, 2) time (s), index in event_names; None if none are located
    event_names: tuple[str, ...] = ()  # contacts, then tension-only springs, then declared events
    method: str = ""  # of the run, where the engine reports it
    reason: str = ""  # why this method, where the engine chose it
    step_compliance: np.ndarray | None = None  # (n_samples, 2) time s, max |C| over the steps since the last sample
    # settings in use, defaults included: step (s), or rtol, and atol of lengths (m); samples; mbs_ref's carried_share
    used: dict[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()  # corrections applied, redundant rows, warnings
    estimate: Estimate | None = None  # of the error; None if switched off, if the run failed, and for other engines
    cut_steps: int = 0  # mbs_ref alone: steps that an output time shortened; outputs = 'dense' avoids them
    unreported: bool = False  # the engine reported no failure: `status` was detected from its numbers

    @classmethod
    def empty(cls, n_bodies: int, dimension: int, status: Status, message: str) -> "Trajectory":
        """Return a trajectory without samples: of a run that did not start."""
        parts = (np.zeros((0, *shape)) for shape in pose_shapes(n_bodies, dimension))
        return cls(np.zeros(0), *parts, status=status, message=message)

    @property
    def ok(self) -> bool:
        return self.status is Status.SUCCESS

    def _repr_html_(self) -> str:
        """Return the table that a notebook shows: how the run ended, and its cost."""
        bodies = self.position.shape[1] if self.position.ndim > 1 else 0
        estimate, reached = self.estimate, "nothing"
        if len(self.times):
            reached = f"{self.times[-1]:.6g} s, {len(self.times)} samples of {bodies} bodies"
        return facts("Trajectory", [
            ("status", f"{self.status}: {self.message}"), ("reached", reached),
            ("method", f"{self.method}: {self.reason}" if self.reason else self.method),
            ("steps", f"{self.steps}, {self.rejected_steps} rejected; {self.rhs_calls} right-hand sides"),
            ("settings", self.used),
            ("estimated error", None if estimate is None else f"{estimate.value:.2g} of the scene: {estimate.how}"),
            ("loop, s", self.timing.loop_s), ("notes", "; ".join(self.notes)),
        ])  # fmt: skip

    def at(self, rows: np.ndarray | slice) -> "Trajectory":
        """Return some of the samples, given by their places, a mask (n_t,) or a slice."""
        samples = {name: getattr(self, name)[rows] for name in ("times", *POSES)}
        shared = ("reactions", "contacts")
        forces = {of: {name: value[rows] for name, value in getattr(self, of).items()} for of in shared}
        return replace(self, **samples, **forces)
