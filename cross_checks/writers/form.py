"""What a scene is written from: the model that an engine's adapter builds, and the settings of its run."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from cross_checks import engines
from cross_checks.engine import Engine, Plan, plan_run
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Trajectory


class NotWritable(ValueError):
    """A scene cannot be written in a form; the sentence names each element that stands in the way."""


@dataclass(frozen=True)
class Form:
    """One form that scenes are written in."""

    name: str
    suffix: str  # of the files
    about: str
    write: Callable[[Scene, Settings], str]


@dataclass(frozen=True)
class Job:
    """A scene, an engine, and what its adapter makes of the settings and the scene."""

    scene: Scene
    engine: Engine
    plan: Plan
    built: Any  # the adapter's own model, from which the written one is taken

    @property
    def title(self) -> str:
        """Return one sentence of what runs how."""
        plan = self.plan
        how = f"a step of {float(plan.step)!r} s" if plan.counts else f"rtol = {plan.rtol!r}, atol = {plan.atol!r}"
        return f"{self.scene.name} in {self.engine.name} {self.engine.version()}: {plan.method.name} with {how}."


def job_of(scene: Scene, settings: Settings, engine: str) -> Job:
    """Return what the engine's adapter would run.

    Raises EngineMissing, NotWritable with the adapter's own refusals, or ValueError for settings that it does not take.
    """
    adapter = engines.get(engine)
    plan = plan_run(adapter, scene, settings, None)
    if isinstance(plan, Trajectory):
        raise NotWritable(f"{scene.name} is not run by {engine}: {plan.message}")
    return Job(scene, adapter, plan, adapter.build(scene, plan))


def refuse(scene: Scene, form: str, reasons: Iterable[str]) -> None:
    """Raise NotWritable where there is a reason."""
    named = list(reasons)
    if named:
        raise NotWritable(f"{scene.name} cannot be written as {form}: {'; '.join(named)}")


def refuse_shared(job: Job) -> None:
    """Refuse loads and contacts whose forces our code computes for the engine; each is named."""
    parts = [f"{kind} {p.name!r} ({p.type})" for kind in ("load", "contact") for p in getattr(job.scene, f"{kind}s")]
    sentence = f"mbs-ref computes the forces of these, and {job.engine.name} alone cannot: {', '.join(parts)}"
    refuse(job.scene, job.engine.name, [sentence])
