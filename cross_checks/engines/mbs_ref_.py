"""The project's own reference solver, behind the same contract as every other engine."""

from __future__ import annotations

from importlib.metadata import version
from importlib.util import find_spec
from typing import ClassVar

import numpy as np

from cross_checks.engine import Engine, Method, Refusal
from cross_checks.outcome import refuse_spatial, stopped
from mbs_ref.integrators import integrators
from mbs_ref.integrators.leg import Integrator
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate import InconsistentScene, simulate
from mbs_ref.trajectory import Status, Trajectory

PART_TYPES = (
    "planar point_mass revolute prismatic weld distance coordinate_drive point_drive "
    "force torque spring_damper torsion_spring bushing user_force "
    "circle_on_line circle_on_circle pin_on_sprocket "
    "spring_damper_law progressive_law hunt_crossley_law lankarani_nikravesh_law flores_law rigid_law "
    "regularised_coulomb stick_slip"
)


class MbsRef(Engine):
    """mbs_ref.simulate, and nothing else."""

    name: ClassVar[str] = "mbs_ref"
    package: ClassVar[str] = "mbs_ref"
    part_types: ClassVar[frozenset[str]] = frozenset(PART_TYPES.split())

    def methods(self) -> tuple[Method, ...]:
        return tuple(_method(entry) for entry in integrators().values())

    def version(self) -> str:
        return version("mbs-ref")

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        return refuse_spatial(self, scene)

    def method_refusals(self, scene: Scene, method: Method) -> list[Refusal]:
        package = integrators()[method.name].package
        missing = package is not None and find_spec(package) is None
        absent = [Refusal(f"{method.name} needs the package {package!r}, which is not installed", False)]
        return super().method_refusals(scene, method) + (absent if missing else [])

    def run(self, scene: Scene, settings: Settings, times: np.ndarray | None = None) -> Trajectory:
        method = self.method(settings.method)
        reasons = self.refusals(scene) + self.method_refusals(scene, method)
        if reasons:
            return stopped(scene, Status.REFUSED, "; ".join(refusal.reason for refusal in reasons))
        try:
            return simulate(scene, settings, times)
        except InconsistentScene as error:
            return stopped(scene, Status.INCONSISTENT, str(error))


def _method(entry: Integrator) -> Method:
    """An integrator of either kind is listed as the adaptive one it is by default."""
    kind = "fixed" if entry.kind == "fixed" else "adaptive"
    return Method(entry.name, kind, entry.order, entry.description, entry.ladder)


ENGINE = MbsRef
