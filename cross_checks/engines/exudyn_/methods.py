"""Exudyn's methods, and which of its solvers each one is."""

# Its items take their arguments by names that type checkers cannot see.
# pyright: reportCallIssue=false, reportArgumentType=false, reportAttributeAccessIssue=false

from __future__ import annotations

import exudyn as exu

from cross_checks.engine import Method, exponential

STEPS = (2e-2, 1e-2, 5e-3, 2.5e-3, 1e-3, 5e-4, 2.5e-4, 1e-4)  # s
RTOLS = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
TREE = "tree_"
CONTACT = "contact_rk44"
PAIR_CONTACT = "pair_contact_rk44"
EXPLICIT_CONTACT = (CONTACT, PAIR_CONTACT)
SINGULAR = "stops at singular poses, or leaves them on another branch and reports success"
JUMPS = "at tight tolerances its step control may never come back from the jump of a contact force"
FRICTION = "friction acts on the surface as it was before a body sank in, and gives way to slow slip"
RAMP = "friction grows in proportion to slow slip, up to v_s, not as tanh(v_t / v_s)"
SOLVERS = {
    "generalized_alpha": exu.DynamicSolverType.GeneralizedAlpha,
    "rotation_vector": exu.DynamicSolverType.GeneralizedAlpha,
    "trapezoidal": exu.DynamicSolverType.TrapezoidalIndex2,
    "contact_rk44": exu.DynamicSolverType.RK44,
    "pair_contact_rk44": exu.DynamicSolverType.RK44,
    "tree_dopri5": exu.DynamicSolverType.DOPRI5,
    "tree_rk44": exu.DynamicSolverType.RK44,
    "tree_rk67": exu.DynamicSolverType.RK67,
    "tree_euler": exu.DynamicSolverType.ExplicitEuler,
}
# right-hand sides a step
STAGES = {"contact_rk44": 4, "pair_contact_rk44": 4, "tree_rk44": 4, "tree_rk67": 9, "tree_euler": 1, "tree_dopri5": 7}
SPATIAL = frozenset({"spatial"})
METHODS = (
    Method("generalized_alpha", "fixed", 2, "generalized-alpha, index 3, redundant coordinates", STEPS),
    Method(
        "trapezoidal",
        "fixed",
        2,
        "trapezoidal rule, index 2, redundant coordinates",
        STEPS,
        wrong_limit=SINGULAR,
        weak_on=frozenset({"closed-loop"}),
    ),
    Method("rotation_vector", "fixed", 2, "generalized-alpha on rotation vectors (Lie group)", STEPS, requires=SPATIAL),
    Method(
        "contact_rk44",
        "fixed",
        None,
        "Runge-Kutta 4 with GeneralContact; bodies without joints",
        STEPS,
        requires=frozenset({"contact"}),
        wrong_limit=FRICTION,
        weak_on=frozenset({"friction"}),
    ),
    Method(
        "pair_contact_rk44",
        "fixed",
        None,
        "Runge-Kutta 4 with contact connectors; bodies without joints",
        STEPS,
        requires=frozenset({"contact", "spatial"}),
        wrong_limit=RAMP,
        weak_on=frozenset({"friction"}),
    ),
    Method(
        "tree_dopri5",
        "adaptive",
        5,
        "KinematicTree, Dormand-Prince 5",
        RTOLS,
        wrong_limit=JUMPS,
        weak_on=frozenset({"contact"}),
        embedded=4,
    ),
    Method("tree_rk44", "fixed", 4, "KinematicTree, Runge-Kutta 4", STEPS, stability=exponential(4)),
    Method("tree_rk67", "fixed", 6, "KinematicTree, Runge-Kutta 6 of 7 stages", STEPS, stability=exponential(6)),
    Method("tree_euler", "fixed", 1, "KinematicTree, explicit Euler", STEPS, stability=exponential(1)),
)
