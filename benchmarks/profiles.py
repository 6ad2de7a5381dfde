"""Performance profiles: how often is a method within a factor of the best?"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from cross_checks.record import Record

ERRORS = (1e-3, 1e-6, 1e-9)  # m

Solver = tuple[str, str]  # engine, method


@dataclass(frozen=True)
class Profile:
    """The factors by which a solver is dearer than the best, sorted; problems it misses have none."""

    solver: Solver
    factors: tuple[float, ...]
    problems: int

    def share(self, tau: float) -> float:
        """Return rho(tau): the share of problems solved within tau times the best time."""
        return sum(factor <= tau for factor in self.factors) / self.problems


def profiles(records: Iterable[Record], error: float) -> list[Profile]:
    """Return each engine and method's profile at an error (m), the most often best first (Dolan & More 2002, eq 1)."""
    times: dict[str, dict[Solver, float]] = {}
    solvers: set[Solver] = set()
    for record in records:
        solver, problem = (record.engine, record.method), f"{record.scene} {sorted(record.parameters.items())}"
        solvers.add(solver)
        loop_s = record.times.get("loop_s", 0.0)
        if record.status != "success" or record.error is None or loop_s <= 0.0:
            continue  # censored: a failure has no time, and none is made up
        if record.error.value + record.error.uncertainty <= error:
            own = times.setdefault(problem, {})
            own[solver] = min(loop_s, own.get(solver, loop_s))
    found = [Profile(solver, _factors(times, solver), len(times)) for solver in sorted(solvers)] if times else []
    return sorted(found, key=lambda p: (-p.share(1.0), -p.share(10.0), p.solver))


def _factors(times: dict[str, dict[Solver, float]], solver: Solver) -> tuple[float, ...]:
    return tuple(sorted(own[solver] / min(own.values()) for own in times.values() if solver in own))
