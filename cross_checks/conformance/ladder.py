"""One method on one scene, from coarse to fine: do its deviations from what is right converge to zero?

Errors from the truth, and how far velocities, energy and joints are off, are data of the one convergence model.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import make_interp_spline

from cross_checks.conformance.apart import Called, called
from cross_checks.conformance.clock import impossible_time
from cross_checks.conformance.finding import Finding, Row, verdict
from cross_checks.conformance.questions import Question, rungs
from cross_checks.engine import Engine
from cross_checks.engine.method import Method
from cross_checks.engine.plan import initial_sample
from cross_checks.judge.bounds import AGREEMENT, EVEN, FAILING, RESOLVED, SCATTER, TARGETS
from cross_checks.judge.convergence.ladder import Ladder
from cross_checks.judge.convergence.model import ROUNDED, Posterior, posterior
from cross_checks.judge.ladder import knob_of
from cross_checks.judge.runs import gap
from cross_checks.judge.tried import facts_of
from cross_checks.metrics.metric import known_to
from cross_checks.truths.truth import ONE_FIGURE, Truth
from mbs_ref.observables import constraint_residual, energy_balance, kinetic_energy
from mbs_ref.observables.distance import NAMES, relative
from mbs_ref.scene import PlanarBody, Scene, SpatialBody
from mbs_ref.scene.euler_parameters import from_axis_angle, rotation_matrices
from mbs_ref.scene.scales import scales_of
from mbs_ref.trajectory import Trajectory

MORE = 7  # halvings of the finest step while no run resolves the motion
GOOD = 1e-8  # of the scene: a deviation that need not shrink any more ...
SLOPE = 1e-5  # ... and of the largest rate, where slopes are differences of samples
EXPLAINED = 2.0  # times the gap to the two runs before: a method of order 1/2 or more is nearer than that to its limit
SPARSE = 20  # the one inner sample of those runs
ALOUD = "none: it stops before the end and says so, which is an answer"
ORDERS = (5, 7)  # degrees of the splines through samples whose slopes are compared: errors of orders 6 and 8
EDGE = 4  # samples at either end whose slopes are one-sided
NORMAL = np.array([0.0, 0.0, 1.0])  # of the plane: what turns in it turns about this axis of space


def _peak(curve: np.ndarray) -> float:
    return float(np.abs(curve).max())


def climb(engine: Engine, method: Method, question: Question) -> tuple[list[Finding], Row]:
    """Run the method from coarse to fine and return the findings, with the figures of the best run."""
    name, scene, exemption = method.name, question.scene.name, method.exemption(question.scene)
    settings = rungs(method, question.times, jumps=not question.is_smooth)
    runs = [called(engine, question.scene, one, question.times) for one in settings]
    rising = _Rungs(method, question, tuple(run for run in runs if run.path.ok))
    if method.kind == "fixed" and question.is_smooth and runs[-1].path.ok:
        rising = _refined(engine, rising)
    if len(rising.runs) < 2:
        stops = "; ".join(f"{run.setting}: {run.path.message}" for run in runs if not run.path.ok)
        wrong = f"fewer than two runs end: {stops}"
        return [verdict("runs", name, scene, wrong, exemption=exemption or ALOUD)], rising.row()
    seen = f"error {min(rising.errors):.1e}"
    findings = [verdict("runs", name, scene, "")]
    findings += [verdict(what, name, scene, wrong) for what, wrong in _always(rising)]
    findings += [
        verdict(what, name, scene, wrong, seen=seen, exemption=exemption) for what, wrong in _exemptible(rising)
    ]
    if question.is_smooth or rising.meets_contacts:
        findings.append(verdict("same end", name, scene, _other_end(engine, rising), exemption=exemption))
    return findings, rising.row()


@dataclass(frozen=True)
class _Rungs:
    """Runs of a method that succeeded, coarse to fine."""

    method: Method
    question: Question
    runs: tuple[Called, ...]

    @property
    def meets_contacts(self) -> bool:
        """Whether the steps are given or end at contacts; an adaptive method may else step over one."""
        return self.method.kind == "fixed" or self.method.locates_events

    @property
    def bar(self) -> float:
        """The odds from which a failure to converge is a finding; higher where forces jump, and errors scatter."""
        return EVEN if self.question.is_smooth else FAILING

    @cached_property
    def errors(self) -> list[float]:
        """The distance of each run from the truth, over the scene's scales; infinite where it has none."""
        return [float(np.nan_to_num(self.apart(run, self.question.truth), nan=np.inf)) for run in self.runs]

    def apart(self, run: Called, other: Trajectory | Truth) -> float:
        """Return the distance of a run from a motion, over the scene's scales, in what the truth knows; else NaN."""
        return gap(self.question.scene, self.question.truth, run.path, other)

    @cached_property
    def shown(self) -> Posterior | None:
        """What the runs show of convergence to the truth; None where one has no error."""
        gaps = [[self.apart(one, other.path) for other in self.runs] for one in self.runs]
        return self.posterior(self.errors, gaps, known_to(self.question.scene, self.question.truth))

    def posterior(self, errors: Sequence[float], gaps: list[list[float]], uncertainty: float = 0.0) -> Posterior | None:
        """Return what errors and gaps of the runs show."""
        if not self.runs or not np.isfinite(errors).all():
            return None
        facts = facts_of(self.method, self.question.scene, float(self.question.times[-1]), uncertainty)
        counts = [(knob_of(run.settings), run.path.steps) for run in self.runs]
        runs = [(knob, x, n, self.method.roundoff * n) for (knob, n), x in zip(counts, errors, strict=True)]
        return posterior(Ladder.of(runs, np.array(gaps), **facts))

    def deviation(
        self, what: str, curves: Sequence[np.ndarray | None], floor: float, size: Callable[[np.ndarray], float] = _peak
    ) -> str:
        """Return a sentence where a deviation that every right motion lacks does not converge to zero."""
        known = [curve for curve in curves if curve is not None]
        if len(known) < len(self.runs):
            return ""
        errors = [size(curve) for curve in known]
        if errors[-1] <= floor:
            return ""
        gaps = [[size(one - other) for other in known] for one in known]
        return _sentence(what, self.posterior(errors, gaps), errors, floor, self.bar)

    def row(self) -> Row:
        """Return the figures of the best run; the order of fixed steps on smooth scenes."""
        has_order = self.shown is not None and self.method.kind == "fixed" and self.question.is_smooth
        best = int(np.argmin(self.errors)) if self.runs else None
        error, loop = (None, None) if best is None else (self.errors[best], self.runs[best].path.timing.loop_s)
        order = self.shown.observed_order if has_order and self.shown else None
        return Row(self.method.name, self.question.scene.name, order, self.method.order, error, loop)


