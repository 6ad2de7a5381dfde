"""NASA's check case 2 is Euler's top: exact in Jacobi's elliptic functions."""

from cross_checks.truths.torque_free_top import solve

__all__ = ["solve"]
