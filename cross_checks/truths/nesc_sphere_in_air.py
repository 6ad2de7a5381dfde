"""NASA's check cases 4 and 5, converged: the fall through the standard atmosphere."""

from cross_checks.truths.satellite import solve

__all__ = ["solve"]
