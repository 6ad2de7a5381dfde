"""Is a run near the motion? A second run that errs less tells how far the first is from it.

Two runs that differ by d, the error of the second k times smaller, bound the error of the first by d k / (k - 1), as
Richardson (1911) has it (Hairer, Norsett, Wanner I, eq. II.4.4). Half the step makes k = 2^p at order p, and 2 where
impacts and kinks leave order 1; a tenth of the tolerance makes k = 10, if errors are in proportion to it (ibid.,
sec. II.4). Nothing hides from it between outputs: a close pass, an impact or the growth of small errors all show in
what comes after. What dies out before the first output does not; for that see mbs_ref.self_checks.resolution.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbs_ref.cores.system import Poses
from mbs_ref.scene import Scene

SEEN = 0.01  # of the motion's size: an estimated error beyond is seen with the naked eye
LEAST = 1e-9  # m, rad: a motion smaller than this is none
UNSEEN = 1e-3  # of the largest body's radius of gyration, and rad: no more is none to a tolerance as wide
TURN = 1.0  # rad: bodies that turn further are no better known for it


@dataclass(frozen=True)
class Size:
    """How far a motion goes: errors are measured by it."""

    length: float = LEAST  # m
    angle: float = LEAST  # rad


def least_size(scene: Scene, absolute: float, bound: float) -> Size:
    """Return what is no motion to an `absolute` tolerance (m, rad): what it alone may err, if nobody sees that."""
    borne = absolute / bound
    size = max(body.gyration_radius for body in scene.bodies)
    return Size(max(min(borne, UNSEEN * size), LEAST), max(min(borne, UNSEEN), LEAST))


def size_of(least: Size, *runs: Poses) -> Size:
    """Return how far the runs go from where they start, but no less than `least`."""
    moved = [_largest(run.position - run.position[:1]) for run in runs]
    turned = [_turns(run.orientation, run.orientation[:1]) for run in runs]
    return Size(_furthest(moved, least.length), _furthest([np.minimum(turns, TURN) for turns in turned], least.angle))


def _furthest(ways: list[np.ndarray], least: float) -> float:
    return max(least, *(float(np.max(way, where=np.isfinite(way), initial=0.0)) for way in ways))


@dataclass(frozen=True)
class Disagreement:
    """How far a run is from one that errs less."""

    share: float  # largest estimated error, over the motion's size
    first: int | None  # output from which on it is beyond the bound; None where it never is
    body: int  # which errs most


def disagreement(run: Poses, better: Poses, size: Size, smaller: float, bound: float = SEEN) -> Disagreement:
    """Compare the poses of a run and of one whose error is so many times `smaller`, at the same times."""
    gap = _largest(run.position - better.position) / size.length
    shares = np.maximum(gap, _turns(run.orientation, better.orientation) / size.angle)  # (n_t, n_bodies)
    shares = np.where(np.isfinite(shares), shares, np.inf) * smaller / (smaller - 1.0)
    late = np.flatnonzero(shares.max(axis=1) > bound)
    body = int(np.argmax(shares.max(axis=0)))
    return Disagreement(float(np.max(shares)), int(late[0]) if len(late) else None, body)


def _largest(vectors: np.ndarray) -> np.ndarray:
    """Return the largest component of each: squares may overflow."""
    return np.max(np.abs(vectors), axis=2)


def _turns(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the angles (n_t, n_bodies) rad between orientations: planar ones count whole turns."""
    if a.ndim == 2:
        return np.abs(a - b)
    near = np.minimum(np.linalg.norm(a - b, axis=2), np.linalg.norm(a + b, axis=2))
    return 4.0 * np.arcsin(np.minimum(0.5 * near, 1.0))
