"""What an integrator receives and what it returns: one smooth leg between declared breakpoints."""

from collections import namedtuple
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from mbs_ref.trajectory import Status

if TYPE_CHECKING:
    from mbs_ref.cores.system import System
    from mbs_ref.scene import Scene

# Codes shared with compiled loops.
RUNNING, DONE, NON_FINITE, STEP_TOO_SMALL, TOO_MANY_STEPS = range(5)
COMPLIANCE, PROJECTION, NOT_CONVERGED, SINGULAR, STALLED, ENDLESS_EVENTS, STOP_EVENT = range(5, 12)
NEAR_SINGULAR = 12  # nothing ends: DOP853 carries the method on (loop/crossing.py)
COLLISION = 13  # two free bodies came closer than the sum of their radii
ENDS: dict[int, tuple[Status, str]] = {  # the status of a leg that ends so, and its sentence
    DONE: (Status.SUCCESS, ""),
    NON_FINITE: (Status.NON_FINITE, "a state or acceleration became infinite or NaN"),
    STEP_TOO_SMALL: (Status.STEP_TOO_SMALL, "the step needed for the asked accuracy fell below the resolution of time"),
    TOO_MANY_STEPS: (Status.TOO_MANY_STEPS, "the limit on steps was reached"),
    COMPLIANCE: (Status.COMPLIANCE, "the constraint-compliance test |C| < h failed"),
    PROJECTION: (Status.PROJECTION, "the constraints could not be restored by projection"),
    NOT_CONVERGED: (Status.NOT_CONVERGED, "the iteration of an implicit step did not converge"),
    SINGULAR: (Status.SINGULAR, "the constraint Jacobian is rank-deficient and the motion's branch is ambiguous"),
    STALLED: (Status.STEP_TOO_SMALL, "steps have become so short that the rest of the run is out of reach"),
    ENDLESS_EVENTS: (
        Status.ENDLESS_EVENTS,
        "contact events follow each other without end (endless bouncing, or more than max_events)",
    ),
    STOP_EVENT: (Status.STOP_EVENT, "a declared event asked the run to stop"),
    COLLISION: (Status.COLLISION, "two bodies collided"),
}

FEWEST = 4  # steps in a leg between declared breakpoints, however short: a pulse is not one step's business


class Options(NamedTuple):
    """Settings as compiled loops take them."""

    step: float  # s, fixed step; 0 when adaptive
    rtol: float
    atol: np.ndarray  # (n_state,) in the state's units
    units: np.ndarray  # (n_state,) what each entry of the state counts in: L, 1 rad, and the same over T
    time: float  # s, T of the scene
    project: bool
    stop_on_compliance: bool
    max_steps: int
    projection_tolerance: float  # m, rad
    max_events: int
    chunk: int  # steps before compiled code returns to Python, so that Ctrl-C acts
    dense: bool  # outputs are interpolated inside of steps, and do not end them
    settle: int  # address of the code that changes modes at events (loop/events.py); 0 in a scene without
    watch: int  # likewise, of the code that looks for events inside a step
    between: int  # address of the code that interpolates outputs (loop/explicit.py); 0 unless `dense`


# The state of a run, over chunks and legs: one record, whose fields Python and compiled code read and write alike.
PROGRESS = np.dtype((np.record, [
    ("t", float),  # s
    ("h", float),  # s, next step
    ("h_before", float),  # s, step before
    ("span", float),  # s, of the leg
    ("carried", float),  # s, passed by DOP853 where the method could not (loop/crossing.py)
    ("compliance", float),  # largest |C| since the last sample
    ("steps", np.int64),
    ("rejected", np.int64),
    ("cut", np.int64),  # steps that end at an output, where accuracy allows longer ones
    ("rhs_calls", np.int64),
    ("next_output", np.int64),  # place among the leg's times
    ("events", np.int64),
    ("event_source", np.int64),  # of the last event
    ("switches", np.int64),  # between a method's families
    ("near_singular", np.int64),  # explicit steps so close to a singular pose that their stages are projected
    ("needs_tangent", np.int64),  # 1 once corrections with the mass matrix alone have failed
]))  # fmt: skip
Progress = np.record


def progress(t: float) -> Progress:
    """Return the state of a run that starts at t."""
    run = np.zeros(1, PROGRESS)[0]
    run["t"] = t
    return run


