"""Performance profiles: how often is a method within a factor of the best?"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from cross_checks.records.record import Record

ERRORS = (1e-3, 1e-6, 1e-9)  # over the scenes' scales

Solver = tuple[str, str]  # engine, method
Problem = str  # a scene with its parameters


@dataclass(frozen=True)
class Profile:
    """The factors by which a solver is dearer than the best, sorted; problems it misses have none."""

    solver: Solver
    factors: tuple[float, ...]
    problems: int

    def share(self, tau: float) -> float:
        """Return rho(tau): the share of problems solved within tau times the best time."""
        return sum(factor <= tau for factor in self.factors) / self.problems

    @property
    def solved(self) -> float:
        """The share of problems solved at whatever cost: rho at infinity."""
        return len(self.factors) / self.problems


def profiles(records: Iterable[Record], error: float) -> list[Profile]:
    """Return each engine and method's profile at an error, the most often best first (Dolan & More 2002, eq 1).

    Problems that nobody solves are left out, and those whose truth is not known 30 times better than `error`.
    """
    times: dict[Problem, dict[Solver, float]] = {}
    solvers: set[Solver] = set()
    unjudged: set[Problem] = set()
    for record in records:
        solver, problem = (record.engine, record.method), f"{record.scene} {sorted(record.parameters.items())}"
        solvers.add(solver)
        loop_s = record.times.get("loop_s", 0.0)
        if record.status != "success" or record.error is None or loop_s <= 0.0:
            continue  # censored: a failure has no time, and none is made up
        if error < record.error.floor:
            unjudged.add(problem)
        if record.error.bound <= error:
            own = times.setdefault(problem, {})
            own[solver] = min(loop_s, own.get(solver, loop_s))
    judged = {problem: own for problem, own in times.items() if problem not in unjudged}
    profiles = [Profile(solver, _factors(judged, solver), len(judged)) for solver in sorted(solvers)] if judged else []
    return sorted(profiles, key=lambda p: (-p.share(1.0), -p.share(10.0), -p.solved, p.solver))


def _factors(times: dict[Problem, dict[Solver, float]], solver: Solver) -> tuple[float, ...]:
    return tuple(sorted(own[solver] / min(own.values()) for own in times.values() if solver in own))
