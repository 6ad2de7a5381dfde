"""The Engine contract: what a solver must offer to be compared, ours included."""

import warnings
from functools import cache
from importlib.metadata import version
from time import perf_counter
from typing import Any, ClassVar

import numpy as np

from cross_checks.engine.method import LOOPS, RTOLS, SINGLE, STEPS, Method, Refusal, adaptive, exponential, fixed
from cross_checks.engine.plan import End, Loop, Plan, end_of, output_times, plan_run, stopped
from mbs_ref import Scene, Settings
from mbs_ref.trajectory import Timing, Trajectory

__all__ = [
    "LOOPS", "RTOLS", "SINGLE", "STEPS", "End", "Engine", "Loop", "Method", "Plan", "Poses", "Refusal",
    "adaptive", "end_of", "exponential", "fixed", "output_times", "plan_run", "stopped",
]  # fmt: skip

type Poses = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]  # position, orientation, velocity, angular velocity
DRIVEN = "driven from Python"
_version = cache(version)  # every run asks for it: the keys of the store contain it


class Engine:
    """A solver behind one contract. An implementer's duties:

    1. `name` is unique, lower case; `package` is the import name whose absence means engine-missing.
    2. Import the package inside the methods or at the top of this one file, nowhere else.
    3. `method_table` lists every method with its documented order; the first is the default. An engine whose methods
       are known at run time alone overrides `methods()`, one that is no installed distribution `version()`.
    4. `part_types` names the scene parts translated (their `type` fields); everything else is refused, as "not yet"
       unless `no_equivalent` states why the engine has nothing for it.
    5. `refusals()` adds what depends on topology (see `traits`); it gives every reason at once.
    6. `build()` returns the engine's model of the scene, at t = 0 and ready to go.
    7. `first_call()` does what only the first call of the engine takes time for (compilation, allocation),
       and leaves the model at t = 0.
    8. `advance()` is what is timed: the engine's own loop to the output times, which are exact multiples of the
       step for fixed-step methods and never interpolated from coarse output; in compiled code where the engine
       has any, without output, hooks or verbosity, and without any check of ours.
    9. `collect()` turns what the loop left into rows at the output times, and finds the failures that the engine
       keeps to itself: silent resets, silent step changes, missed convergence. NaN is looked for by `run`.
    10. `poses()` returns world poses and velocities of those rows, `reactions()` the joint reactions, if known.

    `run` reads the settings, refuses what cannot be run, times build, first call and loop apart, and assembles the
    trajectory. An engine that cannot be cut like this may override `run` itself: duties 8 to 10 are then its own,
    and an unknown or unsupported setting is a ValueError that names it, its value and what is allowed.
    """

    name: ClassVar[str]
    package: ClassVar[str]
    distribution: ClassVar[str] = ""  # whose version is the engine's; the package unless given
    method_table: ClassVar[tuple[Method, ...]] = ()
    part_types: ClassVar[frozenset[str]]
    no_equivalent: ClassVar[dict[str, str]] = {}  # part types that the engine itself has nothing for, and why
    as_shipped: ClassVar[Settings | None] = None  # the settings of a user who chooses nothing, if there are such
    default_method: ClassVar[str | None] = None  # of a run by a user who names no method; the first unless given
    made_of: str = ""  # a digest of its adapter, where that is imported in another environment
    compiles: ClassVar[bool] = False  # its first run compiles a program, which later ones find stored
    checks_start: ClassVar[bool] = False  # refuses inconsistent initial states by itself; else the suite looks for it

    def methods(self) -> tuple[Method, ...]:
        """Return the methods, the default first."""
        return self.method_table

    def version(self) -> str:
        """Return the engine's version."""
        return _version(self.distribution or self.package)

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        """Return the reasons that follow from the scene's traits rather than its part types."""
        return []

    def build(self, scene: Scene, plan: Plan) -> Any:
        """Return the engine's model of the scene at t = 0."""
        raise NotImplementedError(f"{self.name} must offer build, advance and poses, or a run of its own")

    def first_call(self, model: Any, plan: Plan) -> None:
        """Do what takes time only once, and leave the model at t = 0."""

    def advance(self, model: Any, plan: Plan) -> Any:
        """Run the engine's loop and return a Loop, or what `collect` makes one of."""
        raise NotImplementedError(f"{self.name} must offer build, advance and poses, or a run of its own")

    def collect(self, model: Any, plan: Plan, left: Any) -> Loop:
        """Return the loop's result as rows at the output times; this is not part of the timed loop."""
        return left

    def poses(self, model: Any, plan: Plan, states: np.ndarray) -> Poses:
        """Return world poses and velocities of the first len(states) output times, as a Trajectory holds them."""
        raise NotImplementedError(f"{self.name} must offer build, advance and poses, or a run of its own")

    def reactions(self, model: Any, plan: Plan, states: np.ndarray, poses: Poses) -> dict[str, np.ndarray]:
        """Return joint reactions as a Trajectory holds them; empty where the engine gives none."""
        return {}

    def notes(self, model: Any, plan: Plan) -> tuple[str, ...]:
        """Return sentences for the user on how this run was computed."""
        return ()

    def run(self, scene: Scene, settings: Settings, times: np.ndarray | None = None) -> Trajectory:
        """Integrate and return poses and velocities at `times` (s; the first is 0).

        Without `times`, `settings.samples` even ones from 0 to `settings.t_end` or the scene's duration.
        """
        plan = plan_run(self, scene, settings, times)
        if isinstance(plan, Trajectory):
            return plan
        start = perf_counter()
        model = self.build(scene, plan)
        built = perf_counter()
        self.first_call(model, plan)
        called = perf_counter()
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            left = self.advance(model, plan)
        looped = perf_counter()
        warned = dict.fromkeys(f"{self.name} warned: {str(one.message).strip()}" for one in said)
        loop = self.collect(model, plan, left)
        end = end_of(loop.states.reshape(len(loop.states), -1), plan.times, loop.end)
        states = loop.states[: end.samples]
        poses = self.poses(model, plan, states)
        return Trajectory(
            plan.times[: end.samples], *poses, end.status, end.message or f"reached t = {plan.times[-1]:g} s",
            steps=loop.steps, rejected_steps=loop.rejected_steps, rhs_calls=loop.rhs_calls,
            timing=Timing(built - start, called - built, looped - called),
            reactions=self.reactions(model, plan, states, poses) if settings.reactions else {},
            notes=((DRIVEN,) if plan.method.driven_from_python else ()) + (*self.notes(model, plan), *warned),
            used=plan.used, unreported=end.unreported,
        )  # fmt: skip

    @property
    def library(self) -> str:
        """The package without its parts: engines of one library share code, and its mistakes."""
        return self.package.partition(".")[0]

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
        reasons = []
        for kind in missing:
            why = self.no_equivalent.get(kind)
            yet, because = ("yet ", "") if why is None else ("", f": {why}")
            sentence = f"{self.name} does not {yet}support the part type {kind!r}{because}"
            reasons.append(Refusal(sentence, permanent=why is not None))
        return reasons + self.topology_refusals(scene)

    def able(self, scene: Scene) -> list[Method]:
        """Return the methods that can run the scene."""
        return [] if self.refusals(scene) else [m for m in self.methods() if not self.method_refusals(scene, m)]

    def method_refusals(self, scene: Scene, method: Method) -> list[Refusal]:
        """Return why this method of the engine cannot run the scene."""
        from mbs_ref.scene.traits import traits

        present = traits(scene)
        reasons = [f"{method.name} needs a scene that is {t}" for t in sorted(method.requires - present)]
        reasons += [f"{method.name} cannot model a scene that is {t}" for t in sorted(method.excludes & present)]
        return [Refusal(reason, permanent=True) for reason in reasons]

    def refusal(self, scene: Scene, method: Method) -> str:
        """Return why this method cannot run the scene as one text; empty when it can."""
        return Refusal.text((*self.refusals(scene), *self.method_refusals(scene, method)))
