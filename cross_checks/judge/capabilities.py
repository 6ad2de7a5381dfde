"""What every engine can do, asked of the adapters themselves: no hand-written table."""

from __future__ import annotations

from dataclasses import dataclass

from cross_checks import engines
from cross_checks.engine import Engine, Method
from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.scene.traits import PART_TYPES


@dataclass(frozen=True)
class Capability:
    """One engine: what it is, which parts it translates, and which scenes it runs."""

    engine: str
    installed: bool
    reason: str  # why it is not installed, otherwise empty
    version: str
    methods: tuple[Method, ...]
    parts: dict[str, bool]  # part type -> translated
    scenes: dict[str, tuple[str, ...]]  # scene -> reasons to refuse; empty where it runs


def capabilities() -> list[Capability]:
    """Return what each engine can do with each part type and each scene as it comes."""
    probes = {name: scenes.make(name) for name in scenes.names()}
    return [_capability(name, probes) for name in engines.names()]


def _capability(name: str, probes: dict[str, Scene]) -> Capability:
    try:
        engine = engines.get(name)
    except engines.EngineMissing as error:
        return Capability(name, False, str(error), "", (), {}, {})
    parts = {kind: kind in engine.part_types for kind in PART_TYPES}
    answers = {label: _reasons(engine, scene) for label, scene in probes.items()}
    return Capability(name, True, "", engine.version(), tuple(engine.methods()), parts, answers)


def _reasons(engine: Engine, scene: Scene) -> tuple[str, ...]:
    """Return why no method of the engine runs the scene; empty where one does."""
    reasons = [refusal.reason for refusal in engine.refusals(scene)]
    if reasons:
        return tuple(reasons)
    refused = [engine.method_refusals(scene, method) for method in engine.methods()]
    return tuple(r.reason for each in refused for r in each) if all(refused) else ()
