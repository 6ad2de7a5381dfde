"""The plan of a run: its consistent start, method, output times, steps, tolerances; and how its loop ended."""

import math
from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from cross_checks.engine.method import Method
from mbs_ref import Scene, Settings, Status, Trajectory
from mbs_ref.observables import rows
from mbs_ref.scene import Revolute, Weld


def initial_sample(scene: Scene) -> Trajectory:
    """Return the scene's own initial state as a trajectory of one sample."""
    world = scene.world
    names = ("position", ()), (world.orientation, world.unturned), ("velocity", ()), ("angular_velocity", world.still)
    parts = [[getattr(body, name, default) for body in scene.bodies] for name, default in names]
    position, turn, velocity, spin = (np.array(part, dtype=float)[None] for part in parts)
    return Trajectory(np.zeros(1), position, turn, velocity, spin)


def inconsistency(scene: Scene, tolerance: float) -> str:
    """Return why engines that take one world point a joint cannot start the scene, or nothing."""
    for joint in scene.joints:
        if isinstance(joint, Revolute | Weld) and joint.point_b is not None:
            gap = math.dist(joint.point, joint.point_b)
            if gap > 0.0:
                return f"joint {joint.name!r} starts {gap:.3g} m open, and only mbs_ref closes such loops"
    return broken_start(scene, tolerance)


def broken_start(scene: Scene, tolerance: float) -> str:
    """Return a sentence on the joint farthest from satisfied at t = 0, if it is farther than the tolerance."""
    constraints = rows(scene, initial_sample(scene))
    gaps = np.abs([constraints.residual[0], constraints.rate[0]])  # (2, n_rows) m or rad; m/s or rad/s
    if gaps.max(initial=0.0) <= tolerance:
        return ""
    joint = constraints.joints[int(np.argmax(gaps.max(axis=0)))]
    position, velocity = gaps[:, [name == joint for name in constraints.joints]].max(axis=1)
    return (
        f"the initial state breaks joint {joint!r} by {position:.3g} (m, rad) and {velocity:.3g} (m/s, rad/s), "
        f"more than initial_tolerance = {tolerance:g}"
    )


def stopped(scene: Scene, status: Status, message: str) -> Trajectory:
    """Return a trajectory without samples."""
    return Trajectory.empty(len(scene.bodies), scene.dimension, status, message)


@dataclass(frozen=True)
class End:
    """How the engine's loop ended: how many samples it vouches for, and why it stopped there."""

    samples: int
    status: Status = Status.SUCCESS
    message: str = ""
    unreported: bool = False  # the engine itself did not complain


@dataclass(frozen=True)
class Loop:
    """The result of an engine's loop: states at the output times, how it ended, and its counts of work."""

    states: np.ndarray  # (n_t, n) one row an output time, in the engine's own terms
    end: End
    steps: int = 0
    rhs_calls: int = 0
    rejected_steps: int = 0


def end_of(states: np.ndarray, times: np.ndarray, end: End) -> End:
    """Return the end, moved ahead to the first sample (row of `states`) that is not finite."""
    finite = np.isfinite(states[: end.samples]).all(axis=1)
    good = end.samples if finite.all() else int(np.argmin(finite))
    if good == end.samples:
        return end
    last = f"the last finite sample is at t = {times[good - 1]:g} s" if good else "no sample is finite"
    cause = f" ({end.message})" if end.message else ""
    silent = end.status in (Status.SUCCESS, Status.RESET)
    return End(good, Status.NON_FINITE, f"NaN or infinity arose before t = {times[good]:g} s; {last}{cause}", silent)


DEFAULT_STEP = 1e-3  # s, the largest step chosen when none is given
DEFAULT_RTOL = 1e-9
SLACK = 1e-9  # of a step: how exactly a step must divide an output interval


@dataclass(frozen=True)
class Plan:
    """A run whose settings have been understood."""

    method: Method
    times: np.ndarray  # (n_t,) s
    step: float = 0.0  # s, fixed-step methods
    counts: tuple[int, ...] = ()  # steps between output times, fixed-step methods
    rtol: float = 0.0
    atol: float = 0.0
    max_steps: int = Settings().max_steps

    @property
    def used(self) -> dict[str, float]:
        """Return the settings that the run really has, defaults included."""
        accuracy = {"step": self.step} if self.method.kind == "fixed" else {"rtol": self.rtol, "atol": self.atol}
        return {**accuracy, "samples": len(self.times)}


