"""A method of an engine, and why an engine cannot run a scene."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from math import factorial
from typing import Any, Literal

from mbs_ref import Scene
from mbs_ref.scene.traits import traits

STEPS = (2e-2, 1e-2, 5e-3, 2.5e-3, 1e-3, 5e-4, 2.5e-4, 1e-4)  # s, that a sweep of a fixed-step method tries
RTOLS = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)  # that a sweep of an adaptive method tries
LOOPS = frozenset({"closed-loop"})
MOST_ALIKE = 8  # reasons that differ by names alone and are shown in full
DOUBLE, SINGLE = 2.0**-53, 2.0**-24  # unit roundoff of IEEE 754 arithmetic


@dataclass(frozen=True)
class Method:
    """One way an engine integrates."""

    name: str
    kind: Literal["fixed", "adaptive"]
    order: int | None  # of convergence in the step, as documented; None where it varies
    description: str
    ladder: tuple[float, ...] = ()  # steps (s) or rtols a sweep tries, coarse to fine
    requires: frozenset[str] = frozenset()  # traits the scene must have ...
    excludes: frozenset[str] = frozenset()  # ... or must not have (see mbs_ref.scene.traits)
    locates_events: bool = False  # touch-down, lift-off, slip; else contact forces are clipped by the state
    stability: tuple[float, ...] = ()  # explicit fixed-step methods: coefficients of R(z), lowest power first
    wrong_limit: str = ""  # why it is known to fail or converge elsewhere ...
    weak_on: frozenset[str] = frozenset()  # ... on scenes with any of these traits: an exemption there, nowhere else
    weak_also: tuple[tuple[str, frozenset[str]], ...] = ()  # further causes, each with its traits
    driven_from_python: bool = False  # the engine gives accelerations alone; the time loop is Python code of ours
    embedded: int | None = None  # order of the solution that a pair's estimate of errors compares with, as in 5(4)
    roundoff: float = DOUBLE  # by which a step's result is off, over its size, for want of digits

    @property
    def local_order(self) -> int:
        """The power of a step that the estimate of its error follows, 6 where no order is documented.

        Pairs compare with an embedded solution of lower order; others estimate the local error of their own.
        """
        compared = (self.order or 5) if self.embedded is None else self.embedded
        return compared + 1

    def rounding(self, steps: int) -> float:
        """Return what rounding may add up to over the scene's scales: each step leaves the state off by `roundoff`."""
        return self.roundoff * steps

    def exemption(self, scene: Scene) -> str:
        """Return why the method is known to go wrong on this very scene; empty where it is not."""
        causes = ((self.wrong_limit, self.weak_on), *self.weak_also)
        return "; ".join(why for why, weak_on in causes if weak_on & traits(scene))


def fixed(name: str, order: int | None, text: str, ladder: tuple[float, ...] = STEPS, **more: Any) -> Method:
    """Return a fixed-step method; `more` are other fields of Method."""
    return Method(name, "fixed", order, text, ladder, **more)


def adaptive(name: str, order: int | None, text: str, ladder: tuple[float, ...] = RTOLS, **more: Any) -> Method:
    """Return an adaptive method; `more` are other fields of Method."""
    return Method(name, "adaptive", order, text, ladder, **more)


def exponential(order: int) -> tuple[float, ...]:
    """Return R(z) of an explicit method with as many stages as its order: exp(z) up to there."""
    return tuple(1.0 / factorial(k) for k in range(order + 1))


@dataclass(frozen=True)
class Refusal:
    """Why an engine cannot run a scene."""

    reason: str
    permanent: bool  # True: never, by its nature; False: not yet supported

    @staticmethod
    def text(refusals: Iterable["Refusal"]) -> str:
        """Return the reasons as one text; a count for more than MOST_ALIKE that differ by quoted names."""
        alike: dict[str, dict[str, None]] = {}
        for one in refusals:
            alike.setdefault(re.sub(r"(?<!\w)'[^']*'", "''", one.reason), {})[one.reason] = None
        return "; ".join(
            "; ".join(group) if len(group) <= MOST_ALIKE else f"{next(iter(group))} (and {len(group) - 1} more like it)"
            for group in alike.values()
        )
