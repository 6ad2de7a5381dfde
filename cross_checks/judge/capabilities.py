"""What every engine can do, derived from the adapters themselves: no hand-written table."""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
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


LACKS = re.compile(r"not (?:yet )?support the part type '?(\w+)")


def tables(every: Sequence[Capability]) -> Iterator[tuple[str, list[str], list[list[str]]]]:
    """Yield title, heading and rows of a table: the methods of each engine, the parts and the scenes that it takes."""
    methods, here = list[list[str]](), [one for one in every if one.installed]
    for one in every:
        own = [[m.name, m.kind, str(m.order or "varies"), m.description] for m in one.methods]
        head = [one.engine, one.version if one.installed else "missing"]
        methods += [[*(["", ""] if k else head), *row] for k, row in enumerate(own or [["", "", "", one.reason]])]
    names = [one.engine for one in here]
    yield "Engines", ["engine", "version", "method", "kind", "order", "about"], methods
    parts = [[kind, *("yes" if one.parts[kind] else "not yet" for one in here)] for kind in PART_TYPES]
    yield "Parts of a scene", ["part", *names], parts
    scenes = here[0].scenes if here else ()
    runs = [[scene, *(summary(list(one.scenes[scene])) or "runs" for one in here)] for scene in scenes]
    yield "Scenes", ["scene", *names], runs


def summary(reasons: list[str]) -> str:
    """Return the part types that are lacking, and of other reasons the most frequent with its count."""
    lacking = list(dict.fromkeys(result[1] for reason in reasons if (result := LACKS.search(reason))))
    counts = Counter(_kind(reason) for reason in reasons if not LACKS.search(reason))
    text = [f"lacks {', '.join(lacking)}"] if lacking else []
    if not lacking:
        text += [f"{kind} ({count} times)" if count > 1 else kind for kind, count in counts.most_common(1)]
    more = len(counts) - (0 if lacking else 1)
    return "; ".join([*text, f"{more} more" if more == 1 else f"{more} others"] if more > 0 and text else text)


def _kind(reason: str) -> str:
    """Return a reason without the names of its parts: what stands in quotes, and the numbers of names."""
    return re.sub(r"\b([A-Za-z]+)(?:_?\d+)+(?:_\w+)*\b", r"\1…", re.sub(r"'[^']*'", "…", reason))