class Planned(Protocol):
    """What of an engine a plan depends on."""

    name: ClassVar[str]

    def method(self, name: str | None) -> Method: ...
    def refusal(self, scene: Scene, method: Method) -> str: ...


def plan_run(engine: Planned, scene: Scene, settings: Settings, times: np.ndarray | None) -> Plan | Trajectory:
    """Return the plan, or a trajectory without samples that says why the scene is not run.

    ValueError where a setting other than method, step, tolerances and times differs from its default.
    """
    method = engine.method(settings.method)
    _check_settings(engine.name, method, settings)
    grid = step_grid(scene, settings) if times is None and settings.step else output_times(scene, settings, times)
    if grid.ndim != 1 or len(grid) < 2 or grid[0] != 0.0 or not np.all(np.diff(grid) > 0.0):
        raise ValueError("times must be at least two increasing numbers, the first 0")
    if refusal := engine.refusal(scene, method):
        return stopped(scene, Status.REFUSED, refusal)
    if broken := inconsistency(scene, settings.initial_tolerance):
        return stopped(scene, Status.INCONSISTENT, broken)
    if method.kind == "adaptive":
        rtol = settings.rtol or DEFAULT_RTOL
        return Plan(method, grid, rtol=rtol, atol=settings.atol or rtol, max_steps=settings.max_steps)
    step = settings.step or default_step(grid)
    counts = step_counts(grid, step)
    if sum(counts) > settings.max_steps:
        raise ValueError(f"step = {step:g} needs {sum(counts)} steps, more than max_steps = {settings.max_steps}")
    return Plan(method, grid, step, counts, max_steps=settings.max_steps)


def _check_settings(engine: str, method: Method, settings: Settings) -> None:
    if method.kind == "fixed" and (settings.rtol is not None or settings.atol is not None):
        raise ValueError(f"rtol, atol = {settings.rtol}, {settings.atol}: {method.name} takes a step instead")
    if method.kind == "adaptive" and settings.step is not None:
        raise ValueError(f"step = {settings.step}: {method.name} takes rtol and atol instead")
    defaults = Settings()
    for name in ("coordinates", "stabilization", "baumgarte_gain", "stop_on_compliance", "project_initial", "outputs"):
        value, default = getattr(settings, name), getattr(defaults, name)
        if value != default:
            raise ValueError(f"{name} = {value!r} is not offered by {engine}; allowed: {default!r}")
    if settings.events == "located" and not method.locates_events:
        raise ValueError(f"events = 'located': {method.name} of {engine} locates no events; allowed: 'none'")


def output_times(scene: Scene, settings: Settings, times: np.ndarray | None) -> np.ndarray:
    """Return the requested times, or the settings' even grid (s)."""
    if times is not None:
        return np.asarray(times, dtype=float)
    t_end = settings.t_end if settings.t_end is not None else scene.duration
    return np.linspace(0.0, t_end, settings.samples)


def step_grid(scene: Scene, settings: Settings) -> np.ndarray:
    """Return the output times (s): the settings' number of samples, rounded to multiples of the step."""
    t_end = settings.t_end if settings.t_end is not None else scene.duration
    assert settings.step is not None
    (whole,) = step_counts(np.array([0.0, t_end]), settings.step)
    samples = min(settings.samples, whole + 1)
    times = np.unique(np.linspace(0, whole, samples).round()) * settings.step
    times[-1] = t_end
    return times


def default_step(times: np.ndarray) -> float:
    """Return the largest step up to DEFAULT_STEP that divides the smallest output interval."""
    interval = float(np.min(np.diff(times)))
    return interval / np.ceil(interval / DEFAULT_STEP * (1.0 - SLACK))


def step_counts(times: np.ndarray, step: float) -> tuple[int, ...]:
    """Return the whole numbers of steps between output times; ValueError names the nearest steps allowed."""
    total = times / step
    if np.any(np.abs(total - np.rint(total)) > SLACK * np.maximum(1.0, total)):
        interval = float(np.min(np.diff(times)))
        fewer = max(1, int(interval / step))
        raise ValueError(
            f"step = {step:g} s does not divide the output times (smallest interval {interval:g} s); allowed: "
            f"{interval / fewer:.12g} or {interval / (fewer + 1):.12g}, or any whole fraction of the interval"
        )
    return tuple(int(n) for n in np.diff(np.rint(total)))
