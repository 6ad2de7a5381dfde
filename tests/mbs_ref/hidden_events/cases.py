"""Cases by their seed: a world whose events are exact, its units, and how a run compares with it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from mbs_ref.integrators import integrators
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Status, Trajectory
from tests.mbs_ref.hidden_events.exact import Truth, Undecided, truth
from tests.mbs_ref.hidden_events.families import FAMILIES, draw, log_uniform
from tests.mbs_ref.hidden_events.own_errors import flight_error, spring_error
from tests.mbs_ref.hidden_events.world import Level, World
from tests.mbs_ref.hidden_events.write_scene import Units, write_scene

ADAPTIVE = ("dop853", "radau", "lsodar", "dassl", "dassl_index1", "dassl_index2", "dassl_index3")
RESOLUTION = {"dop853": 1e-10, "radau": 1e-10}  # of the extent: a run's own errors; closer calls are not judged
LOOSE = 1e-7  # the same for multistep methods, whose error per step is larger at the same tolerance
FIXED = 1e-6  # the same for fixed steps, at least
SAFE = 10.0  # times the errors of a fixed step where nothing is watched
LATEST = 1e-10  # of the horizon: a time that is off by more is late, where a method's resolution is as fine
MARGIN = 0.01  # of how far a time moves with the resolution: roundoff of a distance is as much smaller
REACH = 0.1  # of the time between two events of one name: a logged time within is a late one, not another event
MOST_DRAWS = 200
STEP_ANGLE = 0.03  # rad, a fixed step turns no body by more, nor lasts more of the time that a spring holds


@dataclass(frozen=True, eq=False)
class Case:
    """A scene with hidden events: what happens, and when, is known in closed form."""

    family: str
    seed: int
    world: World
    units: Units

    @cached_property
    def scene(self) -> Scene:
        """The scene in SI units."""
        return write_scene(f"{self.family}_{self.seed}", self.world, self.units)

    @lru_cache(maxsize=64)  # noqa: B019
    def truth(self, resolution: float) -> Truth | None:
        """Return the events, or None where they depend on less than `resolution` of the extent."""
        try:
            return truth(self.world, resolution)
        except Undecided:
            return None

    @lru_cache(maxsize=64)  # noqa: B019
    def resolution(self, method: str) -> float:
        """Return the share of the extent below which a method's own errors decide what happens."""
        if method in ADAPTIVE:
            return RESOLUTION.get(method, LOOSE)
        flight = flight_error(self.world, self.units, self.settings(method, 101))
        return max(FIXED, SAFE * flight, spring_error(self.world, integrators()[method].order, STEP_ANGLE))

    def settings(self, method: str, samples: int) -> Settings:
        """Return tight tolerances, or a fixed step that turns no body by more than STEP_ANGLE."""
        more = {"method": method, "samples": samples, "estimate": "off", "reactions": False}
        if method in ADAPTIVE:
            return Settings.model_validate(more | {"rtol": 1e-12})
        spins = [float(np.linalg.norm(body.spin)) for body in self.world.bodies]
        holds = [watch.hold for watch in self.world.watches if not isinstance(watch, Level) and watch.hold]
        step = min(self.world.horizon / 200.0, STEP_ANGLE / (max(spins) or 1.0), *(STEP_ANGLE * hold for hold in holds))
        return Settings.model_validate(more | {"step": step * self.units.time})


def case(family: str, seed: int) -> Case:
    """Return the case of a seed: the first draw whose events are decided at the finest resolution."""
    rng = np.random.default_rng([list(FAMILIES).index(family), seed])
    for _ in range(MOST_DRAWS):
        world = draw(family, rng, 2 + seed % 2)
        length, mass = log_uniform(rng, 1e-3, 1e3), log_uniform(rng, 1e-3, 1e3)
        time = max(log_uniform(rng, 1e-3, 1e2), length / 1e3)  # s; speeds to some 1e6 m/s
        drawn = Case(family, seed, world, Units(length, time, mass))
        if drawn.truth(min(RESOLUTION.values())) is not None:
            return drawn
    raise ValueError(f"no decided draw of {family} at seed {seed}")


@dataclass(frozen=True)
class Comparison:
    """How a run's events differ from the exact ones, up to the first difference."""

    verdict: str  # good, late, missed, invented, undecided, or the status of a run that failed
    expected: int = 0
    error: float = 0.0  # the largest error of a time until the first difference, of the horizon
    message: str = ""


def compare(hidden: Case, run: Trajectory, method: str) -> Comparison:
    """Compare by name and time. The first difference decides: what follows it is another motion."""
    resolution = hidden.resolution(method)
    exact = hidden.truth(resolution)
    if exact is None:
        return Comparison("undecided")
    if run.status is not Status.SUCCESS:
        return Comparison(str(run.status), len(exact.events), message=run.message)
    assert run.event_times is not None
    horizon, (when, which) = hidden.world.horizon, run.event_times.T
    differences: list[tuple[float, str]] = []
    errors: list[tuple[float, float, float]] = []  # time, error, allowed
    for watch in hidden.world.watches:
        one = [k for k, event in enumerate(exact.events) if event.name == watch.name]
        times = np.array([exact.events[k].time for k in one])
        allowed = LATEST * horizon + MARGIN * exact.moved[one]
        logged = np.sort(when[which == run.event_names.index(watch.name)]) / hidden.units.time
        reach = np.maximum(1e3 * resolution * horizon, 10.0 * exact.moved[one])
        near = np.minimum(REACH * _spacing(times, horizon), 1e-4 * horizon)
        missing, extra, pairs = _matched(times, logged, np.maximum(reach, near))
        differences += [(times[k], "missed") for k in missing] + [(logged[k], "invented") for k in extra]
        errors += [(times[k], abs(logged[i] - times[k]), allowed[k]) for k, i in pairs]
    until, verdict = min(differences, default=(np.inf, "good"))
    before = [(error, allowed) for time, error, allowed in errors if time < until]
    if verdict == "good" and resolution <= LATEST and any(error > allowed for error, allowed in before):
        verdict = "late"
    return Comparison(verdict, len(exact.events), max((error for error, _ in before), default=0.0) / horizon)


def _spacing(times: np.ndarray, horizon: float) -> np.ndarray:
    """Return how far each time is from the nearest other."""
    apart = np.diff(times, prepend=-horizon, append=2.0 * horizon)
    return np.minimum(apart[1:], apart[:-1])


def _matched(
    times: np.ndarray, logged: np.ndarray, within: np.ndarray
) -> tuple[list[int], list[int], list[tuple[int, int]]]:
    """Pair each exact time with the nearest free logged one within reach; return unpaired ones, and pairs."""
    free, pairs, missing = set(range(len(logged))), [], []
    for k, time in enumerate(times):
        nearest = min(free, key=lambda i: abs(logged[i] - time), default=None)
        if nearest is None or abs(logged[nearest] - time) > within[k]:
            missing.append(k)
        else:
            free.remove(nearest)
            pairs.append((k, nearest))
    return missing, sorted(free), pairs
