"""Signals as functions of time, for engines that take their loads and drives from callbacks."""

import math
from bisect import bisect_right
from dataclasses import dataclass

from mbs_ref.scene.signals import Constant, Level, Segment, Signal, motion_segments


@dataclass(frozen=True)
class Prescribed:
    """A piecewise function of time (s) and its rate."""

    segments: tuple[Segment, ...]

    def _segment(self, t: float) -> Segment:
        return self.segments[max(0, bisect_right([s.start for s in self.segments], t) - 1)]

    def value(self, t: float) -> float:
        segment = self._segment(t)
        return segment.coefficients[0] if math.isinf(segment.start) else segment.value(t)

    def rate(self, t: float) -> float:
        segment = self._segment(t)
        if math.isinf(segment.start):
            return 0.0
        tau = t - segment.start
        polynomial = sum(k * c * tau ** (k - 1) for k, c in enumerate(segment.coefficients) if k)
        return polynomial + segment.amplitude * segment.omega * math.cos(segment.omega * tau + segment.phase)


def displacement(motion: Signal, level: Level) -> Prescribed:
    """Return the motion a drive prescribes: zero at t = 0 (m or rad)."""
    return Prescribed(tuple(motion_segments(motion, level)))


def factor(signal: Signal) -> Prescribed:
    """Return a load's factor."""
    return Prescribed(tuple(signal.segments()))


def constant_value(signal: Signal) -> float | None:
    """Return a signal's value if it never changes."""
    return signal.value if isinstance(signal, Constant) else None
