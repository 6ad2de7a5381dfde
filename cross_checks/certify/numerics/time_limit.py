"""The processor time that a truth may take, checked at every step of its computation."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from cross_checks.truth import NoConvergenceError

_deadline: ContextVar[float] = ContextVar("deadline", default=math.inf)  # s of the thread's processor time


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Limit the computation inside to so much processor time (s); an outer limit that ends earlier holds."""
    token = _deadline.set(min(_deadline.get(), time.thread_time() + seconds))
    try:
        yield
    finally:
        _deadline.reset(token)


def check_time(t: float) -> None:
    """Raise NoConvergenceError with the time reached, t (s) of the motion, where the limit is exceeded."""
    if time.thread_time() > _deadline.get():
        raise NoConvergenceError(f"the limit of processor time ends the computation at t = {float(t):.6g} s")
