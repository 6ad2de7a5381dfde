"""A file's motion compared with a truth, or with another file: errors of every body and component, and a verdict."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from cross_checks import metrics
from cross_checks.judge.measure import gaps_as_none, measure
from cross_checks.metrics.metric import Judged, from_truth
from cross_checks.records.record import Error
from cross_checks.trajectory_files.formats import FileError
from cross_checks.trajectory_files.motion import SAME_TIME, DescribedMotion
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import Scene, Trajectory
from mbs_ref.observables.distance import NAMES, UNITS, largest, units_of
from mbs_ref.scene.scales import scales_of

MOST = 8  # errors in the text of a judgement


class Part(NamedTuple):
    """How far one component of one body is off."""

    body: str
    component: str
    unit: str
    largest: float | None = None  # in `unit`; None where it is unknown
    relative: float | None = None  # over the scene's own scale
    at: float | None = None  # s
    final: float | None = None  # in `unit`, at the last sample; None where it is unknown there
    below: float | None = None  # in `unit`: what an unknown size is at most, where that is known


@dataclass(frozen=True)
class Judgement:
    """The verdict on a trajectory file, with the figures that it rests on."""

    scene: str
    verdict: str  # agrees, departs, not-judged
    reason: str
    limit: float  # the error that the verdict is about, of the scene
    error: Error | None
    parts: tuple[Part, ...]
    measures: dict[str, float | None]  # compliance, drifts: the file's own consistency
    missing: tuple[str, ...]
    notes: tuple[str, ...]
    curves: dict[str, list[float | None]]  # t (s) and each component's error over time, of the scene
    suspicions: tuple[str, ...] = ()  # mistakes that would explain the error

    def __str__(self) -> str:
        """Return the verdict, what explains the error, and the largest errors, a line each."""
        worst = sorted((part for part in self.parts if part.relative), key=lambda part: -(part.relative or 0.0))
        errors = (f"{p.body} {p.component}: {p.largest:.3g} {p.unit} at t = {p.at:.4g} s" for p in worst[:MOST])
        return "\n  ".join([f"{self.scene} {self.verdict}: {self.reason}", *self.suspicions, *errors, *self.missing])

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        error = None if self.error is None else vars(self.error)
        return {**vars(self), "error": error, "parts": [part._asdict() for part in self.parts]}


def judgement(scene: Scene, motion: DescribedMotion, truth: Truth | NoTruth, limit: float) -> Judgement:
    """Return the verdict on a motion: it agrees where no stated component is off by more than `limit` of the scene."""
    figures = measure(Judged(scene, motion.path, truth))
    verdict, reason = _verdict(figures["error"], truth, limit)
    own = {name: figures["measures"][name] for name in metrics.every() if name not in _ERRORS}
    parts, curves = (), {}
    if isinstance(truth, Truth):
        parts, relative = tuple(_parts(scene, motion.path, truth)), from_truth(scene, motion.path, truth).counted
        relative = largest(relative, 1) / units_of(scales_of(scene))
        columns = {name: gaps_as_none(relative[:, c]) for c, name in enumerate(NAMES)}
        curves = {"t": motion.path.times.tolist(), **columns}
    return Judgement(
        scene.name, verdict, reason, limit, figures["error"], parts, own, motion.missing, figures["notes"], curves
    )


_ERRORS = frozenset({"position_error", "orientation_error", "velocity_error", "angular_velocity_error"})


def _verdict(error: Error | None, truth: Truth | NoTruth, limit: float) -> tuple[str, str]:
    if isinstance(truth, NoTruth):
        return "not-judged", truth.reason
    if error is None:
        return "not-judged", "the error is not finite"
    if error.bound <= limit:
        return "agrees", f"off by {error.bound:.2g} of the scene at most; the limit is {limit:g}"
    if error.value <= limit + error.uncertainty:
        return (
            "not-judged",
            f"off by {error.value:.2g} of the scene; the truth is known to {error.uncertainty:.1e} of it",
        )
    return "departs", f"off by {error.value:.3g} of the scene in {error.worst}; the limit is {limit:g}"


def _parts(scene: Scene, path: Trajectory, truth: Truth) -> Iterator[Part]:
    units, errors = units_of(scales_of(scene)), from_truth(scene, path, truth)
    for (k, body), (c, name) in product(enumerate(scene.bodies), enumerate(NAMES)):
        sizes, below = errors.sizes[:, k, c], largest(errors.bounds[:, k, c])
        part = Part(body.name, name, UNITS[c])
        if np.isnan(sizes).all():
            yield part if np.isnan(below) else part._replace(below=float(below))
            continue
        row = int(np.nanargmax(sizes))
        worst, final = float(sizes[row]), gaps_as_none(sizes)[-1]
        yield part._replace(largest=worst, relative=worst / units[c], at=float(path.times[row]), final=final)


def as_truth(scene: Scene, first: DescribedMotion, second: DescribedMotion, name: str) -> tuple[DescribedMotion, Truth]:
    """Return a file's motion at the times that both files have, and the other's as what to hold it against.

    FileError where the two have no time in common but the start.
    """
    near = SAME_TIME * scene.duration
    at = np.searchsorted(second.path.times, first.path.times - near)
    at = np.minimum(at, len(second.path.times) - 1)
    common = np.abs(second.path.times[at] - first.path.times) <= near
    if np.count_nonzero(common & (first.path.times > 0.0)) == 0:
        raise FileError(f"{name}: no sample after the start is at a time that the first file has")
    ours, theirs = first.path.at(common), second.path.at(at[common])
    how = f"{name}, at the {len(ours.times)} times that both files have"
    truth = Truth(theirs.position, theirs.orientation, 0.0, "published", how, velocity=theirs.velocity,
                  angular_velocity=theirs.angular_velocity, rate_uncertainty=np.zeros(len(ours.times)))  # fmt: skip
    return DescribedMotion(ours, (*first.missing, *(f"{sentence} ({name})" for sentence in second.missing))), truth


def truth_rows(truth: Truth, rows: np.ndarray) -> Truth:
    """Return a truth at some of its times, given by places or a mask (n,)."""
    arrays: dict[str, Any] = {name: value[rows] for name, value in vars(truth).items() if isinstance(value, np.ndarray)}
    return replace(truth, **arrays)
