"""The vertebral android: the simplified one's truth with more bodies."""

from __future__ import annotations

from cross_checks.truths.android_simplified import solve

__all__ = ["solve"]
