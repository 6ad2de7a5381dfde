"""What every method must reach, how much work a run may take, and every threshold of verdicts and searches."""

import math

TARGETS = (1e-3, 1e-6, 1e-9)  # errors over the scene's scales
MOST_STEPS = 100_000  # that a run may take
LONGEST = 1.0  # s of processor time: a report makes no run for a target alone that would take longer, unless --full
CHECKED = 15.0  # s, likewise of `check`: a table of 40 methods ends in minutes
CHECK = 540.0  # s from the begin of a check, for each of its scenes, after which it makes no further run
AGREEMENT = 1e-6  # of the scene: an error at or below this is agreement

# Thresholds. None refers to a scene or an engine; `python -m tests.cross_checks.convergence.searched` calibrates them.
FAILING = 0.95  # odds of a failure from which a method is classified as wrong; a truth's uncertainty has them, too
LIKELY = 0.3  # odds with which another run for a target already reached, or missed by LEVELS runs, is worth making
DOUBTFUL = 0.1  # odds below which nothing is expected: no target, no failure; a decade of steps costs as much
EVEN = 0.5  # odds from which a statement is more likely true than not: of a finding of conformance, of a run's fate
LEVELS = 3  # of runs that determine the law's unknowns D, C and p; a failure rests on them, an approach on one more
RESOLVED = 0.1  # of the scene: a larger error shows no approach
SCATTER = 3.0  # ratio of errors that scatter alone explains: a smaller ratio shows neither fall nor growth
WINDOW = 10.0  # a chosen error lies within this factor below its target
FINER = {"fixed": 4.0, "adaptive": 100.0}  # ratio to a plainly finer setting, required of a failure beyond MOST_STEPS
MOST_RUNS = 12  # of one method where a failure is likely and not certain; half of it in other cases


def longest(full: bool) -> float:
    """Return the processor time (s) that a report's run for a target alone may take; a full report has no limit."""
    return math.inf if full else LONGEST
