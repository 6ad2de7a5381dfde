"""Drake's methods: continuous time with its integrators, discrete time with its SAP solver."""

from __future__ import annotations

from cross_checks.engine import Method, exponential

FIXED, SAP, WORLD, CENIC = "_fixed", "sap", "sap_world", "cenic"
STEPS = (2e-2, 1e-2, 5e-3, 2.5e-3, 1e-3, 5e-4, 2.5e-4, 1e-4)  # s
ACCURACIES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)  # of Drake's error control
TREES = frozenset({"closed-loop", "rod-in-space"})  # Drake has constraints in discrete time alone
DIES = "tied to the world body itself, constraints of discrete time end the process (SIGSEGV, seen in 1.58.0)"


def _continuous(name: str, order: int, text: str, embedded: int | None = None) -> Method:
    return Method(name, "adaptive", order, text, ACCURACIES, excludes=TREES, embedded=embedded)


def _stepped(name: str, order: int, text: str) -> Method:
    return Method(name + FIXED, "fixed", order, text, STEPS, excludes=TREES, stability=exponential(order))


METHODS = (
    _continuous("runge_kutta3", 3, "Drake's default: Runge-Kutta 3 with an embedded estimate", 2),
    _continuous("runge_kutta5", 5, "Runge-Kutta 5 with an embedded estimate (Dormand-Prince)", 4),
    _continuous("radau3", 3, "Radau IIA of two stages"),
    _stepped("runge_kutta3", 3, "Runge-Kutta 3 at a fixed step"),
    _stepped("runge_kutta2", 2, "Runge-Kutta 2 at a fixed step"),
    Method(SAP, "fixed", 1, "discrete time: symplectic Euler, constraints by SAP", STEPS),
    Method(
        WORLD,
        "fixed",
        1,
        "the same, loops to ground closed at Drake's own world body",
        STEPS,
        wrong_limit=DIES,
        weak_on=TREES,
    ),
    Method(CENIC, "adaptive", 1, "CENIC: SAP's convex step under error control", ACCURACIES[:3]),
)
