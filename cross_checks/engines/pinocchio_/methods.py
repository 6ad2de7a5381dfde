"""Pinocchio's methods: it has no integrator, so these drive it from Python."""

# It is installed under a prefix that only the interpreter knows.
# pyright: reportMissingImports=false

from __future__ import annotations

from cross_checks.engine import Method, exponential

GAINS = (100.0, 20.0)  # 1/s^2, 1/s: Kp and Kd, critically damped at 10 rad/s; Pinocchio's own default is 0, 0
STEPS = (2e-2, 1e-2, 5e-3, 2.5e-3, 1e-3, 5e-4, 2.5e-4, 1e-4)  # s
RTOLS = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
NO_GAINS = "_no_gains"
SHRINK = "in loops, steps that shrink towards a singular pose end on it, where the proximal solve loses the energy"
DRIFT = "without gains nothing holds the loop once a singular pose has let it slip"
METHODS = (
    Method(
        "dop853",
        "adaptive",
        8,
        "SciPy DOP853, driven from Python, Baumgarte gains in loops",
        RTOLS,
        wrong_limit=SHRINK,
        weak_on=frozenset({"closed-loop"}),
        driven_from_python=True,
        embedded=7,
    ),
    Method(
        "rk4",
        "fixed",
        4,
        "Runge-Kutta 4, driven from Python, Baumgarte gains in loops",
        STEPS,
        stability=exponential(4),
        driven_from_python=True,
    ),
    Method(
        "rk4" + NO_GAINS,
        "fixed",
        4,
        "Runge-Kutta 4, driven from Python, with Pinocchio's default gains of zero",
        STEPS,
        frozenset({"closed-loop"}),
        stability=exponential(4),
        wrong_limit=DRIFT,
        weak_on=frozenset({"closed-loop"}),
        driven_from_python=True,
    ),
)
