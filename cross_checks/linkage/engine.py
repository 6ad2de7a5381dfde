"""What engines of minimal coordinates share: a model built from a scene's links, and the motion of the links."""

from typing import Any, ClassVar

import numpy as np

from cross_checks.engine import Engine, Poses, Refusal
from cross_checks.engine.plan import Plan
from cross_checks.linkage.forces import MECHANISM, PARTS, SHARED, contact_refusals, read
from cross_checks.linkage.links import closure_refusals
from cross_checks.linkage.motion import poses_of
from mbs_ref.scene import Scene


class LinkageEngine(Engine):
    """An engine whose model has a `linkage`, a `reader` of its states, and `applied` forces or None."""

    lacks: ClassVar[frozenset[str]] = frozenset()  # parts of links and shared forces that it cannot represent
    extra: ClassVar[frozenset[str]] = frozenset()  # parts that its own elements represent
    closes: ClassVar[frozenset[str]] = frozenset()  # kinds of closures that it represents (see Closure.kind)
    takes_loads: ClassVar[bool] = True  # whether forces from the shared force code can be applied

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        cls.part_types = (PARTS if cls.takes_loads else MECHANISM) - cls.lacks | cls.extra

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        return closure_refusals(self.name, scene, self.closes) + contact_refusals(scene)

    def poses(self, model: Any, plan: Plan, states: np.ndarray) -> Poses:
        return poses_of(model.linkage, (read(model.linkage, model.reader, state) for state in states))

    def notes(self, model: Any, plan: Plan) -> tuple[str, ...]:
        return (SHARED,) if model.applied else ()