def _refined(engine: Engine, rising: _Rungs) -> _Rungs:
    """Add runs with ever half the step while none resolves the motion and convergence is open."""
    for _ in range(MORE):
        is_open = rising.shown is None or _failing(rising.shown, RESOLVED)[1] < rising.bar
        if rising.errors[-1] < RESOLVED or not is_open:
            break
        last = rising.runs[-1].settings
        finer = last.model_copy(update={"step": 0.5 * (last.step or math.nan)})
        run = called(engine, rising.question.scene, finer, rising.question.times)
        if not run.path.ok:
            break
        rising = replace(rising, runs=(*rising.runs, run))
    return rising


def _failing(shown: Posterior, floor: float) -> tuple[str, float]:
    """Return how the runs fail to converge to zero, and the odds of it: 0 for errors that are small or falling."""
    error = float(shown.ladder.errors[-1])
    if shown.ladder.is_falling or not error > floor:
        return "", 0.0
    bar = max(floor, error / SCATTER)
    limit, stall = shown.odds_of_limit(bar), shown.odds_of_stall(bar)
    return "converge to another limit" if limit > stall else "do not fall", limit + stall


def _sentence(what: str, shown: Posterior | None, errors: Sequence[float], floor: float, bar: float) -> str:
    how, odds = ("", 0.0) if shown is None else _failing(shown, floor)
    listed = " ".join(f"{error:.1e}" for error in errors)
    return f"{what} {listed}, coarse to fine, {how}, with odds of {odds:.2g}" if odds >= bar else ""


def _always(rising: _Rungs) -> Iterator[tuple[str, str]]:
    """Yield what no weakness exempts: samples, start, velocities, clocks."""
    scene, method, runs = rising.question.scene, rising.method, rising.runs
    odd = [run.setting for run in runs if not np.array_equal(run.path.times, rising.question.times)]
    yield "asked times", f"{odd[0]}: samples are not at the requested times" if odd else ""
    off = relative(scene, runs[-1].path.at(slice(1)), initial_sample(scene))[0]
    allowed = max(TARGETS[-1], ROUNDED * method.roundoff)  # a pose may be read in single precision
    wrong = [f"{part} by {miss:.1e} of its scale" for part, miss in zip(NAMES, off, strict=True) if miss > allowed]
    yield "start", f"the first sample is off: {', '.join(wrong)}" if wrong else ""
    misses = [slope_misses(scene, run.path, method.roundoff) for run in runs]
    curves, floor = [miss for miss, _ in misses], max(SLOPE, 10.0 * misses[-1][1])
    yield "velocities", rising.deviation("velocities miss the slope of positions by", curves, floor, typical)
    yield "clock", impossible_time(runs)


