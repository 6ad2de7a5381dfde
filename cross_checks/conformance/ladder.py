"""One method on one scene, from coarse to fine, and what the runs say of it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cross_checks.conformance import figures
from cross_checks.conformance.apart import called
from cross_checks.conformance.finding import Finding, Row, verdict
from cross_checks.conformance.questions import Asked, rungs
from cross_checks.engine import Engine
from cross_checks.engine.method import Method
from cross_checks.judge.convergence.ladder import Ladder
from cross_checks.judge.convergence.model import Posterior, posterior
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Trajectory

ORDER_OFF = 0.35  # how far an observed order may be from the documented one
MORE = 7  # halvings of the finest step while its error is as large as the motion
RESOLVED = 0.1  # of the scene's size: a larger error shows no order
LIKELY = 0.5  # odds from which a failure to converge to the truth is a finding
GOOD = 1e-8  # of the scene's size: an error that need not shrink any more
AT_START = 1e-9  # of the scene's size and speed: how exactly the first sample is the scene's initial state ...
READ = 10  # ... or this many roundings, as reading a pose in single precision takes
SHRINKS = 0.8  # of an error by one refinement, the step halved: a third of an order does it
SLOPE = 1e-5  # of the largest speed: a mismatch of velocity and slope that need not shrink any more
ALOUD = "none: it stops before the end and says so, which is an answer"
FASTEST = 5e-9  # s: no processor evaluates a right-hand side, or takes a step, in less
RESTARTED = 1e-6  # of the scene's size: how far the end may depend on which samples are asked for


@dataclass(frozen=True)
class Run:
    """One run and its clocks."""

    settings: Settings
    path: Trajectory
    wall_s: float  # of the whole call
    cpu_s: float
    error: float = math.inf  # of positions, over the scene's size, and of orientations, rad

    @property
    def setting(self) -> str:
        s = self.settings
        return f"step = {s.step:g} s" if s.step else f"rtol = {s.rtol:g}"


def climb(engine: Engine, method: Method, question: Asked) -> tuple[list[Finding], Row]:
    """Run the method from coarse to fine and return what is found, with the figures of the best run."""
    asked = rungs(method, question.times, jumps=not question.is_smooth)
    runs = [timed(engine, question, settings) for settings in asked]
    runs += _refined(engine, method, question, runs)
    good = [run for run in runs if run.path.ok]
    shown = _shown(method, question, good)
    row = _row(method, question, good, shown)
    if len(good) < 2:
        said = "; ".join(f"{run.setting}: {run.path.message}" for run in runs if not run.path.ok)
        seen, excuse = f"fewer than two runs end: {said}", method.excused(question.scene) or ALOUD
        return [verdict("runs", method.name, question.scene.name, seen, excuse=excuse)], row
    findings = [verdict("runs", method.name, question.scene.name, "")]
    findings += list(_always(engine, method, question, good)) + list(_excusable(method, question, good, shown))
    if question.is_smooth or method.kind == "fixed" or method.locates_events:  # else it may step over a contact
        findings.append(_same_end(engine, method, question, good[-1]))
    return findings, row


def _refined(engine: Engine, method: Method, question: Asked, runs: list[Run]) -> Iterator[Run]:
    """Yield runs with ever half the step while they tell nothing of convergence.

    That is while the error is as large as the motion, unless all refinements that are left could not take it away at
    the last one's pace: then the runs have converged, to another answer.
    """
    *_, before, last = runs
    for left in range(MORE, 0, -1):
        if method.kind != "fixed" or not question.is_smooth or not last.path.ok or last.error < RESOLVED:
            return
        if math.isfinite(before.error) and left * figures.apart(question, before.path, last.path) < last.error:
            return
        assert last.settings.step is not None
        finer = timed(engine, question, last.settings.model_copy(update={"step": last.settings.step / 2}))
        before, last = last, finer
        yield last


def timed(engine: Engine, question: Asked, settings: Settings, times: np.ndarray | None = None) -> Run:
    """Run once, with the clocks of the call and the error."""
    asked = question.times if times is None else times
    run = called(engine, question.scene, settings, asked)
    path, wall, cpu = run.path, run.wall_s, run.cpu_s
    if not path.ok or len(path.times) != len(question.times):
        return Run(settings, path, wall, cpu)
    return Run(settings, path, wall, cpu, figures.apart(question, path, question.truth))


def _row(method: Method, question: Asked, good: list[Run], shown: Posterior | None) -> Row:
    best = min(good, key=lambda run: run.error, default=None)
    order = shown.observed_order if shown and method.kind == "fixed" and question.is_smooth else None
    error, loop = (best.error, best.path.timing.loop_s) if best else (None, None)
    return Row(method.name, question.scene.name, order, method.order, error, loop)


def _shown(method: Method, question: Asked, good: list[Run]) -> Posterior | None:
    """Return what the runs show of convergence; None where none has an error."""
    known = [run for run in good if math.isfinite(run.error)]
    if not known:
        return None
    knobs = np.array([run.settings.step or run.settings.rtol or math.nan for run in known])
    gaps = np.array([[figures.apart(question, one.path, other.path) for other in known] for one in known])
    is_first = not method.locates_events and not question.is_smooth
    order = float(method.order or 1) if method.kind == "fixed" else (method.order or 5) / method.local_order
    order = min(order, 1.0) if is_first else order
    errors = np.array([run.error for run in known])
    return posterior(Ladder(
        knobs, errors, gaps, np.array([run.path.steps for run in known]),
        np.array([method.rounding(run.path.steps) for run in known]), method.kind, order,
        reference=float(knobs[0]), typical=float(np.log10(max(errors[0], 1e-16))),
        uncertainty=question.truth.uncertainty / figures.size(question),
    ))  # fmt: skip


def _always(engine: Engine, method: Method, question: Asked, good: list[Run]) -> Iterator[Finding]:
    """Yield what no weakness excuses: samples, start, velocities, clocks."""
    name, scene = method.name, question.scene.name
    yield verdict("asked times", name, scene, _wrong_times(question, good))
    yield verdict("start", name, scene, _wrong_start(question, good[-1].path, max(AT_START, method.rounding(READ))))
    yield verdict("velocities", name, scene, _wrong_slope(method, question, good))
    yield verdict("clock", name, scene, _wrong_clock(good) or _untold_work(engine, question, good))


def _excusable(method: Method, question: Asked, good: list[Run], shown: Posterior | None) -> Iterator[Finding]:
    """Yield what a method may fail where it declares a weakness: accuracy, energy, joints."""
    name, scene, excuse = method.name, question.scene.name, method.excused(question.scene)
    enough = max(GOOD, method.rounding(good[-1].path.steps))
    floor = max(enough, 100.0 * question.truth.uncertainty / figures.size(question))
    steady = question.is_smooth and method.order is not None
    seen = f"error {min(run.error for run in good):.1e}"
    yield verdict("truth", name, scene, _off_truth(good, shown, floor), seen=seen, excuse=excuse)
    energy = [figures.energy_miss(question.scene, run.path) for run in good]
    yield verdict("energy", name, scene, _unshrunk(steady, energy, enough, "energy is lost or won:"), excuse=excuse)
    gaps = [figures.joint_gap(question, run.path) for run in good]
    yield verdict("joints", name, scene, _unshrunk(steady, gaps, enough, "joints open by"), excuse=excuse)


def _off_truth(good: list[Run], shown: Posterior | None, floor: float) -> str:
    """Return a sentence where the runs are likely not to converge to the truth, and their error is not small."""
    error = good[-1].error
    if shown is None or error <= floor:
        return ""
    limit = shown.odds_of_limit(max(floor, 0.3 * error))
    fails = shown.odds_of_stall(max(floor, 0.3 * error)) + shown.weights["lost"]
    if limit + fails < LIKELY:
        return ""
    what = "converge to another limit" if limit > fails else "do not fall"
    errors = " ".join(f"{run.error:.1e}" for run in good)
    return f"errors {errors}, coarse to fine, {what}, with odds of {limit + fails:.2g}"


def _unshrunk(steady: bool, sizes: list[float | None], floor: float, what: str) -> str:
    """Return a sentence where a figure is not small and does not shrink any more.

    Each refinement must bring something where it is `steady`. Where contacts begin and end between steps, and where a
    method documents no order, errors go up and down, and the finest run is held against the worst before it.
    """
    known = [figure for figure in sizes if figure is not None]
    if len(known) < 2 or known[-1] <= floor:
        return ""
    before = known[-2] if steady else max(known[:-1])
    if known[-1] < SHRINKS * before:
        return ""
    return f"{what} {' '.join(f'{figure:.1e}' for figure in known)} of the scene's scale, coarse to fine"


def _wrong_times(question: Asked, good: list[Run]) -> str:
    for run in good:
        if not np.array_equal(run.path.times, question.times):
            return f"{run.setting}: samples are not at the times that were asked for"
    return ""


def _wrong_start(question: Asked, path: Trajectory, allowed: float) -> str:
    """Compare the first sample with the scene: every part, whatever the method."""
    from cross_checks.engine.initial_state import initial_sample

    start, turns = initial_sample(question.scene), figures.turning(question.scene)
    axes = [figures.axes(question.scene, p.orientation[:1])[:, turns] for p in (path, start)]
    length = float(np.linalg.norm(path.velocity, axis=-1).max()) or 1.0
    spin = float(np.abs(path.angular_velocity).max()) or 1.0
    spun = np.abs(path.angular_velocity[0] - start.angular_velocity[0])[turns]
    parts = {
        "positions": np.abs(path.position[0] - start.position[0]).max() / figures.size(question),
        "orientations": np.abs(axes[0] - axes[1]).max(initial=0.0),
        "velocities": np.abs(path.velocity[0] - start.velocity[0]).max() / length,
        "angular velocities": spun.max(initial=0.0) / spin,
    }
    wrong = [f"{part} by {miss:.1e} of their scale" for part, miss in parts.items() if not miss <= allowed]
    return f"the first sample misses the initial state: {', '.join(wrong)}" if wrong else ""


def _wrong_slope(method: Method, question: Asked, good: list[Run]) -> str:
    """A velocity is what the position's slope converges to, as fast as the method's order says."""
    slopes = [figures.slope_mismatch(question.scene, run.path, method.roundoff) for run in good]
    misses, unsure = zip(*slopes, strict=True)
    floor = max(SLOPE, 10.0 * unsure[-1])
    if misses[-1] <= floor:
        return ""
    shrinks = misses[-1] < SHRINKS * misses[-2] and misses[-1] < 0.1
    steps = [run.settings.step or math.nan for run in good]
    order = math.log(misses[-2] / misses[-1]) / math.log(steps[-2] / steps[-1])
    slow = method.kind == "fixed" and question.is_smooth and order < min(method.order or 1, 2) - 2.0 * ORDER_OFF
    if shrinks and not slow:
        return ""
    seen = " ".join(f"{miss:.1e}" for miss in misses)
    return f"velocities miss the slope of positions by {seen} of the largest, coarse to fine"


def _wrong_clock(good: list[Run]) -> str:
    """The loop's time fits into the call, and is not shorter than any processor takes."""
    for run in good:
        clock, counted = run.path.timing, max(run.path.steps, run.path.rhs_calls)
        total = clock.build_s + clock.first_call_s + clock.loop_s
        if not clock.loop_s > 0.0:
            return f"{run.setting}: the loop is not timed"
        # the two clocks are read apart: a tenth of a millisecond may pass between
        if total > 1.01 * run.wall_s + 1e-4:
            return f"{run.setting}: {total:.2e} s are reported of a call of {run.wall_s:.2e} s"
        if clock.loop_s < counted * FASTEST:
            told = f"{counted} steps or right-hand sides in {clock.loop_s:.2e} s"
            return f"{run.setting}: {told} are beyond any processor"
    return ""


