"""Exudyn's methods, and which of its solvers each one is."""

import exudyn as exu

from cross_checks.engine import LOOPS, Method, adaptive, exponential, fixed

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
SPATIAL, TOUCHING = frozenset({"spatial"}), frozenset({"contact"})


def _in_contact(name: str, text: str, limit: str, also: frozenset[str] = frozenset()) -> Method:
    return fixed(name, None, text, requires=TOUCHING | also, wrong_limit=limit, weak_on=frozenset({"friction"}))


METHODS = (
    fixed("generalized_alpha", 2, "generalized-alpha, index 3, redundant coordinates"),
    fixed("trapezoidal", 2, "trapezoidal rule, index 2, redundant coordinates", wrong_limit=SINGULAR, weak_on=LOOPS),
    fixed("rotation_vector", 2, "generalized-alpha on rotation vectors (Lie group)", requires=SPATIAL),
    _in_contact("contact_rk44", "Runge-Kutta 4 with GeneralContact; bodies without joints", FRICTION),
    _in_contact("pair_contact_rk44", "Runge-Kutta 4 with contact connectors; bodies without joints", RAMP, SPATIAL),
    adaptive("tree_dopri5", 5, "KinematicTree, Dormand-Prince 5", wrong_limit=JUMPS, weak_on=TOUCHING, embedded=4),
    fixed("tree_rk44", 4, "KinematicTree, Runge-Kutta 4", stability=exponential(4)),
    fixed("tree_rk67", 6, "KinematicTree, Runge-Kutta 6 of 7 stages", stability=exponential(6)),
    fixed("tree_euler", 1, "KinematicTree, explicit Euler", stability=exponential(1)),
)