Figures = namedtuple("Figures", list(PROGRESS.fields or ()))


def figures_of(run: Progress) -> Figures:
    """Return the numbers of a run's state as Python has them: a record looks each of its fields up slowly."""
    return Figures(*run.item())


class Outputs(NamedTuple):
    """What a compiled loop fills; the first of each is the start."""

    times: np.ndarray  # (n_times,) s, of outputs
    states: np.ndarray  # (n_times, n_state)
    compliance: np.ndarray  # (n_times,) largest |C| over the steps since the time before


@dataclass
class Leg:
    """States at the output times of one leg; `reached` of them are valid."""

    states: np.ndarray  # (n_times, n_state), the first is the start
    compliance: np.ndarray  # (n_times,) largest |C| over the steps up to each time
    reached: int
    status: Status
    message: str = ""


class Pace:
    """Watches for a run that creeps: twice in a row a stretch of steps at which max_steps would not suffice."""

    def __init__(self, start: float, end: float, max_steps: int, every: int) -> None:
        self.least = (end - start) * every / max_steps  # s, progress expected of every stretch
        self.every = every
        self.mark, self.slow = start, 0
        self.seen = 0

    def is_hopeless(self, t: float, steps: int) -> bool:
        """Return whether to give up, after `steps` steps that reached t (s)."""
        if steps - self.seen < self.every:
            return False
        self.slow = self.slow + 1 if t - self.mark < self.least else 0
        self.mark, self.seen = t, steps
        return self.slow >= 2


Advance = Callable[["System", Options, Progress, np.ndarray, np.ndarray], Leg]


@dataclass(frozen=True)
class Integrator:
    """One method of integration, as listed by `mbs_ref.integrators`."""

    name: str
    kind: Literal["fixed", "adaptive", "both"]
    order: int
    description: str
    advance: Advance  # (system, options, progress, y, times of the leg) -> Leg
    stabilization: Literal["none", "projection"] = "projection"  # default
    stabilizations: tuple[str, ...] = ("none", "baumgarte", "projection")  # allowed
    ladder: tuple[float, ...] = ()  # steps (s) or rtols for sweeps, coarse to fine
    source: str = ""
    requires: frozenset[str] = frozenset()  # traits the scene must have: the cores that answer what the method asks
    locates_events: bool = True  # touch-down, lift-off and slip are located; else contact forces are merely clipped
    stability: tuple[float, ...] = ()  # explicit methods: coefficients of R(z), lowest power first
    weakness: str = ""  # why the method is known to fail or stand wrong where others do not: shown, never judged by
    embedded: int | None = None  # order of the solution that the estimate of errors compares with, as in 5(4)
    varies_order: bool = False  # besides the step: its errors follow the tolerance loosely
    slack: float = 1.0  # how many times the tolerance a step may err and be accepted
    switches: str = ""  # the families between which the method changes and says so
    package: str | None = None  # optional third-party package it needs
    holds_deflections: bool = True  # carries the deflections of sticking contacts, which are states in space
    needs_positions: bool = False  # imposes every C = 0 on positions: no rows on velocities alone
    interpolates: bool = False  # has dense output of its own order
    refusals: "Callable[[Scene], Iterable[str]]" = lambda _: ()  # what keeps it from running a scene
    prepare: "Callable[[System], object]" = lambda _: None  # builds what the method alone needs of a system
    cores: tuple[str, ...] = ()  # the only cores it runs on (mbs_ref.cores.choice.core_name); empty for all


def run_chunks(
    chunk: Callable[[Outputs], int], options: Options, run: Progress, y: np.ndarray, times: np.ndarray
) -> Leg:
    """Call a compiled loop, which fills the outputs, until it ends or creeps; Ctrl-C acts between."""
    outputs = Outputs(times, np.empty((len(times), len(y))), np.zeros(len(times)))
    outputs.states[0] = y
    run["next_output"], run["span"] = 1, times[-1] - times[0]
    pace = Pace(float(times[0]), float(times[-1]), options.max_steps, options.chunk)
    code = RUNNING
    while code == RUNNING:
        code = chunk(outputs)
        if code == RUNNING and pace.is_hopeless(float(run.t), int(run.steps)):
            code = STALLED
    status, words = ENDS[code]
    sentence = words and f"at t = {run.t:.9g} s {words}"
    return Leg(outputs.states, outputs.compliance, int(run["next_output"]), status, sentence)
