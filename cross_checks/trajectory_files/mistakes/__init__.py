"""Which mistakes explain a file's error; each file here looks for one kind.

A suspicion is one change of what was stated, or of the motion, whose size is fitted where it has one. The one that
leaves least of the error is named if that is EXPLAINS times less; the search goes on from there, since mistakes come in
company.
"""

from collections.abc import Iterator

import numpy as np

from cross_checks.trajectory_files.mistakes.case import Case
from cross_checks.trajectory_files.mistakes.conventions import lag, other_conventions
from cross_checks.trajectory_files.mistakes.frames import other_points, turned_bodies, turned_world, turning_world
from cross_checks.trajectory_files.mistakes.terms import left_out

KINDS = (other_conventions, turned_world, turning_world, turned_bodies, other_points, lag, left_out)
EXPLAINS = 10.0  # times less error: that is no accident
MOST = 4  # mistakes looked for in one file


def suspicions(case: Case, asked: float) -> list[str]:
    """Return a sentence for each mistake, the one that explains most first; none where nothing explains the error."""
    sentences: list[str] = []
    while case.error > asked and len(sentences) < MOST:
        best = min(_every(case), key=lambda one: one[1].error, default=None)
        if best is None or not best[1].error * EXPLAINS < case.error:
            break
        left = f"without that the error is {best[1].error:.2g} of the scene, not {case.error:.2g}"
        sentences.append(f"{best[0]}: {left}")
        case = best[1]
    return sentences


def _every(case: Case) -> Iterator[tuple[str, Case]]:
    with np.errstate(all="ignore"):
        for find in KINDS:
            yield from find(case)
