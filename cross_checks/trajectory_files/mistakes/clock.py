"""A clock that is ahead or behind: samples that tell the state of another time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from cross_checks.trajectory_files.judgement import samples_at
from cross_checks.trajectory_files.mistakes.case import Case
from cross_checks.truths.truth import NoTruth
from mbs_ref.observables.distance import turn_between

FITS = 8  # corrections by Gauss and Newton; each squares what is left


def lag(case: Case) -> Iterator[tuple[str, Case]]:
    """Yield a clock that is ahead or behind, fitted by Gauss and Newton on positions and angles."""
    late, now = 0.0, case
    for _ in range(FITS):
        change = _lateness(now)
        if change is None or not abs(change) > 1e-12 * case.scene.duration:
            break
        late += change
        moved = case.path.times - late
        rows = np.flatnonzero((moved >= 0.0) & (moved <= case.scene.duration))
        if len(rows) < 2:
            return
        truth = case.truth_at(moved[rows])
        if isinstance(truth, NoTruth):
            return
        now = replace(case, path=replace(samples_at(case.path, rows), times=moved[rows]), truth=truth)
    if late:
        word = "late" if late > 0.0 else "early"
        yield f"samples are {word} by {abs(late):.4g} s (they tell the state of another time)", now


def _lateness(case: Case) -> float | None:
    """Return by how much (s) the file's samples lag behind, to first order."""
    truth, path, length = case.truth, case.path, case.length
    gaps, rates = [], []
    speed = truth.velocity if truth.velocity is not None else np.gradient(truth.position, path.times, axis=0)
    gaps.append((path.position - truth.position).ravel() / length)
    rates.append(speed.ravel() / length)
    turn = turn_between(path.orientation, truth.orientation, case.scene.dimension == 3)
    if truth.angular_velocity is not None and turn is not None:
        gaps.append(turn.ravel())
        rates.append(truth.angular_velocity.ravel())
    gap, rate = np.concatenate(gaps), np.concatenate(rates)
    known = np.isfinite(gap) & np.isfinite(rate)
    square = float(np.sum(rate[known] ** 2))
    return -float(np.sum(gap[known] * rate[known])) / square if square > 0.0 else None
