"""mbs-ref pick: the cheapest setting that reaches an accuracy."""

from __future__ import annotations

import click

from reports import inputs
from reports.console import echo_json, show, table
from reports.exit_codes import NothingSelected
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

    from benchmarks import pick

    choice = pick.pick(records, error, compliance, limit)
    if choice is None:
        raise NothingSelected("no setting that was tried reaches what was asked")
    facts = choice.to_dict()
    if as_json:
        echo_json(facts)
        return
    listing = table("", "", "")
    for key, value in facts.items():
        listing.add_row(key.replace("_", " "), str(value))
    show(listing)