def _exemptible(rising: _Rungs) -> Iterator[tuple[str, str]]:
    """Yield what a method may fail where it declares a weakness: accuracy, energy, joints, contact."""
    scene, paths, last = rising.question.scene, [run.path for run in rising.runs], rising.runs[-1]
    enough = max(GOOD, rising.method.rounding(last.path.steps))
    floor = max(enough, ONE_FIGURE * known_to(scene, rising.question.truth))
    yield "truth", _sentence("errors", rising.shown, rising.errors, floor, rising.bar)
    energy = [energy_drift(scene, path) for path in paths]
    yield "energy", rising.deviation("energy is lost or won:", energy, enough)
    joints = [joint_gaps(scene, path) for path in paths]
    yield "joints", rising.deviation("joints open by", joints, enough)
    if scene.contacts:
        yield "contact", _contact(rising)


def _contact(rising: _Rungs) -> str:
    """Return a sentence where contacts are off by more than a target and than refinement explains."""
    error, last = rising.errors[-1], rising.runs[-1]
    moved = max(np.nan_to_num(rising.apart(last, run.path)) for run in rising.runs[-3:-1])
    explained = min(RESOLVED, EXPLAINED * moved) if rising.meets_contacts else RESOLVED
    if error <= max(TARGETS[0], explained):
        return ""
    return f"{last.setting}: bodies do not stop and part as they must: error {error:.1e} of the scene"


def _other_end(engine: Engine, rising: _Rungs) -> str:
    """Request the end alone: the state there must not depend on which samples are requested."""
    fine, scene = rising.runs[-1], rising.question.scene
    alone = called(engine, scene, fine.settings, rising.question.times[[0, SPARSE, -1]])
    if not alone.path.ok:
        return f"{fine.setting}: with other samples the run ends: {alone.path.message}"
    moved = float(np.abs(alone.path.position[-1] - fine.path.position[-1]).max()) / scales_of(scene).length
    if moved <= max(AGREEMENT, 1e3 * (fine.settings.rtol or 0.0), rising.errors[-1]):
        return ""
    return f"{fine.setting}: the end moves by {moved:.1e} of the scene's length with the samples requested"


# --- deviations of one run, each over the scene's own length, speed or energy


def slope_misses(scene: Scene, path: Trajectory, roundoff: float) -> tuple[np.ndarray, float]:
    """Return by how much rates miss the slopes of poses (n, k) at inner samples, and how sure slopes are.

    Both are over the largest rate. Places count over the scene's length; angular velocities are compared with the
    slope of the rotation matrices, R' = omega x R. Poses are known to `roundoff`, relative.
    """
    n, length = len(path.times), scales_of(scene).length
    turns = np.array([isinstance(body, PlanarBody | SpatialBody) for body in scene.bodies])
    theta, omega = path.orientation[:, turns], path.angular_velocity[:, turns]
    if scene.dimension == 2:
        theta, omega = from_axis_angle(NORMAL, theta), omega[..., None] * NORMAL
    matrices = rotation_matrices(theta)
    spun = np.cross(omega[..., None, :], np.swapaxes(matrices, -1, -2)).swapaxes(-1, -2)
    pose, rate = (
        np.concatenate([places.reshape(n, -1) / length, turned.reshape(n, -1)], axis=1)
        for places, turned in ((path.position, matrices), (path.velocity, spun))
    )
    interval = path.times[1] - path.times[0]
    rougher, slope = (make_interp_spline(path.times, pose, k)(path.times, 1)[EDGE:-EDGE] for k in ORDERS)
    inner = rate[EDGE:-EDGE]
    fastest = max(float(np.abs(slope).max()), float(np.abs(inner).max())) or 1.0
    rounding = roundoff * float(np.abs(pose).max()) / interval
    return (slope - inner) / fastest, (typical(slope - rougher) + rounding) / fastest


def typical(misses: np.ndarray) -> float:
    """Return the median over samples of the largest miss: samples do not resolve a transient, or an impact's jump."""
    return float(np.median(np.abs(misses).max(axis=1)))


def energy_drift(scene: Scene, path: Trajectory) -> np.ndarray | None:
    """Return E(t) - E(0) - work over the largest kinetic energy (n_t,); None where no balance can be drawn."""
    balance = energy_balance(scene, path)
    if balance.drift is None or balance.resolution > 0.0:  # work is integrated over the samples: too rough here
        return None
    scale = float(kinetic_energy(scene, path).max())
    return balance.drift / scale if scale else None


def joint_gaps(scene: Scene, path: Trajectory) -> np.ndarray | None:
    """Return C (m over the scene's length, rad) at every sample; None where there is no joint."""
    return constraint_residual(scene, path) / scales_of(scene).length if scene.joints else None
