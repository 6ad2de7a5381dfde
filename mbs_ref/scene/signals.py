"""Functions of time: what drives, pulses and switched loads follow.

Every signal reduces to segments between breakpoints; on a segment it is a polynomial plus one
sinusoid. The family is closed under integration, so prescribed accelerations become exact
prescribed motions, and the breakpoints are declared to every integrator.
"""

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from pydantic import Field, model_validator

from mbs_ref.scene.base.part import Part, Positive

DEGREE = 6  # highest polynomial degree a compiled segment carries (4 plus two integrations)


class Segment(NamedTuple):
    """One smooth piece: sum_k coefficients[k] tau^k + amplitude sin(omega tau + phase), tau = t - start."""

    start: float  # s
    coefficients: tuple[float, ...]
    amplitude: float = 0.0
    omega: float = 0.0  # rad/s
    phase: float = 0.0  # rad

    def value(self, t: Any, sine: Callable[[Any], Any] = math.sin) -> Any:
        """Return the value at a time t (s), or, with NumPy's sine, at many."""
        tau = t - self.start if math.isfinite(self.start) else 0.0  # only constants hold from -inf on
        polynomial = sum(c * tau**k for k, c in enumerate(self.coefficients))
        return polynomial + self.amplitude * sine(self.omega * tau + self.phase)

    def rate(self, t: Any, cosine: Callable[[Any], Any] = math.cos) -> Any:
        """Return the derivative in the same way."""
        tau = t - self.start if math.isfinite(self.start) else 0.0
        polynomial = sum(k * c * tau ** (k - 1) for k, c in enumerate(self.coefficients) if k)
        return polynomial + self.amplitude * self.omega * cosine(self.omega * tau + self.phase)

    def integral(self, initial: float) -> "Segment":
        """Return the antiderivative that equals `initial` at the segment's start."""
        raised = [c / (k + 1) for k, c in enumerate(self.coefficients)]
        if self.amplitude == 0.0:
            return Segment(self.start, (initial, *raised))
        amplitude = self.amplitude / self.omega
        # -cos(x) = sin(x - pi/2)
        offset = initial + amplitude * math.cos(self.phase)
        return Segment(self.start, (offset, *raised), amplitude, self.omega, self.phase - math.pi / 2)


class Constant(Part):
    """A value that does not change."""

    type: Literal["constant"] = "constant"
    value: float = 1.0  # of what the signal stands for

    def segments(self) -> list[Segment]:
        return [Segment(-math.inf, (self.value,))]


class Table(Part):
    """Linear between (time, value) points; a repeated time is a jump; the end values hold outside."""

    type: Literal["table"] = "table"
    times: tuple[float, ...] = Field(min_length=1)  # s
    values: tuple[float, ...] = Field(min_length=1)  # one for each time

    @model_validator(mode="after")
    def _check(self) -> Self:
        if len(self.times) != len(self.values):
            raise ValueError(f"times has {len(self.times)} entries and values {len(self.values)}; they must match")
        for before, after in pairwise(self.times):
            if after < before:
                raise ValueError(f"times must not decrease, but {after} follows {before}")
        if any(a == b == c for a, b, c in zip(self.times, self.times[1:], self.times[2:], strict=False)):
            raise ValueError("a time may occur at most twice (the value before and after a jump)")
        return self

    def segments(self) -> list[Segment]:
        pieces = [Segment(-math.inf, (self.values[0],))]
        points = list(zip(self.times, self.values, strict=True))
        for (t0, f0), (t1, f1) in pairwise(points):
            if t1 > t0:
                pieces.append(Segment(t0, (f0, (f1 - f0) / (t1 - t0))))
        pieces.append(Segment(self.times[-1], (self.values[-1],)))
        return pieces


class HalfSine(Part):
    """A half-sine pulse of the given peak, zero before `start` and after `start + duration`."""

    type: Literal["half_sine"] = "half_sine"
    peak: float  # of what the signal stands for
    duration: Positive  # s
    start: float = 0.0  # s

    def segments(self) -> list[Segment]:
        pulse = Segment(self.start, (0.0,), self.peak, math.pi / self.duration, 0.0)
        return [Segment(-math.inf, (0.0,)), pulse, Segment(self.start + self.duration, (0.0,))]


