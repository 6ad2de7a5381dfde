"""mbs-ref engines: who can simulate what."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import asdict

import click

from cross_checks.engines.capabilities import Capability, capabilities
from mbs_ref.scene.traits import PART_TYPES
from reports.terminal.console import echo_json, show, table

LACKS = re.compile(r"not yet taught the part type '?(\w+)")


@click.command(name="engines")
@click.option("--json", "as_json", is_flag=True, help="Print JSON, with every reason in full.")
def command(as_json: bool) -> None:
    """List the engines, their methods, and what each can model."""
    found = capabilities()
    if as_json:
        echo_json([asdict(item) for item in found])
        return
    show(_methods(found))
    show(_parts(found))
    show(_scenes(found))


def _methods(found: list[Capability]):
    listing = table("Engines", "engine", "version", "method", "kind", "order", "about")
    for item in found:
        if not item.installed:
            listing.add_row(item.engine, "missing", "", "", "", item.reason)
        for k, method in enumerate(item.methods):
            head = (item.engine, item.version) if k == 0 else ("", "")
            listing.add_row(*head, method.name, method.kind, str(method.order or "varies"), method.description)
    return listing


def _parts(found: list[Capability]):
    here = [item for item in found if item.installed]
    listing = table("\nParts of a scene", "part", *(item.engine for item in here))
    for kind in PART_TYPES:
        listing.add_row(kind, *("yes" if item.parts[kind] else "not yet" for item in here))
    return listing


def _scenes(found: list[Capability]):
    here = [item for item in found if item.installed]
    listing = table("\nScenes", "scene", *(item.engine for item in here))
    for scene in here[0].scenes if here else ():
        listing.add_row(scene, *(summary(list(item.scenes[scene])) or "runs" for item in here))
    return listing


def summary(reasons: list[str]) -> str:
    """Return the part types that are lacking, and of other reasons the most frequent with its count."""
    lacking = list(dict.fromkeys(found[1] for reason in reasons if (found := LACKS.search(reason))))
    counts = Counter(_kind(reason) for reason in reasons if not LACKS.search(reason))
    told = [f"lacks {', '.join(lacking)}"] if lacking else []
    if not lacking:
        told += [f"{kind} ({count} times)" if count > 1 else kind for kind, count in counts.most_common(1)]
    more = len(counts) - (0 if lacking else 1)
    return "; ".join([*told, f"{more} more" if more == 1 else f"{more} others"] if more > 0 and told else told)


def _kind(reason: str) -> str:
    """Return a reason without the names of its parts: what stands in quotes, and the numbers of names."""
    return re.sub(r"\b([A-Za-z]+)(?:_?\d+)+(?:_\w+)*\b", r"\1…", re.sub(r"'[^']*'", "…", reason))
