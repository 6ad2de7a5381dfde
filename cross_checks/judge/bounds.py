"""What every method must reach, how much work a run may take, and every threshold of verdicts and searches."""

TARGETS = (1e-3, 1e-6, 1e-9)  # errors over the scene's scales
MOST_STEPS = 100_000  # that a run may take
MOST_SECONDS = 15.0  # s of loop time that a run may be expected to take: a table of 40 methods ends in minutes
AGREEMENT = 1e-6  # of the scene: an error at or below this is agreement

# Thresholds. None refers to a scene or an engine; `python -m tests.cross_checks.convergence.searched` calibrates them.
FAILING = 0.95  # odds of a failure from which a method is classified as wrong; a truth's uncertainty has them, too
DOUBTFUL = 0.1  # odds of a failure below which a method agrees or converges
LEVELS = 3  # of runs at least that a verdict rests on: two differences
RESOLVED = 0.1  # of the scene: a larger error shows no approach
SCATTER = 3.0  # ratio of errors that scatter alone explains: a smaller ratio shows neither fall nor growth
ROUNDED = 5.0  # times what rounding may add to an error: a smaller error states nothing about the method
WINDOW = 10.0  # a chosen error lies within this factor below its target ...
AIM = 6.0  # ... and the search aims within this one, because errors scatter
BELOW = 0.4  # worth of an error below the window; 1 within it
PRICE = 0.1  # worth of a decade of steps
FAIR = 0.12  # odds of reaching a target, below which no run is made for it
LIKELY = 0.3  # the same after three runs for it; also the odds for a coarser setting, and that a setting runs
FINER = {"fixed": 4.0, "adaptive": 100.0}  # ratio to a plainly finer setting, required of a failure beyond MOST_STEPS
MOST_RUNS = 12  # of one method where a failure is likely and not certain; half of it in other cases