def _untold_work(engine: Engine, question: Asked, good: list[Run]) -> str:
    """The loop's time grows as the work does. One dear call has many causes: it is believed when it comes again."""
    if not _untold(good[0], good[-1]):
        return ""
    return _untold(*(timed(engine, question, run.settings) for run in (good[0], good[-1])))


def _untold(coarse: Run, fine: Run) -> str:
    more = fine.cpu_s - coarse.cpu_s  # what eight times the steps cost
    told = fine.path.timing.loop_s - coarse.path.timing.loop_s
    if fine.settings.step and more > max(0.02, 0.5 * fine.cpu_s) and told < 0.1 * more:
        return f"finer steps cost {more:.2e} s more, and the loop's time tells of {told:.2e} s"
    return ""


def _same_end(engine: Engine, method: Method, question: Asked, fine: Run) -> Finding:
    """Ask for the end alone: the state there must not depend on which samples are asked for."""
    ends = question.times[[0, SPARSE, -1]]
    alone = timed(engine, question, fine.settings, ends)
    allowed = max(RESTARTED, 1e3 * (fine.settings.rtol or 0.0), fine.error)
    wrong = ""
    if not alone.path.ok:
        wrong = f"{fine.setting}: with other samples the run ends: {alone.path.message}"
    else:
        gap = float(np.abs(alone.path.position[-1] - fine.path.position[-1]).max()) / figures.size(question)
        if gap > allowed:
            wrong = f"{fine.setting}: the end moves by {gap:.1e} of the scene's size with the samples asked for"
    return verdict("same end", method.name, question.scene.name, wrong, excuse=method.excused(question.scene))


SPARSE = 20  # the one inner sample of those runs
