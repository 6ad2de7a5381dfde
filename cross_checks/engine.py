"""The Engine contract: what a solver must offer to be compared, ours included."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from math import factorial
from typing import ClassVar, Literal

import numpy as np

from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Trajectory


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
    weak_on: frozenset[str] = frozenset()  # ... on scenes with any of these traits: it excuses there, nowhere else

    def excused(self, scene: Scene) -> str:
        """Return why the method is known to go wrong on this very scene; empty where it is not."""
        from mbs_ref.scene.traits import traits

        return self.wrong_limit if self.weak_on & traits(scene) else ""


def exponential(order: int) -> tuple[float, ...]:
    """Return R(z) of an explicit method with as many stages as its order: exp(z) up to there."""
    return tuple(1.0 / factorial(k) for k in range(order + 1))


@dataclass(frozen=True)
class Refusal:
    """Why an engine cannot run a scene."""

    reason: str
    permanent: bool  # True: never, by its nature; False: not yet taught


class Engine(ABC):
    """A solver behind one contract. An implementer's duties:

    1. `name` is unique, lower case; `package` is the import name whose absence means engine-missing.
    2. Import the package inside the methods or at the top of this one file, nowhere else.
    3. `methods()` lists every method with its documented order; the first is the default.
    4. `part_types` names the scene parts translated (their `type` fields); everything else is refused.
    5. `refusals()` adds what depends on topology (see `traits`); it gives every reason at once.
    6. `run()` builds, integrates and returns world poses and velocities at the asked times, exact
       multiples of the step for fixed-step methods, never interpolated from coarse output.
    7. An unknown or unsupported setting is a ValueError that names it, its value and what is allowed.
    8. Failure is a status with a sentence: NaN, silent resets, silent step changes and missed
       convergence are looked for here, because nobody else can.
    9. Build, first call and loop are timed apart; the loop runs in the engine's own compiled code
       where it has one, without output, hooks or verbosity.
    """

    name: ClassVar[str]
    package: ClassVar[str]
    part_types: ClassVar[frozenset[str]]
    checks_start: ClassVar[bool] = False  # refuses inconsistent initial states by itself; else the suite looks for it

    @abstractmethod
    def methods(self) -> tuple[Method, ...]:
        """Return the methods, the default first."""

    @abstractmethod
    def version(self) -> str:
        """Return the engine's version."""

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        """Return the reasons that follow from the scene's traits rather than its part types."""
        return []

    @abstractmethod
    def run(self, scene: Scene, settings: Settings, times: np.ndarray | None = None) -> Trajectory:
        """Integrate and return poses and velocities at `times` (s; the first is 0).

        Without `times`, `settings.samples` even ones from 0 to `settings.t_end` or the scene's duration.
        """

    def method(self, name: str | None) -> Method:
        """Return the named method, or the default; ValueError lists what is allowed."""
        methods = self.methods()
        for method in methods:
            if name is None or method.name == name:
                return method
        raise ValueError(f"method = {name!r} is unknown to {self.name}; allowed: {', '.join(m.name for m in methods)}")

    def refusals(self, scene: Scene) -> list[Refusal]:
        """Return every reason why the scene cannot be run; empty when it can."""
        from mbs_ref.scene.traits import part_types

        missing = sorted(part_types(scene) - self.part_types)
        sentence = f"{self.name} is not yet taught the part type"
        return [Refusal(f"{sentence} {kind!r}", permanent=False) for kind in missing] + self.topology_refusals(scene)

    def method_refusals(self, scene: Scene, method: Method) -> list[Refusal]:
        """Return why this method of the engine cannot run the scene."""
        from mbs_ref.scene.traits import traits

        found = traits(scene)
        reasons = [f"{method.name} needs a scene that is {t}" for t in sorted(method.requires - found)]
        reasons += [f"{method.name} cannot model a scene that is {t}" for t in sorted(method.excludes & found)]
        return [Refusal(reason, permanent=True) for reason in reasons]


def output_times(scene: Scene, settings: Settings, times: np.ndarray | None) -> np.ndarray:
    """Return the asked times, or the settings' even grid."""
    if times is not None:
        return np.asarray(times, dtype=float)
    t_end = settings.t_end if settings.t_end is not None else scene.duration
    return np.linspace(0.0, t_end, settings.samples)
