"""Where a drive forces a loop to the end of its reach, a run must stop: told from the judge's rows, not from the run.

The loops are closed at the stop, and soon after it no pose near by closes them. Both are asked of one least-squares
search (Levenberg-Marquardt) that knows nothing of masses, velocities or the solver. Near such an end the smallest
singular value of C_q goes as the square root of the time left and the speeds as its inverse.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from cross_checks.truths.oracle import Moment, judged_rows
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Status, Trajectory

# s after the stop. A run at rtol = 1e-10 stops where roundoff in accelerations, eps / sigma^3, is more than was asked,
# and the time left from there goes as sigma^2: below 1e-7 s where the reach ends fast, 1.04e-4 s in seed 314.
SOON = 1e-3
NEAR = 0.1  # m, rad: a closed pose farther away is another assembly of the loop, out of the motion's reach
CLOSED = 1e-10  # m, rad
ASIDE = 0.03  # m, rad: how far from the last pose other searches begin
SEARCHES = 4  # of them, at random, besides both ways along the weakest direction
MOST_STEPS = 80
FIRST_DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-3, 1e-16, 1e6  # added to C_q^T C_q
SENTENCE = re.compile(
    r"at t = (?P<time>\S+) s the constraint.*body '\S+' .*joint '\S+'.* nearest to rank loss .*"
    r"last good output is at t = \S+ s"
)


def is_dead_end(scene: Scene, path: Trajectory) -> bool:
    """Return whether a stopped run says what it must, and the motion could not go on for SOON after it."""
    said = SENTENCE.match(path.message)
    if path.status not in (Status.SINGULAR, Status.PROJECTION) or not said:
        return False
    here = Moment.of(
        scene, simulate(scene, Settings(rtol=1e-10, estimate="off"), np.array([0.0, float(said["time"])])), -1
    )
    return closes_near(here) and not closes_near(replace(here, time=here.time + SOON))


def closes_near(moment: Moment) -> bool:
    """Return whether a pose near a moment's keeps every row at its time."""
    random = np.random.default_rng(0)
    weakest = np.linalg.svd(judged_rows(moment).jacobian)[2][-1]
    asides = [np.zeros_like(weakest), weakest, -weakest, *random.standard_normal((SEARCHES, len(weakest)))]
    starts = (moment.displaced(ASIDE * aside / max(1e-12, np.abs(aside).max())) for aside in asides)
    return any(gap < CLOSED and distance(moment, found) < NEAR for found, gap in map(closest, starts))


def closest(moment: Moment) -> tuple[Moment, float]:
    """Return the pose down the slope of |C|^2 from a moment's, and its largest |C| (m, rad)."""
    damping, rows = FIRST_DAMPING, judged_rows(moment)
    for _ in range(MOST_STEPS):
        size = rows.jacobian.shape[1]
        stacked = np.vstack((rows.jacobian, np.sqrt(damping) * np.eye(size)))
        step = np.linalg.lstsq(stacked, -np.concatenate((rows.residual, np.zeros(size))))[0]
        trial = moment.displaced(step)
        tried = judged_rows(trial)
        if np.linalg.norm(tried.residual) < np.linalg.norm(rows.residual):
            moment, rows, damping = trial, tried, max(0.1 * damping, LEAST_DAMPING)
        else:
            damping *= 10.0
        if damping > MOST_DAMPING or np.abs(rows.residual).max() < 0.01 * CLOSED:
            break
    return moment, float(np.abs(rows.residual).max())


def distance(moment: Moment, other: Moment) -> float:
    """Return how far two poses are apart, m or Euler parameters (half of an angle)."""
    turn = np.abs(moment.orientation - other.orientation).max()
    return float(max(np.abs(moment.position - other.position).max(), turn))
