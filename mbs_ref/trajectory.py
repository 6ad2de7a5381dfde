"""What every engine returns: world poses and velocities at the asked times, and how the run ended."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import numpy as np

from mbs_ref.display import facts


class Status(StrEnum):
    """How a run ended. Only SUCCESS vouches for every asked time."""

    SUCCESS = "success"
    NON_FINITE = "non-finite"  # NaN or infinity arose
    STEP_TOO_SMALL = "step-too-small"  # t + h == t, or the error test could not be met
    TOO_MANY_STEPS = "too-many-steps"
    COMPLIANCE = "compliance"  # the papers' test |C| < h failed and was asked to stop
    PROJECTION = "projection"  # the constraints could not be restored
    INCONSISTENT = "inconsistent"  # initial conditions break a constraint
    NOT_CONVERGED = "not-converged"  # an implicit step's iteration failed
    SINGULAR = "singular"  # a singular pose where the branch of the motion is ambiguous
    UNRESOLVED = "unresolved"  # by the run's own estimate no output after the start has a digit that holds
    COLLISION = "collision"  # two bodies came closer than the sum of their radii
    ENDLESS_EVENTS = "endless-events"  # contact events accumulate: endless bouncing (Zeno), or more than allowed
    STOP_EVENT = "stop-event"  # an event that the scene declares ended the run; its state is the last sample
    REFUSED = "refused"  # stopped before the first step, with the reason
    RESET = "reset"  # the engine restarted or skipped time behind the caller's back
    INTERRUPTED = "interrupted"
    ENGINE_ERROR = "engine-error"  # the engine reported failure


@dataclass(frozen=True)
class Timing:
    """Wall-clock seconds of the three phases of a run."""

    build_s: float = 0.0
    first_call_s: float = 0.0
    loop_s: float = 0.0


SEEN = 0.01  # of the motion's size: an error beyond is seen with the naked eye
DIGIT = 0.1  # of the motion's size: an error beyond leaves not one digit, and is another motion
PROMISED = 100.0  # times the tolerance, which bounds the error of one step alone: more than that is said


@dataclass(frozen=True)
class Estimate:
    """How far a run may be off, by its own account, in the quantity by which truths judge errors.

    That is the largest over bodies of position, orientation, velocity and angular velocity, each over the scene's own
    scales (mbs_ref.scene.scales). Digits are counted by poses alone: rates jump where bodies hit.
    """

    times: np.ndarray  # (n_t,) s
    components: np.ndarray  # (n_t, 4) of position, orientation and their rates; infinite where nothing vouches for them
    how: str  # one sentence
    size: float  # how far the motion goes in position or orientation
    tolerance: float  # rtol times the largest coordinate
    cost_s: float  # s of wall time, outside of `timing`
    length: float = 1.0  # m, the scene's, which positions count in
    time: float = 1.0  # s

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
        return np.max(self.components[:, :2], axis=1)

    @property
    def holds_until(self) -> float | None:
        """The last output (s) whose pose may be off by less than SEEN of the motion, or the tolerance; None: the end."""
        beyond = np.flatnonzero(self.poses > max(SEEN * self.size, self.tolerance))
        return float(self.times[max(beyond[0] - 1, 0)]) if len(beyond) else None

    @property
    def is_void(self) -> bool:
        """Whether already the first output after the start may have no digit."""
        return bool(np.any(self.poses[1:2] > max(DIGIT * self.size, self.tolerance)))

    def remark(self) -> str:
        """Return a sentence where the estimate is more than was asked for, or nothing."""
        if self.holds_until is not None:
            return (f"the digits hold until t = {self.holds_until:.6g} s: beyond, poses may be off by more than {SEEN:g} "
                    f"of the motion, by up to {self.poses[-1] / self.size:.2g} of it")  # fmt: skip
        if self.poses[-1] > PROMISED * self.tolerance:
            return (f"poses may be off by {self.poses[-1]:.2g} of the scene, more than {PROMISED:g} times the relative "
                    f"tolerance, which is {self.tolerance:.2g} here")  # fmt: skip
        return ""

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON; the value is None where it is infinite."""
        value = self.value if np.isfinite(self.value) else None
        return {"value": value, "unit": "of the scene", "how": self.how, "holds_until": self.holds_until,
                "motion_size": self.size, "cost_s": self.cost_s, "length": self.length, "time": self.time}  # fmt: skip


@dataclass(frozen=True)
class Trajectory:
    """World poses and velocities; n_t is the number of times reached, in the scene's body order."""

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
    method_switches: int | None = None  # changes between families such as Adams and BDF, where the method tells
    timing: Timing = field(default_factory=Timing)
    reactions: dict[str, np.ndarray] = field(
        default_factory=dict
    )  # joint -> (n_t, 3): force on body_b at the joint point (N, N, world) and torque (N m)
    contacts: dict[str, np.ndarray] = field(
        default_factory=dict
    )  # contact -> (n_t, 5), in space (n_t, 7): depth (m), force on body_a (N, world), its point (m)
    event_times: np.ndarray | None = (
        None  # (n_events, 2) time s and index in event_names, where the engine locates events
    )
    event_names: tuple[str, ...] = ()  # contacts, then tension-only springs, then declared events
    method: str = ""  # that made the run, where the engine tells
    reason: str = ""  # why that one, where the engine was left to choose
    step_compliance: np.ndarray | None = None  # (n_samples, 2) time s, max |C| over the steps since the last sample
    used: dict[str, float] = field(
        default_factory=dict
    )  # settings the run had, defaults included: step (s), or rtol, and atol of lengths (m); samples; of ours also carried_share, by DOP853
    notes: tuple[str, ...] = ()  # what the user should know: corrections applied, redundant rows, warnings
    estimate: Estimate | None = None  # of the error; None where it is switched off, where the run failed, and elsewhere
    cut_steps: int = (
        0  # of ours: steps that an output ended before accuracy asked for it; outputs = 'dense' spares them
    )
    unreported: bool = (
        False  # the engine itself said nothing: the failure in `status` was found by looking at its numbers
    )

    @property
    def ok(self) -> bool:
        return self.status is Status.SUCCESS

    def _repr_html_(self) -> str:
        """Return what a notebook shows: how the run ended, and what it cost."""
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

    def upto(self, count: int) -> Trajectory:
        """Return the first `count` samples."""
        from dataclasses import replace

        return replace(
            self,
            times=self.times[:count],
            position=self.position[:count],
            orientation=self.orientation[:count],
            velocity=self.velocity[:count],
            angular_velocity=self.angular_velocity[:count],
            reactions={name: value[:count] for name, value in self.reactions.items()},
            contacts={name: value[:count] for name, value in self.contacts.items()},
        )
