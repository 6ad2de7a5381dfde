"""What each engine can model, asked of its adapter: can, some methods, not yet, never."""

from __future__ import annotations

from cross_checks import engines
from cross_checks.engine import Engine, Refusal
from mbs_ref.scene import Scene
from mbs_ref.scene.traits import ALL_TRAITS, PART_TYPES, traits
from reports.facts.report_data import Capability


def capabilities(probes: dict[str, Scene]) -> tuple[Capability, ...]:
    """Return an answer for every engine and part type, and for every trait that one of the scenes shows."""
    return tuple(answer for name in engines.names() for answer in _of_engine(name, probes))


def _of_engine(name: str, probes: dict[str, Scene]) -> list[Capability]:
    shown = [trait for trait in ALL_TRAITS if any(trait in traits(scene) for scene in probes.values())]
    try:
        engine = engines.get(name)
    except engines.EngineMissing as error:
        asked = [*(("part", kind) for kind in PART_TYPES), *(("trait", trait) for trait in shown)]
        return [Capability(name, kind, what, "missing", str(error)) for kind, what in asked]
    parts = [Capability(name, "part", k, "can" if k in engine.part_types else "not-yet") for k in PART_TYPES]
    return parts + [_of_trait(engine, trait, probes) for trait in shown]


def _of_trait(engine: Engine, trait: str, probes: dict[str, Scene]) -> Capability:
    """Judge by the scenes that show the trait: the best answer among them is what the engine can do."""
    refusals = [_refusals(engine, scene) for scene in probes.values() if trait in traits(scene)]
    if all(refusals):
        mildest = min(refusals, key=lambda found: _word(found) == "never")
        return Capability(engine.name, "trait", trait, _word(mildest), _reasons(mildest))
    barred = [method.name for method in engine.methods() if trait in method.excludes]
    reason = f"all but {', '.join(barred)}" if barred else ""
    return Capability(engine.name, "trait", trait, "some" if barred else "can", reason)


def _refusals(engine: Engine, scene: Scene) -> list[Refusal]:
    """Return why the engine runs the scene by none of its methods; empty where one does."""
    found = engine.refusals(scene)
    by_method = [engine.method_refusals(scene, method) for method in engine.methods()]
    return found or ([refusal for each in by_method for refusal in each] if all(by_method) else [])


def _word(refusals: list[Refusal]) -> str:
    return "never" if any(refusal.permanent for refusal in refusals) else "not-yet"


def _reasons(refusals: list[Refusal]) -> str:
    return "; ".join(dict.fromkeys(refusal.reason for refusal in refusals))
