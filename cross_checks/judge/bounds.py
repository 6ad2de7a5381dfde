"""What every method is asked, and how much work a run may take: the same for all."""

from __future__ import annotations

TARGETS = (1e-3, 1e-6, 1e-9)  # errors over the scene's scales
MOST_STEPS = 100_000  # that a run may take
