"""Pinocchio's methods: it has no integrator, so these drive it from Python."""

from cross_checks.engine.method import LOOPS, adaptive, exponential, fixed

GAINS = (100.0, 20.0)  # 1/s^2, 1/s: Kp and Kd, critically damped at 10 rad/s; Pinocchio's own default is 0, 0
NO_GAINS = "_no_gains"
SHRINK = "in loops, steps that shrink towards a singular pose end on it, where the proximal solve loses the energy"
DRIFT = "without gains nothing holds the loop once a singular pose has let it slip"
METHODS = (
    adaptive(
        "dop853", 8, "SciPy DOP853, driven from Python, Baumgarte gains in loops",
        wrong_limit=SHRINK, weak_on=LOOPS, embedded=7, driven_from_python=True,
    ),
    fixed(
        "rk4", 4, "Runge-Kutta 4, driven from Python, Baumgarte gains in loops", stability=exponential(4),
        driven_from_python=True,
    ),
    fixed(
        "rk4" + NO_GAINS, 4, "Runge-Kutta 4, driven from Python, with Pinocchio's default gains of zero",
        requires=LOOPS, stability=exponential(4), wrong_limit=DRIFT, weak_on=LOOPS, driven_from_python=True,
    ),
)  # fmt: skip
