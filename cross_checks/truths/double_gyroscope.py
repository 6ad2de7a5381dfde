"""Two gyroscopes in a row are a chain of two links on spherical joints."""

from cross_checks.truths.spatial_chain import solve

__all__ = ["solve"]
