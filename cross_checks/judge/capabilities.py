"""What every engine can do, derived from the adapters themselves: no hand-written table."""

from dataclasses import dataclass, field
from typing import Literal

from cross_checks import engines
from cross_checks.engine import Engine, Method, Refusal
from mbs_ref import Scene, scenes
from mbs_ref.scene.traits import ALL_TRAITS, PART_TYPES, traits


@dataclass(frozen=True)
class Ability:
    """Whether an engine models a trait of scenes, and why not."""

    answer: Literal["can", "some", "not-yet", "never"]  # some: not by all of its methods
    reason: str = ""


@dataclass(frozen=True)
class Capability:
    """One engine: what it is, which parts it translates, which traits it models, and which scenes it runs."""

    engine: str
    installed: bool
    reason: str = ""  # why it is not installed, otherwise empty
    version: str = ""
    methods: tuple[Method, ...] = ()
    parts: dict[str, bool] = field(default_factory=dict)  # part type -> translated
    scenes: dict[str, tuple[str, ...]] = field(default_factory=dict)  # scene -> reasons to refuse; empty where it runs
    traits: dict[str, Ability] = field(default_factory=dict)  # of the scenes


def capabilities(probes: dict[str, Scene] | None = None) -> tuple[Capability, ...]:
    """Return what each engine can do with each part type and each labelled scene: those of the library unless given."""
    chosen = {name: scenes.make(name) for name in scenes.names()} if probes is None else probes
    return tuple(_capability(name, chosen) for name in engines.names())


def _capability(name: str, probes: dict[str, Scene]) -> Capability:
    try:
        engine = engines.get(name)
    except engines.EngineMissing as error:
        return Capability(name, False, str(error))
    refusals = {label: _refusals(engine, scene) for label, scene in probes.items()}
    shown = {trait: [refusals[k] for k, scene in probes.items() if trait in traits(scene)] for trait in ALL_TRAITS}
    return Capability(
        name, True, "", engine.version(), tuple(engine.methods()),
        {kind: kind in engine.part_types for kind in PART_TYPES},
        {label: tuple(refusal.reason for refusal in own) for label, own in refusals.items()},
        {trait: _ability(engine, trait, own) for trait, own in shown.items() if own},
    )  # fmt: skip


def _refusals(engine: Engine, scene: Scene) -> list[Refusal]:
    """Return why the engine runs the scene by none of its methods; empty where one does."""
    by_method = [engine.method_refusals(scene, method) for method in engine.methods()]
    return engine.refusals(scene) or ([refusal for each in by_method for refusal in each] if all(by_method) else [])


def _ability(engine: Engine, trait: str, refusals: list[list[Refusal]]) -> Ability:
    """Judge by the scenes that show the trait: the best answer among them is what the engine can do."""
    if all(refusals):
        mildest = min(refusals, key=_is_never)
        reasons = "; ".join(dict.fromkeys(refusal.reason for refusal in mildest))
        return Ability("never" if _is_never(mildest) else "not-yet", reasons)
    barred = [method.name for method in engine.methods() if trait in method.excludes]
    return Ability("some", f"all but {', '.join(barred)}") if barred else Ability("can")


def _is_never(refusals: list[Refusal]) -> bool:
    return any(refusal.permanent for refusal in refusals)
