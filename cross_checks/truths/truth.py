"""Reference solutions with a stated uncertainty, the reasons for having none, and the limit of their computation."""

import math
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numba.core.event import Event, Listener, register

from mbs_ref.scene.euler_parameters import from_axis_angle

EPS = float(np.finfo(float).eps)
ONE_FIGURE = 10.0  # times the uncertainty: of such a difference, and of larger ones, a truth knows a figure
NO_ERROR = "no error: "  # begins the note of a run that is compared with no truth
# Uncertainty over the gap of two runs whose errors are of one size: their standard deviation is gap / sqrt(2), and
# Student's t for one degree of freedom covers 95 % (JCGM 100:2008, annex G.3). Where the other run is the coarser one,
# the gap is its error and needs no factor.
ALIKE = math.tan(0.475 * math.pi) / math.sqrt(2.0)


@dataclass(frozen=True)
class Truth:
    """World poses of every body at the requested times, and their rates where they are known.

    A truth "proven" is the middle of an enclosure by a proof: a limit outside it is wrong by a theorem. One "agreed"
    comes from two packages. One of "one-package" comes from two methods of a single package: errors from it are shown,
    but it confirms no method and calls none wrong.

    The exact motion is within the uncertainty with a probability of 95 % at least (an expanded uncertainty, JCGM
    100:2008, 6.2), and surely of one "proven". A run at a distance e therefore has an error of e - u to e + u.
    """

    position: np.ndarray  # (n_t, n_bodies, dimension) m, centres of mass
    orientation: np.ndarray  # (n_t, n_bodies) rad; in space (n_t, n_bodies, 4) Euler parameters
    uncertainty: float  # m, of every world point at every time
    kind: Literal["proven", "exact", "published", "converged", "agreed", "one-package"]
    how: str  # one sentence
    difference: float | None = None  # m, between two unlike ways to it; None where there is one alone
    is_costly: bool = False  # takes so long to make that `mbs-ref certify --write` keeps its poses
    velocity: np.ndarray | None = None  # (n_t, n_bodies, dimension) m/s
    angular_velocity: np.ndarray | None = None  # (n_t, n_bodies) or (n_t, n_bodies, 3) rad/s, world axes
    rate_uncertainty: np.ndarray | None = None  # (n_t,) m/s and rad/s; inf where the rates are not known
    turn_uncertainty: float | None = None  # rad; unless given, the angle that `uncertainty` of a near point makes


def unturned(position: np.ndarray) -> np.ndarray:
    """Return angles or Euler parameters (n_t, n_bodies, 4) of bodies that do not turn, by their positions."""
    times, bodies, dimension = position.shape
    return np.zeros((times, bodies)) if dimension == 2 else np.tile([1.0, 0.0, 0.0, 0.0], (times, bodies, 1))


def of_one_body(x: np.ndarray, y: np.ndarray, angle: Any, uncertainty: float, how: str) -> Truth:
    """Return the exact truth of one body in the plane: x and y (n_t,), m, and one angle (rad), or one for each time."""
    return Truth(np.stack((x, y), axis=1)[:, None], np.full_like(x, angle)[:, None], uncertainty, "exact", how)


def in_space(flat: Truth) -> Truth:
    """Return the truth of a planar motion that happens in the plane z = 0 of space."""

    def lifted(vectors: np.ndarray | None) -> np.ndarray | None:
        return None if vectors is None else np.insert(vectors, 2, 0.0, axis=2)

    turning = None if flat.angular_velocity is None else flat.angular_velocity[..., None] * (0.0, 0.0, 1.0)
    turned = from_axis_angle((0.0, 0.0, 1.0), flat.orientation)
    lines: dict[str, Any] = {"position": lifted(flat.position), "velocity": lifted(flat.velocity)}
    return replace(flat, orientation=turned, angular_velocity=turning, **lines)


@dataclass(frozen=True)
class NoTruth:
    """Why there is nothing to compare with.

    The kind is "one-package" where a single package runs the scene, and "defect" where the computation of a truth
    raises an exception that it does not document.
    """

    reason: str
    kind: Literal["none", "one-package", "defect"] = "none"
    limit_s: float | None = None  # of processor time: within a longer limit there may be a truth


class NoConvergenceError(ArithmeticError):
    """The computation of a truth does not reach its tolerance, or not within its limit of processor time."""


class OutsideDomainError(ValueError):
    """The equations of a truth do not hold at these parameters."""


class _Compilation(Listener, threading.local):
    """Adds up the processor time (s) that a thread compiles; the compilation of one function may contain others."""

    spent, began, depth = 0.0, 0.0, 0

    def on_start(self, event: Event) -> None:
        self.began = self.began if self.depth else time.thread_time()
        self.depth += 1

    def on_end(self, event: Event) -> None:
        self.depth -= 1
        self.spent += 0.0 if self.depth else time.thread_time() - self.began


_compilation = _Compilation()
register("numba:compile", _compilation)


def _now() -> float:
    """Return the thread's processor time (s) without compilation, which is done once for all scenes."""
    return time.thread_time() - _compilation.spent


# the end (s of `_now`) and the length (s) of the current limit
_limit: ContextVar[tuple[float, float]] = ContextVar("limit", default=(math.inf, math.inf))


@contextmanager
def time_limit(seconds: float) -> Iterator[float]:
    """Limit the processor time (s) of the computation inside; an outer limit still holds. Yield the shorter of both."""
    end, length = _limit.get()
    shortest = min(length, seconds)
    token = _limit.set((min(end, _now() + seconds), shortest))
    try:
        yield shortest
    finally:
        _limit.reset(token)


def check_time(t: float) -> None:
    """Raise NoConvergenceError with the time reached, t (s) of the motion, where the limit is exceeded."""
    if _now() > _limit.get()[0]:
        raise NoConvergenceError(f"the limit of processor time ends the computation at t = {float(t):.6g} s")


SHARE, MARGIN = 0.1, 2.0  # of the limit after which the pace counts; the factor by which a motion may speed up later


class Pace:
    """Whether an integration over `times` (s, increasing) will end within the limit of processor time."""

    def __init__(self, times: np.ndarray) -> None:
        self.first, self.last, self.began = float(times[0]), float(times[-1]), _now()

    def check(self, t: float) -> None:
        """Raise NoConvergenceError where the limit is exceeded, or would be by far, at t (s) of the motion."""
        check_time(t)
        if not t > self.first:
            self.began = _now()  # what comes before the first step is no part of the pace
            return
        length, spent = _limit.get()[1], _now() - self.began
        if spent > SHARE * length:
            needed = spent * (self.last - self.first) / (t - self.first)
            if needed > MARGIN * length:
                raise NoConvergenceError(
                    f"the computation needs some {needed:.2g} s of processor time, and its limit is {length:g} s"
                )
