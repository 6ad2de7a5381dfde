"""Which mistakes explain a file's error: every change of a table of hypotheses is tried, and its size is fitted.

A hypothesis is one change of what the columns mean or of the scene that was simulated. It is named if the error
without it is EXPLAINS times less, and no other leaves less. Of those that leave as little, one without a fitted number
comes first; the search goes on from there, since a file may have several mistakes. Where nothing explains what remains,
errors of integration are looked for.
"""

from collections.abc import Iterator

import numpy as np

from cross_checks.trajectory_files.mistakes.case import Case, Explanation, explanations
from cross_checks.trajectory_files.mistakes.frames import clocks, conventions, frames, signs
from cross_checks.trajectory_files.mistakes.integration import integration_errors
from cross_checks.trajectory_files.mistakes.terms import terms

KINDS = (conventions, signs, frames, clocks, terms)
EXPLAINS = 10.0  # times less error: that is no accident
ALIKE = 3.0  # explanations that leave no more than this many times as much as the best explain as well
MOST = 4  # mistakes looked for in one file


def suspicions(case: Case, limit: float) -> list[str]:
    """Return a sentence for each mistake, the one that explains most first; none where nothing explains the error."""
    sentences: list[str] = []
    while case.error > limit and len(sentences) < MOST:
        every = [one for one in _every(case) if one.case.error * EXPLAINS < case.error]
        if not every:
            sentences += filter(None, [integration_errors(case)])
            break
        least = min(one.case.error for one in every)
        alike = [one for one in every if one.case.error <= max(ALIKE * least, limit)]
        alike.sort(key=lambda one: (one.numbers, one.case.error))  # the simplest first
        best = alike[0]
        said = dict.fromkeys(one.sentence for one in alike if one.numbers == best.numbers)
        remains = f"without that the error is {best.case.error:.2g} of the scene, not {case.error:.2g}"
        sentences.append(f"{', or '.join(said)}: {remains}")
        case = best.case
    return sentences


def _every(case: Case) -> Iterator[Explanation]:
    with np.errstate(all="ignore"):
        for kind in KINDS:
            for hypothesis in kind(case):
                yield from explanations(case, hypothesis)