class Harmonic(Part):
    """offset + amplitude sin(omega t + phase)."""

    type: Literal["harmonic"] = "harmonic"
    amplitude: float  # of what the signal stands for
    omega: float  # rad/s
    phase: float = 0.0  # rad
    offset: float = 0.0  # of what the signal stands for

    def segments(self) -> list[Segment]:
        if self.omega == 0.0:
            return [Segment(0.0, (self.offset + self.amplitude * math.sin(self.phase),))]
        return [Segment(0.0, (self.offset,), self.amplitude, self.omega, self.phase)]


class Polynomial(Part):
    """sum_k coefficients[k] t^k, of degree 4 at most."""

    type: Literal["polynomial"] = "polynomial"
    coefficients: tuple[float, ...] = Field(min_length=1, max_length=5)  # of t^0, t^1, ... with t in s

    def segments(self) -> list[Segment]:
        return [Segment(0.0, self.coefficients)]


AnySignal = Constant | Table | HalfSine | Harmonic | Polynomial
Signal = Annotated[AnySignal, Field(discriminator="type")]
Level = Literal["position", "velocity", "acceleration"]


def breakpoints(signal: Signal) -> list[float]:
    """Return the times (s) at which the signal or its derivatives may jump."""
    return [piece.start for piece in signal.segments()[1:]]


def piece_at(pieces: list[Segment], t: float) -> Segment:
    """Return the segment that contains the time t (s), at a jump the later one."""
    begun = [piece for piece in pieces if piece.start <= t]
    return begun[-1] if begun else pieces[0]


def _integrate(pieces: list[Segment]) -> list[Segment]:
    """Return the continuous antiderivative that vanishes at t = 0."""
    result: list[Segment] = []
    for piece in _anchored(pieces):
        result.append(piece.integral(result[-1].value(piece.start) if result else 0.0))
    return _from_zero(result)


def _from_zero(pieces: list[Segment]) -> list[Segment]:
    """Return the pieces less their value at t = 0."""
    first = piece_at(pieces, 0.0).value(0.0)
    return [p._replace(coefficients=(p.coefficients[0] - first, *p.coefficients[1:])) for p in pieces]


def _anchored(pieces: list[Segment]) -> list[Segment]:
    """Return the signal with a finite start of its constant first segment, before all other times."""
    first, *following = pieces
    if math.isfinite(first.start):
        return pieces
    return [first._replace(start=min([0.0, *(p.start for p in following)]) - 1.0), *following]


def motion_segments(signal: Signal, level: Level) -> list[Segment]:
    """Return the displacement whose `level`-th derivative is the signal; zero at t = 0 (and at rest
    there where the level is acceleration; the signal's own value sets the rate where it is velocity).
    """
    pieces = signal.segments()
    for _ in range({"position": 0, "velocity": 1, "acceleration": 2}[level]):
        pieces = _integrate(pieces)
    return _from_zero(_anchored(pieces))


def values(signal: Signal, times: np.ndarray) -> np.ndarray:
    """Return the signal's values (n_t,); at a jump the later one."""
    return _over(signal.segments(), times, lambda piece, t: piece.value(t, np.sin))


def prescribed(signal: Signal, level: Level, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the displacement a drive prescribes, zero at t = 0, and its rate; each (n_t,)."""
    pieces = motion_segments(signal, level)
    rates = _over(pieces, times, lambda piece, t: piece.rate(t, np.cos))
    return _over(pieces, times, lambda piece, t: piece.value(t, np.sin)), rates


def _over(pieces: list[Segment], times: np.ndarray, of: Callable[[Segment, np.ndarray], Any]) -> np.ndarray:
    starts, result = [piece.start for piece in pieces], np.empty(len(times), dtype=np.result_type(times, float))
    chosen = np.clip(np.searchsorted(starts, times, side="right") - 1, 0, None)
    for k, piece in enumerate(pieces):
        result[chosen == k] = of(piece, times[chosen == k])
    return result
