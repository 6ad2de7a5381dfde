"""NASA's check case 1, converged: the fall under the oblate Earth's gravity."""

from cross_checks.truths.satellite import solve

__all__ = ["solve"]
