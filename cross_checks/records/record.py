"""One run, judged: the line of JSON that reports, sweeps and history read."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

MARGIN = 30.0  # a truth this many times better known than an error judges it


@dataclass(frozen=True)
class Error:
    """Distance from the truth, and how well the truth is known."""

    value: float  # largest distance over bodies and times of body reference points
    unit: str  # m
    truth: str  # exact | published | converged | ephemeris, and where it comes from
    uncertainty: float  # of the truth, same unit
    final: float  # at the last time alone

    @property
    def bound(self) -> float:
        """What the error is at most (m): the distance and the truth's own uncertainty."""
        return self.value + self.uncertainty

    @property
    def floor(self) -> float:
        """The smallest error (m) that this truth can judge."""
        return MARGIN * self.uncertainty

    @property
    def is_judged(self) -> bool:
        """Whether the truth is known well enough to judge this error."""
        return self.value >= self.floor


@dataclass(frozen=True)
class Record:
    """The result of (scene, engine, settings). Numbers are finite or None with a reason in `message`."""

    scene: str
    parameters: dict[str, Any]
    engine: str
    method: str
    settings: dict[str, Any]
    status: str  # of mbs_ref.trajectory.Status, or cannot | engine-missing | crashed | timeout | out-of-memory
    message: str
    t_end: float  # s, reached
    steps: int
    rhs_calls: int
    final: dict[str, dict[str, Any]]  # body -> position, angle or orientation, velocity, angular_velocity
    compliance: dict[
        str, float | None
    ]  # position (m, rad), velocity (m/s, rad/s): largest over samples and, in-house, every step
    energy_drift: float | None  # J, largest |E(t) - E(0) - work| where the energy balance is defined
    momentum_drift: float | None
    error: Error | None
    reaction_error: float | None  # N, N m
    times: dict[str, float]  # build_s, first_call_s, loop_s
    versions: dict[str, str]
    notes: tuple[str, ...] = ()
    orientation_error: float | None = None  # rad, largest geodesic angle from the truth; spatial scenes
    figures: dict[str, float] = field(
        default_factory=dict
    )  # body -> significant figures at the end, against an ephemeris
    contact: dict[str, float] = field(default_factory=dict)  # restitution, penetration, ... by "contact: figure, unit"
    events: dict[str, list[float]] = field(default_factory=dict)  # declared event -> its times (s), where located
    estimate: dict[str, Any] | None = None  # of the error, by the run itself: value, unit, how, holds_until (s), ...
    history: dict[str, list[float]] = field(default_factory=dict)  # t, compliance, energy_drift, error, estimate

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return asdict(self)
