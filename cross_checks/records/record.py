"""One run, judged: what reports, sweeps and history read; the machine it is timed on, and whether it may be ranked."""

import platform
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from mbs_ref import Settings, Status, scenes
from mbs_ref.display import facts

CANNOT, MISSING = "cannot", "engine-missing"  # statuses of what was refused, and of what no installed package runs


@dataclass(frozen=True)
class Error:
    """Distance from the truth over the scene's own scales, and how well the truth is known in the same measure.

    The largest over components (position, orientation, velocity, angular velocity), bodies and times; see
    mbs_ref.observables.distance. Each component in its own unit is among the record's measures. Rates count where they
    are known to a figure; the uncertainty is that of poses, which holds with a probability of 95 %.
    """

    value: float
    truth: str  # exact | published | converged | agreed | one-package, and where it comes from
    uncertainty: float  # of the truth
    final: float | None  # at the last time alone; None where the truth knows nothing there
    worst: str = "position"  # the component that is largest, and of which body
    length: float = 1.0  # m, what a position counts in
    time: float = 1.0  # s

    @property
    def bound(self) -> float:
        """What the error is at most: the distance and the truth's own uncertainty."""
        return self.value + self.uncertainty

    @property
    def is_judged(self) -> bool:
        """Whether the run is farther off than the truth's uncertainty explains."""
        return self.value > self.uncertainty

    @property
    def metres(self) -> float:
        """The error as a length: its value times the scene's."""
        return self.value * self.length


@dataclass(frozen=True)
class Record:
    """The result of (scene, engine, settings). Numbers are finite or None with a reason in `message` or `notes`."""

    scene: str
    parameters: dict[str, Any]
    engine: str
    method: str
    settings: dict[str, Any]
    status: str  # of mbs_ref.trajectory.Status, or cannot | engine-missing | crashed | timeout | out-of-memory
    message: str = ""
    t_end: float = 0.0  # s, reached
    steps: int = 0
    rhs_calls: int = 0
    final: dict[str, dict[str, Any]] = field(default_factory=dict)  # body -> position, angle or orientation, rates
    measures: dict[str, float | None] = field(default_factory=dict)  # by the name of a metric (cross_checks.metrics)
    bounds: dict[str, float] = field(default_factory=dict)  # what unknown measures are at most, where that is known
    error: Error | None = None
    times: dict[str, float] = field(default_factory=dict)  # build_s, first_call_s, loop_s, cpu_share (of a processor)
    versions: dict[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    figures: dict[str, float] = field(default_factory=dict)  # body -> significant figures, against an ephemeris
    contact: dict[str, float] = field(default_factory=dict)  # restitution, ... by "contact: figure, unit"
    events: dict[str, list[float]] = field(default_factory=dict)  # declared event -> its times (s), where located
    estimate: dict[str, Any] | None = None  # of the error, by the run itself: value, unit, how, holds_until (s), ...
    # curves over time: t, error, estimate and the plotted metrics
    history: dict[str, list[float | None]] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """The scene with its parameters, as the command line takes them."""
        return scenes.label(self.scene, self.parameters)

    def measure(self, name: str) -> float | None:
        """Return a metric's figure; None where it is not defined."""
        return self.measures.get(name)

    def at_most(self, name: str) -> float | None:
        """Return a metric's figure, or what it is at most where it is unknown; None where that is unknown, too."""
        value = self.measure(name)
        return self.bounds.get(name) if value is None else value

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return asdict(self)

    def _repr_html_(self) -> str:
        """Return what a notebook shows: how the run ended, and how far it is from the truth."""
        usual, error = Settings().model_dump(mode="json"), self.error
        chosen = {name: value for name, value in self.settings.items() if value != usual.get(name)}
        off = None if error is None else f"{error.value:.2g} of the scene ({error.worst}), {error.metres:.2g} m"
        truth = None if error is None else f"{error.truth}, known to {error.uncertainty:.2g} of the scene"
        return facts(f"{self.scene}: {self.engine} {self.method}", [
            ("settings", chosen), ("status", f"{self.status}: {self.message}" if self.message else self.status),
            ("error", off), ("truth", truth), ("loop, s", self.times.get("loop_s")),
            *self.measures.items(), *((name, f"below {bound:.2g}") for name, bound in self.bounds.items()),
            ("notes", "; ".join(self.notes)),
        ])  # fmt: skip


BUSY = 0.9  # of a processor: with less, a run shares the machine
WARMED = 0.2  # s of loop time: warming caches up is a small part of a longer run, which counts
CPU_FACTS = Path("/proc/cpuinfo")  # Linux; elsewhere the platform module knows
BUSY_NOTE = "timed on a busy machine"


def processor() -> str:
    """Return the processor's name."""
    lines = CPU_FACTS.read_text().splitlines() if CPU_FACTS.exists() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return next(iter(models), platform.processor() or platform.machine())


@cache
def machine() -> str:
    """Return what times compare on: the computer and its processor."""
    return f"{platform.node()} {processor()}"


def usable(record: Record) -> bool:
    """Return whether the run finished, was measured against a truth, and has a loop time."""
    return record.status == Status.SUCCESS and record.error is not None and record.times.get("loop_s", 0.0) > 0.0


def out_of_memory(error: BaseException) -> str:
    """Return what a MemoryError says, which may be nothing, and the next step."""
    return f"{f'memory is exhausted: {error}'.removesuffix(': ')}; request fewer samples or runs at once"


def known_error(record: Record) -> float:
    """Return the error with the truth's uncertainty added."""
    assert record.error is not None
    return record.error.bound


def floor(records: Iterable[Record]) -> float:
    """Return the uncertainty of the records' truth, below which it resolves no error."""
    return max((record.error.uncertainty for record in records if record.error), default=0.0)


def loop_time(record: Record) -> float:
    """Return the loop time (s) by which runs are ranked."""
    return record.times.get("loop_s", float("inf"))


def is_timed(record: Record) -> bool:
    """Whether the loop was timed with a processor to itself, a short one several times."""
    return "loop_runs" in record.times


def is_busy(record: Record) -> bool:
    """Whether the loop was timed while others used the machine."""
    return BUSY_NOTE in record.notes


def best_of_engines(records: Sequence[Record], target: float = 1e-6) -> list[Record]:
    """Return one record for each engine: its cheapest within `target`, else its most accurate, else its last."""

    def preference(record: Record) -> tuple[int, float]:
        if not usable(record):
            return (2, 0.0)
        error = known_error(record)
        return (0, loop_time(record)) if error <= target else (1, error)

    names = dict.fromkeys(record.engine for record in records)
    return [min((r for r in reversed(records) if r.engine == name), key=preference) for name in names]
