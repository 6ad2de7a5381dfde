"""Simbody's integrators as OpenSim offers them; its manager projects on the constraints after every step."""

from __future__ import annotations

from cross_checks.engine import Method

ACCURACIES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)  # of Simbody's error control
STEPS = (2e-2, 1e-2, 5e-3, 2.5e-3, 1e-3, 5e-4, 2.5e-4, 1e-4)  # s
FIXED = "_fixed"
SHORTEST = 2e-8  # of a run: no step is shorter, whatever its error, for 5e7 steps are the most that a run may take
ENDLESS = "cpodes"  # in loops: no limit on steps ends it (seen in 4.6 on spatial_n_four_bar at 1e-8)
INTEGRATORS = {
    "rk_merson": "RungeKuttaMerson",
    "rk_feldberg": "RungeKuttaFeldberg",
    "rk3": "RungeKutta3",
    "verlet": "Verlet",
    "cpodes": "CPodes",
}
METHODS = (
    Method("rk_merson", "adaptive", 4, "OpenSim's default: Runge-Kutta-Merson", ACCURACIES, embedded=3),
    Method("rk_feldberg", "adaptive", 5, "Runge-Kutta-Fehlberg", ACCURACIES),
    Method("rk3", "adaptive", 3, "Runge-Kutta 3 with an embedded estimate", ACCURACIES, embedded=2),
    Method("verlet", "adaptive", 2, "velocity Verlet", ACCURACIES[:4]),
    Method("cpodes", "adaptive", None, "CPODES: variable-order BDF", ACCURACIES),
    Method("rk_merson" + FIXED, "fixed", 4, "Runge-Kutta-Merson at a fixed step", STEPS),
)
