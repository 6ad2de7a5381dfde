"""The same tiny engine as the cross-checks' tests use."""

from tests.cross_checks.conftest import swing

__all__ = ["swing"]
