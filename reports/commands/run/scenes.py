"""mbs-ref scenes: what can be simulated."""

from __future__ import annotations

from dataclasses import asdict

import click

from mbs_ref import scenes
from reports.console import echo_json, show, table


@click.command(name="scenes")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(as_json: bool) -> None:
    """List the scenes and their parameters."""
    found = [scenes.describe(name) for name in scenes.names()]
    if as_json:
        echo_json([asdict(info) for info in found])
        return
    listing = table("", "scene", "parameters (default)", "about")
    for info in found:
        listing.add_row(info.name, " ".join(f"{k}={v}" for k, v in info.parameters.items()), info.summary)
    show(listing)
