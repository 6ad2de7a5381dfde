"""mbs-ref pick: the cheapest setting that reaches an accuracy."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import click

from benchmarks import pick
from benchmarks.pick import Choice
from reports import inputs
from reports.console import echo_json
from reports.exit_codes import NothingSelected
from reports.page.command import command as reproduce
from reports.sweeping import sweep_records


@click.command(name="pick")
@click.argument("scene", metavar="SCENE|FILE.toml")
@click.option("-p", "parameters", multiple=True, metavar="NAME=VALUE", help="A parameter of the scene; repeatable.")
@click.option("--engine", "chosen", multiple=True, metavar="E", help="Only this engine; repeatable.")
@click.option("--error", type=float, required=True, callback=inputs.positive, help="Largest world-pose error, m.")
@click.option("--compliance", type=float, callback=inputs.positive, help="Largest constraint violation, m or rad.")
@click.option("--budget", metavar="50ms", help="Longest loop time.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(
    scene: str,
    parameters: tuple[str, ...],
    chosen: tuple[str, ...],
    error: float,
    compliance: float | None,
    budget: str | None,
    as_json: bool,
) -> None:
    """Name the cheapest engine, method and setting that reaches --error on SCENE."""
    limit = None if budget is None else inputs.seconds(budget)
    records = sweep_records(inputs.scene(scene, parameters), chosen, (), None)

    choice = pick.pick(records, error, compliance, limit)
    if as_json:
        echo_json(_facts(choice))
    if choice.best is None:
        raise NothingSelected(choice.sentence)
    if not as_json:
        click.echo(choice.sentence)
        click.echo(reproduce(choice.best))


def _facts(choice: Choice) -> dict[str, Any]:
    """Return the choice as plain data, with the command that runs it, and without the curves of its records."""
    facts = asdict(choice)
    for record in (facts["best"], facts["runner_up"]):
        if record is not None:
            del record["history"]
    return facts | {"command": None if choice.best is None else reproduce(choice.best)}
