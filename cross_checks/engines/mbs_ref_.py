"""The project's own reference solver, behind the same contract as every other engine."""

from importlib.util import find_spec
from typing import ClassVar

import numpy as np

from cross_checks.engine import Engine, Method, Refusal, stopped
from cross_checks.engine.celestial import contradictions
from mbs_ref import Scene, Settings, Status, Trajectory
from mbs_ref.integrators import integrators
from mbs_ref.integrators.loop.leg import Integrator
from mbs_ref.scene.scales import is_celestial
from mbs_ref.scene.traits import PART_TYPES
from mbs_ref.simulate import InconsistentScene, simulate
from mbs_ref.simulate.method_choice import AUTO
from mbs_ref.simulate.plan import obstacles
from mbs_ref.simulate.start_checks import UnsoundScene

CHOSEN = Method(AUTO, "adaptive", None, "chosen by what the scene contains and what its first steps tell")


class MbsRef(Engine):
    """mbs_ref.simulate, and nothing else."""

    name: ClassVar[str] = "mbs_ref"
    package: ClassVar[str] = "mbs_ref"
    distribution: ClassVar[str] = "mbs-ref"
    checks_start: ClassVar[bool] = True
    default_method: ClassVar[str | None] = AUTO
    part_types: ClassVar[frozenset[str]] = frozenset(PART_TYPES)

    def methods(self) -> tuple[Method, ...]:
        return tuple(_method(entry) for entry in integrators().values())

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        return [Refusal(reason, True) for reason in contradictions(scene)] if is_celestial(scene) else []

    def method(self, name: str | None) -> Method:
        return CHOSEN if name == AUTO else super().method(name)

    def method_refusals(self, scene: Scene, method: Method) -> list[Refusal]:
        if method is CHOSEN:
            return []
        integrator, reasons = integrators()[method.name], super().method_refusals(scene, method)
        reasons += [Refusal(f"{method.name}: {why}", never) for why, never in obstacles(scene, integrator)]
        package = integrator.package
        if package is not None and find_spec(package) is None:
            reasons.append(Refusal(f"{method.name} needs the package {package!r}, which is not installed", False))
        return reasons

    def run(self, scene: Scene, settings: Settings, times: np.ndarray | None = None) -> Trajectory:
        if refusal := self.refusal(scene, self.method(settings.method)):
            return stopped(scene, Status.REFUSED, refusal)
        try:
            return simulate(scene, settings, times)
        except InconsistentScene as error:
            return stopped(scene, Status.INCONSISTENT, str(error))
        except UnsoundScene as error:
            return stopped(scene, Status.REFUSED, str(error))


def _method(entry: Integrator) -> Method:
    """An integrator of either kind is listed as the adaptive one it is by default."""
    kind = "fixed" if entry.kind == "fixed" else "adaptive"
    return Method(
        entry.name, kind, entry.order, entry.description, entry.ladder, entry.requires,
        locates_events=entry.locates_events, stability=entry.stability, wrong_limit=entry.weakness,
        weak_on=frozenset({"constrained"}) if entry.weakness else frozenset(), embedded=entry.embedded,
    )  # fmt: skip


ENGINE = MbsRef
