"""mbs-ref engines: who can simulate what."""

from __future__ import annotations

from dataclasses import asdict

import click

from cross_checks.engines.capabilities import Capability, capabilities
from mbs_ref.scene.traits import PART_TYPES
from reports.console import echo_json, show, table


@click.command(name="engines")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(as_json: bool) -> None:
    """List the engines, their methods, and what each can model."""
    found = capabilities()
    if as_json:
        echo_json([asdict(item) for item in found])
        return
    show(_methods(found))
    show(_matrix(found))


def _methods(found: list[Capability]):
    listing = table("Engines", "engine", "version", "method", "kind", "order", "about")
    for item in found:
        if not item.installed:
            listing.add_row(item.engine, "missing", "", "", "", item.reason)
        for k, method in enumerate(item.methods):
            head = (item.engine, item.version) if k == 0 else ("", "")
            listing.add_row(*head, method.name, method.kind, str(method.order or "varies"), method.description)
    return listing


def _matrix(found: list[Capability]):
    here = [item for item in found if item.installed]
    listing = table("\nCapabilities", "part or scene", *(item.engine for item in here))
    for kind in PART_TYPES:
        listing.add_row(kind, *("yes" if item.parts[kind] else "not yet" for item in here))
    for scene in here[0].scenes if here else ():
        listing.add_row(scene, *("; ".join(item.scenes[scene]) or "runs" for item in here))
    return listing
