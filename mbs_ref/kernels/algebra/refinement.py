"""How often a solution is refined: the loop closures square the condition of C_q, and refinement takes that back.

With sigma^2 the smallest relative pivot of the closures' Schur complement, elimination leaves a relative error near
eps / sigma^2 where a backward stable method leaves eps / sigma. Each step of refinement in working precision, with
the same factors, multiplies the excess by eps / sigma^2 (Higham, Accuracy and Stability of Numerical Algorithms,
2nd ed., sec. 12.1 and 20.5). It costs a residual and a solve, and only poses near a singular one pay for it.
"""

from __future__ import annotations

from mbs_ref.kernels.jit import jit

EPS = 2.220446049250313e-16
BORNE = 100.0 * EPS  # relative: below the tightest tolerance that is asked for, 1e-13
REFINED_BELOW = EPS / BORNE  # pivot: elimination alone loses no more above it
MOST_REFINEMENTS = 4
CONVERGES = 1e-4  # relative: where elimination loses more, a rank is lost and nothing is there to refine


@jit
def refinements(pivot):
    """Return the steps of refinement after which what elimination lost at this relative pivot is borne."""
    if pivot >= REFINED_BELOW or pivot * CONVERGES < EPS:
        return 0
    steps = 0
    error = EPS / pivot
    while error > BORNE and steps < MOST_REFINEMENTS:
        error *= EPS / pivot
        steps += 1
    return steps
