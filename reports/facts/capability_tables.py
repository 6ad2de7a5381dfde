"""What the engines can, as tables of words: for a terminal, and for a page of the documentation."""

import re
from collections import Counter
from collections.abc import Iterator, Sequence

from cross_checks.judge.capabilities import Capability
from mbs_ref.scene.traits import PART_TYPES

LACKS = re.compile(r"not yet support the part type '?(\w+)")


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
